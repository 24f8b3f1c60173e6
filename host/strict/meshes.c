/* SPDX-License-Identifier: Apache-2.0 */
/* Meshes: their attributes, indices, morph targets, and what their materials need of them. */
#include "strict/strict_parts.h"

#include <ctype.h>
#include <stdlib.h>
#include <string.h>

/* A semantic with a number behind it: TEXCOORD_0. False where the name is none. */
static bool numbered(const char *name, const char *semantic, size_t *number) {
    const size_t length = strlen(semantic);
    if (strncmp(name, semantic, length) != 0 || name[length] != '_') return false;
    const char *digits = name + length + 1;
    if (!isdigit((unsigned char)digits[0]) || (digits[0] == '0' && digits[1]) ||
        strspn(digits, "0123456789") != strlen(digits) || strlen(digits) > 4)
        return false;
    *number = 0;
    for (; *digits; ++digits) *number = 10 * *number + (size_t)(*digits - '0');
    return true;
}

static const struct {
    const char *name, *type[2], *components;
    bool is_numbered, of_targets;
} semantics[] = {{"POSITION", {"VEC3", NULL}, "f", false, true},
                 {"NORMAL", {"VEC3", NULL}, "f", false, true},
                 {"TANGENT", {"VEC4", NULL}, "f", false, true},
                 {"TEXCOORD", {"VEC2", NULL}, "fBNHN", true, true},
                 {"COLOR", {"VEC3", "VEC4"}, "fBNHN", true, true},
                 {"JOINTS", {"VEC4", NULL}, "BH", true, false},
                 {"WEIGHTS", {"VEC4", NULL}, "fBNHN", true, false}};
enum { SEMANTICS = sizeof semantics / sizeof semantics[0] };

/* The row of an attribute's name; SEMANTICS for one of its own (_NAME), more for a wrong one. */
static size_t semantic_of(const char *name, size_t *number) {
    if (name[0] == '_') return SEMANTICS;
    for (size_t i = 0; i < SEMANTICS; ++i)
        if (semantics[i].is_numbered ? numbered(name, semantics[i].name, number)
                                     : strcmp(name, semantics[i].name) == 0)
            return i;
    return SEMANTICS + 1;
}

static bool is_quantized(const mcv_strict *s) {
    const json_t *used = json_object_get(s->root, "extensionsRequired");
    for (size_t i = 0; i < json_array_size(used); ++i) {
        const char *name = json_string_value(json_array_get(used, i));
        if (name && strcmp(name, "KHR_mesh_quantization") == 0) return true;
    }
    return false;
}

static void check_format(mcv_strict *s, const json_t *accessor, size_t row,
                         const mcv_json_path *place) {
    const uint64_t type = mcv_strict_uint(accessor, "componentType", 0);
    if (type == 5125)
        mcv_strict_find(s, "MESH_PRIMITIVE_ATTRIBUTES_ACCESSOR_UNSIGNED_INT", place,
                        "must not be of 32-bit integers");
    else if (row < SEMANTICS && !is_quantized(s) &&
             !mcv_strict_has_format(accessor, semantics[row].type[0], semantics[row].components) &&
             !(semantics[row].type[1] &&
               mcv_strict_has_format(accessor, semantics[row].type[1], semantics[row].components)))
        mcv_strict_find(s, "MESH_PRIMITIVE_ATTRIBUTES_ACCESSOR_INVALID_FORMAT", place,
                        "must be a %s of its component types", semantics[row].type[0]);
}

/* Places of elements in their view. */
static void check_layout(mcv_strict *s, const json_t *accessor, const mcv_json_path *place) {
    const json_t *view = mcv_strict_target(s, accessor, "bufferView", "bufferViews");
    const uint64_t bytes =
        mcv_strict_component_bytes(mcv_strict_uint(accessor, "componentType", 0)) *
        mcv_strict_components(accessor);
    if (!view || bytes == 0) return;
    if (mcv_strict_uint(accessor, "byteOffset", 0) % 4 != 0 ||
        mcv_strict_uint(view, "byteStride", bytes) % 4 != 0)
        mcv_strict_find(s, "MESH_PRIMITIVE_ACCESSOR_UNALIGNED", place,
                        "its elements must begin at multiples of 4 bytes");
}

