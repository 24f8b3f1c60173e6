/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Choosing an emitter by what it may bring to a receiver: its power, thinned out by its distance,
 * and nothing from behind the receiver, of what emits the other way, and out of narrow cones and
 * beams. What is left out by rounding, a receiver in the plane of an emitter or on the rim of a
 * cone, would have brought as good as nothing.
 *
 * The power Φ gives about the irradiance E = Φ/(A + Ω d²) at the distance d. A is the emitter's
 * area and Ω the projected solid angle of its light: Φ/A close by, Φ/(Ω d²) from afar. The
 * importance is π E = power/(narrowest + widening d²), with `narrowest` = A/π and `widening` = Ω/π
 * of mcv_device_emitter (host/device/pack_emitters.c). An emitter at infinity has no widening.
 */
#ifndef MCVISI_KERNELS_SELECTION_H
#define MCVISI_KERNELS_SELECTION_H

#include "light/discrete.h"
#include "light/lobe.h"
#include "world.h"

/* How far a flat emitter stretches along a direction, r times the sine of the angle to its normal;
 * without a normal, r. */
MCV_LOOP_FUNCTION float mcv_stretch(__global const mcv_device_emitter *e, mcv_vec3 direction) {
    const float cosine = mcv_dot(mcv_vec(e->facing[0], e->facing[1], e->facing[2]), direction);
    const float squared = 1.0f - cosine * cosine;
    return squared > 0.0f ? e->radius * mcv_sqrt(squared) : 0.0f;
}

/* `sides` of the receiver that scatter light: one, which all of the normals show, or both. */
MCV_LOOP_FUNCTION int mcv_emitter_reaches(__global const mcv_device_emitter *e, mcv_vec3 receiver,
                                          mcv_vec3 ng, mcv_vec3 ns, uint sides) {
    const mcv_vec3 way = mcv_sub(mcv_vec(e->middle[0], e->middle[1], e->middle[2]), receiver);
    const mcv_vec3 axis = mcv_vec(e->facing[0], e->facing[1], e->facing[2]);
    const int behind_it = -mcv_dot(axis, way) < 0.0f;
    const int behind_ng = mcv_dot(ng, way) < -mcv_stretch(e, ng),
              behind_ns = mcv_dot(ns, way) < -mcv_stretch(e, ns);
    int behind = (sides == 1u) & behind_ng & behind_ns;
    int lit = 1;
#if MCV_WITH_PARALLEL
    const float ahead =
        -mcv_dot(mcv_vec(e->parallel.axis[0], e->parallel.axis[1], e->parallel.axis[2]), way);
    const float reach = e->radius + (ahead + e->radius) * mcv_sqrt(e->parallel.tangent_squared);
    const int in_cone =
        (ahead + e->radius > 0.0f) & (mcv_dot(way, way) - ahead * ahead <= reach * reach);
    lit &= (e->type != MCV_EMITTER_PARALLEL) | !e->parallel.from_receiver | in_cone;
#endif
#if MCV_WITH_BEAM
    lit &= (e->type != MCV_EMITTER_COLLIMATED_BEAM) |
           mcv_collimated_beam_covers(&e->beam, mcv_scale(way, -1.0f));
#endif
#if MCV_WITH_PUNCTUAL
    lit &= (e->type != MCV_EMITTER_POINT) |
           (mcv_point_light_profile(&e->light, mcv_normalize(mcv_scale(way, -1.0f))) > 0.0f);
#endif
    int nowhere = e->radius < 0.0f;
#if MCV_WITH_LASER
    nowhere &= (e->type != MCV_EMITTER_LASER) | mcv_laser_covers(&e->laser, mcv_scale(way, -1.0f));
    behind |= e->type == MCV_EMITTER_LASER;
#endif
    return (e->probability > 0.0f) & (nowhere | (!behind_it & !behind & lit));
}

/* The irradiance that the receiver may get from an emitter, up to a factor. */
MCV_LOOP_FUNCTION float mcv_emitter_importance(__global const mcv_device_emitter *e,
                                               mcv_vec3 receiver) {
    const mcv_vec3 way = mcv_sub(mcv_vec(e->middle[0], e->middle[1], e->middle[2]), receiver);
    return e->power / mcv_fma(e->widening, mcv_dot(way, way), e->narrowest);
}

/* What reaches a receiver: of so many emitters the sum of the importances, and of these times what
 * the receiver sends on, once and squared. */
typedef struct mcv_reaching {
    float sum, count;
    float received, squares;
} mcv_reaching;

MCV_LOOP_FUNCTION mcv_reaching mcv_nothing_reaches(void) {
    const mcv_reaching nothing = {0.0f, 0.0f, 0.0f, 0.0f};
    return nothing;
}

/* An emitter's importance to a receiver times what that sends on against `direction`, -1 where it
 * does not reach it. `sides` as in mcv_emitter_reaches. glossy, known to the compiler: 0 if all
 * lobes are mcv_even_lobe(). */
