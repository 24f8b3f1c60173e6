/* SPDX-License-Identifier: Apache-2.0 */
/* The tile schedule's loops that begin the light paths of a slice, and their state in its rows. */
#ifndef MCVISI_KERNELS_BEGIN_LIGHT_PATHS_H
#define MCVISI_KERNELS_BEGIN_LIGHT_PATHS_H

#include "light/leave_emitter.h"
#include "path/camera_path.h"
#include "schedule/compact.h"

#if MCV_LIGHT_ROWS
MCV_LOOP_FUNCTION mcv_light_path mcv_load_light_path(mcv_slot slot) {
    mcv_light_path path;
    path.origin = MCV_LOAD_3(slot, origin);
    path.direction = MCV_LOAD_3(slot, direction);
    MCV_LOAD_COLOR(slot, light_flux, path.flux);
    MCV_LOAD_COLOR(slot, throughput, path.throughput);
    path.etendue = MCV_LOAD(slot, light_etendue, 0);
    path.origin_surface = MCV_NONE;
#if MCV_WITH_SURFACES
    path.origin_surface = MCV_WORD(slot, origin_surface, 0);
#endif
    path.media = mcv_path_media(slot);
    path.emitter = MCV_WORD(slot, light_emitter, 0);
    path.path_class = MCV_WORD(slot, light_class, 0);
    path.length = MCV_LOAD(slot, light_length, 0);
    return path;
}

/* What changes from surface to surface, but for the origin; skipped: 1 leaves it as it is, known to
 * the compiler where that cannot be. */
MCV_LOOP_FUNCTION void mcv_store_light_step(mcv_slot slot, int skipped, mcv_light_path path) {
    const mcv_vec3 direction = mcv_choose(skipped, MCV_LOAD_3(slot, direction), path.direction);
    MCV_STORE_3(slot, direction, direction);
    MCV_EACH_CHANNEL(c)
    MCV_STORE(slot, throughput, c, skipped ? MCV_LOAD(slot, throughput, c) : path.throughput.c[c]);
#if MCV_WITH_SURFACES
    MCV_WORD(slot, origin_surface, 0) =
        skipped ? MCV_WORD(slot, origin_surface, 0) : path.origin_surface;
#endif
#if MCV_WITH_DIELECTRIC
    MCV_WORD(slot, media, 0) = skipped ? MCV_WORD(slot, media, 0) : path.media;
#endif
    MCV_WORD(slot, light_class, 0) = skipped ? MCV_WORD(slot, light_class, 0) : path.path_class;
}

MCV_LOOP_FUNCTION void mcv_store_light_path(mcv_slot slot, mcv_light_path path) {
    mcv_store_light_step(slot, 0, path);
    MCV_STORE_3(slot, origin, path.origin);
    MCV_STORE_COLOR(slot, light_flux, path.flux);
    MCV_STORE(slot, light_etendue, 0, path.etendue);
    MCV_WORD(slot, light_emitter, 0) = path.emitter;
    MCV_STORE(slot, light_length, 0, path.length);
}

/* Whether all emitters that light paths start at are areas that shine alike everywhere. */
#define MCV_WITH_LAMPS \
    (MCV_WITH_AREA && !MCV_WITH_TEXTURE && !MCV_WITH_PARALLEL && !MCV_WITH_LIGHT_FIELD && \
     !MCV_WITH_PROJECTOR && !MCV_WITH_PUNCTUAL)

#if MCV_WITH_LAMPS
/* The cone that a ball fills from a path's place on its lamp. */
MCV_LOOP_FUNCTION mcv_cone mcv_lamp_cone(mcv_world world, mcv_slot slot, mcv_ball ball) {
    return mcv_cone_to(ball, MCV_LOAD_3(slot, point),
                       mcv_own_cone(world.emitters, MCV_LOAD_3(slot, normal)));
}

/* mcv_aim_anywhere from the places on their lamps, ball by ball; angle and within as in
 * mcv_aiming. */
static __attribute__((noinline)) void mcv_aim_lamps(mcv_world world, mcv_slot slot, uint count,
                                                    float *angle, uint *within) {
    float ahead[MCV_SLOTS], remainder[MCV_SLOTS], squared[MCV_SLOTS];
    __constant const mcv_ball *balls = world.frame->balls;
    const uint ball_count = world.frame->ball_count;
    for (uint i = 0; i < count; ++i) {
        angle[i] = 0.0f;
        within[i] = 0u;
    }
    for (uint k = 0; k < ball_count; ++k) {
        const mcv_ball ball = balls[k];
        MCV_VECTORIZE
        for (uint i = 0; i < count; ++i) {
            slot.index = i;
            angle[i] += mcv_lamp_cone(world, slot, ball).squared;
        }
    }
    MCV_VECTORIZE
    for (uint i = 0; i < count; ++i) {
        slot.index = i;
        const mcv_aim aim = mcv_begin_aim(mcv_own_cone(world.emitters, MCV_LOAD_3(slot, normal)),
                                          angle[i] * MCV_LOAD(slot, drawn, 2 * MCV_PAIR_SCATTER));
        MCV_STORE_3(slot, bounce, aim.cone.axis);
        squared[i] = aim.cone.squared;
        ahead[i] = aim.ahead;
        remainder[i] = aim.remainder;
        angle[i] *= 4.0f * MCV_PI;
    }
    for (uint k = 0; k < ball_count; ++k) {
        const mcv_ball ball = balls[k];
        MCV_VECTORIZE
        for (uint i = 0; i < count; ++i) {
            slot.index = i;
            const mcv_aim so_far = {
                {MCV_LOAD_3(slot, bounce), squared[i], 0}, ahead[i], remainder[i]};
            const mcv_aim aim = mcv_ask_cone(so_far, mcv_lamp_cone(world, slot, ball));
            MCV_STORE_3(slot, bounce, aim.cone.axis);
            squared[i] = aim.cone.squared;
            ahead[i] = aim.ahead;
            remainder[i] = aim.remainder;
        }
    }
    MCV_VECTORIZE
    for (uint i = 0; i < count; ++i) {
        slot.index = i;
        const mcv_aim aim = {{MCV_LOAD_3(slot, bounce), squared[i], 0}, ahead[i], remainder[i]};
        const mcv_vec3 direction =
            mcv_aim_direction(aim, MCV_LOAD(slot, drawn, 2 * MCV_PAIR_SCATTER + 1));
        MCV_STORE_3(slot, direction, direction);
    }
    for (uint k = 0; k < ball_count; ++k) {
        const mcv_ball ball = balls[k];
        MCV_VECTORIZE
        for (uint i = 0; i < count; ++i) {
            slot.index = i;
            within[i] +=
                (uint)mcv_is_in_cone(mcv_lamp_cone(world, slot, ball), MCV_LOAD_3(slot, direction));
        }
    }
}

