/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Stage: light paths, one for every 2^k-th camera path. Each starts at an emitter chosen by flux
 * and goes through smooth surfaces and sharp ones, which spread light a little; from the first
 * other one that spreads light on, if one of those came before, it connects each such surface to a
 * place on the sensor's lens, straight or through plates. A beam that comes to the lens itself
 * counts, too. What camera paths find as well, both share (mcv_light_share); what these find only
 * by next-event estimation at a sharp surface is left to light paths.
 *
 * They carry flux. Radiance on camera paths and flux on these are transported alike where a surface
 * spreads light about its triangle's normal n_g; about another one n_s, flux has the factor
 * |i·n_s||o·n_g|/(|i·n_g||o·n_s|) for going from i to o (Veach 1997, 5.3), without which facets
 * would show. Smooth and sharp surfaces hand on all flux, as the smooth body would that the mesh
 * stands for: there the factor is 1 on the average over a facet, but for the square of its angle,
 * and without bound where light grazes it.
 *
 * reads nothing -> writes splats
 */
#ifndef MCVISI_KERNELS_TRACE_LIGHT_PATH_H
#define MCVISI_KERNELS_TRACE_LIGHT_PATH_H

#include "light/emitter_point.h"
#include "traverse/closest.h"
#include "light/light_path.h"
#include "stage/roulette.h"
#include "bsdf/bsdf.h"
#include "bsdf/shading.h"
#include "stage/splat_film.h"

/* Which light path it is. They are numbered sample by sample: Sobol' points of one replicate, over
 * pixels and samples. */
typedef struct mcv_light_identity {
    uint replicate, stream, sample;
} mcv_light_identity;

/* 0: the camera path of that number has none. */
MCV_FUNCTION int mcv_identify_light(__constant const mcv_frame *frame, uint path,
                                    mcv_light_identity *id) {
    const uint set = frame->first_set + (path >> frame->log2_samples);
    const uint pixel = set / frame->replicates;
    const uint sample = frame->first_sample + (path & ((1u << frame->log2_samples) - 1u));
    const uint bits = frame->log2_pixels - frame->log2_thinning;
    if (pixel & ((1u << frame->log2_thinning) - 1u)) return 0;
    id->replicate = set % frame->replicates;
    id->sample = (sample << bits) | (pixel >> frame->log2_thinning);
    /* A shift by 32 bits would be none. */
    id->stream =
        mcv_hash_2(mcv_hash_2(frame->seed ^ 0x3c6ef372u, bits > 0u ? sample >> (32u - bits) : 0u),
                   id->replicate);
    return 1;
}

typedef struct mcv_light_path {
    mcv_vec3 origin, direction;
    mcv_color flux;       /* that started [W] */
    mcv_color throughput; /* since then */
    float etendue;        /* one over the density of its start; 0: camera paths do not find it */
    uint origin_surface;  /* the exact surface that it starts on (mcv_mark_origin_surface) */
    uint media;
    uint emitter;
    uint path_class; /* MCV_LIGHT_… */
    float length;    /* so far [m] */
} mcv_light_path;

enum {
    MCV_LIGHT_CARRIED = 1, /* has met a smooth or sharp surface, */
    MCV_LIGHT_OPEN = 2,    /* and no other one yet */
    MCV_LIGHT_SPREAD = 4,  /* has met a surface that spreads light */
    MCV_LIGHT_FOUND = 8    /* camera paths find it, too */
};

/* Surfaces that a light path meets before roulette may end it. */
#define MCV_LIGHT_ROULETTE_DEPTH 5u

#if MCV_WITH_EMISSION || MCV_WITH_PUNCTUAL
/* Towards one of the balls. */
MCV_FUNCTION mcv_vec3 mcv_aim(mcv_world world, mcv_vec3 from, mcv_cone *own, mcv_pair turn,
                              mcv_aiming *aimed) {
    mcv_cone cones[MCV_MAX_BALLS];
    return mcv_aim_anywhere(world.frame->balls, world.frame->ball_count, from, own, turn.x, turn.y,
                            cones, aimed);
}
#endif

