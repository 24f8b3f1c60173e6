/* SPDX-License-Identifier: Apache-2.0 */
/* Rectangles of pixels in which edges, lines, circles and widths are looked for. */
#ifndef MCVISI_HOST_ANALYSIS_BOX_H
#define MCVISI_HOST_ANALYSIS_BOX_H

#include "analysis/region.h"

typedef struct mcv_pixel_box {
    uint32_t x, y, width, height; /* of the top-left pixel, and how many [pixel] */
} mcv_pixel_box;

/*
 * Reads up to `most` places from "[NAME=]PLACE[+PLACE…]", where a place is X,Y,W,H in whole pixels.
 * Without a name it is called by its number. `what` ("edge") and the text stand in messages.
 * MCV_USAGE where a place is none, has less than 8 pixels a side, reaches outside the image, or
 * where there are too many.
 */
mcv_result mcv_boxes_parse(const char *what, const char *text, size_t number,
                           const mcv_image *image, size_t most, char name[64], mcv_pixel_box *boxes,
                           size_t *count, mcv_error *error);

#endif
