/* SPDX-License-Identifier: Apache-2.0 */
/* What a sensor of type laserTriangulation says of its scans, as options of scan. */
#include "verbs/scan.h"

#include "core/json.h"
#include "scene/params.h"

#include <ctype.h>
#include <limits.h>
#include <stdio.h>
#include <string.h>

/* The option of a key: filterWidth is filter-width. */
static void name_option(const char *key, char name[64]) {
    size_t length = 0;
    for (; *key && length + 3 < 64; ++key) {
        if (isupper((unsigned char)*key)) name[length++] = '-';
        name[length++] = (char)tolower((unsigned char)*key);
    }
    name[length] = '\0';
}

/* A file is relative to the scene's folder. */
static json_t *file_json(const char *file, const char *scene) {
    const char *slash = strrchr(scene, '/');
    return *file == '/' || !slash ? json_string(file)
                                  : json_sprintf("%.*s/%s", (int)(slash - scene), scene, file);
}

/* The value of a parameter; NULL where it is not given. */
static json_t *option_json(const mcv_param *p, const mcv_sensor *sensor, const char *scene) {
    const void *field = (const char *)&sensor->as + p->offset;
    if (mcv_param_unset(p, &sensor->as)) return NULL;
    switch (p->kind) {
    case MCV_PARAM_text:
        return strcmp(p->key, "calibration") == 0 ? file_json(field, scene) : json_string(field);
    case MCV_PARAM_integer:
        return json_integer(*(const uint32_t *)field);
    case MCV_PARAM_choice:
        return json_string(mcv_param_options(p->key)[*(const int *)field]);
    default:
        return json_real(*(const double *)field);
    }
}

/* Is the exposure told by the command? Then the head's does not count. */
static bool is_exposed(const mcv_command *given) {
    return given->exposure_time > 0 || given->expose_to > 0 || given->electrons_per_unit[0] > 0;
}

json_t *mcv_scan_head(const mcv_sensor *sensor, const char *scene, const mcv_command *given,
                      const json_t *defaults) {
    const mcv_param_table table = mcv_sensor_table(MCV_SENSOR_LASER_TRIANGULATION);
    const size_t lens = mcv_sensor_table(MCV_SENSOR_THIN_LENS).count;
    json_t *options = json_object();
    for (size_t i = 0; i < table.count; ++i) {
        const mcv_param *p = table.params + i;
        const bool exposure =
            strcmp(p->key, "exposureTime") == 0 || strcmp(p->key, "exposeTo") == 0;
        char name[64];
        if ((i < lens && !exposure) || (exposure && is_exposed(given))) continue;
        json_t *value = option_json(p, sensor, scene);
        name_option(p->key, name);
        if (value) mcv_json_put(&options, name, value);
    }
    if (options && defaults && json_object_update(options, (json_t *)defaults) != 0) {
        json_decref(options);
        return NULL;
    }
    return options;
}
