/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What the benchmarks share. A benchmark checks a result first and times it then; the sides that it
 * compares take turns, one repetition each, so that what else the machine does meets all of them.
 * Figures are medians; the spread is half the distance of the quartiles over the median. A ratio is
 * above 1 where ours is better; that of a timing is the median over the repetitions of the peer's
 * seconds over ours.
 */
#ifndef MCVISI_BENCH_HARNESS_H
#define MCVISI_BENCH_HARNESS_H

#include <jansson.h>
#include <sys/types.h>

#include "cl/cl.h"

enum { BENCH_REPETITIONS = 7, BENCH_QUICK_REPETITIONS = 5 };

/*
 * Seconds of the wall, or of the processor in all threads together: on one core other programs do
 * not count, on several what waits does not either.
 */
typedef enum bench_clock { BENCH_WALL, BENCH_CPU } bench_clock;

typedef struct bench {
    bool quick;       /* --quick: smaller cases, for development */
    const char *only; /* --only TEXT: only scenes of such a name; NULL: all */
    unsigned seed;    /* --seed N: the variant of generated scenes */
    int repetitions;
    mcv_cl cl; /* the first device, all of its cores */
    json_t *rows, *summary;
    char stem[1024]; /* of the output: other files stand beside it */
} bench;

typedef struct bench_seconds {
    double by[2]; /* bench_clock */
} bench_seconds;

/* One of those that are compared. */
typedef struct bench_side {
    mcv_result (*run)(void *user, mcv_error *error);
    void *user;
    bench_seconds seconds[BENCH_REPETITIONS]; /* of each repetition */
    pid_t process; /* the one that works, whose time BENCH_CPU is; 0: this one */
} bench_side;

/*
 * main of a benchmark: PROGRAM [--quick] [--only TEXT] [--seed N] [OUTPUT.json], by default beside
 * the program. Opens the device, runs, and writes rows, summary, device, driver, compiler, commit,
 * cores and the load that the machine had at the beginning; also where the run failed, of what it
 * had until then.
 */
int bench_main(int argc, char **argv, const char *name,
               mcv_result (*run)(bench *b, mcv_error *error));

bench_seconds bench_now(void);
bench_seconds bench_since(bench_seconds start);

/* Runs each side once untimed, then b->repetitions times in turns. */
mcv_result bench_time(const bench *b, bench_side *sides, size_t count, mcv_error *error);

double bench_median(const double *values, int count);
double bench_spread(const double *values, int count);
double bench_side_median(const bench *b, const bench_side *side, bench_clock clock);

/* A line above the rows. */
void bench_title(const char *text);

/*
 * A row of two timings, or of one where the peer is NULL: work per second in millions, or seconds
 * where work is 0. Returns the ratio (NaN without a peer). The case is printf style.
 */
double bench_row(bench *b, bench_clock clock, const bench_side *ours, const bench_side *peer,
                 double work, const char *unit, const char *format, ...)
    __attribute__((format(printf, 7, 8)));

/* A row of numbers of which the smaller is the better; the peer may be NaN. Returns the ratio. */
double bench_number(bench *b, double ours, double peer, const char *unit, const char *format, ...)
    __attribute__((format(printf, 5, 6)));

/* More of the last row. */
void bench_more(bench *b, const char *key, double value);

/* An own key of the summary, printed too. */
void bench_summary(bench *b, const char *key, double value);
void bench_summary_text(bench *b, const char *key, const char *text);

/* A geometric mean under way. */
typedef struct bench_mean {
    double log_sum;
    int count;
} bench_mean;
void bench_mean_add(bench_mean *mean, double value);
double bench_mean_value(const bench_mean *mean);

/* The device's first cores only, as a device of its own: what OpenCL calls a sub-device. */
mcv_result bench_cores(const mcv_cl *all, cl_uint count, mcv_cl *cl, mcv_error *error);

#endif
