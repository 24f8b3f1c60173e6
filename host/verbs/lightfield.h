/* SPDX-License-Identifier: Apache-2.0 */
/* What `mcvisi lightfield` makes. */
#ifndef MCVISI_HOST_VERBS_LIGHTFIELD_H
#define MCVISI_HOST_VERBS_LIGHTFIELD_H

#include "analysis/lightfield_file.h"
#include "options/command.h"

/* The words of --form. */
extern const char *const mcv_emd_forms[2];

/* Views and gradient with the attributes of what they were made from that still hold. */
mcv_result mcv_views_make(const mcv_light_field_file *file, mcv_exr *views, mcv_error *error);
mcv_result mcv_gradient_make(const mcv_command *command, const mcv_light_field_file *file,
                             mcv_exr *gradient, mcv_error *error);

#endif
