/* SPDX-License-Identifier: Apache-2.0 */
/* mcvisi measure: figures of regions of an image, and of the edges, lines, widths and circles in
 * it. */
#include "check/growth.h"
#include "analysis/render_error.h"
#include "cli/metrics.h"
#include "cli/options.h"
#include "cli/places.h"
#include "cli/report.h"
#include "cli/sensor.h"
#include "core/basics.h"
#include "io/png.h"
#include "io/exr.h"
#include "core/output_file.h"
#include "io/grid.h"
#include "io/values.h"
#include "scene/sensors.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* The image, and what is known of it. */
typedef struct subject {
    const mcv_command *command;
    mcv_readings readings;
    const char *noise; /* where the deviations come from; NULL: nowhere yet */
    bool whole;        /* a file of whole numbers */
    double largest;    /* grey value, NaN where that is not known */
    double pixel[2];   /* width and height in the object plane [m], 0: not known */
    mcv_camera_model model;
    bool has_model;
    char unit[64];
    mcv_roi *regions, background; /* background.inside: NULL without one */
    size_t region_count;
    mcv_scene *scene; /* of --scene, or NULL */
    uint32_t sensor;
    mcv_found *found; /* in the boxes of all forms, one form after the other */
    size_t found_count;
} subject;

/* --- reading
 * ----------------------------------------------------------------------------------------------------
 */

/* What the model tells of the image, if it is its model. */
static void take_model(subject *s, mcv_camera_model *model) {
    const mcv_image *values = &s->readings.values;
    mcv_camera_model_free(&s->model);
    s->model = *model;
    s->has_model = mcv_camera_model_fit(&s->model, values->width, values->height);
    for (int i = 0; i < 2; ++i)
        s->pixel[i] = s->has_model && s->model.macro[0] * s->model.macro[1] == 1
                          ? s->model.object_pixel[i]
                          : 0;
}

static mcv_result read_model(const char *text, const char *path, subject *s, mcv_error *error) {
    mcv_camera_model model;
    bool is_one;
    MCV_TRY(mcv_camera_model_read(text, path, &model, &is_one, error));
    if (!is_one) return MCV_OK;
    take_model(s, &model);
    if (s->has_model && isfinite(s->model.bits)) s->largest = exp2(s->model.bits) - 1;
    return MCV_OK;
}

/* All that a render does not know is its own error; grey values have that apart from the camera's
 * noise. */
static mcv_result read_render_error(const char *path, const mcv_exr *exr, subject *s,
                                    mcv_error *error) {
    const double *rho = mcv_exr_numbers(exr, MCV_EXR_CORRELATION, 4),
                 *freedom = mcv_exr_numbers(exr, "mcvisi:errorFreedom", 1);
    const mcv_attribute *quantity = mcv_exr_attribute(exr, "mcvisi:quantity");
    const bool grey = quantity && quantity->text && strcmp(quantity->text, "grey value") == 0;
    const mcv_image *render = grey ? mcv_exr_image(exr, MCV_EXR_RENDER_ERROR) : mcv_exr_error(exr);
    if (rho) s->readings.correlation = (mcv_correlation){rho[0], rho[1], rho[2], rho[3]};
    s->readings.render_freedom = freedom ? *freedom : 0;
    if (!render || (!grey && !quantity)) return MCV_OK;
    return mcv_choose_channel(s->command->channel, path, render, true, &s->readings.render, error);
}

static mcv_result read_exr(const char *path, subject *s, mcv_error *error) {
    mcv_exr exr;
    MCV_TRY(mcv_exr_read(path, &exr, error));
    const mcv_image *image = &exr.parts[0].image;
    const mcv_attribute *unit = mcv_exr_attribute(&exr, "mcvisi:unit");
    const double *bits = mcv_exr_numbers(&exr, "mcvisi:bits", 1);
    snprintf(s->unit, sizeof s->unit, "%s", unit && unit->text ? unit->text : "");
    s->largest = bits ? exp2(*bits) - 1 : NAN;
    const mcv_attribute *model = mcv_exr_attribute(&exr, MCV_CAMERA_MODEL_KEY);
    mcv_result result =
        mcv_choose_channel(s->command->channel, path, image, false, &s->readings.values, error);
    if (result == MCV_OK) result = read_model(model ? model->text : NULL, path, s, error);
    const mcv_image *deviation = mcv_exr_error(&exr);
    if (result == MCV_OK && deviation) {
        result = mcv_choose_channel(s->command->channel, path, deviation, true,
                                    &s->readings.deviation, error);
        s->noise = "the image's standard errors";
    }
    if (result == MCV_OK) result = read_render_error(path, &exr, s, error);
    mcv_exr_free(&exr);
    return result;
}

