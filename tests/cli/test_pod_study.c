/* SPDX-License-Identifier: Apache-2.0 */
/* mcvisi pod of an experiment: sets are rendered with noise of their own, the table is continued,
 * and what it tells is what is known. */
#include "experiment_files.h"

#include <math.h>

#include "pod/common_noise.h"

/* A panel that fills the view of a pinhole camera of 8 x 8 pixels. */
static const char scene[] = PANEL_SCENE("[8,8]", "0.0004", "[2,2]", "1");

/* The "size" is the panel's radiance, its signal the grey value of one pixel: y = 1000 x ± the read
 * noise of 100 and the shot noise of √(1000 x), 104.9 at x = 1. */
#define STUDY \
    "{\"rig\": \"s.gltf\", \"vary\": \"emitters/panel/radiance=0.4..1.6:40\", \"region\": " \
    "\"mid=4,4,1,1\", \"metric\": \"grey:=mid.mean\", \"electrons-per-unit\": 1000, " \
    "\"full-well\": 4095, \"bits\": 12, \"read-noise\": 100, \"spp\": 16"
#define TELL \
    ", \"pod\": {\"size\": \"radiance\", \"signal\": \"grey\", \"threshold\": \"1000\", " \
    "\"size-scale\": \"linear\", \"signal-scale\": \"linear\", \"size-unit\": \"none\"}}"

static double number(const json_t *report, const char *group, const char *key) {
    return json_number_value(json_object_get(json_object_get(report, group), key));
}

static void test_study(void **state) {
    (void)state;
    write_file("study.json", STUDY TELL);
    json_t *report = program_json("pod study.json --json");
    /* The scatter of 40 is known to 11 %: four of these. a50 is known to s/(1000 √40). */
    const double scatter = number(report, "fit", "scatter"), a50 = number(report, "a50", "value");
    if (!(fabs(scatter / 105 - 1) < 0.45)) fail_msg("scatter %g: must be 105", scatter);
    if (!(fabs(a50 - 1) < 4 * 0.105 / sqrt(40))) fail_msg("a50 %g: must be 1", a50);
    const double bound = json_number_value(json_object_get(report, "a90_bound"));
    if (!(bound > 1 + 1.2816 * 0.105 - 0.05 && bound < 1.35)) fail_msg("a90/95 %g", bound);
    json_decref(report);
    const char *page = read_whole("study-pod.html");
    assert_non_null(strstr(page, "What was simulated"));
    assert_non_null(strstr(page, "emitters/panel/radiance=0.4..1.6:40"));
    /* The table goes on: nothing is rendered again, and a threshold of the command line counts. */
    report = program_json("pod study.json --json --threshold 1100");
    assert_true(fabs(number(report, "a50", "value") - a50 - 0.1) < 0.02);
    json_decref(report);
    assert_int_equal(system("test \"$(wc -l < study-sweep.csv)\" = 41"), 0);
    /* The sweep takes the same file, and pod its table. */
    program_well("sweep study.json --spp 4 -o other.csv --noise own");
    program_well("pod other.csv --size radiance --signal grey --threshold 1000 --size-unit none");
}

/* A mirror-like plate with a dent before a sky of one radiance: pictures of three sizes, with and
 * without, and their differences; then the set-up. */
static const char dented[] =
    "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0,1,2]}],"
    "\"extensionsUsed\":[\"MCVISI_defects\",\"MCVISI_emitters\",\"MCVISI_sensors\"],"
    "\"extensions\":{\"MCVISI_sensors\":{\"sensors\":[{\"name\":\"cam\",\"type\":"
    "\"telecentric\",\"magnification\":1,\"workingDistance\":0.1,\"fNumber\":8,"
    "\"resolution\":[16,12],\"pixelSize\":2e-4}]},\"MCVISI_emitters\":{\"emitters\":[{"
    "\"name\":\"sky\",\"type\":\"environment\",\"radiance\":1}]},"
    "\"MCVISI_defects\":{\"defects\":[{\"name\":\"nick\",\"type\":\"dent\",\"node\":"
    "\"plate\",\"at\":[0,0,0],\"size\":1e-3}]}},"
    "\"buffers\":[{\"byteLength\":60,\"uri\":\"data:application/octet-stream;base64,"
    "CtejvArXo7wAAAAACtejPArXo7wAAAAACtejPArXozwAAAAACtejvArXozwAAAAAAAABAAIAAAACAAMA\"}],"
    "\"bufferViews\":[{\"buffer\":0,\"byteLength\":48},{\"buffer\":0,\"byteOffset\":48,"
    "\"byteLength\":12}],\"accessors\":[{\"bufferView\":0,\"componentType\":5126,"
    "\"count\":4,\"type\":\"VEC3\",\"min\":[-0.02,-0.02,0],\"max\":[0.02,0.02,0]},"
    "{\"bufferView\":1,\"componentType\":5123,\"count\":6,\"type\":\"SCALAR\"}],"
    "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"indices\":1}]}],"
    "\"nodes\":[{\"name\":\"plate\",\"mesh\":0},{\"name\":\"cam\",\"translation\":"
    "[0,0,0.1],\"extensions\":{\"MCVISI_sensors\":{\"sensor\":0}}},{\"name\":\"sky\","
    "\"extensions\":{\"MCVISI_emitters\":{\"emitter\":0}}}]}";

