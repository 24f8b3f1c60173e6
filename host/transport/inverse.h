/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Patterns for which a flawless part looks even, so that a defect stands out: from the light
 * transport matrix T of the flawless part. Of the other emitters none shines.
 *
 *     replay         x = Tᵀ w with w = 1/(T Tᵀ 1): the light that the camera would send is sent
 * back least squares  min ‖T x - 1‖² + µ ‖x‖², x >= 0 dark field     1 where Tᵀ 1 is 0, else 0:
 * light that reaches no pixel
 *
 * After J. Meyer, R. Gruna, T. Längle, J. Beyerer, Simulation of an inverse schlieren image
 * acquisition system for inspecting transparent objects, Electronic Imaging 2016.
 */
#ifndef MCVISI_HOST_TRANSPORT_INVERSE_H
#define MCVISI_HOST_TRANSPORT_INVERSE_H

#include "transport/matrix.h"

typedef enum mcv_inverse_method {
    MCV_INVERSE_REPLAY,
    MCV_INVERSE_LEAST_SQUARES
} mcv_inverse_method;

typedef struct mcv_inverse {
    const mcv_element_group *group; /* the emitter that shows the pattern */
    mcv_inverse_method method;
    bool dark;      /* the complement: `method` is not used */
    double damping; /* µ over the mean of the squares of T's columns */
    uint32_t bits;  /* the emitter's; 0: any value */
} mcv_inverse;

/*
 * The pattern, one value from 0 to 1 for each pixel of the emitter (width x height of its group):
 * the largest is 1, before it is rounded to the emitter's bits. Colours count by their mean.
 * `deviation`: its standard errors, from patterns that leave out a replicate each; NaN with one.
 * They show in all images that are taken with the pattern, always the same. MCV_BAD_INPUT where the
 * emitter lights no pixel.
 */
mcv_result mcv_inverse_pattern(const mcv_matrix *matrix, const mcv_inverse *inverse,
                               mcv_image *pattern, mcv_image *deviation, mcv_error *error);

#endif
