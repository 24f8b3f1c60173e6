/* SPDX-License-Identifier: Apache-2.0 */
/* ctest: label slow */
/* test_circle with a noise that is estimated from the image's neighbouring pixels: intervals by Student's t. */
#define NOISE_IS_KNOWN false
#include "test_circle.c"
