/* SPDX-License-Identifier: Apache-2.0 */
/* The probability of detection as users call it: tables, options, what is told. No OpenCL device
 * is needed. */
#include "api.h"

#include "program.h"

#include <math.h>
#include <unistd.h>

static void write_text(const char *path, const char *text) {
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    assert_true(fputs(text, file) >= 0);
    assert_int_equal(fclose(file), 0);
}

/* y = a ± 2, each size with both; and flawless parts of ± 1. */
static void write_line(const char *path, bool flawless) {
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    fputs("set,\"depth, m\",peak,found,part,message\n", file);
    for (int i = 0; i < 40; ++i) {
        const double a = 1 + (double)(i / 2), y = a + (i % 2 ? 2 : -2);
        fprintf(file, "%d,%g,%g,%d,part %d,\n", i, a, y, y >= 8, i);
    }
    for (int i = 0; i < 20 && flawless; ++i)
        fprintf(file, "%d,0,%d,%s,clean %d,\r\n", 40 + i, i % 2 ? 1 : -1, "false", i);
    fputs("99,,,,,\"failed, \"\"badly\"\",\nin two lines\"\n\n", file);
    assert_int_equal(fclose(file), 0);
}

static json_t *study(const char *path, const char *options) {
    char *report = NULL;
    WELL(mcv_pod_table(path, options, &report, &error));
    json_t *found = json_loads(report, 0, NULL);
    assert_non_null(found);
    mcv_text_free(report);
    return found;
}

static double number(const json_t *report, const char *group, const char *key) {
    const json_t *object = group ? json_object_get(report, group) : report;
    const json_t *value = json_object_get(object, key);
    if (!json_is_number(value)) fail_msg("%s %s is no number", group ? group : "", key);
    return json_number_value(value);
}

#define LINE \
    "\"size\": \"depth, m\", \"signal\": \"peak\", \"size-scale\": \"linear\", " \
    "\"signal-scale\": \"linear\", \"size-unit\": \"none\""

/* The numbers of the line are those of SciPy (statistics/test_pod.c). */
static void test_table(void **state) {
    (void)state;
    write_line("line.csv", true);
    json_t *r = study("line.csv", "{" LINE ", \"threshold\": \"8\"}");
    assert_true(fabs(number(r, NULL, "a90_bound") - 11.4964950885) < 1e-8);
    assert_true(fabs(number(r, "a50", "value") - 8) < 1e-9);
    assert_int_equal(number(r, NULL, "defects"), 40);
    assert_int_equal(number(r, NULL, "left_out"), 1);
    assert_int_equal(number(r, "false_calls", "flawless"), 20);
    assert_int_equal(number(r, "false_calls", "calls"), 0);
    assert_non_null(strstr(json_string_value(json_object_get(r, "answer")), "A defect of 11.5 is"));
    json_decref(r);
    /* ± 1 has the deviation √(20/19); 3.0902 of it are exceeded in one of a thousand cases. */
    r = study("line.csv", "{" LINE ", \"false-calls\": \"0.001\"}");
    assert_true(fabs(number(r, NULL, "threshold") - 3.090232306 * sqrt(20.0 / 19)) < 1e-8);
    assert_true(fabs(number(r, "false_calls", "expected_rate") - 0.001) < 1e-9);
    json_decref(r);
}

/* Rows of one defect count once: the first one. */
static void test_defects(void **state) {
    (void)state;
    char text[8192] = "size,peak,part\n";
    for (int i = 0; i < 40; ++i) {
        const int a = 1 + i / 2, y = a + (i % 2 ? 2 : -2);
        const size_t at = strlen(text);
        snprintf(text + at, sizeof text - at, "%d,%d,p%d\n%d,%d,p%d\n", a, y, i, a, 1000, i);
    }
    write_text("twice.csv", text);
    json_t *r = study("twice.csv", "{\"signal\": \"peak\", \"defect\": \"part\", \"threshold\": "
                                   "\"8\", \"size-scale\": \"linear\", \"signal-scale\": "
                                   "\"linear\"}");
    assert_true(fabs(number(r, NULL, "a90_bound") - 11.4964950885) < 1e-8);
    assert_int_equal(number(r, NULL, "repeated"), 40);
    json_decref(r);
}

