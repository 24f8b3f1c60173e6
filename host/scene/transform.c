/* SPDX-License-Identifier: Apache-2.0 */
#include "scene/transform.h"

#include <math.h>
#include <string.h>

mcv_transform mcv_transform_identity(void) {
    return (mcv_transform){{1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0}};
}

void mcv_transform_vector(const mcv_transform *transform, const double v[3], double out[3]) {
    const double *m = transform->m;
    const double x = v[0], y = v[1], z = v[2];
    for (int i = 0; i < 3; ++i) out[i] = m[3 * i] * x + m[3 * i + 1] * y + m[3 * i + 2] * z;
}

void mcv_transform_point(const mcv_transform *transform, const double p[3], double out[3]) {
    mcv_transform_vector(transform, p, out);
    for (int i = 0; i < 3; ++i) out[i] += transform->m[9 + i];
}

mcv_transform mcv_transform_compose(const mcv_transform *outer, const mcv_transform *inner) {
    mcv_transform product;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) {
            double sum = 0;
            for (int k = 0; k < 3; ++k) sum += outer->m[3 * i + k] * inner->m[3 * k + j];
            product.m[3 * i + j] = sum;
        }
    mcv_transform_point(outer, inner->m + 9, product.m + 9);
    return product;
}

void mcv_cross3(const double a[3], const double b[3], double out[3]) {
    const double x = a[1] * b[2] - a[2] * b[1];
    const double y = a[2] * b[0] - a[0] * b[2];
    const double z = a[0] * b[1] - a[1] * b[0];
    out[0] = x;
    out[1] = y;
    out[2] = z;
}

bool mcv_normalize3(const double v[3], double out[3]) {
    const double length = hypot(hypot(v[0], v[1]), v[2]);
    if (!(length > 0) || !isfinite(length)) return false;
    /* By the largest power of two first: a subnormal length would leave few digits in the quotient.
     */
    int exponent;
    frexp(length, &exponent);
    double scaled[3];
    for (int i = 0; i < 3; ++i) scaled[i] = ldexp(v[i], -exponent);
    const double one = hypot(hypot(scaled[0], scaled[1]), scaled[2]);
    for (int i = 0; i < 3; ++i) out[i] = scaled[i] / one;
    return true;
}

double mcv_transform_determinant(const mcv_transform *transform) {
    double cross[3];
    mcv_cross3(transform->m, transform->m + 3, cross);
    return cross[0] * transform->m[6] + cross[1] * transform->m[7] + cross[2] * transform->m[8];
}

mcv_transform mcv_transform_from_trs(const double translation[3], const double rotation[4],
                                     const double scale[3]) {
    const double x = rotation[0], y = rotation[1], z = rotation[2], w = rotation[3];
    const double r[9] = {1 - 2 * (y * y + z * z), 2 * (x * y - z * w),     2 * (x * z + y * w),
                         2 * (x * y + z * w),     1 - 2 * (x * x + z * z), 2 * (y * z - x * w),
                         2 * (x * z - y * w),     2 * (y * z + x * w),     1 - 2 * (x * x + y * y)};
    mcv_transform transform;
    for (int i = 0; i < 9; ++i) transform.m[i] = r[i] * scale[i % 3];
    for (int i = 0; i < 3; ++i) transform.m[9 + i] = translation[i];
    return transform;
}

void mcv_transform_normal(const mcv_transform *transform, const double n[3], double out[3]) {
    const double *m = transform->m;
    const double sign = mcv_transform_determinant(transform) < 0 ? -1 : 1;
    double rows[3][3], result[3];
    mcv_cross3(m + 3, m + 6, rows[0]);
    mcv_cross3(m + 6, m, rows[1]);
    mcv_cross3(m, m + 3, rows[2]);
    for (int i = 0; i < 3; ++i)
        result[i] = sign * (rows[i][0] * n[0] + rows[i][1] * n[1] + rows[i][2] * n[2]);
    memcpy(out, result, sizeof result);
}

bool mcv_transform_rigid(const mcv_transform *transform, mcv_transform *rigid) {
    const double *m = transform->m;
    double x[3], y[3] = {m[1], m[4], m[7]}, z[3] = {m[2], m[5], m[8]};
    if (!mcv_normalize3(z, z) || !mcv_normalize3(y, y)) return false;
    mcv_cross3(y, z, x);
    if (!mcv_normalize3(x, x)) return false;
    mcv_cross3(z, x, y);
    *rigid =
        (mcv_transform){{x[0], y[0], z[0], x[1], y[1], z[1], x[2], y[2], z[2], m[9], m[10], m[11]}};
    return true;
}
