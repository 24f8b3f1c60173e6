/* SPDX-License-Identifier: Apache-2.0 */
#include "analysis/speckle.h"

#include "analysis/fft.h"
#include "analysis/noise.h"
#include "core/parallel.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

uint32_t mcv_speckle_subpixels(double pixel, double wavelength, double f_number) {
    return (uint32_t)fmax(1, ceil(4 * pixel / (wavelength * f_number) - 1e-9));
}

double mcv_speckle_spectral_patterns(double linewidth, double wavelength, double roughness) {
    const double width = linewidth / sqrt(8 * M_LN2) / wavelength, height = roughness / wavelength;
    return hypot(1, 8 * M_PI * width * height);
}

/* --- transforms --- */

/* A periodic grid of sub-pixels: the image and a margin around it, across which nothing comes. */
typedef struct grid {
    size_t size[2];
    double *values; /* [row][column][re, im] */
    double *roots[2];
    int axis; /* along which lines are transformed */
    bool failed;
} grid;

/* Where number i of line l of the axis stands. */
static double *at(const grid *g, size_t line, size_t i) {
    const size_t row = g->axis ? i : line, column = g->axis ? line : i;
    return g->values + 2 * (row * g->size[0] + column);
}

static void transform_lines(void *user, size_t block) {
    grid *g = user;
    enum { LINES = MCV_FFT_LINES };
    const size_t n = g->size[g->axis], lines = g->size[!g->axis], first = block * LINES;
    const size_t count = lines - first < LINES ? lines - first : LINES;
    double *values = malloc(4 * LINES * n * sizeof *values);
    if (!values) {
        g->failed = true;
        return;
    }
    memset(values, 0, 2 * LINES * n * sizeof *values);
    bool dark = true;
    for (size_t i = 0; i < n; ++i)
        for (size_t l = 0; l < count; ++l)
            for (size_t part = 0; part < 2; ++part) {
                const double value = at(g, first + l, i)[part];
                values[(2 * i + part) * LINES + l] = value;
                dark = dark && value == 0;
            }
    if (dark) { /* as is its transform: what the pupil stops is most of the grid */
        free(values);
        return;
    }
    const double *out = mcv_fft(values, values + 2 * LINES * n, n, g->roots[g->axis]);
    for (size_t i = 0; i < n; ++i)
        for (size_t l = 0; l < count; ++l)
            for (size_t part = 0; part < 2; ++part)
                at(g, first + l, i)[part] = out[(2 * i + part) * LINES + l];
    free(values);
}

static void transform(grid *g) {
    for (g->axis = 0; g->axis < 2; ++g->axis)
        mcv_in_parallel((g->size[!g->axis] + MCV_FFT_LINES - 1) / MCV_FFT_LINES, transform_lines,
                        g);
}

/* --- the pupil --- */

typedef struct speckle {
    const mcv_speckle *given;
    const float *laser;
    uint32_t q;
    uint16_t *counts;           /* of a surface's cells in each sub-pixel of the image, or NULL */
    size_t inner[2], before[2]; /* the image in sub-pixels, and the margin before it */
    grid grid;
    bool whole; /* the pupil is the full disc */
    mcv_aperture aperture;
    double *sums;    /* of w |U|², then less the mean, per sub-pixel of the grid */
    double *blurred; /* |h|²'s transform */
    double open;     /* the sum of P² */
    double weight;
    uint32_t pattern;
} speckle;

/* A frequency of the grid along an axis [1/m], with its sign. */
static double frequency(const speckle *s, int axis, size_t k) {
    const size_t n = s->grid.size[axis];
    return (2 * k < n ? (double)k : (double)k - (double)n) / ((double)n * s->given->pitch[axis]);
}

/* P: of a mask, which absorbs, the root of what its cells pass of the light. In the pupil's radii y
 * is up. Which of two opposite places a frequency belongs to makes no
 * difference to |U|². */
