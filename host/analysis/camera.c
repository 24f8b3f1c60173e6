/* SPDX-License-Identifier: Apache-2.0 */
#include "analysis/camera.h"
#include "analysis/noise.h"
#include "core/parallel.h"

#include <math.h>
#include <stdlib.h>

double mcv_camera_electrons_per_irradiance(double exposure_time, double quantum_efficiency,
                                           double wavelength, double pixel_area) {
    const double planck = 6.62607015e-34; /* [J s], exact in the SI of 2019, as is c [m/s] */
    const double light_speed = 299792458;
    return quantum_efficiency * pixel_area * exposure_time * wavelength / (planck * light_speed);
}

const char *const mcv_bayer_patterns[] = {
#define MCV_X(NAME, pattern) pattern,
    MCV_BAYER_PATTERNS(MCV_X)
#undef MCV_X
};

static bool is_amount(double value) { return value >= 0 && isfinite(value); }

static mcv_result check_camera(const mcv_camera *c, mcv_error *error) {
    if (c->bits < 1 || c->bits > MCV_CAMERA_MAX_BITS)
        return mcv_fail(error, MCV_USAGE, "a camera of %u bits: must be 1 to %d", c->bits,
                        MCV_CAMERA_MAX_BITS);
    if (c->black_level >= 1u << c->bits) {
        return mcv_fail(error, MCV_USAGE,
                        "a black level of %u DN: must be below %u, the grey values of %u bits",
                        c->black_level, 1u << c->bits, c->bits);
    }
    if (!(c->full_well > 0 && c->full_well <= 1e12 && c->gain > 0 && isfinite(c->gain))) {
        return mcv_fail(error, MCV_USAGE,
                        "a full well of %g e- and a gain of %g DN/e-: must be above 0 and at most "
                        "1e12, and above 0",
                        c->full_well, c->gain);
    }
    if (!is_amount(c->read_noise) || !is_amount(c->dark_electrons) || !is_amount(c->dsnu) ||
        !is_amount(c->prnu)) {
        return mcv_fail(error, MCV_USAGE,
                        "a read noise of %g e-, %g dark electrons, a DSNU of %g e- and a PRNU of "
                        "%g: must be at least 0 and finite",
                        c->read_noise, c->dark_electrons, c->dsnu, c->prnu);
    }
    for (int i = 0; i < 3; ++i) {
        if (is_amount(c->electrons_per_unit[i])) continue;
        return mcv_fail(error, MCV_USAGE,
                        "a scale of %g e- per unit: must be at least 0 and finite",
                        c->electrons_per_unit[i]);
    }
    return MCV_OK;
}

mcv_result mcv_camera_check_light(const mcv_image *light, mcv_error *error) {
    const size_t plane = (size_t)light->width * light->height;
    for (size_t i = 0; i < plane * light->channels; ++i) {
        if (light->pixels[i] >= 0 && isfinite(light->pixels[i])) continue;
        return mcv_fail(error, MCV_BAD_INPUT,
                        "the pixel in column %zu, row %zu, channel %zu, is %g: light must be "
                        "finite and not negative",
                        i % plane % light->width, i % plane / light->width, i / plane,
                        light->pixels[i]);
    }
    return MCV_OK;
}

/* --- the level --- */

enum { SQUARE = 16, LATTICE = 4, LATTICES = LATTICE * LATTICE };

/* Of errors that channels share in part: the variance if they shared nothing is Σ own, if all
 * (Σ roots)², the roots with the signs of the slopes. */
static double shared_variance(double own, double all, double shared) {
    return own + shared * (all - own);
}

/* Sums over squares. */
typedef struct powers {
    double low, high; /* of μ^15 and μ^16 */
    double errors[3]; /* of v μ^28, v μ^29 and v μ^30, v the variance of μ */
    double roots[2];  /* over the channels of this square alone: of √v μ^14 and √v μ^15 */
    double whole[3];  /* of the products of the roots, as in errors */
} powers;

/* Adds a channel of a square: of μ^15 and μ^16 the means of products of 15 and of 16 different
 * lattices. */
