/* SPDX-License-Identifier: Apache-2.0 */
/* What `mcvisi inverse-pattern` makes by its options, and tells. */
#ifndef MCVISI_HOST_VERBS_INVERSE_H
#define MCVISI_HOST_VERBS_INVERSE_H

#include "io/exr.h"
#include "options/command.h"
#include "transport/inverse.h"
#include "verbs/report.h"

/* Refuses files that cannot be written and images of matrices that are not given. */
mcv_result mcv_inverse_plan(const mcv_command *command, mcv_error *error);

/* The options as mcv_inverse_pattern takes them. MCV_USAGE for an emitter without pixels. */
mcv_result mcv_inverse_read(const mcv_command *command, const mcv_matrix *matrix,
                            mcv_inverse *inverse, mcv_error *error);

/* The pattern and its error as a picture, which scenes take. */
mcv_result mcv_inverse_make(const mcv_matrix *matrix, const mcv_inverse *inverse, mcv_exr *exr,
                            mcv_error *error);

/* The pattern for a matrix: as the picture says, all other emitters dark; the caller frees it.
 * MCV_BAD_INPUT for a matrix whose emitter has another name or size. */
mcv_result mcv_inverse_shown(const mcv_inverse *inverse, const mcv_exr *picture,
                             const mcv_matrix *matrix, const char *path, float **pattern,
                             mcv_error *error);

/* Tells of the pattern: how much of the emitter shines, its error, its rounding. */
void mcv_inverse_report(const mcv_inverse *inverse, const mcv_exr *picture, mcv_report *report);

#endif