/* mcv_leave_surface for many paths; `sends`: whether they carry anything. */
static __attribute__((noinline)) void mcv_leave_lamps(mcv_world world, mcv_slot slot, uint count,
                                                      uint *sends) {
    float angle[MCV_SLOTS];
    uint within[MCV_SLOTS];
    for (slot.index = 0; slot.index < count; ++slot.index) {
        const uint emitter = mcv_choose_light(world, mcv_draw(slot, 0, MCV_PAIR_CHOICE));
        MCV_WORD(slot, light_emitter, 0) = emitter;
        MCV_WORD(slot, hit, 3) = mcv_choose_triangle(world, world.emitters + emitter,
                                                     mcv_draw(slot, 0, MCV_PAIR_EMITTER));
    }
    MCV_VECTORIZE
    for (uint i = 0; i < count; ++i) {
        slot.index = i;
        const mcv_emitter_point point =
            mcv_point_on_mesh(world, world.emitters + MCV_WORD(slot, light_emitter, 0),
                              MCV_WORD(slot, hit, 3), mcv_draw(slot, 0, MCV_PAIR_EMITTER));
        const mcv_surface surface = mcv_surface_on(point.facet, point.u, point.v);
        MCV_STORE_3(slot, point, surface.point);
        MCV_STORE_3(slot, error, surface.error);
        MCV_STORE_3(slot, face, surface.face);
        MCV_STORE_3(slot, normal, surface.normal);
    }
    mcv_aim_lamps(world, slot, count, angle, within);
    MCV_VECTORIZE
    for (uint i = 0; i < count; ++i) {
        slot.index = i;
        const mcv_aiming aimed = {angle[i], within[i]};
        mcv_light_path path = mcv_make_light_path(world, MCV_WORD(slot, light_emitter, 0));
        mcv_surface surface;
        surface.point = MCV_LOAD_3(slot, point);
        surface.error = MCV_LOAD_3(slot, error);
        surface.face = MCV_LOAD_3(slot, face);
        surface.normal = MCV_LOAD_3(slot, normal);
        mcv_leave_point(world, surface, MCV_LOAD_3(slot, direction), aimed, 1.0f, 0, &path);
        mcv_store_light_path(slot, path);
        sends[i] = (uint)(mcv_brightest(path.flux) > 0.0f);
    }
}
#endif

/* Begins so many light paths, whose pairs are drawn; returns how many carry anything. */
static __attribute__((noinline)) uint mcv_begin_light_paths(mcv_world world, mcv_slot slot,
                                                            uint count) {
    uint sends[MCV_ROW], begun[MCV_SLOTS];
#if MCV_WITH_LAMPS
    mcv_leave_lamps(world, slot, count, sends);
#else
    for (slot.index = 0; slot.index < count; ++slot.index) {
        const mcv_light_path path = mcv_begin_light_path(world, mcv_draw(slot, 0, MCV_PAIR_CHOICE),
                                                         mcv_draw(slot, 0, MCV_PAIR_EMITTER),
                                                         mcv_draw(slot, 0, MCV_PAIR_SCATTER));
        mcv_store_light_path(slot, path);
        sends[slot.index] = (uint)(mcv_brightest(path.flux) > 0.0f);
    }
#endif
    const uint next = mcv_compact_indices(sends, count, begun);
    if (next < count) mcv_move_paths(slot.base, begun, next);
    return next;
}

/* Begins the next light paths of the launch's paths *next … last - 1, as many as there is room for;
 * returns how many. */
static __attribute__((noinline)) uint mcv_fill_light_slice(mcv_world world, mcv_slot slot,
                                                           uint *next, uint last) {
    const uint samples = 1u << world.frame->log2_samples;
    uint count = 0;
    while (*next < last && count < MCV_SLICE) {
        mcv_light_identity id;
        if (!mcv_identify_light(world.frame, *next, &id)) {
            *next = (*next | (samples - 1u)) + 1u;
            continue;
        }
        slot.index = count++;
        MCV_WORD(slot, stream, 0) = id.stream;
        MCV_WORD(slot, sample, 0) = id.sample;
        MCV_WORD(slot, light_replicate, 0) = id.replicate;
        ++*next;
    }
    mcv_draw_pairs(slot.base, 0, count, 0, MCV_PAIR_CHOICE);
    mcv_draw_pairs(slot.base, 0, count, 0, MCV_PAIR_EMITTER);
    mcv_draw_pairs(slot.base, 0, count, 0, MCV_PAIR_SCATTER);
    return mcv_begin_light_paths(world, slot, count);
}
#endif

#endif
