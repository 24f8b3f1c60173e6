/* SPDX-License-Identifier: Apache-2.0 */
/* A sensor of a scene, as the command line speaks of it. */
#ifndef MCVISI_HOST_SCENE_SENSOR_FIND_H
#define MCVISI_HOST_SCENE_SENSOR_FIND_H

#include "scene/scene.h"

/* The sensor of a name or number. MCV_USAGE with the candidates where there is none, or more than
 * one of that name. */
mcv_result mcv_sensor_find(const mcv_scene *scene, const char *name, uint32_t *sensor,
                           mcv_error *error);

/* Its name where that tells it from the others, else its number. */
void mcv_sensor_label(const mcv_scene *scene, uint32_t sensor, char *label, size_t size);

/* Gives it width x height pixels (macro pixels) and such a size that the film, and so what it sees,
 * stays. */
mcv_result mcv_sensor_resize(mcv_sensor *sensor, uint64_t width, uint64_t height,
                             const mcv_scene *scene, mcv_error *error);

/* Does a pixel measure irradiance [W/m²] instead of mean radiance [W/(m² sr)]? */
bool mcv_sensor_measures_irradiance(const mcv_sensor *sensor);

#endif
