/* SPDX-License-Identifier: Apache-2.0 */
/* The media that a path is in: which one fills a place, and what it does to light. */
#ifndef MCVISI_KERNELS_MEDIA_H
#define MCVISI_KERNELS_MEDIA_H

#include "mcvisi/elementary.h"
#include "world.h"

/* The medium that fills a place inside all media of the set: the one of the highest priority. */
MCV_FUNCTION uint mcv_filling_medium(uint media) { return 32u - clz(media); }

/* Radiance L of light in a medium as paths carry it, L/n². */
MCV_LOOP_FUNCTION mcv_color mcv_basic_radiance(mcv_world world, mcv_color radiance, uint media) {
    if (!MCV_WITH_DIELECTRIC) return radiance;
    return mcv_dim(radiance, world.medium_table[mcv_filling_medium(media)].inverse_index_squared);
}

/* What the medium leaves of light over a distance. */
MCV_LOOP_FUNCTION mcv_color mcv_medium_transmittance(mcv_world world, uint media, float distance) {
    __global const mcv_device_medium *medium = world.medium_table + mcv_filling_medium(media);
    mcv_color transmittance = mcv_grey(1.0f);
    MCV_EACH_CHANNEL(i) {
        const int absorbs = MCV_WITH_ABSORPTION && medium->absorption[i] > 0.0f;
        const float left = mcv_exp_minus(absorbs ? medium->absorption[i] * distance : 0.0f);
        transmittance.c[i] = absorbs ? left : 1.0f;
    }
    return transmittance;
}

#endif
