/* SPDX-License-Identifier: Apache-2.0 */
/* Affine transforms in double. */
#ifndef MCVISI_HOST_SCENE_TRANSFORM_H
#define MCVISI_HOST_SCENE_TRANSFORM_H

#include <stdbool.h>

/* Row-major affine map of points: world = m[0..8] p + m[9..11]. */
typedef struct mcv_transform {
    double m[12];
} mcv_transform;

void mcv_transform_point(const mcv_transform *transform, const double p[3], double out[3]);
void mcv_transform_vector(const mcv_transform *transform, const double v[3], double out[3]);
mcv_transform mcv_transform_compose(const mcv_transform *outer, const mcv_transform *inner);
mcv_transform mcv_transform_identity(void);

/* Negative where the transform mirrors. */
double mcv_transform_determinant(const mcv_transform *transform);

/* glTF: translation, unit quaternion (x, y, z, w), scale: T R S. */
mcv_transform mcv_transform_from_trs(const double translation[3], const double rotation[4],
                                     const double scale[3]);

/* A normal (not normalised): by the cofactors, with the sign that keeps it on its side of the
 * surface under mirroring. */
void mcv_transform_normal(const mcv_transform *transform, const double n[3], double out[3]);

/*
 * Rotation and translation without scale, shear and mirroring: keeps the direction of the z axis,
 * and of y as far as it is perpendicular to it. False where an axis has vanished.
 */
bool mcv_transform_rigid(const mcv_transform *transform, mcv_transform *rigid);

/* v / |v| without overflow or underflow; false (and out untouched) for the zero vector and what is
 * not finite. */
bool mcv_normalize3(const double v[3], double out[3]);
void mcv_cross3(const double a[3], const double b[3], double out[3]);

#endif
