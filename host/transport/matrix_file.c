/* SPDX-License-Identifier: Apache-2.0 */
#include "transport/matrix_file.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/basics.h"
#include "core/json.h"
#include "core/output_file.h"
#include "io/npz.h"

#define FORMAT "mcvisi transport"

enum { HEADER_VERSION = 1, MOST_SIDE = 65536 };

/* --- header --- */

static json_t *numbers(const double *values, size_t count) {
    json_t *list = json_array();
    for (size_t i = 0; i < count; ++i) json_array_append_new(list, json_real(values[i]));
    return list;
}

/* Where its elements lie, as far as it has a rectangle of them. */
static void put_place(const mcv_element_group *g, json_t *element) {
    if (g->binning[0] > 1 || g->binning[1] > 1)
        json_object_set_new(
            element, "binning",
            json_pack("[I, I]", (json_int_t)g->binning[0], (json_int_t)g->binning[1]));
    if (g->size[0] > 0) json_object_set_new(element, "size", numbers(g->size, 2));
    if (g->slope_range[0] > 0)
        json_object_set_new(element, "slopeRange", numbers(g->slope_range, 2));
    if (g->mirror) json_object_set_new(element, "mirror", json_true());
}

json_t *mcv_matrix_header(const mcv_matrix *m) {
    json_t *elements = json_array();
    for (uint32_t i = 0; i < m->group_count; ++i) {
        const mcv_element_group *g = m->groups + i;
        json_t *element = json_pack(
            "{s:s, s:s, s:I, s:I, s:I, s:o, s:o}", "emitter", g->emitter, "type", g->type, "first",
            (json_int_t)g->first, "width", (json_int_t)g->width, "height", (json_int_t)g->height,
            "radiance", numbers(g->radiance, 3), "to_world", numbers(g->to_world, 12));
        put_place(g, element);
        if (g->angular[0] > 0) {
            json_object_set_new(
                element, "angularResolution",
                json_pack("[I, I]", (json_int_t)g->angular[0], (json_int_t)g->angular[1]));
            json_object_set_new(element, "angularRange", json_real(g->angular_range));
        }
        json_array_append_new(elements, element);
    }
    return json_pack("{s:s, s:i, s:I, s:I, s:I, s:I, s:I, s:f, s:b, s:o, s:O}", "format", FORMAT,
                     "version", HEADER_VERSION, "width", (json_int_t)m->width, "height",
                     (json_int_t)m->height, "channels", (json_int_t)m->channels, "replicates",
                     (json_int_t)m->replicates, "samples", (json_int_t)m->samples, "kept", m->kept,
                     "residual", m->column_count > m->element_count, "elements", elements,
                     "attributes", m->attributes ? m->attributes : json_null());
}

/* --- writing --- */

static mcv_result write_npz(const mcv_matrix *m, const char *path, const char *header,
                            mcv_error *error) {
    const uint64_t count = m->row_begins[m->row_count];
    const int64_t shape[2] = {(int64_t)m->row_count, m->column_count};
    const size_t pattern = (size_t)m->element_count * m->channels;
    const mcv_npz_member members[] = {
        {.name = "header.json", .data = header, .bytes = strlen(header)},
        {.name = "format.npy", .dtype = "|S3", .scalar = true, .data = "csr", .bytes = 3},
        {.name = "shape.npy", .dtype = "<i8", .shape = {2}, .data = shape, .bytes = sizeof shape},
        {.name = "indptr.npy",
         .dtype = "<i8",
         .shape = {m->row_count + 1},
         .data = m->row_begins,
         .bytes = (m->row_count + 1) * sizeof *m->row_begins},
        {.name = "indices.npy",
         .dtype = "<i4",
         .shape = {count},
         .data = m->columns,
         .bytes = count * sizeof *m->columns},
        {.name = "data.npy",
         .dtype = "<f8",
         .shape = {count},
         .data = m->values,
         .bytes = count * sizeof *m->values},
        {.name = "replicates.npy",
         .dtype = "<f4",
         .shape = {count, m->replicates},
         .data = m->replicates_of,
         .bytes = count * m->replicates * sizeof *m->replicates_of},
        {.name = "pattern.npy",
         .dtype = "<f4",
         .shape = {m->element_count, m->channels},
         .data = m->pattern,
         .bytes = pattern * sizeof *m->pattern},
    };
    return mcv_npz_write(path, members, sizeof members / sizeof members[0], error);
}

