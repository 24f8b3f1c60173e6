/* SPDX-License-Identifier: Apache-2.0 */
#include "verbs/merge_tables.h"

#include "core/basics.h"
#include "core/json.h"
#include "core/output_file.h"
#include "experiment/sidecar.h"
#include "experiment/table.h"
#include "verbs/sweep.h"

#include <errno.h>
#include <libgen.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

typedef struct line {
    long set;
    const char *text; /* without its end */
    size_t length, table;
} line;

typedef struct table {
    const char *path;
    char *text;
    json_t *experiment; /* F.json */
} table;

typedef struct joining {
    table *tables;
    size_t table_count;
    line *lines;
    size_t line_count, room;
    size_t dropped; /* rows of sets that failed for want of a device */
    mcv_error *error;
} joining;

/* F.json of F.csv. */
static mcv_result sidecar_of(const char *path, char sidecar[PATH_MAX], mcv_error *error) {
    if (!mcv_ends_in(path, ".csv"))
        return mcv_fail(error, MCV_USAGE, "%s: is no table: its name must end in .csv", path);
    const int length = (int)strlen(path) - 4;
    return snprintf(sidecar, PATH_MAX, "%.*s.json", length, path) < PATH_MAX
               ? MCV_OK
               : mcv_fail(error, MCV_USAGE, "%s: the path is too long", path);
}

static mcv_result read_table(joining *j, const char *path, table *t) {
    char sidecar[PATH_MAX];
    uint8_t *bytes;
    size_t size;
    mcv_error why;
    MCV_TRY(sidecar_of(path, sidecar, j->error));
    MCV_TRY(mcv_file_load(path, &bytes, &size, j->error));
    t->path = path;
    t->text = (char *)bytes; /* the load leaves room for an end */
    t->text[size] = '\0';
    if (strlen(t->text) != size)
        return mcv_fail(j->error, MCV_BAD_INPUT, "%s: has a byte 0: it is no table of a sweep",
                        path);
    if (mcv_json_file_read(sidecar, &t->experiment, &why) != MCV_OK)
        return mcv_fail(j->error, MCV_BAD_INPUT, "%s; without it %s cannot be merged", why.text,
                        path);
    if (!json_is_object(t->experiment))
        return mcv_fail(j->error, MCV_BAD_INPUT, "%s: must be an object of JSON", sidecar);
    if (!strchr(t->text, '\n'))
        return mcv_fail(j->error, MCV_BAD_INPUT, "%s: has no header: it is no table of a sweep",
                        path);
    return MCV_OK;
}

/* What the parts of one experiment may differ in. */
static bool is_free(const char *key) {
    static const char *const keys[] = {"rig", "title", "note", "best", "range"};
    for (size_t i = 0; i < sizeof keys / sizeof keys[0]; ++i)
        if (strcmp(key, keys[i]) == 0) return true;
    return false;
}

static mcv_result check_same(const table *a, const table *b, mcv_error *error) {
    const char *key;
    json_t *value;
    for (int turn = 0; turn < 2; ++turn) {
        const json_t *from = turn ? b->experiment : a->experiment,
                     *to = turn ? a->experiment : b->experiment;
        json_object_foreach((json_t *)from, key, value) {
            if (!is_free(key) && !json_equal(value, json_object_get(to, key)))
                return mcv_fail(
                    error, MCV_BAD_INPUT, "%s and %s: are of different experiments: %s%s differs",
                    a->path, b->path, strcmp(key, "fingerprint") == 0 ? "the scene's " : "--", key);
        }
    }
    const size_t header = strcspn(a->text, "\n");
    if (strncmp(a->text, b->text, header + 1) != 0)
        return mcv_fail(error, MCV_BAD_INPUT, "%s and %s: have different columns", a->path,
                        b->path);
    return MCV_OK;
}

static bool is_to_retry(const char *text, size_t length) {
    const char *found = memmem(text, length, ",\"" MCV_ROW_RETRY, strlen(",\"" MCV_ROW_RETRY));
    return found != NULL;
}

static mcv_result add_line(joining *j, const char *text, size_t length, size_t number) {
    char *end;
    errno = 0;
    const long set = strtol(text, &end, 10);
    if (*text < '0' || *text > '9' || *end != ',' || errno == ERANGE)
        return mcv_fail(j->error, MCV_BAD_INPUT, "%s: has a line that is no row: %.40s",
                        j->tables[number].path, text);
    if (is_to_retry(text, length)) {
        ++j->dropped;
        return MCV_OK;
    }
    if (j->line_count == j->room) {
        const size_t room = 2 * j->room + 64;
        line *lines = realloc(j->lines, room * sizeof *lines);
        if (!lines) return mcv_fail(j->error, MCV_FAILED, "no memory for the rows");
        j->lines = lines;
        j->room = room;
    }
    j->lines[j->line_count++] = (line){set, text, length, number};
    return MCV_OK;
}

/* The whole rows: what follows the last end of a line was cut. */
static mcv_result add_lines(joining *j, size_t number) {
    const char *at = strchr(j->tables[number].text, '\n') + 1;
    for (const char *end; (end = strchr(at, '\n')); at = end + 1)
        MCV_TRY(add_line(j, at, (size_t)(end - at), number));
    return MCV_OK;
}

static int by_set(const void *a, const void *b) {
    const line *x = a, *y = b;
    return (x->set > y->set) - (x->set < y->set);
}

