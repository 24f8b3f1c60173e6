/* SPDX-License-Identifier: Apache-2.0 */
#include "statistics/pod_size.h"

#include "statistics/distributions.h"

#include <math.h>

static double scaled(const mcv_pod *pod, double size) { return pod->log_size ? log(size) : size; }

static double pod_of(const mcv_pod *pod, double x) {
    return pod->data.signals ? mcv_response_pod(&pod->response, x)
                             : mcv_hit_miss_pod(&pod->hit_miss, x);
}

static double confidence_of(const mcv_pod *pod, double x, double p) {
    return pod->data.signals ? mcv_response_confidence(&pod->response, x, p)
                             : mcv_hit_miss_confidence(&pod->hit_miss, x, p);
}

static double slope_of(const mcv_pod *pod) {
    return pod->data.signals ? pod->response.slope : pod->hit_miss.slope;
}

static bool is_too_few(const mcv_pod *pod) {
    if (pod->data.signals) return false;
    size_t hits = 0;
    for (size_t i = 0; i < pod->data.count; ++i) hits += pod->data.hits[i] > 0;
    return pod->data.count < MCV_POD_LEAST_DEFECTS || hits < MCV_POD_LEAST_OF_EACH ||
           pod->data.count - hits < MCV_POD_LEAST_OF_EACH;
}

/* Whether x is at or above the size looked for. */
static bool reaches(const mcv_pod *pod, double x, double p, double confidence) {
    return isnan(confidence) ? pod_of(pod, x) >= p : confidence_of(pod, x, p) >= confidence;
}

/* The smallest tested size that reaches; with a confidence of NaN, of the curve itself. A bound
 * may fall again far from the data: a coarse walk comes first. */
static double find(const mcv_pod *pod, double p, double confidence, mcv_pod_known *known) {
    enum { COARSE = 24 };
    const double from = scaled(pod, pod->smallest), to = scaled(pod, pod->largest);
    double low = from, high = from;
    if (reaches(pod, from, p, confidence)) {
        *known = MCV_POD_SMALLER;
        return pod->smallest;
    }
    for (int i = 1; i <= COARSE; ++i) {
        low = high;
        high = from + i * (to - from) / COARSE;
        if (reaches(pod, high, p, confidence)) break;
        if (i < COARSE) continue;
        *known = MCV_POD_LARGER;
        return NAN;
    }
    for (int i = 0; i < 40; ++i) {
        const double middle = 0.5 * (low + high);
        if (reaches(pod, middle, p, confidence)) {
            high = middle;
        } else {
            low = middle;
        }
    }
    *known = MCV_POD_FOUND;
    return pod->log_size ? exp(high) : high;
}

mcv_pod_size mcv_pod_find_size(const mcv_pod *pod, double probability) {
    mcv_pod_size s = {.probability = probability, .value = NAN, .low = NAN, .high = NAN};
    const double c = pod->data.confidence;
    const bool too_few = is_too_few(pod), falling = !too_few && !(slope_of(pod) > 0);
    s.value_known = s.low_known = s.high_known = falling ? MCV_POD_FALLING : MCV_POD_TOO_FEW;
    if (falling || too_few) return s;
    s.value = find(pod, probability, NAN, &s.value_known);
    s.low = find(pod, probability, 1 - c, &s.low_known);
    s.high = find(pod, probability, c, &s.high_known);
    return s;
}

/* The p for which the confidence that the POD is above it is this. */
static double bound(const mcv_pod *pod, double x, double confidence) {
    double low = -9, high = 9; /* as quantiles of the normal distribution */
    for (int i = 0; i < 40; ++i) {
        const double middle = 0.5 * (low + high);
        if (confidence_of(pod, x, mcv_normal_cdf(middle)) >= confidence) {
            low = middle;
        } else {
            high = middle;
        }
    }
    return mcv_normal_cdf(0.5 * (low + high));
}

mcv_pod_point mcv_pod_at(const mcv_pod *pod, double size) {
    const double x = scaled(pod, size), c = pod->data.confidence;
    if (!pod->fitted) return (mcv_pod_point){NAN, NAN, NAN};
    if (is_too_few(pod)) return (mcv_pod_point){pod_of(pod, x), NAN, NAN};
    return (mcv_pod_point){pod_of(pod, x), bound(pod, x, c), bound(pod, x, 1 - c)};
}
