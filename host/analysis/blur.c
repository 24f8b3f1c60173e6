/* SPDX-License-Identifier: Apache-2.0 */
#include "analysis/blur.h"

#include "analysis/fft.h"
#include "core/parallel.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/*
 * A periodic grid around the image. Light is its real part, the light's variance its imaginary
 * part, so that both are transformed at once: a number of the spectrum and the conjugate of that at
 * the negative frequency tell their spectra apart.
 */
typedef struct grid {
    size_t size[2];
    double *values; /* [row][column][re, im] */
    double *roots[2];
    /* At the frequencies 0 … size/2 in both directions, real: no phase is turned. */
    double *response, *squared; /* that of light, and that whose kernel is the square: what becomes
                                   of variances */
    const mcv_image *image;
    float *light, *light_error; /* of one channel; the latter may be NULL */
    const mcv_lens_mtf *mtf;
    double pitch[2];
    bool failed; /* no memory */
} grid;

/* Frequencies of one direction that are different but for the sign. */
static size_t half_of(size_t n) { return n / 2 + 1; }

static void grid_free(grid *g) {
    free(g->values);
    free(g->response);
    free(g->squared);
    for (int i = 0; i < 2; ++i) free(g->roots[i]);
}

static bool grid_new(grid *g, const mcv_image *image) {
    enum { MARGIN = 64 }; /* on each side: what wraps round comes from at least so far */
    const size_t sides[] = {image->width, image->height};
    for (int i = 0; i < 2; ++i) {
        g->size[i] = mcv_fft_length(sides[i] + 2 * (size_t)MARGIN);
        g->roots[i] = mcv_fft_roots(g->size[i]);
    }
    const size_t responses = half_of(g->size[0]) * half_of(g->size[1]);
    g->image = image;
    g->values = malloc(2 * g->size[0] * g->size[1] * sizeof *g->values);
    g->response = malloc(responses * sizeof *g->response);
    g->squared = malloc(responses * sizeof *g->squared);
    return g->values && g->response && g->squared && g->roots[0] && g->roots[1];
}

/* The index of the pixel that a place of the grid continues: half of what is beyond the image lies
 * before its first pixel. */
static size_t nearest(size_t place, size_t side, size_t length) {
    if (place < side) return place;
    return place - side < (length - side) / 2 ? side - 1 : 0;
}

static void set_response_row(void *user, size_t y) {
    const grid *g = user;
    const size_t width = half_of(g->size[0]);
    const double down = (double)y / (double)g->size[1] / g->pitch[1];
    for (size_t x = 0; x < width; ++x)
        g->response[y * width + x] =
            mcv_lens_modulation(g->mtf, hypot((double)x / (double)g->size[0] / g->pitch[0], down));
}

/* How often a frequency 0 … n/2 stands among the n. */
static double weight(size_t k, size_t n) { return k == 0 || 2 * k == n ? 1 : 2; }

/* --- what becomes of errors --- */

/* [k][d]: cos(2π kd/n). */
static void fill_cosines(double *table, size_t rows, size_t columns, const double *roots,
                         size_t n) {
    for (size_t k = 0; k < rows; ++k)
        for (size_t d = 0; d < columns; ++d) table[k * columns + d] = roots[2 * (k * d % n)];
}

/* to[j][i] = sum over y and x of from[y][x] across[x][i] down[y][j]; `half` has room for [y][i].
 * All sizes are width, height. */
static void transform_even(const double *from, const size_t size[2], const double *across,
                           const double *down, double *half, double *to, const size_t to_size[2]) {
    memset(half, 0, size[1] * to_size[0] * sizeof *half);
    memset(to, 0, to_size[1] * to_size[0] * sizeof *to);
    for (size_t y = 0; y < size[1]; ++y)
        for (size_t x = 0; x < size[0]; ++x)
            for (size_t i = 0; i < to_size[0]; ++i)
                half[y * to_size[0] + i] += from[y * size[0] + x] * across[x * to_size[0] + i];
    for (size_t y = 0; y < size[1]; ++y)
        for (size_t j = 0; j < to_size[1]; ++j)
            for (size_t i = 0; i < to_size[0]; ++i)
                to[j * to_size[0] + i] += half[y * to_size[0] + i] * down[y * to_size[1] + j];
}

