/* SPDX-License-Identifier: Apache-2.0 */
/* JSON schemas (draft 4) of the MCVISI_ extensions, from the same tables that read them. */
#ifndef MCVISI_HOST_SCENE_SCHEMA_H
#define MCVISI_HOST_SCENE_SCHEMA_H

#include "core/error.h"

#include <stdio.h>

/* The extensions that have a schema, ended by NULL. Their files are
 * include/mcvisi/schema/NAME.schema.json. */
extern const char *const mcv_schema_names[];

/* Writes the schema of one of them. */
mcv_result mcv_schema_write(FILE *stream, const char *name, mcv_error *error);

#endif
