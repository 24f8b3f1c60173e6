/* SPDX-License-Identifier: Apache-2.0 */
/* ctest: label truth */
/* Furnaces of all materials that lose nothing, and meshes that converge (test_truths.c). */
#define LOSSLESS 1
#include "test_truths.c"
