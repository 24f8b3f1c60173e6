/* SPDX-License-Identifier: Apache-2.0 */
#include "reference/gloss.h"

#include "reference/gloss_microfacet.h"
#include "reference/gloss_tables.h"

/* The shares of light that a surface seen from o sends along its kinds of lobes; each adds up to
 * the surface's albedo. */
typedef struct lobes {
    double alpha[2];
    double chance[3];             /* of microfacets, of the near and the far hemisphere */
    double thin[3];               /* factor of light that passes the layer straight */
    double near[2][3], far[2][3]; /* factors of the two functions of i in `weigh` */
    double more[3]; /* a metal's three and more reflections, over those of white microfacets */
} lobes;

static double largest(const double a[3]) { return fmax(a[0], fmax(a[1], a[2])); }

static double layer_f0(const ref_gloss *g) {
    const double n = g->material->as.metallic_roughness.ior;
    return (n - 1) / (n + 1) * (n - 1) / (n + 1);
}

/* The functions of a direction that cosine lobes are multiplied with, and how the layer's albedo
 * goes with F0. */
static void weigh(const ref_gloss *g, const double pair[2], double weights[2]) {
    if (g->material->type == MCV_MATERIAL_DIELECTRIC) {
        weights[0] = 1 - pair[g->inside];
        weights[1] = 1 - pair[!g->inside];
        return;
    }
    const double f0 = g->material->type == MCV_MATERIAL_METALLIC_ROUGHNESS ? layer_f0(g) : 0;
    weights[0] = 1 - (f0 * pair[0] + (1 - f0) * pair[1]);
    weights[1] = 1 - pair[0];
}

static lobes lobes_at(const ref_gloss *g, ref_vec o) {
    lobes l = {0};
    double pair[2], mean[2], own[2], average[2];
    const mcv_roughness roughness = mcv_material_roughness(g->material);
    ref_alphas(&roughness, g->roughness, l.alpha);
    ref_albedos_at(&g->table->albedos, o, g->roughness, pair);
    ref_albedos_mean(&g->table->albedos, g->roughness, mean);
    weigh(g, pair, own);
    weigh(g, mean, average);
    if (g->material->type == MCV_MATERIAL_DIELECTRIC) {
        const bool apart = g->table->orders; /* cosines but choose directions */
        const double near = g->from * g->from * (apart ? 1 : average[0]),
                     far = g->to * g->to * (apart ? 1 : average[1]);
        l.chance[1] = near > 0 ? own[0] * near / (near + far) : 0;
        l.chance[2] = near > 0 ? own[0] * far / (near + far) : 0;
        l.chance[0] = 1 - l.chance[1] - l.chance[2];
        for (int c = 0; c < 3 && !apart && near > 0; ++c) {
            l.near[0][c] = own[0] * g->from * g->from / (near + far);
            l.far[1][c] = own[0] * g->to * g->to / (near + far);
        }
        return l;
    }
    const double missing = own[1] / average[1];
    if (g->material->type == MCV_MATERIAL_CONDUCTOR) {
        for (int c = 0; c < 3; ++c)
            l.near[1][c] = g->table->orders ? 0 : missing * g->table->multiple[c];
        l.chance[0] = pair[0];
        l.chance[1] = 1 - pair[0];
        return l;
    }
    const mcv_metallic_roughness_params *p = &g->material->as.metallic_roughness;
    const double plain = 1 - g->metallic, below = own[0] / average[0], bright = largest(g->base),
                 f0 = layer_f0(g);
    for (int c = 0; c < 3; ++c) {
        const double schlick_mean = g->base[c] + (1 - g->base[c]) / 21;
        l.thin[c] = plain * p->transmission * g->base[c];
        l.near[0][c] =
            plain * (1 - p->transmission) * (1 - p->diffuseTransmission) * g->base[c] * below;
        l.far[0][c] = plain * (1 - p->transmission) * p->diffuseTransmission * g->base[c] * below;
        const double twice =
            schlick_mean * schlick_mean * mean[0] / (1 - schlick_mean * (1 - mean[0]));
        l.near[1][c] = g->table->orders ? 0 : g->metallic * twice * missing;
        l.more[c] = schlick_mean * twice;
        l.far[1][c] = l.thin[c] * missing;
    }
    const double specular = f0 + g->metallic * (bright - f0),
                 passed = plain * p->transmission * bright;
    const double diffuse = plain * (1 - p->transmission) * bright * own[0];
    l.chance[0] = specular * pair[0] + (1 - specular) * pair[1] + passed * (own[0] - own[1]);
    l.chance[1] = diffuse * (1 - p->diffuseTransmission) + g->metallic * bright * own[1];
    l.chance[2] = diffuse * p->diffuseTransmission + passed * own[1];
    const double all = l.chance[0] + l.chance[1] + l.chance[2];
    for (int k = 0; k < 3; ++k) l.chance[k] /= all;
    return l;
}

