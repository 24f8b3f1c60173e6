/* SPDX-License-Identifier: Apache-2.0 */
/* A straight line through the edges of several boxes, and the width between two opposite edges of
 * one. */
#ifndef MCVISI_HOST_ANALYSIS_LINE_H
#define MCVISI_HOST_ANALYSIS_LINE_H

#include "analysis/edge.h"

enum { MCV_LINE_BOXES = 64 };

/* Least squares through the places of all boxes' lines of pixels, each with the same weight. */
typedef struct mcv_line {
    mcv_edge edge; /* of it the name, point, normal, position, tilt; the point lies in the mean row
                      of all places */
    size_t box_count;
    mcv_pixel_box boxes[MCV_LINE_BOXES];
    mcv_quantity straightness; /* root of the mean squared distance from the line, along its normal,
                                  without that of the noise [pixel] */
} mcv_line;

/* "[NAME=]X,Y,W,H[+X,Y,W,H…]", as mcv_boxes_parse() reads it. */
mcv_result mcv_line_parse(const char *text, size_t number, const mcv_image *image, mcv_line *line,
                          mcv_error *error);

/* Of line the name and the boxes are read; least as for mcv_edge_locate(). MCV_FAILED where a box
 * holds no edge, or they do not agree. */
mcv_result mcv_line_locate(mcv_readings *readings, double least, mcv_line *line, mcv_error *error);

typedef struct mcv_caliper {
    char name[64];
    mcv_pixel_box box;
    mcv_edge edges[2];  /* in the order of columns or rows */
    mcv_quantity width; /* along the mean normal, through the points of the edges [pixel] */
    mcv_quantity angle; /* from the first edge to the second, 0: parallel [rad] */
} mcv_caliper;

mcv_result mcv_caliper_parse(const char *text, size_t number, const mcv_image *image,
                             mcv_caliper *caliper, mcv_error *error);

/* Of caliper the name and the box are read. MCV_FAILED where two opposite straight edges do not
 * cross the box's longer side. */
mcv_result mcv_caliper_locate(mcv_readings *readings, double least, mcv_caliper *caliper,
                              mcv_error *error);

#endif
