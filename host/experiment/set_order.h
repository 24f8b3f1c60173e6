/* SPDX-License-Identifier: Apache-2.0 */
/* The order of sets in which those of one scene follow each other, so that it is rendered once. */
#ifndef MCVISI_HOST_EXPERIMENT_SET_ORDER_H
#define MCVISI_HOST_EXPERIMENT_SET_ORDER_H

#include "experiment/experiment.h"

typedef struct mcv_set_place {
    uint64_t scene; /* mcv_judge_scene */
    size_t first;   /* set of this scene */
    size_t set;
} mcv_set_place;

/* All sets; scenes come in the order of their first sets. The caller frees *order. */
mcv_result mcv_set_order(const mcv_sweep *sweep, mcv_set_place **order, mcv_error *error);

/* Gives each set a seed by its scene, for noise of its own: sets of one scene have the same. */
mcv_result mcv_set_seeds(mcv_sweep *sweep, mcv_error *error);

#endif
