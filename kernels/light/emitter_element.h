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
 * Loops know whether the emitter sends by pixel. */
MCV_LOOP_FUNCTION uint mcv_emitter_element_by(mcv_world world, uint emitter, mcv_surface surface,
                                              mcv_vec3 direction, int by_pixel) {
    const uint first = mcv_first_emitter_element(world, emitter);
    (void)surface, (void)direction, (void)by_pixel;
#if MCV_WITH_RECORDS && MCV_WITH_TEXTURE && (MCV_HAS_EMISSION || MCV_WITH_BEAM)
    __global const mcv_device_emitter *e = world.emitters + emitter;
    const int told = e->emitter_element_width > 0u;
    int lit = 1;
    mcv_pixel pixel;
    if (by_pixel)
        lit = mcv_find_pixel(world, surface, e, direction, &pixel);
    else
        pixel = mcv_texel_at(world, surface, told ? e->texture : 0u);
    return first + (told & lit ? pixel.row * e->emitter_element_width + pixel.column : 0u);
#else
    return first;
#endif
}

MCV_LOOP_FUNCTION uint mcv_emitter_element_of(mcv_world world, uint emitter, mcv_surface surface,
                                              mcv_vec3 direction) {
    return mcv_emitter_element_by(world, emitter, surface, direction,
                                  MCV_SENDS_BY_PIXEL(world.emitters + emitter));
}

#endif
