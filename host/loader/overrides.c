/* SPDX-License-Identifier: Apache-2.0 */
#include "loader/overrides.h"

#include "scene/params.h"
#include "loader/load.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Members of core glTF objects that --set may add, with the value they have while absent (JSON, or
 * NULL). */
static const struct {
    const char *collection,
        *parent; /* parent: the part of the element that holds it, "" for the element itself */
    const char *key, *absent;
} members[] = {
    {"nodes", "", "translation", "[0,0,0]"},
    {"nodes", "", "rotation", "[0,0,0,1]"},
    {"nodes", "", "scale", "[1,1,1]"},
    {"nodes", "", "mesh", NULL},
    {"nodes", "", "camera", NULL},
    {"nodes", "extensions/MCVISI_pose", "target", NULL},
    {"nodes", "extensions/MCVISI_pose", "distance", NULL},
    {"nodes", "extensions/MCVISI_pose", "azimuth", NULL},
    {"nodes", "extensions/MCVISI_pose", "elevation", NULL},
    {"nodes", "extensions/MCVISI_pose", "roll", NULL},
    {"nodes", "extensions/MCVISI_misalignment", "shiftX", "0"},
    {"nodes", "extensions/MCVISI_misalignment", "shiftY", "0"},
    {"nodes", "extensions/MCVISI_misalignment", "shiftZ", "0"},
    {"nodes", "extensions/MCVISI_misalignment", "turnX", "0"},
    {"nodes", "extensions/MCVISI_misalignment", "turnY", "0"},
    {"nodes", "extensions/MCVISI_misalignment", "turnZ", "0"},
    {"materials", "pbrMetallicRoughness", "baseColorFactor", "[1,1,1,1]"},
    {"materials", "pbrMetallicRoughness", "metallicFactor", NULL},
    {"materials", "pbrMetallicRoughness", "roughnessFactor", NULL},
    {"materials", "", "emissiveFactor", "[0,0,0]"},
    {"materials", "extensions/KHR_materials_ior", "ior", NULL},
    {"materials", "extensions/KHR_materials_transmission", "transmissionFactor", NULL},
    {"materials", "extensions/KHR_materials_volume", "thicknessFactor", NULL},
    {"materials", "extensions/KHR_materials_volume", "attenuationDistance", NULL},
    {"materials", "extensions/KHR_materials_volume", "attenuationColor", "[1,1,1]"},
    {"materials", "extensions/KHR_materials_emissive_strength", "emissiveStrength", NULL},
    {"lights", "", "intensity", "1"},
    {"lights", "", "color", "[1,1,1]"},
    {"lights", "", "range", NULL},
    {"lights", "spot", "innerConeAngle", NULL},
    {"lights", "spot", "outerConeAngle", NULL},
    {"cameras", "perspective", "yfov", NULL},
    {"cameras", "perspective", "aspectRatio", NULL},
};
enum { MEMBER_COUNT = sizeof members / sizeof members[0] };

/* One --set while it is followed into the tree. */
typedef struct setting {
    const char *item; /* PATH=VALUE, for messages */
    char *path;       /* the copy that is cut into segments */
    json_t *value;    /* NULL: the path is followed to what there is */
    json_t *found;    /* that, borrowed from the tree */
    const char *collection;
    bool own; /* inside an MCVISI_ object: its parser checks keys and units */
    const mcv_json_path *file;
    mcv_error *error;
} setting;

__attribute__((format(printf, 2, 3))) static mcv_result fail(const setting *set, const char *format,
                                                             ...) {
    char text[1024];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    return mcv_fail_at(set->file, set->error, "%s%s: %s", set->value ? "--set " : "", set->item,
                       text);
}

/* The object at extensions/NAME and the like below `object`, made where it is missing. */
static json_t *make_path(json_t *object, const char *path) {
    while (object && *path) {
        const size_t length = strcspn(path, "/");
        char key[64];
        snprintf(key, sizeof key, "%.*s", (int)length, path);
        json_t *child = json_object_get(object, key);
        if (!child) {
            child = json_object();
            json_object_set_new(object, key, child);
        }
        object = child;
        path += length + (path[length] == '/');
    }
    return json_is_object(object) ? object : NULL;
}

/* Cuts the first segment off *rest; returns it. */
static char *cut(char **rest) {
    char *segment = *rest;
    *rest += strcspn(*rest, "/");
    if (**rest) *(*rest)++ = '\0';
    return segment;
}

