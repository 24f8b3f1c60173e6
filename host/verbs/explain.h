/* SPDX-License-Identifier: Apache-2.0 */
/* What `mcvisi explain` does. */
#ifndef MCVISI_HOST_VERBS_EXPLAIN_H
#define MCVISI_HOST_VERBS_EXPLAIN_H

#include "options/command.h"
#include "scene/scene.h"
#include "verbs/report.h"

/* Explains the pixel of --pixel, writes the page of --html, and reports the routes. */
mcv_result mcv_explain(const mcv_command *command, const mcv_scene *scene, uint32_t sensor,
                       mcv_report *report, mcv_error *error);

#endif
