/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The tile schedule's loops of next-event estimation, up to what the surfaces make of the light.
 * Paths that sample the same emitter are worked out together: what is known of it is read once.
 */
#ifndef MCVISI_KERNELS_SAMPLE_EMITTER_ROWS_H
#define MCVISI_KERNELS_SAMPLE_EMITTER_ROWS_H

#include "schedule/tile.h"

#include "schedule/compact.h"
#include "schedule/make_shadow_rows.h"
#include "schedule/sample_direction_rows.h"
#include "schedule/select_emitter_rows.h"
#include "schedule/surface_rows.h"
#include "schedule/vectorize.h"
#include "stage/sample_emitters.h"

#if MCV_WITH_NEXT_EVENT
/* Of so many emitters each has some four paths of a slice that sample it; of more, too few to be
 * worked out together. Without MANY_EMITTERS there are at most MCV_MOST_REACHING. */
#define MCV_MOST_SORTED \
    (MCV_SLICE / 4u > MCV_MOST_REACHING ? MCV_SLICE / 4u : (uint)MCV_MOST_REACHING)

/* Up to so many, a slice's paths are asked for each of them; more are sorted. */
#define MCV_MOST_LISTED 16u

#if MCV_WITH_MANY_EMITTERS
/* One path. */
MCV_BATCH void mcv_sample_emitter_alone(mcv_world world, mcv_slot slot) {
    const mcv_receiver at = mcv_receiver_of(mcv_make_interaction(world, slot));
    const uint emitter = MCV_WORD(slot, emitter, 0);
    const mcv_light_sample sample =
        mcv_sample_towards(world, at, emitter, mcv_drawn(slot, MCV_PAIR_EMITTER));
    mcv_store_light_sample(world, slot, emitter,
                           mcv_apply_selection(world, slot, at.point, emitter, sample));
}
#endif

#if MCV_HAS_EMISSION
/* `found` holds the triangles that the paths have chosen unless the emitter is a rectangle. Whether
 * it is, and whether the paths are a row, is known to the compiler. */
MCV_LOOP_FUNCTION void mcv_sample_point_row(mcv_world world, mcv_slot slot, uint emitter,
                                            int rectangle, const uint *found, const uint *chosen,
                                            uint count, int row) {
    __global const mcv_device_emitter *e = world.emitters + emitter;
    const uint first = chosen[0];
    (void)rectangle, (void)found;
#if MCV_WITH_RECTANGLE
    mcv_facets two;
    if (rectangle) two = mcv_facets_of(world, e);
#endif
    MCV_VECTORIZE_MASKED
    for (uint i = 0; i < count; ++i) {
        slot.index = row ? first + i : chosen[i];
        const mcv_receiver at = mcv_receiver_of(mcv_make_interaction(world, slot));
        const mcv_pair pair = mcv_drawn(slot, MCV_PAIR_EMITTER);
        mcv_emitter_point point;
        mcv_surface there;
#if MCV_WITH_RECTANGLE
        if (rectangle)
            point = mcv_point_on_rectangle(e, &two, at.point, pair);
        else
#endif
            point = mcv_point_on_mesh(world, e, found[i], pair);
        const mcv_light_sample sample = mcv_sample_point(at, e, point, &there);
        mcv_store_light_sample(world, slot, emitter,
                               mcv_apply_selection(world, slot, at.point, emitter, sample));
#if MCV_WITH_TEXTURE
        /* For mcv_light_points. */
        MCV_WORD(slot, place, 0) = there.primitive;
        MCV_STORE(slot, place, 1, there.u);
        MCV_STORE(slot, place, 2, there.v);
        MCV_STORE(slot, place, 3, sample.pdf);
#endif
    }
}

#if MCV_WITH_TEXTURE
/* The light of the points of an emitter with an image. Whether it sends by pixel is known to the
 * compiler. */
MCV_LOOP_FUNCTION void mcv_light_point_row(mcv_world world, mcv_slot slot, uint emitter,
                                           const uint *chosen, uint count, int by_pixel) {
    MCV_VECTORIZE_MASKED
    for (uint i = 0; i < count; ++i) {
        slot.index = chosen[i];
        const mcv_receiver at = mcv_receiver_of(mcv_make_interaction(world, slot));
        const mcv_surface there = mcv_surface_at(
            world, MCV_WORD(slot, place, 0), MCV_LOAD(slot, place, 1), MCV_LOAD(slot, place, 2));
        mcv_light_sample sample = mcv_load_light_sample(slot);
        sample.pdf = MCV_LOAD(slot, place, 3);
        sample = mcv_light_sample_by_image(world, at.point, there, emitter, sample, by_pixel);
        mcv_store_light_sample(world, slot, emitter,
                               mcv_apply_selection(world, slot, at.point, emitter, sample));
    }
}

MCV_BATCH void mcv_light_points(mcv_world world, mcv_slot slot, uint emitter, const uint *chosen,
                                uint count) {
    if (MCV_SENDS_BY_PIXEL(world.emitters + emitter))
        mcv_light_point_row(world, slot, emitter, chosen, count, 1);
    else
        mcv_light_point_row(world, slot, emitter, chosen, count, 0);
}
#endif

/* The chosen paths sample an emitter at points of its surface. */
MCV_BATCH void mcv_sample_points(mcv_world world, mcv_slot slot, uint emitter, const uint *chosen,
                                 uint count) {
    __global const mcv_device_emitter *e = world.emitters + emitter;
    uint found[MCV_SLOTS];
    if (mcv_is_rectangle(e) && mcv_is_row(chosen, count)) {
        mcv_sample_point_row(world, slot, emitter, 1, found, chosen, count, 1);
    } else if (mcv_is_rectangle(e)) {
        mcv_sample_point_row(world, slot, emitter, 1, found, chosen, count, 0);
    } else {
        mcv_search_cdf_rows(world.emitter_cdf + e->cdf, e->triangle_count, slot, MCV_PAIR_EMITTER,
                            chosen, count, found);
        mcv_sample_point_row(world, slot, emitter, 0, found, chosen, count, 0);
    }
#if MCV_WITH_TEXTURE
    if (mcv_has_image(e)) mcv_light_points(world, slot, emitter, chosen, count);
#endif
}
#endif

