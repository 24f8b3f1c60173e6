/* SPDX-License-Identifier: Apache-2.0 */
/* A scene as one HTML page that needs nothing else: each sensor's set-up drawn from the side and
 * from above (inline SVG), and findings. */
#ifndef MCVISI_HOST_CHECK_SETUP_PAGE_H
#define MCVISI_HOST_CHECK_SETUP_PAGE_H

#include "check/findings.h"

/* Writes it; the file appears whole or not at all. */
mcv_result mcv_setup_page_write(const char *path, const mcv_scene *scene,
                                const mcv_findings *findings, mcv_error *error);

#endif
