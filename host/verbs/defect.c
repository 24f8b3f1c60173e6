/* SPDX-License-Identifier: Apache-2.0 */
#include "verbs/defect.h"

#include "check/findings.h"
#include "core/json.h"
#include "scene/defect_params.h"
#include "scene/params.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* --- the entry of the scene file --- */

/* extensions/MCVISI_defects/defects of the document, made where it is missing; NULL where something
 * else stands there, or without memory. */
static json_t *defects_of(json_t *root) {
    static const char *const keys[] = {"extensions", "MCVISI_defects"};
    json_t *object = root, *used = json_object_get(root, "extensionsUsed");
    for (int i = 0; i < 2 && object; ++i) {
        json_t *child = json_object_get(object, keys[i]);
        if (!child) {
            child = json_object();
            json_object_set_new(object, keys[i], child);
        }
        object = json_is_object(child) ? child : NULL;
    }
    json_t *array = json_object_get(object, "defects");
    if (array) return json_is_array(array) ? array : NULL;
    if (!used) {
        used = json_array();
        json_object_set_new(root, "extensionsUsed", used);
    }
    json_array_append_new(used, json_string(keys[1]));
    array = json_array();
    return object && json_object_set_new(object, "defects", array) == 0 ? array : NULL;
}

static bool is_taken(const json_t *defects, const char *name) {
    size_t i;
    const json_t *one;
    json_array_foreach((json_t *)defects, i, one) {
        if (strcmp(mcv_json_name(one), name) == 0) return true;
    }
    return false;
}

/* The wished name, or the type with the first number that is free. */
static mcv_result choose_name(const json_t *defects, const mcv_command *command, char **name,
                              mcv_error *error) {
    *name = NULL;
    if (command->defect_name && is_taken(defects, command->defect_name))
        return mcv_fail(error, MCV_USAGE, "--name %s: the rig has a defect of this name already",
                        command->defect_name);
    if (command->defect_name)
        *name = strdup(command->defect_name);
    else
        for (unsigned i = 1; i <= json_array_size(defects) + 1; ++i) {
            free(*name);
            if (asprintf(name, "%s-%u", command->second, i) < 0) *name = NULL;
            if (!*name || !is_taken(defects, *name)) break;
        }
    return *name ? MCV_OK : mcv_fail(error, MCV_FAILED, "no memory for the defect's name");
}

/* The parts of A,B,C: quantities as texts with `lengths`, else numbers. NULL where they are not
 * `count`. */
static json_t *read_list(const char *text, size_t count, bool lengths) {
    json_t *list = json_array();
    for (bool more = true; more && list;) {
        char one[64];
        const size_t size = strcspn(text, ",");
        double value;
        snprintf(one, sizeof one, "%.*s", (int)(size < sizeof one ? size : 0), text);
        if (!mcv_parse_quantity(one, lengths ? MCV_PARAM_length : MCV_PARAM_number, &value)) {
            json_decref(list);
            return NULL;
        }
        /* As it was typed: 12mm stays 12mm. */
        json_array_append_new(list, lengths ? json_string(one) : json_real(value));
        more = text[size] == ',';
        text += size + more;
    }
    if (json_array_size(list) == count) return list;
    json_decref(list);
    return NULL;
}

static mcv_result put_list(json_t *entry, const char *key, const char *text, bool lengths,
                           mcv_error *error) {
    json_t *list = read_list(text, 3, lengths);
    if (list && json_object_set_new(entry, key, list) == 0) return MCV_OK;
    return mcv_fail(error, MCV_USAGE, "--%s %s: must be X,Y,Z, %s", key, text,
                    lengths ? "lengths with units, as in 12mm,3mm,0"
                            : "the numbers of a direction, as in 1,0,0");
}

static mcv_result put_triangle(json_t *entry, const char *text, mcv_error *error) {
    json_t *list = strchr(text, ',') ? read_list(text, 4, false) : read_list(text, 1, false);
    const double number = json_number_value(json_array_get(list, 0));
    if (!list || !(number >= 0 && number <= INT32_MAX) || number != (double)(int32_t)number) {
        json_decref(list);
        return mcv_fail(error, MCV_USAGE,
                        "--triangle %s: must be a number of a triangle, or with its barycentric "
                        "coordinates, as in 17,0.2,0.3,0.5",
                        text);
    }
    json_object_set_new(entry, "triangle", json_integer((json_int_t)number));
    json_array_remove(list, 0);
    if (json_array_size(list))
        json_object_set_new(entry, "barycentric", list);
    else
        json_decref(list);
    return MCV_OK;
}

/* KEY=VALUE of --with; a value that is no JSON is a text. */
static mcv_result put_other(json_t *entry, const char *item, mcv_error *error) {
    const char *equals = strchr(item, '=');
    char key[64];
    if (!equals || equals == item || (size_t)(equals - item) >= sizeof key)
        return mcv_fail(error, MCV_USAGE, "--with %s: must be KEY=VALUE, as in profile=U", item);
    snprintf(key, sizeof key, "%.*s", (int)(equals - item), item);
    if (json_object_get(entry, key))
        return mcv_fail(error, MCV_USAGE, "--with %s: %s is given already", item, key);
    json_t *value = json_loads(equals + 1, JSON_DECODE_ANY, NULL);
    if (!value) value = json_string(equals + 1);
    return json_object_set_new(entry, key, value) == 0
               ? MCV_OK
               : mcv_fail(error, MCV_USAGE, "--with %s: must be UTF-8 text", item);
}

