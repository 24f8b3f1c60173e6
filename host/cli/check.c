/* SPDX-License-Identifier: Apache-2.0 */
/* mcvisi check: how a scene was understood. */
#include "cli/client.h"
#include "cli/verbs.h"

#include <stdio.h>

static mcv_result print_report(const mcv_command *command, char *report, mcv_error *error) {
    if (!command->defines) return mcv_client_print(report, command->json, error);
    fputs(report, stdout);
    mcv_text_free(report);
    return MCV_OK;
}

mcv_result mcv_verb_check(const mcv_command *command, mcv_error *error) {
    char *report = NULL;
    mcv_client client;
    if (!command->argument && !command->defines)
        return mcv_fail(error, MCV_USAGE, "SCENE is missing: `mcvisi check SCENE`");
    mcv_result result = mcv_client_open(command, command->argument, &client, error);
    if (result == MCV_OK)
        result = mcv_session_check(client.session, client.rig, client.options, &report, error);
    if (result == MCV_OK) result = print_report(command, report, error);
    mcv_client_close(&client);
    return result;
}
