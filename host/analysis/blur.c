/* SPDX-License-Identifier: Apache-2.0 */
#include "analysis/blur.h"
#include "analysis/fft.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* --- modulation ------------------------------------------------------------------------------------------------- */

double mcv_lens_modulation(const mcv_lens_mtf *mtf, double frequency) {
    if (mtf->row_count == 0) {
        const double s = frequency * mtf->wavelength * mtf->f_number;
        return s < 1 ? 2 / M_PI * (acos(s) - s * sqrt(1 - s * s)) : 0;
    }
    size_t i = 1;
    while (i < mtf->row_count && mtf->rows[i].frequency < frequency) ++i;
    if (i == mtf->row_count) return mtf->rows[i - 1].modulation;
    const mcv_mtf_row a = mtf->rows[i - 1], b = mtf->rows[i];
    return a.modulation + (b.modulation - a.modulation) * (frequency - a.frequency) / (b.frequency - a.frequency);
}

static mcv_result check_row(const char *path, unsigned line, const mcv_mtf_row *rows, size_t count, mcv_error *error) {
    const mcv_mtf_row *row = rows + count;
    if (!(row->modulation >= 0 && row->modulation <= 1))
        return mcv_fail(error, MCV_BAD_INPUT, "%s: line %u: a modulation of %g: must be from 0 to 1", path, line, row->modulation);
    if (count == 0 && !(row->frequency == 0 && row->modulation == 1))
        return mcv_fail(error, MCV_BAD_INPUT, "%s: line %u: the first row must be 0, 1: full modulation at frequency 0", path, line);
    if (count > 0 && !(row->frequency > row[-1].frequency && isfinite(row->frequency)))
        return mcv_fail(error, MCV_BAD_INPUT, "%s: line %u: frequencies must ascend, but %g follows %g", path, line, row->frequency * 1e-3,
                        row[-1].frequency * 1e-3);
    return MCV_OK;
}

mcv_result mcv_mtf_read(const char *path, mcv_mtf_row **rows, size_t *count, mcv_error *error) {
    enum { MAX_ROWS = 10000 };
    char text[256];
    mcv_result result = MCV_OK;
    FILE *file = fopen(path, "r");
    *count = 0;
    *rows = NULL;
    if (!file) return mcv_fail(error, MCV_BAD_INPUT, "%s: cannot be read: %s", path, strerror(errno));
    *rows = malloc(MAX_ROWS * sizeof **rows);
    if (!*rows) {
        fclose(file);
        return mcv_fail(error, MCV_FAILED, "%s: no memory for it", path);
    }
    for (unsigned line = 1; result == MCV_OK && *count < MAX_ROWS && fgets(text, sizeof text, file); ++line) {
        mcv_mtf_row *row = *rows + *count;
        if (text[strspn(text, " \t\r\n")] == '\0' || text[0] == '#') continue;
        char *end, *start = text;
        row->frequency = 1e3 * strtod(start, &end);
        start = end + strspn(end, " \t,;");
        const bool first = end != text;
        row->modulation = strtod(start, &end);
        if (!first || end == start || end[strspn(end, " \t\r\n")] != '\0')
            result = mcv_fail(error, MCV_BAD_INPUT, "%s: line %u must be `cycles per mm, modulation`, as in 40, 0.62", path, line);
        else
            result = check_row(path, line, *rows, *count, error);
        ++*count;
    }
    if (result == MCV_OK && *count == MAX_ROWS)
        result = mcv_fail(error, MCV_BAD_INPUT, "%s: has %d rows or more: thin it out", path, MAX_ROWS);
    if (result == MCV_OK && *count < 2)
        result = mcv_fail(error, MCV_BAD_INPUT, "%s: %zu rows make no MTF: at least 2 are needed", path, *count);
    fclose(file);
    if (result == MCV_OK) return MCV_OK;
    free(*rows);
    *rows = NULL;
    return result;
}

/* --- filter ----------------------------------------------------------------------------------------------------- */

/* A periodic grid around the image, and what transforms it. */
typedef struct grid {
    size_t size[2];
    mcv_complex *values; /* [row][column] */
    mcv_complex *line[2];
    mcv_complex *roots[2];
    double *response; /* at the frequencies of values, real: no phase is turned */
} grid;

