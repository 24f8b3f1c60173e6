/* SPDX-License-Identifier: Apache-2.0 */
/* Bodies that refract colours differently: a path keeps one channel there. */
#ifndef MCVISI_KERNELS_DISPERSION_H
#define MCVISI_KERNELS_DISPERSION_H

#include "path/sampler.h"
#include "world.h"

#if MCV_WITH_DISPERSION
/* The one channel that goes on at a body that refracts them differently, by what a path carries. */
MCV_FUNCTION uint mcv_choose_channel(mcv_color carried, float xi, float *chance) {
    const float sum = carried.c[0] + carried.c[1] + carried.c[2];
    const uint channel = xi * sum < carried.c[0]                  ? 0u
                         : xi * sum < carried.c[0] + carried.c[1] ? 1u
                                                                  : 2u;
    *chance = carried.c[channel] > 0.0f ? carried.c[channel] / sum : 1.0f;
    return channel;
}

MCV_FUNCTION mcv_color mcv_keep_channel(mcv_color color, uint channel, float chance) {
    MCV_EACH_CHANNEL(i) color.c[i] = (uint)i == channel ? color.c[i] / chance : 0.0f;
    return color;
}

/* The channel of a path that carries only one: nothing else needs to tell. */
MCV_FUNCTION uint mcv_kept_channel(mcv_color carried) {
    return carried.c[1] > 0.0f ? 1u : carried.c[2] > 0.0f ? 2u : 0u;
}

/* The world as light of a channel meets it: with its indices of refraction. */
MCV_FUNCTION mcv_world mcv_in_channel(mcv_world world, uint channel) {
    world.medium_table += channel * (MCV_MAX_MEDIA + 1u);
    world.interfaces += channel * (MCV_MAX_MEDIA + 1u) * (MCV_MAX_MEDIA + 1u);
#if MCV_WITH_MIXED
    world.refractive_indices += channel * (MCV_MAX_MEDIA + 1u);
#endif
    return world;
}

/* Keeps one channel of a throughput at a dielectric, by what is carried; the world as the path's
 * light meets it. `stream` and `sample` are the path's, of either kind. mcv_disperse calls it at
 * the surface that a camera path has met, and therefore is in geometry/path_interaction.h. */
MCV_FUNCTION mcv_world mcv_disperse_at(mcv_world world, uint instance, uint stream, uint sample,
                                       mcv_color carried, mcv_color *throughput) {
    if (world.instances[instance].medium != 0u) {
        float chance;
        const uint channel = mcv_choose_channel(
            carried, mcv_sample_pair(stream, sample, MCV_PAIR_CHANNEL).x, &chance);
        *throughput = mcv_keep_channel(*throughput, channel, chance);
    }
    return mcv_in_channel(world, mcv_kept_channel(*throughput));
}
#endif

#endif
