/* SPDX-License-Identifier: Apache-2.0 */
/* ctest: label slow */
/* ctest: timeout 1800 */
/* Light paths before every sensor, against chance, and the same bits in more ways. */
#define GROUP GROUP_ALL
#include "test_light_tracing.c"
