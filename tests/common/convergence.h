/* SPDX-License-Identifier: Apache-2.0 */
/* Errors of images against a true one, and how they fall with the samples. For the test of
 * convergence and the benchmark of errors. */
#ifndef MCVISI_TESTS_CONVERGENCE_H
#define MCVISI_TESTS_CONVERGENCE_H

#include "reference/reference.h"
#include "render/render.h"
#include "loader/load.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Samples per pixel 4^0, 4^1 … 4^7: more than four decades, or fewer steps. The truth has 16 times
 * the most, of another seed, in four scrambles. */
enum { CONVERGENCE_STEPS = 8, TRUTH_REPLICATES = 4, TRUTH_SEED = 1000003 };

typedef struct image_errors {
    double rmse;         /* root of the mean squared difference [the image's unit] */
    double relative_mse; /* mean of difference²/(truth² + mean²/100): pixels count alike, and dark
                            ones do not rule */
} image_errors;

static inline size_t film_values(const mcv_film *film) {
    return (size_t)film->width * film->height * film->channels;
}

/* The mean over replicates of the i-th value. */
static inline double film_value(const mcv_film *film, size_t i) {
    double sum = 0;
    for (uint32_t r = 0; r < film->replicates; ++r) sum += film->sums[r * film_values(film) + i];
    return sum / ((double)film->samples * film->replicates);
}

static inline image_errors errors_against(const mcv_film *film, const mcv_film *truth) {
    const size_t count = film_values(film);
    const double mean = mcv_film_mean(truth);
    image_errors e = {0, 0};
    for (size_t i = 0; i < count; ++i) {
        const double t = film_value(truth, i);
        const double difference = film_value(film, i) - t;
        e.rmse += difference * difference / (double)count;
        e.relative_mse += difference * difference / (t * t + mean * mean / 100) / (double)count;
    }
    e.rmse = sqrt(e.rmse);
    return e;
}

/* The exponent of y ~ samples^slope over samples 4^0, 4^1 …, by least squares in logarithms. */
static inline double convergence_slope(const double *y, int steps) {
    double xy = 0, xx = 0;
    for (int i = 0; i < steps; ++i) {
        const double x = (i - 0.5 * (steps - 1)) * log(4);
        xy += x * log(y[i]);
        xx += x * x;
    }
    return xy / xx;
}

/* Coarser pixels on the same field of view. */
static inline void shrink_film(uint32_t pixels[2], double size[2], uint32_t width,
                               uint32_t height) {
    const uint32_t target[2] = {width, height};
    for (int k = 0; k < 2; ++k) {
        size[k] *= (double)pixels[k] / target[k];
        pixels[k] = target[k];
    }
}

/* A shipped scene whose first sensor is a light field (6 x 4 macro pixels of 3 x 3), telecentric,
 * pinhole or thin lens camera (16 x 12 pixels). */
static inline mcv_result load_small(const char *name, mcv_scene **scene, mcv_error *error) {
    char path[1024];
    snprintf(path, sizeof path, "%s/scenes/%s", MCV_SOURCE_DIR, name);
    MCV_TRY(mcv_scene_load(path, (mcv_overrides){NULL, 0}, scene, error));
    mcv_sensor *sensor = &(*scene)->sensors[0];
    if (sensor->type == MCV_SENSOR_LIGHT_FIELD) {
        mcv_light_field_params *p = &sensor->as.light_field;
        for (int k = 0; k < 2; ++k) p->pixelSize[k] *= p->angularResolution[k] / 3.0;
        p->angularResolution[0] = p->angularResolution[1] = 3;
        shrink_film(p->spatialResolution, p->pixelSize, 6, 4);
    } else if (sensor->type == MCV_SENSOR_THIN_LENS) {
        shrink_film(sensor->as.thin_lens.resolution, sensor->as.thin_lens.pixelSize, 16, 12);
    } else if (sensor->type == MCV_SENSOR_PINHOLE) {
        shrink_film(sensor->as.pinhole.resolution, sensor->as.pinhole.pixelSize, 16, 12);
    } else {
        shrink_film(sensor->as.telecentric.resolution, sensor->as.telecentric.pixelSize, 16, 12);
    }
    return MCV_OK;
}

/* The image of the device for so many steps, made here. */
static inline mcv_result render_truth(const mcv_scene *scene, int steps, mcv_film *truth,
                                      mcv_render_stats *stats, mcv_error *error) {
    mcv_render_options options = mcv_render_defaults();
    options.replicates = TRUTH_REPLICATES;
    options.last = ((uint64_t)16 << 2 * (steps - 1)) / TRUTH_REPLICATES;
    options.seed = TRUTH_SEED;
    return mcv_render(scene, 0, &options, truth, stats, error);
}

typedef struct convergence_point {
    uint64_t samples; /* per pixel */
    double seconds;   /* of rendering alone */
    image_errors errors;
} convergence_point;

/* One image for each number of samples, rendered with these options, of one replicate, but their
 * samples and seed. */
static inline mcv_result converge_with(const mcv_scene *scene, mcv_render_options options,
                                       const mcv_film *truth, int steps, convergence_point *points,
                                       mcv_error *error) {
    for (int i = 0; i < steps; ++i) {
        mcv_render_stats stats = {0};
        mcv_film film = {0};
        options.last = (uint64_t)1 << 2 * i;
        options.seed = (uint32_t)i + 1;
        MCV_TRY((options.precision == MCV_PRECISION_DOUBLE ? mcv_reference_render : mcv_render)(
            scene, 0, &options, &film, &stats, error));
        points[i] =
            (convergence_point){options.last, stats.seconds_render, errors_against(&film, truth)};
        mcv_film_free(&film);
    }
    return MCV_OK;
}

/* The same of one scramble. */
static inline mcv_result converge(const mcv_scene *scene, uint32_t precision, uint32_t sampler,
                                  const mcv_film *truth, int steps, convergence_point *points,
                                  mcv_error *error) {
    mcv_render_options options = mcv_render_defaults();
    options.replicates = 1;
    options.precision = precision;
    options.sampler = sampler;
    return converge_with(scene, options, truth, steps, points, error);
}

static inline double slope_of_rmse(const convergence_point *points, int steps) {
    double rmse[CONVERGENCE_STEPS];
    for (int i = 0; i < steps; ++i) rmse[i] = points[i].errors.rmse;
    return convergence_slope(rmse, steps);
}

#endif
