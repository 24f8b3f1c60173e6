/* SPDX-License-Identifier: Apache-2.0 */
/* From a film to a picture, with what is needed to repeat the render. */
#include "verbs/render_picture.h"

#include "io/exr_make.h"
#include "io/picture_header.h"
#include "analysis/read_speckle.h"
#include "scene/camera_model.h"
#include "scene/laser.h"
#include "scene/sensor_find.h"
#include "verbs/surface_part.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

const char *mcv_rendered_quantity(const mcv_scene *scene, uint32_t sensor) {
    return mcv_sensor_measures_irradiance(scene->sensors + sensor) ? "irradiance" : "radiance";
}

const char *mcv_rendered_unit(const mcv_scene *scene, uint32_t sensor) {
    return mcv_sensor_measures_irradiance(scene->sensors + sensor) ? "W/m^2" : "W/(m^2 sr)";
}

/* --- parts --- */

/* The means of one replicate, named "replicate 0" …. */
static mcv_result add_replicate(const mcv_film *film, uint32_t replicate, mcv_exr *exr,
                                mcv_error *error) {
    char name[32];
    mcv_image image;
    snprintf(name, sizeof name, MCV_PICTURE_REPLICATE, replicate);
    MCV_TRY(mcv_image_new(&image, film->width, film->height, film->channels, error));
    const size_t count = (size_t)film->width * film->height * film->channels;
    for (size_t i = 0; i < count; ++i)
        image.pixels[i] = (float)(film->sums[replicate * count + i] / (double)film->samples);
    return mcv_exr_add_part(exr, name, image, NULL, error);
}

/* The number of samples of each pixel. */
static mcv_result add_samples(const mcv_film *film, mcv_exr *exr, mcv_error *error) {
    mcv_image image;
    MCV_TRY(mcv_image_new(&image, film->width, film->height, 1, error));
    for (uint32_t row = 0; row < film->height; ++row)
        for (uint32_t column = 0; column < film->width; ++column)
            image.pixels[(size_t)row * film->width + column] =
                (float)mcv_film_samples_at(film, column, row);
    return mcv_exr_add_part(exr, "samples", image, NULL, error);
}

mcv_result mcv_film_parts(const mcv_film *film, bool replicates, mcv_exr *exr, mcv_error *error) {
    mcv_image mean, deviation = {0};
    /* One replicate has no spread, so its error is not known. */
    const bool several = film->replicates > 1;
    MCV_TRY(mcv_film_develop(film, &mean, several ? &deviation : NULL, error));
    const mcv_result added = mcv_exr_add_part(exr, "image", mean, NULL, error);
    if (added != MCV_OK) mcv_image_free(&deviation);
    MCV_TRY(added);
    if (several) MCV_TRY(mcv_exr_add_part(exr, "error", deviation, NULL, error));
    for (uint32_t k = 0; k < film->replicates && several && replicates; ++k)
        MCV_TRY(add_replicate(film, k, exr, error));
    return film->levels ? add_samples(film, exr, error) : MCV_OK;
}

static mcv_result add_parts(const mcv_rendered *r, mcv_exr *exr, mcv_error *error) {
    MCV_TRY(mcv_film_parts(r->film, r->replicates, exr, error));
    if (r->subpixels) MCV_TRY(mcv_surface_part_of(r->scene, r->sensor, r->subpixels, exr, error));
    return mcv_header_describe(r->scene, r->sensor, &exr->parts[0].image, error);
}

/* --- attributes --- */

/* All that was set, one a line. The caller frees it. */
static char *join(mcv_overrides set) {
    size_t length = 1;
    for (size_t i = 0; i < set.count; ++i) length += strlen(set.items[i]) + 1;
    char *text = calloc(1, length), *end = text;
    for (size_t i = 0; text && i < set.count; ++i) {
        if (i) *end++ = '\n';
        end = stpcpy(end, set.items[i]);
    }
    return text;
}

static mcv_attribute text_attribute(const char *name, const char *text) {
    return (mcv_attribute){.name = name, .text = text};
}

static mcv_attribute number_attribute(const char *name, double number) {
    return (mcv_attribute){.name = name, .numbers = {number}, .count = 1};
}

/* The cells of an aperture's mask. */
static mcv_result add_mask(const mcv_sensor *sensor, mcv_exr *exr, mcv_error *error) {
    bool has_mask;
    char *mask = mcv_header_mask(sensor, &has_mask);
    const mcv_attribute cells = text_attribute(MCV_PICTURE_MASK, mask);
    const mcv_result masked = mask ? mcv_exr_set_attributes(exr, &cells, 1, error)
                              : has_mask
                                  ? mcv_fail(error, MCV_FAILED, "no memory for an image's header")
                                  : MCV_OK;
    free(mask);
    return masked;
}

