/* SPDX-License-Identifier: Apache-2.0 */
#include "scene/scene.h"

#include <math.h>

double mcv_srgb_decode(uint8_t value) {
    const double v = value / 255.0;
    return v <= 0.04045 ? v / 12.92 : pow((v + 0.055) / 1.055, 2.4);
}

void mcv_texture_texel(const mcv_texture *texture, uint32_t column, uint32_t row, double rgb[3]) {
    const size_t texel = (size_t)row * texture->width + column;
    for (size_t k = 0; k < 3; ++k) rgb[k] = texture->rgba ? mcv_srgb_decode(texture->rgba[4 * texel + k]) : texture->linear[3 * texel + k];
}
