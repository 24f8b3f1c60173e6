/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Scenes of few triangles: floors, walls and lamps beside exact bodies. What is known of each
 * triangle is worked out once for many paths and then looked up in registers; reading it from
 * memory, path by path, takes longer than all else about a place on a triangle.
 */
#ifndef MCVISI_KERNELS_SMALL_SCENE_CACHE_H
#define MCVISI_KERNELS_SMALL_SCENE_CACHE_H

#include "schedule/tile.h"

#include "schedule/compact.h"
#include "geometry/path_interaction.h"
#include "schedule/vectorize.h"

/* Of moving parts places differ from path to path. */
#define MCV_FACETS_CACHED (MCV_CACHED && !MCV_WITH_NORMALS && !MCV_WITH_MOVING)
#if MCV_FACETS_CACHED
enum { MCV_FACET_WORDS = 14, MCV_REGISTER_LOOKUP = 128 };

/* Rows of what mcv_facet_of says: corners, normal, area; and the instance. */
typedef struct mcv_facet_table {
    uint words[MCV_FACET_WORDS][MCV_CACHED];
} mcv_facet_table;

/* As of mcv_surface_on. */
MCV_LOOP_FUNCTION mcv_facet mcv_facet_in(const uint *words, uint row, uint i) {
    float f[MCV_FACET_WORDS];
    mcv_facet facet;
#pragma unroll
    for (uint k = 0; k < MCV_FACET_WORDS; ++k) f[k] = as_float(words[k * row + i]);
    facet.a = mcv_vec(f[0], f[1], f[2]);
    facet.b = mcv_vec(f[3], f[4], f[5]);
    facet.c = mcv_vec(f[6], f[7], f[8]);
    facet.ng = mcv_vec(f[9], f[10], f[11]);
    facet.area = f[12];
    facet.corners.x = facet.corners.y = facet.corners.z = 0u;
    facet.corners.w = as_uint(f[13]);
    return facet;
}

MCV_BATCH void mcv_fill_facets(mcv_world world, mcv_facet_table *table) {
    const uint count = world.frame->triangle_count;
    MCV_VECTORIZE
    for (uint i = 0; i < MCV_CACHED; ++i) {
        const mcv_facet facet = mcv_facet_of(world, i < count ? i : 0u);
        const float f[MCV_FACET_WORDS - 1] = {
            facet.a.x, facet.a.y, facet.a.z,  facet.b.x,  facet.b.y,  facet.b.z, facet.c.x,
            facet.c.y, facet.c.z, facet.ng.x, facet.ng.y, facet.ng.z, facet.area};
#pragma unroll
        for (uint k = 0; k < MCV_FACET_WORDS - 1; ++k) table->words[k][i] = as_uint(f[k]);
        table->words[MCV_FACET_WORDS - 1][i] = facet.corners.w;
    }
}

/* mcv_find_triangle for the paths in the slots first … last - 1, which have met triangles. */
MCV_BATCH void mcv_find_cached_triangles(uint *paths, const mcv_facet_table *table, uint first,
                                         uint last) {
    uint known[MCV_FACET_WORDS * MCV_REGISTER_LOOKUP];
    for (uint begin = first; begin < last; begin += MCV_REGISTER_LOOKUP) {
        const uint count = min(last - begin, (uint)MCV_REGISTER_LOOKUP);
        const uint *met = paths + (MCV_PATH_hit + 3) * MCV_ROW + begin;
        for (uint k = 0; k < MCV_FACET_WORDS; ++k)
            mcv_register_lookup(table->words[k], met, count, known + k * MCV_REGISTER_LOOKUP);
        MCV_VECTORIZE_MASKED
        MCV_EACH_PATH (slot, paths, begin, begin + count) {
            const uint i = slot.index - begin;
            mcv_facet facet = mcv_facet_in(known, MCV_REGISTER_LOOKUP, i);
            facet.triangle = met[i];
            mcv_put_surface(slot,
                            mcv_surface_on(facet, MCV_LOAD(slot, hit, 1), MCV_LOAD(slot, hit, 2)));
        }
    }
}
#endif

#endif
