/* SPDX-License-Identifier: Apache-2.0 */
/* ctest: label slow */
/* ctest: timeout 1200 */
/* The images of test_precision.c, with both schedules and small slices. */
#define SLOW 1
#include "test_precision.c"
