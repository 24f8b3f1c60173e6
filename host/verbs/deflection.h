/* SPDX-License-Identifier: Apache-2.0 */
/* Files and words of `mcvisi deflection`. */
#ifndef MCVISI_HOST_VERBS_DEFLECTION_H
#define MCVISI_HOST_VERBS_DEFLECTION_H

#include "io/exr.h"
#include "options/command.h"
#include "transport/deflection.h"
#include "verbs/report.h"

/* Refuses options of files that cannot be written. */
mcv_result mcv_deflection_plan(const mcv_command *command, mcv_error *error);

/* Two pictures: the deflection with its parts, and the histograms; with the attributes of the
 * matrix that still hold. The deflection is freed, also on failure. */
mcv_result mcv_deflection_make(mcv_deflection *deflection, const mcv_matrix *matrix, mcv_exr *image,
                               mcv_exr *histogram, mcv_error *error);

/* Writes what the options name. `name`: of the matrix. */
mcv_result mcv_deflection_write(const mcv_command *command, const mcv_exr *exr,
                                const mcv_exr *histogram, const char *name, mcv_error *error);

/* Tells the mean of the deflections, the largest one, and the shares. */
void mcv_deflection_report(const mcv_exr *exr, const mcv_exr *histogram, mcv_report *report);

#endif
