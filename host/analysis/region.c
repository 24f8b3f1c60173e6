/* SPDX-License-Identifier: Apache-2.0 */
#include "analysis/region.h"

#include "analysis/statistics.h"
#include "output/values.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* --- what belongs to it ----------------------------------------------------------------------------------------- */

enum { MAX_NUMBERS = 256 };

size_t mcv_roi_numbers(const char *text, size_t number, char name[64], const char **rest, double *numbers, size_t most) {
    const char *equals = strchr(text, '=');
    if (equals && equals > text)
        snprintf(name, 64, "%.*s", (int)(equals - text), text);
    else
        snprintf(name, 64, "%zu", number);
    *rest = equals ? equals + 1 : text;
    if ((*rest)[strspn(*rest, "0123456789.+-eE, ")] != '\0') return 0;
    size_t count = 0;
    for (const char *c = *rest; count < most; ++c) {
        char *end;
        numbers[count] = strtod(c, &end);
        if (end == c || !isfinite(numbers[count])) return 0;
        ++count;
        c = end + strspn(end, " ");
        if (*c == '\0') return count;
        if (*c != ',') return 0;
    }
    return 0;
}

/* Even-odd: how many edges a ray to the left meets. */
static bool in_polygon(const double *corners, size_t count, double x, double y) {
    bool inside = false;
    for (size_t i = 0, j = count - 1; i < count; j = i++) {
        const double *a = corners + 2 * i, *b = corners + 2 * j;
        if ((a[1] > y) != (b[1] > y) && x > a[0] + (y - a[1]) * (b[0] - a[0]) / (b[1] - a[1])) inside = !inside;
    }
    return inside;
}

static mcv_result fill_polygon(const char *text, const double *corners, size_t count, mcv_roi *region, mcv_error *error) {
    for (size_t i = 0; i < count; ++i)
        if (!(corners[2 * i] >= 0 && corners[2 * i] <= region->width && corners[2 * i + 1] >= 0 && corners[2 * i + 1] <= region->height))
            return mcv_fail(error, MCV_USAGE, "region %s reaches to column %g, row %g: the image has %u x %u pixels", text, corners[2 * i],
                            corners[2 * i + 1], region->width, region->height);
    for (uint32_t y = 0; y < region->height; ++y)
        for (uint32_t x = 0; x < region->width; ++x)
            region->inside[(size_t)y * region->width + x] = in_polygon(corners, count, x + 0.5, y + 0.5);
    return MCV_OK;
}

static mcv_result fill_mask(const char *text, const char *path, mcv_roi *region, mcv_error *error) {
    mcv_image mask;
    if (!mcv_values_named(path))
        return mcv_fail(error, MCV_USAGE, "region %s must be X,Y,W,H, a polygon X,Y,X,Y,X,Y,… or an image " MCV_VALUES_ENDINGS, text);
    MCV_TRY(mcv_values_read(path, &mask, error));
    const bool fits = mask.width == region->width && mask.height == region->height;
    const mcv_result result = fits ? MCV_OK
                                   : mcv_fail(error, MCV_BAD_INPUT, "%s: a mask of %u x %u pixels: the image has %u x %u", path, mask.width,
                                              mask.height, region->width, region->height);
    for (size_t i = 0; fits && i < (size_t)region->width * region->height; ++i) region->inside[i] = mask.pixels[i] > 0;
    mcv_image_free(&mask);
    return result;
}

mcv_result mcv_roi_parse(const char *text, size_t number, const mcv_image *image, mcv_roi *region, mcv_error *error) {
    double n[MAX_NUMBERS];
    const char *rest;
    *region = (mcv_roi){.width = image->width, .height = image->height};
    const size_t count = mcv_roi_numbers(text, number, region->name, &rest, n, MAX_NUMBERS), plane = (size_t)image->width * image->height;
    region->inside = calloc(plane, 1);
    if (!region->inside) return mcv_fail(error, MCV_FAILED, "region %s: no memory for it", text);
    mcv_result result;
    if (count == 4) {
        const double box[] = {n[0], n[1], n[0] + n[2], n[1], n[0] + n[2], n[1] + n[3], n[0], n[1] + n[3]};
        result = fill_polygon(text, box, 4, region, error);
    } else if (count >= 6 && count % 2 == 0) {
        result = fill_polygon(text, n, count / 2, region, error);
    } else {
        result = fill_mask(text, rest, region, error);
    }
    for (size_t i = 0; result == MCV_OK && i < plane; ++i) {
        region->inside[i] = region->inside[i] && !isnan(image->pixels[i]);
        region->count += region->inside[i];
    }
    if (result == MCV_OK && region->count == 0) result = mcv_fail(error, MCV_USAGE, "region %s holds no pixel of the image", text);
    if (result != MCV_OK) mcv_roi_free(region);
    return result;
}

