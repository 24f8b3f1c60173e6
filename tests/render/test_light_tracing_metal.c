/* SPDX-License-Identifier: Apache-2.0 */
/* Light paths by metal plates. */
#define GROUP GROUP_METAL
#include "test_light_tracing.c"
