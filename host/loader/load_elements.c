/* SPDX-License-Identifier: Apache-2.0 */
/* The definitions in MCVISI_sensors and MCVISI_emitters, and the emitters that nodes place. */
#include "loader/loader.h"

#include "scene/emitters.h"
#include "scene/mesh.h"
#include "scene/params.h"
#include "scene/sensors.h"
#include "scene/transform.h"

#include <stdlib.h>

/* --- definitions --- */

/* A projector needs an image or a pattern. */
static mcv_result check_picture(mcv_emitter *emitter, const mcv_json_path *place,
                                mcv_error *error) {
    const mcv_pattern *pattern = mcv_emitter_pattern(emitter);
    const mcv_json_path image = mcv_json_path_key(place, "image"),
                        index = mcv_json_path_key(place, "index");
    if (!pattern) return MCV_OK;
    if (pattern->type == MCV_NONE && *mcv_emitter_image(emitter) == MCV_NONE)
        return mcv_fail_at(&image, error,
                           "is missing: index or name of one of the file's images, {\"uri\": "
                           "FILE.exr}, or give a pattern");
    if (pattern->type != MCV_NONE && *mcv_emitter_image(emitter) != MCV_NONE)
        return mcv_fail_at(place, error, "has both image and pattern: give one of them");
    if (pattern->type == MCV_NONE && *mcv_emitter_index(emitter) != 0)
        return mcv_fail_at(&index, error,
                           "is the index in a pattern's sequence, but there is no pattern");
    return MCV_OK;
}

static mcv_result define_emitter(const mcv_scene *scene, const json_t *object, mcv_emitter *emitter,
                                 mcv_preset *preset, const mcv_json_path *place, mcv_error *error) {
    uint32_t type;
    MCV_TRY(
        mcv_element_type(object, mcv_emitter_types, MCV_EMITTER_TYPE_COUNT, &type, place, error));
    const mcv_param_table table = mcv_emitter_table(type);
    const bool is_preset = type >= MCV_EMITTER_COUNT;
    preset->type = is_preset ? type : MCV_NONE;
    void *params = is_preset ? (void *)&preset->as : (void *)&emitter->as;
    mcv_params_set_defaults(table, params);
    MCV_TRY(mcv_params_parse(table, object, mcv_element_keys, params, place, error));
    emitter->name = (char *)mcv_json_name(object);
    emitter->type = type;
    emitter->bare_angle = json_is_number(json_object_get(object, "halfAngle")) ||
                          json_is_number(json_object_get(object, "outerConeAngle"));
    if (is_preset)
        MCV_TRY(mcv_preset_resolve(preset, emitter, place, error));
    else
        MCV_TRY(check_picture(emitter, place, error));
    emitter->texture = MCV_NONE;
    emitter->area = 1; /* placeholder: here only the presence of radiance or power is checked */
    MCV_TRY(mcv_emitter_check(emitter, place, error));
    return mcv_emitter_resolve(scene, emitter, place, error);
}

mcv_result mcv_load_definitions(mcv_loader *loader, mcv_error *error) {
    json_t *sensors, *emitters;
    MCV_TRY(mcv_load_array(loader, "MCVISI_sensors", "sensors", &sensors, error));
    MCV_TRY(mcv_load_array(loader, "MCVISI_emitters", "emitters", &emitters, error));
    loader->sensor_count = json_array_size(sensors);
    loader->emitter_count = json_array_size(emitters);
    loader->sensors = calloc(loader->sensor_count + 1, sizeof *loader->sensors);
    loader->emitters = calloc(loader->emitter_count + 1, sizeof *loader->emitters);
    loader->presets = calloc(loader->emitter_count + 1, sizeof *loader->presets);
    loader->sensor_uses = calloc(loader->sensor_count + 1, sizeof *loader->sensor_uses);
    loader->emitter_uses = calloc(loader->emitter_count + 1, sizeof *loader->emitter_uses);
    if (!loader->sensors || !loader->emitters || !loader->presets || !loader->sensor_uses ||
        !loader->emitter_uses)
        return mcv_fail_memory(&loader->file, error);
    const mcv_json_path sensors_place = mcv_json_path_key(&loader->file, "sensors"),
                        emitters_place = mcv_json_path_key(&loader->file, "emitters");
    for (size_t i = 0; i < loader->sensor_count; ++i) {
        const json_t *object = json_array_get(sensors, i);
        const mcv_json_path here = mcv_json_path_element(&sensors_place, mcv_json_name(object), i);
        MCV_TRY(mcv_define_sensor(object, loader->sensors + i, &here, error));
    }
    for (size_t i = 0; i < loader->emitter_count; ++i) {
        const json_t *object = json_array_get(emitters, i);
        const mcv_json_path here = mcv_json_path_element(&emitters_place, mcv_json_name(object), i);
        MCV_TRY(define_emitter(loader->scene, object, loader->emitters + i, loader->presets + i,
                               &here, error));
    }
    return MCV_OK;
}

/* --- emitters --- */

/* Each of a node's meshes emits the same radiance: a power is divided by area. */
static mcv_result add_emitters(mcv_loader *loader, const mcv_emitter *emitter, uint32_t first,
                               uint32_t last, mcv_error *error) {
    double total = 0;
    for (uint32_t i = first; i < last; ++i) total += mcv_scene_area(loader->scene, i);
    for (uint32_t i = first; i < last; ++i) {
        mcv_emitter part = *emitter;
        double *power = mcv_emitter_parameter(&part, "power");
        part.instance = i;
        const double share =
            last - first > 1 && total > 0 ? mcv_scene_area(loader->scene, i) / total : 1;
        if (share == 0) continue; /* this mesh has no area, but others have */
        for (int k = 0; power && k < 3; ++k) power[k] *= share;
        MCV_TRY(mcv_scene_add_emitter(loader->scene, &part, error));
    }
    return MCV_OK;
}

