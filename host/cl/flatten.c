/* SPDX-License-Identifier: Apache-2.0 */
#include "cl/flatten.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MAX_FILES = 128, MAX_DEPTH = 16, MAX_PATH = 1024 };

typedef struct flattening {
    const char *root;
    FILE *out;
    char seen[MAX_FILES][128];
    size_t seen_count;
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

/* `optional`: the file is included under some #if, which may be false, so a later #include of it
 * must be expanded again. */
static mcv_result flatten_file(flattening *f, const char *name, int depth, bool optional) {
    for (size_t i = 0; i < f->seen_count; ++i) {
        if (strcmp(f->seen[i], name) == 0) return MCV_OK;
    }
    if (depth == MAX_DEPTH || f->seen_count == MAX_FILES || strlen(name) >= sizeof f->seen[0]) {
        return mcv_fail(f->error, MCV_FAILED, "%s: includes are nested too deeply or too many",
                        name);
    }
    if (!optional) memcpy(f->seen[f->seen_count++], name, strlen(name) + 1);
    FILE *in = open_source(f, name);
    if (!in)
        return mcv_fail(f->error, MCV_FAILED, "%s: no such file in %s/kernels or %s/include", name,
                        f->root, f->root);
    fprintf(f->out, "#line 1 \"%s\"\n", name);

    mcv_result result = MCV_OK;
    char *line = NULL;
    size_t capacity = 0;
    int conditions = 0;
    int guards = -1; /* 1 if the file's first condition is its include guard, -1: not yet known */
    for (unsigned number = 1; result == MCV_OK && getline(&line, &capacity, in) >= 0; ++number) {
        char included[128];
        const char *hash = line + strspn(line, " \t");
        if (begins(hash, "#if")) {
            if (guards < 0) guards = begins(hash, "#ifndef");
            ++conditions;
        }
        if (begins(hash, "#endif")) --conditions;
        if (sscanf(hash, "#include \"%127[^\"]\"", included) == 1) {
            result = flatten_file(f, included, depth + 1, optional || conditions > (guards > 0));
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
    mcv_result result = flatten_file(&f, name, 0, false);
    if (result == MCV_OK) result = flatten_file(&f, "probe.cl", 0, false);
    if ((fclose(f.out) != 0 || !*text) && result == MCV_OK)
        result = mcv_fail(error, MCV_FAILED, "%s: no memory to read the OpenCL program", program);
    if (result != MCV_OK) {
        free(*text);
        *text = NULL;
    }
    return result;
}
