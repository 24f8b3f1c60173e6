/* SPDX-License-Identifier: Apache-2.0 */
/* Labelled pictures of numbers, drawn by cairo: an image in colours, the bar that explains them,
 * text. */
#ifndef MCVISI_HOST_IO_FIGURE_H
#define MCVISI_HOST_IO_FIGURE_H

#include "film/film.h"
#include "io/colormap.h"

#include <cairo.h>

/* The values at both ends of the colours; what lies beyond has the end's colour. low < high. */
typedef struct mcv_color_scale {
    mcv_colormap map;
    double low, high;
} mcv_color_scale;

/* A white page of width x height pixels with black text in `size` pixels. mcv_page_write frees it.
 */
mcv_result mcv_page_new(cairo_t **page, uint32_t width, uint32_t height, double size,
                        mcv_error *error);

/* Writes the page as PNG, whole or not at all, and frees it. */
mcv_result mcv_page_write(cairo_t *page, const char *path, mcv_error *error);

/* One line of text. align: 0 begins at x, 0.5 is centred there, 1 ends there; y is its baseline. */
void mcv_page_text(cairo_t *page, double x, double y, double align, const char *text);

/* The image's first channel, each value a square of zoom x zoom pixels; NaN is hatched grey. */
void mcv_page_image(cairo_t *page, int x, int y, const mcv_image *image, uint32_t zoom,
                    const mcv_color_scale *scale);

/* A bar `height` pixels high with ticks at round values, and the label along it. It is
 * MCV_COLOR_BAR_WIDTH pixels wide in all. */
enum { MCV_COLOR_BAR_WIDTH = 120 };
void mcv_page_color_bar(cairo_t *page, int x, int y, int height, const char *label,
                        const mcv_color_scale *scale);

/*
 * Vectors of an image's first two channels (x right, y down) under a title: hue is the direction,
 * and colours grow from white to the hue at the length `high`; 0: 99.5 % of the lengths are below
 * it. A wheel beside the image explains both. NaN is grey.
 */
mcv_result mcv_vector_figure_write(const char *path, const mcv_image *image, const char *title,
                                   const char *label, double high, mcv_error *error);

/* The image under a title, beside its colour bar; enlarged to some 640 pixels. */
mcv_result mcv_figure_write(const char *path, const mcv_image *image, const char *title,
                            const char *label, const mcv_color_scale *scale, mcv_error *error);

#endif
