/* SPDX-License-Identifier: Apache-2.0 */
/* For bench_render: those that race to an image of one scene, how their errors fall over time, and
 * the means over scenes of what comes out. */
#ifndef MCVISI_BENCH_RACERS_H
#define MCVISI_BENCH_RACERS_H

#include "harness.h"
#include "image_maker.h"

/* Images of a 64th, a 16th, a quarter and all of the samples; of few samples no 64th. */
enum { RACE_POINTS = 4, RACE_CLOCKS = 2 /* of bench_clock */ };

/* One of those that take part, and what it showed at each number of samples. */
typedef struct racer {
    image_maker maker; /* of all samples */
    char name[48];
    bool is_out;
    double seconds[RACE_CLOCKS][RACE_POINTS], rmse[RACE_POINTS];
} racer;

/* Of so many times all samples: what each image takes, and what each sample does. */
double racer_seconds(const racer *x, bench_clock clock, double samples);

/* Of all samples. */
double racer_whole(const racer *x, bench_clock clock);

/* By its own power law between a quarter of the samples and all. */
double racer_seconds_to(const racer *x, bench_clock clock, double rmse);

/* The exponent of RMSE ~ samples^-exponent there. It cannot be below that of random numbers: what
 * seems to be is the noise of rare paths. */
double racer_exponent(const racer *x);

/* The geometric mean of both errors, which both are to reach, and the time of the other to it over
 * that of ours. */
double racer_equal_error(const racer *x, const racer *y);
double racer_time_ratio(const racer *ours, const racer *other, bench_clock clock);

/* Rows of the errors at each number of samples. */
void racer_note_curve(bench *b, const racer *x);

/* What a race measures, of which kinds of scenes. */
typedef enum race_figure {
    RACE_SAMPLES,
    RACE_PATHS,
    RACE_TIME,
    RACE_UNIFORM_TIME,
    RACE_FIGURES
} race_figure;
typedef enum race_set { RACE_ALL, RACE_ANALYTIC, RACE_MESHES, RACE_SETS } race_set;

/* Ratios of scenes: their geometric means and the least. */
typedef struct race_means {
    bench_mean mean[RACE_FIGURES][RACE_SETS][RACE_CLOCKS];
    double least[RACE_FIGURES][RACE_SETS][RACE_CLOCKS];
} race_means;

/* A scene's ratio counts for all and for its own set. */
void race_means_add(race_means *m, race_figure figure, race_set set, bench_clock clock,
                    double ratio);

/* Into the summary: FIGURE[_SET][_of_processor], and least_… of each. */
void race_means_note(bench *b, const race_means *m);

#endif
