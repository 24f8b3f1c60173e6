/* SPDX-License-Identifier: Apache-2.0 */
/* Camera models as JSON. */
#include "scene/camera_model.h"

#include "core/json.h"

#include <stdlib.h>
#include <string.h>

static const char format[] = "mcvisi camera model 1";

static void put_numbers(json_t *object, const char *key, const double *values, size_t count) {
    json_t *array = json_array();
    for (size_t i = 0; i < count; ++i) json_array_append_new(array, json_real(values[i]));
    json_object_set_new(object, key, array);
}

static void put_matrix(json_t *object, const char *key, const double *values, size_t rows,
                       size_t columns) {
    json_t *matrix = json_array();
    for (size_t i = 0; i < rows; ++i) {
        json_t *row = json_array();
        for (size_t j = 0; j < columns; ++j)
            json_array_append_new(row, json_real(values[columns * i + j]));
        json_array_append_new(matrix, row);
    }
    json_object_set_new(object, key, matrix);
}

/* JSON has neither infinity nor NaN: such members are left out. */
static void put_number(json_t *object, const char *key, double value) {
    if (isfinite(value)) json_object_set_new(object, key, json_real(value));
}

static void put_pair(json_t *object, const char *key, const uint32_t values[2]) {
    json_object_set_new(object, key, json_pack("[i,i]", (int)values[0], (int)values[1]));
}

/* The frame as 3 x 4 by rows: axes, and the origin as the last column. */
static json_t *node_of(const mcv_placement *frame) {
    double matrix[12];
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) matrix[4 * i + j] = frame->to_world.m[3 * i + j];
        matrix[4 * i + 3] = frame->to_world.m[9 + i];
    }
    json_t *node = json_object();
    json_object_set_new(node, "name", json_string(frame->name));
    put_matrix(node, "toWorld", matrix, 3, 4);
    if (frame->of_asset) json_object_set_new(node, "ofAsset", json_true());
    return node;
}

/* The lists of a render's error, one number of each per cell. Errors are whole thousandths of a
 * grey value, at edges millionths of the step: numbers of few digits. */
enum { ERROR_LISTS = 5, FIRST_EDGE_LIST = 3 };
static const struct {
    const char *key;
    double steps;
} error_lists[ERROR_LISTS] = {{"level", 1},
                              {"milliBelow", 1e3},
                              {"milliAbove", 1e3},
                              {"microEdgeBelow", 1e6},
                              {"microEdgeAbove", 1e6}};

static double *number_of(mcv_error_cell *cell, int list) {
    return list == 0                ? &cell->level
           : list < FIRST_EDGE_LIST ? &cell->errors[list - 1]
                                    : &cell->edges[list - FIRST_EDGE_LIST];
}

static void put_render_error(json_t *object, const mcv_render_error *e) {
    json_t *render = json_object();
    const size_t count = (size_t)e->cells[0] * e->cells[1] * e->channels;
    put_pair(render, "cells", e->cells);
    json_object_set_new(render, "channels", json_integer(e->channels));
    put_numbers(render, "correlation", e->correlation, 3);
    put_number(render, "channelCorrelation", e->shared);
    put_number(render, "freedom", e->freedom);
    for (int k = 0; k < ERROR_LISTS; ++k) {
        json_t *list = json_array();
        for (size_t i = 0; i < count; ++i)
            json_array_append_new(
                list, json_integer(llround(error_lists[k].steps * *number_of(e->items + i, k))));
        json_object_set_new(render, error_lists[k].key, list);
    }
    json_object_set_new(object, "renderError", render);
}

/* Members of "lens", each with its place; those of 0 are left out. kappa stands in 1/m². */
enum { LENS_MEMBERS = 17 };
typedef struct lens_member {
    const char *key;
    double value;
} lens_member;

static void list_lens(const mcv_lens_map *m, double distance, lens_member list[LENS_MEMBERS]) {
    const lens_member members[LENS_MEMBERS] = {{"tilt", m->tilt},
                                               {"tiltDirection", m->direction},
                                               {"tiltX", m->tilt_xy[0]},
                                               {"tiltY", m->tilt_xy[1]},
                                               {"k1", m->k[0]},
                                               {"k2", m->k[1]},
                                               {"k3", m->k[2]},
                                               {"k4", m->k[3]},
                                               {"k5", m->k[4]},
                                               {"k6", m->k[5]},
                                               {"p1", m->p[0]},
                                               {"p2", m->p[1]},
                                               {"s1", m->s[0]},
                                               {"s2", m->s[1]},
                                               {"s3", m->s[2]},
                                               {"s4", m->s[3]},
                                               {"kappa", m->kappa / (distance * distance)}};
    memcpy(list, members, sizeof members);
}

