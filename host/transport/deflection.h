/* SPDX-License-Identifier: Apache-2.0 */
/*
 * How a part turns light aside: at each place of an image the histogram of the light's directions,
 * from a light transport matrix. Two kinds of matrices tell directions:
 *
 *     a light field emitter    its elements are directions; a place is a pixel of the sensor
 *     a light field camera     its pixels are directions; a place is a macro pixel
 *
 * Directions are slopes in the camera's axes (x right, y down), per length travelled towards the
 * camera. A deflection is the slope behind the part less the slope before it: -h/f at the height h
 * of a thin lens.
 *
 * After J. Meyer, T. Längle, J. Beyerer, About the acquisition and processing of ray deflection
 * histograms for transparent object inspection, Irish Machine Vision and Image Processing
 * Conference 2016.
 */
#ifndef MCVISI_HOST_TRANSPORT_DEFLECTION_H
#define MCVISI_HOST_TRANSPORT_DEFLECTION_H

#include "transport/matrix.h"

/* Images of one value per place, with their standard errors from the replicates (NaN of a single
 * one). NaN where a place has no light. */
typedef struct mcv_deflection {
    uint32_t width, height;                   /* places */
    uint32_t bins[2];                         /* J, K directions of a place */
    mcv_image mean, mean_error;               /* deflection, x and y */
    mcv_image covariance, covariance_error;   /* xx, xy, yy of the light's directions */
    mcv_image transmitted, transmitted_error; /* share of the light; NaN where it is not known */
    mcv_image histogram, histogram_error;     /* J·width x K·height: shares of a place's light */
} mcv_deflection;

/*
 * `reference`: the matrix of the same set-up without the part, or NULL. It gives the directions
 * that deflections are measured from, and the light that shares are of. Without it deflections are
 * measured from light parallel to the axis, and shares are known of images of radiance that light
 * field emitters light. Light beyond the bins is missing from `transmitted`, not in the bins at the
 * edge. MCV_BAD_INPUT for a matrix without directions or a reference of another size.
 */
mcv_result mcv_deflection_of(const mcv_matrix *matrix, const mcv_matrix *reference,
                             mcv_deflection *deflection, mcv_error *error);
void mcv_deflection_free(mcv_deflection *deflection);

#endif
