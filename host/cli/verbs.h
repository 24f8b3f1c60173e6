/* SPDX-License-Identifier: Apache-2.0 */
/* The verbs, one file each, and how they are explained. */
#ifndef MCVISI_HOST_CLI_VERBS_H
#define MCVISI_HOST_CLI_VERBS_H

#include "options/command.h"

/* Prints all verbs, or one and its options. */
void mcv_help_print(void);
void mcv_help_print_verb(unsigned verb);

/* Prints the schema of a verb's options. */
mcv_result mcv_help_print_schema(unsigned verb, mcv_error *error);

/* The verbs. Results go to standard output, warnings and progress to standard error. */
#define MCV_X(verb, VERB, name, argument, doc) \
    mcv_result mcv_verb_##verb(const mcv_command *command, mcv_error *error);
MCV_VERBS(MCV_X)
#undef MCV_X

#endif
