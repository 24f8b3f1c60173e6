/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Glossy surfaces: microfacets that reflect (and, of dielectrics, refract), what light they pass on
 * to each other, and what lies below them. Everything is a mixture of a specular lobe and of cosine
 * lobes on both sides, evaluated and sampled by the same lines. Directions are unit vectors in the
 * frame of the surface; o, with o_z > 0, points to where the path comes from.
 */
#ifndef MCVISI_KERNELS_MICROFACET_H
#define MCVISI_KERNELS_MICROFACET_H

#include "mcvisi/materials/microfacet.h"
#include "world.h"

/* A glossy surface at a place. */
typedef struct mcv_gloss {
    uint type; /* MCV_MATERIAL_… */
    mcv_alpha alpha;
    mcv_color
        base; /* metallic-roughness: base colour; conductor: what multiple reflection leaves */
    float metallic;
    float layer;                  /* place among the table's roughnesses */
    uint table;                   /* in the albedos */
    uint inside;                  /* dielectric: 1: the ray is in the body */
    mcv_device_interface between; /* dielectric: from the ray's side to the other; conductor: eta is
                                     1/n of the medium before it */
} mcv_gloss;

typedef struct mcv_albedo {
    float a, b;
} mcv_albedo;

/* Rows of azimuth and cosine for one roughness. */
MCV_LOOP_FUNCTION mcv_albedo mcv_albedo_row(__global const float *rows, uint azimuths, mcv_vec3 w) {
    const float x = mcv_sqrt(mcv_abs(w.z)) * (float)(MCV_ALBEDO_COSINES - 1);
    const uint column = min((uint)x, (uint)(MCV_ALBEDO_COSINES - 2));
    const float f = x - (float)column;
    float g = 0.0f;
    uint row = 0;
    if (azimuths > 1) {
        const float sum = mcv_abs(w.x) + mcv_abs(w.y);
        const float y = (sum > 0.0f ? mcv_abs(w.x) / sum : 0.0f) * (float)(azimuths - 1);
        row = min((uint)y, azimuths - 2);
        g = y - (float)row;
    }
    mcv_albedo albedo = {0.0f, 0.0f};
#pragma unroll
    for (uint k = 0; k < 4; ++k) {
        if (k > 1 && azimuths == 1) break;
        const float weight = (k & 1 ? f : 1.0f - f) * (k & 2 ? g : 1.0f - g);
        __global const float *entry =
            rows + 2 * ((row + (k >> 1)) * MCV_ALBEDO_COSINES + column + (k & 1));
        albedo.a = mcv_fma(weight, entry[0], albedo.a);
        albedo.b = mcv_fma(weight, entry[1], albedo.b);
    }
    return albedo;
}

/* The table's entries for a direction, or with `mean` their means over the hemisphere. */
MCV_LOOP_FUNCTION mcv_albedo mcv_albedo_at(const mcv_device_gloss *m, const mcv_gloss *gloss,
                                           __global const float *albedos, mcv_vec3 w, int mean) {
    const uint size = 2 + 2 * m->azimuths * MCV_ALBEDO_COSINES;
    const uint layer = m->roughnesses > 1 ? min((uint)gloss->layer, m->roughnesses - 2) : 0;
    const float f = gloss->layer - (float)layer;
    __global const float *at =
        albedos + (gloss->table == MCV_NONE ? 0u : gloss->table) + layer * size;
    mcv_albedo low, high;
    low.a = at[0];
    low.b = at[1];
    if (!mean) low = mcv_albedo_row(at + 2, m->azimuths, w);
    if (m->roughnesses == 1) return low;
    high.a = at[size];
    high.b = at[size + 1];
    if (!mean) high = mcv_albedo_row(at + size + 2, m->azimuths, w);
    low.a = mcv_fma(f, high.a - low.a, low.a);
    low.b = mcv_fma(f, high.b - low.b, low.b);
    return low;
}

