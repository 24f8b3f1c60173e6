/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The tile schedule's order of the paths that have met something, and its loops over the ranges of
 * that order. A loop over surfaces of one kind calls the functions that the stages call for one
 * path (mcv_shade_hit, mcv_continue_path), with the kind as a constant: they hold no branches then,
 * and the loop is vectorised.
 *
 * A plain surface reflects diffusely, or is made of microfacets that have no direction; it has no
 * texture and does not emit. Of glossy materials only one in a slice is plain: its table is read
 * once.
 */
#ifndef MCVISI_KERNELS_PLAIN_SURFACES_H
#define MCVISI_KERNELS_PLAIN_SURFACES_H

#include "bsdf/shading.h"

/* What paths have met. The paths of a kind lie side by side in this order; ends[kind] is where the
 * next kind begins. */
enum {
    MCV_CLASS_SMOOTH_TRIANGLE,
    MCV_CLASS_SMOOTH_EXACT,
    MCV_CLASS_DIFFUSE_EXACT,
    MCV_CLASS_GLOSS_EXACT,
    MCV_CLASS_GLOSS_TRIANGLE,
    MCV_CLASS_DIFFUSE_TRIANGLE, /* the last plain one */
    MCV_CLASS_TRIANGLE,
    MCV_CLASS_EXACT,
    MCV_CLASS_MISS,
    MCV_CLASS_COUNT,
    /* What absorbs all light; if it is the lamp of an emitter, the emitter's number and 1 more.
     * Such paths end before the others are put in order (kernels/schedule/terminate_paths.h). */
    MCV_CLASS_BLACK = MCV_CLASS_COUNT
};

/* Where a ray has met nothing or the other sort of surface, the first one is read instead;
 * `triangles` may be read there. */
MCV_LOOP_FUNCTION uint mcv_classify_hit(mcv_world world, __global const uint *triangles, uint met) {
    const int nothing = met == MCV_NONE;
    int exact = 0;
#if MCV_WITH_SURFACES
    exact = !nothing & (met >= MCV_EXACT);
#endif
    __global const uint *met_at = triangles + 4u * (nothing | exact ? 0u : met) + 3u;
#if MCV_WITH_SURFACES
    met_at = exact ? world.solids[(met & ~MCV_EXACT) >> 2].instance + (met & 3u) : met_at;
#endif
    const uint instance = *met_at, shading = world.instances[nothing ? 0u : instance].shading;
    uint kind = exact ? MCV_CLASS_EXACT : MCV_CLASS_TRIANGLE;
    kind = shading >= MCV_SHADED_BLACK ? MCV_CLASS_BLACK + (shading - MCV_SHADED_BLACK) : kind;
#if MCV_WITH_SMOOTH
    kind = shading == MCV_SHADED_SMOOTH
               ? (exact ? MCV_CLASS_SMOOTH_EXACT : MCV_CLASS_SMOOTH_TRIANGLE)
               : kind;
#endif
#if MCV_WITH_PLAIN
    kind = shading == MCV_SHADED_DIFFUSE
               ? (exact ? MCV_CLASS_DIFFUSE_EXACT : MCV_CLASS_DIFFUSE_TRIANGLE)
               : kind;
#if MCV_WITH_GLOSS
    kind = shading == MCV_SHADED_GLOSSY ? (exact ? MCV_CLASS_GLOSS_EXACT : MCV_CLASS_GLOSS_TRIANGLE)
                                        : kind;
#endif
#endif
    return nothing ? MCV_CLASS_MISS : kind;
}

#if MCV_CACHED
/* The same where there are few triangles and exact surfaces. */
static __attribute__((noinline)) void mcv_lookup_classes(mcv_world world,
                                                         __global const uint *triangles,
                                                         const uint *met, uint count,
                                                         uint *classes) {
    uint of_each[MCV_CACHED];
    MCV_VECTORIZE
    for (uint i = 0; i < MCV_CACHED; ++i)
        of_each[i] =
            mcv_classify_hit(world, triangles, i < world.frame->triangle_count ? i : MCV_NONE);
    mcv_register_lookup(of_each, met, count, classes);
#if MCV_WITH_SURFACES
    uint exacts[MCV_ROW];
    MCV_VECTORIZE
    for (uint i = 0; i < MCV_CACHED; ++i) {
        const int is_piece = (i >> 2 < world.frame->solid_count) & ((i & 3u) < MCV_PIECE_COUNT);
        of_each[i] = mcv_classify_hit(world, triangles, is_piece ? MCV_EXACT | i : MCV_NONE);
    }
    mcv_register_lookup(of_each, met, count, exacts);
    MCV_VECTORIZE
    for (uint i = 0; i < mcv_fill_lanes(count); ++i)
        classes[i] = met[i] >= MCV_EXACT ? exacts[i] : classes[i];
#endif
    MCV_VECTORIZE
    for (uint i = 0; i < mcv_fill_lanes(count); ++i)
        classes[i] = ((i < count) & (met[i] != MCV_NONE)) ? classes[i] : MCV_CLASS_MISS;
}
#endif