/* The render's error as the header tells it by cells. Their means are of many pixels: squares of
 * them are hardly too large. */
static mcv_result read_told_error(const char *path, const mcv_image *image, subject *s,
                                  mcv_error *error) {
    const mcv_render_error *told = &s->model.render_error;
    mcv_image errors;
    if (!s->has_model || !told->items || told->channels != image->channels) return MCV_OK;
    MCV_TRY(mcv_render_error_image(told, image, &errors, error));
    const mcv_result result =
        mcv_choose_channel(s->command->channel, path, &errors, true, &s->readings.render, error);
    mcv_image_free(&errors);
    s->readings.correlation =
        (mcv_correlation){told->correlation[0], told->correlation[1], told->correlation[2], 0};
    s->readings.render_freedom = told->freedom;
    return result;
}

static mcv_result read_values(const char *path, subject *s, mcv_error *error) {
    mcv_image image;
    MCV_TRY(mcv_values_read(path, &image, error));
    mcv_result result =
        mcv_choose_channel(s->command->channel, path, &image, false, &s->readings.values, error);
    if (result == MCV_OK) result = read_model(image.description, path, s, error);
    if (result == MCV_OK) result = read_told_error(path, &image, s, error);
    mcv_image_free(&image);
    s->whole = true;
    for (size_t i = 0; result == MCV_OK && s->whole &&
                       i < (size_t)s->readings.values.width * s->readings.values.height;
         ++i)
        s->whole = s->readings.values.pixels[i] == floorf(s->readings.values.pixels[i]);
    snprintf(s->unit, sizeof s->unit, "DN");
    return result;
}

/* What the user says of the noise stands above what the file says; of the camera's, it says nothing
 * of the render's error. */
static void set_noise(subject *s) {
    const mcv_command *c = s->command;
    if (!(c->noise > 0) && !(c->gain > 0)) return;
    s->noise = c->noise > 0 ? "--noise" : "the camera's gain and read noise";
    if (c->noise > 0) mcv_image_free(&s->readings.render);
    for (size_t i = 0; i < (size_t)s->readings.values.width * s->readings.values.height; ++i) {
        const double electrons =
            fmax(0, s->readings.values.pixels[i] - (double)c->black_level) / fmax(c->gain, 1e-300);
        const double variance =
            c->gain * c->gain * (electrons + c->read_noise * c->read_noise) + 1.0 / 12;
        const double render = s->readings.render.pixels ? s->readings.render.pixels[i] : 0;
        s->readings.deviation.pixels[i] =
            (float)(c->noise > 0 ? c->noise : sqrt(variance + render * render));
    }
}

static mcv_result read_subject(const mcv_command *command, const char *path, subject *s,
                               mcv_error *error) {
    *s = (subject){.command = command, .largest = NAN};
    MCV_TRY(mcv_ends_in(path, ".exr") ? read_exr(path, s, error) : read_values(path, s, error));
    const mcv_image *values = &s->readings.values;
    if (!s->readings.deviation.pixels)
        MCV_TRY(mcv_image_new(&s->readings.deviation, values->width, values->height, 1, error));
    set_noise(s);
    return MCV_OK;
}

static void free_subject(subject *s) {
    mcv_image_free(&s->readings.values);
    mcv_image_free(&s->readings.deviation);
    mcv_image_free(&s->readings.render);
    mcv_camera_model_free(&s->model);
    mcv_roi_free(&s->background);
    for (size_t i = 0; i < s->region_count; ++i) mcv_roi_free(s->regions + i);
    mcv_scene_free(s->scene);
}

