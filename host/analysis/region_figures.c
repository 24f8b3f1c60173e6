/* SPDX-License-Identifier: Apache-2.0 */
/* Figures of a region: mean, deviation, contrast, uniformity, each with its standard uncertainty.
 */
#include "analysis/region_noise.h"

#include "analysis/form.h"

#include <math.h>
#include <stdint.h>

static mcv_quantity quantity(double value, double variance) {
    return (mcv_quantity){value, sqrt(fmax(0, variance))};
}

/* A variance from so many degrees of freedom, widened so that 1.96 deviations cover 95 %. */
static double widened(double variance, double freedom) {
    const double widening = mcv_widening(freedom);
    return widening * widening * variance;
}

/*
 * Mean m and sample variance V of n values y whose pixels have the variances u²: Var m = Σu²/n²,
 * Cov(m, V) = 2 Σ(y - m)u²/(n (n - 1)) and, the noise being normal, Var V = (4 Σ(y - m)²u² - 2
 * Σu⁴)/(n - 1)², in which the second term takes out the noise that y brings into the first; 2
 * Σu⁴/(n - 1)² where all is noise. Half of that is the least: few values may lie closer together
 * than their noise. The square of an estimated u² is too large by its own variance, 2/freedom of
 * it.
 *
 * Part of u² is the error r² of the render; where a lens has blurred it, neighbours share it. With
 * correlations ρ, A = Σρ and B = Σρ², it counts A r² in sums of the values and B r⁴ in those of
 * squares, and V holds (n - A)/(n - 1) of it. A is the most that it can be: signals that change
 * within the reach of the blur weigh less.
 *
 * Without any signal V - noise is below `reach` in 95 % of cases. The ratio of V to a noise that is
 * estimated from it is skewed, its logarithm hardly.
 */
typedef struct moments {
    double n, mean, variance;
    double noise, render; /* what all noise, and what the render's error, adds to V */
    double camera;        /* the mean variance that is not the render's */
    double freedom;       /* of the noise, where it is estimated from the values */
    double var_mean, covariance, var_variance, reach;
    double var_noise;  /* of the estimate from the values */
    double var_render; /* of `render`, from how few replicates it is */
    double var_left;   /* of what the estimate from the values, which sees the render's error too,
                          leaves of that */
    double render_reach, render_least; /* without anything else V - render is below the first; its
                                          variance is the second */
} moments;

static moments find_moments(const mcv_readings *r, const mcv_roi *region) {
    const size_t plane = (size_t)region->width * region->height;
    const mcv_correlation rho = mcv_readings_correlation(r);
    moments m = {.n = (double)region->count,
                 .freedom = mcv_roi_estimate_freedom(region->estimated)};
    double sum = 0, squares = 0, c2_sum = 0, r2_sum = 0, c4_sum = 0, r4_sum = 0, cr_sum = 0,
           first = 0, second = 0;
    for (size_t i = 0; i < plane; ++i)
        if (region->inside[i]) sum += r->values.pixels[i];
    m.mean = sum / m.n;
    for (size_t i = 0; i < plane; ++i) {
        if (!region->inside[i]) continue;
        const double off = r->values.pixels[i] - m.mean, r2 = mcv_readings_render_variance(r, i);
        const double c2 = fmax(0, (double)r->deviation.pixels[i] * r->deviation.pixels[i] - r2),
                     w2 = c2 + rho.sum * r2;
        squares += off * off;
        c2_sum += c2;
        r2_sum += r2;
        c4_sum += c2 * c2;
        r4_sum += r2 * r2;
        cr_sum += c2 * r2;
        first += off * w2;
        second += off * off * w2;
    }
    const double freedom = m.n > 1 ? m.n - 1 : NAN;
    if (r->render_freedom > 0) r4_sum /= 1 + 2 * rho.shares / r->render_freedom;
    m.variance = squares / freedom;
    m.camera = c2_sum / m.n;
    m.render = r2_sum > 0 ? r2_sum / m.n * fmax(0, m.n - rho.sum) / freedom : 0;
    m.noise = m.camera + m.render;
    m.var_mean = (c2_sum + rho.sum * r2_sum) / (m.n * m.n);
    m.covariance = 2 * first / (m.n * freedom);
    m.var_render = r->render_freedom > 0 ? 2 * r4_sum / (r->render_freedom * m.n * m.n) : 0;
    m.var_noise = 2 * pow(m.camera + rho.stencil * r2_sum / m.n, 2) / m.freedom;
    m.var_left = m.var_render * (region->estimated ? pow(1 - rho.stencil, 2) : 1);
    const double var_least = 2 * (c4_sum + 2 * cr_sum + rho.squares * r4_sum) / (freedom * freedom);
    m.render_least = 2 * rho.squares * r4_sum / (freedom * freedom) + m.var_render;
    m.render_reach = 1.645 * sqrt(m.render_least);
    const double far = 1.645 * sqrt(var_least + m.var_noise + m.var_left);
    m.reach = m.var_noise > 0 ? m.noise * expm1(far / m.noise) : far;
    const double c4 = c4_sum / (1 + 2 / m.freedom),
                 signal = 4 * (second - c4 - (1 + rho.sum) * cr_sum - rho.sum * r4_sum);
    const double wide = m.variance > m.noise + m.reach ? widened(signal, m.freedom) : signal;
    m.var_variance = fmax(0.5 * var_least, (wide + 2 * (c4 + 2 * cr_sum + rho.squares * r4_sum)) /
                                               (freedom * freedom));
    return m;
}

