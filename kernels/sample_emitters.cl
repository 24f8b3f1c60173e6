/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Stage: next-event estimation. A surface that spreads light chooses an emitter by power, then a direction to it: uniform in the cone
 * of a parallel emitter that is smaller than the emitter seen from there (which must then be the closest hit), else towards a
 * point uniform by area; of an environment's image a pixel by what it brings. Weighed against the surface's own choice of directions by the
 * balance heuristic. Beams and lights without extent, which a direction of the surface's own cannot meet, come in full.
 *
 * reads ray, hit -> writes shadow ray
 */
#include "choose.h"
#include "environment.h"
#include "identity.h"
#include "meet_surface.h"

typedef struct mcv_shadow {
    mcv_vec3 origin, direction;
    uint target;
    mcv_color light; /* radiance over the density of the choice; 0: nothing comes */
    float density;   /* of the choice [1/sr]; 0: the only direction there is, and light is irradiance over the chance of the choice */
} mcv_shadow;

#if MCV_WITH_BEAM
/* Back along the beam, where it goes through the receiver: the emitter must then be the closest hit. */
static mcv_shadow mcv_sample_beam_of(mcv_meeting at, __global const mcv_device_emitter *e) {
    mcv_shadow shadow;
    const mcv_vec3 from_middle = mcv_sub(at.surface.point, mcv_vec(e->middle[0], e->middle[1], e->middle[2]));
    shadow.direction = mcv_vec(-e->beam.axis[0], -e->beam.axis[1], -e->beam.axis[2]);
    shadow.origin = mcv_offset_origin(at.surface.point, at.surface.error, at.face, shadow.direction);
    shadow.target = e->instance;
    shadow.density = 0.0f;
    shadow.light = mcv_grey(0.0f);
    if (mcv_collimated_beam_covers(&e->beam, from_middle)) MCV_EACH_CHANNEL(i) shadow.light.c[i] = e->radiance[i] / e->probability;
    return shadow;
}
#endif

#if MCV_WITH_PUNCTUAL
static mcv_shadow mcv_sample_spot_of(mcv_meeting at, __global const mcv_device_emitter *e) {
    mcv_shadow shadow;
    const mcv_vec3 position = mcv_vec(e->spot.position[0], e->spot.position[1], e->spot.position[2]);
    const mcv_vec3 towards = mcv_sub(position, at.surface.point);
    const mcv_vec3 direction = mcv_normalize(towards);
    shadow.origin = mcv_offset_origin(at.surface.point, at.surface.error, at.face, direction);
    shadow.direction = mcv_sub(position, shadow.origin);
    shadow.target = MCV_NONE;
    shadow.density = 0.0f;
    const float share =
        mcv_spot_evaluate(&e->spot, mcv_scale(direction, -1.0f)) * mcv_spot_attenuation(&e->spot, mcv_dot(towards, towards));
    MCV_EACH_CHANNEL(i) shadow.light.c[i] = e->radiance[i] * share / e->probability;
    return shadow;
}

static mcv_shadow mcv_sample_directional_of(mcv_meeting at, __global const mcv_device_emitter *e) {
    mcv_shadow shadow;
    const mcv_vec3 direction = mcv_vec(-e->directional.axis[0], -e->directional.axis[1], -e->directional.axis[2]);
    shadow.origin = mcv_offset_origin(at.surface.point, at.surface.error, at.face, direction);
    shadow.direction = direction;
    shadow.target = MCV_SKY;
    shadow.density = 0.0f;
    MCV_EACH_CHANNEL(i) shadow.light.c[i] = e->radiance[i] / e->probability;
    return shadow;
}
#endif