static mcv_result sort_lines(joining *j) {
    if (j->line_count == 0) return MCV_OK;
    qsort(j->lines, j->line_count, sizeof *j->lines, by_set);
    for (size_t i = 1; i < j->line_count; ++i)
        if (j->lines[i].set == j->lines[i - 1].set)
            return mcv_fail(j->error, MCV_BAD_INPUT, "%s and %s: both have set %ld",
                            j->tables[j->lines[i - 1].table].path,
                            j->tables[j->lines[i].table].path, j->lines[i].set);
    return MCV_OK;
}

/* Which parts of N are not there. */
static void tell_missing(const joining *j, mcv_report *report) {
    size_t share[2], parts = 0;
    char sentence[512] = "", *end = sentence, *last = sentence + sizeof sentence - 32;
    for (size_t i = 0; i < j->table_count; ++i) {
        const char *range = json_string_value(json_object_get(j->tables[i].experiment, "range"));
        if (!range || !mcv_read_share(range, share)) return;
        if (parts != 0 && parts != share[1]) return;
        parts = share[1];
    }
    for (size_t k = 0; k < parts && end < last; ++k) {
        bool found = false;
        for (size_t i = 0; i < j->table_count; ++i) {
            const json_t *range = json_object_get(j->tables[i].experiment, "range");
            found = found || (mcv_read_share(json_string_value(range), share) && share[0] == k);
        }
        if (!found) end += snprintf(end, 32, "%s%zu/%zu", end > sentence ? ", " : "", k, parts);
    }
    char text[640];
    if (end == sentence) return;
    snprintf(text, sizeof text, "parts are missing: %s%s", sentence, end >= last ? " …" : "");
    mcv_report_tell(report, "warning", text);
}

/* The experiment of the whole. Its rig is found from the output's folder. */
static mcv_result write_experiment(const joining *j, const char *sidecar, mcv_error *error) {
    char folder[PATH_MAX], rig[PATH_MAX], real[PATH_MAX];
    const table *first = j->tables;
    const char *name = json_string_value(json_object_get(first->experiment, "rig"));
    json_t *document = json_deep_copy(first->experiment);
    json_object_del(document, "range");
    snprintf(folder, sizeof folder, "%s", first->path);
    if (name && name[0] != '/' &&
        snprintf(rig, sizeof rig, "%s/%s", dirname(folder), name) < PATH_MAX && realpath(rig, real))
        json_object_set_new(document, "rig", json_string(real));
    char *text = json_dumps(document, JSON_INDENT(2) | JSON_REAL_PRECISION(17));
    json_decref(document);
    if (!text) return mcv_fail(error, MCV_FAILED, "%s: no memory for its text", sidecar);
    const mcv_result result = mcv_output_whole(sidecar, text, strlen(text), error);
    free(text);
    return result;
}

static mcv_result write_table(const joining *j, const char *output, mcv_error *error) {
    char *text = NULL;
    size_t size = 0;
    FILE *out = open_memstream(&text, &size);
    if (!out) return mcv_fail(error, MCV_FAILED, "%s: no memory for its rows", output);
    const char *header = j->tables[0].text;
    fwrite(header, 1, strcspn(header, "\n") + 1, out);
    for (size_t i = 0; i < j->line_count; ++i) {
        fwrite(j->lines[i].text, 1, j->lines[i].length, out);
        fputc('\n', out);
    }
    const mcv_result result = mcv_text_close(out, &text)
                                  ? mcv_output_whole(output, text, size, error)
                                  : mcv_fail(error, MCV_FAILED, "%s: no memory", output);
    free(text);
    return result;
}

static mcv_result join(joining *j, mcv_texts paths, const char *output, const char *sidecar,
                       mcv_report *report, mcv_error *error) {
    for (size_t i = 0; i < paths.count; ++i) {
        if (mcv_same_file(paths.items[i], output))
            return mcv_fail(error, MCV_USAGE, "%s is one of the tables: give another name", output);
        MCV_TRY(read_table(j, paths.items[i], j->tables + i));
        if (i > 0) MCV_TRY(check_same(j->tables, j->tables + i, error));
        MCV_TRY(add_lines(j, i));
    }
    MCV_TRY(sort_lines(j));
    tell_missing(j, report);
    MCV_TRY(write_experiment(j, sidecar, error));
    MCV_TRY(write_table(j, output, error));
    mcv_report_text(report, "table", output);
    mcv_report_value(report, "tables", json_integer((json_int_t)j->table_count));
    mcv_report_value(report, "rows", json_integer((json_int_t)j->line_count));
    if (j->dropped)
        mcv_report_tell(report, "note",
                        "rows of sets that failed for want of a device are left out: sweep "
                        "--resume renders them");
    return MCV_OK;
}

mcv_result mcv_tables_join(mcv_texts paths, const char *output, bool force, mcv_report *report,
                           mcv_error *error) {
    char sidecar[PATH_MAX];
    joining j = {.table_count = paths.count, .error = error};
    MCV_TRY(sidecar_of(output, sidecar, error));
    if (!force && access(output, F_OK) == 0)
        return mcv_fail(error, MCV_BAD_INPUT,
                        "%s exists already: replace it by --force, or give another name by -o",
                        output);
    if (!force) MCV_TRY(mcv_sidecar_is_free(sidecar, error));
    MCV_TRY(mcv_output_check(output, error));
    MCV_TRY(mcv_output_check(sidecar, error));
    j.tables = calloc(paths.count, sizeof *j.tables);
    const mcv_result result = j.tables ? join(&j, paths, output, sidecar, report, error)
                                       : mcv_fail(error, MCV_FAILED, "no memory for the tables");
    for (size_t i = 0; j.tables && i < paths.count; ++i) {
        free(j.tables[i].text);
        json_decref(j.tables[i].experiment);
    }
    free(j.tables);
    free(j.lines);
    return result;
}
