/* SPDX-License-Identifier: Apache-2.0 */
/* Rough materials of which the model leaves out or spreads light by more than a measurement may
 * bear. */
#include "check/find.h"

#include "device/microsurface.h"
#include "scene/materials.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

static bool is_in_use(const mcv_scene *scene, uint32_t material) {
    for (uint32_t i = 0; i < scene->instance_count; ++i)
        if (scene->instances[i].material == material) return true;
    return false;
}

/* --- the layer of metallicRoughness --- */

/* splitmix64, as a number in (0, 1). */
static double unit(uint64_t *state) {
    uint64_t x = *state += 0x9e3779b97f4a7c15U;
    x = (x ^ x >> 30) * 0xbf58476d1ce4e5b9U;
    x = (x ^ x >> 27) * 0x94d049bb133111ebU;
    return ((double)((x ^ x >> 31) >> 11) + 0.5) * 0x1p-53;
}

/* Reflectances at normal incidence that a walk counts at once, from 0 to 1, and steps of roughness
 * between which shares are linear. */
enum { NODES = 13, STEPS = 32 };

/* What a layer reflects once and more than once, for each node. */
typedef struct counted {
    double of[2][NODES];
} counted;

/*
 * Layers of microfacets. What one reflects is a power series of its reflectance f0 at normal
 * incidence, with terms of at least 0: a polynomial through the nodes of Chebyshev and Lobatto
 * serves every f0. A scene of many materials thus takes the walks of STEPS + 1 layers at most.
 */
typedef struct layers {
    double nodes[NODES];
    bool walked[STEPS + 1];
    counted even[STEPS + 1], grazing[STEPS + 1]; /* even light; light at 80° */
} layers;

static void layers_begin(layers *l) {
    memset(l, 0, sizeof *l);
    for (int k = 0; k < NODES; ++k) l->nodes[k] = 0.5 - 0.5 * cos(M_PI * k / (NODES - 1));
}

/* Where a walk begins: the cosine of its light, and numbers in (0, 1) for its first microfacet. */
typedef struct start {
    double cosine, height, left, turn;
} start;

/*
 * One walk from microfacet to microfacet (Heitz and others 2016) of light of this weight: adds what
 * the layer reflects. After each microfacet a part of the light leaves, and the walk goes on with
 * the rest, which is `white` for white microfacets. `below` is the share of the surface below the
 * light.
 */
static void walk(const double *nodes, double alpha, const start *from, double weight,
                 uint64_t *state, counted *sums) {
    const double alphas[2] = {alpha, alpha}, negligible = 1e-5;
    double back[3] = {sqrt(1 - from->cosine * from->cosine), 0, from->cosine}, white = 1,
           weights[NODES];
    double below = pow(from->height, 1 / (1 + mcv_smith(alpha, from->cosine)));
    for (int k = 0; k < NODES; ++k) weights[k] = weight;
    for (int meeting = 1; white > negligible; ++meeting) {
        const double left = sqrt(meeting > 1 ? unit(state) : from->left),
                     angle = 2 * M_PI * (meeting > 1 ? unit(state) : from->turn),
                     turn[2] = {cos(angle), sin(angle)};
        double on[3], c, h[3];
        mcv_reflect_by_facet(alphas, back, left, turn, on, &c, h);
        const double smith = mcv_smith(alpha, fmax(fabs(on[2]), 1e-12)),
                     leaves = on[2] > 0 ? pow(below, smith) : 0,
                     chance = leaves + (1 - leaves) * unit(state), schlick = pow(1 - c, 5);
        double *to = sums->of[meeting > 1];
        for (int k = 0; k < NODES; ++k) {
            weights[k] *= nodes[k] + (1 - nodes[k]) * schlick;
            to[k] += weights[k] * leaves;
            weights[k] *= 1 - leaves;
        }
        white *= 1 - leaves;
        below = fmin(below / pow(chance, on[2] > 0 ? 1 / fmax(smith, 1e-12) : -1 / (1 + smith)), 1);
        for (int k = 0; k < 3; ++k) back[k] = -on[k];
    }
}

