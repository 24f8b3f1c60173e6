/* SPDX-License-Identifier: Apache-2.0 */
/* A sensor of type laserTriangulation: its scan needs no options and is that of the same options,
 * its render is that of the thin lens; what the command says counts; and bad input. */
#include "experiment_files.h"

#include "laser_head.h"

#define KEYS \
    "\"laser\":\"laser\",\"frame\":\"plate\",\"feed\":\"0.7mm\",\"profiles\":2,\"exposeTo\":0.5," \
    "\"filter\":\"660nm\",\"filterWidth\":\"20nm\",\"extractor\":\"gauss\",\"window\":11,"
#define OPTIONS "--laser laser --frame plate --filter 660nm --filter-width 20nm --window 11 "

/* The head of laser_head with these keys of a laserTriangulation sensor; to be freed. */
static char *head_with(const char *keys) {
    static const char type[] = "\"type\":\"thinLens\",";
    const char *at = strstr(laser_head, type);
    char *text = NULL;
    assert_non_null(at);
    assert_true(asprintf(&text, "%.*s\"type\":\"laserTriangulation\",%s%s", (int)(at - laser_head),
                         laser_head, keys, at + strlen(type)) > 0);
    return text;
}

static void write_head(const char *name, const char *keys) {
    char *text = head_with(keys);
    write_file(name, text);
    free(text);
}

static int write_scenes(void **state) {
    if (enter_folder(state) != 0) return -1;
    write_file("plain.gltf", laser_head);
    write_head("head.gltf", KEYS);
    return 0;
}

static void must_be_same(const char *a, const char *b) {
    char line[256];
    snprintf(line, sizeof line, "cmp %s %s", a, b);
    if (system(line) != 0) fail_msg("%s and %s differ", a, b);
}

#define QUICK "--device reference --spp 16 "

static void test_scan_needs_no_options(void **state) {
    (void)state;
    program_well("scan head.gltf " QUICK "-o head.csv");
    program_well("scan plain.gltf " QUICK OPTIONS "--extractor gauss --expose-to 0.5 --profiles 2 "
                 "--feed 0.7mm -o plain.csv");
    must_be_same("head.csv", "plain.csv");
    assert_int_equal(count_lines(read_whole("head.csv")), 1 + 2 * 48);
}

/* Options go before keys; an exposure time takes the place of exposeTo, and a single profile has no
 * feed. */
static void test_options_count(void **state) {
    (void)state;
    program_well("scan head.gltf " QUICK "--extractor cog --exposure-time 20us --profiles 1 "
                 "-o head.csv");
    program_well("scan plain.gltf " QUICK OPTIONS "--exposure-time 20us -o plain.csv");
    must_be_same("head.csv", "plain.csv");
    program_well("scan head.gltf " QUICK "--set sensors/camera/feed=0.2mm --set "
                 "sensors/camera/extractor=parabola -o head.csv");
    program_well("scan plain.gltf " QUICK OPTIONS "--extractor parabola --expose-to 0.5 --profiles "
                 "2 --feed 0.2mm -o plain.csv");
    must_be_same("head.csv", "plain.csv");
}

/* A calibration is relative to the scene's folder. */
static void test_calibration(void **state) {
    (void)state;
    assert_int_equal(system("mkdir -p part"), 0);
    write_head("part/head.gltf", KEYS "\"calibration\":\"plane.json\",");
    program_fails("scan part/head.gltf " QUICK, 3, "part/plane.json");
}

/* Its raw image is that of the thin lens. */
static void test_render(void **state) {
    (void)state;
    program_well("render head.gltf " QUICK "-o head.exr");
    program_well("render plain.gltf " QUICK "-o plain.exr");
    json_t *difference = program_json("measure head.exr --minus plain.exr --json");
    const json_t *all = json_array_get(json_object_get(difference, "regions"), 0);
    assert_true(number_at(all, "largest") == 0 && number_at(all, "smallest") == 0);
    json_decref(difference);
}

