/* SPDX-License-Identifier: Apache-2.0 */
/* Files of PoCL's cache that some file systems leave full of zeros. */
#define FIRST_WAY 2
#define WAYS 3
#include "test_pocl_cache.c"
