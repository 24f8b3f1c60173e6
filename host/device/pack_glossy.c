/* SPDX-License-Identifier: Apache-2.0 */
#include "device/pack_glossy.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "mcvisi/materials/microfacet.h"
#include "device/albedo.h"
#include "device/multiple.h"
#include "scene/materials.h"

/* α along the tangent and across, as the device computes it. */
static void alphas(double roughness, double anisotropy, double alpha[2]) {
    alpha[1] = fmax(roughness * roughness, MCV_LEAST_ALPHA);
    alpha[0] = alpha[1] + (1 - alpha[1]) * anisotropy;
}

/* Floats of a table, for each of its roughnesses. */
static uint32_t words_of(const mcv_albedo_source *source) {
    const uint32_t behind = source->n_outside > 0 && source->azimuths == 1
                                ? mcv_interface_words()
                                : 0; /* an interface's albedos */
    if (source->multiple)
        return source->azimuths > 1 ? mcv_multiple_brushed_words() : mcv_multiple_words();
    return mcv_albedo_words(source->azimuths) + behind;
}

/* False: no memory. */
static bool integrate(const mcv_albedo_source *source, float *table) {
    const uint32_t words = words_of(source);
    const bool metal = source->n[0] > 0 || source->k[0] > 0;
    bool made = true;
    for (uint32_t r = 0; r < source->roughnesses; ++r) {
        const double share = source->roughnesses > 1 ? (double)r / (source->roughnesses - 1) : 1;
        double alpha[2];
        alphas(share * source->roughness, source->anisotropy, alpha);
        float *block = table + (size_t)r * words;
        float *multiple =
            source->azimuths == 1 ? block + mcv_albedo_words(1) : NULL; /* of an interface */
        const double *n = metal ? source->n : NULL, *k = metal ? source->k : NULL;
        if (source->multiple && source->azimuths > 1) {
            made &= mcv_multiple_brushed(alpha, n, k, block);
        } else if (source->multiple) {
            made &= mcv_multiple_reflection(alpha[1], n, k, block);
        } else if (source->n_outside > 0) {
            made &=
                !multiple || mcv_multiple_interface(alpha[1], source->n_outside, source->n_inside,
                                                    source->coating, multiple);
            mcv_albedo_interface(alpha[0], alpha[1], source->n_outside, source->n_inside,
                                 source->coating, source->azimuths, block);
        } else {
            mcv_albedo_reflection(alpha[0], alpha[1], source->azimuths, block);
        }
    }
    return made;
}

static const mcv_albedo_source *find_source(const mcv_packed *packed,
                                            const mcv_albedo_source *like) {
    for (uint32_t i = 0; packed && i < packed->albedo_source_count; ++i) {
        const mcv_albedo_source *s = packed->albedo_sources + i;
        if (s->roughness == like->roughness && s->anisotropy == like->anisotropy &&
            s->n_outside == like->n_outside && s->n_inside == like->n_inside &&
            s->coating == like->coating && s->azimuths == like->azimuths &&
            s->roughnesses == like->roughnesses && s->multiple == like->multiple &&
            memcmp(s->n, like->n, sizeof s->n) == 0 && memcmp(s->k, like->k, sizeof s->k) == 0)
            return s;
    }
    return NULL;
}

/* The table from this source: an existing one, one of the previous scene, or a new one. For
 * features alone none is made. */
static mcv_result find_table(const mcv_packed *earlier, mcv_packed *packed,
                             mcv_albedo_source source, uint32_t *table, mcv_error *error) {
    *table = MCV_NONE;
    if (packed->for_features_alone) return MCV_OK;
    const mcv_albedo_source *found = find_source(packed, &source);
    if (found) {
        *table = found->table;
        return MCV_OK;
    }
    const size_t words = (size_t)words_of(&source) * source.roughnesses;
    float *albedos = realloc(packed->albedos, (packed->albedo_count + words) * sizeof *albedos);
    if (albedos) packed->albedos = albedos;
    mcv_albedo_source *sources =
        realloc(packed->albedo_sources, (packed->albedo_source_count + 1) * sizeof *sources);
    if (sources) packed->albedo_sources = sources;
    if (!albedos || !sources)
        return mcv_fail(error, MCV_FAILED, "no memory for the albedos of microfacets");
    source.table = *table = (uint32_t)packed->albedo_count;
    found = find_source(earlier, &source);
    if (found)
        memcpy(albedos + *table, earlier->albedos + found->table, words * sizeof *albedos);
    else if (!integrate(&source, albedos + *table))
        return mcv_fail(error, MCV_FAILED, "no memory for the multiple scattering of microfacets");
    sources[packed->albedo_source_count++] = source;
    packed->albedo_count += words;
    return MCV_OK;
}

/* The light after reflection between microfacets: Σ over 2, 3 … reflections, after each of which
 * the share E escapes. */
static double left_by_facets(double reflectance, double missing) {
    return reflectance * reflectance * (1 - missing) / (1 - reflectance * missing);
}

