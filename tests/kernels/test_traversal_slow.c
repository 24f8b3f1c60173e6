/* SPDX-License-Identifier: Apache-2.0 */
/* ctest: label slow */
/* ctest: label truth */
/* ctest: timeout 7200 */
/* The tests of test_traversal.c with a hundred times the rays: above 10^8 for equal hits and 10^9
 * for watertightness. */
#define RAY_FACTOR 100
#include "test_traversal.c"
