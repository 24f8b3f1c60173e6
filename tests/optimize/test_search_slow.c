/* SPDX-License-Identifier: Apache-2.0 */
/* ctest: label slow */
/* test_search.c with 200 runs: the share of intervals that hold the truth. */
#define RUNS 200
#include "test_search.c"
