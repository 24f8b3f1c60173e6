/* SPDX-License-Identifier: Apache-2.0 */
/* The first surface on a ray, of triangles and exact ones. */
#ifndef MCVISI_KERNELS_CLOSEST_H
#define MCVISI_KERNELS_CLOSEST_H

#include "surface.h"
#if MCV_WITH_SURFACES
#include "solids.h"
#endif

/* The closest hit of a ray that has left `left` (mcv_leave). */
MCV_FUNCTION mcv_hit mcv_closest(mcv_world world, mcv_vec3 origin, mcv_vec3 direction, uint left) {
    const mcv_hit hit = mcv_intersect_closest_ray(world.nodes, world.leaves, origin, direction, INFINITY);
#if MCV_WITH_SURFACES
    return mcv_meet_solids(world, origin, direction, left, hit);
#else
    (void)left;
    return hit;
#endif
}

/* The closest hit within a way, in its lengths: t is 1 at its end. */
MCV_FUNCTION mcv_hit mcv_closest_within(mcv_world world, mcv_vec3 origin, mcv_vec3 way, uint left) {
    const mcv_hit hit = mcv_intersect_closest_ray(world.nodes, world.leaves, origin, way, 1.0f);
#if MCV_WITH_SURFACES
    return mcv_meet_solids_along(world, origin, way, left, hit);
#else
    (void)left;
    return hit;
#endif
}

#endif