/* The root of a variance, of which noise was taken out. Near 0 the root has no slope, and the
 * interval reaches up only. */
static mcv_quantity root_of(double signal, double reach, double variance) {
    if (isnan(signal)) return (mcv_quantity){NAN, NAN};
    double var_root =
        0.75 * reach / 1.645; /* below `reach` whatever is large enough: the interval ends at 0 */
    if (signal > reach)
        var_root =
            fmax(variance / (4 * signal), pow((sqrt(signal) - sqrt(signal - reach)) / 1.96, 2));
    return quantity(sqrt(fmax(0, signal)), var_root);
}

/*
 * The deviation that is not noise, over the mean: √s/m with s = V - noise. An estimate of the noise
 * from the values adds its own variance to that of s, `share` of it, because it has to do with V.
 */
static mcv_quantity rms_contrast(const moments *m, double share) {
    const double variance =
                     m->var_variance + widened(share * m->var_noise, m->freedom) + m->var_left,
                 mean2 = m->mean * m->mean;
    const mcv_quantity root = root_of(m->variance - m->noise, m->reach, variance);
    const double rms = root.value / m->mean;
    return quantity(rms, root.uncertainty * root.uncertainty / mean2 +
                             rms * rms * widened(m->var_mean, m->freedom) / mean2 -
                             (root.value > 0 ? m->covariance / (mean2 * m->mean) : 0));
}

/* The deviation without the render's error. */
static mcv_quantity deviation_of(const moments *m) {
    return root_of(m->variance - m->render, m->render_reach, m->var_variance + m->var_render);
}

/*
 * The factor of samples with which the deviation could be separated from the render's error; 0
 * where they are enough. A render's variance goes as 1/samples. The variance of V has a part that
 * goes with its square, and one, mixed with other causes, that goes with itself.
 */
static double samples_needed(const moments *m) {
    const double signal = fmax(m->variance - m->render, m->render_reach),
                 allowed = pow(MCV_ROI_HIDDEN * signal, 2);
    const double squared = m->render_least,
                 mixed = m->render > 0 ? 4 * m->render * signal / m->n : 0;
    if (!(squared + mixed > allowed)) return 0;
    return (mixed + sqrt(mixed * mixed + 4 * squared * allowed)) / (2 * allowed);
}

enum { CELLS = 8 };

/* Sums over the pixels of one cell. */
typedef struct cell {
    double values, variance, render, count;
} cell;

/* Adds the region's pixels to the cells of its frame. */
static void fill_cells(const mcv_readings *r, const mcv_roi *region, cell cells[CELLS * CELLS],
                       double *whole) {
    const double shared = mcv_readings_correlation(r).sum;
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
            const double render = mcv_readings_render_variance(r, i);
            ++cells[k].count;
            cells[k].values += r->values.pixels[i];
            cells[k].variance +=
                (double)r->deviation.pixels[i] * r->deviation.pixels[i] + (shared - 1) * render;
            cells[k].render += shared * render;
        }
}

