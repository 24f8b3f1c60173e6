/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Where light paths start: at a point of an emitter's surface, at a point light, or before all
 * surfaces in the light of a far one. A schedule that starts many at once loops over the same
 * steps.
 */
#ifndef MCVISI_KERNELS_LEAVE_EMITTER_H
#define MCVISI_KERNELS_LEAVE_EMITTER_H

#include "light/emitter_point.h"
#include "light/laser.h"
#include "light/light_path.h"
#include "path/identity.h"

#if MCV_WITH_LIGHT_TRACING
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
    uint emitter, emitter_element; /* light/emitter_element.h */
    uint light_flags;              /* MCV_LIGHT_FLAG_… */
    float length;                  /* so far [m] */
} mcv_light_path;

enum {
    MCV_LIGHT_FLAG_CARRIED = 1, /* has met a smooth or near-specular surface, */
    MCV_LIGHT_FLAG_OPEN = 2,    /* and no other one yet */
    MCV_LIGHT_FLAG_SPREAD = 4,  /* has met a scattering surface */
    MCV_LIGHT_FLAG_FOUND = 8    /* camera paths find it, too */
};

/* A path of an emitter, before it is known where it starts. */
MCV_LOOP_FUNCTION mcv_light_path mcv_make_light_path(mcv_world world, uint emitter) {
    __global const mcv_device_emitter *e = world.emitters + emitter;
    mcv_light_path path;
    path.flux = mcv_dim(mcv_color_at(e->radiance), e->light_inverse_pdf);
    path.throughput = mcv_grey(1.0f);
    path.origin_surface = MCV_NONE;
    path.media = e->media;
    path.emitter = emitter;
    path.emitter_element = mcv_first_emitter_element(world, emitter);
    path.etendue = 0.0f;
    path.light_flags = MCV_LIGHT_FLAG_OPEN;
    path.length = 0.0f;
    return path;
}

/* The emitter, by flux. It takes the place of surface 0. */
MCV_FUNCTION uint mcv_choose_light(mcv_world world, mcv_pair pair) {
    return mcv_search_cdf(world.emitter_cdf + world.frame->light_cdf, world.frame->emitter_count,
                          mcv_cdf_bits(pair.x, pair.y));
}

#if MCV_HAS_EMISSION
/* The path leaves a point in a direction. factor: of the flux, where the density in étendue is not
 * even: cos⁴ of a projector; in_emission_cone: whether the direction was chosen in the emission
 * cone, where it is, wherever rounding puts it. */
MCV_LOOP_FUNCTION void mcv_leave_point(mcv_world world, mcv_surface surface, mcv_vec3 direction,
                                       mcv_aiming aimed, float factor, int in_emission_cone,
                                       mcv_light_path *path) {
    __global const mcv_device_emitter *e = world.emitters + path->emitter;
    mcv_color radiance = mcv_full_radiance(world, surface, path->emitter);
    const float profile = mcv_angular_profile(e, surface.ng, surface.ns, direction);
    float sent = (in_emission_cone & (e->type == MCV_EMITTER_PARALLEL)) ? 1.0f : profile;
#if MCV_WITH_TEXTURE
    if (MCV_SENDS_BY_PIXEL(e)) {
        radiance = mcv_emitted(world, surface, path->emitter, direction);
        sent = 1.0f;
    }
#endif
    path->direction = direction;
    path->emitter_element = mcv_emitter_element_of(world, path->emitter, surface, direction);
    path->etendue = mcv_etendue_of(e, aimed, surface.ng, direction);
    factor *= sent;
    const int sends = (path->etendue > 0.0f) & (factor > 0.0f);
    MCV_EACH_CHANNEL(i) {
        const float flux = radiance.c[i] * (factor * path->etendue);
        path->flux.c[i] = sends ? flux : 0.0f;
    }
    path->origin = mcv_offset_origin(surface.point, surface.error, surface.ng, direction);
    path->light_flags |= path->etendue > 0.0f ? (uint)MCV_LIGHT_FLAG_FOUND : 0u;
}
#endif

#if MCV_HAS_EMISSION || MCV_WITH_PUNCTUAL
/* Towards one of the balls. */
MCV_FUNCTION mcv_vec3 mcv_aim_light(mcv_world world, mcv_vec3 from, mcv_cone *cone, mcv_pair pair,
                                    mcv_aiming *aimed) {
    return mcv_aim_anywhere(world.frame->balls, world.frame->ball_count, from, cone, pair.x, pair.y,
                            aimed);
}
#endif

#if MCV_WITH_BEAM
/* The path leaves a point along the beam. */
MCV_FUNCTION void mcv_leave_along_beam(mcv_world world, mcv_surface surface, mcv_light_path *path) {
    __global const mcv_device_emitter *e = world.emitters + path->emitter;
    path->direction = mcv_vec_at(e->beam.axis);
    /* Only the disk has an edge inside. */
    if (e->beam.radius_squared < INFINITY &&
        !mcv_collimated_beam_covers(&e->beam, mcv_sub(surface.point, mcv_vec_at(e->middle))))
        path->flux = mcv_grey(0.0f);
#if MCV_WITH_TEXTURE
    if (e->texture != MCV_NONE)
        path->flux = mcv_tint(path->flux, mcv_texture_at(world, surface, e->texture));
    path->emitter_element = mcv_emitter_element_of(world, path->emitter, surface, path->direction);
#endif
    path->origin = mcv_offset_origin(surface.point, surface.error, surface.ng, path->direction);
}
#endif

