/* SPDX-License-Identifier: Apache-2.0 */
/* The lobes of a glossy surface seen from o, and with which chances they are chosen. Directions are
 * as in bsdf/microfacet.h. */
#ifndef MCVISI_KERNELS_MICROFACET_LOBES_H
#define MCVISI_KERNELS_MICROFACET_LOBES_H

#include "bsdf/microfacet_tables.h"

typedef struct mcv_lobes {
    float lambda;   /* Λ(o) */
    mcv_color more; /* metallic-roughness: three and more reflections, as a share of those of white
                       microfacets */
    mcv_color passing;        /* factor of what passes a thin wall */
    mcv_color near_a, near_b; /* cosine lobes on the ray's side: near_a a(i) + near_b b(i) … */
    mcv_color far_a, far_b;   /* … and on the other */
    float microfacet, near_chance; /* with which the lobes are chosen; else the far one */
    float far_chance;
} mcv_lobes;

/* What a(i) and b(i) are: of a metallic-roughness surface what the layer passes, and what its
 * microfacets send on to each other. */
MCV_LOOP_FUNCTION mcv_albedo mcv_microfacet_weights(const mcv_device_glossy *m,
                                                    const mcv_microfacets *microfacets,
                                                    mcv_albedo albedo) {
    mcv_albedo weights;
    weights.a = 1.0f - mcv_fma(m->f0, 1.0f - albedo.a - albedo.b, albedo.b);
    weights.b = albedo.a;
    if (microfacets->type == MCV_MATERIAL_DIELECTRIC) return albedo;
    return weights;
}

MCV_LOOP_FUNCTION mcv_lobes mcv_no_lobes(float lambda) {
    mcv_lobes lobes;
    lobes.lambda = lambda;
    lobes.passing = lobes.more = mcv_grey(0.0f);
    lobes.near_a = lobes.near_b = lobes.far_a = lobes.far_b = mcv_grey(0.0f);
    lobes.microfacet = lobes.near_chance = lobes.far_chance = 0.0f;
    return lobes;
}

#if MCV_WITH_ROUGH_GLASS
/* Of rough glass, by the table's entries for o. */
MCV_LOOP_FUNCTION mcv_lobes mcv_glass_lobes(const mcv_device_glossy *m,
                                            const mcv_microfacets *microfacets,
                                            __global const float *albedos, mcv_vec3 o,
                                            mcv_albedo at, mcv_lobes lobes) {
    /* a: what is missing outside the body, b: inside. */
    const float missing = microfacets->inside ? at.b : at.a;
    const float square = microfacets->between.eta * microfacets->between.eta;
    if (mcv_has_multiple(
            m,
            microfacets)) { /* the table has it; cosines choose directions, by n² of either side */
        lobes.far_chance = missing / (1.0f + square);
        lobes.near_chance = missing - lobes.far_chance;
        lobes.microfacet = 1.0f - missing;
        return lobes;
    }
    /* Light in the medium s leaves into t with the share n_t² M_t/X, by X = Σ n² M. */
    const mcv_albedo mean = mcv_albedo_at(m, microfacets, albedos, o, 1);
    const float near_mean = microfacets->inside ? mean.b : mean.a;
    const float far_mean = microfacets->inside ? mean.a : mean.b;
    const float near = square * near_mean;
    const float sum = near + far_mean;
    const float share = near > 0.0f ? missing / sum : 0.0f;
    lobes.near_chance = near > 0.0f ? missing * near / sum : 0.0f;
    lobes.far_chance = near > 0.0f ? missing - lobes.near_chance : 0.0f;
    lobes.microfacet = 1.0f - lobes.near_chance - lobes.far_chance;
    MCV_EACH_CHANNEL(k) {
        lobes.near_a.c[k] = microfacets->inside ? 0.0f : share * square;
        lobes.near_b.c[k] = microfacets->inside ? share * square : 0.0f;
        lobes.far_a.c[k] = microfacets->inside ? share : 0.0f;
        lobes.far_b.c[k] = microfacets->inside ? 0.0f : share;
    }
    return lobes;
}
#endif