static void add_square(const mcv_image *light, const mcv_image *light_error, uint32_t channel,
                       const uint32_t x[2], const uint32_t y[2], double scale, powers *sums) {
    const size_t first = (size_t)channel * light->width * light->height;
    double means[LATTICES] = {0}, counts[LATTICES] = {0}, products[LATTICES + 1] = {1}, mean = 0,
           variance = 0;
    for (uint32_t row = y[0]; row < y[1]; ++row)
        for (uint32_t column = x[0]; column < x[1]; ++column) {
            const uint32_t k = row % LATTICE * LATTICE + column % LATTICE;
            const size_t i = first + (size_t)row * light->width + column;
            means[k] += scale * (double)light->pixels[i];
            ++counts[k];
            if (light_error) variance += pow(scale * (double)light_error->pixels[i], 2);
        }
    /* products[n]: the sum over all choices of n of the lattices so far. */
    for (int k = 0; k < LATTICES; ++k) {
        means[k] /= counts[k];
        mean += means[k] / LATTICES;
        for (int n = k + 1; n > 0; --n) products[n] += products[n - 1] * means[k];
    }
    const double pixels = (double)(x[1] - x[0]) * (y[1] - y[0]);
    sums->low += products[LATTICES - 1] / LATTICES;
    sums->high += products[LATTICES];
    /*
     * The noise of the mean makes the mean of its power p too large by about exp(p (p - 1) s²/2), s
     * its share of the mean. One factor for the three powers: level_of_squares takes their
     * difference.
     */
    enum { MIDDLE = 2 * LATTICES - 3 };
    const double own = variance / (pixels * pixels), share = mean > 0 ? own / (mean * mean) : 0;
    const double factor = exp(-0.5 * MIDDLE * (MIDDLE - 1) * share);
    for (int n = 0; n < 3; ++n) sums->errors[n] += factor * own * pow(mean, MIDDLE - 1 + n);
    for (int n = 0; n < 2; ++n) sums->roots[n] += sqrt(factor * own) * pow(mean, LATTICES - 2 + n);
}

/* Ends a square, whose channels are all added. Their errors have the same shape within it: where
 * they have not, the uncertainty is slightly too large. */
static void end_square(powers *sums) {
    const double low = sums->roots[0], high = sums->roots[1];
    sums->whole[0] += low * low;
    sums->whole[1] += low * high;
    sums->whole[2] += high * high;
    sums->roots[0] = sums->roots[1] = 0;
}

/* H/L of the sums H of μ^16 and L of μ^15: dμ moves it by (16 μ^15 - 15 μ^14 H/L)/L. */
static mcv_quantity level_of_squares(const mcv_image *light, const mcv_image *light_error,
                                     double shared, const double electrons_per_unit[3],
                                     double mean) {
    const uint32_t across = light->width / SQUARE, down = light->height / SQUARE;
    powers p = {0};
    for (uint32_t j = 0; j < down; ++j)
        for (uint32_t i = 0; i < across; ++i) {
            const uint32_t x[] = {(uint32_t)((uint64_t)light->width * i / across),
                                  (uint32_t)((uint64_t)light->width * (i + 1) / across)};
            const uint32_t y[] = {(uint32_t)((uint64_t)light->height * j / down),
                                  (uint32_t)((uint64_t)light->height * (j + 1) / down)};
            for (uint32_t c = 0; c < light->channels; ++c)
                add_square(light, light_error, c, x, y, electrons_per_unit[c < 3 ? c : 2] / mean,
                           &p);
            end_square(&p);
        }
    if (!(p.low > 0)) return (mcv_quantity){0, NAN};
    const double level = p.high / p.low, a = LATTICES, b = (LATTICES - 1) * level;
    double v[3];
    for (int n = 0; n < 3; ++n) v[n] = shared_variance(p.errors[n], p.whole[n], shared);
    const double variance = (a * a * v[2] - 2 * a * b * v[1] + b * b * v[0]) / (p.low * p.low);
    return (mcv_quantity){mean * level, mean * sqrt(fmax(0, variance))};
}

/* The variance of the level of squares: dy moves it by (2 y - level)/sum. The noise of y adds 4 u^4
 * to its mean square, more than the squares' own noise is. */
