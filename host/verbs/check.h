/* SPDX-License-Identifier: Apache-2.0 */
/* What `mcvisi check` does. */
#ifndef MCVISI_HOST_VERBS_CHECK_H
#define MCVISI_HOST_VERBS_CHECK_H

#include "check/findings.h"
#include "device/features.h"
#include "device/pack.h"
#include "loader/load.h"
#include "options/command.h"
#include "verbs/report.h"

/* A scene as it goes to a device, and the features that its sensor, or its last one, needs. */
typedef struct mcv_checked {
    mcv_packed packed; /* owned: mcv_packed_free */
    mcv_feature_causes causes;
    uint32_t sensor; /* the one asked for, else the first */
} mcv_checked;

mcv_result mcv_check_pack(const mcv_command *command, const mcv_scene *scene, mcv_checked *checked,
                          mcv_error *error);

/* The -D options that specialise the scene's programs; scene NULL: those with all features. The
 * caller frees the text, also after failure. */
mcv_result mcv_check_defines(const mcv_command *command, const mcv_scene *scene, char **text,
                             mcv_error *error);

/* The findings of --strict: codes, JSON pointers and sentences, a list `strict`. */
mcv_result mcv_check_strict(const mcv_command *command, const mcv_document *document,
                            mcv_report *report, mcv_error *error);

/* Tells what was understood of the scene, with the findings; draws the page of --html. */
mcv_result mcv_check(const mcv_command *command, const mcv_scene *scene, mcv_report *report,
                     mcv_error *error);

#endif
