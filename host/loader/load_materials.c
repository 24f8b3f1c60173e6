/* SPDX-License-Identifier: Apache-2.0 */
/* glTF materials to the scene's: MCVISI_materials if given, else the core material and KHR
 * extensions. */
#include "loader/loader.h"

#include "scene/params.h"

#include <float.h>
#include <stdlib.h>
#include <string.h>

mcv_result mcv_load_needed_images(mcv_loader *loader, uint32_t *count, mcv_error *error) {
    const json_t *materials = json_object_get(loader->root, "materials");
    const mcv_json_path place = mcv_json_path_key(&loader->file, "materials");
    *count = 0;
    for (size_t i = 0; i < json_array_size(json_object_get(loader->root, "images")); ++i)
        loader->images[i] = MCV_NONE;
    for (size_t i = 0; i < json_array_size(materials); ++i) {
        const json_t *material = json_array_get(materials, i);
        const mcv_json_path here = mcv_json_path_element(&place, mcv_json_name(material), i);
        json_t *core;
        MCV_TRY(mcv_json_object(material, "pbrMetallicRoughness", &core, &here, error));
        const mcv_json_path core_place = mcv_json_path_key(&here, "pbrMetallicRoughness");
        const struct {
            const json_t *part;
            const char *key;
            const mcv_json_path *place;
            bool needed;
        } textures[] = {{core, "baseColorTexture", &core_place, true},
                        {material, "emissiveTexture", &here, true},
                        {core, "metallicRoughnessTexture", &core_place, true},
                        {material, "normalTexture", &here, false},
                        {material, "occlusionTexture", &here, false}};
        for (size_t k = 0; k < sizeof textures / sizeof textures[0]; ++k) {
            uint32_t texture, source;
            MCV_TRY(mcv_load_texture_source(loader, textures[k].part, textures[k].key, &texture,
                                            &source, textures[k].place, error));
            if (textures[k].needed && source != MCV_NONE)
                mcv_load_need_image(loader, source, count);
        }
    }
    return MCV_OK;
}

typedef struct core_material {
    double base[4], metallic, roughness, transmission, thickness, ior, dispersion;
    double diffuse_transmission, anisotropy, rotation;
    double attenuation_distance, attenuation[3];
    double emissive[3], emissive_strength;
} core_material;

static mcv_result read_core(const json_t *material, core_material *core, const mcv_json_path *place,
                            mcv_error *error) {
    const json_t *part = json_object_get(material, "pbrMetallicRoughness");
    const mcv_json_path part_place = mcv_json_path_key(place, "pbrMetallicRoughness");
    const mcv_json_path extensions = mcv_json_path_key(place, "extensions");
    enum { EXTENSIONS = 7 };
    json_t *extension[EXTENSIONS];
    static const char *const names[EXTENSIONS] = {
        "KHR_materials_transmission", "KHR_materials_volume",
        "KHR_materials_ior",          "KHR_materials_emissive_strength",
        "KHR_materials_anisotropy",   "KHR_materials_diffuse_transmission",
        "KHR_materials_dispersion"};
    mcv_json_path places[EXTENSIONS];
    *core = (core_material){.base = {1, 1, 1, 1},
                            .metallic = 1,
                            .roughness = 1,
                            .ior = 1.5,
                            .attenuation_distance = INFINITY,
                            .attenuation = {1, 1, 1},
                            .emissive_strength = 1};
    json_t *all;
    MCV_TRY(mcv_json_object(material, "extensions", &all, place, error));
    for (int i = 0; i < EXTENSIONS; ++i) {
        places[i] = mcv_json_path_key(&extensions, names[i]);
        MCV_TRY(mcv_json_object(all, names[i], extension + i, &extensions, error));
    }
    MCV_TRY(mcv_json_numbers(part, "baseColorFactor", 4, 0, 1, core->base, &part_place, error));
    MCV_TRY(mcv_json_number(part, "metallicFactor", 0, 1, &core->metallic, &part_place, error));
    MCV_TRY(mcv_json_number(part, "roughnessFactor", 0, 1, &core->roughness, &part_place, error));
    MCV_TRY(mcv_json_numbers(material, "emissiveFactor", 3, 0, 1, core->emissive, place, error));
    MCV_TRY(mcv_json_number(extension[0], "transmissionFactor", 0, 1, &core->transmission,
                            &places[0], error));
    MCV_TRY(mcv_json_number(extension[1], "thicknessFactor", 0, DBL_MAX, &core->thickness,
                            &places[1], error));
    MCV_TRY(mcv_json_number(extension[1], "attenuationDistance", DBL_MIN, DBL_MAX,
                            &core->attenuation_distance, &places[1], error));
    MCV_TRY(mcv_json_numbers(extension[1], "attenuationColor", 3, 0, 1, core->attenuation,
                             &places[1], error));
    MCV_TRY(mcv_json_number(extension[2], "ior", 0, DBL_MAX, &core->ior, &places[2], error));
    MCV_TRY(mcv_json_number(extension[3], "emissiveStrength", 0, DBL_MAX, &core->emissive_strength,
                            &places[3], error));
    MCV_TRY(mcv_json_number(extension[4], "anisotropyStrength", 0, 1, &core->anisotropy, &places[4],
                            error));
    MCV_TRY(mcv_json_number(extension[4], "anisotropyRotation", -DBL_MAX, DBL_MAX, &core->rotation,
                            &places[4], error));
    MCV_TRY(mcv_json_number(extension[5], "diffuseTransmissionFactor", 0, 1,
                            &core->diffuse_transmission, &places[5], error));
    MCV_TRY(mcv_json_number(extension[6], "dispersion", 0, DBL_MAX, &core->dispersion, &places[6],
                            error));
    core->rotation = remainder(core->rotation, 2 * M_PI);
    if (core->ior > 0 && core->ior < 1)
        return mcv_fail_at(&places[2], error, "ior %g must be 1 or more", core->ior);
    return MCV_OK;
}

