/* SPDX-License-Identifier: Apache-2.0 */
/* The -D options that specialise OpenCL programs, a line for each program: what --defines tells. */
#include "verbs/check.h"

#include "core/basics.h"

#include "render/render.h"
#include "scene/sensors.h"

#include <stdio.h>

enum { SLICE = 512 }; /* of the tile schedule, with the renderer's choice for paths that split */

static void print_defines(FILE *out, uint64_t features, uint32_t channels, uint32_t sensor_type) {
    char options[2048];
    mcv_feature_defines(features, channels, sensor_type, MCV_SAMPLER_SOBOL, SLICE, options,
                        sizeof options);
    fprintf(out, "%s\n", options);
}

static mcv_result print_scene(FILE *out, const mcv_command *command, const mcv_scene *scene,
                              mcv_error *error) {
    mcv_checked checked;
    MCV_TRY(mcv_check_pack(command, scene, &checked, error));
    print_defines(out, checked.packed.features, checked.packed.channels,
                  scene->sensors[checked.sensor].type);
    mcv_packed_free(&checked.packed);
    return MCV_OK;
}

/* With all features that each type of sensor can have. A scene chooses emitters by reach or by a
 * light tree. */
static void print_all(FILE *out) {
    static const uint64_t choices[] = {MCV_FEATURE_BIT(REACH), MCV_FEATURE_BIT(LIGHT_TREE)};
    for (uint32_t type = 0; type < MCV_SENSOR_COUNT; ++type) {
        const bool disk = type == MCV_SENSOR_THIN_LENS ||
                          type == MCV_SENSOR_TELECENTRIC; /* pupil guiding needs a round pupil */
        /* Light paths do not reach a scanner. */
        const uint64_t none = (disk ? 0 : MCV_FEATURE_BIT(PUPIL_GUIDE)) |
                              (type == MCV_SENSOR_FLYING_SPOT ? MCV_FEATURE_BIT(LIGHT_TRACING) : 0);
        const uint64_t all = MCV_ALL_FEATURES & ~none;
        for (int other = 0; other < 2; ++other) print_defines(out, all & ~choices[other], 3, type);
    }
}

mcv_result mcv_check_defines(const mcv_command *command, const mcv_scene *scene, char **text,
                             mcv_error *error) {
    mcv_result result = MCV_OK;
    size_t size;
    *text = NULL;
    FILE *out = open_memstream(text, &size);
    if (out && scene)
        result = print_scene(out, command, scene, error);
    else if (out)
        print_all(out);
    if (!mcv_text_close(out, text))
        result = mcv_fail(error, MCV_FAILED, "no memory for the options");
    return result;
}