MCV_LOOP_FUNCTION float mcv_add_reaching(__global const mcv_device_emitter *e, mcv_vec3 receiver,
                                         mcv_vec3 ng, mcv_vec3 ns, uint sides, mcv_vec3 direction,
                                         mcv_receiver_lobe lobe, int glossy, mcv_reaching *all) {
    const int reaches = mcv_emitter_reaches(e, receiver, ng, ns, sides);
    const float importance = mcv_emitter_importance(e, receiver);
    float received = 1.0f;
#if MCV_WITH_GLOSSY
    if (glossy) received = mcv_lobe_towards(e, receiver, direction, ns, lobe);
#endif
    const float weight = importance * received;
    all->sum += reaches ? importance : 0.0f;
    all->count += reaches ? 1.0f : 0.0f;
    all->received += reaches ? weight : 0.0f;
    all->squares += reaches ? weight * received : 0.0f;
    (void)direction, (void)lobe, (void)glossy;
    return reaches ? weight : -1.0f;
}

/*
 * How a receiver chooses among the emitters that reach it, and by what its MIS weighs them.
 *
 * Emitters are chosen with the pmf pmf_scale * w + pmf_least, w being the importance times what the
 * receiver's lobe sends on (mcv_add_reaching). With a glossy receiver w depends on the path's
 * direction before it. A BSDF ray that hits the emitter cannot evaluate this pmf again: the path
 * keeps neither that direction nor the lobe. So MIS uses a surrogate in place of the pmf, on both
 * sides: s = mis_scale * importance + mis_least. The path keeps its two numbers, and can evaluate
 * it wherever it meets the emitter (mcv_selection_ratio). The sampled light is divided by the pmf
 * itself. The weights of both sides sum to 1 with any s, which keeps the estimate unbiased.
 *
 * s need not sum to 1. It is the pmf by importance alone, times the mean of how much oftener the
 * lobe chooses what it chooses. Without glossy receivers s is the pmf.
 */
typedef struct mcv_light_selection {
    float mis_scale, mis_least;
    float pmf_scale, pmf_least;
} mcv_light_selection;

MCV_LOOP_FUNCTION mcv_light_selection mcv_make_light_selection(mcv_reaching all, int glossy) {
    mcv_light_selection selection;
    selection.mis_scale = all.sum > 0.0f ? MCV_INFORMED_PROBABILITY / all.sum : 0.0f;
    selection.mis_least = (all.sum > 0.0f ? MCV_DEFENSIVE_PROBABILITY : 1.0f) / all.count;
    selection.pmf_scale = selection.mis_scale;
    selection.pmf_least = selection.mis_least;
    if (!(MCV_WITH_GLOSSY && glossy)) return selection;
    const int sends = all.received > 0.0f;
    const float oftener =
        mcv_fma(MCV_INFORMED_PROBABILITY, (all.squares / all.received) * (all.sum / all.received),
                MCV_DEFENSIVE_PROBABILITY);
    selection.pmf_scale = sends ? MCV_INFORMED_PROBABILITY / all.received : 0.0f;
    selection.pmf_least = (sends ? MCV_DEFENSIVE_PROBABILITY : 1.0f) / all.count;
    selection.mis_scale *= sends ? oftener : 1.0f;
    selection.mis_least *= sends ? oftener : 1.0f;
    return selection;
}

/* The emitter that a number has chosen of those asked so far, and the chances of these: the first
 * one whose chances, with those before it, exceed the number; for want of it the last one. */
typedef struct mcv_emitter_choice {
    uint emitter;          /* MCV_NONE: none of them reaches the receiver */
    float chances, chance; /* of all asked, of this one */
} mcv_emitter_choice;

MCV_LOOP_FUNCTION mcv_emitter_choice mcv_ask_emitter(mcv_emitter_choice so_far, uint emitter,
                                                     float weight, float scale, float least,
                                                     float xi) {
    const int open = (so_far.emitter == MCV_NONE) | (so_far.chances <= xi),
              takes = open & (weight >= 0.0f);
    const float chance = mcv_fma(weight, scale, least);
    so_far.emitter = takes ? emitter : so_far.emitter;
    so_far.chance = takes ? chance : so_far.chance;
    so_far.chances += takes ? chance : 0.0f;
    return so_far;
}

/* The emitter at xi of all that reach the receiver, MCV_NONE where nothing does. *chance: of that
 * choice. */
MCV_FUNCTION uint mcv_select_emitter(mcv_world world, mcv_vec3 receiver, mcv_vec3 ng, mcv_vec3 ns,
                                     uint sides, mcv_vec3 direction, mcv_receiver_lobe lobe,
                                     float xi, mcv_light_selection *selection, float *chance) {
    float weights[MCV_MOST_REACHING];
    mcv_reaching all = mcv_nothing_reaches();
    mcv_emitter_choice choice = {MCV_NONE, 0.0f, 0.0f};
    const uint count = min(world.frame->emitter_count, (uint)MCV_MOST_REACHING);
    for (uint i = 0; i < count; ++i)
        weights[i] = mcv_add_reaching(world.emitters + i, receiver, ng, ns, sides, direction, lobe,
                                      MCV_WITH_GLOSSY, &all);
    *selection = mcv_make_light_selection(all, MCV_WITH_GLOSSY);
    for (uint i = 0; i < count; ++i)
        choice =
            mcv_ask_emitter(choice, i, weights[i], selection->pmf_scale, selection->pmf_least, xi);
    *chance = choice.chance;
    return choice.emitter;
}

/* The surrogate of mcv_light_selection over the probability that the emitter has by power alone. */
MCV_LOOP_FUNCTION float mcv_selection_ratio(__global const mcv_device_emitter *e, mcv_vec3 receiver,
                                            float mis_scale, float mis_least) {
    return mcv_fma(mcv_emitter_importance(e, receiver), mis_scale, mis_least) / e->probability;
}

#endif
