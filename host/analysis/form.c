/* SPDX-License-Identifier: Apache-2.0 */
#include "analysis/form.h"

#include "analysis/statistics.h"

#include <math.h>

double mcv_noise_freedom(const double variances[2], const uint64_t differences[2]) {
    double squares = 0;
    for (int i = 0; i < 2; ++i)
        squares += variances[i] * variances[i] / mcv_roi_estimate_freedom(differences[i]);
    return squares > 0 ? pow(variances[0] + variances[1], 2) / squares : INFINITY;
}

double mcv_widening(double freedom) {
    return isfinite(freedom) ? mcv_student_quantile(0.05, freedom) / 1.959964 : 1;
}

/* The 95th percentile of χ² over its mean. */
static double reach_of(double freedom) {
    const double part = 2 / (9 * freedom);
    return pow(1 - part + 1.644854 * sqrt(part), 3);
}

mcv_quantity mcv_form_deviation(const mcv_scatter *s, double freedom) {
    const double signal = fmax(0, s->squares - s->noise) / s->count, noise = s->noise / s->count;
    const double variance =
        (s->variance + 2 * s->noise * s->noise / freedom) / (s->count * s->count);
    if (!(noise > 0)) return (mcv_quantity){sqrt(signal), 0};
    const double reach = noise * (reach_of(2 * noise * noise / variance) - 1);
    if (signal <= reach) return (mcv_quantity){sqrt(signal), sqrt(reach) / 1.9};
    const double slanted = (variance + s->crossed / (s->count * s->count)) / (4 * signal);
    return (mcv_quantity){
        sqrt(signal),
        sqrt(fmax(slanted, pow((sqrt(signal) - sqrt(signal - reach)) / 1.959964, 2)))};
}
