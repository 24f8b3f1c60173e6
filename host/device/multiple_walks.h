/* SPDX-License-Identifier: Apache-2.0 */
/* Light that walks between the microfacets of an interface; its table (multiple_interface.c) alone
 * calls it. */
#ifndef MCVISI_HOST_DEVICE_MULTIPLE_WALKS_H
#define MCVISI_HOST_DEVICE_MULTIPLE_WALKS_H

#include "device/multiple_goals.h"

/*
 * Light that walks from the direction of a row on the side `start` until it leaves (Heitz and
 * others 2016): adds what each meeting from the third on sends to the goals. Half the walks reflect
 * first, half refract.
 */
void mcv_walk(const mcv_facet_interface *at, const mcv_goals *goals, int start, uint32_t row,
              mcv_goal_sums sums);

#endif
