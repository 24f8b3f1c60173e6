/* SPDX-License-Identifier: Apache-2.0 */
#include "experiment/table.h"

#include "core/basics.h"
#include "core/file_lock.h"
#include "core/output_file.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

enum { MAX_ROW = 8192 }; /* bytes in the file */

mcv_result mcv_table_plan(mcv_table *table, const char *path, const mcv_plan *plan,
                          const mcv_measurement *measurement, mcv_error *error) {
    *table = (mcv_table){.plan = plan, .measurement = measurement, .descriptor = -1};
    table->columns = plan->count + 2 * measurement->count + MCV_ROW_FIXED;
    table->rows = malloc(plan->set_count * table->columns * sizeof *table->rows);
    table->messages = calloc(plan->set_count, sizeof *table->messages);
    if (!table->rows || !table->messages)
        return mcv_fail(error, MCV_FAILED, "no memory for a table of %zu rows", plan->set_count);
    if (!path) return MCV_OK;
    const char *dot = strrchr(path, '.');
    if (strlen(path) + 16 >= PATH_MAX)
        return mcv_fail(error, MCV_USAGE, "the path of the table is too long");
    if (!dot || strcmp(dot, ".csv") != 0)
        return mcv_fail(error, MCV_USAGE, "--output %s: must end in .csv", path);
    const int stem = (int)(dot - path);
    snprintf(table->path, sizeof table->path, "%.*s.csv", stem, path);
    snprintf(table->sidecar, sizeof table->sidecar, "%.*s.json", stem, path);
    snprintf(table->page, sizeof table->page, "%.*s.html", stem, path);
    return MCV_OK;
}

size_t mcv_row_metric(const mcv_table *table, size_t metric) {
    return table->plan->count + 2 * metric;
}

size_t mcv_row_fixed(const mcv_table *table, int which) {
    return mcv_row_metric(table, table->measurement->count) + (size_t)which;
}

static void put_quoted(FILE *out, const char *text) {
    fputc('"', out);
    for (; *text; ++text) {
        if (*text == '"') fputc('"', out);
        fputc(*text == '\n' || *text == '\r' ? ' ' : *text, out);
    }
    fputc('"', out);
}

static void put_name(FILE *out, const char *name, const char *ending) {
    char whole[256];
    snprintf(whole, sizeof whole, "%s%s", name, ending);
    if (whole[strcspn(whole, ",\" \n")])
        put_quoted(out, whole);
    else
        fputs(whole, out);
    fputc(',', out);
}

static void put_header(const mcv_table *table, FILE *out) {
    const mcv_measurement *m = table->measurement;
    fputs("set,", out);
    for (size_t i = 0; i < table->plan->count; ++i)
        put_name(out, table->plan->parameters[i].name, "");
    for (size_t i = 0; i < m->count; ++i) {
        put_name(out, m->metrics[i].name, "");
        put_name(out, m->metrics[i].name, "_u");
    }
    fputs("samples,render_error,seconds,message\n", out);
}

/* The set is the first column in the file and the last in memory. */
static void put_row(const mcv_table *table, FILE *out, const double *row, const char *message) {
    fprintf(out, "%.0f", row[mcv_row_fixed(table, MCV_ROW_SET)]);
    for (size_t i = 0; i + 1 < table->columns; ++i) {
        mcv_value_text value;
        if (isnan(row[i]))
            fputc(',', out);
        else if (i < table->plan->count)
            fprintf(out, ",%s", mcv_parameter_text(table->plan->parameters + i, row[i], 10, value));
        else
            fprintf(out, ",%.10g", row[i]);
    }
    fputc(',', out);
    if (message) put_quoted(out, message);
    fputc('\n', out);
}

