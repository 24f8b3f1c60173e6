/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Mirror (type "mirror", and glTF metal without roughness): a smooth opaque surface. It reflects a
 * share of the light that does not depend on the angle, on both sides.
 *
 *     {"type": "mirror", "reflectance": 0.95}
 */
#ifndef MCVISI_MATERIALS_MIRROR_H
#define MCVISI_MATERIALS_MIRROR_H

#include "mcvisi/materials/material.h"

#define MCV_MIRROR_PARAMS(X) \
    X(spectrum, reflectance, 1, 0, 1, "share of the light that is reflected")

#endif
