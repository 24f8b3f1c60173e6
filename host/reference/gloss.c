/* SPDX-License-Identifier: Apache-2.0 */
#include "reference/gloss.h"

#include <complex.h>
#include <stdlib.h>

#include "mcvisi/materials/microfacet.h"
#include "reference/interface.h"
#include "device/multiple.h"

enum { COSINES = 100, AZIMUTHS = 25, ROUGHNESSES = 33, NORMALS = 64 };

/* Narrower microfacet distributions are as narrow as this, and interfaces that spread light less
 * than this are smooth (docs/limitations.md). */
static const double least_alpha = 1e-3, least_spread = 1e-5;

static void alphas(const mcv_roughness *roughness, double share, double alpha[2]) {
    const double r = roughness->roughness * share, s = roughness->anisotropy;
    alpha[1] = fmax(r * r, least_alpha);
    alpha[0] = alpha[1] + (1 - alpha[1]) * s * s;
}

/* Smith's Λ, by the roughness that the direction's azimuth sees. */
static double lambda(const double alpha[2], ref_vec w) {
    const double slope = hypot(alpha[0] * w.x, alpha[1] * w.y) / fabs(w.z);
    return (sqrt(1 + slope * slope) - 1) / 2;
}

/*
 * The mean, over the heights at which light meets microfacets first, of being seen from two
 * directions of these Λ; on opposite sides what lies high for the one lies low for the other (Heitz
 * and others 2016).
 */
static double seen_from(double a, double b, bool opposite) {
    return opposite ? exp(lgamma(1 + a) + lgamma(1 + b) - lgamma(2 + a + b)) : 1 / (1 + a + b);
}

static double distribution(const double alpha[2], ref_vec h) {
    const double x = h.x / (alpha[0] * h.z), y = h.y / (alpha[1] * h.z), t = 1 + x * x + y * y;
    return 1 / (M_PI * alpha[0] * alpha[1] * pow(h.z, 4) * t * t);
}

static ref_vec reflected(ref_vec o, ref_vec h) {
    return ref_sub(ref_scale(2 * ref_dot(o, h), h), o);
}

/* False: total reflection. */
static bool refracted(ref_vec o, ref_vec h, double ratio, ref_vec *i) {
    const ref_vec along = ref_scale(-ratio, ref_sub(o, ref_scale(ref_dot(o, h), h)));
    const double squared = ref_dot(along, along);
    if (squared >= 1) return false;
    *i = ref_sub(along, ref_scale(sqrt(1 - squared), h));
    return true;
}

double ref_conductor_reflectance(double n, double k, double cosine) {
    const double complex square = (n - k * I) * (n - k * I),
                         other = csqrt(square - (1 - cosine * cosine));
    const double s = cabs((cosine - other) / (cosine + other)),
                 p = cabs((square * cosine - other) / (square * cosine + other));
    return (s * s + p * p) / 2;
}

static double unpolarised(double from, double to, double cosine) {
    double s, p;
    ref_fresnel(from, to, fmin(cosine, 1), &s, &p);
    return (s + p) / 2;
}

/*
 * The words of the entry for two directions, of n cosines; `roughness` counts the tables. In
 * between by lines, and by triangles among the two cosines.
 */
