/* SPDX-License-Identifier: Apache-2.0 */
#include "scene/params.h"

#include "scene/param_lists.h"
#include "scene/pattern.h"

#include <stdio.h>
#include <stdlib.h>

/* A table ends with an empty row, so that an element may have no parameters. */
#define MCV_TABLE(name, key, NAME) \
    static mcv_param_table name##_table(void) { \
        typedef mcv_##name##_params element_params; \
        static const mcv_param rows[] = {MCV_##NAME##_PARAMS(MCV_PARAM_ROW){0}}; \
        return (mcv_param_table){rows, sizeof rows / sizeof rows[0] - 1, sizeof(element_params)}; \
    }
MCV_SENSORS(MCV_TABLE)
MCV_TABLE(line_scan, "lineScan", LINE_SCAN)
/* A thin lens, and then the rest. */
#define MCV_LENS_ROW(kind, key, default_value, min, max, doc) \
    {MCV_PARAM_##kind, #key, offsetof(element_params, lens.key), default_value, min, max, doc},
static mcv_param_table laser_triangulation_table(void) {
    typedef mcv_laser_triangulation_params element_params;
    static const mcv_param rows[] = {MCV_THIN_LENS_PARAMS(MCV_LENS_ROW)
                                         MCV_HEAD_PARAMS(MCV_PARAM_ROW){0}};
    return (mcv_param_table){rows, sizeof rows / sizeof rows[0] - 1, sizeof(element_params)};
}
MCV_EMITTERS(MCV_TABLE)
MCV_PRESETS(MCV_TABLE)
MCV_MATERIALS(MCV_TABLE)

#define MCV_CALL(name, key, NAME) name##_table,
#define MCV_TYPE(name, key, NAME) key,
typedef mcv_param_table table_of(void);
static table_of *const sensor_tables[] = {MCV_SENSORS(MCV_CALL) line_scan_table,
                                          laser_triangulation_table};
static table_of *const emitter_tables[] = {MCV_EMITTERS(MCV_CALL) MCV_PRESETS(MCV_CALL)};
static table_of *const material_tables[] = {MCV_MATERIALS(MCV_CALL)};
const char *const mcv_sensor_types[] = {MCV_SENSORS(MCV_TYPE) "lineScan", "laserTriangulation"};
const char *const mcv_emitter_types[] = {MCV_EMITTERS(MCV_TYPE) MCV_PRESETS(MCV_TYPE)};
const char *const mcv_material_types[] = {MCV_MATERIALS(MCV_TYPE)};

mcv_param_table mcv_sensor_table(uint32_t type) { return sensor_tables[type](); }
mcv_param_table mcv_emitter_table(uint32_t type) { return emitter_tables[type](); }
mcv_param_table mcv_material_table(uint32_t type) { return material_tables[type](); }

const char *const *mcv_param_options(const char *key) {
#define MCV_OPTIONS(choice, ...) {#choice, {__VA_ARGS__, NULL}},
    static const struct {
        const char *key;
        const char *options[32];
    } choices[] = {MCV_CHOICES(MCV_OPTIONS)};
    for (size_t i = 0; i < sizeof choices / sizeof choices[0]; ++i)
        if (strcmp(choices[i].key, key) == 0) return choices[i].options;
    return NULL;
}

bool mcv_is_metal(const char *name, char list[256]) {
    static const char *const others[] = {"metal",  "steel", "stainlessSteel", "brass",
                                         "bronze", "zinc",  "aluminum",       NULL};
    const char *const *metals = mcv_param_options("metal"), *const *const words[] = {metals,
                                                                                     others};
    bool found = false;
    for (int k = 0; k < 2; ++k)
        for (int i = 0; words[k][i]; ++i) found = found || strcasecmp(name, words[k][i]) == 0;
    strcpy(list, "metals are ");
    for (int i = 0; metals[i]; ++i)
        snprintf(list + strlen(list), 256 - strlen(list), "%s%s", i ? ", " : "", metals[i]);
    return found;
}

size_t mcv_param_components(mcv_param_kind kind) {
    switch (kind) {
    case MCV_PARAM_int4:
        return 4;
    case MCV_PARAM_spectrum:
        return 3;
    case MCV_PARAM_int2:
    case MCV_PARAM_length2:
    case MCV_PARAM_number2:
        return 2;
    case MCV_PARAM_text:
        return 0;
    default:
        return 1;
    }
}

bool mcv_param_integral(mcv_param_kind kind) {
    return kind == MCV_PARAM_integer || kind == MCV_PARAM_int2 || kind == MCV_PARAM_int4 ||
           kind == MCV_PARAM_mask || kind == MCV_PARAM_curve;
}

/* Is its unset value MCV_NONE? */
static bool numbered(mcv_param_kind kind) {
    return kind == MCV_PARAM_image || kind == MCV_PARAM_pattern;
}

static double get(const mcv_param *param, const void *params, size_t i) {
    const char *field = (const char *)params + param->offset;
    if (mcv_param_integral(param->kind)) return ((const uint32_t *)(const void *)field)[i];
    if (numbered(param->kind)) return *(const uint32_t *)(const void *)field;
    if (param->kind == MCV_PARAM_choice || param->kind == MCV_PARAM_flag)
        return *(const int *)(const void *)field;
    return ((const double *)(const void *)field)[i];
}

static void set(const mcv_param *param, void *params, size_t i, double value) {
    char *field = (char *)params + param->offset;
    if (mcv_param_integral(param->kind))
        ((uint32_t *)(void *)field)[i] = (uint32_t)value;
    else if (numbered(param->kind))
        *(uint32_t *)(void *)field = (uint32_t)value;
    else if (param->kind == MCV_PARAM_choice || param->kind == MCV_PARAM_flag)
        *(int *)(void *)field = (int)value;
    else
        ((double *)(void *)field)[i] = value;
}

void *mcv_params_find(mcv_param_table table, const char *key, const void *params) {
    for (size_t i = 0; i < table.count; ++i)
        if (strcmp(table.params[i].key, key) == 0) return (char *)params + table.params[i].offset;
    return NULL;
}

void mcv_params_set_defaults(mcv_param_table table, void *params) {
    memset(params, 0, table.struct_size);
    for (size_t i = 0; i < table.count; ++i) {
        const mcv_param *param = table.params + i;
        const bool given =
            param->default_value != MCV_REQUIRED && param->default_value != MCV_UNSET;
        const bool number = param->kind == MCV_PARAM_int4 || numbered(param->kind);
        const bool counts = mcv_param_integral(param->kind);
        const double unset = number ? MCV_NONE : counts ? 0 : (double)NAN;
        const double value = given ? param->default_value : unset;
        for (size_t j = 0; j < mcv_param_components(param->kind); ++j) set(param, params, j, value);
    }
}

bool mcv_param_unset(const mcv_param *param, const void *params) {
    if (param->kind == MCV_PARAM_text) return !*((const char *)params + param->offset);
    const double first = get(param, params, 0);
    if (param->kind == MCV_PARAM_int4 || numbered(param->kind)) return first == MCV_NONE;
    if (mcv_param_integral(param->kind)) return first == 0;
    return param->kind != MCV_PARAM_choice && param->kind != MCV_PARAM_flag && isnan(first);
}

bool mcv_parse_quantity(const char *text, mcv_param_kind kind, double *value) {
    static const struct {
        const char *name;
        mcv_param_kind kind;
        double si, times;
    } units[] = {
        {"nm", MCV_PARAM_length, 1e9, 1},        {"um", MCV_PARAM_length, 1e6, 1},
        {"µm", MCV_PARAM_length, 1e6, 1},        {"mm", MCV_PARAM_length, 1e3, 1},
        {"cm", MCV_PARAM_length, 1e2, 1},        {"m", MCV_PARAM_length, 1, 1},
        {"rad", MCV_PARAM_angle, 1, 1},          {"mrad", MCV_PARAM_angle, 1e3, 1},
        {"deg", MCV_PARAM_angle, 180 / M_PI, 1}, {"inch", MCV_PARAM_length, 1e4, 254},
    };
    /* Digits only: strtod also accepts "inf", "nan" and hexadecimal numbers. */
    if (text[strspn(text, " +-.")] < '0' || text[strspn(text, " +-.")] > '9' || strchr(text, 'x') ||
        strchr(text, 'X'))
        return false;
    char *end;
    const double number = strtod(text, &end);
    if (end == text || !isfinite(number)) return false;
    end += strspn(end, " ");
    *value = number;
    if (!*end) return true;
    for (size_t i = 0; i < sizeof units / sizeof units[0]; ++i)
        if (strcmp(end, units[i].name) == 0 &&
            (kind == units[i].kind || kind == MCV_PARAM_choice)) {
            /* Divided, because 1e6 is exact in binary and 1e-6 is not. */
            *value = number * units[i].times / units[i].si;
            return true;
        }
    return false;
}

/* An example of a number of this kind. */
static const char *example(mcv_param_kind kind) {
    switch (kind) {
    case MCV_PARAM_length:
    case MCV_PARAM_length2:
        return "a length in metres, or with a unit as in \"25mm\" (nm, um, mm, cm, m, inch)";
    case MCV_PARAM_angle:
        return "an angle in radians, or with a unit as in \"0.5deg\" (deg, mrad, rad)";
    case MCV_PARAM_integer:
    case MCV_PARAM_int2:
    case MCV_PARAM_int4:
        return "an integer";
    default:
        return "a number";
    }
}

mcv_result mcv_param_number(const mcv_param *param, const json_t *value, double *number,
                            const mcv_json_path *place, mcv_error *error) {
    const mcv_param_kind kind = param->kind == MCV_PARAM_length2 ? MCV_PARAM_length : param->kind;
    if (json_is_string(value) && !mcv_param_integral(param->kind) &&
        param->kind != MCV_PARAM_spectrum) {
        if (mcv_parse_quantity(json_string_value(value), kind, number)) return MCV_OK;
        return mcv_fail_at(place, error, "\"%s\" must be %s", json_string_value(value),
                           example(kind));
    }
    if (!json_is_number(value)) return mcv_fail_at(place, error, "must be %s", example(kind));
    *number = json_number_value(value);
    if (!mcv_param_integral(param->kind)) return MCV_OK;
    /* Checked here because the value must fit the field. */
    if (!(*number >= param->min && *number <= param->max) || *number != floor(*number))
        return mcv_fail_at(place, error, "%g must be an integer from %g to %g", *number, param->min,
                           param->max);
    return MCV_OK;
}

/* Other names of options, or those of similar materials. */
static const char *const other_names[][2] = {{"acrylic", "PMMA"},       {"plexiglass", "PMMA"},
                                             {"quartz", "fusedSilica"}, {"silica", "fusedSilica"},
                                             {"steel", "iron"},         {"stainlessSteel", "iron"},
                                             {"chrome", "chromium"}};

/* The option that is probably meant, or NULL. Current glasses have the old names after "N-". */
static const char *nearest_option(const char *text, const char *const *options, size_t count) {
    for (size_t i = 0; i < count; ++i)
        if (strncmp(options[i], "N-", 2) == 0 && strcasecmp(options[i] + 2, text) == 0)
            return options[i];
    for (size_t i = 0; i < sizeof other_names / sizeof other_names[0]; ++i)
        for (size_t k = 0; k < count && strcasecmp(other_names[i][0], text) == 0; ++k)
            if (strcmp(options[k], other_names[i][1]) == 0) return options[k];
    return mcv_nearest_word(text, options, count);
}

static mcv_result parse_choice(const mcv_param *param, const json_t *value, void *params,
                               const mcv_json_path *place, mcv_error *error) {
    const char *const *options = mcv_param_options(param->key);
    const char *text = json_string_value(value);
    char list[512] = "";
    const int first = (int)param->min, last = (int)param->max;
    for (int i = first; i <= last; ++i) {
        if (text && strcmp(text, options[i]) == 0) {
            set(param, params, 0, i);
            return MCV_OK;
        }
        snprintf(list + strlen(list), sizeof list - strlen(list), "%s\"%s\"",
                 i > first ? " or " : "", options[i]);
    }
    const char *nearest =
        text ? nearest_option(text, options + first, (size_t)last - (size_t)first + 1) : NULL;
    if (nearest)
        return mcv_fail_at(place, error, "\"%s\" must be %s: did you mean \"%s\"?", text, list,
                           nearest);
    return text ? mcv_fail_at(place, error, "\"%s\" must be %s", text, list)
                : mcv_fail_at(place, error, "must be %s", list);
}

/* Marks the image as given; the loader finds it later (load_images.c). */
static mcv_result parse_image(const mcv_param *param, const json_t *value, void *params,
                              const mcv_json_path *place, mcv_error *error) {
    if (!json_is_integer(value) && !json_is_string(value) && !json_is_object(value))
        return mcv_fail_at(
            place, error,
            "must be the index or the name of one of the file's images, or {\"uri\": FILE.exr}");
    set(param, params, 0, 0);
    return MCV_OK;
}

static mcv_result parse_text(const json_t *value, char *text, const mcv_json_path *place,
                             mcv_error *error) {
    const char *given = json_string_value(value);
    if (!given || !*given || strlen(given) >= MCV_TEXT_BYTES)
        return mcv_fail_at(place, error, "must be a text of 1 to %d bytes", MCV_TEXT_BYTES - 1);
    strcpy(text, given);
    return MCV_OK;
}

static mcv_result parse_flag(const mcv_param *param, const json_t *value, void *params,
                             const mcv_json_path *place, mcv_error *error) {
    if (!json_is_boolean(value)) return mcv_fail_at(place, error, "must be true or false");
    set(param, params, 0, json_is_true(value));
    return MCV_OK;
}

static mcv_result parse_value(const mcv_param *param, const json_t *value, void *params,
                              const mcv_json_path *place, mcv_error *error) {
    if (param->kind == MCV_PARAM_choice) return parse_choice(param, value, params, place, error);
    if (param->kind == MCV_PARAM_image) return parse_image(param, value, params, place, error);
    if (param->kind == MCV_PARAM_flag) return parse_flag(param, value, params, place, error);
    if (param->kind == MCV_PARAM_mask)
        return mcv_mask_parse(value, (mcv_mask *)(void *)((char *)params + param->offset), place,
                              error);
    if (param->kind == MCV_PARAM_curve)
        return mcv_curve_parse(param, value, (mcv_curve *)(void *)((char *)params + param->offset),
                               place, error);
    if (param->kind == MCV_PARAM_text)
        return parse_text(value, (char *)params + param->offset, place, error);
    if (param->kind == MCV_PARAM_pattern)
        return mcv_pattern_parse(value, (mcv_pattern *)(void *)((char *)params + param->offset),
                                 place, error);
    const size_t n = mcv_param_components(param->kind);
    if (json_is_array(value) && (n == 1 || json_array_size(value) != n)) {
        if (n == 1)
            return mcv_fail_at(place, error, "must be %s, not an array", example(param->kind));
        return mcv_fail_at(place, error, "has %zu values, but must have %zu%s",
                           json_array_size(value), n, n == 4 ? "" : " (or be one for all)");
    }
    if (!json_is_array(value) && n == 4)
        return mcv_fail_at(place, error, "must be an array of 4 integers");
    for (size_t i = 0; i < n; ++i) {
        const mcv_json_path element = mcv_place_index(place, i);
        double number = 0;
        MCV_TRY(json_is_array(value)
                    ? mcv_param_number(param, json_array_get(value, i), &number, &element, error)
                    : mcv_param_number(param, value, &number, place, error));
        set(param, params, i, number);
    }
    return MCV_OK;
}

static mcv_result fail_unknown(mcv_param_table table, const char *const *others,
                               const mcv_json_path *place, const char *key, mcv_error *error) {
    const char *words[96];
    char list[1024] = "";
    size_t n = 0;
    for (size_t i = 0; i < table.count && n < 88; ++i) words[n++] = table.params[i].key;
    for (size_t i = 0; others[i] && n < 96; ++i) words[n++] = others[i];
    const char *nearest = mcv_nearest_word(key, words, n);
    if (nearest)
        return mcv_fail_at(place, error, "unknown key \"%s\": did you mean \"%s\"?", key, nearest);
    for (size_t i = 0; i < n; ++i)
        snprintf(list + strlen(list), sizeof list - strlen(list), "%s%s", i ? ", " : "", words[i]);
    return mcv_fail_at(place, error, "unknown key \"%s\": known are %s", key, list);
}

mcv_result mcv_params_parse(mcv_param_table table, const json_t *object, const char *const *others,
                            void *params, const mcv_json_path *place, mcv_error *error) {
    const char *key;
    json_t *value;
    json_object_foreach((json_t *)object, key, value) {
        size_t i = 0, other = 0;
        while (i < table.count && strcmp(table.params[i].key, key) != 0) ++i;
        while (others[other] && strcmp(others[other], key) != 0) ++other;
        const mcv_json_path here = mcv_json_path_key(place, key);
        if (i < table.count)
            MCV_TRY(parse_value(table.params + i, value, params, &here, error));
        else if (!others[other])
            return fail_unknown(table, others, place, key, error);
    }
    return MCV_OK;
}

mcv_result mcv_params_check(mcv_param_table table, const void *params, const mcv_json_path *place,
                            mcv_error *error) {
    for (size_t i = 0; i < table.count; ++i) {
        const mcv_param *param = table.params + i;
        const mcv_json_path here = mcv_json_path_key(place, param->key);
        if (mcv_param_unset(param, params)) {
            if (param->default_value == MCV_REQUIRED)
                return mcv_fail_at(&here, error, "is missing: %s", param->doc);
            if (param->default_value == MCV_UNSET || !isnan(get(param, params, 0))) continue;
        }
        for (size_t j = 0; j < mcv_param_components(param->kind); ++j) {
            const double value = get(param, params, j);
            if (value >= param->min && value <= param->max) continue;
            if (param->min == MCV_POSITIVE)
                return mcv_fail_at(&here, error, "%g must be above 0 and at most %g: %s", value,
                                   param->max, param->doc);
            return mcv_fail_at(&here, error, "%g must lie from %g to %g: %s", value, param->min,
                               param->max, param->doc);
        }
    }
    return MCV_OK;
}

mcv_result mcv_element_type(const json_t *object, const char *const *types, uint32_t count,
                            uint32_t *type, const mcv_json_path *place, mcv_error *error) {
    char list[512] = "";
    const char *name = NULL;
    const mcv_json_path here = mcv_json_path_key(place, "type");
    MCV_TRY(mcv_json_string(object, "type", &name, place, error));
    for (*type = 0; *type < count; ++*type) {
        if (name && strcmp(name, types[*type]) == 0) return MCV_OK;
        snprintf(list + strlen(list), sizeof list - strlen(list), "%s%s", *type ? ", " : "",
                 types[*type]);
    }
    if (!name) return mcv_fail_at(&here, error, "is missing: one of %s", list);
    const char *nearest = mcv_nearest_word(name, types, count);
    if (nearest)
        return mcv_fail_at(&here, error, "unknown type \"%s\": did you mean \"%s\"?", name,
                           nearest);
    return mcv_fail_at(&here, error, "unknown type \"%s\": known are %s", name, list);
}
