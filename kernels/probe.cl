/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Does the device compute as IEEE 754 says? The host compares the bits (host/cl/cl.c). It is part
 * of every program: one of its own would have to be compiled besides.
 */
#include "mcvisi/dialect.h"

__kernel void probe_arithmetic(__global const float *inputs, __global float *results) {
    const uint i = get_global_id(0);
    const float a = inputs[3 * i];
    const float b = inputs[3 * i + 1];
    const float c = inputs[3 * i + 2];
    results[4 * i] = mcv_fma(a, b, c);
    results[4 * i + 1] = a / b;
    results[4 * i + 2] = mcv_sqrt(a);
    results[4 * i + 3] = a * b;
}
