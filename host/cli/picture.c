/* SPDX-License-Identifier: Apache-2.0 */
#include "cli/picture.h"

#include "cli/camera.h"
#include "scene/sensor_find.h"
#include "io/exr.h"
#include "core/basics.h"
#include "core/output_file.h"
#include "scene/camera_model.h"
#include "scene/sensors.h"

#include <ctype.h>
#include <errno.h>
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MAX_PARTS = MCV_MAX_REPLICATES + 3 }; /* image, error, samples */

/* --- names --- */

/* The path without the ending of its file name. */
static int stem_length(const char *path) {
    const char *slash = strrchr(path, '/');
    const char *dot = strrchr(slash ? slash + 1 : path, '.');
    return (int)(dot && dot > (slash ? slash + 1 : path) ? (size_t)(dot - path) : strlen(path));
}

/* path with -SENSOR before its ending where there is a sensor, and another ending where one is
 * given. */
static mcv_result make_path(char *out, const char *path, const char *sensor, const char *ending,
                            mcv_error *error) {
    const int stem = stem_length(path);
    const int length = snprintf(out, PATH_MAX, "%.*s%s%s%s", stem, path, sensor ? "-" : "",
                                sensor ? sensor : "", ending ? ending : path + stem);
    if (length < PATH_MAX) return MCV_OK;
    return mcv_fail(error, MCV_BAD_INPUT, "%s: the path of the output is longer than %d bytes",
                    path, PATH_MAX);
}

