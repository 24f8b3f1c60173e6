/* SPDX-License-Identifier: Apache-2.0 */
#include "deflectometry/phase.h"

#include <math.h>

mcv_fringe mcv_fringe_decode(const double *values, uint32_t steps) {
    double s = 0, c = 0, sum = 0;
    for (uint32_t k = 0; k < steps; ++k) {
        s += values[k] * sin(2 * M_PI * k / steps);
        c += values[k] * cos(2 * M_PI * k / steps);
        sum += values[k];
    }
    const double phase = atan2(s, c);
    return (mcv_fringe){.phase = phase < 0 ? phase + 2 * M_PI : phase,
                        .modulation = 2 / (double)steps * hypot(s, c),
                        .mean = sum / steps};
}

double mcv_fringe_deviation(uint32_t steps, double value_deviation, double modulation) {
    return sqrt(2.0 / steps) * value_deviation / modulation;
}

/* The place that is nearest to a coarse one and has this phase, on the screen. */
static double nearest_period(double coarse, double phase, double periods) {
    const double place = phase / (2 * M_PI) + round(coarse - phase / (2 * M_PI));
    return place < 0 ? place + periods : place > periods ? place - periods : place;
}

double mcv_unwrap_heterodyne(double phase, double phase_of_fewer, double periods) {
    const double beat = (phase - phase_of_fewer) / (2 * M_PI);
    return nearest_period(periods * (beat - floor(beat)), phase, periods);
}

double mcv_unwrap_gray(double phase, uint32_t half_period, double periods) {
    return nearest_period((half_period + 0.5) / 2, phase, periods);
}
