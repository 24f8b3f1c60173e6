/* SPDX-License-Identifier: Apache-2.0 */
/* What `mcvisi import` does before it writes. */
#ifndef MCVISI_HOST_VERBS_IMPORT_H
#define MCVISI_HOST_VERBS_IMPORT_H

#include "lens/lens_file.h"
#include "options/command.h"
#include "verbs/report.h"

/* The lens of the file that is the command's argument, as the text of a glTF document that a scene
 * takes; the caller frees it. */
mcv_result mcv_import(const mcv_command *command, char **text, mcv_lens_report *lens,
                      mcv_error *error);

/* Tells of the lens; people read the file that was written first, if there is one. */
void mcv_import_report(const mcv_lens_report *lens, const char *path, mcv_report *report);

#endif
