/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Which element of an emitter sends light: the whole emitter, or a pixel of its image. Elements are
 * the columns of a light transport matrix (host/transport/matrix.h). Without the feature RECORDS
 * all have the number 0, and nobody asks for it.
 */
#ifndef MCVISI_KERNELS_EMITTER_ELEMENT_H
#define MCVISI_KERNELS_EMITTER_ELEMENT_H

#include "light/emission.h"

/* That of an emitter whose elements are not told apart, or its first one. */
MCV_LOOP_FUNCTION uint mcv_first_emitter_element(mcv_world world, uint emitter) {
    return MCV_WITH_RECORDS ? world.emitters[emitter].first_emitter_element : 0u;
}

/* That of the environment. */
MCV_LOOP_FUNCTION uint mcv_environment_element(mcv_world world) {
    return MCV_WITH_RECORDS ? world.frame->environment_element : 0u;
}

/* That which sends light from a place on an emitter in a direction (unit, away from the surface).
 */
MCV_FUNCTION uint mcv_emitter_element_of(mcv_world world, uint emitter, mcv_surface surface,
                                         mcv_vec3 direction) {
    uint emitter_element = mcv_first_emitter_element(world, emitter);
    (void)surface, (void)direction;
#if MCV_WITH_RECORDS && MCV_WITH_TEXTURE && (MCV_WITH_EMISSION || MCV_WITH_BEAM)
    mcv_pixel pixel;
    __global const mcv_device_emitter *e = world.emitters + emitter;
    if (e->emitter_element_width == 0u) return emitter_element;
    if (!MCV_SENDS_BY_PIXEL(e))
        pixel = mcv_texel_at(world, surface, e->texture);
    else if (!mcv_find_pixel(world, surface, e, direction, &pixel))
        return emitter_element;
    emitter_element += pixel.row * e->emitter_element_width + pixel.column;
#endif
    return emitter_element;
}

#endif
