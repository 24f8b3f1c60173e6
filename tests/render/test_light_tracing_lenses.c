/* SPDX-License-Identifier: Apache-2.0 */
/* Light paths through several slabs, from a projector, through a lens. */
#define GROUP GROUP_LENSES
#include "test_light_tracing.c"
