/* SPDX-License-Identifier: Apache-2.0 */
#include "scene/illumination.h"

#include <float.h>
#include <math.h>

mcv_result mcv_illumination_check(const mcv_telecentric_params *p, const mcv_readout *readout,
                                  const mcv_json_path *place, mcv_error *error) {
    const mcv_curve *curve = &p->relativeIllumination;
    const mcv_json_path here = mcv_json_path_key(place, "relativeIllumination");
    double corner = 0;
    if (curve->count == 0) return MCV_OK;
    if (p->radiometry != MCV_RADIOMETRY_IRRADIANCE)
        return mcv_fail_at(&here, error,
                           "is of irradiance: give \"radiometry\": \"irradiance\", too");
    for (int k = 0; k < 4; ++k) {
        double at[2];
        for (int i = 0; i < 2; ++i)
            at[i] = ((k >> i & 1 ? readout->film[i] : 0) - readout->centre[i]) * readout->pitch[i];
        corner = fmax(corner, hypot(at[0], at[1]));
    }
    if (corner * (1 - 8 * DBL_EPSILON) <= curve->at[curve->count - 1]) return MCV_OK;
    return mcv_fail_at(&here, error,
                       "ends at %g m from the axis, but the film's corner is %g m away: go on with "
                       "the table up to there",
                       curve->at[curve->count - 1], corner);
}

void mcv_illumination_prepare(const mcv_curve *curve, double h, mcv_distortion *device) {
    device->illumination_count = curve->count;
    for (uint32_t i = 0; i < curve->count; ++i) {
        device->distance[i] = (float)(curve->at[i] / h);
        device->illumination[i] = (float)curve->value[i];
    }
}
