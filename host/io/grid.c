/* SPDX-License-Identifier: Apache-2.0 */
#include "io/grid.h"

#include "core/basics.h"
#include "io/figure.h"
#include "io/png.h"

#include <math.h>
#include <stdio.h>

/* Room about the image for the numbers; letters and the least longer side of the image [pixel of
 * the page]. */
enum {
    ROOM_LEFT = 48,
    ROOM_TOP = 48,
    ROOM_RIGHT = 72,
    ROOM_BOTTOM = 28,
    LETTERS = 12,
    LEAST = 640
};

enum { LINES = 8 };

double mcv_grid_step(double span, double count) {
    const double least = span / count, decade = pow(10, floor(log10(least)));
    return decade * (least <= 1.0000001 * decade   ? 1
                     : least <= 2.0000001 * decade ? 2
                     : least <= 5.0000001 * decade ? 5
                                                   : 10);
}

void mcv_grid_coordinates(const mcv_camera_model *model, const mcv_placement *node,
                          double a[3][3]) {
    const double *m = node->to_world.m;
    const bool focused = isfinite(model->focused_depth) && model->focused_depth > 0;
    const double depth = focused ? model->focused_depth : mcv_camera_model_depth(model, m + 9);
    double at[3][3]; /* the places (0, 0), (1, 0) and (0, 1) in the world */
    for (int p = 0; p < 3; ++p)
        mcv_camera_model_unproject(model, (const double[2]){p == 1, p == 2}, depth, at[p]);
    for (int k = 0; k < 3; ++k) {
        double local[3];
        for (int p = 0; p < 3; ++p) {
            local[p] = 0; /* the axes are unit, if not always at right angles */
            for (int i = 0; i < 3; ++i) local[p] += m[3 * i + k] * (at[p][i] - m[9 + i]);
        }
        a[k][0] = local[1] - local[0];
        a[k][1] = local[2] - local[0];
        a[k][2] = local[0];
    }
}

/* A pixel's number, or a coordinate in mm, as few digits as it takes. */
static void put_number(const mcv_grid *grid, double x, double y, double align, const char *before,
                       double value) {
    char text[64];
    snprintf(text, sizeof text, "%s%.6g", before, value + 0.0);
    mcv_page_text(grid->page, x, y, align, text);
}

static void draw_pixels(const mcv_grid *grid) {
    cairo_t *page = grid->page;
    const uint32_t size[2] = {grid->width, grid->height};
    cairo_set_source_rgb(page, 0, 0, 0);
    cairo_set_line_width(page, 1);
    for (int axis = 0; axis < 2; ++axis) {
        const double step = mcv_grid_step(fmax(size[0], size[1]), 1.5 * LINES);
        for (double pixel = 0; pixel <= size[axis]; pixel += fmax(1, step)) {
            const double at = grid->zoom * pixel;
            if (axis == 0)
                put_number(grid, grid->left + at, grid->top - 8, 0.5, "", pixel);
            else
                put_number(grid, grid->left - 8, grid->top + at + 0.35 * LETTERS, 1, "", pixel);
            cairo_move_to(page, grid->left + (axis == 0 ? at : -5),
                          grid->top + (axis == 0 ? -5 : at));
            cairo_rel_line_to(page, axis == 0 ? 0 : 5, axis == 0 ? 5 : 0);
            cairo_stroke(page);
        }
    }
}

/* Where the line a column + b row = c leaves the image: the first end on the left or the upper
 * side. False where it misses it. */
static bool clip(const mcv_grid *grid, double a, double b, double c, double ends[2][2]) {
    const double w = grid->width, h = grid->height;
    const double places[4][2] = {
        {0, c / b}, {c / a, 0}, {w, (c - a * w) / b}, {(c - b * h) / a, h}};
    int count = 0;
    for (int i = 0; i < 4 && count < 2; ++i) {
        const double x = places[i][0], y = places[i][1];
        if (!(x >= 0 && x <= w && y >= 0 && y <= h)) continue;
        if (count == 1 && hypot(x - ends[0][0], y - ends[0][1]) < 1e-6 * (w + h)) continue;
        ends[count][0] = x;
        ends[count++][1] = y;
    }
    return count == 2;
}