/* In one write: other programs, and a crash, leave whole rows only. */
static mcv_result append(const mcv_table *table, const char *text, size_t size, mcv_error *error) {
    const int file = table->descriptor;
    const ssize_t written = write(file, text, size);
    if (written == (ssize_t)size) return MCV_OK;
    if (written > 0 && ftruncate(file, lseek(file, 0, SEEK_END) - written) != 0)
        return mcv_fail(error, MCV_FAILED, "%s: a row was written in part: %s", table->path,
                        strerror(errno));
    return mcv_fail(error, MCV_FAILED, "%s: %s", table->path,
                    written < 0 ? strerror(errno) : "the disk is full");
}

/* row NULL: the header. */
static mcv_result append_line(const mcv_table *table, const double *row, const char *message,
                              mcv_error *error) {
    char text[MAX_ROW];
    FILE *stream = fmemopen(text, sizeof text, "w");
    if (!stream) return mcv_fail(error, MCV_FAILED, "%s: no memory for a row", table->path);
    if (row)
        put_row(table, stream, row, message);
    else
        put_header(table, stream);
    const long size = ftell(stream);
    const bool fits = !ferror(stream) && size < MAX_ROW - 1;
    fclose(stream);
    return fits ? append(table, text, (size_t)size, error)
                : mcv_fail(error, MCV_FAILED, "%s: a row is too long", table->path);
}

static void keep(mcv_table *table, const double *row, const char *message) {
    memcpy(table->rows + table->row_count * table->columns, row, table->columns * sizeof *row);
    table->messages[table->row_count++] = message ? strdup(message) : NULL;
}

mcv_result mcv_table_append(mcv_table *table, const double *row, const char *message,
                            mcv_error *error) {
    if (table->path[0]) MCV_TRY(append_line(table, row, message, error));
    keep(table, row, message);
    return MCV_OK;
}

mcv_result mcv_table_lock(mcv_table *table, bool *exists, mcv_error *error) {
    struct stat held;
    MCV_TRY(mcv_file_lock(table->path, table->path, "-o", &table->descriptor, error));
    table->locked = true;
    *exists = fstat(table->descriptor, &held) == 0 && held.st_size > 0;
    return MCV_OK;
}

mcv_result mcv_table_begin(mcv_table *table, mcv_error *error) {
    if (ftruncate(table->descriptor, 0) != 0)
        return mcv_fail(error, MCV_FAILED, "%s: %s", table->path, strerror(errno));
    return append_line(table, NULL, NULL, error);
}

/* Removes the quotes that put_quoted has added. */
static const char *unquote(char *text) {
    char *to = text;
    for (const char *from = text + 1; *from && !(from[0] == '"' && from[1] == '\0'); ++from) {
        *to++ = *from;
        if (from[0] == '"' && from[1] == '"') ++from;
    }
    *to = '\0';
    return text;
}

/* The set of a row, whose text goes on at *end: digits alone, and one of the plan. */
static mcv_result read_set(const mcv_table *table, char *line, size_t number, size_t *set,
                           char **end, mcv_error *error) {
    const int shown = (int)strcspn(line, ",");
    *end = line + strspn(line, "0123456789");
    *set = *end > line ? strtoull(line, NULL, 10) : SIZE_MAX;
    if (*set < table->plan->set_count && *end == line + shown) return MCV_OK;
    return mcv_fail(error, MCV_BAD_INPUT,
                    "%s: line %zu: \"%.*s\" must be the number of a set, from 0 to %zu: mend the "
                    "line, or begin the table again by --force",
                    table->path, number, mcv_whole_characters(line, shown < 40 ? shown : 40), line,
                    table->plan->set_count - 1);
}

