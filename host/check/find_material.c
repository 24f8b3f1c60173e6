/* SPDX-License-Identifier: Apache-2.0 */
/* Rough materials of which the model leaves out or spreads light by more than a measurement may
 * bear. */
#include "check/find.h"

#include "device/microsurface.h"
#include "scene/materials.h"

#include <math.h>
#include <stdio.h>

static bool is_in_use(const mcv_scene *scene, uint32_t material) {
    for (uint32_t i = 0; i < scene->instance_count; ++i)
        if (scene->instances[i].material == material) return true;
    return false;
}

/* --- the layer of metallicRoughness --- */

/* Means over the channels. */
typedef struct layer {
    double alpha, f0, base; /* Schlick's F at normal incidence, the base's reflectance */
} layer;

static layer layer_of(const mcv_material *m) {
    const mcv_metallic_roughness_params *p = &m->as.metallic_roughness;
    const double colour = (p->baseColor[0] + p->baseColor[1] + p->baseColor[2]) / 3,
                 least = 0.032, /* a roughness below counts as that */
        r = fmax(mcv_material_roughness(m).roughness, least);
    return (layer){.alpha = r * r,
                   .f0 = (1 - p->metallic) * pow((p->ior - 1) / (p->ior + 1), 2) +
                         p->metallic * colour,
                   .base = (1 - p->metallic) * colour};
}

/* splitmix64, as a number in (0, 1). */
static double unit(uint64_t *state) {
    uint64_t x = *state += 0x9e3779b97f4a7c15U;
    x = (x ^ x >> 30) * 0xbf58476d1ce4e5b9U;
    x = (x ^ x >> 27) * 0x94d049bb133111ebU;
    return ((double)((x ^ x >> 31) >> 11) + 0.5) * 0x1p-53;
}

/*
 * One walk from microfacet to microfacet (Heitz and others 2016) of light from this cosine: adds
 * what the layer reflects once to shares[0], and more than once to shares[1]. After each microfacet
 * a part of the light leaves, and the walk goes on with the rest. `below` is the share of the
 * surface below the light.
 */
static void walk(const layer *l, double cosine, uint64_t *state, double shares[2]) {
    const double alpha[2] = {l->alpha, l->alpha}, negligible = 1e-5;
    double back[3] = {sqrt(1 - cosine * cosine), 0, cosine}, weight = 1;
    double below = pow(unit(state), 1 / (1 + mcv_smith(l->alpha, cosine)));
    for (int meeting = 1; weight > negligible; ++meeting) {
        const double left = sqrt(unit(state)), angle = 2 * M_PI * unit(state),
                     turn[2] = {cos(angle), sin(angle)};
        double on[3], c, h[3];
        mcv_reflect_by_facet(alpha, back, left, turn, on, &c, h);
        const double smith = mcv_smith(l->alpha, fmax(fabs(on[2]), 1e-12)),
                     leaves = on[2] > 0 ? pow(below, smith) : 0,
                     chance = leaves + (1 - leaves) * unit(state);
        weight *= l->f0 + (1 - l->f0) * pow(1 - c, 5);
        shares[meeting > 1] += weight * leaves;
        weight *= 1 - leaves;
        below = fmin(below / pow(chance, on[2] > 0 ? 1 / fmax(smith, 1e-12) : -1 / (1 + smith)), 1);
        for (int k = 0; k < 3; ++k) back[k] = -on[k];
    }
}

/* What the layer reflects once and more than once, of even light or of light at one cosine. */
static void walk_often(const layer *l, double cosine, double shares[2]) {
    enum { WALKS = 1 << 15 };
    uint64_t state = 1;
    shares[0] = shares[1] = 0;
    for (int k = 0; k < WALKS; ++k)
        walk(l, cosine > 0 ? cosine : sqrt((k + 0.5) / WALKS), &state, shares);
    for (int k = 0; k < 2; ++k) shares[k] /= WALKS;
}

