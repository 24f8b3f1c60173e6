/* SPDX-License-Identifier: Apache-2.0 */
/* Surfaces of microfacets of test_materials.c, as both renderers see them. */
#define PART PART_IMAGES
#include "test_materials.c"
