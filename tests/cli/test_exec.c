/* SPDX-License-Identifier: Apache-2.0 */
/* Metrics that programs of the user decide: what they get, what becomes of their answers, and of
 * programs that fail, hang or answer nonsense. */
#include "experiment_files.h"

#include <math.h>

/* A panel that fills the view of a pinhole camera of 8 x 8 pixels. */
static const char scene[] = PANEL_SCENE("[8,8]", "0.0004", "[2,2]", "1");

/* It reads the uncompressed TIFF of 16 bits itself, and logs what it was asked. */
static const char judge[] =
    "import json, os, struct, sys\n"
    "def pixels(path):\n"
    "    data = open(path, 'rb').read()\n"
    "    at, = struct.unpack_from('<I', data, 4)\n"
    "    tags = {}\n"
    "    for i in range(struct.unpack_from('<H', data, at)[0]):\n"
    "        tag, kind, count, value = struct.unpack_from('<HHII', data, at + 2 + 12 * i)\n"
    "        tags[tag] = value & (0xffff if kind == 3 else 0xffffffff)\n"
    "    return struct.unpack_from('<64H', data, tags[273])\n"
    "for line in sys.stdin:\n"
    "    q = json.loads(line)\n"
    "    assert os.path.isabs(q['image']) and q['bits'] == 12 and q['camera_model']\n"
    "    values = pixels(q['image'])\n"
    "    threshold = q['parameters'].get('threshold', 0)\n"
    "    print(q['set'], q['exposure'], os.getpid(), *values, file=open('log', 'a'))\n"
    "    off = sum(values) / 64 - q['parameters'].get('setting', 0)\n"
    "    print(json.dumps({'score': 1 / (1 + (off / 50) ** 2),\n"
    "                      'mean': sum(values) / 64, 'found': values[0] > threshold,\n"
    "                      'words': sys.argv[1:] == ['a b', '$HOME', 'c']}), flush=True)\n";

static int fresh_with_judge(void **state) {
    *state = (void *)scene;
    if (fresh(state) != 0 || mkdir("tmp", 0700) != 0) return -1;
    write_file("judge.py", judge);
    return setenv("TMPDIR", "tmp", 1);
}

/* 1000 electrons for a radiance of 1, 1 DN for each: grey values of 1000 ± √1000. */
#define CAMERA " --electrons-per-unit 1000 --full-well 4095 --bits 12 --spp 64 "

/* Arguments are a list, images are what the camera gives, and the mean over K exposures has the
 * camera's noise: √(1000/64) for one, 1/√K of it for K. */
static void test_answers(void **state) {
    double row[9];
    (void)state;
    program_well("sweep s.gltf --vary emitters/panel/radiance=1,2 --exposures 16 "
                 "--metric 'mean:=exec(python3 judge.py \"a b\" $HOME c)' "
                 "--metric 'words:=exec(python3 judge.py \"a b\" $HOME c)'" CAMERA);
    for (size_t i = 0; i < 2; ++i) {
        read_numbers(read_whole("s-sweep.csv"), i, row, 6);
        const double expected = 1000 * (double)(i + 1), u = sqrt(expected / 64 / 16);
        if (!(fabs(row[2] - expected) < 5 * u)) fail_msg("mean %g: must be %g", row[2], expected);
        /* The deviation of 16 values is known to 18 %; four of these. */
        if (!(row[3] > 0.28 * u && row[3] < 1.72 * u)) fail_msg("u %g: must be %g", row[3], u);
        assert_true(row[4] == 1);
    }
    /* Both metrics are one program, asked once for each exposure; exposures differ. */
    assert_int_equal(count_lines(read_whole("log")), 32);
    assert_int_equal(system("test \"$(cut -d' ' -f4- log | sort -u | wc -l)\" = 32"), 0);
    assert_int_equal(system("test -z \"$(ls tmp)\""), 0); /* nothing is left behind */
}

/* Sets that differ in process/ alone are rendered once, in whatever order they stand, and have the
 * same exposures. A worker is one process. */