#if MCV_WITH_EMISSION || MCV_WITH_BEAM
/* From a place uniform by area. */
static void mcv_leave_surface(mcv_world world, uint emitter, mcv_pair place, mcv_pair turn,
                              mcv_light_path *path) {
    __global const mcv_device_emitter *e = world.emitters + emitter;
    const mcv_emitter_point point =
        mcv_point_on_mesh(world, e, mcv_choose_triangle(world, e, place), place);
    const mcv_surface surface = mcv_surface_on(point.facet, point.u, point.v);
    (void)turn;
#if MCV_WITH_BEAM
    if (e->type == MCV_EMITTER_COLLIMATED_BEAM) {
        const mcv_vec3 from_middle =
            mcv_sub(surface.point, mcv_vec(e->middle[0], e->middle[1], e->middle[2]));
        path->direction = mcv_vec(e->beam.axis[0], e->beam.axis[1], e->beam.axis[2]);
        /* Only the disk has an edge inside. */
        if (e->beam.radius_squared < INFINITY && !mcv_collimated_beam_covers(&e->beam, from_middle))
            path->flux = mcv_grey(0.0f);
#if MCV_WITH_TEXTURE
        if (e->texture != MCV_NONE)
            path->flux = mcv_tint(path->flux, mcv_texture_at(world, surface, e->texture));
#endif
        path->origin =
            mcv_offset_origin(surface.point, surface.error, surface.face, path->direction);
        return;
    }
#endif
#if MCV_WITH_EMISSION
    float share = 1.0f;
    mcv_cone cone = mcv_own_cone(e, surface.normal);
    mcv_aiming aimed = {0.0f, 0u};
#if MCV_WITH_PROJECTOR
    if (e->type == MCV_EMITTER_PROJECTOR) {
        float cosine;
        path->direction =
            mcv_projector_emit(&e->projector, mcv_texcoord(world, surface, 0),
                               mcv_texcoord(world, surface, 1), turn.x, turn.y, &cosine);
        share = cosine * cosine * cosine * cosine;
    } else
#endif
        path->direction = mcv_aim(world, surface.point, &cone, turn, &aimed);
    path->etendue = mcv_etendue_of(e, aimed, surface.face, path->direction);
    if (!(path->etendue > 0.0f)) share = 0.0f;
    /* What was chosen in the emitter's own cone is in it, wherever rounding puts it. */
    path->flux = mcv_dim(cone.own && e->type == MCV_EMITTER_PARALLEL
                             ? mcv_full_radiance(world, surface, emitter)
                             : mcv_emitted(world, surface, emitter, path->direction),
                         share > 0.0f ? share * path->etendue : 0.0f);
    path->origin = mcv_offset_origin(surface.point, surface.error, surface.face, path->direction);
#endif
}
#endif

#if MCV_WITH_PUNCTUAL
static void mcv_leave_spot(mcv_world world, __global const mcv_device_emitter *e, mcv_pair turn,
                           mcv_light_path *path) {
    mcv_cone own;
    own.axis = mcv_vec(e->spot.axis[0], e->spot.axis[1], e->spot.axis[2]);
    own.squared = e->spot.edge < 1.0f ? e->spot.edge : 1.0f;
    own.own = 1;
    path->origin = mcv_vec(e->spot.position[0], e->spot.position[1], e->spot.position[2]);
    mcv_aiming all;
    path->direction = mcv_aim(world, path->origin, &own, turn, &all);
    const float angle = all.within > 0u ? all.angle / (float)all.within : 0.0f;
    path->flux = mcv_dim(path->flux, angle * mcv_spot_evaluate(&e->spot, path->direction));
}

