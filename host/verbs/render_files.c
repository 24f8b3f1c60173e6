/* SPDX-License-Identifier: Apache-2.0 */
#include "verbs/render_files.h"

#include "verbs/grey_files.h"
#include "scene/laser.h"
#include "scene/sensor_find.h"
#include "core/basics.h"
#include "core/output_file.h"
#include "film/film_file.h"
#include "io/exr_header.h"
#include "scene/sensors.h"

#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* --- names --- */

/* The path without the ending of its file name. */
static int stem_length(const char *path) {
    const char *slash = strrchr(path, '/');
    const char *dot = strrchr(slash ? slash + 1 : path, '.');
    return (int)(dot && dot > (slash ? slash + 1 : path) ? (size_t)(dot - path) : strlen(path));
}

/* The path with -SENSOR inserted before its ending if a sensor is given, and with another ending if
 * one is given. */
static mcv_result make_path(char *out, const char *path, const char *sensor, const char *ending,
                            mcv_error *error) {
    const int stem = stem_length(path);
    const int length = snprintf(out, PATH_MAX, "%.*s%s%s%s", stem, path, sensor ? "-" : "",
                                sensor ? sensor : "", ending ? ending : path + stem);
    if (length < PATH_MAX) return MCV_OK;
    return mcv_fail(error, MCV_BAD_INPUT, "%s: the path of the output is longer than %d bytes",
                    path, PATH_MAX);
}

/* No two files are the same one, none is the scene, and each can be written. */
static mcv_result check_paths(const mcv_render_files *files, const mcv_scene *scene,
                              mcv_error *error) {
    const char *const paths[] = {files->exr, files->png, files->grey, files->film, files->part};
    for (int i = 0; i < 5; ++i) {
        if (!paths[i][0]) continue;
        for (int j = 0; i >= 3 && j < i; ++j)
            if (strcmp(paths[i], paths[j]) == 0)
                return mcv_fail(error, MCV_USAGE,
                                "%s would be two files: give --checkpoint and --film other names",
                                paths[i]);
        if (mcv_same_file(paths[i], scene->path))
            return mcv_fail(error, MCV_USAGE, "%s is the scene: give the image another name",
                            paths[i]);
        MCV_TRY(mcv_output_check(paths[i], error));
    }
    if (strcmp(files->grey, files->exr) == 0 || strcmp(files->grey, files->png) == 0)
        return mcv_fail(
            error, MCV_USAGE,
            "%s would be both the image and its grey values: give --camera another name",
            files->grey);
    if (strcmp(files->exr, files->png) == 0)
        return mcv_fail(
            error, MCV_USAGE,
            "%s would be both the image and its preview: give the preview another name by --png",
            files->exr);
    return MCV_OK;
}

