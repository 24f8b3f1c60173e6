/* SPDX-License-Identifier: Apache-2.0 */
/* A damaged file in PoCL's cache of kernels, on which PoCL would end the process, is compiled
 * again. Skipped with another driver. */
#include "test.h"

#include "program.h"

#include <ftw.h>

/* Which ways of damage are tried: no file of tests shall take long. test_pocl_cache_zeros.c: the
 * last one alone. */
#ifndef FIRST_WAY
#define FIRST_WAY 0
#define WAYS 2
#endif

#define HASH "CDEFGHIJKLMNOPABCDEFGHIJKLMNOPABCDEFGH"

static char files[16][512];
static int file_count;

static int collect(const char *path, const struct stat *status, int type, struct FTW *ftw) {
    (void)status;
    (void)ftw;
    const char *dot = strrchr(path, '.');
    if (type == FTW_F && dot && (strcmp(dot, ".so") == 0 || strcmp(dot, ".bc") == 0) &&
        file_count < 16)
        snprintf(files[file_count++], sizeof files[0], "%s", path);
    return 0;
}

static const char *const render = "render beam.gltf --resolution 4x4 --spp 1 -o out.exr";

static void damage(const char *path, int how) {
    struct stat status;
    assert_int_equal(stat(path, &status), 0);
    if (how < 2) {
        assert_int_equal(truncate(path, how ? status.st_size / 2 : 0), 0);
        return;
    }
    char *zeros = calloc(1, (size_t)status.st_size); /* what some file systems leave */
    FILE *file = fopen(path, "r+b");
    assert_int_equal(fwrite(zeros, 1, (size_t)status.st_size, file), status.st_size);
    fclose(file);
    free(zeros);
}

/* A folder with a scene and an empty cache. */
static int enter_with_cache(void **state) {
    const int entered = enter_folder(state);
    if (entered != 0 || system("cp " MCV_SOURCE_DIR "/scenes/beam.gltf .") != 0) return -1;
    setenv("POCL_CACHE_DIR", "cache", 1);
    return mkdir("cache", 0700);
}

static void test_damaged(void **state) {
    (void)state;
    program_well(render);
    nftw("cache", collect, 16, FTW_PHYS);
    if (file_count == 0) skip(); /* no PoCL, or a PoCL without such files */
    assert_true(file_count >= 3);
    assert_int_equal(system("cp out.exr whole.exr"), 0);
    for (int i = 0; i < file_count; ++i)
        for (int how = FIRST_WAY; how < WAYS; ++how) {
            damage(files[i], how);
            const int code = program(render);
            if (code != 0)
                fail_msg("%s damaged in way %d: exit code %d: %s", files[i], how, code, said);
            struct stat status;
            if (stat(files[i], &status) != 0 || status.st_size == 0)
                fail_msg("%s was not compiled again", files[i]);
        }
    program_fails("compare out.exr whole.exr", 0, "");
}

/* Damage within a file, on which PoCL may end the process: then the sentence tells what to delete.
 */
static void test_damaged_within(void **state) {
    (void)state;
    program_well(render);
    file_count = 0;
    nftw("cache", collect, 16, FTW_PHYS);
    if (file_count == 0) skip();
    for (int i = 0; i < file_count; ++i) {
        FILE *file = fopen(files[i], "r+b");
        assert_non_null(file);
        assert_int_equal(fseek(file, 400, SEEK_SET), 0);
        for (int k = 0; k < 4000; ++k) fputc(k * 73 & 255, file);
        fclose(file);
    }
    const int code = program(render);
    print_message("exit code %d\n", code);
    if (code != 0 && !strstr(said, "delete the folder cache\n"))
        fail_msg("exit code %d: %s", code, said);
}

/* PoCL has no device, or builds nothing, where it cannot write: the sentence tells why. */
static void test_folder_that_takes_no_files(void **state) {
    (void)state;
    write_file("taken", "");
    setenv("POCL_CACHE_DIR", "taken", 1);
    if (program(render) != 0) program_fails(render, 4, "into the folder \"taken\": ");
    setenv("POCL_CACHE_DIR", "/proc/nowhere", 1);
    if (program(render) != 0)
        program_fails("devices", 4, "into the folder \"/proc/nowhere\": No such file or directory");
    unsetenv("POCL_CACHE_DIR");
    const char *was = getenv("HOME");
    char *home = strdup(was ? was : "");
    setenv("HOME", "/dev/null", 1);
    unsetenv("XDG_CACHE_HOME");
    if (program(render) != 0) program_fails(render, 4, "let POCL_CACHE_DIR name a folder");
    if (home) setenv("HOME", home, 1);
    free(home);
}

/* A file that another process is about to write is left to it: PoCL names it so until it is whole.
 * What is not PoCL's stays, such as a linker's script beside its folders. */
static void test_files_of_others(void **state) {
    (void)state;
    static const char of_pocl[] = "cache/AB/" HASH "/other.so";
    /* NOLINTNEXTLINE(bugprone-suspicious-missing-comma) */
    static const char *const kept[] = {"tempfile_a1b2c3.so", "libc.so", "lib/libm.so", "AB/libm.so",
                                       ("lib/" HASH "/libm.so")};
    char path[256];
    assert_int_equal(system("mkdir -p cache/lib/" HASH " cache/AB/" HASH), 0);
    for (size_t i = 0; i < sizeof kept / sizeof *kept; ++i) {
        snprintf(path, sizeof path, "cache/%s", kept[i]);
        write_file(path, "half");
    }
    write_file(of_pocl, "half");
    program_well(render);
    for (size_t i = 0; i < sizeof kept / sizeof *kept; ++i) {
        snprintf(path, sizeof path, "cache/%s", kept[i]);
        if (access(path, F_OK) != 0) fail_msg("%s was deleted", path);
    }
    file_count = 0;
    nftw("cache", collect, 16, FTW_PHYS);
    if (file_count > (int)(sizeof kept / sizeof *kept) + 1 && access(of_pocl, F_OK) == 0)
        fail_msg("%s was left", of_pocl);
}

static void test_empty(void **state) {
    (void)state;
    setenv("POCL_CACHE_DIR", "", 1);
    program_fails("devices", 4, "POCL_CACHE_DIR is set and empty");
    program_fails("render beam.gltf", 3, "beam.gltf");
    unsetenv("POCL_CACHE_DIR");
}

int main(void) {
    const struct CMUnitTest damage_alone[] = {
        cmocka_unit_test_setup_teardown(test_damaged, enter_with_cache, leave_folder)};
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_damaged, enter_with_cache, leave_folder),
        cmocka_unit_test_setup_teardown(test_damaged_within, enter_with_cache, leave_folder),
        cmocka_unit_test_setup_teardown(test_folder_that_takes_no_files, enter_with_cache,
                                        leave_folder),
        cmocka_unit_test_setup_teardown(test_files_of_others, enter_with_cache, leave_folder),
        cmocka_unit_test_setup_teardown(test_empty, enter_folder, leave_folder)};
    return FIRST_WAY ? cmocka_run_group_tests(damage_alone, NULL, NULL)
                     : cmocka_run_group_tests(tests, NULL, NULL);
}
