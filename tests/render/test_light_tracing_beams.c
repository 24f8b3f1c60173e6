/* SPDX-License-Identifier: Apache-2.0 */
/* Light paths of beams into lenses, and the same bits. */
#define GROUP GROUP_BEAMS
#include "test_light_tracing.c"
