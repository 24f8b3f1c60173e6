/* SPDX-License-Identifier: Apache-2.0 */
#include "scene/schema.h"

#include "scene/defect_params.h"
#include "scene/params.h"
#include "scene/pattern.h"
#include "scene/surfaces.h"
#include "scene/spectra.h"

const char *const mcv_schema_names[] = {"MCVISI_sensors",
                                        "MCVISI_emitters",
                                        "MCVISI_materials",
                                        "MCVISI_assets",
                                        "MCVISI_pose",
                                        "MCVISI_misalignment",
                                        "MCVISI_spectrum",
                                        "MCVISI_surfaces",
                                        "MCVISI_defects",
                                        "MCVISI_motion",
                                        NULL};

/* The schema of one number of a parameter. */
static json_t *scalar_schema(const mcv_param *param) {
    json_t *schema = json_object();
    const char *units = NULL;
    if (param->kind == MCV_PARAM_length || param->kind == MCV_PARAM_length2)
        units = "nm|um|µm|mm|cm|m|inch";
    if (param->kind == MCV_PARAM_angle) units = "deg|mrad|rad";
    if (units) {
        json_object_set_new(schema, "type", json_pack("[s, s]", "number", "string"));
        json_object_set_new(schema, "pattern", json_sprintf("^[-+.0-9eE]+ *(%s)?$", units));
    } else {
        json_object_set_new(schema, "type",
                            json_string(mcv_param_integral(param->kind) ? "integer" : "number"));
    }
    json_object_set_new(schema, "minimum", json_real(param->min == MCV_POSITIVE ? 0 : param->min));
    if (param->min == MCV_POSITIVE) json_object_set_new(schema, "exclusiveMinimum", json_true());
    json_object_set_new(schema, "maximum", json_real(param->max));
    return schema;
}

static json_t *pattern_schema(void);

/* A mask, or a curve. */
static json_t *rows_schema(bool mask) {
    return mask ? json_pack("{s:s, s:i, s:i, s:{s:s, s:{s:s, s:i, s:i}}}", "type", "array",
                            "minItems", 1, "maxItems", MCV_MASK_SIDE, "items", "type", "array",
                            "items", "type", "number", "minimum", 0, "maximum", 1)
                : json_pack("{s:s, s:i, s:i, s:{s:s, s:i, s:i}}", "type", "array", "minItems", 2,
                            "maxItems", MCV_CURVE_POINTS, "items", "type", "array", "minItems", 2,
                            "maxItems", 2);
}

static json_t *param_schema(const mcv_param *param) {
    json_t *schema = json_object();
    json_object_set_new(schema, "description", json_string(param->doc));
    if (param->kind == MCV_PARAM_choice) {
        const char *const *options = mcv_param_options(param->key);
        json_t *list = json_array();
        for (int i = (int)param->min; i <= (int)param->max; ++i)
            json_array_append_new(list, json_string(options[i]));
        /* Of a lens there may be a list of apertures, one for each exposure. */
        if (strcmp(param->key, "aperture") == 0 && param->max == MCV_APERTURE_MASK)
            json_object_set_new(
                schema, "anyOf",
                json_pack("[{s:o}, {s:s, s:i}]", "enum", list, "type", "array", "minItems", 1));
        else
            json_object_set_new(schema, "enum", list);
        json_object_set_new(schema, "default", json_string(options[(int)param->default_value]));
        return schema;
    }
    if (param->kind == MCV_PARAM_flag) {
        json_object_set_new(schema, "type", json_string("boolean"));
        json_object_set_new(schema, "default", json_boolean(param->default_value != 0));
        return schema;
    }
    if (param->kind == MCV_PARAM_image) {
        json_object_set_new(schema, "anyOf",
                            json_pack("[{s:s, s:i}, {s:s}, {s:s, s:{s:{s:s}}, s:[s]}]", "type",
                                      "integer", "minimum", 0, "type", "string", "type", "object",
                                      "properties", "uri", "type", "string", "required", "uri"));
        return schema;
    }
    if (param->kind == MCV_PARAM_mask || param->kind == MCV_PARAM_curve) {
        json_object_update_new(schema, rows_schema(param->kind == MCV_PARAM_mask));
        return schema;
    }
    if (param->kind == MCV_PARAM_text) {
        json_object_set_new(schema, "type", json_string("string"));
        return schema;
    }
    if (param->kind == MCV_PARAM_pattern) {
        json_object_set_new(schema, "oneOf", pattern_schema());
        return schema;
    }
    const int n = (int)mcv_param_components(param->kind);
    if (n == 1)
        json_object_update_new(schema, scalar_schema(param));
    else if (n == 4)
        json_object_update_new(schema,
                               json_pack("{s:s, s:o, s:i, s:i}", "type", "array", "items",
                                         scalar_schema(param), "minItems", n, "maxItems", n));
    else
        json_object_set_new(schema, "anyOf",
                            json_pack("[o, {s:s, s:o, s:i, s:i}]", scalar_schema(param), "type",
                                      "array", "items", scalar_schema(param), "minItems", n,
                                      "maxItems", n));
    if (param->default_value != MCV_REQUIRED && param->default_value != MCV_UNSET)
        json_object_set_new(schema, "default", json_real(param->default_value));
    return schema;
}

