/* SPDX-License-Identifier: Apache-2.0 */
/* An image with coordinates drawn on it, from which people read places to measure in. */
#ifndef MCVISI_HOST_IO_GRID_H
#define MCVISI_HOST_IO_GRID_H

#include "film/film.h"
#include "scene/camera_model.h"

#include <cairo.h>

typedef struct mcv_grid {
    cairo_t *page;
    double left, top, zoom; /* of the image on the page [pixel] */
    uint32_t width, height;
} mcv_grid;

/*
 * Draws the first channel in grey, up to the level of a preview, with pixel numbers along the left
 * and the upper side. With a model it also draws lines of equal coordinates of the node, in mm, in
 * the plane in focus, or in the depth of the node where there is none. They are those of the two
 * axes that the view shows most of; the title names the third. `node` may be NULL.
 */
mcv_result mcv_grid_begin(mcv_grid *grid, const mcv_image *image, const mcv_camera_model *model,
                          const mcv_placement *node, mcv_error *error);

/* A rectangle X, Y, W, H in pixels of the image, with its name. */
void mcv_grid_box(mcv_grid *grid, const char *name, const double box[4]);

/* Writes the page as PNG, whole or not at all, and frees it. */
mcv_result mcv_grid_write(mcv_grid *grid, const char *path, mcv_error *error);

/* The distance of lines: 1, 2 or 5 times a power of ten, so that about `count` of them, at most 2.5
 * times as many, fit into a span. */
double mcv_grid_step(double span, double count);

/*
 * The coordinates of a node that the places of an image show in a plane across the axis: coordinate
 * k [m] = a[k][0] column + a[k][1] row + a[k][2]. The depth is that of the plane in focus, or else
 * of the node.
 */
void mcv_grid_coordinates(const mcv_camera_model *model, const mcv_placement *node, double a[3][3]);

#endif