static double passes(const speckle *s, size_t column, size_t row) {
    const double radius = 2 * s->given->wavelength * s->given->f_number,
                 x = radius * frequency(s, 0, column), y = -radius * frequency(s, 1, row);
    if (fabs(x) > 1 || fabs(y) > 1 || hypot(x, y) > 1) return 0;
    if (s->whole) return 1;
    const double weight = (double)mcv_aperture_weight(&s->aperture, (float)x, (float)y);
    return s->given->aperture.shape == MCV_APERTURE_MASK ? sqrt(weight) : weight > 0;
}

static void set_pupil(speckle *s, bool whole) {
    s->whole = whole;
    s->open = 0;
    for (size_t row = 0; row < s->grid.size[1]; ++row)
        for (size_t column = 0; column < s->grid.size[0]; ++column)
            s->open += pow(passes(s, column, row), 2);
}

/* Where E of a grid point stands, or NULL in the margin. */
static const float *laser_at(const speckle *s, size_t column, size_t row) {
    if (column < s->before[0] || row < s->before[1]) return NULL;
    column -= s->before[0], row -= s->before[1];
    return column < s->inner[0] && row < s->inner[1] ? s->laser + row * s->inner[0] + column : NULL;
}

/* The numbers of the surface's cells that a row of pixels sees, added up; in rows of pixels. */
static void draw_surface_row(void *user, size_t row) {
    speckle *s = user;
    const size_t q = s->q;
    memset(s->counts + row * q * s->inner[0], 0, q * s->inner[0] * sizeof *s->counts);
    for (size_t j = 0; j < q; ++j)
        memset(s->grid.values + 2 * ((s->before[1] + row * q + j) * s->grid.size[0] + s->before[0]),
               0, 2 * s->inner[0] * sizeof(double));
    for (size_t column = 0; column < s->inner[0] / q; ++column) {
        const float *e = s->laser + row * q * s->inner[0] + column * q;
        float lit = 0;
        for (size_t j = 0; j < q; ++j)
            for (size_t i = 0; i < q; ++i) lit = fmaxf(lit, e[j * s->inner[0] + i]);
        if (!(lit > 0)) continue;
        const size_t at = (s->before[1] + row * q) * s->grid.size[0] + s->before[0] + column * q;
        const mcv_surface_sums sums = {.q = s->q,
                                       .values = s->grid.values + 2 * at,
                                       .stride = s->grid.size[0],
                                       .counts = s->counts + (e - s->laser),
                                       .count_stride = s->inner[0]};
        mcv_surface_noise_add(s->given->surface, s->given->seed, s->pattern, (uint32_t)column,
                              (uint32_t)row, &sums);
    }
}

/* What is done row by row. √E times the mean of the surface's cells, or a number of the film. */
static void draw_row(void *user, size_t row) {
    speckle *s = user;
    for (size_t column = 0; column < s->grid.size[0]; ++column) {
        const float *e = laser_at(s, column, row);
        double *value = s->grid.values + 2 * (row * s->grid.size[0] + column);
        const uint16_t count = e && s->counts ? s->counts[e - s->laser] : 0;
        if (!e || !(*e > 0)) {
            value[0] = value[1] = 0;
            continue;
        }
        const double scale = sqrt((double)*e / 2 / (count ? count : 1));
        mcv_noise noise = mcv_noise_begin(s->given->seed, s->pattern, (uint64_t)(e - s->laser));
        /* Apart from the noise of exposures and of the fixed pattern, 0 and 1, and surfaces, 3. */
        noise.key[1] = 2 + 4 * s->given->exposure;
        for (int part = 0; part < 2; ++part)
            value[part] = scale * (count ? value[part] : mcv_noise_normal(&noise));
    }
}

static void stop_row(void *user, size_t row) {
    speckle *s = user;
    for (size_t column = 0; column < s->grid.size[0]; ++column) {
        double *value = s->grid.values + 2 * (row * s->grid.size[0] + column);
        const double passed = passes(s, column, row);
        value[0] = passed > 0 ? passed * value[0] : 0;
        value[1] =
            passed > 0 ? -passed * value[1] : 0; /* conjugate: the next transform is the inverse */
    }
}