/* "25mm" to 0.025, for numbers of core glTF; anything else stays. */
static json_t *in_si(json_t *value) {
    double number;
    if (json_is_string(value) &&
        mcv_parse_quantity(json_string_value(value), MCV_PARAM_choice, &number))
        return json_real(number);
    if (!json_is_array(value)) return json_incref(value);
    json_t *copy = json_array(), *element;
    size_t i;
    json_array_foreach(value, i, element) { json_array_append_new(copy, in_si(element)); }
    return copy;
}

static json_t *new_value(const setting *set, const json_t *old) {
    return set->own || json_is_string(old) ? json_incref(set->value) : in_si(set->value);
}

/* The position that a segment names in an array: x y z w, r g b a, or a number. */
static size_t array_index(const json_t *array, const char *segment) {
    const size_t size = json_array_size(array);
    static const char axes[] = "xyzwrgba";
    const char *axis = segment[0] && !segment[1] ? strchr(axes, segment[0]) : NULL;
    size_t index = SIZE_MAX;
    if (axis)
        index = (size_t)(axis - axes) % 4;
    else if (*segment && strspn(segment, "0123456789") == strlen(segment))
        index = strtoul(segment, NULL, 10);
    return index < size ? index : SIZE_MAX;
}

static mcv_result fail_unknown(const setting *set, const json_t *object, const char *segment) {
    const char *words[256];
    char list[512] = "";
    size_t n = 0;
    const char *key;
    json_t *value;
    json_object_foreach((json_t *)object, key, value) {
        if (n < 128) words[n++] = key;
    }
    for (size_t i = 0; i < MEMBER_COUNT; ++i)
        if (strcmp(members[i].collection, set->collection) == 0) words[n++] = members[i].key;
    const char *nearest = mcv_nearest_word(segment, words, n);
    if (nearest) return fail(set, "there is no \"%s\"; did you mean \"%s\"?", segment, nearest);
    for (size_t i = 0; i < n; ++i)
        snprintf(list + strlen(list), sizeof list - strlen(list), "%s%s", i ? ", " : "", words[i]);
    return fail(set, "there is no \"%s\"; there are %s", segment, *list ? list : "no members");
}

/* The end of a path that is only followed. */
static mcv_result take(setting *set, json_t *found) {
    if (!found || json_is_null(found))
        return fail(set, "is not written in the document: its default counts");
    set->found = found;
    return MCV_OK;
}

/* Follows the rest of the path from an object or array inside of an element, and sets its end. */
static mcv_result set_below(setting *set, json_t *parent, char *rest) {
    for (;;) {
        const char *segment = cut(&rest);
        json_t *child = NULL;
        if (json_is_array(parent)) {
            const size_t index = array_index(parent, segment);
            if (index == SIZE_MAX)
                return fail(set,
                            "\"%s\" is not an element of an array of %zu: use x y z w, r g b a or "
                            "an index from 0",
                            segment, json_array_size(parent));
            child = json_array_get(parent, index);
            if (!*rest && !set->value) return take(set, child);
            if (!*rest) {
                json_array_set_new(parent, index, new_value(set, child));
                return MCV_OK;
            }
        } else if (json_is_object(parent)) {
            child = json_object_get(parent, segment);
            if (!child && !(set->own && !*rest && set->value))
                return fail_unknown(set, parent, segment);
            if (!*rest && !set->value) return take(set, child);
            if (!*rest) {
                json_object_set_new(parent, segment, new_value(set, child));
                return MCV_OK;
            }
        } else {
            return fail(set, "\"%s\" follows a value that has no members", segment);
        }
        parent = child;
    }
}

