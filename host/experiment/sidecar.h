/* SPDX-License-Identifier: Apache-2.0 */
/* The experiment as JSON beside its table. It can be run again, and it decides whether the table
 * can be resumed. */
#ifndef MCVISI_HOST_EXPERIMENT_SIDECAR_H
#define MCVISI_HOST_EXPERIMENT_SIDECAR_H

#include "core/error.h"

#include <jansson.h>

/* All pointers are borrowed. */
typedef struct mcv_sidecar {
    const char *path, *table; /* its own and the table's */
    const char
        *rig; /* the scene; written as a relative path if it lies in or below the table's folder */
    const char *fingerprint; /* of the scene and the files that it names */
    json_t *settings;        /* an object whose members are written too; NULL: none */
} mcv_sidecar;

/* Is there no file at `path`, or one that was written beside a table? Another one is MCV_BAD_INPUT:
 * it is a file of the user, of which only the table's name was given. */
mcv_result mcv_sidecar_is_free(const char *path, mcv_error *error);

/* Writes the file. */
mcv_result mcv_sidecar_write(const mcv_sidecar *sidecar, mcv_error *error);

/* Does the existing file have the same scene and settings? MCV_BAD_INPUT names the difference. */
mcv_result mcv_sidecar_check(const mcv_sidecar *sidecar, mcv_error *error);

#endif
