/* SPDX-License-Identifier: Apache-2.0 */
/* mcvisi camera: the grey values that a camera reads from a rendered image. */
#include "cli/client.h"
#include "cli/verbs.h"

#include <stdlib.h>

mcv_result mcv_verb_camera(const mcv_command *command, mcv_error *error) {
    mcv_picture *picture = NULL, *grey = NULL;
    char *options = NULL, *report = NULL;
    if (!command->grey)
        return mcv_fail(error, MCV_USAGE,
                        "--output is missing: give the file of the grey values, as in -o grey.png");
    mcv_result result = mcv_client_options(command, NULL, &options, error);
    if (result == MCV_OK) result = mcv_picture_read(command->argument, &picture, error);
    if (result == MCV_OK) result = mcv_picture_camera(picture, options, &grey, &report, error);
    if (result == MCV_OK) result = mcv_client_print(report, command->json, error);
    mcv_picture_free(picture);
    mcv_picture_free(grey);
    free(options);
    return result;
}
