/* SPDX-License-Identifier: Apache-2.0 */
/* mcvisi measure: a client of the public header. */
#include "cli/client.h"
#include "cli/verbs.h"

#include <stdlib.h>

static mcv_result measure(const mcv_command *command, const mcv_picture *picture,
                          const mcv_picture *minus, mcv_error *error) {
    static const char *const without[] = {"minus", "scene", NULL};
    char *options, *report = NULL;
    mcv_rig *rig = NULL;
    mcv_result result = mcv_client_options(command, without, &options, error);
    if (result == MCV_OK && command->scene) result = mcv_rig_open(command->scene, &rig, error);
    if (result == MCV_OK)
        result = mcv_picture_measure(picture, minus, rig, options, &report, error);
    if (result == MCV_OK) result = mcv_client_print(report, command->json, error);
    mcv_rig_free(rig);
    free(options);
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
