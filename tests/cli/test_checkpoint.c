/* SPDX-License-Identifier: Apache-2.0 */
/* Renders that are interrupted or killed, and go on from their checkpoint. */
#include "test.h"

#include "child.h"
#include "same_image.h"

#include "film/film_file.h"

#ifndef KILLS
#define KILLS 2 /* of each render */
#endif
/* Which renders are killed: no file of tests shall take long. test_checkpoint_kills.c: the first
 * ones and the reference; test_checkpoint_kills_caustic.c: the others. */
#ifndef FIRST_KILLED
#define FIRST_KILLED 0
#define LAST_KILLED 0
#endif

#define SCENES MCV_SOURCE_DIR "/scenes/"

/* When a file was written; 0: there is none. */
static struct timespec modified(const char *path) {
    struct stat status;
    return stat(path, &status) == 0 ? status.st_mtim : (struct timespec){0};
}

static bool is_same(struct timespec a, struct timespec b) {
    return a.tv_sec == b.tv_sec && a.tv_nsec == b.tv_nsec;
}

/* Waits until the file is written anew, or the child has ended: half a minute at most. */
static void wait_for_save(pid_t child, const char *path, struct timespec before) {
    for (int k = 0; k < 6000 && !child_ended(child); ++k, sleep_for(0.005))
        if (!is_same(before, modified(path))) return;
}

/* Kills a render at moments that depend on `seed`, each after a save that was asked for, and lets
 * it go on until it is done. One that is done before begins again, but not more than twice as often
 * as it shall be killed. The saves that were met are counted. */
static int render_with_kills(const char *line, int size, int kills, unsigned seed) {
    int saves = 0, killed = 0;
    char resumed[1024];
    snprintf(resumed, sizeof resumed,
             "render %s --resolution %dx%d -o killed.exr --checkpoint killed.film --resume", line,
             size, size);
    srand48(seed);
    remove("killed.exr");
    for (int i = 0; i < 2 * kills && killed < kills; ++i) {
        const pid_t child = child_start(resumed, 0);
        const double late = 0.1 * drand48(), later = 0.04 * drand48();
        const struct timespec before = modified("killed.film");
        child_wait_for_handler(child, SIGTERM);
        sleep_for(late);
        kill(child, SIGUSR1);
        wait_for_save(child, "killed.film", before);
        sleep_for(later);
        kill(child, SIGKILL);
        const int code = child_end(child);
        if (code != 0 && code != -SIGKILL)
            fail_msg("mcvisi %s: exit code %d: %s", resumed, code, said);
        killed += code != 0;
        saves += code != 0 && access("killed.film", R_OK) == 0;
        if (code != 0) continue;
        expect_same_image("whole.exr", "killed.exr");
        remove("killed.exr");
    }
    program_well(resumed);
    if (access("killed.film", F_OK) == 0) fail_msg("the checkpoint of a finished render is there");
    if (files_named(".", ".part") + files_named(".", "killed.film.lock") > 0)
        fail_msg("what killed renders left was not removed");
    print_message("%d of %d were killed, %d found a checkpoint\n", killed, kills, saves);
    return saves;
}

/* The picture is enlarged until a render takes long enough to be killed: machines differ. */
static void kills_change_nothing(const char *line, int size, unsigned seed) {
    char whole[1024];
    int saves = 0;
    for (; saves == 0 && size <= 1024; size *= 2) {
        snprintf(whole, sizeof whole, "render %s --resolution %dx%d -o whole.exr --checkpoint off",
                 line, size, size);
        program_well(whole);
        saves = render_with_kills(line, size, KILLS, seed);
        expect_same_image("whole.exr", "killed.exr");
    }
    if (saves == 0) fail_msg("mcvisi %s: was not killed after a save: nothing is shown", whole);
}