static mcv_result write_lines(const mcv_matrix *m, mcv_output *out, mcv_error *error) {
    char line[128];
    const uint64_t count = m->row_begins[m->row_count];
    size_t length = (size_t)snprintf(
        line, sizeof line, "%%%%MatrixMarket matrix coordinate real general\n%zu %u %" PRIu64 "\n",
        m->row_count, m->column_count, count);
    MCV_TRY(mcv_output_write(out, line, length, error));
    for (size_t row = 0; row < m->row_count; ++row)
        for (uint64_t i = m->row_begins[row]; i < m->row_begins[row + 1]; ++i) {
            length = (size_t)snprintf(line, sizeof line, "%zu %u %.17g\n", row + 1,
                                      m->columns[i] + 1, m->values[i]);
            MCV_TRY(mcv_output_write(out, line, length, error));
        }
    return MCV_OK;
}

static mcv_result write_market(const mcv_matrix *m, const char *path, mcv_error *error) {
    mcv_output out;
    MCV_TRY(mcv_output_open(&out, path, error));
    const mcv_result result = write_lines(m, &out, error);
    if (result == MCV_OK) return mcv_output_commit(&out, error);
    mcv_output_discard(&out);
    return result;
}

mcv_result mcv_matrix_write(const mcv_matrix *matrix, const char *path, mcv_error *error) {
    if (mcv_ends_in(path, ".mtx")) return write_market(matrix, path, error);
    if (!mcv_ends_in(path, ".npz"))
        return mcv_fail(error, MCV_USAGE, "%s: a matrix is written into .npz or .mtx", path);
    json_t *header = mcv_matrix_header(matrix);
    char *text = header ? json_dumps(header, JSON_INDENT(1)) : NULL;
    json_decref(header);
    if (!text) return mcv_fail(error, MCV_FAILED, "%s: no memory for its header", path);
    const mcv_result result = write_npz(matrix, path, text, error);
    free(text);
    return result;
}

/* --- reading --- */

static mcv_result read_uint(const json_t *from, const char *key, uint64_t min, uint64_t max,
                            uint32_t *out, const mcv_json_path *place, mcv_error *error) {
    uint64_t value = max + 1;
    MCV_TRY(mcv_json_uint(from, key, min, max, &value, place, error));
    if (value > max) return mcv_fail_at(place, error, "has no %s", key);
    *out = (uint32_t)value;
    return MCV_OK;
}

/* The directions of a light field emitter, which divide the pixels of its image. */
static mcv_result read_directions(const json_t *from, mcv_element_group *g,
                                  const mcv_json_path *place, mcv_error *error) {
    double angular[2] = {0};
    MCV_TRY(mcv_json_numbers(from, "angularResolution", 2, 1, MOST_SIDE, angular, place, error));
    MCV_TRY(mcv_json_number(from, "angularRange", 0, 1, &g->angular_range, place, error));
    for (int i = 0; i < 2; ++i) g->angular[i] = (uint32_t)angular[i];
    if (angular[0] > 0 && g->width > 1 &&
        (g->width % g->angular[0] > 0 || g->height % g->angular[1] > 0))
        return mcv_fail_at(place, error, "angularResolution does not divide its pixels");
    return MCV_OK;
}

static mcv_result read_place(const json_t *from, mcv_element_group *g, const mcv_json_path *place,
                             mcv_error *error) {
    double binning[2] = {1, 1};
    MCV_TRY(mcv_json_numbers(from, "binning", 2, 1, MOST_SIDE, binning, place, error));
    for (int i = 0; i < 2; ++i) g->binning[i] = (uint32_t)binning[i];
    MCV_TRY(mcv_json_numbers(from, "size", 2, 0, INFINITY, g->size, place, error));
    MCV_TRY(mcv_json_numbers(from, "slopeRange", 2, 0, INFINITY, g->slope_range, place, error));
    return mcv_json_bool(from, "mirror", &g->mirror, place, error);
}

