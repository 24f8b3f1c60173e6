/* SPDX-License-Identifier: Apache-2.0 */
/* The laser's Gaussian beams in double: what its parameters say, and what the device needs. */
#ifndef MCVISI_HOST_SCENE_LASER_H
#define MCVISI_HOST_SCENE_LASER_H

#include "core/json_path.h"
#include "scene/scene.h"

/* A laser's beam in x and y; of a line only y counts. */
typedef struct mcv_laser_beam {
    double waist[2];      /* w₀, the 1/e² radius of the waist [m] */
    double divergence[2]; /* Θ = M² λ/(π w₀), half of the full one [rad] */
    double rayleigh[2];   /* z_R = w₀/Θ [m] */
    bool is_line;
} mcv_laser_beam;

/* The parameters must have passed mcv_laser_check. */
mcv_laser_beam mcv_laser_beam_of(const mcv_laser_params *p);

/* flying_spot.c: that of a scanner, whose parameters are resolved. */
mcv_laser_beam mcv_flying_spot_beam(const mcv_flying_spot_params *p);

/* Refuses parameters that do not fit together: a width without its measure, or of the other kind;
 * a table without image; lines that lie on one another; a beam too narrow for its wavelength. */
mcv_result mcv_laser_check(const mcv_laser_params *p, const mcv_json_path *place, mcv_error *error);

/* Do lasers of one wavelength alone light the scene? Then that, and the largest of their widths
 * [m]. */
bool mcv_scene_is_laser_lit(const mcv_scene *scene, double *wavelength, double *linewidth);

/* Switches off all emitters but the lasers. MCV_BAD_INPUT where no laser has power. */
mcv_result mcv_scene_keep_lasers(mcv_scene *scene, mcv_error *error);

/*
 * Writes the power of each column of a laser's table, summed over rows and channels, to
 * `columns`, which has image->width numbers. Returns their sum.
 */
double mcv_laser_table(const mcv_texture *image, double *columns);

/* Does the image of a laser's table hold light? `place` is that of the image. */
mcv_result mcv_laser_check_table(const mcv_texture *image, const mcv_json_path *place,
                                 mcv_error *error);

/* The tangent of a cone about its axis that holds all of its light but 4e-6 of a beam. */
double mcv_laser_tangent(const mcv_laser_params *p);

/* The axes x, y and forward of the laser of emitters[index] in the world, boresight included. */
void mcv_laser_axes(const mcv_emitter *emitter, double axes[3][3]);

/* The device struct, in a world whose origin is moved to `centre`. */
void mcv_laser_prepare(const mcv_scene *scene, uint32_t index, const double centre[3],
                       mcv_laser *device);

#endif
