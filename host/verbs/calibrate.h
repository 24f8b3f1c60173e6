/* SPDX-License-Identifier: Apache-2.0 */
/* The plane of a laser's light from images of a flat target, as a file. */
#ifndef MCVISI_HOST_VERBS_CALIBRATE_H
#define MCVISI_HOST_VERBS_CALIBRATE_H

#include "triangulation/light_plane.h"
#include "verbs/triangulate.h"

/* Checks --calibrate, --target and --calibration, and reads the latter's plane. MCV_USAGE or
 * MCV_BAD_INPUT with a sentence. */
mcv_result mcv_light_plane_begin(const mcv_command *command, mcv_profiles *profiles,
                                 mcv_error *error);

/* With --calibrate: adds where the target of this image is lit, by the profile that was found
 * last. */
mcv_result mcv_light_plane_add(mcv_profiles *profiles, const mcv_subject *subject,
                               mcv_error *error);

/* With --calibrate: fits the plane and writes the file. MCV_BAD_INPUT where the images do not tell
 * it. */
mcv_result mcv_light_plane_write(mcv_profiles *profiles, mcv_error *error);

/* Tells of the plane that was fitted. */
void mcv_light_plane_report(const mcv_profiles *profiles, mcv_report *report);

#endif
