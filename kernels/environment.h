/* SPDX-License-Identifier: Apache-2.0 */
/* What a ray that leaves the scene sees. */
#ifndef MCVISI_KERNELS_ENVIRONMENT_H
#define MCVISI_KERNELS_ENVIRONMENT_H

#include "surface.h"

#if MCV_WITH_ENVIRONMENT_IMAGE && MCV_WITH_TEXTURE
/* Radiance of the environment's image from a unit direction. */
MCV_FUNCTION mcv_color mcv_environment_radiance(mcv_world world, __global const mcv_device_emitter *e, mcv_vec3 direction) {
    uint column, row;
    mcv_environment_pixel(&e->environment, direction, &column, &row);
    mcv_color radiance = mcv_texel(world, world.textures[e->texture], (int)column, (int)row);
    MCV_EACH_CHANNEL(i) radiance.c[i] *= e->radiance[i];
    return radiance;
}

/* The share of an entry in a table of cumulative shares. */
MCV_FUNCTION float mcv_cdf_share(__global const uint *cdf, uint i) {
    return (float)(cdf[i + 1] - cdf[i]) * 4.656612873077393e-10f; /* 2^-31 */
}

/* The cumulative shares of a row's pixels; those of the rows come first. */
MCV_FUNCTION __global const uint *mcv_environment_row(mcv_world world, __global const mcv_device_emitter *e, uint row) {
    return world.emitter_cdf + e->cdf + e->environment.height + 1u + row * (e->environment.width + 1u);
}

/* The density [1/sr] with which next-event estimation chooses a direction into the sky. */
MCV_FUNCTION float mcv_environment_density(mcv_world world, __global const mcv_device_emitter *e, mcv_vec3 direction) {
    uint column, row;
    mcv_environment_pixel(&e->environment, direction, &column, &row);
    const float share = mcv_cdf_share(world.emitter_cdf + e->cdf, row) * mcv_cdf_share(mcv_environment_row(world, e, row), column);
    return e->probability * share / mcv_environment_solid_angle(&e->environment, row);
}
#endif

/*
 * The environment's light along a ray that met nothing, L/n², weighed against next-event estimation, which looks for its image, by the
 * balance heuristic; `density` is that of the ray's choice, 0 for smooth surfaces.
 */
MCV_FUNCTION mcv_color mcv_environment_met(mcv_world world, mcv_vec3 direction, uint media, float density) {
    mcv_color light = mcv_grey(0.0f);
#if MCV_WITH_ENVIRONMENT
    MCV_EACH_CHANNEL(i) light.c[i] = world.frame->environment[i];
#endif
#if MCV_WITH_ENVIRONMENT_IMAGE && MCV_WITH_TEXTURE
    __global const mcv_device_emitter *e = world.emitters + world.frame->environment_emitter;
    light = mcv_environment_radiance(world, e, direction);
#if MCV_WITH_NEXT_EVENT
    if (density > 0.0f) light = mcv_dim(light, density / (density + mcv_environment_density(world, e, direction)));
#endif
#endif
#if MCV_WITH_DIELECTRIC
    light = mcv_dim(light, world.media[mcv_filling_medium(media)].inverse_index_squared);
#endif
    (void)world, (void)direction, (void)media, (void)density;
    return light;
}

#endif
