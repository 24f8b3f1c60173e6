/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Stage: next-event estimation. A surface that spreads light chooses an emitter by power and reach,
 * then a direction to it: uniform in the cone of a parallel emitter that is smaller than the
 * emitter seen from there (which must then be the closest hit), else towards a point uniform in
 * solid angle on a rectangle that looks large from there, elsewhere by area; of an environment's
 * image a pixel by what it brings. Weighed against the surface's own choice of directions by the
 * power heuristic. Beams and lights without extent, which a direction of the surface's own cannot
 * meet, come in full.
 *
 * reads ray, hit -> writes shadow ray
 */
#ifndef MCVISI_KERNELS_SAMPLE_EMITTERS_H
#define MCVISI_KERNELS_SAMPLE_EMITTERS_H

#include "light/discrete.h"
#include "light/emission.h"
#include "light/environment.h"
#include "path/identity.h"
#include "geometry/interaction.h"
#include "light/selection.h"
#include "bsdf/shading.h"

#if MCV_WITH_NEXT_EVENT
/* Where an emitter is looked for from. */
typedef struct mcv_receiver {
    mcv_vec3 point, error, face;
} mcv_receiver;

MCV_LOOP_FUNCTION mcv_receiver mcv_receiver_of(mcv_interaction interaction) {
    const mcv_receiver at = {interaction.surface.point, interaction.surface.error,
                             interaction.face};
    return at;
}

typedef struct mcv_shadow {
    mcv_vec3 origin, direction;
    uint target;
    mcv_color light; /* radiance over the density of the choice; 0: nothing comes */
    float density; /* of the choice [1/sr]; 0: the only direction there is, and light is irradiance
                      over the chance of the choice */
} mcv_shadow;

#if MCV_WITH_BEAM
/* Back along the beam, where it goes through the receiver: the emitter must then be the closest
 * hit. */
MCV_LOOP_FUNCTION mcv_shadow mcv_sample_beam_of(mcv_receiver at,
                                                __global const mcv_device_emitter *e) {
    mcv_shadow shadow;
    const mcv_vec3 from_middle =
        mcv_sub(at.point, mcv_vec(e->middle[0], e->middle[1], e->middle[2]));
    shadow.direction = mcv_vec(-e->beam.axis[0], -e->beam.axis[1], -e->beam.axis[2]);
    shadow.origin = mcv_offset_origin(at.point, at.error, at.face, shadow.direction);
    shadow.target = e->instance;
    shadow.density = 0.0f;
    const int lit = mcv_collimated_beam_covers(&e->beam, from_middle);
    MCV_EACH_CHANNEL(i) {
        const float sent = e->radiance[i] / e->probability;
        shadow.light.c[i] = lit ? sent : 0.0f;
    }
    return shadow;
}
#endif

#if MCV_WITH_PUNCTUAL
MCV_LOOP_FUNCTION mcv_shadow mcv_sample_spot_of(mcv_receiver at,
                                                __global const mcv_device_emitter *e) {
    mcv_shadow shadow;
    const mcv_vec3 position =
        mcv_vec(e->spot.position[0], e->spot.position[1], e->spot.position[2]);
    const mcv_vec3 towards = mcv_sub(position, at.point);
    const mcv_vec3 direction = mcv_normalize(towards);
    shadow.origin = mcv_offset_origin(at.point, at.error, at.face, direction);
    shadow.direction = mcv_sub(position, shadow.origin);
    shadow.target = MCV_NONE;
    shadow.density = 0.0f;
    const float share = mcv_spot_evaluate(&e->spot, mcv_scale(direction, -1.0f)) *
                        mcv_spot_attenuation(&e->spot, mcv_dot(towards, towards));
    MCV_EACH_CHANNEL(i) shadow.light.c[i] = e->radiance[i] * share / e->probability;
    return shadow;
}

MCV_LOOP_FUNCTION mcv_shadow mcv_sample_directional_of(mcv_receiver at,
                                                       __global const mcv_device_emitter *e) {
    mcv_shadow shadow;
    const mcv_vec3 direction =
        mcv_vec(-e->directional.axis[0], -e->directional.axis[1], -e->directional.axis[2]);
    shadow.origin = mcv_offset_origin(at.point, at.error, at.face, direction);
    shadow.direction = direction;
    shadow.target = MCV_SKY;
    shadow.density = 0.0f;
    MCV_EACH_CHANNEL(i) shadow.light.c[i] = e->radiance[i] / e->probability;
    return shadow;
}
#endif

