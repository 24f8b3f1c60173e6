/* SPDX-License-Identifier: Apache-2.0 */
/* Running the program in a folder of its own, through a shell. */
#ifndef MCVISI_TESTS_PROGRAM_H
#define MCVISI_TESTS_PROGRAM_H

#include "test.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <jansson.h>

static char program_folder[64];
static char said[1 << 16]; /* by the last run, standard error and output */

static int enter_folder(void **state) {
    (void)state;
    strcpy(program_folder, "program.XXXXXX");
    return mkdtemp(program_folder) && chdir(program_folder) == 0 ? 0 : -1;
}

static int leave_folder(void **state) {
    char command[128];
    (void)state;
    snprintf(command, sizeof command, "rm -rf %s", program_folder);
    return chdir("..") || system(command);
}

/* The exit code of `mcvisi LINE`; errors: what the shell does with standard error. */
static int program_into(const char *line, const char *errors) {
    char command[2048];
    assert_true(snprintf(command, sizeof command, MCV_BINARY_DIR "/mcvisi %s %s", line, errors) <
                (int)sizeof command);
    FILE *pipe = popen(command, "r");
    assert_non_null(pipe);
    said[fread(said, 1, sizeof said - 1, pipe)] = '\0';
    const int status = pclose(pipe);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

static inline int program(const char *line) { return program_into(line, "2>&1"); }

static inline void program_well(const char *line) {
    const int code = program(line);
    if (code != 0) fail_msg("mcvisi %s: exit code %d: %s", line, code, said);
}

/* Fails with this code and one line, the last, that holds the words. */
static inline void program_fails(const char *line, int code, const char *words) {
    const int got = program(line);
    if (got != code || !strstr(said, words))
        fail_msg("mcvisi %s: exit code %d, not %d with \"%s\": %s", line, got, code, words, said);
}

static inline json_t *program_json(const char *line) {
    json_error_t wrong;
    const int code = program_into(line, "2>program.err"); /* progress and warnings */
    if (code != 0) fail_msg("mcvisi %s: exit code %d", line, code);
    json_t *value = json_loads(said, 0, &wrong);
    if (!value) fail_msg("mcvisi %s: no JSON (%s): %s", line, wrong.text, said);
    return value;
}

/* What is at a path of keys and indices, as in "regions/0/mean/value". */
static inline const json_t *value_at(const json_t *object, const char *path) {
    char copy[256], *rest = NULL;
    snprintf(copy, sizeof copy, "%s", path);
    for (char *key = strtok_r(copy, "/", &rest); key; key = strtok_r(NULL, "/", &rest)) {
        object = json_is_array(object) ? json_array_get(object, strtoul(key, NULL, 10))
                                       : json_object_get(object, key);
        if (!object) fail_msg("%s: there is no %s", path, key);
    }
    return object;
}

static inline double number_at(const json_t *object, const char *path) {
    return json_number_value(value_at(object, path));
}

static inline void write_file(const char *path, const char *text) {
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    assert_true(fputs(text, file) >= 0);
    assert_int_equal(fclose(file), 0);
}

static inline char *read_whole(const char *path) {
    static char text[1 << 20];
    FILE *file = fopen(path, "r");
    if (!file) fail_msg("%s is missing", path);
    text[fread(text, 1, sizeof text - 1, file)] = '\0';
    fclose(file);
    return text;
}

/* A binary STL of a box from `lower` to `upper`. */
static inline void write_box_stl(const char *path, const double lower[3], const double upper[3]) {
    static const int faces[12][3] = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6},
                                     {0, 1, 4}, {1, 5, 4}, {2, 6, 3}, {3, 6, 7},
                                     {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
    const uint32_t count = 12;
    char record[50] = {0};
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    for (int i = 0; i < 80; ++i) fputc(0, file);
    fwrite(&count, 4, 1, file);
    for (int f = 0; f < 12; ++f) {
        for (int corner = 0; corner < 3; ++corner)
            for (int axis = 0; axis < 3; ++axis) {
                const float value =
                    (float)(faces[f][corner] >> axis & 1 ? upper[axis] : lower[axis]);
                memcpy(record + 12 + 12 * corner + 4 * axis, &value, 4);
            }
        fwrite(record, 50, 1, file);
    }
    assert_int_equal(fclose(file), 0);
}

#endif