/* Tells a fault of an element, unless one of its kind was told. */
static void tell_once(mcv_strict *s, bool *told, const char *code, const mcv_json_path *place,
                      const char *what, double value) {
    if (!*told) mcv_strict_find(s, code, place, "%s, not %g", what, value);
    *told = true;
}

/* Lengths, signs and ranges of the elements. */
static void check_elements(mcv_strict *s, const json_t *accessor, size_t row,
                           const mcv_json_path *place) {
    if (mcv_strict_uint(accessor, "componentType", 0) != 5126 || row == 0 || row == 3 ||
        row >= SEMANTICS)
        return;
    const unsigned n = mcv_strict_components(accessor);
    bool told[3] = {false};
    for (uint64_t i = 0; i < mcv_strict_uint(accessor, "count", 0); ++i) {
        double square = 0, value = 0;
        for (unsigned k = 0; k < n; ++k) {
            if (!mcv_strict_value(s, accessor, i, k, &value)) return;
            if (k < 3) square += value * value;
            if (row >= 4 && !(value >= 0 && value <= 1))
                tell_once(s, told, "ACCESSOR_NON_CLAMPED", place, "must lie from 0 to 1", value);
        }
        /* Half of a unit of 8-bit normals. */
        if (row <= 2 && !(fabs(sqrt(square) - 1) <= 0.00674))
            tell_once(s, told + 1, "ACCESSOR_VECTOR3_NON_UNIT", place, "vectors must have length 1",
                      sqrt(square));
        if (row == 2 && value != 1 && value != -1)
            tell_once(s, told + 2, "ACCESSOR_INVALID_SIGN", place, "w must be 1 or -1", value);
    }
}

/* The number that is kept under a text; without one, `number`, which is kept from then on. */
static json_int_t keep_first(mcv_strict *s, json_t *kept, const char *text, json_int_t number) {
    const json_t *known = text ? json_object_get(kept, text) : NULL;
    if (known) return json_integer_value(known);
    if (!text || json_object_set_new_nocheck(kept, text, json_integer(number)) != 0)
        s->no_memory = true;
    return number;
}

/* Do two attributes without a byteStride share a view? Each further one is told. */
static void check_shared(mcv_strict *s, json_t *attributes, const mcv_json_path *place) {
    enum { SEVERAL = -1 };
    json_t *kept = json_object(), *value; /* the accessor in each view */
    const char *key;
    json_object_foreach(attributes, key, value) {
        const json_t *accessor = mcv_strict_target(s, attributes, key, "accessors");
        const json_t *view = mcv_strict_target(s, accessor, "bufferView", "bufferViews");
        const mcv_json_path here = mcv_json_path_key(place, key);
        if (!view || json_object_get(view, "byteStride")) continue;
        const json_int_t own = (json_int_t)mcv_strict_uint(attributes, key, 0);
        char text[32];
        snprintf(text, sizeof text, "%llu",
                 (unsigned long long)mcv_strict_uint(accessor, "bufferView", 0));
        if (keep_first(s, kept, text, own) == own) continue;
        mcv_strict_find(s, "MESH_PRIMITIVE_ACCESSOR_WITHOUT_BYTESTRIDE", &here,
                        "shares its bufferView, which needs a byteStride");
        json_object_set_new_nocheck(kept, text, json_integer(SEVERAL));
    }
    json_decref(kept);
}

