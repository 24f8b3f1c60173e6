/* SPDX-License-Identifier: Apache-2.0 */
/* ctest: label slow */
/* ctest: timeout 1200 */
/* Colours of test_glass.c behind rough glass and in light paths. */
#define SLOW 1
#include "test_glass.c"
