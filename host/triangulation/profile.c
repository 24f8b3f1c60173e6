/* SPDX-License-Identifier: Apache-2.0 */
#include "triangulation/profile.h"

#include <math.h>

static double dot(const double a[3], const double b[3]) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

bool mcv_triangulate(const mcv_camera_model *model, const mcv_transform *laser,
                     const double place[2], double world[3]) {
    const double *m = laser->m, x[3] = {m[0], m[3], m[6]}, z[3] = {m[2], m[5], m[8]};
    double from[3], to[3], normal[3], along[3], aside[3];
    mcv_cross3(z, x, normal);
    /* A chief ray is straight: two depths tell it. */
    mcv_camera_model_unproject(model, place, 1, from);
    mcv_camera_model_unproject(model, place, 2, to);
    for (int i = 0; i < 3; ++i) {
        along[i] = to[i] - from[i];
        aside[i] = m[9 + i] - from[i];
    }
    const double steps = dot(normal, aside) / dot(normal, along);
    for (int i = 0; i < 3; ++i) world[i] = from[i] + steps * along[i];
    return isfinite(steps) && (model->telecentric || steps > -1);
}

/* --- coordinates --- */

/* In the axes of a rigid frame. */
static void to_frame(const mcv_transform *frame, const double world[3], double at[3]) {
    const double *m = frame->m;
    for (int j = 0; j < 3; ++j) {
        at[j] = 0;
        for (int i = 0; i < 3; ++i) at[j] += m[3 * i + j] * (world[i] - m[9 + i]);
    }
}

/* The place on the image of a point of the line: number i along, `across` the line. */
static bool point_at(const mcv_profile_settings *s, const mcv_camera_model *model, double i,
                     double across, double at[3]) {
    const double place[2] = {s->rows ? across : i + 0.5, s->rows ? i + 0.5 : across};
    double world[3];
    if (!mcv_triangulate(model, s->laser, place, world)) return false;
    for (int k = 0; k < 3; ++k) world[k] -= s->feed * s->laser->m[3 * k + 1];
    to_frame(s->frame, world, at);
    return true;
}

/* Coordinates and their uncertainty, by the change of z with the place. */
static void locate(const mcv_profile_settings *s, const mcv_camera_model *model, uint32_t i,
                   mcv_profile_point *point) {
    const double step = 0.5, place = point->line.place;
    double before[3], behind[3];
    if (!point_at(s, model, i, place, point->at)) {
        for (int k = 0; k < 3; ++k) point->at[k] = NAN;
        return;
    }
    if (point_at(s, model, i, place - step, before) && point_at(s, model, i, place + step, behind))
        point->u_z = fabs(behind[2] - before[2]) / (2 * step) * point->uncertainty;
}

/* --- speckle --- */

/* How the pixels of a profile lie: `step` from one place to the next, `stride` across the line. */
typedef struct layout {
    uint32_t length;
    size_t count, step, stride;
} layout;

static layout layout_of(const mcv_profile_settings *s, const mcv_image *values) {
    const size_t width = values->width;
    return s->rows ? (layout){values->height, width, width, 1}
                   : (layout){values->width, values->height, 1, width};
}

/* The variance of light across the line about its places [pixel²]. Light of all places is added
 * up, so that speckle and noise average out; pixels' own 1/12 is taken off. */
static double mean_variance(const mcv_profile_settings *s, const mcv_image *values, layout lies,
                            const mcv_profile_point *points) {
    double sum = 0, squares = 0;
    for (uint32_t i = 0; i < lies.length; ++i) {
        const double place = points[i].line.place, reach = s->line.window / 2.0;
        if (!mcv_line_has_place(points[i].line.state)) continue;
        for (size_t k = (size_t)fmax(ceil(place - reach - 0.5), 0);
             k < lies.count && (double)k + 0.5 <= place + reach; ++k) {
            const double off = (double)k + 0.5 - place,
                         light = (double)values->pixels[i * lies.step + k * lies.stride] -
                                 s->line.background;
            sum += light;
            squares += light * off * off;
        }
    }
    return squares / sum - 1.0 / 12;
}

static void add_speckle(const mcv_profile_settings *s, const mcv_image *values, layout lies,
                        const mcv_camera_model *model, mcv_profile_point *points) {
    const double along = model->pixel[s->rows ? 1 : 0], across = model->pixel[s->rows ? 0 : 1];
    const double variance = mean_variance(s, values, lies, points);
    if (!(s->contrast > 0) || !(variance > 0)) return;
    const double noise = mcv_line_speckle_noise(s->contrast, s->wavelength * model->f_number,
                                                sqrt(variance) * across, along,
                                                (mcv_line_stop){s->aperture, s->rows}) /
                         across;
    for (uint32_t i = 0; i < lies.length; ++i)
        points[i].uncertainty = hypot(points[i].uncertainty, noise);
}

/* --- profiles --- */

uint32_t mcv_profile_length(const mcv_profile_settings *settings, const mcv_image *values) {
    return layout_of(settings, values).length;
}

void mcv_profile_find(const mcv_profile_settings *s, const mcv_image *values,
                      const mcv_image *deviations, const mcv_camera_model *model,
                      mcv_profile_point *points) {
    const layout lies = layout_of(s, values);
    mcv_line_settings line = s->line;
    double brightest = line.background;
    for (size_t i = 0; i < lies.count * lies.length; ++i)
        brightest = fmax(brightest, (double)values->pixels[i]);
    line.threshold = s->threshold_share * (brightest - line.background);
    for (uint32_t i = 0; i < lies.length; ++i) {
        points[i] = (mcv_profile_point){.at = {NAN, NAN, NAN}, .u_z = NAN};
        points[i].line = mcv_line_find(&line, values->pixels + i * lies.step,
                                       deviations ? deviations->pixels + i * lies.step : NULL,
                                       lies.count, lies.stride);
        points[i].uncertainty = points[i].line.uncertainty;
    }
    if (!model) return;
    add_speckle(s, values, lies, model, points);
    for (uint32_t i = 0; s->laser && i < lies.length; ++i)
        if (mcv_line_has_place(points[i].line.state)) locate(s, model, i, points + i);
}

/* --- straight lines --- */

/* Adds the squares of the residuals of z about a line in x. */
static uint64_t add_residuals(const mcv_profile_point *points, size_t length, double *squares) {
    double n = 0, mean[2] = {0, 0}, xx = 0, xz = 0, zz = 0;
    for (size_t i = 0; i < length; ++i) {
        if (isnan(points[i].at[2])) continue;
        ++n;
        mean[0] += points[i].at[0];
        mean[1] += points[i].at[2];
    }
    if (n < 3) return 0;
    for (size_t i = 0; i < length; ++i) {
        if (isnan(points[i].at[2])) continue;
        const double x = points[i].at[0] - mean[0] / n, z = points[i].at[2] - mean[1] / n;
        xx += x * x;
        xz += x * z;
        zz += z * z;
    }
    *squares += fmax(zz - (xx > 0 ? xz * xz / xx : 0), 0);
    return (uint64_t)n - 2;
}

double mcv_profile_residual(const mcv_profile_point *points, size_t count, size_t length,
                            uint64_t *used) {
    double squares = 0;
    *used = 0;
    for (size_t i = 0; i + length <= count; i += length)
        *used += add_residuals(points + i, length, &squares);
    return *used > 0 ? sqrt(squares / (double)*used) : NAN;
}
