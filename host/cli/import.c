/* SPDX-License-Identifier: Apache-2.0 */
/* mcvisi import: a lens file of a design program to a glTF file with exact surfaces, for a scene to place. */
#include "cli/options.h"
#include "output/file.h"
#include "scene/lens_file.h"

#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

mcv_result mcv_verb_import(const mcv_command *command, mcv_error *error) {
    const char *from = command->argument, *dot = strrchr(from, '.');
    char path[PATH_MAX];
    json_t *scene;
    const int stem = dot ? (int)(dot - from) : (int)strlen(from);
    const int length =
        command->lens ? snprintf(path, sizeof path, "%s", command->lens) : snprintf(path, sizeof path, "%.*s.gltf", stem, from);
    if (length >= PATH_MAX) return mcv_fail(error, MCV_USAGE, "the path of the lens is longer than %d bytes", PATH_MAX);
    if (mcv_same_file(path, from)) return mcv_fail(error, MCV_USAGE, "%s is the lens file: give the lens another name", path);
    MCV_TRY(mcv_lens_file_read(from, command->index.items, command->index.count, &scene, error));
    char *text = json_dumps(scene, JSON_INDENT(1) | JSON_REAL_PRECISION(12));
    json_decref(scene);
    if (!text) return mcv_fail(error, MCV_FAILED, "%s: no memory to write it", path);
    const mcv_result result = mcv_output_whole(path, text, strlen(text), error);
    free(text);
    if (result == MCV_OK) printf("%s\n", path);
    return result;
}
