/* SPDX-License-Identifier: Apache-2.0 */
/* Reads the image of `mcvisi measure`, with the information of its header and of the options. */
#include "analysis/channel.h"
#include "analysis/render_error.h"
#include "verbs/measure.h"
#include "io/exr.h"
#include "scene/sensor_find.h"
#include "scene/sensors.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* Takes over the model's information if the model belongs to the image. */
static void take_model(mcv_subject *s, mcv_camera_model *model) {
    const mcv_image *values = &s->readings.values;
    mcv_camera_model_free(&s->model);
    s->model = *model;
    s->has_model = mcv_camera_model_fit(&s->model, values->width, values->height);
    for (int i = 0; i < 2; ++i)
        s->pixel[i] = s->has_model && s->model.macro[0] * s->model.macro[1] == 1
                          ? s->model.object_pixel[i]
                          : 0;
}

static mcv_result read_model(const char *text, const char *path, mcv_subject *s, mcv_error *error) {
    mcv_camera_model model;
    bool is_one;
    MCV_TRY(mcv_camera_model_read(text, path, &model, &is_one, error));
    if (!is_one) return MCV_OK;
    take_model(s, &model);
    if (s->has_model && isfinite(s->model.bits)) s->largest = exp2(s->model.bits) - 1;
    return MCV_OK;
}

/* The part of the standard errors that is the render's own: of light all, of grey values that
 * beside the camera's noise. NULL where the file does not tell. */
static const mcv_image *render_error_of(const mcv_exr *exr) {
    const mcv_attribute *quantity = mcv_exr_attribute(exr, "mcvisi:quantity");
    const bool grey = quantity && quantity->text && strcmp(quantity->text, "grey value") == 0;
    return grey ? mcv_exr_image(exr, MCV_EXR_RENDER_ERROR) : quantity ? mcv_exr_error(exr) : NULL;
}

static mcv_result read_errors(const char *path, const mcv_exr *exr, mcv_subject *s,
                              mcv_error *error) {
    const double *rho = mcv_exr_numbers(exr, MCV_EXR_CORRELATION, 4),
                 *freedom = mcv_exr_numbers(exr, "mcvisi:errorFreedom", 1),
                 shared = mcv_exr_channel_correlation(exr);
    const mcv_image *deviation = mcv_exr_error(exr), *render = render_error_of(exr);
    mcv_readings *r = &s->readings;
    if (rho) r->correlation = (mcv_correlation){rho[0], rho[1], rho[2], rho[3]};
    r->render_freedom = freedom ? *freedom : 0;
    if (render)
        MCV_TRY(mcv_choose_errors(s->command->channel, path, render, render, shared, &r->render,
                                  error));
    if (!deviation) return MCV_OK;
    s->noise = "the image's standard errors";
    return mcv_choose_errors(s->command->channel, path, deviation, render, shared, &r->deviation,
                             error);
}

static mcv_result read_exr(const mcv_picture *picture, mcv_subject *s, mcv_error *error) {
    const mcv_exr *exr = &picture->exr;
    const char *path = picture->path;
    const mcv_attribute *unit = mcv_exr_attribute(exr, "mcvisi:unit");
    const double *bits = mcv_exr_numbers(exr, "mcvisi:bits", 1);
    snprintf(s->unit, sizeof s->unit, "%s", unit && unit->text ? unit->text : "");
    s->largest = bits ? exp2(*bits) - 1 : NAN;
    const mcv_attribute *model = mcv_exr_attribute(exr, MCV_CAMERA_MODEL_KEY);
    s->averaged = s->command->channel ? 1 : exr->parts[0].image.channels;
    MCV_TRY(mcv_choose_channel(s->command->channel, path, &exr->parts[0].image, &s->readings.values,
                               error));
    MCV_TRY(read_model(model ? model->text : NULL, path, s, error));
    return read_errors(path, exr, s, error);
}