/*
 * The kernel within REACH pixels, beyond which its square is nothing, squared, and the response
 * that this has. The transform of what is even in both directions is a sum of cosines.
 */
static bool square_response(grid *g) {
    enum { REACH = 64 };
    const size_t half[2] = {half_of(g->size[0]), half_of(g->size[1])};
    const size_t near[2] = {half[0] < REACH ? half[0] : REACH, half[1] < REACH ? half[1] : REACH};
    const double count = (double)g->size[0] * (double)g->size[1];
    double *all =
        malloc((half[0] * half[1] + REACH * (REACH + 2 * half[0] + 2 * half[1])) * sizeof *all);
    if (!all) return false;
    double *even = all, *kernel = even + half[0] * half[1], *rows = kernel + REACH * REACH;
    double *across = rows + REACH * (half[0] + half[1]), *down = across + REACH * half[0];
    for (size_t y = 0; y < half[1]; ++y)
        for (size_t x = 0; x < half[0]; ++x)
            even[y * half[0] + x] = g->response[y * half[0] + x] * weight(x, g->size[0]) *
                                    weight(y, g->size[1]) / count;
    fill_cosines(across, half[0], near[0], g->roots[0], g->size[0]);
    fill_cosines(down, half[1], near[1], g->roots[1], g->size[1]);
    transform_even(even, half, across, down, rows, kernel, near);
    for (size_t y = 0; y < near[1]; ++y)
        for (size_t x = 0; x < near[0]; ++x)
            kernel[y * near[0] + x] *=
                kernel[y * near[0] + x] * weight(x, g->size[0]) * weight(y, g->size[1]);
    fill_cosines(across, near[0], half[0], g->roots[0], g->size[0]);
    fill_cosines(down, near[1], half[1], g->roots[1], g->size[1]);
    transform_even(kernel, near, across, down, rows, g->squared, half);
    free(all);
    return true;
}

/*
 * The correlation's spectrum is the square of the response over its mean: at frequency 0 the
 * response is 1. The stencil of second differences in both directions, whose sum of squares is 36,
 * has the spectrum (2 - 2 cos)² of each.
 */
static void add_correlation(const grid *g, double share, mcv_correlation *to) {
    const size_t w = half_of(g->size[0]), h = half_of(g->size[1]);
    const double count = (double)g->size[0] * (double)g->size[1];
    double second = 0, fourth = 0, stencil = 0, shares = 0;
    for (size_t y = 0; y < h; ++y) {
        const double down = 2 - 2 * g->roots[1][2 * y];
        for (size_t x = 0; x < w; ++x) {
            const double h2 = pow(g->response[y * w + x], 2),
                         times = weight(x, g->size[0]) * weight(y, g->size[1]);
            second += times * h2;
            fourth += times * h2 * h2;
            stencil += times * h2 * pow(down * (2 - 2 * g->roots[0][2 * x]), 2);
            shares += times * pow(g->squared[y * w + x] / g->squared[0], 2);
        }
    }
    to->sum += share * count / second;
    to->squares += share * fourth * count / (second * second);
    to->stencil += share * stencil / (36 * second);
    to->shares += share * shares / count;
}

/* --- transforms --- */

enum { LINES = MCV_FFT_LINES };

/* Two blocks of lines, and room for their transforms. */
static double *lines_new(grid *g, size_t n) {
    double *lines = malloc(8 * LINES * n * sizeof *lines);
    if (!lines) g->failed = true;
    return lines;
}