static mcv_result subtract(subject *s, mcv_error *error) {
    subject other;
    mcv_image *v = &s->readings.values;
    mcv_result result = read_subject(s->command, s->command->minus, &other, error);
    if (result == MCV_OK &&
        (other.readings.values.width != v->width || other.readings.values.height != v->height))
        result = mcv_fail(error, MCV_BAD_INPUT,
                          "%s has %u x %u pixels: it must have the %u x %u of the image",
                          s->command->minus, other.readings.values.width,
                          other.readings.values.height, v->width, v->height);
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
    free_subject(&other);
    return result;
}

static mcv_result scale_by_scene(subject *s, mcv_error *error) {
    const mcv_command *c = s->command;
    uint32_t width, height;
    mcv_camera_model model;
    MCV_TRY(
        mcv_scene_load(c->scene, (mcv_overrides){c->set.items, c->set.count}, &s->scene, error));
    if (s->scene->sensor_count == 0)
        return mcv_fail(error, MCV_BAD_INPUT, "%s: the scene has no sensor", c->scene);
    if (c->sensor) MCV_TRY(mcv_sensor_find(s->scene, c->sensor, &s->sensor, error));
    const mcv_sensor *sensor = s->scene->sensors + s->sensor;
    mcv_sensor_film_size(sensor, &width, &height);
    MCV_TRY(mcv_camera_model_of(s->scene, sensor, &model, error));
    take_model(s, &model);
    if (!s->has_model)
        return mcv_fail(error, MCV_BAD_INPUT, "%s has %u x %u pixels, but sensor %s of %s %u x %u",
                        c->argument, s->readings.values.width, s->readings.values.height,
                        sensor->name, c->scene, width, height);
    if (!(mcv_sensor_optics(sensor).magnification > 0))
        return mcv_fail(error, MCV_BAD_INPUT, "%s: sensor %s has no plane in focus to measure in",
                        c->scene, sensor->name);
    return MCV_OK;
}

/* --- regions
 * ----------------------------------------------------------------------------------------------------
 */

static void put(mcv_report *report, const char *key, const char *unit, mcv_quantity q) {
    mcv_report_quantity(report, key, unit, q.value, q.uncertainty);
}

static void know_noise(subject *s, mcv_roi *region) {
    mcv_know_noise(&s->readings, s->noise, s->whole, region);
}

/* Why the ratio is missing. */
static void explain(mcv_report *report, const char *key, double samples) {
    char words[160];
    mcv_samples_words(samples, words);
    if (samples > 0) mcv_report_text(report, key, words);
}

static void report_region(subject *s, mcv_report *report, mcv_roi *region, mcv_roi *background) {
    uint64_t saturated = 0;
    for (size_t i = 0; i < (size_t)region->width * region->height; ++i)
        saturated += region->inside[i] && (double)s->readings.values.pixels[i] >= s->largest;
    if (background) know_noise(s, background);
    know_noise(s, region);
    const mcv_roi_figures f = mcv_roi_measure(&s->readings, region);
    mcv_report_element(report, region->name, "region");
    mcv_report_number(report, "pixels", "", (double)f.count);
    put(report, "mean", s->unit, f.mean);
    put(report, "deviation", s->unit, f.deviation);
    mcv_report_number(report, "noise", s->unit, f.noise);
    if (s->readings.render.pixels)
        mcv_report_number(report, "render_noise", s->unit, f.render_noise);
    mcv_report_number(report, "smallest", s->unit, f.smallest);
    mcv_report_number(report, "largest", s->unit, f.largest);
    if (isfinite(s->largest))
        mcv_report_number(report, "saturated", "", (double)saturated / (double)f.count);
    put(report, "snr", "", f.snr);
    explain(report, "no_snr", f.samples);
    put(report, "rms_contrast", "", f.rms_contrast);
    put(report, "uniformity", "", f.uniformity);
    if (background) {
        const mcv_contrast_figures c = mcv_roi_contrast(&s->readings, region, background);
        put(report, "difference", s->unit, c.difference);
        put(report, "weber_contrast", "", c.weber);
        put(report, "michelson_contrast", "", c.michelson);
        put(report, "contrast_to_noise", "", c.contrast_to_noise);
        explain(report, "no_contrast_to_noise", c.samples);
    }
    mcv_report_close(report);
}

