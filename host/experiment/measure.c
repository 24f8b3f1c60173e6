/* SPDX-License-Identifier: Apache-2.0 */
#include "experiment/measure.h"

#include "analysis/channel.h"
#include "analysis/lightfield.h"
#include "analysis/metrics.h"
#include "experiment/expression.h"
#include "experiment/program.h"
#include "experiment/set_image.h"
#include "scene/sensors.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static mcv_result read_metric(const char *item, mcv_measurement *m, mcv_error *error) {
    mcv_metric *metric = m->metrics + m->count;
    const char *assigned = strstr(item, ":=");
    mcv_quantity ignored;
    *metric = (mcv_metric){.expression = assigned ? assigned + 2 : item};
    snprintf(metric->name, sizeof metric->name, "%.*s",
             (int)(assigned ? assigned - item : (long)strlen(item)), item);
    for (size_t i = 0; i < m->count; ++i)
        if (strcmp(m->metrics[i].name, metric->name) == 0)
            return mcv_fail(error, MCV_USAGE, "--metric %s: is given twice", metric->name);
    if (mcv_program_named(metric->expression) && !assigned)
        return mcv_fail(error, MCV_USAGE, "--metric %s: has no name: give NAME:=%s", item, item);
    if (!mcv_program_named(metric->expression))
        MCV_TRY(mcv_expression_evaluate(metric->expression, mcv_metric_known,
                                        (void *)&m->asked->places, &ignored, error));
    ++m->count;
    return MCV_OK;
}

/* The metric of "NAME=…" and what follows; *equals is NULL without "=". */
static mcv_result find_metric(const char *option, const char *item, const mcv_measurement *m,
                              const char **equals, size_t *found, mcv_error *error) {
    *equals = strrchr(item, '=');
    for (*found = 0; *equals && *found < m->count; ++*found) {
        const char *name = m->metrics[*found].name;
        const size_t length = (size_t)(*equals - item);
        if (strlen(name) == length && strncmp(name, item, length) == 0) return MCV_OK;
    }
    return *equals ? mcv_fail(error, MCV_USAGE, "--%s %s: there is no --metric with this name",
                              option, item)
                   : MCV_OK;
}

mcv_result mcv_measurement_read_limit(const char *option, const char *item,
                                      const mcv_measurement *m, size_t *metric, double *limit,
                                      mcv_error *error) {
    const char *equals;
    char *end = NULL;
    MCV_TRY(find_metric(option, item, m, &equals, metric, error));
    *limit = equals ? strtod(equals + 1, &end) : 0;
    if (!equals || end == equals + 1 || *end || !(*limit > 0))
        return mcv_fail(error, MCV_USAGE, "--%s %s: must be NAME=%s above 0", option, item,
                        strcmp(option, "until") == 0 ? "U, a standard uncertainty"
                                                     : "D, a difference");
    return MCV_OK;
}

static mcv_result read_until(const char *item, mcv_measurement *m, mcv_error *error) {
    size_t found = 0;
    double until;
    MCV_TRY(mcv_measurement_read_limit("until", item, m, &found, &until, error));
    if (mcv_program_named(m->metrics[found].expression))
        return mcv_fail(error, MCV_USAGE,
                        "--until %s: a program decides after the render, not while it goes on",
                        item);
    m->metrics[found].until = until;
    return MCV_OK;
}

mcv_result mcv_measurement_read_goal(const char *option, const char *item, const mcv_measurement *m,
                                     size_t *metric, bool *largest, mcv_error *error) {
    const char *equals;
    MCV_TRY(find_metric(option, item, m, &equals, metric, error));
    *largest = equals && strcmp(equals + 1, "largest") == 0;
    return equals && (*largest || strcmp(equals + 1, "smallest") == 0)
               ? MCV_OK
               : mcv_fail(error, MCV_USAGE,
                          "--%s %s: must be NAME=largest or NAME=smallest, a metric's name", option,
                          item);
}

mcv_result mcv_measurement_read(const mcv_measuring *asked, mcv_measurement *m, mcv_error *error) {
    *m = (mcv_measurement){.asked = asked};
    if (asked->metrics.count == 0)
        return mcv_fail(
            error, MCV_USAGE,
            "--metric is missing: give what to measure, as in --metric mean or --metric "
            "dent.contrast_to_noise");
    if (asked->metrics.count > MCV_METRICS)
        return mcv_fail(error, MCV_USAGE, "%zu metrics: at most %d", asked->metrics.count,
                        MCV_METRICS);
    for (size_t i = 0; i < asked->metrics.count; ++i)
        MCV_TRY(read_metric(asked->metrics.items[i], m, error));
    for (size_t i = 0; i < asked->until.count; ++i)
        MCV_TRY(read_until(asked->until.items[i], m, error));
    m->best = m->count;
    return asked->best ? mcv_measurement_read_goal("best", asked->best, m, &m->best,
                                                   &m->best_largest, error)
                       : MCV_OK;
}

/* Values of the gradient, whose uncertainties are not known. */
static mcv_result read_gradient(const mcv_measuring *asked, const mcv_scene *scene, uint32_t sensor,
                                const mcv_image *image, mcv_metrics *m, mcv_error *error) {
    const mcv_readout readout = mcv_sensor_readout(scene->sensors + sensor);
    mcv_image gradient;
    if (readout.angular[0] * readout.angular[1] < 2)
        return mcv_fail(error, MCV_BAD_INPUT,
                        "sensor %s is not a light field camera: leave out --in emd-gradient",
                        scene->sensors[sensor].name);
    MCV_TRY(mcv_light_field_gradient(image, readout.angular, asked->form, asked->threads, &gradient,
                                     error));
    const mcv_result result =
        mcv_choose_channel(0, scene->path, &gradient, &m->readings.values, error);
    mcv_image_free(&gradient);
    MCV_TRY(result);
    m->known = m->whole = false;
    return mcv_image_new(&m->readings.deviation, m->readings.values.width,
                         m->readings.values.height, 1, error);
}

