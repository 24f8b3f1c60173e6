/* SPDX-License-Identifier: Apache-2.0 */
/* Which direction of light an entry of a light transport matrix stands for. */
#ifndef MCVISI_HOST_TRANSPORT_DIRECTIONS_H
#define MCVISI_HOST_TRANSPORT_DIRECTIONS_H

#include "transport/matrix.h"

typedef struct mcv_directions {
    const mcv_matrix *matrix;
    const mcv_element_group *group; /* the light field emitter; NULL: a light field camera */
    uint32_t width, height;         /* places */
    uint32_t bins[2];               /* J, K */
    double *slopes;             /* owned; [bin][x, y], of camera bins at a place in the middle */
    double middle[2], pitch[2]; /* of a camera's places: the slope changes from place to place */
    double full;                /* the value of a place that sees the emitter alone; NaN: not
                                   known */
} mcv_directions;

/* Reads it from the matrix's header. MCV_BAD_INPUT with a sentence where it tells no directions. */
mcv_result mcv_directions_of(const mcv_matrix *matrix, mcv_directions *directions,
                             mcv_error *error);
void mcv_directions_free(mcv_directions *directions);

/* The slope of a bin at the place (column, row). */
void mcv_directions_slope(const mcv_directions *directions, uint32_t column, uint32_t row,
                          uint32_t bin, double slope[2]);

/* The light at a place by direction and replicate, [bin][replicate], for a white light field
 * emitter, or for the pattern of the scene; the mean of the channels. */
void mcv_directions_light(const mcv_directions *directions, uint32_t column, uint32_t row,
                          double *light);

#endif
