/* SPDX-License-Identifier: Apache-2.0 */
#include "statistics/hit_miss.h"

#include "statistics/distributions.h"

#include <math.h>
#include <string.h>

/* The likelihood of the curve with this logit at this x, with this slope; and its derivatives by
 * logit and slope. The place may be any: 0 for the intercept. */
typedef struct curve {
    double value;
    double gradient[2];
    double information[3]; /* by logit twice, both, slope twice */
} curve;

/* ln(1 + exp(t)) without overflow. */
static double softplus(double t) { return t > 0 ? t + log1p(exp(-t)) : log1p(exp(t)); }

static curve evaluate(const mcv_hit_miss *fit, double place, double logit, double slope) {
    curve c;
    memset(&c, 0, sizeof c);
    for (size_t i = 0; i < fit->count; ++i) {
        const double off = fit->x[i] - place, t = logit + slope * off;
        const double p = 1 / (1 + exp(-t)), weight = p / (1 + exp(t));
        c.value += fit->hit[i] * t - softplus(t);
        c.gradient[0] += fit->hit[i] - p;
        c.gradient[1] += (fit->hit[i] - p) * off;
        c.information[0] += weight;
        c.information[1] += weight * off;
        c.information[2] += weight * off * off;
    }
    return c;
}

static double determinant(const curve *c) {
    return c->information[0] * c->information[2] - c->information[1] * c->information[1];
}

/* The likelihood, with Firth's penalty if asked for. The determinant is that for any place. */
static double penalised(const mcv_hit_miss *fit, const curve *c) {
    return fit->penalised ? c->value + 0.5 * log(determinant(c)) : c->value;
}

/* Firth's score adds h(1/2 - p) for each x, h the leverage. */
static void add_penalty(const mcv_hit_miss *fit, double place, double logit, double slope,
                        curve *c) {
    const double d = determinant(c);
    for (size_t i = 0; i < fit->count; ++i) {
        const double off = fit->x[i] - place, t = logit + slope * off;
        const double p = 1 / (1 + exp(-t)), weight = p / (1 + exp(t));
        const double leverage =
            weight *
            (c->information[2] - 2 * off * c->information[1] + off * off * c->information[0]) / d;
        c->gradient[0] += leverage * (0.5 - p);
        c->gradient[1] += leverage * (0.5 - p) * off;
    }
}

/* Newton's way up to the largest likelihood: over both parameters or, with `fixed`, over the slope
 * alone. Steps are halved until they climb. */
static double maximise(const mcv_hit_miss *fit, double place, double *logit, double *slope,
                       bool fixed) {
    curve c = evaluate(fit, place, *logit, *slope);
    double best = penalised(fit, &c);
    for (int i = 0; i < 100; ++i) {
        if (fit->penalised) add_penalty(fit, place, *logit, *slope, &c);
        const double *g = c.gradient, *h = c.information, d = determinant(&c);
        const double up = fixed ? 0 : (h[2] * g[0] - h[1] * g[1]) / d;
        const double steeper = fixed ? g[1] / h[2] : (h[0] * g[1] - h[1] * g[0]) / d;
        const double gain = up * g[0] + steeper * g[1];
        double share = 1;
        for (; share > 1e-9; share /= 2) {
            c = evaluate(fit, place, *logit + share * up, *slope + share * steeper);
            if (penalised(fit, &c) > best) break;
        }
        if (!(gain > 1e-12) || !(share > 1e-9)) break;
        *logit += share * up;
        *slope += share * steeper;
        best = penalised(fit, &c);
    }
    return best;
}

/* Whether some x parts hits from misses, or only one x has both. */
static bool is_separated(const mcv_hit_miss *fit) {
    double low[2] = {INFINITY, INFINITY}, high[2] = {-INFINITY, -INFINITY};
    for (size_t i = 0; i < fit->count; ++i) {
        const int hit = fit->hit[i] > 0;
        low[hit] = fmin(low[hit], fit->x[i]);
        high[hit] = fmax(high[hit], fit->x[i]);
    }
    return high[0] <= low[1] || high[1] <= low[0];
}

mcv_result mcv_hit_miss_fit(const double *x, const double *hit, size_t count, mcv_hit_miss *fit,
                            mcv_error *error) {
    size_t hits = 0;
    double mean = 0;
    *fit = (mcv_hit_miss){.x = x, .hit = hit, .count = count};
    for (size_t i = 0; i < count; ++i) {
        hits += hit[i] > 0;
        mean += x[i] / (double)count;
    }
    if (hits == 0 || hits == count)
        return mcv_fail(error, MCV_BAD_INPUT,
                        "all %zu defects are %s: give %s sizes, so that some are %s", count,
                        hits ? "hits" : "misses", hits ? "smaller" : "larger",
                        hits ? "missed" : "found");
    fit->penalised = is_separated(fit);
    /* About the middle of x both parameters are all but independent. */
    double logit = log((double)hits / (double)(count - hits)), slope = 0;
    fit->log_likelihood = maximise(fit, mean, &logit, &slope, false);
    fit->slope = slope;
    fit->intercept = logit - slope * mean;
    return MCV_OK;
}

double mcv_hit_miss_pod(const mcv_hit_miss *fit, double x) {
    return 1 / (1 + exp(-fit->intercept - fit->slope * x));
}

double mcv_hit_miss_confidence(const mcv_hit_miss *fit, double x, double p) {
    double logit = log(p / (1 - p)), slope = fit->slope;
    const double there = fit->intercept + fit->slope * x;
    const double ratio = 2 * (fit->log_likelihood - maximise(fit, x, &logit, &slope, true));
    const double root = sqrt(fmax(0, ratio));
    return mcv_normal_cdf(there > logit ? root : -root);
}
