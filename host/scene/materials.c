/* SPDX-License-Identifier: Apache-2.0 */
/* What several kinds of material have in common. */
#include "scene/materials.h"

mcv_roughness mcv_material_roughness(const mcv_material *material) {
    switch (material->type) {
    case MCV_MATERIAL_CONDUCTOR: {
        const mcv_conductor_params *p = &material->as.conductor;
        return (mcv_roughness){p->roughness, p->roughness > 0 ? p->anisotropy : 0,
                               p->anisotropyRotation};
    }
    case MCV_MATERIAL_METALLIC_ROUGHNESS: {
        const mcv_metallic_roughness_params *p = &material->as.metallic_roughness;
        return (mcv_roughness){p->roughness, p->anisotropy, p->anisotropyRotation};
    }
    case MCV_MATERIAL_DIELECTRIC: {
        const mcv_dielectric_params *p = &material->as.dielectric;
        return (mcv_roughness){p->roughness, p->roughness > 0 ? p->anisotropy : 0,
                               p->anisotropyRotation};
    }
    default:
        return (mcv_roughness){0, 0, 0};
    }
}

bool mcv_material_has_own_bsdf(uint32_t type) { return MCV_IS_MATERIAL_OF(MCV_OWN_BSDFS, type); }

bool mcv_material_is_plate(uint32_t type) { return MCV_IS_MATERIAL_OF(MCV_PLATES, type); }

bool mcv_material_has_medium(uint32_t type) {
    return MCV_IS_MATERIAL_OF(MCV_MEDIUM_MATERIALS, type);
}

bool mcv_material_is_rough(const mcv_material *material) {
    return material->type == MCV_MATERIAL_METALLIC_ROUGHNESS ||
           mcv_material_roughness(material).roughness > 0;
}

uint32_t mcv_material_surface_texture(const mcv_material *material) {
    return material->type == MCV_MATERIAL_METALLIC_ROUGHNESS ? material->surface_texture : MCV_NONE;
}

double mcv_material_coating(const mcv_material *material, double outside) {
    const double densest_gas = 1.1;
    return material->type == MCV_MATERIAL_DIELECTRIC && outside < densest_gas
               ? material->as.dielectric.coating
               : 0;
}

bool mcv_scene_has_directions(const mcv_scene *scene) {
    for (uint32_t i = 0; i < scene->instance_count; ++i)
        if (mcv_material_roughness(&scene->materials[scene->instances[i].material]).anisotropy > 0)
            return true;
    return false;
}
