/* SPDX-License-Identifier: Apache-2.0 */
/* Colours for numbers. */
#ifndef MCVISI_HOST_IO_COLORMAP_H
#define MCVISI_HOST_IO_COLORMAP_H

#include <stdint.h>

/*
 * Grey from black to white, and viridis (S. van der Walt, N. Smith, 2015, CC0), as bright as the
 * value is large. Diverging: blue, white in the middle, red; for signed values.
 */
typedef enum mcv_colormap {
    MCV_COLORMAP_GREY,
    MCV_COLORMAP_VIRIDIS,
    MCV_COLORMAP_DIVERGING
} mcv_colormap;

/*
 * The sRGB colour of a position from 0 to 1, clipped to them, as 0xRRGGBB. Linear in the encoded
 * values between control colours: within 2/255 of viridis' own table of 256.
 */
uint32_t mcv_colormap_rgb(mcv_colormap map, double position);

#endif