void mcv_roi_free(mcv_roi *region) {
    free(region->inside);
    region->inside = NULL;
}

/* --- noise ------------------------------------------------------------------------------------------------------ */

static int compare_floats(const void *a, const void *b) {
    const float x = *(const float *)a, y = *(const float *)b;
    return (x > y) - (x < y);
}

static bool has_neighbours(const mcv_roi *r, uint32_t x, uint32_t y) {
    for (uint32_t j = y - 1; j <= y + 1; ++j)
        for (uint32_t i = x - 1; i <= x + 1; ++i)
            if (!r->inside[(size_t)j * r->width + i]) return false;
    return true;
}

/*
 * Of N second differences, which share pixels: by simulation, for squares of 3 x 3 to 32 x 32 pixels, the squared median is 1 + 5/N times
 * the variance in the mean, and as uncertain as a variance from so many degrees of freedom.
 */
static double estimate_bias(double differences) { return 1 + 5 / differences; }

static double estimate_freedom(uint64_t differences) { return differences ? ((double)differences + 4) / 6 : INFINITY; }

double mcv_roi_estimate_noise(mcv_readings *readings, mcv_roi *region, double least) {
    static const float stencil[3][3] = {{1, -2, 1}, {-2, 4, -2}, {1, -2, 1}}; /* noise of 1 makes 6 */
    const double median_of_normal = 0.67448975;                               /* of |Z| */
    const uint32_t width = region->width;
    float *found = malloc(region->count * sizeof *found);
    size_t count = 0;
    for (uint32_t y = 1; found && y + 1 < region->height; ++y)
        for (uint32_t x = 1; x + 1 < width; ++x) {
            float sum = 0;
            if (!has_neighbours(region, x, y)) continue;
            for (uint32_t j = 0; j < 3; ++j)
                for (uint32_t i = 0; i < 3; ++i) sum += stencil[j][i] * readings->values.pixels[(size_t)(y - 1 + j) * width + x - 1 + i];
            found[count++] = fabsf(sum);
        }
    double noise = NAN;
    if (count) {
        qsort(found, count, sizeof *found, compare_floats);
        const double median = 0.5 * ((double)found[(count - 1) / 2] + found[count / 2]);
        noise = fmax(least, median / (6 * median_of_normal * sqrt(estimate_bias((double)count))));
    }
    free(found);
    region->estimated = count;
    for (size_t i = 0; i < (size_t)width * region->height; ++i)
        if (region->inside[i]) readings->deviation.pixels[i] = (float)noise;
    return noise;
}

/* --- figures ---------------------------------------------------------------------------------------------------- */

static mcv_quantity quantity(double value, double variance) { return (mcv_quantity){value, sqrt(fmax(0, variance))}; }

/* A variance that is known from so many degrees of freedom, as wide as one that is known. */
static double widened(double variance, double freedom) {
    return isfinite(freedom) ? variance * pow(mcv_student_quantile(0.05, freedom) / 1.959964, 2) : variance;
}

/*
 * Mean m and sample variance V of n values y whose pixels have the variances u²: Var m = Σu²/n², Cov(m, V) = 2 Σ(y - m)u²/(n (n - 1)) and,
 * the noise being normal, Var V = (4 Σ(y - m)²u² - 2 Σu⁴)/(n - 1)², in which the second term takes out the noise that y brings into the
 * first; 2 Σu⁴/(n - 1)² where all is noise. Half of that is the least: few values may lie closer together than their noise. The square of
 * an estimated u² is too large by its own variance, 2/freedom of it.
 *
 * Without any signal V - noise is below `reach` in 95 % of cases. The ratio of V to an estimated noise is skewed, its logarithm hardly.
 */
typedef struct moments {
    double n, mean, variance, noise;
    double freedom; /* of the noise */
    double var_mean, covariance, var_variance, reach;
} moments;

