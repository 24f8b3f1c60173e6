/* SPDX-License-Identifier: Apache-2.0 */
/* ctest: label slow */
/* ctest: timeout 1800 */
/* The same bits of test_render.c, of more scenes, samplers, slices and with rays that take turns.
 */
#define SLOW 1
#include "test_render.c"
