/* SPDX-License-Identifier: Apache-2.0 */
/* Where on which surface the corners of pixels look. */
#ifndef MCVISI_HOST_REFERENCE_SURFACE_PLACES_H
#define MCVISI_HOST_REFERENCE_SURFACE_PLACES_H

#include "film/film.h"
#include "reference/geometry.h"

/*
 * Four channels of one more place than pixels along each side, for pixels of q x q of the sensor's.
 * x, y and z are what the chief ray meets first, in the coordinates of the surface's node, without
 * its scale [m]. The fourth is the surface's number from 1 on, 0 where the ray meets none. Rays
 * pass through thin sheets and beam splitters. What moves stands where it is at the time 0.
 */
mcv_result ref_surface_places(const ref_geometry *geometry, const mcv_sensor *sensor, uint32_t q,
                              mcv_image *places, mcv_error *error);

#endif
