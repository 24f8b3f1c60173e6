/* SPDX-License-Identifier: Apache-2.0 */
/* Textured microfacets of test_materials.c, as both renderers see them. */
#define PART PART_TEXTURES
#include "test_materials.c"
