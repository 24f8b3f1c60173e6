/* SPDX-License-Identifier: Apache-2.0 */
/* What the files of a search share. */
#ifndef MCVISI_HOST_OPTIMIZE_SEARCH_PARTS_H
#define MCVISI_HOST_OPTIMIZE_SEARCH_PARTS_H

#include "optimize/search.h"

typedef struct mcv_searching {
    const mcv_search *search;
    mcv_search_result *result;
    mcv_surrogate surrogate;                       /* of one objective, or of a weighted sum */
    mcv_surrogate limits[MCV_SEARCH_REQUIREMENTS]; /* of the margins */
    double better[MCV_SEARCH_OBJECTIVES];
    uint32_t fresh; /* the next seed */
    size_t calm;    /* steps in a row that expected nothing better */
} mcv_searching;

/* space.c: from the unit cube to values, with ten digits as tables have; moves the point to the
 * nearest level of lists. Whether it is allowed. */
bool mcv_space_place(const mcv_search *search, double *unit, double *values);

/* Allowed points of a Sobol' sequence: *count of at most `most`. Their values are not needed. */
mcv_result mcv_space_fill(const mcv_search *search, uint32_t seed, size_t wanted, double *units,
                          size_t *count, mcv_error *error);

/* Evaluates a point and keeps it. */
mcv_result mcv_search_evaluate(mcv_searching *s, const double *unit, int stage, uint32_t seed,
                               mcv_error *error);

/* believe.c: fits the process to a weighted sum of the objectives (NULL: the only one). */
mcv_result mcv_search_believe(mcv_searching *s, const double *weights, bool lengths,
                              mcv_error *error);

/* require.c: fits the processes of the margins. */
mcv_result mcv_search_believe_margins(mcv_searching *s, bool lengths, mcv_error *error);

/* require.c: the chance at each point that all requirements are met; 1 without any. */
mcv_result mcv_search_chances(const mcv_searching *s, const double *points, size_t count,
                              double *chances, mcv_error *error);

/* acquire.c: the most promising point. *promise: its expected improvement; *chance: the probability
 * that any point is better than the best by `better`. */
mcv_result mcv_search_acquire(mcv_searching *s, uint32_t seed, double *unit, double *promise,
                              double *chance, mcv_error *error);

/* believe.c: the evaluated point with the smallest mean of the process, among those that meet the
 * requirements at even odds or better; `cautious`: of mean + deviation. *meets: false where none
 * does; then it is that with the best chance. */
mcv_result mcv_search_best(const mcv_searching *s, bool cautious, double *unit, double *mean,
                           bool *meets, mcv_error *error);

/* confirm.c: mean and standard uncertainty of a point's evaluations from one on: by their spread;
 * or by what they state, where that counts and is there. */
void mcv_search_mean(const mcv_searching *s, size_t from, bool stated_counts,
                     mcv_confirmed *confirmed);

/* polish.c, confirm.c, front.c */
mcv_result mcv_search_polish(mcv_searching *s, size_t budget, mcv_error *error);
mcv_result mcv_search_confirm(mcv_searching *s, size_t budget, mcv_error *error);
mcv_result mcv_search_confirm_front(mcv_searching *s, size_t budget, mcv_error *error);

#endif
