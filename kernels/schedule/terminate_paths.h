/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Where the tile schedule's paths end. Those that miss, or hit an absorber or a lamp, end before
 * the others are sorted: they are copied to rows of their own, so that a loop runs over them.
 */
#ifndef MCVISI_KERNELS_TERMINATE_PATHS_H
#define MCVISI_KERNELS_TERMINATE_PATHS_H

#include "schedule/tile.h"

#include "schedule/compact.h"
#include "schedule/ranges.h"
#include "schedule/value_rows.h"
#include "stage/shade_hit.h"
#include "stage/sample_emitters.h"

/* Of the paths of a class the rows first … last - 1, side by side in `apart`; returns how many
 * paths there are. */
MCV_BATCH uint mcv_set_apart(const uint *paths, const uint *classes, uint class, uint count,
                             uint first, uint last, uint *apart) {
    uint flags[MCV_SLOTS];
    MCV_VECTORIZE
    for (uint i = 0; i < count; ++i) flags[i] = classes[i] == class;
    return mcv_compact_rows(flags, paths + first * MCV_ROW, last - first, MCV_ROW, count,
                            apart + first * MCV_ROW);
}

/* The rows that matter to a path that leaves the scene. */
#if MCV_WITH_ENVIRONMENT_IMAGE || MCV_WITH_DISPERSION
#define MCV_MISS_BEGIN MCV_PATH_origin
#define MCV_MISS_END (MCV_PATH_hit + 4)
#else
#define MCV_MISS_BEGIN (MCV_WITH_ENVIRONMENT ? MCV_PATH_throughput : MCV_PATH_weight)
#define MCV_MISS_END MCV_PATH_density
#endif

#if MCV_WITH_RECORDS && (MCV_WITH_ENVIRONMENT || MCV_WITH_ENVIRONMENT_IMAGE)
/* mcv_shade_miss of all. Records are written one by one, after a loop that the compiler makes a
 * vector one. */
MCV_BATCH void mcv_shade_recorded_misses(mcv_world world, uint *apart, uint count) {
    float lights[MCV_CHANNELS * MCV_SLOTS];
    MCV_VECTORIZE
    MCV_EACH_PATH (slot, apart, 0, count) {
        const mcv_color light = mcv_miss_radiance(world, slot),
                        arriving = mcv_tint(mcv_path_throughput(slot), light);
        mcv_add_unrecorded_radiance(slot, light);
        MCV_EACH_CHANNEL(c) lights[c * MCV_SLOTS + slot.index] = arriving.c[c];
    }
    uint place = mcv_reserve_records(world, count);
    MCV_EACH_PATH (slot, apart, 0, count) {
        mcv_color arriving;
        MCV_EACH_CHANNEL(c) arriving.c[c] = lights[c * MCV_SLOTS + slot.index];
        mcv_record_at(world, slot, place++, mcv_environment_element(world), arriving);
    }
}
#endif

/* Ends the paths that have met nothing. */
MCV_BATCH uint mcv_shade_misses(mcv_world world, uint *apart, uint count, float *values) {
    uint nonfinite = 0;
#if MCV_WITH_RECORDS && (MCV_WITH_ENVIRONMENT || MCV_WITH_ENVIRONMENT_IMAGE)
    mcv_shade_recorded_misses(world, apart, count);
#endif
    MCV_VECTORIZE
    MCV_EACH_PATH (slot, apart, 0, count) {
        if (!MCV_WITH_RECORDS) mcv_shade_miss(world, slot);
        nonfinite += mcv_terminate_path(world, slot, values);
    }
    return nonfinite;
}

#if MCV_WITH_PARALLEL || MCV_WITH_AREA
struct mcv_facets;

/* The paths have met a lamp. `two`: the triangles of a rectangle, else NULL; `chosen`: whether
 * their directions may have been chosen where the lamp was looked for, too. Both are known to the
 * compiler. */
MCV_LOOP_FUNCTION uint mcv_shade_lamp_hits(mcv_world world, uint *apart, uint count, uint emitter,
                                           const struct mcv_facets *two, int chosen,
                                           const float *mis_weights, float *values) {
    __global const mcv_device_emitter *e = world.emitters + emitter;
    uint nonfinite = 0;
    (void)two, (void)chosen, (void)mis_weights;
#if !MCV_WITH_RECORDS
    MCV_VECTORIZE_MASKED
#endif
    MCV_EACH_PATH (slot, apart, 0, count) {
        const uint triangle = MCV_WORD(slot, hit, 3);
        const mcv_vec3 direction = MCV_LOAD_3(slot, direction);
        mcv_facet facet;
#if MCV_WITH_RECTANGLE
        const int first = two && triangle == two->first.triangle;
        if (two)
            facet = mcv_either_facet(first, two);
        else
#endif
            facet = mcv_facet_of(world, triangle);
        const mcv_surface there =
            mcv_surface_on(facet, MCV_LOAD(slot, hit, 1), MCV_LOAD(slot, hit, 2));
        const float sent = mcv_angular_profile(e, there.ng, there.ns, mcv_scale(direction, -1.0f));
        mcv_emitter_hit met =
            mcv_make_emitter_hit(emitter, mcv_first_emitter_element(world, emitter),
                                 mcv_dim(mcv_color_at(e->radiance), sent));
        met.mis_weight = mis_weights[slot.index];
#if MCV_WITH_NEXT_EVENT
        float pmf;
#if MCV_WITH_RECTANGLE
        if (two)
            pmf = first ? two->first_pmf : two->second_pmf;
        else
#endif
            pmf = mcv_triangle_pmf(world, e, triangle);
        if (chosen)
            met.other =
                mcv_other_density(e, two != 0, pmf, there, direction, MCV_LOAD(slot, hit, 0));
#endif
#if MCV_WITH_DISPERSION
        mcv_add_emission(mcv_in_channel(world, mcv_kept_channel(mcv_path_throughput(slot))), slot,
                         &met);
#else
        mcv_add_emission(world, slot, &met);
#endif
        nonfinite += mcv_terminate_path(world, slot, values);
    }
    return nonfinite;
}

