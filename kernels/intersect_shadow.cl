/* SPDX-License-Identifier: Apache-2.0 */
/* Stage: adds the light of a shadow ray that nothing blocks. reads shadow ray -> writes radiance */
#include "path.h"
#include "surface.h"

static void mcv_intersect_shadow(mcv_world world, mcv_slot slot) {
    const mcv_vec3 origin = MCV_LOAD_3(slot, shadow_origin);
    const mcv_vec3 direction = MCV_LOAD_3(slot, shadow_direction);
    const uint target = MCV_WORD(slot, shadow_target, 0);
    mcv_color light;
    mcv_color radiance;
    MCV_LOAD_COLOR(slot, shadow_light, light);
    float t = 1.0f; /* a ray without target ends at the emitter's point */
    if (target == MCV_NONE) {
        if (mcv_intersect_any_ray(world.nodes, world.leaves, origin, direction, 1.0f)) return;
    } else {
        const mcv_hit hit = mcv_intersect_closest_ray(world.nodes, world.leaves, origin, direction, INFINITY);
        if (hit.triangle == MCV_NONE || world.triangles[hit.triangle].w != target) return;
        t = hit.t;
#if MCV_WITH_PARALLEL && MCV_WITH_TEXTURE
        /* What comes along a cone's direction depends on where it was met. */
        const uint texture = world.emitters[world.instances[target].emitter].texture;
        if (texture != MCV_NONE) light = mcv_tint(light, mcv_texture_at(world, mcv_surface_at(world, hit.triangle, hit.u, hit.v), texture));
#endif
    }
#if MCV_WITH_ABSORPTION
    light = mcv_tint(light, mcv_medium_transmittance(world, MCV_WORD(slot, media, 0), t * mcv_sqrt(mcv_dot(direction, direction))));
#else
    (void)t;
#endif
    MCV_LOAD_COLOR(slot, radiance, radiance);
    MCV_EACH_CHANNEL(i) radiance.c[i] += light.c[i];
    MCV_STORE_COLOR(slot, radiance, radiance);
}
