/* SPDX-License-Identifier: Apache-2.0 */
#include "check/setup_page.h"

#include "check/find.h"
#include "core/basics.h"
#include "core/output_file.h"
#include "io/html.h"
#include "scene/emitters.h"
#include "scene/params.h"
#include "scene/transform.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Of a drawing [CSS pixels]: its width, the most and the least height of what is true to scale, a
 * row of dimensions. */
enum { WIDTH = 1040, MARGIN = 24, TALLEST = 420, LOWEST = 150, TOP = 10, ROW = 30, MOST_ROWS = 6 };
enum {
    LABELS = 8,
    MOST_NAMES = 32
}; /* parts that are named; the others tell their names where they are pointed at */
/* Fields that what lies beside one may widen a drawing to; where no part is in the field, it is
 * shown where they are. */
static const double reach = 2.5, far_reach = 15;

/* A point of a drawing [m]: depth from the lens, height above the axis. */
typedef struct point {
    double depth, height;
} point;

/* What a view is drawn on. */
typedef struct canvas {
    FILE *out;
    const mcv_scene *scene;
    const mcv_view *view;
    bool from_above;
    double film[2];  /* of the view, along the drawing's height */
    double focus;    /* depth of the plane in focus, or NaN */
    double film_at;  /* depth of the film [m], negative */
    double lens;     /* half its width [m] */
    double depth[2]; /* what is shown [m] */
    double height[2];
    double scale[2]; /* CSS pixels per metre along depth and height */
    double left, bottom;
    int number, rows;
    struct {
        double x, y, half; /* [CSS pixels] */
    } names[MOST_NAMES];
    int name_count;
} canvas;

static double x_of(const canvas *c, double depth) {
    return c->left + (depth - c->depth[0]) * c->scale[0];
}
static double y_of(const canvas *c, double height) {
    return TOP + (c->height[1] - height) * c->scale[1];
}

/* From above, what is to the right of the camera lies below its axis. */
static point to_drawing(const canvas *c, const double world[3]) {
    double local[3];
    mcv_view_point(c->view, world, local);
    return (point){local[2], c->from_above ? -local[0] : local[1]};
}

/* --- outlines
 * ---------------------------------------------------------------------------------------------------
 */

static int compare_points(const void *a, const void *b) {
    const point *p = a, *q = b;
    if (p->depth != q->depth) return p->depth < q->depth ? -1 : 1;
    return p->height < q->height ? -1 : p->height > q->height;
}

static double turn(point a, point b, point p) {
    return (b.depth - a.depth) * (p.height - a.height) -
           (b.height - a.height) * (p.depth - a.depth);
}

