/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Glossy surfaces: microfacets that reflect (and, of dielectrics, refract), what light they pass on
 * to each other, and what lies below them. Everything is a mixture of a specular lobe and of cosine
 * lobes on both sides, evaluated and sampled by the same lines. Directions are unit vectors in the
 * frame of the surface; o, with o_z > 0, points to where the path comes from.
 */
#ifndef MCVISI_KERNELS_MICROFACET_H
#define MCVISI_KERNELS_MICROFACET_H

#include "bsdf/microfacet_tables.h"

/* The lobes of a surface seen from o. */
typedef struct mcv_lobes {
    float lambda;   /* Λ(o) */
    mcv_color more; /* metallic-roughness: three and more reflections, as a share of those of white
                       microfacets */
    mcv_color passing;           /* factor of what passes a thin wall */
    mcv_color near_a, near_b;    /* cosine lobes on the ray's side: near_a a(i) + near_b b(i) … */
    mcv_color far_a, far_b;      /* … and on the other */
    float specular, near_chance; /* with which the lobes are chosen; else the far one */
    float far_chance;
} mcv_lobes;

/* What a(i) and b(i) are: of a metallic-roughness surface what the layer passes, and what its
 * microfacets send on to each other. */
MCV_LOOP_FUNCTION mcv_albedo mcv_gloss_weights(const mcv_device_gloss *m, const mcv_gloss *gloss,
                                               mcv_albedo albedo) {
    mcv_albedo weights;
    weights.a = 1.0f - mcv_fma(m->f0, 1.0f - albedo.a - albedo.b, albedo.b);
    weights.b = albedo.a;
    if (gloss->type == MCV_MATERIAL_DIELECTRIC) return albedo;
    return weights;
}

MCV_LOOP_FUNCTION mcv_lobes mcv_gloss_lobes(const mcv_device_gloss *m, const mcv_gloss *gloss,
                                            __global const float *albedos, mcv_vec3 o) {
    mcv_lobes lobes;
    const mcv_albedo at = mcv_albedo_at(m, gloss, albedos, o, 0);
    lobes.lambda = mcv_ggx_lambda(gloss->alpha, o);
    lobes.passing = lobes.more = mcv_grey(0.0f);
    lobes.near_a = lobes.near_b = lobes.far_a = lobes.far_b = mcv_grey(0.0f);
    lobes.far_chance = 0.0f;
#if MCV_WITH_ROUGH_GLASS
    if (gloss->type == MCV_MATERIAL_DIELECTRIC) {
        /* a: what is missing outside the body, b: inside. */
        const float missing = gloss->inside ? at.b : at.a;
        const float square = gloss->between.eta * gloss->between.eta;
        if (mcv_has_multiple(
                m, gloss)) { /* the table has it; cosines choose directions, by n² of either side */
            lobes.far_chance = missing / (1.0f + square);
            lobes.near_chance = missing - lobes.far_chance;
            lobes.specular = 1.0f - missing;
            return lobes;
        }
        /* Light in the medium s leaves into t with the share n_t² M_t/X, by X = Σ n² M. */
        const mcv_albedo mean = mcv_albedo_at(m, gloss, albedos, o, 1);
        const float near_mean = gloss->inside ? mean.b : mean.a;
        const float far_mean = gloss->inside ? mean.a : mean.b;
        const float near = square * near_mean;
        const float sum = near + far_mean;
        const float share = near > 0.0f ? missing / sum : 0.0f;
        lobes.near_chance = near > 0.0f ? missing * near / sum : 0.0f;
        lobes.far_chance = near > 0.0f ? missing - lobes.near_chance : 0.0f;
        lobes.specular = 1.0f - lobes.near_chance - lobes.far_chance;
        MCV_EACH_CHANNEL(k) {
            lobes.near_a.c[k] = gloss->inside ? 0.0f : share * square;
            lobes.near_b.c[k] = gloss->inside ? share * square : 0.0f;
            lobes.far_a.c[k] = gloss->inside ? share : 0.0f;
            lobes.far_b.c[k] = gloss->inside ? 0.0f : share;
        }
        return lobes;
    }
#endif
    const mcv_albedo mean = mcv_albedo_at(m, gloss, albedos, o, 1);
    const float missing = mean.a > 0.0f ? at.a / mean.a : 0.0f;
    if (MCV_WITH_METAL && gloss->type == MCV_MATERIAL_CONDUCTOR) {
        if (!mcv_has_multiple(m, gloss)) lobes.near_b = mcv_dim(gloss->base, missing);
        lobes.specular = 1.0f - at.a;
        lobes.near_chance = at.a;
        return lobes;
    }
    const mcv_albedo weights = mcv_gloss_weights(m, gloss, at);
    const float below = weights.a / mcv_gloss_weights(m, gloss, mean).a * (1.0f - gloss->metallic);
    const float brightest = mcv_brightest(gloss->base);
    MCV_EACH_CHANNEL(i) {
        const float f = mcv_fma(gloss->base.c[i], 1.0f - 1.0f / 21.0f, 1.0f / 21.0f);
        const float again = f * f * (1.0f - mean.a) / mcv_fma(-f, mean.a, 1.0f);
        lobes.more.c[i] = f * again;
        lobes.passing.c[i] = gloss->base.c[i] * m->transmission * (1.0f - gloss->metallic);
        lobes.near_a.c[i] =
            gloss->base.c[i] * below * (1.0f - m->transmission) * (1.0f - m->diffuse_transmission);
        lobes.far_a.c[i] =
            gloss->base.c[i] * below * (1.0f - m->transmission) * m->diffuse_transmission;
        lobes.near_b.c[i] = m->multiple == MCV_NONE ? gloss->metallic * again * missing : 0.0f;
        lobes.far_b.c[i] = lobes.passing.c[i] * missing;
    }
    /* By how much light they bring, of the brightest channel. */
    const float f0 = mcv_fma(gloss->metallic, brightest - m->f0, m->f0);
    const float reflected = mcv_fma(f0, 1.0f - at.a - at.b, at.b);
    const float passed = brightest * m->transmission * (1.0f - gloss->metallic);
    const float specular = mcv_fma(passed, weights.a - at.a, reflected);
    const float spread =
        brightest * weights.a * (1.0f - gloss->metallic) * (1.0f - m->transmission);
    const float near =
        mcv_fma(spread, 1.0f - m->diffuse_transmission, gloss->metallic * brightest * at.a);
    const float far = mcv_fma(spread, m->diffuse_transmission, passed * at.a);
    const float sum = specular + near + far;
    lobes.specular = specular / sum;
    lobes.near_chance = near / sum;
    lobes.far_chance = far / sum;
    return lobes;
}