static size_t count_boxes(const mcv_command *command) {
    size_t count = 0;
    for (unsigned f = 0; f < MCV_FORM_COUNT; ++f) count += mcv_form_boxes(command, f)->count;
    return count;
}

/* The whole image where no region is named and no box either. */
static mcv_result parse_regions(subject *s, mcv_error *error) {
    const mcv_command *c = s->command;
    const mcv_image *image = &s->readings.values;
    char all[64];
    const char *whole = all;
    snprintf(all, sizeof all, "image=0,0,%u,%u", image->width, image->height);
    const size_t count = c->region.count                    ? c->region.count
                         : count_boxes(c) && !c->background ? 0
                                                            : 1;
    const char *const *texts = c->region.count ? c->region.items : &whole;
    if (c->background) MCV_TRY(mcv_roi_parse(c->background, 0, image, &s->background, error));
    for (; s->region_count < count; ++s->region_count)
        MCV_TRY(mcv_roi_parse(texts[s->region_count], s->region_count + 1, image,
                              s->regions + s->region_count, error));
    return MCV_OK;
}

static void report_regions(subject *s, mcv_report *report) {
    if (s->region_count == 0) return;
    mcv_report_list(report, "regions");
    for (size_t i = 0; i < s->region_count; ++i)
        report_region(s, report, s->regions + i, s->background.inside ? &s->background : NULL);
    mcv_report_close(report);
}

/* --- boxes
 * ------------------------------------------------------------------------------------------------------
 */

static void report_values(mcv_report *report, const char *key, const mcv_quantity *q, size_t count,
                          bool uncertainties) {
    double *values = malloc(count * sizeof *values);
    for (size_t i = 0; values && i < count; ++i)
        values[i] = uncertainties ? q[i].uncertainty : q[i].value;
    if (values) mcv_report_numbers(report, key, "", "", values, count);
    free(values);
}

/* The curves are for programs. */
static void report_spread(const subject *s, mcv_report *report, const mcv_edge *edge) {
    mcv_edge_mtf m;
    mcv_error why = {""};
    if (mcv_edge_spread(&s->readings, edge, &m, &why) != MCV_OK) {
        mcv_report_text(report, "no_mtf", why.text);
        return;
    }
    put(report, "mtf50", "cycles/pixel", m.mtf50);
    put(report, "mtf_at_nyquist", "", m.nyquist);
    if (report->json) {
        mcv_report_numbers(report, "frequency", "", "", m.frequency, MCV_MTF_COUNT);
        report_values(report, "mtf", m.modulation, MCV_MTF_COUNT, false);
        report_values(report, "mtf_uncertainty", m.modulation, MCV_MTF_COUNT, true);
        mcv_report_numbers(report, "place", "", "", m.place, m.count);
        report_values(report, "esf", m.esf, m.count, false);
        report_values(report, "esf_uncertainty", m.esf, m.count, true);
        mcv_report_numbers(report, "lsf", "", "", m.lsf, m.count);
    }
    mcv_edge_mtf_free(&m);
}

static void put_length(mcv_report *report, const char *key, mcv_quantity pixels, double scale) {
    mcv_report_quantity(report, key, "m", pixels.value * scale, pixels.uncertainty * scale);
}

static void report_edge(const subject *s, mcv_report *report, const mcv_edge *edge) {
    mcv_report_element(report, edge->name, "edge");
    mcv_report_numbers(report, "point", "pixels", ", ", edge->point, 2);
    put(report, edge->across_rows ? "column" : "row", "pixels", edge->position);
    put(report, "tilt", "rad", edge->tilt);
    put(report, "dark", s->unit, edge->dark);
    put(report, "bright", s->unit, edge->bright);
    put(report, "width_10_90", "pixels", edge->width_10_90);
    put_length(report, "width_10_90_length", edge->width_10_90,
               mcv_scale_along(s->pixel, edge->normal));
    put(report, "sagitta", "pixels", edge->sagitta);
    report_spread(s, report, edge);
    mcv_report_close(report);
}

