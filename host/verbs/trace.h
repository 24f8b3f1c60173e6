/* SPDX-License-Identifier: Apache-2.0 */
/* What `mcvisi trace` does. */
#ifndef MCVISI_HOST_VERBS_TRACE_H
#define MCVISI_HOST_VERBS_TRACE_H

#include "options/command.h"
#include "render/render.h"

/* The table of all vertices, a row each, as CSV; the caller frees the text. */
mcv_result mcv_trace_table(const mcv_command *command, const mcv_scene *scene,
                           const mcv_trace_ray *rays, size_t ray_count, char **text, size_t *size,
                           mcv_error *error);

#endif