/* From before all surfaces, on the disks that the balls throw. */
static void mcv_leave_directional(mcv_world world, __global const mcv_device_emitter *e,
                                  mcv_pair place, mcv_pair turn, mcv_light_path *path) {
    __constant const mcv_ball *balls = world.frame->balls;
    const mcv_vec3 axis =
        mcv_vec(e->directional.axis[0], e->directional.axis[1], e->directional.axis[2]);
    float cosine, sine;
    float sum = 0.0f;
    uint within = 0;
    uint chosen = 0;
    for (uint i = 0; i < world.frame->ball_count; ++i) sum += balls[i].radius * balls[i].radius;
    float remainder = turn.x * sum;
    for (; chosen + 1u < world.frame->ball_count &&
           remainder >= balls[chosen].radius * balls[chosen].radius;
         ++chosen)
        remainder -= balls[chosen].radius * balls[chosen].radius;
    const float r = balls[chosen].radius * mcv_disk(place.x, place.y, &cosine, &sine);
    const mcv_vec3 centre =
        mcv_vec(balls[chosen].centre[0], balls[chosen].centre[1], balls[chosen].centre[2]);
    const mcv_vec3 at = mcv_add(centre, mcv_from_frame(mcv_vec(r * cosine, r * sine, 0.0f), axis));
    for (uint i = 0; i < world.frame->ball_count; ++i) {
        const mcv_vec3 away = mcv_cross(
            mcv_sub(at, mcv_vec(balls[i].centre[0], balls[i].centre[1], balls[i].centre[2])), axis);
        within += i == chosen || mcv_dot(away, away) <= balls[i].radius * balls[i].radius;
    }
    path->direction = axis;
    path->origin = mcv_along(at, -e->directional.reach, axis);
    path->flux = mcv_dim(path->flux, MCV_PI * sum / (float)within);
}
#endif

static mcv_light_path mcv_leave_emitter(mcv_world world, uint emitter, mcv_pair place,
                                        mcv_pair turn) {
    __global const mcv_device_emitter *e = world.emitters + emitter;
    mcv_light_path path;
    MCV_EACH_CHANNEL(i) path.flux.c[i] = e->radiance[i] * e->light_flux;
    path.throughput = mcv_grey(1.0f);
    path.origin_surface = MCV_NONE;
    path.media = e->media;
    path.emitter = emitter;
    path.etendue = 0.0f;
    path.path_class = MCV_LIGHT_OPEN;
    path.length = 0.0f;
#if MCV_WITH_PUNCTUAL
    if (e->type == MCV_EMITTER_SPOT) {
        mcv_leave_spot(world, e, turn, &path);
        return path;
    }
    if (e->type == MCV_EMITTER_DIRECTIONAL) {
        mcv_leave_directional(world, e, place, turn, &path);
        return path;
    }
#endif
#if MCV_WITH_EMISSION || MCV_WITH_BEAM
    mcv_leave_surface(world, emitter, place, turn, &path);
#endif
    return path;
}

/* The flux that goes on from a surface about another normal than its triangle's, over what is
 * carried: see above. */
MCV_LOOP_FUNCTION float mcv_flux_correction(mcv_interaction interaction, mcv_vec3 out) {
#if MCV_WITH_NORMALS
    const float in_face = mcv_dot(interaction.direction, interaction.face);
    const float out_normal = mcv_dot(out, interaction.normal);
    const float factor = mcv_dot(interaction.direction, interaction.normal) *
                         mcv_dot(out, interaction.face) / (in_face * out_normal);
    return factor > 0.0f && factor < INFINITY ? factor : 0.0f;
#else
    (void)interaction, (void)out;
    return 1.0f;
#endif
}

#if MCV_WITH_BEAM
/* A beam from smooth surfaces, or straight from its emitter, comes to the plane of the lens before
 * t. */
