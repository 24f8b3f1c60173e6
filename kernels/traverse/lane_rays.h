/* SPDX-License-Identifier: Apache-2.0 */
/* As many rays as registers have lanes, against one triangle: the arithmetic of one ray against the
 * triangles of a leaf (traverse/triangle.h), so the same bits. */
#ifndef MCVISI_KERNELS_LANE_RAYS_H
#define MCVISI_KERNELS_LANE_RAYS_H

#include "traverse/rows.h"
#include "traverse/triangle.h"

/* Rays, and what they have hit so far. */
typedef struct mcv_lanes {
    mcv_lane_shear shear;
    mcv_floats t, b, c, det; /* as of mcv_intersect_lanes */
    mcv_uints primitive;
} mcv_lanes;

/* One row of the given rays; neighbours: they follow each other. */
#define MCV_TAKE_LANES(row, step, numbers, neighbours, lanes) \
    do { \
        if (neighbours) { \
            (lanes) = mcv_load_lanes((row) + (numbers)[0]); \
        } else { \
            uint mcv_taken[MCV_LANES]; \
            /* Unrolled, or the compiler makes a loop of gathers, which are slower. */ \
            _Pragma("unroll") for (uint mcv_lane = 0; mcv_lane < MCV_LANES; ++mcv_lane) \
                mcv_taken[mcv_lane] = (row)[(numbers)[mcv_lane] * (step)]; \
            (lanes) = mcv_load_lanes(mcv_taken); \
        } \
    } while (0)

/* Whether the numbers of the rays follow each other. */
static inline int mcv_are_neighbours(const uint *numbers) {
    uint apart = 0;
    for (uint i = 0; i < MCV_LANES; ++i) apart |= numbers[i] ^ (numbers[0] + i);
    return apart == 0;
}

/* mcv_ray_setup of the rays of these numbers. */
MCV_LOOP_FUNCTION void mcv_lanes_setup(mcv_rows origins, mcv_rows directions, const uint *numbers,
                                       int neighbours, float extent, mcv_lane_slabs *slabs,
                                       mcv_lanes *rays) {
    mcv_floats o[3], d[3];
#pragma unroll
    for (uint k = 0; k < 3; ++k) {
        mcv_uints origin, direction;
        MCV_TAKE_LANES(origins.base + k * origins.component, origins.step, numbers, neighbours,
                       origin);
        MCV_TAKE_LANES(directions.base + k * directions.component, directions.step, numbers,
                       neighbours, direction);
        o[k] = mcv_as_floats(origin);
        d[k] = mcv_as_floats(direction);
    }
    mcv_setup_lanes(o, d, extent, slabs, &rays->shear);
}

/* A coordinate of the rays' axes. */
#define MCV_AXIS(if_z, if_y, if_x) \
    MCV_MAIN(shear, (mcv_floats)(if_z), (mcv_floats)(if_y), (mcv_floats)(if_x))

/* A triangle of a leaf: its first coordinate. */
#define MCV_CORNERS_OF(leaf, lane) ((__global const float *)(leaf)->vertex + (lane))

/*
 * One triangle of a leaf against all rays; of a ray that has hit t is -1 where any hit will do.
 * Returns those that have hit, one bit each.
 */
MCV_LOOP_FUNCTION uint mcv_lanes_hit(__global const float *corners, uint number, int any,
                                     mcv_lanes *rays) {
    const mcv_uints triangle = (mcv_uints)(number);
    const mcv_lane_shear *shear = &rays->shear;
    mcv_floats x[3], y[3], z[3], t, b, c, det;
    mcv_ints met;
#pragma unroll
    for (int corner = 0; corner < 3; ++corner) {
        __global const float *v = corners + 3 * MCV_LEAF_TRIANGLES * corner;
        const float p = v[0], q = v[MCV_LEAF_TRIANGLES], r = v[2 * MCV_LEAF_TRIANGLES];
        z[corner] = MCV_AXIS(r, q, p) - shear->origin[2];
        x[corner] = fma(-shear->slope[0], z[corner], MCV_AXIS(p, r, q) - shear->origin[0]);
        y[corner] = fma(-shear->slope[1], z[corner], MCV_AXIS(q, p, r) - shear->origin[1]);
    }
    if (!mcv_intersect_lanes(x, y, z, shear->slope[0], shear->slope[1], shear->scale, rays->t, &met,
                             &t, &b, &c, &det))
        return 0;
    if (any) {
        met &= t < rays->t;
        rays->primitive = met ? triangle : rays->primitive;
        rays->t = met ? (mcv_floats)(-1.0f) : rays->t;
        return mcv_mask_lanes(met);
    }
    met &= (t < rays->t) |
           ((t == rays->t) & (rays->primitive != MCV_NONE) & (triangle < rays->primitive));
    rays->t = met ? t : rays->t;
    rays->b = met ? b : rays->b;
    rays->c = met ? c : rays->c;
    rays->det = met ? det : rays->det;
    rays->primitive = met ? triangle : rays->primitive;
    return mcv_mask_lanes(met);
}

#endif
