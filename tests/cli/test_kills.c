/* SPDX-License-Identifier: Apache-2.0 */
/* Sweeps and merges that are killed at any moment: no file is damaged, and what goes on ends as it
 * would have without. */
#include "test.h"

#include "child.h"
#include "experiment_files.h"
#include "same_image.h"

#ifndef KILLS
#define KILLS 4 /* of sweeps, and of merges */
#endif

#define SWEEP \
    "sweep " MCV_SOURCE_DIR "/scenes/beam.gltf --vary emitters/beam/power=1..12:12 --metric mean " \
    "--spp 16 --resolution 16x16 --device reference"

/* Kills the line at a random moment of the time that it takes. True if it was killed. */
static bool kill_once(const char *line, double seconds) {
    const pid_t child = child_start(line, 0);
    const double end = now() + seconds * drand48();
    while (now() < end && !child_ended(child)) sleep_for(0.001);
    kill(child, SIGKILL);
    const int code = child_end(child);
    if (code != 0 && code != -SIGKILL) fail_msg("mcvisi %s: exit code %d: %s", line, code, said);
    return code != 0;
}

static void test_killed_sweeps_end_in_the_same_rows(void **state) {
    (void)state;
    const double begun = now();
    program_well(SWEEP " -o whole.csv");
    const double seconds = now() - begun;
    int killed = 0;
    srand48(1);
    for (int turn = 0; turn < 10 * KILLS && killed < KILLS; ++turn) {
        if (kill_once(SWEEP " -o killed.csv --resume", seconds))
            ++killed;
        else
            remove("killed.csv"); /* it was done: begin again */
    }
    program_well(SWEEP " -o killed.csv --resume");
    assert_int_equal(files_named(".", ".part"), 0);
    char *whole = read_rows("whole.csv"), *rows = read_rows("killed.csv");
    if (strcmp(whole, rows) != 0) fail_msg("after %d kills:\n%s\n%s", killed, whole, rows);
    free(whole);
    free(rows);
    print_message("%d of %d were killed\n", killed, KILLS);
}

/* The image that a merge replaces is the old one or the new one, whole. */
static void test_killed_merges_leave_whole_files(void **state) {
    static const char line[] = "merge a.film b.film -o merged.exr";
    (void)state;
    int killed = 0;
    program_well("render " MCV_SOURCE_DIR "/scenes/beam.gltf --resolution 64x64 --samples 0:4 "
                 "--film a.film -o a.exr --device reference");
    program_well("render " MCV_SOURCE_DIR "/scenes/beam.gltf --resolution 64x64 --samples 4:8 "
                 "--film b.film -o b.exr --device reference");
    const double begun = now();
    program_well(line);
    const double seconds = now() - begun;
    assert_int_equal(rename("merged.exr", "whole.exr"), 0);
    srand48(2);
    for (int i = 0; i < 10 * KILLS && killed < KILLS; ++i) {
        killed += kill_once(line, seconds);
        if (access("merged.exr", F_OK) == 0) expect_same_image("whole.exr", "merged.exr");
    }
    program_well(line);
    expect_same_image("whole.exr", "merged.exr");
    assert_int_equal(files_named(".", ".part"), 0);
    print_message("%d of %d were killed\n", killed, KILLS);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_killed_sweeps_end_in_the_same_rows),
        cmocka_unit_test(test_killed_merges_leave_whole_files),
    };
    return cmocka_run_group_tests(tests, enter_folder, leave_folder);
}
