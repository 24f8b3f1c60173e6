/* SPDX-License-Identifier: Apache-2.0 */
/* mcvisi measure: figures of regions and edges of an image. */
#include "analysis/edge.h"
#include "analysis/growth.h"
#include "cli/metrics.h"
#include "cli/options.h"
#include "cli/places.h"
#include "cli/report.h"
#include "cli/sensor.h"
#include "core/basics.h"
#include "output/exr.h"
#include "output/file.h"
#include "output/grid.h"
#include "output/values.h"
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
    mcv_edge *edges;       /* as many as --edge */
    mcv_quantity *growths; /* of --nominal, of each edge [m]; else NULL */
    mcv_scene *scene;      /* of --scene, or NULL */
    uint32_t sensor;
} subject;

/* --- reading ---------------------------------------------------------------------------------------------------- */

/* What the model tells of the image, if it is its model. */
static void take_model(subject *s, mcv_camera_model *model) {
    const mcv_image *values = &s->readings.values;
    mcv_camera_model_free(&s->model);
    s->model = *model;
    s->has_model = mcv_camera_model_fit(&s->model, values->width, values->height);
    for (int i = 0; i < 2; ++i) s->pixel[i] = s->has_model && s->model.macro[0] * s->model.macro[1] == 1 ? s->model.object_pixel[i] : 0;
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

static mcv_result read_exr(const char *path, subject *s, mcv_error *error) {
    mcv_exr exr;
    MCV_TRY(mcv_exr_read(path, &exr, error));
    const mcv_image *image = &exr.parts[0].image;
    const mcv_attribute *unit = mcv_exr_attribute(&exr, "mcvisi:unit");
    const double *bits = mcv_exr_numbers(&exr, "mcvisi:bits", 1);
    snprintf(s->unit, sizeof s->unit, "%s", unit && unit->text ? unit->text : "");
    s->largest = bits ? exp2(*bits) - 1 : NAN;
    const mcv_attribute *model = mcv_exr_attribute(&exr, MCV_CAMERA_MODEL_KEY);
    mcv_result result = mcv_choose_channel(s->command->channel, path, image, false, &s->readings.values, error);
    if (result == MCV_OK) result = read_model(model ? model->text : NULL, path, s, error);
    const mcv_image *deviation = mcv_exr_error(&exr);
    if (result == MCV_OK && deviation) {
        result = mcv_choose_channel(s->command->channel, path, deviation, true, &s->readings.deviation, error);
        s->noise = "the image's standard errors";
    }
    mcv_exr_free(&exr);
    return result;
}

static mcv_result read_values(const char *path, subject *s, mcv_error *error) {
    mcv_image image;
    MCV_TRY(mcv_values_read(path, &image, error));
    mcv_result result = mcv_choose_channel(s->command->channel, path, &image, false, &s->readings.values, error);
    if (result == MCV_OK) result = read_model(image.description, path, s, error);
    mcv_image_free(&image);
    s->whole = true;
    for (size_t i = 0; result == MCV_OK && s->whole && i < (size_t)s->readings.values.width * s->readings.values.height; ++i)
        s->whole = s->readings.values.pixels[i] == floorf(s->readings.values.pixels[i]);
    snprintf(s->unit, sizeof s->unit, "DN");
    return result;
}

/* What the user says of the noise stands above what the file says. */
static void set_noise(subject *s) {
    const mcv_command *c = s->command;
    if (!(c->noise > 0) && !(c->gain > 0)) return;
    s->noise = c->noise > 0 ? "--noise" : "the camera's gain and read noise";
    for (size_t i = 0; i < (size_t)s->readings.values.width * s->readings.values.height; ++i) {
        const double electrons = fmax(0, s->readings.values.pixels[i] - (double)c->black_level) / fmax(c->gain, 1e-300);
        const double variance = c->gain * c->gain * (electrons + c->read_noise * c->read_noise) + 1.0 / 12;
        s->readings.deviation.pixels[i] = (float)(c->noise > 0 ? c->noise : sqrt(variance));
    }
}

static mcv_result read_subject(const mcv_command *command, const char *path, subject *s, mcv_error *error) {
    *s = (subject){.command = command, .largest = NAN};
    MCV_TRY(mcv_ends_in(path, ".exr") ? read_exr(path, s, error) : read_values(path, s, error));
    const mcv_image *values = &s->readings.values;
    if (!s->readings.deviation.pixels) MCV_TRY(mcv_image_new(&s->readings.deviation, values->width, values->height, 1, error));
    set_noise(s);
    return MCV_OK;
}

static void free_subject(subject *s) {
    mcv_image_free(&s->readings.values);
    mcv_image_free(&s->readings.deviation);
    mcv_camera_model_free(&s->model);
    mcv_roi_free(&s->background);
    for (size_t i = 0; i < s->region_count; ++i) mcv_roi_free(s->regions + i);
    free(s->growths);
    mcv_scene_free(s->scene);
}

static mcv_result subtract(subject *s, mcv_error *error) {
    subject other;
    mcv_image *v = &s->readings.values;
    mcv_result result = read_subject(s->command, s->command->minus, &other, error);
    if (result == MCV_OK && (other.readings.values.width != v->width || other.readings.values.height != v->height))
        result = mcv_fail(error, MCV_BAD_INPUT, "%s has %u x %u pixels: it must have the %u x %u of the image", s->command->minus,
                          other.readings.values.width, other.readings.values.height, v->width, v->height);
    for (size_t i = 0; result == MCV_OK && i < (size_t)v->width * v->height; ++i) {
        v->pixels[i] -= other.readings.values.pixels[i];
        s->readings.deviation.pixels[i] = hypotf(s->readings.deviation.pixels[i], other.readings.deviation.pixels[i]);
    }
    if (!other.noise) s->noise = NULL;
    free_subject(&other);
    return result;
}

static mcv_result scale_by_scene(subject *s, mcv_error *error) {
    const mcv_command *c = s->command;
    uint32_t width, height;
    mcv_camera_model model;
    MCV_TRY(mcv_scene_load(c->scene, (mcv_overrides){c->set.items, c->set.count}, &s->scene, error));
    if (s->scene->sensor_count == 0) return mcv_fail(error, MCV_BAD_INPUT, "%s: the scene has no sensor", c->scene);
    if (c->sensor) MCV_TRY(mcv_sensor_find(s->scene, c->sensor, &s->sensor, error));
    const mcv_sensor *sensor = s->scene->sensors + s->sensor;
    mcv_sensor_film_size(sensor, &width, &height);
    MCV_TRY(mcv_camera_model_of(s->scene, sensor, &model, error));
    take_model(s, &model);
    if (!s->has_model)
        return mcv_fail(error, MCV_BAD_INPUT, "%s has %u x %u pixels, but sensor %s of %s %u x %u", c->argument, s->readings.values.width,
                        s->readings.values.height, sensor->name, c->scene, width, height);
    if (!(mcv_sensor_optics(sensor).magnification > 0))
        return mcv_fail(error, MCV_BAD_INPUT, "%s: sensor %s has no plane in focus to measure in", c->scene, sensor->name);
    return MCV_OK;
}

/* --- regions ---------------------------------------------------------------------------------------------------- */

static void put(mcv_report *report, const char *key, const char *unit, mcv_quantity q) {
    mcv_report_quantity(report, key, unit, q.value, q.uncertainty);
}

static void know_noise(subject *s, mcv_roi *region) { mcv_know_noise(&s->readings, s->noise, s->whole, region); }

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
    mcv_report_number(report, "smallest", s->unit, f.smallest);
    mcv_report_number(report, "largest", s->unit, f.largest);
    if (isfinite(s->largest)) mcv_report_number(report, "saturated", "", (double)saturated / (double)f.count);
    put(report, "snr", "", f.snr);
    put(report, "rms_contrast", "", f.rms_contrast);
    put(report, "uniformity", "", f.uniformity);
    if (background) {
        const mcv_contrast_figures c = mcv_roi_contrast(&s->readings, region, background);
        put(report, "difference", s->unit, c.difference);
        put(report, "weber_contrast", "", c.weber);
        put(report, "michelson_contrast", "", c.michelson);
        put(report, "contrast_to_noise", "", c.contrast_to_noise);
    }
    mcv_report_close(report);
}

