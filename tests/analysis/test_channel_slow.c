/* SPDX-License-Identifier: Apache-2.0 */
/* ctest: label slow */
/* test_channel with the 1000 pictures that are asked for: intervals hold the truth in 95 ± 2 % of
 * them. */
#define CASES 1000
#include "test_channel.c"
