/* SPDX-License-Identifier: Apache-2.0 */
/* Vectors of three doubles. The prefix ref_ marks what is used in host/reference/ only. */
#ifndef MCVISI_HOST_REFERENCE_VECTOR_H
#define MCVISI_HOST_REFERENCE_VECTOR_H

#include <math.h>

typedef struct ref_vec {
    double x, y, z;
} ref_vec;

static inline ref_vec ref_add(ref_vec a, ref_vec b) {
    return (ref_vec){a.x + b.x, a.y + b.y, a.z + b.z};
}
static inline ref_vec ref_sub(ref_vec a, ref_vec b) {
    return (ref_vec){a.x - b.x, a.y - b.y, a.z - b.z};
}
static inline ref_vec ref_scale(double s, ref_vec a) {
    return (ref_vec){s * a.x, s * a.y, s * a.z};
}
static inline double ref_dot(ref_vec a, ref_vec b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
static inline ref_vec ref_cross(ref_vec a, ref_vec b) {
    return (ref_vec){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
static inline double ref_component(ref_vec v, int axis) {
    return axis == 0 ? v.x : axis == 1 ? v.y : v.z;
}
static inline double ref_length(ref_vec a) { return sqrt(ref_dot(a, a)); }
static inline ref_vec ref_unit(ref_vec a) { return ref_scale(1 / ref_length(a), a); }
static inline ref_vec ref_from(const double a[3]) { return (ref_vec){a[0], a[1], a[2]}; }

/* The angle between two vectors in [0, π], accurate to rounding, unlike an arc cosine. */
static inline double ref_angle(ref_vec a, ref_vec b) {
    return atan2(ref_length(ref_cross(a, b)), ref_dot(a, b));
}

/* Two unit vectors that complete the unit vector n to an orthogonal frame. */
static inline void ref_frame(ref_vec n, ref_vec *s, ref_vec *t) {
    const ref_vec off = fabs(n.x) < 0.5 ? (ref_vec){1, 0, 0} : (ref_vec){0, 1, 0};
    *s = ref_unit(ref_cross(off, n));
    *t = ref_cross(n, *s);
}

#endif
