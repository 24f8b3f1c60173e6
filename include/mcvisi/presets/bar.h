/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Bar light (type "bar"): a rectangle in the node's xy plane, `length` along x, `width` along y,
 * that emits along -z. It emits diffusely, or with `halfAngle` into a cone about -z.
 *
 *     {"type": "bar", "length": "200mm", "width": "20mm", "halfAngle": "15deg", "power": 3}
 */
#ifndef MCVISI_PRESETS_BAR_H
#define MCVISI_PRESETS_BAR_H

#include "mcvisi/presets/preset.h"

#define MCV_BAR_PARAMS(X) \
    X(length, length, MCV_REQUIRED, MCV_POSITIVE, 1e6, \
      "length of the bar, along the node's x axis [m]") \
    X(length, width, MCV_REQUIRED, MCV_POSITIVE, 1e6, \
      "width of the bar, along the node's y axis [m]") \
    MCV_DIRECTED_PRESET_PARAMS(X)

#endif
