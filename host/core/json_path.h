/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A path into the scene file: a linked list on the callers' stacks, which is written out only for
 * error messages. Elements are written as in --set (sensors/cam/focalLength), everything else as
 * JSON paths (nodes/3/rotation).
 */
#ifndef MCVISI_HOST_CORE_JSON_PATH_H
#define MCVISI_HOST_CORE_JSON_PATH_H

#include "core/error.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct mcv_json_path {
    const struct mcv_json_path *parent; /* NULL: the file itself, whose path is key */
    const char *key;                    /* NULL: an index */
    size_t index;
} mcv_json_path;

mcv_json_path mcv_place_file(const char *path);
mcv_json_path mcv_json_path_key(const mcv_json_path *parent, const char *key);
mcv_json_path mcv_place_index(const mcv_json_path *parent, size_t index);

/* An element, by its name, or by its index if the name is missing or empty. */
mcv_json_path mcv_json_path_element(const mcv_json_path *parent, const char *name, size_t index);

/* Writes "FILE: PATH: sentence" and returns MCV_BAD_INPUT. */
mcv_result mcv_fail_at(const mcv_json_path *place, mcv_error *error, const char *format, ...)
    __attribute__((format(printf, 3, 4)));
#ifdef __clang_analyzer__ /* as of mcv_fail */
#define mcv_fail_at(place, error, ...) (mcv_fail_at(place, error, __VA_ARGS__), MCV_BAD_INPUT)
#endif

/* No memory for what is at `place`. */
mcv_result mcv_fail_memory(const mcv_json_path *place, mcv_error *error);
#ifdef __clang_analyzer__ /* as of mcv_fail */
#define mcv_fail_memory(place, error) (mcv_fail_memory(place, error), MCV_FAILED)
#endif

#ifdef __cplusplus
}
#endif
#endif
