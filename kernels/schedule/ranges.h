/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The tile schedule's order of the paths that have met something, and its loops over the ranges of that order. A loop over surfaces of one
 * kind calls the functions that the stages call for one path (mcv_shade_hit, mcv_continue_path), with the kind as a constant: they hold no
 * branches then, and the loop is vectorised.
 *
 * A plain surface reflects diffusely, or is made of microfacets that have no direction; it has no texture and does not emit. Of glossy
 * materials only one in a slice is plain: its table is read once.
 */
#ifndef MCVISI_KERNELS_PLAIN_SURFACES_H
#define MCVISI_KERNELS_PLAIN_SURFACES_H

#include "bsdf/shading.h"

/* What paths have met. The paths of a kind lie side by side in this order; ends[kind] is where the next kind begins. */
enum {
    MCV_MET_SMOOTH_TRIANGLE,
    MCV_MET_SMOOTH_EXACT,
    MCV_MET_DIFFUSE_EXACT,
    MCV_MET_GLOSS_EXACT,
    MCV_MET_GLOSS_TRIANGLE,
    MCV_MET_DIFFUSE_TRIANGLE, /* the last plain one */
    MCV_MET_TRIANGLE,
    MCV_MET_EXACT,
    MCV_MET_NOTHING,
    MCV_MET_COUNT,
    /* What absorbs all light; if it is the lamp of an emitter, the emitter's number and 1 more. Such paths end before the others are put in
     * order (kernels/schedule/terminate_paths.h). */
    MCV_MET_BLACK = MCV_MET_COUNT
};

/* Where a ray has met nothing or the other sort of surface, the first one is read instead; `triangles` may be read there. */
MCV_LOOP_FUNCTION uint mcv_kind_met(mcv_world world, __global const uint *triangles, uint met) {
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
    uint kind = exact ? MCV_MET_EXACT : MCV_MET_TRIANGLE;
    kind = shading >= MCV_SHADED_BLACK ? MCV_MET_BLACK + (shading - MCV_SHADED_BLACK) : kind;
#if MCV_WITH_SMOOTH
    kind = shading == MCV_SHADED_SMOOTH ? (exact ? MCV_MET_SMOOTH_EXACT : MCV_MET_SMOOTH_TRIANGLE) : kind;
#endif
#if MCV_WITH_PLAIN
    kind = shading == MCV_SHADED_DIFFUSE ? (exact ? MCV_MET_DIFFUSE_EXACT : MCV_MET_DIFFUSE_TRIANGLE) : kind;
#if MCV_WITH_GLOSS
    kind = shading == MCV_SHADED_GLOSSY ? (exact ? MCV_MET_GLOSS_EXACT : MCV_MET_GLOSS_TRIANGLE) : kind;
#endif
#endif
    return nothing ? MCV_MET_NOTHING : kind;
}

#if MCV_FEW
/* The same where there are few triangles and exact surfaces. */
static __attribute__((noinline)) void mcv_look_up_kinds(mcv_world world, __global const uint *triangles, const uint *met, uint count,
                                                        uint *kinds) {
    uint of_each[MCV_FEW];
    MCV_PARALLEL
    for (uint i = 0; i < MCV_FEW; ++i) of_each[i] = mcv_kind_met(world, triangles, i < world.frame->triangle_count ? i : MCV_NONE);
    mcv_look_up(of_each, met, count, kinds);
#if MCV_WITH_SURFACES
    uint exacts[MCV_ROW];
    MCV_PARALLEL
    for (uint i = 0; i < MCV_FEW; ++i) {
        const int is_piece = (i >> 2 < world.frame->solid_count) & ((i & 3u) < MCV_PIECE_COUNT);
        of_each[i] = mcv_kind_met(world, triangles, is_piece ? MCV_EXACT | i : MCV_NONE);
    }
    mcv_look_up(of_each, met, count, exacts);
    MCV_PARALLEL
    for (uint i = 0; i < mcv_fill_lanes(count); ++i) kinds[i] = met[i] >= MCV_EXACT ? exacts[i] : kinds[i];
#endif
    MCV_PARALLEL
    for (uint i = 0; i < mcv_fill_lanes(count); ++i) kinds[i] = ((i < count) & (met[i] != MCV_NONE)) ? kinds[i] : MCV_MET_NOTHING;
}
#endif

