/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Heights from slopes by least squares. Between neighbouring pixels i and j with slopes (p, q) at
 * the places (x, y) the height changes by (p_i + p_j)/2 (x_j - x_i) + (q_i + q_j)/2 (y_j - y_i)
 * (W. H. Southwell, JOSA 70 (1980) 998, for places that need not lie on a grid). The normal
 * equations are solved by conjugate gradients, preconditioned by an incomplete Cholesky
 * factorisation that keeps the rows' sums (I. Gustafsson, BIT 18 (1978) 142).
 */
#ifndef MCVISI_HOST_DEFLECTOMETRY_HEIGHT_H
#define MCVISI_HOST_DEFLECTOMETRY_HEIGHT_H

#include "core/error.h"

#include <stdbool.h>
#include <stdint.h>

/* Slopes of a map of width x height pixels, row by row. */
typedef struct mcv_slope_map {
    uint32_t width, height;
    const bool *valid;
    const double *x, *y; /* places on the plane [m] */
    const double *p, *q; /* slopes along x and y */
} mcv_slope_map;

/*
 * heights [m]: on entry a guess, 0 for none. Each connected part of the map has the mean 0: slopes
 * do not tell more. Pixels that are not valid get 0. *residual (or NULL): root of the mean squared
 * difference between the changes of height and what the slopes say [m]. MCV_FAILED without memory.
 */
mcv_result mcv_heights_integrate(const mcv_slope_map *map, double *heights, double *residual,
                                 mcv_error *error);

#endif