static void check_attributes(mcv_strict *s, json_t *attributes, const mcv_json_path *place) {
    size_t most[SEMANTICS] = {0}, found[SEMANTICS] = {0}, number = 0;
    uint64_t count = UINT64_MAX;
    const json_t *told[SEMANTICS] = {NULL};
    const char *key;
    json_t *value;
    json_object_foreach(attributes, key, value) {
        const json_t *accessor = mcv_strict_target(s, attributes, key, "accessors");
        const mcv_json_path here = mcv_json_path_key(place, key);
        const size_t row = semantic_of(key, &number);
        if (row > SEMANTICS)
            mcv_strict_find(s, "MESH_PRIMITIVE_INVALID_ATTRIBUTE", &here,
                            "is no name of an attribute: names of your own begin with _");
        if (row < SEMANTICS && semantics[row].is_numbered) {
            ++found[row];
            if (number + 1 > most[row]) most[row] = number + 1;
        }
        if (!accessor) continue;
        const uint64_t own = mcv_strict_uint(accessor, "count", 0);
        if (count != UINT64_MAX && own != count)
            mcv_strict_find(s, "MESH_PRIMITIVE_UNEQUAL_ACCESSOR_COUNT", &here,
                            "has another count than the other attributes");
        count = own;
        check_format(s, accessor, row, &here);
        check_layout(s, accessor, &here);
        if (row >= SEMANTICS || told[row] != accessor) check_elements(s, accessor, row, &here);
        if (row < SEMANTICS) told[row] = accessor; /* COLOR_0 and COLOR_1 may be the same */
    }
    for (size_t i = 0; i < SEMANTICS; ++i)
        if (most[i] != found[i])
            mcv_strict_find(s, "MESH_PRIMITIVE_INDEXED_SEMANTIC_CONTINUITY", place,
                            "%s_n must begin with 0 and leave none out", semantics[i].name);
    check_shared(s, attributes, place);
}

static void check_targets(mcv_strict *s, const json_t *primitive, const mcv_json_path *place) {
    const json_t *targets = json_object_get(primitive, "targets"),
                 *base = json_object_get(primitive, "attributes");
    const mcv_json_path all = mcv_json_path_key(place, "targets");
    for (size_t i = 0; i < json_array_size(targets); ++i) {
        json_t *target = json_array_get(targets, i), *value;
        const mcv_json_path here = mcv_place_index(&all, i);
        const char *key;
        size_t number;
        if (json_is_object(target) && json_object_size(target) == 0)
            mcv_strict_find(s, "EMPTY_ENTITY", &here, "is empty");
        json_object_foreach(target, key, value) {
            const mcv_json_path there = mcv_json_path_key(&here, key);
            const json_t *accessor = mcv_strict_target(s, target, key, "accessors"),
                         *own = mcv_strict_target(s, base, key, "accessors");
            const size_t row = semantic_of(key, &number);
            if (row > SEMANTICS || (row < SEMANTICS && !semantics[row].of_targets))
                mcv_strict_find(s, "MESH_PRIMITIVE_INVALID_ATTRIBUTE", &there,
                                "is no name of an attribute of a morph target");
            if (!json_object_get(base, key))
                mcv_strict_find(s, "MESH_PRIMITIVE_MORPH_TARGET_NO_BASE_ACCESSOR", &there,
                                "the primitive has no such attribute");
            if (!accessor)
                mcv_strict_find(s, "UNRESOLVED_REFERENCE", &there, "there is no such accessor");
            if (accessor && own &&
                mcv_strict_uint(own, "count", 0) != mcv_strict_uint(accessor, "count", 0))
                mcv_strict_find(s, "MESH_PRIMITIVE_MORPH_TARGET_INVALID_ATTRIBUTE_COUNT", &there,
                                "has another count than the primitive's attribute");
        }
    }
}

static bool uses_view(const mcv_strict *s, json_t *attributes, const json_t *view) {
    const char *key;
    json_t *value;
    json_object_foreach(attributes, key, value) {
        const json_t *accessor = mcv_strict_target(s, attributes, key, "accessors");
        if (mcv_strict_target(s, accessor, "bufferView", "bufferViews") == view) return true;
    }
    return false;
}

