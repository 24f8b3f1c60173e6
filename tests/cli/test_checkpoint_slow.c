/* SPDX-License-Identifier: Apache-2.0 */
/* ctest: label slow */
/* ctest: timeout 1800 */
/* Twenty kills of each render. */
#define KILLS 20
#include "test_checkpoint.c"
