/* SPDX-License-Identifier: Apache-2.0 */
#include "scene/scene.h"
#include "scene/texture.h"

#include <math.h>

double mcv_srgb_decode(uint8_t value) {
    const double v = value / 255.0;
    return v <= 0.04045 ? v / 12.92 : pow((v + 0.055) / 1.055, 2.4);
}

void mcv_srgb_table(double decoded[256]) {
    for (unsigned value = 0; value < 256; ++value) decoded[value] = mcv_srgb_decode((uint8_t)value);
}

void mcv_texture_value(const mcv_texture *texture, const double decoded[256], uint32_t column,
                       uint32_t row, double rgb[3]) {
    const size_t texel = (size_t)row * texture->width + column;
    for (size_t i = 0; i < 3; ++i)
        rgb[i] =
            texture->rgba ? decoded[texture->rgba[4 * texel + i]] : texture->linear[3 * texel + i];
}