/*
 * Full transmission of a smooth material is glass or, without thickness, a sheet. A smooth metal is
 * a mirror. Everything else is metallicRoughness. `textured`: an image scales roughness and
 * metallic. False: a property of the core material is lost.
 */
static bool map_core(const core_material *core, bool textured, mcv_material *material) {
    const bool smooth = core->roughness == 0,
               clear = core->transmission == 1 && (core->metallic == 0);
    if (clear && core->thickness > 0 && !textured) {
        material->type = MCV_MATERIAL_DIELECTRIC;
        material->as.dielectric =
            (mcv_dielectric_params){.ior = {core->ior, core->ior, core->ior},
                                    .abbeNumber = core->dispersion > 0 ? 20 / core->dispersion : 0,
                                    .roughness = core->roughness,
                                    .anisotropy = core->anisotropy,
                                    .anisotropyRotation = core->rotation};
        for (int i = 0; i < 3; ++i) /* a colour of 0 means an infinite coefficient: the largest
                                       allowed one replaces it */
            material->as.dielectric.absorption[i] =
                core->attenuation[i] == 1
                    ? 0
                    : fmin(-log(core->attenuation[i]) / core->attenuation_distance, 1e30);
        return true;
    }
    if (clear && smooth) {
        material->type = MCV_MATERIAL_SHEET;
        material->as.sheet.ior = core->ior;
        memcpy(material->as.sheet.transmittance, core->base,
               sizeof material->as.sheet.transmittance);
        return true;
    }
    if (core->metallic == 1 && smooth && core->transmission == 0 && !textured) {
        material->type = MCV_MATERIAL_MIRROR;
        memcpy(material->as.mirror.reflectance, core->base, sizeof material->as.mirror.reflectance);
        return true;
    }
    material->type = MCV_MATERIAL_METALLIC_ROUGHNESS;
    material->as.metallic_roughness =
        (mcv_metallic_roughness_params){.metallic = core->metallic,
                                        .ior = core->ior,
                                        .transmission = core->transmission,
                                        .diffuseTransmission = core->diffuse_transmission,
                                        .roughness = core->roughness,
                                        .anisotropy = core->anisotropy,
                                        .anisotropyRotation = core->rotation};
    memcpy(material->as.metallic_roughness.baseColor, core->base,
           sizeof material->as.metallic_roughness.baseColor);
    return !(core->thickness > 0 && core->transmission > 0);
}

