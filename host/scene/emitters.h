/* SPDX-License-Identifier: Apache-2.0 */
/* Emitters on the host: radiometry and what the device needs, in double. */
#ifndef MCVISI_HOST_SCENE_EMITTERS_H
#define MCVISI_HOST_SCENE_EMITTERS_H

#include "core/json_path.h"
#include "mcvisi/point_light.h"
#include "mcvisi/surface_light.h"
#include "scene/scene.h"

/* Is it a light without extent (MCV_POINT_LIGHTS)? */
bool mcv_emitter_is_point_light(uint32_t type);

/* Has it a place but no surface: a light without extent, or a laser? */
bool mcv_emitter_has_place(uint32_t type);

/* Does its radiance depend on the angle from its surface's normal alone (MCV_SURFACE_LIGHTS)? */
bool mcv_emitter_is_surface_light(uint32_t type);

/* Where a light's range ends, of those without extent [m]; NaN: nowhere. */
const double *mcv_emitter_range(const mcv_emitter *emitter);

/* Does this type emit from the surface of an instance? */
bool mcv_emitter_has_surface(uint32_t type);

/* Checks parameters by the table, names the collimated beam where a cone's half-angle is 0, derives
 * what a lens's parameters leave out. */
mcv_result mcv_emitter_check(mcv_emitter *emitter, const mcv_json_path *place, mcv_error *error);

/* Does the parameter `image` fit: a texture of the scene, but for an environment on a rectangle,
 * M·J x N·K pixels for a light field? */
mcv_result mcv_emitter_check_image(const mcv_scene *scene, const mcv_emitter *emitter,
                                   const mcv_json_path *place, mcv_error *error);

/* emitter->radiance from its parameters, area and image: exactly one of radiance (irradiance,
 * intensity) and power must be given. */
mcv_result mcv_emitter_resolve(const mcv_scene *scene, mcv_emitter *emitter,
                               const mcv_json_path *place, mcv_error *error);

/* Width and height of its rectangle, or NaN where it is not one of its own [m]. */
void mcv_emitter_size(const mcv_scene *scene, const mcv_emitter *emitter, double size[2]);

/* The member `radiance` or `power` of the parameters, or NULL where this type has none. */
double *mcv_emitter_parameter(mcv_emitter *emitter, const char *key);

/* What says how bright it is apart from `power`: "radiance", "irradiance" or "intensity"; of a
 * laser "power" itself. *unit is its unit. */
const char *mcv_emitter_brightness(const mcv_emitter *emitter, const char **unit);

/* Are its image's columns flipped? */
bool mcv_emitter_mirrors(const mcv_emitter *emitter);

/* The parameter `image`, `pattern` or `index`, or NULL where this type has none. */
uint32_t *mcv_emitter_image(mcv_emitter *emitter);
mcv_pattern *mcv_emitter_pattern(mcv_emitter *emitter);
uint32_t *mcv_emitter_index(mcv_emitter *emitter);

/* Width and height of a projector's or screen's image in pixels: of its texture, or of the pattern
 * that the texture holds a line of. */
void mcv_picture_resolution(const mcv_pattern *pattern, const mcv_texture *texture,
                            uint32_t pixels[2]);

/* Does a screen's light depend on the angle or on the place in a pixel (feature SCREEN)? */
bool mcv_screen_has_structure(const mcv_emitter *emitter);

/* How far a screen rises at a place from -1 to 1 across its width and height [m]. */
double mcv_screen_rise(const mcv_screen_params *p, double xi, double eta);

/* Half-angle β of its emission cone [rad]; NaN where the type has none. */
double mcv_emitter_half_angle(const mcv_emitter *emitter);

/*
 * The mean of its image per channel, each pixel weighed by the power it sends at equal radiance; 1
 * without `image` (an emissive texture is left out: how it lies on its mesh is not looked at).
 */
void mcv_emitter_image_mean(const mcv_scene *scene, const mcv_emitter *emitter, double mean[3]);

/*
 * Solid angle into which each of its points emits [sr]: 4π sin²(β/2) for a cone, 2π for area, 4π
 * for the environment, less than 2π for a light field; NaN for a projector, whose image says, and a
 * laser.
 */
double mcv_emitter_solid_angle(const mcv_emitter *emitter);

/*
 * Exitance over radiance [sr]: π sin²β for a cone, π for area and environment, the area of the
 * square |x|, |y| <= a in the unit disk for a light field, NaN for a projector. Power = radiance x
 * image mean x this x area.
 */
double mcv_emitter_projected_solid_angle(const mcv_emitter *emitter);

/* Its power at radiance (irradiance, intensity) 1 and image mean 1; NaN where it has none:
 * environment and directional light. */
double mcv_emitter_unit_power(const mcv_scene *scene, const mcv_emitter *emitter);

/*
 * The device struct of emitters[index]; the projector's is that of the parallel emitter. A cone of
 * up to 30° about one common normal is sampled from the receiver: a wider one looks like a
 * hemisphere, where sampling by area is as good.
 */
void mcv_parallel_prepare(const mcv_scene *scene, uint32_t index, mcv_parallel *device);
void mcv_light_field_emitter_prepare(const mcv_scene *scene, uint32_t index,
                                     mcv_light_field_emitter *device);
void mcv_environment_prepare(const mcv_scene *scene, uint32_t index,
                             mcv_environment *device); /* one with an image */
void mcv_projector_prepare(const mcv_scene *scene, uint32_t index, mcv_projector *device);
void mcv_collimated_beam_prepare(const mcv_scene *scene, uint32_t index,
                                 mcv_collimated_beam *device);

/* Lights without extent, in a world whose origin is moved to `centre`. */
void mcv_point_light_prepare(const mcv_scene *scene, uint32_t index, const double centre[3],
                             mcv_point_light *device);
void mcv_surface_light_prepare(const mcv_scene *scene, uint32_t index, mcv_surface_light *device);
void mcv_directional_prepare(const mcv_scene *scene, uint32_t index, mcv_directional *device);

#endif
