/* SPDX-License-Identifier: Apache-2.0 */
/* ctest: label slow */
/* ctest: timeout 1800 */
/* A hundred kills of sweeps, and of merges. */
#define KILLS 100
#include "test_kills.c"