/* No bound: a sentence, and null. */
static void test_no_number(void **state) {
    static const struct {
        const char *options, *words;
    } cases[] = {
        {"{" LINE ", \"threshold\": \"25\"}", "No size up to 20"},
        {"{\"size\": \"depth, m\", \"hit\": \"few\"}", "too few hits for a bound"},
        {"{\"size\": \"depth, m\", \"hit\": \"all\"}", "too few misses for a bound"},
    };
    (void)state;
    char text[8192] = "\"depth, m\",peak,few,all\n";
    for (int i = 0; i < 40; ++i) {
        const size_t at = strlen(text);
        snprintf(text + at, sizeof text - at, "%d,%d,%d,1\n", 1 + i / 2,
                 1 + i / 2 + (i % 2 ? 2 : -2), i >= 37);
    }
    write_text("none.csv", text);
    for (size_t i = 0; i < 3; ++i) {
        json_t *r = study("none.csv", cases[i].options);
        const char *answer = json_string_value(json_object_get(r, "answer"));
        if (!strstr(answer, cases[i].words)) fail_msg("\"%s\"", answer);
        assert_true(json_is_null(json_object_get(r, "a90_bound")));
        assert_null(strstr(answer, "NaN"));
        assert_null(strstr(answer, "nan"));
        json_decref(r);
    }
}

static void refuse(mcv_result code, const char *words, const char *table, const char *options) {
    char *report = NULL;
    FAILS(code, words, mcv_pod_table(table, options, &report, &error));
    assert_null(report);
}

static void test_refused(void **state) {
    static const char hit[] = "{\"hit\": \"hit\"}";
    (void)state;
    write_line("line.csv", false);
    refuse(MCV_USAGE, "give --signal or --hit", "line.csv", NULL);
    refuse(MCV_USAGE, "give --signal or --hit", "line.csv", "{\"hit\": \"a\", \"signal\": \"b\"}");
    refuse(MCV_USAGE, "--threshold is missing", "line.csv", "{" LINE "}");
    refuse(MCV_USAGE, "must be a number", "line.csv", "{" LINE ", \"threshold\": \"high\"}");
    refuse(MCV_USAGE, "above 0 and below 1", "line.csv", "{" LINE ", \"false-calls\": \"1\"}");
    refuse(MCV_USAGE, "exclude each other", "line.csv",
           "{" LINE ", \"false-calls\": \"0.1\", \"threshold\": \"8\"}");
    refuse(MCV_USAGE, "below --saturated-above", "line.csv",
           "{" LINE ", \"threshold\": \"8\", \"lost-below\": \"3\", \"saturated-above\": \"2\"}");
    refuse(MCV_BAD_INPUT, "at least 10 flawless parts", "line.csv",
           "{" LINE ", \"false-calls\": \"0.1\"}");
    refuse(MCV_BAD_INPUT, "there is no column hit", "line.csv",
           "{\"size\": \"depth, m\", \"hit\": \"hit\"}");
    refuse(MCV_BAD_INPUT, "absent.csv", "absent.csv", hit);
    write_text("bad.csv", "");
    refuse(MCV_BAD_INPUT, "is empty", "bad.csv", hit);
    write_text("bad.csv", "size,hit\n1,2,3\n");
    refuse(MCV_BAD_INPUT, "bad.csv:2: has 3 fields", "bad.csv", hit);
    write_text("bad.csv", "size,hit\n1,1\nbig,0\n");
    refuse(MCV_BAD_INPUT, "bad.csv:3: size is \"big\"", "bad.csv", hit);
    write_text("bad.csv", "size,hit\n1,");
    refuse(MCV_BAD_INPUT, "0 defects are too few", "bad.csv", hit);
    write_text("bad.csv", "size,hit\n1,0.3");
    refuse(MCV_BAD_INPUT, "must be 0 or 1", "bad.csv", hit);
    write_text("bad.csv", "size,hit\n-1,0");
    refuse(MCV_BAD_INPUT, "must be above 0", "bad.csv", hit);
}

static void test_values(void **state) {
    double sizes[40], values[40];
    char *report = NULL;
    (void)state;
    for (int i = 0; i < 40; ++i) {
        sizes[i] = 1 + (double)(i / 2);
        values[i] = sizes[i] + (i % 2 ? 2 : -2);
    }
    WELL(mcv_pod_values(sizes, values, 40, false,
                        "{\"threshold\": \"8\", \"size-scale\": \"linear\", \"signal-scale\": "
                        "\"linear\"}",
                        &report, &error));
    json_t *r = json_loads(report, 0, NULL);
    assert_true(fabs(number(r, NULL, "a90_bound") - 11.4964950885) < 1e-8);
    json_decref(r);
    mcv_text_free(report);
    FAILS(MCV_USAGE, "hit",
          mcv_pod_values(sizes, values, 40, true, "{\"hit\": \"x\"}", &report, &error));
    FAILS(MCV_USAGE, "must not be NULL",
          mcv_pod_values(NULL, values, 40, true, NULL, &report, &error));
}

