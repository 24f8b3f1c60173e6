/* SPDX-License-Identifier: Apache-2.0 */
/* Signals to the program, and its limits: exit codes, and what is left behind. */
#include "test.h"

#include "child.h"

#define SCENE MCV_SOURCE_DIR "/scenes/beam.gltf"

/* The driver's compiler gets the signal as well where it goes to the whole group, as from a batch
 * system; LLVM in the driver removes its files in any case. */
static void test_terminated_while_kernels_are_built(void **state) {
    (void)state;
    int built = 0;
    for (int turn = 0; turn < 4; ++turn) {
        char cache[64];
        snprintf(cache, sizeof cache, "cache-%d", turn);
        assert_int_equal(mkdir(cache, 0700), 0);
        setenv("POCL_CACHE_DIR", cache, 1);
        const pid_t child =
            child_start("render " SCENE " -o early.exr --resolution 8x8 --spp 4", 0);
        for (int i = 0; i < 10000 && files_named(cache, "tempfile") == 0 && !child_ended(child);
             ++i)
            sleep_for(0.001);
        sleep_for(0.03 * turn);
        built += files_named(cache, "tempfile") > 0;
        kill(turn % 2 ? -child : child, SIGTERM);
        const int code = child_end(child);
        if (code != 143) fail_msg("turn %d: exit code %d, not 143: %s", turn, code, said);
        assert_null(strstr(said, "clBuildProgram"));
        assert_int_equal(files_named(".", ".part"), 0);
    }
    unsetenv("POCL_CACHE_DIR");
    if (built == 0)
        print_message("the driver showed no temporary file: its building was not met\n");
}

/* The reference renderer begins at once and does not end in the time of a test. Few pixels: their
 * first sample is there before the signal is looked at. */
static void test_signals_end_with_their_codes(void **state) {
    (void)state;
    static const int signals[] = {SIGINT, SIGTERM, SIGHUP, SIGXCPU};
    for (size_t i = 0; i < sizeof signals / sizeof signals[0]; ++i) {
        remove("stopped.exr");
        const pid_t child = child_start(
            "render " SCENE " -o stopped.exr --resolution 4x4 --time 1000 --device reference", 0);
        child_wait_for_handler(child, signals[i]);
        kill(child, signals[i]);
        const int code = child_end(child);
        if (code != 128 + signals[i])
            fail_msg("signal %d: exit code %d: %s", signals[i], code, said);
        assert_int_equal(access("stopped.exr", R_OK), 0);
        assert_int_equal(files_named(".", ".part"), 0);
    }
}

/* timeout, for one, sends its signal to the process and then to the group: one request. */
static void test_a_signal_that_comes_twice_at_once(void **state) {
    (void)state;
    for (int turn = 0; turn < 5; ++turn) {
        remove("twice.exr");
        const pid_t child = child_start(
            "render " SCENE " -o twice.exr --resolution 4x4 --time 1000 --device reference", 0);
        child_wait_for_handler(child, SIGTERM);
        kill(child, SIGTERM);
        sleep_for(0.001 * turn);
        kill(-child, SIGTERM);
        const int code = child_end(child);
        if (code != 143) fail_msg("%d ms apart: exit code %d: %s", turn, code, said);
        if (access("twice.exr", R_OK) != 0) fail_msg("%d ms apart: no image: %s", turn, said);
    }
}

/* A second signal ends the program at once: here kernels are compiled, for seconds. The empty file
 * of the lock stays, which nobody holds; the next render removes it. */
static void test_a_second_signal(void **state) {
    (void)state;
    struct stat lock;
    assert_int_equal(mkdir("second", 0700), 0);
    setenv("POCL_CACHE_DIR", "second", 1);
    const pid_t child = child_start(
        "render " MCV_SOURCE_DIR "/scenes/glasses.gltf -o second.exr --resolution 8x8 --spp 4", 0);
    child_wait_for_handler(child, SIGINT);
    kill(child, SIGINT);
    sleep_for(0.6); /* Sooner, it would count as the first one, sent twice (mcv_interrupt_watch). */
    const double begun = now();
    kill(child, SIGINT);
    const int code = child_end(child);
    unsetenv("POCL_CACHE_DIR");
    if (code != -SIGINT) fail_msg("exit code %d: %s", code, said);
    if (now() - begun > 1) fail_msg("it took %g s", now() - begun);
    assert_int_equal(access("second.exr", F_OK), -1);
    assert_int_equal(stat("second.checkpoint.lock", &lock), 0);
    assert_int_equal(lock.st_size, 0);
    const pid_t next = child_start(
        "render " SCENE " -o second.exr --resolution 8x8 --spp 4 --device reference", 0);
    assert_int_equal(child_end(next), 0);
    assert_int_equal(stat("second.checkpoint.lock", &lock), -1);
}

/* A write above the limit fails with a sentence; the old image stays. */
static void test_limited_file_size(void **state) {
    (void)state;
    write_file("limited.exr", "the image before");
    const pid_t child = child_start(
        "render " SCENE " -o limited.exr --resolution 64x64 --spp 4 --device reference", 2048);
    const int code = child_end(child);
    if (code != 1 || !strstr(said, "limited.exr: writing failed: File too large"))
        fail_msg("exit code %d: %s", code, said);
    assert_int_equal(files_named(".", ".part"), 0);
    char text[64] = "";
    FILE *file = fopen("limited.exr", "r");
    assert_non_null(file);
    text[fread(text, 1, sizeof text - 1, file)] = '\0';
    fclose(file);
    assert_string_equal(text, "the image before");
}

/* The driver could not write its kernels: it is the limit, no fault of theirs. */
static void test_limited_file_size_of_kernels(void **state) {
    (void)state;
    assert_int_equal(mkdir("limited", 0700), 0);
    setenv("POCL_CACHE_DIR", "limited", 1);
    const pid_t child =
        child_start("render " SCENE " -o kernels.exr --resolution 8x8 --spp 4", 20480);
    const int code = child_end(child);
    unsetenv("POCL_CACHE_DIR");
    if (code == 0) skip(); /* a driver without files */
    if (code != 4 || !strstr(said, "files may have at most 20480 bytes (ulimit -f)"))
        fail_msg("exit code %d: %s", code, said);
    assert_int_equal(files_named(".", ".part"), 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_terminated_while_kernels_are_built),
        cmocka_unit_test(test_signals_end_with_their_codes),
        cmocka_unit_test(test_a_signal_that_comes_twice_at_once),
        cmocka_unit_test(test_a_second_signal),
        cmocka_unit_test(test_limited_file_size),
        cmocka_unit_test(test_limited_file_size_of_kernels),
    };
    return cmocka_run_group_tests(tests, enter_folder, leave_folder);
}
