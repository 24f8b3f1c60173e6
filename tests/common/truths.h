/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What tests find beside closed forms, for `./run accuracy`: where MCVISI_ACCURACY names a file,
 * each test adds a line of JSON to it when it ends: the worst case of every truth, as error over
 * bound, and points of plots. A truth is called by its number, as in "T3 sphere: crossing", or by
 * one of the names below.
 */
#ifndef MCVISI_TESTS_TRUTHS_H
#define MCVISI_TESTS_TRUTHS_H

#include <ctype.h>
#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct noted_truth {
    char what[96];
    const char *renderer;
    double error, bound;
    int cases;
} noted_truth;

static noted_truth noted_truths[256];
static int noted_count;

static inline FILE *open_truths(void) {
    const char *path = getenv("MCVISI_ACCURACY");
    return path ? fopen(path, "a") : NULL;
}

static inline void write_truths(void) {
    FILE *file = open_truths();
    for (int i = 0; file && i < noted_count; ++i)
        fprintf(file,
                "{\"truth\": \"%s\", \"renderer\": \"%s\", \"error\": %.6g, \"bound\": %.6g, "
                "\"cases\": %d}\n",
                noted_truths[i].what, noted_truths[i].renderer,
                isfinite(noted_truths[i].error) ? noted_truths[i].error : 1e300,
                noted_truths[i].bound, noted_truths[i].cases);
    if (file) fclose(file);
}

static inline bool is_truth(const char *what) {
    static const char *const names[] = {"bias:", "coverage:", "traversal:"};
    for (size_t i = 0; i < sizeof names / sizeof names[0]; ++i)
        if (strncmp(what, names[i], strlen(names[i])) == 0) return true;
    return what[0] == 'T' && isdigit((unsigned char)what[1]);
}

/* renderer: "device", "reference", or "program" for what only measures. Names that are no truth's
 * are passed over. */
static inline void note_truth(const char *what, const char *renderer, double error, double bound) {
    int i = 0;
    if (!is_truth(what) || !getenv("MCVISI_ACCURACY")) return;
    while (i < noted_count && (strcmp(noted_truths[i].what, what) != 0 ||
                               strcmp(noted_truths[i].renderer, renderer) != 0))
        ++i;
    if (i == noted_count) {
        if (i == (int)(sizeof noted_truths / sizeof noted_truths[0])) abort();
        if (noted_count++ == 0) atexit(write_truths);
        snprintf(noted_truths[i].what, sizeof noted_truths[i].what, "%s", what);
        noted_truths[i].renderer = renderer;
    } else if (error * noted_truths[i].bound <= noted_truths[i].error * bound) {
        ++noted_truths[i].cases;
        return;
    }
    noted_truths[i].error = error;
    noted_truths[i].bound = bound;
    ++noted_truths[i].cases;
}

/* A point of a series in a plot. */
static inline void note_point(const char *plot, const char *series, double x, double y) {
    FILE *file = open_truths();
    if (!file) return;
    fprintf(file, "{\"plot\": \"%s\", \"series\": \"%s\", \"x\": %.9g, \"y\": %.9g}\n", plot,
            series, x, y);
    fclose(file);
}

#endif
