/* SPDX-License-Identifier: Apache-2.0 */
/* The first surface on a ray, of triangles and exact ones. */
#ifndef MCVISI_KERNELS_CLOSEST_H
#define MCVISI_KERNELS_CLOSEST_H

#include "geometry/surface.h"
#if MCV_WITH_SURFACES
#include "geometry/solids.h"
#endif

#if MCV_WITH_SURFACES
/* Where to look for triangles: one at the same distance as an exact surface comes first. */
MCV_FUNCTION float mcv_just_beyond(mcv_hit exact) {
    return exact.t < INFINITY ? as_float(as_uint(exact.t) + 1u) : exact.t;
}

#if MCV_TILE
/* Does a ray meet a box before it ends? Margins as in kernels/traverse/bvh8.h. */
MCV_LOOP_FUNCTION int mcv_hits_box(const float *low, const float *high, float extent,
                                   mcv_vec3 origin, mcv_vec3 direction, float end) {
    const float o[3] = {origin.x, origin.y, origin.z};
    const float d[3] = {direction.x, direction.y, direction.z};
    const float x = mcv_abs(d[0]), y = mcv_abs(d[1]), z = mcv_abs(d[2]);
    const float a = mcv_abs(o[0]), b = mcv_abs(o[1]), c = mcv_abs(o[2]);
    const float least = (x > y ? (x > z ? x : z) : y > z ? y : z) * 0x1p-64f;
    const float margin = 32.0f * MCV_UNIT_ROUNDOFF *
                         ((a > b   ? (a > c ? a : c)
                           : b > c ? b
                                   : c) +
                          extent);
    float enter = 0.0f, exit = end;
#pragma unroll
    for (int axis = 0; axis < 3; ++axis) {
        const float inverse = 1.0f / (mcv_abs(d[axis]) < least ? least : d[axis]);
        const float spread = margin * mcv_abs(inverse);
        const float first = low[axis] * inverse - o[axis] * inverse,
                    second = high[axis] * inverse - o[axis] * inverse;
        const float near = (first < second ? first : second) - spread,
                    far = (first < second ? second : first) + spread;
        enter = near > enter ? near : enter;
        exit = far < exit ? far : exit;
    }
    return (low[0] <= high[0]) & (enter <= exit);
}
#endif
#endif

/* The closest hit of a ray that has left `left` (mcv_mark_origin_surface). */
MCV_FUNCTION mcv_hit mcv_closest(mcv_world world, mcv_vec3 origin, mcv_vec3 direction,
                                 uint origin_surface) {
#if MCV_WITH_SURFACES
    const mcv_hit exact =
        mcv_intersect_solids(world, origin, direction, origin_surface, mcv_miss(INFINITY));
    const mcv_hit hit = mcv_intersect_closest_ray(world.nodes, world.leaves, origin, direction,
                                                  mcv_just_beyond(exact));
    return hit.triangle != MCV_NONE ? hit : exact;
#else
    (void)origin_surface;
    return mcv_intersect_closest_ray(world.nodes, world.leaves, origin, direction, INFINITY);
#endif
}

/* The closest hit within a way, in its lengths: t is 1 at its end. */
MCV_FUNCTION mcv_hit mcv_closest_within(mcv_world world, mcv_vec3 origin, mcv_vec3 way,
                                        uint origin_surface) {
    const mcv_hit hit = mcv_intersect_closest_ray(world.nodes, world.leaves, origin, way, 1.0f);
#if MCV_WITH_SURFACES
    return mcv_intersect_solids_along(world, origin, way, origin_surface, hit);
#else
    (void)origin_surface;
    return hit;
#endif
}

#endif
