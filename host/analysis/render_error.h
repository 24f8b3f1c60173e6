/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The render's own error of grey values, for files that have no room for it pixel by pixel: the
 * header of PNG and TIFF (mcv_render_error of scene/camera_model.h).
 *
 * Each cell of the image has two errors, for pixels below and above the middle of its grey values,
 * so that a contour may run through it. At the contour the error is larger: of a pixel's samples a
 * share c sees one side, and the variance goes with c (1 - c). So does (largest - value)(value -
 * smallest) of the 3 x 3 pixels about it, to which what quiet pixels do not have is given.
 * Sums of variances over the pixels of either side of a cell are those of the pixels, to the
 * rounding of the header.
 */
#ifndef MCVISI_HOST_ANALYSIS_RENDER_ERROR_H
#define MCVISI_HOST_ANALYSIS_RENDER_ERROR_H

#include "analysis/region.h"
#include "scene/camera_model.h"

/* Of whole grey values and their standard errors [DN], of the same size; `shared` is the
 * correlation of channels. MCV_FAILED without memory. */
mcv_result mcv_render_error_of(const mcv_image *grey, const mcv_image *errors,
                               const mcv_correlation *correlation, double shared, double freedom,
                               mcv_render_error *out, mcv_error *error);

/* The errors of grey values of the same channels, in an image made here. MCV_FAILED without memory.
 */
mcv_result mcv_render_error_image(const mcv_render_error *told, const mcv_image *grey,
                                  mcv_image *out, mcv_error *error);

#endif
