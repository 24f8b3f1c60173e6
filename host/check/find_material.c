/* SPDX-License-Identifier: Apache-2.0 */
/* Materials whose model is known to be less right than others. */
#include "check/find.h"

#include "scene/materials.h"

static bool is_in_use(const mcv_scene *scene, uint32_t material) {
    for (uint32_t i = 0; i < scene->instance_count; ++i)
        if (scene->instances[i].material == material) return true;
    return false;
}

/* Its microfacets have no table of multiple scattering (device/gloss.c). */
mcv_result mcv_find_brushed_texture(const mcv_scene *scene, mcv_findings *findings,
                                    mcv_error *error) {
    for (uint32_t i = 0; i < scene->material_count; ++i) {
        const mcv_material *m = scene->materials + i;
        if (mcv_material_surface_texture(m) == MCV_NONE ||
            !(mcv_material_roughness(m).anisotropy > 0) ||
            !(m->as.metallic_roughness.metallic > 0) || !is_in_use(scene, i))
            continue;
        MCV_TRY(mcv_findings_add(
            findings, MCV_SEVERITY_NOTE, "materials", m->name, NULL, error,
            "material \"%s\" is brushed metal whose roughness is a texture: what its microfacets "
            "reflect more than once is right in sum, not in direction, so that a low ring looks up "
            "to 23 %% too bright; take one roughness where a dark field is measured",
            m->name));
    }
    return MCV_OK;
}
