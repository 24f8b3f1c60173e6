/* SPDX-License-Identifier: Apache-2.0 */
/*
 * An experiment whose sets a search chooses one after the other. Its table is all that there is to
 * be kept: to resume, the search takes the same way again and finds its rows there.
 *
 *     mcv_optimization o;
 *     result = mcv_optimization_run(&asked, &o, &error);
 *     …              o.found
 *     mcv_optimization_free(&o);
 */
#ifndef MCVISI_HOST_OPTIMIZE_STUDY_H
#define MCVISI_HOST_OPTIMIZE_STUDY_H

#include "experiment/experiment.h"
#include "optimize/search.h"

/* All pointers are borrowed and must outlive the optimisation. */
typedef struct mcv_optimization_asked {
    mcv_experiment experiment; /* variation: ranges and lists of values; where: the constraints */
    mcv_texts objectives;      /* "NAME=smallest|largest" */
    mcv_texts better;          /* "NAME=D": the least difference that matters */
    mcv_texts require;         /* "EXPR<EXPR" of metrics and parameters, also with <=, > and >= */
    size_t evaluations;        /* at most */
} mcv_optimization_asked;

/* A requirement as "A - B", which must be 0 or less. */
typedef struct mcv_requirement {
    const char *text; /* as given; borrowed */
    char margin[512];
} mcv_requirement;

typedef struct mcv_objective {
    size_t metric;
    bool largest;
} mcv_objective;

/* It points into itself: it must not be copied. */
typedef struct mcv_optimization {
    mcv_experiment experiment;
    mcv_texts where;
    mcv_plan space;                           /* the parameters with the constraints */
    mcv_levels levels[MCV_DESIGN_PARAMETERS]; /* of the search; their lists are owned */
    double point[MCV_DESIGN_PARAMETERS];      /* of the space, while a constraint is looked at */
    mcv_given_sets sets;
    double *values;
    mcv_objective objectives[MCV_SEARCH_OBJECTIVES];
    mcv_requirement requirements[MCV_SEARCH_REQUIREMENTS];
    mcv_search search;
    mcv_search_result found; /* results of objectives that are to be large have the other sign */
    size_t *rows;            /* row of each set + 1, of those that were read; 0: none */
    size_t next;             /* set */
    mcv_sweep sweep;
} mcv_optimization;

/*
 * Searches, renders and measures. Codes and files are those of an experiment; MCV_USAGE for
 * constraints and objectives that cannot be read, MCV_BAD_INPUT for constraints that allow nothing.
 * It must be freed even after a failure.
 */
mcv_result mcv_optimization_run(const mcv_optimization_asked *asked, mcv_optimization *o,
                                mcv_error *error);
void mcv_optimization_free(mcv_optimization *o);

/* A result of an objective with its own sign again. */
double mcv_optimization_value(const mcv_optimization *o, size_t objective, double result);

/* requirements.c: reads them, and finds the margins of a set from the numbers of its row. */
mcv_result mcv_requirements_read(const mcv_optimization_asked *asked, mcv_optimization *o,
                                 mcv_error *error);
mcv_result mcv_requirements_margins(const mcv_optimization *o, const double *row, mcv_evaluation *e,
                                    mcv_error *error);

/* page.c: what the experiment's page shows; an mcv_experiment's put_results. */
bool mcv_optimization_put_results(FILE *out, const struct mcv_page *page, void *optimization);

#endif
