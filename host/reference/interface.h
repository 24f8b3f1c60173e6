/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Smooth interfaces: Snell, Fresnel, reflection. Directions and normals are unit.
 *
 * The triangle's face decides from which side a ray comes and on which it goes on, the interpolated
 * normal the angles. Where they contradict each other (at silhouettes) the face's normal stands in:
 * for all of the event where the ray meets the back of the interpolated normal, for a direction
 * that would leave on the wrong side where only that is so. No light is lost.
 */
#ifndef MCVISI_HOST_REFERENCE_INTERFACE_H
#define MCVISI_HOST_REFERENCE_INTERFACE_H

#include "reference/geometry.h"

/* A surface as seen along a direction. */
typedef struct ref_interaction {
    bool front;           /* the ray comes from the triangle's front */
    ref_vec face, normal; /* on the ray's side */
    ref_vec direction;
} ref_interaction;

ref_interaction ref_make_interaction(const ref_surface *surface, ref_vec direction);

/*
 * Fresnel's reflectances of a polarised wave, perpendicular and parallel to the plane of incidence,
 * by the cosine of the angle of incidence in [0, 1]; both 1 under total reflection.
 */
void ref_fresnel(double from, double to, double cosine, double *perpendicular, double *parallel);

/* The reflectance of unpolarised light from index `from` to index `to`; 1 under total reflection.
 */
double ref_reflectance(const ref_interaction *interaction, double from, double to);

/* What a coating of that reflectance at normal incidence (0: none) makes of the bare interface's.
 */
double ref_coated(double bare, double coating, double from, double to);

ref_vec ref_reflect(const ref_interaction *interaction);

/* Only below total reflection. Equal indices: the same direction, exactly. */
ref_vec ref_refract(const ref_interaction *interaction, double from, double to);

#endif
