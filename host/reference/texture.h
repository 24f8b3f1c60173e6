/* SPDX-License-Identifier: Apache-2.0 */
#ifndef MCVISI_HOST_REFERENCE_TEXTURE_H
#define MCVISI_HOST_REFERENCE_TEXTURE_H

#include "scene/scene.h"

/*
 * The linear R, G, B of a texture at glTF's two sets of coordinates (0, 0 is the top-left corner of
 * the image). It uses the set and the transform of the texture; values are decoded from sRGB (IEC
 * 61966-2-1), then interpolated. `texture` MCV_NONE is white.
 */
void ref_texture_lookup(const mcv_scene *scene, uint32_t texture, const double texcoord[2][2],
                        double rgb[3]);

/* The texel there, column and row, of a texture without interpolation; false for others. */
bool ref_nearest_texel(const mcv_texture *texture, const double texcoord[2][2], uint32_t texel[2]);

/* Linear R, G, B of one texel. */
void ref_texel(const mcv_texture *texture, uint32_t column, uint32_t row, double rgb[3]);

#endif
