/* SPDX-License-Identifier: Apache-2.0 */
/* Small pictures inside HTML pages. */
#ifndef MCVISI_HOST_IO_THUMBNAIL_H
#define MCVISI_HOST_IO_THUMBNAIL_H

#include "film/film.h"

#include <stdio.h>

/* The largest height and width of a thumbnail [pixels]. */
enum { MCV_THUMBNAIL_HEIGHT = 96, MCV_THUMBNAIL_WIDTH = 192 };

/*
 * Writes an image of 1 or 3 channels as an <img> that holds its own PNG: means of blocks of pixels,
 * from black to mcv_preview_white, sRGB. `label` is its text. Nothing for other images, and without
 * memory.
 */
void mcv_thumbnail_put(FILE *out, const mcv_image *image, const char *label);

#endif
