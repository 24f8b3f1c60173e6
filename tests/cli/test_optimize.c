/* SPDX-License-Identifier: Apache-2.0 */
/* mcvisi optimize: a lamp whose best place is known in closed form, its files, and bad input. */
#include "experiment_files.h"

#include <math.h>

/*
 * A diffuse floor of 2 x 2 m at z = 0, seen by a camera 1 m above its middle, which a point light
 * at (x, 0, z) lights: the irradiance at the middle is I z/(x² + z²)^1.5.
 */
static const char scene[] =
    "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0,1,2]}],"
    "\"extensionsUsed\":[\"MCVISI_sensors\",\"KHR_lights_punctual\",\"MCVISI_materials\"],"
    "\"extensions\":{\"MCVISI_sensors\":{\"sensors\":[{\"name\":\"cam\",\"type\":\"pinhole\","
    "\"imageDistance\":0.01,\"resolution\":[8,8],\"pixelSize\":0.00002}]},"
    "\"KHR_lights_punctual\":{\"lights\":[{\"type\":\"point\",\"intensity\":100}]}},"
    "\"materials\":[{\"name\":\"floor\",\"extensions\":{\"MCVISI_materials\":{\"type\":\"diffuse\","
    "\"reflectance\":0.5}}}],"
    "\"buffers\":[{\"byteLength\":60,\"uri\":\"data:application/octet-stream;base64,"
    "AACAvwAAgL8AAAAAAACAPwAAgL8AAAAAAACAPwAAgD8AAAAAAACAvwAAgD8A"
    "AAAAAAABAAIAAAACAAMA\"}],"
    "\"bufferViews\":[{\"buffer\":0,\"byteLength\":48},{\"buffer\":0,\"byteOffset\":48,"
    "\"byteLength\":12}],"
    "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":4,\"type\":\"VEC3\","
    "\"min\":[-1,-1,0],\"max\":[1,1,0]},{\"bufferView\":1,\"componentType\":5123,\"count\":6,"
    "\"type\":\"SCALAR\"}],"
    "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"indices\":1,\"material\":0}]}]"
    ",\"nodes\":[{\"name\":\"floor\",\"mesh\":0},{\"name\":\"eye\",\"translation\":[0,0,1],"
    "\"extensions\":{\"MCVISI_sensors\":{\"sensor\":0}}},{\"name\":\"lamp\",\"translation\":[0.5,0,"
    "0.5],\"extensions\":{\"KHR_lights_punctual\":{\"light\":0}}}]}";

static double irradiance(double x, double z) { return z / pow(x * x + z * z, 1.5); }

#define LAMP \
    "optimize s.gltf --vary nodes/lamp/translation/x=0.1..1 --vary " \
    "nodes/lamp/translation/z=0.05..1 --where 'x+z>=0.6' --metric mean --objective mean=largest " \
    "--electrons-per-unit 2000 --read-noise 40 --full-well 5000 --spp 4 --replicates 2 " \
    "--lens-mtf none "

/* At most a tenth of a grid of 40 x 40, to 2 % of its best; each render has 2 % of noise there. */
static void test_the_lamp(void **state) {
    (void)state;
    double best = 0;
    for (int i = 0; i < 40; ++i)
        for (int k = 0; k < 40; ++k) {
            const double x = 0.1 + 0.9 * i / 39, z = 0.05 + 0.95 * k / 39;
            if (x + z >= 0.6) best = fmax(best, irradiance(x, z));
        }
    json_t *report = program_json(LAMP "--evaluations 100 --better mean=1 --json");
    const double x = number_at(report, "winner/parameters/x"),
                 z = number_at(report, "winner/parameters/z"), found = irradiance(x, z);
    print_message("%g of %g at %g, %g after %g renders\n", found, best, x, z,
                  number_at(report, "rows"));
    assert_true(number_at(report, "rows") <= 160);
    assert_true(x + z >= 0.6);
    assert_true(found > 0.98 * best);
    /* The interval is of the winner's own value; what the search had seen is more. */
    assert_true(number_at(report, "winner/interval/0") < number_at(report, "winner/interval/1"));
    assert_true(number_at(report, "winner/as_good_within/z/0") <= z);
    assert_true(number_at(report, "winner/as_good_within/z/1") >= z);
    json_decref(report);
    const char *page = read_whole("s-optimize.html");
    assert_non_null(strstr(page, "Optimisation of s.gltf"));
    assert_non_null(strstr(page, "The best set-up is x "));
    const char *seen = strstr(page, "What the camera sees");
    assert_true(seen && strstr(seen, "data:image/png;base64,"));
}

/* What is rendered is not rendered again, and the end is the same. */
static void test_resumes(void **state) {
    (void)state;
    json_t *first = program_json(LAMP "--evaluations 40 --json");
    assert_int_equal(system("cp s-optimize.csv whole.csv && head -25 whole.csv >s-optimize.csv && "
                            "printf 30,0.3,0.4,1 >>s-optimize.csv"),
                     0);
    json_t *second = program_json(LAMP "--evaluations 40 --resume --json");
    assert_true(json_equal(value_at(first, "winner"), value_at(second, "winner")));
    assert_true(json_equal(value_at(first, "rows"), value_at(second, "rows")));
    json_decref(first);
    json_decref(second);
    /* All but the seconds are the same. */
    assert_int_equal(system("cut -d, -f1-6 whole.csv >a && cut -d, -f1-6 s-optimize.csv | cmp - a"),
                     0);
    program_fails(LAMP "--evaluations 41 --resume", 3, "--evaluations differs");
}

