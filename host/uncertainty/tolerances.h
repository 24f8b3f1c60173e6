/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tolerances: the distributions of an experiment's parameters about their nominal values.
 *
 *     normal(U)       standard deviation U
 *     uniform(A)      anywhere within ±A; standard deviation A/√3
 *     triangular(A)   within ±A, most often at the centre; standard deviation A/√6
 *
 * Each may name its centre first, as in normal(25mm,0.1mm). Correlated tolerances have a normal
 * copula: standard normal scores z with a matrix of correlations, each transformed to its own
 * distribution. The matrix is chosen so that the coefficients given are those of the parameters
 * themselves (Cario and Nelson, Modeling and generating random vectors with arbitrary marginal
 * distributions and correlation matrix, 1997).
 */
#ifndef MCVISI_HOST_UNCERTAINTY_TOLERANCES_H
#define MCVISI_HOST_UNCERTAINTY_TOLERANCES_H

#include "experiment/plan.h"

/* X(NAME, "name", standard deviation over the width) */
#define MCV_DISTRIBUTIONS(X) \
    X(NORMAL, "normal", 1.0) \
    X(UNIFORM, "uniform", 0.57735026918962576) \
    X(TRIANGULAR, "triangular", 0.40824829046386302)
enum {
#define MCV_X(NAME, name, deviation) MCV_DISTRIBUTION_##NAME,
    MCV_DISTRIBUTIONS(MCV_X)
#undef MCV_X
        MCV_DISTRIBUTION_COUNT
};

typedef struct mcv_distribution {
    int kind;
    double centre; /* NaN: not given */
    double width;  /* U or A, above 0 */
} mcv_distribution;

typedef struct mcv_tolerances {
    size_t count;
    mcv_distribution of[MCV_DESIGN_PARAMETERS];
    bool correlated;
    double correlation[MCV_DESIGN_PARAMETERS][MCV_DESIGN_PARAMETERS]; /* of the parameters */
    double factor[MCV_DESIGN_PARAMETERS][MCV_DESIGN_PARAMETERS]; /* lower: Cholesky's of scores */
} mcv_tolerances;

/* Reads "normal(0.1mm)" and the like. MCV_USAGE says what there is. */
mcv_result mcv_distribution_parse(const char *text, mcv_distribution *distribution,
                                  mcv_error *error);

double mcv_distribution_deviation(const mcv_distribution *distribution);

/* The value at a standard normal score. */
double mcv_distribution_at(const mcv_distribution *distribution, double score);

/* Reads the tolerances that a plan's parameters were given as, "PATH=DISTRIBUTION", and the
 * coefficients "A,B=R" by the parameters' names. MCV_USAGE for unknown distributions and names,
 * and for coefficients that no parameters can have together. */
mcv_result mcv_tolerances_read(const mcv_plan *plan, mcv_texts correlate,
                               mcv_tolerances *tolerances, mcv_error *error);

/* One draw of all parameters from independent standard normal scores. */
void mcv_tolerances_draw(const mcv_tolerances *tolerances, const double *scores, double *values);

#endif
