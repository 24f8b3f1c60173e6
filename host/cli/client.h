/* SPDX-License-Identifier: Apache-2.0 */
/* What the verbs share as clients of the public header, mcvisi/mcvisi.h. */
#ifndef MCVISI_HOST_CLI_CLIENT_H
#define MCVISI_HOST_CLI_CLIENT_H

#include "options/command.h"

#include <limits.h>

/* The command's options as the library takes them, without those of `without` (names, NULL at the
 * end; or NULL); the caller frees the text. MCV_USAGE where one is no UTF-8 text, which JSON cannot
 * hold. */
mcv_result mcv_client_options(const mcv_command *command, const char *const *without, char **text,
                              mcv_error *error);

/* The path without the ending of its file name, with another ending: a default name. The caller
 * frees it. MCV_USAGE where it is no UTF-8 text. */
mcv_result mcv_client_name(const char *path, const char *ending, char **name, mcv_error *error);

/* The scene of an experiment's file, relative to its folder. MCV_BAD_INPUT where it has none. */
mcv_result mcv_client_rig(const json_t *document, const char *path, char rig[PATH_MAX],
                          mcv_error *error);

/* What verbs that work on a scene begin with. */
typedef struct mcv_client {
    char *options;
    mcv_session *session;
    mcv_rig *rig;
} mcv_client;

/* The command's options, a session, and the rig of a file; NULL: none. After failure, too, it is
 * closed by mcv_client_close. */
mcv_result mcv_client_open(const mcv_command *command, const char *rig, mcv_client *client,
                           mcv_error *error);
void mcv_client_close(mcv_client *client);

/* A call of the library that makes a picture of a rig and tells how far it is. */
typedef mcv_result mcv_picture_call(mcv_session *session, const mcv_rig *rig, const char *options,
                                    mcv_progress_call *progress, void *user, mcv_picture **picture,
                                    char **report, mcv_error *error);

/* Does it for a verb, shows its progress and prints its report. The picture is in its files. */
mcv_result mcv_client_picture(const mcv_command *command, mcv_picture_call *call, mcv_error *error);

/* Prints a report of the library to standard output and its notes to standard error, and frees it.
 */
mcv_result mcv_client_print(char *report, bool json, mcv_error *error);

/* Prints the notes of a report in JSON only. False where the report is nothing else. */
bool mcv_client_notes(const char *report);

/* For experiments, of which `user` is the command: prints what finishes; with --json only its
 * notes. False after an interrupt. */
bool mcv_client_told(void *user, const char *report);

/* Prints a text, JSON for example, and a line feed to standard output. */
void mcv_client_line(const char *text);

/* Prints a text for people to standard output, and the notes before it to standard error. */
void mcv_client_text(const char *text);

#endif