static void add_row(void *user, size_t row) {
    speckle *s = user;
    const size_t width = s->grid.size[0];
    const double scale = s->weight / ((double)width * (double)s->grid.size[1] * s->open);
    for (size_t i = row * width; i < (row + 1) * width; ++i) {
        const double *value = s->grid.values + 2 * i;
        s->sums[i] += scale * (value[0] * value[0] + value[1] * value[1]);
    }
}

static void put_pupil_row(void *user, size_t row) {
    speckle *s = user;
    for (size_t column = 0; column < s->grid.size[0]; ++column) {
        double *value = s->grid.values + 2 * (row * s->grid.size[0] + column);
        value[0] = passes(s, column, row);
        value[1] = 0;
    }
}

static void square_row(void *user, size_t row) {
    speckle *s = user;
    const double count = (double)s->grid.size[0] * (double)s->grid.size[1];
    for (size_t column = 0; column < s->grid.size[0]; ++column) {
        double *value = s->grid.values + 2 * (row * s->grid.size[0] + column);
        value[0] = (value[0] * value[0] + value[1] * value[1]) / (count * s->open);
        value[1] = 0;
    }
}

/* E, and after its transform that times |h|²'s, conjugate. */
static void put_laser_row(void *user, size_t row) {
    speckle *s = user;
    for (size_t column = 0; column < s->grid.size[0]; ++column) {
        double *value = s->grid.values + 2 * (row * s->grid.size[0] + column);
        const float *e = laser_at(s, column, row);
        value[0] = e ? (double)*e : 0;
        value[1] = 0;
    }
}

static void blur_row(void *user, size_t row) {
    speckle *s = user;
    for (size_t column = 0; column < s->grid.size[0]; ++column) {
        const size_t i = row * s->grid.size[0] + column;
        s->grid.values[2 * i] *= s->blurred[i];
        s->grid.values[2 * i + 1] *= -s->blurred[i];
    }
}

static void take_mean_row(void *user, size_t row) {
    speckle *s = user;
    const double count = (double)s->grid.size[0] * (double)s->grid.size[1];
    for (size_t column = 0; column < s->grid.size[0]; ++column) {
        const size_t i = row * s->grid.size[0] + column;
        s->sums[i] -= s->grid.values[2 * i] / count;
    }
}

static void each_row(speckle *s, void (*work)(void *, size_t)) {
    mcv_in_parallel(s->grid.size[1], work, s);
}

/* Takes E blurred by |h|² off the sums: |h|² is even, so its transform is real. */
static void take_mean(speckle *s) {
    if (s->given->disc_blurred) set_pupil(s, true);
    each_row(s, put_pupil_row);
    transform(&s->grid);
    each_row(s, square_row);
    transform(&s->grid);
    for (size_t i = 0; i < s->grid.size[0] * s->grid.size[1]; ++i)
        s->blurred[i] = s->grid.values[2 * i];
    each_row(s, put_laser_row);
    transform(&s->grid);
    each_row(s, blur_row);
    transform(&s->grid);
    each_row(s, take_mean_row);
}

/* --- patterns --- */

static void add_pattern(speckle *s, double weight) {
    s->weight = weight;
    if (s->counts) mcv_in_parallel(s->inner[1] / s->q, draw_surface_row, s);
    each_row(s, draw_row);
    transform(&s->grid);
    each_row(s, stop_row);
    transform(&s->grid);
    each_row(s, add_row);
    ++s->pattern;
}

/*
 * n weights for a contrast of 1/√M, n - 1 < M <= n: n - 1 of them are a and one is 1 - (n - 1) a,
 * and their squares add up to 1/M.
 */
static void add_patterns(speckle *s) {
    const double m = ceil(s->given->patterns) - 1, p = s->given->polarization;
    const double root = m * m - (m + m * m) * (1 - 1 / s->given->patterns);
    const double a = m > 0 ? (m + sqrt(fmax(root, 0))) / (m + m * m) : 0;
    for (int k = 0; k <= (int)m; ++k) {
        const double weight = k < (int)m ? a : 1 - m * a;
        add_pattern(s, weight * (1 + p) / 2);
        if (p < 1) add_pattern(s, weight * (1 - p) / 2);
    }
}

