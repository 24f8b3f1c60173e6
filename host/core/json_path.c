/* SPDX-License-Identifier: Apache-2.0 */
#include "core/json_path.h"

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

/* Appends to text[size], which has `length` bytes; returns the new length, at most size - 1. */
__attribute__((format(printf, 4, 0))) static size_t append(char *text, size_t size, size_t length,
                                                           const char *format, va_list arguments) {
    const int more = vsnprintf(text + length, size - length, format, arguments);
    return more < 0 ? length : length + (size_t)more < size ? length + (size_t)more : size - 1;
}

__attribute__((format(printf, 4, 5))) static size_t add(char *text, size_t size, size_t length,
                                                        const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    length = append(text, size, length, format, arguments);
    va_end(arguments);
    return length;
}

static size_t add_place(char *text, size_t size, size_t length, const mcv_json_path *place) {
    if (!place->parent) return add(text, size, length, "%s: ", place->key ? place->key : "scene");
    length = add_place(text, size, length, place->parent);
    return place->key
               ? add(text, size, length, "%s%s", place->parent->parent ? "/" : "", place->key)
               : add(text, size, length, "%s%zu", place->parent->parent ? "/" : "", place->index);
}

mcv_result(mcv_fail_at)(const mcv_json_path *place, mcv_error *error, const char *format, ...) {
    const size_t size = sizeof error->text;
    mcv_error sentence = {""}; /* the arguments may point into error */
    size_t length = add_place(sentence.text, size, 0, place);
    if (place->parent) length = add(sentence.text, size, length, ": ");
    va_list arguments;
    va_start(arguments, format);
    append(sentence.text, size, length, format, arguments);
    va_end(arguments);
    for (char *c = sentence.text; *c; ++c) /* a name may not begin a line of its own */
        if (*c == '\n' || *c == '\r') *c = ' ';
    *error = sentence;
    return MCV_BAD_INPUT;
}

mcv_result mcv_fail_memory(const mcv_json_path *place, mcv_error *error) {
    mcv_fail_at(place, error, "no memory for it");
    return MCV_FAILED;
}
