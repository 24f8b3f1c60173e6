/* SPDX-License-Identifier: Apache-2.0 */
/* Light that walks between the microfacets of an interface: what its table (multiple_interface.c)
 * is summed from; nothing else calls it. */
#ifndef MCVISI_HOST_DEVICE_MULTIPLE_WALKS_H
#define MCVISI_HOST_DEVICE_MULTIPLE_WALKS_H

#include <stdint.h>

#include "mcvisi/materials/microfacet.h"

enum { MCV_WALK_NODES = MCV_INTERFACE_COSINES, MCV_WALK_TURNS = MCV_INTERFACE_AZIMUTHS };

typedef struct mcv_walk_node {
    double cosine, sine, lambda;
} mcv_walk_node;

/* Values for each cosine of a direction on each side, and the angle between two azimuths. */
typedef double mcv_walk_goals[2][MCV_WALK_NODES][MCV_WALK_TURNS];

typedef struct mcv_walk_interface {
    double alpha, n[2], scale[2], offset[2]; /* scale, offset: of the coating (mcv_coat) */
    mcv_walk_node nodes[MCV_WALK_NODES];
    /* Of a row: directions of columns. */
    float x[MCV_WALK_NODES][MCV_WALK_NODES][MCV_WALK_TURNS],
        y[MCV_WALK_NODES][MCV_WALK_NODES][MCV_WALK_TURNS];
} mcv_walk_interface;

/*
 * Light that walks from the direction of a row on the side `start` until it leaves (Heitz and
 * others 2016): adds what each meeting but the first sends to the goals. Half the walks reflect
 * first, half refract. Returns the share that goes on after one meeting.
 */
double mcv_walk(const mcv_walk_interface *at, int start, uint32_t row, mcv_walk_goals sums);

#endif
