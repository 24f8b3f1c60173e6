/* SPDX-License-Identifier: Apache-2.0 */
/* What `mcvisi defect` does. */
#ifndef MCVISI_HOST_VERBS_DEFECT_H
#define MCVISI_HOST_VERBS_DEFECT_H

#include "options/command.h"
#include "scene/scene.h"
#include "verbs/report.h"

/* Adds the defect of the options to the tree of a document; *name: its name there, to be freed. */
mcv_result mcv_defect_add(const mcv_command *command, json_t *root, char **name, mcv_error *error);

/* Tells of the scene's last defect, and what is odd about it. */
mcv_result mcv_defect_report(const mcv_scene *scene, mcv_report *report, mcv_error *error);

#endif