static bool in_use(const mcv_scene *scene, uint32_t material) {
    for (uint32_t i = 0; i < scene->instance_count; ++i)
        if (scene->instances[i].material == material) return true;
    return false;
}

mcv_result mcv_pack_glossy(const mcv_scene *scene, const mcv_packed *earlier, mcv_packed *packed,
                           mcv_error *error) {
    for (uint32_t i = 0; i < scene->material_count; ++i) {
        const mcv_material *from = &scene->materials[i];
        mcv_device_glossy *to = &packed->glossy[i];
        const mcv_roughness roughness = mcv_material_roughness(from);
        *to = (mcv_device_glossy){
            .roughness = (float)roughness.roughness,
            .anisotropy = (float)(roughness.anisotropy * roughness.anisotropy),
            .direction = {(float)cos(roughness.rotation), (float)sin(roughness.rotation)},
            .table = MCV_NONE,
            .multiple = MCV_NONE,
            .azimuths = roughness.anisotropy > 0 ? MCV_ALBEDO_AZIMUTHS : 1,
            .roughnesses = 1,
            .texture = mcv_material_surface_texture(from)};
        if (to->texture != MCV_NONE) to->roughnesses = MCV_ALBEDO_ROUGHNESSES;
        if (!in_use(scene, i)) continue;
        const mcv_albedo_source source = {.roughness = to->roughness,
                                          .anisotropy = to->anisotropy,
                                          .azimuths = to->azimuths,
                                          .roughnesses = to->roughnesses};
        if (from->type == MCV_MATERIAL_METALLIC_ROUGHNESS) {
            const mcv_metallic_roughness_params *p = &from->as.metallic_roughness;
            to->metallic = (float)p->metallic;
            to->f0 = (float)pow((p->ior - 1) / (p->ior + 1), 2);
            to->transmission = (float)p->transmission;
            to->diffuse_transmission = (float)p->diffuseTransmission;
            MCV_TRY(find_table(earlier, packed, source, &to->table, error));
        }
        mcv_albedo_source multiple = source;
        multiple.multiple = true;
        if (multiple.roughnesses > 1) multiple.roughnesses = MCV_MULTIPLE_ROUGHNESSES;
        if (from->type == MCV_MATERIAL_METALLIC_ROUGHNESS && to->metallic > 0)
            MCV_TRY(find_table(earlier, packed, multiple, &to->multiple, error));
        if (from->type != MCV_MATERIAL_CONDUCTOR) continue;
        for (int k = 0; k < 3; ++k) {
            to->n[k] = (float)from->as.conductor.n[k];
            to->k[k] = (float)from->as.conductor.k[k];
        }
        if (!mcv_material_is_rough(from)) continue;
        MCV_TRY(find_table(earlier, packed, source, &to->table, error));
        memcpy(multiple.n, from->as.conductor.n, sizeof multiple.n);
        memcpy(multiple.k, from->as.conductor.k, sizeof multiple.k);
        MCV_TRY(find_table(earlier, packed, multiple, &to->multiple, error));
        for (int k = 0; k < 3 && to->table != MCV_NONE; ++k)
            packed->materials[i].color[k] = (float)left_by_facets(
                mcv_conductor_mean(from->as.conductor.n[k], from->as.conductor.k[k]),
                packed->albedos[to->table]);
    }
    return MCV_OK;
}

/*
 * An interface spreads light by α times its relative step of index. Below this value its directions
 * differ by less than 100 roundings of a float32: it is taken as smooth.
 */
static const double least_spread = 1e-5;

mcv_result mcv_pack_interfaces(const mcv_scene *scene, const mcv_packed *earlier,
                               mcv_packed *packed, uint32_t count, const uint32_t *materials,
                               const double *index, mcv_error *error) {
    enum { WIDTH = MCV_MAX_MEDIA + 1 };
    for (uint32_t i = 0; i < WIDTH * WIDTH; ++i) packed->interface_albedos[i] = MCV_NONE;
    /* The later one of two media owns the surface between them, because it has the higher
     * priority. */
    for (uint32_t inside = 1; inside <= count; ++inside) {
        const mcv_material *material = &scene->materials[materials[inside]];
        const mcv_device_glossy *glossy = &packed->glossy[materials[inside]];
        double alpha[2];
        if (!mcv_material_is_rough(material)) continue;
        alphas(glossy->roughness, glossy->anisotropy, alpha);
        for (uint32_t outside = 0; outside < inside; ++outside) {
            if (alpha[1] * fabs(index[inside] - index[outside]) / index[outside] < least_spread)
                continue;
            const mcv_albedo_source source = {.roughness = glossy->roughness,
                                              .anisotropy = glossy->anisotropy,
                                              .n_outside = index[outside],
                                              .n_inside = index[inside],
                                              .coating =
                                                  mcv_material_coating(material, index[outside]),
                                              .azimuths = glossy->azimuths,
                                              .roughnesses = 1};
            uint32_t table;
            MCV_TRY(find_table(earlier, packed, source, &table, error));
            packed->interface_albedos[outside * WIDTH + inside] =
                packed->interface_albedos[inside * WIDTH + outside] = table;
        }
    }
    return MCV_OK;
}
