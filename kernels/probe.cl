/* SPDX-License-Identifier: Apache-2.0 */
#include "mcvisi/dialect.h"

__kernel void probe_placeholder(__global uint *out) { out[0] = 0; }
