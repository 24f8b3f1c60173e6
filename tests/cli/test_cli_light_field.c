/* SPDX-License-Identifier: Apache-2.0 */
/* What the program of test_cli.c makes of light fields, and lenses before its cameras. */
#define PART PART_LIGHT_FIELD
#include "test_cli.c"
