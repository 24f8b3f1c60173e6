/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Loops over the paths of a slice that the compiler vectorises: only the tile schedule has them.
 *
 * MCV_VECTORIZE is one pragma and stands before a `for`, wherever a statement may stand. It
 * promises that no iteration reads what another one writes, which the compiler does not check. Sums
 * into a variable that is declared outside of the loop are allowed: the compiler sees such a
 * reduction by itself, and a promise about memory does not hide it. All of them are of integers,
 * whose sums do not depend on the order.
 *
 * The width is stated, as the compiler left to itself chooses four where a loop divides integers.
 * PoCL's front end cannot vectorise such a loop before its back end has inlined fma, hence the
 * diagnostic that is ignored. The body calls nothing but MCV_LOOP_FUNCTION (mcvisi/dialect.h).
 *
 * MCV_BATCH is how a function is declared that holds such loops. `inline` only says that a program
 * may not need it. It is not inlined: PoCL makes
 * three functions of a kernel, of which it calls one, and would compile each loop three times. For
 * AVX-512 it says, too, that registers of 16 lanes are wanted; tuned for Skylake to Ice Lake
 * clang 14 takes those of 8 otherwise. (Seen with clang 14, and in PoCL with LLVM 15;
 * -mprefer-vector-width=512 would do the same, but cannot be given to an OpenCL driver.)
 */
#ifndef MCVISI_KERNELS_VECTORIZE_H
#define MCVISI_KERNELS_VECTORIZE_H

#include "path/camera_path.h"

#if MCV_TILE && defined(__clang__) && defined(__AVX512F__)
#pragma clang diagnostic ignored "-Wpass-failed"
#define MCV_BATCH static inline __attribute__((noinline, min_vector_width(512)))
#define MCV_VECTORIZE _Pragma("clang loop vectorize(assume_safety) vectorize_width(16)")
/* Where an iteration takes long: the remainder, too, runs as one, with masks. */
#define MCV_VECTORIZE_MASKED \
    _Pragma("clang loop vectorize(assume_safety) vectorize_width(16) vectorize_predicate(enable)")
#elif MCV_TILE && defined(__clang__)
#pragma clang diagnostic ignored "-Wpass-failed"
#define MCV_BATCH static inline __attribute__((noinline))
#define MCV_VECTORIZE _Pragma("clang loop vectorize(assume_safety) vectorize_width(8)")
#define MCV_VECTORIZE_MASKED MCV_VECTORIZE
#else
#define MCV_BATCH static inline
#define MCV_VECTORIZE
#define MCV_VECTORIZE_MASKED
#endif

/* Of rows: no vector of 16 words lies across two cache lines then. */
#define MCV_ALIGNED __attribute__((aligned(64)))

/* The paths in the slots first … last - 1, one after the other. */
#if MCV_TILE
#define MCV_EACH_PATH(slot, paths, first, last) \
    for (mcv_slot slot = mcv_slot_at(paths, first); slot.index < (last); ++slot.index)
#endif

#endif
