/* SPDX-License-Identifier: Apache-2.0 */
#include "statistics/response.h"

#include "analysis/noise.h"
#include "statistics/distributions.h"
#include "statistics/response_censored.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Least squares of the signals as they stand; for censored data first guesses. */
static void fit_line(mcv_response *fit) {
    const mcv_response_data *d = &fit->data;
    const double n = (double)d->count;
    double mean_x = 0, mean_y = 0, xx = 0, xy = 0, rest = 0;
    for (size_t i = 0; i < d->count; ++i) {
        mean_x += d->x[i] / n;
        mean_y += fmin(fmax(d->y[i], d->low), d->high) / n;
    }
    for (size_t i = 0; i < d->count; ++i) {
        const double y = fmin(fmax(d->y[i], d->low), d->high);
        xx += (d->x[i] - mean_x) * (d->x[i] - mean_x);
        xy += (d->x[i] - mean_x) * (y - mean_y);
    }
    fit->mean = mean_x;
    fit->squares = xx;
    fit->slope = xy / xx;
    fit->intercept = mean_y - fit->slope * mean_x;
    for (size_t i = 0; i < d->count; ++i) {
        const double y = fmin(fmax(d->y[i], d->low), d->high);
        const double r = y - fit->intercept - fit->slope * d->x[i];
        rest += r * r;
    }
    fit->scatter = sqrt(rest / (n - 2));
    fit->log_likelihood = -0.5 * n * (log(2 * M_PI * rest / n) + 1);
}

/* The scatter by maximum likelihood is too small; √(n/(n-2)) makes it that of least squares. */
static double widen(size_t count) { return sqrt((double)count / ((double)count - 2)); }

static bool fit_censored(mcv_response *fit) {
    double p[3] = {fit->intercept, fit->slope, fit->scatter};
    if (!mcv_response_censored_fit(&fit->data, p, &fit->log_likelihood)) return false;
    fit->intercept = p[0];
    fit->slope = p[1];
    fit->scatter = p[2] * widen(fit->data.count);
    return true;
}

/* Data of the fitted line, censored likewise, and their fit. A resample without one is left out:
 * *kept does not rise. */
static void resample(const mcv_response *fit, uint32_t number, double *y, size_t *kept) {
    const mcv_response_data *d = &fit->data;
    mcv_noise noise = mcv_noise_begin(d->seed, 0, number);
    for (size_t i = 0; i < d->count; ++i)
        y[i] = fit->intercept + fit->slope * d->x[i] + fit->scatter * mcv_noise_normal(&noise);
    mcv_response other = {.data = *d};
    other.data.y = y;
    double p[3] = {fit->intercept, fit->slope, fit->scatter / widen(d->count)}, likelihood;
    if (!mcv_response_censored_fit(&other.data, p, &likelihood)) return;
    p[2] *= widen(d->count);
    memcpy(fit->again[(*kept)++], p, sizeof p);
}

mcv_result mcv_response_resample(mcv_response *fit, mcv_error *error) {
    if (fit->lost + fit->saturated == 0) return MCV_OK;
    double *y = malloc(fit->data.count * sizeof *y);
    size_t kept = 0;
    fit->again = malloc(MCV_RESPONSE_RESAMPLES * sizeof *fit->again);
    if (!y || !fit->again) {
        free(y);
        return mcv_fail(error, MCV_FAILED, "no memory for the resamples");
    }
    for (uint32_t i = 0; i < 2 * MCV_RESPONSE_RESAMPLES && kept < MCV_RESPONSE_RESAMPLES; ++i)
        resample(fit, i, y, &kept);
    free(y);
    return kept == MCV_RESPONSE_RESAMPLES
               ? MCV_OK
               : mcv_fail(error, MCV_BAD_INPUT,
                          "too many signals are lost or saturated for a bound: %zu of %zu",
                          fit->lost + fit->saturated, fit->data.count);
}

mcv_result mcv_response_fit(const mcv_response_data *data, mcv_response *fit, mcv_error *error) {
    memset(fit, 0, sizeof *fit);
    fit->data = *data;
    for (size_t i = 0; i < data->count; ++i) {
        fit->lost += data->y[i] <= data->low;
        fit->saturated += data->y[i] >= data->high;
    }
    const size_t censored = fit->lost + fit->saturated;
    if (data->count < censored + MCV_RESPONSE_LEAST)
        return mcv_fail(error, MCV_BAD_INPUT,
                        "%zu signals are too few for a line: %d are needed that are neither lost "
                        "nor saturated",
                        data->count - censored, MCV_RESPONSE_LEAST);
    fit_line(fit);
    /* Roundings of the sums are no scatter. */
    if (!(fit->scatter > 1e-12 * fabs(fit->slope) * sqrt(fit->squares)))
        return mcv_fail(error, MCV_BAD_INPUT,
                        "the signals lie on a line without any scatter: there is nothing random "
                        "that a bound could hold");
    if (censored == 0) return MCV_OK;
    if (!fit_censored(fit))
        return mcv_fail(error, MCV_BAD_INPUT,
                        "no line fits %zu signals of which %zu are lost or saturated", data->count,
                        censored);
    return MCV_OK;
}

void mcv_response_free(mcv_response *fit) {
    free(fit->again);
    fit->again = NULL;
}

static double line(const mcv_response *fit, double x) { return fit->intercept + fit->slope * x; }

double mcv_response_pod(const mcv_response *fit, double x) {
    return mcv_normal_cdf((line(fit, x) - fit->data.threshold) / fit->scatter);
}

/* The share of resamples whose own bound would have been above the line that they come from. */
static double bootstrapped(const mcv_response *fit, double x, double p) {
    const double y = line(fit, x), t = (y - fit->data.threshold) / fit->scatter;
    const double true_quantile = y - mcv_normal_quantile(p) * fit->scatter;
    size_t below = 0;
    for (size_t i = 0; i < MCV_RESPONSE_RESAMPLES; ++i) {
        const double *again = fit->again[i];
        below += again[0] + again[1] * x - true_quantile <= t * again[2];
    }
    return (double)below / (MCV_RESPONSE_RESAMPLES + 1);
}

double mcv_response_confidence(const mcv_response *fit, double x, double p) {
    if (fit->again) return bootstrapped(fit, x, p);
    const double n = (double)fit->data.count, off = x - fit->mean;
    const double h = sqrt(1 / n + off * off / fit->squares);
    const double t = (line(fit, x) - fit->data.threshold) / (h * fit->scatter);
    return mcv_noncentral_t_cdf(t, n - 2, mcv_normal_quantile(p) / h);
}
