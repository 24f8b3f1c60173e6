/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Smooth interfaces: Snell, Fresnel, reflection. Directions and normals are unit.
 *
 * The triangle's normal decides from which side a ray comes and on which it continues; the
 * interpolated normal decides the angles. They may contradict each other at silhouettes. The
 * triangle's normal is then used instead: for the whole event if the ray hits the back of the
 * interpolated normal, else for a direction that would leave on the wrong side. No light is lost.
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

/* The reflectance of an interface with a coating of that reflectance at normal incidence (0: none),
 * from that of the bare one. */
double ref_coated(double bare, double coating, double from, double to);

ref_vec ref_reflect(const ref_interaction *interaction);

/* Only without total reflection. With equal indices the direction stays exactly the same. */
ref_vec ref_refract(const ref_interaction *interaction, double from, double to);

#endif
