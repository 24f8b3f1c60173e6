/* SPDX-License-Identifier: Apache-2.0 */
#include "core/json.h"

#include "core/basics.h"
#include "core/output_file.h"
#include "mcvisi/dialect.h"

#include <stdlib.h>
#include <strings.h>

static const char *type_name(const json_t *value) {
    switch (json_typeof(value)) {
    case JSON_OBJECT:
        return "an object";
    case JSON_ARRAY:
        return "an array";
    case JSON_STRING:
        return "a string";
    case JSON_INTEGER:
    case JSON_REAL:
        return "a number";
    case JSON_TRUE:
    case JSON_FALSE:
        return "a boolean";
    default:
        return "null";
    }
}

static mcv_result fail_type(const json_t *value, const char *wanted, const mcv_json_path *place,
                            const char *key, mcv_error *error) {
    const mcv_json_path here = mcv_json_path_key(place, key);
    return mcv_fail_at(&here, error, "must be %s, not %s", wanted, type_name(value));
}

mcv_result mcv_json_uint(const json_t *object, const char *key, uint64_t min, uint64_t max,
                         uint64_t *out, const mcv_json_path *place, mcv_error *error) {
    const json_t *value = json_object_get(object, key);
    if (!value) return MCV_OK;
    if (!json_is_number(value)) return fail_type(value, "an integer", place, key, error);
    const double number = json_number_value(value);
    if (!(number >= (double)min && number <= (double)max) || number != floor(number)) {
        const mcv_json_path here = mcv_json_path_key(place, key);
        return mcv_fail_at(&here, error, "%g must be an integer from %llu to %llu", number,
                           (unsigned long long)min, (unsigned long long)max);
    }
    *out = json_is_integer(value) ? (uint64_t)json_integer_value(value) : (uint64_t)number;
    return MCV_OK;
}

mcv_result mcv_json_index(const json_t *object, const char *key, size_t count, const char *of,
                          uint32_t *out, const mcv_json_path *place, mcv_error *error) {
    *out = MCV_NONE;
    const json_t *value = json_object_get(object, key);
    if (!value) return MCV_OK;
    if (!json_is_number(value)) return fail_type(value, "an index", place, key, error);
    const double number = json_number_value(value);
    const mcv_json_path here = mcv_json_path_key(place, key);
    if (!(number >= 0 && number < (double)count) || number != floor(number)) {
        if (count == 0)
            return mcv_fail_at(&here, error, "index %g does not exist: the file has no %s", number,
                               of);
        return mcv_fail_at(&here, error, "index %g does not exist: %s go from 0 to %zu", number, of,
                           count - 1);
    }
    *out = (uint32_t)number;
    return MCV_OK;
}

static mcv_result read_number(const json_t *value, double min, double max, double *out,
                              const mcv_json_path *here, mcv_error *error) {
    if (!json_is_number(value))
        return mcv_fail_at(here, error, "must be a number, not %s", type_name(value));
    const double number = json_number_value(value);
    if (!(number >= min && number <= max))
        return mcv_fail_at(here, error, "%g must lie from %g to %g", number, min, max);
    *out = number;
    return MCV_OK;
}

mcv_result mcv_json_number(const json_t *object, const char *key, double min, double max,
                           double *out, const mcv_json_path *place, mcv_error *error) {
    const json_t *value = json_object_get(object, key);
    const mcv_json_path here = mcv_json_path_key(place, key);
    return value ? read_number(value, min, max, out, &here, error) : MCV_OK;
}

mcv_result mcv_json_numbers(const json_t *object, const char *key, size_t n, double min, double max,
                            double *out, const mcv_json_path *place, mcv_error *error) {
    const json_t *value = json_object_get(object, key);
    if (!value) return MCV_OK;
    const mcv_json_path here = mcv_json_path_key(place, key);
    if (!json_is_array(value) || json_array_size(value) != n)
        return mcv_fail_at(&here, error,
                           "must be an array of %zu numbers in brackets, as in [1, 0, …]", n);
    for (size_t i = 0; i < n; ++i) {
        const mcv_json_path element = mcv_place_index(&here, i);
        MCV_TRY(read_number(json_array_get(value, i), min, max, out + i, &element, error));
    }
    return MCV_OK;
}

mcv_result mcv_json_string(const json_t *object, const char *key, const char **out,
                           const mcv_json_path *place, mcv_error *error) {
    const json_t *value = json_object_get(object, key);
    if (!value) return MCV_OK;
    if (!json_is_string(value)) return fail_type(value, "a string", place, key, error);
    *out = json_string_value(value);
    return MCV_OK;
}

mcv_result mcv_json_bool(const json_t *object, const char *key, bool *out,
                         const mcv_json_path *place, mcv_error *error) {
    const json_t *value = json_object_get(object, key);
    if (!value) return MCV_OK;
    if (!json_is_boolean(value)) return fail_type(value, "true or false", place, key, error);
    *out = json_is_true(value);
    return MCV_OK;
}