static void mcv_enter_lens(mcv_world world, mcv_light_path path, float t, __global uint *splats,
                           uint replicate, float xi, uint counts[MCV_COUNTER_COUNT]) {
    mcv_sensor_ray sensor_ray;
    mcv_film_point place;
    const mcv_vec3 from = mcv_point_to_optical(world.frame, path.origin);
    const mcv_vec3 along = mcv_to_optical(world.frame, path.direction);
    if (!(from.z > 0.0f && along.z < 0.0f)) return;
    const float way = from.z / -along.z;
    if (!(way < t)) return;
    sensor_ray.origin = mcv_vec(mcv_fma(way, along.x, from.x), mcv_fma(way, along.y, from.y), 0.0f);
    sensor_ray.direction = mcv_vec(along.x / along.z, along.y / along.z, 1.0f);
    const float squared = mcv_dot(sensor_ray.direction, sensor_ray.direction);
    const float importance =
        mcv_sensor_invert(world.sensor, sensor_ray, &place) * squared * squared;
    if (!(importance > 0.0f)) return;
    mcv_color value = mcv_dim(mcv_tint(path.flux, path.throughput), importance);
#if MCV_WITH_ABSORPTION
    value = mcv_tint(value, mcv_medium_transmittance(world, path.media, way));
#endif
    mcv_splat(world, splats, replicate, place, value, xi, counts);
}
#endif

#if MCV_WITH_NEXT_EVENT
/* What plates leave of light from a place (on the surface `begun`, mcv_mark_origin_surface) to
 * another, at most so many of them; 0 where anything else is between. */
static mcv_color mcv_sheet_transmittance(mcv_world world, mcv_vec3 origin, uint begun, mcv_vec3 end,
                                         uint media, uint plates, uint counts[MCV_COUNTER_COUNT]) {
    mcv_color transmittance = mcv_grey(1.0f);
#if MCV_WITH_SHEET
    const mcv_pair never_reflect = {1.0f, 0.0f};
    for (;; --plates) {
        const mcv_vec3 way = mcv_sub(end, origin);
        const mcv_hit hit = mcv_closest_within(world, origin, way, begun);
        ++counts[MCV_COUNTER_shadow_rays];
        if (hit.triangle == MCV_NONE) return transmittance;
        const mcv_interaction interaction =
            mcv_meet_at(mcv_hit_surface(world, origin, way, hit), mcv_normalize(way));
        if (plates == 0 || !mcv_is_sheet(world, interaction)) return mcv_grey(0.0f);
        mcv_scattering other;
        const mcv_scattering on = mcv_scatter(world, interaction, media, never_reflect, 0.0f, 0,
                                              &counts[MCV_COUNTER_unmatched], &other);
        transmittance = on.event == MCV_EVENT_PASS
                            ? mcv_dim(mcv_tint(transmittance, on.factor), on.chance)
                            : mcv_grey(0.0f);
        if (!(mcv_brightest(transmittance) > 0.0f)) return transmittance;
        origin = mcv_offset_origin(interaction.surface.point, interaction.surface.error,
                                   interaction.face, way);
#if MCV_WITH_SURFACES
        begun = mcv_mark_origin_surface(world, interaction.surface, way);
#endif
    }
#else
    ++counts[MCV_COUNTER_shadow_rays];
    const mcv_vec3 way = mcv_sub(end, origin);
    int blocked = mcv_intersect_any_ray(world.nodes, world.leaves, origin, way, 1.0f);
#if MCV_WITH_SURFACES
    blocked =
        blocked ||
        mcv_intersect_solids_along(world, origin, way, begun, mcv_miss(1.0f)).triangle != MCV_NONE;
#else
    (void)begun;
#endif
    if (blocked) transmittance = mcv_grey(0.0f);
    (void)media, (void)plates;
#endif
    return transmittance;
}

/* What a surface may send to a place on the lens. */
typedef struct mcv_connection {
    mcv_vec3 origin, end;
    uint begun,
        media; /* the surface, as mcv_mark_origin_surface tells it, and what the light is in */
    mcv_film_point place;
    mcv_color value; /* that it brings there, if nothing is between */
} mcv_connection;

/* 0: none. `rival`: if camera paths find what arrives, too, one over the density of its start, else
 * 0. */
