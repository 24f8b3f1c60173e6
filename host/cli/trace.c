/* SPDX-License-Identifier: Apache-2.0 */
/* mcvisi trace: all vertices of the paths of given rays, as a table. */
#include "cli/client.h"
#include "cli/verbs.h"
#include "core/basics.h"

#include <stdio.h>

mcv_result mcv_verb_trace(const mcv_command *command, mcv_error *error) {
    char *csv = NULL, *report = NULL;
    mcv_client client;
    mcv_result result = mcv_client_open(command, command->argument, &client, error);
    if (result == MCV_OK)
        result = mcv_session_trace(client.session, client.rig, NULL, 0, client.options,
                                   command->paths ? NULL : &csv, &report, error);
    if (result == MCV_OK) mcv_client_notes(report);
    if (csv) mcv_print_plain(stdout, csv);
    mcv_text_free(csv);
    mcv_text_free(report);
    mcv_client_close(&client);
    return result;
}
