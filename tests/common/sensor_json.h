/* SPDX-License-Identifier: Apache-2.0 */
/* Sensors from JSON, without a file. */
#ifndef MCVISI_TESTS_SENSOR_JSON_H
#define MCVISI_TESTS_SENSOR_JSON_H

#include "test.h"

#include "scene/params.h"
#include "scene/sensors.h"

#include <jansson.h>

/* Parses a JSON object as a sensor of this type, checks and resolves it. */
static inline mcv_result sensor_of(uint32_t type, const char *json, mcv_sensor *sensor,
                                   mcv_error *error) {
    static const char *const others[] = {NULL};
    const mcv_json_path file = mcv_place_file("rig.gltf"), place = mcv_json_path_key(&file, "cam");
    json_t *object = json_loads(json, 0, NULL);
    assert_non_null(object);
    *sensor = (mcv_sensor){.type = type};
    error->text[0] = '\0';
    const mcv_param_table table = mcv_sensor_table(type);
    mcv_params_set_defaults(table, &sensor->as);
    mcv_result result = mcv_params_parse(table, object, others, &sensor->as, &place, error);
    if (result == MCV_OK) result = mcv_sensor_resolve(sensor, &place, error);
    json_decref(object);
    return result;
}

#endif