static void put_row(const grid *g, size_t y, double *line, size_t l) {
    const size_t width = g->image->width, from = nearest(y, g->image->height, g->size[1]) * width;
    for (size_t x = 0; x < g->size[0]; ++x) {
        const size_t i = from + nearest(x, width, g->size[0]);
        const double error = g->light_error ? (double)g->light_error[i] : 0;
        line[2 * x * LINES + l] = g->light[i];
        line[(2 * x + 1) * LINES + l] = error * error;
    }
}

/* Rows of the grid from those of the image. */
static void transform_rows(void *user, size_t block) {
    grid *g = user;
    const size_t width = g->size[0];
    double *lines = lines_new(g, width);
    if (!lines) return;
    for (size_t l = 0; l < LINES; ++l)
        put_row(g, block * LINES + l < g->size[1] ? block * LINES + l : g->size[1] - 1, lines, l);
    const double *out = mcv_fft(lines, lines + 2 * LINES * width, width, g->roots[0]);
    for (size_t l = 0; l < LINES && block * LINES + l < g->size[1]; ++l)
        for (size_t i = 0; i < 2 * width; ++i)
            g->values[2 * width * (block * LINES + l) + i] = out[i * LINES + l];
    free(lines);
}

/* What a number of the spectrum, z, and the one at the negative frequency become: see `grid`.
 * Conjugates, for what inverts. */
static void pass(double response, double squared, double *z, double *other) {
    const double even = 0.5 * (response + squared), odd = 0.5 * (response - squared);
    const double re = z[0], im = z[LINES], other_re = other[0], other_im = other[LINES];
    z[0] = even * re + odd * other_re;
    z[LINES] = -(even * im - odd * other_im);
    other[0] = even * other_re + odd * re;
    other[LINES] = -(even * other_im - odd * im);
}

static void get_column(const grid *g, size_t x, double *lines, size_t l) {
    for (size_t y = 0; y < g->size[1]; ++y) {
        lines[2 * y * LINES + l] = g->values[2 * (y * g->size[0] + x)];
        lines[(2 * y + 1) * LINES + l] = g->values[2 * (y * g->size[0] + x) + 1];
    }
}

static void set_column(grid *g, size_t x, const double *lines, size_t l) {
    for (size_t y = 0; y < g->size[1]; ++y) {
        g->values[2 * (y * g->size[0] + x)] = lines[2 * y * LINES + l];
        g->values[2 * (y * g->size[0] + x) + 1] = lines[(2 * y + 1) * LINES + l];
    }
}

/*
 * Columns of some frequencies and those of the negative ones: transformed, filtered and transformed
 * back. An inverse transform is the conjugate of the transform of the conjugate, over n; the second
 * conjugate is left to be taken.
 */
static void filter_columns(void *user, size_t block) {
    grid *g = user;
    const size_t width = g->size[0], height = g->size[1], half = half_of(width);
    double *lines = lines_new(g, height);
    if (!lines) return;
    double *own = lines, *mirrored = lines + 4 * LINES * height;
    for (size_t l = 0; l < LINES; ++l) {
        const size_t x = block * LINES + l < half ? block * LINES + l : half - 1;
        get_column(g, x, own, l);
        get_column(g, (width - x) % width, mirrored, l);
    }
    double *a = mcv_fft(own, own + 2 * LINES * height, height, g->roots[1]);
    double *b = mcv_fft(mirrored, mirrored + 2 * LINES * height, height, g->roots[1]);
    for (size_t y = 0; y < height; ++y)
        for (size_t l = 0; l < LINES; ++l) {
            const size_t x = block * LINES + l < half ? block * LINES + l : half - 1;
            const size_t at = (2 * y < height ? y : height - y) * half + x;
            pass(g->response[at], g->squared[at], a + 2 * y * LINES + l,
                 b + 2 * ((height - y) % height) * LINES + l);
        }
    own = mcv_fft(a, a == own ? own + 2 * LINES * height : own, height, g->roots[1]);
    mirrored =
        mcv_fft(b, b == mirrored ? mirrored + 2 * LINES * height : mirrored, height, g->roots[1]);
    for (size_t l = 0; l < LINES && block * LINES + l < half; ++l) {
        const size_t x = block * LINES + l;
        set_column(g, x, own, l);
        set_column(g, (width - x) % width, mirrored, l);
    }
    free(lines);
}