static void report_line(const subject *s, mcv_report *report, const mcv_line *line) {
    const mcv_edge *edge = &line->edge;
    mcv_report_element(report, edge->name, "line");
    mcv_report_numbers(report, "point", "pixels", ", ", edge->point, 2);
    put(report, edge->across_rows ? "column" : "row", "pixels", edge->position);
    put(report, "tilt", "rad", edge->tilt);
    put(report, "straightness", "pixels", line->straightness);
    put_length(report, "straightness_length", line->straightness,
               mcv_scale_along(s->pixel, edge->normal));
    mcv_report_close(report);
}

static void report_caliper(const subject *s, mcv_report *report, const mcv_caliper *caliper) {
    const mcv_edge *first = caliper->edges, *second = first + 1;
    mcv_report_element(report, caliper->name, "caliper");
    put(report, "width", "pixels", caliper->width);
    put_length(report, "width_length", caliper->width, mcv_scale_along(s->pixel, first->normal));
    put(report, "angle", "rad", caliper->angle);
    put(report, first->across_rows ? "first_column" : "first_row", "pixels", first->position);
    put(report, first->across_rows ? "second_column" : "second_row", "pixels", second->position);
    mcv_report_close(report);
}

static void report_circle(const subject *s, mcv_report *report, const mcv_circle *circle) {
    const double scale = mcv_scale_along(s->pixel, NULL);
    mcv_report_element(report, circle->name, circle->whole ? "circle" : "arc");
    put(report, "column", "pixels", circle->column);
    put(report, "row", "pixels", circle->row);
    put(report, "radius", "pixels", circle->radius);
    put_length(report, "radius_length", circle->radius, scale);
    put(report, "diameter", "pixels", circle->diameter);
    put_length(report, "diameter_length", circle->diameter, scale);
    put(report, "roundness", "pixels", circle->roundness);
    put_length(report, "roundness_length", circle->roundness, scale);
    mcv_report_number(report, "seen", "", circle->seen);
    mcv_report_number(report, "rejected", "", circle->rejected);
    mcv_report_text(report, "inside", circle->bright ? "bright" : "dark");
    mcv_report_close(report);
}

static void report_found(const subject *s, mcv_report *report, const mcv_found *found) {
    switch (found->form) {
    case MCV_FORM_EDGE:
        report_edge(s, report, &found->as.edge);
        break;
    case MCV_FORM_LINE:
        report_line(s, report, &found->as.line);
        break;
    case MCV_FORM_CALIPER:
        report_caliper(s, report, &found->as.caliper);
        break;
    default:
        report_circle(s, report, &found->as.circle);
    }
}

static void report_distance(const subject *s, mcv_report *report, const mcv_found *a,
                            const mcv_found *b) {
    const bool from_line = mcv_found_straight(a) && mcv_found_is_round(b);
    double direction[2];
    const mcv_quantity d = mcv_found_distance(a, b, direction);
    char name[136];
    snprintf(name, sizeof name, "%s to %s", mcv_found_name(a), mcv_found_name(b));
    mcv_report_element(report, name, "distance");
    if (isnan(d.value)) mcv_report_text(report, "no_distance", MCV_NOT_PARALLEL);
    put(report, from_line ? "line_distance" : "distance", "pixels", d);
    put_length(report, from_line ? "line_length" : "length", d,
               mcv_scale_along(s->pixel, direction));
    mcv_report_close(report);
}

/* From the first edge or line to all other ones and to all circles, and from the first circle to
 * the others. */
static void report_distances(const subject *s, mcv_report *report) {
    const mcv_found *line = NULL, *circle = NULL, *end = s->found + s->found_count;
    bool open = false;
    for (const mcv_found *f = s->found; f < end; ++f) {
        const bool straight = mcv_found_straight(f), round = mcv_found_is_round(f);
        if (!open && ((straight && line) || (round && (line || circle)))) {
            mcv_report_list(report, "distances");
            open = true;
        }
        if (line && (straight || round)) report_distance(s, report, line, f);
        if (circle && round) report_distance(s, report, circle, f);
        if (straight && !line) line = f;
        if (round && !circle) circle = f;
    }
    if (open) mcv_report_close(report);
}

static mcv_result find_all(subject *s, mcv_error *error) {
    for (unsigned f = 0; f < MCV_FORM_COUNT; ++f) {
        const mcv_compact_indices *texts = mcv_form_boxes(s->command, f);
        for (size_t i = 0; i < texts->count; ++i, ++s->found_count)
            MCV_TRY(mcv_locate(&s->readings, s->noise, s->whole, f, texts->items[i], i + 1,
                               s->found + s->found_count, error));
    }
    return MCV_OK;
}

