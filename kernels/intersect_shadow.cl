/* SPDX-License-Identifier: Apache-2.0 */
/* Stage: adds the light of a shadow ray that nothing blocks. reads shadow ray -> writes radiance */
#include "path.h"
#include "surface.h"

/* The light of the emitter at t arrives. */
static void mcv_add_shadow_light(mcv_world world, mcv_slot slot, float t) {
    mcv_color light;
    mcv_color radiance;
    MCV_LOAD_COLOR(slot, shadow_light, light);
#if MCV_WITH_ABSORPTION
    const mcv_vec3 direction = MCV_LOAD_3(slot, shadow_direction);
    light = mcv_tint(light, mcv_medium_transmittance(world, MCV_WORD(slot, media, 0), t * mcv_sqrt(mcv_dot(direction, direction))));
#else
    (void)world, (void)t;
#endif
    MCV_LOAD_COLOR(slot, radiance, radiance);
    MCV_EACH_CHANNEL(i) radiance.c[i] += light.c[i];
    MCV_STORE_COLOR(slot, radiance, radiance);
}

/* A ray without target ends at the emitter's point, t = 1; one with a target must meet it first. */
static int mcv_shadow_is_any(mcv_slot slot) { return MCV_WORD(slot, shadow_target, 0) == MCV_NONE; }

static int mcv_meets_target(mcv_world world, mcv_slot slot, mcv_hit hit) {
    return hit.triangle != MCV_NONE && world.triangles[hit.triangle].w == MCV_WORD(slot, shadow_target, 0);
}

MCV_FUNCTION void mcv_intersect_shadow(mcv_world world, mcv_slot slot) {
    const mcv_vec3 origin = MCV_LOAD_3(slot, shadow_origin);
    const mcv_vec3 direction = MCV_LOAD_3(slot, shadow_direction);
    if (mcv_shadow_is_any(slot)) {
        if (!mcv_intersect_any_ray(world.nodes, world.leaves, origin, direction, 1.0f)) mcv_add_shadow_light(world, slot, 1.0f);
    } else {
        const mcv_hit hit = mcv_intersect_closest_ray(world.nodes, world.leaves, origin, direction, INFINITY);
        if (mcv_meets_target(world, slot, hit)) mcv_add_shadow_light(world, slot, hit.t);
    }
}
