/* SPDX-License-Identifier: Apache-2.0 */
/* The tile schedule's loops that begin the light paths of a slice, and their state in its rows. */
#ifndef MCVISI_KERNELS_BEGIN_LIGHT_PATHS_H
#define MCVISI_KERNELS_BEGIN_LIGHT_PATHS_H

#include "schedule/tile.h"

#include "light/leave_emitter.h"
#include "path/camera_path.h"
#include "schedule/compact.h"
#include "schedule/sort_paths.h"
#include "schedule/surface_rows.h"
#include "schedule/vectorize.h"

#if MCV_WITH_LIGHT_TRACING
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
    /* Values are chosen among, not places in memory: with these a loop over paths would not be
     * vectorised. */
    MCV_EACH_CHANNEL(c) {
        const float before = MCV_LOAD(slot, throughput, c);
        const float carried = path.throughput.c[c];
        MCV_STORE(slot, throughput, c, skipped ? before : carried);
    }
#if MCV_WITH_SURFACES
    const uint surface_before = MCV_WORD(slot, origin_surface, 0);
    const uint surface = path.origin_surface;
    MCV_WORD(slot, origin_surface, 0) = skipped ? surface_before : surface;
#endif
#if MCV_WITH_DIELECTRIC
    const uint media_before = MCV_WORD(slot, media, 0);
    const uint media = path.media;
    MCV_WORD(slot, media, 0) = skipped ? media_before : media;
#endif
    const uint class_before = MCV_WORD(slot, light_class, 0);
    const uint path_class = path.path_class;
    MCV_WORD(slot, light_class, 0) = skipped ? class_before : path_class;
}

MCV_LOOP_FUNCTION void mcv_store_light_path(mcv_slot slot, mcv_light_path path) {
    mcv_store_light_step(slot, 0, path);
    MCV_STORE_3(slot, origin, path.origin);
    MCV_STORE_COLOR(slot, light_flux, path.flux);
    MCV_STORE(slot, light_etendue, 0, path.etendue);
    MCV_WORD(slot, light_emitter, 0) = path.emitter;
    MCV_STORE(slot, light_length, 0, path.length);
}

/* Begins so many light paths, whose pairs are drawn; returns how many carry anything. */
MCV_BATCH uint mcv_begin_light_paths(mcv_world world, mcv_slot slot, uint count) {
    uint sends[MCV_ROW], begun[MCV_SLOTS];
    for (slot.index = 0; slot.index < count; ++slot.index) {
        const mcv_light_path path = mcv_begin_light_path(world, mcv_draw(slot, 0, MCV_PAIR_CHOICE),
                                                         mcv_draw(slot, 0, MCV_PAIR_EMITTER),
                                                         mcv_draw(slot, 0, MCV_PAIR_SCATTER));
        mcv_store_light_path(slot, path);
        sends[slot.index] = (uint)(mcv_brightest(path.flux) > 0.0f);
    }
    const uint next = mcv_compact_indices(sends, count, begun);
    if (next < count) mcv_move_paths(slot.base, begun, next);
    return next;
}

/* Begins the next light paths of the launch's paths *next … last - 1, as many as there is room for;
 * returns how many. */
MCV_BATCH uint mcv_fill_light_slice(mcv_world world, mcv_slot slot, uint *next, uint last) {
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

#endif
