/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Images of a light field camera: M·J x N·K pixels, J x K for each macro pixel; angular = {J, K}.
 * Pixel (j, k) of a macro pixel sees through the position (j, k) of the lens, upright, with row 0
 * on top.
 */
#ifndef MCVISI_HOST_ANALYSIS_LIGHTFIELD_H
#define MCVISI_HOST_ANALYSIS_LIGHTFIELD_H

#include "analysis/emd.h"
#include "film/film.h"

/*
 * Checks that the image is a valid one: whole macro pixels, no NaN or infinity, not all dark.
 * MCV_BAD_INPUT with a sentence that names path. The functions below require it.
 */
mcv_result mcv_light_field_check(const char *path, const mcv_image *image,
                                 const uint32_t angular[2], mcv_error *error);

/*
 * The sub-aperture views, J x K images of M x N pixels side by side. The view through the lens's
 * upper left corner is in the upper left corner. Keeps the channels.
 */
mcv_result mcv_light_field_views(const mcv_image *image, const uint32_t angular[2],
                                 mcv_image *views, mcv_error *error);

/* The image of a plain camera: the sum over each macro pixel and the channels, M x N. */
mcv_result mcv_light_field_plain(const mcv_image *image, const uint32_t angular[2],
                                 mcv_image *plain, mcv_error *error);

/*
 * The Earth Mover's gradient, M x N: ½ √(d_x² + d_y²). d_x and d_y are the distances (emd.h, in
 * fractions of the pupil) between the macro pixels left and right, above and below. The border has
 * no neighbours and is NaN. Histograms are sums over channels; negative values from noise count as
 * 0. They are divided by the median mass of the non-empty macro pixels, one number per image, which
 * affects only the form `mass`. Any number of threads (0: one per core) gives the same bits.
 *
 * After J. Meyer, T. Längle, J. Beyerer, About the acquisition and processing of ray deflection
 * histograms for transparent object inspection, Irish Machine Vision and Image Processing
 * Conference 2016, and section 5 of the report.
 */
mcv_result mcv_light_field_gradient(const mcv_image *image, const uint32_t angular[2],
                                    mcv_emd_form form, uint32_t threads, mcv_image *gradient,
                                    mcv_error *error);

/*
 * The noise floor of the gradient, M x N: what it would be in the mean if neighbours had the same
 * histogram, as the distance of two noisy histograms of the same light is not 0. `errors`: the
 * standard errors of the image's values, taken as normal and independent. It is the mean of some
 * draws about the common histogram of the neighbours: 0.313 √(1/n₁ + 1/n₂) of the width for one
 * uniform row of n rays each. The same bits for any number of threads.
 */
mcv_result mcv_light_field_floor(const mcv_image *image, const mcv_image *errors,
                                 const uint32_t angular[2], mcv_emd_form form, uint32_t threads,
                                 mcv_image *noise_floor, mcv_error *error);

#endif