mcv_result mcv_render_files_plan(const mcv_command *command, const mcv_scene *scene,
                                 uint32_t sensor, bool several, mcv_render_files *files,
                                 mcv_error *error) {
    uint32_t width, height;
    char label[128];
    const bool irradiance = mcv_sensor_measures_irradiance(scene->sensors + sensor);

    mcv_sensor_film_size(scene->sensors + sensor, &width, &height);
    if (width > MCV_EXR_MAX_SIDE || height > MCV_EXR_MAX_SIDE)
        return mcv_fail(
            error, MCV_BAD_INPUT,
            "%s: sensors/%s: its image of %u x %u pixels must have at most %d on a side",
            scene->path, scene->sensors[sensor].name, width, height, MCV_EXR_MAX_SIDE);

    mcv_sensor_label(scene, sensor, label, sizeof label);
    for (char *c = label; *c; ++c)
        if (*c == '/' || iscntrl((unsigned char)*c)) *c = '_';
    const char *suffix = several ? label : NULL;
    MCV_TRY(make_path(files->exr, command->exr ? command->exr : scene->path, suffix,
                      command->exr ? NULL : ".exr", error));
    if (command->png)
        MCV_TRY(make_path(files->png, command->png, suffix, NULL, error));
    else
        MCV_TRY(make_path(files->png, files->exr, NULL, ".png", error));

    files->film[0] = '\0';
    if (!command->checkpoint)
        MCV_TRY(make_path(files->film, files->exr, NULL, ".checkpoint", error));
    else if (strcmp(command->checkpoint, "off") != 0)
        MCV_TRY(make_path(files->film, command->checkpoint, suffix, NULL, error));

    files->part[0] = '\0';
    if (command->part) MCV_TRY(make_path(files->part, command->part, suffix, NULL, error));

    files->grey[0] = '\0';
    if (command->camera) {
        MCV_TRY(make_path(files->grey, command->camera, suffix, NULL, error));
        MCV_TRY(mcv_grey_check_file(command, files->grey, error));
        if (!irradiance && command->electrons_per_unit[0] == 0 && command->expose_to == 0)
            return mcv_fail(error, MCV_BAD_INPUT,
                            "%s: sensor %s measures radiance, which --exposure-time cannot convert "
                            "to electrons: "
                            "--set sensors/%s/radiometry=irradiance, or give --electrons-per-unit "
                            "or --expose-to",
                            scene->path, label, label);
    }
    return check_paths(files, scene, error);
}

mcv_result mcv_render_files_check(const mcv_command *command, const mcv_scene *scene,
                                  uint32_t first, uint32_t count, mcv_error *error) {
    mcv_render_files files, earlier;
    for (uint32_t i = first; i < first + count; ++i) {
        MCV_TRY(mcv_render_files_plan(command, scene, i, count > 1, &files, error));
        for (uint32_t j = first; j < i; ++j) {
            MCV_TRY(mcv_render_files_plan(command, scene, j, count > 1, &earlier, error));
            if (strcmp(files.exr, earlier.exr) == 0)
                return mcv_fail(error, MCV_BAD_INPUT,
                                "%s would be the image of both sensors, %s and %s: rename one, or "
                                "choose one by --sensor",
                                files.exr, scene->sensors[j].name, scene->sensors[i].name);
        }
    }
    return MCV_OK;
}

mcv_result mcv_render_resize(const mcv_command *command, mcv_scene *scene, uint32_t sensor,
                             mcv_error *error) {
    enum { WIDEST = 65536 };
    mcv_sensor *s = scene->sensors + sensor;
    uint32_t width, height;
    if (command->resolution[0])
        MCV_TRY(mcv_sensor_resize(s, command->resolution[0], command->resolution[1], scene, error));
    if (!command->lasers) return MCV_OK;
    mcv_sensor_film_size(s, &width, &height);
    const uint64_t columns = (uint64_t)command->lasers * width,
                   rows = (uint64_t)command->lasers * height;
    if (columns > WIDEST || rows > WIDEST)
        return mcv_fail(error, MCV_USAGE,
                        "--lasers %u: makes %llu x %llu pixels of sensor %s: at most %d each",
                        (unsigned)command->lasers, (unsigned long long)columns,
                        (unsigned long long)rows, s->name, WIDEST);
    MCV_TRY(mcv_scene_keep_lasers(scene, error));
    return mcv_sensor_resize(s, columns, rows, scene, error);
}

mcv_result mcv_render_sensors(const mcv_command *command, mcv_scene *scene, uint32_t *first,
                              uint32_t *count, mcv_error *error) {
    *first = 0;
    *count = scene->sensor_count;
    if (command->sensor) {
        MCV_TRY(mcv_sensor_find(scene, command->sensor, first, error));
        *count = 1;
    }
    for (uint32_t i = *first; i < *first + *count; ++i)
        MCV_TRY(mcv_render_resize(command, scene, i, error));
    return MCV_OK;
}

/* --- what is written --- */