/* Text of a page; freed by the caller. */
static char *read_page(const char *path) {
    FILE *file = fopen(path, "r");
    assert_non_null(file);
    char *text = calloc(1, 1 << 20);
    assert_non_null(text);
    assert_true(fread(text, 1, (1 << 20) - 1, file) > 1000);
    assert_int_equal(fclose(file), 0);
    return text;
}

static void expect_on(const char *page, const char *words, bool there) {
    if ((strstr(page, words) != NULL) != there)
        fail_msg("\"%s\" %s on the page", words, there ? "is not" : "is");
}

/* The answer is the first thing; names of others cannot run; nothing is loaded. */
static void test_page(void **state) {
    (void)state;
    write_line("line.csv", true);
    json_t *r = study("line.csv", "{" LINE ", \"threshold\": \"8\", \"output\": \"line.html\", "
                                  "\"title\": \"<b>dents</b>\"}");
    const char *answer = json_string_value(json_object_get(r, "answer"));
    char *page = read_page("line.html");
    expect_on(page, answer, true);
    expect_on(page, "<b>dents</b>", false);
    expect_on(page, "&lt;b", true);
    expect_on(page, "default-src 'none'", true);
    expect_on(page, "<script", false);
    expect_on(page, "http", true); /* Content-Security-Policy alone: */
    expect_on(page, "http:", false);
    expect_on(page, "https:", false);
    assert_true(strstr(page, answer) < strstr(page, "<svg"));
    expect_on(page, "<polygon", true);
    expect_on(page, "a90/95", true);
    expect_on(page, "0 of 20 flawless parts", true);
    expect_on(page, "nan", false);
    free(page);
    json_decref(r);
}

/* Beyond the tested sizes only the side is known: with signals that grow as the size from 1 on, a
 * threshold below all of them finds smaller ones, too, and one above all finds none. */
static void test_page_beyond_the_sizes(void **state) {
    (void)state;
    char text[4096] = "size,signal\n";
    for (int i = 1; i <= 40; ++i) {
        const size_t at = strlen(text);
        snprintf(text + at, sizeof text - at, "%g,%g\n", 1e-3 * i, i + 0.1 * (i % 3));
    }
    write_text("beyond.csv", text);
    for (int k = 0; k < 2; ++k) {
        json_decref(study("beyond.csv", k ? "{\"signal\": \"signal\", \"threshold\": \"60\", "
                                            "\"output\": \"b.html\"}"
                                          : "{\"signal\": \"signal\", \"threshold\": \"0.1\", "
                                            "\"output\": \"b.html\"}"));
        char *page = read_page("b.html");
        const char *row = k ? "(a50)<td>above 40 mm<td>above 40 mm<td>above 40 mm"
                            : "(a50)<td>1 mm or less<td>1 mm or less<td>1 mm or less";
        expect_on(page, row, true);
        expect_on(page, "nan", false);
        free(page);
    }
}

/* Without a bound there is no band and no a90/95. */
static void test_page_without_bound(void **state) {
    (void)state;
    char text[4096] = "size,few,all\n";
    for (int i = 0; i < 40; ++i) {
        const size_t at = strlen(text);
        snprintf(text + at, sizeof text - at, "%g,%d,1\n", 1e-5 * (1 + i), i >= 37);
    }
    write_text("few.csv", text);
    for (int k = 0; k < 2; ++k) {
        json_decref(study("few.csv", k ? "{\"hit\": \"all\", \"output\": \"few.html\"}"
                                       : "{\"hit\": \"few\", \"output\": \"few.html\"}"));
        char *page = read_page("few.html");
        expect_on(page, "for a bound, and so there is none", true);
        expect_on(page, "<polygon", false);
        expect_on(page, "a90/95", false);
        expect_on(page, "nan", false);
        expect_on(page, "No flawless part was tested", true);
        free(page);
    }
    char *report = NULL;
    FAILS(MCV_BAD_INPUT, "nowhere",
          mcv_pod_table("few.csv", "{\"hit\": \"few\", \"output\": \"nowhere/x.html\"}", &report,
                        &error));
}

static void test_the_verb(void **state) {
    (void)state;
    write_line("line.csv", true);
    program_well("pod line.csv --size 'depth, m' --signal peak --threshold 8 --size-unit none");
    program_well("pod line.csv --size 'depth, m' --hit found --json");
    program_fails("pod line.csv --hit found", 3, "there is no column size");
    program_fails("pod", 2, "TABLE.csv|EXPERIMENT.json is missing");
}

/* --- experiments --- */

/* The "size" is the sky's radiance, its signal the grey value of one pixel: y = 1000 x ± the read
 * noise of 100 and the shot noise of √(1000 x), 104.9 at x = 1. */
