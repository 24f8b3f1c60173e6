/* SPDX-License-Identifier: Apache-2.0 */
/* ctest: label slow */
/* ctest: label truth */
/* ctest: timeout 1200 */
/* Rough glass of more roughnesses, with more walks. */
#define ALPHAS 0.05, 0.1, 0.2, 0.35, 0.6
enum { WALKS = 160000 };
#include "test_rough_glass.c"