/* The image's rows, back from the spectrum of each, of which filter_columns left the conjugate. */
static void extract_rows(void *user, size_t block) {
    grid *g = user;
    const size_t width = g->size[0];
    const double scale = 1 / ((double)width * (double)g->size[1]);
    double *lines = lines_new(g, width);
    if (!lines) return;
    for (size_t l = 0; l < LINES; ++l) {
        const size_t y =
            block * LINES + l < g->image->height ? block * LINES + l : g->image->height - 1;
        for (size_t i = 0; i < 2 * width; ++i) lines[i * LINES + l] = g->values[2 * width * y + i];
    }
    const double *out = mcv_fft(lines, lines + 2 * LINES * width, width, g->roots[0]);
    for (size_t l = 0; l < LINES && block * LINES + l < g->image->height; ++l)
        for (size_t x = 0; x < g->image->width; ++x) {
            const size_t i = (block * LINES + l) * g->image->width + x;
            g->light[i] = (float)fmax(0, out[2 * x * LINES + l] * scale);
            if (g->light_error)
                g->light_error[i] = (float)sqrt(fmax(0, -out[(2 * x + 1) * LINES + l] * scale));
        }
    free(lines);
}

static size_t blocks_of(size_t lines) { return (lines + LINES - 1) / LINES; }

static void blur_channel(grid *g) {
    mcv_in_parallel(blocks_of(g->size[1]), transform_rows, g);
    mcv_in_parallel(blocks_of(half_of(g->size[0])), filter_columns, g);
    mcv_in_parallel(blocks_of(g->image->height), extract_rows, g);
}

static mcv_result blur_channels(grid *g, mcv_image *light, mcv_image *light_error,
                                const mcv_lens_mtf mtf[3], mcv_correlation *correlation) {
    for (uint32_t channel = 0; channel < light->channels; ++channel) {
        const size_t first = (size_t)channel * light->width * light->height;
        const mcv_lens_mtf *before = g->mtf;
        g->mtf = mtf + (channel < 3 ? channel : 2);
        g->light = light->pixels + first;
        g->light_error = light_error ? light_error->pixels + first : NULL;
        if (!before || before->wavelength != g->mtf->wavelength ||
            before->f_number != g->mtf->f_number || before->rows != g->mtf->rows) {
            mcv_in_parallel(half_of(g->size[1]), set_response_row, g);
            if (light_error && !square_response(g)) return MCV_FAILED;
            if (!light_error)
                memcpy(g->squared, g->response,
                       half_of(g->size[0]) * half_of(g->size[1]) * sizeof *g->squared);
        }
        if (correlation && light_error) add_correlation(g, 1.0 / light->channels, correlation);
        blur_channel(g);
    }
    return g->failed ? MCV_FAILED : MCV_OK;
}

mcv_result mcv_blur(mcv_image *light, mcv_image *light_error, const mcv_lens_mtf mtf[3],
                    const double pitch[2], mcv_correlation *correlation, mcv_error *error) {
    grid g = {.pitch = {pitch[0], pitch[1]}};
    if (correlation) *correlation = (mcv_correlation){0};
    mcv_result result =
        grid_new(&g, light) ? blur_channels(&g, light, light_error, mtf, correlation) : MCV_FAILED;
    grid_free(&g);
    if (result == MCV_OK) return MCV_OK;
    return mcv_fail(
        error, result,
        "the lens MTF needs %.3g GB of memory, more than is free: leave it out by --lens-mtf "
        "none",
        24e-9 * (double)g.size[0] * (double)g.size[1]);
}
