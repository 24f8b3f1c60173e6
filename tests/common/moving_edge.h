/* SPDX-License-Identifier: Apache-2.0 */
/* Pictures of an edge while something moves: where it lies, how wide it is, its transfer
 * function. */
#ifndef MCVISI_TESTS_MOVING_EDGE_H
#define MCVISI_TESTS_MOVING_EDGE_H

#include "reference_checks.h"
#include "scene_builder.h"
#include "sensor_json.h"

#include "render/render.h"

#include <complex.h>

enum { SIZE = 48 };
/* A pixel sees 0.3 mm of the plane. */
static const double depth = 0.3, seen = 0.3e-3;

static inline mcv_sensor camera_with(const char *json) {
    char text[512];
    mcv_sensor sensor;
    mcv_error error;
    snprintf(text, sizeof text,
             "{\"imageDistance\":\"20mm\",\"resolution\":[%d,%d],\"pixelSize\":\"20um\"%s}", SIZE,
             SIZE, json);
    if (sensor_of(MCV_SENSOR_PINHOLE, text, &sensor, &error) != MCV_OK) fail_msg("%s", error.text);
    return sensor;
}

/* surfaces: on a path, at most. */
static inline mcv_image picture_by(bool reference, const mcv_scene *scene, uint32_t surfaces) {
    mcv_image image;
    mcv_film film;
    mcv_render_stats stats;
    if (reference) {
        mcv_render_options options = options_of(64, surfaces);
        options.replicates = 2;
        film = render_with(scene, &options, surfaces > 1, &stats);
    } else {
        mcv_render_options options = mcv_render_defaults();
        options.replicates = 2;
        options.last = 128;
        options.depth = surfaces;
        BUILD(mcv_render(scene, 0, &options, &film, &stats, &builder_error));
    }
    BUILD(mcv_film_develop(&film, &image, NULL, &builder_error));
    mcv_film_free(&film);
    return image;
}

/* Mean place of the edge in a row (or column), and its variance, in pixels. */
static inline void edge_of(const mcv_image *image, bool across, uint32_t line, double *place,
                           double *variance) {
    double sum = 0, first = 0, second = 0;
    for (uint32_t i = 1; i < SIZE; ++i) {
        const float *p = image->pixels;
        const double weight = across ? (double)p[i * SIZE + line] - p[(i - 1) * SIZE + line]
                                     : (double)p[line * SIZE + i] - p[line * SIZE + i - 1];
        sum += weight, first += weight * i, second += weight * i * i;
    }
    *place = first / sum;
    *variance = second / sum - *place * *place;
}

/* The spread of the edge at 1/16 per pixel: the transfer function, with that of the pixels and of
 * the difference between them. */
static const double frequency = 1 / 16.0;

static inline double sinc(double x) { return sin(M_PI * x) / (M_PI * x); }

static inline double transfer_of(const mcv_image *image, bool across) {
    double complex sum = 0;
    double all = 0;
    for (uint32_t line = 0; line < SIZE; ++line)
        for (uint32_t i = 1; i < SIZE; ++i) {
            const float *p = image->pixels;
            const double weight = across ? (double)p[i * SIZE + line] - p[(i - 1) * SIZE + line]
                                         : (double)p[line * SIZE + i] - p[line * SIZE + i - 1];
            sum += weight * cexp(I * 2 * M_PI * frequency * i);
            all += weight;
        }
    return cabs(sum) / fabs(all);
}

/* Over all lines: place of the edge on the first and the last line by a straight fit, the mean
 * variance, and the transfer function. */
typedef struct edge {
    double middle, slope, variance, transfer;
} edge;

static inline edge edge_in(bool reference, const mcv_scene *scene, uint32_t surfaces, bool across) {
    mcv_image image = picture_by(reference, scene, surfaces);
    double sum[2] = {0}, variance = 0;
    for (uint32_t line = 0; line < SIZE; ++line) {
        double place, spread;
        edge_of(&image, across, line, &place, &spread);
        sum[0] += place / SIZE, sum[1] += place * (line - (SIZE - 1) / 2.0),
            variance += spread / SIZE;
    }
    const double transfer = transfer_of(&image, across);
    mcv_image_free(&image);
    return (edge){sum[0], sum[1] / (SIZE * (SIZE * SIZE - 1) / 12.0), variance, transfer};
}

static inline void expect(const char *what, double value, double truth, double bound) {
    print_message("  %s: %.4f, must be %.4f\n", what, value, truth);
    if (!(fabs(value - truth) < bound)) fail_msg("%s: %.4f, not %.4f", what, value, truth);
}

#endif
