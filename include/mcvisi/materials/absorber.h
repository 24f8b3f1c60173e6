/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Absorber (type "absorber"): absorbs all light. It is for black walls and stops; the rectangles of
 * emitters without a mesh have it too. It has no parameters.
 *
 *     {"type": "absorber"}
 */
#ifndef MCVISI_MATERIALS_ABSORBER_H
#define MCVISI_MATERIALS_ABSORBER_H

#include "mcvisi/materials/material.h"

#define MCV_ABSORBER_PARAMS(X)

#endif
