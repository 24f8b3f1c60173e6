/* SPDX-License-Identifier: Apache-2.0 */
/* Pictures of vectors: hue for direction. */
#include "io/figure.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "io/png.h"

enum { WIDTH = 640, MARGIN = 16, TITLE = 36, WHEEL = 44 };

/* Red to the right, then through yellow, green and blue against the clock; white in the middle. */
static void colour_of(double x, double y, double high, double rgb[3]) {
    const double hue = (atan2(-y, x) / M_PI + (atan2(-y, x) < 0 ? 2 : 0)) * 3,
                 strength = fmin(1, hypot(x, y) / high);
    for (int c = 0; c < 3; ++c) {
        double apart = fabs(hue - 2 * c);
        if (apart > 3) apart = 6 - apart;
        rgb[c] = 1 - strength * (1 - fmin(1, fmax(0, 2 - apart)));
    }
}

/* Fills a square of the page. */
static void fill_square(cairo_t *page, double x, double y, double size, const double rgb[3]) {
    cairo_set_source_rgb(page, rgb[0], rgb[1], rgb[2]);
    cairo_rectangle(page, x, y, size, size);
    cairo_fill(page);
}

static void draw_wheel(cairo_t *page, int x, int y, double high, const char *label) {
    char text[64];
    for (int row = -WHEEL; row <= WHEEL; ++row)
        for (int column = -WHEEL; column <= WHEEL; ++column) {
            double rgb[3];
            if (hypot(column, row) > WHEEL) continue;
            colour_of(column * high / WHEEL, row * high / WHEEL, high, rgb);
            fill_square(page, x + WHEEL + column, y + WHEEL + row, 1, rgb);
        }
    cairo_set_source_rgb(page, 0, 0, 0);
    snprintf(text, sizeof text, "edge: %.3g", high);
    mcv_page_text(page, x + WHEEL, y + 2 * WHEEL + 20, 0.5, text);
    mcv_page_text(page, x + WHEEL, y + 2 * WHEEL + 38, 0.5, label);
}

/* Each place a square; one without light is grey. */
static void draw_image(cairo_t *page, const mcv_image *image, uint32_t zoom, double high) {
    static const double grey[3] = {0.7, 0.7, 0.7};
    const size_t plane = (size_t)image->width * image->height;
    for (size_t i = 0; i < plane; ++i) {
        const double x = image->pixels[i], y = image->pixels[plane + i];
        const size_t column = i % image->width, row = i / image->width;
        double rgb[3];
        memcpy(rgb, grey, sizeof rgb);
        if (!isnan(x) && !isnan(y)) colour_of(x, y, high, rgb);
        fill_square(page, MARGIN + (double)column * zoom, TITLE + (double)row * zoom, zoom, rgb);
    }
    cairo_set_source_rgb(page, 0, 0, 0);
}

/* The length below which most vectors are. */
static mcv_result find_strong(const mcv_image *image, double *length, mcv_error *error) {
    const size_t plane = (size_t)image->width * image->height;
    mcv_image lengths;
    MCV_TRY(mcv_image_new(&lengths, image->width, image->height, 1, error));
    for (size_t i = 0; i < plane; ++i)
        lengths.pixels[i] = hypotf(image->pixels[i], image->pixels[plane + i]);
    *length = mcv_preview_white(&lengths);
    mcv_image_free(&lengths);
    return MCV_OK;
}

mcv_result mcv_vector_figure_write(const char *path, const mcv_image *image, const char *title,
                                   const char *label, double high, mcv_error *error) {
    const uint32_t zoom = image->width < WIDTH ? WIDTH / image->width : 1,
                   width = image->width * zoom, height = image->height * zoom,
                   least = 2 * WHEEL + 50;
    cairo_t *page;
    if (!(high > 0)) MCV_TRY(find_strong(image, &high, error));
    MCV_TRY(mcv_page_new(&page, width + 3 * MARGIN + MCV_COLOR_BAR_WIDTH,
                         (height > least ? height : least) + TITLE + MARGIN, 14, error));
    mcv_page_text(page, MARGIN, TITLE - 12, 0, title);
    draw_image(page, image, zoom, high);
    draw_wheel(page, (int)(2 * MARGIN + width), TITLE, high, label);
    return mcv_page_write(page, path, error);
}
