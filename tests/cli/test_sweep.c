/* SPDX-License-Identifier: Apache-2.0 */
/* mcvisi sweep: what it measures is what `mcvisi measure` does, its table grows by whole rows, and
 * it goes on. */
#include "experiment_files.h"

#include "comma_locale.h"

#include <math.h>

/* A panel of 0.4931 m before a pinhole camera: 24 x 16 pixels of 40 mm; the error is that of the
 * panel's border. */
static const char scene[] = PANEL_SCENE("[24,16]", "0.0004", "[0.4931,0.3317]", "2.5");

#define SWEEP \
    "sweep s.gltf --vary emitters/panel/radiance=1,2,4 --region mid=8,6,8,4 --metric mid.mean " \
    "--metric mean --spp 16 --seed 3"

static void test_is_what_measure_says(void **state) {
    double row[9];
    (void)state;
    program_well(SWEEP " --images kept");
    for (size_t i = 0; i < 3; ++i) {
        char line[128];
        read_numbers(read_whole("s-sweep.csv"), i, row, 9);
        snprintf(line, sizeof line,
                 "measure kept/set-%05zu.exr --region mid=8,6,8,4 --region all=0,0,24,16 --json",
                 i);
        json_t *figures = program_json(line), *regions = json_object_get(figures, "regions");
        for (size_t k = 0; k < 2; ++k) {
            const json_t *mean = json_object_get(json_array_get(regions, k), "mean");
            const double value = json_number_value(json_object_get(mean, "value"));
            const double u = json_number_value(json_object_get(mean, "uncertainty"));
            /* The table has ten digits; bare `mean` is that of the first region. */
            const double *of = row + 2 + 2 * k;
            if (k == 0 &&
                !(fabs(of[0] - value) <= 1e-9 * value && fabs(of[1] - u) <= 1e-9 * u + 1e-15))
                fail_msg("set %zu: the sweep says %g ± %g, measure %g ± %g", i, of[0], of[1], value,
                         u);
        }
        json_decref(figures);
        assert_true(row[0] == (double)i && row[1] == (double)(1 << i) && row[6] == 16);
        /* The same seed for all: one picture, but for the radiance, to float's rounding. */
        assert_true(fabs(row[2] - row[1]) <= 1e-6 * row[1]);
    }
    /* And what render gives with the same --set, bit for bit. */
    program_well("render s.gltf --set emitters/panel/radiance=4 --spp 16 --seed 3 -o r.exr");
    json_t *difference = program_json("measure r.exr --minus kept/set-00002.exr --json");
    const json_t *region = json_array_get(json_object_get(difference, "regions"), 0);
    assert_true(json_number_value(json_object_get(region, "largest")) == 0 &&
                json_number_value(json_object_get(region, "smallest")) == 0);
    json_decref(difference);
    assert_non_null(strstr(read_whole("s-sweep.html"), "<svg"));
    assert_null(strstr(read_whole("s-sweep.html"), "://")); /* needs nothing else */
}

/* The page has a command for each set, which renders the kept picture again, to the bit: also where
 * a render by itself would give noisy pixels more samples. */
static void test_commands_of_the_page(void **state) {
    (void)state;
    program_well("sweep s.gltf --vary emitters/panel/radiance=1,2 --metric mean --spp 256 --images "
                 "kept --resolution 94x62 --sampler random");
    const char *at = strstr(read_whole("s-sweep.html"), "<pre>mcvisi ");
    assert_non_null(at);
    char line[512];
    at += strlen("<pre>mcvisi ");
    const char *end = strstr(at, "</pre>");
    assert_true(end && (size_t)(end - at) < sizeof line);
    snprintf(line, sizeof line, "%.*s", (int)(end - at), at);
    program_well(line);
    json_t *report = program_json("measure set-00000.exr --minus kept/set-00000.exr --json");
    const json_t *region = json_array_get(json_object_get(report, "regions"), 0);
    const double smallest = json_number_value(json_object_get(region, "smallest")),
                 largest = json_number_value(json_object_get(region, "largest"));
    if (smallest != 0 || largest != 0) fail_msg("%s: differs by %g to %g", line, smallest, largest);
    json_decref(report);
    /* The picture has its noise: at the panel's border. */
    report = program_json("render s.gltf --set emitters/panel/radiance=1 --spp 256 --resolution "
                          "94x62 --sampler random --json -o own.exr");
    assert_true(json_is_true(json_object_get(report, "adaptive")));
    json_decref(report);
}

