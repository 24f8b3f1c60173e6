/* SPDX-License-Identifier: Apache-2.0 */
/* What `mcvisi measure` does: figures of regions of an image, and of the edges, lines, widths and
 * circles in it. */
#include "check/nominal.h"
#include "verbs/measure.h"
#include "verbs/places.h"
#include "core/output_file.h"
#include "io/grid.h"

#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* The default region is the whole image if no region and no box is given. */
static mcv_result parse_regions(mcv_subject *s, mcv_error *error) {
    const mcv_places *p = &s->places;
    const mcv_image *image = &s->readings.values;
    char all[64];
    const char *whole = all;
    snprintf(all, sizeof all, "image=0,0,%u,%u", image->width, image->height);
    const size_t count = p->regions.count                        ? p->regions.count
                         : mcv_places_boxes(p) && !p->background ? 0
                                                                 : 1;
    const char *const *texts = p->regions.count ? p->regions.items : &whole;
    if (p->background) MCV_TRY(mcv_roi_parse(p->background, 0, image, &s->background, error));
    for (; s->region_count < count; ++s->region_count)
        MCV_TRY(mcv_roi_parse(texts[s->region_count], s->region_count + 1, image,
                              s->regions + s->region_count, error));
    return MCV_OK;
}

static mcv_result find_all(mcv_subject *s, mcv_error *error) {
    for (unsigned f = 0; f < MCV_FORM_COUNT; ++f) {
        const mcv_texts texts = s->places.boxes[f];
        for (size_t i = 0; i < texts.count; ++i, ++s->found_count)
            MCV_TRY(mcv_locate(&s->readings, s->noise, s->whole, f, texts.items[i], i + 1,
                               s->found + s->found_count, error));
    }
    return MCV_OK;
}

/* --nominal: corrects all results to the part's contour. */
static mcv_result take_growths_off(mcv_subject *s, mcv_error *error) {
    mcv_growth growth;
    if (!s->scene)
        return mcv_fail(error, MCV_USAGE, "--nominal needs the part and its light: give --scene");
    const mcv_sensor *sensor = s->scene->sensors + s->sensor;
    MCV_TRY(mcv_camera_model_check_places(&s->model, "--nominal", error));
    if (sensor->type != MCV_SENSOR_TELECENTRIC)
        return mcv_fail(
            error, MCV_USAGE,
            "--nominal: sensor %s is not telecentric: perspective determines which rim of the "
            "part is seen",
            sensor->name);
    if (!mcv_growth_of(s->scene, sensor, &growth))
        return mcv_fail(error, MCV_USAGE,
                        "--nominal: %s has no flat emitter that faces sensor %s behind an opaque "
                        "part, so no edge grows",
                        s->scene->path, sensor->name);
    const mcv_part_view view = {s->scene, &s->model, &growth, s->pixel};
    for (size_t i = 0; i < s->found_count; ++i) {
        mcv_error why = {""};
        const mcv_result result = mcv_nominal_put_back(&view, s->found + i, &why);
        if (result != MCV_OK)
            return mcv_fail(error, result, "--nominal: %s: %s", mcv_found_name(s->found + i),
                            why.text);
    }
    return MCV_OK;
}

/* Visits a box X,Y,W,H; false ends the iteration. */
typedef bool box_visitor(void *user, const char *name, const double box[4]);

/* Visits the boxes of "[NAME=]X,Y,W,H[+X,Y,W,H…]"; other forms are skipped. */
static bool visit_boxes(mcv_texts texts, box_visitor *visit, void *user) {
    bool more = true;
    for (size_t i = 0; i < texts.count && more; ++i) {
        char name[64];
        const char *rest;
        double box[4];
        char *copy = strdup(texts.items[i]), *next = NULL;
        mcv_roi_numbers(texts.items[i], i + 1, name, &rest, box, 4);
        for (char *place = copy ? strtok_r(copy, "+", &next) : NULL; place && more;
             place = strtok_r(NULL, "+", &next)) {
            char ignored[64];
            if (mcv_roi_numbers(place, i + 1, ignored, &rest, box, 4) == 4)
                more = visit(user, name, box);
        }
        free(copy);
    }
    return more;
}

static void visit_all_boxes(const mcv_places *places, box_visitor *visit, void *user) {
    bool more = visit_boxes(places->regions, visit, user);
    for (unsigned f = 0; f < MCV_FORM_COUNT && more; ++f)
        more = visit_boxes(places->boxes[f], visit, user);
}

static bool draw_box(void *grid, const char *name, const double box[4]) {
    mcv_grid_box(grid, name, box);
    return true;
}

/* What is to be said of boxes in a light field image. */
typedef struct cut_note {
    const uint32_t *macro;
    mcv_report *report;
} cut_note;