/* What the paths have met. */
static __attribute__((noinline)) void mcv_classify_hits(mcv_world world, const uint *paths,
                                                        uint count, uint *classes, uint *gloss) {
    const uint *met = paths + (MCV_PATH_hit + 3) * MCV_ROW;
    __global const uint *triangles = (__global const uint *)world.triangles;
#if MCV_WITH_SURFACES
    if (!triangles) triangles = (__global const uint *)world.solids;
#endif
    *gloss = MCV_NONE;
    if (!triangles) {
        for (uint i = 0; i < count; ++i) classes[i] = MCV_CLASS_MISS;
        return;
    }
#if MCV_CACHED
    if (world.frame->triangle_count <= MCV_CACHED && 4u * world.frame->solid_count <= MCV_CACHED &&
        count >= 2 * MCV_CACHED)
        mcv_lookup_classes(world, triangles, met, count, classes);
    else
#endif
    {
        MCV_VECTORIZE
        for (uint i = 0; i < mcv_fill_lanes(count); ++i)
            classes[i] = mcv_classify_hit(world, triangles, i < count ? met[i] : MCV_NONE);
    }
#if MCV_WITH_PLAIN && MCV_WITH_GLOSS
    for (uint i = 0; i < count; ++i) {
        if (classes[i] != MCV_CLASS_GLOSS_TRIANGLE && classes[i] != MCV_CLASS_GLOSS_EXACT) continue;
        const uint material = world.instances[mcv_instance_of(world, met[i])].material;
        if (*gloss == MCV_NONE) *gloss = material;
        if (*gloss != material)
            classes[i] = classes[i] == MCV_CLASS_GLOSS_EXACT ? MCV_CLASS_EXACT : MCV_CLASS_TRIANGLE;
    }
#endif
}

/*
 * Which paths move where, one after the other, until they lie in the order of what they have met;
 * returns how many moves. Those that have met nothing, the last kind, are no longer needed: others
 * take their slots. A path that makes room for a ring of others waits in the slot MCV_SLOTS.
 */
static __attribute__((noinline)) uint mcv_plan_moves(uint *classes, uint count, uint *class_end,
                                                     uint *from, uint *to) {
    uint homes[MCV_ROW]; /* kinds whose slots they are */
    uint strays[MCV_ROW], astray[MCV_SLOTS],
        next[MCV_SLOTS]; /* who is not where it belongs, in a list, and the next such of its kind */
    uint leaves[MCV_ROW], holes[MCV_SLOTS]; /* whose slots others take */
    uint first[MCV_CLASS_COUNT], last[MCV_CLASS_MISS] = {0};
    uint moves = 0;
    MCV_VECTORIZE
    for (uint i = 0; i < mcv_fill_lanes(count); ++i) {
        const uint kind = i < count ? classes[i] : MCV_CLASS_MISS;
#pragma unroll
        for (uint k = 0; k < MCV_CLASS_MISS; ++k) last[k] += kind <= k;
    }
    for (uint kind = 0; kind < MCV_CLASS_COUNT; ++kind) {
        class_end[kind] = kind == MCV_CLASS_MISS ? count : last[kind];
        first[kind] = MCV_NONE;
    }
    MCV_VECTORIZE
    for (size_t i = 0; i < mcv_fill_lanes(count); ++i) {
        uint home = 0;
#pragma unroll
        for (uint k = 0; k < MCV_CLASS_MISS; ++k) home += (uint)i >= last[k];
        const int moves_on = classes[i] != home, nothing = classes[i] == MCV_CLASS_MISS;
        homes[i] = home;
        strays[i] = (uint)(moves_on & !nothing);
        leaves[i] = (uint)(moves_on & nothing);
    }
    const uint stray_count = mcv_compact_indices(strays, count, astray),
               hole_count = mcv_compact_indices(leaves, count, holes);
    for (uint k = 0; k < stray_count; ++k) {
        const uint i = astray[k];
        next[i] = first[classes[i]];
        first[classes[i]] = i;
    }
    for (uint k = 0; k < hole_count; ++k) {
        for (uint hole = holes[k]; homes[hole] != MCV_CLASS_MISS; ++moves) {
            const uint home = homes[hole], path = first[home];
            first[home] = next[path];
            from[moves] = path;
            to[moves] = hole;
            classes[hole] = home;
            hole = path;
        }
    }
    for (uint k = 0; k < stray_count; ++k) {
        const uint begin = astray[k];
        if (homes[begin] == classes[begin] || homes[begin] == MCV_CLASS_MISS) continue;
        uint hole = begin;
        from[moves] = begin;
        to[moves++] = MCV_SLOTS;
        do {
            const uint home = homes[hole], path = first[home];
            first[home] = next[path];
            from[moves] = path == begin ? MCV_SLOTS : path;
            to[moves++] = hole;
            classes[hole] = home;
            hole = path;
        } while (hole != begin);
    }
    return moves;
}