static void orders_at(const float *orders, int n, double roughness, ref_vec o, ref_vec i,
                      double words[MCV_MULTIPLE_WORDS]) {
    enum { M = MCV_MULTIPLE_AZIMUTHS, LAST = MCV_MULTIPLE_ROUGHNESSES - 1 };
    const double z[2] = {fmin(o.z, 1), fmin(fabs(i.z), 1)}, sum = z[0] + z[1] + MCV_MULTIPLE_LEAST;
    const double turn = atan2(o.y, o.x) - atan2(i.y, i.x), c = fabs(cos(turn / 2));
    const double entry = (M - 1) * c * (1 + sum) / (c + sum);
    double place[2], share[2];
    for (int k = 0; k < 2; ++k) place[k] = (n - 1) * sqrt(z[k]) / (sqrt(z[k]) + sqrt(1 - z[k]));
    const int low[2] = {(int)fmin(place[0], n - 2), (int)fmin(place[1], n - 2)},
              first = (int)fmin(entry, M - 2);
    for (int k = 0; k < 2; ++k) share[k] = place[k] - low[k];
    const bool below = share[0] > share[1];
    const int corners[3][2] = {{0, 0}, {below, !below}, {1, 1}};
    const double most = fmax(share[0], share[1]), least = fmin(share[0], share[1]),
                 weights[3] = {1 - most, most - least, least};
    const int layer = (int)fmin(roughness, LAST - 1);
    for (int word = 0; word < MCV_MULTIPLE_WORDS; ++word) words[word] = 0;
    for (int k = 0; k < 12; ++k) {
        const int corner = k / 4, next = k & 1, above = k >> 1 & 1;
        const double weight = weights[corner] * (next ? entry - first : 1 - (entry - first)) *
                              (above ? roughness - layer : 1 - (roughness - layer));
        if (weight == 0) continue;
        const float *at =
            orders + (size_t)(layer + above) * mcv_multiple_words() +
            MCV_MULTIPLE_WORDS *
                (((low[0] + corners[corner][0]) * n + low[1] + corners[corner][1]) * M + first +
                 next);
        for (int word = 0; word < MCV_MULTIPLE_WORDS; ++word)
            words[word] += weight * (double)at[word];
    }
}

/* --- albedos
 * ----------------------------------------------------------------------------------------------------
 */

/*
 * What leaves of the light from o, over all microfacet normals: D(h) h_z dh is uniform in the
 * azimuth and in u = tan²θ/(α² + tan²θ). The tail u -> 1 has facets that stand upright, seen far
 * larger than they lie: u = 1 - (1 - v)^4 tames it. Reflection: all of it, and (1 - c)^5 of it.
 * Interface (from > 0): what is reflected and refracted together.
 */
static void integrate(const double alpha[2], ref_vec o, double from, double to, double coating,
                      double sums[2]) {
    const double own = lambda(alpha, o);
    sums[0] = sums[1] = 0;
    for (int a = 0; a < NORMALS; ++a) {
        const double phi = 2 * M_PI * (a + 0.5) / NORMALS;
        for (int b = 0; b < NORMALS; ++b) {
            const double v = (b + 0.5) / NORMALS, left = (1 - v) * (1 - v),
                         slope = sqrt((1 - left * left) / (left * left));
            const ref_vec h =
                ref_unit((ref_vec){alpha[0] * slope * cos(phi), alpha[1] * slope * sin(phi), 1});
            const double c = ref_dot(o, h);
            if (!(c > 0)) continue;
            const double seen = 4 * (1 - v) * left * c / (o.z * h.z) / (NORMALS * NORMALS);
            const ref_vec r = reflected(o, h);
            const double kept = r.z > 0 ? seen * seen_from(own, lambda(alpha, r), false) : 0;
            if (!(from > 0)) {
                sums[0] += kept;
                sums[1] += kept * pow(1 - c, 5);
                continue;
            }
            const double fresnel = ref_coated(unpolarised(from, to, c), coating, from, to);
            ref_vec t;
            const bool passes = refracted(o, h, from / to, &t) && t.z < 0;
            sums[0] += fresnel * kept +
                       (passes ? (1 - fresnel) * seen * seen_from(own, lambda(alpha, t), true) : 0);
        }
    }
}

static double cosine_at(uint32_t c) { return fmax(pow(c / (COSINES - 1.0), 2), 1e-5); }