#if MCV_WITH_ENVIRONMENT_IMAGE && MCV_WITH_TEXTURE
/* What rounding puts into a neighbouring pixel counts as that one's. */
static mcv_shadow mcv_sample_environment_of(mcv_world world, mcv_meeting at, __global const mcv_device_emitter *e, mcv_pair pair) {
    mcv_shadow shadow;
    float xi, eta;
    const uint row = mcv_search_cdf(world.emitter_cdf + e->cdf, e->environment.height, pair.y, pair.x, &eta);
    const uint column = mcv_search_cdf(mcv_environment_row(world, e, row), e->environment.width, pair.x, pair.y, &xi);
    shadow.direction = mcv_environment_sample(&e->environment, column, row, xi, eta);
    shadow.origin = mcv_offset_origin(at.surface.point, at.surface.error, at.face, shadow.direction);
    shadow.target = MCV_SKY;
    shadow.density = mcv_environment_density(world, e, shadow.direction);
    shadow.light = mcv_grey(0.0f);
    if (shadow.density > 0.0f) shadow.light = mcv_dim(mcv_environment_radiance(world, e, shadow.direction), 1.0f / shadow.density);
    return shadow;
}
#endif

#if MCV_WITH_PARALLEL
static mcv_shadow mcv_sample_cone_of(mcv_meeting at, __global const mcv_device_emitter *e, mcv_pair pair) {
    mcv_shadow shadow;
    const mcv_vec3 axis = mcv_vec(e->parallel.axis[0], e->parallel.axis[1], e->parallel.axis[2]);
    shadow.direction = mcv_scale(mcv_from_frame(mcv_sample_cone(e->parallel.sin_half, pair.x, pair.y), axis), -1.0f);
    shadow.origin = mcv_offset_origin(at.surface.point, at.surface.error, at.face, shadow.direction);
    shadow.target = e->instance;
    shadow.density = e->probability / e->parallel.solid_angle;
    MCV_EACH_CHANNEL(i) shadow.light.c[i] = e->radiance[i] / shadow.density;
    return shadow;
}
#endif

#if MCV_WITH_EMISSION
/*
 * Bound of the error with which a ray from the receiver meets the triangle of `there`, per coordinate. The traversal works on the corners
 * relative to the ray's origin, of which R is the largest coordinate: shearing them rounds by γ(6) R, the depth by 12 u R
 * (mcv_intersect_leaf), the ray's end and t itself by 4 u R. Close to the world's origin this is more than the error of the point.
 */
MCV_FUNCTION mcv_vec3 mcv_meeting_error(mcv_world world, mcv_vec3 receiver, mcv_surface there) {
    float largest = 0.0f;
    const uint vertices[3] = {there.corners.x, there.corners.y, there.corners.z};
    for (int i = 0; i < 3; ++i) {
        const mcv_vec3 way = mcv_sub(mcv_vertex_vector(world.positions, vertices[i]), receiver);
        largest = fmax(largest, fmax(mcv_abs(way.x), fmax(mcv_abs(way.y), mcv_abs(way.z))));
    }
    const float more = MCV_GAMMA(16) * largest;
    return mcv_vec(there.error.x + more, there.error.y + more, there.error.z + more);
}

static mcv_shadow mcv_sample_area_of(mcv_world world, mcv_meeting at, uint emitter, mcv_pair pair) {
    mcv_shadow shadow;
    __global const mcv_device_emitter *e = world.emitters + emitter;
    float xi;
    const uint triangle =
        world.instances[e->instance].first_triangle + mcv_search_cdf(world.emitter_cdf + e->cdf, e->triangle_count, pair.x, pair.y, &xi);
    /* The unit square to a triangle by area. */
    const float root = mcv_sqrt(xi);
    const mcv_surface there = mcv_surface_at(world, triangle, root * (1.0f - pair.y), root * pair.y);
    const mcv_vec3 towards = mcv_sub(there.point, at.surface.point);
    const float distance = mcv_sqrt(mcv_dot(towards, towards));
    const mcv_vec3 direction = mcv_normalize(towards);
    shadow.origin = mcv_offset_origin(at.surface.point, at.surface.error, at.face, direction);
    const mcv_vec3 error = mcv_meeting_error(world, at.surface.point, there);
    shadow.direction = mcv_sub(mcv_offset_origin(there.point, error, there.face, mcv_scale(direction, -1.0f)), shadow.origin);
    shadow.target = MCV_NONE;
    shadow.density = mcv_emitter_density(world, at.surface.point, there, emitter, direction, distance);
    shadow.light = mcv_grey(0.0f);
    /* Only a face seen exactly edge-on has no finite density. */
    if (shadow.density > 0.0f && shadow.density < INFINITY) {
        shadow.light = mcv_dim(mcv_emitted(world, there, emitter, mcv_scale(direction, -1.0f)), 1.0f / shadow.density);
    }
    return shadow;
}
#endif