/*
 * Of even light, or with a cosine above 0 of light at that. Cosines are at equal steps, since
 * microfacets that are seen at grazing angles reflect most light twice; the first microfacets are
 * points of an additive recurrence.
 */
static void walk_often(const double *nodes, double alpha, double cosine, counted *means) {
    enum { WALKS = 1 << 15 };
    static const double steps[3] = {0.81917251339616, 0.67104360670379,
                                    0.54970047790197}; /* g^-k, g^4 = g + 1 */
    uint64_t state = 1;
    for (int i = 0; i < WALKS; ++i) {
        const double even = (i + 0.5) / WALKS;
        double u[3];
        for (int k = 0; k < 3; ++k) u[k] = fmod(0.5 + steps[k] * (i + 1), 1);
        const start from = {cosine > 0 ? cosine : even, u[0], u[1], u[2]};
        walk(nodes, alpha, &from, (cosine > 0 ? 1 : 2 * even) / WALKS, &state, means);
    }
}

/* The part of each node in the polynomial's value at f0: the barycentric formula (Berrut and
 * Trefethen 2004). */
static void weigh_nodes(const double *nodes, double f0, double parts[NODES]) {
    double sum = 0;
    for (int k = 0; k < NODES; ++k) {
        const double away = f0 - nodes[k], end = k == 0 || k == NODES - 1 ? 0.5 : 1;
        if (fabs(away) < DBL_EPSILON) { /* its rounding; a quotient could overflow */
            for (int i = 0; i < NODES; ++i) parts[i] = i == k;
            return;
        }
        sum += parts[k] = (k % 2 ? -end : end) / away;
    }
    for (int k = 0; k < NODES; ++k) parts[k] /= sum;
}

/* What a layer reflects, {once, more than once}, of even light and of light at 80°. */
typedef struct shares {
    double even[2], grazing[2];
} shares;

static shares shares_of(layers *l, double roughness, double f0) {
    const double least = 0.032, /* a roughness below counts as that */
        cos_80 = 0.17364817766693035,
                 place = (fmax(roughness, least) - least) / (1 - least) * STEPS;
    const int first = (int)fmin(place, STEPS - 1);
    shares s = {{0, 0}, {0, 0}};
    double parts[NODES];
    weigh_nodes(l->nodes, f0, parts);
    for (int step = first; step < first + 2; ++step) {
        const double r = least + (1 - least) * step / STEPS, part = 1 - fabs(place - step);
        if (part == 0) continue;
        if (!l->walked[step]) {
            walk_often(l->nodes, r * r, 0, &l->even[step]);
            walk_often(l->nodes, r * r, cos_80, &l->grazing[step]);
            l->walked[step] = true;
        }
        for (int more = 0; more < 2; ++more)
            for (int k = 0; k < NODES; ++k) {
                s.even[more] += part * parts[k] * l->even[step].of[more][k];
                s.grazing[more] += part * parts[k] * l->grazing[step].of[more][k];
            }
    }
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

static lack lack_of(const mcv_material *m, layers *of) {
    const mcv_metallic_roughness_params *p = &m->as.metallic_roughness;
    const double roughness = mcv_material_roughness(m).roughness;
    const shares plastic = shares_of(of, roughness, pow((p->ior - 1) / (p->ior + 1), 2));
    lack worst = {.even = -1, .grazing = -1};
    for (int c = 0; c < 3; ++c) {
        const double base = p->baseColor[c];
        const shares metal = p->metallic > 0 ? shares_of(of, roughness, base) : plastic;
        const lack one = {m, missing(plastic.even, metal.even, p->metallic, base),
                          missing(plastic.grazing, metal.grazing, p->metallic, base),
                          plastic.even[1] / (1 - plastic.even[0])};
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
    layers of;
    layers_begin(&of);
    for (uint32_t i = 0; i < scene->material_count; ++i) {
        const mcv_material *m = scene->materials + i;
        if (m->type != MCV_MATERIAL_METALLIC_ROUGHNESS ||
            !(m->as.metallic_roughness.metallic < 1) || !is_in_use(scene, i))
            continue;
        const lack one = lack_of(m, &of);
        if (most(&one) < from) continue;
        ++count;
        if (most(&one) > most(&worst)) worst = one;
    }
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
