/* SPDX-License-Identifier: Apache-2.0 */
/* Emitters on the host: radiometry and what the device needs, in double. */
#ifndef MCVISI_HOST_SCENE_EMITTERS_H
#define MCVISI_HOST_SCENE_EMITTERS_H

#include "scene/place.h"
#include "scene/scene.h"

/* Checks parameters by the table; names the collimated beam where a cone's half-angle is 0. */
mcv_result mcv_emitter_check(const mcv_emitter *emitter, const mcv_place *place, mcv_error *error);

/* emitter->radiance from its parameters and its area: exactly one of radiance and power must be given. */
mcv_result mcv_emitter_resolve(mcv_emitter *emitter, const mcv_place *place, mcv_error *error);

/* The member `radiance`, `power` or `size` of the parameters, or NULL where this type has none. */
double *mcv_emitter_parameter(mcv_emitter *emitter, const char *key);

/* Solid angle of the emission cone [sr]: 4π sin²(β/2), 2π for area; 4π for the environment. */
double mcv_emitter_solid_angle(const mcv_emitter *emitter);

/* Exitance over radiance [sr]: π sin²β for parallel, π for area and environment. Power = radiance x this x area. */
double mcv_emitter_projected_solid_angle(const mcv_emitter *emitter);

/*
 * The device struct of emitters[index]. A cone of up to 30° about one common normal is sampled from the receiver: a wider
 * one looks like a hemisphere, where sampling by area is as good.
 */
void mcv_parallel_prepare(const mcv_scene *scene, uint32_t index, mcv_parallel *device);

#endif
