/* SPDX-License-Identifier: Apache-2.0 */
/* PNG: a preview of a radiance image, and plain grey values of 8 or 16 bits. */
#ifndef MCVISI_HOST_IO_PNG_H
#define MCVISI_HOST_IO_PNG_H

#include "film/film.h"

#include <stdbool.h>

/* How a preview maps values to grey: `white` is the value shown as white, `saturated` the share of
 * pixels with a channel above it. */
typedef struct mcv_preview {
    double white, saturated;
} mcv_preview;

/*
 * The white level of a preview: the 99.5 % quantile of all finite values, so that few highlights do
 * not darken the rest; the largest finite value where the quantile is not above 0 (a small spot on
 * black), 1 for an image without light.
 */
double mcv_preview_white(const mcv_image *image);

/* A share of white as an 8-bit sRGB code (IEC 61966-2-1), clipped to [0, 1]; NaN is black. */
uint8_t mcv_srgb_of(double share);

/*
 * Writes an image of 1 or 3 channels as 8-bit grey or RGB: value / white clipped to [0, 1] and sRGB
 * encoded (IEC 61966-2-1). NaN is black, +∞ white. preview->white > 0 is used as given; otherwise
 * mcv_preview_white chooses, and both fields are set. The level is written as the text "White
 * level", with its unit ("W/(m^2 sr)").
 */
mcv_result mcv_png_write_preview(const char *path, const mcv_image *image, const char *unit,
                                 mcv_preview *preview, mcv_error *error);

/*
 * Writes grey values as they are, linear, in `bits` = 8 or 16: an image of 1 or 3 channels (grey or
 * RGB) of whole numbers from 0 to 2^bits - 1; others are rounded and clipped.
 */
mcv_result mcv_png_write_values(const char *path, const mcv_image *image, int bits,
                                mcv_error *error);

/* Reads the values of a PNG of 8 or 16 bits (fewer bits and palettes are widened to 8), grey or
 * RGB; alpha is left out. */
bool mcv_png_is_srgb(const char *path); /* whether a .png file says that its values are coded for
                                           the eye, as previews are */
mcv_result mcv_png_read_values(const char *path, mcv_image *image, mcv_error *error);

#endif
