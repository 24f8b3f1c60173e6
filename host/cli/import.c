/* SPDX-License-Identifier: Apache-2.0 */
/* mcvisi import: a lens file of a design program to a glTF file with exact surfaces, for a scene to place. */
#include "cli/options.h"
#include "output/file.h"
#include "scene/lens_file.h"

#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static mcv_result write_text(const char *path, const char *text, mcv_error *error) {
    mcv_output output;
    MCV_TRY(mcv_output_open(&output, path, error));
    const mcv_result result = mcv_output_write(&output, text, strlen(text), error);
    if (result == MCV_OK) return mcv_output_commit(&output, error);
    mcv_output_discard(&output);
    return result;
}

mcv_result mcv_verb_import(const mcv_command *command, mcv_error *error) {
    const char *from = command->argument, *dot = strrchr(from, '.');
    char path[PATH_MAX];
    json_t *scene;
    const int length = dot ? (int)(dot - from) : (int)strlen(from);
    if (command->lens)
        snprintf(path, sizeof path, "%s", command->lens);
    else
        snprintf(path, sizeof path, "%.*s.gltf", length, from);
    MCV_TRY(mcv_lens_file_read(from, command->index.items, command->index.count, &scene, error));
    char *text = json_dumps(scene, JSON_INDENT(1) | JSON_REAL_PRECISION(12));
    json_decref(scene);
    if (!text) return mcv_fail(error, MCV_FAILED, "%s: no memory to write it", path);
    const mcv_result result = write_text(path, text, error);
    free(text);
    if (result == MCV_OK) printf("%s\n", path);
    return result;
}
