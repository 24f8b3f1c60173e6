/* SPDX-License-Identifier: Apache-2.0 */
#include "deflectometry/shape.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "analysis/noise.h"
#include "core/parallel.h"
#include "deflectometry/height.h"

enum { ROUNDS = 8, DRAWS = 8 };

/* What slopes are made from. */
typedef struct setting {
    const mcv_camera_model *model;
    const mcv_screen_place *screen;
    const mcv_transform *plane;
    const mcv_decoded *const *places;
    mcv_shape *shape;
    uint32_t seed;
    double *drawn; /* heights of all draws */
    mcv_result results[DRAWS];
    mcv_error errors[DRAWS];
} setting;

void mcv_shape_free(mcv_shape *shape) {
    double *const maps[] = {shape->x, shape->y,   shape->z,   shape->p,
                            shape->q, shape->u_p, shape->u_q, shape->u_z};
    for (size_t i = 0; i < sizeof maps / sizeof maps[0]; ++i) free(maps[i]);
    free(shape->valid);
    *shape = (mcv_shape){0};
}

static mcv_result shape_new(mcv_shape *s, uint32_t width, uint32_t height, mcv_error *error) {
    const size_t count = (size_t)width * height;
    *s = (mcv_shape){.width = width, .height = height};
    double **const maps[] = {&s->x, &s->y, &s->z, &s->p, &s->q, &s->u_p, &s->u_q, &s->u_z};
    bool made = (s->valid = calloc(count + 1, sizeof *s->valid)) != NULL;
    for (size_t i = 0; i < sizeof maps / sizeof maps[0]; ++i)
        made = (*maps[i] = calloc(count + 1, sizeof **maps[i])) && made;
    return made ? MCV_OK : mcv_fail(error, MCV_FAILED, "no memory for a map of %zu pixels", count);
}

/* Slopes at the pixel where it shows a place of the screen. */
static bool slopes_at(const setting *s, const mcv_chief_ray *ray, const double at[3],
                      const double pixel[2], double slopes[2]) {
    double shown[3];
    mcv_screen_point(s->screen, pixel, shown);
    return mcv_slopes_of(ray, s->plane, at, shown, slopes);
}

/* By differences of one pixel of the screen, over which the law of reflection is linear enough. */
static void propagate(const setting *s, const mcv_chief_ray *ray, const double at[3], size_t i,
                      const double slopes[2]) {
    double variance[2] = {0, 0};
    for (int way = 0; way < 2; ++way) {
        double moved[2], pixel[2] = {s->places[0][i].place, s->places[1][i].place};
        pixel[way] += 1;
        if (!slopes_at(s, ray, at, pixel, moved)) continue;
        for (int k = 0; k < 2; ++k)
            variance[k] += pow((moved[k] - slopes[k]) * s->places[way][i].deviation, 2);
    }
    s->shape->u_p[i] = sqrt(variance[0]);
    s->shape->u_q[i] = sqrt(variance[1]);
}

static void look_at_row(void *user, size_t row) {
    const setting *s = user;
    mcv_shape *shape = s->shape;
    for (uint32_t column = 0; column < shape->width; ++column) {
        const size_t i = row * shape->width + column;
        const double pixel[2] = {s->places[0][i].place, s->places[1][i].place};
        const mcv_chief_ray ray = mcv_chief_ray_of(s->model, column, (uint32_t)row);
        double at[3], slopes[2];
        shape->valid[i] = !isnan(pixel[0]) && !isnan(pixel[1]) &&
                          mcv_intersect_plane(&ray, s->plane, shape->z[i], at) &&
                          slopes_at(s, &ray, at, pixel, slopes);
        if (!shape->valid[i]) continue;
        shape->x[i] = at[0];
        shape->y[i] = at[1];
        shape->p[i] = slopes[0];
        shape->q[i] = slopes[1];
        propagate(s, &ray, at, i, slopes);
    }
}

static mcv_slope_map map_of(const mcv_shape *s) {
    return (mcv_slope_map){s->width, s->height, s->valid, s->x, s->y, s->p, s->q};
}

/* The extent of the map [m]. */
static double extent_of(const mcv_shape *s) {
    double low[2] = {INFINITY, INFINITY}, high[2] = {-INFINITY, -INFINITY};
    for (size_t i = 0; i < (size_t)s->width * s->height; ++i) {
        if (!s->valid[i]) continue;
        low[0] = fmin(low[0], s->x[i]);
        high[0] = fmax(high[0], s->x[i]);
        low[1] = fmin(low[1], s->y[i]);
        high[1] = fmax(high[1], s->y[i]);
    }
    return s->valid_count > 0 ? hypot(high[0] - low[0], high[1] - low[1]) : 0;
}