mcv_result mcv_render_files_plan(const mcv_command *command, const mcv_scene *scene, uint32_t sensor,
                            bool several, mcv_render_files *picture, mcv_error *error) {
    uint32_t width, height;
    char label[128];
    const bool irradiance = mcv_sensor_measures_irradiance(scene->sensors + sensor);
    picture->quantity = irradiance ? "irradiance" : "radiance";
    picture->unit = irradiance ? "W/m^2" : "W/(m^2 sr)";

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
            return mcv_fail(
                error, MCV_BAD_INPUT,
                "%s: sensor %s measures radiance, which --exposure-time cannot turn into "
                "electrons: --set "
                "sensors/%s/radiometry=irradiance, or give --electrons-per-unit or --expose-to",
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
    return failed ? mcv_fail(error, MCV_BAD_INPUT, "%s: cannot be read to its end", path) : MCV_OK;
}

/* All --set, one a line. The caller frees it. */
static char *join_set(const mcv_command *command) {
    size_t length = 1;
    for (size_t i = 0; i < command->set.count; ++i) length += strlen(command->set.items[i]) + 1;
    char *text = calloc(1, length);
    for (size_t i = 0; text && i < command->set.count; ++i) {
        if (i) strcat(text, "\n");
        strcat(text, command->set.items[i]);
    }
    return text;
}

static mcv_attribute text_attribute(const char *name, const char *text) {
    return (mcv_attribute){.name = name, .text = text};
}

static mcv_attribute number_attribute(const char *name, double number) {
    return (mcv_attribute){.name = name, .numbers = {number}, .count = 1};
}

/* The means of one replicate, named "replicate 0" …; the caller frees name and image. */
static mcv_result make_replicate(const mcv_film *film, uint32_t replicate, mcv_exr_part *part,
                                 mcv_error *error) {
    char name[32];
    snprintf(name, sizeof name, MCV_PICTURE_REPLICATE, replicate);
    part->name = strdup(name);
    if (!part->name) return mcv_fail(error, MCV_FAILED, "no memory for the replicates");
    MCV_TRY(mcv_image_new(&part->image, film->width, film->height, film->channels, error));
    const size_t count = (size_t)film->width * film->height * film->channels;
    for (size_t i = 0; i < count; ++i)
        part->image.pixels[i] = (float)(film->sums[replicate * count + i] / (double)film->samples);
    return MCV_OK;
}

/* How many samples each pixel has. */
static mcv_result make_samples(const mcv_film *film, mcv_exr_part *part, mcv_error *error) {
    part->name = strdup("samples");
    if (!part->name) return mcv_fail(error, MCV_FAILED, "no memory for the samples");
    MCV_TRY(mcv_image_new(&part->image, film->width, film->height, 1, error));
    for (uint32_t row = 0; row < film->height; ++row)
        for (uint32_t column = 0; column < film->width; ++column)
            part->image.pixels[(size_t)row * film->width + column] =
                (float)mcv_film_samples_at(film, column, row);
    return MCV_OK;
}

static mcv_result write_exr(const mcv_render_files *picture, const mcv_command *command,
                            const mcv_scene *scene, uint32_t sensor,
                            const mcv_render_options *options, const mcv_film *film,
                            const mcv_render_stats *stats, const mcv_exr_part *parts,
                            uint32_t part_count, mcv_error *error) {
    uint64_t hash = 0;
    char hash_text[32];
    MCV_TRY(hash_file(scene->path, &hash, error));
    snprintf(hash_text, sizeof hash_text, "%016" PRIx64, hash);
    char *set = join_set(command);
    if (!set) return mcv_fail(error, MCV_FAILED, "%s: no memory for its header", picture->exr);
    static const char *const precisions[] = {"single", "mixed", "double"};
    const mcv_attribute general[] = {
        text_attribute("mcvisi:version", mcv_version()),
        text_attribute("mcvisi:quantity", picture->quantity),
        text_attribute("mcvisi:unit", picture->unit),
        text_attribute("mcvisi:scene", scene->path),
        text_attribute("mcvisi:sceneFNV1a", hash_text),
        text_attribute("mcvisi:set", set),
        text_attribute("mcvisi:sensor", scene->sensors[sensor].name),
        number_attribute("mcvisi:sensorIndex", sensor),
        text_attribute("mcvisi:sampler",
                       options->sampler == MCV_SAMPLER_RANDOM ? "random" : "sobol"),
        text_attribute("mcvisi:sampling", film->levels ? "adaptive" : "uniform"),
        number_attribute("mcvisi:seed", options->seed),
        number_attribute("mcvisi:replicates", film->replicates),
        number_attribute("mcvisi:firstSample", (double)options->first),
        number_attribute("mcvisi:samplesPerReplicate", (double)film->samples),
        number_attribute("mcvisi:errorFreedom", film->replicates - 1.0),
        number_attribute("mcvisi:depth", options->depth),
        text_attribute("mcvisi:precision", precisions[options->precision]),
        text_attribute("mcvisi:device", stats->device),
        text_attribute("mcvisi:driver", stats->driver),
        text_attribute("mcvisi:features", stats->features),
        number_attribute("mcvisi:lostEnergy", stats->lost_energy),
        number_attribute("mcvisi:nonfinite", (double)stats->nonfinite),
        number_attribute("mcvisi:seconds", stats->seconds_render),
        text_attribute(MCV_CAMERA_MODEL_KEY, parts[0].image.description),
    };
    enum { GENERAL = sizeof general / sizeof general[0] };
    char names[MCV_PICTURE_PARAMETERS][MCV_EXR_ATTRIBUTE_NAME];
    mcv_attribute attributes[GENERAL + MCV_PICTURE_PARAMETERS];
    memcpy(attributes, general, sizeof general);
    const uint32_t count =
        GENERAL + mcv_header_attributes(scene->sensors + sensor, attributes + GENERAL, names);
    const mcv_result result =
        mcv_exr_write(picture->exr, parts, part_count, attributes, count, error);
    free(set);
    return result;
}

mcv_result mcv_render_files_write(const mcv_render_files *picture, const mcv_command *command,
                             const mcv_scene *scene, uint32_t sensor,
                             const mcv_render_options *options, const mcv_film *film,
                             const mcv_render_stats *stats, mcv_preview *preview,
                             mcv_error *error) {
    mcv_exr_part parts[MAX_PARTS] = {{.name = "image"}, {.name = "error"}};
    mcv_result result = mcv_film_develop(film, &parts[0].image, &parts[1].image, error);
    if (result == MCV_OK) result = mcv_header_describe(scene, sensor, &parts[0].image, error);
    /* One replicate has no spread, and so no known error. */
    uint32_t count = film->replicates > 1 ? 2 : 1;
    const uint32_t replicates = command->parts && film->replicates > 1 ? film->replicates : 0;
    for (uint32_t r = 0; r < replicates && result == MCV_OK; ++r)
        result = make_replicate(film, r, &parts[count++], error);
    if (film->levels && result == MCV_OK) result = make_samples(film, &parts[count++], error);
    if (result == MCV_OK)
        result =
            write_exr(picture, command, scene, sensor, options, film, stats, parts, count, error);
    if (result == MCV_OK)
        result =
            mcv_png_write_preview(picture->png, &parts[0].image, picture->unit, preview, error);
    for (uint32_t p = 0; p < MAX_PARTS; ++p) {
        mcv_image_free(&parts[p].image);
        if (p > 1) free((void *)parts[p].name);
    }
    return result;
}