MCV_FUNCTION int mcv_connect(mcv_world world, mcv_interaction interaction, mcv_color flux,
                             float rival, uint media, mcv_pair pair, mcv_connection *connection) {
    mcv_sensor_ray sensor_ray;
    mcv_film_point place;
    const mcv_vec3 point = mcv_point_to_optical(world.frame, interaction.surface.point);
    if (!(point.z > 0.0f)) return 0;
    const float area = mcv_sensor_connect(world.sensor, point, pair.x, pair.y, &sensor_ray);
    const float importance = mcv_sensor_invert(world.sensor, sensor_ray, &place) * area;
    if (!(importance > 0.0f)) return 0;
    if (!(place.column >= 0.0f && place.column < (float)world.frame->width && place.row >= 0.0f &&
          place.row < (float)world.frame->height))
        return 0;
    const mcv_ray seen = mcv_place_sensor_ray(world.frame, sensor_ray);
    const mcv_vec3 out = mcv_scale(seen.direction, -1.0f);
    const mcv_response response = mcv_respond(world, interaction, media, out);
    const float d = mcv_sqrt(mcv_dot(sensor_ray.direction, sensor_ray.direction));
    mcv_color value =
        mcv_dim(mcv_tint(flux, response.value),
                mcv_flux_correction(interaction, out) * importance * d / (point.z * point.z));
    if (rival > 0.0f)
        value = mcv_dim(value,
                        mcv_light_share(world, rival, mcv_sensor_footprint(world.sensor, point.z)));
#if MCV_WITH_ABSORPTION
    value = mcv_tint(value, mcv_medium_transmittance(world, response.media, point.z * d));
#endif
    connection->origin = mcv_offset_origin(interaction.surface.point, interaction.surface.error,
                                           interaction.face, out);
    connection->end = seen.origin;
    connection->begun = MCV_NONE;
#if MCV_WITH_SURFACES
    connection->begun = mcv_origin_surface_of(world, interaction, out);
#endif
    connection->media = response.media;
    connection->place = place;
    connection->value = value;
    return mcv_brightest(response.value) > 0.0f;
}
#endif

/* What the `range` of a point or spot light leaves, by the way to the first surface that spreads
 * light. */
MCV_LOOP_FUNCTION float mcv_within_range(__global const mcv_device_emitter *e, float length) {
#if MCV_WITH_PUNCTUAL
    if (e->type == MCV_EMITTER_SPOT)
        return mcv_spot_attenuation(&e->spot, length * length) * length * length;
#endif
    (void)e, (void)length;
    return 1.0f;
}

/* What the depth limit cuts, in units of 2^-11. */
MCV_FUNCTION uint mcv_lost_light(mcv_color throughput) {
    return (uint)(fmin(mcv_brightest(throughput), 1.0f) * 2048.0f + 0.5f);
}

static mcv_light_path mcv_begin_light_path(mcv_world world, mcv_pair which, mcv_pair place,
                                           mcv_pair turn) {
    /* The emitter takes the place of surface 0. */
    __global const uint *cdf = world.emitter_cdf + world.frame->light_cdf;
    const uint emitter =
        mcv_search_cdf(cdf, world.frame->emitter_count, mcv_cdf_bits(which.x, which.y));
    mcv_light_path path = mcv_leave_emitter(world, emitter, place, turn);
    if (path.etendue > 0.0f) path.path_class |= MCV_LIGHT_FOUND;
    return path;
}

#if MCV_WITH_DISPERSION
/* Keeps one channel at a dielectric; the world as the path's light meets it. */
MCV_FUNCTION mcv_world mcv_disperse_light(mcv_world world, mcv_light_identity id,
                                          mcv_interaction interaction, mcv_light_path *path) {
    if (world.materials[world.instances[interaction.surface.instance].material].type ==
        MCV_MATERIAL_DIELECTRIC) {
        float chance;
        const float xi = mcv_sample_pair(id.stream, id.sample, MCV_PAIR_CHANNEL).x;
        const uint channel =
            mcv_choose_channel(mcv_tint(path->flux, path->throughput), xi, &chance);
        path->throughput = mcv_keep_channel(path->throughput, channel, chance);
    }
    return mcv_in_channel(world, mcv_kept_channel(path->throughput));
}
#endif

