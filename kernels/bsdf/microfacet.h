/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Glossy surfaces: microfacets that reflect (and, of dielectrics, refract), what light they pass on
 * to each other, and what lies below them. Everything is a mixture of a microfacet lobe and of
 * cosine lobes on both sides, evaluated and sampled by the same lines. Directions are unit vectors
 * in the frame of the surface; o, with o_z > 0, points to where the path comes from.
 */
#ifndef MCVISI_KERNELS_MICROFACET_H
#define MCVISI_KERNELS_MICROFACET_H

#include "bsdf/microfacet_lobes.h"

/* What a microfacet reflects at a cosine of incidence. */
MCV_LOOP_FUNCTION mcv_color mcv_microfacet_fresnel(const mcv_device_glossy *m,
                                                   const mcv_microfacets *microfacets,
                                                   float cosine) {
    mcv_color reflected;
    const float c = cosine < 1.0f ? cosine : 1.0f;
#if MCV_WITH_ROUGH_GLASS
    if (microfacets->type == MCV_MATERIAL_DIELECTRIC)
        return mcv_grey(mcv_interface_reflectance(microfacets->between, c,
                                                  mcv_refracted_cosine(microfacets->between, c)));
#endif
    if (MCV_WITH_METAL && microfacets->type == MCV_MATERIAL_CONDUCTOR) {
        MCV_EACH_CHANNEL(i)
        reflected.c[i] = mcv_conductor_fresnel(m->n[i] * microfacets->between.eta,
                                               m->k[i] * microfacets->between.eta, c);
        return reflected;
    }
    const float rise = mcv_schlick(c);
    MCV_EACH_CHANNEL(i) {
        const float f0 = mcv_fma(microfacets->metallic, microfacets->base.c[i] - m->f0, m->f0);
        reflected.c[i] = mcv_fma(1.0f - f0, rise, f0);
    }
    return reflected;
}

/* With which a microfacet is chosen to reflect rather than to pass; `passed` gets what it passes,
 * per channel. */
MCV_LOOP_FUNCTION float mcv_microfacet_reflects(const mcv_device_glossy *m,
                                                const mcv_microfacets *microfacets,
                                                const mcv_lobes *lobes, float cosine,
                                                mcv_color reflected, mcv_color *passed) {
    if (MCV_WITH_ROUGH_GLASS && microfacets->type == MCV_MATERIAL_DIELECTRIC) {
        *passed = mcv_grey(1.0f - reflected.c[0]);
        return reflected.c[0];
    }
    const float rise = mcv_schlick(cosine);
    *passed = mcv_dim(lobes->passing, (1.0f - m->f0) * (1.0f - rise));
    const float far = mcv_brightest(*passed);
    const float near = mcv_brightest(reflected);
    return far > 0.0f ? near / (near + far) : 1.0f;
}

/* The response of the microfacet lobe, and of the cosine lobe on the side of i. */
MCV_LOOP_FUNCTION mcv_response mcv_add_cosine_lobes(const mcv_device_glossy *m,
                                                    const mcv_microfacets *microfacets,
                                                    __global const float *albedos,
                                                    const mcv_lobes *lobes, mcv_vec3 i,
                                                    mcv_response response) {
    const int far = i.z < 0.0f, sees = i.z != 0.0f;
    mcv_albedo weights = {0.0f, 0.0f};
    if (microfacets->type == MCV_MATERIAL_METALLIC_ROUGHNESS ||
        !mcv_has_multiple(m, microfacets)) /* others have cosine lobes in their choices alone */
        weights =
            mcv_microfacet_weights(m, microfacets, mcv_albedo_at(m, microfacets, albedos, i, 0));
    const float diffuse = mcv_abs(i.z) * (1.0f / MCV_PI);
    MCV_EACH_CHANNEL(k) {
        const float a = far ? lobes->far_a.c[k] : lobes->near_a.c[k];
        const float b = far ? lobes->far_b.c[k] : lobes->near_b.c[k];
        const float value =
            mcv_fma(diffuse, mcv_fma(a, weights.a, b * weights.b), response.f_cos.c[k]);
        response.f_cos.c[k] = sees ? value : 0.0f;
    }
    const float density =
        mcv_fma(far ? lobes->far_chance : lobes->near_chance, diffuse, response.density);
    response.density = sees ? density : 0.0f;
    return response;
}