static mcv_result fill_entry(const mcv_command *command, const char *name, json_t *entry,
                             mcv_error *error) {
    const char *const texts[][2] = {{"name", name},
                                    {"type", command->second},
                                    {"node", command->node},
                                    {"size", command->defect_size},
                                    {"depth", command->defect_depth},
                                    {"length", command->length}};
    for (size_t i = 0; i < sizeof texts / sizeof texts[0]; ++i)
        if (texts[i][1] && json_object_set_new(entry, texts[i][0], json_string(texts[i][1])) != 0)
            return mcv_fail(error, MCV_USAGE, "--%s: must be UTF-8 text", texts[i][0]);
    if (command->at) MCV_TRY(put_list(entry, "at", command->at, true, error));
    if (command->triangle) MCV_TRY(put_triangle(entry, command->triangle, error));
    if (command->direction) MCV_TRY(put_list(entry, "direction", command->direction, false, error));
    for (size_t i = 0; i < command->with.count; ++i)
        MCV_TRY(put_other(entry, command->with.items[i], error));
    return MCV_OK;
}

static mcv_result check_given(const mcv_command *command, mcv_error *error) {
    uint32_t type = 0;
    while (type < MCV_DEFECT_COUNT && strcmp(command->second, mcv_defect_types[type]) != 0) ++type;
    const char *nearest = mcv_nearest_word(command->second, mcv_defect_types, MCV_DEFECT_COUNT);
    if (type == MCV_DEFECT_COUNT)
        return mcv_fail(error, MCV_USAGE, "defect %s: there is no such defect%s%s%s",
                        command->second, nearest ? ": did you mean " : "", nearest ? nearest : "",
                        nearest ? "?" : ": `mcvisi help defect` lists them");
    if (!command->node)
        return mcv_fail(error, MCV_USAGE, "--node is missing: name the node that gets the defect");
    bool by_chance = false;
    for (size_t i = 0; i < command->with.count; ++i)
        by_chance = by_chance || strncmp(command->with.items[i], "count=", 6) == 0 ||
                    strncmp(command->with.items[i], "density=", 8) == 0;
    if (by_chance ? command->at || command->triangle : !command->at == !command->triangle)
        return mcv_fail(error, MCV_USAGE,
                        "give the place by --at X,Y,Z or by --triangle%s, or leave it to chance by "
                        "--with count=N",
                        command->at && command->triangle ? ", not by both" : "");
    return MCV_OK;
}

mcv_result mcv_defect_add(const mcv_command *command, json_t *root, char **name, mcv_error *error) {
    *name = NULL;
    MCV_TRY(check_given(command, error));
    json_t *defects = defects_of(root), *entry = json_object();
    mcv_result result =
        defects && entry
            ? choose_name(defects, command, name, error)
            : mcv_fail(error, MCV_BAD_INPUT,
                       "extensions/MCVISI_defects: must be an object with the array \"defects\"");
    if (result == MCV_OK) result = fill_entry(command, *name, entry, error);
    if (result == MCV_OK && json_array_append(defects, entry) != 0)
        result = mcv_fail(error, MCV_FAILED, "no memory for the defect");
    json_decref(entry);
    if (result == MCV_OK) return MCV_OK;
    free(*name);
    *name = NULL;
    return result;
}

/* --- the report --- */

/* Findings about the defect as notes. */
static mcv_result tell_findings(const mcv_scene *scene, const char *name, mcv_report *report,
                                mcv_error *error) {
    mcv_findings findings;
    char path[256];
    const int length = snprintf(path, sizeof path, "defects/%.200s/", name);
    MCV_TRY(mcv_findings_of(scene, &findings, error));
    for (size_t i = 0; i < findings.count; ++i)
        if (strncmp(findings.items[i].path, path, (size_t)length) == 0)
            mcv_report_tell(report, mcv_severities[findings.items[i].severity],
                            findings.items[i].sentence);
    mcv_findings_free(&findings);
    return MCV_OK;
}

mcv_result mcv_defect_report(const mcv_scene *scene, mcv_report *report, mcv_error *error) {
    if (scene->defect_count == 0) {
        mcv_report_tell(report, "note", "with this seed no defect lies on the surface");
        return MCV_OK;
    }
    const mcv_defect *d = scene->defects + scene->defect_count - 1;
    MCV_TRY(tell_findings(scene, d->name, report, error));
    mcv_report_text(report, "defect", d->name);
    mcv_report_text(report, "type", mcv_defect_types[d->type]);
    mcv_report_numbers(report, "position", "m", ", ", d->centre, 3);
    mcv_report_numbers(report, "normal", "", ", ", d->axes[2], 3);
    mcv_report_number(report, "size", "m", d->size);
    if (d->depth > 0)
        mcv_report_number(report, d->type == MCV_DEFECT_CRACK ? "opening" : "depth", "m", d->depth);
    if (d->length > 0) mcv_report_number(report, "length", "m", d->length);
    mcv_report_number(report, "defects", "", scene->defect_count);
    mcv_report_number(report, "triangles", "", scene->triangle_count);
    return MCV_OK;
}