/* A direction from the receiver towards one emitter. */
static mcv_shadow mcv_sample_towards(mcv_world world, mcv_meeting at, uint emitter, mcv_pair pair) {
    __global const mcv_device_emitter *e = world.emitters + emitter;
    (void)e;
#if MCV_WITH_BEAM
    if (e->type == MCV_EMITTER_COLLIMATED_BEAM) return mcv_sample_beam_of(at, e);
#endif
#if MCV_WITH_PUNCTUAL
    if (e->type == MCV_EMITTER_SPOT) return mcv_sample_spot_of(at, e);
    if (e->type == MCV_EMITTER_DIRECTIONAL) return mcv_sample_directional_of(at, e);
#endif
#if MCV_WITH_ENVIRONMENT_IMAGE && MCV_WITH_TEXTURE
    if (e->type == MCV_EMITTER_ENVIRONMENT) return mcv_sample_environment_of(world, at, e, pair);
#endif
#if MCV_WITH_PARALLEL
    if (mcv_samples_cone(e, at.surface.point)) return mcv_sample_cone_of(at, e, pair);
#endif
#if MCV_WITH_EMISSION
    return mcv_sample_area_of(world, at, emitter, pair);
#else
    mcv_shadow none;
    none.light = mcv_grey(0.0f);
    (void)at, (void)pair;
    return none;
#endif
}

/* 1 if there is a shadow ray to follow. */
MCV_FUNCTION int mcv_sample_emitter(mcv_world world, mcv_slot slot, uint depth) {
    const uint triangle = MCV_WORD(slot, hit, 3);
    if (triangle == MCV_NONE) return 0;
    const uint material = world.instances[mcv_instance_of(world, triangle)].material;
    if (!world.materials[material].spreads) return 0;
#if MCV_WITH_DISPERSION
    world = mcv_disperse(world, slot);
#endif

    const mcv_meeting meeting = mcv_meet_surface(world, slot);

    /* Choose an emitter and a direction. */
    const mcv_pair choice = mcv_draw(slot, depth, MCV_PAIR_CHOICE);
    const mcv_pair pair = mcv_draw(slot, depth, MCV_PAIR_EMITTER);
    float unused;
    const uint emitter = mcv_search_cdf(world.emitter_cdf, world.frame->emitter_count, choice.x, choice.y, &unused);
    const mcv_shadow shadow = mcv_sample_towards(world, meeting, emitter, pair);

    /* What the surface makes of it, and the balance heuristic against its own choice. */
    if (!(mcv_brightest(shadow.light) > 0.0f)) return 0;
    uint media = 0;
#if MCV_WITH_DIELECTRIC
    media = MCV_WORD(slot, media, 0);
#endif
    const mcv_response response = mcv_respond(world, meeting, media, mcv_normalize(shadow.direction));
    if (!(mcv_brightest(response.value) > 0.0f)) return 0;
    mcv_color light;
    MCV_LOAD_COLOR(slot, throughput, light);
    light = mcv_tint(mcv_tint(light, response.value), shadow.light);
    if (shadow.density > 0.0f) light = mcv_dim(light, shadow.density / (shadow.density + response.density));
#if MCV_WITH_DIELECTRIC
    light = mcv_dim(light, world.media[mcv_filling_medium(response.media)].inverse_index_squared);
#if MCV_WITH_GLOSS
    MCV_WORD(slot, shadow_media, 0) = response.media;
#endif
#endif
    MCV_STORE_3(slot, shadow_origin, shadow.origin);
    MCV_STORE_3(slot, shadow_direction, shadow.direction);
#if MCV_WITH_SURFACES
    MCV_WORD(slot, shadow_left, 0) = mcv_leave_meeting(world, meeting, shadow.direction);
#endif
    MCV_WORD(slot, shadow_target, 0) = shadow.target;
    MCV_STORE_COLOR(slot, shadow_light, light);
    return 1;
}
