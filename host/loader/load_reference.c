/* SPDX-License-Identifier: Apache-2.0 */
/* Arrays of an extension, and a node's index into them. */
#include "loader/loader.h"
#include "scene/params.h"

/* extensions/EXTENSION/KEY of the document, an array of objects; NULL where absent. */
mcv_result mcv_load_array(const mcv_loader *loader, const char *extension, const char *key,
                          json_t **array, mcv_error *error) {
    const char *const others[] = {key, "extras", "extensions", NULL};
    const mcv_json_path extensions = mcv_json_path_key(&loader->file, "extensions"),
                        place = mcv_json_path_key(&extensions, extension);
    const json_t *all = json_object_get(loader->root, "extensions");
    json_t *object;
    *array = NULL;
    MCV_TRY(mcv_json_object(all, extension, &object, &extensions, error));
    if (!object) return MCV_OK;
    MCV_TRY(mcv_params_parse((mcv_param_table){0}, object, others, NULL, &place, error));
    MCV_TRY(mcv_json_array(object, key, array, &place, error));
    if (!*array) return mcv_fail_at(&place, error, "must have the array \"%s\"", key);
    const mcv_json_path here = mcv_json_path_key(&loader->file, key);
    for (size_t i = 0; i < json_array_size(*array); ++i) {
        const mcv_json_path element = mcv_place_index(&here, i);
        const char *name = NULL; /* only its type is looked at */
        if (!json_is_object(json_array_get(*array, i)))
            return mcv_fail_at(&element, error, "must be an object");
        MCV_TRY(mcv_json_string(json_array_get(*array, i), "name", &name, &element, error));
    }
    return MCV_OK;
}

/* The node's extensions/EXTENSION {"KEY": index}; MCV_NONE where absent. */
mcv_result mcv_load_reference(const json_t *node, const char *extension, const char *key,
                              size_t count, const char *of, uint32_t *index,
                              const mcv_json_path *place, mcv_error *error) {
    const char *const others[] = {key, "extras", "extensions", NULL};
    const mcv_json_path extensions = mcv_json_path_key(place, "extensions"),
                        here = mcv_json_path_key(&extensions, extension);
    json_t *all, *object;
    *index = MCV_NONE;
    MCV_TRY(mcv_json_object(node, "extensions", &all, place, error));
    MCV_TRY(mcv_json_object(all, extension, &object, &extensions, error));
    if (!object) return MCV_OK;
    MCV_TRY(mcv_params_parse((mcv_param_table){0}, object, others, NULL, &here, error));
    MCV_TRY(mcv_json_index(object, key, count, of, index, &here, error));
    return *index == MCV_NONE ? mcv_fail_at(&here, error, "must have the index \"%s\"", key)
                              : MCV_OK;
}
