/* SPDX-License-Identifier: Apache-2.0 */
/* mcvisi lightfield: sub-aperture views and the Earth Mover's gradient of a light field image. */
#include "cli/client.h"
#include "cli/verbs.h"

#include <stdlib.h>
#include <string.h>

mcv_result mcv_verb_lightfield(const mcv_command *command, mcv_error *error) {
    const bool views = strcmp(command->argument, "views") == 0;
    mcv_picture *picture = NULL, *made = NULL;
    char *options = NULL, *report = NULL;
    if (!views && strcmp(command->argument, "emd-gradient") != 0)
        return mcv_fail(error, MCV_USAGE,
                        "lightfield %s: must be `lightfield views` or `lightfield emd-gradient`",
                        command->argument);
    if (!command->processed)
        return mcv_fail(error, MCV_USAGE,
                        "--output is missing: give F.png for a picture or F.exr for the values");
    mcv_result result = mcv_client_options(command, NULL, &options, error);
    if (result == MCV_OK) result = mcv_picture_read(command->second, &picture, error);
    if (result == MCV_OK)
        result = (views ? mcv_picture_views : mcv_picture_emd_gradient)(picture, options, &made,
                                                                        &report, error);
    if (result == MCV_OK) result = mcv_client_print(report, command->json, error);
    mcv_picture_free(picture);
    mcv_picture_free(made);
    free(options);
    return result;
}
