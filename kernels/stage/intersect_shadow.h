/* SPDX-License-Identifier: Apache-2.0 */
/* Stage: adds the light of a shadow ray that nothing blocks. */
#ifndef MCVISI_KERNELS_INTERSECT_SHADOW_H
#define MCVISI_KERNELS_INTERSECT_SHADOW_H

#include "path/camera_path.h"
#include "path/media.h"
#include "path/time.h"
#include "traverse/closest.h"
#include "geometry/surface.h"
#include "geometry/solids.h"
#include "light/emitter_element.h"
#include "stage/record_light.h"

/* Whether shadow rays may have to meet their emitter. */
#define MCV_HAS_TARGETS (MCV_WITH_PARALLEL || MCV_WITH_BEAM)

/* What comes along a cone's or a beam's direction depends on where it is met. */
#define MCV_HAS_TARGET_IMAGES (MCV_HAS_TARGETS && MCV_WITH_TEXTURE)

#if MCV_HAS_TARGET_IMAGES
/* Whether the target of the shadow ray sends an image. */
MCV_LOOP_FUNCTION int mcv_target_has_image(mcv_world world, mcv_slot slot) {
    const uint emitter = world.instances[MCV_WORD(slot, shadow_target, 0)].emitter;
    return world.emitters[emitter].texture != MCV_NONE;
}

/* The image of the target modulates the light of the shadow ray, which has hit it there. */
MCV_LOOP_FUNCTION void mcv_apply_target_image(mcv_world world, mcv_slot slot, mcv_hit hit) {
    const mcv_surface there = mcv_surface_at(world, hit.primitive, hit.u, hit.v);
    const uint emitter = world.instances[there.instance].emitter;
    const int white = mcv_is_recorded_by_pixel(world.emitters + emitter);
    const mcv_color image = mcv_texture_at(world, there, world.emitters[emitter].texture);
    mcv_color light;
    MCV_LOAD_COLOR(slot, shadow_light, light);
    const mcv_color tinted = mcv_tint(light, image);
    MCV_EACH_CHANNEL(i) light.c[i] = white ? light.c[i] : tinted.c[i];
    MCV_STORE_COLOR(slot, shadow_light, light);
    if (MCV_WITH_RECORDS)
        MCV_WORD(slot, shadow_emitter_element, 0) = mcv_emitter_element_by(
            world, emitter, there,
            mcv_scale(mcv_normalize(MCV_LOAD_3(slot, shadow_direction)), -1.0f), 0);
}
#endif

/* The light of the shadow ray arrives, if it is lit; a ray that ends at the emitter's point has no
 * triangle. `place`: reserved for its record, if it is lit. */
MCV_LOOP_FUNCTION void mcv_add_shadow_light(mcv_world world, mcv_slot slot, mcv_hit hit, int lit,
                                            uint place) {
    mcv_color light;
    mcv_color radiance;
    MCV_LOAD_COLOR(slot, shadow_light, light);
    if (MCV_WITH_ABSORPTION) {
        const mcv_vec3 direction = MCV_LOAD_3(slot, shadow_direction);
        const uint media = MCV_CROSSES ? MCV_WORD(slot, shadow_media, 0) : MCV_WORD(slot, media, 0);
        const float way = hit.t * mcv_sqrt(mcv_dot(direction, direction));
        light = mcv_tint(light, mcv_medium_transmittance(world, lit ? media : 0u, way));
    }
    MCV_LOAD_COLOR(slot, radiance, radiance);
    MCV_EACH_CHANNEL(i) radiance.c[i] = lit ? radiance.c[i] + light.c[i] : radiance.c[i];
    MCV_STORE_COLOR(slot, radiance, radiance);
    if (MCV_WITH_RECORDS && lit)
        mcv_record_at(world, slot, place, MCV_WORD(slot, shadow_emitter_element, 0), light);
}

/* A ray without target ends at the emitter's point, t = 1, or nowhere; one with a target must meet
 * it first. MCV_SKY and MCV_NONE are the two largest numbers: neither is an instance. */
static int mcv_shadow_is_any(mcv_slot slot) { return MCV_WORD(slot, shadow_target, 0) >= MCV_SKY; }

static float mcv_shadow_end(mcv_slot slot) {
    return MCV_WORD(slot, shadow_target, 0) == MCV_NONE ? 1.0f : INFINITY;
}

static int mcv_hits_target(mcv_world world, mcv_slot slot, mcv_hit hit) {
    return hit.primitive != MCV_NONE &&
           mcv_instance_of(world, hit.primitive) == MCV_WORD(slot, shadow_target, 0);
}

/* What the shadow ray meets, of triangles that stand still (the given hit) and moving ones. */
MCV_FUNCTION mcv_hit mcv_shadow_past_moving(mcv_world world, mcv_slot slot, mcv_hit hit) {
#if MCV_WITH_MOVING
    const mcv_vec3 origin = MCV_LOAD_3(slot, shadow_origin),
                   direction = MCV_LOAD_3(slot, shadow_direction);
    world = mcv_at_time(world, slot);
    if (!mcv_shadow_is_any(slot)) return mcv_closest_moving(world, origin, direction, hit);
    if (hit.primitive == MCV_NONE && mcv_moving_part_blocks(world, origin, direction, hit.t))
        hit.primitive = 0u; /* whichever */
#else
    (void)world, (void)slot;
#endif
    return hit;
}

/* What the shadow ray meets, of triangles (the given hit) and exact surfaces. */
MCV_FUNCTION mcv_hit mcv_shadow_past_solids(mcv_world world, mcv_slot slot, mcv_hit hit) {
    if (!MCV_WITH_SURFACES || (hit.primitive != MCV_NONE && mcv_shadow_is_any(slot))) return hit;
    return mcv_intersect_solids_along(world, MCV_LOAD_3(slot, shadow_origin),
                                      MCV_LOAD_3(slot, shadow_direction),
                                      MCV_WORD(slot, shadow_origin_surface, 0), hit);
}

/* Adds the light of a single shadow ray. */
MCV_FUNCTION void mcv_add_single_light(mcv_world world, mcv_slot slot, mcv_hit hit) {
    mcv_add_shadow_light(world, slot, hit, 1, mcv_reserve_records(world, 1u));
}

MCV_FUNCTION void mcv_intersect_shadow(mcv_world world, mcv_slot slot) {
    const mcv_vec3 origin = MCV_LOAD_3(slot, shadow_origin);
    const mcv_vec3 direction = MCV_LOAD_3(slot, shadow_direction);
    if (mcv_shadow_is_any(slot)) {
        const mcv_hit end = mcv_shadow_past_solids(
            world, slot, mcv_shadow_past_moving(world, slot, mcv_miss(mcv_shadow_end(slot))));
        if (end.primitive == MCV_NONE &&
            !mcv_intersect_any_ray(world.nodes, world.leaves, origin, direction, end.t))
            mcv_add_single_light(world, slot, end);
    } else {
        const mcv_hit hit = mcv_shadow_past_solids(
            world, slot,
            mcv_shadow_past_moving(
                world, slot,
                mcv_intersect_closest_ray(world.nodes, world.leaves, origin, direction, INFINITY)));
        if (!mcv_hits_target(world, slot, hit)) return;
#if MCV_HAS_TARGET_IMAGES
        if (mcv_target_has_image(world, slot)) mcv_apply_target_image(world, slot, hit);
#endif
        mcv_add_single_light(world, slot, hit);
    }
}

#endif