static mcv_result read_group(const json_t *from, mcv_matrix *m, const mcv_json_path *place,
                             mcv_error *error) {
    mcv_element_group *g = m->groups + m->group_count++;
    const char *emitter = NULL, *type = NULL;
    if (!json_is_object(from)) return mcv_fail_at(place, error, "must be an object");
    MCV_TRY(mcv_json_string(from, "emitter", &emitter, place, error));
    MCV_TRY(mcv_json_string(from, "type", &type, place, error));
    MCV_TRY(read_uint(from, "first", m->element_count, m->element_count, &g->first, place, error));
    MCV_TRY(read_uint(from, "width", 1, MOST_SIDE, &g->width, place, error));
    MCV_TRY(read_uint(from, "height", 1, MOST_SIDE, &g->height, place, error));
    MCV_TRY(mcv_json_numbers(from, "radiance", 3, 0, INFINITY, g->radiance, place, error));
    MCV_TRY(mcv_json_numbers(from, "to_world", 12, -INFINITY, INFINITY, g->to_world, place, error));
    MCV_TRY(read_place(from, g, place, error));
    MCV_TRY(read_directions(from, g, place, error));
    g->emitter = strdup(emitter ? emitter : "");
    g->type = strdup(type ? type : "");
    if (!g->emitter || !g->type) return mcv_fail_memory(place, error);
    const uint64_t elements = m->element_count + (uint64_t)g->width * g->height;
    if (elements > INT32_MAX) return mcv_fail_at(place, error, "has too many elements");
    m->element_count = (uint32_t)elements;
    return MCV_OK;
}

static mcv_result read_groups(const json_t *header, mcv_matrix *m, const mcv_json_path *place,
                              mcv_error *error) {
    json_t *list = NULL;
    MCV_TRY(mcv_json_array(header, "elements", &list, place, error));
    if (!list) return mcv_fail_at(place, error, "has no elements");
    m->groups = calloc(json_array_size(list), sizeof *m->groups);
    if (!m->groups) return mcv_fail_memory(place, error);
    const mcv_json_path here = mcv_json_path_key(place, "elements");
    for (size_t i = 0; i < json_array_size(list); ++i) {
        const mcv_json_path element = mcv_json_path_element(&here, NULL, i);
        MCV_TRY(read_group(json_array_get(list, i), m, &element, error));
    }
    return MCV_OK;
}

static mcv_result read_header(const json_t *header, mcv_matrix *m, const mcv_json_path *place,
                              mcv_error *error) {
    const char *format = "";
    uint64_t samples = 0;
    bool residual = false;
    if (!json_is_object(header)) return mcv_fail_at(place, error, "must be an object");
    MCV_TRY(mcv_json_string(header, "format", &format, place, error));
    if (strcmp(format, FORMAT) != 0)
        return mcv_fail_at(place, error, "is no header of a light transport matrix");
    MCV_TRY(read_uint(header, "width", 1, MOST_SIDE, &m->width, place, error));
    MCV_TRY(read_uint(header, "height", 1, MOST_SIDE, &m->height, place, error));
    MCV_TRY(read_uint(header, "channels", 1, 3, &m->channels, place, error));
    MCV_TRY(read_uint(header, "replicates", 1, MCV_MAX_REPLICATES, &m->replicates, place, error));
    MCV_TRY(mcv_json_uint(header, "samples", 1, UINT32_MAX, &samples, place, error));
    MCV_TRY(mcv_json_number(header, "kept", 0, 1, &m->kept, place, error));
    MCV_TRY(mcv_json_bool(header, "residual", &residual, place, error));
    MCV_TRY(read_groups(header, m, place, error));
    json_t *attributes = json_object_get(header, "attributes");
    m->attributes = json_is_object(attributes) ? json_incref(attributes) : NULL;
    m->samples = samples;
    m->row_count = (size_t)m->width * m->height * m->channels;
    m->column_count = m->element_count + residual;
    return MCV_OK;
}

