/* SPDX-License-Identifier: Apache-2.0 */
#include "analysis/render_error.h"

#include <math.h>
#include <stdlib.h>

/* Cells of less than 8 x 8 pixels would estimate their error from few; more than 32 x 32 cells make
 * a long header. */
enum { LEAST_PIXELS = 8, MOST_CELLS = 32 };

static uint32_t cells_along(uint32_t pixels) {
    const uint32_t cells = pixels / LEAST_PIXELS;
    return cells < 1 ? 1 : cells > MOST_CELLS ? MOST_CELLS : cells;
}

typedef struct place {
    size_t index, column, row, channel; /* of a value */
} place;

static place next(const mcv_image *image, place at) {
    ++at.index;
    if (++at.column != image->width) return at;
    at.column = 0;
    if (++at.row != image->height) return at;
    at.row = 0;
    ++at.channel;
    return at;
}

static size_t cell_of(const mcv_render_error *e, const mcv_image *image, place at) {
    return (at.channel * e->cells[1] + at.row * e->cells[1] / image->height) * e->cells[0] +
           at.column * e->cells[0] / image->width;
}

static size_t count_cells(const mcv_render_error *e) {
    return (size_t)e->cells[0] * e->cells[1] * e->channels;
}

/* (largest - value)(value - smallest) of the 3 x 3 pixels about one, as far as the image has them:
 * what sees two sides of an edge, and how different they are. */
static double edge_at(const mcv_image *grey, place at) {
    const size_t width = grey->width, i = at.index, first = at.row > 0 ? i - width : i,
                 last = at.row + 1 != grey->height ? i + width : i, left = at.column > 0,
                 right = at.column + 1 != width;
    float low = grey->pixels[i], high = low;
    for (size_t row = first; row <= last; row += width)
        for (size_t k = row - left; k <= row + right; ++k) {
            low = grey->pixels[k] < low ? grey->pixels[k] : low;
            high = grey->pixels[k] > high ? grey->pixels[k] : high;
        }
    return ((double)high - grey->pixels[i]) * ((double)grey->pixels[i] - low);
}

/* Sums over the pixels of a cell's side: how many, their variances, and edge_at. Of these, the same
 * over quiet ones: those whose edge_at is at most a quarter of its mean, or the foot of a blurred
 * edge would be among them. */
enum { QUIET = 4 };
typedef struct side {
    double count, variance, edge, quiet_count, quiet_variance;
} side;

typedef struct cell_sums {
    double low, high; /* its smallest and largest value */
    side sides[2];    /* below and above its level */
} cell_sums;

static double level_of(const cell_sums *c) { return ceil(0.5 * (c->low + c->high)); }

static void add_up(const mcv_image *grey, const mcv_image *errors, const mcv_render_error *told,
                   cell_sums *cells) {
    for (size_t k = 0; k < count_cells(told); ++k)
        cells[k] = (cell_sums){.low = INFINITY, .high = -INFINITY};
    for (place at = {0}; at.channel < grey->channels; at = next(grey, at)) {
        cell_sums *c = cells + cell_of(told, grey, at);
        c->low = fmin(c->low, grey->pixels[at.index]);
        c->high = fmax(c->high, grey->pixels[at.index]);
    }
    for (int quiet = 0; quiet < 2; ++quiet)
        for (place at = {0}; at.channel < grey->channels; at = next(grey, at)) {
            const float u = errors->pixels[at.index];
            const double variance = (double)u * u, edge = edge_at(grey, at);
            cell_sums *c = cells + cell_of(told, grey, at);
            side *s = c->sides + (grey->pixels[at.index] >= level_of(c));
            if (!quiet) {
                ++s->count;
                s->variance += variance;
                s->edge += edge;
            } else if (QUIET * edge * s->count <= s->edge) {
                ++s->quiet_count;
                s->quiet_variance += variance;
            }
        }
}

/* What quiet pixels have is each pixel's; edges have the rest. */
static mcv_error_cell split(const cell_sums *c) {
    mcv_error_cell told = {.level = level_of(c)};
    for (int i = 0; i < 2; ++i) {
        const side *s = c->sides + i;
        if (s->count == 0) continue;
        const double all = s->variance / s->count,
                     quiet =
                         s->quiet_count > 0 ? fmin(all, s->quiet_variance / s->quiet_count) : all;
        told.errors[i] = sqrt(quiet);
        if (s->edge > 0) told.edges[i] = sqrt((all - quiet) * s->count / s->edge);
    }
    return told;
}

mcv_result mcv_render_error_of(const mcv_image *grey, const mcv_image *errors,
                               const mcv_correlation *correlation, double shared, double freedom,
                               mcv_render_error *out, mcv_error *error) {
    *out = (mcv_render_error){
        .cells = {cells_along(grey->width), cells_along(grey->height)},
        .channels = grey->channels,
        .correlation = {correlation->sum, correlation->squares, correlation->stencil},
        .shared = shared,
        .freedom = freedom};
    cell_sums *cells = calloc(count_cells(out), sizeof *cells);
    out->items = calloc(count_cells(out), sizeof *out->items);
    if (!cells || !out->items) {
        free(cells);
        free(out->items);
        out->items = NULL;
        return mcv_fail(error, MCV_FAILED, "no memory for the render's error");
    }
    add_up(grey, errors, out, cells);
    for (size_t k = 0; k < count_cells(out); ++k) out->items[k] = split(cells + k);
    free(cells);
    return MCV_OK;
}

mcv_result mcv_render_error_image(const mcv_render_error *told, const mcv_image *grey,
                                  mcv_image *out, mcv_error *error) {
    MCV_TRY(mcv_image_new(out, grey->width, grey->height, grey->channels, error));
    for (place at = {0}; at.channel < grey->channels; at = next(grey, at)) {
        const mcv_error_cell *cell = told->items + cell_of(told, grey, at);
        const int above = grey->pixels[at.index] >= cell->level;
        out->pixels[at.index] = (float)sqrt(pow(cell->errors[above], 2) +
                                            pow(cell->edges[above], 2) * edge_at(grey, at));
    }
    return MCV_OK;
}
