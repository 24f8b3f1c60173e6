/* SPDX-License-Identifier: Apache-2.0 */
/*
 * How many light paths a render takes, if any: as many as make its error least for its time.
 *
 * An image is the sum of two independent estimates, of camera paths and of light paths, with
 * variances V_c and V_l for n of each and the times T_c and T_l that these take. With n / 2^k light
 * paths the time to an error goes as (V_c + 2^k V_l)(T_c + T_l / 2^k). Camera paths that light
 * paths take light from are other ones than those that find it by themselves: without light paths
 * the time goes as V T of these. A pilot measures the six numbers. The times are counted in rays:
 * the same seed then gives the same image everywhere.
 */
#include "render/renderer.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "device/light.h"
#include "film/film.h"

enum {
    PILOT_PIXELS = 4096, /* at most, spread over the image; as many light paths and more */
    FEWEST_PIXELS = 1024,
    PILOT_SHARE = 64,  /* 1 / share of each of the pilot's passes in the samples of the render */
    LEAST_SAMPLES = 8, /* of a render that a pilot is worth its time for, over all replicates */
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

/* The sum of all values. */
static double total(const mcv_film *film) {
    double sum = 0;
    for (size_t i = 0; i < mcv_film_values(film); ++i) sum += film->sums[i];
    return sum;
}

double mcv_missed_squares(double missed, double uncertain, double brightest) {
    return fmax(0, missed - uncertain) * brightest;
}

/* The largest radiance of an emitter that has light paths. */
static double brightest_emitter(const mcv_packed *packed) {
    double brightest = 0;
    for (uint32_t i = 0; i < packed->emitter_count; ++i)
        for (int k = 0; packed->emitters[i].light_inverse_pdf > 0 && k < 3; ++k)
            brightest = fmax(brightest, (double)packed->emitters[i].radiance[k]);
    return brightest;
}

static double traced_rays(const mcv_renderer *r) {
    return (double)(r->stats->rays + r->stats->shadow_rays);
}

/* What a pilot shows: of camera paths, of light paths, of camera paths without light paths. */
typedef struct pilot_look {
    double variance[3], rays[3];
    bool is_apart; /* the third is known */
} pilot_look;

/* A sample of the listed pixels for each replicate, in the film. */
static mcv_result trace_camera(mcv_renderer *r, double *rays, bool *stop) {
    const double begun = traced_rays(r);
    MCV_TRY(mcv_render_class(r, r->classes[0], 0, 1, INFINITY, stop));
    *rays = traced_rays(r) - begun;
    return MCV_OK;
}

/*
 * The same camera paths, where these find all light by themselves. The film holds what light paths
 * have brought, and with_light what camera paths have found beside them; both share the random
 * numbers, so that only what is found otherwise differs.
 */
static mcv_result trace_apart(mcv_renderer *r, const double *with_light, pilot_look *look,
                              bool *stop) {
    mcv_film *film = r->film;
    const uint32_t thinning = r->frame.log2_thinning;
    const double share = (double)film->replicates / (film->replicates - 1), light = total(film);
    memset(film->sums, 0, 8 * mcv_film_values(film));
    mcv_frame_thin_light(&r->frame, MCV_NO_LIGHT_PATHS);
    const mcv_result result = trace_camera(r, &look->rays[2], stop);
    mcv_frame_thin_light(&r->frame, thinning);
    if (result != MCV_OK || *stop) return result;
    look->variance[2] = variance(film);
    for (size_t i = 0; i < mcv_film_values(film); ++i) film->sums[i] -= with_light[i];
    look->variance[2] +=
        mcv_missed_squares(light - total(film), sqrt(share * (look->variance[1] + variance(film))),
                           brightest_emitter(&r->scene.packed));
    look->is_apart = true;
    return MCV_OK;
}

/* The pixels of a pilot, at most. */
static uint64_t pilot_pixels(const mcv_renderer *r, uint64_t all) {
    const double samples = r->options->last > 0
                               ? (double)r->options->last * r->options->replicates * (double)all
                               : INFINITY,
                 fitting = samples / (PILOT_SHARE * MCV_LIGHT_REPLICATES);
    return fitting < PILOT_PIXELS ? (uint64_t)fmax(FEWEST_PIXELS, fitting) : PILOT_PIXELS;
}

/* A sample for each replicate of some pixels, and the light paths of as many pixels. r->film is the
 * pilot's, splats and with_light have room for its values. */
static mcv_result trace_pilot(mcv_renderer *r, uint64_t *splats, double *with_light,
                              pilot_look *look, bool *stop) {
    const mcv_film *film = r->film;
    const uint64_t all = mcv_tiled_pixels(film->width, film->height), most = pilot_pixels(r, all);
    const size_t values = mcv_film_values(film);
    MCV_TRY(mcv_list_pixels(r, (uint32_t)((all + most - 1) / most)));
    MCV_TRY(trace_camera(r, &look->rays[0], stop));
    if (*stop) return MCV_OK;
    const double begun = traced_rays(r);
    MCV_TRY(mcv_render_light(r, r->classes[0].count, 0, 1));
    look->rays[1] = traced_rays(r) - begun;
    MCV_TRY(mcv_cl_read(&r->cl, r->scene.splats, 0, 8 * values, splats, r->error));
    look->variance[0] = variance(film);
    for (size_t i = 0; i < values; ++i) {
        with_light[i] = film->sums[i];
        film->sums[i] = mcv_frame_splat_value(&r->frame) * (double)splats[i];
    }
    look->variance[1] = variance(film);
    return mcv_camera_finds_light(&r->scene.packed) ? trace_apart(r, with_light, look, stop)
                                                    : MCV_OK;
}

/* The same on a film of its own, with other random numbers than the image's. */
static mcv_result render_pilot(mcv_renderer *r, pilot_look *look, bool *stop) {
    mcv_film *image = r->film, pilot;
    double *round = r->round;
    MCV_TRY(mcv_film_new(&pilot, image->width, image->height, image->channels, MCV_LIGHT_REPLICATES,
                         r->error));
    const size_t bytes = 8 * mcv_film_values(&pilot);
    uint64_t *splats = malloc(bytes);
    double *with_light = calloc(1, bytes);
    mcv_result result = MCV_OK;
    if (!splats || !with_light)
        result = mcv_fail(r->error, MCV_FAILED, "no memory for the pilot's light paths");
    r->film = &pilot;
    r->round = pilot.sums;
    r->frame.replicates = pilot.replicates;
    r->frame.seed = r->options->seed ^ MCV_PILOT_SEED;
    if (result == MCV_OK) result = trace_pilot(r, splats, with_light, look, stop);
    r->film = image;
    r->round = round;
    r->frame.replicates = image->replicates;
    r->frame.seed = r->options->seed;
    mcv_unlist_pixels(r);
    mcv_film_free(&pilot);
    free(splats);
    free(with_light);
    MCV_TRY(result);
    return mcv_cl_clear(&r->cl, r->scene.splats, bytes, r->error);
}

void mcv_count_light_paths(mcv_renderer *r) {
    r->stats->light_paths =
        r->scene.splats && r->frame.light_density > 0 ? exp2(-(double)r->frame.log2_thinning) : 0;
}

/* Decides by what the pilot has shown. */
static void decide(mcv_renderer *r, const pilot_look *look) {
    const uint32_t begun = r->frame.log2_thinning;
    const double *v = look->variance, camera = look->rays[0], light = LIGHT_RAY * look->rays[1];
    uint32_t best = mcv_best_thinning(v[0], v[1], camera, light, begun);
    const double thinner = exp2((double)best - begun),
                 with = (v[0] + v[1] * thinner) * (camera + light / thinner),
                 without = v[2] * look->rays[2];
    if (look->is_apart && with > WORTH * without) best = MCV_NO_LIGHT_PATHS;
    mcv_frame_thin_light(&r->frame, best);
    r->film->splat_value = mcv_frame_splat_value(&r->frame);
    r->stats->light_ratio = look->is_apart && with > 0 ? without / with : 0;
}

mcv_result mcv_allocate_light(mcv_renderer *r) {
    const mcv_render_options *o = r->options;
    const uint64_t samples = o->last * r->film->replicates;
    pilot_look look = {{0}, {0}, false};
    bool stop = false;
    mcv_count_light_paths(r);
    if (!o->light_pilot || !r->scene.splats || (o->last > 0 && samples < LEAST_SAMPLES))
        return MCV_OK;
    MCV_TRY(render_pilot(r, &look, &stop));
    /* A render that is stopped now still brings its first round. */
    if (stop) return MCV_OK;
    decide(r, &look);
    mcv_count_light_paths(r);
    return MCV_OK;
}
