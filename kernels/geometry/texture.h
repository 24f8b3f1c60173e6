/* SPDX-License-Identifier: Apache-2.0 */
/* Images on surfaces: 8-bit sRGB, decoded through a table (the first 256 words of the texels), or
 * linear floats; bilinear or nearest. */
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
    const uint texel = mcv_wrap(y, texture.height, texture.wrap_t) * texture.width +
                       mcv_wrap(x, texture.width, texture.wrap_s);
    mcv_color color;
    if (texture.linear) {
        MCV_EACH_CHANNEL(i)
        color.c[i] = as_float(world.texels[texture.first + 3u * texel + (uint)i]);
        return color;
    }
    const uint rgba = world.texels[texture.first + texel];
    MCV_EACH_CHANNEL(i) color.c[i] = as_float(world.texels[(rgba >> (8 * i)) & 255u]);
    return color;
}

/* The texel at a place, or the upper left one of the four around it and how far it is from that
 * one. */
typedef struct mcv_texture_place {
    int i, j;
    float a, b;
} mcv_texture_place;

/* (0, 0) is the upper left corner of the image, as glTF has it. Coordinates beyond 2^16 periods
 * have lost their digits. */
MCV_FUNCTION mcv_texture_place mcv_find_texel(mcv_device_texture texture, float s, float t) {
    mcv_texture_place place;
    const float x = clamp(s, -65536.0f, 65536.0f) * (float)texture.width;
    const float y = clamp(t, -65536.0f, 65536.0f) * (float)texture.height;
    const float middle = texture.nearest ? 0.0f : 0.5f;
    const float left = mcv_floor(x - middle);
    const float top = mcv_floor(y - middle);
    place.i = (int)left;
    place.j = (int)top;
    place.a = x - middle - left;
    place.b = y - middle - top;
    return place;
}

MCV_FUNCTION mcv_color mcv_texture_lookup(mcv_world world, uint index, float s, float t) {
    const mcv_device_texture texture = world.textures[index];
    const mcv_texture_place place = mcv_find_texel(texture, s, t);
    const int i = place.i;
    const int j = place.j;
    const float a = place.a;
    const float b = place.b;
    const mcv_color c00 = mcv_texel(world, texture, i, j);
    if (texture.nearest) return c00;
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

/* A single channel of an image of linear values, however many the render has. */
MCV_FUNCTION float mcv_texture_value(mcv_world world, uint index, float s, float t, uint channel) {
    const mcv_device_texture texture = world.textures[index];
    const mcv_texture_place place = mcv_find_texel(texture, s, t);
    float corner[4];
    for (int k = 0; k < 4; ++k) {
        const uint y = mcv_wrap(place.j + (k >> 1), texture.height, texture.wrap_t);
        const uint x = mcv_wrap(place.i + (k & 1), texture.width, texture.wrap_s);
        corner[k] = as_float(world.texels[texture.first + 3u * (y * texture.width + x) + channel]);
    }
    if (texture.nearest) return corner[0];
    const float upper = mcv_fma(place.a, corner[1] - corner[0], corner[0]);
    const float lower = mcv_fma(place.a, corner[3] - corner[2], corner[2]);
    return mcv_fma(place.b, lower - upper, upper);
}

#endif
