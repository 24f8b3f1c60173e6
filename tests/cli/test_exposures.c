/* SPDX-License-Identifier: Apache-2.0 */
/* A sensor with a list of apertures: one picture for each, that of the aperture alone. */
#include "experiment_files.h"

#include "blurred_edge.h"

/* The scene with a list of apertures in place of the disc; to be freed. */
static char *with_apertures(const char *list) {
    static const char before[] = "\"type\":\"thinLens\",";
    const char *at = strstr(EDGE, before);
    char *text = NULL;
    assert_non_null(at);
    at += strlen(before);
    assert_true(asprintf(&text, "%.*s\"aperture\":%s,%s", (int)(at - EDGE), EDGE, list, at) > 0);
    return text;
}

static void write_scene(const char *name, const char *list) {
    char *text = with_apertures(list);
    write_file(name, text);
    free(text);
}

#define LIST \
    "[\"half\",{\"aperture\":\"half\",\"apertureRotation\":\"180deg\"},[[1,0],[0,1]],\"ring\"]"
#define QUICK "--device reference --depth 1 --spp 16 "

static int write_scenes(void **state) {
    if (enter_folder(state) != 0) return -1;
    write_scene("list.gltf", LIST);
    return 0;
}

static void must_be_same(const char *a, const char *b) {
    char line[256];
    snprintf(line, sizeof line, "measure %s --minus %s --json", a, b);
    json_t *difference = program_json(line);
    const json_t *all = json_array_get(json_object_get(difference, "regions"), 0);
    if (number_at(all, "largest") != 0 || number_at(all, "smallest") != 0)
        fail_msg("%s and %s differ", a, b);
    json_decref(difference);
}

static void test_one_picture_each(void **state) {
    static const char *const apertures[] = {"\"half\"", "\"half\",\"apertureRotation\":\"180deg\"",
                                            "\"mask\",\"apertureMask\":[[1,0],[0,1]]", "\"ring\""};
    static const char *const names[] = {"cam", "cam-2", "cam-3", "cam-4"};
    (void)state;
    program_well("render list.gltf " QUICK "-o all.exr");
    for (int i = 0; i < 4; ++i) {
        char line[256];
        write_scene("one.gltf", apertures[i]);
        program_well("render one.gltf " QUICK "-o one.exr");
        snprintf(line, sizeof line, "render list.gltf --sensor %s " QUICK "-o chosen.exr",
                 names[i]);
        program_well(line);
        must_be_same("chosen.exr", "one.exr");
        snprintf(line, sizeof line, "all-%s.exr", names[i]);
        must_be_same(line, "one.exr");
    }
}

/* An aperture of the list is changed by its number. */
static void test_set(void **state) {
    (void)state;
    program_well("render list.gltf --sensor cam-4 --set sensors/cam/aperture/3=half " QUICK
                 "-o changed.exr");
    program_well("render list.gltf --sensor cam " QUICK "-o first.exr");
    must_be_same("changed.exr", "first.exr");
}

static void must_refuse(const char *list, const char *why) {
    write_scene("bad.gltf", list);
    program_fails("check bad.gltf", 3, why);
}

static void test_bad_input(void **state) {
    (void)state;
    must_refuse("[]", "1 to 64 apertures");
    must_refuse("[3]", "must be a word, the rows of a mask");
    must_refuse("[\"half\",\"rign\"]", "sensors/cam/aperture/1: \"rign\"");
    must_refuse("[\"half\",\"rign\"]", "did you mean \"ring\"?");
    must_refuse("[\"half\",{\"aperture\":\"rign\"}]", "sensors/cam/aperture/1/aperture: \"rign\"");
    must_refuse("[{\"aperture\":\"ring\",\"apertureRatio\":2}]",
                "sensors/cam/aperture/0/apertureRatio: 2 must be above 0");
    must_refuse("[{\"aperture\":\"half\",\"fNumber\":2}]", "fNumber: is no key of an aperture");
    must_refuse("[\"disc\",{\"aperture\":\"half\",\"apertureRatio\":0.5}]",
                "sensors/cam/aperture/1/apertureRatio: is of the aperture");
    must_refuse("[\"disc\",[[1,0],[0]]]", "sensors/cam/aperture/1/1: ");
    program_fails("sweep list.gltf --vary sensors/cam/fNumber=2,4 --metric mean", 2,
                  "choose one by --sensor");
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_one_picture_each),
                                       cmocka_unit_test(test_set),
                                       cmocka_unit_test(test_bad_input)};
    return cmocka_run_group_tests(tests, write_scenes, leave_folder);
}
