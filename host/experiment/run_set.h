/* SPDX-License-Identifier: Apache-2.0 */
/* One set of an experiment: its scene, its render and its row. */
#ifndef MCVISI_HOST_EXPERIMENT_RUN_SET_H
#define MCVISI_HOST_EXPERIMENT_RUN_SET_H

#include "experiment/experiment.h"

/* The parameters of a set as "PATH=VALUE". */
typedef char mcv_set_texts[MCV_DESIGN_PARAMETERS][512];

/* Loads the scene with the overrides of all sets, then those of this set, which are written to
 * texts. */
mcv_result mcv_load_set(const mcv_sweep *sweep, const double *numbers, mcv_set_texts texts,
                        mcv_scene **scene, mcv_error *error);

/* The sensor of the experiment in a scene, which gets the experiment's pixels. */
mcv_result mcv_set_sensor(const mcv_experiment *experiment, mcv_scene *scene, uint32_t *sensor,
                          mcv_error *error);

/* Where --images keeps the picture of a set. */
mcv_result mcv_set_image_path(const mcv_experiment *experiment, size_t set, char path[PATH_MAX],
                              mcv_error *error);

/* MCV_OK, or the result with which the experiment's calls stop it, and a sentence that says how it
 * continues. */
mcv_result mcv_sweep_stopped(const mcv_sweep *sweep, mcv_error *error);

/* As mcv_render_options.progress: `user` is a sweep, whose calls may stop the render. */
bool mcv_sweep_goes_on(void *user, double fraction, double seconds, double error);

/*
 * Renders and measures a set. row has room for MCV_ROW_MOST numbers and contains the set's
 * parameters. Fills in the others and appends the row to the table, with a message if the set
 * fails. Fails only after an interruption, or if the table cannot be written.
 */
mcv_result mcv_run_set(mcv_sweep *sweep, size_t set, double *row, mcv_error *error);

#endif
