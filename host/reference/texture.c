/* SPDX-License-Identifier: Apache-2.0 */
#include "reference/texture.h"

enum { CLAMP_TO_EDGE = 33071, MIRRORED_REPEAT = 33648 }; /* glTF; everything else repeats */

static double decode(uint8_t value) {
    const double v = value / 255.0;
    return v <= 0.04045 ? v / 12.92 : pow((v + 0.055) / 1.055, 2.4);
}

/* The texel that a texel number beyond the image stands for. */
static uint32_t wrap(double texel, uint32_t size, uint32_t mode) {
    if (mode == CLAMP_TO_EDGE) return (uint32_t)fmin(fmax(texel, 0), size - 1.0);
    const double period = mode == MIRRORED_REPEAT ? 2.0 * size : size;
    const double remainder = fmod(texel, period),
                 place = remainder < 0 ? remainder + period : remainder;
    return (uint32_t)(place < size ? place : period - 1 - place);
}

void ref_texel(const mcv_texture *texture, uint32_t column, uint32_t row, double rgb[3]) {
    const size_t number = (size_t)row * texture->width + column;
    for (int channel = 0; channel < 3; ++channel)
        rgb[channel] = texture->linear ? texture->linear[3 * number + (size_t)channel]
                                       : decode(texture->rgba[4 * number + (size_t)channel]);
}

/* Where coordinates lie on a texture, in texels. */
static void place_of(const mcv_texture *t, const double texcoord[2][2], double place[2]) {
    const double *at = texcoord[t->texcoord_set], *m = t->transform;
    double across = at[0], down = at[1];
    if (t->is_transformed) {
        across = m[0] * at[0] + m[1] * at[1] + m[2];
        down = m[3] * at[0] + m[4] * at[1] + m[5];
    }
    place[0] = across * t->width;
    place[1] = down * t->height;
}

bool ref_nearest_texel(const mcv_texture *texture, const double texcoord[2][2], uint32_t texel[2]) {
    double place[2];
    if (!texture->nearest) return false;
    place_of(texture, texcoord, place);
    texel[0] = wrap(floor(place[0]), texture->width, texture->wrap_s);
    texel[1] = wrap(floor(place[1]), texture->height, texture->wrap_t);
    return true;
}

void ref_texture_lookup(const mcv_scene *scene, uint32_t texture, const double texcoord[2][2],
                        double rgb[3]) {
    rgb[0] = rgb[1] = rgb[2] = 1;
    if (texture == MCV_NONE) return;
    const mcv_texture *t = &scene->textures[texture];
    double place[2];
    place_of(t, texcoord, place);
    const double u = place[0], v = place[1];
    double left = floor(u), top = floor(v), right_share = 0, bottom_share = 0;
    if (!t->nearest) { /* between the centres of texels */
        left = floor(u - 0.5);
        top = floor(v - 0.5);
        right_share = u - 0.5 - left;
        bottom_share = v - 0.5 - top;
    }
    for (int channel = 0; channel < 3; ++channel) rgb[channel] = 0;
    for (int i = 0; i < 4; ++i) {
        const int right = i & 1, bottom = i >> 1;
        const uint32_t column = wrap(left + right, t->width, t->wrap_s),
                       row = wrap(top + bottom, t->height, t->wrap_t);
        const double share =
            (right ? right_share : 1 - right_share) * (bottom ? bottom_share : 1 - bottom_share);
        double texel[3];
        ref_texel(t, column, row, texel);
        for (int channel = 0; channel < 3; ++channel) rgb[channel] += share * texel[channel];
    }
}
