/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Weights of the emitters, 0 or more, with which a light transport matrix makes a wanted image. An
 * emitter's weight multiplies its part of a pattern. Colours count by their mean.
 */
#ifndef MCVISI_HOST_TRANSPORT_FIT_H
#define MCVISI_HOST_TRANSPORT_FIT_H

#include "analysis/region.h"
#include "transport/matrix.h"

enum { MCV_FIT_MOST_EMITTERS = 4096 };

/*
 * The weights with which the pixels of a region are most alike: the least sum of their squared
 * distances from the region's mean under the pattern as it is.
 *
 * `weights` and `errors` have room for group_count numbers. errors: standard errors, from fits that
 * leave out a replicate each (the jackknife; B. Efron, The Jackknife, the Bootstrap and Other
 * Resampling Plans, 1982); NaN with one replicate. MCV_BAD_INPUT for a region without light.
 */
mcv_result mcv_fit_uniform(const mcv_matrix *matrix, const float *pattern, const mcv_roi *region,
                           double *weights, double *errors, mcv_error *error);

/*
 * The weights with which the mean of a region stands out most of a background: the largest |mean -
 * mean| over the deviation of the background's pixels, their noise included. The largest weight is
 * 1. It is Fisher's linear discriminant (1936) with weights that are not negative. MCV_BAD_INPUT
 * where no emitter makes a difference.
 */
mcv_result mcv_fit_contrast(const mcv_matrix *matrix, const float *pattern, const mcv_roi *region,
                            const mcv_roi *background, double *weights, double *errors,
                            mcv_error *error);

#endif