/* The pair for a direction, interpolated; at a roughness as a share of the material's. */
static void look_up(const ref_albedos *albedos, ref_vec w, double roughness, double pair[2]) {
    const double places[3] = {roughness * (albedos->roughnesses - 1),
                              atan2(fabs(w.y), fabs(w.x)) / (M_PI / 2) * (albedos->azimuths - 1),
                              sqrt(fabs(w.z)) * (COSINES - 1)};
    const uint32_t sizes[3] = {albedos->roughnesses, albedos->azimuths, COSINES};
    pair[0] = pair[1] = 0;
    for (int corner = 0; corner < 8; ++corner) {
        double weight = 1;
        size_t at = 0;
        for (int axis = 0; axis < 3; ++axis) {
            const double low = fmin(floor(places[axis]), fmax(sizes[axis] - 2.0, 0)),
                         share = places[axis] - low;
            const bool next = corner >> axis & 1;
            weight *= next ? share : 1 - share;
            at = at * sizes[axis] + (size_t)fmin(low + next, sizes[axis] - 1.0);
        }
        for (int k = 0; k < 2; ++k) pair[k] += weight * albedos->pairs[2 * at + (size_t)k];
    }
}

static void mean_at(const ref_albedos *albedos, double roughness, double pair[2]) {
    const double place = roughness * (albedos->roughnesses - 1),
                 low = fmin(floor(place), fmax(albedos->roughnesses - 2.0, 0));
    const size_t first = (size_t)low, second = (size_t)fmin(low + 1, albedos->roughnesses - 1.0);
    for (size_t k = 0; k < 2; ++k)
        pair[k] = (1 - (place - low)) * albedos->means[2 * first + k] +
                  (place - low) * albedos->means[2 * second + k];
}

static bool albedos_new(ref_albedos *albedos, const mcv_material *material, double outside) {
    const mcv_roughness roughness = mcv_material_roughness(material);
    albedos->azimuths = roughness.anisotropy > 0 ? AZIMUTHS : 1;
    albedos->roughnesses = mcv_material_surface_texture(material) != MCV_NONE ? ROUGHNESSES : 1;
    albedos->pairs =
        malloc(2 * sizeof(double) * albedos->roughnesses * albedos->azimuths * COSINES);
    albedos->means = calloc(albedos->roughnesses, 2 * sizeof(double));
    if (!albedos->pairs || !albedos->means) return false;
    double *pair = albedos->pairs;
    for (uint32_t r = 0; r < albedos->roughnesses; ++r) {
        double alpha[2];
        const double share = albedos->roughnesses > 1 ? r / (ROUGHNESSES - 1.0) : 1;
        alphas(&roughness, share, alpha);
        for (uint32_t a = 0; a < albedos->azimuths; ++a)
            for (uint32_t c = 0; c < COSINES; ++c, pair += 2) {
                const double phi = albedos->azimuths > 1 ? M_PI / 2 * a / (AZIMUTHS - 1) : 0,
                             z = cosine_at(c), sine = sqrt(1 - z * z);
                const ref_vec o = {sine * cos(phi), sine * sin(phi), z};
                if (outside > 0) {
                    double both[2];
                    const double coating = mcv_material_coating(material, outside);
                    integrate(alpha, o, outside, material->as.dielectric.ior[MCV_ALBEDO_CHANNEL],
                              coating, both);
                    pair[0] = fmin(both[0], 1);
                    integrate(alpha, o, material->as.dielectric.ior[MCV_ALBEDO_CHANNEL], outside,
                              coating, both);
                    pair[1] = fmin(both[0], 1);
                } else {
                    integrate(alpha, o, 0, 0, 0, pair);
                }
            }
    }
    for (uint32_t r = 0; r < albedos->roughnesses;
         ++r) { /* looking up reads the next roughness too */
        enum { STEPS = 1000, TURNS = 32 };
        const double share = albedos->roughnesses > 1 ? r / (ROUGHNESSES - 1.0) : 1;
        double total = 0;
        for (int turn = 0; turn < TURNS; ++turn)
            for (int step = 0; step < STEPS; ++step) {
                const double phi = M_PI / 2 * (turn + 0.5) / TURNS, z = (step + 0.5) / STEPS,
                             sine = sqrt(1 - z * z);
                double at[2];
                look_up(albedos, (ref_vec){sine * cos(phi), sine * sin(phi), z}, share, at);
                for (int k = 0; k < 2; ++k) albedos->means[2 * r + (uint32_t)k] += z * at[k];
                total += z;
            }
        for (int k = 0; k < 2; ++k) albedos->means[2 * r + (uint32_t)k] /= total;
    }
    return true;
}

