/* SPDX-License-Identifier: Apache-2.0 */
/* What light paths need (kernels/stage/trace_light_path.h): where they start, what each carries,
 * the units of what they bring. */
#ifndef MCVISI_HOST_DEVICE_LIGHT_H
#define MCVISI_HOST_DEVICE_LIGHT_H

#include "device/pack.h"

/* Fills in the balls, the emitters' light_flux, light_aim and media, and the shares by which they
 * are chosen: emitter_count + 1 entries of cdf. */
mcv_result mcv_pack_light(const mcv_scene *scene, mcv_packed *packed, uint32_t *cdf,
                          mcv_error *error);

/*
 * Cumulative shares in units of 2^-31: as fine as what chooses from them
 * (kernels/light/discrete.h), so that each is chosen exactly as often as its share says. The last
 * entry is 2^31. Returns the sum of the values.
 */
double mcv_write_cdf(uint32_t *cdf, uint32_t count, const double *values);

/*
 * The k with which every 2^k-th pixel's samples have a light path, of an image of that size: about
 * four paths for each pixel that the balls cover in it, or one for each pixel. Then what a path
 * brings to a pixel is a quarter of what the emitter's light, without the bodies, makes of it:
 * whatever the emitter, radiance is L Ω there and a path's flux L Ω times the balls' disks over the
 * paths.
 */
uint32_t mcv_light_thinning(const mcv_packed *packed, const mcv_sensor *sensor);

enum { MCV_MOST_THINNING = 6 }; /* pixels come in blocks of 2^6 */

/* Is there light that light paths bring to this sensor and camera paths do not, or with more noise?
 */
bool mcv_traces_light(const mcv_packed *packed, const mcv_sensor *sensor);

/*
 * The value of one unit of the splats, a power of two: 2^-16 of what a path brings from a place as
 * far away as the middle of the scene. That is fine, for rounding is at random, and leaves room for
 * 2^48 such paths in a pixel.
 */
double mcv_splat_unit(const mcv_packed *packed, const mcv_sensor *sensor, const mcv_frame *frame);

#endif
