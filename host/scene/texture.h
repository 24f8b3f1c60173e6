/* SPDX-License-Identifier: Apache-2.0 */
/* Values of textures. */
#ifndef MCVISI_HOST_SCENE_TEXTURE_H
#define MCVISI_HOST_SCENE_TEXTURE_H

#include "scene/scene.h"

/* The linear value of a byte encoded as IEC 61966-2-1 says. */
double mcv_srgb_decode(uint8_t value);

/* Linear R, G, B of a texture's pixel; `decoded` holds mcv_srgb_decode of all bytes. */
void mcv_texture_value(const mcv_texture *texture, const double decoded[256], uint32_t column,
                       uint32_t row, double rgb[3]);
void mcv_srgb_table(double decoded[256]);

#endif
