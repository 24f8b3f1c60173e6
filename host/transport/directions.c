/* SPDX-License-Identifier: Apache-2.0 */
#include "transport/directions.h"

#include "scene/camera_model.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static mcv_result no_directions(mcv_error *error) {
    return mcv_fail(
        error, MCV_BAD_INPUT,
        "the matrix has no directions: it needs one light field emitter with --elements "
        "pixels, or a light field camera");
}

/* The camera model of the header. */
static mcv_result read_camera(const mcv_matrix *m, mcv_camera_model *model, mcv_error *error) {
    bool is_one = false;
    const char *text = json_string_value(json_object_get(m->attributes, MCV_CAMERA_MODEL_KEY));
    if (text) MCV_TRY(mcv_camera_model_read(text, "the matrix's header", model, &is_one, error));
    return is_one ? MCV_OK : no_directions(error);
}

/* --- a light field emitter --- */

static const mcv_element_group *find_emitter(const mcv_matrix *m) {
    const mcv_element_group *found = NULL;
    for (uint32_t i = 0; i < m->group_count; ++i) {
        if (m->groups[i].angular[0] == 0 || m->groups[i].width == 1) continue;
        if (found) return NULL;
        found = m->groups + i;
    }
    return found;
}

/* Light that a bin sends has the sines d in the emitter's frame, where it leaves along -z. Behind
 * the part it is parallel to the axis: its slope is taken off 0. */
static void find_emitter_slopes(mcv_directions *d, const double rotation[9]) {
    const double *to_world = d->group->to_world, range = d->group->angular_range;
    for (uint32_t bin = 0; bin < d->bins[0] * d->bins[1]; ++bin) {
        const uint32_t row = bin / d->bins[0];
        const double x = range * ((2 * (bin % d->bins[0]) + 1.0) / d->bins[0] - 1),
                     y = range * (1 - (2 * row + 1.0) / d->bins[1]),
                     emitted[3] = {x, y, -sqrt(fmax(0, 1 - x * x - y * y))};
        double world[3] = {0}, camera[3] = {0};
        for (int i = 0; i < 3; ++i)
            for (int k = 0; k < 3; ++k) world[i] += to_world[3 * i + k] * emitted[k];
        for (int i = 0; i < 3; ++i)
            for (int k = 0; k < 3; ++k) camera[i] += rotation[3 * i + k] * world[k];
        for (int i = 0; i < 2; ++i) d->slopes[2 * bin + (uint32_t)i] = camera[i] / camera[2];
    }
}

static void find_full(mcv_directions *d) {
    const char *unit = json_string_value(json_object_get(d->matrix->attributes, "mcvisi:unit"));
    const uint32_t channels = d->matrix->channels;
    d->full = NAN;
    if (!unit || strcmp(unit, "W/(m^2 sr)") != 0) return;
    d->full = 0;
    for (uint32_t c = 0; c < channels; ++c) d->full += d->group->radiance[c] / channels;
}

/* --- a light field camera --- */

static bool read_number(const mcv_matrix *m, const char *key, double *number) {
    *number = json_number_value(json_object_get(m->attributes, key));
    return *number > 0;
}

/* A bin is a place o of the lens, and light from the place P in focus at the distance w has the
 * slope (o - P)/w. Pixel (0, 0) of a macro pixel sees through the lens's upper left corner. */
static bool find_camera_slopes(mcv_directions *d, const mcv_camera_model *model) {
    double diameter, distance;
    if (!read_number(d->matrix, "mcvisi:lensDiameter", &diameter) ||
        !read_number(d->matrix, "mcvisi:focusDistance", &distance))
        return false;
    for (uint32_t bin = 0; bin < d->bins[0] * d->bins[1]; ++bin) {
        const uint32_t at[2] = {bin % d->bins[0], bin / d->bins[0]};
        for (int i = 0; i < 2; ++i)
            d->slopes[2 * bin + (uint32_t)i] =
                0.5 * diameter * ((2 * at[i] + 1.0) / d->bins[i] - 1) / distance;
    }
    for (int i = 0; i < 2; ++i) {
        d->middle[i] = model->k[3 * i + 2] / d->bins[i];
        d->pitch[i] = model->object_pixel[i] / distance;
    }
    return true;
}

