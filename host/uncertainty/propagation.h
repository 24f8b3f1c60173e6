/* SPDX-License-Identifier: Apache-2.0 */
/*
 * How tolerances of parameters propagate to a metric: the points at which it is needed, and what
 * its values there say.
 *
 * First order (JCGM 100:2008, 5.1.3 note 2): y(x ± u_i) with a step of one standard deviation, so
 * that curvature over the tolerance counts. All points of a repeat share their random numbers; each
 * repeat has others. The spread among the repeats is the uncertainty that the renders cause, and
 * products of different repeats are free of it on average:
 *
 *     effect_i = (y(x + u_i) - y(x - u_i))/2     curvature_i = (y(x + u_i) + y(x - u_i) - 2 y(x))/2
 *     u² = mean over repeats r ≠ s of effect(r)ᵀ ρ effect(s)
 *
 * A pair of points per sign vector, where all parameters are off together, shows interactions that
 * steps along single parameters do not see.
 *
 * Monte Carlo (JCGM 101:2008): trials are drawn from the distributions, and each is rendered with
 * random numbers of its own. The variance of the metric holds the variance of the renders' noise,
 * which is subtracted:
 *
 *     u² = s² - mean of the renders' squared standard uncertainties
 *
 * Indices (Sobol'; estimators: Saltelli et al., Variance based sensitivity analysis of model
 * output, Comput. Phys. Commun. 181, 259, 2010): trials A and B, and A with parameter i of B.
 */
#ifndef MCVISI_HOST_UNCERTAINTY_PROPAGATION_H
#define MCVISI_HOST_UNCERTAINTY_PROPAGATION_H

#include "uncertainty/tolerances.h"

/* Which points there are, in this order: the repeats, then the trials. */
typedef struct mcv_propagation {
    const mcv_tolerances *tolerances;
    size_t repeats; /* of the first order: 0, or 2 and more */
    size_t trials;  /* of Monte Carlo: 0, or 10 and more */
    bool indices;   /* trials are A, B, and A with each parameter of B */
} mcv_propagation;

size_t mcv_propagation_signs(const mcv_propagation *p);  /* pairs where all parameters are off */
size_t mcv_propagation_repeat(const mcv_propagation *p); /* points of a repeat */
size_t mcv_propagation_trial(const mcv_propagation *p);  /* points of a trial */
size_t mcv_propagation_points(const mcv_propagation *p); /* all */

/* The parameters of a point, and what is added to the seed of its render. */
void mcv_propagation_point(const mcv_propagation *p, size_t point, uint32_t seed, double *values,
                           uint32_t *offset);

/* A value with its 95 % interval. */
typedef struct mcv_bounded {
    double value, low, high;
} mcv_bounded;

/* What one parameter does to a metric. */
typedef struct mcv_effect {
    double effect, effect_error; /* of one standard deviation, and its standard uncertainty */
    double curvature, curvature_error;
    double share;  /* of the variance to first order */
    bool resolved; /* the effect is more than the renders' noise */
    bool curved;   /* the curvature is, too, and is above 0.3 of the effect and 0.1 of all */
    mcv_bounded first, total; /* Sobol' indices; NaN without them */
} mcv_effect;

typedef struct mcv_propagated {
    size_t repeats, trials;        /* those without a failed point */
    double nominal, nominal_error; /* the metric at the centres */
    mcv_bounded linear;            /* its standard deviation by first order; NaN without */
    bool interacts;                /* parameters together do what they do not alone */
    double mean, mean_error;       /* by Monte Carlo; NaN without */
    mcv_bounded deviation;         /* its standard deviation, without the renders' noise */
    double noise;                  /* standard uncertainty of one render of the trials */
    double low, high;              /* 95 % of the metric's values lie between */
    bool nonlinear; /* a parameter is curved, parameters interact, or the two deviations differ */
    mcv_effect effects[MCV_DESIGN_PARAMETERS];
    size_t order[MCV_DESIGN_PARAMETERS]; /* parameters, the largest contribution first */
} mcv_propagated;

/* From the metric at all points, value and standard uncertainty of each in pairs of `stride`
 * doubles; NaN: the point has failed. MCV_FAILED without memory. */
mcv_result mcv_propagate(const mcv_propagation *p, const double *points, size_t stride,
                         mcv_propagated *found, mcv_error *error);

/* first_order.c, trials.c */
mcv_result mcv_propagate_first_order(const mcv_propagation *p, const double *points, size_t stride,
                                     mcv_propagated *found, mcv_error *error);
mcv_result mcv_propagate_trials(const mcv_propagation *p, const double *points, size_t stride,
                                mcv_propagated *found, mcv_error *error);

#endif
