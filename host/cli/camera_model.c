/* SPDX-License-Identifier: Apache-2.0 */
/* mcvisi camera-model: the camera model of a sensor as other programs have it, and back. */
#include "cli/client.h"
#include "cli/verbs.h"
#include "core/basics.h"

#include <libgen.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static mcv_result export_model(const mcv_command *command, mcv_error *error) {
    static const char *const without[] = {"json", NULL};
    char *options = NULL, *text = NULL;
    mcv_rig *rig = NULL;
    mcv_result result = mcv_client_options(command, without, &options, error);
    if (result == MCV_OK) result = mcv_rig_open(command->argument, &rig, error);
    if (result == MCV_OK)
        result = mcv_rig_camera_model(rig, options, command->model ? NULL : &text, error);
    if (text) mcv_print_plain(stdout, text);
    mcv_text_free(text);
    mcv_rig_free(rig);
    free(options);
    return result;
}

/* The rig of the file, or an empty one in its folder. */
static mcv_result open_rig(const char *path, mcv_rig **rig, mcv_error *error) {
    static const char empty[] = "{\"asset\": {\"version\": \"2.0\"}, \"scene\": 0, \"scenes\": []}";
    char folder[PATH_MAX];
    if (access(path, F_OK) == 0) return mcv_rig_open(path, rig, error);
    if (snprintf(folder, sizeof folder, "%s", path) >= PATH_MAX)
        return mcv_fail(error, MCV_USAGE, "the path of the rig is longer than %d bytes", PATH_MAX);
    return mcv_rig_parse(empty, strlen(empty), dirname(folder), rig, error);
}

static mcv_result import_model(const mcv_command *command, mcv_error *error) {
    static const char *const without[] = {"import", "output", NULL};
    char *options = NULL, *report = NULL;
    mcv_rig *rig = NULL;
    mcv_result result = mcv_client_options(command, without, &options, error);
    if (result == MCV_OK) result = open_rig(command->model, &rig, error);
    if (result == MCV_OK)
        result = mcv_rig_add_camera(rig, command->import, options, &report, error);
    if (result == MCV_OK) result = mcv_rig_save(rig, command->model, error);
    if (result == MCV_OK)
        result = mcv_client_print(report, command->json, error);
    else
        mcv_text_free(report);
    mcv_rig_free(rig);
    free(options);
    return result;
}

mcv_result mcv_verb_camera_model(const mcv_command *command, mcv_error *error) {
    if (command->import && command->argument)
        return mcv_fail(error, MCV_USAGE,
                        "--import takes the rig as --output: leave out %s, or give it by -o",
                        command->argument);
    if (command->import && !command->model)
        return mcv_fail(
            error, MCV_USAGE,
            "--output is missing: give the rig that gets the camera, as in -o rig.gltf");
    if (!command->import && !command->argument)
        return mcv_fail(error, MCV_USAGE, "RIG is missing: `mcvisi camera-model RIG`");
    return command->import ? import_model(command, error) : export_model(command, error);
}
