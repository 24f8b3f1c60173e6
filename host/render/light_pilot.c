/* SPDX-License-Identifier: Apache-2.0 */
/*
 * How many light paths a render takes: as many as make its error least for its time.
 *
 * An image is the sum of two independent estimates, of camera paths and of light paths, with
 * variances V_c and V_l for n of each and the times T_c and T_l that these take. With n / 2^k light
 * paths the time to an error goes as (V_c + 2^k V_l)(T_c + T_l / 2^k). A pilot measures the four
 * numbers. The times are counted in rays: the same seed then gives the same image everywhere.
 */
#include "render/renderer.h"

#include <math.h>
#include <stdlib.h>

#include "device/light.h"
#include "film/film.h"

enum {
    PILOT_PIXELS = 4096, /* at most, spread over the image; as many light paths and more */
    LEAST_SAMPLES = 8,   /* of a render that a pilot is worth its time for, over all replicates */
};

/* The time of a ray of light paths over that of one of camera paths. PoCL, six scenes: 1.6 to 2.1
 * where light paths lie in rows, 3.0 to 3.8 where they are traced one by one. */
static const double LIGHT_RAY = 2.5;

/* Fewer or more light paths must bring an error in so many times less time: what a pilot measures
 * is not exact. */
static const double WORTH = 1.1;

/* The variance that the replicates' sums show, summed over pixels and channels. */
static double variance(const mcv_film *film) {
    const size_t values = (size_t)film->width * film->height * film->channels;
    double sum = 0;
    for (size_t i = 0; i < values; ++i) {
        double mean = 0, squares = 0;
        for (uint32_t replicate = 0; replicate < film->replicates; ++replicate) {
            const double x = film->sums[replicate * values + i], apart = x - mean;
            mean += apart / (replicate + 1);
            squares += apart * (x - mean);
        }
        sum += squares;
    }
    return sum;
}

uint32_t mcv_best_thinning(double camera_variance, double light_variance, double camera_time,
                           double light_time, uint32_t begun) {
    const double now = (camera_variance + light_variance) * (camera_time + light_time);
    double gain = WORTH;
    uint32_t best = begun;
    for (uint32_t k = 0; k <= MCV_MOST_THINNING; ++k) {
        const double thinner = exp2((double)k - begun);
        const double then =
            (camera_variance + light_variance * thinner) * (camera_time + light_time / thinner);
        if (!(now > gain * then)) continue;
        gain = now / then;
        best = k;
    }
    return best;
}

static double traced_rays(const mcv_renderer *r) {
    return (double)(r->stats->rays + r->stats->shadow_rays);
}

/* What a pilot shows: of camera paths, then of light paths. */
typedef struct pilot_look {
    double variance[2], rays[2];
} pilot_look;

/* A sample for each replicate of some pixels, and the light paths of as many pixels. r->film is the
 * pilot's. */
static mcv_result trace_pilot(mcv_renderer *r, uint64_t *splats, pilot_look *look, bool *stop) {
    const mcv_film *film = r->film;
    const uint64_t all = mcv_tiled_pixels(film->width, film->height);
    const double begun = traced_rays(r);
    MCV_TRY(mcv_list_pixels(r, (uint32_t)((all + PILOT_PIXELS - 1) / PILOT_PIXELS)));
    const uint64_t pixels = r->classes[0].count;
    MCV_TRY(mcv_render_class(r, r->classes[0], 0, 1, INFINITY, stop));
    if (*stop) return MCV_OK;
    look->rays[0] = traced_rays(r) - begun;
    MCV_TRY(mcv_render_light(r, pixels, 0, 1));
    look->rays[1] = traced_rays(r) - begun - look->rays[0];
    MCV_TRY(mcv_cl_read(&r->cl, r->scene.splats, 0, 8 * mcv_film_values(film), splats, r->error));
    look->variance[0] = variance(film);
    for (size_t i = 0; i < mcv_film_values(film); ++i)
        film->sums[i] = mcv_frame_splat_value(&r->frame) * (double)splats[i];
    look->variance[1] = variance(film);
    return MCV_OK;
}

/* The same on a film of its own, with other random numbers than the image's. */
static mcv_result render_pilot(mcv_renderer *r, pilot_look *look, bool *stop) {
    mcv_film *image = r->film, pilot;
    double *round = r->round;
    MCV_TRY(mcv_film_new(&pilot, image->width, image->height, image->channels, MCV_LIGHT_REPLICATES,
                         r->error));
    const size_t bytes = 8 * mcv_film_values(&pilot);
    uint64_t *splats = malloc(bytes);
    if (!splats) {
        mcv_film_free(&pilot);
        return mcv_fail(r->error, MCV_FAILED, "no memory for the pilot's light paths");
    }
    r->film = &pilot;
    r->round = pilot.sums;
    r->frame.replicates = pilot.replicates;
    r->frame.seed = r->options->seed ^ MCV_PILOT_SEED;
    const mcv_result result = trace_pilot(r, splats, look, stop);
    r->film = image;
    r->round = round;
    r->frame.replicates = image->replicates;
    r->frame.seed = r->options->seed;
    mcv_unlist_pixels(r);
    mcv_film_free(&pilot);
    free(splats);
    MCV_TRY(result);
    return mcv_cl_clear(&r->cl, r->scene.splats, bytes, r->error);
}

mcv_result mcv_allocate_light(mcv_renderer *r) {
    const mcv_render_options *o = r->options;
    const uint64_t samples = o->last * r->film->replicates;
    pilot_look look = {{0}, {0}};
    bool stop = false;
    if (!o->light_pilot || !r->scene.splats || (o->last > 0 && samples < LEAST_SAMPLES))
        return MCV_OK;
    MCV_TRY(render_pilot(r, &look, &stop));
    /* A render that is stopped now still brings its first round. */
    if (stop) return MCV_OK;
    mcv_frame_thin_light(&r->frame,
                         mcv_best_thinning(look.variance[0], look.variance[1], look.rays[0],
                                           LIGHT_RAY * look.rays[1], r->frame.log2_thinning));
    r->film->splat_value = mcv_frame_splat_value(&r->frame);
    return MCV_OK;
}
