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

#if MCV_WITH_RECORDS && MCV_WITH_TEXTURE && (MCV_WITH_EMISSION || MCV_WITH_BEAM)
/* The pixel of an emitter's image that sends light from a place in a direction (unit, away from the
 * surface); 0 if none does. */
MCV_FUNCTION int mcv_emitting_pixel(mcv_world world, mcv_surface surface,
                                    __global const mcv_device_emitter *e, mcv_vec3 direction,
                                    mcv_pixel *pixel) {
#if MCV_WITH_LIGHT_FIELD
    if (e->type == MCV_EMITTER_LIGHT_FIELD_EMITTER)
        return mcv_find_light_field_pixel(world, surface, e, direction, pixel);
#endif
#if MCV_WITH_PROJECTOR
    if (e->type == MCV_EMITTER_PROJECTOR)
        return mcv_find_projector_pixel(world, surface, e, direction, pixel);
#endif
    *pixel = mcv_texel_at(world, surface, e->texture);
    (void)direction;
    return 1;
}
#endif

/* That which sends light from a place on an emitter in a direction (unit, away from the surface).
 */
MCV_FUNCTION uint mcv_emitter_element_of(mcv_world world, uint emitter, mcv_surface surface,
                                         mcv_vec3 direction) {
    uint emitter_element = mcv_first_emitter_element(world, emitter);
    (void)surface, (void)direction;
#if MCV_WITH_RECORDS && MCV_WITH_TEXTURE && (MCV_WITH_EMISSION || MCV_WITH_BEAM)
    mcv_pixel pixel;
    __global const mcv_device_emitter *e = world.emitters + emitter;
    if (e->emitter_element_width > 0u && mcv_emitting_pixel(world, surface, e, direction, &pixel))
        emitter_element += pixel.row * e->emitter_element_width + pixel.column;
#endif
    return emitter_element;
}

#endif
