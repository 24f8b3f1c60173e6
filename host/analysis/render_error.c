/* SPDX-License-Identifier: Apache-2.0 */
#include "analysis/render_error.h"

#include <math.h>
#include <stdlib.h>

/* Cells of less than 8 x 8 pixels would know their errors from few; more than 32 x 32 of them make
 * a long header. */
enum { LEAST_PIXELS = 8, MOST_CELLS = 32 };

static uint32_t cells_along(uint32_t pixels) {
    const uint32_t cells = pixels / LEAST_PIXELS;
    return cells < 1 ? 1 : cells > MOST_CELLS ? MOST_CELLS : cells;
}

static size_t cell_of(const mcv_render_error *e, const mcv_image *image, size_t i) {
    const size_t plane = (size_t)image->width * image->height, x = i % image->width,
                 y = i % plane / image->width;
    return (i / plane * e->cells[1] + y * e->cells[1] / image->height) * e->cells[0] +
           x * e->cells[0] / image->width;
}

static size_t count_cells(const mcv_render_error *e) {
    return (size_t)e->cells[0] * e->cells[1] * e->channels;
}

/* Sums of the squares on both sides of a cell's level. */
typedef struct side {
    double low, high; /* the cell's smallest and largest value */
    double squares[2], count[2];
} side;

static void add_up(const mcv_image *grey, const mcv_image *errors, const mcv_render_error *e,
                   side *sides) {
    const size_t count = (size_t)grey->width * grey->height * grey->channels;
    for (size_t k = 0; k < count_cells(e); ++k)
        sides[k] = (side){.low = INFINITY, .high = -INFINITY};
    for (size_t i = 0; i < count; ++i) {
        side *s = sides + cell_of(e, grey, i);
        s->low = fmin(s->low, grey->pixels[i]);
        s->high = fmax(s->high, grey->pixels[i]);
    }
    for (size_t i = 0; i < count; ++i) {
        side *s = sides + cell_of(e, grey, i);
        const int above = grey->pixels[i] >= ceil(0.5 * (s->low + s->high));
        s->squares[above] += (double)errors->pixels[i] * errors->pixels[i];
        ++s->count[above];
    }
}

mcv_result mcv_render_error_of(const mcv_image *grey, const mcv_image *errors,
                               const mcv_correlation *correlation, double freedom,
                               mcv_render_error *out, mcv_error *error) {
    *out = (mcv_render_error){
        .cells = {cells_along(grey->width), cells_along(grey->height)},
        .channels = grey->channels,
        .correlation = {correlation->sum, correlation->squares, correlation->stencil},
        .freedom = freedom};
    side *sides = calloc(count_cells(out), sizeof *sides);
    out->items = calloc(count_cells(out), sizeof *out->items);
    if (!sides || !out->items) {
        free(sides);
        free(out->items);
        out->items = NULL;
        return mcv_fail(error, MCV_FAILED, "no memory for the render's error");
    }
    add_up(grey, errors, out, sides);
    for (size_t k = 0; k < count_cells(out); ++k) {
        const side *s = sides + k;
        out->items[k].level = ceil(0.5 * (s->low + s->high));
        for (int i = 0; i < 2; ++i)
            out->items[k].errors[i] = s->count[i] > 0 ? sqrt(s->squares[i] / s->count[i]) : 0;
    }
    free(sides);
    return MCV_OK;
}

mcv_result mcv_render_error_image(const mcv_render_error *told, const mcv_image *grey,
                                  mcv_image *out, mcv_error *error) {
    MCV_TRY(mcv_image_new(out, grey->width, grey->height, grey->channels, error));
    for (size_t i = 0; i < (size_t)grey->width * grey->height * grey->channels; ++i) {
        const mcv_error_cell *cell = told->items + cell_of(told, grey, i);
        out->pixels[i] = (float)cell->errors[grey->pixels[i] >= cell->level];
    }
    return MCV_OK;
}
