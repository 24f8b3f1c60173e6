/* SPDX-License-Identifier: Apache-2.0 */
/* GGX microfacets of one roughness, in double; α along the tangent and across, or the same. The
 * tables of multiple scattering (multiple.h) are computed from them. */
#ifndef MCVISI_HOST_DEVICE_MICROSURFACE_H
#define MCVISI_HOST_DEVICE_MICROSURFACE_H

#include <math.h>
#include <stdint.h>

#include "mcvisi/materials/microfacet.h"

/* Smith's Λ, by the square of α times the direction's slope. */
static inline double mcv_smith_of(double slope) { return 0.5 * (sqrt(1 + slope) - 1); }

/* Smith's Λ of a direction, by its cosine from either side. */
static inline double mcv_smith(double alpha, double cosine) {
    return mcv_smith_of(alpha * alpha * (1 - cosine * cosine) / (cosine * cosine));
}

/* Where α depends on the azimuth. */
static inline double mcv_smith_at(const double alpha[2], const double w[3]) {
    const double x = alpha[0] * w[0], y = alpha[1] * w[1], z = fmax(fabs(w[2]), 1e-12);
    return mcv_smith_of((x * x + y * y) / (z * z));
}

/* D of a microfacet whose normal, stretched by 1/α, has this squared length. */
static inline double mcv_facet_density_of(const double alpha[2], double squared) {
    return 1 / (3.14159265358979323846 * alpha[0] * alpha[1] * squared * squared);
}

/* D of a microfacet, by the square of its normal's cosine. */
static inline double mcv_facet_density(double alpha, double h_z_squared) {
    return mcv_facet_density_of((const double[2]){alpha, alpha},
                                (1 - h_z_squared) / (alpha * alpha) + h_z_squared);
}

/* D of the microfacet that reflects from a to b; 0 if there is none. */
static inline double mcv_facet_between(const double alpha[2], const double a[3],
                                       const double b[3]) {
    const double x = a[0] + b[0], y = a[1] + b[1], z = a[2] + b[2];
    const double squared = x * x + y * y + z * z, u = x / alpha[0], v = y / alpha[1];
    return z > 0 && squared > 1e-20 ? mcv_facet_density_of(alpha, (u * u + v * v + z * z) / squared)
                                    : 0;
}

/* The area of visible microfacets, over that of the surface, from a direction above or below. */
static inline double mcv_visible_area(const double alpha[2], const double w[3]) {
    const double z = fmax(fabs(w[2]), 1e-12), l = mcv_smith_at(alpha, w);
    return w[2] > 0 ? z * (1 + l) : z * l;
}

/*
 * The direction w into which a visible microfacet reflects light from o, which may come from below.
 * It corresponds to mcv_ggx_sample with radius² = 1 - left². *c gets the cosine of incidence, h the
 * normal.
 */
static inline void mcv_reflect_by_facet(const double alpha[2], const double o[3], double left,
                                        const double turn[2], double w[3], double *c, double h[3]) {
    double s[3] = {alpha[0] * o[0], alpha[1] * o[1], o[2]};
    const double length = sqrt(s[0] * s[0] + s[1] * s[1] + s[2] * s[2]);
    for (int k = 0; k < 3; ++k) s[k] /= length;
    const double z = left * left * (1 + s[2]), q = 1 + s[2] - z,
                 around = sqrt(fmax(q * (2 - q), 0));
    h[0] = alpha[0] * (around * turn[0] + s[0]);
    h[1] = alpha[1] * (around * turn[1] + s[1]);
    h[2] = fmax(z, 1e-150);
    const double size = sqrt(h[0] * h[0] + h[1] * h[1] + h[2] * h[2]);
    for (int k = 0; k < 3; ++k) h[k] /= size;
    *c = fmin(fmax(o[0] * h[0] + o[1] * h[1] + o[2] * h[2], 0), 1);
    for (int k = 0; k < 3; ++k) w[k] = 2 * *c * h[k] - o[k];
}

/*
 * Positions in a table of `cosines` rows or columns (kernels/bsdf/microfacet.h): from position to
 * cosine, and back. The grazing one is a limit.
 */
static inline double mcv_multiple_cosine(uint32_t place, uint32_t cosines) {
    const double x = (double)place / (cosines - 1), rest = 1 - x;
    return fmax(x * x / (x * x + rest * rest), 1e-3);
}

static inline double mcv_multiple_place(double cosine, uint32_t cosines) {
    const double root = sqrt(cosine), rest = sqrt(fmax(1 - cosine, 0));
    return root / (root + rest) * (cosines - 1);
}

/*
 * Between two directions, whose cosines have that sum, the cosine of half the angle between the
 * azimuths for an entry, and back.
 */
static inline double mcv_multiple_half(uint32_t entry, double sum) {
    const double t = (double)entry / (MCV_MULTIPLE_AZIMUTHS - 1), k = sum + MCV_MULTIPLE_LEAST;
    return k * t / (1 + k - t);
}

static inline double mcv_multiple_entry(double half, double sum) {
    const double k = sum + MCV_MULTIPLE_LEAST;
    return half * (1 + k) / (half + k) * (MCV_MULTIPLE_AZIMUTHS - 1);
}

#endif
