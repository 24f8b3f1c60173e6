/* SPDX-License-Identifier: Apache-2.0 */
/* mcvisi measure. */
#include "cli/tell.h"
#include "cli/verbs.h"
#include "loader/load.h"
#include "verbs/measure.h"

#include <stdlib.h>

static mcv_result measure(const mcv_command *command, const mcv_picture *picture,
                          const mcv_picture *minus, mcv_error *error) {
    mcv_scene *scene = NULL;
    mcv_report report;
    if (command->scene)
        MCV_TRY(mcv_scene_load(command->scene,
                               (mcv_overrides){command->set.items, command->set.count}, &scene,
                               error));
    mcv_report_begin(&report, command->json, mcv_tell);
    const mcv_result result = mcv_measure(command, picture, minus, scene, &report, error);
    mcv_scene_free(scene);
    if (result == MCV_OK) return mcv_report_end(&report, error);
    mcv_report_free(&report);
    return result;
}

mcv_result mcv_verb_measure(const mcv_command *command, mcv_error *error) {
    mcv_picture *picture = NULL, *minus = NULL;
    mcv_result result = mcv_picture_read(command->argument, &picture, error);
    if (result == MCV_OK && command->minus)
        result = mcv_picture_read(command->minus, &minus, error);
    if (result == MCV_OK) result = measure(command, picture, minus, error);
    mcv_picture_free(picture);
    mcv_picture_free(minus);
    return result;
}