static double variance_by_pixels(const mcv_image *light, const mcv_image *light_error,
                                 double shared, const double electrons_per_unit[3], double level) {
    const size_t plane = (size_t)light->width * light->height;
    double variance = 0;
    for (size_t i = 0; i < plane; ++i) {
        double own = 0, all = 0;
        for (uint32_t c = 0; c < light->channels; ++c) {
            const double e = electrons_per_unit[c < 3 ? c : 2];
            const size_t at = c * plane + i;
            const double root =
                e * (double)light_error->pixels[at] * (2 * e * (double)light->pixels[at] - level);
            own += root * root;
            all += root;
        }
        variance += shared_variance(own, all * all, shared);
    }
    return fmax(0, variance);
}

mcv_quantity mcv_camera_level(const mcv_image *light, const mcv_image *light_error, double shared,
                              const double electrons_per_unit[3]) {
    const size_t plane = (size_t)light->width * light->height;
    double sum = 0, squares = 0;
    for (size_t i = 0; i < plane * light->channels; ++i) {
        const double e = electrons_per_unit[i / plane < 3 ? i / plane : 2],
                     y = e * (double)light->pixels[i];
        const double u = light_error ? e * (double)light_error->pixels[i] : 0;
        sum += y;
        squares += y * y - u * u;
    }
    if (!(sum > 0)) return (mcv_quantity){0, NAN};
    const double mean = sum / ((double)plane * light->channels),
                 level = squares / sum; /* by the mean, powers stay small */
    mcv_quantity of_squares =
        level_of_squares(light, light_error, shared, electrons_per_unit, mean);
    if (!light_error) of_squares.uncertainty = NAN;
    if (of_squares.value > 0 && (!light_error || of_squares.value > level)) return of_squares;
    if (!light_error) return (mcv_quantity){level, NAN};
    const double variance =
        variance_by_pixels(light, light_error, shared, electrons_per_unit, level);
    return (mcv_quantity){level, sqrt(variance) / sum};
}

/* --- the pixels --- */

/* Which channel of the light a pixel of a channel of the grey values reads, and with which colour's
 * sensitivity. */
typedef struct site {
    uint32_t channel, colour;
} site;

static site site_of(const mcv_camera *c, const mcv_image *light, uint32_t channel, size_t pixel) {
    uint32_t colour = light->channels == 1 || channel > 2 ? 0 : channel;
    if (c->bayer != MCV_BAYER_NONE) {
        const char letter =
            mcv_bayer_patterns[c->bayer][pixel / light->width % 2 * 2 + pixel % light->width % 2];
        colour = letter == 'R' ? 0 : letter == 'G' ? 1 : 2;
        channel = light->channels > colour ? colour : 0;
    }
    return (site){channel, colour};
}

/* The pixel's own offset [e-] and sensitivity; drawn apart from every exposure. */
static void draw_pattern(const mcv_camera *c, uint32_t channel, size_t pixel, double *offset,
                         double *sensitivity) {
    *offset = 0;
    *sensitivity = 1;
    if (c->noise_free || (c->dsnu == 0 && c->prnu == 0)) return;
    mcv_noise noise = mcv_noise_begin(c->specimen, channel, pixel);
    noise.key[1] = 1;
    *offset = c->dsnu * mcv_noise_normal(&noise);
    *sensitivity = fmax(0, 1 + c->prnu * mcv_noise_normal(&noise));
}

/* Electrons that are read from a pixel. */
static double collect(const mcv_camera *c, double mean, mcv_noise *noise) {
    /* Far above any full well the noise does not matter, and its doubles are no whole numbers any
     * more. */
    if (c->noise_free || mean > 0x1p50) return fmin(mean, c->full_well);
    return fmin(mcv_noise_poisson(noise, mean), c->full_well);
}

/* Standard uncertainty of a grey value as a measure of mu_e: noise, fixed pattern, rounding, and
 * the light's own error. */
static double uncertainty_of(const mcv_camera *c, double light_electrons, double error_electrons) {
    const double electrons = fmin(light_electrons + c->dark_electrons, c->full_well);
    const double temporal = electrons + c->read_noise * c->read_noise;
    const double spatial =
        c->dsnu * c->dsnu + pow(c->prnu * fmin(light_electrons, c->full_well), 2);
    const double own = c->noise_free ? 0 : temporal + spatial;
    return sqrt(c->gain * c->gain * (own + error_electrons * error_electrons) + 1.0 / 12);
}

/* Sums over a row. */
typedef struct tally {
    double electrons, brightest;
    uint64_t saturated, below_zero;
} tally;

