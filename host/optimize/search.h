/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The search for the parameters at which noisy objectives are smallest, with few evaluations:
 *
 *     screening   Sobol' points over the whole box
 *     search      a Gaussian process of what was seen (optimize/surrogate.h); the next point is
 *                 where the augmented expected improvement is largest (Huang, Allen, Notz and Zeng,
 *                 Global optimization of stochastic black-box systems, J. Global Optim. 34, 441,
 *                 2006), which may be an old point with other noise. Several objectives: each step
 *                 has weights of its own (Knowles, ParEGO, IEEE Trans. Evol. Comput. 10, 50, 2006)
 *     polish      BOBYQA of NLopt about the best point, with one seed
 *     require     requirements of what was measured have processes of their own: the improvement
 *                 counts by the chance that all are met (Schonlau, Welch and Jones, Global versus
 *                 local search in constrained optimization, IMS Lecture Notes 34, 11, 1998)
 *     confirm     the best and its rivals with fresh seeds, shared by OCBA (Chen, Lin, Yücesan and
 *                 Chick, Discrete Event Dyn. Syst. 10, 251, 2000); then the winner with seeds that
 *                 have chosen nothing
 *
 * The best of many noisy values looks better than it is. So only the values of the last stage are
 * the result.
 */
#ifndef MCVISI_HOST_OPTIMIZE_SEARCH_H
#define MCVISI_HOST_OPTIMIZE_SEARCH_H

#include "optimize/surrogate.h"

#include <stdint.h>

enum {
    MCV_SEARCH_OBJECTIVES = 3,
    MCV_SEARCH_RIVALS = 5, /* points of which the winner is chosen */
    MCV_SEARCH_FRONT = 12, /* points of several objectives that are confirmed */
    MCV_SEARCH_REQUIREMENTS = 4
};
enum { MCV_STAGE_SCREENING, MCV_STAGE_SEARCH, MCV_STAGE_POLISH, MCV_STAGE_CONFIRM };
extern const char *const mcv_search_stages[];

typedef struct mcv_evaluation {
    double unit[MCV_SURROGATE_PARAMETERS];                                /* in the unit cube */
    double values[MCV_SURROGATE_PARAMETERS];                              /* of the parameters */
    double results[MCV_SEARCH_OBJECTIVES], errors[MCV_SEARCH_OBJECTIVES]; /* NaN: it has failed */
    /* A requirement is met where its margin is 0 or less. */
    double margins[MCV_SEARCH_REQUIREMENTS], margin_errors[MCV_SEARCH_REQUIREMENTS];
    int stage;
    uint32_t seed;
} mcv_evaluation;

typedef struct mcv_search {
    size_t dimensions, objectives;        /* objectives are made small */
    size_t requirements;                  /* for one objective only */
    const mcv_levels *levels;             /* of the parameters; a list: one of its values */
    size_t budget;                        /* evaluations in all */
    double better[MCV_SEARCH_OBJECTIVES]; /* the least difference that matters; 0: 1 % of the range
                                             of the screening */
    uint32_t seed;
    /* Fills in results and margins with their errors for values, seed and stage. Any result but
     * MCV_OK ends it. */
    mcv_result (*evaluate)(void *user, mcv_evaluation *evaluation, mcv_error *error);
    /* Whether the parameters may be so; NULL: they may. */
    bool (*allowed)(void *user, const double *values);
    void *user;
} mcv_search;

/* A point with the mean of its fresh evaluations. */
typedef struct mcv_confirmed {
    mcv_evaluation point; /* results and margins: means with their standard uncertainties */
    size_t count;         /* of fresh evaluations */
    double in_search;     /* what the search had seen there: its smallest value */
} mcv_confirmed;

typedef struct mcv_search_result {
    mcv_evaluation *all; /* owned */
    size_t count, failed, room;
    const char *ended;                      /* why the search stopped, in words */
    mcv_confirmed points[MCV_SEARCH_FRONT]; /* rivals, the winner first; or the Pareto front */
    size_t point_count;
    mcv_confirmed winner;                     /* of one objective: its evaluations choose nothing */
    double low, high;                         /* 95 % interval of the winner's mean */
    double near[MCV_SURROGATE_PARAMETERS][2]; /* of each parameter: where the process's mean is
                                                 worse by less than `better` */
} mcv_search_result;

/*
 * Searches. MCV_BAD_INPUT where no point is allowed; MCV_FAILED where every evaluation has failed,
 * where none seems to meet the requirements, or without memory. After failure, too, the result is
 * freed.
 */
mcv_result mcv_search_run(const mcv_search *search, mcv_search_result *result, mcv_error *error);
void mcv_search_free(mcv_search_result *result);

#endif
