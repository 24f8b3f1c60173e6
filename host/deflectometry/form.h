/* SPDX-License-Identifier: Apache-2.0 */
/* The form of a part: what is taken from its heights and slopes, so that waviness and defects
 * remain. */
#ifndef MCVISI_HOST_DEFLECTOMETRY_FORM_H
#define MCVISI_HOST_DEFLECTOMETRY_FORM_H

#include "deflectometry/shape.h"

enum { MCV_FORM_NONE, MCV_FORM_PLANE, MCV_FORM_QUADRIC };

/* z = a + p x + q y + (xx x² + 2 xy x y + yy y²)/2 about the node's origin. */
typedef struct mcv_form {
    double height;       /* a [m] */
    double slope[2];     /* p, q */
    double curvature[3]; /* xx, xy, yy [1/m]; of a plane 0 */
} mcv_form;

/*
 * The best form through the heights of all valid pixels, weighted equally: MCV_FORM_PLANE or
 * MCV_FORM_QUADRIC. Pixels that lie on a line (of a quadric: on a conic) have none: the form is
 * then 0.
 */
mcv_form mcv_form_fit(const mcv_shape *shape, int kind);

/* Takes it from heights and slopes. */
void mcv_form_take(const mcv_form *form, mcv_shape *shape);

#endif
