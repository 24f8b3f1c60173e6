/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The sets of parameters of an experiment. Some parameters vary by a design (experiment/design.h),
 * others follow from them; conditions leave out sets.
 */
#ifndef MCVISI_HOST_EXPERIMENT_PLAN_H
#define MCVISI_HOST_EXPERIMENT_PLAN_H

#include "core/basics.h"
#include "experiment/design.h"

#include <jansson.h>

/* Sets that are made in another way than by a design. */
typedef struct mcv_given_sets {
    const char *option;   /* of the items "PATH=…", whose values are not read here: "tolerance" */
    const double *values; /* [set][parameter] */
    const uint32_t *seeds; /* what is added to the seed of each set's render, or NULL */
    size_t count;
} mcv_given_sets;

/* The requested variation. A path leads into the scene, as in mcv_overrides; an expression
 * (experiment/expression.h) uses the parameters' names. */
typedef struct mcv_variation {
    mcv_texts vary;              /* "PATH=VALUES", values as mcv_levels_parse reads them */
    mcv_texts tie;               /* "PATH=EXPR" */
    mcv_texts where;             /* "EXPR": a set for which it is 0 is left out */
    int design;                  /* MCV_DESIGN_… */
    size_t points;               /* sets of MCV_DESIGN_LHS and MCV_DESIGN_SOBOL */
    uint32_t seed;               /* of their points */
    const mcv_given_sets *given; /* in place of a design, or NULL */
} mcv_variation;

/* A parameter that varies, or follows from those before it. */
typedef struct mcv_parameter {
    char name[64];    /* the shortest end of its path that is unique */
    const char *item; /* "PATH=…" as given */
    int path_length;
    mcv_levels levels;      /* empty for a tie */
    const char *expression; /* of a tie, or NULL */
} mcv_parameter;

/* The word of a list for which a number stands, and its length; NULL: it is a number. */
const char *mcv_parameter_word(const mcv_parameter *parameter, double number, int *length);

/* The number of a word in the list, the begin of a text that ends at a comma; NaN: there is none.
 */
double mcv_parameter_number(const mcv_parameter *parameter, const char *text);

/* A value as text: its word, or the number in so many digits. */
typedef char mcv_value_text[80];
const char *mcv_parameter_text(const mcv_parameter *parameter, double number, int digits,
                               mcv_value_text text);

/* The word or the number. */
json_t *mcv_parameter_json(const mcv_parameter *parameter, double number);

/* The texts of the variation are borrowed. */
typedef struct mcv_plan {
    mcv_texts where;
    mcv_parameter parameters[MCV_DESIGN_PARAMETERS];
    size_t varied, count;     /* parameters: first those that vary, then ties */
    double *sets;             /* [set][varied] */
    uint32_t *seeds;          /* what is added to the seed of each set's render, or NULL */
    size_t set_count, wanted; /* wanted: number of sets that are not left out */
} mcv_plan;

/* Reads the parameters. MCV_USAGE names the wrong text. The plan must be freed by mcv_plan_free
 * even after a failure. */
mcv_result mcv_plan_parameters(const mcv_variation *variation, mcv_plan *plan, mcv_error *error);

/* Makes the sets of a plan whose parameters are read. MCV_USAGE if the design does not suit them,
 * or if no set is left. */
mcv_result mcv_plan_sets(const mcv_variation *variation, mcv_plan *plan, mcv_error *error);

/* All parameters of a set below set_count, ties included; *wanted is false if it is left out. */
mcv_result mcv_plan_set(const mcv_plan *plan, size_t set, double *numbers, bool *wanted,
                        mcv_error *error);
void mcv_plan_free(mcv_plan *plan);

#endif