static void test_common_random_numbers(void **state) {
    double a[9], b[9];
    (void)state;
    program_well("sweep s.gltf --vary emitters/panel/radiance=1,2 --metric mean --spp 16");
    read_numbers(read_whole("s-sweep.csv"), 0, a, 4);
    read_numbers(read_whole("s-sweep.csv"), 1, b, 4);
    if (!(a[3] > 0 && fabs(b[2] - 2 * a[2]) <= 1e-6 * b[2]))
        fail_msg("%g ± %g is not half of %g", a[2], a[3], b[2]);
}

static void test_designs_ties_and_where(void **state) {
    double row[8];
    (void)state;
    program_well("sweep s.gltf --vary emitters/panel/radiance=1..3:3 --vary "
                 "nodes/stand/translation/z=-1,-2 --where 'radiance!=2' "
                 "--tie 'sensors/cam/imageDistance=-0.01*z' --metric mean --spp 4 -o g.csv");
    assert_int_equal(count_lines(read_whole("g.csv")), 5);
    read_numbers(read_whole("g.csv"), 3, row, 8);
    assert_true(row[0] == 5 && row[1] == 3 && row[2] == -2 && fabs(row[3] - 0.02) < 1e-12);
    program_well("sweep s.gltf --vary emitters/panel/radiance=1..3 --design sobol --points 4 "
                 "--metric mean --spp 4 -o q.csv");
    assert_int_equal(count_lines(read_whole("q.csv")), 5);
    program_well("sweep s.gltf --vary emitters/panel/radiance=1,2 --vary "
                 "nodes/stand/translation/z=-1,-2 --design list --metric mean --spp "
                 "4 -o l.csv");
    assert_int_equal(count_lines(read_whole("l.csv")), 3);
    /* A number of points says nothing of combinations, and is not left unheard. */
    program_fails("sweep s.gltf --vary emitters/panel/radiance=1,2 --points 3 --metric mean", 2,
                  "--points 3 is of --design lhs and sobol");
}

/* Renders end when the metric is exact enough, and not before; its own limit is the number of
 * samples. */
static void test_until(void **state) {
    double loose[8], tight[8];
    (void)state;
    program_well("sweep s.gltf --vary emitters/panel/radiance=2.5 --metric m:=mean --until m=0.02 "
                 "--spp 65536 -o a.csv");
    program_well("sweep s.gltf --vary emitters/panel/radiance=2.5 --metric m:=mean --until "
                 "m=0.0005 --spp 65536 -o b.csv");
    read_numbers(read_whole("a.csv"), 0, loose, 6);
    read_numbers(read_whole("b.csv"), 0, tight, 6);
    assert_true(loose[3] <= 0.02 && tight[3] <= 0.0005 && tight[4] > loose[4] && tight[4] < 65536);
}

static void test_failing_sets_are_rows(void **state) {
    double row[6];
    (void)state;
    program_well(
        "sweep s.gltf --vary sensors/cam/imageDistance=0.01,-1,0.02 --metric mean --spp 4");
    const char *table = read_whole("s-sweep.csv");
    assert_int_equal(count_lines(table), 4);
    read_numbers(table, 1, row, 4);
    assert_true(row[1] == -1 && isnan(row[2]) && isnan(row[3]));
    assert_non_null(strstr(table, "imageDistance"));
    read_numbers(table, 2, row, 4);
    assert_true(row[2] > 0);
    program_fails(
        "sweep s.gltf --vary sensors/cam/imageDistance=-2,-1 --metric mean --spp 4 -o f.csv", 1,
        "all 2 sets failed");
}