mcv_result mcv_json_array(const json_t *object, const char *key, json_t **out,
                          const mcv_json_path *place, mcv_error *error) {
    *out = json_object_get(object, key);
    if (!*out) return MCV_OK;
    if (!json_is_array(*out)) return fail_type(*out, "an array", place, key, error);
    const mcv_json_path here = mcv_json_path_key(place, key);
    return json_array_size(*out)
               ? MCV_OK
               : mcv_fail_at(&here, error, "the array is empty: fill it or leave it out");
}

mcv_result mcv_json_object(const json_t *object, const char *key, json_t **out,
                           const mcv_json_path *place, mcv_error *error) {
    *out = json_object_get(object, key);
    return !*out || json_is_object(*out) ? MCV_OK : fail_type(*out, "an object", place, key, error);
}

json_t *mcv_json_text(const char *text) {
    static const char replacement[] = "\xef\xbf\xbd";
    char *valid = malloc(strlen(replacement) * strlen(text) + 1), *end = valid;
    if (!valid) return NULL;
    for (uint32_t code; *text;) {
        const int length = mcv_character(text, &code);
        memcpy(end, length ? text : replacement, length ? (size_t)length : strlen(replacement));
        end += length ? (size_t)length : strlen(replacement);
        text += length ? length : 1;
    }
    json_t *string = json_stringn(valid, (size_t)(end - valid));
    free(valid);
    return string;
}

void mcv_json_put(json_t **object, const char *key, json_t *value) {
    if (!*object) {
        json_decref(value);
    } else if (json_object_set_new(*object, key, value) != 0) {
        json_decref(*object);
        *object = NULL;
    }
}

/* The bytes between two quotation marks, at most. */
static size_t longest_string(const char *text, size_t size) {
    size_t longest = 0;
    for (size_t i = 0; i < size; ++i) {
        if (text[i] != '"') continue;
        const size_t begin = ++i;
        for (; i < size && text[i] != '"'; ++i) i += text[i] == '\\';
        if (i - begin > longest) longest = i - begin;
    }
    return longest;
}

json_t *mcv_json_parse(const char *text, size_t size, size_t flags, json_error_t *wrong) {
    /* The buffer doubles: the old and the new one, then the string itself. */
    const size_t needed = 5 * longest_string(text, size) + size;
    void *probe = malloc(needed);
    wrong->text[0] = '\0';
    if (!probe) return NULL;
    free(probe);
    return json_loadb(text, size, flags, wrong);
}

json_t *mcv_json_extension(const json_t *object, const char *name) {
    return json_object_get(json_object_get(object, "extensions"), name);
}

const char *mcv_json_name(const json_t *object) {
    const char *name = json_string_value(json_object_get(object, "name"));
    return name ? name : "";
}

/* The number of insertions, deletions and substitutions that turn a into b (Levenshtein), for words
 * below 64 letters. */
static size_t edit_distance(const char *a, const char *b) {
    size_t row[64];
    const size_t columns = strlen(b);
    if (columns >= 64) return SIZE_MAX;
    for (size_t j = 0; j <= columns; ++j) row[j] = j;
    for (size_t i = 0; a[i]; ++i) {
        size_t diagonal = row[0];
        row[0] = i + 1;
        for (size_t j = 0; j < columns; ++j) {
            const size_t substituted = diagonal + (a[i] != b[j]);
            const size_t shorter = (row[j] < row[j + 1] ? row[j] : row[j + 1]) + 1;
            diagonal = row[j + 1];
            row[j + 1] = substituted < shorter ? substituted : shorter;
        }
    }
    return row[columns];
}

mcv_result mcv_json_file_read(const char *path, json_t **document, mcv_error *error) {
    uint64_t size;
    json_error_t wrong;
    FILE *file;
    *document = NULL;
    MCV_TRY(mcv_file_open(path, &file, &size, error));
    const bool small = size <= MCV_JSON_FILE_MOST;
    if (small) *document = json_loadf(file, JSON_REJECT_DUPLICATES, &wrong);
    fclose(file);
    if (*document) return MCV_OK;
    if (!small)
        return mcv_fail(error, MCV_BAD_INPUT, "%s: is larger than 4 MB, the limit for such a file",
                        path);
    return mcv_fail(error, MCV_BAD_INPUT, "%s: line %d column %d is not JSON: %s", path, wrong.line,
                    wrong.column, mcv_json_wrong(&wrong));
}

const char *mcv_json_wrong(const json_error_t *wrong) {
    return strstr(wrong->text, "JSON_ALLOW_NUL")
               ? "the string contains \\u0000, which is not allowed"
               : wrong->text;
}

const char *mcv_nearest_word(const char *word, const char *const *words, size_t n) {
    const char *nearest = NULL;
    size_t least = 1 + strlen(word) / 3; /* a third of the letters may be wrong, but at least one */
    for (size_t i = 0; i < n; ++i) {
        if (strcasecmp(word, words[i]) == 0) return words[i];
        const size_t distance = edit_distance(word, words[i]);
        if (distance <= least && (!nearest || distance < least)) {
            nearest = words[i];
            least = distance;
        }
    }
    return nearest;
}
