/* SPDX-License-Identifier: Apache-2.0 */
#include "statistics/pod.h"

#include "statistics/pod_size.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static mcv_result check(const mcv_pod_data *d, mcv_error *error) {
    for (size_t i = 0; i < d->count; ++i) {
        if (!(d->sizes[i] > 0) || isinf(d->sizes[i]))
            return mcv_fail(error, MCV_BAD_INPUT, "size %zu is %g: must be above 0", i + 1,
                            d->sizes[i]);
        if (d->signals && !isfinite(d->signals[i]))
            return mcv_fail(error, MCV_BAD_INPUT, "signal %zu is not a finite number", i + 1);
        if (!d->signals && d->hits[i] != 0 && d->hits[i] != 1)
            return mcv_fail(error, MCV_BAD_INPUT, "hit %zu is %g: must be 0 or 1", i + 1,
                            d->hits[i]);
    }
    return MCV_OK;
}

static double scaled(double value, bool log_scale) { return log_scale ? log(value) : value; }

/* What is fitted with the pod's scales. */
static mcv_response_data response_data(const mcv_pod *pod) {
    const mcv_pod_data *d = &pod->data;
    for (size_t i = 0; i < d->count; ++i) {
        const double s = fmin(fmax(d->signals[i], d->low), d->high); /* fmax(x, NaN) is x */
        pod->y[i] = scaled(s, pod->log_signal);
    }
    return (mcv_response_data){.x = pod->x,
                               .y = pod->y,
                               .count = d->count,
                               .threshold = scaled(d->threshold, pod->log_signal),
                               .low = isnan(d->low) ? -INFINITY : scaled(d->low, pod->log_signal),
                               .high = isnan(d->high) ? INFINITY : scaled(d->high, pod->log_signal),
                               .seed = d->seed};
}

/* Densities of logarithms are made those of the signals: ln s has the density s times that of s. */
static double jacobian(const mcv_pod *pod) {
    double sum = 0;
    for (size_t i = 0; i < pod->data.count && pod->log_signal; ++i) {
        const double s = pod->data.signals[i];
        if (!(s <= pod->data.low) && !(s >= pod->data.high)) sum -= log(s);
    }
    return sum;
}

static mcv_result fit_scales(mcv_pod *pod, mcv_error *error) {
    const mcv_pod_data *d = &pod->data;
    for (size_t i = 0; i < d->count; ++i) pod->x[i] = scaled(d->sizes[i], pod->log_size);
    if (!d->signals) {
        MCV_TRY(mcv_hit_miss_fit(pod->x, d->hits, d->count, &pod->hit_miss, error));
        pod->akaike = 4 - 2 * pod->hit_miss.log_likelihood;
        return MCV_OK;
    }
    mcv_response_free(&pod->response);
    const mcv_response_data data = response_data(pod);
    MCV_TRY(mcv_response_fit(&data, &pod->response, error));
    pod->akaike = 6 - 2 * (pod->response.log_likelihood + jacobian(pod));
    return MCV_OK;
}

/* Whether the signals, their limits and the threshold have logarithms. */
static bool has_logarithms(const mcv_pod_data *d) {
    if (!d->signals || !(d->threshold > 0) || d->low <= 0 || d->high <= 0) return false;
    for (size_t i = 0; i < d->count; ++i)
        if (!(d->signals[i] > 0) && !(d->low > 0)) return false;
    return true;
}

/* Takes the most likely of the scales. The last fit is done again, because there is room for one.
 */
static mcv_result choose_scales(mcv_pod *pod, mcv_error *error) {
    const mcv_pod_data *d = &pod->data;
    double best = INFINITY;
    int chosen = -1;
    mcv_error detail = {""};
    mcv_result result = MCV_OK, failed = MCV_OK;
    for (int k = 0; k < 4; ++k) {
        const bool log_size = k & 1, log_signal = k & 2;
        if (d->size_scale != MCV_POD_AUTO && log_size != (d->size_scale == MCV_POD_LOG)) continue;
        if (log_signal ? !has_logarithms(d) || d->signal_scale == MCV_POD_LINEAR
                       : d->signals && d->signal_scale == MCV_POD_LOG)
            continue;
        pod->log_size = log_size;
        pod->log_signal = log_signal;
        result = fit_scales(pod, &detail);
        if (result != MCV_OK) failed = result;
        if (result != MCV_OK || !(pod->akaike < best)) continue;
        best = pod->akaike;
        chosen = k;
    }
    if (chosen < 0 && failed == MCV_OK)
        return mcv_fail(error, MCV_BAD_INPUT,
                        "a logarithmic signal needs signals, limits and a threshold above 0");
    if (chosen < 0) return mcv_fail(error, failed, "%s", detail.text);
    pod->log_size = chosen & 1;
    pod->log_signal = chosen & 2;
    return fit_scales(pod, error);
}

static bool has_both(const mcv_pod_data *data) {
    for (size_t i = 1; i < data->count; ++i)
        if (data->hits[i] != data->hits[0]) return true;
    return false;
}

mcv_result mcv_pod_fit(const mcv_pod_data *data, mcv_pod *pod, mcv_error *error) {
    memset(pod, 0, sizeof *pod);
    pod->data = *data;
    if (data->count < MCV_RESPONSE_LEAST)
        return mcv_fail(error, MCV_BAD_INPUT, "%zu defects are too few: at least %d are needed",
                        data->count, MCV_RESPONSE_LEAST);
    MCV_TRY(check(data, error));
    pod->x = malloc(data->count * sizeof *pod->x);
    pod->y = malloc(data->count * sizeof *pod->y);
    if (!pod->x || !pod->y) return mcv_fail(error, MCV_FAILED, "no memory for the fit");
    pod->smallest = INFINITY;
    for (size_t i = 0; i < data->count; ++i) {
        pod->smallest = fmin(pod->smallest, data->sizes[i]);
        pod->largest = fmax(pod->largest, data->sizes[i]);
    }
    if (!(pod->largest > pod->smallest))
        return mcv_fail(error, MCV_BAD_INPUT, "all defects have one size: give several sizes");
    pod->fitted = data->signals || has_both(data);
    if (pod->fitted) MCV_TRY(choose_scales(pod, error));
    if (data->signals) MCV_TRY(mcv_response_resample(&pod->response, error));
    if (data->signals) MCV_TRY(mcv_response_check(&pod->response, &pod->checks, error));
    pod->a50 = mcv_pod_find_size(pod, 0.5);
    pod->a90 = mcv_pod_find_size(pod, 0.9);
    return MCV_OK;
}

void mcv_pod_free(mcv_pod *pod) {
    mcv_response_free(&pod->response);
    free(pod->x);
    free(pod->y);
    pod->x = pod->y = NULL;
}
