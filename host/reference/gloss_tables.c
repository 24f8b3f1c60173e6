/* SPDX-License-Identifier: Apache-2.0 */
#include "reference/gloss_tables.h"

#include "scene/materials.h"

#include <complex.h>
#include <stdlib.h>

#include "device/multiple.h"
#include "mcvisi/materials/brushed.h"
#include "reference/gloss_microfacet.h"

enum { COSINES = 100, AZIMUTHS = 25, ROUGHNESSES = 33, NORMALS = 64, DRAFT_NORMALS = 16 };

/* Interfaces that scatter less than this are smooth (docs/limitations.md). */
static const double least_spread = 1e-5;

double ref_conductor_reflectance(double n, double k, double cosine) {
    const double complex square = (n - k * I) * (n - k * I),
                         other = csqrt(square - (1 - cosine * cosine));
    const double s = cabs((cosine - other) / (cosine + other)),
                 p = cabs((square * cosine - other) / (square * cosine + other));
    return (s * s + p * p) / 2;
}

/*
 * The words of the entry for two directions, of a metal or of glass; `roughness` counts the tables.
 * In between by lines, and by triangles among the two cosines.
 */
void ref_orders_at(const float *orders, bool glass, double roughness, ref_vec o, ref_vec i,
                   double words[MCV_MULTIPLE_WORDS]) {
    enum { LAST = MCV_MULTIPLE_ROUGHNESSES - 1 };
    const int n = glass ? MCV_INTERFACE_COSINES : MCV_MULTIPLE_COSINES,
              m = glass ? MCV_INTERFACE_AZIMUTHS : MCV_MULTIPLE_AZIMUTHS;
    const double z[2] = {fmin(o.z, 1), fmin(fabs(i.z), 1)}, sum = z[0] + z[1] + MCV_MULTIPLE_LEAST;
    const double turn = atan2(o.y, o.x) - atan2(i.y, i.x), c = fabs(cos(turn / 2));
    const double near = c * (1 + sum) / (c + sum),
                 entry = (m - 1) * (glass ? (near + 1 - fabs(sin(turn / 2))) / 2 : near);
    double place[2], share[2];
    for (int k = 0; k < 2; ++k) place[k] = (n - 1) * sqrt(z[k]) / (sqrt(z[k]) + sqrt(1 - z[k]));
    const int low[2] = {(int)fmin(place[0], n - 2), (int)fmin(place[1], n - 2)},
              first = (int)fmin(entry, m - 2);
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
                (((low[0] + corners[corner][0]) * n + low[1] + corners[corner][1]) * m + first +
                 next);
        for (int word = 0; word < MCV_MULTIPLE_WORDS; ++word)
            words[word] += weight * (double)at[word];
    }
    for (int word = 0; glass && word < MCV_MULTIPLE_WORDS; ++word)
        words[word] = pow(words[word], 4);
}

/* The place of |d| on its axis (mcvisi/materials/brushed.h); `upright` is the mirror image's
 * height. */
static double brushed_place(double d, double m, double alpha, double upright) {
    const double v = m < 1 ? fmin(fabs(d) / (1 - m), 1) : 0,
                 k = MCV_BRUSHED_WIDTH * alpha * upright / fmax(1 - m, 1e-12);
    return (MCV_BRUSHED_HALVES - 1) * (v * (1 + k) / (v + k) + 1 - sqrt(1 - v)) / 2;
}