/* Tables of multiple scattering at each roughness, where the material is a metal or glass that has
 * no direction. */
static bool orders_new(const mcv_material *material, double outside, float **orders) {
    const mcv_roughness roughness = mcv_material_roughness(material);
    const bool conductor = material->type == MCV_MATERIAL_CONDUCTOR,
               layered = material->type == MCV_MATERIAL_METALLIC_ROUGHNESS;
    const double *n = conductor ? material->as.conductor.n : NULL,
                 *k = conductor ? material->as.conductor.k : NULL;
    const uint32_t count =
        mcv_material_surface_texture(material) != MCV_NONE ? MCV_MULTIPLE_ROUGHNESSES : 1;
    bool made = true;
    *orders = NULL;
    if (roughness.anisotropy > 0 ||
        !(outside > 0 || conductor || (layered && material->as.metallic_roughness.metallic > 0)))
        return true;
    *orders = malloc(sizeof(float) * (outside > 0 ? mcv_interface_words() : mcv_multiple_words()) *
                     count);
    for (uint32_t i = 0; *orders && i < count; ++i) {
        double alpha[2];
        alphas(&roughness, count > 1 ? i / (count - 1.0) : 1, alpha);
        float *table = *orders + (size_t)i * mcv_multiple_words();
        made =
            made &&
            (outside > 0 ? mcv_multiple_interface(alpha[1], outside,
                                                  material->as.dielectric.ior[MCV_ALBEDO_CHANNEL],
                                                  mcv_material_coating(material, outside), table)
                         : mcv_multiple_reflection(alpha[1], n, k, table));
    }
    return *orders && made;
}

static bool add_table(ref_gloss_tables *tables, const mcv_scene *scene, uint32_t material,
                      double outside) {
    const mcv_material *from = &scene->materials[material];
    for (uint32_t i = 0; i < tables->count; ++i)
        if (tables->items[i].material == material && tables->items[i].outside == outside)
            return true;
    ref_gloss_table *items = realloc(tables->items, (tables->count + (size_t)1) * sizeof *items);
    if (!items) return false;
    tables->items = items;
    ref_gloss_table *table = &items[tables->count++];
    *table = (ref_gloss_table){.material = material, .outside = outside};
    if (!orders_new(from, outside, &table->orders) || !albedos_new(&table->albedos, from, outside))
        return false;
    for (int channel = 0; from->type == MCV_MATERIAL_CONDUCTOR && channel < 3; ++channel) {
        enum { STEPS = 2000 };
        const double escape = table->albedos.means[0];
        double mean = 0;
        for (int i = 0; i < STEPS; ++i) {
            const double cosine = (i + 0.5) / STEPS;
            mean += 2 * cosine / STEPS *
                    ref_conductor_reflectance(from->as.conductor.n[channel],
                                              from->as.conductor.k[channel], cosine);
        }
        table->multiple[channel] = mean * mean * escape / (1 - mean * (1 - escape));
    }
    return true;
}