#define EXPERIMENT(study, more) \
    "{\"vary\": \"emitters/sky/radiance=0.4..1.6:40\", \"region\": \"mid=4,4,1,1\", \"metric\": " \
    "\"grey:=mid.mean\", \"electrons-per-unit\": 1000, \"full-well\": 4095, \"bits\": 12, " \
    "\"read-noise\": 100, \"spp\": 4, \"pod\": {\"size\": \"radiance\", \"size-unit\": " \
    "\"none\"" study "}" more "}"
#define STUDY \
    ", \"signal\": \"grey\", \"threshold\": 1000, \"size-scale\": \"linear\", \"signal-scale\": " \
    "\"linear\""
#define TABLE ", \"output\": \"sky.csv\""

static unsigned rows;

/* Goes on with the first four sets. */
static bool four(void *user, const char *row) {
    (void)user;
    rows += row && strstr(row, "\"set\"") != NULL;
    return rows < 4;
}

static bool all(void *user, const char *row) {
    (void)user;
    rows += row && strstr(row, "\"set\"") != NULL;
    return true;
}

/* An interrupted one goes on; its report is that of its table. */
static void test_experiment(void **state) {
    mcv_session *session = open_session("{\"device\": \"reference\", \"threads\": 1}");
    mcv_rig *rig = parse_rig(sky_rig);
    char *report = NULL, *same = NULL;
    (void)state;
    rows = 0;
    FAILS(MCV_INTERRUPTED, "",
          mcv_session_pod(session, rig, EXPERIMENT(STUDY, TABLE), four, NULL, &report, &error));
    assert_null(report);
    assert_int_equal(rows, 4);
    WELL(mcv_session_pod(session, rig, EXPERIMENT(STUDY, TABLE ", \"resume\": true"), all, NULL,
                         &report, &error));
    assert_int_equal(rows, 40);
    json_t *r = json_loads(report, 0, NULL);
    /* As known as the mean of 40 sets is: four of these. */
    const double a50 = number(r, "a50", "value");
    if (!(fabs(a50 - 1) < 4 * 0.105 / sqrt(40))) fail_msg("a50 %g: must be 1", a50);
    json_decref(r);
    WELL(mcv_pod_table("sky.csv", "{\"size\": \"radiance\", \"size-unit\": \"none\"" STUDY "}",
                       &same, &error));
    assert_string_equal(report, same);
    mcv_text_free(same);
    mcv_text_free(report);
    mcv_rig_free(rig);
    mcv_session_close(session);
}

/* What cannot be studied is not rendered. */
static void test_experiment_refused(void **state) {
    static const struct {
        const char *options, *words;
    } cases[] = {
        {NULL, "output: is missing"},
        {"{\"output\": \"not.csv\"}", "pod: is missing"},
        {EXPERIMENT(STUDY, ""), "output: is missing"},
        {EXPERIMENT("", ", \"output\": \"not.csv\""), "give --signal or --hit"},
        {EXPERIMENT(", \"signal\": \"grey\"", ", \"output\": \"not.csv\""),
         "--threshold is missing"},
        {EXPERIMENT(", \"sgnal\": \"x\"", ", \"output\": \"not.csv\""), "sgnal"},
        {EXPERIMENT(", \"signal\": \"grey\", \"threshold\": \"high\"", ", \"output\": \"not.csv\""),
         "must be a number"},
        {"[]", "must be a JSON object"},
    };
    mcv_session *session = open_session("{\"device\": \"reference\"}");
    mcv_rig *rig = parse_rig(sky_rig);
    char *report = NULL;
    (void)state;
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        FAILS(MCV_USAGE, cases[i].words,
              mcv_session_pod(session, rig, cases[i].options, all, NULL, &report, &error));
        assert_null(report);
    }
    FAILS(MCV_USAGE, "must not be NULL",
          mcv_session_pod(session, NULL, EXPERIMENT(STUDY, TABLE), all, NULL, &report, &error));
    assert_int_not_equal(access("not.csv", F_OK), 0);
    mcv_rig_free(rig);
    mcv_session_close(session);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_page),
        cmocka_unit_test(test_page_beyond_the_sizes),
        cmocka_unit_test(test_page_without_bound),
        cmocka_unit_test(test_table),
        cmocka_unit_test(test_defects),
        cmocka_unit_test(test_no_number),
        cmocka_unit_test(test_refused),
        cmocka_unit_test(test_values),
        cmocka_unit_test(test_the_verb),
        cmocka_unit_test(test_experiment),
        cmocka_unit_test(test_experiment_refused),
    };
    return cmocka_run_group_tests(tests, enter_folder, leave_folder);
}
