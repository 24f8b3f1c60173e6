/* SPDX-License-Identifier: Apache-2.0 */
/* Which paths of a slice go where: the tile schedule's lists of slots. */
#ifndef MCVISI_KERNELS_COMPACT_H
#define MCVISI_KERNELS_COMPACT_H

#include "mcvisi/dialect.h"

/* clang knows the builtins on any x86, but can only emit them with AVX-512. */
#if defined(__AVX512F__) && defined(__has_builtin)
#if __has_builtin(__builtin_ia32_compresssi512_mask) && \
    __has_builtin(__builtin_ia32_expandsi512_mask) && \
    __has_builtin(__builtin_ia32_ucmpd512_mask) && __has_builtin(__builtin_ia32_vpermi2vard512)
#define MCV_AVX512_BUILTINS 1
#endif
#endif

#ifdef MCV_AVX512_BUILTINS
/* A bit for each of the flags i … i + 15 that is not 0, of those before count. */
static inline ushort mcv_set_flags(const uint *flags, uint i, uint count) {
    enum { NOT_EQUAL = 4 };
    const ushort within = (ushort)(count - i < 16u ? (1u << (count - i)) - 1u : 0xffffu);
    return __builtin_ia32_ucmpd512_mask(as_int16(vload16(0, flags + i)), (int16)(0), NOT_EQUAL,
                                        within);
}
#endif

/*
 * Lists the numbers i < count with flags[i] != 0, in their order; returns how many. Both rows have
 * room for the next multiple of 16: what lies beyond is read and written, and counts for nothing.
 */
static inline __attribute__((noinline)) uint mcv_compact_indices(const uint *flags, uint count,
                                                                 uint *listed) {
    uint n = 0;
#ifdef MCV_AVX512_BUILTINS
    int16 numbers = (int16)(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
    for (uint i = 0; i < count; i += 16) {
        const ushort set = mcv_set_flags(flags, i, count);
        vstore16(as_uint16(__builtin_ia32_compresssi512_mask(numbers, numbers, set)), 0,
                 listed + n);
        n += popcount((uint)set);
        numbers += 16;
    }
#else
    for (uint i = 0; i < count; ++i) {
        listed[n] = i;
        n += flags[i] != 0u;
    }
#endif
    return n;
}

/* The words of rows, which begin so many words after each other, whose flags are not 0: side by
 * side, in the same rows or others; returns how many in each. The same room. */
static inline __attribute__((noinline)) uint mcv_compact_rows(const uint *flags, const uint *rows,
                                                              uint row_count, uint stride,
                                                              uint count, uint *packed) {
    uint n = 0;
#ifdef MCV_AVX512_BUILTINS
    for (uint i = 0; i < count; i += 16) {
        const ushort set = mcv_set_flags(flags, i, count);
        for (uint row = 0; set && row < row_count; ++row) {
            const int16 words = as_int16(vload16(0, rows + row * stride + i));
            vstore16(as_uint16(__builtin_ia32_compresssi512_mask(words, words, set)), 0,
                     packed + row * stride + n);
        }
        n += popcount((uint)set);
    }
#else
    for (uint i = 0; i < count; ++i) n += flags[i] != 0u;
    for (uint row = 0; n > 0 && row < row_count; ++row) {
        uint *to = packed + row * stride;
        for (uint i = 0; i < count; ++i) {
            *to = rows[row * stride + i];
            to += flags[i] != 0u;
        }
    }
#endif
    return n;
}

/* The same of one row. */
static inline uint mcv_compact_row(const uint *flags, const uint *row, uint count, uint *packed) {
    return mcv_compact_rows(flags, row, 1, 0, count, packed);
}

/* The words that mcv_compact_row has set side by side go back to where the flags are not 0; the
 * others of the row are any. The same room. */
static inline __attribute__((noinline)) void mcv_expand_row(const uint *flags, const uint *packed,
                                                            uint count, uint *row) {
    uint n = 0;
#ifdef MCV_AVX512_BUILTINS
    for (uint i = 0; i < count; i += 16) {
        const ushort set = mcv_set_flags(flags, i, count);
        const int16 words = as_int16(vload16(0, packed + n));
        vstore16(as_uint16(__builtin_ia32_expandsi512_mask(words, words, set)), 0, row + i);
        n += popcount((uint)set);
    }
#else
    for (uint i = 0; i < count; ++i) {
        row[i] = packed[n];
        n += flags[i] != 0u;
    }
#endif
}

/* So many turns of a loop over rows fill the vectors: for rows that have the room, where nothing is
 * kept beyond their words. */
static inline uint mcv_fill_lanes(uint count) { return (count + 15u) & ~15u; }

/* So many entries of a table can be looked up in registers; 0: none. */
#ifdef MCV_AVX512_BUILTINS
#define MCV_CACHED 32

/* found[i] = from[numbers[i]], of MCV_CACHED; up to the next multiple of 16. */
static inline void mcv_register_lookup(const uint *from, const uint *numbers, uint count,
                                       uint *found) {
    const int16 low = as_int16(vload16(0, from)), high = as_int16(vload16(1, from));
    for (uint i = 0; i < count; i += 16) {
        const int16 chosen = as_int16(vload16(0, numbers + i));
        vstore16(as_uint16(__builtin_ia32_vpermi2vard512(low, chosen, high)), 0, found + i);
    }
}
#else
#define MCV_CACHED 0
#endif

#endif
