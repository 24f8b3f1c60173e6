/* SPDX-License-Identifier: Apache-2.0 */
/* Materials, textures, and how the tile schedule shades an instance. */
#include "device/pack_steps.h"
#include "scene/materials.h"
#include "scene/texture.h"

#include <math.h>

static double largest(const double spectrum[3]) {
    return fmax(spectrum[0], fmax(spectrum[1], spectrum[2]));
}

/* The transmittance of a surface, and the probability with which a path is reflected. */
static void share_out(const double reflectance[3], const double transmittance[3],
                      mcv_device_material *out) {
    const double reflected = largest(reflectance), passed = largest(transmittance);
    for (int k = 0; k < 3; ++k) out->passed[k] = (float)transmittance[k];
    out->chance = reflected + passed > 0 ? (float)(reflected / (reflected + passed)) : 0;
}

/* From this α on, a roughness of 1/2, highlights are tens of degrees wide. */
static const double wide_alpha = 0.25;

/* The non-metallic part scatters widely below its layer, so it is never near-specular. */
static bool is_sharp(const mcv_material *material) {
    const mcv_roughness surface = mcv_material_roughness(material);
    const double alpha = surface.roughness * surface.roughness;
    const bool layered = material->type == MCV_MATERIAL_METALLIC_ROUGHNESS &&
                         (material->as.metallic_roughness.metallic < 1 ||
                          mcv_material_surface_texture(material) != MCV_NONE);
    return mcv_material_is_rough(material) && !layered &&
           alpha + (1 - alpha) * surface.anisotropy < wide_alpha;
}

mcv_device_material mcv_pack_material(const mcv_material *material) {
    mcv_device_material out = {.type = material->type, .texture = material->texture};
    const double *value = NULL;
    switch (material->type) {
    case MCV_MATERIAL_DIFFUSE:
        value = material->as.diffuse.reflectance;
        share_out(value, material->as.diffuse.transmittance, &out);
        out.scattering_sides = largest(material->as.diffuse.transmittance) > 0 ? 2 : 1;
        break;
    case MCV_MATERIAL_MIRROR:
        value = material->as.mirror.reflectance;
        break;
    case MCV_MATERIAL_METALLIC_ROUGHNESS:
        value = material->as.metallic_roughness.baseColor;
        break;
    case MCV_MATERIAL_SHEET: {
        const double n = material->as.sheet.ior;
        value = material->as.sheet.transmittance;
        out.as.sheet =
            (mcv_sheet){.eta = (float)(1 / n), .delta = (float)((n - 1) * (n + 1) / (n * n))};
        break;
    }
    case MCV_MATERIAL_BEAM_SPLITTER: {
        const mcv_beam_splitter_params *p = &material->as.beam_splitter;
        value = p->reflectance;
        share_out(value, p->transmittance, &out);
        break;
    }
    case MCV_MATERIAL_RETROREFLECTOR: {
        const mcv_retroreflector_params *p = &material->as.retroreflector;
        value = p->reflectance;
        for (int k = 0; k < 3; ++k) out.passed[k] = (float)p->diffuseReflectance[k];
        out.as.retroreflector = (mcv_retroreflector){
            .spread = p->divergence > 0 ? (float)tan(fmax(p->divergence, MCV_LEAST_DIVERGENCE)) : 0,
            .fall = (float)(1 / tan(p->entranceAngle))};
        out.scattering_sides = p->divergence > 0 || largest(p->diffuseReflectance) > 0;
        break;
    }
    default:
        break;
    }
    for (int k = 0; value && k < 3; ++k) out.color[k] = (float)value[k];
    if (mcv_material_is_rough(material))
        out.scattering_sides = material->type == MCV_MATERIAL_CONDUCTOR ? 1 : 2;
    const double roughness = mcv_material_roughness(material).roughness;
    const bool matt =
        material->type == MCV_MATERIAL_METALLIC_ROUGHNESS && roughness * roughness >= wide_alpha;
    if (material->type == MCV_MATERIAL_DIFFUSE || matt) out.broad_lobe = 1;
    out.near_specular = is_sharp(material);
    return out;
}

