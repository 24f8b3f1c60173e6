/* SPDX-License-Identifier: Apache-2.0 */
/* What a path of the reference renderer has met, and whom it tells of light. */
#ifndef MCVISI_HOST_REFERENCE_TRAIL_H
#define MCVISI_HOST_REFERENCE_TRAIL_H

#include "reference/explain.h"
#include "reference/path_steps.h"

struct ref_trail {
    mcv_contribution_told *told;
    void *user;
    double scale[3]; /* from light along the path to the pixel's value */
    mcv_contribution contribution;
};

/* A path begins. */
void ref_trail_begin(ref_trail *trail, const ref_sensor_ray *ray, const double scale[3]);

/* It has met a surface; then: what that does to its direction. NULL: nobody is told. */
void ref_trail_meet(ref_trail *trail, const ref_surface *surface);
void ref_trail_leave(ref_trail *trail, const ref_surface *surface, ref_vec before, ref_vec after,
                     bool scatters);

/* It finds light that an emitter's surface sends in the unit direction. */
void ref_trail_emission(ref_trail *trail, const mcv_scene *scene, const ref_surface *surface,
                        ref_vec direction, const double light[3]);

/* It finds light of the emitter from a point, or of a far one from a direction. */
void ref_trail_light(ref_trail *trail, uint32_t emitter, ref_vec from, bool is_far,
                     const double light[3]);

#endif