/* The brightest lamp brings more than a grey value of 60, so that the limit counts. Four standard
 * uncertainties of the margin of fresh renders; the margin is that of the value that is told. */
static void test_requirements(void **state) {
    (void)state;
    json_t *report = program_json(LAMP "--require '60>=mean+0*x' --evaluations 40 --json");
    const double margin = number_at(report, "winner/requirements/0/margin"),
                 u = number_at(report, "winner/requirements/0/uncertainty");
    assert_true(margin <= 4 * u);
    assert_true(fabs(number_at(report, "winner/objectives/mean/value") - 60 - margin) < 1e-6 * 60);
    json_decref(report);
}

/* Light at the middle against distance: the nearest lamps are the brightest. */
static void test_two_objectives(void **state) {
    (void)state;
    json_t *report = program_json(
        "optimize s.gltf --vary nodes/lamp/translation/z=0.3..1 --vary "
        "nodes/lamp/translation/x=0,0.2,0.4 --metric mean --metric spread:=deviation/mean "
        "--objective mean=largest --objective spread=smallest --evaluations 40 --spp 4 "
        "--replicates 2 --json");
    const json_t *front = value_at(report, "front");
    assert_true(json_array_size(front) >= 2);
    for (size_t i = 0; i < json_array_size(front); ++i) {
        const double x = number_at(json_array_get(front, i), "parameters/x");
        assert_true(x == 0 || x == 0.2 || x == 0.4);
    }
    json_decref(report);
}

/* A mirror shows no lamp to the camera: the diffuse floor wins, by its word in all that is told. */
static void test_words(void **state) {
    (void)state;
#define WORDS \
    "--vary nodes/lamp/translation/x=0.1..1 --vary materials/floor/type=mirror,diffuse --metric " \
    "mean --spp 4 --replicates 2 --resolution 4x4 --device reference "
    json_t *report =
        program_json("optimize s.gltf " WORDS "--objective mean=largest --evaluations 30 --json");
    assert_string_equal(json_string_value(value_at(report, "winner/parameters/type")), "diffuse");
    assert_null(json_object_get(value_at(report, "winner/as_good_within"), "type"));
    assert_non_null(json_object_get(value_at(report, "winner/as_good_within"), "x"));
    json_t *again = program_json("optimize s.gltf " WORDS
                                 "--objective mean=largest --evaluations 30 --resume --json");
    assert_true(json_equal(value_at(report, "winner"), value_at(again, "winner")));
    json_decref(report);
    json_decref(again);
    const char *table = read_whole("s-optimize.csv");
    assert_non_null(strstr(table, ",mirror,"));
    assert_non_null(strstr(table, ",diffuse,"));
    assert_non_null(strstr(read_whole("s-optimize.html"), "type diffuse"));
    /* The sweep has them, too, and the page's command takes the word. */
    program_well("sweep s.gltf --vary materials/floor/type=mirror,diffuse --metric mean --spp 4 "
                 "--resolution 4x4 --device reference -o words.csv");
    assert_non_null(strstr(said, "type diffuse"));
    assert_non_null(strstr(read_whole("words.html"), "--set materials/floor/type=diffuse"));
    program_fails("sweep s.gltf --vary materials/floor/type=mirror,2 --metric mean", 2,
                  "numbers with or without a unit, or words");
    program_fails("sweep s.gltf --vary materials/floor/type=2,mirror --metric mean", 2,
                  "numbers with or without a unit, or words");
}

static void test_bad_input(void **state) {
    (void)state;
#define FROM "optimize s.gltf --vary nodes/lamp/translation/x=0.1..1 --metric mean "
    program_fails("optimize s.gltf --metric mean --objective mean=largest", 2, "--vary is missing");
    program_fails(FROM, 2, "--objective is missing");
    program_fails(FROM "--objective mean", 2, "must be NAME=largest or NAME=smallest");
    program_fails(FROM "--objective men=largest", 2, "there is no --metric with this name");
    program_fails(FROM "--objective mean=largest --objective mean=smallest", 2, "is one already");
    program_fails(FROM "--objective mean=largest --better mean=-1", 2, "must be NAME=");
    program_fails(FROM "--objective mean=largest --evaluations 5", 2, "must be 20 or more");
    program_fails(FROM "--objective mean=largest --require mean", 2, "one comparison");
    program_fails(FROM "--objective mean=largest --require '1<mean<2'", 2, "one comparison");
    program_fails(FROM "--objective mean=largest --require 'men<2'", 2,
                  "there is no metric or parameter \"men\"");
    program_fails(FROM "--objective mean=largest --where 'y>1'", 2, "there is no parameter");
    program_fails(FROM "--objective mean=largest --where 'x>'", 2, "is missing at its end");
    program_fails(FROM "--objective mean=largest --where 'x>2'", 3, "constraints allow none");
    /* Before the first render: no table begins. */
    program_fails("optimize s.gltf --vary sensors/cam/imageDistanze=0.01..0.02 --metric mean "
                  "--objective mean=largest --spp 4 -o k.csv",
                  3, "unknown key \"imageDistanze\": did you mean \"imageDistance\"");
    assert_int_not_equal(access("k.csv", F_OK), 0);
    program_fails(FROM "--objective mean=largest --spp 4 --region "
                       "far=100,100,4,4 -o f.csv",
                  1, "evaluations of the screening have failed");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        FRESH(test_the_lamp, scene),       FRESH(test_resumes, scene),
        FRESH(test_two_objectives, scene), FRESH(test_requirements, scene),
        FRESH(test_words, scene),          FRESH(test_bad_input, scene)};
    return cmocka_run_group_tests(tests, enter_folder, leave_folder);
}