void mcv_camera_model_put_lens(const mcv_camera_model *model, json_t *object) {
    lens_member list[LENS_MEMBERS];
    list_lens(&model->lens, model->film_distance, list);
    for (int i = 0; i < LENS_MEMBERS; ++i)
        if (list[i].value != 0) put_number(object, list[i].key, list[i].value);
}

static void put_lens(json_t *object, const mcv_camera_model *model) {
    json_t *lens = json_object();
    put_number(lens, "filmDistance", model->film_distance);
    mcv_camera_model_put_lens(model, lens);
    json_object_set_new(object, "lens", lens);
}

char *mcv_camera_model_write(const mcv_camera_model *model) {
    json_t *object = json_object(), *nodes = json_array();
    json_object_set_new(object, "format", json_string(format));
    json_object_set_new(object, "model",
                        json_string(model->line          ? "line"
                                    : model->telecentric ? "telecentric"
                                                         : "perspective"));
    json_object_set_new(object, "pixels", json_string("from the top-left corner of the image"));
    put_numbers(object, "centreOfFirstPixel", (const double[]){0.5, 0.5}, 2);
    json_object_set_new(object, "axes", json_string("x right, y down, z forward; metres"));
    put_pair(object, "size", model->size);
    if (model->macro[0] > 1 || model->macro[1] > 1) put_pair(object, "macroPixel", model->macro);
    if (model->telecentric)
        put_matrix(object, "A", model->affine, 2, 4);
    else if (!model->line)
        put_matrix(object, "K", model->k, 3, 3);
    if (mcv_lens_map_is_used(&model->lens)) put_lens(object, model);
    put_matrix(object, "R", model->rotation, 3, 3);
    put_numbers(object, "t", model->translation, 3);
    put_numbers(object, "pixelSize", model->pixel, 2);
    put_number(object, "focusedDepth", model->focused_depth);
    if (model->object_pixel[0] > 0) put_numbers(object, "objectPixel", model->object_pixel, 2);
    put_number(object, "fNumber", model->f_number);
    put_number(object, "numericalAperture", model->numerical_aperture);
    put_number(object, "bits", model->bits);
    put_number(object, "blackLevel", model->black_level);
    put_number(object, "gain", model->gain);
    if (model->render_error.items) put_render_error(object, &model->render_error);
    for (uint32_t i = 0; i < model->node_count && i < MCV_CAMERA_MODEL_NODES; ++i)
        json_array_append_new(nodes, node_of(model->nodes + i));
    json_object_set_new(object, "nodes", nodes);
    char *text = json_dumps(object, JSON_COMPACT | JSON_ENSURE_ASCII | JSON_REAL_PRECISION(17));
    json_decref(object);
    return text;
}

/* A member that must be there: an array of arrays, or of numbers where there is one row. */
static mcv_result get_matrix(const json_t *object, const char *key, size_t rows, size_t columns,
                             double *out, const mcv_json_path *where, mcv_error *error) {
    const mcv_json_path here = mcv_json_path_key(where, key);
    const json_t *matrix = json_object_get(object, key);
    bool right = json_array_size(matrix) == (rows == 1 ? columns : rows);
    for (size_t i = 0; right && i < rows; ++i) {
        const json_t *row = rows == 1 ? matrix : json_array_get(matrix, i);
        right = json_array_size(row) == columns;
        for (size_t j = 0; right && j < columns; ++j) {
            const json_t *number = json_array_get(row, j);
            right = json_is_number(number);
            out[columns * i + j] = json_number_value(number);
        }
    }
    if (right) return MCV_OK;
    return mcv_fail_at(&here, error, "must be %zu x %zu numbers", rows, columns);
}

static mcv_result get_number(const json_t *object, const char *key, double absent, double *out,
                             const mcv_json_path *where, mcv_error *error) {
    *out = absent;
    return mcv_json_number(object, key, -DBL_MAX, DBL_MAX, out, where, error);
}

/* Two whole numbers, or 1 and 1. */
static mcv_result get_pair(const json_t *object, const char *key, uint32_t out[2],
                           const mcv_json_path *where, mcv_error *error) {
    double pair[2] = {1, 1};
    const mcv_json_path here = mcv_json_path_key(where, key);
    MCV_TRY(mcv_json_numbers(object, key, 2, 1, 1 << 24, pair, where, error));
    for (int i = 0; i < 2; ++i) {
        if (pair[i] != floor(pair[i])) return mcv_fail_at(&here, error, "must be whole numbers");
        out[i] = (uint32_t)pair[i];
    }
    return MCV_OK;
}

