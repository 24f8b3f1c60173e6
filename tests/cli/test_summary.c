/* SPDX-License-Identifier: Apache-2.0 */
#include "test.h"

#include <jansson.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Of the program, which is no library. */
#include "cli/interrupt.c"
#include "cli/progress.c"
#include "report/summary.h"

static mcv_summary example(void) {
    mcv_summary s = {
        .scene = "rig.gltf",
        .sensor = "cam",
        .image_path = "rig.exr",
        .preview_path = "rig.png",
        .unit = "W/(m^2 sr)",
        .width = 2448,
        .height = 2048,
        .channels = 1,
        .replicates = 4,
        .samples = 256,
        .stats = {.device = "cpu \"zen\"",
                  .features = "telecentric parallel dielectric",
                  .paths = (uint64_t)1 << 40,
                  .rays = 7,
                  .shadow_rays = 5,
                  .nonfinite = 3,
                  .lost_energy = 0.0125,
                  .light_paths = 0.25,
                  .depth_cut = 12,
                  .seconds_compile = 0.25,
                  .seconds_render = 12.34,
                  .stage_count = 1,
                  .stages = {{"intersect_closest", 3.5}}},
        .seconds_load = 0.5,
        .seconds_write = NAN,
        .error = 0.0084,
        .error_of_rest = 0.0083,
        .mean = 0.1,
        .preview = {.white = 0.25, .saturated = 0.005},
    };
    return s;
}

static double number_at(json_t *object, const char *group, const char *key) {
    json_t *value = json_object_get(group ? json_object_get(object, group) : object, key);
    if (!json_is_number(value)) fail_msg("%s/%s is no number", group ? group : "", key);
    return json_number_value(value);
}

static void test_json_holds_what_was_given(void **state) {
    (void)state;
    mcv_error error = {""};
    const mcv_summary s = example();
    char *text;
    assert_int_equal(mcv_summary_json(&s, &text, &error), MCV_OK);
    assert_null(strchr(text, '\n'));
    json_t *object = json_loads(text, JSON_REJECT_DUPLICATES, NULL);
    assert_non_null(object);
    assert_string_equal(json_string_value(json_object_get(object, "device")), "cpu \"zen\"");
    json_t *features = json_object_get(object, "features");
    assert_int_equal(json_array_size(features), 3);
    assert_string_equal(json_string_value(json_array_get(features, 2)), "dielectric");
    assert_true(number_at(object, NULL, "samples") == 256);
    assert_true(number_at(object, "rays", "paths") == 0x1p40);
    assert_true(number_at(object, "rays", "shadow") == 5);
    assert_true(number_at(object, "seconds", "compile") == 0.25);
    assert_true(number_at(object, "stages", "intersect_closest") == 3.5);
    assert_true(number_at(object, NULL, "mean") ==
                0.1); /* twelve digits give a short decimal back */
    assert_true(number_at(object, NULL, "lost_energy") == 0.0125);
    assert_true(number_at(object, NULL, "error_of_rest") == 0.0083);
    assert_true(number_at(object, NULL, "saturated") == 0.005);
    assert_true(number_at(object, "light_paths", "per_sample") == 0.25);
    assert_true(
        json_is_null(json_object_get(json_object_get(object, "light_paths"), "time_without")));
    assert_true(json_is_null(json_object_get(json_object_get(object, "seconds"), "write")));
    assert_true(json_is_false(json_object_get(object, "interrupted")));
    json_decref(object);
    free(text);
}

static void test_json_survives_missing_and_foreign_text(void **state) {
    (void)state;
    mcv_error error = {""};
    mcv_summary s = {.scene = "\xff\xfe.gltf", .error = INFINITY};
    char *text;
    assert_int_equal(mcv_summary_json(&s, &text, &error), MCV_OK);
    json_t *object = json_loads(text, 0, NULL);
    assert_non_null(object);
    assert_true(json_is_null(json_object_get(object, "scene")));
    assert_true(json_is_null(json_object_get(object, "error")));
    assert_int_equal(json_array_size(json_object_get(object, "features")), 0);
    json_decref(object);
    free(text);
}

static void test_text_says_it_in_sentences(void **state) {
    (void)state;
    mcv_error error = {""};
    mcv_summary s = example();
    char *text;
    assert_int_equal(mcv_summary_text(&s, &text, &error), MCV_OK);
    assert_string_equal(
        text, "cam: 2448 x 2048 pixels, 256 samples each, error 0.84 %, 12.3 s\n  mean 0.1 W/(m^2 "
              "sr); 0.5 % of the pixels are above the preview's white of 0.25\n  up to 1.2 % of "
              "the light is missing: 12 paths reached the depth limit (--depth)\n  3 samples were "
              "not finite and are ignored\n  rig.exr\n  rig.png\n");
    free(text);
    s.error_of_rest = 0.0021; /* few pixels hold most of it */
    assert_int_equal(mcv_summary_text(&s, &text, &error), MCV_OK);
    assert_non_null(strstr(text, "\n  without the 16 pixels of the largest error it is 0.21 %\n"));
    free(text);
    s.stats.light_paths = 0; /* by a pilot, which measures their ratio */
    s.stats.light_ratio = 0.5;
    assert_int_equal(mcv_summary_text(&s, &text, &error), MCV_OK);
    assert_non_null(strstr(text, "\n  without light paths, which a pilot has found to take 2 times "
                                 "as long to an error (--light-paths)\n"));
    free(text);
}

