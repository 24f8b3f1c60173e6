/* SPDX-License-Identifier: Apache-2.0 */
/* ctest: label slow */
/* ctest: timeout 3000 */
/* The tests of test_traversal.c with ten times the rays: above 10^7 each for equal hits and for watertightness. */
#define RAY_FACTOR 10
#include "test_traversal.c"
