/* SPDX-License-Identifier: Apache-2.0 */
/* ctest: label slow */
/* test_circle with the 1000 cases that are asked for, and also with a noise that is estimated from
 * the image's neighbouring pixels: intervals by Student's t. */
#define CASES 1000
#define ALSO_ESTIMATED true
#include "test_circle.c"
