/* SPDX-License-Identifier: Apache-2.0 */
/* What emitters emit, and choosing directions towards them from a receiver. */
#ifndef MCVISI_HOST_REFERENCE_EMISSION_H
#define MCVISI_HOST_REFERENCE_EMISSION_H

#include "reference/geometry.h"
#include "reference/random.h"

/* An emitter with a surface, prepared for sampling. */
typedef struct ref_emitter {
    uint32_t index;    /* in the scene's emitters */
    double *areas;     /* running sums of its triangles' areas [m²] */
    double area;       /* their total */
    ref_vec centre;    /* mean of its triangles' centres, by area */
    ref_vec axis;      /* of its vertex normals */
    double half_angle; /* of a cone about the axis that holds all its emission, or 0: too wide to be
                          sampled as one [rad] */
} ref_emitter;

typedef struct ref_emitters {
    uint32_t count; /* without the environment */
    ref_emitter *items;
    const mcv_emitter *environment; /* or NULL */
} ref_emitters;

/* Fails only without memory. */
mcv_result ref_emitters_new(const mcv_scene *scene, ref_emitters *emitters, mcv_error *error);
void ref_emitters_free(ref_emitters *emitters);

/* The radiance of the environment in the unit direction away from the scene, 0 without one. */
void ref_environment(const mcv_scene *scene, const ref_emitters *emitters, ref_vec direction,
                     double radiance[3]);

/* The radiance that a surface emits in the unit direction, 0 where its instance is no emitter. */
void ref_emitted(const mcv_scene *scene, const ref_surface *surface, ref_vec direction,
                 double radiance[3]);

/* Column and row of the pixel of an emitter's image that sends light from there in the unit
 * direction; false where none does, or where values between pixels are interpolated. */
bool ref_emitting_pixel(const mcv_scene *scene, const ref_surface *surface, ref_vec direction,
                        uint32_t pixel[2]);

/*
 * A direction from the point towards the emitter. An emitter whose normals agree and whose cone is
 * narrow, as seen from the point, is sampled as a cone of directions, anything else as a point by
 * area. *number is the triangle that must be met first, or MCV_NONE for any of the emitter's.
 */
ref_vec ref_emitter_sample(const ref_emitter *emitter, const mcv_scene *scene, ref_vec point,
                           ref_random *random, uint32_t *number);

/* The density [1/sr] with which ref_emitter_sample chooses the direction from the point to the
 * surface (of this emitter). */
double ref_emitter_density(const ref_emitter *emitter, ref_vec point, ref_vec direction,
                           const ref_surface *surface);

#endif
