/* SPDX-License-Identifier: Apache-2.0 */
/* How speckle moves the centre of gravity of a line of laser light. */
#include "triangulation/laser_line.h"

#include "mcvisi/sensors/aperture.h"

#include <math.h>
#include <stdlib.h>

/* Midpoints of `count` steps over `reach`. */
typedef struct steps {
    int count;
    double reach;
} steps;

static double step_at(steps s, int i) { return (i + 0.5) / s.count * s.reach; }

/* The middle of cell k of n, from -1 to 1 of the disc's radius. */
static double cell_at(int k, int n) { return (2.0 * k + 1) / n - 1; }

/* What is open of cells across and along the line. Returns the sum. */
static double read_open(mcv_line_stop stop, int n, float *open) {
    mcv_aperture aperture;
    double sum = 0;
    mcv_aperture_prepare(stop.aperture, false, &aperture);
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j) {
            const double across = cell_at(i, n), along = cell_at(j, n);
            float *cell = open + i * n + j;
            if (hypot(across, along) <= 1)
                *cell = mcv_aperture_weight(&aperture, (float)(stop.rows ? across : along),
                                            (float)(stop.rows ? along : across));
            sum += (double)*cell;
        }
    return sum;
}

/* The transform of the cells along the line, of n of them across it: real and imaginary parts. */
static void transform_along(const float *open, int n, steps along, double *sums) {
    for (int i = 0; i < n * n; ++i)
        for (int j = 0; open[i] > 0 && j < along.count; ++j) {
            const double phase = M_PI * step_at(along, j) * cell_at(i % n, n);
            double *sum = sums + 2 * ((i - i % n) / n * along.count + j);
            sum[0] += (double)open[i] * cos(phase);
            sum[1] += (double)open[i] * sin(phase);
        }
}

/* |µ|² of all light at a step across, the mean of both of its signs; `sums` are those along. */
static double transform_across(const double *sums, int n, int stride, double across, double all) {
    double re[2] = {0, 0}, im[2] = {0, 0};
    for (int k = 0; k < n; ++k) {
        const double phase = M_PI * across * cell_at(k, n), *sum = sums + 2 * k * stride;
        re[0] += sum[0] * cos(phase);
        re[1] += sum[1] * sin(phase);
        im[0] += sum[1] * cos(phase);
        im[1] += sum[0] * sin(phase);
    }
    return (re[0] * re[0] + re[1] * re[1] + im[0] * im[0] + im[1] * im[1]) / (all * all);
}

/* |µ|² at steps across and along. */
static bool take_stop(mcv_line_stop stop, steps across, steps along, double *squares) {
    /* The transform of n cells repeats every n λN. */
    const int n = (int)fmax(128, 2 * ceil(fmax(across.reach, along.reach)));
    float *open = calloc((size_t)n * (size_t)n, sizeof *open);
    double *sums = calloc(2 * (size_t)n * (size_t)along.count, sizeof *sums);
    const bool known = open && sums;
    if (known) {
        const double all = read_open(stop, n, open);
        transform_along(open, n, along, sums);
        for (int i = 0; i < across.count; ++i)
            for (int j = 0; j < along.count; ++j)
                squares[i * along.count + j] =
                    transform_across(sums + 2 * j, n, along.count, step_at(across, i), all);
    }
    free(open);
    free(sums);
    return known;
}

static bool take_disc(steps across, steps along, double *squares) {
    for (int i = 0; i < across.count; ++i)
        for (int j = 0; j < along.count; ++j) {
            const double r = M_PI * hypot(step_at(across, i), step_at(along, j)),
                         field = 2 * j1(r) / r;
            squares[i * along.count + j] = field * field;
        }
    return true;
}

double mcv_line_speckle_noise(double contrast, double grain, double sigma, double height,
                              mcv_line_stop stop) {
    /* In λN; x - x' = u and the middle of both are independent: ∫ x x' E E' = (s²/2 - u²/4) ·
     * exp(-u²/(4 s²))/(2 s √π). Beyond 6 s the factor is 1e-4 of its largest, and |µ|² below 1e-3
     * of 1. |µ|² has no period below 1: two steps for each tell all of it. It falls as the distance
     * squared across a stop's straight edges, and faster elsewhere: what lies beyond the farthest
     * is at most a thousandth of it. */
    enum { LEAST_STEPS = 400, LEAST_OF_STOPS = 64, FARTHEST = 1024, FARTHEST_OF_STOPS = 128 };
    const int least = stop.aperture ? LEAST_OF_STOPS : LEAST_STEPS,
              farthest = stop.aperture ? FARTHEST_OF_STOPS : FARTHEST;
    const double s = sigma / grain, h = height / grain, wide = fmin(6 * s, farthest),
                 high = fmin(h, farthest);
    const steps across = {(int)fmax(least, ceil(4 * wide)), wide},
                along = {(int)fmax(least, ceil(4 * high)), high};
    double sum = 0, *squares = malloc(sizeof *squares * (size_t)across.count * along.count);
    const bool known = squares && (stop.aperture ? take_stop(stop, across, along, squares)
                                                 : take_disc(across, along, squares));
    for (int i = 0; known && i < across.count; ++i)
        for (int j = 0; j < along.count; ++j) {
            const double u = step_at(across, i), v = step_at(along, j);
            sum += (s * s / 2 - u * u / 4) * exp(-u * u / (4 * s * s)) * (1 - v / h) *
                   squares[i * along.count + j];
        }
    free(squares);
    const double area = wide / across.count * high / along.count;
    /* Four quadrants; pairs of a row: 2 ∫ (1 - v/h)/h. */
    return known ? contrast * grain * sqrt(fmax(4 * sum * area / (2 * s * sqrt(M_PI) * h), 0))
                 : NAN;
}
