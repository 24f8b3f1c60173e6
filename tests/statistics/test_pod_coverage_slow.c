/* SPDX-License-Identifier: Apache-2.0 */
/* ctest: label slow */
/* ctest: timeout 1200 */
/* test_pod_coverage.c with four times the trials, and with censored signals. */
#define TRIALS 4000
#define CENSORED_TRIALS 2000
#include "test_pod_coverage.c"
