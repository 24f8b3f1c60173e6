/* SPDX-License-Identifier: Apache-2.0 */
/* The light that single scattering at microfacets loses: the directional albedos, in double, behind
 * the compensation in kernels/bsdf/microfacet.h. */
#ifndef MCVISI_HOST_DEVICE_ALBEDO_H
#define MCVISI_HOST_DEVICE_ALBEDO_H

#include <stdint.h>

/* Floats of a block: two means, then `azimuths` rows of pairs. */
uint32_t mcv_albedo_words(uint32_t azimuths);

/*
 * Fills a block for α along the tangent and across. Each pair belongs to one direction: 1 - E, the
 * share of the light that white microfacets lose, and B, the part of E that is proportional to (1 -
 * c)^5.
 */
void mcv_albedo_reflection(double alpha_x, double alpha_y, uint32_t azimuths, float *block);

/*
 * The same for an interface, from index n_outside and from n_inside: the share that is neither
 * reflected nor refracted in a single meeting with a microfacet.
 */
void mcv_albedo_interface(double alpha_x, double alpha_y, double n_outside, double n_inside,
                          double coating, uint32_t azimuths, float *block);

/* A coating with that reflectance at normal incidence changes Fresnel's F to scale F + offset. 0:
 * no coating. */
void mcv_coat(double coating, double n1, double n2, double *scale, double *offset);

/* The mean 2 ∫ F(μ) μ dμ of a metal's reflectance, n and k relative to the medium before it. */
double mcv_conductor_mean(double n, double k);

#endif
