/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Retroreflectors, by angles: mcvisi/materials/retroreflector.h has the model. Directions are given
 * in the frame of the surface, z its normal; o.z > 0.
 */
#ifndef MCVISI_HOST_REFERENCE_RETROREFLECTOR_H
#define MCVISI_HOST_REFERENCE_RETROREFLECTOR_H

#include "reference/random.h"
#include "reference/vector.h"
#include "scene/scene.h"

/* s² of a direction: the share that remains at this angle of incidence. */
double ref_retroreflector_efficiency(const mcv_retroreflector_params *p, ref_vec o);

/* The probability with which a path from o is returned (else it is scattered diffusely). */
double ref_retroreflector_chance(const mcv_retroreflector_params *p, ref_vec o);

/* Divergence above 0: f cosθ for light that arrives from i; returns the density with which
 * ref_retroreflector_sample chooses i [1/sr]. */
double ref_retroreflector_evaluate(const mcv_retroreflector_params *p, ref_vec o, ref_vec i,
                                   double value[3]);
ref_vec ref_retroreflector_sample(const mcv_retroreflector_params *p, ref_vec o,
                                  ref_random *random);

#endif