/* An object with these properties and required keys, and those of the table. */
static json_t *object_schema(json_t *properties, json_t *required, mcv_param_table table) {
    for (size_t i = 0; i < table.count; ++i) {
        json_object_set_new(properties, table.params[i].key, param_schema(table.params + i));
        if (table.params[i].default_value == MCV_REQUIRED)
            json_array_append_new(required, json_string(table.params[i].key));
    }
    json_t *schema = json_pack("{s:s, s:o}", "type", "object", "properties", properties);
    if (json_array_size(required) > 0) json_object_set(schema, "required", required);
    json_decref(required);
    return schema;
}

static json_t *element_schema(const char *type, mcv_param_table table) {
    return object_schema(
        json_pack("{s:{s:[s]}, s:{s:s}}", "type", "enum", type, "name", "type", "string"),
        json_pack("[s]", "type"), table);
}

static json_t *pattern_schema(void) {
    json_t *choice = json_array();
    for (uint32_t type = 0; type < MCV_PATTERN_COUNT; ++type)
        json_array_append_new(
            choice, object_schema(json_pack("{s:{s:[s]}}", "type", "enum", mcv_pattern_types[type]),
                                  json_pack("[s]", "type"), mcv_pattern_table(type)));
    return choice;
}

static json_t *material_schema(const char *description) {
    return json_pack("{s:s, s:[s,s]}", "description", description, "type", "string", "integer");
}

static json_t *map_schema(const char *description) {
    return json_pack("{s:s, s:s, s:{s:[s,s]}}", "description", description, "type", "object",
                     "additionalProperties", "type", "string", "integer");
}

static json_t *asset_schema(void) {
    json_t *properties =
        json_pack("{s:{s:s, s:s}, s:{s:s, s:[s,s,s,s,s,s], s:s}, s:{s:s}}", "uri", "description",
                  "a .gltf, .glb or .stl file beside the scene", "type", "string", "unit",
                  "description", "unit of the file's lengths; required for .stl files", "enum",
                  "nm", "um", "mm", "cm", "m", "inch", "default", "m", "name", "type", "string");
    json_object_set_new(
        properties, "material",
        material_schema("a material of the scene, by name or index, for all of the file"));
    json_object_set_new(
        properties, "materials",
        map_schema("of a glTF file: {\"NAME\": material of the scene}, by the file's materials"));
    json_object_set_new(properties, "nodeMaterials",
                        map_schema("of a glTF file: {\"NAME\": material of the scene}, for the "
                                   "file's nodes of this name and all below"));
    return object_schema(properties, json_pack("[s]", "uri"), mcv_asset_table());
}

static json_t *pose_schema(void) {
    json_t *properties = json_pack("{s:{s:s, s:[s,s,s]}}", "target", "description",
                                   "a node (name or index) or a point [x, y, z] [m]", "type",
                                   "string", "integer", "array");
    return object_schema(properties, json_pack("[s]", "target"), mcv_pose_table());
}

/* A wavelength, or three. */
static json_t *spectrum_schema(void) {
    const mcv_param length = {MCV_PARAM_length,     "wavelengths",          0, MCV_UNSET,
                              MCV_LEAST_WAVELENGTH, MCV_LARGEST_WAVELENGTH, ""};
    json_t *three = json_pack("{s:s, s:o, s:i, s:i}", "type", "array", "items",
                              scalar_schema(&length), "minItems", 3, "maxItems", 3);
    json_t *wavelengths =
        json_pack("{s:s, s:[o, o]}", "description",
                  "wavelengths of red, green and blue, or one for a grey scene [m]", "anyOf",
                  scalar_schema(&length), three);
    return object_schema(json_pack("{s:o}", "wavelengths", wavelengths),
                         json_pack("[s]", "wavelengths"), (mcv_param_table){0});
}

static json_t *asphere_schema(void) {
    return json_pack("{s:s, s:s, s:{s:s}, s:i}", "description",
                     "coefficients A_i of r^4, r^6 and so on, up to r^18 [m^(1-i)]", "type",
                     "array", "items", "type", "number", "maxItems", MCV_ASPHERE_TERMS);
}

