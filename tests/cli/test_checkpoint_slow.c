/* SPDX-License-Identifier: Apache-2.0 */
/* ctest: label slow */
/* ctest: timeout 1800 */
/* A hundred kills of renders by OpenCL, and twenty of the reference renderer. */
#define KILLS 20
#define FIRST_KILLED 0
#define LAST_KILLED 5
#include "test_checkpoint.c"
