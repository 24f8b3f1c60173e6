/* SPDX-License-Identifier: Apache-2.0 */
#include "cli/picture.h"

#include "cli/camera.h"
#include "scene/sensor_find.h"
#include "core/basics.h"
#include "core/output_file.h"
#include "scene/sensors.h"

#include <ctype.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

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

mcv_result mcv_render_files_plan(const mcv_command *command, const mcv_scene *scene,
                                 uint32_t sensor, bool several, mcv_render_files *picture,
                                 mcv_error *error) {
    uint32_t width, height;
    char label[128];
    const bool irradiance = mcv_sensor_measures_irradiance(scene->sensors + sensor);
    picture->unit = mcv_rendered_unit(scene, sensor);

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
    MCV_TRY(make_path(picture->exr, command->exr ? command->exr : scene->path, suffix,
                      command->exr ? NULL : ".exr", error));
    if (command->png)
        MCV_TRY(make_path(picture->png, command->png, suffix, NULL, error));
    else
        MCV_TRY(make_path(picture->png, picture->exr, NULL, ".png", error));

    picture->grey[0] = '\0';
    if (command->camera) {
        MCV_TRY(make_path(picture->grey, command->camera, suffix, NULL, error));
        MCV_TRY(mcv_camera_check(command, picture->grey, error));
        if (!irradiance && command->electrons_per_unit[0] == 0 && command->expose_to == 0)
            return mcv_fail(error, MCV_BAD_INPUT,
                            "%s: sensor %s measures radiance, which --exposure-time cannot convert "
                            "to electrons: "
                            "--set sensors/%s/radiometry=irradiance, or give --electrons-per-unit "
                            "or --expose-to",
                            scene->path, label, label);
    }
    const char *const paths[] = {picture->exr, picture->png, picture->grey};
    for (int i = 0; i < (command->camera ? 3 : 2); ++i) {
        if (mcv_same_file(paths[i], scene->path))
            return mcv_fail(error, MCV_USAGE, "%s is the scene: give the image another name",
                            paths[i]);
        MCV_TRY(mcv_output_check(paths[i], error));
    }
    if (strcmp(picture->grey, picture->exr) == 0 || strcmp(picture->grey, picture->png) == 0)
        return mcv_fail(
            error, MCV_USAGE,
            "%s would be both the image and its grey values: give --camera another name",
            picture->grey);
    if (strcmp(picture->exr, picture->png) == 0)
        return mcv_fail(
            error, MCV_USAGE,
            "%s would be both the image and its preview: give the preview another name by --png",
            picture->exr);
    return MCV_OK;
}

/* --- what is needed to repeat a render --- */

/* FNV-1a, 64 bits, of a file's bytes. */
static mcv_result hash_file(const char *path, uint64_t *hash, mcv_error *error) {
    unsigned char bytes[65536];
    FILE *file = fopen(path, "rb");
    if (!file) return mcv_fail(error, MCV_BAD_INPUT, "%s: %s", path, strerror(errno));
    *hash = MCV_HASH_BEGIN;
    for (size_t count; (count = fread(bytes, 1, sizeof bytes, file)) > 0;)
        *hash = mcv_hash_bytes(*hash, bytes, count);
    const bool failed = ferror(file);
    fclose(file);
    return failed ? mcv_fail(error, MCV_BAD_INPUT, "%s: cannot be read completely", path) : MCV_OK;
}

mcv_result mcv_render_files_write(const mcv_render_files *files, const mcv_command *command,
                                  const mcv_scene *scene, uint32_t sensor,
                                  const mcv_render_options *options, const mcv_film *film,
                                  const mcv_render_stats *stats, mcv_preview *preview,
                                  mcv_error *error) {
    mcv_exr exr;
    mcv_rendered rendered = {.scene = scene,
                             .sensor = sensor,
                             .options = options,
                             .film = film,
                             .stats = stats,
                             .set = {command->set.items, command->set.count},
                             .replicates = command->parts != 0};
    MCV_TRY(hash_file(scene->path, &rendered.hash, error));
    MCV_TRY(mcv_rendered_develop(&rendered, &exr, error));
    mcv_result result = mcv_exr_write(files->exr, exr.parts, exr.part_count, exr.attributes,
                                      exr.attribute_count, error);
    if (result == MCV_OK)
        result =
            mcv_png_write_preview(files->png, &exr.parts[0].image, files->unit, preview, error);
    mcv_exr_free(&exr);
    return result;
}
