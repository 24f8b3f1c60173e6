/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What microfacets send on to each other before it leaves: the tables of multiple scattering behind
 * kernels/bsdf/microfacet.h, in double. Smith's masking describes a surface on which light walks
 * from microfacet to microfacet (Heitz, Hanika, d'Eon and Dachsbacher 2016).
 */
#ifndef MCVISI_HOST_DEVICE_MULTIPLE_H
#define MCVISI_HOST_DEVICE_MULTIPLE_H

#include <stdbool.h>
#include <stdint.h>

/* Floats of a table for one roughness. */
uint32_t mcv_multiple_words(void);

/*
 * Fills a table for α, the same in all directions: for pairs of cosines and the angle between their
 * azimuths, what leaves after two or more reflections over what white microfacets send there by
 * one. n, k: of a metal, for three channels; each entry holds these. NULL: for Schlick's f + (1 -
 * f) (1 - c)^5 it holds the factors of f², f and 1 of the second reflection, and what white
 * microfacets add after it. False: no memory.
 */
bool mcv_multiple_reflection(double alpha, const double *n, const double *k, float *table);

/* Floats of an interface's table. */
uint32_t mcv_interface_words(void);

/*
 * The same for an interface between two indices, by walks: for pairs of cosines and the angle
 * between their azimuths the BSDF of two and more meetings with microfacets, times the cosine it
 * leaves at. The first two words, of light that comes and leaves outside, inside: over what white
 * microfacets reflect there once. The others, of light that comes from outside, inside and leaves
 * on the other side, which is spread wide: over 1/(o_z (1 + Λ(o)) (1 + Λ(i))) [1/sr]. coating: its
 * reflectance at normal incidence, 0: none. False: no memory.
 */
bool mcv_multiple_interface(double alpha, double n_outside, double n_inside, double coating,
                            float *table);

/*
 * The factor of three and more reflections of a mean reflectance, beyond that of two: Σ over 3, 4 …
 * of which the share `left` goes on.
 */
double mcv_more_reflections(double reflectance, double left);

#endif
