/* SPDX-License-Identifier: Apache-2.0 */
/* Bodies in the drawing of a set-up: their convex hulls, sections and names. */
#include "check/setup_drawing.h"

#include "io/html.h"
#include "scene/geometry.h"
#include "scene/materials.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static int compare_points(const void *a, const void *b) {
    const mcv_drawing_point *p = a, *q = b;
    if (p->depth != q->depth) return p->depth < q->depth ? -1 : 1;
    return p->height < q->height ? -1 : p->height > q->height;
}

static double turn(mcv_drawing_point a, mcv_drawing_point b, mcv_drawing_point p) {
    return (b.depth - a.depth) * (p.height - a.height) -
           (b.height - a.height) * (p.depth - a.depth);
}

mcv_drawing_point *mcv_drawing_hull(const mcv_drawing *c, uint32_t instance, size_t *count) {
    const size_t vertices = c->scene->meshes[c->scene->instances[instance].mesh].vertex_count;
    mcv_drawing_point *all = malloc((vertices + 1) * sizeof *all),
                      *hull = malloc((2 * vertices + 2) * sizeof *hull);
    *count = 0;
    for (size_t v = 0; all && hull && v < vertices; ++v) {
        double world[3];
        mcv_scene_vertex(c->scene, instance, (uint32_t)v, world);
        all[v] = mcv_drawing_project(c, world);
    }
    if (all && hull && vertices > 0) {
        size_t n = 0;
        qsort(all, vertices, sizeof *all, compare_points);
        for (int upper = 0; upper < 2; ++upper) {
            const size_t base = n;
            for (size_t i = 0; i < vertices; ++i) {
                const mcv_drawing_point p = all[upper ? vertices - 1 - i : i];
                while (n >= base + 2 && turn(hull[n - 2], hull[n - 1], p) <= 0) --n;
                hull[n++] = p;
            }
            if (n > 1) --n; /* begins the other half */
        }
        *count = n ? n : 1;
    }
    free(all);
    if (*count > 0) return hull;
    free(hull);
    return NULL;
}

void mcv_put_points(const mcv_drawing *c, const mcv_drawing_point *points, size_t count) {
    double x = 0, y = 0;
    for (size_t i = 0; i < count; ++i) {
        const double to_x = mcv_drawing_x(c, points[i].depth),
                     to_y = mcv_drawing_y(c, points[i].height);
        if (i > 0 && i + 1 < count && fabs(to_x - x) + fabs(to_y - y) < 0.5) continue;
        fprintf(c->out, "%s%.1f %.1f", i ? "L" : "M", to_x, to_y);
        x = to_x;
        y = to_y;
    }
}

void mcv_put_label(const mcv_drawing *c, const char *class, double x, double y, const char *anchor,
                   const char *text) {
    fprintf(c->out, "<text class=\"%s\" x=\"%.1f\" y=\"%.1f\" text-anchor=\"%s\">", class, x, y,
            anchor);
    mcv_html_text(c->out, text);
    fputs("</text>\n", c->out);
}

double mcv_drawing_inside(const mcv_drawing *c, double x, const char *text) {
    const double half = 3.6 * (double)strlen(text) + 4;
    return fmin(fmax(x, mcv_drawing_x(c, c->depth[0]) + half),
                mcv_drawing_x(c, c->depth[1]) - half);
}

void mcv_put_name(mcv_drawing *c, double x, double y, const char *name) {
    const double half = 3.6 * (double)strlen(name) + 2;
    x = mcv_drawing_inside(c, x, name);
    y = fmax(y, MCV_DRAWING_TOP + 12);
    for (int i = 0; i < c->name_count; ++i)
        if (fabs(x - c->names[i].x) < half + c->names[i].half && fabs(y - c->names[i].y) < 13)
            return;
    if (c->name_count == MCV_DRAWING_NAMES) return;
    c->names[c->name_count].x = x;
    c->names[c->name_count].y = y;
    c->names[c->name_count++].half = half;
    mcv_put_label(c, "name", x, y, "middle", name);
}

static const char *class_of(const mcv_scene *scene, uint32_t instance) {
    const uint32_t type = scene->materials[scene->instances[instance].material].type;
    if (scene->instances[instance].emitter != MCV_NONE) return "light";
    if (type == MCV_MATERIAL_MIRROR || type == MCV_MATERIAL_BEAM_SPLITTER) return "mirror";
    if (mcv_material_has_medium(type) || mcv_material_is_plate(type)) return "glass";
    return mcv_is_part(scene, instance) ? "part" : "housing";
}

/* Draws the section of the mesh with the plane of the drawing, which contains the axis: two sides
 * of a ring. False if there is none. */
static bool put_section(const mcv_drawing *c, uint32_t instance) {
    const uint32_t triangles = c->scene->meshes[c->scene->instances[instance].mesh].triangle_count;
    bool any = false;
    for (uint32_t t = 0; t < triangles; ++t) {
        double corners[3][3], aside[3];
        mcv_drawing_point ends[3];
        size_t count = 0;
        mcv_scene_corners(c->scene, instance, t, corners);
        for (int k = 0; k < 3; ++k) {
            double local[3];
            mcv_view_point(c->view, corners[k], local);
            aside[k] = local[c->from_above ? 1 : 0];
        }
        for (int k = 0; k < 3; ++k) {
            const int next = (k + 1) % 3;
            if ((aside[k] > 0) == (aside[next] > 0)) continue;
            const double share = aside[k] / (aside[k] - aside[next]);
            const mcv_drawing_point a = mcv_drawing_project(c, corners[k]),
                                    b = mcv_drawing_project(c, corners[next]);
            ends[count++] = (mcv_drawing_point){a.depth + share * (b.depth - a.depth),
                                                a.height + share * (b.height - a.height)};
        }
        if (count != 2) continue;
        fputs(any ? "" : "<path class=\"light\" d=\"", c->out);
        mcv_put_points(c, ends, 2);
        any = true;
    }
    if (any) fputs("\"/>\n", c->out);
    return any;
}

void mcv_put_outline(mcv_drawing *c, uint32_t instance, bool labelled) {
    size_t count;
    char label[MCV_LABEL];
    mcv_drawing_point *hull = mcv_drawing_hull(c, instance, &count);
    if (!hull) return;
    const char *name = c->scene->instances[instance].name;
    mcv_drawing_point top = hull[0];
    double range[2] = {INFINITY, -INFINITY};
    for (size_t i = 0; i < count; ++i) {
        if (hull[i].height > top.height) top = hull[i];
        range[0] = fmin(range[0], fmax(hull[i].depth, c->depth[0]));
        range[1] = fmax(range[1], fmin(hull[i].depth, c->depth[1]));
    }
    const bool cut = c->scene->instances[instance].emitter != MCV_NONE && put_section(c, instance);
    fprintf(c->out, "<path class=\"%s\" d=\"", cut ? "beyond" : class_of(c->scene, instance));
    mcv_put_points(c, hull, count);
    fputs("Z\"><title>", c->out);
    mcv_html_text(c->out, mcv_instance_label(c->scene, instance, label));
    fputs("</title></path>\n", c->out);
    if (labelled && *name) {
        mcv_put_name(c, mcv_drawing_x(c, 0.5 * (range[0] + range[1])),
                     mcv_drawing_y(c, top.height) - 6, name);
    }
    free(hull);
}