static bool emits(const mcv_emission *emission) {
    return emission->radiance[0] + emission->radiance[1] + emission->radiance[2] > 0;
}

/* Instances whose material emits. */
static mcv_result add_emissive(mcv_loader *loader, uint32_t first, uint32_t last,
                               mcv_error *error) {
    const size_t materials = json_array_size(json_object_get(loader->root, "materials"));
    for (uint32_t i = first; i < last; ++i) {
        const mcv_emission *emission = NULL;
        for (size_t m = 0; m < materials && !emission; ++m)
            if (loader->materials[m] == loader->scene->instances[i].material &&
                emits(loader->emission + m))
                emission = loader->emission + m;
        if (!emission) continue;
        mcv_emitter emitter = {.name = loader->scene->instances[i].name,
                               .type = MCV_EMITTER_AREA,
                               .instance = i,
                               .texture = emission->texture};
        mcv_params_set_defaults(mcv_emitter_table(emitter.type), &emitter.as);
        memcpy(emitter.as.area.radiance, emission->radiance, sizeof emission->radiance);
        MCV_TRY(mcv_scene_add_emitter(loader->scene, &emitter, error));
    }
    return MCV_OK;
}

/* Warns that the mirroring of a node has no effect on light with an image. */
static mcv_result warn_of_mirroring(mcv_loader *loader, mcv_emitter *emitter,
                                    const mcv_transform *to_world, mcv_error *error) {
    const uint32_t *image = mcv_emitter_image(emitter);
    if (!image || *image == MCV_NONE || mcv_transform_determinant(to_world) > 0) return MCV_OK;
    return mcv_scene_warn(
        loader->scene, error,
        "emitter \"%s\": its node mirrors (a negative scale), which has no effect on its "
        "light; to mirror it, flip the image%s",
        emitter->name,
        mcv_emitter_parameter(emitter, "mirror") ? ", or write \"mirror\": true into the emitter"
                                                 : "");
}

mcv_result mcv_load_emitter(mcv_loader *loader, const json_t *node, const mcv_transform *to_world,
                            uint32_t first, uint32_t last, const mcv_json_path *place,
                            mcv_error *error) {
    uint32_t index;
    if (loader->is_asset) return add_emissive(loader, first, last, error);
    MCV_TRY(mcv_load_reference(node, "MCVISI_emitters", "emitter", loader->emitter_count,
                               "emitters", &index, place, error));
    if (index == MCV_NONE) return add_emissive(loader, first, last, error);
    mcv_emitter emitter = loader->emitters[index];
    ++loader->emitter_uses[index];
    if (loader->presets[index].type == MCV_NONE)
        MCV_TRY(warn_of_mirroring(loader, &emitter, to_world, error));
    if (!mcv_emitter_has_surface(emitter.type)) {
        if (!mcv_transform_rigid(to_world, &emitter.to_world))
            return mcv_fail_at(place, error, "its scale must not be 0");
        MCV_TRY(mcv_scene_add_emitter(loader->scene, &emitter, error));
        return add_emissive(loader, first, last, error);
    }
    const mcv_json_path emitters = mcv_json_path_key(&loader->file, "emitters"),
                        here = mcv_json_path_element(&emitters, emitter.name, index);
    if (loader->presets[index].type != MCV_NONE) {
        if (json_object_get(node, "mesh"))
            return mcv_fail_at(
                &here, error,
                "a %s has a shape of its own, but node \"%s\" has a mesh: put it on another node",
                mcv_emitter_types[loader->presets[index].type], mcv_json_name(node));
        MCV_TRY(mcv_load_preset(loader, loader->presets + index, mcv_json_name(node), to_world,
                                place, error));
        return add_emitters(loader, &emitter, first, first + 1, error);
    }
    double size[2];
    mcv_emitter_size(loader->scene, &emitter, size);
    const bool rectangle = !isnan(size[0]);
    if (json_object_get(node, "mesh") && rectangle)
        return mcv_fail_at(
            &here, error,
            "%s is for a node without a mesh, but node \"%s\" has one: leave one of them out",
            mcv_emitter_parameter(&emitter, "size") ? "size"
            : emitter.type == MCV_EMITTER_SCREEN    ? "a screen"
                                                    : "a lens",
            mcv_json_name(node));
    if (!json_object_get(node, "mesh")) {
        if (!rectangle)
            return mcv_fail_at(&here, error,
                               "needs size, because its node \"%s\" has no mesh to emit from",
                               mcv_json_name(node));
        MCV_TRY(emitter.type == MCV_EMITTER_SCREEN
                    ? mcv_load_screen(loader, mcv_json_name(node), &emitter.as.screen, size,
                                      to_world, place, error)
                    : mcv_load_rectangle(loader, mcv_json_name(node), size,
                                         mcv_emitter_mirrors(&emitter), to_world, place, error));
        last = first + 1;
    }
    if (first == last)
        return mcv_fail_at(&here, error,
                           "the mesh of its node \"%s\" has no triangles to emit from",
                           mcv_json_name(node));
    return add_emitters(loader, &emitter, first, last, error);
}