/* What can be told apart of a part's contour: edges lie where they are seen within the growth, a
 * few pixels. */
static const double reach = 2;

/* Of the contour that runs along an edge's line by a box, in pixels. */
static mcv_result growth_by_box(const subject *s, const mcv_growth *growth, const mcv_edge *edge,
                                const mcv_pixel_box *box, mcv_quantity *pixels, mcv_error *error) {
    const double length = edge->across_rows ? box->height : box->width,
                 scale = mcv_scale_along(s->pixel, edge->normal);
    const double middle[2] = {box->x + box->width / 2.0, box->y + box->height / 2.0};
    const double off = (middle[0] - edge->point[0]) * edge->normal[0] +
                       (middle[1] - edge->point[1]) * edge->normal[1];
    const double point[2] = {middle[0] - off * edge->normal[0], middle[1] - off * edge->normal[1]};
    mcv_quantity g;
    MCV_TRY(mcv_growth_at(s->scene, &s->model, growth, point, edge->normal, length,
                          reach + 3 * growth->edge.value / scale, &g, error));
    *pixels = (mcv_quantity){g.value / scale, g.uncertainty / scale};
    return MCV_OK;
}

/*
 * Puts an edge back to where the part's contour is. Growths of two edges are uncertain for the same
 * reasons and add as they stand; their uncertainty is taken √2 times, so that the root of both
 * squares is that of a width.
 */
static void put_back(mcv_edge *edge, mcv_quantity pixels) {
    const double along = edge->normal[edge->across_rows ? 0 : 1];
    for (int i = 0; i < 2; ++i) edge->point[i] -= pixels.value * edge->normal[i];
    edge->position.value -= pixels.value / along;
    edge->position.uncertainty =
        hypot(edge->position.uncertainty, M_SQRT2 * pixels.uncertainty / along);
}

static mcv_result take_off_edge(const subject *s, const mcv_growth *growth, mcv_edge *edge,
                                mcv_quantity *pixels, mcv_error *error) {
    MCV_TRY(growth_by_box(s, growth, edge, &edge->box, pixels, error));
    put_back(edge, *pixels);
    return MCV_OK;
}

static mcv_result take_off_line(const subject *s, const mcv_growth *growth, mcv_line *line,
                                mcv_error *error) {
    mcv_quantity mean = {0, 0}, pixels;
    for (size_t i = 0; i < line->box_count; ++i) {
        MCV_TRY(growth_by_box(s, growth, &line->edge, line->boxes + i, &pixels, error));
        mean.value += pixels.value / (double)line->box_count;
        mean.uncertainty += pixels.uncertainty / (double)line->box_count;
    }
    put_back(&line->edge, mean);
    return MCV_OK;
}

static mcv_result take_off_caliper(const subject *s, const mcv_growth *growth, mcv_caliper *caliper,
                                   mcv_error *error) {
    const mcv_edge *first = caliper->edges, *second = first + 1;
    /* Dark between the edges: both normals point away from the other edge. */
    const double across = (second->point[0] - first->point[0]) * first->normal[0] +
                          (second->point[1] - first->point[1]) * first->normal[1];
    const double sign = across < 0 ? -1 : 1;
    mcv_quantity grown[2];
    for (int i = 0; i < 2; ++i)
        MCV_TRY(take_off_edge(s, growth, caliper->edges + i, grown + i, error));
    caliper->width.value += sign * (grown[0].value + grown[1].value);
    caliper->width.uncertainty =
        hypot(caliper->width.uncertainty, grown[0].uncertainty + grown[1].uncertainty);
    return MCV_OK;
}