/* Sends a short path such as materials/glass/ior to the object that holds the member. */
static mcv_result set_member(setting *set, json_t *element, char *rest) {
    json_t *own = mcv_json_extension(element, "MCVISI_materials");
    const size_t length = strcspn(rest, "/");
    char key[64];
    snprintf(key, sizeof key, "%.*s", (int)length, rest);
    if (!*rest && !set->value) return take(set, element);
    if (!*rest) return fail(set, "name a member of it, as in sensors/cam/focalLength");
    if (!json_is_object(element)) return fail(set, "the element must be an object");
    if (json_is_object(own) && strcmp(set->collection, "materials") == 0 &&
        !json_object_get(element, key)) {
        set->own = true;
        return set_below(set, own, rest);
    }
    for (size_t i = 0; i < MEMBER_COUNT; ++i) {
        if (set->own || strcmp(members[i].collection, set->collection) != 0) continue;
        const size_t parent_length = strlen(members[i].parent);
        char *member = rest;
        /* Both the short path and the one that is written out. */
        if (parent_length && strncmp(rest, members[i].parent, parent_length) == 0 &&
            rest[parent_length] == '/')
            member = rest + parent_length + 1;
        const size_t n = strlen(members[i].key);
        if (strncmp(member, members[i].key, n) != 0 || (member[n] != '\0' && member[n] != '/'))
            continue;
        json_t *parent = make_path(element, members[i].parent);
        if (!parent) return fail(set, "%s is no object", members[i].parent);
        if (!json_object_get(parent, members[i].key))
            json_object_set_new(parent, members[i].key,
                                members[i].absent
                                    ? json_loads(members[i].absent, JSON_DECODE_ANY, NULL)
                                    : json_null());
        return set_below(set, parent, member);
    }
    for (size_t i = 0; i < 2 && set->value && strcmp(set->collection, "assets") == 0;
         ++i) { /* names may hold slashes: the rest is one of them */
        static const char *const maps[] = {"materials", "nodeMaterials"};
        const size_t n = strlen(maps[i]);
        if (strncmp(rest, maps[i], n) != 0 || rest[n] != '/' || !rest[n + 1]) continue;
        json_t *map = make_path(element, maps[i]);
        if (!map) return fail(set, "%s is no object", maps[i]);
        json_object_set(map, rest + n + 1, set->value);
        return MCV_OK;
    }
    if (strncmp(rest, "extensions/MCVISI_", 18) == 0) set->own = true;
    return set_below(set, element, rest);
}

/* The element whose name begins the rest of the path (names may contain slashes: the longest
 * counts), or its index. */
static mcv_result find_element(const setting *set, const json_t *array, char **rest,
                               json_t **element) {
    const char *names[64];
    char list[512] = "";
    size_t longest = 0, matches = 0, known = 0, found = 0, i;
    json_t *candidate;
    json_array_foreach(array, i, candidate) {
        const char *name = mcv_json_name(candidate);
        const size_t length = strlen(name);
        if (length && known < 64) names[known++] = name;
        if (length == 0 || length < longest || strncmp(*rest, name, length) != 0 ||
            ((*rest)[length] && (*rest)[length] != '/'))
            continue;
        if (length > longest) {
            matches = 0;
            list[0] = '\0';
        }
        longest = length;
        found = i;
        snprintf(list + strlen(list), sizeof list - strlen(list), "%s%s/%zu", matches++ ? ", " : "",
                 set->collection, i);
    }
    if (matches > 1)
        return fail(set, "the name \"%.*s\" is ambiguous: use one of %s", (int)longest, *rest,
                    list);
    if (matches == 1) {
        *element = json_array_get(array, found);
        *rest += longest + ((*rest)[longest] == '/');
        return MCV_OK;
    }
    const char *segment = cut(rest);
    const size_t index = *segment && strspn(segment, "0123456789") == strlen(segment)
                             ? strtoul(segment, NULL, 10)
                             : SIZE_MAX;
    *element = json_array_get(array, index);
    if (*element) return MCV_OK;
    const char *nearest = mcv_nearest_word(segment, names, known);
    if (nearest)
        return fail(set, "there is no \"%s\" in %s; did you mean \"%s\"?", segment, set->collection,
                    nearest);
    for (i = 0; i < known; ++i)
        snprintf(list + strlen(list), sizeof list - strlen(list), "%s%s", i ? ", " : "", names[i]);
    return fail(set, "there is no \"%s\" in %s: they are %s%s0 to %zu", segment, set->collection,
                list, known ? ", or " : "", json_array_size(array) - 1);
}

/* Is it the array of the extension MCVISI_COLLECTION? */
static bool is_own(const char *collection) {
    static const char *const own[] = {"sensors", "emitters", "assets", "surfaces", "defects"};
    for (size_t i = 0; i < sizeof own / sizeof own[0]; ++i)
        if (strcmp(collection, own[i]) == 0) return true;
    return false;
}