static mcv_result add_attributes(const mcv_rendered *r, mcv_exr *exr, const char *set,
                                 mcv_error *error) {
    static const char *const precisions[] = {"single", "mixed", "double"};
    const mcv_render_options *options = r->options;
    const mcv_render_stats *stats = r->stats;
    const mcv_film *film = r->film;
    const mcv_sensor *sensor = r->scene->sensors + r->sensor;
    char hash[32], names[MCV_PICTURE_PARAMETERS][MCV_EXR_ATTRIBUTE_NAME];
    mcv_attribute parameters[MCV_PICTURE_PARAMETERS];
    snprintf(hash, sizeof hash, "%016" PRIx64, r->hash);
    const mcv_attribute general[] = {
        text_attribute("mcvisi:version", mcv_version()),
        text_attribute("mcvisi:quantity", mcv_rendered_quantity(r->scene, r->sensor)),
        text_attribute("mcvisi:unit", mcv_rendered_unit(r->scene, r->sensor)),
        text_attribute("mcvisi:scene", r->scene->path),
        text_attribute("mcvisi:sceneFNV1a", hash),
        text_attribute("mcvisi:set", set),
        text_attribute("mcvisi:sensor", sensor->name),
        number_attribute("mcvisi:sensorIndex", r->sensor),
        text_attribute("mcvisi:sampler",
                       options->sampler == MCV_SAMPLER_RANDOM ? "random" : "sobol"),
        text_attribute("mcvisi:sampling", film->levels ? "adaptive" : "uniform"),
        number_attribute("mcvisi:lightPaths", stats->light_paths),
        number_attribute("mcvisi:seed", options->seed),
        number_attribute("mcvisi:replicates", film->replicates),
        number_attribute("mcvisi:firstSample", (double)options->first),
        number_attribute("mcvisi:samplesPerReplicate", (double)film->samples),
        number_attribute("mcvisi:errorFreedom", film->replicates - 1.0),
        number_attribute(MCV_EXR_CHANNELS, mcv_film_channel_correlation(film)),
        number_attribute("mcvisi:depth", options->depth),
        text_attribute("mcvisi:precision", precisions[options->precision]),
        text_attribute("mcvisi:device", stats->device),
        text_attribute("mcvisi:driver", stats->driver),
        text_attribute("mcvisi:features", stats->features),
        number_attribute("mcvisi:lostEnergy", stats->lost_energy),
        number_attribute("mcvisi:nonfinite", (double)stats->nonfinite),
        number_attribute("mcvisi:seconds", stats->seconds_render),
        text_attribute(MCV_CAMERA_MODEL_KEY, exr->parts[0].image.description),
    };
    double wavelength, linewidth;
    const bool is_laser_lit = mcv_scene_is_laser_lit(r->scene, &wavelength, &linewidth);
    const mcv_attribute of_laser[] = {number_attribute(MCV_LASER_WAVELENGTH, wavelength),
                                      number_attribute(MCV_LASER_LINEWIDTH, linewidth)};
    const mcv_attribute interrupted = number_attribute(MCV_PICTURE_INTERRUPTED, 1),
                        render = text_attribute(MCV_PICTURE_RENDER, r->identity);
    MCV_TRY(mcv_exr_set_attributes(exr, general, sizeof general / sizeof general[0], error));
    if (is_laser_lit) MCV_TRY(mcv_exr_set_attributes(exr, of_laser, 2, error));
    if (r->identity[0]) MCV_TRY(mcv_exr_set_attributes(exr, &render, 1, error));
    if (stats->interrupted) MCV_TRY(mcv_exr_set_attributes(exr, &interrupted, 1, error));
    MCV_TRY(add_mask(sensor, exr, error));
    const uint32_t count = mcv_header_attributes(sensor, parameters, names);
    return mcv_exr_set_attributes(exr, parameters, count, error);
}

mcv_result mcv_rendered_develop(const mcv_rendered *r, mcv_exr *exr, mcv_error *error) {
    *exr = (mcv_exr){0};
    char *set = join(r->set);
    mcv_result result =
        set ? add_parts(r, exr, error)
            : mcv_fail(error, MCV_FAILED, "%s: no memory for its header", r->scene->path);
    if (result == MCV_OK) result = add_attributes(r, exr, set, error);
    free(set);
    if (result != MCV_OK) mcv_exr_free(exr);
    return result;
}