/* Members of bodies with exact surfaces that are not in their tables. */
static void add_body_members(json_t *definitions) {
    const char *const *types = mcv_body_types;
    for (uint32_t type = 0; type < MCV_BODY_COUNT; ++type) {
        json_t *properties =
            json_object_get(json_object_get(definitions, types[type]), "properties");
        if (type != MCV_BODY_LENS) {
            json_object_set_new(properties, "material",
                                material_schema("a material of the file, by name or index"));
            continue;
        }
        json_t *surface = object_schema(
            json_pack(
                "{s:o, s:o, s:{s:s}}", "asphere", asphere_schema(), "material",
                material_schema("material of the space up to the next surface; without it a gap"),
                "name", "type", "string"),
            json_array(), mcv_lens_surface_table());
        json_object_set_new(properties, "surfaces",
                            json_pack("{s:s, s:s, s:i, s:o}", "description",
                                      "two or more optical surfaces in a row", "type", "array",
                                      "minItems", 2, "items", surface));
        json_object_set_new(properties, "rim",
                            material_schema("a material for the edges; without it they absorb"));
        json_array_append_new(
            json_object_get(json_object_get(definitions, types[type]), "required"),
            json_string("surfaces"));
    }
    json_object_set_new(
        json_object_get(json_object_get(definitions, types[MCV_BODY_OPEN_SURFACE]), "properties"),
        "asphere", asphere_schema());
}

/* Adds definitions/TYPE for each type and returns the choice among them. */
static json_t *any_element(json_t *definitions, const char *const *types, uint32_t count,
                           mcv_param_table (*table)(uint32_t)) {
    json_t *choice = json_array();
    for (uint32_t type = 0; type < count; ++type) {
        json_object_set_new(definitions, types[type], element_schema(types[type], table(type)));
        json_array_append_new(
            choice, json_pack("{s:o}", "$ref", json_sprintf("#/definitions/%s", types[type])));
    }
    return choice;
}

/* The root array KEYs and the index KEY (without s) of a node. */
static json_t *indexed_schema(const char *key, const char *index, json_t *choice,
                              json_t *definitions) {
    json_object_set_new(definitions, "node",
                        json_pack("{s:s, s:s, s:{s:{s:s, s:i}}, s:[s]}", "description",
                                  "the extension object of a node", "type", "object", "properties",
                                  index, "type", "integer", "minimum", 0, "required", index));
    return json_pack("{s:s, s:{s:{s:s, s:i, s:{s:o}}}, s:[s], s:o}", "type", "object", "properties",
                     key, "type", "array", "minItems", 1, "items", "oneOf", choice, "required", key,
                     "definitions", definitions);
}

static json_t *three_schema(const char *description, json_t *item) {
    return json_pack("{s:s, s:s, s:o, s:i, s:i}", "description", description, "type", "array",
                     "items", item, "minItems", 3, "maxItems", 3);
}

/* load_motion.c reads it. */
static json_t *motion_schema(void) {
    return json_pack(
        "{s:s, s:{s:o, s:o, s:o, s:{s:s, s:s}}}", "type", "object", "properties", "velocity",
        three_schema("in the world [m/s]", json_pack("{s:s}", "type", "number")), "axis",
        three_schema("direction of the axis of turns, by the right-hand rule",
                     json_pack("{s:s}", "type", "number")),
        "centre", three_schema("a point of that axis [m]", json_pack("{s:s}", "type", "number")),
        "rate", "description", "turns about the axis [rad/s]", "type", "number");
}

/* Places by chance. */
static void add_chance(json_t *properties) {
    json_object_set_new(properties, "count",
                        json_pack("{s:s, s:s, s:i, s:i}", "description",
                                  "so many in places by chance, in place of `at`", "type",
                                  "integer", "minimum", 1, "maximum", 1000));
    json_object_set_new(properties, "density",
                        json_pack("{s:s, s:s, s:i}", "description",
                                  "defects on a surface by chance, on average [1/m²]", "type",
                                  "number", "minimum", 0));
    json_object_set_new(properties, "seed",
                        json_pack("{s:s, s:s, s:i, s:i}", "description", "of the places by chance",
                                  "type", "integer", "minimum", 0, "default", 0));
}

/* A size may be stated as on drawings, too (host/defects/notation.c). */
static void allow_notation(json_t *properties) {
    json_t *size = json_object_get(properties, "size");
    const char *length = json_string_value(json_object_get(size, "pattern"));
    json_object_set_new(size, "pattern",
                        json_sprintf("%s|^[15]/ *[CLE]?[-+.0-9CLExX×; ]+$|^[0-9.]+-[0-9.]+$",
                                     length ? length : "^$"));
}

