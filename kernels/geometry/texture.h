/* SPDX-License-Identifier: Apache-2.0 */
/* Images on surfaces: 8-bit sRGB, decoded through a table (the first 256 words of the texels), or
 * linear floats; bilinear or nearest. */
#ifndef MCVISI_KERNELS_TEXTURE_H
#define MCVISI_KERNELS_TEXTURE_H

#include "world.h"

enum { MCV_WRAP_CLAMP = 33071, MCV_WRAP_MIRROR = 33648 };

/*
 * Texel index of a whole coordinate, which lies up to 2^16 periods outside [0, size). Integers are
 * not divided in vectors: floats give the whole periods, or one too many or too few. What is no
 * number gives some texel.
 */
MCV_LOOP_FUNCTION uint mcv_wrap(int i, uint size, uint mode) {
    const int n = (int)size, period = mode == MCV_WRAP_MIRROR ? 2 * n : n;
    const int within = i < 0 ? 0 : i;
    int k = i - (int)mcv_floor((float)i / (float)period) * period;
    k += k < 0 ? period : 0;
    k -= k >= period ? period : 0;
    k = k < n ? k : 2 * n - 1 - k;
    const uint texel = (uint)(mode == MCV_WRAP_CLAMP ? within : k);
    return texel < size ? texel : size - 1u;
}

/* Channel i of what is kept of a texel: of a linear one all of its words, else its only one. */
MCV_LOOP_FUNCTION float mcv_texel_value(mcv_world world, __global const mcv_device_texture *texture,
                                        uint texel, uint i) {
    const int linear = texture->linear != 0u;
    const uint word = world.texels[texture->first + (linear ? 3u * texel + i : texel)];
    const float decoded = as_float(world.texels[(word >> (8u * i)) & 255u]);
    return linear ? as_float(word) : decoded;
}

/* A texel of an image, by its column and row. */
MCV_LOOP_FUNCTION mcv_color mcv_texel(mcv_world world, uint index, uint column, uint row) {
    __global const mcv_device_texture *texture = world.textures + index;
    mcv_color color;
    MCV_EACH_CHANNEL(i)
    color.c[i] = mcv_texel_value(world, texture, row * texture->width + column, (uint)i);
    return color;
}

/* A pixel of an image. */
typedef struct mcv_pixel {
    uint column, row;
} mcv_pixel;

/* The texel at a place, or the upper left one of the four around it and how far it is from that
 * one. */
typedef struct mcv_texture_place {
    int i, j;
    float a, b;
} mcv_texture_place;

MCV_LOOP_FUNCTION float mcv_limited(float x, float most) {
    const float below = x < most ? x : most;
    return below > -most ? below : -most;
}

/* (0, 0) is the upper left corner of the image, as glTF has it. Coordinates beyond 2^16 periods
 * have lost their digits. */
MCV_LOOP_FUNCTION mcv_texture_place mcv_find_texel(__global const mcv_device_texture *texture,
                                                   float s, float t) {
    mcv_texture_place place;
    const float x = mcv_limited(s, 65536.0f) * (float)texture->width;
    const float y = mcv_limited(t, 65536.0f) * (float)texture->height;
    const float middle = texture->nearest ? 0.0f : 0.5f;
    const float left = mcv_floor(x - middle);
    const float top = mcv_floor(y - middle);
    place.i = (int)left;
    place.j = (int)top;
    place.a = x - middle - left;
    place.b = y - middle - top;
    return place;
}

/* The texels at a place: of the nearest one, or of the four around it from left to right and down,
 * the numbers. */
typedef struct mcv_texture_corners {
    uint texel[4];
} mcv_texture_corners;

MCV_LOOP_FUNCTION mcv_texture_corners mcv_corners_of(__global const mcv_device_texture *texture,
                                                     mcv_texture_place place) {
    const uint left = mcv_wrap(place.i, texture->width, texture->wrap_s),
               right = mcv_wrap(place.i + 1, texture->width, texture->wrap_s),
               top = mcv_wrap(place.j, texture->height, texture->wrap_t) * texture->width,
               bottom = mcv_wrap(place.j + 1, texture->height, texture->wrap_t) * texture->width;
    const mcv_texture_corners corners = {{top + left, top + right, bottom + left, bottom + right}};
    return corners;
}

/* A channel there. */
MCV_LOOP_FUNCTION float mcv_texture_channel(mcv_world world,
                                            __global const mcv_device_texture *texture,
                                            mcv_texture_place place, mcv_texture_corners corners,
                                            uint i) {
    const float c00 = mcv_texel_value(world, texture, corners.texel[0], i),
                c10 = mcv_texel_value(world, texture, corners.texel[1], i),
                c01 = mcv_texel_value(world, texture, corners.texel[2], i),
                c11 = mcv_texel_value(world, texture, corners.texel[3], i);
    const float upper = mcv_fma(place.a, c10 - c00, c00);
    const float lower = mcv_fma(place.a, c11 - c01, c01);
    const float between = mcv_fma(place.b, lower - upper, upper);
    return texture->nearest ? c00 : between;
}

MCV_LOOP_FUNCTION mcv_color mcv_texture_lookup(mcv_world world, uint index, float s, float t) {
    __global const mcv_device_texture *texture = world.textures + index;
    const mcv_texture_place place = mcv_find_texel(texture, s, t);
    const mcv_texture_corners corners = mcv_corners_of(texture, place);
    mcv_color color;
    MCV_EACH_CHANNEL(i)
    color.c[i] = mcv_texture_channel(world, texture, place, corners, (uint)i);
    return color;
}

/* A single channel of an image of linear values, however many the render has. */
MCV_LOOP_FUNCTION float mcv_texture_value(mcv_world world, uint index, float s, float t,
                                          uint channel) {
    __global const mcv_device_texture *texture = world.textures + index;
    const mcv_texture_place place = mcv_find_texel(texture, s, t);
    return mcv_texture_channel(world, texture, place, mcv_corners_of(texture, place), channel);
}

#endif
