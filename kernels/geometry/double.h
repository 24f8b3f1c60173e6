/* SPDX-License-Identifier: Apache-2.0 */
/* Three-vectors of double, and rays whose double is kept as a float and what rounding leaves of it:
 * 48 bits. */
#ifndef MCVISI_KERNELS_DOUBLE_H
#define MCVISI_KERNELS_DOUBLE_H

#include "mcvisi/vector.h"

#if MCV_WITH_MIXED
typedef struct mcv_dvec {
    double x, y, z;
} mcv_dvec;

typedef struct mcv_precise_ray {
    mcv_dvec origin, direction; /* unit */
} mcv_precise_ray;

MCV_LOOP_FUNCTION mcv_dvec mcv_dvec_of(double x, double y, double z) {
    mcv_dvec v;
    v.x = x;
    v.y = y;
    v.z = z;
    return v;
}

MCV_LOOP_FUNCTION mcv_dvec mcv_widen(mcv_vec3 v) {
    return mcv_dvec_of((double)v.x, (double)v.y, (double)v.z);
}
MCV_LOOP_FUNCTION mcv_vec3 mcv_narrow(mcv_dvec v) {
    return mcv_vec((float)v.x, (float)v.y, (float)v.z);
}

MCV_LOOP_FUNCTION mcv_dvec mcv_add_d(mcv_dvec a, mcv_dvec b) {
    return mcv_dvec_of(a.x + b.x, a.y + b.y, a.z + b.z);
}
MCV_LOOP_FUNCTION mcv_dvec mcv_sub_d(mcv_dvec a, mcv_dvec b) {
    return mcv_dvec_of(a.x - b.x, a.y - b.y, a.z - b.z);
}
MCV_LOOP_FUNCTION mcv_dvec mcv_scale_d(mcv_dvec a, double s) {
    return mcv_dvec_of(a.x * s, a.y * s, a.z * s);
}
MCV_LOOP_FUNCTION double mcv_dot_d(mcv_dvec a, mcv_dvec b) {
    return fma(a.x, b.x, fma(a.y, b.y, a.z * b.z));
}

/* a + s b */
MCV_LOOP_FUNCTION mcv_dvec mcv_along_d(mcv_dvec a, double s, mcv_dvec b) {
    return mcv_dvec_of(fma(s, b.x, a.x), fma(s, b.y, a.y), fma(s, b.z, a.z));
}

MCV_LOOP_FUNCTION mcv_dvec mcv_cross_d(mcv_dvec a, mcv_dvec b) {
    return mcv_dvec_of(fma(a.y, b.z, -a.z * b.y), fma(a.z, b.x, -a.x * b.z),
                       fma(a.x, b.y, -a.y * b.x));
}

/* The zero vector stays as it is. */
MCV_LOOP_FUNCTION mcv_dvec mcv_normalize_d(mcv_dvec v) {
    const double squared = mcv_dot_d(v, v);
    return mcv_scale_d(v, squared > 0.0 ? 1.0 / sqrt(squared) : 1.0);
}

/* A double from its float and the low word; and the low word of a double beside a float, perhaps of
 * another place. */
MCV_LOOP_FUNCTION mcv_dvec mcv_whole(mcv_vec3 v, mcv_vec3 low) {
    return mcv_add_d(mcv_widen(v), mcv_widen(low));
}
MCV_LOOP_FUNCTION mcv_vec3 mcv_low_of(mcv_dvec whole, mcv_vec3 v) {
    return mcv_narrow(mcv_sub_d(whole, mcv_widen(v)));
}
#endif

#endif
