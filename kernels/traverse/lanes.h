/* SPDX-License-Identifier: Apache-2.0 */
/* Values side by side in registers: masks of lanes, and as many lanes as the processor has. */
#ifndef MCVISI_KERNELS_LANES_H
#define MCVISI_KERNELS_LANES_H

#include "mcvisi/dialect.h"

/* Without AVX clang warns that float8 arguments have no stable ABI; all of these calls are inlined.
 */
#ifdef __clang__
#pragma clang diagnostic ignored "-Wpsabi"
#endif

/* clang knows the mask builtins on any x86, but can only emit them with AVX. */
#if defined(__AVX__) && defined(__has_builtin)
#if __has_builtin(__builtin_ia32_movmskps256) && __has_builtin(__builtin_ia32_movmskps)
#define MCV_AVX_BUILTINS 1
#endif
#endif

/* One bit per lane with a negative (true) value. */
static inline uint mcv_mask8(int8 lanes) {
#ifdef MCV_AVX_BUILTINS
    return (uint)__builtin_ia32_movmskps256(as_float8(lanes));
#else
    const int8 bits = lanes & (int8)(1, 2, 4, 8, 16, 32, 64, 128);
    const int4 four = bits.lo | bits.hi;
    const int2 two = four.lo | four.hi;
    return (uint)(two.x | two.y);
#endif
}

#ifdef __AVX512F__
static inline uint mcv_mask16(int16 lanes) {
#if defined(MCV_AVX_BUILTINS) && defined(__AVX512DQ__)
    return (uint)__builtin_ia32_cvtd2mask512(lanes) & 0xffffu;
#else
    return mcv_mask8(lanes.lo) | mcv_mask8(lanes.hi) << 8;
#endif
}
#endif

static inline uint mcv_mask4(int4 lanes) {
#ifdef MCV_AVX_BUILTINS
    return (uint)__builtin_ia32_movmskps(as_float4(lanes));
#else
    const int4 bits = lanes & (int4)(1, 2, 4, 8);
    const int2 two = bits.lo | bits.hi;
    return (uint)(two.x | two.y);
#endif
}

/* Lane i is lane lanes[i], 0 … 7, of the values. */
static inline uint8 mcv_permute8(uint8 values, uint8 lanes) {
#if defined(MCV_AVX_BUILTINS) && defined(__AVX2__)
    return as_uint8(__builtin_ia32_permvarsi256(as_int8(values), as_int8(lanes)));
#else
    uint from[8], which[8];
    vstore8(values, 0, from);
    vstore8(lanes, 0, which);
#pragma unroll
    for (int i = 0; i < 8; ++i) which[i] = from[which[i]];
    return vload8(0, which);
#endif
}

/* Takes the highest bit out of a mask and returns its number. */
static inline uint mcv_pop_bit(uint *mask) {
    const uint bit = 31u - clz(*mask);
    *mask ^= 1u << bit;
    return bit;
}

/* Rays side by side: as many as the processor's registers hold. */
#ifdef __AVX512F__
#define MCV_LANES 16
typedef float16 mcv_floats;
typedef int16 mcv_ints;
typedef uint16 mcv_uints;
#define mcv_load_lanes(from) vload16(0, from)
#define mcv_store_lanes(lanes, to) vstore16(lanes, 0, to)
#define mcv_mask_lanes mcv_mask16
#define mcv_as_floats as_float16
#define mcv_as_uints as_uint16
#else
#define MCV_LANES 8
typedef float8 mcv_floats;
typedef int8 mcv_ints;
typedef uint8 mcv_uints;
#define mcv_load_lanes(from) vload8(0, from)
#define mcv_store_lanes(lanes, to) vstore8(lanes, 0, to)
#define mcv_mask_lanes mcv_mask8
#define mcv_as_floats as_float8
#define mcv_as_uints as_uint8
#endif

#endif
