/* SPDX-License-Identifier: Apache-2.0 */
/* ctest: label slow */
/* ctest: timeout 1200 */
/* The other scenes of test_images.c. */
#define SLOW 1
#include "test_images.c"