static void test_resume(void **state) {
    char whole[4096], part[4096];
    (void)state;
    program_well(SWEEP);
    snprintf(whole, sizeof whole, "%.4000s", read_whole("s-sweep.csv"));
    program_fails(SWEEP, 3, "--resume");
    /* As a crash in the middle of a row would leave it. */
    snprintf(part, sizeof part, "%.*s1,2,0.7",
             (int)(strchr(strchr(whole, '\n') + 1, '\n') + 1 - whole), whole);
    write_file("s-sweep.csv", part);
    program_well(SWEEP " --resume");
    const char *again = read_whole("s-sweep.csv");
    assert_int_equal(count_lines(again), 4);
    for (size_t i = 0; i < 3; ++i) {
        double a[7], b[7];
        read_numbers(whole, i, a, 7);
        read_numbers(again, i, b, 7);
        assert_memory_equal(a, b, sizeof a);
    }
    program_well(SWEEP " --resume"); /* nothing is left to do */
    program_fails("sweep s.gltf --vary emitters/panel/radiance=1,2,5 --region mid=8,6,8,4 --metric "
                  "mid.mean --metric mean --spp 16 --seed 3 --resume",
                  3, "--vary differs");
    program_fails(SWEEP " --depth 3 --resume", 3, "--depth");
    snprintf(part, sizeof part, "%s ", scene);
    write_file("s.gltf", part);
    program_fails(SWEEP " --resume", 3, "has changed");
    program_fails(SWEEP " --resume --force", 2, "--force");
    program_well(SWEEP " --force"); /* the changed scene, from the beginning */
}

static void test_experiment_file(void **state) {
    (void)state;
    mkdir("sub", 0777);
    write_file("sub/e.json", "{\"note\": \"why\", \"rig\": \"../s.gltf\", \"vary\": "
                             "\"emitters/panel/radiance=1,2,4\", \"region\": [\"mid=8,6,8,4\"],"
                             "\"metric\": [\"mid.mean\", \"mean\"], \"spp\": 64}");
    program_well("sweep sub/e.json --spp 16 --seed 3 -o one.csv");
    program_well(SWEEP " -o two.csv");
    double a[7], b[7];
    read_numbers(read_whole("one.csv"), 1, a, 7);
    read_numbers(read_whole("two.csv"), 1, b, 7);
    assert_memory_equal(a, b, sizeof a);
    assert_non_null(strstr(read_whole("one.html"), "<p>why</p>"));
    program_well(SWEEP " --electrons-per-unit 9 --noise-free -o free.csv");
    program_fails(SWEEP " --electrons-per-unit 9 -o free.csv --resume", 3,
                  "--noise-free is missing");
    program_well("sweep two.json -o three.csv"); /* what stands beside a table is an experiment */
    read_numbers(read_whole("three.csv"), 1, a, 7);
    assert_memory_equal(a, b, sizeof a);
    write_file("bad.json", "{\"rig\": \"s.gltf\", \"varry\": \"x=1\"}");
    program_fails("sweep bad.json", 3, "did you mean --vary");
    write_file("bad.json", "{\"vary\": \"x=1\"}");
    program_fails("sweep bad.json", 3, "rig: is missing");
    write_file("bad.json", "{\"rig\": \"s.gltf\", \"spp\": \"many\"}");
    program_fails("sweep bad.json", 2, "bad.json: --spp many");
    write_file("bad.json", "{");
    program_fails("sweep bad.json", 3, "is not JSON");
}

/* Grey values: the noise is the camera's, and the same for all sets. */
static void test_camera(void **state) {
    double row[6];
    (void)state;
    program_well("sweep s.gltf --vary emitters/panel/radiance=1,2 --region mid=8,6,8,4 --metric "
                 "mid.mean --electrons-per-unit 1000 "
                 "--full-well 4095 --bits 12 --spp 16 -o c.csv");
    read_numbers(read_whole("c.csv"), 1, row, 4);
    /* 2000 electrons, K = 1: shot noise of 32 pixels, 5 standard deviations. */
    assert_true(fabs(row[2] - 2000) <= 5 * sqrt(2000.0 / 32) &&
                fabs(row[3] - sqrt(2000.0 / 32)) <= 0.05 * row[3]);
}

/* What the user's language makes of numbers matters nowhere: neither in what is read nor in what is
 * written. */
