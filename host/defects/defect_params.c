/* SPDX-License-Identifier: Apache-2.0 */
/* Parameters of defects. */
#include "defects/defects.h"

#include "scene/params.h"

#include <math.h>

#define MCV_X(name, key, NAME) \
    typedef struct mcv_##name##_params { \
        MCV_DEFECT_##NAME##_PARAMS(MCV_DEFINE_FIELD) \
    } mcv_##name##_params; \
    _Static_assert(sizeof(mcv_##name##_params) <= sizeof(mcv_defect_params), "room for a " key);
MCV_DEFECTS(MCV_X)
#undef MCV_X

const char *const mcv_defect_types[MCV_DEFECT_COUNT] = {
#define MCV_X(name, key, NAME) key,
    MCV_DEFECTS(MCV_X)
#undef MCV_X
};

#define MCV_X(name, key, NAME) \
    static mcv_param_table name##_table(void) { \
        typedef mcv_##name##_params element_params; \
        static const mcv_param rows[] = {MCV_DEFECT_##NAME##_PARAMS(MCV_PARAM_ROW)}; \
        return (mcv_param_table){rows, sizeof rows / sizeof rows[0], sizeof(element_params)}; \
    }
MCV_DEFECTS(MCV_X)
#undef MCV_X

mcv_param_table mcv_defect_table(uint32_t type) {
    switch (type) {
#define MCV_X(name, key, NAME) \
    case MCV_DEFECT_##NAME: \
        return name##_table();
        MCV_DEFECTS(MCV_X)
#undef MCV_X
    default:
        return (mcv_param_table){0};
    }
}

/* A parameter of this type of defect, or 0. */
static double number(const mcv_defect *d, const mcv_defect_params *params, const char *key) {
    const double *found = mcv_params_find(mcv_defect_table(d->type), key, params);
    return found ? *found : 0;
}

static int choice(const mcv_defect *d, const mcv_defect_params *params, const char *key) {
    const int *found = mcv_params_find(mcv_defect_table(d->type), key, params);
    return found ? *found : 0;
}

bool mcv_defect_is_inside(uint32_t type) {
    return type == MCV_DEFECT_BUBBLE || type == MCV_DEFECT_INCLUSION || type == MCV_DEFECT_STRIA;
}

mcv_result mcv_defect_resolve(mcv_defect *defect, const mcv_defect_params *params,
                              const mcv_json_path *place, mcv_error *error) {
    const double usual_depth = 0.1, usual_length = 20; /* in sizes */
    const mcv_json_path at_length = mcv_json_path_key(place, "length");
    defect->size = number(defect, params, "size");
    defect->depth = number(defect, params, "depth");
    defect->length = number(defect, params, "length");
    defect->pile_up = number(defect, params, "pileUp");
    defect->form = choice(defect, params, "shape") + choice(defect, params, "profile");
    const uint32_t *tubes = mcv_params_find(mcv_defect_table(defect->type), "tubes", params);
    defect->tubes = tubes ? *tubes : 0;
    defect->index = number(defect, params, "ior") + number(defect, params, "indexStep");
    defect->host = defect->material = MCV_NONE;
    if (isnan(defect->depth)) defect->depth = usual_depth * defect->size;
    if (isnan(defect->length)) defect->length = usual_length * defect->size;
    if (defect->length > 0 && defect->length < defect->size)
        return mcv_fail_at(&at_length, error, "%g m must be at least the size, %g m",
                           defect->length, defect->size);
    return MCV_OK;
}
