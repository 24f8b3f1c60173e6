/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Checked reading of members of a JSON object. If the type or the range is wrong, each function
 * writes a sentence with the member's path. `object` has the path `place`. An absent member leaves
 * *out unchanged, so the caller sets the default before.
 */
#ifndef MCVISI_HOST_CORE_JSON_H
#define MCVISI_HOST_CORE_JSON_H

#include "core/json_path.h"

#include <jansson.h>

/* An integer in [min, max]; glTF allows the form 3.0. */
mcv_result mcv_json_uint(const json_t *object, const char *key, uint64_t min, uint64_t max,
                         uint64_t *out, const mcv_json_path *place, mcv_error *error);

/* An index into the `count` elements of the root array `of`; MCV_NONE if absent. */
mcv_result mcv_json_index(const json_t *object, const char *key, size_t count, const char *of,
                          uint32_t *out, const mcv_json_path *place, mcv_error *error);

/* Finite numbers in [min, max]: one, or an array of exactly n. */
mcv_result mcv_json_number(const json_t *object, const char *key, double min, double max,
                           double *out, const mcv_json_path *place, mcv_error *error);
mcv_result mcv_json_numbers(const json_t *object, const char *key, size_t n, double min, double max,
                            double *out, const mcv_json_path *place, mcv_error *error);

mcv_result mcv_json_string(const json_t *object, const char *key, const char **out,
                           const mcv_json_path *place, mcv_error *error);
mcv_result mcv_json_bool(const json_t *object, const char *key, bool *out,
                         const mcv_json_path *place, mcv_error *error);

/* A non-empty array, or an object; NULL if absent. */
mcv_result mcv_json_array(const json_t *object, const char *key, json_t **out,
                          const mcv_json_path *place, mcv_error *error);
mcv_result mcv_json_object(const json_t *object, const char *key, json_t **out,
                           const mcv_json_path *place, mcv_error *error);

/* A JSON string of a text; bytes that are not UTF-8, as paths may have, become U+FFFD. */
json_t *mcv_json_text(const char *text);

/* Puts a value, which it takes, into *object. Where memory is missing, *object is released and
 * becomes NULL; one that is NULL stays so, so that only the last of several needs a look. */
void mcv_json_put(json_t **object, const char *key, json_t *value);

/*
 * json_loadb, for texts whose strings may be large. jansson's parser reads beyond the buffer of a
 * string that could not grow: the memory for the longest one is asked for beforehand. NULL with
 * wrong->text empty: no memory.
 */
json_t *mcv_json_parse(const char *text, size_t size, size_t flags, json_error_t *wrong);

/* The object extensions/NAME of an object, or NULL. */
json_t *mcv_json_extension(const json_t *object, const char *name);

/* The member `name` of an object as a string, "" if absent. */
const char *mcv_json_name(const json_t *object);

/* Bytes of an experiment, and of what stands beside a table, at most. As a tree they take some
 * 300 MB. */
enum { MCV_JSON_FILE_MOST = 4000000 };

/* Reads such a file: a regular one. MCV_BAD_INPUT names it. The caller owns *document. */
mcv_result mcv_json_file_read(const char *path, json_t **document, mcv_error *error);

/* The parser's error, without words about options of the parser. */
const char *mcv_json_wrong(const json_error_t *wrong);

/* The one of n words that is nearest to `word`, or NULL if none is near: for "did you mean". */
const char *mcv_nearest_word(const char *word, const char *const *words, size_t n);

#endif