static void test_no_second_render(void **state) {
    (void)state;
    json_t *report =
        program_json("sweep s.gltf --vary process/threshold=0,4095 --vary "
                     "emitters/panel/radiance=1,2 --metric 'found:=worker(python3 judge.py)' "
                     "--metric mean --exposures 3 --json" CAMERA);
    assert_int_equal(json_integer_value(json_object_get(report, "renders")), 2);
    json_decref(report);
    double row[8];
    const char *table = read_whole("s-sweep.csv");
    for (size_t i = 0; i < 4; ++i) {
        read_numbers(table, i, row, 8);
        assert_true(row[3] == (row[1] == 0)); /* found */
        assert_true(fabs(row[5] - 1000 * row[2]) < 25);
    }
    assert_int_equal(count_lines(read_whole("log")), 12);
    assert_int_equal(system("test \"$(cut -d' ' -f3 log | sort -u | wc -l)\" = 1"), 0);
    assert_int_equal(system("test \"$(cut -d' ' -f4- log | sort -u | wc -l)\" = 6"), 0);
}

/* The known optimum: two kinds of parts with grey values of 1000 ± √1000 and 1100 ± √1100, judged
 * by one pixel. The best threshold is in the middle, and errs in Φ(-50/32.4) = 6.2 % of cases. */
static void test_threshold(void **state) {
    double row[4], found[2][3];
    (void)state;
    program_well("sweep s.gltf --vary emitters/panel/radiance=1,1.1 --vary "
                 "process/threshold=1000,1050,1100 --metric 'found:=worker(python3 judge.py)' "
                 "--exposures 400" CAMERA);
    const char *table = read_whole("s-sweep.csv");
    for (size_t i = 0; i < 6; ++i) {
        read_numbers(table, i, row, 4);
        found[row[1] > 1.05][(int)((row[2] - 1000) / 50)] = row[3];
    }
    const double error[3] = {found[0][0] + 1 - found[1][0], found[0][1] + 1 - found[1][1],
                             found[0][2] + 1 - found[1][2]};
    /* 400 each: 1.2 % of noise. */
    if (!(error[1] < error[0] && error[1] < error[2] && fabs(0.5 * error[1] - 0.062) < 0.04))
        fail_msg("errors %g %g %g", error[0], error[1], error[2]);
}

/* A program that guesses: of 200 settings the best one looks better than 1/2 where it was chosen,
 * and is 1/2 where it was not. The best of 200 means of n coins lies some 2.7 deviations of
 * 1/(2√n) above; less than 1.5 has a chance below 1e-6. */
