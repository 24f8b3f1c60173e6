/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The figure `bound` of an experiment: how well any method can know a parameter of the scene from
 * one exposure (analysis/detect.h). Each set is rendered once more with the parameter larger by a
 * step and with the same random numbers.
 */
#ifndef MCVISI_HOST_EXPERIMENT_BOUND_H
#define MCVISI_HOST_EXPERIMENT_BOUND_H

#include "analysis/light_pairs.h"
#include "experiment/plan.h"
#include "loader/overrides.h"

typedef struct mcv_bound {
    const char *item; /* "PATH=STEP", borrowed; NULL: no bound is wanted */
    int path_length;
    double step;      /* [SI] */
    const char *unit; /* of that: "m", "rad", or "" where the item gives none */
    double from;      /* the parameter in the scene; NaN: the plan has it */
    size_t parameter; /* of the plan */
} mcv_bound;

/* Reads the item and finds the parameter in the scene. MCV_USAGE, or MCV_BAD_INPUT where the scene
 * has no such number. */
mcv_result mcv_bound_read(const char *item, const mcv_plan *plan, const mcv_document *document,
                          mcv_overrides set, mcv_bound *bound, mcv_error *error);

/* The override of the second render of a set with these parameters. */
void mcv_bound_override(const mcv_bound *bound, const double *numbers, char text[512]);

/* The pairs of both films of a sensor, the first as the set is. Freed by mcv_light_pairs_free,
 * after failure as well. MCV_BAD_INPUT where the films do not fit. */
mcv_result mcv_bound_pairs(const mcv_camera_settings *settings, const mcv_scene *scene,
                           uint32_t sensor, const mcv_film *film, const mcv_film *stepped,
                           mcv_light_pairs *pairs, mcv_error *error);

#endif
