/* SPDX-License-Identifier: Apache-2.0 */
#include "transport/fit.h"

#include "transport/nonnegative.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ½ w·G w - c·w of n weights. */
typedef struct problem {
    size_t n;
    double *g, *c;
} problem;

/* Sums over the pixels of a region of what the emitters bring. */
typedef struct sums {
    double count;
    double *mean;    /* [emitter] */
    double *product; /* [emitter][emitter], of two */
} sums;

typedef struct fit {
    const mcv_matrix *matrix;
    const float *pattern;
    size_t n;         /* emitters */
    uint32_t *groups; /* of each element, and of the dropped column: n */
    double *light;    /* [emitter][replicate], in one pixel */
    double *kept;     /* [emitter], in one pixel without a replicate */
    sums region, background;
    problem problem;
    double *weights; /* [left out][emitter]; the last of all replicates */
} fit;

enum { MOST_EVALUATIONS = 10000 };

/* --- light of a pixel by emitter --- */

static double shown(const fit *f, uint32_t column, uint32_t channel) {
    return f->pattern[(size_t)column * f->matrix->channels + channel];
}

static void find_light(const fit *f, size_t pixel) {
    const mcv_matrix *m = f->matrix;
    memset(f->light, 0, f->n * m->replicates * sizeof *f->light);
    for (uint32_t c = 0; c < m->channels; ++c) {
        const size_t row = pixel * m->channels + c;
        for (uint64_t i = m->row_begins[row]; i < m->row_begins[row + 1]; ++i) {
            const uint32_t group = f->groups[m->columns[i]];
            if (group == f->n) continue;
            for (uint32_t r = 0; r < m->replicates; ++r)
                f->light[(size_t)group * m->replicates + r] +=
                    shown(f, m->columns[i], c) * (double)m->replicates_of[i * m->replicates + r] /
                    m->channels;
        }
    }
}

/* The mean of each emitter's light over the replicates but one; `out` = their number: of all. */
static void leave_out(const fit *f, uint32_t out) {
    const uint32_t replicates = f->matrix->replicates;
    const double used = out < replicates ? replicates - 1 : replicates;
    for (size_t e = 0; e < f->n; ++e) {
        double sum = 0;
        for (uint32_t r = 0; r < replicates; ++r)
            if (r != out) sum += f->light[e * replicates + r];
        f->kept[e] = sum / used;
    }
}

static void add_region(const fit *f, const mcv_roi *roi, uint32_t out, sums *to) {
    memset(to->mean, 0, f->n * sizeof *to->mean);
    memset(to->product, 0, f->n * f->n * sizeof *to->product);
    to->count = (double)roi->count;
    for (size_t pixel = 0; pixel < (size_t)roi->width * roi->height; ++pixel) {
        if (!roi->inside[pixel]) continue;
        find_light(f, pixel);
        leave_out(f, out);
        for (size_t a = 0; a < f->n; ++a) {
            to->mean[a] += f->kept[a] / to->count;
            for (size_t b = 0; b < f->n; ++b)
                to->product[a * f->n + b] += f->kept[a] * f->kept[b] / to->count;
        }
    }
}

/* --- fits --- */

static double value_at(void *user, const double *at, double *slopes) {
    const problem *p = user;
    double value = 0;
    for (size_t a = 0; a < p->n; ++a) {
        double steep = 0;
        for (size_t b = 0; b < p->n; ++b) steep += p->g[a * p->n + b] * at[b];
        slopes[a] = steep - p->c[a];
        value += at[a] * (0.5 * steep - p->c[a]);
    }
    return value;
}

/* The weights, and the value there. */
static mcv_result solve(fit *f, double *weights, double *value, mcv_error *error) {
    double *scale = malloc(2 * f->n * sizeof *scale);
    if (!scale) return mcv_fail(error, MCV_FAILED, "no memory to fit %zu weights", f->n);
    double *slopes = scale + f->n;
    for (size_t a = 0; a < f->n; ++a) {
        const double own = f->problem.g[a * f->n + a];
        scale[a] = own > 0 ? 1 / sqrt(own) : 0;
        weights[a] = own > 0 ? 1 : 0;
    }
    const mcv_result result = mcv_minimise_nonnegative(value_at, &f->problem, scale, f->n,
                                                       MOST_EVALUATIONS, weights, error);
    if (result == MCV_OK) *value = value_at(&f->problem, weights, slopes);
    free(scale);
    return result;
}

static mcv_result fit_uniform(fit *f, double *weights, mcv_error *error) {
    double wanted = 0, unused;
    for (size_t a = 0; a < f->n; ++a) wanted += f->region.mean[a];
    if (!(wanted > 0)) return mcv_fail(error, MCV_BAD_INPUT, "the region has no light to fit");
    memcpy(f->problem.g, f->region.product, f->n * f->n * sizeof *f->problem.g);
    for (size_t a = 0; a < f->n; ++a) f->problem.c[a] = wanted * f->region.mean[a];
    return solve(f, weights, &unused, error);
}

/* G = S + λ d dᵀ and c = λ sign d: the least wᵀ S w + λ (d·w - sign)² is where d·w over √(wᵀ S w)
 * is extreme, whatever λ. */