static void test_validation(void **state) {
    (void)state;
    write_file(
        "coin.py",
        "import json, sys, hashlib\n"
        "for line in sys.stdin:\n"
        "    q = json.loads(line)\n"
        "    p = q['parameters']\n"
        "    key = ('%r %r' % (p['radiance'], p['setting'])).encode()\n"
        "    print(json.dumps({'right': hashlib.sha256(key).digest()[0] & 1}), flush=True)\n");
    json_t *report = program_json(
        "sweep s.gltf --vary emitters/panel/radiance=1..2:40 --vary process/setting=1..200:200 "
        "--metric 'right:=worker(python3 coin.py)' --validate 0.5 --json" CAMERA);
    const json_t *settings = json_object_get(json_object_get(report, "validation"), "right");
    assert_int_equal(json_array_size(settings), 200);
    size_t best = 0, index, scenes[2] = {0};
    double rates[2] = {0}, largest = 0, both = 0;
    const json_t *setting;
    json_array_foreach((json_t *)settings, index, setting) {
        static const char *const sides[2] = {"tuning", "validation"};
        double rate[2];
        for (int k = 0; k < 2; ++k) {
            const json_t *side = json_object_get(setting, sides[k]);
            rate[k] = json_number_value(json_object_get(side, "rate"));
            scenes[k] = (size_t)json_integer_value(json_object_get(side, "scenes"));
            assert_true(json_number_value(json_object_get(side, "low")) < rate[k] + 1e-12);
            assert_true(json_number_value(json_object_get(side, "high")) > rate[k] - 1e-12);
        }
        largest = fmax(largest, rate[0]);
        both += rate[1] / 200;
        if (!json_is_true(json_object_get(setting, "best"))) continue;
        ++best;
        memcpy(rates, rate, sizeof rates);
    }
    assert_int_equal(best, 1);
    assert_int_equal(scenes[0] + scenes[1], 40);
    assert_true(scenes[0] >= 8 && scenes[1] >= 8);
    const double deviation[2] = {0.5 / sqrt((double)scenes[0]), 0.5 / sqrt((double)scenes[1])};
    assert_true(rates[0] == largest && rates[0] > 0.5 + 1.5 * deviation[0]);
    assert_true(fabs(rates[1] - 0.5) < 4 * deviation[1]);
    assert_true(fabs(both - 0.5) < 5 * deviation[1] / sqrt(200.0));
    json_decref(report);
    /* The page has the same, a line for each setting, and the best one marked. */
    const char *page = read_whole("s-sweep.html"), *at = strstr(page, "Tuned and validated: right");
    assert_non_null(at);
    char line[64];
    snprintf(line, sizeof line, "<td>%.3g %% (", 100 * rates[0]);
    assert_non_null(at = strstr(at, "<tr class=\"best\"><th>setting "));
    assert_non_null(at = strstr(at, line));
    snprintf(line, sizeof line, "<td>%.3g %% (", 100 * rates[1]);
    assert_non_null(strstr(at + 1, line));
}

/* A setting of the program is optimised on one render, and confirmed on others. The best one is the
 * image's mean: its grey values are 1000 ± √1000, the mean of 64 pixels and 4 exposures errs by
 * 2, and the score falls by the 1 % that `better` allows within 5 of its place: 5 · 2 + 5. Five
 * deviations of 4 of a single exposure further off it is 1/(1 + 0.7²). */
static void test_optimized(void **state) {
    (void)state;
    json_t *report = program_json(
        "optimize s.gltf --vary process/setting=500..1500 --metric "
        "'score:=worker(python3 judge.py)' --objective score=largest --better score=0.01 "
        "--exposures 4 --evaluations 40 --json" CAMERA);
    const double setting = number_at(report, "winner/parameters/setting"),
                 rows = number_at(report, "rows");
    if (!(fabs(setting - 1000) < 15)) fail_msg("the best setting is %g", setting);
    assert_true(number_at(report, "winner/interval/0") > 0.67);
    /* 4 exposures of one render, and of each of the 12 that confirm at most. */
    assert_true(rows > 20);
    assert_int_equal(count_lines(read_whole("log")), 4 * rows);
    assert_int_equal(system("test \"$(cut -d' ' -f4- log | sort -u | wc -l)\" -le 52"), 0);
    json_decref(report);
}

static void expect_row(const char *program, const char *words) {
    char line[512];
    write_file("bad.py", program);
    snprintf(line, sizeof line,
             "sweep s.gltf --vary emitters/panel/radiance=1,2 --metric mean --metric "
             "'found:=exec(python3 bad.py)' --exec-time 2 --force -o bad.csv" CAMERA);
    program_fails(line, 1, words);
    const char *table = read_whole("bad.csv");
    if (count_lines(table) != 3 || !strstr(table, words))
        fail_msg("\"%s\" is not in %s", words, table);
}

/* Each is a row with its message, and the sweep goes on. */
static void test_failures(void **state) {
    (void)state;
    expect_row("import sys\nprint('out of paper', file=sys.stderr)\nsys.exit(3)\n",
               "ended with code 3: out of paper");
    expect_row("import os, signal\nos.kill(os.getpid(), signal.SIGSEGV)\n", "ended by signal 11");
    expect_row("print('fine')\n", "must be a JSON object");
    expect_row("print('{\"fond\": 1}')\n", "answered without a number");
    expect_row("print('{\"found\": \"yes\"}')\n", "answered without a number");
    expect_row("", "must be a JSON object");
    expect_row("import time\ntime.sleep(100)\n", "gave no answer within 2 s");
    expect_row("while True: print('x' * 100000)\n", "longer than");
    assert_int_equal(system("test -z \"$(ls tmp)\""), 0);
    program_fails("sweep s.gltf --vary emitters/panel/radiance=1 --metric "
                  "'found:=exec(./no-such-program)'" CAMERA,
                  1, "cannot be started: No such file");
}

