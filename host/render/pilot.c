/* SPDX-License-Identifier: Apache-2.0 */
/* Adaptive sampling: a pilot render decides how many samples each pixel takes. */
#include "render/renderer.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/basics.h"

enum {
    PILOT_SHARE = 32,     /* 1 / share of the pilot in the samples of the render */
    LEAST_PILOT = 4,      /* samples per pixel, over all of its replicates */
    MOST_PILOT = 1024,    /* more would improve the decision little */
    PILOT_REPLICATES = 8, /* at most */
    WORTH_A_PILOT = 64,   /* samples per pixel, over all replicates */
};

/* Combined with the user's seed for the render after a pilot. */
static const uint32_t ADAPTIVE_SEED = 0x2545f491u;

/* The exponent with which the variance falls with the samples; it is 1 with random numbers. */
static const double SOBOL_FALL = 1.25;

/* Adaptive sampling is used if it needs less than this share of the samples of a uniform render, by
 * MCV_ADAPTIVE_…. A pilot does not know how long samples take. In the scenes of
 * docs/adaptive-sampling.md that gain least those of noisy pixels take up to 1.2 times as long;
 * those that take up to 1.5 times as long gain twice that. */
static const double WORTH[] = {
    [MCV_ADAPTIVE_OFF] = 0, [MCV_ADAPTIVE_ON] = 0.9, [MCV_ADAPTIVE_AUTO] = 0.75};

static double fall_of(const mcv_render_options *o) {
    return o->sampler == MCV_SAMPLER_RANDOM ? 1 : SOBOL_FALL;
}

/* The expected samples per replicate of the whole render, extrapolated from its error so far;
 * infinite if this is not possible. */
static double expected_samples(const mcv_renderer *r, double error) {
    const mcv_render_options *o = r->options;
    const double samples = (double)r->film->samples;
    double expected = o->last > 0 ? (double)o->last : INFINITY;
    if (o->error > 0)
        expected = fmin(expected, samples * pow(fmax(error / o->error, 1), 2 / fall_of(o)));
    if (o->seconds > 0)
        expected = fmin(expected, samples * o->seconds / (mcv_seconds() - r->begun));
    return expected;
}

mcv_result mcv_upload_list(mcv_renderer *r, size_t count) {
    r->frame.listed = 1;
    mcv_cl_release(&r->scene.listed);
    return mcv_cl_buffer(&r->cl, "the list of pixels", count * sizeof *r->listed, r->listed,
                         &r->scene.listed, r->error);
}

/* Whether the block is one of one in `stride`. Multiples of the golden ratio have even remainders;
 * every stride-th block would be a column of the image where stride divides its blocks. */
static bool is_spread(uint32_t block, uint32_t stride) {
    return block * 0x9e3779b9u <= UINT32_MAX / stride;
}

mcv_result mcv_list_pixels(mcv_renderer *r, uint32_t stride) {
    const mcv_film *film = r->film;
    const size_t count = (size_t)film->width * film->height;
    const uint32_t numbers = (uint32_t)mcv_tiled_pixels(film->width, film->height);
    uint32_t listed = 0;
    if (!r->listed) r->listed = malloc(count * sizeof *r->listed);
    if (!r->listed)
        return mcv_fail(r->error, MCV_FAILED, "no memory for a list of %zu pixels", count);
    r->class_count = 0;
    for (int level = MCV_LOWEST_LEVEL; level <= MCV_HIGHEST_LEVEL; ++level) {
        const uint32_t first = listed;
        for (uint32_t i = 0; i < numbers; ++i) {
            size_t pixel;
            if (is_spread(i >> 6, stride) && mcv_find_blocked_pixel(film, i, &pixel) &&
                (film->levels ? film->levels[pixel] : 0) == level)
                r->listed[listed++] = (uint32_t)pixel;
        }
        if (listed > first)
            r->classes[r->class_count++] = (mcv_pixel_class){level, first, listed - first};
    }
    return mcv_upload_list(r, count);
}

