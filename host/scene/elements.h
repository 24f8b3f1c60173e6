/* SPDX-License-Identifier: Apache-2.0 */
/* The parameters of all elements as structs and tables, generated from the lists of
 * mcvisi/elements.h and of each element's header. */
#ifndef MCVISI_HOST_SCENE_ELEMENTS_H
#define MCVISI_HOST_SCENE_ELEMENTS_H

#include "mcvisi/elements.h"
#include "core/error.h"
#include "mcvisi/params.h"
#include "mcvisi/pattern.h"
#include "mcvisi/presets/bar.h"
#include "mcvisi/presets/coaxial.h"
#include "mcvisi/presets/dome.h"
#include "mcvisi/presets/ring.h"
#include "mcvisi/surfaces/surfaces.h"

/* The parameter structs mcv_<name>_params. `end` keeps that of the absorber, which has no
 * parameters, from being empty: C does not allow empty structs. */
#define MCV_X(name, key, NAME) \
    typedef struct mcv_##name##_params { \
        MCV_##NAME##_PARAMS(MCV_DEFINE_FIELD) char end; \
    } mcv_##name##_params;
MCV_SENSORS(MCV_X)
MCV_EMITTERS(MCV_X)
MCV_PRESETS(MCV_X)
MCV_MATERIALS(MCV_X)
MCV_X(medium, , MEDIUM) /* what those of MCV_MEDIUM_MATERIALS begin with */
#undef MCV_X
typedef mcv_thin_lens_params mcv_line_scan_params;
/* It begins as those of a thin lens. */
typedef struct mcv_laser_triangulation_params {
    mcv_thin_lens_params lens;
    MCV_HEAD_PARAMS(MCV_DEFINE_FIELD)
} mcv_laser_triangulation_params;

/* Sets all parameters of `params` to their defaults (NaN if unset), for elements made by hand;
 * table from mcv_<kind>_table(type). */
typedef struct mcv_param_table {
    const mcv_param *params;
    size_t count;
    size_t struct_size;
} mcv_param_table;
mcv_param_table mcv_sensor_table(uint32_t type);  /* those that are rendered as others, too */
mcv_param_table mcv_emitter_table(uint32_t type); /* presets too */
mcv_param_table mcv_material_table(uint32_t type);
void mcv_params_set_defaults(mcv_param_table table, void *params);
/* The field of a parameter in params, or NULL if the table has no such key. */
void *mcv_params_find(mcv_param_table table, const char *key, const void *params);

#endif