/* --- both --- */

static mcv_result find_slopes(const mcv_camera_model *model, mcv_directions *d, mcv_error *error) {
    const mcv_matrix *m = d->matrix;
    const bool camera = model->macro[0] * model->macro[1] > 1;
    if (!camera) d->group = find_emitter(m);
    if (!camera && !d->group) return no_directions(error);
    for (int i = 0; i < 2; ++i) d->bins[i] = camera ? model->macro[i] : d->group->angular[i];
    d->width = camera ? m->width / d->bins[0] : m->width;
    d->height = camera ? m->height / d->bins[1] : m->height;
    d->slopes = calloc(2 * (size_t)d->bins[0] * d->bins[1], sizeof *d->slopes);
    if (!d->slopes) return mcv_fail(error, MCV_FAILED, "no memory for directions");
    d->full = NAN;
    if (camera) return find_camera_slopes(d, model) ? MCV_OK : no_directions(error);
    find_emitter_slopes(d, model->rotation);
    find_full(d);
    return MCV_OK;
}

mcv_result mcv_directions_of(const mcv_matrix *matrix, mcv_directions *directions,
                             mcv_error *error) {
    mcv_camera_model model = {0};
    *directions = (mcv_directions){.matrix = matrix};
    mcv_result result = read_camera(matrix, &model, error);
    if (result == MCV_OK) result = find_slopes(&model, directions, error);
    mcv_camera_model_free(&model);
    if (result != MCV_OK) mcv_directions_free(directions);
    return result;
}

void mcv_directions_free(mcv_directions *directions) {
    free(directions->slopes);
    directions->slopes = NULL;
}

void mcv_directions_slope(const mcv_directions *d, uint32_t column, uint32_t row, uint32_t bin,
                          double slope[2]) {
    slope[0] = d->slopes[2 * bin] - (column + 0.5 - d->middle[0]) * d->pitch[0];
    slope[1] = d->slopes[2 * bin + 1] - (row + 0.5 - d->middle[1]) * d->pitch[1];
}

static void add_entry(const mcv_directions *d, uint64_t entry, uint32_t channel, double *light) {
    const mcv_matrix *m = d->matrix;
    const uint32_t column = m->columns[entry];
    double shown = 1.0 / m->channels;
    if (d->group) {
        const uint32_t i = column - d->group->first, width = d->group->width;
        if (column < d->group->first || i >= width * d->group->height) return;
        light += ((i / width % d->bins[1]) * d->bins[0] + i % width % d->bins[0]) *
                 (size_t)m->replicates;
    } else if (column < m->element_count) {
        shown *= (double)m->pattern[(size_t)column * m->channels + channel];
    }
    for (uint32_t r = 0; r < m->replicates; ++r)
        light[r] += shown * (double)m->replicates_of[entry * m->replicates + r];
}

static void add_pixel(const mcv_directions *d, size_t pixel, double *light) {
    const mcv_matrix *m = d->matrix;
    for (uint32_t c = 0; c < m->channels; ++c) {
        const size_t row = pixel * m->channels + c;
        for (uint64_t i = m->row_begins[row]; i < m->row_begins[row + 1]; ++i)
            add_entry(d, i, c, light);
    }
}

void mcv_directions_light(const mcv_directions *d, uint32_t column, uint32_t row, double *light) {
    const mcv_matrix *m = d->matrix;
    const uint32_t bins = d->bins[0] * d->bins[1];
    memset(light, 0, (size_t)bins * m->replicates * sizeof *light);
    if (d->group) {
        add_pixel(d, (size_t)row * m->width + column, light);
        return;
    }
    for (uint32_t bin = 0; bin < bins; ++bin) {
        const size_t y = (size_t)row * d->bins[1] + bin / d->bins[0],
                     x = (size_t)column * d->bins[0] + bin % d->bins[0];
        add_pixel(d, y * m->width + x, light + (size_t)bin * m->replicates);
    }
}
