/* SPDX-License-Identifier: Apache-2.0 */
/* What the program of test_cli.c makes of pictures: cameras, measures, comparisons. */
#define PART PART_MEASURE
#include "test_cli.c"
