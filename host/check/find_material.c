/* SPDX-License-Identifier: Apache-2.0 */
/* Rough materials of which the model leaves out or spreads light by more than a measurement may
 * bear. */
#include "check/find.h"

#include "device/microsurface.h"
#include "scene/materials.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

static bool is_in_use(const mcv_scene *scene, uint32_t material) {
    for (uint32_t i = 0; i < scene->instance_count; ++i)
        if (scene->instances[i].material == material) return true;
    return false;
}

/* --- the layer of metallicRoughness --- */

/* Microfacets with the reflectance at normal incidence of Schlick's F. */
typedef struct layer {
    double alpha, f0;
} layer;

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

/* What a layer reflects, {once, more than once}, of even light and of light at 80°. */
typedef struct shares {
    layer of;
    double even[2], grazing[2];
} shares;

/* The layers that were walked on: an assembly has few, and many materials. */
typedef struct known_layers {
    shares *items;
    size_t count;
} known_layers;

static const shares *shares_of(known_layers *known, double alpha, double f0) {
    const double cos_80 = 0.17364817766693035;
    for (size_t i = 0; i < known->count; ++i)
        if (known->items[i].of.alpha == alpha && known->items[i].of.f0 == f0)
            return known->items + i;
    shares *s = known->items + known->count++;
    s->of = (layer){alpha, f0};
    walk_often(&s->of, 0, s->even);
    walk_often(&s->of, cos_80, s->grazing);
    return s;
}

/*
 * The part that is missing of the light that should leave. glTF mixes plastic and metal. The base
 * of the plastic gets the light of several reflections, and absorbs some of it. The metal lacks
 * nothing: it reflects `metal` {once, more than once}.
 */
static double missing(const double plastic[2], const double metal[2], double metallic,
                      double base) {
    const double all = plastic[0] + plastic[1];
    return (1 - metallic) * plastic[1] * (1 - base) /
           ((1 - metallic) * (all + base * (1 - all)) + metallic * (metal[0] + metal[1]));
}

/* How much a material lacks, in the channel that lacks most. */
typedef struct lack {
    const mcv_material *material;
    double even, grazing;
    double black; /* what a black base lacks for the right sum */
} lack;

static double most(const lack *l) { return fmax(l->even, l->grazing); }

static lack lack_of(const mcv_material *m, known_layers *known) {
    const mcv_metallic_roughness_params *p = &m->as.metallic_roughness;
    const double least = 0.032, /* a roughness below counts as that */
        r = fmax(mcv_material_roughness(m).roughness, least);
    const shares *plastic = shares_of(known, r * r, pow((p->ior - 1) / (p->ior + 1), 2));
    lack worst = {.even = -1, .grazing = -1};
    for (int c = 0; c < 3; ++c) {
        const double base = p->baseColor[c];
        const shares *metal = p->metallic > 0 ? shares_of(known, r * r, base) : plastic;
        const lack one = {m, missing(plastic->even, metal->even, p->metallic, base),
                          missing(plastic->grazing, metal->grazing, p->metallic, base),
                          plastic->even[1] / (1 - plastic->even[0])};
        if (most(&one) > most(&worst)) worst = one;
    }
    return worst;
}

/* The remedy by baseColor; none where metal or a texture takes its colour from it, too. */
static const char *to_add(const lack *l, char text[128]) {
    const mcv_metallic_roughness_params *p = &l->material->as.metallic_roughness;
    double add[3];
    text[0] = 0;
    if (p->metallic > 0 || l->material->texture != MCV_NONE) return text;
    for (int c = 0; c < 3; ++c) add[c] = l->black * (1 - p->baseColor[c]);
    if (add[0] == add[1] && add[1] == add[2])
        snprintf(text, 128, ". For the right sum under even light, add %.2g to baseColor", add[0]);
    else
        snprintf(text, 128,
                 ". For the right sum under even light, add %.2g, %.2g, %.2g to baseColor", add[0],
                 add[1], add[2]);
    return text;
}

static mcv_result report_layer(const lack *worst, uint32_t others, double from,
                               mcv_findings *findings, mcv_error *error) {
    char more[80] = "", add[128];
    if (others)
        snprintf(more, sizeof more, " %u other material%s %g %% or more.", others,
                 others == 1 ? " lacks" : "s lack", 100 * from);
    return mcv_findings_add(
        findings, MCV_SEVERITY_NOTE, "materials", worst->material->name, "roughness", error,
        "material \"%s\" lacks %.1f %% of its light under even light, and %.1f %% at an incidence "
        "of 80°.%s Light that a layer reflects more than once goes to the base. Count the shares "
        "as uncertainty of grey values%s",
        worst->material->name, 100 * worst->even, 100 * worst->grazing, more, to_add(worst, add));
}

/* One finding for all: an assembly has many. */
mcv_result mcv_find_layer(const mcv_scene *scene, mcv_findings *findings, mcv_error *error) {
    const double from = 0.02;
    lack worst = {.material = NULL};
    uint32_t count = 0;
    if (findings->least > MCV_SEVERITY_NOTE) return MCV_OK;
    /* For each material a plastic, and a metal in each channel. */
    known_layers known = {.items = calloc(4 * (size_t)scene->material_count + 1, sizeof(shares))};
    if (!known.items)
        return mcv_fail(error, MCV_FAILED, "%s: no memory for what its materials reflect",
                        scene->path);
    for (uint32_t i = 0; i < scene->material_count; ++i) {
        const mcv_material *m = scene->materials + i;
        if (m->type != MCV_MATERIAL_METALLIC_ROUGHNESS ||
            !(m->as.metallic_roughness.metallic < 1) || !is_in_use(scene, i))
            continue;
        const lack one = lack_of(m, &known);
        if (most(&one) < from) continue;
        ++count;
        if (most(&one) > most(&worst)) worst = one;
    }
    free(known.items);
    return worst.material ? report_layer(&worst, count - 1, from, findings, error) : MCV_OK;
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
                "material \"%s\" is brushed glass. Light that its microfacets send on more than "
                "once is right in sum. Single directions are off by some percent. Leave out "
                "anisotropy where grey values must be right",
                m->name));
        else if (alpha < narrow)
            MCV_TRY(mcv_findings_add(
                findings, MCV_SEVERITY_NOTE, "materials", m->name, "roughness", error,
                "material \"%s\" is glass of α = %.2g. Light that it transmits is right in sum. A "
                "single direction is off by 1.8 %% (root mean square at α = 0.05), beyond 72° by "
                "up to 8 %%. Count that as uncertainty of grey values",
                m->name, alpha));
    }
    return MCV_OK;
}