static void test_killed_renders_go_on_to_the_same_bits(void **state) {
    (void)state;
    static const struct {
        const char *line;
        int size; /* pixels in each direction */
    } renders[] = {
        {SCENES "beam.gltf --spp 2048", 96},
        {SCENES "beam.gltf --error 0.03 --seed 7", 64},
        {SCENES "beam.gltf --samples 512:1024 --replicates 3", 64},
        {SCENES "caustic.gltf --spp 1024 --light-paths on", 64},
        {SCENES "caustic.gltf --spp 1024 --adaptive", 64},
    };
    for (int i = FIRST_KILLED; i < LAST_KILLED; ++i)
        kills_change_nothing(renders[i].line, renders[i].size, (unsigned)i);
}

/* The reference renderer saves the rows that are done. */
static void test_the_reference_goes_on(void **state) {
    (void)state;
    if (FIRST_KILLED > 0) skip();
    kills_change_nothing(SCENES "beam.gltf --spp 256 --device reference", 48, 9);
}

/* --- one checkpoint, for the tests that follow --- */

#define STOPPED SCENES "beam.gltf --resolution 48x48"

static void stop_a_render(const char *options) {
    char line[1024];
    snprintf(line, sizeof line, "render " STOPPED " -o stopped.exr --checkpoint stopped.film %s",
             options);
    const pid_t child = child_start(line, 0);
    child_wait_for_handler(child, SIGTERM);
    kill(child, SIGTERM);
    const int code = child_end(child);
    if (code != 143) fail_msg("mcvisi %s: exit code %d: %s", line, code, said);
    assert_non_null(strstr(said, "continue by --resume from stopped.film"));
}

static void test_what_does_not_match_is_named(void **state) {
    (void)state;
    static const struct {
        const char *options, *words;
    } cases[] = {
        {STOPPED " --spp 1000000 --seed 1", "with --seed as it is by default, not 1"},
        {STOPPED " --spp 2000000", "with --spp 1000000, not 2000000"},
        {STOPPED " --spp 1000000 --depth 4", "--depth"},
        {STOPPED " --spp 1000000 --precision double", "with --precision single, not double"},
        {STOPPED " --spp 1000000 --split off", "--split"},
        {STOPPED " --spp 1000000 --replicates 8", "--replicates"},
        {STOPPED " --spp 1000000 --set sensors/camera/radiometry=irradiance", "--set"},
        {SCENES "beam.gltf --spp 1000000", "--resolution 48x48"},
        {SCENES "sky.gltf --spp 1000000 --resolution 48x48", "is of another scene"},
    };
    stop_a_render("--spp 1000000");
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        char line[1024];
        snprintf(line, sizeof line, "render %s -o other.exr --checkpoint stopped.film --resume",
                 cases[i].options);
        program_fails(line, 3, cases[i].words);
    }
}

/* Any byte that differs, and any cut, is noticed. */
static void test_damaged_checkpoints_are_refused(void **state) {
    (void)state;
    static uint8_t bytes[1 << 21];
    stop_a_render("--spp 1000000 --resume");
    FILE *file = fopen("stopped.film", "rb");
    assert_non_null(file);
    const size_t size = fread(bytes, 1, sizeof bytes, file);
    fclose(file);
    assert_true(size > 10000 && size < sizeof bytes);
    for (size_t i = 0; i < 12; ++i) {
        const size_t at = i < 4 ? 4 * i : size / 12 * i;
        bytes[at] ^= 0x10;
        file = fopen("damaged.film", "wb");
        assert_int_equal(fwrite(bytes, 1, i == 11 ? size / 2 : size, file),
                         i == 11 ? size / 2 : size);
        fclose(file);
        bytes[at] ^= 0x10;
        program_fails("render " STOPPED
                      " --spp 1000000 -o other.exr --checkpoint damaged.film --resume",
                      3, "damaged.film: ");
    }
}