/* Of a metallic-roughness surface, by the table's entries for o and their means. */
MCV_LOOP_FUNCTION mcv_lobes mcv_layer_lobes(const mcv_device_glossy *m,
                                            const mcv_microfacets *microfacets, mcv_albedo at,
                                            mcv_albedo mean, float missing, mcv_lobes lobes) {
    const mcv_albedo weights = mcv_microfacet_weights(m, microfacets, at);
    const float below =
        weights.a / mcv_microfacet_weights(m, microfacets, mean).a * (1.0f - microfacets->metallic);
    const float brightest = mcv_brightest(microfacets->base);
    MCV_EACH_CHANNEL(i) {
        const float f = mcv_fma(microfacets->base.c[i], 1.0f - 1.0f / 21.0f, 1.0f / 21.0f);
        const float again = f * f * (1.0f - mean.a) / mcv_fma(-f, mean.a, 1.0f);
        lobes.more.c[i] = f * again;
        lobes.passing.c[i] =
            microfacets->base.c[i] * m->transmission * (1.0f - microfacets->metallic);
        lobes.near_a.c[i] = microfacets->base.c[i] * below * (1.0f - m->transmission) *
                            (1.0f - m->diffuse_transmission);
        lobes.far_a.c[i] =
            microfacets->base.c[i] * below * (1.0f - m->transmission) * m->diffuse_transmission;
        lobes.near_b.c[i] =
            m->multiple == MCV_NONE ? microfacets->metallic * again * missing : 0.0f;
        lobes.far_b.c[i] = lobes.passing.c[i] * missing;
    }
    /* By how much light they bring, of the brightest channel. */
    const float f0 = mcv_fma(microfacets->metallic, brightest - m->f0, m->f0);
    const float reflected = mcv_fma(f0, 1.0f - at.a - at.b, at.b);
    const float passed = brightest * m->transmission * (1.0f - microfacets->metallic);
    const float microfacet = mcv_fma(passed, weights.a - at.a, reflected);
    const float spread =
        brightest * weights.a * (1.0f - microfacets->metallic) * (1.0f - m->transmission);
    const float near =
        mcv_fma(spread, 1.0f - m->diffuse_transmission, microfacets->metallic * brightest * at.a);
    const float far = mcv_fma(spread, m->diffuse_transmission, passed * at.a);
    const float sum = microfacet + near + far;
    lobes.microfacet = microfacet / sum;
    lobes.near_chance = near / sum;
    lobes.far_chance = far / sum;
    return lobes;
}

MCV_LOOP_FUNCTION mcv_lobes mcv_microfacet_lobes(const mcv_device_glossy *m,
                                                 const mcv_microfacets *microfacets,
                                                 __global const float *albedos, mcv_vec3 o) {
    mcv_lobes lobes = mcv_no_lobes(mcv_ggx_lambda(microfacets->alpha, o));
    const mcv_albedo at = mcv_albedo_at(m, microfacets, albedos, o, 0);
#if MCV_WITH_ROUGH_GLASS
    if (microfacets->type == MCV_MATERIAL_DIELECTRIC)
        return mcv_glass_lobes(m, microfacets, albedos, o, at, lobes);
#endif
    const mcv_albedo mean = mcv_albedo_at(m, microfacets, albedos, o, 1);
    const float missing = mean.a > 0.0f ? at.a / mean.a : 0.0f;
    if (MCV_WITH_METAL && microfacets->type == MCV_MATERIAL_CONDUCTOR) {
        if (!mcv_has_multiple(m, microfacets)) lobes.near_b = mcv_dim(microfacets->base, missing);
        lobes.microfacet = 1.0f - at.a;
        lobes.near_chance = at.a;
        return lobes;
    }
    return mcv_layer_lobes(m, microfacets, at, mean, missing, lobes);
}

#endif