void ref_brushed_at(const float *orders, const double alpha[2], double roughness, ref_vec o,
                    ref_vec i, double words[MCV_MULTIPLE_WORDS]) {
    enum { M = MCV_BRUSHED_MIDDLES, D = MCV_BRUSHED_HALVES };
    static const int counts[4] = {M, M, D, 2 * D - 1};
    const ref_vec w[2] = {o, {i.x, i.y, fabs(i.z)}};
    double p[2][2], m[2], d[2], upright = 1, places[4];
    for (int k = 0; k < 2; ++k) { /* tan(θ/2) */
        p[k][0] = tan(atan2(w[k].x, w[k].z) / 2);
        p[k][1] = tan(atan2(w[k].y, hypot(w[k].x, w[k].z)) / 2);
    }
    bool turned = false;
    for (int axis = 0; axis < 2; ++axis) {
        m[axis] = fabs(p[0][axis] - p[1][axis]) / 2;
        d[axis] = (p[0][axis] + p[1][axis]) / 2;
        turned ^= (p[0][axis] < p[1][axis]) ^ (d[axis] < 0);
        upright *= cos(2 * atan(m[axis]));
    }
    upright += (double)MCV_BRUSHED_LEAST;
    for (int axis = 0; axis < 2; ++axis) {
        places[axis] = (M - 1) * (1 - sqrt(fmax(1 - m[axis], 0)));
        places[2 + axis] = brushed_place(d[axis], m[axis], alpha[axis], upright);
    }
    places[3] = D - 1 + (turned ? -places[3] : places[3]);
    for (int word = 0; word < MCV_MULTIPLE_WORDS; ++word) words[word] = 0;
    const int layer = (int)fmin(roughness, MCV_MULTIPLE_ROUGHNESSES - 2);
    for (int corner = 0; corner < 32; ++corner) {
        const int above = corner >> 4;
        double weight = above ? roughness - layer : 1 - (roughness - layer);
        size_t at = 0;
        if (weight == 0) continue;
        for (int axis = 0; axis < 4; ++axis) {
            const int low = (int)fmin(places[axis], counts[axis] - 2), next = corner >> axis & 1;
            weight *= next ? places[axis] - low : 1 - (places[axis] - low);
            at = at * (size_t)counts[axis] + (size_t)(low + next);
        }
        const float *table = orders + (size_t)(layer + above) * mcv_multiple_brushed_words();
        for (int word = 0; word < MCV_MULTIPLE_WORDS; ++word)
            words[word] += weight * (double)table[MCV_MULTIPLE_WORDS * at + (size_t)word];
    }
}

/*
 * What leaves of the light from o, over all microfacet normals: D(h) h_z dh is uniform in the
 * azimuth and in u = tan²θ/(α² + tan²θ). The tail u -> 1 has facets that stand upright, seen far
 * larger than they lie: u = 1 - (1 - v)^4 tames it. Reflection: all of it, and (1 - c)^5 of it.
 * Interface (from > 0): what is reflected and refracted together. `normals` is the number of steps
 * of each of the two integrals.
 */
static void integrate(const double alpha[2], ref_vec o, double from, double to, double coating,
                      int normals, double sums[2]) {
    const double own = ref_lambda(alpha, o);
    sums[0] = sums[1] = 0;
    for (int a = 0; a < normals; ++a) {
        const double phi = 2 * M_PI * (a + 0.5) / normals;
        for (int b = 0; b < normals; ++b) {
            const double v = (b + 0.5) / normals, left = (1 - v) * (1 - v),
                         slope = sqrt((1 - left * left) / (left * left));
            const ref_vec h =
                ref_unit((ref_vec){alpha[0] * slope * cos(phi), alpha[1] * slope * sin(phi), 1});
            const double c = ref_dot(o, h);
            if (!(c > 0)) continue;
            const double seen = 4 * (1 - v) * left * c / (o.z * h.z) / (normals * normals);
            const ref_vec r = ref_reflected(o, h);
            const double kept = r.z > 0 ? seen * ref_masking(own, ref_lambda(alpha, r), false) : 0;
            if (!(from > 0)) {
                sums[0] += kept;
                sums[1] += kept * pow(1 - c, 5);
                continue;
            }
            const double fresnel = ref_coated(ref_unpolarised(from, to, c), coating, from, to);
            ref_vec t;
            const bool passes = ref_refracted(o, h, from / to, &t) && t.z < 0;
            sums[0] +=
                fresnel * kept +
                (passes ? (1 - fresnel) * seen * ref_masking(own, ref_lambda(alpha, t), true) : 0);
        }
    }
}

static double cosine_at(uint32_t c) { return fmax(pow(c / (COSINES - 1.0), 2), 1e-5); }

