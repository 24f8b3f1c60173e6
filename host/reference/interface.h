/* SPDX-License-Identifier: Apache-2.0 */
/* Smooth interfaces: Snell, Fresnel, reflection, and which normal they take. Directions and normals are unit. */
#ifndef MCVISI_HOST_REFERENCE_INTERFACE_H
#define MCVISI_HOST_REFERENCE_INTERFACE_H

#include "reference/geometry.h"

/*
 * What a smooth interface does to a ray. The geometric normal decides from which side the ray comes. The interpolated
 * normal decides the angles, unless it contradicts the triangle: where the ray meets its back, or the reflected or the
 * refracted direction would leave on the wrong side, the geometric normal stands in for all of the event. So no light is lost.
 */
typedef struct ref_interface {
    bool front;         /* the ray comes from the triangle's front */
    ref_vec normal;     /* the normal used, on the ray's side */
    double reflectance; /* unpolarised; 1 under total reflection */
    ref_vec reflected, refracted; /* refracted: 0 under total reflection */
} ref_interface;

/* The interface from index `from` to index `to` (equal ones: all passes, undeflected). */
ref_interface ref_interface_at(const ref_surface *surface, ref_vec direction, double from, double to);

/* The side and the interpolated normal on it, without an interface: what a diffuse surface takes. */
ref_vec ref_facing_normal(const ref_surface *surface, ref_vec direction);

/*
 * Fresnel's reflectances of a polarised wave, perpendicular and parallel to the plane of incidence, by the cosine of the
 * angle of incidence in [0, 1]; both 1 under total reflection.
 */
void ref_fresnel(double from, double to, double cosine, double *perpendicular, double *parallel);

#endif