/* The render's error from the header, which has it by cells. A cell's mean is over many pixels, so
 * its square is hardly too large. */
static mcv_result read_told_error(const char *path, const mcv_image *image, mcv_subject *s,
                                  mcv_error *error) {
    const mcv_render_error *told = &s->model.render_error;
    mcv_image errors;
    if (!s->has_model || !told->items || told->channels != image->channels) return MCV_OK;
    MCV_TRY(mcv_render_error_image(told, image, &errors, error));
    const mcv_result result = mcv_choose_errors(s->command->channel, path, &errors, &errors,
                                                told->shared, &s->readings.render, error);
    mcv_image_free(&errors);
    s->readings.correlation =
        (mcv_correlation){told->correlation[0], told->correlation[1], told->correlation[2], 0};
    s->readings.render_freedom = told->freedom;
    return result;
}

static mcv_result read_values(const mcv_picture *picture, mcv_subject *s, mcv_error *error) {
    const mcv_image *image = &picture->exr.parts[0].image;
    s->averaged = s->command->channel ? 1 : image->channels;
    MCV_TRY(
        mcv_choose_channel(s->command->channel, picture->path, image, &s->readings.values, error));
    MCV_TRY(read_model(image->description, picture->path, s, error));
    MCV_TRY(read_told_error(picture->path, image, s, error));
    s->whole = true;
    for (size_t i = 0; s->whole && i < (size_t)s->readings.values.width * s->readings.values.height;
         ++i)
        s->whole = s->readings.values.pixels[i] == floorf(s->readings.values.pixels[i]);
    snprintf(s->unit, sizeof s->unit, "DN");
    return MCV_OK;
}

/* The user's statement of the noise has precedence over the file's. The camera's noise does not
 * include the render's error. */
static void set_noise(mcv_subject *s) {
    const mcv_command *c = s->command;
    if (!(c->noise > 0) && !(c->gain > 0)) return;
    s->noise = c->noise > 0 ? "--noise" : "the camera's gain and read noise";
    if (c->noise > 0) mcv_image_free(&s->readings.render);
    for (size_t i = 0; i < (size_t)s->readings.values.width * s->readings.values.height; ++i) {
        const double electrons =
            fmax(0, s->readings.values.pixels[i] - (double)c->black_level) / fmax(c->gain, 1e-300);
        const double variance =
            (c->gain * c->gain * (electrons + c->read_noise * c->read_noise) + 1.0 / 12) /
            s->averaged;
        const double render = s->readings.render.pixels ? s->readings.render.pixels[i] : 0;
        s->readings.deviation.pixels[i] =
            (float)(c->noise > 0 ? c->noise : sqrt(variance + render * render));
    }
}

mcv_result mcv_subject_read(const mcv_command *command, const mcv_picture *picture, mcv_subject *s,
                            mcv_error *error) {
    *s = (mcv_subject){.command = command, .picture = picture, .largest = NAN};
    MCV_TRY(picture->values ? read_values(picture, s, error) : read_exr(picture, s, error));
    const mcv_image *values = &s->readings.values;
    if (!s->readings.deviation.pixels)
        MCV_TRY(mcv_image_new(&s->readings.deviation, values->width, values->height, 1, error));
    set_noise(s);
    return MCV_OK;
}

void mcv_subject_free(mcv_subject *s) {
    mcv_image_free(&s->readings.values);
    mcv_image_free(&s->readings.deviation);
    mcv_image_free(&s->readings.render);
    mcv_camera_model_free(&s->model);
    mcv_roi_free(&s->background);
    for (size_t i = 0; i < s->region_count; ++i) mcv_roi_free(s->regions + i);
}

