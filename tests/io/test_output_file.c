/* SPDX-License-Identifier: Apache-2.0 */
#include "test.h"

#include <dirent.h>
#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "core/output_file.h"

static char folder[64];

static const char *in_folder(const char *name) {
    static char path[512];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    return path;
}

static int make_folder(void **state) {
    (void)state;
    strcpy(folder, "test_output_file.XXXXXX");
    return mkdtemp(folder) ? 0 : -1;
}

static int remove_folder(void **state) {
    (void)state;
    DIR *directory = opendir(folder);
    if (!directory) return -1;
    for (struct dirent *entry; (entry = readdir(directory));) {
        if (entry->d_name[0] != '.') unlink(in_folder(entry->d_name));
    }
    closedir(directory);
    return rmdir(folder);
}

static void expect_content(const char *path, const char *expected) {
    char content[256] = "";
    FILE *file = fopen(path, "r");
    assert_non_null(file);
    content[fread(content, 1, sizeof content - 1, file)] = '\0';
    fclose(file);
    assert_string_equal(content, expected);
}

static int files_in_folder(void) {
    int count = 0;
    DIR *directory = opendir(folder);
    assert_non_null(directory);
    for (struct dirent *entry; (entry = readdir(directory));) count += entry->d_name[0] != '.';
    closedir(directory);
    return count;
}

static void write_file(const char *path, const char *text) {
    mcv_error error = {""};
    mcv_output output;
    if (mcv_output_open(&output, path, &error) != MCV_OK ||
        mcv_output_write(&output, text, strlen(text), &error) != MCV_OK ||
        mcv_output_commit(&output, &error) != MCV_OK) {
        fail_msg("%s", error.text);
    }
}

static void test_appears_only_at_commit(void **state) {
    (void)state;
    mcv_error error = {""};
    mcv_output output;
    const char *path = in_folder("image");
    write_file(path, "old");
    assert_int_equal(mcv_output_open(&output, path, &error), MCV_OK);
    assert_int_equal(mcv_output_write(&output, "?? file", 7, &error), MCV_OK);
    assert_int_equal(mcv_output_write_at(&output, "ne", 2, 0, &error), MCV_OK);
    expect_content(path, "old");
    assert_int_equal(mcv_output_write(&output, ".", 1, &error), MCV_OK);
    assert_int_equal(mcv_output_commit(&output, &error), MCV_OK);
    expect_content(path, "ne file.");
    assert_int_equal(files_in_folder(), 1);
}

static void test_discard_leaves_what_was_there(void **state) {
    (void)state;
    mcv_error error = {""};
    mcv_output output;
    const char *path = in_folder("image");
    write_file(path, "old");
    assert_int_equal(mcv_output_open(&output, path, &error), MCV_OK);
    assert_int_equal(mcv_output_write(&output, "new", 3, &error), MCV_OK);
    mcv_output_discard(&output);
    expect_content(path, "old");
    assert_int_equal(mcv_output_check(path, &error), MCV_OK);
    expect_content(path, "old");
    assert_int_equal(files_in_folder(), 1);
}

static void test_permissions_follow_umask(void **state) {
    (void)state;
    const char *path = in_folder("image");
    const mode_t mask = umask(027);
    write_file(path, "x");
    umask(mask);
    struct stat status;
    assert_int_equal(stat(path, &status), 0);
    assert_int_equal(status.st_mode & 0777, 0640);
}

static void expect_refusal(const char *path, const char *reason) {
    mcv_error error = {""};
    if (mcv_output_check(path, &error) != MCV_BAD_INPUT) fail_msg("%s can be written", path);
    if (!strstr(error.text, path)) fail_msg("the sentence does not name %s: %s", path, error.text);
    if (!strstr(error.text, reason))
        fail_msg("the sentence does not say `%s`: %s", reason, error.text);
}

static void test_unwritable_targets_are_named(void **state) {
    (void)state;
    char path[512];
    expect_refusal("", "empty");
    expect_refusal(folder, "directory");
    expect_refusal("/dev/null", "device");
    expect_refusal(in_folder("missing/image"), "No such file or directory");
    write_file(in_folder("file"), "x");
    expect_refusal(in_folder("file/image"), "Not a directory");
    snprintf(path, sizeof path, "%s/%0300d", folder, 1);
    expect_refusal(path, "File name too long");
    assert_int_equal(symlink("file", in_folder("link")), 0);
    expect_refusal(in_folder("link"), "link");
    assert_int_equal(mkfifo(in_folder("pipe"), 0600), 0);
    expect_refusal(in_folder("pipe"), "pipe");
    if (geteuid() != 0) { /* root may write everywhere */
        assert_int_equal(chmod(in_folder("file"), 0444), 0);
        expect_refusal(in_folder("file"), "Permission denied");
        assert_int_equal(chmod(folder, 0555), 0);
        expect_refusal(in_folder("new"), "Permission denied");
        assert_int_equal(chmod(folder, 0755), 0);
    }
    assert_int_equal(files_in_folder(), 3);
}

