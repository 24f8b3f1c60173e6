/* SPDX-License-Identifier: Apache-2.0 */
/* Light paths by surfaces that spread light a little. */
#define GROUP GROUP_GLOSS
#include "test_light_tracing.c"