/* The chosen paths sample one emitter, in a direction or at points of its surface. */
MCV_BATCH void mcv_sample_emitter_row(mcv_world world, mcv_slot slot, uint emitter,
                                      const uint *chosen, uint count) {
    __global const mcv_device_emitter *e = world.emitters + emitter;
    uint by_direction[MCV_ROW], by_point[MCV_ROW], listed[MCV_ROW];
    MCV_VECTORIZE
    for (uint i = 0; i < count; ++i) {
        slot.index = chosen[i];
        const int direction = mcv_samples_direction(e, MCV_LOAD_3(slot, point));
        by_direction[i] = (uint)direction;
        by_point[i] = (uint)!direction;
    }
    const uint directions = mcv_compact_row(by_direction, chosen, count, listed);
    if (directions > 0) mcv_sample_directions(world, slot, emitter, listed, directions);
#if MCV_HAS_EMISSION
    const uint points = mcv_compact_row(by_point, chosen, count, listed);
    if (points > 0) mcv_sample_points(world, slot, emitter, listed, points);
#endif
}

/* Lists the paths in the slots first … last - 1 that sample an emitter; returns how many. */
MCV_BATCH uint mcv_list_sampling(const uint *emitters, uint first, uint last, uint emitter,
                                 uint *listed) {
    uint looks[MCV_ROW];
    MCV_VECTORIZE
    for (uint i = first; i < last; ++i) looks[i - first] = emitters[i] == emitter;
    const uint count = mcv_compact_indices(looks, last - first, listed);
    MCV_VECTORIZE
    for (uint i = 0; i < count; ++i) listed[i] += first;
    return count;
}

/* The same for many emitters at once: sorts the paths in the slots first … last - 1 by the emitter
 * that they sample, in ascending order: those of emitter k begin at begins[k]. */
MCV_BATCH void mcv_sort_by_emitter(const uint *emitters, uint first, uint last, uint count,
                                   uint *begins, uint *sorted) {
    uint next[MCV_MOST_SORTED];
    for (uint k = 0; k <= count; ++k) begins[k] = 0;
    for (uint i = first; i < last; ++i)
        if (emitters[i] != MCV_NONE) ++begins[emitters[i] + 1u];
    for (uint k = 0; k < count; ++k) {
        next[k] = begins[k];
        begins[k + 1u] += begins[k];
    }
    for (uint i = first; i < last; ++i)
        if (emitters[i] != MCV_NONE) sorted[next[emitters[i]]++] = i;
}

/* What comes to the paths in the slots first … last - 1 from the emitters that they look for:
 * together, unless these are so many that few paths look for the same one. */
MCV_BATCH void mcv_sample_emitter_rows(mcv_world world, mcv_slot slot, uint first, uint last) {
    const uint *emitters = slot.base + MCV_PATH_emitter * MCV_ROW;
    const uint count = world.frame->emitter_count;
    uint begins[MCV_MOST_SORTED + 1], sorted[MCV_ROW];
#if MCV_WITH_MANY_EMITTERS
    if (count > MCV_MOST_SORTED) {
        for (slot.index = first; slot.index < last; ++slot.index)
            if (emitters[slot.index] != MCV_NONE) mcv_sample_emitter_alone(world, slot);
        return;
    }
#endif
    const int few = count <= MCV_MOST_LISTED;
    if (!few) mcv_sort_by_emitter(emitters, first, last, count, begins, sorted);
    for (uint k = 0; first < last && k < count; ++k) {
        const uint begin = few ? 0u : begins[k],
                   listed = few ? mcv_list_sampling(emitters, first, last, k, sorted)
                                : begins[k + 1u] - begin;
        if (listed > 0) mcv_sample_emitter_row(world, slot, k, sorted + begin, listed);
    }
}

/* Samples an emitter for each path; lists those that have a shadow ray to follow and returns how
 * many. */
MCV_BATCH uint mcv_sample_emitters(mcv_world world, mcv_slot slot, const uint *class_end,
                                   uint glossy_material, uint depth, uint *shadows) {
    const uint alive = class_end[MCV_LAST_CLASS], smooth_end = class_end[MCV_LAST_SMOOTH],
               known_end = class_end[MCV_LAST_KNOWN];
    uint shadow_count = 0;
    (void)glossy_material;
    mcv_draw_pairs(slot.base, smooth_end, alive, depth, MCV_PAIR_EMITTER);
#if MCV_HAS_PLAIN
    mcv_select_plain_emitters(world, slot, class_end, glossy_material);
    mcv_sample_emitter_rows(world, slot, smooth_end, known_end);
    shadow_count = mcv_list_plain_shadows(world, slot, class_end, glossy_material, shadows);
#endif
    mcv_select_any_emitters(world, slot, known_end, alive);
    mcv_sample_emitter_rows(world, slot, known_end, alive);
    for (slot.index = known_end; slot.index < alive; ++slot.index) {
        if (MCV_WORD(slot, emitter, 0) == MCV_NONE) continue;
        const mcv_interaction interaction = mcv_make_interaction(world, slot);
        if (mcv_make_shadow_ray(world, slot, &interaction, mcv_any_shading(),
                                mcv_load_light_sample(slot)))
            shadows[shadow_count++] = slot.index;
    }
    return shadow_count;
}
#endif

#endif