/* A ball with a dent, which becomes a mesh of 400 000 triangles. */
static const char ball[] =
    "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0,1,2]}],"
    "\"extensionsUsed\":[\"MCVISI_defects\",\"MCVISI_emitters\",\"MCVISI_materials\","
    "\"MCVISI_sensors\",\"MCVISI_surfaces\"],\"materials\":[{\"extensions\":{"
    "\"MCVISI_materials\":{\"type\":\"diffuse\",\"reflectance\":0.5}}}],"
    "\"extensions\":{\"MCVISI_sensors\":{\"sensors\":[{\"name\":\"cam\",\"type\":"
    "\"telecentric\",\"magnification\":1,\"workingDistance\":0.1,\"fNumber\":8,"
    "\"resolution\":[16,12],\"pixelSize\":2e-4}]},\"MCVISI_emitters\":{\"emitters\":[{"
    "\"name\":\"sky\",\"type\":\"environment\",\"radiance\":1}]},"
    "\"MCVISI_surfaces\":{\"surfaces\":[{\"type\":\"sphere\",\"radius\":\"3mm\","
    "\"material\":0}]},\"MCVISI_defects\":{\"defects\":[{\"name\":\"nick\",\"type\":\"dent\","
    "\"node\":\"ball\",\"at\":[0,0,\"3mm\"],\"size\":1e-3}]}},"
    "\"nodes\":[{\"name\":\"ball\",\"extensions\":{\"MCVISI_surfaces\":{\"surface\":0}}},"
    "{\"name\":\"cam\",\"translation\":[0,0,0.1],\"extensions\":{\"MCVISI_sensors\":{"
    "\"sensor\":0}}},{\"name\":\"sky\",\"extensions\":{\"MCVISI_emitters\":{\"emitter\":0}}}]}";

/* A dent of another size has other triangles: the structure stays but for them, and the figures are
 * those of sets that are rendered alone. */
static void test_a_structure_serves_all_sizes(void **state) {
    static const char *const sizes[] = {"0.0005", "0.0008", "0.001"};
    (void)state;
    write_file("b.gltf", ball);
    json_t *report = program_json("sweep b.gltf --vary defects/nick/size=0.0005,0.0008,0.001 "
                                  "--metric mean --spp 4 --json -o all.csv");
    assert_int_equal(json_integer_value(json_object_get(report, "structures_built")), 1);
    json_decref(report);
    for (size_t i = 0; i < 3; ++i) {
        char line[256];
        snprintf(line, sizeof line,
                 "sweep b.gltf --vary defects/nick/size=%s --metric mean --spp 4 --json -o one.csv "
                 "--force",
                 sizes[i]);
        json_decref(program_json(line));
        snprintf(line, sizeof line,
                 "test \"$(cut -d, -f2-5 one.csv | tail -1)\" = "
                 "\"$(cut -d, -f2-5 all.csv | sed -n %zup)\"",
                 i + 2);
        if (system(line) != 0) fail_msg("size %s: other figures than alone", sizes[i]);
    }
}

static size_t count_pictures(const char *page) {
    size_t pictures = 0;
    for (const char *at = page; (at = strstr(at, "data:image/png;base64,")); ++at) ++pictures;
    return pictures;
}

