/* SPDX-License-Identifier: Apache-2.0 */
#include "scene/scene.h"

#include <math.h>

double mcv_srgb_decode(uint8_t value) {
    const double v = value / 255.0;
    return v <= 0.04045 ? v / 12.92 : pow((v + 0.055) / 1.055, 2.4);
}
