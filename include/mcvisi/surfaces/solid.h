/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Exact surfaces on the device. A solid is the intersection of three sets: the inside of a side
 * (cylinder, box or sphere about the z axis of its frame), the space above its first cap, and the
 * space below its second cap. Along a ray each set is an interval or the complement of one, so that
 * a ray that enters a solid also leaves it: rounding cannot make an edge leak. An open surface is
 * its first cap within the side. All solids of a lens share one frame.
 */
#ifndef MCVISI_SURFACES_SOLID_H
#define MCVISI_SURFACES_SOLID_H

#include "mcvisi/dialect.h"
#include "mcvisi/surfaces/surfaces.h"

enum { MCV_SIDE_CYLINDER, MCV_SIDE_BOX, MCV_SIDE_SPHERE, MCV_SIDE_OPEN };

/* The pieces of a solid's surface. The faces of a box along x and y are one piece, its side. */
enum { MCV_PIECE_FIRST_CAP, MCV_PIECE_SECOND_CAP, MCV_PIECE_SIDE, MCV_PIECE_COUNT };

/* Takes the place of a triangle's index: this bit, plus four times the solid's index, plus the
 * piece. It never equals MCV_NONE. */
#define MCV_EXACT 0x80000000u

MCV_LOOP_FUNCTION uint mcv_exact_hit(uint solid, uint piece) {
    return MCV_EXACT | 4u * solid | piece;
}
MCV_LOOP_FUNCTION uint mcv_solid_of(uint exact) { return (exact & ~MCV_EXACT) >> 2; }
MCV_LOOP_FUNCTION uint mcv_piece_of(uint exact) { return exact & 3u; }

/* A cap, as a surface of revolution or a cylindrical one. */
typedef struct mcv_device_cap {
    float z;         /* of the vertex, in the solid's frame [m] */
    float curvature; /* c [1/m] */
    float conic;     /* k */
    float across;    /* r² = across x² + y²: 0 for a cylindrical cap, else 1 */
    float bend;      /* of aspheres: bound of |d²z/dr²| and |dz/dr|/r within the side [1/m] */
    float scale;     /* 1/(r of the side)² [1/m²] */
    uint terms;      /* number of the asphere's terms */
    uint surface;    /* 4 · solid + piece of the first solid that has this cap */
    float term[MCV_ASPHERE_TERMS]; /* Σ term_i (scale r²)^(i + 2) [m] */
} mcv_device_cap;
MCV_ASSERT_SIZE(mcv_device_cap, 64);

typedef struct mcv_device_solid {
    float origin[3]; /* of the frame [m] */
    float bound;     /* radius of the ball about the origin that contains the solid [m] */
    float axes[9];   /* x, y, z of the frame, unit */
    float radius;    /* of the side [m] */
    float extent[2]; /* of a box: half its size along x and y [m] */
    float hole;      /* of an open surface: the radius of its hole [m] */
    uint side;       /* MCV_SIDE_… */
    uint group;      /* the first solid of the same lens */
    uint instance[MCV_PIECE_COUNT];
    uint convex; /* 1: a ray that leaves it outwards does not hit it again */
    uint padding;
    mcv_device_cap cap[2];
} mcv_device_solid;
MCV_ASSERT_SIZE(mcv_device_solid, 224);

#endif
