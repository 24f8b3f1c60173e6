/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The sets of parameters of an experiment. Each parameter has levels (a list, or FROM to TO in some
 * number of steps) or a range.
 *
 *     grid   all combinations of the levels, the last parameter changing fastest
 *     list   the first levels of all parameters, then the second ones, and so on; all parameters
 *            must have the same number of levels
 *     lhs    Latin hypercube (McKay, Beckman and Conover 1979): each parameter's range is divided
 *            into as many strata as there are points, with one point in each
 *     sobol  Sobol' points (directions: Joe and Kuo 2008) with a random digital shift; powers of
 *            two are best
 *
 * lhs and sobol use any values of a range, and the members of a list.
 */
#ifndef MCVISI_HOST_EXPERIMENT_DESIGN_H
#define MCVISI_HOST_EXPERIMENT_DESIGN_H

#include "core/error.h"

enum { MCV_DESIGN_GRID, MCV_DESIGN_LIST, MCV_DESIGN_LHS, MCV_DESIGN_SOBOL };
enum { MCV_DESIGN_PARAMETERS = 16, MCV_DESIGN_SETS = 1000000 };

typedef struct mcv_levels {
    double from, to;
    bool logarithmic; /* between from and to, both above 0 */
    double *list;     /* or NULL: a range */
    bool named;       /* the list was of words, and holds their places in it: 0, 1, 2 … */
    size_t count;     /* of the list, or steps of the range */
} mcv_levels;

/*
 * Reads "A..B:N", "A..B:N:log", "A..B" and "A..B:log" (not for a grid) or "A,B,C"; numbers may have
 * units. A list of two or more may be of words, which begin with a letter. MCV_USAGE for other
 * texts. The list is freed by mcv_levels_free.
 */
mcv_result mcv_levels_parse(const char *text, mcv_levels *levels, mcv_error *error);
void mcv_levels_free(mcv_levels *levels);

/* A member of the list, or a step of the range; index below count. */
double mcv_levels_at(const mcv_levels *levels, size_t index);

/*
 * *values gets [set][parameter], malloc'ed. `points` is the number of sets of lhs and sobol; other
 * designs ignore it. MCV_USAGE if the levels do not suit the design, or for more than
 * MCV_DESIGN_SETS sets.
 */
mcv_result mcv_design_make(int design, const mcv_levels *levels, size_t parameters, size_t points,
                           uint32_t seed, double **values, size_t *sets, mcv_error *error);

#endif
