/* SPDX-License-Identifier: Apache-2.0 */
/* mcvisi import: a lens file of a design program to a glTF file with exact surfaces, for a scene to
 * place. */
#include "cli/client.h"
#include "cli/verbs.h"

#include <stdlib.h>

mcv_result mcv_verb_import(const mcv_command *command, mcv_error *error) {
    mcv_command named = *command;
    mcv_rig *rig = NULL;
    char *name = NULL, *options = NULL, *report = NULL;
    mcv_result result = MCV_OK;
    if (!command->lens) {
        result = mcv_client_name(command->argument, ".gltf", &name, error);
        named.lens = name;
    }
    if (result == MCV_OK) result = mcv_client_options(&named, NULL, &options, error);
    if (result == MCV_OK) result = mcv_rig_import(command->argument, options, &rig, &report, error);
    if (result == MCV_OK) result = mcv_client_print(report, command->json, error);
    mcv_rig_free(rig);
    free(options);
    free(name);
    return result;
}