#if MCV_WITH_ENVIRONMENT_IMAGE && MCV_WITH_TEXTURE
/* What rounding puts into a neighbouring pixel counts as that one's. */
static mcv_shadow mcv_sample_environment_of(mcv_world world, mcv_receiver at,
                                            __global const mcv_device_emitter *e, mcv_pair pair) {
    mcv_shadow shadow;
    float xi, eta;
    const uint row =
        mcv_search_cdf(world.emitter_cdf + e->cdf, e->environment.height, pair.y, pair.x, &eta);
    const uint column = mcv_search_cdf(mcv_environment_row(world, e, row), e->environment.width,
                                       pair.x, pair.y, &xi);
    shadow.direction = mcv_environment_sample(&e->environment, column, row, xi, eta);
    shadow.origin = mcv_offset_origin(at.point, at.error, at.face, shadow.direction);
    shadow.target = MCV_SKY;
    const mcv_sky_pixel pixel = mcv_sky_pixel_at(e, shadow.direction);
    shadow.density = mcv_environment_density(world, e, pixel);
    shadow.light = mcv_grey(0.0f);
    if (shadow.density > 0.0f)
        shadow.light = mcv_dim(mcv_environment_radiance(world, e, pixel), 1.0f / shadow.density);
    return shadow;
}
#endif

#if MCV_WITH_PARALLEL
/*
 * Whether a ray, of unit direction, may meet an emitter: it passes the middle at |way × direction|,
 * which rounds by γ(4) |way|, within its radius. The traversal rounds by γ(6) of the corners'
 * coordinates from the ray's origin (mcv_interaction_error).
 */
MCV_LOOP_FUNCTION int mcv_may_hit(__global const mcv_device_emitter *e, mcv_vec3 origin,
                                  mcv_vec3 direction) {
    const mcv_vec3 way = mcv_sub(mcv_vec(e->middle[0], e->middle[1], e->middle[2]), origin);
    const mcv_vec3 beside = mcv_cross(way, direction);
    const float distance = mcv_abs(way.x) + mcv_abs(way.y) + mcv_abs(way.z);
    const float within = mcv_fma(MCV_GAMMA(32), distance + e->radius, e->radius);
    const int close = mcv_dot(beside, beside) <= within * within,
              ahead = mcv_dot(way, direction) >= -within;
    return close & ahead;
}

/* Most rays from beside a parallel beam pass the emitter by: they bring nothing. */
MCV_LOOP_FUNCTION mcv_shadow mcv_sample_cone_of(mcv_receiver at,
                                                __global const mcv_device_emitter *e,
                                                mcv_pair pair) {
    mcv_shadow shadow;
    const mcv_vec3 axis = mcv_vec(e->parallel.axis[0], e->parallel.axis[1], e->parallel.axis[2]);
    shadow.direction = mcv_scale(
        mcv_from_frame(mcv_sample_cone(e->parallel.sin_half, pair.x, pair.y), axis), -1.0f);
    shadow.origin = mcv_offset_origin(at.point, at.error, at.face, shadow.direction);
    shadow.target = e->instance;
    shadow.density = e->probability / e->parallel.solid_angle;
    const int lit = mcv_may_hit(e, shadow.origin, shadow.direction);
    MCV_EACH_CHANNEL(i) {
        const float sent = e->radiance[i] / shadow.density;
        shadow.light.c[i] = lit ? sent : 0.0f;
    }
    return shadow;
}
#endif

#if MCV_WITH_EMISSION
/*
 * Bound of the error with which a ray from the receiver meets the triangle of a place that has an
 * error itself, per coordinate. The traversal works on the corners relative to the ray's origin, of
 * which R is the largest coordinate: shearing them rounds by γ(6) R, the depth by 12 u R
 * (mcv_intersect_leaf), the ray's end and t itself by 4 u R. Close to the world's origin this is
 * more than the error of the point.
 */
