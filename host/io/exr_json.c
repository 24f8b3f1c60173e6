/* SPDX-License-Identifier: Apache-2.0 */
#include "io/exr_json.h"

#include "core/json.h"

#include <math.h>
#include <string.h>

/* A text, a number or a list of 2, 4 or 16 numbers. */
static mcv_result set_from_json(mcv_exr *exr, const char *key, const json_t *value,
                                mcv_error *error) {
    const size_t count = json_is_array(value) ? json_array_size(value) : 1;
    mcv_attribute a = {.name = key, .text = json_string_value(value), .count = (uint32_t)count};
    bool right = strlen(key) < MCV_EXR_ATTRIBUTE_NAME &&
                 (a.text || count == 1 || count == 2 || count == 4 || count == 16);
    for (size_t i = 0; right && !a.text && i < count; ++i) {
        const json_t *number = json_is_array(value) ? json_array_get(value, i) : value;
        right = json_is_number(number);
        a.numbers[i] = json_number_value(number);
    }
    if (right) return mcv_exr_set_attributes(exr, &a, 1, error);
    return mcv_fail(error, MCV_USAGE,
                    "attributes: %s: must be a text, a number or a list of 2, 4 or 16 numbers, and "
                    "its name at most %d bytes long",
                    key, MCV_EXR_ATTRIBUTE_NAME - 1);
}

mcv_result mcv_attributes_set_json(mcv_exr *exr, const json_t *object, mcv_error *error) {
    const char *key;
    json_t *value;
    if (!json_is_object(object))
        return mcv_fail(error, MCV_USAGE,
                        "attributes: must be a JSON object, as in {\"mcvisi:unit\": \"DN\"}");
    json_object_foreach((json_t *)object, key, value) {
        MCV_TRY(set_from_json(exr, key, value, error));
    }
    return MCV_OK;
}

/* JSON has neither NaN nor infinity. */
static json_t *number_json(double value) {
    return isfinite(value) ? json_real(value) : json_null();
}

static json_t *attribute_json(const mcv_attribute *a) {
    if (a->text) return mcv_json_text(a->text);
    if (a->count == 1) return number_json(a->numbers[0]);
    json_t *list = json_array();
    for (uint32_t i = 0; i < a->count; ++i) json_array_append_new(list, number_json(a->numbers[i]));
    return list;
}

json_t *mcv_attributes_json(const mcv_exr *exr) {
    json_t *object = json_object();
    for (uint32_t i = 0; object && i < exr->attribute_count; ++i)
        json_object_set_new(object, exr->attributes[i].name, attribute_json(exr->attributes + i));
    return object;
}
