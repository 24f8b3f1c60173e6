/* SPDX-License-Identifier: Apache-2.0 */
/* Images on surfaces: 8-bit sRGB, decoded through a table (the first 256 words of the texels), or linear floats; bilinear or nearest. */
#ifndef MCVISI_KERNELS_TEXTURE_H
#define MCVISI_KERNELS_TEXTURE_H

#include "world.h"

enum { MCV_WRAP_CLAMP = 33071, MCV_WRAP_MIRROR = 33648 };

/* Texel index of a whole coordinate outside [0, size). */
MCV_FUNCTION uint mcv_wrap(int i, uint size, uint mode) {
    const int n = (int)size;
    if (mode == MCV_WRAP_CLAMP) return (uint)(i < 0 ? 0 : i >= n ? n - 1 : i);
    const int period = mode == MCV_WRAP_MIRROR ? 2 * n : n;
    int k = i % period;
    if (k < 0) k += period;
    return (uint)(k < n ? k : 2 * n - 1 - k);
}

MCV_FUNCTION mcv_color mcv_texel(mcv_world world, mcv_device_texture texture, int x, int y) {
    const uint texel = mcv_wrap(y, texture.height, texture.wrap_t) * texture.width + mcv_wrap(x, texture.width, texture.wrap_s);
    mcv_color color;
    if (texture.linear) {
        MCV_EACH_CHANNEL(i) color.c[i] = as_float(world.texels[texture.first + 3u * texel + (uint)i]);
        return color;
    }
    const uint rgba = world.texels[texture.first + texel];
    MCV_EACH_CHANNEL(i) color.c[i] = as_float(world.texels[(rgba >> (8 * i)) & 255u]);
    return color;
}

/* (0, 0) is the upper left corner of the image, as glTF has it. Coordinates beyond 2^16 periods have lost their digits. */
MCV_FUNCTION mcv_color mcv_texture_lookup(mcv_world world, uint index, float s, float t) {
    const mcv_device_texture texture = world.textures[index];
    const float x = clamp(s, -65536.0f, 65536.0f) * (float)texture.width;
    const float y = clamp(t, -65536.0f, 65536.0f) * (float)texture.height;
    if (texture.nearest) return mcv_texel(world, texture, (int)mcv_floor(x), (int)mcv_floor(y));
    const float left = mcv_floor(x - 0.5f);
    const float top = mcv_floor(y - 0.5f);
    const float a = x - 0.5f - left;
    const float b = y - 0.5f - top;
    const int i = (int)left;
    const int j = (int)top;
    const mcv_color c00 = mcv_texel(world, texture, i, j);
    const mcv_color c10 = mcv_texel(world, texture, i + 1, j);
    const mcv_color c01 = mcv_texel(world, texture, i, j + 1);
    const mcv_color c11 = mcv_texel(world, texture, i + 1, j + 1);
    mcv_color color;
    MCV_EACH_CHANNEL(k) {
        const float upper = mcv_fma(a, c10.c[k] - c00.c[k], c00.c[k]);
        const float lower = mcv_fma(a, c11.c[k] - c01.c[k], c01.c[k]);
        color.c[k] = mcv_fma(b, lower - upper, upper);
    }
    return color;
}

#endif
