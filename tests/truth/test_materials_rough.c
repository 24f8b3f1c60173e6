/* SPDX-License-Identifier: Apache-2.0 */
/* Materials that spread light. */
#define PART PART_ROUGH
#include "test_materials.c"