/* A full disk, as a limit on the size of files. */
static void test_failed_write_is_reported(void **state) {
    (void)state;
    mcv_error error = {""};
    mcv_output output;
    const char *path = in_folder("image");
    write_file(path, "old");
    struct rlimit before;
    assert_int_equal(getrlimit(RLIMIT_FSIZE, &before), 0);
    signal(SIGXFSZ, SIG_IGN);
    const struct rlimit small = {.rlim_cur = 4096, .rlim_max = before.rlim_max};
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &small), 0);
    static const char block[8192];
    assert_int_equal(mcv_output_open(&output, path, &error), MCV_OK);
    const mcv_result result = mcv_output_write(&output, block, sizeof block, &error);
    mcv_output_discard(&output);
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &before), 0);
    assert_int_equal(result, MCV_FAILED);
    assert_non_null(strstr(error.text, path));
    assert_non_null(strstr(error.text, "File too large"));
    expect_content(path, "old");
    assert_int_equal(files_in_folder(), 1);
}

/* Several writers of one path at a time: each has its own temporary file. */
static void test_two_writers_do_not_mix(void **state) {
    (void)state;
    mcv_error error = {""};
    mcv_output a, b;
    const char *path = in_folder("image");
    assert_int_equal(mcv_output_open(&a, path, &error), MCV_OK);
    assert_int_equal(mcv_output_open(&b, path, &error), MCV_OK);
    assert_int_equal(mcv_output_write(&a, "aaa", 3, &error), MCV_OK);
    assert_int_equal(mcv_output_write(&b, "bb", 2, &error), MCV_OK);
    assert_int_equal(mcv_output_commit(&a, &error), MCV_OK);
    expect_content(path, "aaa");
    assert_int_equal(mcv_output_commit(&b, &error), MCV_OK);
    expect_content(path, "bb");
}

/* A process that begins to write and is killed. */
static void leave_unfinished(const char *path) {
    const pid_t child = fork();
    assert_true(child >= 0);
    if (child == 0) {
        mcv_output output;
        mcv_error error = {""};
        if (mcv_output_open(&output, path, &error) == MCV_OK)
            (void)mcv_output_write(&output, "half", 4, &error);
        raise(SIGKILL);
    }
    int status;
    assert_int_equal(waitpid(child, &status, 0), child);
    assert_true(WIFSIGNALED(status));
}

static void test_what_killed_processes_left_is_removed(void **state) {
    (void)state;
    static const char *const others[] = {"image.part", "image.1-x.part", "image.1-2.parts",
                                         "images.1-2.part", "image.1-2.part.old"};
    mcv_error error = {""};
    mcv_output output;
    const int before = files_in_folder();
    char path[512];
    snprintf(path, sizeof path, "%s", in_folder("image"));
    for (int i = 0; i < 3; ++i) leave_unfinished(path);
    assert_int_equal(files_in_folder(), before + 3);
    for (size_t i = 0; i < sizeof others / sizeof others[0]; ++i)
        write_file(in_folder(others[i]), "of the user");
    /* One is being written: it stays, whoever looks. */
    assert_int_equal(mcv_output_open(&output, path, &error), MCV_OK);
    assert_int_equal(mcv_output_check(path, &error), MCV_OK);
    assert_int_equal(files_in_folder(), before + 1 + 5);
    const pid_t child = fork();
    assert_true(child >= 0);
    if (child == 0) {
        close(output.descriptor); /* as in another program, which has not inherited it */
        _exit(mcv_output_check(path, &error) == MCV_OK ? 0 : 1);
    }
    int status;
    assert_int_equal(waitpid(child, &status, 0), child);
    assert_int_equal(status, 0);
    assert_int_equal(files_in_folder(), before + 1 + 5);
    assert_int_equal(mcv_output_write(&output, "whole", 5, &error), MCV_OK);
    assert_int_equal(mcv_output_commit(&output, &error), MCV_OK);
    expect_content(path, "whole");
    for (size_t i = 0; i < sizeof others / sizeof others[0]; ++i) unlink(in_folder(others[i]));
    unlink(path);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_appears_only_at_commit, make_folder, remove_folder),
        cmocka_unit_test_setup_teardown(test_discard_leaves_what_was_there, make_folder,
                                        remove_folder),
        cmocka_unit_test_setup_teardown(test_permissions_follow_umask, make_folder, remove_folder),
        cmocka_unit_test_setup_teardown(test_unwritable_targets_are_named, make_folder,
                                        remove_folder),
        cmocka_unit_test_setup_teardown(test_failed_write_is_reported, make_folder, remove_folder),
        cmocka_unit_test_setup_teardown(test_two_writers_do_not_mix, make_folder, remove_folder),
        cmocka_unit_test_setup_teardown(test_what_killed_processes_left_is_removed, make_folder,
                                        remove_folder),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