/* Refuses names of substances where a type of scattering is expected, and suggests the type. */
static mcv_result check_substance(const json_t *object, const mcv_json_path *place,
                                  mcv_error *error) {
    static const char *const clear[] = {"glass", "plexiglass", "acrylic", "quartz", NULL};
    static const char *const matt[] = {"plastic", "rubber",  "wood", "paper",
                                       "paint",   "ceramic", NULL};
    const struct {
        const char *const *words;
        const char *says;
    } substances[] = {
        {clear,
         "a body of glass is a dielectric, {\"type\": \"dielectric\", \"glass\": \"N-BK7\"}"},
        {mcv_param_options("glass") + 1,
         /* behind "none" */ "a body of glass is a dielectric, {\"type\": \"dielectric\", "
                             "\"glass\": \"N-BK7\"}"},
        {matt, "a matt part is {\"type\": \"diffuse\", \"reflectance\": 0.5}, one with a gloss "
               "{\"type\": "
               "\"metallicRoughness\", \"metallic\": 0, \"roughness\": 0.5}"}};
    const char *name = json_string_value(json_object_get(object, "type"));
    const mcv_json_path here = mcv_json_path_key(place, "type");
    char metals[256];
    if (name && mcv_is_metal(name, metals))
        return mcv_fail_at(&here, error,
                           "\"%s\" is not a type: a metal is a conductor, "
                           "{\"type\": \"conductor\", "
                           "\"metal\": \"iron\", \"roughness\": 0.3}; %s",
                           name, metals);
    for (size_t i = 0; name && i < sizeof substances / sizeof substances[0]; ++i)
        for (const char *const *word = substances[i].words; *word; ++word)
            if (strcasecmp(name, *word) == 0)
                return mcv_fail_at(&here, error, "\"%s\" is not a type: %s", name,
                                   substances[i].says);
    return MCV_OK;
}

static mcv_result read_own(const json_t *object, mcv_material *material, const mcv_json_path *place,
                           mcv_error *error) {
    static const char *const others[] = {"type", "extras", "extensions", NULL};
    if (!json_is_object(object))
        return mcv_fail_at(place, error, "must be an object {\"type\": ...}");
    MCV_TRY(check_substance(object, place, error));
    MCV_TRY(mcv_element_type(object, mcv_material_types, MCV_MATERIAL_COUNT, &material->type, place,
                             error));
    const mcv_param_table table = mcv_material_table(material->type);
    mcv_params_set_defaults(table, &material->as);
    MCV_TRY(mcv_params_parse(table, object, others, &material->as, place, error));
    return mcv_params_check(table, &material->as, place, error);
}

/* Collects the names of materials for a warning, as keys of a JSON object, so that each occurs
 * once. */
static void note(json_t *names, const char *name, size_t index) {
    char number[32];
    snprintf(number, sizeof number, "%zu", index);
    json_object_set_new(names, *name ? name : number, json_true());
}

static mcv_result warn_names(mcv_scene *scene, json_t *names, const char *sentence,
                             mcv_error *error) {
    char *text = NULL;
    size_t size = 0;
    const char *key;
    json_t *value;
    FILE *stream = json_object_size(names) ? open_memstream(&text, &size) : NULL;
    if (!stream) return MCV_OK;
    json_object_foreach(names, key, value)
        fprintf(stream, "%s%s", ftell(stream) > 0 ? ", " : "", key);
    fclose(stream);
    const mcv_result result =
        text ? mcv_scene_warn(scene, error, "materials %s: %s", text, sentence) : MCV_OK;
    free(text);
    return result;
}