/* Shifts all heights so that the surface passes the node's origin: the pixel nearest to it is
 * continued straight. Slopes do not tell where the part is, but depend on it. */
static void anchor(mcv_shape *s) {
    const size_t count = (size_t)s->width * s->height;
    size_t nearest = count;
    double least = INFINITY;
    for (size_t i = 0; i < count; ++i) {
        const double distance = hypot(s->x[i], s->y[i]);
        if (!s->valid[i] || !(distance < least)) continue;
        least = distance;
        nearest = i;
    }
    if (nearest == count) return;
    const double shift =
        s->z[nearest] - s->p[nearest] * s->x[nearest] - s->q[nearest] * s->y[nearest];
    for (size_t i = 0; i < count; ++i)
        if (s->valid[i]) s->z[i] -= shift;
}

/* Heights change places, and these the slopes. The change shrinks in each round by about the height
 * over the distance of the screen. */
static mcv_result find_heights(const setting *s, mcv_error *error) {
    mcv_shape *shape = s->shape;
    const size_t count = (size_t)shape->width * shape->height;
    double *before = malloc((count + 1) * sizeof *before);
    mcv_result result =
        before ? MCV_OK : mcv_fail(error, MCV_FAILED, "no memory for a map of %zu pixels", count);
    for (int round = 0; round < ROUNDS && result == MCV_OK; ++round) {
        double change = 0;
        memcpy(before, shape->z, count * sizeof *before);
        mcv_in_parallel(shape->height, look_at_row, (void *)s);
        const mcv_slope_map map = map_of(shape);
        result = mcv_heights_integrate(&map, shape->z, &shape->residual, error);
        anchor(shape);
        shape->valid_count = 0;
        for (size_t i = 0; i < count; ++i) {
            shape->valid_count += shape->valid[i];
            change = fmax(change, fabs(shape->z[i] - before[i]));
        }
        if (change <= 1e-9 * extent_of(shape)) break;
    }
    free(before);
    return result;
}

/* The heights of slopes that are nothing but errors. */
static void draw(void *user, size_t number) {
    setting *s = user;
    const mcv_shape *shape = s->shape;
    const size_t count = (size_t)shape->width * shape->height;
    double *slopes = malloc((2 * count + 1) * sizeof *slopes);
    if (!slopes) {
        s->results[number] = mcv_fail(&s->errors[number], MCV_FAILED, "no memory for slopes");
        return;
    }
    mcv_slope_map map = map_of(shape);
    for (size_t i = 0; i < count; ++i) {
        mcv_noise noise = mcv_noise_begin(s->seed, 2 + (uint32_t)number, i);
        slopes[i] = shape->valid[i] ? shape->u_p[i] * mcv_noise_normal(&noise) : 0;
        slopes[count + i] = shape->valid[i] ? shape->u_q[i] * mcv_noise_normal(&noise) : 0;
    }
    map.p = slopes;
    map.q = slopes + count;
    s->results[number] =
        mcv_heights_integrate(&map, s->drawn + number * count, NULL, &s->errors[number]);
    free(slopes);
}

static mcv_result find_uncertainty(setting *s, mcv_error *error) {
    mcv_shape *shape = s->shape;
    const size_t count = (size_t)shape->width * shape->height;
    s->drawn = calloc(DRAWS * count + 1, sizeof *s->drawn);
    if (!s->drawn) return mcv_fail(error, MCV_FAILED, "no memory for draws of heights");
    mcv_in_parallel(DRAWS, draw, s);
    mcv_result result = MCV_OK;
    for (int k = 0; k < DRAWS && result == MCV_OK; ++k)
        if ((result = s->results[k]) != MCV_OK) *error = s->errors[k];
    for (size_t i = 0; i < count; ++i) {
        double sum = 0;
        for (int k = 0; k < DRAWS; ++k) sum += pow(s->drawn[(size_t)k * count + i], 2);
        shape->u_z[i] = sqrt(sum / DRAWS);
    }
    free(s->drawn);
    return result;
}

mcv_result mcv_shape_make(const mcv_camera_model *model, const mcv_screen_place *screen,
                          const mcv_transform *plane, const mcv_decoded *const places[2],
                          uint32_t width, uint32_t height, uint32_t seed, mcv_shape *shape,
                          mcv_error *error) {
    setting s = {.model = model,
                 .screen = screen,
                 .plane = plane,
                 .places = places,
                 .shape = shape,
                 .seed = seed};
    mcv_result result = shape_new(shape, width, height, error);
    if (result == MCV_OK) result = find_heights(&s, error);
    if (result == MCV_OK) result = find_uncertainty(&s, error);
    if (result != MCV_OK) mcv_shape_free(shape);
    return result;
}