/* A box of whole macro pixels weighs all directions alike. */
static bool note_cut(void *user, const char *name, const double box[4]) {
    const cut_note *note = user;
    const uint32_t *macro = note->macro;
    char text[256];
    bool whole = true;
    for (int i = 0; i < 4; ++i) whole = whole && fmod(box[i], macro[i % 2]) == 0;
    if (whole) return true;
    snprintf(text, sizeof text,
             "the box %s=%g,%g,%g,%g cuts macro pixels of %u x %u pixels, so that directions have "
             "unequal weights: begin and end at multiples of them",
             name, box[0], box[1], box[2], box[3], macro[0], macro[1]);
    mcv_report_tell(note->report, "note", text);
    return false;
}

static void note_cuts(mcv_subject *s, mcv_report *report) {
    const mcv_texts background = {&s->places.background, s->places.background ? 1 : 0};
    cut_note note = {s->model.macro, report};
    if (visit_boxes(background, note_cut, &note)) visit_all_boxes(&s->places, note_cut, &note);
}

static mcv_result draw_grid(mcv_subject *s, mcv_error *error) {
    const char *text = s->command->grid, *equals = strchr(text, '='),
               *path = equals ? equals + 1 : text;
    const mcv_placement *node = NULL;
    mcv_grid grid;
    if (equals && !s->has_model)
        return mcv_fail(
            error, MCV_USAGE,
            "--grid %s: the image's header does not state where the node lies: give --scene, or "
            "leave it out",
            text);
    if (equals) {
        MCV_TRY(mcv_camera_model_check_places(&s->model, "--grid", error));
        char *name = strndup(text, (size_t)(equals - text));
        const mcv_result found =
            name ? mcv_camera_model_node(&s->model, name, "--grid", &node, error)
                 : mcv_fail(error, MCV_FAILED, "--grid %s: no memory for its node", text);
        free(name);
        MCV_TRY(found);
    } else if (s->has_model && s->model.node_count && !s->model.line) {
        node = s->model.nodes;
    }
    if (mcv_same_file(path, s->picture->path))
        return mcv_fail(error, MCV_USAGE, "--grid %s is the image: give it another name", path);
    MCV_TRY(
        mcv_grid_begin(&grid, &s->readings.values, s->has_model ? &s->model : NULL, node, error));
    visit_all_boxes(&s->places, draw_box, &grid);
    return mcv_grid_write(&grid, path, error);
}

/* Edges in it seem to lie elsewhere. */
static void warn_of_srgb(const mcv_picture *picture, mcv_report *report) {
    char text[PATH_MAX + 256];
    snprintf(text, sizeof text,
             "%s: its values are encoded in sRGB, for viewing: this shifts edges and changes "
             "contrasts; measure the grey values of `camera` or the .exr file",
             picture->path);
    mcv_report_tell(report, "warning", text);
}

/* Whatever can fail comes before the first line of the report. */
static mcv_result measure(mcv_subject *s, mcv_report *report, mcv_error *error) {
    MCV_TRY(parse_regions(s, error));
    MCV_TRY(find_all(s, error));
    if (s->command->nominal) MCV_TRY(take_growths_off(s, error));
    if (s->has_model && s->model.macro[0] * s->model.macro[1] > 1) note_cuts(s, report);
    if (s->picture->srgb) warn_of_srgb(s->picture, report);
    mcv_subject_report(s, report);
    return MCV_OK;
}

/* Measures with all places in pixels. The drawing comes first: it shows the places even if there is
 * no edge. */
static mcv_result measure_places(mcv_subject *s, const mcv_places *given, mcv_report *report,
                                 mcv_error *error) {
    if (s->minus) MCV_TRY(mcv_subject_subtract(s, error));
    if (s->scene) MCV_TRY(mcv_subject_scale_by_scene(s, error));
    mcv_result result =
        mcv_places_resolve(given, s->has_model ? &s->model : NULL, &s->places, error);
    if (result == MCV_OK && s->command->grid) result = draw_grid(s, error);
    if (result == MCV_OK) result = measure(s, report, error);
    mcv_places_free(&s->places);
    return result;
}

mcv_result mcv_measure(const mcv_command *command, const mcv_picture *picture,
                       const mcv_picture *minus, const mcv_scene *scene, mcv_report *report,
                       mcv_error *error) {
    const mcv_places places = mcv_places_of(command);
    mcv_roi *regions = calloc(places.regions.count + 1, sizeof *regions);
    mcv_found *found = calloc(mcv_places_boxes(&places) + 1, sizeof *found);
    mcv_subject s;
    if (!regions || !found) {
        free(regions);
        free(found);
        return mcv_fail(error, MCV_FAILED, "no memory for the regions and boxes");
    }
    mcv_result result = mcv_subject_read(command, picture, &s, error);
    s.minus = minus;
    s.scene = scene;
    s.regions = regions;
    s.found = found;
    if (result == MCV_OK) result = measure_places(&s, &places, report, error);
    mcv_subject_free(&s);
    free(regions);
    free(found);
    return result;
}
