/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A circle, whole or in part, in a box of an image.
 *
 * Rows that cross it within 45° of its normal, and columns elsewhere, each give the place at which
 * an ideal step would hold the same light (analysis/edge.h). A spread of variance σ² (the blur's
 * and the pixel's 1/12) smooths the circle along the scan's own width, too, which shifts places
 * inwards by about σ²/(2R cos²): σ² is measured in the same pixels, and the circle's mean place
 * over such a spread is what the places are compared with. The circle is that of least squared
 * distances (geometric fit); places far off the others do not count.
 */
#ifndef MCVISI_HOST_ANALYSIS_CIRCLE_H
#define MCVISI_HOST_ANALYSIS_CIRCLE_H

#include "analysis/edge.h"

typedef struct mcv_circle {
    char name[64];
    mcv_pixel_box box;
    bool whole;               /* all of it must be in the box, else a part (an arc) */
    bool bright;              /* inside is the brighter side */
    mcv_quantity column, row; /* of the centre; 0, 0 is the image's top-left corner [pixel] */
    mcv_quantity radius;      /* [pixel] */
    mcv_quantity diameter;    /* [pixel] */
    mcv_quantity roundness;   /* root of the mean squared distance from the circle, without that of
                                 the noise [pixel] */
    double covariance[3][3];  /* of column, row and radius [pixel²] */
    double seen;              /* the share of the circumference that was measured */
    double rejected;          /* the share of the places found that do not count */
    double spread;            /* σ [pixel] */
} mcv_circle;

/* "[NAME=]X,Y,W,H", as mcv_boxes_parse() reads it. */
mcv_result mcv_circle_parse(const char *text, size_t number, const mcv_image *image, bool whole,
                            mcv_circle *circle, mcv_error *error);

/*
 * Finds the circle with the strongest edge; of circle the name, the box and `whole` are read; least
 * as for mcv_edge_locate(). MCV_FAILED says why there is none: no edge, too little room, a radius
 * too small for its blur, or an arc too short for a radius.
 */
mcv_result mcv_circle_locate(mcv_readings *readings, double least, mcv_circle *circle,
                             mcv_error *error);

/* From centre to centre [pixel]. */
mcv_quantity mcv_circle_distance(const mcv_circle *a, const mcv_circle *b);

/* From a line to the centre of a circle, along the line's normal; negative on the darker side of
 * the line [pixel]. */
mcv_quantity mcv_edge_to_circle(const mcv_edge *line, const mcv_circle *circle);

#endif
