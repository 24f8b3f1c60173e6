/* SPDX-License-Identifier: Apache-2.0 */
/* What `mcvisi new` does before it writes. */
#ifndef MCVISI_HOST_VERBS_NEW_H
#define MCVISI_HOST_VERBS_NEW_H

#include "options/command.h"
#include "rig/rig.h"
#include "verbs/report.h"

/* The rig that the options ask for. Texts are the command's. */
mcv_result mcv_new_design(const mcv_command *command, mcv_rig_design *rig, mcv_error *error);

/* Warns where the part does not fit into the view, or its unit is likely another one. */
void mcv_new_warn(const mcv_rig_design *rig, mcv_report *report);

/* Tells what was chosen; people read the file first, or the kind where `path` is NULL. */
void mcv_new_report(const mcv_rig_design *rig, const char *path, mcv_report *report);

#endif
