/* SPDX-License-Identifier: Apache-2.0 */
/* KHR_lights_punctual: its lights become emitters of the types point, spot and directional; candela
 * and lux are converted to watts. */
#include "loader/loader.h"

#include "scene/emitters.h"
#include "scene/transform.h"

#include <float.h>
#include <stdlib.h>

/* Luminous efficacy at 555 nm [lm/W], which exporters assume for white light. */
static const double lumens_per_watt = 683;

/* Exporters halve a float32; that of 180 degrees is slightly larger than pi. */
static const double widest = (float)M_PI_2;

static mcv_result light_type(const json_t *object, uint32_t *type, const mcv_json_path *place,
                             mcv_error *error) {
    static const uint32_t types[] = {MCV_EMITTER_POINT, MCV_EMITTER_SPOT, MCV_EMITTER_DIRECTIONAL};
    static const char *const names[] = {"point", "spot", "directional"};
    const mcv_json_path here = mcv_json_path_key(place, "type");
    const char *name = NULL;
    MCV_TRY(mcv_json_string(object, "type", &name, place, error));
    if (!name) return mcv_fail_at(&here, error, "is missing: one of point, spot, directional");
    for (int i = 0; i < 3; ++i) {
        if (strcmp(name, names[i]) != 0) continue;
        *type = types[i];
        return MCV_OK;
    }
    return mcv_fail_at(&here, error, "unknown type \"%.32s\": known are point, spot, directional",
                       name);
}

static mcv_result read_spot(const json_t *light, mcv_spot_params *spot, const mcv_json_path *place,
                            mcv_error *error) {
    const mcv_json_path here = mcv_json_path_key(place, "spot");
    json_t *object;
    MCV_TRY(mcv_json_object(light, "spot", &object, place, error));
    if (!object) return mcv_fail_at(&here, error, "is missing: it holds the cone of a spot light");
    MCV_TRY(
        mcv_json_number(object, "innerConeAngle", 0, widest, &spot->innerConeAngle, &here, error));
    MCV_TRY(mcv_json_number(object, "outerConeAngle", DBL_MIN, widest, &spot->outerConeAngle, &here,
                            error));
    spot->innerConeAngle = fmin(spot->innerConeAngle, M_PI / 2);
    spot->outerConeAngle = fmin(spot->outerConeAngle, M_PI / 2);
    return MCV_OK;
}

static mcv_result define_light(const mcv_scene *scene, const json_t *object, mcv_emitter *emitter,
                               const mcv_json_path *place, mcv_error *error) {
    double colour[3] = {1, 1, 1}, intensity = 1, range = (double)NAN;
    MCV_TRY(light_type(object, &emitter->type, place, error));
    mcv_params_set_defaults(mcv_emitter_table(emitter->type), &emitter->as);
    MCV_TRY(mcv_json_numbers(object, "color", 3, 0, DBL_MAX, colour, place, error));
    MCV_TRY(mcv_json_number(object, "intensity", 0, DBL_MAX, &intensity, place, error));
    MCV_TRY(mcv_json_number(object, "range", DBL_MIN, DBL_MAX, &range, place, error));
    if (emitter->type == MCV_EMITTER_SPOT)
        MCV_TRY(read_spot(object, &emitter->as.spot, place, error));
    const char *unit, *key = mcv_emitter_brightness(emitter, &unit);
    double *brightness = mcv_emitter_parameter(emitter, key),
           *own_range = mcv_emitter_parameter(emitter, "range");
    for (int i = 0; i < 3; ++i) brightness[i] = colour[i] * intensity / lumens_per_watt;
    if (own_range) *own_range = range;
    emitter->name = (char *)mcv_json_name(object);
    emitter->texture = MCV_NONE;
    MCV_TRY(mcv_emitter_check(emitter, place, error));
    return mcv_emitter_resolve(scene, emitter, place, error);
}

mcv_result mcv_load_lights(mcv_loader *loader, mcv_error *error) {
    const mcv_json_path extensions = mcv_json_path_key(&loader->file, "extensions"),
                        here = mcv_json_path_key(&extensions, "KHR_lights_punctual");
    const mcv_json_path lights = mcv_json_path_key(&here, "lights");
    json_t *array;
    const json_t *object = mcv_json_extension(loader->root, "KHR_lights_punctual");
    MCV_TRY(mcv_json_array(object, "lights", &array, &here, error));
    if (object && !array) return mcv_fail_at(&here, error, "must have the array \"lights\"");
    loader->light_count = json_array_size(array);
    loader->lights = calloc(loader->light_count + 1, sizeof *loader->lights);
    if (!loader->lights) return mcv_fail_memory(&loader->file, error);
    for (size_t i = 0; i < loader->light_count; ++i) {
        const json_t *light = json_array_get(array, i);
        const mcv_json_path place = mcv_json_path_element(&lights, mcv_json_name(light), i);
        if (!json_is_object(light)) return mcv_fail_at(&place, error, "must be an object");
        MCV_TRY(define_light(loader->scene, light, loader->lights + i, &place, error));
    }
    return MCV_OK;
}

mcv_result mcv_load_light(mcv_loader *loader, const json_t *node, const mcv_transform *to_world,
                          const mcv_json_path *place, mcv_error *error) {
    const mcv_json_path extensions = mcv_json_path_key(place, "extensions"),
                        here = mcv_json_path_key(&extensions, "KHR_lights_punctual");
    const json_t *object = mcv_json_extension(node, "KHR_lights_punctual");
    uint32_t index;
    if (loader->is_asset || !object) return MCV_OK;
    MCV_TRY(mcv_json_index(object, "light", loader->light_count, "lights", &index, &here, error));
    if (index == MCV_NONE) return mcv_fail_at(&here, error, "must have the index \"light\"");
    mcv_emitter light = loader->lights[index];
    if (!light.name || !*light.name) light.name = (char *)mcv_json_name(node);
    if (!mcv_transform_rigid(to_world, &light.to_world))
        return mcv_fail_at(place, error, "its scale must not be 0");
    return mcv_scene_add_emitter(loader->scene, &light, error);
}
