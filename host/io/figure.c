/* SPDX-License-Identifier: Apache-2.0 */
#include "io/figure.h"
#include "core/output_file.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* --- the page --- */

mcv_result mcv_page_new(cairo_t **page, uint32_t width, uint32_t height, double size,
                        mcv_error *error) {
    cairo_surface_t *surface =
        cairo_image_surface_create(CAIRO_FORMAT_RGB24, (int)width, (int)height);
    *page = cairo_create(surface);
    cairo_surface_destroy(surface); /* the page keeps it */
    if (cairo_status(*page) != CAIRO_STATUS_SUCCESS) {
        const cairo_status_t status = cairo_status(*page);
        cairo_destroy(*page);
        *page = NULL;
        return mcv_fail(error, MCV_FAILED, "a picture of %u x %u pixels cannot be drawn: cairo: %s",
                        width, height, cairo_status_to_string(status));
    }
    cairo_set_source_rgb(*page, 1, 1, 1);
    cairo_paint(*page);
    cairo_set_source_rgb(*page, 0, 0, 0);
    cairo_select_font_face(*page, "sans-serif", CAIRO_FONT_SLANT_NORMAL, CAIRO_FONT_WEIGHT_NORMAL);
    cairo_set_font_size(*page, size);
    return MCV_OK;
}

typedef struct target {
    mcv_output output;
    mcv_error *error;
    mcv_result result;
} target;

static cairo_status_t on_write(void *user, const unsigned char *bytes, unsigned count) {
    target *t = user;
    t->result = mcv_output_write(&t->output, bytes, count, t->error);
    return t->result == MCV_OK ? CAIRO_STATUS_SUCCESS : CAIRO_STATUS_WRITE_ERROR;
}

static mcv_result write_page(cairo_t *page, const char *path, mcv_error *error) {
    target t = {.error = error, .result = MCV_OK};
    MCV_TRY(mcv_output_open(&t.output, path, error));
    const cairo_status_t status =
        cairo_surface_write_to_png_stream(cairo_get_target(page), on_write, &t);
    if (status == CAIRO_STATUS_SUCCESS) return mcv_output_commit(&t.output, error);
    mcv_output_discard(&t.output);
    if (t.result != MCV_OK) return t.result;
    return mcv_fail(error, MCV_FAILED, "%s: cairo: %s", path, cairo_status_to_string(status));
}

mcv_result mcv_page_write(cairo_t *page, const char *path, mcv_error *error) {
    const mcv_result result = write_page(page, path, error);
    cairo_destroy(page);
    return result;
}

void mcv_page_text(cairo_t *page, double x, double y, double align, const char *text) {
    cairo_text_extents_t extents;
    cairo_text_extents(page, text, &extents);
    cairo_move_to(page, x - align * extents.x_advance, y);
    cairo_show_text(page, text);
    cairo_new_path(page);
}

/* --- images and bars --- */

/* Grey with darker diagonals: no colour of a scale. */
static uint32_t hatch(uint32_t x, uint32_t y) { return (x + y) % 6 < 2 ? 0x909090 : 0xc8c8c8; }

void mcv_page_image(cairo_t *page, int x, int y, const mcv_image *image, uint32_t zoom,
                    const mcv_color_scale *scale) {
    cairo_surface_t *surface = cairo_image_surface_create(
        CAIRO_FORMAT_RGB24, (int)(image->width * zoom), (int)(image->height * zoom));
    unsigned char *bytes = cairo_image_surface_get_data(surface);
    if (bytes) { /* otherwise the page takes over the surface's error */
        const size_t stride = (size_t)cairo_image_surface_get_stride(surface);
        cairo_surface_flush(surface);
        for (uint32_t row = 0; row < image->height * zoom; ++row) {
            for (uint32_t column = 0; column < image->width * zoom; ++column) {
                const double value =
                    image->pixels[(size_t)(row / zoom) * image->width + column / zoom];
                const uint32_t rgb =
                    isnan(value) ? hatch(column, row)
                                 : mcv_colormap_rgb(scale->map, (value - scale->low) /
                                                                    (scale->high - scale->low));
                memcpy(bytes + row * stride + 4 * (size_t)column, &rgb, sizeof rgb);
            }
        }
        cairo_surface_mark_dirty(surface);
    }
    cairo_save(page);
    cairo_set_source_surface(page, surface, x, y);
    cairo_paint(page);
    cairo_restore(page);
    cairo_surface_destroy(surface);
}

/* The step of ticks: 1, 2 or 5 times a power of ten, for at most `count` intervals. */
static double tick_step(double range, double count) {
    const double power = pow(10, floor(log10(range / count)));
    const double rest = range / count / power;
    return power * (rest <= 1 ? 1 : rest <= 2 ? 2 : rest <= 5 ? 5 : 10);
}

void mcv_page_color_bar(cairo_t *page, int x, int y, int height, const char *label,
                        const mcv_color_scale *scale) {
    enum { BAR = 18, TICK = 5, GAP = 4 };
    const double range = scale->high - scale->low;
    cairo_font_extents_t font;
    cairo_font_extents(page, &font);
    cairo_save(page);
    for (int row = 0; row < height; ++row) {
        const uint32_t rgb = mcv_colormap_rgb(scale->map, 1 - (row + 0.5) / height);
        cairo_set_source_rgb(page, (rgb >> 16) / 255.0, (rgb >> 8 & 255) / 255.0,
                             (rgb & 255) / 255.0);
        cairo_rectangle(page, x, y + row, BAR, 1);
        cairo_fill(page);
    }
    cairo_restore(page);
    cairo_set_line_width(page, 1);
    cairo_rectangle(page, x + 0.5, y + 0.5, BAR, height - 1);
    cairo_stroke(page);
    const double step = tick_step(range, height / (3 * font.height));
    for (double tick = ceil(scale->low / step); tick * step <= scale->high + 1e-6 * range; ++tick) {
        char text[32];
        const double at = y + height * (scale->high - tick * step) / range;
        const double line = fmin(fmax(floor(at), y), y + height - 1) + 0.5;
        cairo_move_to(page, x + BAR, line);
        cairo_line_to(page, x + BAR + TICK, line);
        cairo_stroke(page);
        snprintf(text, sizeof text, "%.4g", tick * step);
        mcv_page_text(page, x + BAR + TICK + GAP, line + 0.35 * font.ascent, 0, text);
    }
    cairo_save(page);
    cairo_translate(page, x + MCV_COLOR_BAR_WIDTH - font.descent, y + 0.5 * height);
    cairo_rotate(page, -acos(0));
    mcv_page_text(page, 0, 0, 0.5, label);
    cairo_restore(page);
}

mcv_result mcv_figure_write(const char *path, const mcv_image *image, const char *title,
                            const char *label, const mcv_color_scale *scale, mcv_error *error) {
    enum { WIDTH = 640, MARGIN = 16, TITLE = 36 };
    const uint32_t zoom = image->width < WIDTH ? WIDTH / image->width : 1;
    const uint32_t width = image->width * zoom, height = image->height * zoom;
    cairo_t *page;
    MCV_TRY(mcv_page_new(&page, width + 3 * MARGIN + MCV_COLOR_BAR_WIDTH, height + TITLE + MARGIN,
                         14, error));
    mcv_page_text(page, MARGIN, TITLE - 12, 0, title);
    mcv_page_image(page, MARGIN, TITLE, image, zoom, scale);
    mcv_page_color_bar(page, (int)(2 * MARGIN + width), TITLE, (int)height, label, scale);
    return mcv_page_write(page, path, error);
}