/* Lines of one coordinate; their numbers stand below the image or to its right. */
static void draw_lines(const mcv_grid *grid, const double a[3], const char *name,
                       const double colour[3]) {
    const double w = grid->width, h = grid->height;
    double low = INFINITY, high = -INFINITY, ends[2][2];
    for (int corner = 0; corner < 4; ++corner) {
        const double value = a[0] * (corner % 2) * w + a[1] * (corner >> 1) * h + a[2];
        low = fmin(low, value);
        high = fmax(high, value);
    }
    const double step = mcv_grid_step(high - low, LINES);
    const bool upright = fabs(a[0]) >= fabs(a[1]);
    char before[16];
    snprintf(before, sizeof before, "%s ", name);
    for (int line = 0; line <= LINES;
         ++line) { /* so many at the most: steps from far off may be less than rounding */
        const double value = step * (ceil(low / step) + line);
        if (!(value <= high) || !clip(grid, a[0], a[1], value - a[2], ends)) continue;
        cairo_set_source_rgba(grid->page, colour[0], colour[1], colour[2], 0.6);
        cairo_move_to(grid->page, grid->left + grid->zoom * ends[0][0],
                      grid->top + grid->zoom * ends[0][1]);
        cairo_line_to(grid->page, grid->left + grid->zoom * ends[1][0],
                      grid->top + grid->zoom * ends[1][1]);
        cairo_stroke(grid->page);
        cairo_set_source_rgb(grid->page, colour[0], colour[1], colour[2]);
        const int last = upright ? ends[1][1] >= ends[0][1]
                                 : ends[1][0] >= ends[0][0]; /* the lower, the right one */
        const double x = grid->left + grid->zoom * ends[last][0],
                     y = grid->top + grid->zoom * ends[last][1];
        put_number(grid, x + (upright ? 0 : 6), y + (upright ? 16 : 0.35 * LETTERS),
                   upright ? 0.5 : 0, before, 1e3 * value);
    }
}

static void draw_node(const mcv_grid *grid, const mcv_camera_model *model,
                      const mcv_placement *node) {
    static const char *const names[] = {"x", "y", "z"};
    static const double colours[2][3] = {{0.85, 0.25, 0.1}, {0.1, 0.35, 0.85}};
    double a[3][3];
    char title[256];
    int hidden = 0, shown = 0;
    mcv_grid_coordinates(model, node, a);
    for (int k = 1; k < 3; ++k)
        if (hypot(a[k][0], a[k][1]) < hypot(a[hidden][0], a[hidden][1])) hidden = k;
    const double middle =
        a[hidden][0] * grid->width / 2 + a[hidden][1] * grid->height / 2 + a[hidden][2];
    for (int k = 0; k < 3; ++k)
        if (k != hidden) draw_lines(grid, a[k], names[k], colours[shown++]);
    cairo_set_source_rgb(grid->page, 0, 0, 0);
    snprintf(title, sizeof title,
             "mm of node %.*s, in the plane in focus: %s = %.4g mm in its middle",
             mcv_whole_characters(node->name, 128), node->name, names[hidden], 1e3 * middle + 0.0);
    mcv_page_text(grid->page, grid->left, 16, 0, title);
}

mcv_result mcv_grid_begin(mcv_grid *grid, const mcv_image *image, const mcv_camera_model *model,
                          const mcv_placement *node, mcv_error *error) {
    const double longer = fmax(image->width, image->height);
    const mcv_color_scale scale = {
        .map = MCV_COLORMAP_GREY, .low = 0, .high = mcv_preview_white(image)};
    *grid = (mcv_grid){.left = ROOM_LEFT,
                       .top = ROOM_TOP,
                       .zoom = fmax(1, ceil(LEAST / longer)),
                       .width = image->width,
                       .height = image->height};
    MCV_TRY(mcv_page_new(
        &grid->page, (uint32_t)(grid->zoom * image->width) + ROOM_LEFT + ROOM_RIGHT,
        (uint32_t)(grid->zoom * image->height) + ROOM_TOP + ROOM_BOTTOM, LETTERS, error));
    mcv_page_image(grid->page, ROOM_LEFT, ROOM_TOP, image, (uint32_t)grid->zoom, &scale);
    draw_pixels(grid);
    if (model && node) draw_node(grid, model, node);
    return MCV_OK;
}

void mcv_grid_box(mcv_grid *grid, const char *name, const double box[4]) {
    const double x = grid->left + grid->zoom * box[0], y = grid->top + grid->zoom * box[1];
    cairo_set_source_rgb(grid->page, 0, 0.6, 0.2);
    cairo_rectangle(grid->page, x, y, grid->zoom * box[2], grid->zoom * box[3]);
    cairo_stroke(grid->page);
    mcv_page_text(grid->page, x, y - 3, 0, name);
}

mcv_result mcv_grid_write(mcv_grid *grid, const char *path, mcv_error *error) {
    return mcv_page_write(grid->page, path, error);
}
