/* SPDX-License-Identifier: Apache-2.0 */
/* What mixed precision shows is what single precision does. */
#define IMAGES 1
#include "test_precision.c"
