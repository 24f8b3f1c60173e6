/* SPDX-License-Identifier: Apache-2.0 */
#include "pod/columns.h"

#include "core/basics.h"
#include "core/output_file.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* The text of a table while it is read; fields end in place. */
typedef struct reading {
    const char *path;
    char *at;    /* the next field; NULL: the file is at its end */
    size_t line; /* of it */
    bool ended;  /* the last field was the last one of its row */
} reading;

/* Takes a field without its quotes; "" inside of them is one ". */
static char *take_field(reading *r) {
    char *from = r->at, *to = r->at, *begin = r->at;
    const bool quoted = *from == '"';
    from += quoted;
    while (*from && (quoted || (*from != ',' && *from != '\n'))) {
        if (quoted && *from == '"' && *++from != '"') break;
        r->line += *from == '\n';
        *to++ = *from++;
    }
    while (*from && *from != ',' && *from != '\n') ++from; /* after the quotes */
    if (!quoted && to > begin && to[-1] == '\r') --to;
    const char end = *from;
    *to = '\0';
    r->ended = end != ',';
    r->line += end == '\n';
    r->at = end == '\0' || (end == '\n' && from[1] == '\0') ? NULL : from + 1;
    return begin;
}

enum { NO_COLUMN = -1 };

/* The place of each name in the header, and how many columns there are. */
typedef struct places {
    int size, value, defect, count;
} places;

static mcv_result find_columns(reading *r, const mcv_column_names *names, places *p,
                               mcv_error *error) {
    char listed[256] = "";
    *p = (places){NO_COLUMN, NO_COLUMN, NO_COLUMN, 0};
    do {
        const char *name = take_field(r);
        if (strcmp(name, names->size) == 0) p->size = p->count;
        if (strcmp(name, names->value) == 0) p->value = p->count;
        if (names->defect && strcmp(name, names->defect) == 0) p->defect = p->count;
        const size_t length = strlen(listed);
        snprintf(listed + length, sizeof listed - length, "%s%s", length ? ", " : "", name);
        ++p->count;
    } while (!r->ended && r->at);
    const char *missing = p->size < 0                      ? names->size
                          : p->value < 0                   ? names->value
                          : names->defect && p->defect < 0 ? names->defect
                                                           : NULL;
    return missing ? mcv_fail(error, MCV_BAD_INPUT, "%s: there is no column %s: it has %.*s",
                              r->path, missing, mcv_whole_characters(listed, 200), listed)
                   : MCV_OK;
}

/* Words for hits are as good as numbers. */
static mcv_result read_number(const reading *r, size_t line, const char *name, const char *field,
                              double *number, mcv_error *error) {
    char *end;
    field += strspn(field, " \t");
    *number = NAN;
    if (*field == '\0') return MCV_OK;
    if (strcmp(field, "true") == 0 || strcmp(field, "false") == 0) {
        *number = field[0] == 't';
        return MCV_OK;
    }
    *number = strtod(field, &end);
    if (end != field && end[strspn(end, " \t")] == '\0') return MCV_OK;
    return mcv_fail(error, MCV_BAD_INPUT, "%s:%zu: %s is \"%.*s\": must be a number", r->path, line,
                    name, mcv_whole_characters(field, 40), field);
}

static mcv_result read_row(reading *r, const mcv_column_names *names, const places *p,
                           mcv_columns *c, mcv_error *error) {
    const size_t line = r->line, row = c->count;
    int column = 0;
    c->sizes[row] = c->values[row] = NAN;
    for (;; ++column) {
        const char *field = take_field(r);
        if (column == 0 && r->ended && *field == '\0') return MCV_OK; /* an empty line */
        if (column == p->size)
            MCV_TRY(read_number(r, line, names->size, field, c->sizes + row, error));
        if (column == p->value)
            MCV_TRY(read_number(r, line, names->value, field, c->values + row, error));
        if (column == p->defect)
            c->defects[row] = mcv_hash_bytes(MCV_HASH_BEGIN, field, strlen(field));
        if (r->ended) break;
        if (!r->at)
            return mcv_fail(error, MCV_BAD_INPUT, "%s:%zu: ends within a row", r->path, line);
    }
    if (column + 1 != p->count)
        return mcv_fail(error, MCV_BAD_INPUT, "%s:%zu: has %d fields: must have %d, as the header",
                        r->path, line, column + 1, p->count);
    ++c->count;
    return MCV_OK;
}

static mcv_result read_text(reading r, size_t rows, const mcv_column_names *names, mcv_columns *c,
                            mcv_error *error) {
    const char *path = r.path;
    places p;
    if (!*r.at) return mcv_fail(error, MCV_BAD_INPUT, "%s: is empty: must be a table", path);
    c->sizes = malloc(rows * sizeof *c->sizes);
    c->values = malloc(rows * sizeof *c->values);
    c->defects = names->defect ? malloc(rows * sizeof *c->defects) : NULL;
    if (!c->sizes || !c->values || (names->defect && !c->defects))
        return mcv_fail(error, MCV_FAILED, "%s: no memory for %zu rows", path, rows);
    MCV_TRY(find_columns(&r, names, &p, error));
    while (r.at) MCV_TRY(read_row(&r, names, &p, c, error));
    return MCV_OK;
}

mcv_result mcv_columns_read(const char *path, const mcv_column_names *names, mcv_columns *columns,
                            mcv_error *error) {
    uint8_t *bytes;
    size_t size, rows = 1;
    *columns = (mcv_columns){.count = 0};
    MCV_TRY(mcv_file_load(path, &bytes, &size, error));
    char *text = malloc(size + 1);
    if (text) {
        memcpy(text, bytes, size);
        text[size] = '\0';
    }
    free(bytes);
    if (!text) return mcv_fail(error, MCV_FAILED, "%s: no memory for it", path);
    for (const char *c = text; *c; ++c) rows += *c == '\n';
    const size_t mark = strncmp(text, "\xEF\xBB\xBF", 3) == 0 ? 3 : 0; /* as Excel begins files */
    const mcv_result result = read_text((reading){.path = path, .at = text + mark, .line = 1}, rows,
                                        names, columns, error);
    free(text);
    return result;
}

void mcv_columns_free(mcv_columns *columns) {
    free(columns->sizes);
    free(columns->values);
    free(columns->defects);
    *columns = (mcv_columns){.count = 0};
}