/* The row of a table of multiple scattering for a cosine, with how far it is to the next. */
MCV_LOOP_FUNCTION float mcv_multiple_row(float z, uint cosines) {
    const float c = mcv_abs(z) < 1.0f ? mcv_abs(z) : 1.0f;
    const float root = mcv_sqrt(c);
    return root / (root + mcv_sqrt(1.0f - c)) * (float)(cosines - 1);
}

/* Where a table of multiple scattering is read: entries of azimuths, and what each of three corners
 * counts. */
typedef struct mcv_multiple_place {
    uint first, edge,
        across; /* the near corner, words from it to the one beyond an edge and to the far one */
    float near, middle, far;
    float turn; /* to the next azimuth */
} mcv_multiple_place;

/*
 * In rows and columns by the triangles that the diagonal divides a cell into: light that comes and
 * leaves at like angles is special. Both directions are given as if they lay above.
 */
MCV_LOOP_FUNCTION mcv_multiple_place mcv_find_multiple(uint cosines, mcv_vec3 o, mcv_vec3 i) {
    const float x = mcv_multiple_row(o.z, cosines);
    const float y = mcv_multiple_row(i.z, cosines);
    const float o_sine = mcv_sqrt(mcv_fma(o.x, o.x, o.y * o.y));
    const float i_sine = mcv_sqrt(mcv_fma(i.x, i.x, i.y * i.y));
    const float o_scale = o_sine > 0.0f ? 0.5f / o_sine : 0.0f;
    const float i_scale = i_sine > 0.0f ? 0.5f / i_sine : 0.0f;
    const float across = mcv_fma(o.x, o_scale, i.x * i_scale);
    const float up = mcv_fma(o.y, o_scale, i.y * i_scale);
    const float length = mcv_sqrt(mcv_fma(across, across, up * up)); /* |cos φ/2|, to a rounding */
    const float half_turn = length < 1.0f ? length : 1.0f;
    const float sum = o.z + i.z + MCV_MULTIPLE_LEAST;
    const float z =
        half_turn * (1.0f + sum) / (half_turn + sum) * (float)(MCV_MULTIPLE_AZIMUTHS - 1);
    const uint row = min((uint)x, cosines - 2);
    const uint column = min((uint)y, cosines - 2);
    const uint entry = min((uint)z, (uint)(MCV_MULTIPLE_AZIMUTHS - 2));
    const float f = x - (float)row;
    const float g = y - (float)column;
    const float both = f < g ? f : g;
    const float either = f < g ? g : f;
    const uint step = MCV_MULTIPLE_WORDS * MCV_MULTIPLE_AZIMUTHS;
    mcv_multiple_place place;
    place.first = MCV_MULTIPLE_WORDS * ((row * cosines + column) * MCV_MULTIPLE_AZIMUTHS + entry);
    place.edge = step * (f > g ? cosines : 1u);
    place.across = step * (cosines + 1u);
    place.near = 1.0f - either;
    place.middle = either - both;
    place.far = both;
    place.turn = z - (float)entry;
    return place;
}

/* A word there. */
MCV_LOOP_FUNCTION float mcv_multiple_word(__global const float *table, mcv_multiple_place place) {
    __global const float *at = table + place.first;
    const float near = mcv_fma(place.turn, at[MCV_MULTIPLE_WORDS] - at[0], at[0]);
    at += place.edge;
    const float middle = mcv_fma(place.turn, at[MCV_MULTIPLE_WORDS] - at[0], at[0]);
    at += place.across - place.edge;
    const float far = mcv_fma(place.turn, at[MCV_MULTIPLE_WORDS] - at[0], at[0]);
    return mcv_fma(place.far, far, mcv_fma(place.middle, middle, place.near * near));
}

