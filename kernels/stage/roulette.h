/* SPDX-License-Identifier: Apache-2.0 */
/* Russian roulette, of camera paths and of light paths. */
#ifndef MCVISI_KERNELS_ROULETTE_H
#define MCVISI_KERNELS_ROULETTE_H

#include "world.h"

typedef struct mcv_roulette {
    int survives;   /* the path continues */
    int threatened; /* it might not have: what it carries grows by the gain */
    float gain;
} mcv_roulette;

/*
 * A path that carries less than `enough` survives with the probability carried / enough, and then
 * carries `enough`. One that carries nothing ends in any case. plays: 0 spares the path; xi in [0,
 * 1) decides.
 */
MCV_LOOP_FUNCTION mcv_roulette mcv_play_roulette(int plays, float carried, float enough, float xi) {
    mcv_roulette roulette;
    const float chance = carried / enough;
    roulette.threatened = plays & (carried < enough);
    roulette.survives = (carried > 0.0f) & !(roulette.threatened & (xi >= chance));
    roulette.gain = 1.0f / chance;
    return roulette;
}

/* What a path carries that has survived. */
MCV_LOOP_FUNCTION mcv_color mcv_after_roulette(mcv_roulette roulette, mcv_color carried) {
    MCV_EACH_CHANNEL(i)
    carried.c[i] = roulette.threatened ? carried.c[i] * roulette.gain : carried.c[i];
    return carried;
}

/* What the depth limit cuts of a path, in units of 2^-11: a million paths fit the counter. */
MCV_FUNCTION uint mcv_lost_energy(float carried) { return (uint)(carried * 2048.0f + 0.5f); }

#endif