/* The convex hull of an instance's vertices in the drawing (Andrew 1979); NULL without memory. */
static point *hull_of(const canvas *c, uint32_t instance, size_t *count) {
    const size_t vertices = c->scene->meshes[c->scene->instances[instance].mesh].vertex_count;
    point *all = malloc((vertices + 1) * sizeof *all),
          *hull = malloc((2 * vertices + 2) * sizeof *hull);
    *count = 0;
    for (size_t v = 0; all && hull && v < vertices; ++v) {
        double world[3];
        mcv_scene_vertex(c->scene, instance, (uint32_t)v, world);
        all[v] = to_drawing(c, world);
    }
    if (all && hull && vertices > 0) {
        size_t n = 0;
        qsort(all, vertices, sizeof *all, compare_points);
        for (int upper = 0; upper < 2; ++upper) {
            const size_t base = n;
            for (size_t i = 0; i < vertices; ++i) {
                const point p = all[upper ? vertices - 1 - i : i];
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

/* Without points that nobody could tell from the one before. */
static void put_points(const canvas *c, const point *points, size_t count) {
    double x = 0, y = 0;
    for (size_t i = 0; i < count; ++i) {
        const double to_x = x_of(c, points[i].depth), to_y = y_of(c, points[i].height);
        if (i > 0 && i + 1 < count && fabs(to_x - x) + fabs(to_y - y) < 0.5) continue;
        fprintf(c->out, "%s%.1f %.1f", i ? "L" : "M", to_x, to_y);
        x = to_x;
        y = to_y;
    }
}

static void put_label(const canvas *c, const char *class, double x, double y, const char *anchor,
                      const char *text) {
    fprintf(c->out, "<text class=\"%s\" x=\"%.1f\" y=\"%.1f\" text-anchor=\"%s\">", class, x, y,
            anchor);
    mcv_html_text(c->out, text);
    fputs("</text>\n", c->out);
}

/* Where a text's middle must be for it not to leave the drawing. */
static double inside(const canvas *c, double x, const char *text) {
    const double half = 3.6 * (double)strlen(text) + 4;
    return fmin(fmax(x, x_of(c, c->depth[0]) + half), x_of(c, c->depth[1]) - half);
}

/* Above a place; left out where it would run into another name. */
static void put_name(canvas *c, double x, double y, const char *name) {
    const double half = 3.6 * (double)strlen(name) + 2;
    x = inside(c, x, name);
    y = fmax(y, TOP + 12);
    for (int i = 0; i < c->name_count; ++i)
        if (fabs(x - c->names[i].x) < half + c->names[i].half && fabs(y - c->names[i].y) < 13)
            return;
    if (c->name_count == MOST_NAMES) return;
    c->names[c->name_count].x = x;
    c->names[c->name_count].y = y;
    c->names[c->name_count++].half = half;
    put_label(c, "name", x, y, "middle", name);
}

static const char *class_of(const mcv_scene *scene, uint32_t instance) {
    if (scene->instances[instance].emitter != MCV_NONE) return "light";
    switch (scene->materials[scene->instances[instance].material].type) {
    case MCV_MATERIAL_DIELECTRIC:
    case MCV_MATERIAL_SHEET:
        return "glass";
    case MCV_MATERIAL_MIRROR:
    case MCV_MATERIAL_BEAM_SPLITTER:
        return "mirror";
    default:
        return mcv_is_part(scene, instance) ? "part" : "housing";
    }
}

/* Where the mesh crosses the plane of the drawing, in which the axis lies: of a ring its two sides.
 * False where it does not. */
static bool put_section(const canvas *c, uint32_t instance) {
    const uint32_t triangles = c->scene->meshes[c->scene->instances[instance].mesh].triangle_count;
    bool any = false;
    for (uint32_t t = 0; t < triangles; ++t) {
        double corners[3][3], aside[3];
        point ends[3];
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
            const point a = to_drawing(c, corners[k]), b = to_drawing(c, corners[next]);
            ends[count++] = (point){a.depth + share * (b.depth - a.depth),
                                    a.height + share * (b.height - a.height)};
        }
        if (count != 2) continue;
        fputs(any ? "" : "<path class=\"light\" d=\"", c->out);
        put_points(c, ends, 2);
        any = true;
    }
    if (any) fputs("\"/>\n", c->out);
    return any;
}

static void put_outline(canvas *c, uint32_t instance, bool labelled) {
    size_t count;
    char label[MCV_LABEL];
    point *hull = hull_of(c, instance, &count);
    if (!hull) return;
    const char *name = c->scene->instances[instance].name;
    point top = hull[0];
    double range[2] = {INFINITY, -INFINITY};
    for (size_t i = 0; i < count; ++i) {
        if (hull[i].height > top.height) top = hull[i];
        range[0] = fmin(range[0], fmax(hull[i].depth, c->depth[0]));
        range[1] = fmax(range[1], fmin(hull[i].depth, c->depth[1]));
    }
    const bool cut = c->scene->instances[instance].emitter != MCV_NONE && put_section(c, instance);
    fprintf(c->out, "<path class=\"%s\" d=\"", cut ? "beyond" : class_of(c->scene, instance));
    put_points(c, hull, count);
    fputs("Z\"><title>", c->out);
    mcv_html_text(c->out, mcv_instance_label(c->scene, instance, label));
    fputs("</title></path>\n", c->out);
    if (labelled && *name) {
        put_name(c, x_of(c, 0.5 * (range[0] + range[1])), y_of(c, top.height) - 6, name);
    }
    free(hull);
}

/* --- lights
 * -----------------------------------------------------------------------------------------------------
 */

/* The mean direction in which an instance faces, and how alike its faces are: 1 of a plane, 0 of a
 * ball. */
static double facing(const mcv_scene *scene, uint32_t instance, double normal[3]) {
    const uint32_t triangles = scene->meshes[scene->instances[instance].mesh].triangle_count;
    double area = 0;
    for (int k = 0; k < 3; ++k) normal[k] = 0;
    for (uint32_t t = 0; t < triangles; ++t) {
        double face[3];
        mcv_scene_face_normal(scene, instance, t, face);
        area += sqrt(mcv_dot3(face, face));
        for (int k = 0; k < 3; ++k) normal[k] += face[k];
    }
    const double length = sqrt(mcv_dot3(normal, normal));
    return area > 0 ? length / area : 0;
}

/* The light of a surface: from its two ends as far as a share of the drawing, with the half-angle
 * of its cone. */
static void put_beam(const canvas *c, uint32_t emitter) {
    const mcv_emitter *e = c->scene->emitters + emitter;
    double normal[3], world[3];
    size_t count;
    if (e->instance == MCV_NONE || facing(c->scene, e->instance, normal) < 0.9) return;
    const double half_angle = mcv_emitter_half_angle(e);
    const bool collimated = e->type == MCV_EMITTER_COLLIMATED_BEAM;
    for (int k = 0; k < 3; ++k) world[k] = c->view->sensor->to_world.m[9 + k] + normal[k];
    const point n = to_drawing(c, world); /* a direction: seen from the lens */
    const double along = hypot(n.depth, n.height), whole = sqrt(mcv_dot3(normal, normal));
    point *hull = along > 0.7 * whole ? hull_of(c, e->instance, &count) : NULL;
    if (!hull) return;
    const double dz = n.depth / along, dh = n.height / along;
    point ends[2] = {hull[0], hull[0]};
    for (size_t i = 1; i < count; ++i) {
        const double across = hull[i].height * dz - hull[i].depth * dh;
        if (across < ends[0].height * dz - ends[0].depth * dh) ends[0] = hull[i];
        if (across > ends[1].height * dz - ends[1].depth * dh) ends[1] = hull[i];
    }
    const double angle = collimated ? 0 : isnan(half_angle) ? M_PI / 3 : fmin(half_angle, M_PI / 3);
    const double length =
                     (isnan(half_angle) && !collimated ? 0.06 : 0.2) * (c->depth[1] - c->depth[0]),
                 spread = length * tan(angle);
    const point far[2] = {
        {ends[0].depth + length * dz + spread * dh, ends[0].height + length * dh - spread * dz},
        {ends[1].depth + length * dz - spread * dh, ends[1].height + length * dh + spread * dz}};
    fputs("<path class=\"beam\" d=\"", c->out);
    put_points(c, (const point[]){ends[0], far[0], far[1], ends[1]}, 4);
    fputs("Z\"/>\n", c->out);
    free(hull);
}

/* Lights without extent. */
static void put_source(canvas *c, const mcv_emitter *e) {
    if (e->instance != MCV_NONE || (e->type != MCV_EMITTER_POINT && e->type != MCV_EMITTER_SPOT))
        return;
    const point at = to_drawing(c, e->to_world.m + 9);
    fprintf(c->out, "<circle class=\"light\" cx=\"%.1f\" cy=\"%.1f\" r=\"5\"><title>",
            x_of(c, at.depth), y_of(c, at.height));
    mcv_html_text(c->out, e->name);
    fputs("</title></circle>\n", c->out);
    put_name(c, x_of(c, at.depth), y_of(c, at.height) - 10, e->name);
}

/* --- rays
 * -------------------------------------------------------------------------------------------------------
 */

/* Rays of a point of the film, at `film` in the view's units, through the middle and the edges of
 * the pupil. */
static void put_rays(const canvas *c, int colour, double film) {
    const mcv_sensor *sensor = c->view->sensor;
    const double end = c->depth[1], b = -c->film_at;
    for (int k = -1; k <= 1; ++k) {
        double lens, far, image;
        if (c->view->is_telecentric) {
            const mcv_telecentric_params *p = &sensor->as.telecentric;
            const double slope = k * p->stopDiameter / (2 * p->focalLength);
            lens = film - slope * c->focus;
            far = film + slope * (end - c->focus);
            image = -p->magnification * film;
        } else {
            const double kappa = isfinite(c->focus) ? 1 / c->focus : 0;
            lens = k * c->lens;
            far = lens + end * (film - kappa * lens);
            image = -b * film;
        }
        if (k != 0 && c->lens == 0) continue; /* a pinhole */
        fprintf(c->out, "<path class=\"ray ray%d%s\" d=\"", colour, k ? "" : " chief");
        put_points(c, (const point[]){{c->film_at, image}, {0, lens}, {end, far}}, 3);
        fputs("\"/>\n", c->out);
    }
}

static void put_camera(canvas *c) {
    const bool telecentric = c->view->is_telecentric;
    const double scale = telecentric ? c->view->sensor->as.telecentric.magnification : -c->film_at;
    const double x = x_of(c, 0), bulge = fmin(14, fmax(4, 0.12 * c->lens * c->scale[1]));
    fprintf(c->out, "<path class=\"film\" d=\"M%.1f %.1fV%.1f\"><title>film</title></path>\n",
            x_of(c, c->film_at), y_of(c, -scale * c->film[0]), y_of(c, -scale * c->film[1]));
    if (c->lens > 0)
        fprintf(c->out,
                "<path class=\"lens\" d=\"M%.1f %.1fQ%.1f %.1f %.1f %.1fQ%.1f %.1f %.1f "
                "%.1fZ\"><title>main lens</title></path>\n",
                x, y_of(c, c->lens), x + bulge, y_of(c, 0), x, y_of(c, -c->lens), x - bulge,
                y_of(c, 0), x, y_of(c, c->lens));
    else
        fprintf(
            c->out,
            "<path class=\"film\" d=\"M%.1f %.1fv-12m0 28v-12\"><title>pinhole</title></path>\n", x,
            y_of(c, 0) - 2);
    if (telecentric) {
        const mcv_telecentric_params *p = &c->view->sensor->as.telecentric;
        const double at = x_of(c, -p->focalLength), half = p->stopDiameter / 2;
        fprintf(c->out,
                "<path class=\"film\" d=\"M%.1f %.1fV%.1fM%.1f "
                "%.1fV%.1f\"><title>stop</title></path>\n",
                at, y_of(c, half), y_of(c, fmax(half * 1.5, 0.6 * c->lens)), at, y_of(c, -half),
                y_of(c, -fmax(half * 1.5, 0.6 * c->lens)));
    }
    put_name(c, x, y_of(c, c->lens) - 8, c->view->sensor->name);
}

/* --- dimensions
 * -------------------------------------------------------------------------------------------------
 */

/* An arrow between two depths in the next row below the drawing. */
static void put_dimension(canvas *c, const char *class, double from, double to, const char *text) {
    const double y = c->bottom + 24 + ROW * c->rows++, a = x_of(c, from), b = x_of(c, to),
                 width = c->left + (c->depth[1] - c->depth[0]) * c->scale[0];
    const double letters = 7.0 * (double)strlen(text);
    fprintf(c->out,
            "<path class=\"dimension %s\" d=\"M%.1f %.1fH%.1fM%.1f %.1fv12M%.1f %.1fv12\"/>\n",
            class, a, y, b, a, y - 6, b, y - 6);
    if (b - a > letters + 12)
        put_label(c, "over", (a + b) / 2, y - 5, "middle", text);
    else if (b + letters + 12 < width)
        put_label(c, "size", b + 8, y + 4, "start", text);
    else
        put_label(c, "size", a - 8, y + 4, "end", text);
}

static void put_field(const canvas *c) {
    const double depth = c->view->is_telecentric ? 1 : c->focus, low = c->film[0] * depth,
                 high = c->film[1] * depth;
    char text[2][32], words[96];
    const double x = x_of(c, c->focus), *dof = c->view->optics.depth_of_field;
    if (isfinite(dof[0])) {
        const double from = x_of(c, fmax(dof[0], c->depth[0])),
                     to = x_of(c, fmin(dof[1], c->depth[1]));
        fprintf(c->out,
                "<rect class=\"sharp\" x=\"%.1f\" y=\"%.1f\" width=\"%.1f\" "
                "height=\"%.1f\"><title>depth of field</title></rect>\n",
                from, y_of(c, high), fmax(1, to - from), y_of(c, low) - y_of(c, high));
    }
    fprintf(c->out,
            "<path class=\"focus\" d=\"M%.1f %.1fV%.1fm-5 0h10M%.1f %.1fh10\"><title>plane in "
            "focus</title></path>\n",
            x, y_of(c, high), y_of(c, low), x - 5, y_of(c, high));
    snprintf(words, sizeof words, "field %s%s", mcv_length_in_words(high - low, text[0]),
             c->from_above ? " wide" : " high");
    put_label(c, "focus-text", inside(c, x, words), fmin(y_of(c, low) + 16, c->bottom - 3),
              "middle", words);
}

static void put_dimensions(canvas *c, const double parts[2]) {
    const mcv_optics *o = &c->view->optics;
    char text[2][32], words[160];
    if (isfinite(c->focus) && c->focus > 0) {
        snprintf(words, sizeof words, "working distance %s",
                 mcv_length_in_words(c->focus, text[0]));
        put_dimension(c, "of-focus", 0, c->focus, words);
        const double far = o->depth_of_field[1];
        snprintf(words, sizeof words, "depth of field %s to %s",
                 mcv_length_in_words(o->depth_of_field[0], text[0]),
                 isfinite(far) ? mcv_length_in_words(far, text[1]) : "infinity");
        if (isfinite(o->depth_of_field[0]))
            put_dimension(c, "of-focus", fmax(o->depth_of_field[0], c->depth[0]),
                          fmin(far, c->depth[1]), words);
    }
    if (parts[0] < parts[1]) {
        const bool thin = parts[1] - parts[0] < 1e-3 * parts[1];
        mcv_length_in_words(parts[0], text[0]);
        snprintf(words, sizeof words, "parts %s %s%s%s", thin ? "at" : "from", text[0],
                 thin ? "" : " to ", thin ? "" : mcv_length_in_words(parts[1], text[1]));
        put_dimension(c, "of-part", fmax(parts[0], c->depth[0]), fmin(parts[1], c->depth[1]),
                      words);
    }
    for (uint32_t i = 0; i < c->scene->emitter_count && c->rows < MOST_ROWS; ++i) {
        const mcv_emitter *e = c->scene->emitters + i;
        double at;
        if (e->instance != MCV_NONE)
            at = mcv_view_extent(c->view, c->scene, e->instance).middle[2];
        else if (e->type == MCV_EMITTER_POINT || e->type == MCV_EMITTER_SPOT)
            at = to_drawing(c, e->to_world.m + 9).depth;
        else
            continue;
        const char *name = *e->name ? e->name : "light";
        snprintf(words, sizeof words, "%.*s at %s", mcv_whole_characters(name, 60), name,
                 mcv_length_in_words(fabs(at), text[0]));
        if (at < 0)
            snprintf(words + strlen(words), sizeof words - strlen(words), " behind the lens");
        if (at > c->depth[0] && at < c->depth[1])
            put_dimension(c, "of-light", fmin(0, at), fmax(0, at), words);
    }
}

/* --- one drawing
 * ------------------------------------------------------------------------------------------------
 */

static void extend(double range[2], double value, double low, double high) {
    if (!isfinite(value)) return;
    range[0] = fmin(range[0], fmax(value, low));
    range[1] = fmax(range[1], fmin(value, high));
}

/* What is drawn: the sensor, what is in its field, the plane in focus, and lights and parts as far
 * as they are near. */
static bool frame(canvas *c, double parts[2]) {
    double deepest = isfinite(c->focus) && c->focus > 0 ? c->focus : 0;
    parts[0] = INFINITY;
    parts[1] = -INFINITY;
    for (uint32_t i = 0; i < c->scene->instance_count; ++i) {
        const mcv_extent e = mcv_view_extent(c->view, c->scene, i);
        if (!mcv_is_part(c->scene, i) || !mcv_view_shows(c->view, &e)) continue;
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
        point *hull = hull_of(c, i, &count);
        if (!hull) return false;
        for (size_t k = 0; k < count; ++k) {
            extend(c->depth, hull[k].depth, -0.8 * deepest, 1.8 * deepest);
            extend(c->height, hull[k].height, -most, most);
        }
        free(hull);
    }
    for (uint32_t i = 0; i < c->scene->emitter_count; ++i) {
        const mcv_emitter *e = c->scene->emitters + i;
        if (e->type != MCV_EMITTER_POINT && e->type != MCV_EMITTER_SPOT) continue;
        const point at = to_drawing(c, e->to_world.m + 9);
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

/* True to scale, but for heights that would be too low to see anything: *stretch says how much they
 * are drawn larger. */
static void fit(canvas *c, double *stretch) {
    const double depth = c->depth[1] - c->depth[0], height = c->height[1] - c->height[0];
    const double scale = fmin((WIDTH - 2 * MARGIN) / depth, TALLEST / height);
    *stretch = 1;
    for (int i = 1; *stretch * scale * height < LOWEST && i < 30; ++i)
        *stretch *= i % 3 == 2 ? 2.5 : 2; /* 1 2 5 10 20 50 … */
    c->scale[0] = scale;
    c->scale[1] = *stretch * scale;
    c->left = (WIDTH - scale * depth) / 2;
    c->bottom = TOP + c->scale[1] * height;
}

static double area_of(const mcv_scene *scene, uint32_t i) {
    double lower[3], upper[3];
    mcv_scene_box(scene, i, lower, upper);
    return hypot(hypot(upper[0] - lower[0], upper[1] - lower[1]), upper[2] - lower[2]);
}

/* Is an instance one of the few largest that are named? Lights are in any case, once per node. */
static bool is_named(const mcv_scene *scene, uint32_t instance) {
    uint32_t larger = 0;
    if (instance > 0 &&
        strcmp(scene->instances[instance - 1].name, scene->instances[instance].name) == 0)
        return false;
    if (!mcv_is_part(scene, instance)) return true;
    for (uint32_t i = 0; i < scene->instance_count && larger < LABELS; ++i)
        larger +=
            i != instance && mcv_is_part(scene, i) && area_of(scene, i) > area_of(scene, instance);
    return larger < LABELS;
}

static bool put_drawing(canvas *c) {
    double parts[2], stretch;
    if (!frame(c, parts)) return false;
    fit(c, &stretch);
    char *body = NULL;
    size_t size = 0;
    FILE *page = c->out;
    if (!(c->out = open_memstream(&body, &size))) return false;
    fprintf(c->out, "<g clip-path=\"url(#frame%d)\">\n", c->number);
    for (uint32_t i = 0; i < c->scene->emitter_count; ++i) put_beam(c, i);
    put_camera(c);
    if (isfinite(c->focus) && c->focus > 0) put_field(c);
    for (uint32_t i = 0; i < c->scene->instance_count; ++i)
        put_outline(c, i, is_named(c->scene, i));
    for (uint32_t i = 0; i < c->scene->emitter_count; ++i) put_source(c, c->scene->emitters + i);
    fprintf(c->out, "<path class=\"axis\" d=\"M%.1f %.1fH%.1f\"/>\n", x_of(c, c->depth[0]),
            y_of(c, 0), x_of(c, c->depth[1]));
    const double film[3] = {c->film[0], 0.5 * (c->film[0] + c->film[1]), c->film[1]};
    for (int k = 0; k < 3; ++k) put_rays(c, k, film[k]);
    fputs("</g>\n", c->out);
    put_dimensions(c, parts);
    fclose(c->out);
    c->out = page;
    const double width = c->scale[0] * (c->depth[1] - c->depth[0]),
                 height = c->bottom + 20 + ROW * c->rows;
    fprintf(page, "<figure><figcaption>From %s%s", c->from_above ? "above" : "the side",
            stretch > 1 ? "" : ", true to scale");
    if (stretch > 1) fprintf(page, ", heights %g times larger than depths", stretch);
    fprintf(page,
            "</figcaption>\n<svg viewBox=\"0 0 %d %.0f\" role=\"img\" aria-label=\"The set-up from "
            "%s\">\n",
            WIDTH, height, c->from_above ? "above" : "the side");
    fprintf(page,
            "<clipPath id=\"frame%d\"><rect x=\"%.1f\" y=\"%d\" width=\"%.1f\" "
            "height=\"%.1f\"/></clipPath>\n",
            c->number, c->left, TOP, width, c->bottom - TOP);
    fprintf(page, "<rect class=\"ground\" x=\"%.1f\" y=\"%d\" width=\"%.1f\" height=\"%.1f\"/>\n",
            c->left, TOP, width, c->bottom - TOP);
    fputs(body ? body : "", page);
    fputs("</svg></figure>\n", page);
    free(body);
    return true;
}

static void put_row(FILE *out, const char *key, const char *value) {
    fprintf(out, "<tr><th>%s<td>", key);
    mcv_html_text(out, value);
    fputs("\n", out);
}

static void put_numbers(FILE *out, const mcv_view *view) {
    const mcv_optics *o = &view->optics;
    uint32_t width, height;
    char text[2][32], words[96];
    mcv_sensor_film_size(view->sensor, &width, &height);
    fputs("<table>\n", out);
    snprintf(words, sizeof words, "%u x %u pixels", width, height);
    put_row(out, "image", words);
    if (isfinite(o->field[0])) {
        snprintf(words, sizeof words, "%s x %s", mcv_length_in_words(o->field[0], text[0]),
                 mcv_length_in_words(o->field[1], text[1]));
        put_row(out, "field in focus", words);
        put_row(out,
                view->sensor->type == MCV_SENSOR_LIGHT_FIELD ? "a macro pixel there"
                                                             : "a pixel there",
                mcv_length_in_words(mcv_view_pixel(view, fabs(o->focused_depth)), text[0]));
    }
    const struct {
        const char *key;
        double value;
    } numbers[] = {{"magnification", o->magnification},
                   {"f-number, working", o->f_number},
                   {"numerical aperture", o->numerical_aperture}};
    for (size_t i = 0; i < sizeof numbers / sizeof numbers[0]; ++i) {
        snprintf(words, sizeof words, "%.4g", numbers[i].value);
        if (!isnan(numbers[i].value)) put_row(out, numbers[i].key, words);
    }
    fputs("</table>\n", out);
}

static bool put_sensor(FILE *out, const mcv_scene *scene, uint32_t index) {
    const mcv_sensor *sensor = scene->sensors + index;
    const mcv_view view = mcv_view_of(sensor);
    if (isnan(view.film[0][0])) return true; /* a type whose optics nobody knows here */
    fputs("<section><h2>", out);
    mcv_html_text(out, sensor->name);
    fprintf(out, " <small>%s</small></h2>\n", mcv_sensor_types[sensor->type]);
    put_numbers(out, &view);
    for (int above = 0; above < 2; ++above) {
        const int axis = above ? 0 : 1;
        canvas c = {.out = out,
                    .scene = scene,
                    .view = &view,
                    .from_above = above,
                    .focus = view.optics.focused_depth,
                    .number = (int)(2 * index) + above};
        c.film[0] = above ? -view.film[axis][1] : view.film[axis][0];
        c.film[1] = above ? -view.film[axis][0] : view.film[axis][1];
        switch (sensor->type) {
        case MCV_SENSOR_THIN_LENS:
            c.film_at = -sensor->as.thin_lens.imageDistance;
            break;
        case MCV_SENSOR_LIGHT_FIELD:
            c.film_at = -sensor->as.light_field.imageDistance;
            break;
        case MCV_SENSOR_TELECENTRIC:
            c.film_at = -sensor->as.telecentric.imageDistance;
            break;
        default:
            c.film_at = -sensor->as.pinhole.imageDistance;
        }
        c.lens = sensor->type == MCV_SENSOR_LIGHT_FIELD ? sensor->as.light_field.lensDiameter / 2
                                                        : mcv_lens_radius(sensor);
        if (!put_drawing(&c)) return false;
    }
    fputs("</section>\n", out);
    return true;
}

/* --- the page
 * ---------------------------------------------------------------------------------------------------
 */

static const char style[] =
    ":root{--ink:#1d2733;--soft:#5b6775;--page:#fff;--ground:#f6f8fa;--line:#c9d1da;--part:#8a94a0;"
    "--glass:#7fb6d9;--light:#e69a00;"
    "--focus:#00856f;--ray0:#0072b2;--ray1:#56789b;--ray2:#b0418f;--bad:#b3261e;--warn:#9a6700;--"
    "note:#3b6ea5}\n"
    "@media(prefers-color-scheme:dark){:root{--ink:#e6ebf0;--soft:#9fabb8;--page:#14191f;--ground:#"
    "1c232b;--line:#3a4550;--part:#77828e;"
    "--glass:#4b86ab;--light:#f0b43c;--focus:#3fc6ac;--ray0:#58b0e8;--ray1:#8fb0d0;--ray2:#e080c0;-"
    "-bad:#ff8f86;--warn:#e3b341;--note:#"
    "86b6ea}}\n"
    "body{font:15px/1.5 system-ui,-apple-system,\"Segoe "
    "UI\",sans-serif;color:var(--ink);background:var(--page);margin:0 "
    "auto;max-width:1080px;"
    "padding:24px 20px 60px}\nh1{font-size:1.5em;margin:0 0 .1em}h2{font-size:1.2em;margin:2em 0 "
    ".4em}small{color:var(--soft);font-weight:400}\n"
    ".file{color:var(--soft);margin:0 0 "
    "1.2em}ul{list-style:none;padding:0;margin:0}li{border-left:4px solid "
    "var(--note);background:var(--ground);"
    "padding:8px 14px;margin:0 0 8px;border-radius:0 6px 6px "
    "0}li.warning{border-color:var(--warn)}li.error{border-color:var(--bad)}\n"
    "li b{color:var(--note);margin-right:.5em}li.warning b{color:var(--warn)}li.error "
    "b{color:var(--bad)}li "
    "code{color:var(--soft);font-size:12px;"
    "display:block}\ntable{border-collapse:collapse;font-size:14px;margin:.4em 0 "
    "1em;font-variant-numeric:tabular-nums}"
    "th{font-weight:400;color:var(--soft);text-align:left;padding:1px 18px 1px 0}td{padding:1px "
    "0}\n"
    "figure{margin:0 0 "
    "22px}figcaption{color:var(--soft);font-size:13px;margin-bottom:2px}svg{width:100%;height:auto;"
    "display:block}\n"
    "svg "
    "text{font-size:12px;fill:var(--ink);paint-order:stroke;stroke:var(--page);stroke-width:3px;"
    "stroke-linejoin:round}\n"
    ".ground{fill:var(--ground);stroke:var(--line)}\n"
    ".part,.housing,.glass,.mirror{fill:var(--part);fill-opacity:.45;stroke:var(--part);stroke-"
    "width:1.2}.glass{fill:var(--glass);"
    "stroke:var(--glass);fill-opacity:.35}.housing{fill-opacity:.1}.mirror{stroke-width:3}\n"
    ".light{fill:var(--light);fill-opacity:.25;stroke:var(--light);stroke-width:4;stroke-linejoin:"
    "round}.beyond{fill:none;stroke:var(--"
    "light);stroke-width:"
    "1.2;opacity:.5}.beam{fill:var(--light);fill-opacity:.16;stroke:"
    "none}\n"
    ".ray{fill:none;stroke-width:1;opacity:.75}.chief{stroke-width:1.8;opacity:1}.ray0{stroke:var(-"
    "-ray0)}.ray1{stroke:var(--ray1)}"
    ".ray2{stroke:var(--ray2)}\n.axis{stroke:var(--soft);stroke-dasharray:14 4 3 "
    "4;fill:none;opacity:.6}.film{stroke:var(--ink);stroke-width:3;"
    "fill:none}.lens{fill:var(--glass);fill-opacity:.45;stroke:var(--ink)}\n"
    ".focus{stroke:var(--focus);stroke-width:2;fill:none}.sharp{fill:var(--focus);fill-opacity:.18}"
    "svg .focus-text{fill:var(--focus)}\n"
    ".dimension{fill:none;stroke:var(--soft);stroke-width:1.2}.of-focus{stroke:var(--focus)}.of-"
    "light{stroke:var(--light)}\n"
    "svg .name{font-weight:600}@media print{body{max-width:none}figure{break-inside:avoid}}\n";

static bool put_page(FILE *out, const mcv_scene *scene, const mcv_findings *findings) {
    const char *slash = strrchr(scene->path, '/'), *name = slash ? slash + 1 : scene->path;
    fputs("<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta "
          "name=\"viewport\" content=\"width=device-width\">\n"
          "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; style-src "
          "'unsafe-inline'\">\n<title>",
          out);
    mcv_html_text(out, name);
    fprintf(out, "</title>\n<style>\n%s</style></head><body>\n<h1>", style);
    mcv_html_text(out, name);
    fprintf(out, "</h1>\n<p class=\"file\">%u triangles, %u %s, %u %s</p>\n", scene->triangle_count,
            scene->sensor_count, scene->sensor_count == 1 ? "sensor" : "sensors",
            scene->emitter_count, scene->emitter_count == 1 ? "emitter" : "emitters");
    if (findings->count == 0) fputs("<p>Nothing was found that is likely not meant.</p>\n", out);
    fputs("<ul>\n", out);
    for (mcv_severity severity = MCV_SEVERITY_ERROR + 1; severity-- > 0;)
        for (size_t i = 0; i < findings->count; ++i) {
            if (findings->items[i].severity != severity) continue;
            fprintf(out, "<li class=\"%s\"><b>%s</b>", mcv_severities[severity],
                    mcv_severities[severity]);
            mcv_html_text(out, findings->items[i].sentence);
            if (*findings->items[i].path) {
                fputs("<code>", out);
                mcv_html_text(out, findings->items[i].path);
                fputs("</code>", out);
            }
            fputs("</li>\n", out);
        }
    fputs("</ul>\n", out);
    for (uint32_t i = 0; i < scene->sensor_count; ++i)
        if (!put_sensor(out, scene, i)) return false;
    fputs("<p class=\"file\">Rays are those of first-order optics, from the edges and the middle "
          "of the film; bodies are drawn as their "
          "convex "
          "hulls, and glass does not bend rays here.</p>\n</body></html>\n",
          out);
    return true;
}

mcv_result mcv_setup_page_write(const char *path, const mcv_scene *scene,
                                const mcv_findings *findings, mcv_error *error) {
    char *text = NULL;
    size_t size = 0;
    FILE *stream = open_memstream(&text, &size);
    const bool written = stream && put_page(stream, scene, findings);
    if (!stream || fclose(stream) != 0 || !written) {
        free(text);
        return mcv_fail(error, MCV_FAILED, "%s: no memory to write it", path);
    }
    const mcv_result result = mcv_output_whole(path, text, size, error);
    free(text);
    return result;
}
