/* SPDX-License-Identifier: Apache-2.0 */
/* What the public interface does with pictures: files, grey values, figures. */
#include "api/handles.h"
#include "core/basics.h"
#include "io/exr_make.h"
#include "io/png.h"
#include "io/values.h"
#include "core/output_file.h"
#include "verbs/grey_files.h"
#include "verbs/measure.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* --- files --- */

typedef struct write_options {
    bool preview;
    json_t *parts; /* names, or NULL for all */
    json_t *all;
} write_options;

static mcv_result read_write_options(const char *text, write_options *o, mcv_error *error) {
    json_error_t wrong;
    const char *key;
    json_t *value;
    *o = (write_options){0};
    if (!text || !text[0]) return MCV_OK;
    o->all = json_loads(text, JSON_REJECT_DUPLICATES, &wrong);
    bool right = json_is_object(o->all);
    json_object_foreach(o->all, key, value) {
        const bool preview = strcmp(key, "preview") == 0 && json_is_boolean(value);
        right = right && (preview || (strcmp(key, "parts") == 0 && json_is_array(value)));
    }
    if (!right) {
        json_decref(o->all);
        return mcv_fail(error, MCV_USAGE,
                        "options: must be a JSON object of preview (true or false) and parts (a "
                        "list of names)");
    }
    o->preview = json_is_true(json_object_get(o->all, "preview"));
    o->parts = json_object_get(o->all, "parts");
    return MCV_OK;
}

static bool is_wanted(const json_t *names, const char *name) {
    size_t i;
    const json_t *item;
    json_array_foreach((json_t *)names, i, item) {
        if (json_is_string(item) && strcmp(json_string_value(item), name) == 0) return true;
    }
    return names == NULL;
}

static mcv_result write_exr(const mcv_exr *exr, const char *path, const json_t *names,
                            mcv_error *error) {
    mcv_exr_part *parts = malloc(exr->part_count * sizeof *parts);
    uint32_t count = 0;
    if (!parts) return mcv_fail(error, MCV_FAILED, "%s: no memory for its parts", path);
    for (uint32_t i = 0; i < exr->part_count; ++i)
        if (is_wanted(names, exr->parts[i].name)) parts[count++] = exr->parts[i];
    const mcv_result result =
        count > 0
            ? mcv_exr_write(path, parts, count, exr->attributes, exr->attribute_count, error)
            : mcv_fail(error, MCV_USAGE, "options: parts: the picture has none of these parts");
    free(parts);
    return result;
}

static mcv_result write_preview(const mcv_exr *exr, const char *path, mcv_error *error) {
    const mcv_attribute *unit = mcv_exr_attribute(exr, "mcvisi:unit");
    const double *bits = mcv_exr_numbers(exr, "mcvisi:bits", 1);
    mcv_preview preview = {.white = bits ? exp2(*bits) - 1 : 0};
    return mcv_png_write_preview(path, &exr->parts[0].image, unit && unit->text ? unit->text : "",
                                 &preview, error);
}

static mcv_result write_picture(const mcv_picture *picture, const char *path, const char *text,
                                mcv_error *error) {
    const mcv_exr *exr = &picture->exr;
    const bool values = mcv_grey_is(exr);
    write_options options;
    MCV_TRY(read_write_options(text, &options, error));
    mcv_result result;
    if (mcv_ends_in(path, ".exr"))
        result = write_exr(exr, path, options.parts, error);
    else if (mcv_ends_in(path, ".png") && (options.preview || !values))
        result = write_preview(exr, path, error);
    else if (!values)
        result = mcv_fail(error, MCV_USAGE,
                          "%s: light is written into .exr, or as a preview into .png; grey values "
                          "(mcv_picture_camera) also into " MCV_VALUES_ENDINGS,
                          path);
    else
        result = mcv_grey_write(path, exr, error);
    json_decref(options.all);
    return result;
}

mcv_result mcv_picture_write(const mcv_picture *picture, const char *path, const char *options,
                             mcv_error *error) {
    mcv_result result;
    MCV_NEED(picture);
    MCV_NEED(path);
    MCV_INSIDE(result, write_picture(picture, path, options, error));
    return result;
}

/* --- grey values --- */

