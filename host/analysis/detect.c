/* SPDX-License-Identifier: Apache-2.0 */
#include "analysis/detect.h"

#include <math.h>

double mcv_normal_below(double x) { return 0.5 * erfc(-x * M_SQRT1_2); }

double mcv_detect_variance(const mcv_camera *camera, double electrons) {
    const double pattern = camera->prnu * electrons;
    return electrons + camera->dark_electrons + camera->read_noise * camera->read_noise +
           1 / (12 * camera->gain * camera->gain) + camera->dsnu * camera->dsnu + pattern * pattern;
}

/* Does the camera read this channel in this pixel? */
static bool is_read(const mcv_camera *camera, uint32_t channels, uint32_t channel, uint32_t column,
                    uint32_t row) {
    static const char colours[] = "RGB";
    if (camera->bayer == MCV_BAYER_NONE || channels == 1) return true;
    const char *pattern = mcv_bayer_patterns[camera->bayer];
    return pattern[2 * (row % 2) + column % 2] == colours[channel < 3 ? channel : 2];
}

/* The pairs of one pixel. */
typedef struct pixel {
    double without, mean, variance; /* of the pairs */
} pixel;

/* One pair. Electrons above the full well are lost in either picture. */
static pixel pair_at(const mcv_pairs *p, double full_well, uint32_t replicate, size_t i) {
    const size_t at = replicate * (size_t)p->width * p->height * p->channels + i;
    const double without = fmin(p->without[at], full_well);
    return (pixel){.without = without, .mean = fmin(p->with[at], full_well) - without};
}

static pixel pixel_at(const mcv_pairs *p, double full_well, size_t i) {
    pixel at = {0};
    double squares = 0;
    for (uint32_t r = 0; r < p->replicates; ++r) {
        const pixel pair = pair_at(p, full_well, r, i);
        const double off = pair.mean - at.mean;
        at.without += pair.without / p->replicates;
        at.mean += off / (r + 1); /* Welford's recurrence */
        squares += off * (pair.mean - at.mean);
    }
    at.variance = squares / (p->replicates - 1);
    return at;
}

/*
 * Sums over the pixels. In units of σ: m², without its error v/R; and what Var Σ(mean² - v/R)
 * takes, of the covariances V of a pixel's channels 4 Σ mᵀVm/R + 2 Σ tr V²/(R (R - 1)) for normal
 * errors.
 */
typedef struct sums {
    double values, without, difference, variance; /* in electrons */
    double squared, cross, fourth;                /* in σ */
    double power, power_cross, power_fourth;      /* the first three in electrons */
    uint64_t visible;
} sums;

/* The channels of one pixel, with weights w: 1/σ², or 1 for electrons. */
typedef struct channels {
    double errors[MCV_MAX_REPLICATES]; /* of each pair x: Σ w mean (x - mean) */
    double left;                       /* Σ w (mean² - v/R) */
    double variances, squares;         /* Σ w v and Σ (w v)² */
} channels;

static void add_channel(channels *all, const mcv_pairs *p, const double *errors, const pixel *at,
                        double weight) {
    const double replicates = p->replicates, v = weight * at->variance,
                 left = at->mean * at->mean - at->variance / replicates;
    for (uint32_t r = 0; r < p->replicates; ++r) all->errors[r] += weight * at->mean * errors[r];
    all->left += weight * left;
    all->variances += v;
    all->squares += v * v;
}

/*
 * Adds what the channels have together. Estimates are unbiased: of v² it is v² (R - 1)/(R + 1), of
 * V_cd² = ρ² v_c v_d the product of both over 1 + 2 ρ²/(R - 1), and of mᵀVm what the pairs show
 * less tr V²/R.
 */
static void add_together(const channels *all, uint32_t replicates, double rho, double *squared,
                         double *cross, double *fourth) {
    const double r = replicates, shared = rho * rho / (1 + 2 * rho * rho / (r - 1)),
                 trace = all->squares * (r - 1) / (r + 1) +
                         shared * (all->variances * all->variances - all->squares);
    double variance = 0;
    for (uint32_t k = 0; k < replicates; ++k) variance += all->errors[k] * all->errors[k] / (r - 1);
    *squared += all->left;
    *cross += variance - trace / r;
    *fourth += trace;
}

/*
 * How the channels share the pairs' errors, as mcv_film_channel_correlation: all channels of a
 * pixel come from the same paths. 0 where the camera reads one channel of each pixel.
 */
static double correlation_of_channels(const mcv_pairs *p, const mcv_camera *camera) {
    const size_t plane = (size_t)p->width * p->height;
    double covariance = 0, product = 0;
    if (camera->bayer != MCV_BAYER_NONE || p->channels == 1) return 0;
    for (size_t i = 0; i < plane; ++i) {
        double all[MCV_MAX_REPLICATES] = {0}, roots = 0, squares = 0;
        if (p->inside && !p->inside[i]) continue;
        for (uint32_t c = 0; c < p->channels; ++c) {
            const pixel at = pixel_at(p, camera->full_well, c * plane + i);
            for (uint32_t r = 0; r < p->replicates; ++r)
                all[r] += pair_at(p, camera->full_well, r, c * plane + i).mean - at.mean;
            roots += sqrt(at.variance);
            squares += at.variance;
        }
        for (uint32_t r = 0; r < p->replicates; ++r)
            covariance += all[r] * all[r] / (p->replicates - 1);
        covariance -= squares;
        product += roots * roots - squares;
    }
    return product > 0 ? covariance / product : 0;
}