/* What is finished stays, and an interrupted image says so. */
static void test_an_interrupted_image_is_known(void **state) {
    (void)state;
    mcv_error error = {""};
    mcv_exr image;
    remove("stopped.film");
    remove("stopped.exr");
    stop_a_render("--spp 1000000");
    assert_int_equal(mcv_exr_read("stopped.exr", &image, &error), MCV_OK);
    assert_non_null(mcv_exr_numbers(&image, "mcvisi:interrupted", 1));
    mcv_exr_free(&image);
    program_well("render " STOPPED " -o stopped.exr --spp 4 --checkpoint off");
    program_well("render " STOPPED " -o finished.exr --spp 4 --checkpoint off");
    remove("stopped.film");
    stop_a_render("--spp 1000000");
    if (!strstr(said, "saved in stopped-interrupted.exr; the finished image stays, stopped.exr"))
        fail_msg("%s", said);
    expect_same_image("finished.exr", "stopped.exr");
    assert_int_equal(access("stopped-interrupted.exr", R_OK), 0);
    assert_int_equal(access("stopped-interrupted.png", R_OK), 0);
    program("render " STOPPED " -o stopped.exr --spp 4 --checkpoint stopped.film");
    assert_non_null(strstr(said, "stopped.film: holds an unfinished render"));
}

/* A save that is asked for while kernels are built, when LLVM in the driver has a handler of its
 * own, is made after the first launch. */
static void test_a_save_may_be_asked_for_early(void **state) {
    (void)state;
    remove("stopped.film");
    mkdir("cold", 0700);
    setenv("POCL_CACHE_DIR", "cold", 1);
    const pid_t child = child_start("render " STOPPED " -o stopped.exr --checkpoint stopped.film "
                                    "--spp 1000000000",
                                    0);
    child_wait_for_handler(child, SIGTERM);
    for (int i = 0; i < 3000 && files_named("cold", "tempfile") == 0 && !child_ended(child); ++i)
        sleep_for(0.001);
    kill(child, SIGUSR1);
    wait_for_save(child, "stopped.film", (struct timespec){0});
    unsetenv("POCL_CACHE_DIR");
    const bool saved = access("stopped.film", R_OK) == 0;
    kill(child, SIGKILL);
    const int code = child_end(child);
    if (code != -SIGKILL) fail_msg("exit code %d: %s", code, said);
    if (!saved) fail_msg("SIGUSR1 while kernels were built was lost");
}

/* The folder of the image is gone, or its disk is full, when the work is done. */
static void test_an_image_that_cannot_be_written(void **state) {
    (void)state;
    static const char render[] = "render " SCENES "beam.gltf --resolution 32x32 --device reference "
                                 "--spp 1024 -o gone/a.exr --checkpoint kept.film --resume";
    assert_int_equal(mkdir("gone", 0700), 0);
    const pid_t child = child_start(render, 0);
    child_wait_for_handler(child, SIGTERM);
    kill(child, SIGUSR1);
    wait_for_save(child, "kept.film", (struct timespec){0});
    assert_int_equal(rename("gone", "away"), 0);
    const int code = child_end(child);
    if (code != 3 || !strstr(said, "the checkpoint stays, kept.film: "))
        fail_msg("exit code %d: %s", code, said);
    assert_int_equal(rename("away", "gone"), 0);
    program_well(render);
    assert_int_not_equal(access("kept.film", F_OK), 0);
    assert_null(strstr(said, "there is no checkpoint"));
}

/* --- one process writes a checkpoint --- */

#define HELD STOPPED " --device reference -o held.exr "

static pid_t start_holder(const char *line, const char *lock) {
    const pid_t child = child_start(line, 0);
    child_wait_for_handler(child, SIGTERM);
    for (int i = 0; i < 6000 && access(lock, F_OK) != 0 && !child_ended(child); ++i)
        sleep_for(0.005);
    if (access(lock, F_OK) == 0) return child;
    kill(child, SIGKILL);
    fail_msg("mcvisi %s: exit code %d, and no %s: %s", line, child_end(child), lock, said);
    return child;
}

static void expect_stopped(pid_t child, int signal, int expected) {
    kill(child, signal);
    const int code = child_end(child);
    if (code != expected) fail_msg("exit code %d, not %d: %s", code, expected, said);
}

