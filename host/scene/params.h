/* SPDX-License-Identifier: Apache-2.0 */
/* Parameters of elements (mcvisi/params.h) from JSON values, by the tables that their lists
 * generate. */
#ifndef MCVISI_HOST_SCENE_PARAMS_H
#define MCVISI_HOST_SCENE_PARAMS_H

#include "core/json.h"
#include "scene/scene.h"

/* A row of a table: expanded where `element_params` is the parameter struct. */
#define MCV_PARAM_ROW(kind, key, default_value, min, max, doc) \
    {MCV_PARAM_##kind, #key, offsetof(element_params, key), default_value, min, max, doc},

/* MCVISI_pose (mcvisi/pose.h), and the entries of MCVISI_assets (mcvisi/asset.h). */
mcv_param_table mcv_pose_table(void);
mcv_param_table mcv_misalignment_table(void); /* mcvisi/misalignment.h */
mcv_param_table mcv_asset_table(void);

/*
 * Reads a number with a unit, "3.45um" or "0.5 deg", into SI. `kind` determines the allowed units:
 * nm um mm cm m inch for lengths, deg mrad rad for angles, none for numbers; MCV_PARAM_choice
 * allows all of them. False if the text is not such a quantity.
 */
bool mcv_parse_quantity(const char *text, mcv_param_kind kind, double *value);

/*
 * Reads the members of `object` into `params`, which the caller has set to defaults. An unknown
 * member is an error that suggests the nearest key; `others` (name, type …, ended by NULL) are
 * allowed too.
 */
mcv_result mcv_params_parse(mcv_param_table table, const json_t *object, const char *const *others,
                            void *params, const mcv_json_path *place, mcv_error *error);

/* Are all required parameters given and all given ones in range? */
mcv_result mcv_params_check(mcv_param_table table, const void *params, const mcv_json_path *place,
                            mcv_error *error);

/* Does a kind hold integers? */
bool mcv_param_integral(mcv_param_kind kind);

/* How many numbers a kind holds. */
size_t mcv_param_components(mcv_param_kind kind);

/* Is this parameter still MCV_UNSET? Never for choices. */
bool mcv_param_unset(const mcv_param *param, const void *params);

/* The options of a choice, ended by NULL. */
const char *const *mcv_param_options(const char *key);

/* Is it the name of a metal, one of the options or another, as steel and brass? Then its list says
 * which there are: "metals are aluminium, …". */
bool mcv_is_metal(const char *name, char list[256]);

/* The number that "type" names in a list of elements; an error lists the types. */
mcv_result mcv_element_type(const json_t *object, const char *const *types, uint32_t count,
                            uint32_t *type, const mcv_json_path *place, mcv_error *error);
extern const char
    *const mcv_sensor_types[MCV_SENSOR_TYPE_COUNT]; /* those that are rendered as others, too */
extern const char *const mcv_emitter_types[MCV_EMITTER_TYPE_COUNT]; /* presets too */
extern const char *const mcv_material_types[MCV_MATERIAL_COUNT];

#endif