static void grid_free(grid *g) {
    free(g->values);
    free(g->response);
    for (int i = 0; i < 2; ++i) {
        free(g->line[i]);
        free(g->roots[i]);
    }
}

static bool grid_new(grid *g, const mcv_image *image) {
    enum { MARGIN = 64 }; /* on each side: what wraps round comes from at least so far */
    const size_t sides[] = {image->width, image->height};
    for (int i = 0; i < 2; ++i) g->size[i] = mcv_fft_length(sides[i] + 2 * (size_t)MARGIN);
    const size_t longest = g->size[0] > g->size[1] ? g->size[0] : g->size[1];
    for (int i = 0; i < 2; ++i) {
        g->roots[i] = mcv_fft_roots(g->size[i]);
        g->line[i] = malloc(longest * sizeof *g->line[i]);
    }
    g->values = malloc(g->size[0] * g->size[1] * sizeof *g->values);
    g->response = malloc(g->size[0] * g->size[1] * sizeof *g->response);
    return g->values && g->response && g->line[0] && g->line[1] && g->roots[0] && g->roots[1];
}

/* The index of the pixel that a place of the grid continues: half of what is beyond the image lies before its first pixel. */
static size_t nearest(size_t place, size_t side, size_t length) {
    if (place < side) return place;
    return place - side < (length - side) / 2 ? side - 1 : 0;
}

static void fill(grid *g, const mcv_image *image, const float *plane, bool squared) {
    for (size_t y = 0; y < g->size[1]; ++y) {
        const float *row = plane + nearest(y, image->height, g->size[1]) * image->width;
        for (size_t x = 0; x < g->size[0]; ++x) {
            const double value = row[nearest(x, image->width, g->size[0])];
            g->values[y * g->size[0] + x] = (mcv_complex){squared ? value * value : value, 0};
        }
    }
}

/* Cycles per pixel of the k-th coefficient. */
static double frequency(size_t k, size_t n) { return (double)(2 * k <= n ? (ptrdiff_t)k : (ptrdiff_t)k - (ptrdiff_t)n) / (double)n; }

static void set_response(grid *g, const mcv_lens_mtf *mtf, const double pitch[2]) {
    for (size_t y = 0; y < g->size[1]; ++y)
        for (size_t x = 0; x < g->size[0]; ++x)
            g->response[y * g->size[0] + x] =
                mcv_lens_modulation(mtf, hypot(frequency(x, g->size[0]) / pitch[0], frequency(y, g->size[1]) / pitch[1]));
}

static void transform_rows(grid *g) {
    for (size_t y = 0; y < g->size[1]; ++y) {
        mcv_complex *row = g->values + y * g->size[0];
        memcpy(g->line[0], row, g->size[0] * sizeof *row);
        mcv_fft(g->line[0], row, g->size[0], g->roots[0]);
    }
}

/* An inverse transform is the conjugate of the transform of the conjugate, over n; where all is real but for rounding, without the first.
 */
static void conjugate(mcv_complex *line, size_t n, double scale) {
    for (size_t i = 0; i < n; ++i) line[i] = (mcv_complex){line[i].re * scale, -line[i].im * scale};
}

/* values become their convolution with the kernel of this response. */
static void filter(grid *g) {
    const size_t width = g->size[0], height = g->size[1];
    transform_rows(g);
    for (size_t x = 0; x < width; ++x) {
        for (size_t y = 0; y < height; ++y) g->line[0][y] = g->values[y * width + x];
        mcv_fft(g->line[0], g->line[1], height, g->roots[1]);
        for (size_t y = 0; y < height; ++y) {
            g->line[1][y].re *= g->response[y * width + x];
            g->line[1][y].im *= g->response[y * width + x];
        }
        conjugate(g->line[1], height, 1 / (double)height);
        mcv_fft(g->line[1], g->line[0], height, g->roots[1]);
        conjugate(g->line[0], height, 1);
        for (size_t y = 0; y < height; ++y) g->values[y * width + x] = g->line[0][y];
    }
    for (size_t y = 0; y < height; ++y) conjugate(g->values + y * width, width, 1 / (double)width);
    transform_rows(g);
}