static mcv_result get_lengths(const json_t *object, const char *key, double out[2],
                              const mcv_json_path *where, mcv_error *error) {
    const mcv_json_path here = mcv_json_path_key(where, key);
    MCV_TRY(get_matrix(object, key, 1, 2, out, where, error));
    return out[0] > 0 && out[1] > 0 ? MCV_OK : mcv_fail_at(&here, error, "must be lengths above 0");
}

static mcv_result get_nodes(const json_t *object, mcv_camera_model *model,
                            const mcv_json_path *where, mcv_error *error) {
    const mcv_json_path list = mcv_json_path_key(where, "nodes");
    const json_t *nodes = json_object_get(object, "nodes"), *node;
    size_t i;
    if (!json_is_array(nodes)) return mcv_fail_at(&list, error, "must be an array");
    model->nodes = calloc(json_array_size(nodes) + 1, sizeof *model->nodes);
    if (!model->nodes) return mcv_fail_memory(where, error);
    json_array_foreach(nodes, i, node) {
        const mcv_json_path here = mcv_place_index(&list, i);
        double matrix[12] = {0};
        mcv_placement *frame = model->nodes + model->node_count;
        MCV_TRY(get_matrix(node, "toWorld", 3, 4, matrix, &here, error));
        for (int k = 0; k < 3; ++k) {
            for (int j = 0; j < 3; ++j) frame->to_world.m[3 * k + j] = matrix[4 * k + j];
            frame->to_world.m[9 + k] = matrix[4 * k + 3];
        }
        frame->of_asset = json_is_true(json_object_get(node, "ofAsset"));
        frame->name = strdup(mcv_json_name(node));
        if (!frame->name) return mcv_fail_memory(where, error);
        ++model->node_count;
    }
    return MCV_OK;
}

static mcv_result get_render_error(const json_t *object, mcv_render_error *out,
                                   const mcv_json_path *where, mcv_error *error) {
    const mcv_json_path here = mcv_json_path_key(where, "renderError");
    json_t *render = NULL;
    double channels = 0;
    if (!json_object_get(object, "renderError")) return MCV_OK;
    MCV_TRY(mcv_json_object(object, "renderError", &render, where, error));
    MCV_TRY(get_pair(render, "cells", out->cells, &here, error));
    MCV_TRY(get_number(render, "channels", 1, &channels, &here, error));
    MCV_TRY(get_matrix(render, "correlation", 1, 3, out->correlation, &here, error));
    out->shared = 1;
    MCV_TRY(mcv_json_number(render, "channelCorrelation", -1, 1, &out->shared, &here, error));
    MCV_TRY(get_number(render, "freedom", 0, &out->freedom, &here, error));
    /* Before there is memory for them: as many as the text has. */
    const size_t count = json_array_size(json_object_get(render, "level"));
    if (!(channels >= 1 && channels <= 1 << 12) ||
        count != (uint64_t)out->cells[0] * out->cells[1] * (uint64_t)channels)
        return mcv_fail_at(&here, error, "must have a level for each of cells x channels");
    out->channels = (uint32_t)channels;
    double *list = calloc(count, sizeof *list);
    mcv_error_cell *items = calloc(count, sizeof *items);
    mcv_result result = list && items ? MCV_OK : mcv_fail_memory(where, error);
    for (int k = 0; result == MCV_OK && k < ERROR_LISTS; ++k) {
        /* Older files do not tell edges apart. */
        if (k >= FIRST_EDGE_LIST && !json_object_get(render, error_lists[k].key)) continue;
        result = get_matrix(render, error_lists[k].key, 1, count, list, &here, error);
        for (size_t i = 0; result == MCV_OK && i < count; ++i)
            *number_of(items + i, k) = list[i] / error_lists[k].steps;
    }
    free(list);
    out->items = result == MCV_OK ? items : NULL;
    if (result != MCV_OK) free(items);
    return result;
}