/* The second process is told who writes, and loses nothing of either; a killed one blocks nobody.
 */
static void test_one_process_renders_an_image(void **state) {
    char words[96];
    (void)state;
    const pid_t child = start_holder("render " HELD "--time 1000", "held.checkpoint.lock");
    snprintf(words, sizeof words, "held.checkpoint: is being written by process %d: wait",
             (int)child);
    kill(child, SIGUSR1);
    wait_for_save(child, "held.checkpoint", (struct timespec){0});
    const int before = files_named(".", "held");
    program_fails("render " HELD "--time 1000", 3, words);
    program_fails("render " HELD "--spp 4 --resume", 3, words);
    program_fails("render " STOPPED " --spp 4 -o rival.exr --checkpoint held.checkpoint", 3, words);
    assert_int_equal(files_named(".", "held"), before);
    assert_int_equal(files_named(".", "rival"), 0);
    program_well("render " STOPPED " --spp 4 --device reference -o beside.exr");
    program_well("render " HELD "--spp 4 --checkpoint off");
    expect_same_image("beside.exr", "held.exr");
    assert_int_equal(access("held.checkpoint", F_OK), 0);
    expect_stopped(child, SIGKILL, -SIGKILL);
    const pid_t next = start_holder("render " HELD "--time 1000 --resume", "held.checkpoint.lock");
    expect_stopped(next, SIGTERM, 143);
    assert_null(strstr(said, "there is no checkpoint"));
    assert_int_equal(files_named(".", "held.checkpoint.lock"), 0);
    assert_int_equal(access("held.checkpoint", F_OK), 0);
}

/* Who renders several sensors has all of their files from the beginning. */
static void test_one_process_renders_several_images(void **state) {
    (void)state;
    const char *line = "render " SCENES "bolts.gltf --resolution 8x8 --device reference "
                       "--time 1000 -o several.exr";
    const pid_t child = start_holder(line, "several-telecentric.checkpoint.lock");
    assert_int_equal(access("several-entocentric.checkpoint.lock", F_OK), 0);
    program_fails("render " SCENES "bolts.gltf --sensor telecentric --resolution 8x8 --spp 4 "
                  "--device reference -o several-telecentric.exr",
                  3, "several-telecentric.checkpoint: is being written by process");
    program_fails(line, 3, "several-entocentric.checkpoint: is being written by process");
    expect_stopped(child, SIGTERM, 143);
    assert_int_equal(files_named(".", "tric.checkpoint.lock"), 0);
}

/* --- images that are finished --- */

#define TWO \
    SCENES "bolts.gltf --resolution 8x8 --device reference --checkpoint off -o two.exr --resume "

static void expect_finished(const char *line, bool one, bool other) {
    const struct timespec before[] = {modified("two-entocentric.exr"),
                                      modified("two-telecentric.exr")};
    sleep_for(0.02); /* a file that is written anew has another time */
    program_well(line);
    const bool stays[] = {strstr(said, "two-entocentric.exr: is finished, and stays") != NULL,
                          strstr(said, "two-telecentric.exr: is finished, and stays") != NULL};
    if (stays[0] != one || stays[1] != other) fail_msg("mcvisi %s: %s", line, said);
    assert_int_equal(is_same(before[0], modified("two-entocentric.exr")), one);
    assert_int_equal(is_same(before[1], modified("two-telecentric.exr")), other);
}

/* Of several sensors those that are finished are not rendered again. */
static void test_finished_images_stay(void **state) {
    (void)state;
    expect_finished("render " TWO "--spp 4", false, false);
    assert_int_equal(system("cp two-telecentric.exr whole.exr"), 0);
    remove("two-telecentric.exr");
    remove("two-entocentric.png");
    expect_finished("render " TWO "--spp 4", true, false);
    expect_same_image("whole.exr", "two-telecentric.exr");
    assert_int_equal(access("two-entocentric.png", R_OK), 0);
    expect_finished("render " TWO "--spp 4 --camera grey.png --expose-to 0.5", true, true);
    assert_int_equal(access("grey-entocentric.png", R_OK), 0);
    expect_finished("render " TWO "--spp 8", false, false);
    assert_non_null(strstr(said, "two-entocentric.exr: is of another render, or has no film"));
    expect_finished("render " TWO "--spp 8 --parts replicates", false, false);
    assert_int_equal(system("head -c 900 whole.exr >two-telecentric.exr"), 0);
    expect_finished("render " TWO "--spp 8 --parts replicates", true, false);
}

