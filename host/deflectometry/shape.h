/* SPDX-License-Identifier: Apache-2.0 */
/* From decoded fringes to the slopes and heights of a mirroring part, with their uncertainties. */
#ifndef MCVISI_HOST_DEFLECTOMETRY_SHAPE_H
#define MCVISI_HOST_DEFLECTOMETRY_SHAPE_H

#include "deflectometry/fringes.h"
#include "deflectometry/slope.h"

typedef struct mcv_shape {
    uint32_t width, height;
    bool *valid;
    double *x, *y, *z;       /* places on the part in the node's axes [m]; z has no piston */
    double *p, *q;           /* slopes dz/dx and dz/dy [rad] */
    double *u_p, *u_q, *u_z; /* standard uncertainties */
    size_t valid_count;
    double residual; /* of the integration: slopes that are those of no surface [m] */
} mcv_shape;

/*
 * Slopes and heights from the places that the pixels show, across and down. The part lies about the
 * x-y plane of `plane`. Heights and the places that follow from them are found in turn: a part that
 * is curved lies off the plane, and its slopes there are others. The surface passes the node's
 * origin. Where the map has several connected parts, their mean heights are equal: slopes do not
 * tell more. Uncertainties of heights come from 8 draws of slopes with random errors.
 */
mcv_result mcv_shape_make(const mcv_camera_model *model, const mcv_screen_place *screen,
                          const mcv_transform *plane, const mcv_decoded *const places[2],
                          uint32_t width, uint32_t height, uint32_t seed, mcv_shape *shape,
                          mcv_error *error);

void mcv_shape_free(mcv_shape *shape);

#endif
