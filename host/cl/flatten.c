/* SPDX-License-Identifier: Apache-2.0 */
#include "cl/flatten.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MAX_FILES = 1024, MAX_DEPTH = 16, MAX_CONDITIONS = 64, MAX_PATH = 1024 };

/* A file that is in the text, and the branch of an #if in which it is; 0: in none. */
typedef struct seen_file {
    char name[128];
    unsigned branch;
} seen_file;

typedef struct flattening {
    const char *root;
    FILE *out;
    seen_file seen[MAX_FILES];
    size_t seen_count;
    unsigned open[MAX_CONDITIONS]; /* the branches around the current line, include guards apart */
    size_t open_count;
    unsigned last_branch;
    mcv_error *error;
} flattening;

static FILE *open_source(const flattening *f, const char *name) {
    static const char *const folders[] = {"kernels", "include"};
    char path[MAX_PATH];
    for (size_t i = 0; i < 2; ++i) {
        snprintf(path, sizeof path, "%s/%s/%s", f->root, folders[i], name);
        FILE *file = fopen(path, "r");
        if (file) return file;
    }
    return NULL;
}

static bool begins(const char *text, const char *word) {
    return strncmp(text, word, strlen(word)) == 0;
}

/* Whether the text has the file already wherever the current line counts. In another branch it may
 * not: its include guard then decides. */
static bool is_there(const flattening *f, const char *name) {
    for (size_t i = 0; i < f->seen_count; ++i) {
        if (strcmp(f->seen[i].name, name) != 0) continue;
        if (f->seen[i].branch == 0) return true;
        for (size_t k = 0; k < f->open_count; ++k)
            if (f->open[k] == f->seen[i].branch) return true;
    }
    return false;
}

/* Follows the conditions of a file. *guards: 1 if its first one is its include guard, -1: not yet
 * known. False if there are too many. */
static bool follow_condition(flattening *f, const char *hash, size_t outside, int *guards) {
    if (begins(hash, "#if")) {
        if (*guards < 0) {
            *guards = begins(hash, "#ifndef");
            if (*guards) return true;
        }
        if (f->open_count == MAX_CONDITIONS) return false;
        f->open[f->open_count++] = ++f->last_branch;
    } else if (f->open_count > outside) {
        if (begins(hash, "#el")) f->open[f->open_count - 1] = ++f->last_branch;
        if (begins(hash, "#endif")) --f->open_count;
    }
    return true;
}

static mcv_result flatten_file(flattening *f, const char *name, int depth) {
    const size_t outside = f->open_count;
    if (is_there(f, name)) return MCV_OK;
    if (depth == MAX_DEPTH || f->seen_count == MAX_FILES ||
        strlen(name) >= sizeof f->seen[0].name) {
        return mcv_fail(f->error, MCV_FAILED, "%s: includes are nested too deeply or too many",
                        name);
    }
    seen_file *seen = f->seen + f->seen_count++;
    memcpy(seen->name, name, strlen(name) + 1);
    seen->branch = outside > 0 ? f->open[outside - 1] : 0;
    FILE *in = open_source(f, name);
    if (!in)
        return mcv_fail(f->error, MCV_FAILED, "%s: no such file in %s/kernels or %s/include", name,
                        f->root, f->root);
    fprintf(f->out, "#line 1 \"%s\"\n", name);

    mcv_result result = MCV_OK;
    char *line = NULL;
    size_t capacity = 0;
    int guards = -1;
    for (unsigned number = 1; result == MCV_OK && getline(&line, &capacity, in) >= 0; ++number) {
        char included[128];
        const char *hash = line + strspn(line, " \t");
        if (!follow_condition(f, hash, outside, &guards))
            result = mcv_fail(f->error, MCV_FAILED, "%s: conditions are nested too deeply", name);
        else if (sscanf(hash, "#include \"%127[^\"]\"", included) == 1) {
            result = flatten_file(f, included, depth + 1);
            fprintf(f->out, "#line %u \"%s\"\n", number + 1, name);
        } else if (begins(hash, "#include <")) {
            fputc('\n', f->out);
        } else {
            fputs(line, f->out);
        }
    }
    free(line);
    fclose(in);
    return result;
}

mcv_result mcv_flatten(const char *root, const char *program, char **text, mcv_error *error) {
    size_t size = 0;
    char name[128];
    *text = NULL;
    flattening f = {.root = root, .error = error, .out = open_memstream(text, &size)};
    if (!f.out)
        return mcv_fail(error, MCV_FAILED, "%s: no memory to read the OpenCL program", program);
    snprintf(name, sizeof name, "%s.cl", program);
    mcv_result result = flatten_file(&f, name, 0);
    if (result == MCV_OK) result = flatten_file(&f, "probe.cl", 0);
    if ((fclose(f.out) != 0 || !*text) && result == MCV_OK)
        result = mcv_fail(error, MCV_FAILED, "%s: no memory to read the OpenCL program", program);
    if (result != MCV_OK) {
        free(*text);
        *text = NULL;
    }
    return result;
}