static void test_foreign_locale(void **state) {
    static const char *const lines[] = {
        "check s.gltf --set sensors/cam/imageDistance=10.5mm --json",
        // NOLINTNEXTLINE(bugprone-suspicious-missing-comma): one line of two texts
        "sweep s.gltf --vary emitters/panel/radiance=0.5..2.5:3 --tie "
        "nodes/stand/translation/z=-0.75*radiance --where 'radiance<2.75' "
        "--region mid=8.5,6.5,8,4 --metric 'x:=0.5*mid.mean' --until x=0.125 --spp 16 --images "
        "kept -o x.csv",
        "camera kept/set-00001.exr --electrons-per-unit 1000.5 --gain 0.25 --bits 12 -o grey.png "
        "--json",
        "measure grey.png --region mid=8.5,6.5,8,4 --gain 0.25 --json",
        "measure kept/set-00001.exr --region 8.5,6.5,8,4",
    };
    char *plain[5] = {NULL};
    (void)state;
    if (!make_comma_locale()) skip();
    for (int foreign = 0; foreign < 2; ++foreign) {
        assert_int_equal(foreign ? setenv("LC_ALL", "comma", 1) : unsetenv("LC_ALL"), 0);
        for (int i = 0; i < 5; ++i) {
            program_well(lines[i]);
            if (i == 1) continue; /* it tells seconds */
            if (foreign && strcmp(said, plain[i]) != 0)
                fail_msg("%s says %s in place of %s", lines[i], said, plain[i]);
            free(plain[i]);
            plain[i] = strdup(said);
        }
        if (!foreign) assert_int_equal(system("mkdir away && mv x.* kept away"), 0);
    }
    for (int i = 0; i < 5; ++i) free(plain[i]);
    assert_int_equal(unsetenv("LC_ALL"), 0);
    assert_int_equal(system("cmp x.html away/x.html && cmp x.json away/x.json && test $(wc -l "
                            "<x.csv) -eq 4 && ! grep , x.csv | grep -q '\"'"),
                     0);
    for (size_t i = 0; i < 3; ++i) {
        double a[6], b[6];
        char text[4096];
        snprintf(text, sizeof text, "%.4000s", read_whole("away/x.csv"));
        read_numbers(text, i, a, 6);
        read_numbers(read_whole("x.csv"), i, b, 6);
        assert_memory_equal(a, b, sizeof a);
    }
}

static void test_bad_input(void **state) {
    (void)state;
    program_fails("sweep none.gltf --vary a/b=1 --metric mean", 3, "none.gltf");
    program_fails("sweep s.gltf --metric mean", 2, "--vary is missing");
    program_fails("sweep s.gltf --vary emitters/panel/radiance=1", 2, "--metric is missing");
    program_fails("sweep s.gltf --vary emitters/panell/radiance=1 --metric mean", 3,
                  "did you mean \"panel\"");
    program_fails("sweep s.gltf --vary emitters/panel/radiancee=1,2 --metric mean", 3,
                  "unknown key \"radiancee\": did you mean \"radiance\"");
    program_fails("sweep s.gltf --vary emitters/panel/radiance=1..2 --metric mean", 2,
                  "lhs or sobol");
    program_fails("sweep s.gltf --vary emitters/panel/radiance=x --metric mean", 2, "FROM..TO");
    program_fails("sweep s.gltf --vary emitters/panel/radiance=1 --metric meann", 2,
                  "did you mean \"mean\"");
    program_fails("sweep s.gltf --vary emitters/panel/radiance=1 --metric dent.mean", 2,
                  "no --region with the name \"dent\"");
    program_fails("sweep s.gltf --vary emitters/panel/radiance=1 --metric contrast_to_noise", 2,
                  "--background");
    program_fails("sweep s.gltf --vary emitters/panel/radiance=1 --metric mtf50", 2, "--edge");
    program_fails("sweep s.gltf --vary emitters/panel/radiance=1 --metric radius", 2,
                  "--circle or --arc");
    program_fails("sweep s.gltf --vary emitters/panel/radiance=1 --metric straightness", 2,
                  "--line");
    program_fails(
        "sweep s.gltf --vary emitters/panel/radiance=1 --circle 0,0,16,16 --metric line_length", 2,
        "--edge or --line");
    program_fails(
        "sweep s.gltf --vary emitters/panel/radiance=1 --circle 0,0,16,16 --metric distance", 2,
        "from the first");
    program_fails(
        "sweep s.gltf --vary emitters/panel/radiance=1 --circle a=0,0,16,16 --metric b.radius", 2,
        "with the name \"b\"");
    program_fails("sweep s.gltf --vary emitters/panel/radiance=1 --metric mean --until x=1", 2,
                  "no --metric");
    program_fails("sweep s.gltf --vary emitters/panel/radiance=1 --tie sensors/cam/imageDistance=r "
                  "--metric mean",
                  2, "there is no parameter");
    program_fails("sweep s.gltf --vary emitters/panel/radiance=1 --where 0 --metric mean", 2,
                  "leaves out all");
    program_fails("sweep s.gltf --vary emitters/panel/radiance=1 --metric mean --spp 4 --region "
                  "far=100,100,4,4",
                  1, "extends to column");
    program_fails("sweep s.gltf --vary emitters/panel/radiance=1 --metric mean --spp 4 --in "
                  "emd-gradient -o x.csv",
                  1, "not a light field");
    program_fails("sweep s.gltf --vary emitters/panel/radiance=1 --metric mean -o x.txt", 2,
                  ".csv");
    program_fails("sweep s.gltf --vary emitters/panel/radiance=1 --metric mean -o nowhere/x.csv", 3,
                  "nowhere");
}