/* 1 less the contrast of an image of 8 x 8 pixels, the cells' means. */
static mcv_quantity uniformity(const mcv_readings *r, const mcv_roi *region) {
    cell sums[CELLS * CELLS] = {{0}};
    float means[CELLS * CELLS], deviations[CELLS * CELLS], renders[CELLS * CELLS];
    uint8_t inside[CELLS * CELLS];
    double whole, pixels = 0;
    mcv_roi all = {
        .width = CELLS, .height = CELLS, .inside = inside, .estimated = region->estimated};
    fill_cells(r, region, sums, &whole);
    for (int k = 0; k < CELLS * CELLS; ++k) {
        inside[k] = sums[k].count > 0 && 2 * sums[k].count >= whole;
        all.count += inside[k];
        if (inside[k]) pixels += sums[k].count;
        means[k] = (float)(sums[k].values / sums[k].count);
        deviations[k] = (float)(sqrt(sums[k].variance) / sums[k].count);
        renders[k] = (float)(sqrt(sums[k].render) / sums[k].count);
    }
    const mcv_image plane = {.width = CELLS, .height = CELLS, .channels = 1};
    mcv_readings cells = {.values = plane, .deviation = plane, .render = plane};
    cells.values.pixels = means;
    cells.deviation.pixels = deviations;
    cells.render.pixels = renders;
    cells.render_freedom = r->render_freedom * pixels / (double)all.count;
    const moments m = find_moments(&cells, &all);
    const mcv_quantity contrast = rms_contrast(&m, 1);
    return (mcv_quantity){1 - contrast.value, contrast.uncertainty};
}

static const mcv_quantity unknown = {NAN, NAN};

mcv_roi_figures mcv_roi_measure(const mcv_readings *r, const mcv_roi *region) {
    const moments m = find_moments(r, region);
    const mcv_quantity deviation = deviation_of(&m);
    const double d2 = deviation.value * deviation.value, snr = m.mean / deviation.value,
                 var_mean = widened(m.var_mean, m.freedom);
    mcv_roi_figures f = {
        .count = region->count,
        .smallest = INFINITY,
        .largest = -INFINITY,
        .noise = sqrt(m.camera),
        .render_noise = sqrt(m.noise - m.camera),
        .samples = samples_needed(&m),
        .mean = quantity(m.mean, var_mean),
        .deviation = deviation,
        .rms_contrast = rms_contrast(&m, 10.0 / 12),
        .uniformity = uniformity(r, region),
    };
    f.snr = f.samples > 0
                ? unknown
                : quantity(snr, var_mean / d2 +
                                    snr * snr * deviation.uncertainty * deviation.uncertainty / d2 -
                                    m.mean * m.covariance / (d2 * d2));
    for (size_t i = 0; i < (size_t)region->width * region->height; ++i) {
        if (!region->inside[i]) continue;
        f.smallest = fmin(f.smallest, r->values.pixels[i]);
        f.largest = fmax(f.largest, r->values.pixels[i]);
    }
    return f;
}

/* a + b, each with its degrees of freedom, widened by those that Welch and Satterthwaite give the
 * sum. */
static double widened_sum(double a, double freedom_a, double b, double freedom_b) {
    return widened(a + b, (a + b) * (a + b) / (a * a / freedom_a + b * b / freedom_b));
}

mcv_contrast_figures mcv_roi_contrast(const mcv_readings *r, const mcv_roi *region,
                                      const mcv_roi *background) {
    const moments mm = find_moments(r, region), bm = find_moments(r, background);
    const mcv_quantity deviation = deviation_of(&bm);
    const double m = mm.mean, b = bm.mean, v = deviation.value * deviation.value, both = m + b,
                 ratio = (m - b) / deviation.value;
    double shared = 0, slanted = 0; /* Σu² and Σ(y - b)u² of the pixels that both have */
    for (size_t i = 0; i < (size_t)region->width * region->height; ++i) {
        if (!region->inside[i] || !background->inside[i]) continue;
        const double u2 =
            (double)r->deviation.pixels[i] * r->deviation.pixels[i] +
            (mcv_readings_correlation(r).sum - 1) * mcv_readings_render_variance(r, i);
        shared += u2 / (mm.n * bm.n);
        slanted += 2 * (r->values.pixels[i] - b) * u2 / (mm.n * (bm.n - 1));
    }
    const double vm = mm.var_mean, vb = bm.var_mean,
                 difference = widened_sum(vm, mm.freedom, vb, bm.freedom) - 2 * shared;
    mcv_contrast_figures f = {
        .samples = samples_needed(&bm),
        .difference = quantity(m - b, difference),
        .weber =
            quantity((m - b) / b, (widened_sum(vm, mm.freedom, m * m / (b * b) * vb, bm.freedom) -
                                   2 * m / b * shared) /
                                      (b * b)),
        .michelson = quantity(
            (m - b) / both,
            4 * (widened_sum(b * b * vm, mm.freedom, m * m * vb, bm.freedom) - 2 * m * b * shared) /
                pow(both, 4)),
    };
    f.contrast_to_noise = f.samples > 0
                              ? unknown
                              : quantity(ratio, difference / v +
                                                    ratio * ratio * deviation.uncertainty *
                                                        deviation.uncertainty / v -
                                                    (m - b) / (v * v) * (slanted - bm.covariance));
    return f;
}
