/* SPDX-License-Identifier: Apache-2.0 */
/* Light that meets two microfacets of an interface, by quadrature; its table
 * (multiple_interface.c) alone calls it. */
#ifndef MCVISI_HOST_DEVICE_MULTIPLE_TWO_H
#define MCVISI_HOST_DEVICE_MULTIPLE_TWO_H

#include "device/multiple_goals.h"

/*
 * Means over the heights of two microfacets, times 1 + Λ of the direction between them, at equal
 * steps of Λ/(1 + Λ): by whether the first one passes light, whether light goes up between them,
 * whether the second one passes it, and by the goal's column.
 */
enum { MCV_HEIGHT_STEPS = 17 };
typedef float mcv_heights[2][2][2][MCV_GOAL_NODES][MCV_HEIGHT_STEPS];

/* Those of a row; both sides have the same. */
void mcv_heights_fill(const mcv_goals *goals, uint32_t row, mcv_heights heights);

/*
 * Adds what light from the direction of a row on the side `start` sends to the goals after two
 * meetings. Returns the share that goes on after one.
 */
double mcv_meet_twice(const mcv_facet_interface *at, const mcv_goals *goals, int start,
                      uint32_t row, mcv_heights heights, mcv_goal_sums sums);

#endif