/* An array of the file, copied. */
static mcv_result copy_array(const mcv_npz *z, const char *name, const char *dtype,
                             const size_t shape[MCV_NPZ_DIMENSIONS], size_t *length, void **copy,
                             mcv_error *error) {
    const uint8_t *data;
    size_t bytes = (size_t)(dtype[2] - '0');
    MCV_TRY(mcv_npz_array(z, name, dtype, shape, length, &data, error));
    for (int i = 0; i < MCV_NPZ_DIMENSIONS && (i == 0 || shape[i] > 0); ++i)
        bytes *= shape[i] == SIZE_MAX ? *length : shape[i];
    *copy = malloc(bytes + 1);
    if (!*copy) return mcv_fail(error, MCV_FAILED, "%s: no memory for %s", z->path, name);
    memcpy(*copy, data, bytes);
    return MCV_OK;
}

static mcv_result read_arrays(const mcv_npz *z, mcv_matrix *m, mcv_error *error) {
    size_t count = 0, unused;
    MCV_TRY(copy_array(z, "indptr.npy", "<i8", (size_t[3]){m->row_count + 1}, &unused,
                       (void **)&m->row_begins, error));
    MCV_TRY(copy_array(z, "indices.npy", "<i4", (size_t[3]){SIZE_MAX}, &count, (void **)&m->columns,
                       error));
    MCV_TRY(
        copy_array(z, "data.npy", "<f8", (size_t[3]){count}, &unused, (void **)&m->values, error));
    MCV_TRY(copy_array(z, "replicates.npy", "<f4", (size_t[3]){count, m->replicates}, &unused,
                       (void **)&m->replicates_of, error));
    MCV_TRY(copy_array(z, "pattern.npy", "<f4", (size_t[3]){m->element_count, m->channels}, &unused,
                       (void **)&m->pattern, error));
    bool right = m->row_begins[0] == 0 && m->row_begins[m->row_count] == count;
    for (size_t row = 0; right && row < m->row_count; ++row)
        right = m->row_begins[row] <= m->row_begins[row + 1] && m->row_begins[row + 1] <= count;
    for (size_t row = 0; right && row < m->row_count; ++row)
        for (uint64_t i = m->row_begins[row]; right && i < m->row_begins[row + 1]; ++i)
            right = m->columns[i] < m->column_count && isfinite(m->values[i]) &&
                    (i == m->row_begins[row] || m->columns[i] > m->columns[i - 1]);
    for (size_t i = 0; right && i < count * m->replicates; ++i)
        right = isfinite(m->replicates_of[i]);
    for (size_t i = 0; right && i < (size_t)m->element_count * m->channels; ++i)
        right = isfinite(m->pattern[i]);
    if (right) return MCV_OK;
    return mcv_fail(error, MCV_BAD_INPUT,
                    "%s: its arrays are no matrix in rows of ascending columns with finite values",
                    z->path);
}

static mcv_result read_matrix(const mcv_npz *z, mcv_matrix *m, mcv_error *error) {
    json_error_t wrong;
    size_t bytes = 0;
    const uint8_t *text = mcv_npz_bytes(z, "header.json", &bytes);
    if (!text)
        return mcv_fail(error, MCV_BAD_INPUT,
                        "%s: has no header.json: it is not from `mcvisi transport`", z->path);
    json_t *header = json_loadb((const char *)text, bytes, JSON_REJECT_DUPLICATES, &wrong);
    if (!header)
        return mcv_fail(error, MCV_BAD_INPUT, "%s: header.json: %s", z->path,
                        mcv_json_wrong(&wrong));
    const mcv_json_path file = mcv_place_file(z->path),
                        place = mcv_json_path_key(&file, "header.json");
    mcv_result result = read_header(header, m, &place, error);
    json_decref(header);
    if (result == MCV_OK) result = read_arrays(z, m, error);
    return result;
}

mcv_result mcv_matrix_read(const char *path, mcv_matrix *matrix, mcv_error *error) {
    mcv_npz z;
    *matrix = (mcv_matrix){0};
    MCV_TRY(mcv_npz_read(path, &z, error));
    const mcv_result result = read_matrix(&z, matrix, error);
    mcv_npz_free(&z);
    if (result != MCV_OK) mcv_matrix_free(matrix);
    return result;
}