/* Puts the paths in the order of what they have met, in place; those that have met nothing are
 * lost. */
static __attribute__((noinline)) void mcv_sort_paths(uint *paths, uint *classes, uint count,
                                                     uint *class_end) {
    uint from[2 * MCV_SLOTS], to[2 * MCV_SLOTS];
    const uint moves = mcv_plan_moves(classes, count, class_end, from, to);
    for (uint word = 0; moves > 0 && word < MCV_PATH_hit + 4; ++word) {
        uint *row = paths + word * MCV_ROW;
        for (uint i = 0; i < moves; ++i) row[to[i]] = row[from[i]];
    }
}

#if MCV_WITH_PLAIN
MCV_LOOP_FUNCTION mcv_color mcv_reflectance_of(mcv_world world, uint instance) {
    mcv_color reflectance;
    MCV_EACH_CHANNEL(c)
    reflectance.c[c] = world.materials[world.instances[instance].material].value[c];
    return reflectance;
}

/* What the diffuse surfaces reflect that the paths in the slots first … last - 1 have met. What
 * follows in the row is of no account then.
 */
static __attribute__((noinline)) void mcv_find_reflectances(mcv_world world, uint *paths,
                                                            uint first, uint last) {
    const uint *instances = paths + MCV_PATH_instance * MCV_ROW;
    uint *rows = paths + MCV_PATH_reflectance * MCV_ROW;
#if MCV_CACHED
    const uint count = world.frame->instance_count;
    if (count - 1u < MCV_CACHED && last - first >= 2 * MCV_CACHED) {
        uint of_each[MCV_CHANNELS][MCV_CACHED];
        MCV_VECTORIZE
        for (uint i = 0; i < MCV_CACHED; ++i) {
            const mcv_color reflectance = mcv_reflectance_of(world, i < count ? i : 0u);
            MCV_EACH_CHANNEL(c) of_each[c][i] = as_uint(reflectance.c[c]);
        }
        for (uint c = 0; c < MCV_CHANNELS; ++c)
            mcv_register_lookup(of_each[c], instances + first, last - first,
                                rows + c * MCV_ROW + first);
        return;
    }
#endif
    MCV_VECTORIZE_MASKED
    for (uint i = first; i < last; ++i) {
        const mcv_color reflectance = mcv_reflectance_of(world, instances[i]);
        MCV_EACH_CHANNEL(c) rows[c * MCV_ROW + i] = as_uint(reflectance.c[c]);
    }
}

#endif

/*
 * The ranges of paths whose surfaces are of a kind that is known: X(first, last, shading), the
 * shading known to the compiler. Smooth bodies; then diffuse surfaces, and glossy ones, all of one
 * material.
 */
#if MCV_WITH_SMOOTH
#define MCV_SMOOTH_RANGES(X, class_end) \
    X(0u, (class_end)[MCV_CLASS_SMOOTH_TRIANGLE], \
      mcv_shading_of(MCV_SHADING_SMOOTH, 0, MCV_WITH_SPLIT)) \
    if (MCV_WITH_SURFACES) \
    X((class_end)[MCV_CLASS_SMOOTH_TRIANGLE], (class_end)[MCV_CLASS_SMOOTH_EXACT], \
      mcv_shading_of(MCV_SHADING_SMOOTH, 1, MCV_WITH_SPLIT))