/* What the paths have met. */
static __attribute__((noinline)) void mcv_find_kinds(mcv_world world, const uint *paths, uint count, uint *kinds, uint *gloss) {
    const uint *met = paths + (MCV_PATH_hit + 3) * MCV_ROW;
    __global const uint *triangles = (__global const uint *)world.triangles;
#if MCV_WITH_SURFACES
    if (!triangles) triangles = (__global const uint *)world.solids;
#endif
    *gloss = MCV_NONE;
    if (!triangles) {
        for (uint i = 0; i < count; ++i) kinds[i] = MCV_MET_NOTHING;
        return;
    }
#if MCV_FEW
    if (world.frame->triangle_count <= MCV_FEW && 4u * world.frame->solid_count <= MCV_FEW && count >= 2 * MCV_FEW)
        mcv_look_up_kinds(world, triangles, met, count, kinds);
    else
#endif
    {
        MCV_PARALLEL
        for (uint i = 0; i < mcv_fill_lanes(count); ++i) kinds[i] = mcv_kind_met(world, triangles, i < count ? met[i] : MCV_NONE);
    }
#if MCV_WITH_PLAIN && MCV_WITH_GLOSS
    for (uint i = 0; i < count; ++i) {
        if (kinds[i] != MCV_MET_GLOSS_TRIANGLE && kinds[i] != MCV_MET_GLOSS_EXACT) continue;
        const uint material = world.instances[mcv_instance_of(world, met[i])].material;
        if (*gloss == MCV_NONE) *gloss = material;
        if (*gloss != material) kinds[i] = kinds[i] == MCV_MET_GLOSS_EXACT ? MCV_MET_EXACT : MCV_MET_TRIANGLE;
    }
#endif
}

/*
 * Which paths move where, one after the other, until they lie in the order of what they have met; returns how many moves. Those that have
 * met nothing, the last kind, are no longer needed: others take their slots. A path that makes room for a ring of others waits in the slot
 * MCV_SLOTS.
 */
static __attribute__((noinline)) uint mcv_plan_moves(uint *kinds, uint count, uint *ends, uint *from, uint *to) {
    uint homes[MCV_ROW];                                      /* kinds whose slots they are */
    uint strays[MCV_ROW], astray[MCV_SLOTS], next[MCV_SLOTS]; /* who is not where it belongs, in a list, and the next such of its kind */
    uint leaves[MCV_ROW], holes[MCV_SLOTS];                   /* whose slots others take */
    uint first[MCV_MET_COUNT], last[MCV_MET_NOTHING] = {0};
    uint moves = 0;
    MCV_PARALLEL
    for (uint i = 0; i < mcv_fill_lanes(count); ++i) {
        const uint kind = i < count ? kinds[i] : MCV_MET_NOTHING;
#pragma unroll
        for (uint k = 0; k < MCV_MET_NOTHING; ++k) last[k] += kind <= k;
    }
    for (uint kind = 0; kind < MCV_MET_COUNT; ++kind) {
        ends[kind] = kind == MCV_MET_NOTHING ? count : last[kind];
        first[kind] = MCV_NONE;
    }
    MCV_PARALLEL
    for (size_t i = 0; i < mcv_fill_lanes(count); ++i) {
        uint home = 0;
#pragma unroll
        for (uint k = 0; k < MCV_MET_NOTHING; ++k) home += (uint)i >= last[k];
        const int moves_on = kinds[i] != home, nothing = kinds[i] == MCV_MET_NOTHING;
        homes[i] = home;
        strays[i] = (uint)(moves_on & !nothing);
        leaves[i] = (uint)(moves_on & nothing);
    }
    const uint stray_count = mcv_list(strays, count, astray), hole_count = mcv_list(leaves, count, holes);
    for (uint k = 0; k < stray_count; ++k) {
        const uint i = astray[k];
        next[i] = first[kinds[i]];
        first[kinds[i]] = i;
    }
    for (uint k = 0; k < hole_count; ++k) {
        for (uint hole = holes[k]; homes[hole] != MCV_MET_NOTHING; ++moves) {
            const uint home = homes[hole], path = first[home];
            first[home] = next[path];
            from[moves] = path;
            to[moves] = hole;
            kinds[hole] = home;
            hole = path;
        }
    }
    for (uint k = 0; k < stray_count; ++k) {
        const uint begin = astray[k];
        if (homes[begin] == kinds[begin] || homes[begin] == MCV_MET_NOTHING) continue;
        uint hole = begin;
        from[moves] = begin;
        to[moves++] = MCV_SLOTS;
        do {
            const uint home = homes[hole], path = first[home];
            first[home] = next[path];
            from[moves] = path == begin ? MCV_SLOTS : path;
            to[moves++] = hole;
            kinds[hole] = home;
            hole = path;
        } while (hole != begin);
    }
    return moves;
}

