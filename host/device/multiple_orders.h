/* SPDX-License-Identifier: Apache-2.0 */
/* Two and three reflections between GGX microfacets: what the tables of metals (multiple.c,
 * multiple_brushed.c) share; nothing else calls them. */
#ifndef MCVISI_HOST_DEVICE_MULTIPLE_ORDERS_H
#define MCVISI_HOST_DEVICE_MULTIPLE_ORDERS_H

#include <stdint.h>

#include "mcvisi/materials/microfacet.h"

/* Steps of a metal's reflectance by the cosine. */
enum { MCV_FACET_STEPS = 512 };

/* What microfacets reflect: a metal's three channels, or 0: Schlick's words. */
typedef struct mcv_facet_metal {
    float reflectance[3][MCV_FACET_STEPS + 2];
    uint32_t channels;
} mcv_facet_metal;

/* Of n - ik, or with n == NULL of Schlick's f + (1 - f) (1 - c)^5. */
void mcv_facet_metal_fill(const double *n, const double *k, mcv_facet_metal *metal);

/* Adds to an entry's words, and to the sum of white microfacets behind them, two reflections at the
 * cosines of incidence c1 and c2. */
void mcv_add_two_reflections(const mcv_facet_metal *metal, double value, float c1, float c2,
                             double sums[MCV_MULTIPLE_WORDS + 1]);

/*
 * Three reflections of white microfacets between two directions, in the unit of 1/(4 |o_z| |i_z| (1
 * + Λ(o) + Λ(i))) of the BRDF times i_z. Two of the three microfacets are chosen among the visible
 * ones by an additive recurrence, of which so many points are left out; the balance heuristic
 * combines the three choices.
 */
double mcv_three_reflections(const double alpha[2], const double o[3], const double i[3],
                             int choices, int left_out);

/*
 * Three and more reflections over two, for a mean reflectance: Σ over 3, 4 …, before each of which
 * the share `left` remains.
 */
double mcv_more_reflections(double reflectance, double left);

#endif