MCV_LOOP_FUNCTION mcv_response mcv_microfacet_respond(const mcv_device_glossy *m,
                                                      const mcv_microfacets *microfacets,
                                                      __global const float *albedos,
                                                      const mcv_lobes *lobes, mcv_vec3 o,
                                                      mcv_vec3 i) {
    mcv_response response;
    const int far = i.z < 0.0f, refracts = far & (microfacets->type == MCV_MATERIAL_DIELECTRIC),
              sees = i.z != 0.0f;
    response.media = 0;

    /* The microfacet normal that sends i to o, and d²h/d²i. */
    const mcv_vec3 mirrored = mcv_vec(i.x, i.y, mcv_abs(i.z));
    mcv_vec3 h = mcv_normalize(
        mcv_either(refracts, mcv_along(i, microfacets->between.eta, o), mcv_add(o, mirrored)));
    h = mcv_scale(h, (refracts & (h.z < 0.0f)) ? -1.0f : 1.0f);
    const float cosine = mcv_dot(o, h);
    const float behind = -mcv_dot(i, h);
    const float sum = mcv_fma(microfacets->between.eta, cosine, -behind);
    const float jacobian =
        refracts ? (behind > 0.0f ? behind / (sum * sum) : 0.0f) : 0.25f / cosine;
    const int meets = sees & (cosine > 0.0f) & (jacobian > 0.0f) & (jacobian < INFINITY);
    mcv_color passed;
    mcv_color reflected = mcv_microfacet_fresnel(m, microfacets, cosine);
    const float chance = mcv_microfacet_reflects(m, microfacets, lobes, cosine, reflected, &passed);
    const int multiplied = mcv_has_multiple(m, microfacets);
    mcv_color multiple = mcv_grey(0.0f);
    if (multiplied && (!far || refracts || microfacets->type == MCV_MATERIAL_CONDUCTOR))
        multiple = mcv_microfacet_multiple(m, microfacets, albedos, lobes->more, o, mirrored, far);
    MCV_EACH_CHANNEL(k) reflected.c[k] += multiple.c[k];
    const float facets = mcv_ggx_density(microfacets->alpha, h) * cosine * jacobian / o.z;
    const float lambda = mcv_ggx_lambda(microfacets->alpha, i);
    float seen = facets / (1.0f + lobes->lambda + lambda);
#if MCV_WITH_DIELECTRIC
    if (refracts) seen = facets * mcv_opposite_masking(lobes->lambda, lambda);
#endif
    MCV_EACH_CHANNEL(k)
    response.f_cos.c[k] = meets ? (far ? passed.c[k] : reflected.c[k]) * seen : 0.0f;
#if MCV_WITH_DIELECTRIC
    if (refracts) {
        const float wide = 1.0f / (o.z * (1.0f + lobes->lambda) * (1.0f + lambda));
        MCV_EACH_CHANNEL(k) response.f_cos.c[k] = mcv_fma(multiple.c[k], wide, response.f_cos.c[k]);
    }
#endif
    response.density =
        meets ? lobes->microfacet * (far ? 1.0f - chance : chance) * facets / (1.0f + lobes->lambda)
              : 0.0f;

    return mcv_add_cosine_lobes(m, microfacets, albedos, lobes, i, response);
}

/* A direction with the density that mcv_microfacet_respond gives; the zero vector where the path
 * ends.
 */
MCV_LOOP_FUNCTION mcv_vec3 mcv_microfacet_sample(const mcv_device_glossy *m,
                                                 const mcv_microfacets *microfacets,
                                                 const mcv_lobes *lobes, mcv_vec3 o, float xi,
                                                 float eta, float choice) {
    const mcv_vec3 spread = mcv_sample_cosine(xi, eta);
    const int diffuse = choice >= lobes->microfacet,
              near = choice - lobes->microfacet < lobes->near_chance;
    const mcv_vec3 h = mcv_ggx_sample(microfacets->alpha, o, xi, eta);
    const float cosine = mcv_dot(o, h);
    mcv_color passed;
    const float share = mcv_microfacet_reflects(
        m, microfacets, lobes, cosine, mcv_microfacet_fresnel(m, microfacets, cosine), &passed);
    const int passes =
        microfacets->type == MCV_MATERIAL_DIELECTRIC || mcv_brightest(lobes->passing) > 0.0f;
    const int reflects = choice < lobes->microfacet * (passes ? share : 1.0f);
    mcv_vec3 i = mcv_normalize(mcv_along(mcv_scale(o, -1.0f), 2.0f * cosine, h));
    int goes_on = i.z > 0.0f;
    i.z = reflects ? i.z : -i.z;
    if (MCV_WITH_ROUGH_GLASS && microfacets->type == MCV_MATERIAL_DIELECTRIC) {
        const float c1 = cosine < 1.0f ? cosine : 1.0f;
        const float c2 = mcv_refracted_cosine(microfacets->between, c1);
        const mcv_vec3 refracted =
            mcv_refract(microfacets->between, mcv_scale(o, -1.0f), h, c1, c2);
        goes_on = reflects ? goes_on : (c2 > 0.0f) & (refracted.z < 0.0f);
        i = mcv_either(reflects, i, refracted);
    }
    i = mcv_either(diffuse, mcv_vec(spread.x, spread.y, near ? spread.z : -spread.z), i);
    return mcv_either(diffuse | goes_on, i, mcv_vec(0.0f, 0.0f, 0.0f));
}

#endif
