/* SPDX-License-Identifier: Apache-2.0 */
/* Light transport matrices take as much memory as --memory allows, beyond that of a render. */
#include "child.h"
#include "matrices.h"

#include "transport/matrix_file.h"

#include <sys/wait.h>

#define SCENE MCV_SOURCE_DIR "/scenes/painted-panel.gltf --resolution 140x105 --spp 64 "

/* The most memory that a run of the program had [bytes]; its exit code. */
static double most_of(const char *line, int *code) {
    struct rusage used;
    int status = 0;
    const pid_t child = child_start(line, 0);
    while (wait4(child, &status, 0, &used) < 0) assert_int_equal(errno, EINTR);
    *code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
    return 1024.0 * (double)used.ru_maxrss;
}

/* The driver compiles kernels in the first run of each kind, which takes memory of its own. */
static double most_without_compiling(const char *line) {
    int code;
    most_of(line, &code);
    const double most = most_of(line, &code);
    assert_int_equal(code, 0);
    return most;
}

/* Two files of the same scene hold the same entries. */
static void expect_same_entries(const char *a, const char *b) {
    mcv_error error;
    mcv_matrix first = {0}, second = {0};
    if (mcv_matrix_read(a, &first, &error) != MCV_OK ||
        mcv_matrix_read(b, &second, &error) != MCV_OK)
        fail_msg("%s", error.text);
    expect_equal(b, &first, &second);
    mcv_matrix_free(&first);
    mcv_matrix_free(&second);
}

/*
 * The paint is diffuse, so that each pixel has some 85 entries: 1.25 million of 32 bytes or more
 * while they are added up, 40 MB, and of 28 in the matrix, 35 MB. Less than both is enough, for
 * the same bits. What is refused has left no file, and has not taken more, either. 10 MB are for
 * the heap of the allocator, and for what the output of a file takes.
 */
static void test_memory_is_kept(void **state) {
    (void)state;
#ifdef __SANITIZE_ADDRESS__
    skip(); /* it takes memory of its own, which is most of all */
#endif
    static const double others = 10e6;
    int code;
    const double render = most_without_compiling("render " SCENE "-o render.exr"),
                 whole =
                     most_without_compiling("transport " SCENE "--memory 350MB -o t.npz") - render,
                 part = most_of("transport " SCENE "--memory 60MB -o part.npz", &code) - render;
    assert_int_equal(code, 0);
    const double refused = most_of("transport " SCENE "--memory 20MB -o no.npz", &code) - render;
    print_message("beyond a render: %.1f of 350 MB, %.1f of 60 MB, and %.1f of 20 MB\n",
                  whole / 1e6, part / 1e6, refused / 1e6);
    assert_int_equal(code, 3);
    assert_true(access("no.npz", F_OK) != 0);
    assert_true(whole > 75e6 && whole < 350e6 + others);
    assert_true(part > 35e6 && part < 60e6 + others);
    assert_true(refused < 20e6 + others);
    expect_same_entries("t.npz", "part.npz");
}

/* A bound without room for one tile of the image is refused before anything is rendered. */
static void test_a_tile_needs_room(void **state) {
    (void)state;
    int code;
    most_of("transport " SCENE "--memory 300kB -o no.npz", &code);
    assert_int_equal(code, 3);
    assert_true(access("no.npz", F_OK) != 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_memory_is_kept, enter_folder, leave_folder),
        cmocka_unit_test_setup_teardown(test_a_tile_needs_room, enter_folder, leave_folder)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
