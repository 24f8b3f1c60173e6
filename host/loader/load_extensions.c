/* SPDX-License-Identifier: Apache-2.0 */
/* Supported extensions, and the warning about what is ignored. */
#include "loader/loader.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Supported extensions; a file must not require others. */
static const char *const known_extensions[] = {"MCVISI_sensors",
                                               "MCVISI_emitters",
                                               "MCVISI_materials",
                                               "MCVISI_assets",
                                               "MCVISI_pose",
                                               "MCVISI_misalignment",
                                               "MCVISI_motion",
                                               "MCVISI_surfaces",
                                               "MCVISI_defects",
                                               "KHR_materials_transmission",
                                               "KHR_materials_volume",
                                               "KHR_materials_ior",
                                               "KHR_materials_emissive_strength",
                                               "KHR_lights_punctual",
                                               "KHR_mesh_quantization",
                                               "KHR_texture_transform",
                                               "KHR_materials_anisotropy",
                                               "KHR_materials_diffuse_transmission",
                                               "KHR_materials_dispersion",
                                               "MCVISI_spectrum"};
static bool is_known(const char *name) {
    for (size_t i = 0; i < sizeof known_extensions / sizeof known_extensions[0]; ++i)
        if (strcmp(known_extensions[i], name) == 0) return true;
    return false;
}

mcv_result mcv_check_extensions(const json_t *root, const mcv_json_path *file, mcv_error *error) {
    const size_t known = sizeof known_extensions / sizeof known_extensions[0];
    const json_t *required = json_object_get(root, "extensionsRequired");
    for (size_t i = 0; i < json_array_size(required); ++i) {
        const char *name = json_string_value(json_array_get(required, i));
        if (is_known(name)) continue;
        const mcv_json_path place = mcv_json_path_key(file, "extensionsRequired"),
                            here = mcv_place_index(&place, i);
        const char *nearest = mcv_nearest_word(name, known_extensions, known);
        return mcv_fail_at(&here, error, "%s is required, but this program does not read it%s%s",
                           name, nearest ? "; it reads " : ": export without it",
                           nearest ? nearest : "");
    }
    return MCV_OK;
}

/* --- one line about what was ignored --- */

/* Objects with extras other than a note, below `value`. jansson bounds the depth of a document. */
static size_t count_extras(const json_t *value) {
    size_t count = 0, i;
    const char *key;
    json_t *child;
    if (json_is_object(value)) {
        const json_t *extras = json_object_get(value, "extras");
        const size_t notes = json_object_get(extras, "note") ? 1 : 0;
        if (extras && !(json_is_object(extras) && json_object_size(extras) <= notes)) ++count;
        json_object_foreach((json_t *)value, key, child) {
            if (strcmp(key, "extras") != 0) count += count_extras(child);
        }
    } else if (json_is_array(value)) {
        json_array_foreach(value, i, child) { count += count_extras(child); }
    }
    return count;
}

mcv_result mcv_load_warn_ignored(mcv_loader *loader, mcv_error *error) {
    const json_t *used = json_object_get(loader->root, "extensionsUsed");
    char *text = NULL;
    size_t size = 0, unknown = 0;
    FILE *stream = open_memstream(&text, &size);
    if (!stream) return mcv_fail_memory(&loader->file, error);
    loader->scene->ignored_extras += count_extras(loader->root);
    for (size_t i = 0; i < json_array_size(used); ++i) {
        const char *name = json_string_value(json_array_get(used, i));
        if (!is_known(name)) fprintf(stream, "%s%s", unknown++ ? ", " : "extensions ", name);
    }
    if (json_array_size(json_object_get(loader->root, "animations")))
        fprintf(stream, "%sanimations", unknown++ ? ", " : "");
    if (json_array_size(json_object_get(loader->root, "skins")))
        fprintf(stream, "%sskins", unknown++ ? ", " : "");
    fclose(stream);
    const mcv_result result =
        unknown && text ? mcv_scene_warn(loader->scene, error, "ignored: %s", text) : MCV_OK;
    free(text);
    return result;
}
