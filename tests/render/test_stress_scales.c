/* SPDX-License-Identifier: Apache-2.0 */
/* Scenes of all sizes and at all places, of test_stress.c. */
#define PART PART_SCALES
#include "test_stress.c"
