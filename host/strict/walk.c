/* SPDX-License-Identifier: Apache-2.0 */
/* Each object by itself: its members' types, ranges and references, by the tables of rules.c. */
#include "strict/strict_parts.h"

#include "strict/rules.h"

#include <string.h>

static void check_members(mcv_strict *s, const json_t *object, const mcv_rule *rules,
                          const mcv_rule_type *type, const mcv_json_path *place);

/* The array of the root at a path of keys. */
static const json_t *list_at(const mcv_strict *s, const char *path) {
    const json_t *at = s->root;
    while (*path) {
        const size_t length = strcspn(path, "/");
        at = json_object_getn(at, path, length);
        path += length + (path[length] == '/');
    }
    return json_is_array(at) ? at : NULL;
}

static bool is_integer(const json_t *value) {
    const double number = json_number_value(value);
    return json_is_number(value) && number == floor(number);
}

static void check_index(mcv_strict *s, const json_t *value, const mcv_rule *rule,
                        const mcv_json_path *place) {
    const double number = json_number_value(value);
    if (!is_integer(value))
        mcv_strict_find(s, "TYPE_MISMATCH", place, "must be an integer");
    else if (number < 0)
        mcv_strict_find(s, "VALUE_NOT_IN_RANGE", place, "%g must not be negative", number);
    else if (number >= (double)json_array_size(list_at(s, rule->to)))
        mcv_strict_find(s, "UNRESOLVED_REFERENCE", place, "%s has no element %g", rule->to, number);
}

static void check_range(mcv_strict *s, double number, const mcv_rule *rule,
                        const mcv_json_path *place) {
    if (rule->low == 0 && rule->high == 0) return;
    const bool low = rule->above ? number > rule->low : number >= rule->low;
    if (!low || !(number <= rule->high) || !isfinite(number))
        mcv_strict_find(s, "VALUE_NOT_IN_RANGE", place, "%g must %s %g and at most %g", number,
                        rule->above ? "be above" : "be at least", rule->low, rule->high);
}

static void check_numbers(mcv_strict *s, const json_t *array, const mcv_rule *rule,
                          const mcv_json_path *place) {
    const size_t count = json_array_size(array);
    if (rule->most && (count < rule->least || count > rule->most))
        mcv_strict_find(s, "ARRAY_LENGTH_NOT_IN_LIST", place,
                        "has %zu numbers, but must have %u to %u", count, rule->least, rule->most);
    for (size_t i = 0; i < count; ++i) {
        const json_t *value = json_array_get(array, i);
        const mcv_json_path here = mcv_place_index(place, i);
        if (!json_is_number(value)) {
            mcv_strict_find(s, "ARRAY_TYPE_MISMATCH", place, "element %zu must be a number", i);
            return;
        }
        check_range(s, json_number_value(value), rule, &here);
    }
}

static void check_indices(mcv_strict *s, const json_t *array, const mcv_rule *rule,
                          const mcv_json_path *place) {
    for (size_t i = 0; i < json_array_size(array); ++i) {
        const json_t *value = json_array_get(array, i);
        const mcv_json_path here = mcv_place_index(place, i);
        check_index(s, value, rule, &here);
        for (size_t k = 0; k < i && i < 1000; ++k) /* a thousand are enough to tell */
            if (json_equal(value, json_array_get(array, k)))
                mcv_strict_find(s, "ARRAY_DUPLICATE_ELEMENTS", &here, "stands there twice");
    }
}

static void check_array(mcv_strict *s, json_t *array, const mcv_rule *rule,
                        const mcv_json_path *place) {
    if (!json_is_array(array)) {
        mcv_strict_find(s, "TYPE_MISMATCH", place, "must be an array");
        return;
    }
    if (json_array_size(array) == 0) mcv_strict_find(s, "EMPTY_ENTITY", place, "is empty");
    if (rule->kind == MCV_RULE_NUMBERS) {
        check_numbers(s, array, rule, place);
        return;
    }
    if (rule->kind == MCV_RULE_INDICES) {
        check_indices(s, array, rule, place);
        return;
    }
    for (size_t i = 0; i < json_array_size(array); ++i) {
        const json_t *element = json_array_get(array, i);
        const mcv_json_path here = mcv_place_index(place, i);
        if (rule->kind == MCV_RULE_STRINGS ? !json_is_string(element) : !json_is_object(element))
            mcv_strict_find(s, "ARRAY_TYPE_MISMATCH", place, "element %zu must be %s", i,
                            rule->kind == MCV_RULE_STRINGS ? "a string" : "an object");
        else if (rule->kind == MCV_RULE_LIST)
            check_members(s, element, rule->of->rules, rule->of, &here);
    }
}

static void check_references(mcv_strict *s, json_t *object, const mcv_rule *rule,
                             const mcv_json_path *place) {
    const char *key;
    json_t *value;
    if (json_object_size(object) == 0) mcv_strict_find(s, "EMPTY_ENTITY", place, "is empty");
    json_object_foreach(object, key, value) {
        const mcv_json_path here = mcv_json_path_key(place, key);
        check_index(s, value, rule, &here);
    }
}

