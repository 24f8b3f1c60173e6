/* SPDX-License-Identifier: Apache-2.0 */
#include "uncertainty/tolerances.h"

#include "scene/params.h"

#include <lapacke.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const struct {
    const char *name;
    double deviation;
} kinds[] = {
#define MCV_X(NAME, name, deviation) {name, deviation},
    MCV_DISTRIBUTIONS(MCV_X)
#undef MCV_X
};

/* --- one distribution --- */

/* A number with or without a unit, up to a given character. */
static bool read_number(const char **at, char end, double *value) {
    const char *stop = strchr(*at, end);
    char copy[64], *rest;
    if (!stop || stop == *at || (size_t)(stop - *at) >= sizeof copy) return false;
    snprintf(copy, sizeof copy, "%.*s", (int)(stop - *at), *at);
    *at = stop + 1;
    if (copy[strspn(copy, "0123456789.eE+-")] == '\0') {
        *value = strtod(copy, &rest);
        return rest != copy && *rest == '\0' && isfinite(*value);
    }
    return mcv_parse_quantity(copy, MCV_PARAM_choice, value) && isfinite(*value);
}

mcv_result mcv_distribution_parse(const char *text, mcv_distribution *d, mcv_error *error) {
    const char *open = strchr(text, '('), *at = open ? open + 1 : text;
    *d = (mcv_distribution){.kind = MCV_DISTRIBUTION_COUNT, .centre = NAN};
    for (int i = 0; open && i < MCV_DISTRIBUTION_COUNT; ++i)
        if (strlen(kinds[i].name) == (size_t)(open - text) &&
            strncmp(kinds[i].name, text, (size_t)(open - text)) == 0)
            d->kind = i;
    bool read = d->kind < MCV_DISTRIBUTION_COUNT;
    if (read && strchr(at, ',')) read = read_number(&at, ',', &d->centre);
    if (!read || !read_number(&at, ')', &d->width) || *at)
        return mcv_fail(error, MCV_USAGE,
                        "\"%s\": must be normal(U), uniform(A) or triangular(A), or with the "
                        "centre, as in normal(25mm,0.1mm)",
                        text);
    if (!(d->width > 0)) return mcv_fail(error, MCV_USAGE, "\"%s\": must be wider than 0", text);
    return MCV_OK;
}

double mcv_distribution_deviation(const mcv_distribution *d) {
    return d->width * kinds[d->kind].deviation;
}

/* The value of a distribution about 0 of width 1. Probabilities above one half are those of the
 * other side, so that none is rounded to 1. */
static double standard_at(int kind, double score) {
    if (kind == MCV_DISTRIBUTION_NORMAL) return score;
    const double below = erfc(fabs(score) / M_SQRT2) / 2; /* P(Z < -|z|) */
    const double depth = kind == MCV_DISTRIBUTION_UNIFORM ? 1 - 2 * below : 1 - sqrt(2 * below);
    return copysign(depth, score);
}

double mcv_distribution_at(const mcv_distribution *d, double score) {
    return d->centre + d->width * standard_at(d->kind, score);
}

/* --- correlations --- */

/* The coefficient of two distributions whose scores have the coefficient r: the trapezoidal rule,
 * which is exact beyond doubles for a smooth function times the normal density. */
static double correlation_at(int a, int b, double r) {
    enum { STEPS = 96 };
    const double step = 16.0 / STEPS, rest = sqrt(1 - r * r);
    double sum = 0;
    for (int i = 0; i <= STEPS; ++i) {
        const double z = -8 + step * i, from = standard_at(a, z) * exp(-z * z / 2);
        for (int k = 0; k <= STEPS; ++k) {
            const double w = -8 + step * k;
            sum += from * standard_at(b, r * z + rest * w) * exp(-w * w / 2);
        }
    }
    return sum * step * step / (2 * M_PI) / (kinds[a].deviation * kinds[b].deviation);
}