/* What ships is what the program prints, and holds for the experiments that ship. */
static void test_schema(void **state) {
    static const char *const experiments[] = {"telecentric-edge", "dent-visibility"};
    (void)state;
    program_well("help sweep --json");
    if (strcmp(said, read_whole(MCV_SOURCE_DIR "/include/mcvisi/schema/experiment.schema.json")) !=
        0)
        fail_msg("`mcvisi help sweep --json` prints another schema than "
                 "include/mcvisi/schema/experiment.schema.json");
    json_t *schema = json_loads(said, 0, NULL), *properties = json_object_get(schema, "properties"),
           *value;
    for (int i = 0; i < 2; ++i) {
        char path[512];
        const char *key;
        snprintf(path, sizeof path, MCV_SOURCE_DIR "/scenes/%s.json", experiments[i]);
        json_t *experiment = json_load_file(path, 0, NULL);
        assert_non_null(experiment);
        json_object_foreach(experiment, key, value) if (!json_object_get(properties, key))
            fail_msg("%s: %s", path, key);
        json_decref(experiment);
    }
    json_decref(schema);
}

/* The shipped experiments run: a few samples, and few sets. */
static void test_shipped_experiments(void **state) {
    double row[10];
    (void)state;
    program_well("sweep " MCV_SOURCE_DIR "/scenes/telecentric-edge.json -o edge.csv --spp 64");
    const char *table = read_whole("edge.csv");
    assert_int_equal(count_lines(table), 10);
    double sharpest = INFINITY, sharpest_stop = 0, surest = INFINITY, surest_stop = 0;
    for (size_t i = 0; i < 9; ++i) {
        read_numbers(table, i, row, 6);
        if (row[2] < surest) surest_stop = row[1];
        surest = fmin(surest, row[2]);
        if (row[4] < sharpest) sharpest_stop = row[1];
        sharpest = fmin(sharpest, row[4]);
    }
    /* What the page says: the stop of the sharpest picture is not the one that locates best. */
    if (!(sharpest_stop > 1e-3 && sharpest_stop < 2.5e-3 && surest_stop > 3.5e-3))
        fail_msg("sharpest at %g m, surest at %g m", sharpest_stop, surest_stop);
    program_well("sweep " MCV_SOURCE_DIR "/scenes/dent-visibility.json -o dent.csv --spp 4 --where "
                 "'halfAngle<0.11deg && imageDistance>61.5mm'");
    assert_int_equal(count_lines(read_whole("dent.csv")), 2);
    program_well("sweep " MCV_SOURCE_DIR
                 "/scenes/depth-by-masks.json -o masks.csv --spp 64 --where "
                 "'shiftZ<-9mm'");
    assert_int_equal(count_lines(read_whole("masks.csv")), 5);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        FRESH(test_is_what_measure_says, scene),
        FRESH(test_commands_of_the_page, scene),
        FRESH(test_common_random_numbers, scene),
        FRESH(test_designs_ties_and_where, scene),
        FRESH(test_until, scene),
        FRESH(test_failing_sets_are_rows, scene),
        FRESH(test_resume, scene),
        FRESH(test_experiment_file, scene),
        FRESH(test_camera, scene),
        FRESH(test_foreign_locale, scene),
        FRESH(test_bad_input, scene),
        FRESH(test_schema, scene),
        FRESH(test_shipped_experiments, scene),
    };
    return cmocka_run_group_tests(tests, enter_folder, leave_folder);
}
