/* SPDX-License-Identifier: Apache-2.0 */
/* What mcvisi check says of each element (cli/check.c); nothing else calls this. */
#ifndef MCVISI_HOST_VERBS_CHECK_REPORT_H
#define MCVISI_HOST_VERBS_CHECK_REPORT_H

#include "check/findings.h"
#include "verbs/report.h"

/* check_optics.c: adds findings about emitters that fill its pupil badly. */
mcv_result mcv_check_report_sensor(mcv_report *report, const mcv_scene *scene, uint32_t index,
                                   mcv_findings *findings, mcv_error *error);

/* check_elements.c */

/* All parameters of an element, as they are after everything that follows from others has been
 * derived. */
void mcv_check_report_parameters(mcv_report *report, mcv_param_table table, const void *params);
void mcv_check_report_place(mcv_report *report, const mcv_transform *to_world);
void mcv_check_report_emitter(mcv_report *report, const mcv_scene *scene, uint32_t index);
void mcv_check_report_material(mcv_report *report, const mcv_scene *scene, uint32_t index);

#endif
