/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Phases of fringes: decoding of N-step phase shifting, and unwrapping.
 *
 * Image k of N shows 1/2 + 1/2 cos(φ - 2πk/N) (mcvisi/pattern.h). With S = Σ I_k sin(2πk/N) and C =
 * Σ I_k cos(2πk/N) the phase is φ = atan2(S, C), the modulation B = 2/N √(S² + C²), and the mean A
 * = Σ I_k/N. Independent errors u(I) of the values give u(φ) = √(2/N) u(I)/B.
 *
 * Source: V. Srinivasan, H. C. Liu, M. Halioua, Applied Optics 23 (1984) 3105. Heterodyne: C.
 * Reich, R. Ritter, J. Thesing, Optical Engineering 39 (2000) 224.
 */
#ifndef MCVISI_HOST_DEFLECTOMETRY_PHASE_H
#define MCVISI_HOST_DEFLECTOMETRY_PHASE_H

#include <stdint.h>

typedef struct mcv_fringe {
    double phase; /* [0, 2π) */
    double modulation, mean;
} mcv_fringe;

/* From values[0 … steps - 1]; steps >= 3. */
mcv_fringe mcv_fringe_decode(const double *values, uint32_t steps);

/* The standard uncertainty of a phase [rad]. */
double mcv_fringe_deviation(uint32_t steps, double value_deviation, double modulation);

/*
 * The place in periods, from 0 to `periods`, of the phase of fringes with that many periods across
 * the screen and of that of one period less: their difference, the beat, has one period.
 */
double mcv_unwrap_heterodyne(double phase, double phase_of_fewer, double periods);

/* The same from the number of the half period, 0 … 2 periods - 1, that a Gray code tells. An error
 * of one half period is put right. */
double mcv_unwrap_gray(double phase, uint32_t half_period, double periods);

#endif