/* Puts the paths in the order of what they have met, in place; those that have met nothing are lost. */
static __attribute__((noinline)) void mcv_order_paths(uint *paths, uint *kinds, uint count, uint *ends) {
    uint from[2 * MCV_SLOTS], to[2 * MCV_SLOTS];
    const uint moves = mcv_plan_moves(kinds, count, ends, from, to);
    for (uint word = 0; moves > 0 && word < MCV_PATH_hit + 4; ++word) {
        uint *row = paths + word * MCV_ROW;
        for (uint i = 0; i < moves; ++i) row[to[i]] = row[from[i]];
    }
}

#if MCV_WITH_PLAIN
MCV_LOOP_FUNCTION mcv_color mcv_reflectance_of(mcv_world world, uint instance) {
    mcv_color reflectance;
    MCV_EACH_CHANNEL(c) reflectance.c[c] = world.materials[world.instances[instance].material].value[c];
    return reflectance;
}

/* What the diffuse surfaces reflect that the paths in the slots first … last - 1 have met. What follows in the row is of no account then.
 */
static __attribute__((noinline)) void mcv_find_reflectances(mcv_world world, uint *paths, uint first, uint last) {
    const uint *instances = paths + MCV_PATH_instance * MCV_ROW;
    uint *rows = paths + MCV_PATH_reflectance * MCV_ROW;
#if MCV_FEW
    const uint count = world.frame->instance_count;
    if (count - 1u < MCV_FEW && last - first >= 2 * MCV_FEW) {
        uint of_each[MCV_CHANNELS][MCV_FEW];
        MCV_PARALLEL
        for (uint i = 0; i < MCV_FEW; ++i) {
            const mcv_color reflectance = mcv_reflectance_of(world, i < count ? i : 0u);
            MCV_EACH_CHANNEL(c) of_each[c][i] = as_uint(reflectance.c[c]);
        }
        for (uint c = 0; c < MCV_CHANNELS; ++c) mcv_look_up(of_each[c], instances + first, last - first, rows + c * MCV_ROW + first);
        return;
    }
#endif
    MCV_PARALLEL_MASKED
    for (uint i = first; i < last; ++i) {
        const mcv_color reflectance = mcv_reflectance_of(world, instances[i]);
        MCV_EACH_CHANNEL(c) rows[c * MCV_ROW + i] = as_uint(reflectance.c[c]);
    }
}

#endif

/*
 * The ranges of paths whose surfaces are of a kind that is known: X(first, last, shading), the shading known to the compiler. Smooth
 * bodies; then diffuse surfaces, and glossy ones, all of one material.
 */
#if MCV_WITH_SMOOTH
#define MCV_SMOOTH_RANGES(X, ends) \
    X(0u, (ends)[MCV_MET_SMOOTH_TRIANGLE], mcv_shading_of(MCV_SHADING_SMOOTH, 0, MCV_WITH_SPLIT)) \
    if (MCV_WITH_SURFACES) \
    X((ends)[MCV_MET_SMOOTH_TRIANGLE], (ends)[MCV_MET_SMOOTH_EXACT], mcv_shading_of(MCV_SHADING_SMOOTH, 1, MCV_WITH_SPLIT))