#else
#define MCV_SMOOTH_RANGES(X, class_end)
#endif
#if MCV_WITH_PLAIN
#define MCV_DIFFUSE_RANGES(X, class_end) \
    X((class_end)[MCV_CLASS_GLOSS_TRIANGLE], (class_end)[MCV_CLASS_DIFFUSE_TRIANGLE], \
      mcv_shading_of(MCV_SHADING_DIFFUSE, 0, 0)) \
    if (MCV_WITH_SURFACES) \
    X((class_end)[MCV_CLASS_SMOOTH_EXACT], (class_end)[MCV_CLASS_DIFFUSE_EXACT], \
      mcv_shading_of(MCV_SHADING_DIFFUSE, 1, 0))
#else
#define MCV_DIFFUSE_RANGES(X, class_end)
#endif
#if MCV_WITH_PLAIN && MCV_WITH_GLOSS
#define MCV_GLOSS_RANGE(X, class_end, TYPE) \
    if (glossy.type == TYPE) \
    X((class_end)[MCV_CLASS_DIFFUSE_EXACT], (class_end)[MCV_CLASS_GLOSS_TRIANGLE], \
      mcv_shading_as(glossy, TYPE))
#define MCV_PLAIN_RANGES(X, world, class_end, gloss) \
    MCV_DIFFUSE_RANGES(X, class_end) \
    if ((gloss) != MCV_NONE) { \
        const mcv_device_gloss from = mcv_plain_gloss(world, gloss); \
        const mcv_shading glossy = mcv_glossy_shading(world, gloss, &from); \
        MCV_GLOSS_RANGE(X, class_end, MCV_MATERIAL_CONDUCTOR) \
        MCV_GLOSS_RANGE(X, class_end, MCV_MATERIAL_METALLIC_ROUGHNESS) \
        if (MCV_WITH_DIELECTRIC) { \
            MCV_GLOSS_RANGE(X, class_end, MCV_MATERIAL_DIELECTRIC) \
        } \
    }
#else
#define MCV_PLAIN_RANGES(X, world, class_end, gloss) MCV_DIFFUSE_RANGES(X, class_end)
#endif

#if MCV_WITH_PLAIN || MCV_WITH_SMOOTH
/* How the paths in the slots first … last - 1 continue, whose surfaces are of one kind; into
 * `parted` how their branches do. */
MCV_LOOP_FUNCTION void mcv_shade_range(mcv_world world, uint *paths, uint first, uint last,
                                       mcv_shading shading, uint depth, uint *fate,
                                       uint *unmatched) {
    mcv_slot slot;
    slot.base = paths;
    MCV_VECTORIZE_MASKED
    for (uint i = first; i < last; ++i) {
        slot.index = i;
        uint differs = 0u;
        const mcv_interaction interaction = mcv_make_interaction(world, slot);
        const mcv_shaded shaded =
            mcv_shade_hit(world, slot, &interaction, shading, depth, &differs);
#if MCV_WITH_SPLIT
        if (shading.splits) mcv_keep_split(slot, shaded.split);
#endif
#if MCV_WITH_NEXT_EVENT && MCV_WITH_REACH
        if (shading.kind != MCV_SHADING_SMOOTH) mcv_keep_selection(slot);
#endif
        mcv_continue_path(world, slot, &interaction, shading, shaded.on, shaded.throughput,
                          shading.kind == MCV_SHADING_GLOSS ? shaded.fate == MCV_UNSHADED : 0);
        fate[i] = shaded.fate;
        unmatched[i] = differs;
    }
}

/* The paths on all surfaces whose kind is known. */
static __attribute__((noinline)) void mcv_shade_ranges(mcv_world world, uint *paths,
                                                       const uint *class_end, uint gloss,
                                                       uint depth, uint *fate, uint *unmatched) {
    uint differs[MCV_SLOTS];
    (void)gloss;
#define MCV_X(first, last, shading) \
    mcv_shade_range(world, paths, first, last, shading, depth, fate, differs);
    MCV_SMOOTH_RANGES(MCV_X, class_end)
    MCV_PLAIN_RANGES(MCV_X, world, class_end, gloss)
#undef MCV_X
    for (uint i = 0;
         i < class_end[MCV_WITH_PLAIN ? MCV_CLASS_DIFFUSE_TRIANGLE : MCV_CLASS_SMOOTH_EXACT]; ++i)
        *unmatched += differs[i];
}
#endif

#endif