/* Words of device memory per texel. */
size_t mcv_texel_words(const mcv_texture *texture) { return texture->linear ? 3 : 1; }

/* The first texel's word; textures that share pixels share it. */
static uint32_t first_texel(const mcv_scene *scene, const mcv_packed *packed, uint32_t texture,
                            size_t next) {
    const mcv_texture *t = &scene->textures[texture];
    for (uint32_t i = 0; t->shares_pixels && i < texture; ++i)
        if (scene->textures[i].rgba == t->rgba && scene->textures[i].linear == t->linear)
            return packed->textures[i].first;
    return (uint32_t)next;
}

void mcv_pack_textures(const mcv_scene *scene, mcv_packed *packed) {
    static const double as_it_is[6] = {1, 0, 0, 0, 1, 0};
    size_t next = 256;
    for (unsigned i = 0; i < 256; ++i)
        packed->texels[i] = as_uint((float)mcv_srgb_decode((uint8_t)i));
    for (uint32_t i = 0; i < scene->texture_count; ++i) {
        const mcv_texture *texture = &scene->textures[i];
        packed->textures[i] =
            (mcv_device_texture){.width = texture->width,
                                 .height = texture->height,
                                 .first = first_texel(scene, packed, i, next),
                                 .first_texcoord = texture->texcoord_set * packed->vertex_count,
                                 .wrap_s = texture->wrap_s,
                                 .wrap_t = texture->wrap_t,
                                 .nearest = texture->nearest,
                                 .linear = texture->linear != NULL};
        for (int k = 0; k < 6; ++k)
            packed->textures[i].transform[k] =
                (float)(texture->is_transformed ? texture->transform : as_it_is)[k];
        if (texture->shares_pixels) continue;
        const size_t texels = (size_t)texture->width * texture->height;
        for (size_t k = 0; texture->linear && k < 3 * texels; ++k, ++next)
            packed->texels[next] = as_uint(texture->linear[k]);
        for (size_t k = 0; texture->rgba && k < texels; ++k, ++next) {
            const uint8_t *rgba = texture->rgba + 4 * k;
            packed->texels[next] = rgba[0] | (uint32_t)rgba[1] << 8 | (uint32_t)rgba[2] << 16 |
                                   (uint32_t)rgba[3] << 24;
        }
    }
}

/* How the tile schedule shades an instance's surface (kernels/schedule/ranges.h), when all else is
 * known. */
uint32_t mcv_instance_shading(const mcv_packed *packed, const mcv_device_instance *instance) {
    const mcv_device_material *m = &packed->materials[instance->material];
    const mcv_device_emitter *e =
        instance->emitter == MCV_NONE ? NULL : packed->emitters + instance->emitter;
    if (m->type == MCV_MATERIAL_ABSORBER && !e) return MCV_SHADING_BLACK;
    if (m->type == MCV_MATERIAL_ABSORBER && packed->emitter_count <= MCV_MOST_LAMPS &&
        e->texture == MCV_NONE && (e->type == MCV_EMITTER_AREA || e->type == MCV_EMITTER_PARALLEL))
        return MCV_SHADING_BLACK + 1 + instance->emitter;
    if (e) return MCV_SHADING_ANY;
    if (m->type == MCV_MATERIAL_DIFFUSE)
        return m->scattering_sides == 1 ? MCV_SHADING_DIFFUSE : MCV_SHADING_ANY;
    if (m->type == MCV_MATERIAL_DIELECTRIC && !m->scattering_sides)
        return m->texture == MCV_NONE ? MCV_SHADING_SMOOTH : MCV_SHADING_ANY;
    return packed->glossy && m->scattering_sides && !mcv_material_has_own_bsdf(m->type)
               ? MCV_SHADING_GLOSSY
               : MCV_SHADING_ANY;
}
