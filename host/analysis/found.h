/* SPDX-License-Identifier: Apache-2.0 */
/* What is found in the boxes of an image: edges, lines, calipers, circles and arcs. */
#ifndef MCVISI_HOST_ANALYSIS_FOUND_H
#define MCVISI_HOST_ANALYSIS_FOUND_H

#include "analysis/circle.h"
#include "analysis/line.h"
#include "analysis/places.h"

/* Estimates the noise of a region where the readings' deviations are not known; rounding to whole
 * numbers alone makes 1/√12. */
void mcv_know_noise(mcv_readings *readings, bool known, bool whole, mcv_roi *region);

/* One that was found. */
typedef struct mcv_found {
    unsigned form;
    union {
        mcv_edge edge;
        mcv_line line;
        mcv_caliper caliper;
        mcv_circle circle; /* or arc */
    } as;
} mcv_found;

/* Finds what the text, a box or more, asks for; with its noise as above. MCV_FAILED for a curved
 * edge, too. */
mcv_result mcv_locate(mcv_readings *readings, bool known, bool whole, unsigned form,
                      const char *text, size_t number, mcv_found *found, mcv_error *error);
const char *mcv_found_name(const mcv_found *found);

/* The line of an edge or a line; NULL of others. */
const mcv_edge *mcv_found_straight(const mcv_found *found);
bool mcv_found_is_round(const mcv_found *found);

/*
 * From a to b, neither a caliper, a no circle unless b is one: in pixels, and the unit vector along
 * which it counts. NaN between edges and lines that are not parallel within 10°.
 */
#define MCV_NOT_PARALLEL "they are not parallel within 10°, so they have no distance"
mcv_quantity mcv_found_distance(const mcv_found *a, const mcv_found *b, double direction[2]);

/* Metres in the object for a pixel along a direction, or in every direction (NULL); NaN where that
 * is not known. */
double mcv_scale_along(const double pixel[2], const double direction[2]);

#endif