MCV_LOOP_FUNCTION mcv_vec3 mcv_interaction_error(mcv_vec3 receiver, mcv_facet facet,
                                                 mcv_vec3 error) {
    float largest = 0.0f;
    const mcv_vec3 corners[3] = {facet.a, facet.b, facet.c};
#pragma unroll
    for (int i = 0; i < 3; ++i) {
        const mcv_vec3 way = mcv_sub(corners[i], receiver);
        const float flat = mcv_abs(way.x) > mcv_abs(way.y) ? mcv_abs(way.x) : mcv_abs(way.y);
        const float far = mcv_abs(way.z) > flat ? mcv_abs(way.z) : flat;
        largest = far > largest ? far : largest;
    }
    const float more = MCV_GAMMA(16) * largest;
    return mcv_vec(error.x + more, error.y + more, error.z + more);
}

/* A place on an emitter. */
typedef struct mcv_emitter_point {
    mcv_facet facet;
    float u, v;
    float share;   /* of the choices by area, the facet's */
    float density; /* with which it is chosen [1/sr]; 0: by area */
} mcv_emitter_point;

/* The place (xi, eta) of the unit square on a triangle, uniform by area. */
MCV_LOOP_FUNCTION mcv_emitter_point mcv_emitter_point_on(mcv_facet facet, float share, float xi,
                                                         float eta) {
    mcv_emitter_point place;
    const float root = mcv_sqrt(xi);
    place.facet = facet;
    place.u = root * (1.0f - eta);
    place.v = root * eta;
    place.share = share;
    place.density = 0.0f;
    return place;
}

/* Uniform by area. */
MCV_FUNCTION mcv_emitter_point mcv_choose_emitter_point(mcv_world world,
                                                        __global const mcv_device_emitter *e,
                                                        mcv_pair pair) {
    float xi;
    const uint triangle =
        world.instances[e->instance].first_triangle +
        mcv_search_cdf(world.emitter_cdf + e->cdf, e->triangle_count, pair.x, pair.y, &xi);
    return mcv_emitter_point_on(mcv_facet_of(world, triangle),
                                mcv_triangle_share(world, e, triangle), xi, pair.y);
}

#if MCV_WITH_RECTANGLE
/* The two triangles of a rectangle, and their shares. */
typedef struct mcv_facets {
    mcv_facet first, second;
    float first_share, second_share;
} mcv_facets;

MCV_LOOP_FUNCTION mcv_facets mcv_facets_of(mcv_world world, __global const mcv_device_emitter *e) {
    mcv_facets two;
    const uint first = world.instances[e->instance].first_triangle;
    two.first = mcv_facet_of(world, first);
    two.second = mcv_facet_of(world, first + 1u);
    two.first_share = mcv_triangle_share(world, e, first);
    two.second_share = mcv_triangle_share(world, e, first + 1u);
    return two;
}

MCV_LOOP_FUNCTION mcv_facet mcv_choose_facet(int first, const mcv_facets *of) {
    mcv_facet facet;
    facet.a = mcv_choose(first, of->first.a, of->second.a);
    facet.b = mcv_choose(first, of->first.b, of->second.b);
    facet.c = mcv_choose(first, of->first.c, of->second.c);
    facet.face = mcv_choose(first, of->first.face, of->second.face);
    facet.area = first ? of->first.area : of->second.area;
#if MCV_WITH_NORMALS
    facet.normal_a = mcv_choose(first, of->first.normal_a, of->second.normal_a);
    facet.normal_b = mcv_choose(first, of->first.normal_b, of->second.normal_b);
    facet.normal_c = mcv_choose(first, of->first.normal_c, of->second.normal_c);
#endif
    facet.triangle = first ? of->first.triangle : of->second.triangle;
    facet.corners.x = first ? of->first.corners.x : of->second.corners.x;
    facet.corners.y = first ? of->first.corners.y : of->second.corners.y;
    facet.corners.z = first ? of->first.corners.z : of->second.corners.z;
    facet.corners.w = of->first.corners.w;
    return facet;
}

MCV_LOOP_FUNCTION float mcv_on_triangle(__global const float *map, float s, float t) {
    return mcv_fma(map[1], s, mcv_fma(map[2], t, map[0]));
}

