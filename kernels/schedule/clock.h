/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Where the time of a fused kernel goes, for bench/stages.c: built with MCV_CLOCK it writes the
 * processor's ticks in each stage, modulo 2^32; otherwise nothing of this is there. Needs a
 * compiler that knows such a counter, as PoCL's does.
 */
#ifndef MCVISI_KERNELS_CLOCK_H
#define MCVISI_KERNELS_CLOCK_H

#include "mcvisi/features.h"

#ifdef MCV_CLOCK
#define MCV_X(stage, runs) MCV_CLOCK_##stage,
enum { MCV_STAGES(MCV_X) MCV_CLOCK_COUNT };
#undef MCV_X
#define MCV_CLOCK_BEGIN \
    uint ticks[MCV_CLOCK_COUNT] = {0}; \
    uint ticked = (uint)__builtin_readcyclecounter();
/* The time since the last one was this stage's. */
#define MCV_CLOCK_STAGE(stage) \
    ticks[MCV_CLOCK_##stage] -= ticked; \
    ticked = (uint)__builtin_readcyclecounter(); \
    ticks[MCV_CLOCK_##stage] += ticked;
#define MCV_CLOCK_END(to) \
    for (uint i = 0; i < MCV_CLOCK_COUNT; ++i) (to)[i] = ticks[i];
#else
#define MCV_CLOCK_BEGIN
#define MCV_CLOCK_STAGE(stage)
#define MCV_CLOCK_END(to)
#endif

#endif