/*
 * The mean over a sub-pixel of what is sampled in its middle, for frequencies that the grid holds:
 * 1 + δ²/24 - 17 δ⁴/5760, δ² the second difference. Summed over a pixel's q sub-pixels along an
 * axis, this is the weight of sub-pixel i, from -2 on.
 */
static double cell_weight(int i, int q) {
    static const double stencil[] = {-17.0 / 5760, 1.0 / 24 + 68.0 / 5760,
                                     1 - 1.0 / 12 - 102.0 / 5760, 1.0 / 24 + 68.0 / 5760,
                                     -17.0 / 5760};
    double sum = 0;
    for (int k = -2; k <= 2; ++k)
        if (i + k >= 0 && i + k < q) sum += stencil[k + 2];
    return sum / q;
}

static void add_to_pixels(const speckle *s, uint32_t q, uint32_t width, uint32_t height,
                          float *light) {
    for (uint32_t row = 0; row < height; ++row)
        for (uint32_t column = 0; column < width; ++column) {
            double sum = 0;
            for (int j = -2; j < (int)q + 2; ++j)
                for (int i = -2; i < (int)q + 2; ++i) {
                    const size_t y = s->before[1] + (size_t)row * q + (size_t)j,
                                 x = s->before[0] + (size_t)column * q + (size_t)i;
                    sum += cell_weight(i, (int)q) * cell_weight(j, (int)q) *
                           s->sums[y * s->grid.size[0] + x];
                }
            light[(size_t)row * width + column] += (float)sum;
        }
}

static bool open_grid(speckle *s) {
    enum { MARGIN = 16 }; /* in λN; beyond 8 of them the disc's |h|² holds 1 % */
    const double grain = s->given->wavelength * s->given->f_number *
                         mcv_aperture_border(&s->given->aperture); /* |h|² falls by the border */
    for (int i = 0; i < 2; ++i) {
        const size_t margin = (size_t)ceil(MARGIN * grain / s->given->pitch[i]);
        s->before[i] = margin / 2 + 2;
        s->grid.size[i] = mcv_fft_length(s->inner[i] + margin + 4);
        s->grid.roots[i] = mcv_fft_roots(s->grid.size[i]);
    }
    const size_t count = s->grid.size[0] * s->grid.size[1];
    s->grid.values = malloc(2 * count * sizeof(double));
    s->sums = calloc(count, sizeof(double));
    s->blurred = malloc(count * sizeof(double));
    if (s->given->surface) s->counts = malloc(s->inner[0] * s->inner[1] * sizeof *s->counts);
    if (!s->grid.values || !s->sums || !s->blurred || !s->grid.roots[0] || !s->grid.roots[1] ||
        (s->given->surface && !s->counts))
        return false;
    mcv_aperture_prepare(&s->given->aperture, false, &s->aperture);
    set_pupil(s, s->given->aperture.shape == MCV_APERTURE_DISC);
    return true;
}

mcv_result mcv_speckle_add(const mcv_speckle *given, const float *laser, uint32_t q, uint32_t width,
                           uint32_t height, float *light, mcv_error *error) {
    speckle s = {
        .given = given, .laser = laser, .q = q, .inner = {(size_t)width * q, (size_t)height * q}};
    bool done = open_grid(&s);
    if (done) {
        add_patterns(&s);
        take_mean(&s);
        done = !s.grid.failed;
    }
    if (done) add_to_pixels(&s, q, width, height, light);
    free(s.grid.values);
    free(s.sums);
    free(s.blurred);
    free(s.counts);
    for (int i = 0; i < 2; ++i) free(s.grid.roots[i]);
    if (done) return MCV_OK;
    return mcv_fail(error, MCV_FAILED,
                    "speckle needs %.3g GB of memory, more than is free: render the laser's light "
                    "of a smaller image",
                    32e-9 * (double)s.grid.size[0] * (double)s.grid.size[1]);
}
