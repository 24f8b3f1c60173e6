/* SPDX-License-Identifier: Apache-2.0 */
/* Speckle in an image of light, from a picture of the laser's light alone at sub-pixels. */
#ifndef MCVISI_HOST_ANALYSIS_READ_SPECKLE_H
#define MCVISI_HOST_ANALYSIS_READ_SPECKLE_H

#include "analysis/read_out.h"
#include "scene/aperture.h"

/* In the header of a picture that lasers of one wavelength alone have lit: that and the largest of
 * their widths [m]. */
#define MCV_LASER_WAVELENGTH "mcvisi:laserWavelength"
#define MCV_LASER_LINEWIDTH "mcvisi:laserLinewidth"
/* In that of grey values: the contrast of the field's speckle. */
#define MCV_SPECKLE_CONTRAST "mcvisi:speckleContrast"

/* What of the stop is open, by the header; `path` is for messages, and `mask` keeps the cells of
 * one. MCV_BAD_INPUT for what is no shape, or a mask without cells. */
mcv_result mcv_exr_aperture(const char *path, const mcv_exr *exr, mcv_aperture_shape *aperture,
                            mcv_mask *mask, mcv_error *error);

/*
 * Adds speckle to the first part, which the lens has blurred: the settings name the picture of the
 * laser's light (analysis/speckle.h). *contrast gets that of the field, 0 without speckle.
 * MCV_BAD_INPUT where that picture holds other light, or its pixels are not enough for the grains.
 * `path` is for messages.
 */
mcv_result mcv_camera_add_speckle(const mcv_camera_settings *settings, const char *path,
                                  mcv_exr *exr, double *contrast, mcv_error *error);

#endif