/* A place on a rectangle that the receiver sees: uniform in solid angle, from afar by area. */
MCV_LOOP_FUNCTION mcv_emitter_point mcv_choose_on_rectangle(__global const mcv_device_emitter *e,
                                                            const mcv_facets *of, mcv_vec3 receiver,
                                                            mcv_pair pair) {
    __global const mcv_rectangle *r = &e->rectangle;
    mcv_emitter_point place;
    const mcv_rectangle_view view = mcv_view_emitter(e, receiver);
    const int close = mcv_samples_solid_angle(view);
    float s, t;
    mcv_sample_rectangle(r, view, pair.x, pair.y, &s, &t);
    s = close ? s : pair.x;
    t = close ? t : pair.y;
    const float u = mcv_on_triangle(r->to_triangle[0], s, t),
                v = mcv_on_triangle(r->to_triangle[0] + 3, s, t);
    const float least = u < v ? u : v, other = 1.0f - u - v;
    const int first = (least < other ? least : other) >= 0.0f;
    const float second_u = mcv_on_triangle(r->to_triangle[1], s, t),
                second_v = mcv_on_triangle(r->to_triangle[1] + 3, s, t);
    place.facet = mcv_choose_facet(first, of);
    place.u = first ? u : second_u;
    place.v = first ? v : second_v;
    place.share = first ? of->first_share : of->second_share;
    place.density = close ? e->probability / view.solid_angle : 0.0f;
    return place;
}
#endif

/* What comes from there; of an emitter with an image as without. */
MCV_LOOP_FUNCTION mcv_shadow mcv_sample_point_of(mcv_receiver at,
                                                 __global const mcv_device_emitter *e,
                                                 mcv_emitter_point place, mcv_surface *there,
                                                 mcv_vec3 *direction) {
    mcv_shadow shadow;
    *there = mcv_surface_on(place.facet, place.u, place.v);
    const mcv_vec3 way = mcv_sub(there->point, at.point);
    const float distance = mcv_sqrt(mcv_dot(way, way));
    const mcv_vec3 towards = mcv_normalize(way), back = mcv_scale(towards, -1.0f);
    shadow.origin = mcv_offset_origin(at.point, at.error, at.face, towards);
    const mcv_vec3 error = mcv_interaction_error(at.point, place.facet, there->error);
    shadow.direction =
        mcv_sub(mcv_offset_origin(there->point, error, there->face, back), shadow.origin);
    shadow.target = MCV_NONE;
    const float by_area = mcv_area_density(e, place.share, *there, towards, distance);
    shadow.density = place.density > 0.0f ? place.density : by_area;
    /* Only a face seen exactly edge-on has no finite density. */
    const int lit = (shadow.density > 0.0f) & (shadow.density < INFINITY) &
                    mcv_shines(e, there->face, there->normal, back);
    const float scale = 1.0f / shadow.density;
    MCV_EACH_CHANNEL(i) {
        const float sent =
            e->radiance[i] * scale; /* by itself: what is read on a condition is gathered */
        shadow.light.c[i] = lit ? sent : 0.0f;
    }
    *direction = back;
    return shadow;
}

#if MCV_WITH_TEXTURE
/* Whether what an emitter sends varies over its surface, or in more ways than mcv_shines knows. */
MCV_FUNCTION int mcv_has_image(__global const mcv_device_emitter *e) {
    return e->texture != MCV_NONE;
}

/* The light of an emitter with an image. */
MCV_FUNCTION void mcv_light_by_image(mcv_world world, mcv_surface there, uint emitter,
                                     mcv_vec3 back, mcv_shadow *shadow) {
    shadow->light = mcv_grey(0.0f);
    if (shadow->density > 0.0f && shadow->density < INFINITY)
        shadow->light = mcv_dim(mcv_emitted(world, there, emitter, back), 1.0f / shadow->density);
}
#endif

MCV_FUNCTION mcv_shadow mcv_sample_area_of(mcv_world world, mcv_receiver at, uint emitter,
                                           mcv_pair pair) {
    __global const mcv_device_emitter *e = world.emitters + emitter;
    mcv_surface there;
    mcv_vec3 back;
    mcv_emitter_point place;
#if MCV_WITH_RECTANGLE
    if (mcv_is_rectangle(e)) {
        const mcv_facets two = mcv_facets_of(world, e);
        place = mcv_choose_on_rectangle(e, &two, at.point, pair);
    } else
#endif
        place = mcv_choose_emitter_point(world, e, pair);
    mcv_shadow shadow = mcv_sample_point_of(at, e, place, &there, &back);
#if MCV_WITH_TEXTURE
    if (mcv_has_image(e)) mcv_light_by_image(world, there, emitter, back, &shadow);
#endif
    return shadow;
}
#endif

