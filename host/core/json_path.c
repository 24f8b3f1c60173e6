/* SPDX-License-Identifier: Apache-2.0 */
#include "core/json_path.h"

#include "core/basics.h"

#include <limits.h>
#include <stdarg.h>
#include <stdio.h>

mcv_json_path mcv_place_file(const char *path) { return (mcv_json_path){NULL, path, 0}; }

mcv_json_path mcv_json_path_key(const mcv_json_path *parent, const char *key) {
    return (mcv_json_path){parent, key, 0};
}

mcv_json_path mcv_place_index(const mcv_json_path *parent, size_t index) {
    return (mcv_json_path){parent, NULL, index};
}

mcv_json_path mcv_json_path_element(const mcv_json_path *parent, const char *name, size_t index) {
    return name && *name ? mcv_json_path_key(parent, name) : mcv_place_index(parent, index);
}

__attribute__((format(printf, 4, 5))) static size_t add(char *text, size_t size, size_t length,
                                                        const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    const int more = vsnprintf(text + length, size - length, format, arguments);
    va_end(arguments);
    return more < 0 ? length : length + (size_t)more < size ? length + (size_t)more : size - 1;
}

/* Names of elements may be long: their first 64 bytes tell them. */
static size_t add_place(char *text, size_t size, size_t length, const mcv_json_path *place) {
    if (!place->parent) return add(text, size, length, "%s: ", place->key ? place->key : "scene");
    length = add_place(text, size, length, place->parent);
    const char *slash = place->parent->parent ? "/" : "";
    if (!place->key) return add(text, size, length, "%s%zu", slash, place->index);
    const int shown = mcv_whole_characters(place->key, 64);
    return add(text, size, length, "%s%.*s%s", slash, shown, place->key,
               place->key[shown] ? "…" : "");
}

mcv_result(mcv_fail_at)(const mcv_json_path *place, mcv_error *error, const char *format, ...) {
    char text[PATH_MAX + sizeof error->text];
    const size_t length = add_place(text, sizeof text, 0, place);
    if (place->parent) add(text, sizeof text, length, ": ");
    va_list arguments;
    va_start(arguments, format);
    mcv_write_sentence(error, false, text, format, arguments);
    va_end(arguments);
    return MCV_BAD_INPUT;
}

mcv_result(mcv_fail_memory)(const mcv_json_path *place, mcv_error *error) {
    mcv_fail_at(place, error, "no memory for it");
    return MCV_FAILED;
}
