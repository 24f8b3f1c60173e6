/* SPDX-License-Identifier: Apache-2.0 */
/* mcvisi new: a rig around a part, with standard optics and a light, as a file to read and edit. */
#include "cli/client.h"
#include "cli/verbs.h"

#include <stdlib.h>

mcv_result mcv_verb_new(const mcv_command *command, mcv_error *error) {
    mcv_command named = *command;
    mcv_rig *rig = NULL;
    char *name = NULL, *ending = NULL, *options = NULL, *report = NULL;
    mcv_result result = MCV_OK;
    if (!command->rig) {
        if (asprintf(&ending, "-%s.gltf", command->argument) < 0) ending = NULL;
        result = mcv_client_name(command->second, ending, &name, error);
        free(ending);
        named.rig = name;
    }
    if (result == MCV_OK) result = mcv_client_options(&named, NULL, &options, error);
    if (result == MCV_OK)
        result = mcv_rig_new(command->argument, command->second, options, &rig, &report, error);
    if (result == MCV_OK) result = mcv_client_print(report, command->json, error);
    mcv_rig_free(rig);
    free(options);
    free(name);
    return result;
}
