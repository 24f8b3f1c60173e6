/* SPDX-License-Identifier: Apache-2.0 */
#include "transport/deflection.h"

#include "transport/directions.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* What is known of a place, with standard errors: the light, its mean slopes and their
 * covariance. */
typedef struct place {
    double light, light_error;
    double mean[2], mean_error[2];
    double covariance[3], covariance_error[3]; /* xx, xy, yy */
} place;

typedef struct work {
    mcv_directions directions, undisturbed; /* undisturbed.matrix: NULL without a reference */
    double *light;                          /* of a place, [bin][replicate] */
    mcv_deflection *out;
} work;

/* --- a place --- */

/* The standard error of a mean over the replicates of Σ_bin f(bin) light(bin, replicate)/light. */
typedef struct sums {
    double of[6][MCV_MAX_REPLICATES]; /* light, x, y, xx, xy, yy */
} sums;

static void put_weights(const place *p, const double slope[2], double weights[6]) {
    const double x = slope[0] - p->mean[0], y = slope[1] - p->mean[1];
    const double all[6] = {
        1, x, y, x * x - p->covariance[0], x * y - p->covariance[1], y * y - p->covariance[2]};
    for (int i = 0; i < 6; ++i) weights[i] = all[i];
}

/* Means over bins and replicates are those of first order: a ratio's error is that of the numerator
 * less the ratio times the denominator. */
static void find_errors(const mcv_directions *d, const double *light, uint32_t column, uint32_t row,
                        place *p) {
    const uint32_t replicates = d->matrix->replicates;
    sums s = {{{0}}};
    double errors[6];
    for (uint32_t bin = 0; bin < d->bins[0] * d->bins[1]; ++bin) {
        double slope[2], weights[6];
        mcv_directions_slope(d, column, row, bin, slope);
        put_weights(p, slope, weights);
        for (uint32_t r = 0; r < replicates; ++r)
            for (int i = 0; i < 6; ++i)
                s.of[i][r] += weights[i] * light[(size_t)bin * replicates + r];
    }
    for (int i = 0; i < 6; ++i)
        errors[i] = sqrt(mcv_estimate_replicates(s.of[i], replicates).variance);
    p->light_error = errors[0];
    for (int i = 0; i < 2; ++i) p->mean_error[i] = errors[1 + i] / p->light;
    for (int i = 0; i < 3; ++i) p->covariance_error[i] = errors[3 + i] / p->light;
}

static double bin_light(const double *light, uint32_t bin, uint32_t replicates) {
    double sum = 0;
    for (uint32_t r = 0; r < replicates; ++r) sum += light[(size_t)bin * replicates + r];
    return sum / replicates;
}

static void find_place(const mcv_directions *d, double *light, uint32_t column, uint32_t row,
                       place *p) {
    const uint32_t replicates = d->matrix->replicates, bins = d->bins[0] * d->bins[1];
    double slope[2], first[2] = {0}, second[3] = {0};
    *p = (place){0};
    mcv_directions_light(d, column, row, light);
    for (uint32_t bin = 0; bin < bins; ++bin) {
        const double here = bin_light(light, bin, replicates);
        mcv_directions_slope(d, column, row, bin, slope);
        p->light += here;
        for (int i = 0; i < 2; ++i) first[i] += here * slope[i];
    }
    for (int i = 0; i < 2; ++i) p->mean[i] = first[i] / p->light;
    for (uint32_t bin = 0; bin < bins; ++bin) {
        const double here = bin_light(light, bin, replicates);
        mcv_directions_slope(d, column, row, bin, slope);
        const double x = slope[0] - p->mean[0], y = slope[1] - p->mean[1];
        second[0] += here * x * x;
        second[1] += here * x * y;
        second[2] += here * y * y;
    }
    for (int i = 0; i < 3; ++i) p->covariance[i] = second[i] / p->light;
    find_errors(d, light, column, row, p);
}

/* --- the images --- */

static void put(mcv_image *image, uint32_t channel, size_t pixel, double value) {
    image->pixels[(size_t)channel * image->width * image->height + pixel] = (float)value;
}

static void put_histogram(const work *w, uint32_t column, uint32_t row, double light) {
    const mcv_directions *d = &w->directions;
    mcv_deflection *out = w->out;
    for (uint32_t bin = 0; bin < d->bins[0] * d->bins[1]; ++bin) {
        const size_t y = (size_t)row * d->bins[1] + bin / d->bins[0],
                     at = y * out->histogram.width + (size_t)column * d->bins[0] + bin % d->bins[0];
        const mcv_estimate e = mcv_estimate_replicates(
            w->light + (size_t)bin * d->matrix->replicates, d->matrix->replicates);
        put(&out->histogram, 0, at, light > 0 ? e.mean / light : 0);
        put(&out->histogram_error, 0, at, light > 0 ? sqrt(e.variance) / light : NAN);
    }
}

/* Less what the reference says of the place. */
static void compare(const work *w, uint32_t column, uint32_t row, place *p, double share[2]) {
    place r = {.light = w->directions.full};
    if (w->undisturbed.matrix) find_place(&w->undisturbed, w->light, column, row, &r);
    share[0] = p->light / r.light;
    share[1] = hypot(p->light_error, share[0] * r.light_error) / r.light;
    if (!w->undisturbed.matrix) return;
    for (int i = 0; i < 2; ++i) {
        p->mean[i] -= r.mean[i];
        p->mean_error[i] = hypot(p->mean_error[i], r.mean_error[i]);
    }
}