static mcv_result take_off_circle(const subject *s, const mcv_growth *growth, mcv_circle *circle,
                                  mcv_error *error) {
    const double scale = mcv_scale_along(s->pixel, NULL),
                 centre[2] = {circle->column.value, circle->row.value};
    mcv_quantity g;
    if (isnan(scale))
        return mcv_fail(error, MCV_FAILED,
                        "pixels are not square in the object: a circle has no radius");
    MCV_TRY(mcv_growth_of_circle(s->scene, &s->model, growth, centre, circle->radius.value,
                                 circle->bright, reach + 3 * growth->edge.value / scale, &g,
                                 error));
    const double sign = circle->bright ? 1 : -1, value = g.value / scale,
                 uncertainty = g.uncertainty / scale;
    circle->radius = (mcv_quantity){circle->radius.value + sign * value,
                                    hypot(circle->radius.uncertainty, uncertainty)};
    circle->diameter = (mcv_quantity){circle->diameter.value + 2 * sign * value,
                                      hypot(circle->diameter.uncertainty, 2 * uncertainty)};
    circle->covariance[2][2] += uncertainty * uncertainty;
    return MCV_OK;
}

static mcv_result take_off(const subject *s, const mcv_growth *growth, mcv_found *found,
                           mcv_error *error) {
    mcv_quantity pixels;
    switch (found->form) {
    case MCV_FORM_EDGE:
        return take_off_edge(s, growth, &found->as.edge, &pixels, error);
    case MCV_FORM_LINE:
        return take_off_line(s, growth, &found->as.line, error);
    case MCV_FORM_CALIPER:
        return take_off_caliper(s, growth, &found->as.caliper, error);
    default:
        return take_off_circle(s, growth, &found->as.circle, error);
    }
}

/* --nominal: all that was found goes back to where the part's contour is. */
static mcv_result take_growths_off(subject *s, mcv_error *error) {
    const mcv_command *c = s->command;
    mcv_growth growth;
    if (!s->scene)
        return mcv_fail(error, MCV_USAGE, "--nominal needs the part and its light: give --scene");
    const mcv_sensor *sensor = s->scene->sensors + s->sensor;
    if (sensor->type != MCV_SENSOR_TELECENTRIC)
        return mcv_fail(error, MCV_USAGE,
                        "--nominal: sensor %s is not telecentric: perspective says which rim of "
                        "the part is seen",
                        sensor->name);
    if (!mcv_growth_of(s->scene, sensor, &growth))
        return mcv_fail(error, MCV_USAGE,
                        "--nominal: %s has no flat emitter that faces sensor %s behind an opaque "
                        "part, so no edge grows",
                        c->scene, sensor->name);
    for (size_t i = 0; i < s->found_count; ++i) {
        mcv_error why = {""};
        const mcv_result result = take_off(s, &growth, s->found + i, &why);
        if (result != MCV_OK)
            return mcv_fail(error, result, "--nominal: %s: %s", mcv_found_name(s->found + i),
                            why.text);
    }
    return MCV_OK;
}

static void report_boxes(const subject *s, mcv_report *report) {
    static const char *const lists[] = {
#define MCV_X(form, FORM, figures, what) #form "s",
        MCV_FORMS(MCV_X)
#undef MCV_X
    };
    for (size_t i = 0; i < s->found_count; ++i) {
        const mcv_found *f = s->found + i;
        if (i == 0 || f->form != f[-1].form) mcv_report_list(report, lists[f->form]);
        report_found(s, report, f);
        if (i + 1 == s->found_count || f->form != f[1].form) mcv_report_close(report);
    }
    report_distances(s, report);
}

/* --- the grid
 * ---------------------------------------------------------------------------------------------------
 */

/* The boxes of "[NAME=]X,Y,W,H[+X,Y,W,H…]"; other forms are left out. */
static void draw_boxes(mcv_grid *grid, const mcv_compact_indices *list) {
    for (size_t i = 0; i < list->count; ++i) {
        char name[64];
        const char *rest;
        double box[4];
        char *copy = strdup(list->items[i]), *next = NULL;
        mcv_roi_numbers(list->items[i], i + 1, name, &rest, box, 4);
        for (char *place = copy ? strtok_r(copy, "+", &next) : NULL; place;
             place = strtok_r(NULL, "+", &next)) {
            char ignored[64];
            if (mcv_roi_numbers(place, i + 1, ignored, &rest, box, 4) == 4)
                mcv_grid_box(grid, name, box);
        }
        free(copy);
    }
}