/* Values and deviations of one channel. `shared`: what mcv_choose_errors takes. */
static mcv_result read_channel(const mcv_measuring *asked, const char *path, const mcv_image *image,
                               const mcv_image *deviation, const mcv_image *render, double shared,
                               mcv_metrics *m, mcv_error *error) {
    mcv_readings *r = &m->readings;
    const mcv_image *own = render->pixels ? render : NULL;
    MCV_TRY(mcv_choose_channel(asked->channel, path, image, &r->values, error));
    if (own) MCV_TRY(mcv_choose_errors(asked->channel, path, own, own, shared, &r->render, error));
    if (m->known)
        return mcv_choose_errors(asked->channel, path, deviation, own, shared, &r->deviation,
                                 error);
    return mcv_image_new(&r->deviation, image->width, image->height, 1, error);
}

static mcv_result take_readings(const mcv_measuring *asked, const mcv_scene *scene, uint32_t sensor,
                                const mcv_film *film, mcv_metrics *m, mcv_error *error) {
    mcv_set_image light;
    mcv_read_out out = {.level = NAN};
    *m = (mcv_metrics){.known = film->replicates > 1};
    m->readings.render_freedom = film->replicates - 1.0;
    mcv_result result = mcv_set_image_develop(scene, sensor, film, &light, error);
    const mcv_image *image = &light.parts[0].image, *deviation = &light.parts[1].image,
                    *light_error = deviation;
    if (result == MCV_OK && mcv_camera_wanted(&asked->camera)) {
        result = mcv_camera_read_out(&asked->camera, scene->path, &light.exr, &out, error);
        m->readings.correlation = out.correlation;
        image = &out.exposure.grey;
        deviation = &out.exposure.uncertainty;
        light_error = &out.exposure.render;
        m->known = m->whole = true;
    }
    if (result == MCV_OK)
        result = asked->in_gradient
                     ? read_gradient(asked, scene, sensor, image, m, error)
                     : read_channel(asked, scene->path, image, deviation, light_error,
                                    mcv_exr_channel_correlation(&light.exr), m, error);
    mcv_exposure_free(&out.exposure);
    mcv_set_image_free(&light);
    return result;
}

/* The scale of the image, and the places to measure in pixels. */
static mcv_result find_places(const mcv_measuring *asked, const mcv_scene *scene, uint32_t sensor,
                              mcv_metrics *m, mcv_places *resolved, mcv_error *error) {
    mcv_camera_model model;
    MCV_TRY(mcv_camera_model_of(scene, scene->sensors + sensor, &model, error));
    const bool fits =
        mcv_camera_model_fit(&model, m->readings.values.width, m->readings.values.height);
    for (int i = 0; i < 2 && fits && model.macro[0] * model.macro[1] == 1; ++i)
        m->pixel[i] = model.object_pixel[i];
    const mcv_result result =
        mcv_places_resolve(&asked->places, fits ? &model : NULL, resolved, error);
    mcv_camera_model_free(&model);
    m->places = resolved;
    return result;
}

mcv_result mcv_measurement_take(const mcv_measurement *measurement, const mcv_scene *scene,
                                uint32_t sensor, const mcv_film *film, const mcv_film *stepped,
                                double *numbers, mcv_error *error) {
    const mcv_measuring *asked = measurement->asked;
    mcv_metrics m;
    mcv_places resolved = {.background = NULL};
    mcv_result result = take_readings(asked, scene, sensor, film, &m, error);
    if (result == MCV_OK) result = find_places(asked, scene, sensor, &m, &resolved, error);
    mcv_light_pairs pairs = {.lens = ""};
    if (result == MCV_OK && stepped)
        result = mcv_bound_pairs(&asked->camera, scene, sensor, film, stepped, &pairs, error);
    m.pairs = &pairs;
    m.step = measurement->bound.step;
    const bool taken = result == MCV_OK;
    for (size_t i = 0; i < measurement->count; ++i) {
        mcv_quantity value = {NAN, NAN};
        mcv_error why = {""};
        numbers[2 * i] = numbers[2 * i + 1] = NAN;
        if (mcv_program_named(measurement->metrics[i].expression)) continue;
        const mcv_result one = taken ? mcv_expression_evaluate(measurement->metrics[i].expression,
                                                               mcv_metric_look_up, &m, &value, &why)
                                     : MCV_FAILED;
        numbers[2 * i] = one == MCV_OK ? value.value : NAN;
        numbers[2 * i + 1] = one == MCV_OK ? value.uncertainty : NAN;
        if (one != MCV_OK && result == MCV_OK) result = mcv_fail(error, one, "%s", why.text);
    }
    mcv_light_pairs_free(&pairs);
    mcv_places_free(&resolved);
    mcv_image_free(&m.readings.values);
    mcv_image_free(&m.readings.deviation);
    mcv_image_free(&m.readings.render);
    return result;
}

bool mcv_measurement_suffices(const mcv_measurement *measurement, const mcv_scene *scene,
                              uint32_t sensor, const mcv_film *film) {
    double numbers[2 * MCV_METRICS];
    mcv_error ignored;
    if (mcv_measurement_take(measurement, scene, sensor, film, NULL, numbers, &ignored) != MCV_OK)
        return false;
    for (size_t i = 0; i < measurement->count; ++i)
        if (measurement->metrics[i].until > 0 &&
            !(numbers[2 * i + 1] <= measurement->metrics[i].until))
            return false;
    return true;
}
