/* SPDX-License-Identifier: Apache-2.0 */
/* What verbs need that are clients of the public header. */
#ifndef MCVISI_HOST_CLI_CLIENT_H
#define MCVISI_HOST_CLI_CLIENT_H

#include "options/command.h"

/* The command's options as the library takes them, without those of `without` (names, NULL at the
 * end); the caller frees the text. MCV_USAGE where one is no UTF-8 text, which JSON cannot hold. */
mcv_result mcv_client_options(const mcv_command *command, const char *const *without, char **text,
                              mcv_error *error);

/* Prints a report of the library to standard output and its notes to standard error, and frees it.
 */
mcv_result mcv_client_print(char *report, bool json, mcv_error *error);

#endif
