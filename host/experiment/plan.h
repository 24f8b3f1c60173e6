/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The sets of parameters that an experiment tries: some parameters vary by a design
 * (experiment/design.h), others follow from them, and some sets are left out.
 */
#ifndef MCVISI_HOST_EXPERIMENT_PLAN_H
#define MCVISI_HOST_EXPERIMENT_PLAN_H

#include "core/basics.h"
#include "experiment/design.h"

/* What is asked for. A path is one into the scene, as in mcv_overrides; an expression is one of
 * experiment/expression.h in the parameters' names. */
typedef struct mcv_variation {
    mcv_texts vary;  /* "PATH=VALUES", values as mcv_levels_parse reads them */
    mcv_texts tie;   /* "PATH=EXPR" */
    mcv_texts where; /* "EXPR": a set for which it is 0 is left out */
    int design;      /* MCV_DESIGN_… */
    size_t points;   /* sets of MCV_DESIGN_LHS and MCV_DESIGN_SOBOL */
    uint32_t seed;   /* of their points */
} mcv_variation;

/* A parameter that varies, or follows from those before it. */
typedef struct mcv_parameter {
    char name[64];    /* the end of its path, as long as it takes to tell it from the others */
    const char *item; /* "PATH=…" as given */
    int path_length;
    mcv_levels levels;      /* empty for a tie */
    const char *expression; /* of a tie, or NULL */
} mcv_parameter;

/* The texts of the variation are not copied. */
typedef struct mcv_plan {
    mcv_texts where;
    mcv_parameter parameters[MCV_DESIGN_PARAMETERS];
    size_t varied, count;     /* parameters: first those that vary, then ties */
    double *sets;             /* [set][varied] */
    size_t set_count, wanted; /* wanted: not left out */
} mcv_plan;

/* Reads the parameters. MCV_USAGE names the text that is wrong. After failure, too, the plan is
 * freed by mcv_plan_free. */
mcv_result mcv_plan_parameters(const mcv_variation *variation, mcv_plan *plan, mcv_error *error);

/* Makes the sets of a plan whose parameters are read. MCV_USAGE where the design does not suit
 * them, or no set is left. */
mcv_result mcv_plan_sets(const mcv_variation *variation, mcv_plan *plan, mcv_error *error);

/* All parameters of a set below set_count, ties included; *wanted is false where it is left out. */
mcv_result mcv_plan_set(const mcv_plan *plan, size_t set, double *numbers, bool *wanted,
                        mcv_error *error);
void mcv_plan_free(mcv_plan *plan);

#endif
