/* SPDX-License-Identifier: Apache-2.0 */
/* The tile schedule's shadows in the rows of a slice, and the loops that make shadow rays of them.
 */
#ifndef MCVISI_KERNELS_MAKE_SHADOW_ROWS_H
#define MCVISI_KERNELS_MAKE_SHADOW_ROWS_H

#include "schedule/tile.h"

#include "schedule/compact.h"
#include "schedule/ranges.h"
#include "schedule/vectorize.h"
#include "stage/sample_emitters.h"

#if MCV_WITH_NEXT_EVENT
MCV_LOOP_FUNCTION mcv_light_sample mcv_load_light_sample(mcv_slot slot) {
    mcv_light_sample sample;
    sample.origin = MCV_LOAD_3(slot, shadow_origin);
    sample.direction = MCV_LOAD_3(slot, shadow_direction);
    sample.target = MCV_WORD(slot, shadow_target, 0);
    MCV_LOAD_COLOR(slot, shadow_light, sample.radiance_over_pdf);
    sample.pdf = MCV_LOAD(slot, shadow_density, 0);
    sample.emitter_element =
        MCV_WITH_RECORDS ? MCV_WORD(slot, shadow_emitter_element, 0) : MCV_NONE;
    return sample;
}

#if MCV_HAS_PLAIN
/* Whether the paths in the slots first … last - 1, whose surfaces are of one kind, have a shadow
 * ray to follow. */
MCV_LOOP_FUNCTION void mcv_make_shadow_range(mcv_world world, mcv_slot slot, uint first, uint last,
                                             mcv_shading shading, uint *casts) {
    MCV_VECTORIZE_MASKED
    for (uint i = first; i < last; ++i) {
        slot.index = i;
        const mcv_interaction interaction = mcv_make_interaction(world, slot);
        casts[i] = (uint)mcv_make_shadow_ray(world, slot, &interaction, shading,
                                             mcv_load_light_sample(slot));
    }
}

/* Lists those of the paths on plain surfaces that have a shadow ray to follow; returns how many. */
MCV_BATCH uint mcv_list_plain_shadows(mcv_world world, mcv_slot slot, const uint *class_end,
                                      uint glossy_material, uint *shadows) {
    uint casts[MCV_ROW];
    const uint begin = class_end[MCV_LAST_SMOOTH], end = class_end[MCV_LAST_KNOWN];
    (void)glossy_material;
#define MCV_MAKE_SHADOWS(bsdf, first, last, shading) \
    if (bsdf != MCV_SHADING_SMOOTH) mcv_make_shadow_range(world, slot, first, last, shading, casts);
    MCV_EACH_RANGE(MCV_MAKE_SHADOWS)
#undef MCV_MAKE_SHADOWS
    const uint listed = mcv_compact_indices(casts + begin, end - begin, shadows);
    for (uint i = 0; i < listed; ++i) shadows[i] += begin;
    return listed;
}
#endif
#endif

#endif