/* A word of a metal at its roughness. */
MCV_LOOP_FUNCTION float mcv_metal_word(const mcv_device_gloss *m, float layer,
                                       __global const float *table, mcv_multiple_place place) {
    if (m->roughnesses == 1) return mcv_multiple_word(table, place);
    const uint size =
        MCV_MULTIPLE_WORDS * MCV_MULTIPLE_COSINES * MCV_MULTIPLE_COSINES * MCV_MULTIPLE_AZIMUTHS;
    const float at =
        layer * ((float)(MCV_MULTIPLE_ROUGHNESSES - 1) / (float)(MCV_ALBEDO_ROUGHNESSES - 1));
    const uint low = min((uint)at, (uint)(MCV_MULTIPLE_ROUGHNESSES - 2));
    const float below = mcv_multiple_word(table + low * size, place);
    const float above = mcv_multiple_word(table + (low + 1) * size, place);
    return mcv_fma(at - (float)low, above - below, below);
}

/*
 * What leaves towards i after two and more meetings with microfacets: on o's side over what white
 * ones send there by one, on the other (far) over 1/(o_z (1 + Λ(o)) (1 + Λ(i))). Both directions
 * are given as if they lay above. The table of an interface lies behind its albedos.
 */
MCV_LOOP_FUNCTION mcv_color mcv_gloss_multiple(const mcv_device_gloss *m, const mcv_gloss *gloss,
                                               __global const float *tables, mcv_color more,
                                               mcv_vec3 o, mcv_vec3 i, int far) {
    mcv_color multiple;
    (void)far;
#if MCV_WITH_DIELECTRIC
    if (gloss->type == MCV_MATERIAL_DIELECTRIC) {
        const uint words = gloss->inside + (far ? 2u : 0u) + 2u + 2u * MCV_ALBEDO_COSINES;
        const uint known =
            gloss->table != MCV_NONE; /* else it is smooth, and what is read does not count */
        mcv_multiple_place place = mcv_find_multiple(MCV_INTERFACE_COSINES, o, i);
        place.first = known * (gloss->table + words + place.first);
        place.edge *= known;
        place.across *= known;
        return mcv_grey(mcv_multiple_word(tables, place));
    }
#endif
    const mcv_multiple_place place = mcv_find_multiple(MCV_MULTIPLE_COSINES, o, i);
    __global const float *table = tables + m->multiple;
    if (gloss->type == MCV_MATERIAL_CONDUCTOR) {
        MCV_EACH_CHANNEL(c) multiple.c[c] = mcv_metal_word(m, gloss->layer, table + c, place);
        return multiple;
    }
    const float square = mcv_metal_word(m, gloss->layer, table, place);
    const float linear = mcv_metal_word(m, gloss->layer, table + 1, place);
    const float least = mcv_metal_word(m, gloss->layer, table + 2, place);
    const float rest = mcv_metal_word(m, gloss->layer, table + 3, place);
    MCV_EACH_CHANNEL(c) {
        const float b = gloss->base.c[c];
        multiple.c[c] = gloss->metallic *
                        mcv_fma(more.c[c], rest, mcv_fma(b, mcv_fma(b, square, linear), least));
    }
    return multiple;
}

/* Is there a table of multiple scattering? Metal and glass without a direction have one, which is
 * known beforehand of plain surfaces. */
MCV_LOOP_FUNCTION int mcv_has_multiple(const mcv_device_gloss *m, const mcv_gloss *gloss) {
    return gloss->type == MCV_MATERIAL_METALLIC_ROUGHNESS ? m->multiple != MCV_NONE
                                                          : m->azimuths == 1;
}

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
#if MCV_WITH_DIELECTRIC
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
    if (gloss->type == MCV_MATERIAL_CONDUCTOR) {
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
#if MCV_WITH_DIELECTRIC
    if (gloss->type == MCV_MATERIAL_DIELECTRIC)
        return mcv_grey(
            mcv_interface_reflectance(gloss->between, c, mcv_refracted_cosine(gloss->between, c)));
#endif
    if (gloss->type == MCV_MATERIAL_CONDUCTOR) {
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
    if (gloss->type == MCV_MATERIAL_DIELECTRIC) {
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
    if (gloss->type == MCV_MATERIAL_DIELECTRIC) {
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
