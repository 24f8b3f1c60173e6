/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Which sets of parameters an experiment tries. Each parameter has levels (a list, or from … to in
 * so many steps) or a range.
 *
 *   grid   all combinations of the levels, the last parameter changing fastest
 *   list   the first levels of all, then the second ones, …: as many each
 *   lhs    Latin hypercube (McKay, Beckman and Conover 1979): each parameter's range in as many
 * strata as points, each met once sobol  Sobol' points (directions: Joe and Kuo 2008) with a random
 * digital shift; powers of two of them are best
 *
 * lhs and sobol take any values of a range, and of a list its members.
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
    size_t count;     /* of the list, or steps of the range */
} mcv_levels;

/*
 * "A..B:N", "A..B:N:log", "A..B" (no grid then), or "A,B,C"; numbers may have units. MCV_USAGE
 * where it is neither. The list is freed by mcv_levels_free.
 */
mcv_result mcv_levels_parse(const char *text, mcv_levels *levels, mcv_error *error);
void mcv_levels_free(mcv_levels *levels);

/*
 * *values gets [set][parameter], malloc'ed. points is the number of sets of lhs and sobol, and
 * counts for no other. MCV_USAGE where the levels do not suit the design, or for more than
 * MCV_DESIGN_SETS sets.
 */
mcv_result mcv_design_make(int design, const mcv_levels *levels, size_t parameters, size_t points,
                           uint32_t seed, double **values, size_t *sets, mcv_error *error);

#endif
