/* SPDX-License-Identifier: Apache-2.0 */
/* A scene as one HTML page that needs nothing else: each sensor's set-up drawn from the side and
 * from above (inline SVG), and findings. */
#ifndef MCVISI_HOST_CHECK_SETUP_PAGE_H
#define MCVISI_HOST_CHECK_SETUP_PAGE_H

#include "check/findings.h"
#include "check/setup_drawing.h"

#include <stdio.h>

/* Writes it; the file appears whole or not at all. */
mcv_result mcv_setup_page_write(const char *path, const mcv_scene *scene,
                                const mcv_findings *findings, mcv_error *error);

/*
 * The drawing of one sensor's set-up alone, from the side or from above, as a figure for a page
 * with the style mcv_setup_css (io/embedded.h); the overlay is put in place of the rays of its
 * optics, or is NULL. Nothing for a type of sensor whose optics are not known. False without
 * memory.
 */
bool mcv_setup_put_view(FILE *out, const mcv_scene *scene, uint32_t sensor, bool from_above,
                        mcv_drawing_overlay *overlay, void *user);

/* The same from the side as a file of its own, SVG. */
bool mcv_setup_put_file(FILE *out, const mcv_scene *scene, uint32_t sensor,
                        mcv_drawing_overlay *overlay, void *user);

/* Whether the sensor's optics are known, so that its set-up can be drawn. */
bool mcv_setup_is_known(const mcv_scene *scene, uint32_t sensor);

#endif