static void check_value(mcv_strict *s, json_t *value, const mcv_rule *rule,
                        const mcv_json_path *place) {
    const char *wanted = NULL;
    switch (rule->kind) {
    case MCV_RULE_BOOLEAN:
        if (!json_is_boolean(value)) wanted = "true or false";
        break;
    case MCV_RULE_STRING:
        if (!json_is_string(value)) wanted = "a string";
        break;
    case MCV_RULE_INTEGER:
    case MCV_RULE_NUMBER:
        if (rule->kind == MCV_RULE_INTEGER ? !is_integer(value) : !json_is_number(value))
            wanted = rule->kind == MCV_RULE_INTEGER ? "an integer" : "a number";
        else
            check_range(s, json_number_value(value), rule, place);
        break;
    case MCV_RULE_INDEX:
        check_index(s, value, rule, place);
        break;
    case MCV_RULE_OBJECT:
    case MCV_RULE_REFERENCES:
        if (!json_is_object(value))
            wanted = "an object";
        else if (rule->kind == MCV_RULE_OBJECT)
            check_members(s, value, rule->of->rules, rule->of, place);
        else
            check_references(s, value, rule, place);
        break;
    default:
        check_array(s, value, rule, place);
    }
    if (wanted) mcv_strict_find(s, "TYPE_MISMATCH", place, "must be %s", wanted);
}

static void check_extension(mcv_strict *s, const char *name, const json_t *object,
                            const mcv_rule_type *type, const mcv_json_path *place) {
    bool known = false;
    for (const mcv_rule_extension *e = mcv_rule_extensions; e->name; ++e) {
        if (strcmp(e->name, name) != 0) continue;
        known = true;
        if (!e->at || strcmp(e->at->name, type->name) != 0) continue;
        const mcv_rule_type own = {name, e->rules};
        if (json_is_object(object))
            check_members(s, object, e->rules, &own, place);
        else
            mcv_strict_find(s, "TYPE_MISMATCH", place, "must be an object");
        return;
    }
    if (known)
        mcv_strict_find(s, "UNEXPECTED_EXTENSION_OBJECT", place,
                        "the extension does not belong here");
}

static void check_extensions(mcv_strict *s, const json_t *object, const mcv_rule_type *type,
                             const mcv_json_path *place) {
    json_t *extensions = json_object_get(object, "extensions"), *value;
    const json_t *used = json_object_get(s->root, "extensionsUsed");
    const mcv_json_path here = mcv_json_path_key(place, "extensions");
    const char *name;
    if (!extensions) return;
    if (!json_is_object(extensions)) {
        mcv_strict_find(s, "TYPE_MISMATCH", &here, "must be an object");
        return;
    }
    json_object_foreach(extensions, name, value) {
        const mcv_json_path there = mcv_json_path_key(&here, name);
        bool declared = false;
        for (size_t i = 0; i < json_array_size(used); ++i) {
            const char *other = json_string_value(json_array_get(used, i));
            declared = declared || (other && strcmp(other, name) == 0);
        }
        if (!declared)
            mcv_strict_find(s, "UNDECLARED_EXTENSION", &there, "must stand in extensionsUsed");
        check_extension(s, name, value, type, &there);
    }
}

static void check_members(mcv_strict *s, const json_t *object, const mcv_rule *rules,
                          const mcv_rule_type *type, const mcv_json_path *place) {
    for (; rules->key; ++rules) {
        json_t *value = json_object_get(object, rules->key);
        const mcv_json_path here = mcv_json_path_key(place, rules->key);
        if (value)
            check_value(s, value, rules, &here);
        else if (rules->required)
            mcv_strict_find(s, "UNDEFINED_PROPERTY", place, "must have \"%s\"", rules->key);
    }
    check_extensions(s, object, type, place);
}

/* Every required extension is used, too. */
static void check_required(mcv_strict *s) {
    const json_t *used = json_object_get(s->root, "extensionsUsed"),
                 *required = json_object_get(s->root, "extensionsRequired");
    const mcv_json_path place = mcv_json_path_key(&s->file, "extensionsRequired");
    for (size_t i = 0; i < json_array_size(required); ++i) {
        const mcv_json_path here = mcv_place_index(&place, i);
        bool found = false;
        for (size_t k = 0; k < json_array_size(used); ++k)
            found = found || json_equal(json_array_get(used, k), json_array_get(required, i));
        if (!found)
            mcv_strict_find(s, "UNUSED_EXTENSION_REQUIRED", &here,
                            "must stand in extensionsUsed, too");
    }
}

void mcv_strict_walk(mcv_strict *s) {
    check_members(s, s->root, mcv_rule_root.rules, &mcv_rule_root, &s->file);
    check_required(s);
}

const json_t *mcv_strict_list(const mcv_strict *s, const char *name) { return list_at(s, name); }

const json_t *mcv_strict_item(const mcv_strict *s, const char *name, size_t i) {
    const json_t *item = json_array_get(list_at(s, name), i);
    return json_is_object(item) ? item : NULL;
}

uint64_t mcv_strict_uint(const json_t *object, const char *key, uint64_t usual) {
    const json_t *value = json_object_get(object, key);
    const double number = json_number_value(value);
    return is_integer(value) && number >= 0 && number < 0x1p53 ? (uint64_t)number : usual;
}

const json_t *mcv_strict_target(const mcv_strict *s, const json_t *object, const char *key,
                                const char *list) {
    const uint64_t index = mcv_strict_uint(object, key, UINT64_MAX);
    return index < json_array_size(list_at(s, list)) ? mcv_strict_item(s, list, index) : NULL;
}