/* What a microfacet reflects and lets pass; returns the chance with which it is taken to reflect.
 */
static double split(const ref_gloss *g, const lobes *l, double cosine, double reflects[3],
                    double passes[3]) {
    for (int c = 0; c < 3; ++c) {
        passes[c] = 0;
        if (g->material->type == MCV_MATERIAL_DIELECTRIC) {
            const double coating = mcv_material_coating(g->material, g->inside ? g->to : g->from);
            reflects[c] =
                ref_coated(ref_unpolarised(g->from, g->to, cosine), coating, g->from, g->to);
            passes[c] = 1 - reflects[c];
        } else if (g->material->type == MCV_MATERIAL_CONDUCTOR) {
            reflects[c] = ref_conductor_reflectance(g->material->as.conductor.n[c] / g->from,
                                                    g->material->as.conductor.k[c] / g->from,
                                                    fmin(cosine, 1));
        } else {
            const double rise = pow(1 - fmin(cosine, 1), 5), f0 = layer_f0(g),
                         mixed = f0 + g->metallic * (g->base[c] - f0);
            reflects[c] = mixed + (1 - mixed) * rise;
            passes[c] = l->thin[c] * (1 - f0 - (1 - f0) * rise);
        }
    }
    const double near = largest(reflects), far = largest(passes);
    return far > 0 ? near / (near + far) : 1;
}

double ref_gloss_evaluate(const ref_gloss *g, ref_vec o, ref_vec i, double value[3]) {
    const lobes l = lobes_at(g, o);
    const bool glass = g->material->type == MCV_MATERIAL_DIELECTRIC, far = i.z < 0,
               bends = far && glass;
    double density = 0;
    value[0] = value[1] = value[2] = 0;
    if (i.z == 0) return 0;

    ref_vec h = bends ? ref_add(ref_scale(g->from, o), ref_scale(g->to, i))
                      : ref_add(o, (ref_vec){i.x, i.y, fabs(i.z)});
    if (bends && h.z < 0) h = ref_scale(-1, h);
    const double length = ref_length(h);
    h = ref_scale(1 / length, h);
    const double c = ref_dot(o, h), behind = -ref_dot(i, h);
    if (h.z > 0 && c > 0 && (!bends || behind > 0)) {
        /* dh/di: of the reflection 1/4c, of the refraction n_t² |i·h| over the squared length of
         * n_s o + n_t i. */
        const double jacobian = bends ? g->to * g->to * behind / (length * length) : 1 / (4 * c);
        double reflects[3], passes[3];
        const double chance = split(g, &l, c, reflects, passes);
        const double facets = ref_ggx(l.alpha, h) * c / o.z * jacobian,
                     own = ref_lambda(l.alpha, o);
        double words[MCV_MULTIPLE_WORDS] = {0};
        const double layer =
            g->table->albedos.roughnesses > 1 ? g->roughness * (MCV_MULTIPLE_ROUGHNESSES - 1) : 0;
        if (g->table->orders && !far && l.alpha[0] != l.alpha[1])
            ref_brushed_at(g->table->orders, l.alpha, layer, o, i, words);
        else if (g->table->orders && !far)
            ref_orders_at(g->table->orders, glass, layer, o, i, words);
        for (int channel = 0; g->table->orders && !far && channel < 3; ++channel) {
            const double b = g->base[channel];
            reflects[channel] += glass ? words[g->inside]
                                 : g->material->type == MCV_MATERIAL_CONDUCTOR
                                     ? words[channel]
                                     : g->metallic * (b * b * words[0] + b * words[1] + words[2] +
                                                      l.more[channel] * words[3]);
        }
        for (int channel = 0; channel < 3; ++channel)
            value[channel] = (far ? passes : reflects)[channel] * facets *
                             ref_masking(own, ref_lambda(l.alpha, i), bends);
        density = l.chance[0] * (far ? 1 - chance : chance) * facets / (1 + own);
    }

    if (bends && g->table->orders) { /* what goes on from facet to facet and leaves here */
        double words[MCV_MULTIPLE_WORDS];
        ref_orders_at(g->table->orders, true, 0, o, i, words);
        const double wide = words[2 + g->inside] /
                            (o.z * (1 + ref_lambda(l.alpha, o)) * (1 + ref_lambda(l.alpha, i)));
        for (int channel = 0; channel < 3; ++channel) value[channel] += wide;
    }
    double pair[2], weights[2];
    ref_albedos_at(&g->table->albedos, i, g->roughness, pair);
    weigh(g, pair, weights);
    for (int channel = 0; channel < 3; ++channel)
        for (int k = 0; k < 2; ++k)
            value[channel] += fabs(i.z) / M_PI * weights[k] * (far ? l.far : l.near)[k][channel];
    return density + l.chance[far ? 2 : 1] * fabs(i.z) / M_PI;
}

