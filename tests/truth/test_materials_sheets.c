/* SPDX-License-Identifier: Apache-2.0 */
/* Translucent sheets and retroreflectors of test_materials.c. */
#define PART PART_SHEETS
#include "test_materials.c"