/* Is what comes to the surface left to camera paths? */
MCV_LOOP_FUNCTION int mcv_is_left_to_camera(mcv_world world, mcv_interaction interaction,
                                            uint path_class) {
    return ((path_class & MCV_LIGHT_FOUND) != 0u) & !mcv_is_connectable(world, interaction);
}

#if MCV_WITH_NEXT_EVENT
/* Sends what arrives at a surface that spreads light to a place on the lens: mcv_connect. */
MCV_FUNCTION int mcv_connect_light(mcv_world world, mcv_interaction interaction,
                                   mcv_light_path path, mcv_pair pair, mcv_connection *connection) {
    if (!(path.path_class & MCV_LIGHT_CARRIED) ||
        mcv_is_left_to_camera(world, interaction, path.path_class))
        return 0;
    if (!world.materials[world.instances[interaction.surface.instance].material].scattering_sides)
        return 0;
    const float share = path.path_class & MCV_LIGHT_SPREAD
                            ? 1.0f
                            : mcv_within_range(world.emitters + path.emitter, path.length);
    return mcv_connect(world, interaction, mcv_dim(mcv_tint(path.flux, path.throughput), share),
                       path.etendue, path.media, pair, connection);
}
#endif

/*
 * A light path continues from a surface that has scattered it so: all but its origin. Returns
 * whether it does. Roulette plays for what it carries of its start.
 */
MCV_LOOP_FUNCTION int mcv_continue_light_path(mcv_world world, const mcv_interaction *interaction,
                                              mcv_shading shading, mcv_scattering on, uint depth,
                                              float xi, mcv_light_path *path) {
    const uint before = path->path_class;
    const int carried = (before & MCV_LIGHT_CARRIED) != 0u, open = (before & MCV_LIGHT_OPEN) != 0u;
    const int scatters = on.density > 0.0f,
              parts = scatters & !(open & mcv_is_near_specular(world, *interaction));
    const int first = scatters & ((before & MCV_LIGHT_SPREAD) == 0u);
    /* What comes straight from the emitter, next-event estimation has; what comes to a glossy
     * surface, camera paths. */
    const int class_end =
        parts & (!carried | (open & mcv_is_left_to_camera(world, *interaction, before)));
    /* The first surface finds the emitter by next-event estimation. */
    const uint after =
        before | MCV_LIGHT_CARRIED | ((scatters & !carried) ? (uint)MCV_LIGHT_FOUND : 0u);
    mcv_color throughput = mcv_tint(path->throughput, on.factor);
    const mcv_roulette roulette =
        mcv_play_roulette(depth >= MCV_LIGHT_ROULETTE_DEPTH, mcv_brightest(throughput), 1.0f, xi);
    const float correction = mcv_flux_correction(*interaction, on.direction);
    const float within = mcv_within_range(world.emitters + path->emitter, path->length);
    throughput = mcv_dim(mcv_dim(throughput, parts ? correction : 1.0f), first ? within : 1.0f);
    path->throughput = mcv_after_roulette(roulette, throughput);
    path->path_class =
        (parts ? before & ~(uint)MCV_LIGHT_OPEN : after) | (scatters ? (uint)MCV_LIGHT_SPREAD : 0u);
    path->direction = on.direction;
    path->media = on.media;
#if MCV_WITH_SURFACES
    path->origin_surface =
        shading.exact ? mcv_origin_surface_of(world, *interaction, on.direction) : MCV_NONE;
#endif
    (void)shading;
    return roulette.survives & !class_end;
}