mcv_result mcv_subject_subtract(mcv_subject *s, mcv_error *error) {
    mcv_subject other;
    mcv_image *v = &s->readings.values;
    mcv_result result = mcv_subject_read(s->command, s->minus, &other, error);
    if (result == MCV_OK &&
        (other.readings.values.width != v->width || other.readings.values.height != v->height))
        result = mcv_fail(error, MCV_BAD_INPUT,
                          "%s has %u x %u pixels: it must have the %u x %u of the image",
                          s->minus->path, other.readings.values.width, other.readings.values.height,
                          v->width, v->height);
    const bool both = s->readings.render.pixels && other.readings.render.pixels;
    for (size_t i = 0; result == MCV_OK && i < (size_t)v->width * v->height; ++i) {
        v->pixels[i] -= other.readings.values.pixels[i];
        s->readings.deviation.pixels[i] =
            hypotf(s->readings.deviation.pixels[i], other.readings.deviation.pixels[i]);
        if (both)
            s->readings.render.pixels[i] =
                hypotf(s->readings.render.pixels[i], other.readings.render.pixels[i]);
    }
    if (!both) mcv_image_free(&s->readings.render);
    if (!other.noise) s->noise = NULL;
    mcv_subject_free(&other);
    return result;
}

/* Has the image the film of this sensor, with another number of pixels? Its header tells; both
 * sides are products of the same three numbers, so that they differ by roundings alone. */
static bool was_resized(const mcv_subject *s, const mcv_camera_model *scene) {
    const mcv_camera_model *image = &s->model;
    bool same = s->has_model && image->telecentric == scene->telecentric &&
                memcmp(image->size, scene->size, sizeof image->size) != 0;
    for (int i = 0; same && i < 2; ++i) {
        const double a = image->pixel[i] * image->size[i] / image->macro[i],
                     b = scene->pixel[i] * scene->size[i] / scene->macro[i];
        same = image->macro[i] == scene->macro[i] && fabs(a - b) <= 1e-12 * b;
    }
    return same;
}

/* The model of the scene's sensor, with as many pixels as --resolution gave the image. */
static mcv_result model_of_scene(const mcv_subject *s, const mcv_sensor *sensor,
                                 mcv_camera_model *model, mcv_error *error) {
    mcv_sensor resized = *sensor;
    mcv_error none;
    MCV_TRY(mcv_camera_model_of(s->scene, sensor, model, error));
    if (!was_resized(s, model)) return MCV_OK;
    const uint32_t size[2] = {s->model.size[0] / model->macro[0],
                              s->model.size[1] / model->macro[1]};
    /* A sensor with a region of interest cannot be: the sizes then have another reason. */
    if (mcv_sensor_resize(&resized, size[0], size[1], s->scene, &none) != MCV_OK) return MCV_OK;
    mcv_camera_model_free(model);
    return mcv_camera_model_of(s->scene, &resized, model, error);
}

mcv_result mcv_subject_scale_by_scene(mcv_subject *s, mcv_error *error) {
    const mcv_command *c = s->command;
    uint32_t width, height;
    mcv_camera_model model;
    if (s->scene->sensor_count == 0)
        return mcv_fail(error, MCV_BAD_INPUT, "%s: the scene has no sensor", s->scene->path);
    if (c->sensor) MCV_TRY(mcv_sensor_find(s->scene, c->sensor, &s->sensor, error));
    const mcv_sensor *sensor = s->scene->sensors + s->sensor;
    mcv_sensor_film_size(sensor, &width, &height);
    MCV_TRY(model_of_scene(s, sensor, &model, error));
    take_model(s, &model);
    if (!s->has_model)
        return mcv_fail(
            error, MCV_BAD_INPUT,
            "%s has %u x %u pixels, but sensor %s of %s %u x %u, and no header tells that "
            "--resolution changed them: take an image of this sensor",
            s->picture->path, s->readings.values.width, s->readings.values.height, sensor->name,
            s->scene->path, width, height);
    if (!(mcv_sensor_optics(sensor).magnification > 0))
        return mcv_fail(error, MCV_BAD_INPUT, "%s: sensor %s has no plane in focus to measure in",
                        s->scene->path, sensor->name);
    return MCV_OK;
}
