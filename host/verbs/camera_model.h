/* SPDX-License-Identifier: Apache-2.0 */
/* What `mcvisi camera-model` does. */
#ifndef MCVISI_HOST_VERBS_CAMERA_MODEL_H
#define MCVISI_HOST_VERBS_CAMERA_MODEL_H

#include "calibration/calibration.h"
#include "options/command.h"
#include "verbs/report.h"

/* The model of a sensor in the format of the options. */
mcv_result mcv_camera_model_export(const mcv_command *command, const mcv_scene *scene,
                                   uint32_t sensor, mcv_calibration_texts *texts, mcv_error *error);

/* Writes them into the file or COLMAP's folder of --output. */
mcv_result mcv_camera_model_save(const mcv_command *command, const mcv_calibration_texts *texts,
                                 mcv_error *error);

/* Adds the camera of the file --import to a document, and tells of it. */
mcv_result mcv_camera_model_import(const mcv_command *command, json_t *document, mcv_report *report,
                                   mcv_error *error);

#endif
