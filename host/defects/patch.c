/* SPDX-License-Identifier: Apache-2.0 */
/* Patches of another material: stains and rough patches (mcvisi/defects.h). */
#include "defects/facets.h"

#include "scene/materials.h"
#include "scene/mesh.h"
#include "scene/params.h"

/* A copy of the material with the defect's roughness. */
static mcv_result roughen(mcv_scene *scene, uint32_t number, const mcv_defect *defect,
                          uint32_t *patch, const mcv_json_path *place, mcv_error *error) {
    mcv_material own = scene->materials[number];
    const mcv_param_table table = mcv_material_table(own.type);
    double *roughness = mcv_params_find(table, "roughness", &own.as);
    if (!roughness)
        return mcv_fail_at(place, error,
                           "lies on \"%s\", a material without a roughness: give a stain with a "
                           "material of its own",
                           own.name);
    *roughness = defect->roughness;
    MCV_TRY(mcv_scene_add_material(scene, &own, error));
    *patch = scene->material_count - 1;
    scene->materials[*patch].by_name = own.by_name; /* n and k follow the scene's wavelengths */
    return MCV_OK;
}

/* What the patch would leave of the facets. */
static bool leaves_nothing(const mcv_facets *facets, uint32_t instance) {
    for (size_t f = 0; f < facets->count; ++f)
        if (facets->items[f].instance == instance && !facets->items[f].within) return false;
    return true;
}

static bool has_patch(const mcv_facets *facets, uint32_t instance) {
    for (size_t f = 0; f < facets->count; ++f)
        if (facets->items[f].instance == instance && facets->items[f].within) return true;
    return false;
}

mcv_result mcv_facets_add_patch(const mcv_facets *facets, mcv_scene *scene, uint32_t instance,
                                bool alone, const mcv_defect *defect, const mcv_json_path *place,
                                mcv_error *error) {
    mcv_instance own = scene->instances[instance];
    const mcv_material *host = scene->materials + own.material;
    mcv_mesh mesh;
    if (!has_patch(facets, instance)) return MCV_OK;
    if (mcv_material_has_medium(host->type))
        return mcv_fail_at(place, error,
                           "lies on \"%s\", a dielectric: a patch of another material would open "
                           "its body; use a dig or a scratch",
                           host->name);
    if (alone && leaves_nothing(facets, instance))
        return mcv_fail_at(place, error,
                           "covers all of node \"%s\": give the node that material instead",
                           own.name);
    own.material = defect->material;
    if (defect->type == MCV_DEFECT_ROUGH_PATCH)
        MCV_TRY(roughen(scene, scene->instances[instance].material, defect, &own.material, place,
                        error));
    MCV_TRY(mcv_facets_mesh(facets, scene, instance, NULL, true, true, &mesh, place, error));
    MCV_TRY(mcv_scene_take_mesh(scene, &mesh, error));
    own.mesh = scene->mesh_count - 1;
    return mcv_scene_insert_instance(scene, instance, &own, error);
}