/* *kept: the row is whole, the first of its set, and not to be tried again. */
static mcv_result read_line(mcv_table *table, char *line, size_t number, bool *done, bool *kept,
                            mcv_error *error) {
    double row[MCV_ROW_MOST];
    size_t set;
    char *at;
    *kept = false;
    MCV_TRY(read_set(table, line, number, &set, &at, error));
    row[mcv_row_fixed(table, MCV_ROW_SET)] = (double)set;
    for (size_t i = 0; i + 1 < table->columns && *at == ','; ++i) {
        char *end = ++at;
        const bool named = i < table->plan->count && table->plan->parameters[i].levels.named;
        row[i] = named ? mcv_parameter_number(table->plan->parameters + i, at) : strtod(at, &end);
        if (named) end += strcspn(at, ",");
        if (end == at) row[i] = NAN;
        at = end;
    }
    if (*at != ',') return MCV_OK;
    const char *message = at[1] ? unquote(at + 1) : NULL;
    if (done[set] || (message && strncmp(message, MCV_ROW_RETRY, strlen(MCV_ROW_RETRY)) == 0))
        return MCV_OK;
    *kept = done[set] = true;
    keep(table, row, message);
    return MCV_OK;
}

/* Puts the kept lines in the place of the file, which is locked anew. */
static mcv_result replace(mcv_table *table, const char *text, size_t size, mcv_error *error) {
    bool exists;
    MCV_TRY(mcv_output_whole(table->path, text, size, error));
    close(table->descriptor);
    return mcv_table_lock(table, &exists, error);
}

mcv_result mcv_table_resume(mcv_table *table, bool *done, mcv_error *error) {
    char *line = NULL, *kept = NULL;
    size_t room = 0, size = 0;
    size_t number = 0;
    off_t whole = 0;
    bool all = true;
    mcv_result result = MCV_OK;
    FILE *file = fopen(table->path, "re"), *out = file ? open_memstream(&kept, &size) : NULL;
    if (!out) {
        if (file) fclose(file);
        return mcv_fail(error, MCV_BAD_INPUT, "%s: %s", table->path, strerror(errno));
    }
    for (ssize_t length;
         result == MCV_OK && (length = getline(&line, &room, file)) > 0 && line[length - 1] == '\n';
         whole += length) {
        const long before = ftell(out);
        bool kept_too = true; /* the header is */
        fwrite(line, 1, (size_t)length, out);
        line[length - 1] = '\0';
        if (++number > 1) result = read_line(table, line, number, done, &kept_too, error);
        if (kept_too) continue;
        all = false;
        fseek(out, before, SEEK_SET);
    }
    /* Rows that could not be read must not be taken for missing ones. */
    const bool read = feof(file) != 0;
    free(line);
    fclose(file);
    const long end = ftell(out);
    const bool closed = mcv_text_close(out, &kept);
    if (result == MCV_OK && (!closed || !read))
        result = mcv_fail(error, MCV_FAILED, "%s: no memory for its rows", table->path);
    else if (result == MCV_OK && !all)
        result = replace(table, kept, (size_t)end, error);
    else if (result == MCV_OK && ftruncate(table->descriptor, whole) != 0)
        result = mcv_fail(error, MCV_FAILED, "%s: %s", table->path, strerror(errno));
    free(kept);
    return result != MCV_OK || whole > 0 ? result : append_line(table, NULL, NULL, error);
}

size_t mcv_table_failed(const mcv_table *table) {
    size_t failed = 0;
    for (size_t row = 0; row < table->row_count; ++row) failed += table->messages[row] != NULL;
    return failed;
}

void mcv_table_extremes(const mcv_table *table, size_t metric, const double *extremes[2]) {
    const size_t at = mcv_row_metric(table, metric);
    extremes[0] = extremes[1] = NULL;
    for (size_t i = 0; i < table->row_count; ++i) {
        const double *row = table->rows + i * table->columns;
        if (isnan(row[at])) continue;
        if (!extremes[0] || row[at] < extremes[0][at]) extremes[0] = row;
        if (!extremes[1] || row[at] > extremes[1][at]) extremes[1] = row;
    }
}

void mcv_table_free(mcv_table *table) {
    struct stat status;
    if (table->locked && fstat(table->descriptor, &status) == 0 && status.st_size == 0)
        unlink(table->path);
    if (table->descriptor >= 0) close(table->descriptor);
    for (size_t i = 0; i < table->row_count; ++i) free(table->messages[i]);
    free(table->messages);
    free(table->rows);
    *table = (mcv_table){.descriptor = -1};
}
