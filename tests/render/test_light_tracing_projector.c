/* SPDX-License-Identifier: Apache-2.0 */
/* Light paths of a projector. */
#define GROUP GROUP_PROJECTOR
#include "test_light_tracing.c"
