/* SPDX-License-Identifier: Apache-2.0 */
/* The report of mcvisi check about each element (cli/check.c); only check.c calls these. */
#ifndef MCVISI_HOST_VERBS_CHECK_REPORT_H
#define MCVISI_HOST_VERBS_CHECK_REPORT_H

#include "check/findings.h"
#include "verbs/report.h"

/* check_optics.c: also adds findings about emitters that fill little of its pupil. */
mcv_result mcv_check_report_sensor(mcv_report *report, const mcv_scene *scene, uint32_t index,
                                   mcv_findings *findings, mcv_error *error);

/* check_elements.c */

/* All parameters of an element, derived ones included. */
void mcv_check_report_parameters(mcv_report *report, mcv_param_table table, const void *params);
void mcv_check_report_place(mcv_report *report, const mcv_transform *to_world);
void mcv_check_report_emitter(mcv_report *report, const mcv_scene *scene, uint32_t index);
void mcv_check_report_material(mcv_report *report, const mcv_scene *scene, uint32_t index);

#endif
