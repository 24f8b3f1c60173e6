/* SPDX-License-Identifier: Apache-2.0 */
/* Furnaces of test_render.c, and the digits of its sums. */
#define FURNACES 1
#include "test_render.c"
