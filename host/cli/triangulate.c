/* SPDX-License-Identifier: Apache-2.0 */
/* mcvisi triangulate: images of a laser line become profiles. */
#include "cli/client.h"
#include "cli/verbs.h"

#include <stdlib.h>

mcv_result mcv_verb_triangulate(const mcv_command *command, mcv_error *error) {
    char *options = NULL, *report = NULL;
    const mcv_list *images = &command->arguments;
    mcv_result result = mcv_client_options(command, NULL, &options, error);
    if (result == MCV_OK)
        result = mcv_images_triangulate(images->items, images->count, options, &report, error);
    if (result == MCV_OK) result = mcv_client_print(report, command->json, error);
    free(options);
    return result;
}