static moments find_moments(const mcv_readings *r, const mcv_roi *region) {
    const size_t plane = (size_t)region->width * region->height;
    moments m = {.n = (double)region->count, .freedom = estimate_freedom(region->estimated)};
    double sum = 0, squares = 0, u2_sum = 0, u4_sum = 0, first = 0, second = 0;
    for (size_t i = 0; i < plane; ++i)
        if (region->inside[i]) sum += r->values.pixels[i];
    m.mean = sum / m.n;
    for (size_t i = 0; i < plane; ++i) {
        if (!region->inside[i]) continue;
        const double off = r->values.pixels[i] - m.mean, u2 = (double)r->deviation.pixels[i] * r->deviation.pixels[i];
        squares += off * off;
        u2_sum += u2;
        u4_sum += u2 * u2;
        first += off * u2;
        second += off * off * u2;
    }
    const double freedom = m.n > 1 ? m.n - 1 : NAN;
    m.variance = squares / freedom;
    m.noise = u2_sum / m.n;
    m.var_mean = u2_sum / (m.n * m.n);
    m.covariance = 2 * first / (m.n * freedom);
    const double var_noise = 2 * m.noise * m.noise / m.freedom, var_least = 2 * u4_sum / (freedom * freedom);
    const double far = 1.645 * sqrt(var_least + var_noise);
    m.reach = var_noise > 0 ? m.noise * expm1(far / m.noise) : far;
    const double squared_noise = u4_sum / (1 + 2 / m.freedom), signal = 4 * (second - squared_noise);
    const double wide = m.variance > m.noise + m.reach ? widened(signal, m.freedom) : signal;
    m.var_variance = fmax(0.5 * var_least, (wide + 2 * squared_noise) / (freedom * freedom));
    return m;
}

/*
 * The deviation that is not noise, over the mean: √s/m with s = V - noise. An estimate of the noise adds its own variance to that of s,
 * `share` of it: it has to do with V, if it comes from the same values. Near 0 the root has no slope, and the interval reaches up only.
 */
static mcv_quantity rms_contrast(const moments *m, double share) {
    const double signal = isnan(m->variance) ? NAN : fmax(0, m->variance - m->noise), rms = sqrt(signal) / m->mean,
                 mean2 = m->mean * m->mean;
    const double reach = m->reach, var_noise = widened(share * 2 * m->noise * m->noise / m->freedom, m->freedom);
    double var_root = 0.75 * reach / 1.645; /* below `reach` whatever is large enough: the interval ends at 0 */
    if (signal > reach) var_root = fmax((m->var_variance + var_noise) / (4 * signal), pow((sqrt(signal) - sqrt(signal - reach)) / 1.96, 2));
    return quantity(rms, var_root / mean2 + rms * rms * widened(m->var_mean, m->freedom) / mean2 -
                             (signal > 0 ? m->covariance / (mean2 * m->mean) : 0));
}

enum { CELLS = 8 };

/* Adds the region's pixels to the cells of its frame: sums of values and variances, and how many. */
static void fill_cells(const mcv_readings *r, const mcv_roi *region, double sums[CELLS * CELLS], double variances[CELLS * CELLS],
                       double counts[CELLS * CELLS], double *whole) {
    uint32_t low[2] = {UINT32_MAX, UINT32_MAX}, high[2] = {0, 0};
    for (uint32_t y = 0; y < region->height; ++y)
        for (uint32_t x = 0; x < region->width; ++x) {
            if (!region->inside[(size_t)y * region->width + x]) continue;
            low[0] = x < low[0] ? x : low[0];
            low[1] = y < low[1] ? y : low[1];
            high[0] = x >= high[0] ? x + 1 : high[0];
            high[1] = y >= high[1] ? y + 1 : high[1];
        }
    const uint64_t width = high[0] - low[0], height = high[1] - low[1];
    *whole = (double)(width * height) / (CELLS * CELLS);
    for (uint32_t y = low[1]; y < high[1]; ++y)
        for (uint32_t x = low[0]; x < high[0]; ++x) {
            const size_t i = (size_t)y * region->width + x;
            const uint64_t k = (y - low[1]) * CELLS / height * CELLS + (x - low[0]) * CELLS / width;
            if (!region->inside[i]) continue;
            ++counts[k];
            sums[k] += r->values.pixels[i];
            variances[k] += (double)r->deviation.pixels[i] * r->deviation.pixels[i];
        }
}

