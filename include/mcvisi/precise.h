/* SPDX-License-Identifier: Apache-2.0 */
/* What kernels need in double to intersect smooth surfaces precisely (kernels/geometry/precise.h).
 * They read the float tables beside it. */
#ifndef MCVISI_PRECISE_H
#define MCVISI_PRECISE_H

#include "mcvisi/surfaces/surfaces.h"

/* mcv_device_cap in double. */
typedef struct mcv_precise_cap {
    double z;         /* of the vertex, in the solid's frame [m] */
    double curvature; /* c [1/m] */
    double conic;     /* k */
    double scale;     /* 1/(r of the side)² [1/m²] */
    double term[MCV_ASPHERE_TERMS];
} mcv_precise_cap;
MCV_ASSERT_SIZE(mcv_precise_cap, 96);

/* mcv_device_solid in double. */
typedef struct mcv_precise_solid {
    double origin[3]; /* of the frame [m] */
    double axes[9];   /* x, y, z of the frame, unit */
    double radius;    /* of the side [m] */
    double extent[2]; /* of a box: half its size along x and y [m] */
    double padding;
    mcv_precise_cap cap[2];
} mcv_precise_solid;
MCV_ASSERT_SIZE(mcv_precise_solid, 320);

#endif