/* Whether the path continues from the surface, and how. */
MCV_FUNCTION int mcv_shade_any_light_hit(mcv_world world, mcv_interaction interaction,
                                         mcv_pair pair, mcv_pair choice, uint depth,
                                         uint *unmatched, mcv_light_path *path) {
    mcv_scattering other;
    /* It would end there: mcv_continue_light_path. */
    if (!(path->path_class & MCV_LIGHT_CARRIED) && mcv_is_connectable(world, interaction)) return 0;
    const mcv_scattering on =
        mcv_scatter(world, interaction, path->media, pair, choice.x, 0, unmatched, &other);
    path->origin = mcv_onward_origin(interaction, on.direction);
    return mcv_continue_light_path(world, &interaction, mcv_any_shading(), on, depth, choice.y,
                                   path);
}

MCV_FUNCTION void mcv_trace_light_path(mcv_world world, uint index, __global uint *splats,
                                       uint counts[MCV_COUNTER_COUNT]) {
    mcv_light_identity id;
    if (!mcv_identify_light(world.frame, index, &id)) return;
    mcv_light_path path = mcv_begin_light_path(
        world, mcv_sample_pair(id.stream, id.sample, MCV_SURFACE_PAIR(0u, MCV_PAIR_CHOICE)),
        mcv_sample_pair(id.stream, id.sample, MCV_SURFACE_PAIR(0u, MCV_PAIR_EMITTER)),
        mcv_sample_pair(id.stream, id.sample, MCV_SURFACE_PAIR(0u, MCV_PAIR_SCATTER)));
    if (!(mcv_brightest(path.flux) > 0.0f)) return;

    for (uint depth = 1; depth < world.frame->depth; ++depth) {
        const mcv_pair choice =
            mcv_sample_pair(id.stream, id.sample, MCV_SURFACE_PAIR(depth, MCV_PAIR_CHOICE));
        const mcv_hit hit = mcv_closest(world, path.origin, path.direction, path.origin_surface);
        ++counts[MCV_COUNTER_rays];
#if MCV_WITH_BEAM
        if (world.emitters[path.emitter].type == MCV_EMITTER_COLLIMATED_BEAM &&
            !(path.path_class & MCV_LIGHT_SPREAD))
            mcv_enter_lens(world, path, hit.t, splats, id.replicate, choice.x, counts);
#endif
        if (hit.triangle == MCV_NONE) return;
        path.length += hit.t;
#if MCV_WITH_ABSORPTION
        path.throughput =
            mcv_tint(path.throughput, mcv_medium_transmittance(world, path.media, hit.t));
#endif
        const mcv_interaction interaction = mcv_meet(world, path.origin, path.direction, hit);
#if MCV_WITH_DISPERSION
        const mcv_world seen = mcv_disperse_light(world, id, interaction, &path);
#else
        const mcv_world seen = world;
#endif
#if MCV_WITH_NEXT_EVENT
        mcv_connection connection;
        const mcv_pair pupil =
            mcv_sample_pair(id.stream, id.sample, MCV_SURFACE_PAIR(depth, MCV_PAIR_EMITTER));
        if (mcv_connect_light(seen, interaction, path, pupil, &connection)) {
            const mcv_color transmittance =
                mcv_sheet_transmittance(seen, connection.origin, connection.begun, connection.end,
                                        connection.media, world.frame->depth - 1u - depth, counts);
            if (mcv_brightest(transmittance) > 0.0f)
                mcv_splat(world, splats, id.replicate, connection.place,
                          mcv_tint(connection.value, transmittance), choice.x, counts);
        }
#endif
        const mcv_pair pair =
            mcv_sample_pair(id.stream, id.sample, MCV_SURFACE_PAIR(depth, MCV_PAIR_SCATTER));
        if (!mcv_shade_any_light_hit(seen, interaction, pair, choice, depth,
                                     &counts[MCV_COUNTER_unmatched], &path))
            return;
    }
    ++counts[MCV_COUNTER_depth_cut];
    counts[MCV_COUNTER_lost] += mcv_lost_light(path.throughput);
}

#endif