/* A visible microfacet normal (Heitz 2018): the stretched hemisphere seen from o, uniform over its
 * projection. */
static ref_vec visible_normal(const double alpha[2], ref_vec o, ref_random *random) {
    const ref_vec v = ref_unit((ref_vec){alpha[0] * o.x, alpha[1] * o.y, o.z});
    const double across = hypot(v.x, v.y);
    const ref_vec t1 = across > 0 ? (ref_vec){-v.y / across, v.x / across, 0} : (ref_vec){1, 0, 0},
                  t2 = ref_cross(v, t1);
    const double r = sqrt(ref_random_unit(random)), phi = 2 * M_PI * ref_random_unit(random),
                 s = (1 + v.z) / 2;
    const double a = r * cos(phi), b = (1 - s) * sqrt(1 - a * a) + s * r * sin(phi);
    const ref_vec n = ref_add(ref_add(ref_scale(a, t1), ref_scale(b, t2)),
                              ref_scale(sqrt(fmax(0, 1 - a * a - b * b)), v));
    return ref_unit((ref_vec){alpha[0] * n.x, alpha[1] * n.y, fmax(1e-12, n.z)});
}

ref_vec ref_gloss_sample(const ref_gloss *g, ref_vec o, ref_random *random) {
    const ref_vec none = {0, 0, 0};
    const lobes l = lobes_at(g, o);
    const double choice = ref_random_unit(random);
    if (choice >= l.chance[0]) {
        const double u = ref_random_unit(random), phi = 2 * M_PI * ref_random_unit(random),
                     sine = sqrt(u), cosine = sqrt(1 - u);
        return (ref_vec){sine * cos(phi), sine * sin(phi),
                         choice < l.chance[0] + l.chance[1] ? cosine : -cosine};
    }
    double reflects[3], passes[3];
    const ref_vec h = visible_normal(l.alpha, o, random);
    const bool stays = ref_random_unit(random) < split(g, &l, ref_dot(o, h), reflects, passes);
    ref_vec i = ref_reflected(o, h);
    if (!stays && g->material->type == MCV_MATERIAL_DIELECTRIC)
        return ref_refracted(o, h, g->from / g->to, &i) && i.z < 0 ? i : none;
    if (!(i.z > 0)) return none;
    if (!stays) i.z = -i.z;
    return i;
}