static mcv_result draw_grid(subject *s, mcv_error *error) {
    const char *text = s->command->grid, *equals = strchr(text, '='),
               *path = equals ? equals + 1 : text;
    const mcv_placement *node = NULL;
    mcv_grid grid;
    if (equals && !s->has_model)
        return mcv_fail(error, MCV_USAGE,
                        "--grid %s: the image's header does not say where the node lies: give "
                        "--scene, or leave it out",
                        text);
    if (equals) {
        char *name = strndup(text, (size_t)(equals - text));
        const mcv_result found =
            name ? mcv_camera_model_node(&s->model, name, "--grid", &node, error)
                 : mcv_fail(error, MCV_FAILED, "--grid %s: no memory for its node", text);
        free(name);
        MCV_TRY(found);
    } else if (s->has_model && s->model.node_count) {
        node = s->model.nodes;
    }
    if (mcv_same_file(path, s->command->argument))
        return mcv_fail(error, MCV_USAGE, "--grid %s is the image: give it another name", path);
    MCV_TRY(
        mcv_grid_begin(&grid, &s->readings.values, s->has_model ? &s->model : NULL, node, error));
#define MCV_X(field, name) draw_boxes(&grid, &s->command->field);
    MCV_PLACE_OPTIONS(MCV_X)
#undef MCV_X
    return mcv_grid_write(&grid, path, error);
}

/* --- the verb
 * ---------------------------------------------------------------------------------------------------
 */

static mcv_result report_all(subject *s, mcv_error *error) {
    const mcv_image *image = &s->readings.values;
    mcv_report report;
    mcv_report_begin(&report, s->command->json);
    mcv_report_text(&report, "image", s->command->argument);
    if (s->command->minus) mcv_report_text(&report, "minus", s->command->minus);
    mcv_report_numbers(&report, "size", "", " x ", (const double[]){image->width, image->height},
                       2);
    if (s->pixel[0] > 0) mcv_report_numbers(&report, "object_pixel", "m", " x ", s->pixel, 2);
    mcv_report_text(&report, "noise_from", s->noise ? s->noise : "the differences of neighbours");
    mcv_report_text(&report, "render_error",
                    s->readings.render.pixels
                        ? "taken out"
                        : "not told by the image: what there is of it counts as noise");
    report_regions(s, &report);
    report_boxes(s, &report);
    return mcv_report_end(&report, error);
}

/* All that may fail comes before the first word of the report. */
static mcv_result measure(subject *s, mcv_error *error) {
    MCV_TRY(parse_regions(s, error));
    MCV_TRY(find_all(s, error));
    if (s->command->nominal) MCV_TRY(take_growths_off(s, error));
    if (mcv_png_is_srgb(s->command->argument))
        fprintf(stderr,
                "mcvisi: warning: %s: its values are coded by sRGB, for the eye: edges seem to lie "
                "elsewhere, and contrasts are other ones; "
                "measure the grey values of `camera` or the .exr file\n",
                s->command->argument);
    return report_all(s, error);
}

/* With all places in pixels. The drawing comes first: it shows where they lie, though there may be
 * no edge. */
static mcv_result measure_places(subject *s, mcv_error *error) {
    const mcv_command *given = s->command;
    mcv_command resolved;
    if (given->minus) MCV_TRY(subtract(s, error));
    if (given->scene) MCV_TRY(scale_by_scene(s, error));
    mcv_result result =
        mcv_places_resolve(given, s->has_model ? &s->model : NULL, &resolved, error);
    s->command = &resolved;
    if (result == MCV_OK && given->grid) result = draw_grid(s, error);
    if (result == MCV_OK) result = measure(s, error);
    s->command = given;
    mcv_places_free(&resolved);
    return result;
}

mcv_result mcv_verb_measure(const mcv_command *command, mcv_error *error) {
    mcv_roi *regions = calloc(command->region.count + 1, sizeof *regions);
    mcv_found *found = calloc(count_boxes(command) + 1, sizeof *found);
    subject s;
    if (!regions || !found) {
        free(regions);
        free(found);
        return mcv_fail(error, MCV_FAILED, "no memory for the regions and boxes");
    }
    mcv_result result = read_subject(command, command->argument, &s, error);
    s.regions = regions;
    s.found = found;
    if (result == MCV_OK) result = measure_places(&s, error);
    free_subject(&s);
    free(regions);
    free(found);
    return result;
}
