/* SPDX-License-Identifier: Apache-2.0 */
#include "scene/sensor_find.h"

#include "scene/sensors.h"

#include <stdio.h>
#include <string.h>

static uint32_t count_named(const mcv_scene *scene, const char *name) {
    uint32_t count = 0;
    for (uint32_t i = 0; i < scene->sensor_count; ++i)
        count += strcmp(scene->sensors[i].name, name) == 0;
    return count;
}

void mcv_sensor_label(const mcv_scene *scene, uint32_t sensor, char *label, size_t size) {
    const char *name = scene->sensors[sensor].name;
    if (name[0] != '\0' && count_named(scene, name) == 1)
        snprintf(label, size, "%s", name);
    else
        snprintf(label, size, "%u", sensor);
}

mcv_result mcv_sensor_find(const mcv_scene *scene, const char *name, uint32_t *sensor,
                           mcv_error *error) {
    char labels[1024] = "";
    for (*sensor = 0; *sensor < scene->sensor_count; ++*sensor) {
        char label[128], number[16];
        mcv_sensor_label(scene, *sensor, label, sizeof label);
        snprintf(number, sizeof number, "%u", *sensor);
        if (strcmp(name, label) == 0 ||
            (strcmp(name, number) == 0 && count_named(scene, name) == 0))
            return MCV_OK;
        const size_t length = strlen(labels);
        snprintf(labels + length, sizeof labels - length, "%s%s", length ? ", " : "", label);
    }
    const uint32_t count = count_named(scene, name);
    if (count > 1)
        return mcv_fail(error, MCV_USAGE,
                        "%s: %u sensors are called %s: give the number of one: %s", scene->path,
                        count, name, labels);
    return mcv_fail(error, MCV_USAGE, "%s: there is no sensor %s: there are %s", scene->path, name,
                    labels);
}

static void *parameter(const mcv_sensor *sensor, const char *key) {
    return mcv_params_find(mcv_sensor_table(sensor->type), key, &sensor->as);
}

mcv_result mcv_sensor_resize(mcv_sensor *sensor, uint64_t width, uint64_t height,
                             const mcv_scene *scene, mcv_error *error) {
    const uint64_t size[2] = {width, height};
    uint32_t *resolution = parameter(sensor, "spatialResolution");
    double *pixel_size = parameter(sensor, "pixelSize");
    double *principal_point = parameter(sensor, "principalPoint");
    if (!resolution) resolution = parameter(sensor, "resolution");
    if (!resolution || !pixel_size)
        return mcv_fail(error, MCV_USAGE,
                        "%s: sensor %s has no resolution to change: leave out --resolution",
                        scene->path, sensor->name);
    const mcv_readout readout = mcv_sensor_readout(sensor);
    if (readout.size[0] != resolution[0] || readout.size[1] != resolution[1])
        return mcv_fail(error, MCV_USAGE,
                        "%s: sensor %s has a regionOfInterest or binning: leave out --resolution",
                        scene->path, sensor->name);
    for (int i = 0; i < 2; ++i) {
        if (principal_point) principal_point[i] *= (double)size[i] / (double)resolution[i];
        pixel_size[i] *= (double)resolution[i] / (double)size[i];
        resolution[i] = (uint32_t)size[i];
    }
    return MCV_OK;
}

bool mcv_sensor_measures_irradiance(const mcv_sensor *sensor) {
    const int *radiometry = parameter(sensor, "radiometry");
    return radiometry && *radiometry == MCV_RADIOMETRY_IRRADIANCE;
}