/* What a line prints to a stream in memory, for reports at these seconds of a render of 40 s. */
static char *progress(bool terminal, const double *times, size_t count,
                      const volatile sig_atomic_t *stop, bool *go_on) {
    char *text = NULL;
    size_t size = 0;
    mcv_progress_line line = {.stream = open_memstream(&text, &size),
                              .terminal = terminal,
                              .label = "cam",
                              .stop = stop,
                              .reported = -1};
    assert_non_null(line.stream);
    for (size_t i = 0; i < count; ++i)
        *go_on = mcv_progress_report(&line, times[i] / 40, times[i], i == 0 ? NAN : 0.0123);
    mcv_progress_end(&line);
    fclose(line.stream);
    return text;
}

static void test_progress_tells_the_time_left(void **state) {
    (void)state;
    const double times[] = {1, 1.05, 2, 9.9, 10, 15, 20, 40};
    const size_t count = sizeof times / sizeof times[0];
    bool go_on = false;
    char *text = progress(false, times, count, NULL, &go_on);
    assert_string_equal(text, "cam:  25 %, error 1.2 %, 10 s, 30 s left\n"
                              "cam:  50 %, error 1.2 %, 20 s, 20 s left\n"
                              "cam: 100 %, error 1.2 %, 40 s, 0 s left\n");
    assert_true(go_on);
    free(text);

    text = progress(true, times, 3, NULL, &go_on); /* 1.05 comes too soon after 1 */
    assert_string_equal(text, "\rcam:   2 %, 1 s"
                              "\rcam:   5 %, error 1.2 %, 2 s, 38 s left"
                              "\r                                       \r");
    free(text);

    /* Kernels are compiled for 19 s, the first tenth of a render of one second is there a tenth of
     * a second later. */
    size_t size = 0;
    mcv_progress_line line = {
        .stream = open_memstream(&text, &size), .terminal = true, .label = "cam", .reported = -1};
    assert_non_null(line.stream);
    mcv_progress_report(&line, (double)NAN, 0.01, INFINITY);
    mcv_progress_report(&line, 0.1, 19.1, INFINITY);
    mcv_progress_report(&line, 0.3, 19.3, INFINITY);
    fclose(line.stream);
    assert_string_equal(text, "\rcam: compiling kernels"
                              "\rcam:  10 %, 20 s      "
                              "\rcam:  30 %, 20 s, 1 s left");
    free(text);

    volatile sig_atomic_t stop = 1;
    text = progress(false, times, 1, &stop, &go_on);
    assert_false(go_on);
    assert_string_equal(text, "");
    free(text);
}

/*
 * A render by a clock of its own: `setup` seconds, a first round of four samples, and rounds as
 * mcv_next_round says, each of which takes 6 % more or less than its samples' time: from one to the
 * next 13 % at most, for which its margin of 15 % is. It ends before the limit and not before 0.8
 * of it, unless not one sample fits into the rest.
 */
static void test_rounds_fill_the_time(void **state) {
    static const double limit = 10;
    (void)state;
    for (int i = 0; i < 2000; ++i) {
        const double per_sample = 1e-5 * pow(10, 5.0 * i / 2000), setup = 3 * (i % 3);
        double elapsed = setup + 4 * per_sample, measured = per_sample;
        uint64_t done = 4, count;
        if (elapsed > limit) continue;
        for (int round = 0; (count = mcv_next_round(done, 1, measured, elapsed, limit)) > 0;
             ++round) {
            if ((count & (count - 1)) != 0 || done % count != 0)
                fail_msg("%llu samples after %llu", (unsigned long long)count,
                         (unsigned long long)done);
            measured = per_sample * (round % 2 ? 0.94 : 1.06);
            elapsed += measured * (double)count;
            done += count;
        }
        if (elapsed > limit)
            fail_msg("%g s per sample, %g s before: ends after %g s of %g", per_sample, setup,
                     elapsed, limit);
        if (elapsed < 0.8 * limit && elapsed + 1.15 * measured <= limit)
            fail_msg("%g s per sample, %g s before: ends after %g s of %g", per_sample, setup,
                     elapsed, limit);
    }
    for (uint64_t done = 1; done < 1u << 20; done *= 2)
        assert_true(mcv_next_round(done, 1, 1, 1e9, 0) == done);
    assert_true(mcv_next_round(24, 8, 0.1, 0, 100) ==
                8); /* adaptive: its lowest level takes an eighth of the samples */
    assert_true(mcv_next_round(24, 8, 0.1, 0, 0.7) == 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_json_holds_what_was_given),
        cmocka_unit_test(test_json_survives_missing_and_foreign_text),
        cmocka_unit_test(test_text_says_it_in_sentences),
        cmocka_unit_test(test_progress_tells_the_time_left),
        cmocka_unit_test(test_rounds_fill_the_time),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