static void expose_pixel(const mcv_camera *c, const mcv_image *light, const mcv_image *light_error,
                         uint32_t channel, size_t pixel, const mcv_exposure *exposure, tally *row) {
    const size_t plane = (size_t)light->width * light->height, to = channel * plane + pixel;
    const site s = site_of(c, light, channel, pixel);
    const size_t from = s.channel * plane + pixel;
    const double per_unit = c->electrons_per_unit[s.colour],
                 mean = per_unit * (double)light->pixels[from];
    const double largest = (double)((1u << c->bits) - 1);
    double offset, sensitivity;
    draw_pattern(c, channel, pixel, &offset, &sensitivity);
    mcv_noise noise = mcv_noise_begin(c->seed, channel, pixel);
    const double electrons = collect(c, sensitivity * mean + c->dark_electrons, &noise);
    const double dark =
        c->noise_free || c->read_noise == 0 ? 0 : c->read_noise * mcv_noise_normal(&noise);
    const double grey = floor(c->black_level + c->gain * (electrons + offset + dark) + 0.5);
    const double error = light_error ? per_unit * (double)light_error->pixels[from] : 0;
    exposure->grey.pixels[to] = (float)fmin(fmax(grey, 0), largest);
    exposure->uncertainty.pixels[to] = (float)uncertainty_of(c, mean, error);
    if (light_error)
        exposure->render.pixels[to] =
            electrons >= c->full_well || grey >= largest ? 0 : (float)(c->gain * error);
    row->electrons += mean;
    row->brightest = fmax(row->brightest, mean);
    row->saturated += electrons >= c->full_well || grey >= largest;
    row->below_zero += grey < 0;
}

/* What is done row by row, channel by channel. */
typedef struct readout {
    const mcv_camera *camera;
    const mcv_image *light, *light_error;
    mcv_exposure *exposure;
    tally *rows;
} readout;

static void expose_row(void *user, size_t row) {
    const readout *r = user;
    const uint32_t width = r->light->width, channel = (uint32_t)(row / r->light->height);
    const size_t first = row % r->light->height * width;
    for (size_t pixel = first; pixel < first + width; ++pixel)
        expose_pixel(r->camera, r->light, r->light_error, channel, pixel, r->exposure,
                     r->rows + row);
}

static mcv_result make_images(const mcv_image *light, uint32_t channels, bool error_known,
                              mcv_exposure *exposure, mcv_error *error) {
    mcv_image *images[] = {&exposure->grey, &exposure->uncertainty, &exposure->render};
    for (int i = 0; i < 2 + error_known; ++i)
        MCV_TRY(mcv_image_new(images[i], light->width, light->height, channels, error));
    return MCV_OK;
}

mcv_result mcv_camera_expose(const mcv_camera *camera, const mcv_image *light,
                             const mcv_image *light_error, mcv_exposure *exposure,
                             mcv_error *error) {
    *exposure = (mcv_exposure){0};
    MCV_TRY(check_camera(camera, error));
    MCV_TRY(mcv_camera_check_light(light, error));
    const uint32_t channels = camera->bayer == MCV_BAYER_NONE ? light->channels : 1;
    const size_t rows = (size_t)channels * light->height;
    readout r = {
        .camera = camera, .light = light, .light_error = light_error, .exposure = exposure};
    mcv_result result = make_images(light, channels, light_error, exposure, error);
    if (result == MCV_OK && !(r.rows = calloc(rows, sizeof *r.rows)))
        result = mcv_fail(error, MCV_FAILED, "no memory for %zu rows", rows);
    if (result != MCV_OK) {
        mcv_exposure_free(exposure);
        return result;
    }
    mcv_in_parallel(rows, expose_row, &r);
    for (size_t i = 0; i < rows; ++i) {
        exposure->electrons += r.rows[i].electrons / ((double)rows * light->width);
        exposure->brightest = fmax(exposure->brightest, r.rows[i].brightest);
        exposure->saturated += r.rows[i].saturated;
        exposure->below_zero += r.rows[i].below_zero;
    }
    free(r.rows);
    return MCV_OK;
}

void mcv_exposure_free(mcv_exposure *exposure) {
    mcv_image_free(&exposure->grey);
    mcv_image_free(&exposure->uncertainty);
    mcv_image_free(&exposure->render);
}
