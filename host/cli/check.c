/* SPDX-License-Identifier: Apache-2.0 */
/* mcvisi check. */
#include "cli/client.h"
#include "cli/verbs.h"
#include "loader/load.h"
#include "render/render.h"
#include "verbs/check.h"

#include <stdio.h>
#include <stdlib.h>

enum {
    DEFINES_SLICE = 512
}; /* of the tile schedule, with the renderer's choice for paths that split */

static void print_defines(uint32_t features, uint32_t channels, uint32_t sensor_type) {
    char options[1024];
    mcv_feature_defines(features, channels, sensor_type, MCV_SAMPLER_SOBOL, DEFINES_SLICE, options,
                        sizeof options);
    puts(options);
}

static mcv_result print_scene_defines(const mcv_command *command, mcv_error *error) {
    mcv_scene *scene;
    mcv_checked checked;
    MCV_TRY(mcv_scene_load(command->argument,
                           (mcv_overrides){command->set.items, command->set.count}, &scene, error));
    const mcv_result result = mcv_check_pack(command, scene, &checked, error);
    if (result == MCV_OK) {
        print_defines(checked.packed.features, checked.packed.channels,
                      scene->sensors[checked.sensor].type);
        mcv_packed_free(&checked.packed);
    }
    mcv_scene_free(scene);
    return result;
}

/* By the public header. */
static mcv_result print_report(const mcv_command *command, mcv_error *error) {
    char *options, *report = NULL;
    mcv_session *session = NULL;
    mcv_rig *rig = NULL;
    mcv_result result = mcv_client_options(command, (const char *const[]){NULL}, &options, error);
    if (result == MCV_OK) result = mcv_session_open(NULL, &session, error);
    if (result == MCV_OK) result = mcv_rig_open(command->argument, &rig, error);
    if (result == MCV_OK) result = mcv_session_check(session, rig, options, &report, error);
    if (result == MCV_OK) result = mcv_client_print(report, command->json, error);
    mcv_rig_free(rig);
    mcv_session_close(session);
    free(options);
    return result;
}

mcv_result mcv_verb_check(const mcv_command *command, mcv_error *error) {
    if (!command->argument) {
        if (!command->defines)
            return mcv_fail(error, MCV_USAGE, "SCENE is missing: `mcvisi check SCENE`");
        for (uint32_t type = 0; type < MCV_SENSOR_COUNT; ++type) {
            const bool disk =
                type == MCV_SENSOR_THIN_LENS ||
                type == MCV_SENSOR_TELECENTRIC; /* pupil guiding needs a round pupil */
            const uint32_t all = MCV_ALL_FEATURES;
            print_defines(disk ? all : all & ~(1u << MCV_FEATURE_AIM), 3, type);
        }
        return MCV_OK;
    }
    return command->defines ? print_scene_defines(command, error) : print_report(command, error);
}