static void check_indices(mcv_strict *s, const json_t *primitive, const mcv_json_path *place) {
    const json_t *accessor = mcv_strict_target(s, primitive, "indices", "accessors");
    const json_t *view = mcv_strict_target(s, accessor, "bufferView", "bufferViews");
    json_t *attributes = json_object_get(primitive, "attributes");
    const mcv_json_path here = mcv_json_path_key(place, "indices");
    const json_t *positions = mcv_strict_target(s, attributes, "POSITION", "accessors");
    if (!accessor) return;
    if (!mcv_strict_has_format(accessor, "SCALAR", "BHI") ||
        json_is_true(json_object_get(accessor, "normalized")))
        mcv_strict_find(s, "MESH_PRIMITIVE_INDICES_ACCESSOR_INVALID_FORMAT", &here,
                        "must be a SCALAR of unsigned integers");
    if (view && json_object_get(view, "byteStride"))
        mcv_strict_find(s, "MESH_PRIMITIVE_INDICES_ACCESSOR_WITH_BYTESTRIDE", &here,
                        "must have no byteStride");
    if (view && (uses_view(s, attributes, view) || mcv_strict_uint(view, "target", 0) == 34962))
        mcv_strict_find(s, "BUFFER_VIEW_TARGET_OVERRIDE", &here,
                        "its bufferView holds vertices: indices need one of their own");
    const uint64_t type = mcv_strict_uint(accessor, "componentType", 0),
                   vertices = mcv_strict_uint(positions, "count", UINT64_MAX);
    const double restart = type == 5121 ? UINT8_MAX : type == 5123 ? UINT16_MAX : UINT32_MAX;
    bool told[2] = {false};
    for (uint64_t i = 0; i < mcv_strict_uint(accessor, "count", 0); ++i) {
        double value;
        if (!mcv_strict_value(s, accessor, i, 0, &value)) break;
        if (value == restart)
            tell_once(s, told, "ACCESSOR_INDEX_PRIMITIVE_RESTART", &here,
                      "must be indices, which end below that of a restart", value);
        else if (positions && value >= (double)vertices)
            tell_once(s, told + 1, "ACCESSOR_INDEX_OOB", &here, "must be indices of vertices",
                      value);
    }
}

/* Tells a texture below `object` whose set of coordinates the attributes lack. */
static void check_textures(mcv_strict *s, json_t *object, const json_t *attributes, int depth,
                           const mcv_json_path *place) {
    const char *key;
    json_t *value;
    if (depth > 6) return;
    json_object_foreach(object, key, value) {
        const size_t length = strlen(key);
        if (length < 7 || strcmp(key + length - 7, "Texture") != 0) {
            check_textures(s, value, attributes, depth + 1, place);
            continue;
        }
        const json_t *moved = mcv_json_extension(value, "KHR_texture_transform");
        char name[32];
        snprintf(name, sizeof name, "TEXCOORD_%llu",
                 (unsigned long long)mcv_strict_uint(moved, "texCoord",
                                                     mcv_strict_uint(value, "texCoord", 0)));
        if (json_is_object(value) && !json_object_get(attributes, name))
            mcv_strict_find(s, "MESH_PRIMITIVE_TOO_FEW_TEXCOORDS", place, "its %.64s needs %s", key,
                            name);
    }
}

static void check_material(mcv_strict *s, const json_t *primitive, const mcv_json_path *place) {
    const json_t *material = mcv_strict_target(s, primitive, "material", "materials"),
                 *attributes = json_object_get(primitive, "attributes");
    const mcv_json_path here = mcv_json_path_key(place, "material");
    if (!material) return;
    check_textures(s, (json_t *)material, attributes, 0, &here);
    if (mcv_json_extension(material, "KHR_materials_anisotropy") &&
        !json_object_get(attributes, "TANGENT") && !json_object_get(material, "normalTexture"))
        mcv_strict_find(s, "MESH_PRIMITIVE_NO_TANGENT_SPACE", &here,
                        "its anisotropy needs the attribute TANGENT, or a normal texture");
}