/* A direction from the receiver towards one emitter. */
static mcv_shadow mcv_sample_towards(mcv_world world, mcv_receiver at, uint emitter,
                                     mcv_pair pair) {
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
    if (mcv_samples_cone(e, at.point)) return mcv_sample_cone_of(at, e, pair);
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

/* One of the emitters, or MCV_NONE. */
MCV_FUNCTION uint mcv_pick_emitter(mcv_world world, mcv_slot slot, uint depth) {
    if (MCV_WORD(slot, hit, 3) == MCV_NONE) return MCV_NONE;
    const uint material = world.instances[mcv_hit_instance(world, slot)].material;
    if (!world.materials[material].scattering_sides) return MCV_NONE;
    if (world.frame->emitter_count == 1u) return 0u; /* whose number may not have been drawn */
    const mcv_pair choice = mcv_draw(slot, depth, MCV_PAIR_CHOICE);
#if MCV_WITH_REACH
#if MCV_TILE
    const mcv_vec3 point = MCV_LOAD_3(slot, point), face = MCV_LOAD_3(slot, face),
                   normal = MCV_LOAD_3(slot, normal);
#else
    const mcv_interaction interaction = mcv_make_interaction(world, slot);
    const mcv_vec3 point = interaction.surface.point, face = interaction.face,
                   normal = interaction.normal;
#endif
    mcv_light_selection selection;
    const uint emitter =
        mcv_select_emitter(world, point, face, normal, world.materials[material].scattering_sides,
                           choice.x, &selection);
    MCV_STORE(slot, selection_here, 0, selection.scale);
    MCV_STORE(slot, selection_here, 1, selection.least);
    return emitter;
#else
    float unused;
    return mcv_search_cdf(world.emitter_cdf, world.frame->emitter_count, choice.x, choice.y,
                          &unused);
#endif
}

/* Sharp surfaces do not look for emitters whose light the path shares with light paths, but leave
 * that to chance. */
MCV_LOOP_FUNCTION int mcv_leaves_to_light_paths(mcv_world world, mcv_slot slot, uint emitter,
                                                int near_specular) {
#if MCV_WITH_LIGHT_TRACING
    const uint path_class = MCV_WORD(slot, path_class, 0);
    return near_specular &
           ((path_class == MCV_PATH_CLASS_DIFFUSE) | (path_class == MCV_PATH_CLASS_CARRIED)) &
           (world.emitters[emitter].light_flux > 0.0f);
#else
    (void)world, (void)slot, (void)emitter, (void)near_specular;
    return 0;
#endif
}

/* The emitter that the path looks for from where it is, or MCV_NONE. */
MCV_FUNCTION uint mcv_choose_emitter(mcv_world world, mcv_slot slot, uint depth) {
    const uint emitter = mcv_pick_emitter(world, slot, depth);
    if (emitter == MCV_NONE) return MCV_NONE;
    const uint material = world.instances[mcv_hit_instance(world, slot)].material;
    return mcv_leaves_to_light_paths(world, slot, emitter,
                                     (int)world.materials[material].near_specular)
               ? MCV_NONE
               : emitter;
}

#if MCV_WITH_REACH
/* The shadow, of an emitter that is chosen by its share of the power, as that of one chosen by what
 * reaches the path's surface. */
MCV_LOOP_FUNCTION mcv_shadow mcv_apply_selection(mcv_world world, mcv_slot slot, mcv_vec3 point,
                                                 uint emitter, mcv_shadow shadow) {
    const mcv_light_selection selection = {MCV_LOAD(slot, selection_here, 0),
                                           MCV_LOAD(slot, selection_here, 1)};
    const float preference = mcv_selection_ratio(world.emitters + emitter, point, selection);
    shadow.density *= preference;
    shadow.light = mcv_dim(shadow.light, 1.0f / preference);
    return shadow;
}
#else
#define mcv_apply_selection(world, slot, point, emitter, shadow) (shadow)
#endif

/* mcv_respond for a surface of a kind that is known. */
MCV_LOOP_FUNCTION mcv_response mcv_respond_as(mcv_world world, mcv_slot slot,
                                              const mcv_interaction *interaction,
                                              mcv_shading shading, mcv_vec3 direction) {
    const uint media = mcv_path_media(slot);
#if MCV_WITH_PLAIN
    if (shading.kind == MCV_SHADING_DIFFUSE) {
        mcv_color reflectance;
        MCV_LOAD_COLOR(slot, reflectance, reflectance);
        return mcv_respond_diffuse(interaction, reflectance, media, direction);
    }
#if MCV_WITH_GLOSS
    if (shading.kind == MCV_SHADING_GLOSS) {
        const mcv_gloss_interaction m =
            mcv_make_plain_gloss_interaction(world, interaction, shading, media);
        mcv_response response =
            mcv_respond_gloss_of(world, interaction, shading.gloss, &m, direction);
        /* Where it has not chosen an emitter any number will do. */
        const uint emitter = MCV_WORD(slot, emitter, 0), some = emitter == MCV_NONE ? 0u : emitter;
        const int near_specular = (int)world.materials[shading.material].near_specular;
        const int dropped = (m.gloss.table == MCV_NONE) |
                            mcv_leaves_to_light_paths(world, slot, some, near_specular);
        MCV_EACH_CHANNEL(c) response.value.c[c] = dropped ? 0.0f : response.value.c[c];
        return response;
    }
#endif
#endif
    (void)shading;
    return mcv_respond(world, *interaction, media, direction);
}

/*
 * Makes a shadow ray of what comes from an emitter: what the surface makes of the light, and the
 * power heuristic against the surface's own choice of directions. 1 if there is a ray to follow.
 * Its origin, direction and target are the shadow's.
 */
MCV_LOOP_FUNCTION int mcv_make_shadow_ray(mcv_world world, mcv_slot slot,
                                          const mcv_interaction *interaction, mcv_shading shading,
                                          mcv_shadow shadow) {
#if MCV_WITH_DISPERSION
    world = mcv_disperse(world, slot);
#endif
    if (shading.kind == MCV_SHADING_ANY && !(mcv_brightest(shadow.light) > 0.0f)) return 0;
    const mcv_response response =
        mcv_respond_as(world, slot, interaction, shading, mcv_normalize(shadow.direction));
    mcv_color light;
    MCV_LOAD_COLOR(slot, throughput, light);
    light = mcv_tint(mcv_tint(light, response.value), shadow.light);
    light =
        mcv_dim(light, shadow.density > 0.0f ? mcv_power_heuristic(shadow.density, response.density)
                                             : 1.0f);
    light = mcv_basic_radiance(world, light, response.media);
#if MCV_WITH_DIELECTRIC && MCV_WITH_GLOSS
    MCV_WORD(slot, shadow_media, 0) = response.media;
#endif
#if MCV_WITH_SURFACES
    MCV_WORD(slot, shadow_origin_surface, 0) =
        shading.exact ? mcv_origin_surface_of(world, *interaction, shadow.direction) : MCV_NONE;
#endif
    MCV_STORE_COLOR(slot, shadow_light, light);
    const int comes = mcv_brightest(shadow.light) > 0.0f,
              reflects = mcv_brightest(response.value) > 0.0f;
    return comes & reflects;
}

/* 1 if there is a shadow ray to follow. */
MCV_FUNCTION int mcv_sample_emitter(mcv_world world, mcv_slot slot, uint depth) {
    const uint emitter = mcv_choose_emitter(world, slot, depth);
    if (emitter == MCV_NONE) return 0;
    const mcv_interaction interaction = mcv_make_interaction(world, slot);
    const mcv_receiver at = mcv_receiver_of(interaction);
    const mcv_shadow shadow = mcv_apply_selection(
        world, slot, at.point, emitter,
        mcv_sample_towards(world, at, emitter, mcv_draw(slot, depth, MCV_PAIR_EMITTER)));
    MCV_STORE_3(slot, shadow_origin, shadow.origin);
    MCV_STORE_3(slot, shadow_direction, shadow.direction);
    MCV_WORD(slot, shadow_target, 0) = shadow.target;
    return mcv_make_shadow_ray(world, slot, &interaction, mcv_any_shading(), shadow);
}
#endif

#endif