static void test_pictures(void **state) {
    (void)state;
    write_file("d.gltf", dented);
    write_file(
        "dents.json",
        "{\"rig\": \"d.gltf\", \"vary\": \"defects/nick/size=0.5mm..1.4mm:10\", "
        "\"metric\": \"dark:=1-mean\", \"spp\": 8, \"pod\": {\"size\": \"size\", \"signal\": "
        "\"dark\", \"threshold\": \"0.502\"}}");
    program_well("pod dents.json");
    const char *page = read_whole("dents-pod.html");
    assert_int_equal(count_pictures(page), 9);
    const char *seen = strstr(page, "What the camera sees"), *setup = strstr(page, "The set-up");
    assert_true(seen && setup && seen < setup && strstr(setup, "<svg"));
    assert_non_null(strstr(page, "<th>size [mm]<th>with"));
    assert_non_null(strstr(page, "<th>0.5<td>"));
    assert_non_null(strstr(page, "<th>0.9<td>"));
    assert_non_null(strstr(page, "<th>1.4<td>"));
    /* A browser shows none of them unless the page allows it. */
    const char *policy = strstr(page, "Content-Security-Policy"), *end = strchr(policy, '>');
    const char *allowed = strstr(policy, "img-src data:");
    assert_true(allowed && allowed < end);
}

/* Rays are no model of what is smaller than two wavelengths, and no camera sees a hundredth of a
 * pixel: the page says so, and the program. */
static void test_sizes_below_the_model(void **state) {
    (void)state;
    write_file("d.gltf", dented);
    write_file(
        "tiny.json",
        "{\"rig\": \"d.gltf\", \"vary\": \"defects/nick/size=0.2um..1mm:10\", "
        "\"metric\": \"dark:=1-mean\", \"spp\": 8, \"pod\": {\"size\": \"size\", \"signal\": "
        "\"dark\", \"threshold\": \"0.502\"}}");
    program_well("pod tiny.json");
    assert_non_null(strstr(said, "smaller than two wavelengths"));
    const char *page = read_whole("tiny-pod.html"), *doubt = strstr(page, "the smallest size");
    assert_non_null(doubt);
    assert_non_null(strstr(doubt, "smaller than two wavelengths"));
    /* Above these, and below the resolution: a pixel sees 200 um. */
    write_file(
        "small.json",
        "{\"rig\": \"d.gltf\", \"vary\": \"defects/nick/size=1.5um..1mm:10\", "
        "\"metric\": \"dark:=1-mean\", \"spp\": 8, \"pod\": {\"size\": \"size\", \"signal\": "
        "\"dark\", \"threshold\": \"0.502\"}}");
    program_well("pod small.json");
    assert_non_null(strstr(said, "less than a hundredth of the 200 µm"));
    doubt = strstr(read_whole("small-pod.html"), "the smallest size");
    assert_non_null(doubt);
    assert_non_null(strstr(doubt, "less than a hundredth of the 200 µm"));
}

/* Parameters of a program are none of the scene without the defect. */
static void test_pictures_where_a_program_judges(void **state) {
    (void)state;
    write_file("d.gltf", dented);
    write_file("yes.py", "import sys\n"
                         "for line in sys.stdin:\n"
                         "    print('{\"fine\": true}', flush=True)\n");
    write_file("judged.json",
               "{\"rig\": \"d.gltf\", \"vary\": [\"defects/nick/size=0.5mm..1.4mm:10\", "
               "\"process/limit=3\"], \"metric\": [\"dark:=1-mean\", "
               "\"fine:=worker(python3 yes.py)\"], \"electrons-per-unit\": 1000, \"spp\": 4, "
               "\"pod\": {\"size\": \"size\", \"signal\": \"dark\", \"threshold\": \"0.502\"}}");
    program_well("pod judged.json --allow-exec");
    assert_int_equal(count_pictures(read_whole("judged-pod.html")), 9);
}

/* With common random numbers all sets have one noise: that of one pixel does not scatter. */
static void test_common_noise(void **state) {
    (void)state;
    write_file("common.json", STUDY ", \"noise\": \"common\"" TELL);
    json_t *report = program_json("pod common.json --json");
    assert_true(number(report, "fit", "scatter") < 20);
    json_decref(report);
    /* It is told, and not told of sets with noise of their own. */
    static const char tell[] = "--size radiance --signal grey --threshold 1000 --size-unit none";
    char line[256];
    snprintf(line, sizeof line, "pod common-sweep.csv %s", tell);
    program_well(line);
    if (!strstr(said, "common random numbers")) fail_msg("%s", said);
    write_file("own.json", STUDY TELL);
    program_well("pod own.json");
    if (strstr(said, "common random numbers")) fail_msg("%s", said);
}

