/* SPDX-License-Identifier: Apache-2.0 */
#include "render/gloss.h"

#include <math.h>
#include <stdlib.h>

#include "mcvisi/materials/microfacet.h"
#include "render/albedo.h"

/* Room for more albedos, or NULL. *table gets where they begin. */
static float *grow(mcv_packed *packed, size_t words, uint32_t *table) {
    float *albedos = realloc(packed->albedos, (packed->albedo_count + words) * sizeof *albedos);
    if (!albedos) return NULL;
    *table = (uint32_t)packed->albedo_count;
    packed->albedos = albedos;
    packed->albedo_count += words;
    return albedos + *table;
}

/* α along the tangent and across, as the device computes it. */
static void alphas(double roughness, double anisotropy, double alpha[2]) {
    alpha[1] = fmax(roughness * roughness, MCV_LEAST_ALPHA);
    alpha[0] = alpha[1] + (1 - alpha[1]) * anisotropy;
}

static bool same_table(const mcv_device_gloss *a, const mcv_device_gloss *b) {
    return a->roughness == b->roughness && a->anisotropy == b->anisotropy && a->roughnesses == b->roughnesses;
}

/* The table of material i: that of an earlier one where they are alike. */
static mcv_result find_table(const mcv_scene *scene, mcv_packed *packed, uint32_t i, mcv_error *error) {
    mcv_device_gloss *gloss = &packed->gloss[i];
    for (uint32_t j = 0; j < i; ++j) {
        if (packed->gloss[j].table == MCV_NONE || !same_table(gloss, &packed->gloss[j])) continue;
        gloss->table = packed->gloss[j].table;
        return MCV_OK;
    }
    const uint32_t words = mcv_albedo_words(gloss->azimuths);
    float *block = grow(packed, (size_t)words * gloss->roughnesses, &gloss->table);
    if (!block) return mcv_fail(error, MCV_FAILED, "%s: no memory for the albedos of material %u", scene->path, i);
    for (uint32_t r = 0; r < gloss->roughnesses; ++r) {
        const double share = gloss->roughnesses > 1 ? (double)r / (gloss->roughnesses - 1) : 1;
        double alpha[2];
        alphas(share * gloss->roughness, gloss->anisotropy, alpha);
        mcv_albedo_reflection(alpha[0], alpha[1], gloss->azimuths, block + (size_t)r * words);
    }
    return MCV_OK;
}

/* What reflection from facet to facet leaves: Σ over 2, 3 … reflections of which the share E escapes each time. */
static double left_by_facets(double reflectance, double missing) {
    return reflectance * reflectance * (1 - missing) / (1 - reflectance * missing);
}

static bool in_use(const mcv_scene *scene, uint32_t material) {
    for (uint32_t i = 0; i < scene->instance_count; ++i)
        if (scene->instances[i].material == material) return true;
    return false;
}

mcv_result mcv_pack_gloss(const mcv_scene *scene, mcv_packed *packed, mcv_error *error) {
    for (uint32_t i = 0; i < scene->material_count; ++i) {
        const mcv_material *from = &scene->materials[i];
        mcv_device_gloss *to = &packed->gloss[i];
        const mcv_roughness roughness = mcv_material_roughness(from);
        *to = (mcv_device_gloss){.roughness = (float)roughness.roughness,
                                 .anisotropy = (float)(roughness.anisotropy * roughness.anisotropy),
                                 .direction = {(float)cos(roughness.rotation), (float)sin(roughness.rotation)},
                                 .table = MCV_NONE,
                                 .azimuths = roughness.anisotropy > 0 ? MCV_ALBEDO_AZIMUTHS : 1,
                                 .roughnesses = 1,
                                 .texture = mcv_material_surface_texture(from)};
        if (to->texture != MCV_NONE) to->roughnesses = MCV_ALBEDO_ROUGHNESSES;
        if (!in_use(scene, i)) continue;
        if (from->type == MCV_MATERIAL_METALLIC_ROUGHNESS) {
            const mcv_metallic_roughness_params *p = &from->as.metallic_roughness;
            to->metallic = (float)p->metallic;
            to->f0 = (float)pow((p->ior - 1) / (p->ior + 1), 2);
            to->transmission = (float)p->transmission;
            to->diffuse_transmission = (float)p->diffuseTransmission;
            MCV_TRY(find_table(scene, packed, i, error));
        }
        if (from->type != MCV_MATERIAL_CONDUCTOR) continue;
        for (int k = 0; k < 3; ++k) {
            to->n[k] = (float)from->as.conductor.n[k];
            to->k[k] = (float)from->as.conductor.k[k];
        }
        if (!mcv_material_is_rough(from)) continue;
        MCV_TRY(find_table(scene, packed, i, error));
        for (int k = 0; k < 3; ++k)
            packed->materials[i].value[k] =
                (float)left_by_facets(mcv_conductor_mean(from->as.conductor.n[k], from->as.conductor.k[k]), packed->albedos[to->table]);
    }
    return MCV_OK;
}

/*
 * Below this the directions in which an interface spreads light, α times its relative step of index, differ by less than 100
 * roundings of a float32: it is taken as smooth.
 */
static const double least_spread = 1e-5;

mcv_result mcv_pack_interfaces(const mcv_scene *scene, mcv_packed *packed, uint32_t count, const uint32_t *materials, const double *index,
                               mcv_error *error) {
    enum { WIDTH = MCV_MAX_MEDIA + 1 };
    for (uint32_t i = 0; i < WIDTH * WIDTH; ++i) packed->interface_albedos[i] = MCV_NONE;
    /* Of two media that meet, the later one owns the surface between them: it has the higher priority. */
    for (uint32_t inside = 1; inside <= count; ++inside) {
        const mcv_material *material = &scene->materials[materials[inside]];
        const mcv_device_gloss *gloss = &packed->gloss[materials[inside]];
        double alpha[2];
        if (!mcv_material_is_rough(material)) continue;
        alphas(gloss->roughness, gloss->anisotropy, alpha);
        for (uint32_t outside = 0; outside < inside; ++outside) {
            if (alpha[1] * fabs(index[inside] - index[outside]) / index[outside] < least_spread) continue;
            uint32_t table = MCV_NONE;
            for (uint32_t other = 0; other < outside && table == MCV_NONE; ++other) /* the same material meets the same index */
                if (index[other] == index[outside]) table = packed->interface_albedos[other * WIDTH + inside];
            for (uint32_t other = 1; other < inside && table == MCV_NONE; ++other)
                if (materials[other] == materials[inside]) table = packed->interface_albedos[outside * WIDTH + other];
            if (table == MCV_NONE) {
                float *block = grow(packed, mcv_albedo_words(gloss->azimuths), &table);
                if (!block) return mcv_fail(error, MCV_FAILED, "%s: no memory for the albedos of rough interfaces", scene->path);
                mcv_albedo_interface(alpha[0], alpha[1], index[outside], index[inside], mcv_material_coating(material, index[outside]),
                                     gloss->azimuths, block);
            }
            packed->interface_albedos[outside * WIDTH + inside] = packed->interface_albedos[inside * WIDTH + outside] = table;
        }
    }
    return MCV_OK;
}
