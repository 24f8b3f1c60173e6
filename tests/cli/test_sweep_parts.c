/* SPDX-License-Identifier: Apache-2.0 */
/* Sweeps in parts, several sweeps on one table, sets that are tried again. */
#include "test.h"

#include "child.h"
#include "experiment_files.h"

#define SWEEP \
    "sweep " MCV_SOURCE_DIR "/scenes/beam.gltf --vary emitters/beam/power=1..8:8 --metric mean " \
    "--spp 4 --resolution 8x8 --device reference"

static void test_parts_make_the_table(void **state) {
    (void)state;
    program_well(SWEEP " -o whole.csv");
    program_well(SWEEP " -o part.csv --range 2/3");
    program_well(SWEEP " -o part.csv --range 0/3");
    program_well(SWEEP " -o part.csv --range 1/3");
    program_well("merge part.2-of-3.csv part.0-of-3.csv part.1-of-3.csv -o joined.csv");
    assert_null(strstr(said, "missing"));
    expect_same_tables("whole.csv", "joined.csv");
    /* The page comes of the experiment beside the table, without a render. */
    program_well("sweep joined.json -o joined.csv --resume");
    expect_same_tables("whole.csv", "joined.csv");
    assert_int_equal(access("joined.html", R_OK), 0);
}

static void test_what_is_wrong_with_parts_is_told(void **state) {
    (void)state;
    program_well("merge part.2-of-3.csv part.0-of-3.csv -o two.csv");
    assert_non_null(strstr(said, "parts are missing: 1/3"));
    program_well("sweep two.json -o two.csv --resume");
    program_fails("merge part.0-of-3.csv part.0-of-3.csv -o no.csv", 3, "both have set 0");
    program_fails("merge part.0-of-3.csv whole.csv -o no.csv", 3, "both have set 0");
    program_fails("merge part.0-of-3.csv part.1-of-3.csv -o two.csv", 3, "exists already");
    program_well("merge part.0-of-3.csv part.1-of-3.csv -o two.csv --force");
    program_well(SWEEP " --seed 5 -o seed.csv --range 1/3");
    program_fails("merge part.0-of-3.csv seed.1-of-3.csv -o no.csv", 3, "--seed differs");
    program_fails(SWEEP " -o no.csv --range 3/3", 2, "--range 3/3");
    program_fails(SWEEP " -o no.csv --range -1/3", 2, "--range");
    program_fails(SWEEP " -o no.csv --range 1/3x", 2, "--range 1/3x");
    assert_int_equal(access("no.csv", F_OK), -1);
}

/* Of eight processes on one table one writes; the others end with a sentence. */
static void test_one_process_writes_a_table(void **state) {
    enum { PROCESSES = 8 };
    pid_t children[PROCESSES];
    int well = 0, held = 0;
    (void)state;
    for (int i = 0; i < PROCESSES; ++i)
        children[i] = child_start(SWEEP " -o shared.csv --resume --depth 8", 0);
    for (int i = 0; i < PROCESSES; ++i) {
        const int code = child_end(children[i]);
        if (code != 0 && code != 3) fail_msg("exit code %d: %s", code, said);
        well += code == 0;
        held += code == 3;
    }
    /* Who comes after the end of another one resumes a table that is complete. */
    if (well < 1) fail_msg("%d wrote, %d were refused", well, held);
    FILE *file = fopen("shared.csv", "r");
    assert_non_null(file);
    int lines = 0;
    for (int c; (c = fgetc(file)) != EOF;) lines += c == '\n';
    fclose(file);
    assert_int_equal(lines, 9);
}

/* While one of eight writes, seven end with exit code 3 and tell who writes. */
static void test_the_holder_is_told(void **state) {
    enum { OTHERS = 7 };
    pid_t others[OTHERS];
    char words[64];
    (void)state;
    const pid_t child = child_start(
        "sweep " MCV_SOURCE_DIR "/scenes/beam.gltf --vary emitters/beam/power=1,2 --metric mean "
        "--time 1000 --device reference -o held.csv",
        0);
    for (int i = 0; i < 6000 && access("held.csv", F_OK) != 0 && !child_ended(child); ++i)
        sleep_for(0.005);
    sleep_for(0.05);
    snprintf(words, sizeof words, "is being written by process %d", (int)child);
    program_fails(SWEEP " -o held.csv", 3, words);
    program_fails(SWEEP " -o held.csv --force", 3, words);
    for (int i = 0; i < OTHERS; ++i) others[i] = child_start(SWEEP " -o held.csv --resume", 0);
    for (int i = 0; i < OTHERS; ++i) assert_int_equal(child_end(others[i]), 3);
    kill(child, SIGTERM);
    const int code = child_end(child);
    if (code != 143 && code != -SIGTERM) fail_msg("exit code %d: %s", code, said);
}

/* No device at all concerns all sets: none has a row, and a later run renders them. */
static void test_no_device_ends_the_sweep(void **state) {
    (void)state;
    program_fails("sweep " MCV_SOURCE_DIR
                  "/scenes/beam.gltf --vary emitters/beam/power=1..8:8 --metric mean --spp 4 "
                  "--resolution 8x8 --device 99 -o nowhere.csv",
                  4, "no set can be rendered");
    FILE *file = fopen("nowhere.csv", "r");
    assert_non_null(file);
    int lines = 0;
    for (int c; (c = fgetc(file)) != EOF;) lines += c == '\n';
    fclose(file);
    assert_int_equal(lines, 1);
}

