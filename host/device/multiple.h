/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Multiple scattering between microfacets: the tables behind kernels/bsdf/microfacet.h, in double.
 * Smith's masking describes a surface on which light does a random walk from microfacet to
 * microfacet (Heitz, Hanika, d'Eon and Dachsbacher 2016).
 */
#ifndef MCVISI_HOST_DEVICE_MULTIPLE_H
#define MCVISI_HOST_DEVICE_MULTIPLE_H

#include <stdbool.h>
#include <stdint.h>

/* Floats of a table for one roughness. */
uint32_t mcv_multiple_words(void);

/*
 * Fills a table for an isotropic α. Entries are for pairs of cosines and the angle between their
 * azimuths: two and more reflections over one reflection of white microfacets. With n and k, of a
 * metal, each entry holds three channels. NULL: for Schlick's f + (1 - f) (1 - c)^5 an entry holds
 * the factors of f², f and 1 of the second reflection, and the further reflections of white
 * microfacets. False: no memory.
 */
bool mcv_multiple_reflection(double alpha, const double *n, const double *k, float *table);

/* Floats of a brushed metal's table. */
uint32_t mcv_multiple_brushed_words(void);

/*
 * The same as mcv_multiple_reflection for a metal of two α, along the tangent and across. Entries
 * are for pairs of directions, at the places of MCV_BRUSHED_MIDDLES
 * (mcvisi/materials/microfacet.h).
 */
bool mcv_multiple_brushed(const double alpha[2], const double *n, const double *k, float *table);

/* Floats of an interface's table. */
uint32_t mcv_interface_words(void);

/*
 * Fills the table of an interface between two indices by random walks. Entries are for pairs of
 * cosines and the angle between their azimuths: the BSDF of two and more meetings with microfacets,
 * times the cosine of the leaving light. The first two words are reflection outside and inside,
 * over one reflection of white microfacets. The other two are transmission from outside and from
 * inside, which is spread widely, over 1/(o_z (1 + Λ(o)) (1 + Λ(i))) [1/sr]. Words are fourth
 * roots. coating: its reflectance at normal incidence, 0: none. False: no memory.
 */
bool mcv_multiple_interface(double alpha, double n_outside, double n_inside, double coating,
                            float *table);

#endif
