/* SPDX-License-Identifier: Apache-2.0 */
/* Russian roulette, of camera paths and of light paths. */
#ifndef MCVISI_KERNELS_ROULETTE_H
#define MCVISI_KERNELS_ROULETTE_H

#include "path/identity.h"
#include "world.h"

/*
 * The number of surfaces before Russian roulette may end a path, and the throughput below which it
 * does. A smaller threshold costs time, a larger one makes noise. Where next-event estimation
 * samples all emitters, the later vertices contribute little and their rays cost most in meshes.
 * Light that is met by chance, from an environment or through glass, needs them.
 */
#if MCV_WITH_EARLY_ROULETTE
#define MCV_ROULETTE_DEPTH 2u
#define MCV_ROULETTE_WEIGHT 0.5f
#else
#define MCV_ROULETTE_DEPTH 4u
#define MCV_ROULETTE_WEIGHT 0.125f
#endif

/* The depth from which roulette may end a light path. Its emitter is depth 0, the first surface
 * that it meets 1: four surfaces are spared. */
#define MCV_LIGHT_ROULETTE_DEPTH 5u

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

/* Is the pair that chooses among emitters, lobes and going on needed? */
MCV_FUNCTION int mcv_needs_choice(__constant const mcv_frame *frame, uint depth) {
    return MCV_WITH_GLOSSY || MCV_WITH_REFLECTOR || MCV_WITH_TRANSLUCENT ||
           depth >= MCV_ROULETTE_DEPTH || frame->emitter_count > 1u;
}

/*
 * The pair that chooses a lobe and plays roulette; any numbers where a surface needs none. Its
 * first number has chosen an emitter, too, which is another estimate.
 */
MCV_LOOP_FUNCTION mcv_pair mcv_draw_choice(mcv_world world, mcv_slot slot, uint depth) {
    const mcv_pair unused = {0.0f, 0.0f};
    if (!MCV_TILE && !mcv_needs_choice(world.frame, depth)) return unused;
    return mcv_draw(slot, depth, MCV_PAIR_CHOICE);
}

/* What the depth limit cuts of a path, in units of 2^-11: a million paths fit the counter. */
MCV_FUNCTION uint mcv_lost_energy(float carried) { return (uint)(carried * 2048.0f + 0.5f); }

#endif
