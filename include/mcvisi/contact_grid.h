/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Where surfaces of bodies come near each other: a grid of cells over the triangles of all bodies.
 * A cell has the set of the media (bit i: medium i + 1) whose triangles' boxes, widened by `reach`,
 * lie in it. What lies beyond the grid counts as in its outermost cells.
 */
#ifndef MCVISI_CONTACT_GRID_H
#define MCVISI_CONTACT_GRID_H

#include "mcvisi/dialect.h"

#define MCV_CONTACT_CELLS 64u /* along each axis */

typedef struct mcv_contact_grid {
    float low[3];   /* corner of the first cell [m] */
    float scale[3]; /* cells per length [1/m] */
    float reach;    /* [m] */
    uint padding;
    uint media[MCV_CONTACT_CELLS * MCV_CONTACT_CELLS * MCV_CONTACT_CELLS]; /* x runs fastest */
} mcv_contact_grid;

/* The cell along one axis that holds a coordinate x: it never falls where x rises. */
MCV_LOOP_FUNCTION uint mcv_contact_cell(float x, float low, float scale) {
    const float at = (x - low) * scale, most = (float)(MCV_CONTACT_CELLS - 1u);
    const float below = at < most ? at : most;
    return (uint)(below > 0.0f ? below : 0.0f);
}

#endif