/* The variance of Σ(mean² - v/R). The sum over m² v may come out below 0: then there is no signal.
 */
static double variance_of(double cross, double fourth, const mcv_correlation *rho, double r) {
    return 4 * rho->sum * fmax(0, cross) / r + 2 * rho->squares * fourth / (r * (r - 1));
}

/* The root of an estimate, with the interval's half-width as its uncertainty near 0, where a root
 * has no slope. */
static mcv_quantity root_of(double value, double variance, double low_high[2]) {
    const double u = sqrt(variance), reach = 1.96 * u;
    low_high[0] = sqrt(fmax(0, value - reach));
    low_high[1] = sqrt(fmax(0, value + reach));
    const double root = sqrt(fmax(0, value));
    return (mcv_quantity){root,
                          value > 2 * u ? u / (2 * root) : (low_high[1] - low_high[0]) / 3.92};
}

static void finish(const sums *s, const mcv_pairs *p, mcv_detection *d) {
    const mcv_correlation *rho = &p->correlation;
    const double r = p->replicates, n = s->values;
    double ends[2];
    *d = (mcv_detection){.values = (uint64_t)n, .mean = s->without / n, .visible = s->visible};
    d->difference = (mcv_quantity){s->difference / n, sqrt(rho->sum * s->variance) / n};
    d->contrast =
        (mcv_quantity){d->difference.value / d->mean, d->difference.uncertainty / d->mean};
    const mcv_quantity rms =
        root_of(s->power / n, variance_of(s->power_cross, s->power_fourth, rho, r) / (n * n), ends);
    d->rms_contrast = (mcv_quantity){rms.value / d->mean, rms.uncertainty / d->mean};
    const double variance = variance_of(s->cross, s->fourth, rho, r);
    d->squared = (mcv_quantity){s->squared, sqrt(variance)};
    d->detectability = root_of(s->squared, variance, ends).value;
    d->low = ends[0];
    d->high = ends[1];
}

/* Adds the channels of a pixel that the camera reads. The largest |Δ|/σ of them. */
static double add_pixel(sums *s, const mcv_pairs *p, const mcv_camera *camera, double threshold,
                        double rho, size_t i) {
    const size_t plane = (size_t)p->width * p->height;
    const uint32_t column = (uint32_t)(i % p->width), row = (uint32_t)(i / p->width);
    double sums_of_errors[MCV_MAX_REPLICATES] = {0}, largest = 0;
    channels in_sigmas = {0}, in_electrons = {0};
    for (uint32_t c = 0; c < p->channels; ++c) {
        if (!is_read(camera, p->channels, c, column, row)) continue;
        const pixel at = pixel_at(p, camera->full_well, c * plane + i);
        const double noise = mcv_detect_variance(camera, at.without),
                     sigmas = fabs(at.mean) / sqrt(noise);
        double errors[MCV_MAX_REPLICATES];
        for (uint32_t r = 0; r < p->replicates; ++r) {
            errors[r] = pair_at(p, camera->full_well, r, c * plane + i).mean - at.mean;
            sums_of_errors[r] += errors[r];
        }
        add_channel(&in_sigmas, p, errors, &at, 1 / noise);
        add_channel(&in_electrons, p, errors, &at, 1);
        s->values += 1;
        s->without += at.without;
        s->difference += at.mean;
        s->visible += sigmas >= threshold;
        largest = fmax(largest, sigmas);
    }
    for (uint32_t r = 0; r < p->replicates; ++r)
        s->variance += sums_of_errors[r] * sums_of_errors[r] / (p->replicates - 1) / p->replicates;
    add_together(&in_sigmas, p->replicates, rho, &s->squared, &s->cross, &s->fourth);
    add_together(&in_electrons, p->replicates, rho, &s->power, &s->power_cross, &s->power_fourth);
    return largest;
}

mcv_result mcv_detect(const mcv_pairs *pairs, const mcv_camera *camera, double threshold,
                      mcv_image *visible, mcv_detection *detection, mcv_error *error) {
    const size_t plane = (size_t)pairs->width * pairs->height;
    sums s = {0};
    if (visible) {
        MCV_TRY(mcv_image_new(visible, pairs->width, pairs->height, 1, error));
        for (size_t i = 0; i < plane; ++i) visible->pixels[i] = 0;
    }
    const double rho = correlation_of_channels(pairs, camera);
    for (size_t i = 0; i < plane; ++i) {
        if (pairs->inside && !pairs->inside[i]) continue;
        const double sigmas = add_pixel(&s, pairs, camera, threshold, rho, i);
        if (visible) visible->pixels[i] = (float)sigmas;
    }
    finish(&s, pairs, detection);
    return MCV_OK;
}
