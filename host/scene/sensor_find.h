/* SPDX-License-Identifier: Apache-2.0 */
/* Finding a sensor of a scene for the command line. */
#ifndef MCVISI_HOST_SCENE_SENSOR_FIND_H
#define MCVISI_HOST_SCENE_SENSOR_FIND_H

#include "scene/scene.h"

/* The sensor with a name or number. MCV_USAGE with the candidates if there is none, or if several
 * have the name. */
mcv_result mcv_sensor_find(const mcv_scene *scene, const char *name, uint32_t *sensor,
                           mcv_error *error);

/* Its name if that is unique, else its number. */
void mcv_sensor_label(const mcv_scene *scene, uint32_t sensor, char *label, size_t size);

/* Gives the sensor width x height (macro) pixels, with a pixel size that keeps the film's size and
 * the field of view. */
mcv_result mcv_sensor_resize(mcv_sensor *sensor, uint64_t width, uint64_t height,
                             const mcv_scene *scene, mcv_error *error);

/* Does a pixel measure irradiance [W/m²] instead of mean radiance [W/(m² sr)]? */
bool mcv_sensor_measures_irradiance(const mcv_sensor *sensor);

#endif
