/* SPDX-License-Identifier: Apache-2.0 */
/* Rays given as text, one a line. */
#ifndef MCVISI_HOST_CLI_RAYS_H
#define MCVISI_HOST_CLI_RAYS_H

#include "render/render.h"

/*
 * Reads rows x,y,z,dx,dy,dz: origin [m] and direction in the world. Lines that are empty or begin
 * with # are passed over, and so is a first row of just these names. *rays is malloc'ed.
 * MCV_BAD_INPUT with file, line and what would be right.
 */
mcv_result mcv_rays_read(const char *path, mcv_trace_ray **rays, size_t *count, mcv_error *error);

#endif