static void pose_contrast(const fit *f, double sign) {
    const size_t n = f->n;
    const sums *back = &f->background;
    double spread = 0, difference = 0;
    for (size_t a = 0; a < n; ++a) {
        spread += back->product[a * n + a] - back->mean[a] * back->mean[a];
        difference += pow(f->region.mean[a] - back->mean[a], 2);
    }
    const double lambda = spread > 0 ? spread / difference : 1;
    for (size_t a = 0; a < n; ++a) {
        const double d = f->region.mean[a] - back->mean[a];
        f->problem.c[a] = lambda * sign * d;
        for (size_t b = 0; b < n; ++b)
            f->problem.g[a * n + b] = back->product[a * n + b] - back->mean[a] * back->mean[b] +
                                      lambda * d * (f->region.mean[b] - back->mean[b]);
    }
}

static mcv_result fit_contrast(fit *f, double *weights, mcv_error *error) {
    double *brighter = malloc(f->n * sizeof *brighter), value = 0, other = 0, most = 0;
    if (!brighter) return mcv_fail(error, MCV_FAILED, "no memory to fit %zu weights", f->n);
    pose_contrast(f, -1);
    mcv_result result = solve(f, weights, &value, error);
    pose_contrast(f, 1);
    if (result == MCV_OK) result = solve(f, brighter, &other, error);
    if (other < value) memcpy(weights, brighter, f->n * sizeof *weights);
    for (size_t a = 0; a < f->n; ++a) most = fmax(most, weights[a]);
    for (size_t a = 0; a < f->n; ++a) weights[a] /= most;
    free(brighter);
    if (result == MCV_OK && !(most > 0 && fmin(value, other) < 0))
        return mcv_fail(error, MCV_BAD_INPUT,
                        "no emitter makes a difference between the region and the background");
    return result;
}

/* --- errors by replicates --- */

/* The errors of the weights from fits that leave out a replicate each, in f->weights. */
static void find_errors(const fit *f, double *weights, double *errors) {
    const uint32_t replicates = f->matrix->replicates;
    for (size_t a = 0; a < f->n; ++a) {
        double mean = 0, squares = 0;
        for (uint32_t out = 0; out < replicates; ++out) mean += f->weights[out * f->n + a];
        mean /= replicates;
        for (uint32_t out = 0; out < replicates; ++out)
            squares += pow(f->weights[out * f->n + a] - mean, 2);
        weights[a] = f->weights[replicates * f->n + a];
        errors[a] = replicates > 1 ? sqrt(squares * (replicates - 1) / replicates) : NAN;
    }
}

static mcv_result fit_all(fit *f, const mcv_roi *region, const mcv_roi *background, double *weights,
                          double *errors, mcv_error *error) {
    const uint32_t replicates = f->matrix->replicates;
    for (uint32_t out = replicates > 1 ? 0 : 1; out <= replicates; ++out) {
        double *to = f->weights + (size_t)out * f->n;
        add_region(f, region, out, &f->region);
        if (background) add_region(f, background, out, &f->background);
        MCV_TRY(background ? fit_contrast(f, to, error) : fit_uniform(f, to, error));
    }
    find_errors(f, weights, errors);
    return MCV_OK;
}

static void number_groups(const fit *f) {
    const mcv_matrix *m = f->matrix;
    for (uint32_t e = 0; e < m->column_count; ++e) f->groups[e] = (uint32_t)f->n;
    for (uint32_t g = 0; g < f->n; ++g)
        for (uint32_t i = 0; i < m->groups[g].width * m->groups[g].height; ++i)
            f->groups[m->groups[g].first + i] = g;
}

static double *take(double **next, size_t count) {
    double *taken = *next;
    *next += count;
    return taken;
}

static sums take_sums(double **next, size_t n) {
    return (sums){.mean = take(next, n), .product = take(next, n * n)};
}

static mcv_result run(const mcv_matrix *m, const float *pattern, const mcv_roi *region,
                      const mcv_roi *background, double *weights, double *errors,
                      mcv_error *error) {
    const size_t n = m->group_count, fits = m->replicates + 1;
    if (n > MCV_FIT_MOST_EMITTERS)
        return mcv_fail(error, MCV_BAD_INPUT, "the matrix has %zu emitters: at most %d are fitted",
                        n, MCV_FIT_MOST_EMITTERS);
    double *room = calloc(3 * n * n + (m->replicates + fits + 4) * n, sizeof *room), *next = room;
    fit f = {.matrix = m,
             .pattern = pattern,
             .n = n,
             .groups = malloc((size_t)m->column_count * sizeof *f.groups)};
    mcv_result result = MCV_OK;
    if (room && f.groups) {
        f.light = take(&next, n * m->replicates);
        f.kept = take(&next, n);
        f.region = take_sums(&next, n);
        f.background = take_sums(&next, n);
        f.problem = (problem){n, take(&next, n * n), take(&next, n)};
        f.weights = take(&next, n * fits);
        number_groups(&f);
        result = fit_all(&f, region, background, weights, errors, error);
    } else {
        result = mcv_fail(error, MCV_FAILED, "no memory to fit %zu weights", n);
    }
    free(f.groups);
    free(room);
    return result;
}

mcv_result mcv_fit_uniform(const mcv_matrix *matrix, const float *pattern, const mcv_roi *region,
                           double *weights, double *errors, mcv_error *error) {
    return run(matrix, pattern, region, NULL, weights, errors, error);
}

mcv_result mcv_fit_contrast(const mcv_matrix *matrix, const float *pattern, const mcv_roi *region,
                            const mcv_roi *background, double *weights, double *errors,
                            mcv_error *error) {
    return run(matrix, pattern, region, background, weights, errors, error);
}