static mcv_result get_lens(const json_t *object, mcv_camera_model *model,
                           const mcv_json_path *where, mcv_error *error) {
    const mcv_json_path here = mcv_json_path_key(where, "lens");
    lens_member list[LENS_MEMBERS];
    json_t *lens = NULL;
    double n[LENS_MEMBERS];
    mcv_lens_map *m = &model->lens;
    *m = mcv_lens_map_none();
    if (!json_object_get(object, "lens")) return MCV_OK;
    MCV_TRY(mcv_json_object(object, "lens", &lens, where, error));
    MCV_TRY(get_number(lens, "filmDistance", 0, &model->film_distance, &here, error));
    if (!(model->film_distance > 0))
        return mcv_fail_at(&here, error, "must have a filmDistance above 0");
    list_lens(m, model->film_distance, list);
    for (int i = 0; i < LENS_MEMBERS; ++i)
        MCV_TRY(get_number(lens, list[i].key, 0, n + i, &here, error));
    if (n[2] != 0 || n[3] != 0)
        mcv_lens_map_tilt_xy(m, n[2], n[3]);
    else if (n[0] != 0)
        mcv_lens_map_tilt(m, n[0], n[1]);
    memcpy(m->k, n + 4, sizeof m->k);
    memcpy(m->p, n + 10, sizeof m->p);
    memcpy(m->s, n + 12, sizeof m->s);
    m->kappa = n[16] * model->film_distance * model->film_distance;
    for (int i = 4; i < 16; ++i)
        if (n[i] != 0) m->model = MCV_BROWN_CONRADY;
    if (m->kappa != 0) m->model = MCV_DIVISION;
    mcv_lens_map_find_reach(m);
    return MCV_OK;
}

static mcv_result get_all(const json_t *object, mcv_camera_model *model, const mcv_json_path *where,
                          mcv_error *error) {
    const mcv_json_path kind_place = mcv_json_path_key(where, "model"),
                        size = mcv_json_path_key(where, "size");
    const char *kind = "";
    MCV_TRY(mcv_json_string(object, "model", &kind, where, error));
    model->telecentric = strcmp(kind, "telecentric") == 0;
    model->line = strcmp(kind, "line") == 0;
    if (!model->telecentric && !model->line && strcmp(kind, "perspective") != 0)
        return mcv_fail_at(&kind_place, error,
                           "must be \"perspective\", \"telecentric\" or \"line\"");
    if (!json_object_get(object, "size")) return mcv_fail_at(&size, error, "is missing");
    MCV_TRY(get_pair(object, "size", model->size, where, error));
    MCV_TRY(get_pair(object, "macroPixel", model->macro, where, error));
    MCV_TRY(get_lens(object, model, where, error));
    MCV_TRY(get_matrix(object, "R", 3, 3, model->rotation, where, error));
    MCV_TRY(get_matrix(object, "t", 1, 3, model->translation, where, error));
    MCV_TRY(get_lengths(object, "pixelSize", model->pixel, where, error));
    if (model->telecentric || json_object_get(object, "objectPixel"))
        MCV_TRY(get_lengths(object, "objectPixel", model->object_pixel, where, error));
    if (model->telecentric)
        MCV_TRY(get_matrix(object, "A", 2, 4, model->affine, where, error));
    else if (!model->line)
        MCV_TRY(get_matrix(object, "K", 3, 3, model->k, where, error));
    MCV_TRY(get_number(object, "focusedDepth", INFINITY, &model->focused_depth, where, error));
    MCV_TRY(get_number(object, "fNumber", NAN, &model->f_number, where, error));
    MCV_TRY(get_number(object, "numericalAperture", NAN, &model->numerical_aperture, where, error));
    MCV_TRY(get_number(object, "bits", NAN, &model->bits, where, error));
    MCV_TRY(get_number(object, "blackLevel", NAN, &model->black_level, where, error));
    MCV_TRY(get_number(object, "gain", NAN, &model->gain, where, error));
    MCV_TRY(get_render_error(object, &model->render_error, where, error));
    return get_nodes(object, model, where, error);
}

mcv_result mcv_camera_model_read(const char *text, const char *path, mcv_camera_model *model,
                                 bool *is_one, mcv_error *error) {
    json_t *object = text ? json_loads(text, 0, NULL) : NULL;
    const char *said = json_string_value(json_object_get(object, "format"));
    const mcv_json_path file = mcv_place_file(path),
                        where = mcv_json_path_key(&file, MCV_CAMERA_MODEL_KEY);
    *model = (mcv_camera_model){0};
    *is_one = said && strcmp(said, format) == 0;
    const mcv_result result = *is_one ? get_all(object, model, &where, error) : MCV_OK;
    json_decref(object);
    if (result != MCV_OK) mcv_camera_model_free(model);
    return result;
}