void mcv_unlist_pixels(mcv_renderer *r) {
    free(r->listed);
    r->listed = NULL;
    r->frame.listed = 0;
    r->class_count = 1;
    r->classes[0] =
        (mcv_pixel_class){0, 0, (uint32_t)mcv_tiled_pixels(r->film->width, r->film->height)};
}

mcv_result mcv_begin_levels(mcv_renderer *r) {
    r->frame.seed = r->options->seed ^ ADAPTIVE_SEED;
    return mcv_list_pixels(r, 1);
}

/* Empties the film, for a render with other random numbers. */
static mcv_result begin_anew(mcv_renderer *r) {
    /* end_round has taken what the devices hold. */
    if (r->splats) memset(r->splats, 0, 8 * mcv_film_values(r->film));
    r->film->samples = 0;
    return mcv_begin_levels(r);
}

/* Renders a pilot of camera paths alone with `samples` per pixel (a power of two), in as many
 * replicates as possible. Its samples do not enter the image. */
static mcv_result render_pilot(mcv_renderer *r, uint32_t samples, mcv_film *pilot, bool *stop) {
    mcv_film *film = r->film;
    double *round = r->round;
    const uint32_t replicates = samples < PILOT_REPLICATES ? samples : PILOT_REPLICATES;
    MCV_TRY(mcv_film_new(pilot, film->width, film->height, film->channels, replicates, r->error));
    r->film = pilot;
    r->round = pilot->sums;
    r->frame.replicates = replicates;
    r->frame.seed = r->options->seed ^ MCV_PILOT_SEED;
    mcv_result result = mcv_list_pixels(r, 1);
    if (result == MCV_OK)
        result = mcv_render_class(r, r->classes[0], 0, samples / replicates, INFINITY, stop);
    r->film = film;
    r->round = round;
    r->frame.replicates = film->replicates;
    r->frame.seed = r->options->seed;
    mcv_unlist_pixels(r);
    return result;
}

/* The samples per pixel, over all replicates, of a pilot that pays now; 0: none. */
static uint32_t worthy_pilot(const mcv_renderer *r, double expected) {
    const double all = expected * r->film->replicates,
                 begun = (double)r->film->samples * r->film->replicates;
    if (all < WORTH_A_PILOT || expected < MCV_FIRST_ADAPTIVE) return 0;
    uint32_t samples = LEAST_PILOT;
    while (samples < MOST_PILOT && 2 * PILOT_SHARE * samples <= all) samples *= 2;
    return begun + samples < all / 4 ? samples : 0;
}

mcv_result mcv_adapt(mcv_renderer *r, double error) {
    mcv_film *film = r->film;
    const mcv_render_options *o = r->options;
    const bool is_known =
        film->samples >= MCV_MIN_SAMPLES || !(o->error > 0 || o->seconds > 0 || o->last == 0);
    double expected = is_known ? expected_samples(r, error) : 0;
    if (!isfinite(expected)) expected = (double)PILOT_SHARE * (double)film->samples;
    const uint32_t samples = worthy_pilot(r, expected);
    mcv_film pilot = {0};
    bool stop = false;
    double gain = 0;
    if (samples == 0) return MCV_OK;
    r->decided = true;
    film->levels = malloc((size_t)film->width * film->height);
    if (!film->levels) return mcv_fail(r->error, MCV_FAILED, "no memory for the levels of pixels");
    mcv_result result = render_pilot(r, samples, &pilot, &stop);
    const double begun = (double)film->samples + (double)samples / film->replicates;
    const double budget = o->last > 0 ? 1 - begun / (double)o->last : 1;
    if (result == MCV_OK)
        result = mcv_allocate_samples(&pilot, fall_of(o), budget, film->levels, &gain, r->error);
    mcv_film_free(&pilot);
    MCV_TRY(result);
    if (!r->stats->interrupted && gain > 0 &&
        begun + expected / gain < WORTH[o->adaptive] * expected)
        return begin_anew(r);
    free(film->levels);
    film->levels = NULL;
    return MCV_OK;
}