/* What `new laser` writes can be scanned as it is. */
static void test_new_head(void **state) {
    (void)state;
    write_file("plate.gltf",
               "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0]}],"
               "\"buffers\":[{\"byteLength\":60,\"uri\":\"data:application/octet-stream;base64,"
               "CtejvArXo7wAAAAACtejPArXo7wAAAAACtejPArXozwAAAAACtejvArXozwAAAAAAAABAAIAAAACAAMA"
               "\"}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":48},{\"buffer\":0,"
               "\"byteOffset\":48,\"byteLength\":12}],\"accessors\":[{\"bufferView\":0,"
               "\"componentType\":5126,\"count\":4,\"type\":\"VEC3\",\"min\":[-0.02,-0.02,0],"
               "\"max\":[0.02,0.02,0]},{\"bufferView\":1,\"componentType\":5123,\"count\":6,"
               "\"type\":\"SCALAR\"}],\"meshes\":[{\"primitives\":[{\"attributes\":{"
               "\"POSITION\":0},\"indices\":1}]}],\"nodes\":[{\"mesh\":0}]}");
    program_well("new laser plate.gltf --resolution 32x24 --pixel-size 100um --f-number 2 "
                 "--view 0,0,1 -o rig.gltf");
    assert_non_null(strstr(read_whole("rig.gltf"), "\"laserTriangulation\""));
    json_t *told = program_json("scan rig.gltf " QUICK "--speckle off --json -o new.csv");
    assert_true(number_at(told, "profiles") == 10 && number_at(told, "seen") > 100);
    json_decref(told);
    /* Seen from above its y, the part's z is no height. */
    program_well("new laser plate.gltf --resolution 32x24 --pixel-size 100um --f-number 2 "
                 "--view 0,1,0.2 -o above.gltf");
    assert_null(strstr(read_whole("above.gltf"), "\"frame\""));
    assert_non_null(strstr(read_whole("rig.gltf"), "\"frame\": \"part\""));
}

/* `check` tells the head's own type and keys, and for what its scan would be refused. */
static void test_check(void **state) {
    (void)state;
    static const struct {
        const char *set, *warning;
    } cases[] = {
        {"laser=lasr", "laser: there is no node \"lasr\"; did you mean \"laser\"?"},
        {"frame=plat", "frame: there is no node \"plat\"; did you mean \"plate\"?"},
        {"feed=0", "feed is missing, or 0, between 2 profiles"},
        {"filter=700nm", "the laser's 660 nm lie outside of the filter's band, 690 … 710 nm"},
        {"filter=669nm", NULL}, /* above half of the maximum */
        {"profiles=1 --set sensors/camera/feed=0", NULL},
    };
    /* The plate's height is its y. */
    program_well("check head.gltf");
    assert_non_null(strstr(said, "heights are z of node \"plate\", which runs across the light"));
    program_well("check head.gltf --set sensors/camera/frame=laser");
    assert_null(strstr(said, "heights are z"));
    program_well("check head.gltf");
    assert_non_null(strstr(said, "camera: laserTriangulation"));
    assert_non_null(strstr(said, "frame               plate"));
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        char line[128];
        snprintf(line, sizeof line, "check head.gltf --set sensors/camera/%s", cases[i].set);
        program_well(line);
        const int told =
            strstr(said, "sensor \"camera\": a scan without options is refused: ") != NULL;
        if (told != (cases[i].warning != NULL) || (told && !strstr(said, cases[i].warning)))
            fail_msg("%s: %s", cases[i].set, said);
    }
}

static void must_refuse(const char *verb, const char *keys, int code, const char *why) {
    char line[256];
    write_head("bad.gltf", keys);
    snprintf(line, sizeof line, "%s bad.gltf " QUICK, verb);
    program_fails(line, code, why);
}

static void test_bad_input(void **state) {
    (void)state;
    must_refuse("render", "\"extractor\":\"cgo\",", 3, "did you mean \"cog\"?");
    must_refuse("render", "\"laser\":3,", 3, "must be a text");
    must_refuse("render", "\"laser\":\"\",", 3, "must be a text");
    must_refuse("render", "\"profiles\":0,", 3, "profiles");
    must_refuse("render", "\"threshold\":2,", 3, "threshold");
    must_refuse("render", "\"filterwidth\":\"20nm\",", 3, "did you mean \"filterWidth\"?");
    must_refuse("render", "\"lineTime\":1,", 3, "shutter");
    must_refuse("scan", "\"exposeTo\":0.5,\"laser\":\"lasr\",", 2, "lasr");
    must_refuse("scan", "\"exposeTo\":0.5,\"filter\":\"660nm\",", 2, "--filter-width");
    must_refuse("scan", "\"exposeTo\":0.5,\"window\":8,", 2, "must be odd");
    must_refuse("scan", "\"exposeTo\":0.5,\"profiles\":3,", 2, "--feed is missing");
    must_refuse("scan", "\"laser\":\"laser\",", 2, "exactly once");
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_scan_needs_no_options),
                                       cmocka_unit_test(test_options_count),
                                       cmocka_unit_test(test_calibration),
                                       cmocka_unit_test(test_render),
                                       cmocka_unit_test(test_new_head),
                                       cmocka_unit_test(test_check),
                                       cmocka_unit_test(test_bad_input)};
    return cmocka_run_group_tests(tests, write_scenes, leave_folder);
}
