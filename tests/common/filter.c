/* SPDX-License-Identifier: Apache-2.0 */
/* Every test runs only those of its functions that MCVISI_TEST_FILTER matches (* and ?), where that
 * is set: ./run mutants needs it. */
#include "test.h"

#include <stdlib.h>

__attribute__((constructor)) static void take_filter(void) {
    const char *pattern = getenv("MCVISI_TEST_FILTER");
    if (pattern && *pattern) cmocka_set_test_filter(pattern);
}
