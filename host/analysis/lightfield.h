/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Images of a light field camera: M·J x N·K pixels, each macro pixel J x K of them, angular = {J,
 * K}. Pixel (j, k) of a macro pixel sees through the place (j, k) of the lens, upright and row 0 on
 * top, as everywhere.
 */
#ifndef MCVISI_HOST_ANALYSIS_LIGHTFIELD_H
#define MCVISI_HOST_ANALYSIS_LIGHTFIELD_H

#include "analysis/emd.h"
#include "film/film.h"

/*
 * Whether the image can be one: whole macro pixels, no NaN or infinity, light somewhere.
 * MCV_BAD_INPUT with a sentence that names path. The functions below ask it of their input.
 */
mcv_result mcv_light_field_check(const char *path, const mcv_image *image,
                                 const uint32_t angular[2], mcv_error *error);

/*
 * The sub-aperture views, J x K images of M x N pixels side by side: the view through the lens's
 * upper left corner stands in the upper left corner. Keeps the channels.
 */
mcv_result mcv_light_field_views(const mcv_image *image, const uint32_t angular[2],
                                 mcv_image *views, mcv_error *error);

/* What a plain camera would see: the sum over each macro pixel and the channels, M x N. */
mcv_result mcv_light_field_plain(const mcv_image *image, const uint32_t angular[2],
                                 mcv_image *plain, mcv_error *error);

/*
 * The Earth Mover's gradient, M x N: ½ √(d_x² + d_y²) with d_x and d_y the distances (emd.h, in
 * fractions of the pupil) of the macro pixels left and right of, above and below each one. The
 * border, which lacks a neighbour, is NaN. Histograms are the sums over channels (what noise made
 * negative counts as 0), divided by the median mass of the macro pixels that are not empty: one
 * number for the image, which only the form `mass` feels. Any number of threads (0: one per core)
 * gives the same bits.
 *
 * After J. Meyer, T. Längle, J. Beyerer, About the acquisition and processing of ray deflection
 * histograms for transparent object inspection, Irish Machine Vision and Image Processing
 * Conference 2016, and section 5 of the report.
 */
mcv_result mcv_light_field_gradient(const mcv_image *image, const uint32_t angular[2],
                                    mcv_emd_form form, uint32_t threads, mcv_image *gradient,
                                    mcv_error *error);

#endif
