/* SPDX-License-Identifier: Apache-2.0 */
/* mcvisi check. */
#include "cli/tell.h"
#include "cli/verbs.h"
#include "loader/load.h"
#include "render/render.h"
#include "verbs/check.h"

#include <stdio.h>

enum {
    DEFINES_SLICE = 512
}; /* of the tile schedule, as the renderer chooses it where paths split */

static void print_defines(uint32_t features, uint32_t channels, uint32_t sensor_type) {
    char options[1024];
    mcv_feature_defines(features, channels, sensor_type, MCV_SAMPLER_SOBOL, DEFINES_SLICE, options,
                        sizeof options);
    puts(options);
}

static mcv_result print_scene_defines(const mcv_command *command, const mcv_scene *scene,
                                      mcv_error *error) {
    mcv_checked checked;
    MCV_TRY(mcv_check_pack(command, scene, &checked, error));
    print_defines(checked.packed.features, checked.packed.channels,
                  scene->sensors[checked.sensor].type);
    mcv_packed_free(&checked.packed);
    return MCV_OK;
}

static mcv_result print_report(const mcv_command *command, const mcv_scene *scene,
                               mcv_error *error) {
    mcv_report report;
    mcv_report_begin(&report, command->json, mcv_tell);
    const mcv_result result = mcv_check(command, scene, &report, error);
    if (result == MCV_OK) return mcv_report_end(&report, error);
    mcv_report_free(&report);
    return result;
}

mcv_result mcv_verb_check(const mcv_command *command, mcv_error *error) {
    mcv_scene *scene;
    if (!command->argument) {
        if (!command->defines)
            return mcv_fail(error, MCV_USAGE, "SCENE is missing: `mcvisi check SCENE`");
        for (uint32_t type = 0; type < MCV_SENSOR_COUNT; ++type) {
            const bool disk = type == MCV_SENSOR_THIN_LENS ||
                              type == MCV_SENSOR_TELECENTRIC; /* only in a disk a pixel aims */
            const uint32_t all = (1u << MCV_FEATURE_COUNT) - 1;
            print_defines(disk ? all : all & ~(1u << MCV_FEATURE_AIM), 3, type);
        }
        return MCV_OK;
    }
    MCV_TRY(mcv_scene_load(command->argument,
                           (mcv_overrides){command->set.items, command->set.count}, &scene, error));
    const mcv_result result = command->defines ? print_scene_defines(command, scene, error)
                                               : print_report(command, scene, error);
    mcv_scene_free(scene);
    return result;
}