static void fill_place(const work *w, uint32_t column, uint32_t row) {
    mcv_deflection *out = w->out;
    const size_t pixel = (size_t)row * out->width + column;
    double share[2];
    place p;
    find_place(&w->directions, w->light, column, row, &p);
    put_histogram(w, column, row, p.light);
    compare(w, column, row, &p, share);
    for (uint32_t i = 0; i < 2; ++i) {
        put(&out->mean, i, pixel, p.mean[i]);
        put(&out->mean_error, i, pixel, p.mean_error[i]);
    }
    for (uint32_t i = 0; i < 3; ++i) {
        put(&out->covariance, i, pixel, p.covariance[i]);
        put(&out->covariance_error, i, pixel, p.covariance_error[i]);
    }
    put(&out->transmitted, 0, pixel, share[0]);
    put(&out->transmitted_error, 0, pixel, share[1]);
}

static mcv_result allocate(const mcv_directions *d, mcv_deflection *out, mcv_error *error) {
    mcv_image *const images[] = {
        &out->mean,        &out->mean_error,        &out->covariance, &out->covariance_error,
        &out->transmitted, &out->transmitted_error, &out->histogram,  &out->histogram_error};
    static const uint32_t channels[] = {2, 2, 3, 3, 1, 1, 1, 1};
    out->width = d->width;
    out->height = d->height;
    for (int i = 0; i < 2; ++i) out->bins[i] = d->bins[i];
    for (int i = 0; i < 8; ++i)
        MCV_TRY(mcv_image_new(images[i], i < 6 ? d->width : d->width * d->bins[0],
                              i < 6 ? d->height : d->height * d->bins[1], channels[i], error));
    return MCV_OK;
}

/* Whether bins stand for the same directions at each place. */
static bool same_directions(const mcv_directions *a, const mcv_directions *b) {
    const size_t count = 2 * (size_t)a->bins[0] * a->bins[1];
    return memcmp(a->slopes, b->slopes, count * sizeof *a->slopes) == 0 &&
           memcmp(a->middle, b->middle, sizeof a->middle) == 0 &&
           memcmp(a->pitch, b->pitch, sizeof a->pitch) == 0;
}

static mcv_result open_directions(const mcv_matrix *matrix, const mcv_matrix *reference, work *w,
                                  mcv_error *error) {
    const mcv_directions *d = &w->directions, *u = &w->undisturbed;
    MCV_TRY(mcv_directions_of(matrix, &w->directions, error));
    if (!reference) return MCV_OK;
    MCV_TRY(mcv_directions_of(reference, &w->undisturbed, error));
    if (d->width == u->width && d->height == u->height && d->bins[0] == u->bins[0] &&
        d->bins[1] == u->bins[1])
        return same_directions(d, u)
                   ? MCV_OK
                   : mcv_fail(error, MCV_BAD_INPUT,
                              "the reference is of another set-up: its bins are other directions");
    return mcv_fail(error, MCV_BAD_INPUT,
                    "the reference has %u x %u places of %u x %u directions, the matrix %u x %u of "
                    "%u x %u",
                    u->width, u->height, u->bins[0], u->bins[1], d->width, d->height, d->bins[0],
                    d->bins[1]);
}

static mcv_result fill(work *w, mcv_error *error) {
    const mcv_directions *d = &w->directions;
    const uint32_t other = w->undisturbed.matrix ? w->undisturbed.matrix->replicates : 0,
                   replicates = d->matrix->replicates > other ? d->matrix->replicates : other;
    w->light = malloc((size_t)d->bins[0] * d->bins[1] * replicates * sizeof *w->light);
    if (!w->light) return mcv_fail(error, MCV_FAILED, "no memory for histograms of directions");
    MCV_TRY(allocate(d, w->out, error));
    for (uint32_t row = 0; row < d->height; ++row)
        for (uint32_t column = 0; column < d->width; ++column) fill_place(w, column, row);
    return MCV_OK;
}

mcv_result mcv_deflection_of(const mcv_matrix *matrix, const mcv_matrix *reference,
                             mcv_deflection *deflection, mcv_error *error) {
    work w = {.out = deflection};
    *deflection = (mcv_deflection){0};
    mcv_result result = open_directions(matrix, reference, &w, error);
    if (result == MCV_OK) result = fill(&w, error);
    free(w.light);
    mcv_directions_free(&w.directions);
    mcv_directions_free(&w.undisturbed);
    if (result != MCV_OK) mcv_deflection_free(deflection);
    return result;
}

void mcv_deflection_free(mcv_deflection *d) {
    mcv_image *const images[] = {
        &d->mean,        &d->mean_error,        &d->covariance, &d->covariance_error,
        &d->transmitted, &d->transmitted_error, &d->histogram,  &d->histogram_error};
    for (size_t i = 0; i < sizeof images / sizeof images[0]; ++i) mcv_image_free(images[i]);
}
