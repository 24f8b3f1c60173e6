/* SPDX-License-Identifier: Apache-2.0 */
/* mcvisi explain: which light makes a pixel. */
#include "cli/client.h"
#include "cli/verbs.h"

mcv_result mcv_verb_explain(const mcv_command *command, mcv_error *error) {
    mcv_client client = {0};
    char *report = NULL;
    mcv_result result = mcv_client_open(command, command->argument, &client, error);
    if (result == MCV_OK)
        result = mcv_session_explain(client.session, client.rig, client.options, &report, error);
    if (result == MCV_OK) result = mcv_client_print(report, command->json, error);
    mcv_client_close(&client);
    return result;
}
