/* SPDX-License-Identifier: Apache-2.0 */
/* What a ray that leaves the scene sees. */
#ifndef MCVISI_KERNELS_ENVIRONMENT_H
#define MCVISI_KERNELS_ENVIRONMENT_H

#include "light/discrete.h"
#include "geometry/surface.h"
#include "light/emission.h"
#include "light/mis.h"
#include "path/media.h"

#if MCV_WITH_ENVIRONMENT_IMAGE && MCV_WITH_TEXTURE
/* The one that lies in a unit direction. */
MCV_LOOP_FUNCTION mcv_pixel mcv_sky_pixel_at(__global const mcv_device_emitter *e,
                                             mcv_vec3 direction) {
    mcv_pixel pixel;
    mcv_environment_pixel(&e->environment, direction, &pixel.column, &pixel.row);
    return pixel;
}

/* The CDF of a row's pixels; that of the rows comes first. */
MCV_LOOP_FUNCTION __global const uint *
mcv_environment_row(mcv_world world, __global const mcv_device_emitter *e, uint row) {
    return world.emitter_cdf + e->cdf + e->environment.height + 1u +
           row * (e->environment.width + 1u);
}

/* The density [1/sr] with which next-event estimation chooses a direction into a pixel of the sky.
 */
MCV_LOOP_FUNCTION float
mcv_environment_density(mcv_world world, __global const mcv_device_emitter *e, mcv_pixel pixel) {
    const float pmf = mcv_cdf_pmf(world.emitter_cdf + e->cdf, pixel.row) *
                      mcv_cdf_pmf(mcv_environment_row(world, e, pixel.row), pixel.column);
    return e->probability * pmf / mcv_environment_solid_angle(&e->environment, pixel.row);
}
#endif

/*
 * The environment's light along a ray that met nothing, L/n². The power heuristic weights its image
 * against next-event estimation. `density` is that of the ray's choice, 0 for smooth surfaces.
 */
MCV_LOOP_FUNCTION mcv_color mcv_environment_seen(mcv_world world, mcv_vec3 direction, uint media,
                                                 float density) {
    mcv_color light = mcv_grey(0.0f);
#if MCV_WITH_ENVIRONMENT
    MCV_EACH_CHANNEL(i) light.c[i] = world.frame->environment[i];
#endif
#if MCV_WITH_ENVIRONMENT_IMAGE && MCV_WITH_TEXTURE
    __global const mcv_device_emitter *e = world.emitters + world.frame->environment_emitter;
    const mcv_pixel pixel = mcv_sky_pixel_at(e, direction);
    light = mcv_pixel_radiance(world, e, pixel);
#if MCV_WITH_NEXT_EVENT
    const float weight = mcv_power_heuristic(density, mcv_environment_density(world, e, pixel));
    light = mcv_dim(light, density > 0.0f ? weight : 1.0f);
#endif
#endif
    (void)direction, (void)density;
    return mcv_basic_radiance(world, light, media);
}

#endif
