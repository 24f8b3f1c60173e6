/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The only file that distinguishes the two languages. The headers in include/mcvisi are compiled as
 * OpenCL C 1.2 on the device and as C11 on the host, with the same bits. They use only + - * / sqrt
 * fma, comparisons and integers. Contraction is off on both sides (host: -ffp-contract=off).
 *
 * The clang front end defines only __OPENCL_C_VERSION__; drivers define __OPENCL_VERSION__ too.
 */
#ifndef MCVISI_DIALECT_H
#define MCVISI_DIALECT_H

#if defined(__OPENCL_VERSION__) || defined(__OPENCL_C_VERSION__)

#define MCV_ON_DEVICE 1
#pragma OPENCL FP_CONTRACT OFF
#define MCV_GLOBAL __global
#define MCV_CONSTANT __constant
#define MCV_FUNCTION static inline
/*
 * The compiler vectorises a loop only if it has no calls. In the tile schedule these functions are
 * not static: clang removes unused parameters from static functions, and the rewritten call loses
 * the promise that iterations are independent. __inline__ says that no caller lies in another file,
 * so that clang emits no separate function. It is written with underscores because PoCL defines
 * `inline` away.
 */
#if defined(MCV_TILE) && defined(__clang__)
#pragma clang diagnostic ignored "-Wstatic-in-inline"
#define MCV_LOOP_FUNCTION __inline__ __attribute__((always_inline))
#else
#define MCV_LOOP_FUNCTION static inline __attribute__((always_inline))
#endif
#define MCV_ASSERT_SIZE(type, bytes) \
    typedef char mcv_size_of_##type[sizeof(type) == (bytes) ? 1 : -1]
#define mcv_fma(a, b, c) fma((float)(a), (float)(b), (float)(c))
#define mcv_sqrt(x) sqrt((float)(x))
#define mcv_abs(x) fabs((float)(x))
#define mcv_floor(x) floor((float)(x))

#else

#include <math.h>
#include <stdint.h>
#include <string.h>

#define MCV_ON_DEVICE 0
#define MCV_GLOBAL
#define MCV_CONSTANT
#define MCV_FUNCTION static inline
#define MCV_LOOP_FUNCTION static inline
#define MCV_ASSERT_SIZE(type, bytes) \
    _Static_assert(sizeof(type) == (bytes), #type " has another size on the device")
typedef uint32_t uint;
#define mcv_fma(a, b, c) fmaf((a), (b), (c))
#define mcv_sqrt(x) sqrtf(x)
#define mcv_abs(x) fabsf(x)
#define mcv_floor(x) floorf(x)

MCV_FUNCTION uint as_uint(float x) {
    uint bits;
    memcpy(&bits, &x, sizeof bits);
    return bits;
}

MCV_FUNCTION float as_float(uint bits) {
    float x;
    memcpy(&x, &bits, sizeof x);
    return x;
}

#endif

/* "None": an absent texture, emitter, medium or triangle. */
#define MCV_NONE 0xffffffffu
#define MCV_SKY 0xfffffffeu /* in place of an instance: infinitely far away */

#endif