/* What a microfacet reflects at a cosine of incidence. */
MCV_LOOP_FUNCTION mcv_color mcv_gloss_fresnel(const mcv_device_gloss *m, const mcv_gloss *gloss,
                                              float cosine) {
    mcv_color reflected;
    const float c = cosine < 1.0f ? cosine : 1.0f;
#if MCV_WITH_ROUGH_GLASS
    if (gloss->type == MCV_MATERIAL_DIELECTRIC)
        return mcv_grey(
            mcv_interface_reflectance(gloss->between, c, mcv_refracted_cosine(gloss->between, c)));
#endif
    if (MCV_WITH_METAL && gloss->type == MCV_MATERIAL_CONDUCTOR) {
        MCV_EACH_CHANNEL(i)
        reflected.c[i] =
            mcv_conductor_fresnel(m->n[i] * gloss->between.eta, m->k[i] * gloss->between.eta, c);
        return reflected;
    }
    const float rise = mcv_schlick(c);
    MCV_EACH_CHANNEL(i) {
        const float f0 = mcv_fma(gloss->metallic, gloss->base.c[i] - m->f0, m->f0);
        reflected.c[i] = mcv_fma(1.0f - f0, rise, f0);
    }
    return reflected;
}

/* With which a microfacet is chosen to reflect rather than to pass; `passed` gets what it passes,
 * per channel. */
MCV_LOOP_FUNCTION float mcv_gloss_reflects(const mcv_device_gloss *m, const mcv_gloss *gloss,
                                           const mcv_lobes *lobes, float cosine,
                                           mcv_color reflected, mcv_color *passed) {
    if (MCV_WITH_ROUGH_GLASS && gloss->type == MCV_MATERIAL_DIELECTRIC) {
        *passed = mcv_grey(1.0f - reflected.c[0]);
        return reflected.c[0];
    }
    const float rise = mcv_schlick(cosine);
    *passed = mcv_dim(lobes->passing, (1.0f - m->f0) * (1.0f - rise));
    const float far = mcv_brightest(*passed);
    const float near = mcv_brightest(reflected);
    return far > 0.0f ? near / (near + far) : 1.0f;
}

