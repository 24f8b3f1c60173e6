/* SPDX-License-Identifier: Apache-2.0 */
/* One drawing of a set-up: its contents, its scale, and the order of its parts. */
#include "check/setup_drawing.h"

#include "scene/emitters.h"
#include "scene/geometry.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Width of a drawing and its margin; largest and least height of a drawing true to scale [CSS
 * pixels]; the largest number of named parts. */
enum { WIDTH = 1040, MARGIN = 24, TALLEST = 420, LOWEST = 150, LABELS = 8 };

/* Bodies beside a field may widen a drawing to this many fields; if no part is in the field, parts
 * may widen it further. */
static const double reach = 2.5, far_reach = 15;

static void extend(double range[2], double value, double low, double high) {
    if (!isfinite(value)) return;
    range[0] = fmin(range[0], fmax(value, low));
    range[1] = fmax(range[1], fmin(value, high));
}

/* Determines what is drawn: the sensor, its field, the plane in focus, and lights and parts that
 * are near. */
static bool frame(mcv_drawing *c, double parts[2]) {
    double deepest = isfinite(c->focus) && c->focus > 0 ? c->focus : 0;
    parts[0] = INFINITY;
    parts[1] = -INFINITY;
    for (uint32_t end = 0, i = mcv_next_part(c->scene, 0, &end); i < c->scene->instance_count;
         i = mcv_next_part(c->scene, i + 1, &end)) {
        const mcv_extent e = mcv_view_extent(c->view, c->scene, i);
        if (!mcv_view_shows(c->view, &e)) continue;
        parts[0] = fmin(parts[0], e.depth[0]);
        parts[1] = fmax(parts[1], e.depth[1]);
    }
    if (parts[1] > 0 && isfinite(parts[1])) deepest = fmax(deepest, parts[1]);
    for (uint32_t i = 0; i < c->scene->instance_count && deepest == 0; ++i)
        deepest = fmax(deepest, mcv_view_extent(c->view, c->scene, i).depth[1]);
    if (!(deepest > 0)) deepest = 10 * fmax(-c->film_at, 1e-3);
    const double scale = c->view->is_telecentric ? 1 : deepest;
    const double half = fmax(fmax(fabs(c->film[0]), fabs(c->film[1])) * scale, c->lens),
                 most = (parts[0] < parts[1] ? reach : far_reach) * half;
    c->depth[0] = fmax(c->film_at, -deepest);
    c->depth[1] = deepest;
    c->height[0] = fmin(c->film[0] * scale, -c->lens);
    c->height[1] = fmax(c->film[1] * scale, c->lens);
    for (uint32_t i = 0; i < c->scene->instance_count; ++i) {
        size_t count;
        mcv_drawing_point *hull = mcv_drawing_hull(c, i, &count);
        if (!hull) return false;
        for (size_t k = 0; k < count; ++k) {
            extend(c->depth, hull[k].depth, -0.8 * deepest, 1.8 * deepest);
            extend(c->height, hull[k].height, -most, most);
        }
        free(hull);
    }
    for (uint32_t i = 0; i < c->scene->emitter_count; ++i) {
        const mcv_emitter *e = c->scene->emitters + i;
        if (!mcv_emitter_has_place(e->type)) continue;
        const mcv_drawing_point at = mcv_drawing_project(c, e->to_world.m + 9);
        extend(c->depth, at.depth, -0.8 * deepest, 1.8 * deepest);
        extend(c->height, at.height, -most, most);
    }
    const double room[2] = {0.04 * (c->depth[1] - c->depth[0]),
                            0.06 * (c->height[1] - c->height[0])};
    for (int k = 0; k < 2; ++k) {
        c->depth[k] += (k ? 1 : -1) * room[0];
        c->height[k] += (k ? 1 : -1) * room[1];
    }
    return true;
}

/* Chooses the scale. It is the same along both axes unless the drawing would be too low; *stretch
 * is the factor of heights. */
static void fit(mcv_drawing *c, double *stretch) {
    const double depth = c->depth[1] - c->depth[0], height = c->height[1] - c->height[0];
    const double scale = fmin((WIDTH - 2 * MARGIN) / depth, TALLEST / height);
    *stretch = 1;
    for (int i = 1; *stretch * scale * height < LOWEST && i < 30; ++i)
        *stretch *= i % 3 == 2 ? 2.5 : 2; /* 1 2 5 10 20 50 … */
    c->scale[0] = scale;
    c->scale[1] = *stretch * scale;
    c->left = (WIDTH - scale * depth) / 2;
    c->bottom = MCV_DRAWING_TOP + c->scale[1] * height;
}

static double area_of(const mcv_scene *scene, uint32_t i) {
    double lower[3], upper[3];
    mcv_scene_box(scene, i, lower, upper);
    return hypot(hypot(upper[0] - lower[0], upper[1] - lower[1]), upper[2] - lower[2]);
}

