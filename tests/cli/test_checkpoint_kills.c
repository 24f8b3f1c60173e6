/* SPDX-License-Identifier: Apache-2.0 */
/* Renders that are killed go on to the same bits. */
#define FIRST_KILLED 0
#define LAST_KILLED 3
#include "test_checkpoint.c"
