/* SPDX-License-Identifier: Apache-2.0 */
/* The beam of a flying spot scanner. */
#include "scene/laser.h"
#include "scene/sensors.h"

#include <math.h>

/* The beam of a laser without a fan. */
static mcv_laser_params beam_of(const mcv_flying_spot_params *p) {
    return (mcv_laser_params){.wavelength = p->wavelength,
                              .M2 = {p->M2[0], p->M2[1]},
                              .beamDiameter = {p->beamDiameter[0], p->beamDiameter[1]},
                              .lineThickness = NAN,
                              .widthMeasure = p->widthMeasure,
                              .workingDistance = p->workingDistance,
                              .fanAngle = NAN,
                              .image = MCV_NONE,
                              .lineCount = 1};
}

mcv_laser_beam mcv_flying_spot_beam(const mcv_flying_spot_params *p) {
    const mcv_laser_params beam = beam_of(p);
    return mcv_laser_beam_of(&beam);
}

mcv_result mcv_flying_spot_resolve(mcv_flying_spot_params *p, const mcv_json_path *place,
                                   mcv_error *error) {
    const mcv_laser_params beam = beam_of(p);
    const mcv_json_path binning = mcv_json_path_key(place, "binning");
    if (p->binning[0] > 1 || p->binning[1] > 1)
        return mcv_fail_at(&binning, error,
                           "must be 1: the beam stands at each position by itself");
    return mcv_laser_check(&beam, place, error);
}
