/* SPDX-License-Identifier: Apache-2.0 */
/* Lights and wishes of `mcvisi new`. */
#define PART PART_LIGHTS
#include "test_new.c"
