/* SPDX-License-Identifier: Apache-2.0 */
/* A scene for experiments, and their tables. */
#ifndef MCVISI_TESTS_EXPERIMENT_FILES_H
#define MCVISI_TESTS_EXPERIMENT_FILES_H

#include "program.h"

#include <math.h>

/* A panel 1 m before a pinhole camera: the numbers of pixels (a JSON array) of `pixel` metres, the
 * panel's size [m] (an array) and its radiance. A pixel of 0.4 mm sees 40 mm of it. */
#define PANEL_SCENE(resolution, pixel, size, radiance) \
    "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0,1]}]," \
    "\"extensionsUsed\":[\"MCVISI_sensors\",\"MCVISI_emitters\"],\"extensions\":{" \
    "\"MCVISI_sensors\":{\"sensors\":[{\"name\":\"cam\",\"type\":\"pinhole\"," \
    "\"imageDistance\":0.01,\"resolution\":" resolution ",\"pixelSize\":" pixel "}]}," \
    "\"MCVISI_emitters\":{\"emitters\":[{\"name\":\"panel\",\"type\":\"area\",\"size\":" size "," \
    "\"radiance\":" radiance "}]}}," \
    "\"nodes\":[{\"name\":\"camera\",\"extensions\":{\"MCVISI_sensors\":{\"sensor\":0}}}," \
    "{\"name\":\"stand\",\"translation\":[0,0,-1],\"rotation\":[0,1,0,0]," \
    "\"extensions\":{\"MCVISI_emitters\":{\"emitter\":0}}}]}"

/* An empty folder but for s.gltf, the scene that is handed to this set-up, if any. */
static inline int fresh(void **state) {
    if (system("rm -rf ./*") != 0) return -1;
    if (*state) write_file("s.gltf", *state);
    return 0;
}

/* A test that begins in a fresh folder with this scene. */
#define FRESH(test, scene) \
    cmocka_unit_test_prestate_setup_teardown(test, fresh, NULL, (void *)scene)

static inline size_t count_lines(const char *text) {
    size_t lines = 0;
    for (; *text; ++text) lines += *text == '\n';
    return lines;
}

/* The numbers of a row of the table; NaN where a cell holds none. */
static inline void read_numbers(const char *table, size_t row, double *numbers, size_t count) {
    for (size_t i = 0; i <= row; ++i) table = strchr(table, '\n') + 1;
    for (size_t i = 0; i < count; ++i) {
        char *end;
        numbers[i] = strtod(table, &end);
        if (end == table) numbers[i] = NAN;
        table = end + 1;
    }
}

/* The file without its column of seconds, which differ; the caller frees it. */
static inline char *read_rows(const char *path) {
    char *text = NULL, line[1024];
    size_t size;
    FILE *file = fopen(path, "r"), *out = open_memstream(&text, &size);
    if (!file) fail_msg("%s: cannot be read", path);
    while (fgets(line, sizeof line, file)) {
        char *end = strrchr(line, ',');
        if (!end) fail_msg("%s: is no row: %s", path, line);
        while (end > line && end[-1] != ',') --end;
        fprintf(out, "%.*s\n", (int)(end - line), line);
    }
    fclose(file);
    fclose(out);
    return text;
}

static inline void expect_same_tables(const char *a, const char *b) {
    char *x = read_rows(a), *y = read_rows(b);
    if (strcmp(x, y) != 0) fail_msg("%s and %s differ:\n%s\n%s", a, b, x, y);
    free(x);
    free(y);
}

#endif
