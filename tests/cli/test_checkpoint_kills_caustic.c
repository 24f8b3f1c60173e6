/* SPDX-License-Identifier: Apache-2.0 */
/* Renders with light paths or a pilot that are killed go on to the same bits. */
#define FIRST_KILLED 3
#define LAST_KILLED 5
#include "test_checkpoint.c"
