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

mcv_defect_kind mcv_defect_kind_of(uint32_t type) {
    switch (type) {
    case MCV_DEFECT_DIG:
        return MCV_KIND_PIT;
    case MCV_DEFECT_CHIP:
    case MCV_DEFECT_MISSING_PART:
        return MCV_KIND_CUT;
    case MCV_DEFECT_STAIN:
    case MCV_DEFECT_ROUGH_PATCH:
        return MCV_KIND_PATCH;
    case MCV_DEFECT_BUBBLE:
    case MCV_DEFECT_INCLUSION:
    case MCV_DEFECT_STRIA:
    case MCV_DEFECT_CRACK:
        return MCV_KIND_INSIDE;
    default:
        return MCV_KIND_RELIEF;
    }
}

bool mcv_defect_takes_material(uint32_t type) {
    return type == MCV_DEFECT_INCLUSION || type == MCV_DEFECT_STAIN;
}

/* A ball that reaches deeper than its middle would undercut the part; so would a pit whose rim is
 * steeper than upright. */
static mcv_result check_depth(const mcv_defect *defect, const mcv_json_path *place,
                              mcv_error *error) {
    const mcv_json_path here = mcv_json_path_key(place, "depth");
    if (defect->type == MCV_DEFECT_DIG && !(defect->depth < defect->size / 2))
        return mcv_fail_at(&here, error, "%g m must be below half of the size, %g m", defect->depth,
                           defect->size);
    if (defect->type == MCV_DEFECT_CHIP && !(defect->depth <= defect->size / 2))
        return mcv_fail_at(&here, error, "%g m must be at most half of the size, %g m",
                           defect->depth, defect->size);
    return MCV_OK;
}

mcv_result mcv_defect_resolve(mcv_defect *defect, const mcv_defect_params *params,
                              const mcv_json_path *place, mcv_error *error) {
    const bool crack = defect->type == MCV_DEFECT_CRACK, chip = defect->type == MCV_DEFECT_CHIP;
    const double usual_depth = crack ? 0.01 : chip ? 0.5 : 0.1, usual_length = 20; /* in sizes */
    const mcv_json_path at_length = mcv_json_path_key(place, "length");
    defect->size = number(defect, params, "size");
    defect->depth = number(defect, params, crack ? "opening" : "depth");
    defect->length = number(defect, params, "length");
    defect->pile_up = number(defect, params, "pileUp");
    defect->form = choice(defect, params, "shape") + choice(defect, params, "profile");
    const uint32_t *tubes = mcv_params_find(mcv_defect_table(defect->type), "tubes", params);
    defect->tubes = tubes ? *tubes : 0;
    defect->index = number(defect, params, "ior") + number(defect, params, "indexStep");
    defect->roughness = number(defect, params, "roughness");
    defect->host = defect->material = MCV_NONE;
    if (isnan(defect->depth)) defect->depth = usual_depth * defect->size;
    if (isnan(defect->length)) defect->length = usual_length * defect->size;
    if (defect->length > 0 && defect->length < defect->size)
        return mcv_fail_at(&at_length, error, "%g m must be at least the size, %g m",
                           defect->length, defect->size);
    return check_depth(defect, place, error);
}
