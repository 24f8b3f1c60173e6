/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Metrics that programs of the user decide: "NAME:=exec(WORDS)" and "NAME:=worker(WORDS)"
 * (experiment/program.h). For each exposure of a set a program gets a line
 *
 *     {"image": "/tmp/…/image-0.tif", "set": 3, "exposure": 0, "parameters": {"depth": 1e-05, …},
 *      "bits": 8, "camera_model": {…}}
 *
 * and answers {"NAME": number, …}; true and false are 1 and 0. Metrics with the same words are one
 * program, asked once. Parameters whose path begins with process/ are for programs alone: sets that
 * differ in nothing else have the same exposures, and are rendered once.
 */
#ifndef MCVISI_HOST_EXPERIMENT_JUDGE_H
#define MCVISI_HOST_EXPERIMENT_JUDGE_H

#include "experiment/program.h"
#include "film/film.h"
#include "scene/scene.h"

typedef struct mcv_judge mcv_judge;
struct mcv_sweep;
struct mcv_parameter;

/* *judge is NULL where no metric is a program's. MCV_USAGE names the metric that is wrong: programs
 * are not allowed, there is no camera. The sweep must outlive it. */
mcv_result mcv_judge_new(const struct mcv_sweep *sweep, mcv_judge **judge, mcv_error *error);
void mcv_judge_free(mcv_judge *judge);

/* Is the parameter for programs alone? */
bool mcv_judge_has(const struct mcv_parameter *parameter);

/* A hash of a set's parameters but those for programs. */
uint64_t mcv_judge_scene(const struct mcv_sweep *sweep, const double *numbers);

/* The row of the last set, if its scene was the same: what needs no second render. */
const double *mcv_judge_known(const mcv_judge *judge, uint64_t scene);

/* Makes the exposures of a scene; `row` is kept for mcv_judge_known. */
mcv_result mcv_judge_expose(mcv_judge *judge, uint64_t scene, const mcv_scene *of, uint32_t sensor,
                            const mcv_film *film, const double *row, mcv_error *error);

/* Asks the programs about the exposures; fills in their metrics in the row: the mean over the
 * exposures, and its standard uncertainty. */
mcv_result mcv_judge_decide(mcv_judge *judge, size_t set, double *row, mcv_error *error);

#endif
