/* SPDX-License-Identifier: Apache-2.0 */
/* Rays in a text file, one per line. */
#ifndef MCVISI_HOST_VERBS_RAYS_H
#define MCVISI_HOST_VERBS_RAYS_H

#include "render/render.h"

/*
 * Reads rows x,y,z,dx,dy,dz: origin [m] and direction in the world. Empty lines and lines that
 * begin with # are skipped, and so is a first row with these names. *rays is malloc'ed.
 * MCV_BAD_INPUT names file and line and says what would be right.
 */
mcv_result mcv_rays_read(const char *path, mcv_trace_ray **rays, size_t *count, mcv_error *error);

#endif
