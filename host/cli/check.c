/* SPDX-License-Identifier: Apache-2.0 */
/* mcvisi check: how a scene was understood. */
#include "cli/client.h"
#include "cli/verbs.h"
#include "core/basics.h"

#include <stdio.h>
#include <stdlib.h>

static mcv_result print_report(const mcv_command *command, char *report, mcv_error *error) {
    if (!command->defines) return mcv_client_print(report, command->json, error);
    mcv_print_plain(stdout, report);
    mcv_text_free(report);
    return MCV_OK;
}

/* A line for each finding, or the JSON. MCV_BAD_INPUT if there are any. */
static mcv_result print_strict(const mcv_command *command, char *report, mcv_error *error) {
    json_t *document = json_loads(report, 0, NULL);
    if (!document) {
        mcv_text_free(report);
        return mcv_fail(error, MCV_FAILED, "no memory for the report");
    }
    const json_t *list = json_object_get(document, "strict"), *finding;
    const size_t count = json_array_size(list);
    mcv_result result = MCV_OK;
    size_t i;
    json_array_foreach(list, i, finding) {
        char *line = NULL;
        if (!command->json &&
            asprintf(&line, "%s %s: %s", json_string_value(json_object_get(finding, "code")),
                     json_string_value(json_object_get(finding, "path")),
                     json_string_value(json_object_get(finding, "text"))) >= 0)
            mcv_client_line(line);
        free(line);
    }
    if (count == 0 && !command->json) mcv_client_line("no findings");
    json_decref(document);
    if (command->json)
        result = mcv_client_print(report, true, error);
    else
        mcv_text_free(report);
    if (count == 0 || result != MCV_OK) return result;
    return mcv_fail(error, MCV_BAD_INPUT, "%s: the file has %zu findings", command->argument,
                    count);
}

mcv_result mcv_verb_check(const mcv_command *command, mcv_error *error) {
    char *report = NULL;
    mcv_client client;
    if (!command->argument && !command->defines)
        return mcv_fail(error, MCV_USAGE, "SCENE is missing: `mcvisi check SCENE`");
    if (command->strict && !command->argument)
        return mcv_fail(error, MCV_USAGE, "SCENE is missing: `mcvisi check --strict SCENE`");
    mcv_command asked = *command;
    asked.json = command->json || command->strict;
    mcv_result result = mcv_client_open(&asked, command->argument, &client, error);
    if (result == MCV_OK)
        result = mcv_session_check(client.session, client.rig, client.options, &report, error);
    if (result == MCV_OK)
        result = (command->strict ? print_strict : print_report)(command, report, error);
    mcv_client_close(&client);
    return result;
}
