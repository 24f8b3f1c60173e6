/* SPDX-License-Identifier: Apache-2.0 */
/* The first surface on a ray, of triangles and exact ones. */
#ifndef MCVISI_KERNELS_CLOSEST_H
#define MCVISI_KERNELS_CLOSEST_H

#include "geometry/surface.h"
#include "traverse/bvh8.h"
#if MCV_WITH_SURFACES
#include "geometry/solids.h"

/* Where to look for triangles: one at the same distance as an exact surface comes first. */
MCV_FUNCTION float mcv_just_beyond(mcv_hit exact) {
    return exact.t < INFINITY ? as_float(as_uint(exact.t) + 1u) : exact.t;
}
#endif

#if MCV_WITH_MOVING
/* The hit, or that on a moving part which is closer. */
MCV_FUNCTION mcv_hit mcv_closest_moving(mcv_world world, mcv_vec3 origin, mcv_vec3 direction,
                                        mcv_hit hit) {
    MCV_CONSTANT const mcv_rigid_motion *motion = &world.frame->part_motion;
    const mcv_hit moving = mcv_intersect_closest_ray(
        world.nodes + world.frame->moving_nodes, world.leaves + world.frame->moving_leaves,
        mcv_point_at_rest(motion, world.pose, origin),
        mcv_direction_at_rest(motion, world.pose, direction), hit.t);
    return moving.primitive != MCV_NONE ? moving : hit;
}

/* Whether a moving part is hit with 0 < t < t_max. */
MCV_FUNCTION int mcv_moving_part_blocks(mcv_world world, mcv_vec3 origin, mcv_vec3 direction,
                                        float t_max) {
    MCV_CONSTANT const mcv_rigid_motion *motion = &world.frame->part_motion;
    return mcv_intersect_any_ray(world.nodes + world.frame->moving_nodes,
                                 world.leaves + world.frame->moving_leaves,
                                 mcv_point_at_rest(motion, world.pose, origin),
                                 mcv_direction_at_rest(motion, world.pose, direction), t_max);
}
#endif

/* The closest hit of a ray that starts on an exact surface, or not (mcv_mark_origin_surface). */
MCV_FUNCTION mcv_hit mcv_closest(mcv_world world, mcv_vec3 origin, mcv_vec3 direction,
                                 uint origin_surface) {
#if MCV_WITH_SURFACES
    const mcv_hit exact =
        mcv_intersect_solids(world, origin, direction, origin_surface, mcv_miss(INFINITY));
    mcv_hit hit = mcv_intersect_closest_ray(world.nodes, world.leaves, origin, direction,
                                            mcv_just_beyond(exact));
    if (hit.primitive == MCV_NONE) hit = exact;
#else
    mcv_hit hit = mcv_intersect_closest_ray(world.nodes, world.leaves, origin, direction, INFINITY);
    (void)origin_surface;
#endif
#if MCV_WITH_MOVING
    hit = mcv_closest_moving(world, origin, direction, hit);
#endif
    return hit;
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
