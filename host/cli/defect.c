/* SPDX-License-Identifier: Apache-2.0 */
/* mcvisi defect: a rig with a defect on the surface of a node. */
#include "cli/client.h"
#include "cli/verbs.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* --output, or the rig's name with the type: RIG-dent.gltf. The caller frees it. */
static mcv_result output_name(const mcv_command *command, char **name, mcv_error *error) {
    char *ending = NULL;
    const char *dot = strrchr(command->argument, '.');
    *name = NULL;
    if (command->marred) {
        *name = strdup(command->marred);
        return *name ? MCV_OK : mcv_fail(error, MCV_FAILED, "no memory for the rig's name");
    }
    const char *glb = dot && strcmp(dot, ".glb") == 0 ? "glb" : "gltf";
    if (asprintf(&ending, "-%s.%s", command->second, glb) < 0) ending = NULL;
    const mcv_result result = mcv_client_name(command->argument, ending, name, error);
    free(ending);
    return result;
}

mcv_result mcv_verb_defect(const mcv_command *command, mcv_error *error) {
    static const char *const without[] = {"output", NULL};
    char *options = NULL, *report = NULL, *name = NULL;
    mcv_rig *rig = NULL;
    mcv_result result = mcv_client_options(command, without, &options, error);
    if (result == MCV_OK) result = output_name(command, &name, error);
    if (result == MCV_OK) result = mcv_rig_open(command->argument, &rig, error);
    if (result == MCV_OK)
        result = mcv_rig_add_defect(rig, command->second, options, &report, error);
    if (result == MCV_OK) result = mcv_rig_save(rig, name, error);
    if (result == MCV_OK)
        result = mcv_client_print(report, command->json, error);
    else
        mcv_text_free(report);
    mcv_rig_free(rig);
    free(options);
    free(name);
    return result;
}