/* The whole image where no region is named and no edge either. */
static mcv_result parse_regions(subject *s, mcv_error *error) {
    const mcv_command *c = s->command;
    const mcv_image *image = &s->readings.values;
    char all[64];
    const char *whole = all;
    snprintf(all, sizeof all, "image=0,0,%u,%u", image->width, image->height);
    const size_t count = c->region.count ? c->region.count : c->edge.count && !c->background ? 0 : 1;
    const char *const *texts = c->region.count ? c->region.items : &whole;
    if (c->background) MCV_TRY(mcv_roi_parse(c->background, 0, image, &s->background, error));
    for (; s->region_count < count; ++s->region_count)
        MCV_TRY(mcv_roi_parse(texts[s->region_count], s->region_count + 1, image, s->regions + s->region_count, error));
    return MCV_OK;
}

static void report_regions(subject *s, mcv_report *report) {
    if (s->region_count == 0) return;
    mcv_report_list(report, "regions");
    for (size_t i = 0; i < s->region_count; ++i) report_region(s, report, s->regions + i, s->background.inside ? &s->background : NULL);
    mcv_report_close(report);
}

/* --- edges ------------------------------------------------------------------------------------------------------ */

static void report_values(mcv_report *report, const char *key, const mcv_quantity *q, size_t count, bool uncertainties) {
    double *values = malloc(count * sizeof *values);
    for (size_t i = 0; values && i < count; ++i) values[i] = uncertainties ? q[i].uncertainty : q[i].value;
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

/* Metres in the object for a pixel along a direction; NaN where the scale is not known. */
static double scale_along(const subject *s, const double direction[2]) {
    return s->pixel[0] > 0 ? hypot(direction[0] * s->pixel[0], direction[1] * s->pixel[1]) : NAN;
}

static void report_edge(const subject *s, mcv_report *report, size_t index) {
    const mcv_edge *edge = s->edges + index;
    const double scale = scale_along(s, edge->normal);
    mcv_report_element(report, edge->name, "edge");
    mcv_report_numbers(report, "point", "pixels", ", ", edge->point, 2);
    put(report, edge->across_rows ? "column" : "row", "pixels", edge->position);
    put(report, "tilt", "rad", edge->tilt);
    put(report, "dark", s->unit, edge->dark);
    put(report, "bright", s->unit, edge->bright);
    put(report, "width_10_90", "pixels", edge->width_10_90);
    mcv_report_quantity(report, "width_10_90_length", "m", edge->width_10_90.value * scale, edge->width_10_90.uncertainty * scale);
    if (s->growths) put(report, "growth", "m", s->growths[index]);
    report_spread(s, report, edge);
    mcv_report_close(report);
}

/*
 * Takes off what both edges have grown towards their brighter sides. Both growths are uncertain for the same reasons: their uncertainties
 * add as they stand.
 */
static mcv_quantity without_growth(const subject *s, size_t a, size_t b, mcv_quantity distance) {
    const double *na = s->edges[a].normal, *nb = s->edges[b].normal, turn = na[0] * nb[0] + na[1] * nb[1];
    const mcv_quantity ga = s->growths[a], gb = s->growths[b];
    const double pa = scale_along(s, na), pb = scale_along(s, nb);
    const double unknown = ga.uncertainty / pa - turn * gb.uncertainty / pb;
    return (mcv_quantity){distance.value + ga.value / pa - turn * gb.value / pb, hypot(distance.uncertainty, unknown)};
}

static void report_distance(const subject *s, mcv_report *report, size_t first, size_t other) {
    const mcv_edge *a = s->edges + first, *b = s->edges + other;
    mcv_quantity d = mcv_edge_distance(a, b);
    if (s->growths) d = without_growth(s, first, other, d);
    d.value = fabs(d.value);
    const double scale = scale_along(s, a->normal);
    char name[136];
    snprintf(name, sizeof name, "%s to %s", a->name, b->name);
    mcv_report_element(report, name, "distance");
    put(report, "distance", "pixels", d);
    mcv_report_quantity(report, "length", "m", d.value * scale, d.uncertainty * scale);
    mcv_report_close(report);
}

static mcv_result find_edges(subject *s, mcv_error *error) {
    const mcv_list *texts = &s->command->edge;
    for (size_t i = 0; i < texts->count; ++i)
        MCV_TRY(mcv_locate_edge(&s->readings, s->noise, s->whole, texts->items[i], i + 1, s->edges + i, error));
    return MCV_OK;
}

/* What can be told apart of a part's contour: edges lie where they are seen within the growth, a few pixels. */
static const double reach = 2;

/* Of --nominal: how far each edge has grown. */
static mcv_result find_growths(subject *s, mcv_error *error) {
    const mcv_command *c = s->command;
    mcv_growth growth;
    if (!s->scene) return mcv_fail(error, MCV_USAGE, "--nominal needs the part and its light: give --scene");
    const mcv_sensor *sensor = s->scene->sensors + s->sensor;
    if (sensor->type != MCV_SENSOR_TELECENTRIC)
        return mcv_fail(error, MCV_USAGE, "--nominal: sensor %s is not telecentric: perspective says which rim of the part is seen",
                        sensor->name);
    if (!mcv_growth_of(s->scene, sensor, &growth))
        return mcv_fail(error, MCV_USAGE, "--nominal: %s has no flat emitter that faces sensor %s behind an opaque part, so no edge grows",
                        c->scene, sensor->name);
    s->growths = calloc(c->edge.count + 1, sizeof *s->growths);
    if (!s->growths) return mcv_fail(error, MCV_FAILED, "no memory for the growth of edges");
    for (size_t i = 0; i < c->edge.count; ++i) {
        const mcv_edge *edge = s->edges + i;
        const double length = edge->across_rows ? edge->height : edge->width;
        mcv_error why = {""};
        const mcv_result result = mcv_growth_at(s->scene, &s->model, &growth, edge->point, edge->normal, length,
                                                reach + 3 * growth.edge.value / s->pixel[0], s->growths + i, &why);
        if (result != MCV_OK) return mcv_fail(error, result, "edge %s: %s", edge->name, why.text);
    }
    return MCV_OK;
}

static void report_edges(const subject *s, mcv_report *report) {
    const size_t count = s->command->edge.count;
    if (count) mcv_report_list(report, "edges");
    for (size_t i = 0; i < count; ++i) report_edge(s, report, i);
    if (count) mcv_report_close(report);
    if (count > 1) mcv_report_list(report, "distances");
    for (size_t i = 1; i < count; ++i) report_distance(s, report, 0, i);
    if (count > 1) mcv_report_close(report);
}

/* --- the grid --------------------------------------------------------------------------------------------------- */

/* The boxes of "[NAME=]X,Y,W,H[+X,Y,W,H…]"; other forms are left out. */
static void draw_boxes(mcv_grid *grid, const mcv_list *list) {
    for (size_t i = 0; i < list->count; ++i) {
        char name[64];
        const char *rest;
        double box[4];
        char *copy = strdup(list->items[i]), *next = NULL;
        mcv_roi_numbers(list->items[i], i + 1, name, &rest, box, 4);
        for (char *place = copy ? strtok_r(copy, "+", &next) : NULL; place; place = strtok_r(NULL, "+", &next)) {
            char ignored[64];
            if (mcv_roi_numbers(place, i + 1, ignored, &rest, box, 4) == 4) mcv_grid_box(grid, name, box);
        }
        free(copy);
    }
}

static mcv_result draw_grid(subject *s, mcv_error *error) {
    const char *text = s->command->grid, *equals = strchr(text, '='), *path = equals ? equals + 1 : text;
    const mcv_placement *node = NULL;
    mcv_grid grid;
    if (equals && !s->has_model)
        return mcv_fail(error, MCV_USAGE, "--grid %s: the image's header does not say where the node lies: give --scene, or leave it out",
                        text);
    if (equals) {
        char *name = strndup(text, (size_t)(equals - text));
        const mcv_result found = name ? mcv_camera_model_node(&s->model, name, "--grid", &node, error) : MCV_FAILED;
        free(name);
        MCV_TRY(found);
    } else if (s->has_model && s->model.node_count) {
        node = s->model.nodes;
    }
    if (mcv_same_file(path, s->command->argument)) return mcv_fail(error, MCV_USAGE, "--grid %s is the image: give it another name", path);
    MCV_TRY(mcv_grid_begin(&grid, &s->readings.values, s->has_model ? &s->model : NULL, node, error));
#define MCV_X(field, name) draw_boxes(&grid, &s->command->field);
    MCV_PLACE_OPTIONS(MCV_X)
#undef MCV_X
    return mcv_grid_write(&grid, path, error);
}

/* --- the verb --------------------------------------------------------------------------------------------------- */

static mcv_result report_all(subject *s, mcv_error *error) {
    const mcv_image *image = &s->readings.values;
    mcv_report report;
    mcv_report_begin(&report, s->command->json);
    mcv_report_text(&report, "image", s->command->argument);
    if (s->command->minus) mcv_report_text(&report, "minus", s->command->minus);
    mcv_report_numbers(&report, "size", "", " x ", (const double[]){image->width, image->height}, 2);
    if (s->pixel[0] > 0) mcv_report_numbers(&report, "object_pixel", "m", " x ", s->pixel, 2);
    mcv_report_text(&report, "noise_from", s->noise ? s->noise : "the differences of neighbours");
    report_regions(s, &report);
    report_edges(s, &report);
    return mcv_report_end(&report, error);
}

/* All that may fail comes before the first word of the report. */
static mcv_result measure(subject *s, mcv_error *error) {
    MCV_TRY(parse_regions(s, error));
    MCV_TRY(find_edges(s, error));
    if (s->command->nominal) MCV_TRY(find_growths(s, error));
    return report_all(s, error);
}

/* With all places in pixels. The drawing comes first: it shows where they lie, though there may be no edge. */
static mcv_result measure_places(subject *s, mcv_error *error) {
    const mcv_command *given = s->command;
    mcv_command resolved;
    if (given->minus) MCV_TRY(subtract(s, error));
    if (given->scene) MCV_TRY(scale_by_scene(s, error));
    mcv_result result = mcv_places_resolve(given, s->has_model ? &s->model : NULL, &resolved, error);
    s->command = &resolved;
    if (result == MCV_OK && given->grid) result = draw_grid(s, error);
    if (result == MCV_OK) result = measure(s, error);
    s->command = given;
    mcv_places_free(&resolved);
    return result;
}

mcv_result mcv_verb_measure(const mcv_command *command, mcv_error *error) {
    mcv_roi *regions = calloc(command->region.count + 1, sizeof *regions);
    mcv_edge *edges = calloc(command->edge.count + 1, sizeof *edges);
    subject s;
    if (!regions || !edges) {
        free(regions);
        free(edges);
        return mcv_fail(error, MCV_FAILED, "no memory for the regions and edges");
    }
    mcv_result result = read_subject(command, command->argument, &s, error);
    s.regions = regions;
    s.edges = edges;
    if (result == MCV_OK) result = measure_places(&s, error);
    free_subject(&s);
    free(regions);
    free(edges);
    return result;
}