/* 1 less the contrast of an image of 8 x 8 pixels, the cells' means. */
static mcv_quantity uniformity(const mcv_readings *r, const mcv_roi *region) {
    double sums[CELLS * CELLS] = {0}, variances[CELLS * CELLS] = {0}, counts[CELLS * CELLS] = {0}, whole;
    float means[CELLS * CELLS], deviations[CELLS * CELLS];
    uint8_t inside[CELLS * CELLS];
    const mcv_readings cells = {.values = {.width = CELLS, .height = CELLS, .channels = 1, .pixels = means},
                                .deviation = {.width = CELLS, .height = CELLS, .channels = 1, .pixels = deviations}};
    mcv_roi all = {.width = CELLS, .height = CELLS, .inside = inside, .estimated = region->estimated};
    fill_cells(r, region, sums, variances, counts, &whole);
    for (int k = 0; k < CELLS * CELLS; ++k) {
        inside[k] = counts[k] > 0 && 2 * counts[k] >= whole;
        all.count += inside[k];
        means[k] = (float)(sums[k] / counts[k]);
        deviations[k] = (float)(sqrt(variances[k]) / counts[k]);
    }
    const moments m = find_moments(&cells, &all);
    const mcv_quantity contrast = rms_contrast(&m, 1);
    return (mcv_quantity){1 - contrast.value, contrast.uncertainty};
}

mcv_roi_figures mcv_roi_measure(const mcv_readings *r, const mcv_roi *region) {
    const moments m = find_moments(r, region);
    const double deviation = sqrt(m.variance), snr = m.mean / deviation, var_mean = widened(m.var_mean, m.freedom);
    mcv_roi_figures f = {
        .count = region->count,
        .smallest = INFINITY,
        .largest = -INFINITY,
        .noise = sqrt(m.noise),
        .mean = quantity(m.mean, var_mean),
        .deviation = quantity(deviation, m.var_variance / (4 * m.variance)),
        .rms_contrast = rms_contrast(&m, 10.0 / 12),
        .snr = quantity(snr, var_mean / m.variance + snr * snr * m.var_variance / (4 * m.variance * m.variance) -
                                 m.mean * m.covariance / (m.variance * m.variance)),
        .uniformity = uniformity(r, region),
    };
    for (size_t i = 0; i < (size_t)region->width * region->height; ++i) {
        if (!region->inside[i]) continue;
        f.smallest = fmin(f.smallest, r->values.pixels[i]);
        f.largest = fmax(f.largest, r->values.pixels[i]);
    }
    return f;
}

/* a + b, each with its degrees of freedom, widened by those that Welch and Satterthwaite give the sum. */
static double widened_sum(double a, double freedom_a, double b, double freedom_b) {
    return widened(a + b, (a + b) * (a + b) / (a * a / freedom_a + b * b / freedom_b));
}

mcv_contrast_figures mcv_roi_contrast(const mcv_readings *r, const mcv_roi *region, const mcv_roi *background) {
    const moments mm = find_moments(r, region), bm = find_moments(r, background);
    const double m = mm.mean, b = bm.mean, v = bm.variance, both = m + b, ratio = (m - b) / sqrt(v);
    double shared = 0, slanted = 0; /* Σu² and Σ(y - b)u² of the pixels that both have */
    for (size_t i = 0; i < (size_t)region->width * region->height; ++i) {
        if (!region->inside[i] || !background->inside[i]) continue;
        const double u2 = (double)r->deviation.pixels[i] * r->deviation.pixels[i];
        shared += u2 / (mm.n * bm.n);
        slanted += 2 * (r->values.pixels[i] - b) * u2 / (mm.n * (bm.n - 1));
    }
    const double vm = mm.var_mean, vb = bm.var_mean, difference = widened_sum(vm, mm.freedom, vb, bm.freedom) - 2 * shared;
    return (mcv_contrast_figures){
        .difference = quantity(m - b, difference),
        .weber = quantity((m - b) / b, (widened_sum(vm, mm.freedom, m * m / (b * b) * vb, bm.freedom) - 2 * m / b * shared) / (b * b)),
        .michelson =
            quantity((m - b) / both, 4 * (widened_sum(b * b * vm, mm.freedom, m * m * vb, bm.freedom) - 2 * m * b * shared) / pow(both, 4)),
        .contrast_to_noise =
            quantity(ratio, difference / v + ratio * ratio * bm.var_variance / (4 * v * v) - (m - b) / (v * v) * (slanted - bm.covariance)),
    };
}
