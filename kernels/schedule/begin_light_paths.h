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
#include "stage/continue_path.h"
#include "stage/trace_light_path.h"

#if MCV_WITH_LIGHT_TRACING
#if MCV_LIGHT_ROWS
MCV_LOOP_FUNCTION mcv_light_path mcv_load_light_path(mcv_slot slot) {
    mcv_light_path path;
    path.origin = MCV_LOAD_3(slot, origin);
    path.direction = MCV_LOAD_3(slot, direction);
    MCV_LOAD_COLOR(slot, light_flux, path.flux);
    path.throughput = mcv_path_throughput(slot);
    path.etendue = MCV_LOAD(slot, light_etendue, 0);
    path.origin_surface = mcv_path_origin_surface(slot);
    path.media = mcv_path_media(slot);
    path.emitter = MCV_WORD(slot, light_emitter, 0);
    path.emitter_element = MCV_WITH_RECORDS ? MCV_WORD(slot, light_emitter_element, 0) : 0u;
    path.light_flags = MCV_WORD(slot, light_flags, 0);
    path.length = MCV_LOAD(slot, light_length, 0);
    return path;
}

MCV_LOOP_FUNCTION void mcv_store_light_path(mcv_slot slot, mcv_light_path path) {
    MCV_STORE_3(slot, origin, path.origin);
    MCV_STORE_3(slot, direction, path.direction);
    MCV_STORE_COLOR(slot, light_flux, path.flux);
    MCV_STORE_COLOR(slot, throughput, path.throughput);
    if (MCV_WITH_SURFACES) MCV_WORD(slot, origin_surface, 0) = path.origin_surface;
    if (MCV_WITH_DIELECTRIC) MCV_WORD(slot, media, 0) = path.media;
    MCV_WORD(slot, light_flags, 0) = path.light_flags;
    MCV_STORE(slot, light_etendue, 0, path.etendue);
    MCV_WORD(slot, light_emitter, 0) = path.emitter;
    if (MCV_WITH_RECORDS) MCV_WORD(slot, light_emitter_element, 0) = path.emitter_element;
    MCV_STORE(slot, light_length, 0, path.length);
}

/* How a light path continues from a surface of a known kind: all but its origin. Returns its fate.
 */
MCV_LOOP_FUNCTION uint mcv_shade_light_path(mcv_world world, mcv_slot slot,
                                            const mcv_interaction *interaction, mcv_shading shading,
                                            uint depth, uint *unmatched) {
    const mcv_pair choice = mcv_draw(slot, depth, MCV_PAIR_CHOICE);
    mcv_light_path path = mcv_load_light_path(slot);
    mcv_scattering other;
    int unshaded = 0;
    shading.may_split = 0;
    const mcv_scattering on =
        mcv_scatter_as(world, slot, interaction, shading, mcv_draw(slot, depth, MCV_PAIR_SCATTER),
                       choice.x, 0, unmatched, &other, &unshaded);
    const int goes_on =
        mcv_continue_light_path(world, interaction, shading, on, depth, choice.y, &path);
    const int skipped = shading.kind == MCV_SHADING_GLOSSY ? unshaded : 0;
    mcv_continue_ray(world, slot, interaction, shading, on, path.throughput, skipped);
    MCV_REPLACE_WORD(slot, light_flags, 0, skipped, path.light_flags);
    return unshaded ? (uint)MCV_UNSHADED : (uint)goes_on;
}

/* Begins so many light paths, whose pairs are drawn; returns how many carry anything. */
MCV_BATCH uint mcv_begin_light_paths(mcv_world world, mcv_slot slot, uint count) {
    uint sends[MCV_ROW], begun[MCV_SLOTS];
    for (slot.index = 0; slot.index < count; ++slot.index) {
        const mcv_light_path path = mcv_begin_light_path(
            world, mcv_drawn(slot, MCV_PAIR_LIGHT_EMITTER), mcv_drawn(slot, MCV_PAIR_LIGHT_PLACE),
            mcv_drawn(slot, MCV_PAIR_LIGHT_DIRECTION));
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
    mcv_draw_pairs(slot.base, 0, count, 0, MCV_PAIR_LIGHT_EMITTER);
    mcv_draw_pairs(slot.base, 0, count, 0, MCV_PAIR_LIGHT_PLACE);
    mcv_draw_pairs(slot.base, 0, count, 0, MCV_PAIR_LIGHT_DIRECTION);
    return mcv_begin_light_paths(world, slot, count);
}
#endif
#endif

#endif
