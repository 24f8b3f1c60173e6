/* SPDX-License-Identifier: Apache-2.0 */
/* Stated uncertainties: value ± 1.96 uncertainty must hold the truth in 95 % of the cases. */
#ifndef MCVISI_TESTS_COVERAGE_H
#define MCVISI_TESTS_COVERAGE_H

/* The slow twin of a test defines as many as are asked for, before it includes the test. */
#ifndef CASES
#define CASES 200
#endif

/*
 * By how much a share of 95 % may be off: 2 % are asked of 1000 cases, where its standard deviation
 * is 0.7 %. Of fewer ones, three standard deviations.
 */
static const double margin = CASES < 1000 ? 3 * 0.2179 / 14.14 : 0.02; /* √(0.95 · 0.05)/√200 */

#endif