bool mcv_render_files_finished(const mcv_render_files *files) {
    mcv_exr_header header;
    mcv_error ignored;
    uint8_t *bytes;
    size_t size;
    bool finished = true;
    if (access(files->exr, F_OK) != 0 ||
        mcv_file_load(files->exr, &bytes, &size, &ignored) != MCV_OK)
        return false;
    if (mcv_exr_header_read(files->exr, bytes, size, &header, &ignored) == MCV_OK) {
        for (uint32_t i = 0; i < header.attribute_count; ++i)
            finished = finished && strcmp(header.attributes[i].name, MCV_PICTURE_INTERRUPTED) != 0;
        mcv_exr_header_free(&header);
    }
    free(bytes);
    return finished;
}

static bool is_part_of(const char *path, const char *hash) {
    mcv_film_file part;
    mcv_error ignored;
    if (mcv_film_file_look(path, &part, &ignored) != MCV_OK) return false;
    const char *of = json_string_value(
        json_object_get(json_object_get(part.facts, "attributes"), MCV_PICTURE_RENDER));
    const bool same = of && strcmp(of, hash) == 0;
    mcv_film_file_free(&part);
    return same;
}

bool mcv_render_files_kept(const mcv_render_files *files, const char hash[MCV_RENDER_HASH],
                           const char *unit) {
    mcv_exr exr;
    mcv_preview preview = {.white = NAN};
    mcv_error ignored;
    if (!hash[0] || mcv_exr_read(files->exr, &exr, &ignored) != MCV_OK) return false;
    const mcv_attribute *of = mcv_exr_attribute(&exr, MCV_PICTURE_RENDER);
    const bool kept =
        of && of->text && strcmp(of->text, hash) == 0 &&
        !mcv_exr_attribute(&exr, MCV_PICTURE_INTERRUPTED) &&
        (!files->part[0] || is_part_of(files->part, hash)) &&
        mcv_png_write_preview(files->png, &exr.parts[0].image, unit, &preview, &ignored) == MCV_OK;
    mcv_exr_free(&exr);
    return kept;
}

mcv_result mcv_render_files_rename(const mcv_render_files *files, mcv_render_files *others,
                                   mcv_error *error) {
    *others = *files;
    MCV_TRY(make_path(others->exr, files->exr, "interrupted", NULL, error));
    MCV_TRY(make_path(others->png, files->png, "interrupted", NULL, error));
    if (files->grey[0]) MCV_TRY(make_path(others->grey, files->grey, "interrupted", NULL, error));
    return MCV_OK;
}

mcv_result mcv_render_files_write(const mcv_render_files *files, const mcv_rendered *rendered,
                                  mcv_preview *preview, mcv_error *error) {
    mcv_exr exr;
    MCV_TRY(mcv_rendered_develop(rendered, &exr, error));
    mcv_result result = mcv_exr_write(files->exr, exr.parts, exr.part_count, exr.attributes,
                                      exr.attribute_count, error);
    if (result == MCV_OK)
        result = mcv_png_write_preview(files->png, &exr.parts[0].image,
                                       mcv_rendered_unit(rendered->scene, rendered->sensor),
                                       preview, error);
    mcv_exr_free(&exr);
    return result;
}

mcv_result mcv_render_files_expose(const mcv_command *command, const mcv_render_files *files,
                                   mcv_report *report, mcv_error *error) {
    mcv_exr light, grey;
    mcv_read_out out;
    MCV_TRY(mcv_exr_read(files->exr, &light, error));
    mcv_result result = mcv_grey_make(command, files->exr, &light, &out, &grey, error);
    if (result == MCV_OK) {
        result = mcv_grey_save(command, &light, &grey, files->grey, error);
        if (result == MCV_OK && report->json)
            mcv_grey_warn(files->grey, &grey, &out, report);
        else if (result == MCV_OK)
            mcv_grey_tell(command, files->grey, &grey, &out, report);
        mcv_exr_free(&grey);
    }
    mcv_exr_free(&light);
    return result;
}