/* A worker that ends in place of an answer is started again for the next question. */
static void test_worker_that_ends(void **state) {
    (void)state;
    write_file("once.py", "import sys\ninput()\nprint('{\"found\": true}', flush=True)\ninput()\n"
                          "sys.exit('tired')\n");
    program_well("sweep s.gltf --vary emitters/panel/radiance=1,2,3 --metric "
                 "'found:=worker(python3 once.py)'" CAMERA);
    const char *table = read_whole("s-sweep.csv");
    double row[3];
    for (size_t i = 0; i < 3; ++i) {
        read_numbers(table, i, row, 3);
        if (i == 1 ? !isnan(row[2]) : row[2] != 1) fail_msg("%s", table);
    }
    if (!strstr(table, "once.py ended with code 1: tired")) fail_msg("%s", table);
}

static void test_refused(void **state) {
    (void)state;
#define SWEEP "sweep s.gltf --vary emitters/panel/radiance=1,2 "
    program_fails(SWEEP "--metric 'a:=exec(python3 judge.py)' --spp 16", 2, "a camera");
    program_fails(SWEEP "--metric 'exec(python3 judge.py)'" CAMERA, 2, "has no name");
    program_fails(SWEEP "--metric 'a:=exec(python3 judge.py'" CAMERA, 2, "must end in )");
    program_fails(SWEEP "--metric 'a:=exec( )'" CAMERA, 2, "names no program");
    program_fails(SWEEP "--metric 'a:=exec(x \"y)'" CAMERA, 2, "is not closed");
    program_fails(SWEEP "--metric 'a:=exec(x)' --until a=1" CAMERA, 2, "after the render");
    program_fails(SWEEP "--vary process/x=1 --metric mean" CAMERA, 2, "no program takes it");
}

/* A file runs nothing unless the command line says so, and cannot say so itself. */
static void test_files(void **state) {
    (void)state;
    static const char file[] = "{\"rig\": \"s.gltf\", \"vary\": \"emitters/panel/radiance=1\", "
                               "\"metric\": [\"found:=exec(python3 judge.py)\"], %s"
                               "\"electrons-per-unit\": 1000, \"full-well\": 4095, \"bits\": 12, "
                               "\"spp\": 16}";
    char text[512];
    snprintf(text, sizeof text, file, "");
    write_file("e.json", text);
    program_fails("sweep e.json", 2, "allow it by --allow-exec");
    assert_true(access("log", F_OK) != 0);
    program_well("sweep e.json --allow-exec");
    assert_int_equal(count_lines(read_whole("log")), 1);
    snprintf(text, sizeof text, file, "\"allow-exec\": true, ");
    write_file("e.json", text);
    program_fails("sweep e.json --force", 3, "is not for files");
    program_fails("sweep e-sweep.json -o again.csv", 2, "allow it by --allow-exec");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(test_answers, fresh_with_judge),
        cmocka_unit_test_setup(test_no_second_render, fresh_with_judge),
        cmocka_unit_test_setup(test_threshold, fresh_with_judge),
        cmocka_unit_test_setup(test_validation, fresh_with_judge),
        cmocka_unit_test_setup(test_optimized, fresh_with_judge),
        cmocka_unit_test_setup(test_failures, fresh_with_judge),
        cmocka_unit_test_setup(test_worker_that_ends, fresh_with_judge),
        cmocka_unit_test_setup(test_refused, fresh_with_judge),
        cmocka_unit_test_setup(test_files, fresh_with_judge),
    };
    return cmocka_run_group_tests(tests, enter_folder, leave_folder);
}
