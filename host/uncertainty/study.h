/* SPDX-License-Identifier: Apache-2.0 */
/*
 * An experiment whose sets are the points of a propagation of uncertainty: tolerances in place of
 * values that vary.
 *
 *     mcv_study study;
 *     result = mcv_study_run(&asked, &study, &error);
 *     …              mcv_study_find gives what a metric's values say
 *     mcv_study_free(&study);
 */
#ifndef MCVISI_HOST_UNCERTAINTY_STUDY_H
#define MCVISI_HOST_UNCERTAINTY_STUDY_H

#include "experiment/experiment.h"
#include "uncertainty/propagation.h"

/* All pointers are borrowed and must outlive the study. */
typedef struct mcv_study_asked {
    mcv_experiment experiment; /* variation.vary: the tolerances, "PATH=DISTRIBUTION" */
    mcv_texts correlate;       /* "A,B=R", by the parameters' names */
    size_t repeats, trials;    /* 0: no first order, no Monte Carlo */
    bool indices;
} mcv_study_asked;

/* It points into itself: it must not be copied. */
typedef struct mcv_study {
    mcv_experiment experiment;
    mcv_tolerances tolerances;
    mcv_propagation propagation;
    mcv_given_sets sets;
    double *values;
    uint32_t *seeds;
    mcv_sweep sweep;
} mcv_study;

/*
 * Renders and measures all points. Codes and files are those of mcv_experiment_plan,
 * mcv_experiment_open_table and mcv_experiment_run. The study must be freed even after a failure.
 */
mcv_result mcv_study_run(const mcv_study_asked *asked, mcv_study *study, mcv_error *error);

/* What the rows so far say about a metric. MCV_FAILED without memory. */
mcv_result mcv_study_find(const mcv_study *study, size_t metric, mcv_propagated *found,
                          mcv_error *error);

void mcv_study_free(mcv_study *study);

/* page.c: what the experiment's page shows; an mcv_experiment's put_results with the study. */
bool mcv_study_put_results(FILE *out, const struct mcv_page *page, void *study);

#endif