MCV_LOOP_FUNCTION mcv_response mcv_gloss_respond(const mcv_device_gloss *m, const mcv_gloss *gloss,
                                                 __global const float *albedos,
                                                 const mcv_lobes *lobes, mcv_vec3 o, mcv_vec3 i) {
    mcv_response response;
    const int far = i.z < 0.0f, refracts = far & (gloss->type == MCV_MATERIAL_DIELECTRIC),
              sees = i.z != 0.0f;
    response.media = 0;

    /* The microfacet normal that sends i to o, and d²h/d²i. */
    const mcv_vec3 mirrored = mcv_vec(i.x, i.y, mcv_abs(i.z));
    mcv_vec3 h = mcv_normalize(
        mcv_choose(refracts, mcv_along(i, gloss->between.eta, o), mcv_add(o, mirrored)));
    h = mcv_scale(h, (refracts & (h.z < 0.0f)) ? -1.0f : 1.0f);
    const float cosine = mcv_dot(o, h);
    const float behind = -mcv_dot(i, h);
    const float sum = mcv_fma(gloss->between.eta, cosine, -behind);
    const float jacobian =
        refracts ? (behind > 0.0f ? behind / (sum * sum) : 0.0f) : 0.25f / cosine;
    const int meets = sees & (cosine > 0.0f) & (jacobian > 0.0f) & (jacobian < INFINITY);
    mcv_color passed;
    mcv_color reflected = mcv_gloss_fresnel(m, gloss, cosine);
    const float chance = mcv_gloss_reflects(m, gloss, lobes, cosine, reflected, &passed);
    const int multiplied = mcv_has_multiple(m, gloss);
    mcv_color multiple = mcv_grey(0.0f);
    if (multiplied && (!far || refracts || gloss->type == MCV_MATERIAL_CONDUCTOR))
        multiple = mcv_gloss_multiple(m, gloss, albedos, lobes->more, o, mirrored, far);
    MCV_EACH_CHANNEL(k) reflected.c[k] += multiple.c[k];
    const float facets = mcv_ggx_density(gloss->alpha, h) * cosine * jacobian / o.z;
    const float lambda = mcv_ggx_lambda(gloss->alpha, i);
    float seen = facets / (1.0f + lobes->lambda + lambda);
#if MCV_WITH_DIELECTRIC
    if (refracts) seen = facets * mcv_opposite_masking(lobes->lambda, lambda);
#endif
    MCV_EACH_CHANNEL(k)
    response.value.c[k] = meets ? (far ? passed.c[k] : reflected.c[k]) * seen : 0.0f;
#if MCV_WITH_DIELECTRIC
    if (refracts) {
        const float wide = 1.0f / (o.z * (1.0f + lobes->lambda) * (1.0f + lambda));
        MCV_EACH_CHANNEL(k) response.value.c[k] = mcv_fma(multiple.c[k], wide, response.value.c[k]);
    }
#endif
    response.density =
        meets ? lobes->specular * (far ? 1.0f - chance : chance) * facets / (1.0f + lobes->lambda)
              : 0.0f;

    mcv_albedo weights = {0.0f, 0.0f};
    if (gloss->type == MCV_MATERIAL_METALLIC_ROUGHNESS ||
        !multiplied) /* others have cosine lobes in their choices alone */
        weights = mcv_gloss_weights(m, gloss, mcv_albedo_at(m, gloss, albedos, i, 0));
    const float diffuse = mirrored.z * (1.0f / MCV_PI);
    MCV_EACH_CHANNEL(k) {
        const float a = far ? lobes->far_a.c[k] : lobes->near_a.c[k];
        const float b = far ? lobes->far_b.c[k] : lobes->near_b.c[k];
        const float value =
            mcv_fma(diffuse, mcv_fma(a, weights.a, b * weights.b), response.value.c[k]);
        response.value.c[k] = sees ? value : 0.0f;
    }
    const float density =
        mcv_fma(far ? lobes->far_chance : lobes->near_chance, diffuse, response.density);
    response.density = sees ? density : 0.0f;
    return response;
}

/* A direction with the density that mcv_gloss_respond gives; the zero vector where the path ends.
 */
MCV_LOOP_FUNCTION mcv_vec3 mcv_gloss_sample(const mcv_device_gloss *m, const mcv_gloss *gloss,
                                            const mcv_lobes *lobes, mcv_vec3 o, float xi, float eta,
                                            float choice) {
    const mcv_vec3 spread = mcv_sample_cosine(xi, eta);
    const int diffuse = choice >= lobes->specular,
              near = choice - lobes->specular < lobes->near_chance;
    const mcv_vec3 h = mcv_ggx_sample(gloss->alpha, o, xi, eta);
    const float cosine = mcv_dot(o, h);
    mcv_color passed;
    const float share =
        mcv_gloss_reflects(m, gloss, lobes, cosine, mcv_gloss_fresnel(m, gloss, cosine), &passed);
    const int passes =
        gloss->type == MCV_MATERIAL_DIELECTRIC || mcv_brightest(lobes->passing) > 0.0f;
    const int reflects = choice < lobes->specular * (passes ? share : 1.0f);
    mcv_vec3 i = mcv_normalize(mcv_along(mcv_scale(o, -1.0f), 2.0f * cosine, h));
    int goes_on = i.z > 0.0f;
    i.z = reflects ? i.z : -i.z;
    if (MCV_WITH_ROUGH_GLASS && gloss->type == MCV_MATERIAL_DIELECTRIC) {
        const float c1 = cosine < 1.0f ? cosine : 1.0f;
        const float c2 = mcv_refracted_cosine(gloss->between, c1);
        const mcv_vec3 refracted = mcv_refract(gloss->between, mcv_scale(o, -1.0f), h, c1, c2);
        goes_on = reflects ? goes_on : (c2 > 0.0f) & (refracted.z < 0.0f);
        i = mcv_choose(reflects, i, refracted);
    }
    i = mcv_choose(diffuse, mcv_vec(spread.x, spread.y, near ? spread.z : -spread.z), i);
    return mcv_choose(diffuse | goes_on, i, mcv_vec(0.0f, 0.0f, 0.0f));
}

#endif
