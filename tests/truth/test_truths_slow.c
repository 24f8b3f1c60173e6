/* SPDX-License-Identifier: Apache-2.0 */
/* ctest: label truth */
/* ctest: label slow */
/* ctest: timeout 600 */
/* Truths of test_truths.c that take many samples: power is linear, light goes forward as backward.
 */
#define SLOW 1
#include "test_truths.c"
