/* SPDX-License-Identifier: Apache-2.0 */
/* ctest: label slow */
/* ctest: timeout 3600 */
/* The tests of test_split.c with all scenes and slices. */
#define SLOW 1
#include "test_split.c"
