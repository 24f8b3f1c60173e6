/* SPDX-License-Identifier: Apache-2.0 */
#include "scene/param_lists.h"

mcv_result mcv_mask_parse(const json_t *rows, mcv_mask *mask, const mcv_json_path *place,
                          mcv_error *error) {
    const size_t side = json_array_size(rows);
    if (side < 1 || side > MCV_MASK_SIDE)
        return mcv_fail_at(place, error,
                           "must be an array of 1 to %d rows, each of as many numbers from 0 to 1",
                           MCV_MASK_SIDE);
    for (size_t j = 0; j < side; ++j) {
        const json_t *row = json_array_get(rows, j);
        const mcv_json_path here = mcv_place_index(place, j);
        if (json_array_size(row) != side)
            return mcv_fail_at(&here, error, "has %zu numbers, but must have %zu, as many as rows",
                               json_array_size(row), side);
        for (size_t i = 0; i < side; ++i) {
            const mcv_json_path element = mcv_place_index(&here, i);
            const json_t *value = json_array_get(row, i);
            const double number = json_number_value(value);
            if (!json_is_number(value) || !(number >= 0 && number <= 1))
                return mcv_fail_at(&element, error, "must be a number from 0 to 1");
            mask->values[j * side + i] = (float)number;
        }
    }
    mask->side = (uint32_t)side;
    return MCV_OK;
}

mcv_result mcv_curve_parse(const mcv_param *param, const json_t *pairs, mcv_curve *curve,
                           const mcv_json_path *place, mcv_error *error) {
    const size_t count = json_array_size(pairs);
    const mcv_param length = {.kind = MCV_PARAM_length}, number = {.kind = MCV_PARAM_number};
    if (count < 2 || count > MCV_CURVE_POINTS)
        return mcv_fail_at(place, error, "must be an array of 2 to %d %s", MCV_CURVE_POINTS,
                           param->doc);
    for (size_t i = 0; i < count; ++i) {
        const json_t *pair = json_array_get(pairs, i);
        const mcv_json_path here = mcv_place_index(place, i);
        double *at = curve->at + i, *value = curve->value + i;
        if (json_array_size(pair) != 2)
            return mcv_fail_at(&here, error, "must be a pair [LENGTH, NUMBER]: %s", param->doc);
        MCV_TRY(mcv_param_number(&length, json_array_get(pair, 0), at, &here, error));
        MCV_TRY(mcv_param_number(&number, json_array_get(pair, 1), value, &here, error));
        if (i == 0 ? *at != 0 : !(*at > at[-1]))
            return mcv_fail_at(&here, error,
                               i ? "%g m must be above %g m, that of the pair before"
                                 : "%g m must be 0, on the axis",
                               *at, i ? at[-1] : 0);
        if (!(*value > 0 && *value <= 10))
            return mcv_fail_at(&here, error, "%g must be above 0 and at most 10", *value);
    }
    curve->count = (uint32_t)count;
    return MCV_OK;
}

double mcv_curve_at(const mcv_curve *curve, double at) {
    uint32_t i = 1;
    if (curve->count == 0) return 1;
    while (i + 1 < curve->count && curve->at[i] < at) ++i;
    const double share = (at - curve->at[i - 1]) / (curve->at[i] - curve->at[i - 1]);
    return curve->value[i - 1] + share * (curve->value[i] - curve->value[i - 1]);
}