static mcv_result check_file(const mcv_command *command, const mcv_picture *picture,
                             mcv_error *error) {
    if (!command->grey) return MCV_OK;
    if (mcv_same_file(command->grey, picture->path))
        return mcv_fail(error, MCV_USAGE, "%s is the image: give the grey values another name",
                        command->grey);
    return mcv_grey_check_file(command, command->grey, error);
}

static mcv_result expose(const mcv_command *command, const mcv_picture *picture, mcv_picture **grey,
                         char **report, mcv_error *error) {
    mcv_exr light, values;
    mcv_read_out out;
    mcv_report r;
    MCV_TRY(check_file(command, picture, error));
    MCV_TRY(mcv_exr_copy(&picture->exr, &light, error)); /* it is blurred in place */
    mcv_result result = mcv_grey_make(command, picture->path, &light, &out, &values, error);
    if (result == MCV_OK) result = mcv_picture_of(&values, picture->path, grey, error);
    if (result == MCV_OK && command->grey)
        result = mcv_grey_save(command, &light, &(*grey)->exr, command->grey, error);
    mcv_exr_free(&light);
    if (result != MCV_OK || !report) return result;
    MCV_TRY(mcv_report_keep(&r, command->json, error));
    if (command->grey) {
        mcv_grey_tell(command, command->grey, &(*grey)->exr, &out, &r);
    } else {
        mcv_grey_warn(picture->path, &(*grey)->exr, &out, &r);
        mcv_grey_report(command, picture->path, NULL, &(*grey)->exr, &out, &r);
    }
    return mcv_report_take(&r, report, error);
}

static mcv_result camera(const mcv_picture *picture, const char *options, mcv_picture **grey,
                         char **report, mcv_error *error) {
    const char *const arguments[2] = {picture->path};
    mcv_options_given given;
    MCV_TRY(mcv_options_read(options, NULL, MCV_VERB_CAMERA, arguments, NULL, &given, error));
    const mcv_result result = expose(&given.command, picture, grey, report, error);
    mcv_options_free(&given);
    if (result == MCV_OK) return MCV_OK;
    mcv_picture_free(*grey);
    *grey = NULL;
    return result;
}

mcv_result mcv_picture_camera(const mcv_picture *picture, const char *options, mcv_picture **grey,
                              char **report, mcv_error *error) {
    mcv_result result;
    MCV_NEED(grey);
    *grey = NULL;
    if (report) *report = NULL;
    MCV_NEED(picture);
    MCV_INSIDE(result, camera(picture, options, grey, report, error));
    return result;
}

/* --- figures --- */

static mcv_result measure_scene(const mcv_command *command, const mcv_picture *picture,
                                const mcv_picture *minus, const mcv_rig *rig, char **report,
                                mcv_error *error) {
    mcv_scene *scene = NULL;
    mcv_report r;
    if (rig) MCV_TRY(mcv_session_scene(NULL, rig, command, &scene, error));
    mcv_result result = mcv_report_keep(&r, command->json, error);
    if (result == MCV_OK) result = mcv_measure(command, picture, minus, scene, &r, error);
    mcv_scene_free(scene);
    if (result == MCV_OK) return mcv_report_take(&r, report, error);
    mcv_report_free(&r);
    return result;
}

static mcv_result measure(const mcv_picture *picture, const mcv_picture *minus, const mcv_rig *rig,
                          const char *options, char **report, mcv_error *error) {
    static const char *const without[] = {"minus", "scene", NULL};
    const char *const arguments[2] = {picture->path};
    mcv_options_given given;
    MCV_TRY(mcv_options_read(options, NULL, MCV_VERB_MEASURE, arguments, without, &given, error));
    const mcv_result result = measure_scene(&given.command, picture, minus, rig, report, error);
    mcv_options_free(&given);
    return result;
}

mcv_result mcv_picture_measure(const mcv_picture *picture, const mcv_picture *minus,
                               const mcv_rig *rig, const char *options, char **report,
                               mcv_error *error) {
    mcv_result result;
    MCV_NEED(report);
    *report = NULL;
    MCV_NEED(picture);
    MCV_INSIDE(result, measure(picture, minus, rig, options, report, error));
    return result;
}