#else
#define MCV_SMOOTH_RANGES(X, ends)
#endif
#if MCV_WITH_PLAIN
#define MCV_DIFFUSE_RANGES(X, ends) \
    X((ends)[MCV_MET_GLOSS_TRIANGLE], (ends)[MCV_MET_DIFFUSE_TRIANGLE], mcv_shading_of(MCV_SHADING_DIFFUSE, 0, 0)) \
    if (MCV_WITH_SURFACES) X((ends)[MCV_MET_SMOOTH_EXACT], (ends)[MCV_MET_DIFFUSE_EXACT], mcv_shading_of(MCV_SHADING_DIFFUSE, 1, 0))
#else
#define MCV_DIFFUSE_RANGES(X, ends)
#endif
#if MCV_WITH_PLAIN && MCV_WITH_GLOSS
#define MCV_GLOSS_RANGE(X, ends, TYPE) \
    if (glossy.type == TYPE) X((ends)[MCV_MET_DIFFUSE_EXACT], (ends)[MCV_MET_GLOSS_TRIANGLE], mcv_shading_as(glossy, TYPE))
#define MCV_PLAIN_RANGES(X, world, ends, gloss) \
    MCV_DIFFUSE_RANGES(X, ends) \
    if ((gloss) != MCV_NONE) { \
        const mcv_device_gloss from = mcv_plain_gloss(world, gloss); \
        const mcv_shading glossy = mcv_glossy_shading(world, gloss, &from); \
        MCV_GLOSS_RANGE(X, ends, MCV_MATERIAL_CONDUCTOR) \
        MCV_GLOSS_RANGE(X, ends, MCV_MATERIAL_METALLIC_ROUGHNESS) \
        if (MCV_WITH_DIELECTRIC) { \
            MCV_GLOSS_RANGE(X, ends, MCV_MATERIAL_DIELECTRIC) \
        } \
    }
#else
#define MCV_PLAIN_RANGES(X, world, ends, gloss) MCV_DIFFUSE_RANGES(X, ends)
#endif

#if MCV_WITH_PLAIN || MCV_WITH_SMOOTH
/* How the paths in the slots first … last - 1 continue, whose surfaces are of one kind; into `parted` how their branches do. */
MCV_LOOP_FUNCTION void mcv_shade_range(mcv_world world, uint *paths, uint first, uint last, mcv_shading shading, uint depth, uint *ways,
                                       uint *unmatched) {
    mcv_slot slot;
    slot.base = paths;
    MCV_PARALLEL_MASKED
    for (uint i = first; i < last; ++i) {
        slot.index = i;
        uint differs = 0u;
        const mcv_meeting meeting = mcv_meet_surface(world, slot);
        const mcv_shaded shaded = mcv_shade_hit(world, slot, &meeting, shading, depth, &differs);
#if MCV_WITH_SPLIT
        if (shading.splits) mcv_keep_parting(slot, shaded.parting);
#endif
#if MCV_WITH_NEXT_EVENT && MCV_WITH_REACH
        if (shading.kind != MCV_SHADING_SMOOTH) mcv_keep_reach(slot);
#endif
        mcv_continue_path(world, slot, &meeting, shading, shaded.on, shaded.throughput,
                          shading.kind == MCV_SHADING_GLOSS ? shaded.ways == MCV_IS_LEFT : 0);
        ways[i] = shaded.ways;
        unmatched[i] = differs;
    }
}

/* The paths on all surfaces whose kind is known. */
static __attribute__((noinline)) void mcv_shade_ranges(mcv_world world, uint *paths, const uint *ends, uint gloss, uint depth, uint *ways,
                                                       uint *unmatched) {
    uint differs[MCV_SLOTS];
    (void)gloss;
#define MCV_X(first, last, shading) mcv_shade_range(world, paths, first, last, shading, depth, ways, differs);
    MCV_SMOOTH_RANGES(MCV_X, ends)
    MCV_PLAIN_RANGES(MCV_X, world, ends, gloss)
#undef MCV_X
    for (uint i = 0; i < ends[MCV_WITH_PLAIN ? MCV_MET_DIFFUSE_TRIANGLE : MCV_MET_SMOOTH_EXACT]; ++i) *unmatched += differs[i];
}
#endif

#endif