/* The response whose kernel is the square of this one's: what becomes of variances. */
static void square_response(grid *g) {
    const size_t count = g->size[0] * g->size[1];
    for (size_t i = 0; i < count; ++i) g->values[i] = (mcv_complex){0, 0};
    g->values[0].re = 1;
    filter(g);
    for (size_t i = 0; i < count; ++i) g->values[i] = (mcv_complex){g->values[i].re * g->values[i].re, 0};
    transform_rows(g);
    for (size_t x = 0; x < g->size[0]; ++x) {
        for (size_t y = 0; y < g->size[1]; ++y) g->line[0][y] = g->values[y * g->size[0] + x];
        mcv_fft(g->line[0], g->line[1], g->size[1], g->roots[1]);
        for (size_t y = 0; y < g->size[1]; ++y) g->response[y * g->size[0] + x] = g->line[1][y].re;
    }
}

/*
 * The correlation's spectrum is the square of the response over its mean S2: at frequency 0 the response is 1, and the sum 1/S2. The
 * stencil of second differences in both directions, whose sum of squares is 36, has the spectrum (2 - 2 cos)² of each.
 */
static mcv_correlation correlation_of(const grid *g) {
    const size_t count = g->size[0] * g->size[1];
    double second = 0, fourth = 0, stencil = 0;
    for (size_t y = 0; y < g->size[1]; ++y) {
        const double down = pow(2 - 2 * cos(2 * M_PI * (double)y / (double)g->size[1]), 2);
        for (size_t x = 0; x < g->size[0]; ++x) {
            const double h2 = pow(g->response[y * g->size[0] + x], 2);
            second += h2;
            fourth += h2 * h2;
            stencil += h2 * down * pow(2 - 2 * cos(2 * M_PI * (double)x / (double)g->size[0]), 2);
        }
    }
    return (mcv_correlation){(double)count / second, fourth * (double)count / (second * second), stencil / (36 * second), 0};
}

/* Of the response that square_response makes, whose kernel are the shares but for a factor. */
static double shares_of(const grid *g) {
    const size_t count = g->size[0] * g->size[1];
    double squares = 0;
    for (size_t i = 0; i < count; ++i) squares += g->response[i] * g->response[i];
    return squares / ((double)count * g->response[0] * g->response[0]);
}

/* Reads the image out of the grid again. */
static void extract(const grid *g, const mcv_image *image, float *plane, bool squared) {
    for (size_t y = 0; y < image->height; ++y)
        for (size_t x = 0; x < image->width; ++x) {
            const double value = fmax(0, g->values[y * g->size[0] + x].re);
            plane[y * image->width + x] = (float)(squared ? sqrt(value) : value);
        }
}

mcv_result mcv_blur(mcv_image *light, mcv_image *light_error, const mcv_lens_mtf mtf[3], const double pitch[2],
                    mcv_correlation *correlation, mcv_error *error) {
    grid g = {0};
    if (correlation) *correlation = (mcv_correlation){0};
    if (!grid_new(&g, light)) {
        grid_free(&g);
        return mcv_fail(error, MCV_FAILED, "the lens MTF needs %.3g GB of memory, which is not there: leave it out by --lens-mtf none",
                        24e-9 * (double)g.size[0] * (double)g.size[1]);
    }
    for (uint32_t channel = 0; channel < light->channels; ++channel) {
        const size_t first = (size_t)channel * light->width * light->height;
        set_response(&g, mtf + (channel < 3 ? channel : 2), pitch);
        fill(&g, light, light->pixels + first, false);
        filter(&g);
        extract(&g, light, light->pixels + first, false);
        if (!light_error) continue;
        if (correlation) {
            const mcv_correlation one = correlation_of(&g);
            correlation->sum += one.sum / light->channels;
            correlation->squares += one.squares / light->channels;
            correlation->stencil += one.stencil / light->channels;
        }
        square_response(&g);
        if (correlation) correlation->shares += shares_of(&g) / light->channels;
        fill(&g, light, light_error->pixels + first, true);
        filter(&g);
        extract(&g, light, light_error->pixels + first, true);
    }
    grid_free(&g);
    return MCV_OK;
}
