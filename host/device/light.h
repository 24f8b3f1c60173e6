/* SPDX-License-Identifier: Apache-2.0 */
/* What light paths need (kernels/stage/trace_light_path.h): their starting points, their flux, the
 * units of their contributions. */
#ifndef MCVISI_HOST_DEVICE_LIGHT_H
#define MCVISI_HOST_DEVICE_LIGHT_H

#include "device/pack.h"

/* Fills in the balls, the emitters' light_inverse_pdf, light_aim and media, and the shares by which
 * emitters are chosen: emitter_count + 1 entries of cdf. */
mcv_result mcv_pack_light(const mcv_scene *scene, mcv_packed *packed, uint32_t *cdf,
                          mcv_error *error);

/*
 * Writes cumulative shares in units of 2^-31. The choice has the same resolution
 * (kernels/light/discrete.h), so each entry is chosen exactly as often as its share says. The last
 * entry is 2^31. Returns the sum of the values.
 */
double mcv_write_cdf(uint32_t *cdf, uint32_t count, const double *values);

/*
 * The k with which the samples of every 2^k-th pixel have a light path, for an image of that size.
 * There are about four light paths for each pixel that the balls cover, at most one per pixel. The
 * contribution of a path to a pixel is then a quarter of the emitter's direct light without the
 * bodies, for any emitter: radiance gives L Ω there, and a path's flux is L Ω times the balls'
 * disks over the number of paths.
 */
uint32_t mcv_light_thinning(const mcv_packed *packed, const mcv_sensor *sensor);

enum {
    MCV_MOST_THINNING = 6, /* pixels come in blocks of 2^6 */
    MCV_NO_LIGHT_PATHS,    /* in place of a k: there are none */
};

/* Do camera paths find the light of all emitters that have light paths? These can then be left
 * out. */
bool mcv_camera_finds_light(const mcv_packed *packed);

/* Do light paths contribute light to this sensor that camera paths miss, or find with more
 * noise? */
bool mcv_traces_light(const mcv_packed *packed, const mcv_sensor *sensor);

/*
 * The value of one splat unit, a power of two: 2^-16 of a path's contribution from the distance of
 * the scene's middle. This is fine enough, because rounding is random. A pixel has room for 2^48
 * such paths.
 */
double mcv_splat_unit(const mcv_packed *packed, const mcv_sensor *sensor, const mcv_frame *frame);

#endif
