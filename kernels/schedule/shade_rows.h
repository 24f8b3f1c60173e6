/* SPDX-License-Identifier: Apache-2.0 */
/* Stage of the tile schedule: shade_surfaces over a slice. Paths whose BSDF is known are shaded
 * range by range (schedule/ranges.h), the others one by one. */
#ifndef MCVISI_KERNELS_SHADE_ROWS_H
#define MCVISI_KERNELS_SHADE_ROWS_H

#include "schedule/tile.h"

#include "schedule/begin_light_paths.h"
#include "schedule/sort_paths.h"
#include "schedule/surface_rows.h"
#include "stage/shade_hit.h"

/* How a camera path continues from a surface of a known kind. Returns its fate. Where the path
 * splits, branch_state holds the branch. */
MCV_LOOP_FUNCTION uint mcv_shade_camera_path(mcv_world world, mcv_slot slot,
                                             const mcv_interaction *interaction,
                                             mcv_shading shading, uint depth, uint *unmatched) {
    const mcv_shaded shaded = mcv_shade_hit(world, slot, interaction, shading, depth, unmatched);
    if (MCV_WITH_SPLIT && shading.may_split) mcv_store_split(slot, shaded.split);
    if (shading.kind != MCV_SHADING_SMOOTH) mcv_keep_selection(slot);
    mcv_continue_path(world, slot, interaction, shading, shaded.on, shaded.throughput,
                      shading.kind == MCV_SHADING_GLOSSY ? shaded.fate == MCV_UNSHADED : 0);
    return shaded.fate;
}

/* Shades the paths of a range. light: whether they are light paths, known to the compiler. */
MCV_LOOP_FUNCTION void mcv_shade_range(mcv_world world, uint *paths, uint first, uint last,
                                       mcv_shading shading, int light, uint depth, uint *fate,
                                       uint *unmatched) {
    (void)light;
    MCV_VECTORIZE_MASKED
    MCV_EACH_PATH (slot, paths, first, last) {
        uint differs = 0u;
        const mcv_interaction interaction = mcv_make_interaction(world, slot);
#if MCV_LIGHT_ROWS
        if (light)
            fate[slot.index] =
                mcv_shade_light_path(world, slot, &interaction, shading, depth, &differs);
        else
#endif
            fate[slot.index] =
                mcv_shade_camera_path(world, slot, &interaction, shading, depth, &differs);
        unmatched[slot.index] = differs;
    }
}

/* Shades the paths whose BSDF is known: fate[i] of each; MCV_UNSHADED of the others. */
MCV_LOOP_FUNCTION void mcv_shade_ranges(mcv_world world, uint *paths, const uint *class_end,
                                        uint glossy_material, int light, uint depth, uint *fate,
                                        uint *unmatched) {
    uint differs[MCV_SLOTS];
    const uint known_end = class_end[MCV_LAST_KNOWN];
    (void)glossy_material, (void)light;
#define MCV_SHADE(bsdf, first, last, shading) \
    mcv_shade_range(world, paths, first, last, shading, light, depth, fate, differs);
    MCV_EACH_RANGE(MCV_SHADE)
#undef MCV_SHADE
    for (uint i = 0; i < known_end; ++i) *unmatched += differs[i];
    for (uint i = known_end; i < class_end[MCV_LAST_CLASS]; ++i) fate[i] = MCV_UNSHADED;
}

/* Starts the branches of the first `last` paths in the slots from `begin` on; returns where they
 * end. The paths have continued already: what a branch needs is in branch_state and in the rows of
 * the surface. */
MCV_BATCH uint mcv_split_paths(mcv_world world, uint *paths, const uint *fate, uint last,
                               uint begin) {
    uint splitting[MCV_SLOTS], count = 0;
    MCV_VECTORIZE
    for (uint i = 0; i < last; ++i) splitting[i] = fate[i] & MCV_SPLITS;
    const uint rows[4][2] = {{MCV_PATH_stream, MCV_PATH_sample + 1 + MCV_WITH_MOVING},
                             {MCV_PATH_weight, MCV_PATH_hit + 4},
                             {MCV_PATH_point, MCV_PATH_LAST_glossy_known + 1},
                             {MCV_PATH_branch_state, MCV_PATH_LAST_branch_state + 1}};
    for (uint i = 0; i < 4; ++i) {
        uint *from = paths + rows[i][0] * MCV_ROW;
        count =
            mcv_compact_rows(splitting, from, rows[i][1] - rows[i][0], MCV_ROW, last, from + begin);
    }
    MCV_VECTORIZE
    MCV_EACH_PATH (slot, paths, begin, begin + count) {
        const mcv_split split = mcv_load_split(slot);
        const mcv_interaction interaction = mcv_make_interaction(world, slot);
        mcv_continue_branch(world, slot, &interaction,
                            mcv_shading_of(MCV_SHADING_SMOOTH, MCV_WITH_SURFACES, 1), split);
    }
    return begin + count;
}

/* Shades the paths: fate[i] of each. Their branches begin in the slots from `alive` on; returns
 * where these end. */
MCV_BATCH uint mcv_shade_paths(mcv_world world, mcv_slot slot, const uint *class_end,
                               uint glossy_material, uint depth, uint *fate, uint *unmatched) {
    const uint alive = class_end[MCV_LAST_CLASS];
    uint flags[MCV_ROW], unshaded[MCV_SLOTS];
    mcv_slot beside = slot;
    beside.index = alive;
    mcv_draw_pairs(slot.base, 0, alive, depth, MCV_PAIR_SCATTER);
#if MCV_WITH_DIFFUSE
    mcv_sample_diffuse_directions(slot.base, class_end[MCV_LAST_SMOOTH], alive);
#endif
    mcv_shade_ranges(world, slot.base, class_end, glossy_material, 0, depth, fate, unmatched);
    if (MCV_HAS_SMOOTH && MCV_WITH_SPLIT)
        beside.index = mcv_split_paths(world, slot.base, fate, class_end[MCV_LAST_GLOSSY], alive);
    MCV_VECTORIZE
    for (uint i = 0; i < alive; ++i) flags[i] = fate[i] == MCV_UNSHADED;
    const uint count = mcv_compact_indices(flags, alive, unshaded);
    for (uint i = 0; i < count; ++i) {
        slot.index = unshaded[i];
        fate[slot.index] = mcv_shade_surface(world, slot, beside, depth, unmatched);
        beside.index += (fate[slot.index] & MCV_SPLITS) != 0u;
    }
    if (MCV_OFFSETS_TOGETHER) mcv_offset_origins(world, slot.base, alive);
    return beside.index;
}

#endif
