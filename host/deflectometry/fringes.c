/* SPDX-License-Identifier: Apache-2.0 */
#include "deflectometry/fringes.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "analysis/noise.h"
#include "core/parallel.h"

/* The images of a plan: N of P periods, then N of P - 1 or two for each bit of the Gray code. */
typedef struct sequence {
    const mcv_matrix *matrix;
    const mcv_fringe_plan *plan;
    uint32_t first, images, bits;
    double *shown; /* [image][pixel of the screen] */
    double *room;  /* for each row of the camera's image: [image][mean, replicates], [step] */
    mcv_decoded *decoded;
} sequence;

static size_t room_of(const sequence *s) {
    return (size_t)s->images * (s->matrix->replicates + 1) + s->plan->steps;
}

static double half_period_bit(const mcv_fringe_plan *p, uint32_t bits, uint32_t bit, uint32_t at) {
    const uint32_t half = (uint32_t)(2 * p->periods * (at + 0.5) / p->length),
                   gray = half ^ (half >> 1);
    return gray >> (bits - 1 - bit) & 1;
}

static double fringe(const mcv_fringe_plan *p, double periods, uint32_t step, uint32_t at) {
    return 0.5 + 0.5 * cos(2 * M_PI * (periods * (at + 0.5) / p->length - (double)step / p->steps));
}

static double value_of(const sequence *s, uint32_t image, uint32_t at) {
    const mcv_fringe_plan *p = s->plan;
    const uint32_t step = image % p->steps, bit = image - p->steps;
    if (image < p->steps) return fringe(p, p->periods, step, at);
    if (p->unwrap == MCV_UNWRAP_HETERODYNE) return fringe(p, p->periods - 1, step, at);
    const double lit = half_period_bit(p, s->bits, bit / 2, at);
    return bit % 2 ? 1 - lit : lit;
}

static mcv_result make_sequence(sequence *s, mcv_error *error) {
    const mcv_fringe_plan *p = s->plan;
    s->bits = 1;
    while (2 * p->periods > (double)(1u << s->bits)) ++s->bits;
    s->images = p->steps + (p->unwrap == MCV_UNWRAP_HETERODYNE ? p->steps : 2 * s->bits);
    s->shown = malloc(((size_t)s->images * p->length + 1) * sizeof *s->shown);
    s->room = malloc((s->matrix->height * room_of(s) + 1) * sizeof *s->room);
    if (!s->shown || !s->room)
        return mcv_fail(error, MCV_FAILED, "no memory for %u fringe images", s->images);
    for (uint32_t k = 0; k < s->images; ++k)
        for (uint32_t at = 0; at < p->length; ++at)
            s->shown[(size_t)k * p->length + at] = pow(value_of(s, k, at), p->gamma);
    return MCV_OK;
}

/* What the camera sees of one image, over all channels: the mean over the replicates in values[0],
 * then each replicate. `stride` values further on is the next image. */
static void see(const sequence *s, size_t pixel, double *values, uint32_t stride) {
    const mcv_matrix *m = s->matrix;
    const uint32_t length = s->plan->length;
    memset(values, 0, (size_t)s->images * stride * sizeof *values);
    for (uint64_t i = m->row_begins[pixel * m->channels];
         i < m->row_begins[(pixel + 1) * m->channels]; ++i) {
        const uint32_t element = m->columns[i] - s->first;
        const bool screen = m->columns[i] >= s->first && element < length;
        for (uint32_t k = 0; k < s->images; ++k) {
            const double shown = screen ? s->shown[(size_t)k * length + element] : 1;
            values[k * stride] += shown * m->values[i];
            for (uint32_t r = 0; r < m->replicates; ++r)
                values[k * stride + 1 + r] +=
                    shown * (double)m->replicates_of[i * m->replicates + r];
        }
    }
    mcv_noise noise = mcv_noise_begin(s->plan->seed, s->plan->direction, pixel);
    for (uint32_t k = 0; k < s->images && s->plan->noise > 0; ++k)
        values[k * stride] += s->plan->noise * mcv_noise_normal(&noise);
}

