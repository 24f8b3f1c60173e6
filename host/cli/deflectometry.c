/* SPDX-License-Identifier: Apache-2.0 */
/* mcvisi deflectometry: slopes and heights of a mirroring part from fringes. */
#include "cli/client.h"
#include "cli/interrupt.h"
#include "cli/progress.h"
#include "cli/verbs.h"

mcv_result mcv_verb_deflectometry(const mcv_command *command, mcv_error *error) {
    mcv_client client = {0};
    mcv_picture *picture = NULL;
    char *report = NULL;
    mcv_progress_shown shown = {.open = false};
    mcv_result result = mcv_client_open(command, command->argument, &client, error);
    if (result == MCV_OK)
        result = mcv_session_deflectometry(client.session, client.rig, client.options,
                                           mcv_progress_show, &shown, &picture, &report, error);
    if (shown.open) mcv_progress_end(&shown.line);
    if (result == MCV_OK) result = mcv_client_print(report, command->json, error);
    mcv_picture_free(picture);
    mcv_client_close(&client);
    return result == MCV_INTERRUPTED ? mcv_interrupt_result() : result;
}