/* The coefficient of the scores that gives one of the distributions; NaN: there is none. */
static double solve_correlation(int a, int b, double wanted) {
    double low = -1, high = 1;
    if (a == MCV_DISTRIBUTION_NORMAL && b == MCV_DISTRIBUTION_NORMAL) return wanted;
    if (wanted < correlation_at(a, b, low) || wanted > correlation_at(a, b, high)) return NAN;
    for (int i = 0; i < 40; ++i) {
        const double middle = (low + high) / 2;
        *(correlation_at(a, b, middle) < wanted ? &low : &high) = middle;
    }
    return (low + high) / 2;
}

static size_t find_name(const mcv_plan *plan, const char *name, size_t length) {
    size_t i = 0;
    while (i < plan->varied && !(strlen(plan->parameters[i].name) == length &&
                                 strncmp(plan->parameters[i].name, name, length) == 0))
        ++i;
    return i;
}

static mcv_result read_correlation(const mcv_plan *plan, const char *item, mcv_tolerances *t,
                                   double scores[][MCV_DESIGN_PARAMETERS], mcv_error *error) {
    const size_t first = strcspn(item, ","), equals = strcspn(item, "=");
    char *end = NULL;
    size_t a = plan->varied, b = plan->varied;
    double r = NAN;
    if (item[first] == ',' && item[equals] == '=' && first < equals) {
        a = find_name(plan, item, first);
        b = find_name(plan, item + first + 1, equals - first - 1);
        r = strtod(item + equals + 1, &end);
    }
    if (!end || end == item + equals + 1 || *end || !(fabs(r) < 1))
        return mcv_fail(error, MCV_USAGE,
                        "--correlate %s: must be A,B=R, two tolerances by name and a number "
                        "between -1 and 1",
                        item);
    if (a == plan->varied || b == plan->varied || a == b)
        return mcv_fail(error, MCV_USAGE,
                        "--correlate %s: must name two different tolerances, as %s", item,
                        plan->parameters[0].name);
    const double score = solve_correlation(t->of[a].kind, t->of[b].kind, r);
    if (isnan(score))
        return mcv_fail(error, MCV_USAGE,
                        "--correlate %s: these distributions cannot be so closely correlated",
                        item);
    t->correlation[a][b] = t->correlation[b][a] = r;
    scores[a][b] = scores[b][a] = score;
    return MCV_OK;
}

mcv_result mcv_tolerances_read(const mcv_plan *plan, mcv_texts correlate, mcv_tolerances *t,
                               mcv_error *error) {
    double scores[MCV_DESIGN_PARAMETERS][MCV_DESIGN_PARAMETERS] = {{0}};
    const lapack_int n = (lapack_int)plan->varied;
    *t = (mcv_tolerances){.count = plan->varied, .correlated = correlate.count > 0};
    for (size_t i = 0; i < t->count; ++i) {
        const mcv_parameter *p = plan->parameters + i;
        mcv_error detail = {""};
        const mcv_result result =
            mcv_distribution_parse(p->item + p->path_length + 1, t->of + i, &detail);
        if (result != MCV_OK)
            return mcv_fail(error, result, "--tolerance %s: %s", p->item, detail.text);
        t->correlation[i][i] = scores[i][i] = 1;
    }
    for (size_t i = 0; i < correlate.count; ++i)
        MCV_TRY(read_correlation(plan, correlate.items[i], t, scores, error));
    if (LAPACKE_dpotrf(LAPACK_ROW_MAJOR, 'L', n, scores[0], MCV_DESIGN_PARAMETERS) != 0)
        return mcv_fail(error, MCV_USAGE,
                        "--correlate: no parameters can have all of these coefficients together");
    for (size_t i = 0; i < t->count; ++i) memcpy(t->factor[i], scores[i], (i + 1) * sizeof(double));
    return MCV_OK;
}

void mcv_tolerances_draw(const mcv_tolerances *t, const double *scores, double *values) {
    for (size_t i = 0; i < t->count; ++i) {
        double score = 0;
        for (size_t k = 0; k <= i; ++k) score += t->factor[i][k] * scores[k];
        values[i] = mcv_distribution_at(t->of + i, score);
    }
}