/* Of an experiment beside the table: its own metrics have the noise of all sets in common unless it
 * says "own"; a program sees other noise in each set, alone or in a list. */
static void test_whose_noise_is_common(void **state) {
    static const struct {
        const char *experiment;
        bool common;
    } cases[] = {
        {"{\"vary\": \"a=1..2\", \"metric\": \"grey:=mid.mean\"}", true},
        {"{\"vary\": \"a=1..2\", \"metric\": \"grey:=mid.mean\", \"noise\": \"own\"}", false},
        {"{\"vary\": \"a=1..2\", \"metric\": \"grey:=exec(./judge)\"}", false},
        {"{\"vary\": \"a=1..2\", \"metric\": [\"mean\", \"grey:=worker(./judge)\"]}", false},
        {"{\"vary\": \"a=1..2\", \"metric\": [\"grey:=mean\", \"found:=worker(./judge)\"]}", true},
        {"{\"metric\": \"grey:=mid.mean\"}", false},
    };
    (void)state;
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        write_file("table.json", cases[i].experiment);
        if (mcv_pod_common_noise("table.csv", "grey") != cases[i].common)
            fail_msg("%s: must be %s", cases[i].experiment, cases[i].common ? "common" : "own");
    }
    assert_false(mcv_pod_common_noise("no-such-table.csv", "grey"));
}

/* A program decides, and only where it is allowed. */
static void test_program(void **state) {
    (void)state;
    write_file("judge.py", "import json, sys\n"
                           "for line in sys.stdin:\n"
                           "    q = json.loads(line)\n"
                           "    data = open(q['image'], 'rb').read()\n"
                           "    value = int.from_bytes(data[8:10], 'little')\n"
                           "    print(json.dumps({'found': value > 1000}), flush=True)\n");
    write_file("hits.json",
               "{\"rig\": \"s.gltf\", \"vary\": \"emitters/panel/radiance=0.6..1.4:60\", "
               "\"metric\": \"found:=worker(python3 judge.py)\", \"electrons-per-unit\": 1000, "
               "\"full-well\": 4095, \"bits\": 12, \"read-noise\": 100, \"spp\": 4, "
               "\"pod\": {\"size\": \"radiance\", \"hit\": \"found\", \"size-unit\": \"none\"}}");
    program_fails("pod hits.json", 2, "--allow-exec");
    json_t *report = program_json("pod hits.json --allow-exec --json");
    const double a50 = number(report, "a50", "value");
    /* 60 hits and misses about 1 ± 0.105 over a width of 0.8: some 16 of them in the slope. */
    if (!(fabs(a50 - 1) < 0.12)) fail_msg("a50 %g: must be 1", a50);
    json_decref(report);
    write_file("hits.json", STUDY ", \"allow-exec\": true" TELL);
    program_fails("pod hits.json", 3, "is not for files");
}

static void test_wrong_files(void **state) {
    (void)state;
    program_fails("pod none.json", 3, "none.json");
    write_file("bad.json", "{");
    program_fails("pod bad.json", 3, "is not JSON");
    write_file("bad.json", "{\"rig\": \"s.gltf\"}");
    program_fails("pod bad.json", 3, "pod: is missing");
    write_file("bad.json", "{\"pod\": {}}");
    program_fails("pod bad.json", 3, "rig: is missing");
    write_file("bad.json", STUDY ", \"pod\": {\"sgnal\": \"grey\"}}");
    program_fails("pod bad.json", 2, "sgnal");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        FRESH(test_pictures, scene),
        FRESH(test_sizes_below_the_model, scene),
        FRESH(test_pictures_where_a_program_judges, scene),
        FRESH(test_study, scene),
        FRESH(test_a_structure_serves_all_sizes, scene),
        FRESH(test_common_noise, scene),
        FRESH(test_program, scene),
        FRESH(test_wrong_files, scene),
        FRESH(test_whose_noise_is_common, scene),
    };
    return cmocka_run_group_tests(tests, enter_folder, leave_folder);
}
