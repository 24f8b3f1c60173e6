/* SPDX-License-Identifier: Apache-2.0 */
/* What microfacets lose: the directional albedos behind the compensation of
 * kernels/bsdf/microfacet.h, in double. */
#ifndef MCVISI_HOST_DEVICE_ALBEDO_H
#define MCVISI_HOST_DEVICE_ALBEDO_H

#include <stdint.h>

/* Floats of a block: two means, then `azimuths` rows of pairs. */
uint32_t mcv_albedo_words(uint32_t azimuths);

/*
 * Fills a block for α along the tangent and across. Each pair, for one direction: 1 - E, the share
 * of the light that white microfacets do not send out, and B, the part of E that goes with (1 -
 * c)^5.
 */
void mcv_albedo_reflection(double alpha_x, double alpha_y, uint32_t azimuths, float *block);

/*
 * The same for an interface: the share that one meeting with a microfacet neither reflects nor
 * refracts, coming from index n_outside and from n_inside.
 */
void mcv_albedo_interface(double alpha_x, double alpha_y, double n_outside, double n_inside,
                          double coating, uint32_t azimuths, float *block);

/* What a coating of that reflectance at normal incidence makes of Fresnel's: scale F + offset. 0:
 * there is none. */
void mcv_coat(double coating, double n1, double n2, double *scale, double *offset);

/* The mean 2 ∫ F(μ) μ dμ of a metal's reflectance, n and k relative to the medium before it. */
double mcv_conductor_mean(double n, double k);

#endif
