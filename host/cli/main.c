/* SPDX-License-Identifier: Apache-2.0 */
/* The program: one verb per file beside this one. */
#include "cli/interrupt.h"
#include "cli/tell.h"
#include "cli/verbs.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>

mcv_result mcv_verb_help(const mcv_command *command, mcv_error *error) {
    unsigned verb;
    if (!command->argument) {
        mcv_help_print();
        return MCV_OK;
    }
    MCV_TRY(mcv_verb_find(command->argument, &verb, error));
    if (command->json) return mcv_help_print_schema(verb, error);
    mcv_help_print_verb(verb);
    return MCV_OK;
}

static mcv_result run(int argc, char **argv, mcv_error *error) {
    static mcv_result (*const verbs[])(const mcv_command *, mcv_error *) = {
#define MCV_X(verb, VERB, name, argument, doc) mcv_verb_##verb,
        MCV_VERBS(MCV_X)
#undef MCV_X
    };
    if (argc > 1 && strcmp(argv[1], "--version") == 0) {
        printf("mcvisi %s\n", mcv_version());
        return MCV_OK;
    }
    if (argc > 1 && (strcmp(argv[1], "--help") == 0 || strcmp(argv[1], "-h") == 0)) {
        mcv_help_print();
        return MCV_OK;
    }
    mcv_command command;
    mcv_result result = mcv_command_parse(argc, argv, &command, error);
    if (result == MCV_OK && command.help)
        mcv_help_print_verb(command.verb);
    else if (result == MCV_OK)
        result = verbs[command.verb](&command, error);
    mcv_command_free(&command);
    return result;
}

int main(int argc, char **argv) {
    mcv_error error = {""};
    mcv_interrupt_prepare();
    mcv_result result = run(argc, argv, &error);
    if (fflush(stdout) != 0 && result == MCV_OK)
        result = mcv_fail(&error, MCV_FAILED, "standard output: %s", strerror(errno));
    const int code = mcv_interrupt_code(result, &error);
    if (error.text[0]) mcv_tell(NULL, error.text);
    return code;
}