/* Rows of sets that failed for want of a device are rendered again, others stay as they are. */
static void test_failed_sets_are_tried_again(void **state) {
    (void)state;
    FILE *in = fopen("whole.csv", "r"), *out = fopen("again.csv", "w");
    char line[1024];
    assert_true(in && out);
    for (int i = 0; fgets(line, sizeof line, in); ++i)
        if (i == 3 || i == 5)
            fprintf(out, "%d,%d,,,,,,%s\n", i - 1, i,
                    i == 3 ? "\"device trouble: it was gone\"" : "\"a reason of its own\"");
        else
            fputs(line, out);
    fclose(in);
    fclose(out);
    assert_int_equal(system("cp whole.json again.json"), 0);
    program_well(SWEEP " -o again.csv --resume");
    in = fopen("again.csv", "r");
    int lines = 0, own = 0, trouble = 0;
    for (; fgets(line, sizeof line, in); ++lines) {
        own += strstr(line, "a reason of its own") != NULL;
        trouble += strstr(line, "device trouble") != NULL;
    }
    fclose(in);
    assert_int_equal(lines, 9);
    assert_int_equal(own, 1);
    assert_int_equal(trouble, 0);
}

/* A line that was edited is not guessed at, and the table stays as it is. */
static void test_rows_begin_with_a_set(void **state) {
    static const char *const begins[] = {"1.5", "1e0", "-1", "8", "99999999999999999999",
                                         "",    "x1",  "+1"};
    char row[512];
    (void)state;
    snprintf(row, sizeof row, "%.400s", strchr(read_whole("whole.csv"), '\n') + 1);
    row[strcspn(row, "\n")] = '\0';
    assert_int_equal(system("cp whole.json edited.json"), 0);
    for (size_t i = 0; i < sizeof begins / sizeof begins[0]; ++i) {
        char text[1024], words[128];
        snprintf(text, sizeof text, "%.*s\n%s%s\n", (int)strcspn(read_whole("whole.csv"), "\n"),
                 read_whole("whole.csv"), begins[i], strchr(row, ','));
        snprintf(words, sizeof words,
                 "edited.csv: line 2: \"%s\" must be the number of a set, from 0 to 7", begins[i]);
        write_file("edited.csv", text);
        program_fails(SWEEP " -o edited.csv --resume", 3, words);
        assert_string_equal(read_whole("edited.csv"), text);
    }
}

/* A file that only has the name of what is written beside a table is kept, as it is. */
static void test_files_of_the_user_are_kept(void **state) {
    static const char plate[] = "{\"plate\": 1}\n";
    (void)state;
    write_file("plate.json", plate);
    program_fails("merge part.0-of-3.csv part.1-of-3.csv -o plate.csv", 3,
                  "plate.json exists already, and was not written beside a table");
    program_fails(SWEEP " -o plate.csv", 3, "plate.json exists already");
    assert_string_equal(read_whole("plate.json"), plate);
    assert_int_equal(access("plate.csv", F_OK), -1);
    program_well("merge part.0-of-3.csv part.1-of-3.csv -o plate.csv --force");
    /* A damaged file beside a table is not taken for one of the user: --force would lose the rows.
     */
    assert_int_equal(system("cp whole.csv cut.csv; head -c 100 whole.json >cut.json"), 0);
    program_fails(SWEEP " -o cut.csv --resume", 3, "without it cut.csv cannot be resumed");
    assert_null(strstr(said, "--force"));
    /* What a sweep has written there is replaced once its table is gone. */
    assert_int_equal(unlink("plate.csv"), 0);
    program_well(SWEEP " -o plate.csv");
}

/* Tables and what lies beside them are regular files of bounded size, without lost rows. */
static void test_damaged_parts_are_told(void **state) {
    static const char *const rows[] = {"99999999999999999999", "+1", " 1", "-1", "x"};
    char command[256];
    (void)state;
    assert_int_equal(system("cp part.0-of-3.json bad.json; cp part.0-of-3.csv bad.csv; "
                            "printf '\\0\\n1,1,1,1\\n' >>bad.csv"),
                     0);
    program_fails("merge bad.csv part.1-of-3.csv -o no.csv", 3, "bad.csv: has a byte 0");
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; ++i) {
        snprintf(command, sizeof command, "cp part.0-of-3.csv bad.csv; echo '%s,1,1,1' >>bad.csv",
                 rows[i]);
        assert_int_equal(system(command), 0);
        program_fails("merge bad.csv part.1-of-3.csv -o no.csv", 3, "has a line that is no row");
    }
    assert_int_equal(system("cp part.0-of-3.csv bad.csv; rm bad.json; mkfifo bad.json"), 0);
    program_fails("merge bad.csv part.1-of-3.csv -o no.csv", 3,
                  "bad.json: is not a regular file; without it bad.csv cannot be merged");
    program_fails("sweep bad.json", 3, "bad.json: is not a regular file");
    program_fails("pod bad.json", 3, "bad.json: is not a regular file");
    assert_int_equal(system("rm bad.json; head -c 4000001 /dev/zero >bad.json"), 0);
    program_fails("merge bad.csv part.1-of-3.csv -o no.csv", 3, "bad.json: is larger than 4 MB");
    assert_int_equal(access("no.csv", F_OK), -1);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_parts_make_the_table),
        cmocka_unit_test(test_what_is_wrong_with_parts_is_told),
        cmocka_unit_test(test_one_process_writes_a_table),
        cmocka_unit_test(test_the_holder_is_told),
        cmocka_unit_test(test_no_device_ends_the_sweep),
        cmocka_unit_test(test_failed_sets_are_tried_again),
        cmocka_unit_test(test_rows_begin_with_a_set),
        cmocka_unit_test(test_files_of_the_user_are_kept),
        cmocka_unit_test(test_damaged_parts_are_told),
    };
    return cmocka_run_group_tests(tests, enter_folder, leave_folder);
}
