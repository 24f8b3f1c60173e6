/* SPDX-License-Identifier: Apache-2.0 */
#include "cli/client.h"

#include "cli/tell.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

mcv_result mcv_client_options(const mcv_command *command, const char *const *without, char **text,
                              mcv_error *error) {
    *text = NULL;
    for (int i = 2; i < command->argc; ++i) {
        json_t *valid = json_string(command->argv[i]);
        json_decref(valid);
        if (!valid && command->argv[i] != command->argument)
            return mcv_fail(error, MCV_USAGE, "%s: is no UTF-8 text", command->argv[i]);
    }
    json_t *options = mcv_command_json(command, without);
    if (options) mcv_command_flags(command, options);
    for (const char *const *name = without; options && *name; ++name)
        json_object_del(options, *name);
    *text = options ? json_dumps(options, JSON_COMPACT | JSON_REAL_PRECISION(17)) : NULL;
    json_decref(options);
    return *text ? MCV_OK : mcv_fail(error, MCV_FAILED, "no memory for the options");
}

static mcv_result print_json(const char *report, mcv_error *error) {
    json_t *document = json_loads(report, 0, NULL);
    size_t i;
    const json_t *note;
    json_array_foreach(json_object_get(document, "notes"), i, note) {
        mcv_tell(json_string_value(json_object_get(note, "severity")),
                 json_string_value(json_object_get(note, "text")));
    }
    json_object_del(document, "notes");
    const int failed = json_dumpf(document, stdout, JSON_INDENT(2) | JSON_REAL_PRECISION(17));
    json_decref(document);
    putchar('\n');
    return failed ? mcv_fail(error, MCV_FAILED, "the JSON could not be written to standard output")
                  : MCV_OK;
}

/* Notes are the first lines: "warning: SENTENCE". */
static void print_text(char *report) {
    static const char *const severities[] = {"warning", "note"};
    for (size_t i = 0; i < sizeof severities / sizeof severities[0];) {
        const size_t length = strlen(severities[i]);
        char *end = strchr(report, '\n');
        if (!end || strncmp(report, severities[i], length) != 0 ||
            strncmp(report + length, ": ", 2) != 0) {
            ++i;
            continue;
        }
        *end = '\0';
        mcv_tell(severities[i], report + length + 2);
        report = end + 1;
        i = 0;
    }
    fputs(report, stdout);
}

mcv_result mcv_client_print(char *report, bool json, mcv_error *error) {
    mcv_result result = MCV_OK;
    if (json)
        result = print_json(report, error);
    else
        print_text(report);
    mcv_text_free(report);
    return result;
}
