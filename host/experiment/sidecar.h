/* SPDX-License-Identifier: Apache-2.0 */
/* The experiment as JSON beside its table: it can be run again, and tells whether a table may be
 * gone on with. */
#ifndef MCVISI_HOST_EXPERIMENT_SIDECAR_H
#define MCVISI_HOST_EXPERIMENT_SIDECAR_H

#include "core/error.h"

#include <jansson.h>

/* Nothing is owned. */
typedef struct mcv_sidecar {
    const char *path, *table; /* its own and the table's */
    const char *rig;          /* the scene; written relative to the table where it lies below */
    const char *fingerprint;  /* of the scene and the files that it names */
    json_t *settings;         /* an object whose members stand in it as well; NULL: none */
} mcv_sidecar;

/* Writes it whole. */
mcv_result mcv_sidecar_write(const mcv_sidecar *sidecar, mcv_error *error);

/* Is what stands there the same scene with the same settings? MCV_BAD_INPUT names what is not. */
mcv_result mcv_sidecar_check(const mcv_sidecar *sidecar, mcv_error *error);

#endif