/* The area above which parts are named: of the LABELS-th largest part, or 0. */
static double named_area(const mcv_scene *scene) {
    double largest[LABELS] = {0}; /* descending */
    for (uint32_t end = 0, i = mcv_next_part(scene, 0, &end); i < scene->instance_count;
         i = mcv_next_part(scene, i + 1, &end)) {
        double area = area_of(scene, i);
        for (int k = 0; k < LABELS; ++k) {
            const double other = largest[k];
            if (!(area > other)) continue;
            largest[k] = area;
            area = other;
        }
    }
    return largest[LABELS - 1];
}

/* Is an instance one of the few largest, which are named? Lights are always named, once per
 * node. */
static bool is_named(const mcv_scene *scene, uint32_t instance, double least) {
    if (instance > 0 &&
        strcmp(scene->instances[instance - 1].name, scene->instances[instance].name) == 0)
        return false;
    return !mcv_is_part(scene, instance) || area_of(scene, instance) >= least;
}

/* Opens a drawing as a figure on a page. */
static void open_figure(const mcv_drawing *c, double height, double stretch) {
    const char *from = c->from_above ? "above" : "the side";
    fprintf(c->out, "<figure><figcaption>From %s%s", from, stretch > 1 ? "" : ", true to scale");
    if (stretch > 1) fprintf(c->out, ", heights %g times larger than depths", stretch);
    fprintf(c->out,
            "</figcaption>\n<svg viewBox=\"0 0 %d %.0f\" role=\"img\" aria-label=\"The set-up from "
            "%s\">\n",
            WIDTH, height, from);
}

/* Opens it as a file of its own. */
static void open_file(const mcv_drawing *c, double height, double stretch) {
    fprintf(c->out,
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"%d\" height=\"%.0f\" "
            "viewBox=\"0 0 %d %.0f\">\n<desc>The set-up from %s%s",
            WIDTH, height, WIDTH, height, c->from_above ? "above" : "the side",
            stretch > 1 ? "" : ", true to scale");
    if (stretch > 1) fprintf(c->out, ", heights %g times larger than depths", stretch);
    fputs("</desc>\n", c->out);
    mcv_put_drawing_style(c->out);
    fputs("<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n", c->out);
}

bool mcv_put_drawing(mcv_drawing *c) {
    double parts[2], stretch;
    if (!frame(c, parts)) return false;
    fit(c, &stretch);
    char *body = NULL;
    size_t size = 0;
    FILE *page = c->out;
    if (!(c->out = open_memstream(&body, &size))) return false;
    fprintf(c->out, "<g clip-path=\"url(#frame%d)\">\n", c->number);
    for (uint32_t i = 0; i < c->scene->emitter_count; ++i) mcv_put_beam(c, i);
    mcv_put_camera(c);
    if (isfinite(c->focus) && c->focus > 0) mcv_put_field(c);
    const double least = named_area(c->scene);
    for (uint32_t i = 0; i < c->scene->instance_count; ++i)
        mcv_put_outline(c, i, is_named(c->scene, i, least));
    for (uint32_t i = 0; i < c->scene->emitter_count; ++i)
        mcv_put_source(c, c->scene->emitters + i);
    fprintf(c->out, "<path class=\"axis\" d=\"M%.1f %.1fH%.1f\"/>\n", mcv_drawing_x(c, c->depth[0]),
            mcv_drawing_y(c, 0), mcv_drawing_x(c, c->depth[1]));
    const double film[3] = {c->film[0], 0.5 * (c->film[0] + c->film[1]), c->film[1]};
    if (c->overlay) c->overlay(c, c->user);
    for (int k = 0; k < 3 && !c->overlay; ++k) mcv_put_rays(c, k, film[k]);
    fputs("</g>\n", c->out);
    mcv_put_dimensions(c, parts);
    fclose(c->out);
    c->out = page;
    const double width = c->scale[0] * (c->depth[1] - c->depth[0]),
                 height = c->bottom + 20 + MCV_DRAWING_ROW * c->rows;
    (c->alone ? open_file : open_figure)(c, height, stretch);
    fprintf(page,
            "<clipPath id=\"frame%d\"><rect x=\"%.1f\" y=\"%d\" width=\"%.1f\" "
            "height=\"%.1f\"/></clipPath>\n",
            c->number, c->left, MCV_DRAWING_TOP, width, c->bottom - MCV_DRAWING_TOP);
    fprintf(page, "<rect class=\"ground\" x=\"%.1f\" y=\"%d\" width=\"%.1f\" height=\"%.1f\"/>\n",
            c->left, MCV_DRAWING_TOP, width, c->bottom - MCV_DRAWING_TOP);
    fputs(body ? body : "", page);
    fputs(c->alone ? "</svg>\n" : "</svg></figure>\n", page);
    free(body);
    return true;
}