/* Variants of KHR_materials_variants: each in one mapping at most. */
static void check_variants(mcv_strict *s, const json_t *primitive, const mcv_json_path *place) {
    const json_t *mappings =
        json_object_get(mcv_json_extension(primitive, "KHR_materials_variants"), "mappings");
    const mcv_json_path all = mcv_json_path_key(place, "extensions"),
                        here = mcv_json_path_key(&all, "KHR_materials_variants"),
                        list = mcv_json_path_key(&here, "mappings");
    json_t *kept = mappings ? json_object() : NULL; /* the first mapping of each variant */
    for (size_t i = 0; i < json_array_size(mappings); ++i) {
        const json_t *variants = json_object_get(json_array_get(mappings, i), "variants");
        const mcv_json_path mapping = mcv_place_index(&list, i),
                            places = mcv_json_path_key(&mapping, "variants");
        for (size_t k = 0; k < json_array_size(variants); ++k) {
            const json_t *variant = json_array_get(variants, k);
            const bool zero = json_is_real(variant) && json_real_value(variant) == 0; /* or -0.0 */
            char *text =
                zero ? strdup("0.0") : json_dumps(variant, JSON_ENCODE_ANY | JSON_SORT_KEYS);
            const mcv_json_path there = mcv_place_index(&places, k);
            if (keep_first(s, kept, text, (json_int_t)i) < (json_int_t)i)
                mcv_strict_find(s, "KHR_MATERIALS_VARIANTS_NON_UNIQUE_VARIANT", &there,
                                "stands in another mapping, too");
            free(text);
        }
    }
    json_decref(kept);
}

static void check_mesh(mcv_strict *s, const json_t *mesh, const mcv_json_path *place) {
    const json_t *primitives = json_object_get(mesh, "primitives"),
                 *weights = json_object_get(mesh, "weights");
    const mcv_json_path list = mcv_json_path_key(place, "primitives"),
                        weights_place = mcv_json_path_key(place, "weights");
    const json_t *leader = json_array_get(primitives, 0);
    const size_t first = json_array_size(json_object_get(leader, "targets"));
    const bool leads = json_is_object(json_object_get(leader, "attributes"));
    for (size_t i = 0; i < json_array_size(primitives); ++i) {
        const json_t *primitive = json_array_get(primitives, i),
                     *targets = json_object_get(primitive, "targets");
        const mcv_json_path here = mcv_place_index(&list, i),
                            attributes_place = mcv_json_path_key(&here, "attributes"),
                            targets_place = mcv_json_path_key(&here, "targets");
        json_t *attributes = json_object_get(primitive, "attributes");
        if (json_is_object(attributes)) check_attributes(s, attributes, &attributes_place);
        check_targets(s, primitive, &here);
        check_indices(s, primitive, &here);
        check_material(s, primitive, &here);
        check_variants(s, primitive, &here);
        if (leads && json_is_object(primitive) && (!targets || json_is_array(targets)) &&
            json_array_size(targets) != first && json_is_object(attributes))
            mcv_strict_find(s, "MESH_PRIMITIVES_UNEQUAL_TARGETS_COUNT",
                            targets ? &targets_place : &here,
                            "must have as many morph targets as the first primitive");
    }
    if (weights && json_array_size(weights) != first)
        mcv_strict_find(s, "MESH_INVALID_WEIGHTS_COUNT", &weights_place,
                        "has %zu numbers for %zu morph targets", json_array_size(weights), first);
}

void mcv_strict_meshes(mcv_strict *s) {
    const mcv_json_path place = mcv_json_path_key(&s->file, "meshes");
    for (size_t i = 0; i < json_array_size(mcv_strict_list(s, "meshes")); ++i) {
        const json_t *mesh = mcv_strict_item(s, "meshes", i);
        const mcv_json_path here = mcv_place_index(&place, i);
        if (mesh) check_mesh(s, mesh, &here);
    }
}
