/* SPDX-License-Identifier: Apache-2.0 */
/* The options of `mcvisi scan` that no other verb has: a part of MCV_OPTIONS (options/options.h).
 */
#ifndef MCVISI_HOST_OPTIONS_OPTIONS_SCAN_H
#define MCVISI_HOST_OPTIONS_OPTIONS_SCAN_H

#define MCV_SCAN_OPTIONS(X) \
    X(count, profile_count, "profiles", 0, "N", MCV_IN_SCAN, "1", 1, 100000, \
      "how many profiles are rendered") \
    X(choice, scan_speckle, "speckle", 0, "on|off", MCV_IN_SCAN, "on", 0, 0, \
      "speckle, of another pattern in each profile") \
    X(flag, budget, "budget", 0, NULL, MCV_IN_SCAN, NULL, 0, 0, \
      "tell what each cause brings to the error of heights, by a run of its own, and hold the " \
      "sum against all of them together")

#endif
