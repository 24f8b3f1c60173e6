/* SPDX-License-Identifier: Apache-2.0 */
/* ctest: label slow */
/* ctest: timeout 1200 */
/* The tests of test_adaptive.c, with light paths, without error bars, and small slices. */
#define SLOW 1
#include "test_adaptive.c"