mcv_result ref_gloss_tables_new(const mcv_scene *scene, ref_gloss_tables *tables,
                                mcv_error *error) {
    *tables = (ref_gloss_tables){0};
    bool made = true;
    for (uint32_t i = 0; i < scene->instance_count && made; ++i) {
        const uint32_t material = scene->instances[i].material;
        const mcv_material *from = &scene->materials[material];
        if (!mcv_material_is_rough(from)) continue;
        if (from->type != MCV_MATERIAL_DIELECTRIC) {
            made = add_table(tables, scene, material, 0);
            continue;
        }
        made = add_table(tables, scene, material, 1);
        for (uint32_t j = 0; j < scene->instance_count && made; ++j) {
            const mcv_material *other = &scene->materials[scene->instances[j].material];
            if (other->type == MCV_MATERIAL_DIELECTRIC &&
                other->as.dielectric.ior[MCV_ALBEDO_CHANNEL] !=
                    from->as.dielectric.ior[MCV_ALBEDO_CHANNEL])
                made = add_table(tables, scene, material,
                                 other->as.dielectric.ior[MCV_ALBEDO_CHANNEL]);
        }
    }
    return made ? MCV_OK
                : mcv_fail(error, MCV_FAILED,
                           "reference renderer: no memory for the glossy materials of %s",
                           scene->path);
}

void ref_gloss_tables_free(ref_gloss_tables *tables) {
    for (uint32_t i = 0; i < tables->count; ++i) {
        free(tables->items[i].albedos.pairs);
        free(tables->items[i].albedos.means);
        free(tables->items[i].orders);
    }
    free(tables->items);
    *tables = (ref_gloss_tables){0};
}

const ref_gloss_table *ref_gloss_find(const ref_gloss_tables *tables, const mcv_scene *scene,
                                      uint32_t material, double outside) {
    const mcv_material *from = &scene->materials[material];
    const bool dielectric = from->type == MCV_MATERIAL_DIELECTRIC;
    if (dielectric) {
        const mcv_roughness roughness = mcv_material_roughness(from);
        double alpha[2];
        alphas(&roughness, 1, alpha);
        if (alpha[1] * fabs(from->as.dielectric.ior[MCV_ALBEDO_CHANNEL] - outside) / outside <
            least_spread)
            return NULL;
    }
    for (uint32_t i = 0; i < tables->count; ++i)
        if (tables->items[i].material == material &&
            tables->items[i].outside == (dielectric ? outside : 0))
            return &tables->items[i];
    return NULL;
}

/* --- lobes
 * ------------------------------------------------------------------------------------------------------
 */

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
    alphas(&roughness, g->roughness, l.alpha);
    look_up(&g->table->albedos, o, g->roughness, pair);
    mean_at(&g->table->albedos, g->roughness, mean);
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
            reflects[c] = ref_coated(unpolarised(g->from, g->to, cosine), coating, g->from, g->to);
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
        const double facets = distribution(l.alpha, h) * c / o.z * jacobian,
                     own = lambda(l.alpha, o);
        double words[MCV_MULTIPLE_WORDS] = {0};
        if (g->table->orders && !far)
            orders_at(g->table->orders, glass ? MCV_INTERFACE_COSINES : MCV_MULTIPLE_COSINES,
                      g->table->albedos.roughnesses > 1
                          ? g->roughness * (MCV_MULTIPLE_ROUGHNESSES - 1)
                          : 0,
                      o, i, words);
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
                             seen_from(own, lambda(l.alpha, i), bends);
        density = l.chance[0] * (far ? 1 - chance : chance) * facets / (1 + own);
    }

    if (bends && g->table->orders) { /* what goes on from facet to facet and leaves here */
        double words[MCV_MULTIPLE_WORDS];
        orders_at(g->table->orders, MCV_INTERFACE_COSINES, 0, o, i, words);
        const double wide =
            words[2 + g->inside] / (o.z * (1 + lambda(l.alpha, o)) * (1 + lambda(l.alpha, i)));
        for (int channel = 0; channel < 3; ++channel) value[channel] += wide;
    }
    double pair[2], weights[2];
    look_up(&g->table->albedos, i, g->roughness, pair);
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
    ref_vec i = reflected(o, h);
    if (!stays && g->material->type == MCV_MATERIAL_DIELECTRIC)
        return refracted(o, h, g->from / g->to, &i) && i.z < 0 ? i : none;
    if (!(i.z > 0)) return none;
    if (!stays) i.z = -i.z;
    return i;
}
