/* SPDX-License-Identifier: Apache-2.0 */
/* Microfacets of the reference renderer: what its tables (reference/gloss_tables.c) and its lobes
 * (reference/gloss.c) share. */
#ifndef MCVISI_HOST_REFERENCE_GLOSS_MICROFACET_H
#define MCVISI_HOST_REFERENCE_GLOSS_MICROFACET_H

#include <math.h>
#include <stdbool.h>

#include "reference/interface.h"
#include "reference/vector.h"
#include "scene/materials.h"

/* A smaller α is taken as this (docs/limitations.md). */
static const double ref_least_alpha = 1e-3;

static inline void ref_alphas(const mcv_roughness *roughness, double share, double alpha[2]) {
    const double r = roughness->roughness * share, s = roughness->anisotropy;
    alpha[1] = fmax(r * r, ref_least_alpha);
    alpha[0] = alpha[1] + (1 - alpha[1]) * s * s;
}

/* Smith's Λ, with the roughness at the direction's azimuth. */
static inline double ref_lambda(const double alpha[2], ref_vec w) {
    const double slope = hypot(alpha[0] * w.x, alpha[1] * w.y) / fabs(w.z);
    return (sqrt(1 + slope * slope) - 1) / 2;
}

/*
 * The masking of two directions with these Λ: the mean visibility from both over the heights of the
 * microfacets. On opposite sides, what is high for one direction is low for the other (Heitz and
 * others 2016).
 */
static inline double ref_masking(double a, double b, bool opposite) {
    return opposite ? exp(lgamma(1 + a) + lgamma(1 + b) - lgamma(2 + a + b)) : 1 / (1 + a + b);
}

static inline double ref_ggx(const double alpha[2], ref_vec h) {
    const double x = h.x / (alpha[0] * h.z), y = h.y / (alpha[1] * h.z), t = 1 + x * x + y * y;
    return 1 / (M_PI * alpha[0] * alpha[1] * pow(h.z, 4) * t * t);
}

static inline ref_vec ref_reflected(ref_vec o, ref_vec h) {
    return ref_sub(ref_scale(2 * ref_dot(o, h), h), o);
}

/* False: total reflection. */
static inline bool ref_refracted(ref_vec o, ref_vec h, double ratio, ref_vec *i) {
    const ref_vec along = ref_scale(-ratio, ref_sub(o, ref_scale(ref_dot(o, h), h)));
    const double squared = ref_dot(along, along);
    if (squared >= 1) return false;
    *i = ref_sub(along, ref_scale(sqrt(1 - squared), h));
    return true;
}

static inline double ref_unpolarised(double from, double to, double cosine) {
    double s, p;
    ref_fresnel(from, to, fmin(cosine, 1), &s, &p);
    return (s + p) / 2;
}

#endif