/* The half period that the bits tell: a pixel is lit where it is brighter than in the inverse. */
static uint32_t read_bits(const sequence *s, const double *values, uint32_t stride) {
    uint32_t gray = 0, half = 0;
    for (uint32_t b = 0; b < s->bits; ++b) {
        const double *of = values + (size_t)(s->plan->steps + 2 * b) * stride;
        gray = gray << 1 | (of[0] > of[stride]);
    }
    for (; gray; gray >>= 1) half ^= gray;
    return half;
}

/* The phase of a set of N images; `which`: 0 the mean, r + 1 a replicate. */
static mcv_fringe decode_set(const sequence *s, const double *values, uint32_t stride,
                             uint32_t which, uint32_t first_image, double *work) {
    for (uint32_t k = 0; k < s->plan->steps; ++k)
        work[k] = values[(size_t)(first_image + k) * stride + which];
    return mcv_fringe_decode(work, s->plan->steps);
}

/* The uncertainty of the phase that the spread of the replicates about it gives [rad]. */
static double render_deviation(const sequence *s, const double *values, uint32_t stride,
                               double *work) {
    double phases[MCV_MAX_REPLICATES];
    const double phase = decode_set(s, values, stride, 1, 0, work).phase;
    for (uint32_t r = 0; r < s->matrix->replicates; ++r)
        phases[r] =
            remainder(decode_set(s, values, stride, 1 + r, 0, work).phase - phase, 2 * M_PI);
    const double variance = mcv_estimate_replicates(phases, s->matrix->replicates).variance;
    return variance > 0 ? sqrt(variance) : 0;
}

static void decode_pixel(const sequence *s, size_t pixel, double *values, uint32_t stride,
                         double *work) {
    const mcv_fringe_plan *p = s->plan;
    mcv_decoded *d = s->decoded + pixel;
    see(s, pixel, values, stride);
    const mcv_fringe fine = decode_set(s, values, stride, 0, 0, work);
    const double render = render_deviation(s, values, stride, work);
    d->modulation = fine.modulation;
    d->contrast = fine.mean > 0 ? fine.modulation / fine.mean : 0;
    d->phase_noise = mcv_fringe_deviation(p->steps, p->noise, fine.modulation);
    const double deviation = hypot(render, d->phase_noise),
                 periods_to_pixels = p->length / p->periods;
    d->place = d->deviation = NAN;
    /* Nothing is decoded where the phase is unknown by a radian. */
    if (!(fine.modulation > 0) || !(deviation < 1)) return;
    const double place =
        p->unwrap == MCV_UNWRAP_HETERODYNE
            ? mcv_unwrap_heterodyne(
                  fine.phase, decode_set(s, values, stride, 0, p->steps, work).phase, p->periods)
            : mcv_unwrap_gray(fine.phase, read_bits(s, values, stride), p->periods);
    d->place = place * periods_to_pixels;
    d->deviation = deviation / (2 * M_PI) * periods_to_pixels;
}

static void decode_row(void *user, size_t row) {
    const sequence *s = user;
    const uint32_t stride = s->matrix->replicates + 1;
    double *values = s->room + row * room_of(s);
    for (size_t x = 0; x < s->matrix->width; ++x)
        decode_pixel(s, row * s->matrix->width + x, values, stride,
                     values + (size_t)s->images * stride);
}

mcv_result mcv_fringes_decode(const mcv_matrix *matrix, uint32_t first, const mcv_fringe_plan *plan,
                              mcv_decoded *decoded, mcv_error *error) {
    sequence s = {.matrix = matrix, .plan = plan, .first = first, .decoded = decoded};
    const mcv_result result = make_sequence(&s, error);
    if (result == MCV_OK) mcv_in_parallel(matrix->height, decode_row, &s);
    free(s.shown);
    free(s.room);
    return result;
}

/* --- the best period --- */

/* The sum of a pixel's light times exp(i angle) of the places on the screen, by each replicate. */
typedef struct spectrum {
    double c[MCV_MAX_REPLICATES], s[MCV_MAX_REPLICATES], sum;
} spectrum;