static mcv_result load_material(mcv_loader *loader, const json_t *object, size_t index,
                                json_t *thin, json_t *cut_out, const mcv_json_path *place,
                                mcv_error *error) {
    const char *name = mcv_json_name(object), *alpha = "OPAQUE";
    const json_t *part = json_object_get(object, "pbrMetallicRoughness");
    core_material core;
    mcv_material material = {
        .name = (char *)name, .texture = MCV_NONE, .surface_texture = MCV_NONE};
    mcv_emission *emission = loader->emission + index;
    MCV_TRY(read_core(object, &core, place, error));
    MCV_TRY(mcv_json_string(object, "alphaMode", &alpha, place, error));
    const json_t *own = mcv_json_extension(object, "MCVISI_materials");
    if (core.ior == 0 && !own) { /* glTF: ior 0 means no Fresnel effect; converters from
                                    specular-glossiness write it */
        MCV_TRY(
            mcv_scene_warn(loader->scene, error, "material \"%s\": ior 0 is read as 1.5", name));
        core.ior = 1.5;
    }
    if (own)
        MCV_TRY(read_own(own, &material, place, error));
    else if (!map_core(&core, json_object_get(part, "metallicRoughnessTexture"), &material))
        note(thin, name, index);
    if (strcmp(alpha, "OPAQUE") != 0) note(cut_out, name, index);
    if (material.type == MCV_MATERIAL_DIFFUSE || material.type == MCV_MATERIAL_SHEET ||
        material.type == MCV_MATERIAL_MIRROR || material.type == MCV_MATERIAL_METALLIC_ROUGHNESS)
        MCV_TRY(mcv_load_texture(loader, part, "baseColorTexture", false, &material.texture, place,
                                 error));
    if (material.type == MCV_MATERIAL_METALLIC_ROUGHNESS)
        MCV_TRY(mcv_load_texture(loader, part, "metallicRoughnessTexture", true,
                                 &material.surface_texture, place, error));
    emission->texture = MCV_NONE;
    for (int i = 0; i < 3; ++i) emission->radiance[i] = core.emissive[i] * core.emissive_strength;
    if (emission->radiance[0] + emission->radiance[1] + emission->radiance[2] > 0)
        MCV_TRY(mcv_load_texture(loader, object, "emissiveTexture", false, &emission->texture,
                                 place, error));
    return mcv_scene_add_material(loader->scene, &material, error);
}

mcv_result mcv_load_materials(mcv_loader *loader, mcv_error *error) {
    const json_t *materials = json_object_get(loader->root, "materials");
    const mcv_json_path place = mcv_json_path_key(&loader->file, "materials");
    json_t *thin = json_object(), *cut_out = json_object();
    mcv_result result = MCV_OK;
    for (size_t i = 0; result == MCV_OK && i < json_array_size(materials); ++i) {
        const json_t *object = json_array_get(materials, i);
        const mcv_json_path here = mcv_json_path_element(&place, mcv_json_name(object), i);
        if (loader->materials[i] != MCV_NONE) continue; /* replaced by a material of the scene */
        loader->materials[i] = loader->scene->material_count;
        result = load_material(loader, object, i, thin, cut_out, &here, error);
    }
    if (result == MCV_OK)
        result =
            warn_names(loader->scene, thin, "rendered as thin walls, without their volume", error);
    if (result == MCV_OK)
        result = warn_names(loader->scene, cut_out, "rendered opaque, without their alpha", error);
    json_decref(thin);
    json_decref(cut_out);
    return result;
}

mcv_result mcv_load_plain(mcv_loader *loader, uint32_t *material, mcv_error *error) {
    if (loader->plain == MCV_NONE) {
        mcv_material plain = {.name = "", .type = MCV_MATERIAL_DIFFUSE, .texture = MCV_NONE};
        mcv_params_set_defaults(mcv_material_table(plain.type), &plain.as);
        MCV_TRY(mcv_scene_add_material(loader->scene, &plain, error));
        loader->plain = loader->scene->material_count - 1;
        MCV_TRY(mcv_scene_warn(loader->scene, error,
                               "meshes without a material are rendered diffuse, reflectance %g",
                               plain.as.diffuse.reflectance[0]));
    }
    *material = loader->plain;
    return MCV_OK;
}

mcv_result mcv_load_absorber(mcv_loader *loader, uint32_t *material, mcv_error *error) {
    if (loader->absorber == MCV_NONE) {
        const mcv_material absorber = {
            .name = "", .type = MCV_MATERIAL_ABSORBER, .texture = MCV_NONE};
        MCV_TRY(mcv_scene_add_material(loader->scene, &absorber, error));
        loader->absorber = loader->scene->material_count - 1;
    }
    *material = loader->absorber;
    return MCV_OK;
}
