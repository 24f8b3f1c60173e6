/* SPDX-License-Identifier: Apache-2.0 */
/* The first order: differences within repeats, and their spread among repeats. */
#include "uncertainty/propagation.h"

#include "analysis/statistics.h"

#include <math.h>
#include <stdlib.h>

/* What curvature or interaction is worth a flag: a share of the effect, and of all effects. */
static const double of_effect = 0.3, of_all = 0.1;

/* Columns of quantities, a row of each whole repeat: the nominal value, the effects, the
 * curvatures and the interactions. */
typedef struct repeats {
    const mcv_tolerances *tolerances;
    size_t columns, count;
    double *rows;
    double t; /* Student's, two-sided 95 % */
} repeats;

static size_t effect(size_t i) { return 1 + i; }
static size_t curvature(const repeats *r, size_t i) { return 1 + r->tolerances->count + i; }
static size_t interaction(const repeats *r, size_t v) { return 1 + 2 * r->tolerances->count + v; }

static double mean_of(const repeats *r, size_t column) {
    double sum = 0;
    for (size_t i = 0; i < r->count; ++i) sum += r->rows[i * r->columns + column];
    return sum / (double)r->count;
}

/* The standard uncertainty of the mean. */
static double error_of(const repeats *r, size_t column) {
    const double mean = mean_of(r, column), n = (double)r->count;
    double sum = 0;
    for (size_t i = 0; i < r->count; ++i) {
        const double off = r->rows[i * r->columns + column] - mean;
        sum += off * off;
    }
    return sqrt(sum / (n * (n - 1)));
}

/* One row from the points of a repeat; false: a point has failed. */
static bool take_repeat(const mcv_propagation *p, const double *points, size_t stride,
                        const repeats *r, double *row) {
    const size_t k = p->tolerances->count, signs = mcv_propagation_signs(p);
    for (size_t i = 0; i < mcv_propagation_repeat(p); ++i)
        if (isnan(points[i * stride])) return false;
    row[0] = points[0];
    double curvatures = 0;
    for (size_t i = 0; i < k + signs; ++i) {
        const double up = points[(1 + 2 * i) * stride], down = points[(2 + 2 * i) * stride];
        const double even = (up + down) / 2 - row[0];
        if (i < k) {
            row[effect(i)] = (up - down) / 2;
            row[curvature(r, i)] = even;
            curvatures += even;
        } else {
            row[interaction(r, i - k)] = even - curvatures;
        }
    }
    return true;
}

/* aᵀ ρ b */
static double form(const mcv_tolerances *t, const double *a, const double *b) {
    double sum = 0;
    for (size_t i = 0; i < t->count; ++i)
        for (size_t k = 0; k < t->count; ++k) sum += a[i] * t->correlation[i][k] * b[k];
    return sum;
}

/*
 * The variance as a U-statistic over pairs of repeats. Its own variance: that of the linear term,
 * 4 dᵀρΣρd/n, and that of the quadratic one, 2 tr(ρΣρΣ)/(n(n-1)), which is what is left where no
 * effect is resolved.
 */
static void find_deviation(const repeats *r, const double *means, mcv_propagated *found) {
    const mcv_tolerances *t = r->tolerances;
    const double n = (double)r->count;
    double off[2][MCV_DESIGN_PARAMETERS], linear = 0, quadratic = 0, noise = 0;
    for (size_t a = 0; a < r->count; ++a)
        for (size_t b = 0; b < r->count; ++b) {
            for (size_t i = 0; i < t->count; ++i) {
                off[0][i] = r->rows[a * r->columns + effect(i)] - means[i];
                off[1][i] = r->rows[b * r->columns + effect(i)] - means[i];
            }
            const double both = form(t, off[0], off[1]) / (n - 1);
            quadratic += both * both;
            if (a != b) continue;
            noise += both;
            const double along = form(t, means, off[0]);
            linear += along * along / (n - 1);
        }
    const double variance = form(t, means, means) - noise / n,
                 half = r->t * sqrt(4 * linear / n + 2 * quadratic / (n * (n - 1)));
    found->linear = (mcv_bounded){sqrt(fmax(0, variance)), sqrt(fmax(0, variance - half)),
                                  sqrt(fmax(0, variance + half))};
    for (size_t i = 0; i < t->count; ++i) {
        double row = 0;
        for (size_t k = 0; k < t->count; ++k) row += t->correlation[i][k] * means[k];
        found->effects[i].share = variance > half ? means[i] * row / variance : NAN;
    }
}

static void find_effects(const repeats *r, size_t signs, mcv_propagated *found) {
    const size_t k = r->tolerances->count;
    /* One of all these tests is wrong in 5 % of the cases (Bonferroni). */
    const double t = mcv_student_quantile(0.05 / (double)(k + signs), (double)r->count - 1);
    double means[MCV_DESIGN_PARAMETERS], squares = 0;
    for (size_t i = 0; i < k; ++i) {
        mcv_effect *e = found->effects + i;
        e->effect = means[i] = mean_of(r, effect(i));
        e->effect_error = error_of(r, effect(i));
        e->curvature = mean_of(r, curvature(r, i));
        e->curvature_error = error_of(r, curvature(r, i));
        e->resolved = fabs(e->effect) > r->t * e->effect_error;
        squares += means[i] * means[i];
    }
    const double all = of_all * sqrt(squares);
    for (size_t i = 0; i < k; ++i) {
        mcv_effect *e = found->effects + i;
        e->curved = fabs(e->curvature) >
                    fmax(fmax(of_effect * fabs(e->effect), all), t * e->curvature_error);
    }
    for (size_t v = 0; v < signs; ++v) {
        const size_t column = interaction(r, v);
        found->interacts =
            found->interacts ||
            fabs(mean_of(r, column)) > fmax(of_effect * sqrt(squares), t * error_of(r, column));
    }
    find_deviation(r, means, found);
}

mcv_result mcv_propagate_first_order(const mcv_propagation *p, const double *points, size_t stride,
                                     mcv_propagated *found, mcv_error *error) {
    const size_t per = mcv_propagation_repeat(p), signs = mcv_propagation_signs(p);
    repeats r = {
        .tolerances = p->tolerances, .columns = 1 + 2 * p->tolerances->count + signs, .rows = NULL};
    r.rows = malloc(p->repeats * r.columns * sizeof *r.rows);
    if (!r.rows) return mcv_fail(error, MCV_FAILED, "no memory for %zu repeats", p->repeats);
    for (size_t i = 0; i < p->repeats; ++i)
        r.count +=
            take_repeat(p, points + i * per * stride, stride, &r, r.rows + r.count * r.columns);
    found->repeats = r.count;
    if (r.count > 1) {
        r.t = mcv_student_quantile(0.05, (double)r.count - 1);
        found->nominal = mean_of(&r, 0);
        found->nominal_error = error_of(&r, 0);
        find_effects(&r, signs, found);
    }
    free(r.rows);
    return MCV_OK;
}
