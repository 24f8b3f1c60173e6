/* SPDX-License-Identifier: Apache-2.0 */
/* Step of the tile schedule: the shading class of each hit (schedule/ranges.h). */
#ifndef MCVISI_KERNELS_CLASSIFY_HITS_H
#define MCVISI_KERNELS_CLASSIFY_HITS_H

#include "schedule/tile.h"

#include "schedule/compact.h"
#include "schedule/ranges.h"
#include "schedule/vectorize.h"

/* Where there are no triangles `triangles` is any memory that may be read: without a hit, or on an
 * exact surface, its first words are loaded and not used. */
MCV_LOOP_FUNCTION uint mcv_classify_hit(mcv_world world, __global const uint *triangles, uint hit) {
    const int misses = hit == MCV_NONE;
    const int on_solid = (hit != MCV_NONE) & mcv_is_exact(hit);
    __global const uint *instance = triangles + 4u * (misses | on_solid ? 0u : hit) + 3u;
    if (MCV_WITH_SURFACES)
        instance =
            on_solid ? world.solids[mcv_solid_of(hit)].instance + mcv_piece_of(hit) : instance;
    const uint number = *instance, shading = world.instances[misses ? 0u : number].shading;
    uint class = on_solid ? MCV_CLASS_EXACT : MCV_CLASS_TRIANGLE;
    class = shading >= MCV_SHADING_BLACK ? MCV_CLASS_BLACK + (shading - MCV_SHADING_BLACK) : class;
#define MCV_CHOOSE_CLASS(name, exact, bsdf, joined, A) \
    if (MCV_KNOWS_##bsdf && (MCV_WITH_SURFACES || !exact)) { \
        const int is_bsdf = shading == MCV_SHADING_##bsdf, is_geometry = on_solid == exact; \
        class = (is_bsdf & is_geometry) ? MCV_CLASS_##name : class; \
    }
    MCV_SHADING_CLASSES(MCV_CHOOSE_CLASS, )
#undef MCV_CHOOSE_CLASS
    return misses ? MCV_CLASS_MISS : class;
}

#if MCV_CACHED
/* The same where there are few triangles and exact surfaces. */
MCV_BATCH void mcv_lookup_classes(mcv_world world, __global const uint *triangles, const uint *hits,
                                  uint count, uint *classes) {
    uint of_each[MCV_CACHED];
    MCV_VECTORIZE
    for (uint i = 0; i < MCV_CACHED; ++i)
        of_each[i] =
            mcv_classify_hit(world, triangles, i < world.frame->triangle_count ? i : MCV_NONE);
    mcv_register_lookup(of_each, hits, count, classes);
    uint exacts[MCV_ROW];
    MCV_VECTORIZE
    for (uint i = 0; i < MCV_CACHED; ++i) {
        const uint hit = MCV_EXACT | i;
        const int is_solid = mcv_solid_of(hit) < world.frame->solid_count,
                  is_piece = is_solid & (mcv_piece_of(hit) < MCV_PIECE_COUNT);
        of_each[i] = mcv_classify_hit(world, triangles, is_piece ? hit : MCV_NONE);
    }
    mcv_register_lookup(of_each, hits, count, exacts);
    MCV_VECTORIZE
    for (uint i = 0; i < mcv_fill_lanes(count); ++i) {
        const uint class = mcv_is_exact(hits[i]) ? exacts[i] : classes[i];
        classes[i] = ((i < count) & (hits[i] != MCV_NONE)) ? class : MCV_CLASS_MISS;
    }
}
#endif

/* The class of each path. *glossy_material: the material of the glossy classes, which is that of
 * the first glossy path, or MCV_NONE. */
MCV_BATCH void mcv_classify_hits(mcv_world world, const uint *paths, uint count, uint *classes,
                                 uint *glossy_material) {
    const uint *hits = paths + (MCV_PATH_hit + 3) * MCV_ROW;
    __global const uint *triangles = (__global const uint *)world.triangles;
    if (MCV_WITH_SURFACES && !triangles) triangles = (__global const uint *)world.solids;
    *glossy_material = MCV_NONE;
    if (!triangles) {
        for (uint i = 0; i < count; ++i) classes[i] = MCV_CLASS_MISS;
        return;
    }
#if MCV_CACHED
    if (world.frame->triangle_count <= MCV_CACHED && 4u * world.frame->solid_count <= MCV_CACHED &&
        count >= 2 * MCV_CACHED)
        mcv_lookup_classes(world, triangles, hits, count, classes);
    else
#endif
    {
        MCV_VECTORIZE
        for (uint i = 0; i < mcv_fill_lanes(count); ++i)
            classes[i] = mcv_classify_hit(world, triangles, i < count ? hits[i] : MCV_NONE);
    }
    for (uint i = 0; MCV_KNOWS_GLOSSY && i < count; ++i) {
        const uint class = classes[i];
        if (class != MCV_CLASS_GLOSSY_TRIANGLE && class != MCV_CLASS_GLOSSY_EXACT) continue;
        const uint material = world.instances[mcv_instance_of(world, hits[i])].material;
        if (*glossy_material == MCV_NONE) *glossy_material = material;
        if (*glossy_material != material)
            classes[i] = class == MCV_CLASS_GLOSSY_EXACT ? MCV_CLASS_EXACT : MCV_CLASS_TRIANGLE;
    }
}

#endif