static spectrum spectrum_of(const mcv_matrix *m, uint32_t first, uint32_t length, size_t pixel,
                            double period) {
    spectrum f = {.sum = 0};
    for (uint64_t i = m->row_begins[pixel * m->channels];
         i < m->row_begins[(pixel + 1) * m->channels]; ++i) {
        if (m->columns[i] < first || m->columns[i] - first >= length) continue;
        const double angle = 2 * M_PI * (m->columns[i] - first + 0.5) / period;
        const float *of = m->replicates_of + i * m->replicates;
        for (uint32_t r = 0; r < m->replicates; ++r) {
            f.c[r] += (double)of[r] * cos(angle);
            f.s[r] += (double)of[r] * sin(angle);
        }
        f.sum += m->values[i];
    }
    return f;
}

/* |mean of F_r|² over the squared light, from products of different replicates: the noise of a
 * replicate has no part in it. */
static double squared_contrast(const spectrum *f, uint32_t replicates) {
    double c = 0, s = 0, own = 0;
    for (uint32_t r = 0; r < replicates; ++r) {
        c += f->c[r];
        s += f->s[r];
        own += f->c[r] * f->c[r] + f->s[r] * f->s[r];
    }
    const double pairs = (double)replicates * (replicates > 1 ? replicates - 1 : 1);
    return (c * c + s * s - (replicates > 1 ? own : 0)) / (pairs * f->sum * f->sum);
}

enum { MOST_LOOKED_AT = 1024, LADDER = 64 };

/* The pixels that are looked at. */
typedef struct looked_at {
    const mcv_matrix *matrix;
    uint32_t first, length, count;
    size_t pixels[MOST_LOOKED_AT];
} looked_at;

/* The root of the mean squared contrast of the pixels; 0 where it is nothing but noise. */
static double mean_contrast(const looked_at *l, double period) {
    double sum = 0;
    for (uint32_t i = 0; i < l->count; ++i) {
        const spectrum f = spectrum_of(l->matrix, l->first, l->length, l->pixels[i], period);
        sum += squared_contrast(&f, l->matrix->replicates);
    }
    return sum > 0 ? sqrt(sum / l->count) : 0;
}

/* What the uncertainty of slopes is proportional to; infinite without contrast. */
static double cost_of(const looked_at *l, double period) {
    return period / mean_contrast(l, period);
}

double mcv_best_period(const mcv_matrix *matrix, uint32_t first, uint32_t length, const bool *valid,
                       double *contrast) {
    const size_t pixels = (size_t)matrix->width * matrix->height;
    looked_at l = {.matrix = matrix, .first = first, .length = length};
    size_t all = 0, seen = 0;
    for (size_t i = 0; i < pixels; ++i) all += valid[i];
    const size_t spread = all > MOST_LOOKED_AT ? all : MOST_LOOKED_AT;
    for (size_t i = 0; i < pixels && l.count < MOST_LOOKED_AT; ++i)
        if (valid[i] && seen++ * MOST_LOOKED_AT / spread >= l.count) l.pixels[l.count++] = i;
    *contrast = 0;
    if (l.count == 0) return 0;
    /* From 8 pixels, below which the steps of pixels bend the phase, to the whole screen. */
    const double shortest = fmin(8, length), ratio = pow(length / shortest, 1.0 / LADDER),
                 golden = (sqrt(5) - 1) / 2;
    double costs[LADDER + 1], least = INFINITY;
    for (int k = 0; k <= LADDER; ++k) {
        costs[k] = cost_of(&l, shortest * pow(ratio, k));
        least = fmin(least, costs[k]);
    }
    if (!isfinite(least)) return 0;
    /* The side lobes of a pixel that sees an even stretch are as good as the main one, but tell
     * wrong places where stretches differ: of minima that are as good, the longest period. */
    int at = LADDER;
    while (!(costs[at] <= 1.1 * least)) --at;
    while (at > 0 && costs[at - 1] < costs[at]) --at;
    double low = shortest * pow(ratio, at > 0 ? at - 1 : 0), high = shortest * pow(ratio, at + 1);
    for (int k = 0; k < 30; ++k) {
        const double a = high - golden * (high - low), b = low + golden * (high - low);
        if (cost_of(&l, a) < cost_of(&l, b))
            high = b;
        else
            low = a;
    }
    *contrast = mean_contrast(&l, (low + high) / 2);
    return (low + high) / 2;
}
