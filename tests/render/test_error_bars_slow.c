/* SPDX-License-Identifier: Apache-2.0 */
/* ctest: label truth */
/* ctest: label slow */
/* ctest: timeout 900 */
/* The tests of test_error_bars.c with all scenes. */
#define SLOW 1
#include "test_error_bars.c"
