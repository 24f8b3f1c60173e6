/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Absorber (type "absorber"): takes all light. Black walls, stops, and the rectangles that emitters
 * without a mesh get. It has no parameters.
 *
 *     {"type": "absorber"}
 */
#ifndef MCVISI_MATERIALS_ABSORBER_H
#define MCVISI_MATERIALS_ABSORBER_H

#include "mcvisi/materials/material.h"

#define MCV_ABSORBER_PARAMS(X)

#endif
