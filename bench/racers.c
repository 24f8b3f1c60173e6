/* SPDX-License-Identifier: Apache-2.0 */
#include "racers.h"

#include <math.h>
#include <stdio.h>

enum { LAST = RACE_POINTS - 1 };

double racer_exponent(const racer *x) {
    return fmin(fmax(log(x->rmse[LAST - 1] / x->rmse[LAST]) / log(4), 0.5), 1);
}

double racer_whole(const racer *x, bench_clock clock) { return x->seconds[clock][LAST]; }

double racer_seconds(const racer *x, bench_clock clock, double samples) {
    const double all = racer_whole(x, clock),
                 slope = fmin(fmax((all - x->seconds[clock][LAST - 1]) / 0.75, 0), all);
    return all - slope + slope * samples;
}

double racer_seconds_to(const racer *x, bench_clock clock, double rmse) {
    return racer_seconds(x, clock, pow(x->rmse[LAST] / rmse, 1 / racer_exponent(x)));
}

double racer_equal_error(const racer *x, const racer *y) {
    return sqrt(x->rmse[LAST] * y->rmse[LAST]);
}

double racer_time_ratio(const racer *ours, const racer *other, bench_clock clock) {
    const double rmse = racer_equal_error(ours, other);
    return racer_seconds_to(other, clock, rmse) / racer_seconds_to(ours, clock, rmse);
}

void racer_note_curve(bench *b, const racer *x) {
    for (int point = 0; point < RACE_POINTS; ++point) {
        const uint32_t samples = x->maker.samples >> 2 * (LAST - point);
        if (samples == 0) continue;
        bench_number(b, x->rmse[point] / mcv_film_mean(x->maker.truth), NAN, "RMSE/mean",
                     "%s, %s, %u samples", x->maker.scene_name, x->name, samples);
        bench_more(b, "curve_seconds", x->seconds[BENCH_WALL][point]);
        bench_more(b, "curve_processor_seconds", x->seconds[BENCH_CPU][point]);
    }
}

void race_means_add(race_means *m, race_figure figure, race_set set, bench_clock clock,
                    double ratio) {
    const race_set sets[2] = {RACE_ALL, set};
    for (int i = 0; i < 2; ++i) {
        bench_mean *mean = &m->mean[figure][sets[i]][clock];
        double *least = &m->least[figure][sets[i]][clock];
        *least = mean->count ? fmin(*least, ratio) : ratio;
        bench_mean_add(mean, ratio);
    }
}

void race_means_note(bench *b, const race_means *m) {
    static const char *const figures[RACE_FIGURES] = {"samples_per_second", "paths_per_second",
                                                      "time_to_rmse", "time_to_rmse_uniform"},
                             *const sets[RACE_SETS] = {"", "_analytic", "_mesh"},
                             *const clocks[RACE_CLOCKS] = {"", "_of_processor"};
    for (int k = 0; k < RACE_FIGURES * RACE_SETS * RACE_CLOCKS; ++k) {
        const int clock = k % RACE_CLOCKS, set = k / RACE_CLOCKS % RACE_SETS,
                  figure = k / (RACE_CLOCKS * RACE_SETS);
        const bench_mean *mean = &m->mean[figure][set][clock];
        char key[80];
        if (mean->count == 0) continue;
        snprintf(key, sizeof key, "%s%s%s", figures[figure], sets[set], clocks[clock]);
        bench_summary(b, key, bench_mean_value(mean));
        snprintf(key, sizeof key, "least_%s%s%s", figures[figure], sets[set], clocks[clock]);
        bench_summary(b, key, m->least[figure][set][clock]);
    }
}