/* The image of a part is finished once its film is there; merged parts are the image. */
static void test_finished_parts_stay(void **state) {
    (void)state;
    program_well("render " STOPPED " --samples 0:4 -o a.exr");
    program_well("render " STOPPED " --samples 0:4 -o a.exr --film a.film --resume");
    assert_non_null(strstr(said, "it is rendered anew"));
    program_well("render " STOPPED " --samples 0:4 -o a.exr --film a.film --resume");
    assert_non_null(strstr(said, "a.exr: is finished, and stays"));
    program_well("render " STOPPED " --samples 4:8 -o b.exr --film b.film");
    program_well("render " STOPPED " --samples 0:4 -o a.exr --film b.film --resume");
    assert_non_null(strstr(said, "it is rendered anew"));
    program_well("render " STOPPED " --samples 4:8 -o b.exr --film b.film");
    program_well("merge a.film b.film -o ab.exr");
    program_well("render " STOPPED " --samples 0:8 -o ab.exr --resume");
    assert_non_null(strstr(said, "ab.exr: is finished, and stays"));
    json_t *kept = program_json("render " STOPPED " --samples 0:8 -o ab.exr --resume --json");
    assert_string_equal(json_string_value(json_object_get(kept, "image")), "ab.exr");
    assert_true(json_is_true(json_object_get(kept, "kept")));
    json_decref(kept);
}

/* The time before counts: a checkpoint that says that all of it has passed ends at once. */
static void test_time_goes_on(void **state) {
    (void)state;
    mcv_film_file file;
    mcv_error error = {""};
    remove("stopped.film");
    stop_a_render("--time 1000");
    assert_int_equal(mcv_film_file_read("stopped.film", &file, &error), MCV_OK);
    json_t *state_of = json_object_get(file.facts, "state");
    const double before = json_number_value(json_object_get(state_of, "seconds"));
    if (!(before > 0 && before < 300)) fail_msg("%g s had passed", before);
    json_object_set_new(state_of, "seconds", json_real(999.99));
    json_object_del(file.facts, "film");
    assert_int_equal(
        mcv_film_file_write("stopped.film", &file.film, &file.round, file.facts, &error), MCV_OK);
    mcv_film_file_free(&file);
    const double begun = now();
    program_well("render " STOPPED
                 " -o stopped.exr --checkpoint stopped.film --time 1000 --resume");
    if (now() - begun > 100) fail_msg("%.2f s of 1000 s were left after 999.99 s", now() - begun);
}

int main(void) {
    const struct CMUnitTest kills[] = {
        cmocka_unit_test(test_killed_renders_go_on_to_the_same_bits),
        cmocka_unit_test(test_the_reference_goes_on),
    };
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_what_does_not_match_is_named),
        cmocka_unit_test(test_damaged_checkpoints_are_refused),
        cmocka_unit_test(test_an_interrupted_image_is_known),
        cmocka_unit_test(test_an_image_that_cannot_be_written),
        cmocka_unit_test(test_a_save_may_be_asked_for_early),
        cmocka_unit_test(test_one_process_renders_an_image),
        cmocka_unit_test(test_one_process_renders_several_images),
        cmocka_unit_test(test_finished_images_stay),
        cmocka_unit_test(test_finished_parts_stay),
        cmocka_unit_test(test_time_goes_on),
    };
    return LAST_KILLED ? cmocka_run_group_tests(kills, enter_folder, leave_folder)
                       : cmocka_run_group_tests(tests, enter_folder, leave_folder);
}