/* The root array of defects; what they have in common stands beside their parameters. */
static json_t *defects_schema(json_t *definitions) {
    const mcv_param length = {MCV_PARAM_length, "at", 0, MCV_UNSET, -1e6, 1e6, ""};
    json_t *choice = any_element(definitions, mcv_defect_types, MCV_DEFECT_COUNT, mcv_defect_table);
    for (uint32_t type = 0; type < MCV_DEFECT_COUNT; ++type) {
        json_t *one = json_object_get(definitions, mcv_defect_types[type]);
        json_t *properties = json_object_get(one, "properties");
        json_array_append_new(json_object_get(one, "required"), json_string("node"));
        json_object_set_new(properties, "node",
                            json_pack("{s:s, s:s}", "description",
                                      "a node of the scene or of an asset, by name; the meshes of "
                                      "the nodes below it are part of it",
                                      "type", "string"));
        json_object_set_new(properties, "at",
                            three_schema("a point of the surface along the node's axes [m]",
                                         scalar_schema(&length)));
        json_object_set_new(
            properties, "triangle",
            json_pack("{s:s, s:s, s:i}", "description",
                      "in place of `at`: a triangle of the node's meshes, by its number", "type",
                      "integer", "minimum", 0));
        json_object_set_new(properties, "barycentric",
                            three_schema("where in the triangle; by default in its middle",
                                         json_pack("{s:s, s:i}", "type", "number", "minimum", 0)));
        add_chance(properties);
        allow_notation(properties);
        if (type == MCV_DEFECT_INCLUSION || type == MCV_DEFECT_STAIN)
            json_object_set_new(properties, "material",
                                material_schema("a material of the file, by name or index"));
        json_object_set_new(properties, "direction",
                            three_schema("along the surface, in the node's axes; by default its x",
                                         json_pack("{s:s}", "type", "number")));
    }
    return json_pack("{s:s, s:{s:{s:s, s:i, s:{s:o}}}, s:[s], s:o}", "type", "object", "properties",
                     "defects", "type", "array", "minItems", 1, "items", "oneOf", choice,
                     "required", "defects", "definitions", definitions);
}

mcv_result mcv_schema_write(FILE *stream, const char *name, mcv_error *error) {
    json_t *definitions = json_object(), *schema = NULL;
    if (strcmp(name, "MCVISI_sensors") == 0)
        schema = indexed_schema(
            "sensors", "sensor",
            any_element(definitions, mcv_sensor_types, MCV_SENSOR_TYPE_COUNT, mcv_sensor_table),
            definitions);
    else if (strcmp(name, "MCVISI_emitters") == 0)
        schema = indexed_schema(
            "emitters", "emitter",
            any_element(definitions, mcv_emitter_types, MCV_EMITTER_TYPE_COUNT, mcv_emitter_table),
            definitions);
    else if (strcmp(name, "MCVISI_materials") == 0)
        schema = json_pack(
            "{s:s, s:o, s:o}", "type", "object", "oneOf",
            any_element(definitions, mcv_material_types, MCV_MATERIAL_COUNT, mcv_material_table),
            "definitions", definitions);
    else if (strcmp(name, "MCVISI_assets") == 0)
        schema = indexed_schema("assets", "asset", json_pack("[o]", asset_schema()), definitions);
    else if (strcmp(name, "MCVISI_pose") == 0)
        schema = pose_schema();
    else if (strcmp(name, "MCVISI_misalignment") == 0)
        schema = object_schema(json_object(), json_array(), mcv_misalignment_table());
    else if (strcmp(name, "MCVISI_spectrum") == 0)
        schema = spectrum_schema();
    else if (strcmp(name, "MCVISI_surfaces") == 0) {
        json_t *choice = any_element(definitions, mcv_body_types, MCV_BODY_COUNT, mcv_body_table);
        add_body_members(definitions);
        schema = indexed_schema("surfaces", "surface", choice, definitions);
    } else if (strcmp(name, "MCVISI_defects") == 0)
        schema = defects_schema(definitions);
    else if (strcmp(name, "MCVISI_motion") == 0)
        schema = motion_schema();
    if (!json_object_get(schema, "definitions")) json_decref(definitions);
    if (!schema) return mcv_fail(error, MCV_USAGE, "there is no schema of \"%s\"", name);
    json_t *document =
        json_pack("{s:s, s:s}", "$schema", "http://json-schema.org/draft-04/schema", "title", name);
    json_object_update_new(document, schema);
    const bool written =
        json_dumpf(document, stream, JSON_INDENT(2)) == 0 && fputc('\n', stream) != EOF;
    json_decref(document);
    return written ? MCV_OK
                   : mcv_fail(error, MCV_FAILED, "the schema of %s cannot be written", name);
}