/* The part that is missing of the light that should leave: the base gets the light of several
 * reflections, and absorbs some of it. */
static double missing(const layer *l, const double shares[2]) {
    const double more = shares[1], all = shares[0] + more;
    return more * (1 - l->base) / (all + l->base * (1 - all));
}

/* How much a material's layer lacks, in even light and at 80°, and what its base colour lacks. */
typedef struct lack {
    const mcv_material *material;
    double even, grazing, base;
} lack;

static lack lack_of(const mcv_material *m) {
    const double cos_80 = 0.17364817766693035;
    const layer l = layer_of(m);
    double even[2], grazing[2];
    walk_often(&l, 0, even);
    walk_often(&l, cos_80, grazing);
    return (lack){m, missing(&l, even), missing(&l, grazing),
                  even[1] * (1 - l.base) / (1 - even[0]) / (1 - m->as.metallic_roughness.metallic)};
}

/* One sentence for all: an assembly has many. */
mcv_result mcv_find_layer(const mcv_scene *scene, mcv_findings *findings, mcv_error *error) {
    const double most = 0.02;
    lack worst = {.grazing = 0};
    uint32_t others = 0;
    char more[48] = "";
    for (uint32_t i = 0; findings->least <= MCV_SEVERITY_NOTE && i < scene->material_count; ++i) {
        const mcv_material *m = scene->materials + i;
        if (m->type != MCV_MATERIAL_METALLIC_ROUGHNESS ||
            !(m->as.metallic_roughness.metallic < 1) || !is_in_use(scene, i))
            continue;
        const lack one = lack_of(m);
        if (fmax(one.even, one.grazing) < most) continue;
        others += worst.material != NULL;
        if (!worst.material || one.even > worst.even) worst = one;
    }
    if (!worst.material) return MCV_OK;
    if (others) snprintf(more, sizeof more, ", as do %u others less,", others);
    return mcv_findings_add(
        findings, MCV_SEVERITY_NOTE, "materials", worst.material->name, "roughness", error,
        "material \"%s\"%s lacks %.1f %% of the light that should leave it under even light, and "
        "%.1f %% of light that falls in at 80°: what its layer reflects more than once goes to the "
        "base; add %.2g to baseColor for the right sum under even light, and count the shares as "
        "uncertainty of grey values",
        worst.material->name, more, 100 * worst.even, 100 * worst.grazing, worst.base);
}

/* --- rough glass --- */

mcv_result mcv_find_rough_glass(const mcv_scene *scene, mcv_findings *findings, mcv_error *error) {
    const double narrow = 0.1; /* α from which on transmitted light is right to 1 % */
    for (uint32_t i = 0; i < scene->material_count; ++i) {
        const mcv_material *m = scene->materials + i;
        const mcv_roughness r = mcv_material_roughness(m);
        const double alpha = r.roughness * r.roughness;
        if (m->type != MCV_MATERIAL_DIELECTRIC || !mcv_material_is_rough(m) || !is_in_use(scene, i))
            continue;
        if (r.anisotropy > 0)
            MCV_TRY(mcv_findings_add(
                findings, MCV_SEVERITY_NOTE, "materials", m->name, "anisotropy", error,
                "material \"%s\" is brushed glass: what its microfacets send on more than once is "
                "right in sum, and off by some percent in single directions; leave out anisotropy "
                "where grey values must be right",
                m->name));
        else if (alpha < narrow)
            MCV_TRY(mcv_findings_add(
                findings, MCV_SEVERITY_NOTE, "materials", m->name, "roughness", error,
                "material \"%s\" is glass of α = %.2g: light that it transmits into a single "
                "direction is off by 1.8 %% (root mean square at α = 0.05), beyond 72° by up to "
                "8 %%, and right in sum; count that as uncertainty of grey values",
                m->name, alpha));
    }
    return MCV_OK;
}
