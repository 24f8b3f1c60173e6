/* SPDX-License-Identifier: Apache-2.0 */
/* Faces, rays, lights and films at the edge of what numbers hold, of test_stress.c. */
#define PART PART_LIGHT
#include "test_stress.c"