/* The pair for a direction, interpolated; at a roughness as a share of the material's. */
void ref_albedos_at(const ref_albedos *albedos, ref_vec w, double roughness, double pair[2]) {
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

void ref_albedos_mean(const ref_albedos *albedos, double roughness, double pair[2]) {
    const double place = roughness * (albedos->roughnesses - 1),
                 low = fmin(floor(place), fmax(albedos->roughnesses - 2.0, 0));
    const size_t first = (size_t)low, second = (size_t)fmin(low + 1, albedos->roughnesses - 1.0);
    for (size_t k = 0; k < 2; ++k)
        pair[k] = (1 - (place - low)) * albedos->means[2 * first + k] +
                  (place - low) * albedos->means[2 * second + k];
}

static bool albedos_new(ref_albedos *albedos, const mcv_material *material, double outside,
                        int normals) {
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
        ref_alphas(&roughness, share, alpha);
        for (uint32_t a = 0; a < albedos->azimuths; ++a)
            for (uint32_t c = 0; c < COSINES; ++c, pair += 2) {
                const double phi = albedos->azimuths > 1 ? M_PI / 2 * a / (AZIMUTHS - 1) : 0,
                             z = cosine_at(c), sine = sqrt(1 - z * z);
                const ref_vec o = {sine * cos(phi), sine * sin(phi), z};
                if (outside > 0) {
                    double both[2];
                    const double coating = mcv_material_coating(material, outside);
                    integrate(alpha, o, outside, material->as.dielectric.ior[MCV_ALBEDO_CHANNEL],
                              coating, normals, both);
                    pair[0] = fmin(both[0], 1);
                    integrate(alpha, o, material->as.dielectric.ior[MCV_ALBEDO_CHANNEL], outside,
                              coating, normals, both);
                    pair[1] = fmin(both[0], 1);
                } else {
                    integrate(alpha, o, 0, 0, 0, normals, pair);
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
                ref_albedos_at(albedos, (ref_vec){sine * cos(phi), sine * sin(phi), z}, share, at);
                for (int k = 0; k < 2; ++k) albedos->means[2 * r + (uint32_t)k] += z * at[k];
                total += z;
            }
        for (int k = 0; k < 2; ++k) albedos->means[2 * r + (uint32_t)k] /= total;
    }
    return true;
}

/* Tables of multiple scattering at each roughness, where the material is a metal, or glass that has
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
    const bool brushed = roughness.anisotropy > 0,
               metal = conductor || (layered && material->as.metallic_roughness.metallic > 0);
    if (brushed ? !metal : !(outside > 0 || metal)) return true;
    const uint32_t words = brushed       ? mcv_multiple_brushed_words()
                           : outside > 0 ? mcv_interface_words()
                                         : mcv_multiple_words();
    *orders = malloc(sizeof(float) * count * words);
    for (uint32_t i = 0; *orders && i < count; ++i) {
        double alpha[2];
        ref_alphas(&roughness, count > 1 ? i / (count - 1.0) : 1, alpha);
        float *table = *orders + (size_t)i * words;
        made =
            made &&
            (brushed       ? mcv_multiple_brushed(alpha, n, k, table)
             : outside > 0 ? mcv_multiple_interface(alpha[1], outside,
                                                    material->as.dielectric.ior[MCV_ALBEDO_CHANNEL],
                                                    mcv_material_coating(material, outside), table)
                           : mcv_multiple_reflection(alpha[1], n, k, table));
    }
    return *orders && made;
}

static bool add_table(ref_gloss_tables *tables, const mcv_scene *scene, uint32_t material,
                      double outside, bool draft) {
    const mcv_material *from = &scene->materials[material];
    for (uint32_t i = 0; i < tables->count; ++i)
        if (tables->items[i].material == material && tables->items[i].outside == outside)
            return true;
    ref_gloss_table *items = realloc(tables->items, (tables->count + (size_t)1) * sizeof *items);
    if (!items) return false;
    tables->items = items;
    ref_gloss_table *table = &items[tables->count++];
    *table = (ref_gloss_table){.material = material, .outside = outside};
    if (!draft && !orders_new(from, outside, &table->orders)) return false;
    if (!albedos_new(&table->albedos, from, outside, draft ? DRAFT_NORMALS : NORMALS)) return false;
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

mcv_result ref_gloss_tables_new(const mcv_scene *scene, bool draft, ref_gloss_tables *tables,
                                mcv_error *error) {
    *tables = (ref_gloss_tables){0};
    bool made = true;
    for (uint32_t i = 0; i < scene->instance_count && made; ++i) {
        const uint32_t material = scene->instances[i].material;
        const mcv_material *from = &scene->materials[material];
        if (!mcv_material_is_rough(from)) continue;
        if (from->type != MCV_MATERIAL_DIELECTRIC) {
            made = add_table(tables, scene, material, 0, draft);
            continue;
        }
        made = add_table(tables, scene, material, 1, draft);
        for (uint32_t j = 0; j < scene->instance_count && made; ++j) {
            const mcv_material *other = &scene->materials[scene->instances[j].material];
            if (mcv_material_has_medium(other->type) &&
                other->as.medium.ior[MCV_ALBEDO_CHANNEL] !=
                    from->as.dielectric.ior[MCV_ALBEDO_CHANNEL])
                made = add_table(tables, scene, material, other->as.medium.ior[MCV_ALBEDO_CHANNEL],
                                 draft);
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
        ref_alphas(&roughness, 1, alpha);
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
