/* SPDX-License-Identifier: Apache-2.0 */
/* ctest: label slow */
/* ctest: timeout 3600 */
/* The tests of test_planted_errors.c with more seeds: the share of planted errors that are
 * rejected, and of equal pairs that are not. */
#define ERROR_PAIRS 20
#define EQUAL_PAIRS 400
#include "test_planted_errors.c"