#if MCV_HAS_EMISSION || MCV_WITH_BEAM
/* From a point uniform by area. */
MCV_FUNCTION void mcv_leave_surface(mcv_world world, mcv_pair place, mcv_pair turn,
                                    mcv_light_path *path) {
    __global const mcv_device_emitter *e = world.emitters + path->emitter;
    const mcv_emitter_point point =
        mcv_point_on_mesh(world, e, mcv_choose_triangle(world, e, place), place);
    const mcv_surface surface = mcv_surface_on(point.facet, point.u, point.v);
    (void)turn;
#if MCV_WITH_BEAM
    if (e->type == MCV_EMITTER_COLLIMATED_BEAM) {
        mcv_leave_along_beam(world, surface, path);
        return;
    }
#endif
#if MCV_HAS_EMISSION
    mcv_cone cone = mcv_emission_cone(e, surface.ns);
    mcv_aiming aimed = {0.0f, 0u};
    mcv_vec3 direction;
    float factor = 1.0f;
#if MCV_WITH_PROJECTOR
    if (e->type == MCV_EMITTER_PROJECTOR) {
        float cosine;
        direction = mcv_projector_emit(&e->projector, mcv_texcoord(world, surface, 0),
                                       mcv_texcoord(world, surface, 1), turn.x, turn.y, &cosine);
        factor = cosine * cosine * cosine * cosine;
    } else
#endif
        direction = mcv_aim_light(world, surface.point, &cone, turn, &aimed);
    mcv_leave_point(world, surface, direction, aimed, factor, cone.is_emission_cone, path);
#endif
}
#endif

#if MCV_WITH_PUNCTUAL
MCV_FUNCTION void mcv_leave_point_light(mcv_world world, mcv_pair turn, mcv_light_path *path) {
    __global const mcv_device_emitter *e = world.emitters + path->emitter;
    mcv_cone cone;
    mcv_aiming all;
    cone.axis = mcv_vec_at(e->light.axis);
    cone.squared = e->light.edge;
    cone.is_emission_cone = 1;
    path->origin = mcv_vec_at(e->light.position);
    path->direction = mcv_aim_light(world, path->origin, &cone, turn, &all);
    const float angle = all.within > 0u ? all.angle / (float)all.within : 0.0f;
    path->flux = mcv_dim(path->flux, angle * mcv_point_light_profile(&e->light, path->direction));
}

/* From before all surfaces, on the disks that the balls throw: one by its area, and with the
 * density of all that hold the point. */
MCV_FUNCTION void mcv_leave_directional(mcv_world world, mcv_pair place, mcv_pair turn,
                                        mcv_light_path *path) {
    __global const mcv_device_emitter *e = world.emitters + path->emitter;
    __constant const mcv_ball *balls = world.frame->balls;
    const uint count = world.frame->ball_count;
    const mcv_vec3 axis = mcv_vec_at(e->directional.axis);
    float cosine, sine, sum = 0.0f;
    uint within = 0, chosen = 0;
    for (uint i = 0; i < count; ++i) sum += balls[i].radius * balls[i].radius;
    float ahead = turn.x * sum;
    for (; chosen + 1u < count && ahead >= balls[chosen].radius * balls[chosen].radius; ++chosen)
        ahead -= balls[chosen].radius * balls[chosen].radius;
    const float r = balls[chosen].radius * mcv_disk(place.x, place.y, &cosine, &sine);
    const mcv_vec3 at = mcv_add(mcv_ball_centre(balls[chosen]),
                                mcv_from_frame(mcv_vec(r * cosine, r * sine, 0.0f), axis));
    for (uint i = 0; i < count; ++i) {
        const mcv_vec3 away = mcv_cross(mcv_sub(at, mcv_ball_centre(balls[i])), axis);
        within += i == chosen || mcv_dot(away, away) <= balls[i].radius * balls[i].radius;
    }
    path->direction = axis;
    path->origin = mcv_along(at, -e->directional.reach, axis);
    path->flux = mcv_dim(path->flux, MCV_PI * sum / (float)within);
}
#endif

MCV_FUNCTION mcv_light_path mcv_begin_light_path(mcv_world world, mcv_pair which, mcv_pair place,
                                                 mcv_pair turn) {
    mcv_light_path path = mcv_make_light_path(world, mcv_choose_light(world, which));
#if MCV_WITH_LASER || MCV_WITH_PUNCTUAL
    const uint type = world.emitters[path.emitter].type;
#endif
#if MCV_WITH_LASER
    if (type == MCV_EMITTER_LASER) {
        const float power_over_pdf =
            mcv_leave_laser(world, path.emitter, place, turn, &path.origin, &path.direction);
        path.flux = mcv_dim(path.flux, power_over_pdf);
        return path;
    }
#endif
#if MCV_WITH_PUNCTUAL
    if (type == MCV_EMITTER_POINT) {
        mcv_leave_point_light(world, turn, &path);
        return path;
    }
    if (type == MCV_EMITTER_DIRECTIONAL) {
        mcv_leave_directional(world, place, turn, &path);
        return path;
    }
#endif
#if MCV_HAS_EMISSION || MCV_WITH_BEAM
    mcv_leave_surface(world, place, turn, &path);
#else
    (void)place, (void)turn;
#endif
    return path;
}
#endif

#endif