#if MCV_WITH_LIGHT_TRACING
/* mcv_camera_path_mis_weight */
MCV_BATCH void mcv_weigh_lamp_hits(mcv_world world, uint *apart, uint count, uint emitter,
                                   float *mis_weights) {
    MCV_EACH_PATH (slot, apart, 0, count) {
        const mcv_hit hit = mcv_load_hit(slot);
        if (MCV_WORD(slot, path_class, 0) != MCV_PATH_CLASS_CARRIED) continue;
        const mcv_vec3 direction = MCV_LOAD_3(slot, direction);
        const mcv_surface there = mcv_surface_at(world, hit.primitive, hit.u, hit.v);
        mis_weights[slot.index] =
            mcv_camera_path_mis_weight(world, slot, there, direction, emitter);
    }
}
#endif

/* The paths end, which have met a lamp. */
MCV_BATCH uint mcv_terminate_at_lamp(mcv_world world, uint *apart, uint count, uint emitter,
                                     int chosen, float *values) {
    float mis_weights[MCV_SLOTS];
    for (uint i = 0; i < count; ++i) mis_weights[i] = 1.0f;
#if MCV_WITH_LIGHT_TRACING
    if (chosen) mcv_weigh_lamp_hits(world, apart, count, emitter, mis_weights);
#endif
#if MCV_WITH_RECTANGLE
    if (mcv_is_rectangle(world.emitters + emitter)) {
        const mcv_facets two = mcv_facets_of(world, world.emitters + emitter);
        return chosen
                   ? mcv_shade_lamp_hits(world, apart, count, emitter, &two, 1, mis_weights, values)
                   : mcv_shade_lamp_hits(world, apart, count, emitter, &two, 0, mis_weights,
                                         values);
    }
#endif
    return chosen ? mcv_shade_lamp_hits(world, apart, count, emitter, 0, 1, mis_weights, values)
                  : mcv_shade_lamp_hits(world, apart, count, emitter, 0, 0, mis_weights, values);
}
#endif

/* Ends the paths that have met nothing, or what absorbs all light; the class of these is then MISS,
 * too. Returns how many values are not finite. */
MCV_BATCH uint mcv_terminate_early(mcv_world world, uint *paths, uint *classes, uint count,
                                   uint depth, float *values) {
    MCV_ALIGNED uint apart[(MCV_PATH_hit + 4) * MCV_ROW];
    uint flags[MCV_SLOTS], ended[MCV_SLOTS], black = 0;
    uint ending =
        mcv_set_apart(paths, classes, MCV_CLASS_MISS, count, MCV_MISS_BEGIN, MCV_MISS_END, apart);
    uint nonfinite = mcv_shade_misses(world, apart, ending, values);
    (void)depth;
    MCV_VECTORIZE
    for (uint i = 0; i < count; ++i) black += classes[i] >= MCV_CLASS_BLACK;
    if (black == 0) return nonfinite;
    MCV_VECTORIZE
    for (uint i = 0; i < count; ++i) flags[i] = classes[i] == MCV_CLASS_BLACK;
    nonfinite +=
        mcv_terminate_paths(world, paths, ended, mcv_compact_indices(flags, count, ended), values);
#if MCV_WITH_PARALLEL || MCV_WITH_AREA
    const uint lamps =
        world.frame->emitter_count > MCV_MOST_LAMPS ? 0u : world.frame->emitter_count;
    for (uint emitter = 0; emitter < lamps; ++emitter) {
        ending = mcv_set_apart(paths, classes, MCV_CLASS_BLACK + 1u + emitter, count,
                               MCV_PATH_origin, MCV_PATH_hit + 4, apart);
        if (ending > 0)
            nonfinite += mcv_terminate_at_lamp(world, apart, ending, emitter, depth > 0, values);
    }
#endif
    MCV_VECTORIZE
    for (uint i = 0; i < count; ++i)
        classes[i] = classes[i] >= MCV_CLASS_BLACK ? (uint)MCV_CLASS_MISS : classes[i];
    return nonfinite;
}

#endif
