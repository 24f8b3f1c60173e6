/* SPDX-License-Identifier: Apache-2.0 */
/* mcvisi detect: how well a camera can tell a defect from its noise. */
#include "cli/client.h"
#include "cli/verbs.h"

#include <stdlib.h>

mcv_result mcv_verb_detect(const mcv_command *command, mcv_error *error) {
    mcv_picture *with = NULL, *without = NULL;
    char *options = NULL, *report = NULL;
    mcv_result result = mcv_client_options(command, NULL, &options, error);
    if (result == MCV_OK) result = mcv_picture_read(command->argument, &with, error);
    if (result == MCV_OK) result = mcv_picture_read(command->second, &without, error);
    if (result == MCV_OK) result = mcv_picture_detect(with, without, options, NULL, &report, error);
    if (result == MCV_OK) result = mcv_client_print(report, command->json, error);
    mcv_picture_free(with);
    mcv_picture_free(without);
    free(options);
    return result;
}