static mcv_result follow(setting *set, json_t *root) {
    static const char *const collections[] = {"sensors", "emitters", "assets",   "materials",
                                              "nodes",   "cameras",  "meshes",   "textures",
                                              "images",  "lights",   "surfaces", "defects"};
    char *rest = set->path;
    set->collection = cut(&rest);
    char extension[64];
    if (strcmp(set->collection, "spectrum") == 0) { /* no array: one object, which --set may add */
        json_t *spectrum = make_path(root, "extensions/MCVISI_spectrum");
        set->own = true;
        if (!set->value && !*rest) return take(set, spectrum);
        return spectrum && *rest ? set_below(set, spectrum, rest)
                                 : fail(set, "name a member of it, as in spectrum/wavelengths");
    }
    const bool lights = strcmp(set->collection, "lights") == 0;
    snprintf(extension, sizeof extension, "MCVISI_%.32s", set->collection);
    if (lights) strcpy(extension, "KHR_lights_punctual");
    set->own = is_own(set->collection);
    json_t *array = json_object_get(set->own || lights ? mcv_json_extension(root, extension) : root,
                                    set->collection);
    if (!json_is_array(array) || json_array_size(array) == 0) {
        const size_t n = sizeof collections / sizeof collections[0];
        const char *nearest = mcv_nearest_word(set->collection, collections, n);
        if (!nearest)
            return fail(set, "a path begins with sensors, emitters, materials, nodes or cameras");
        if (strcmp(nearest, set->collection) != 0)
            return fail(set, "there is no \"%s\"; did you mean \"%s\"?", set->collection, nearest);
        return fail(set, "the file has no %s", set->collection);
    }
    json_t *element = NULL;
    if (!set->value && !*rest) return take(set, array);
    MCV_TRY(find_element(set, array, &rest, &element));
    return set_member(set, element, rest);
}

mcv_result mcv_overrides_apply(mcv_overrides overrides, json_t *root, const mcv_json_path *file,
                               mcv_error *error) {
    for (size_t i = 0; i < overrides.count; ++i) {
        const char *item = overrides.items[i], *equals = strchr(item, '=');
        if (!equals || equals == item)
            return mcv_fail(error, MCV_USAGE,
                            "--set %s: must be PATH=VALUE, as in sensors/cam/fNumber=8", item);
        setting set = {.item = item,
                       .path = strndup(item, (size_t)(equals - item)),
                       .file = file,
                       .error = error};
        set.value = json_loads(equals + 1, JSON_DECODE_ANY, NULL);
        if (!set.value) set.value = json_string(equals + 1);
        const mcv_result result = !set.path    ? mcv_fail_memory(file, error)
                                  : !set.value ? fail(&set, "the value must be UTF-8 text")
                                               : follow(&set, root);
        json_decref(set.value);
        free(set.path);
        MCV_TRY(result);
    }
    return MCV_OK;
}

mcv_result mcv_overrides_find(const char *path, json_t *root, const mcv_json_path *file,
                              const json_t **found, mcv_error *error) {
    setting set = {.item = path, .path = strdup(path), .file = file, .error = error};
    const mcv_result result = set.path ? follow(&set, root) : mcv_fail_memory(file, error);
    free(set.path);
    *found = set.found;
    return result;
}

mcv_result mcv_overrides_number(const char *path, mcv_overrides overrides,
                                const mcv_document *document, double *number, mcv_error *error) {
    const mcv_json_path place = mcv_place_file(document->path);
    const json_t *found = NULL;
    json_t *root = json_deep_copy(document->root);
    mcv_result result =
        root ? mcv_overrides_apply(overrides, root, &place, error) : mcv_fail_memory(&place, error);
    if (result == MCV_OK) result = mcv_overrides_find(path, root, &place, &found, error);
    *number = json_number_value(found);
    if (result == MCV_OK && !json_is_number(found) &&
        !(json_is_string(found) &&
          mcv_parse_quantity(json_string_value(found), MCV_PARAM_choice, number)))
        result = mcv_fail(error, MCV_BAD_INPUT, "is no number in the scene");
    json_decref(root);
    return result;
}

const char *mcv_overrides_shorten(const char *collection, const char *path) {
    static const char own[] = "extensions/MCVISI_materials/";
    if (strcmp(collection, "materials") == 0 && strncmp(path, own, strlen(own)) == 0)
        return path + strlen(own);
    for (size_t i = 0; i < MEMBER_COUNT; ++i) {
        const size_t parent = strlen(members[i].parent), key = strlen(members[i].key);
        if (parent == 0 || strcmp(members[i].collection, collection) != 0 ||
            strncmp(path, members[i].parent, parent) != 0 || path[parent] != '/' ||
            strncmp(path + parent + 1, members[i].key, key) != 0)
            continue;
        const char end = path[parent + 1 + key];
        if (end == '\0' || end == '/') return path + parent + 1;
    }
    return path;
}
