/* SPDX-License-Identifier: Apache-2.0 */
#include "render/render.h"
#include "device/features.h"

#include <math.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "core/basics.h"
#include "film/film.h"
#include "render/renderer.h"
#include "scene/sensors.h"
#include "scene/spectra.h"

mcv_render_options mcv_render_defaults(void) {
    return (mcv_render_options){
        .sampler = MCV_SAMPLER_SOBOL, .replicates = 4, .depth = 32, .schedule = MCV_SCHEDULE_AUTO};
}

enum { MIN_SAMPLES_BLACK = 256 }; /* MCV_MIN_SAMPLES of an image that is black so far */

/* Opens a schedule for the scene: the current one, the earlier one, or a new one. */
static mcv_result open_schedule(mcv_renderer *r, uint32_t sensor_type) {
    const mcv_render_options *o = r->options;
    const mcv_program_key key = {r->scene.packed.features,
                                 r->scene.packed.channels,
                                 sensor_type,
                                 o->sampler,
                                 o->schedule,
                                 o->slice,
                                 o->depth};
    for (int tries = 0; tries < 2; ++tries) {
        r->stats->kept_program = r->schedule.program && memcmp(&r->key, &key, sizeof key) == 0;
        if (r->stats->kept_program) return MCV_OK;
        const mcv_schedule schedule = r->schedule;
        const mcv_program_key other = r->key;
        r->schedule = r->earlier;
        r->key = r->earlier_key;
        r->earlier = schedule;
        r->earlier_key = other;
    }
    /* Both belong to other scenes: the current one becomes the earlier one. */
    mcv_schedule_close(&r->earlier);
    r->earlier = r->schedule;
    r->earlier_key = r->key;
    r->key = key;
    const mcv_result result =
        mcv_schedule_open(&r->cl, &r->scene, sensor_type, o, &r->schedule, r->error);
    if (result != MCV_OK) mcv_schedule_close(&r->schedule);
    return result;
}

/* Seconds of the processor in which a program comes from a cache: 0.06 to 0.09 in six scenes, where
 * compiling takes 0.7 or more. No load of the machine changes them. */
static const double FROM_CACHE = 0.25;

static double processor_seconds(void) {
    struct timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* Opens a schedule and tells when it compiles, and when it need not any more: the kernels of a
 * program that is cached are, too. */
static mcv_result prepare_program(mcv_renderer *r, uint32_t sensor_type) {
    const mcv_render_options *o = r->options;
    const double compile = mcv_seconds(), begun = processor_seconds();
    if (o->progress) o->progress(o->user, (double)NAN, compile - r->begun, INFINITY);
    MCV_TRY(open_schedule(r, sensor_type));
    r->stats->seconds_compile = mcv_seconds() - compile;
    if (o->cached && processor_seconds() - begun < FROM_CACHE) o->cached(o->user);
    return MCV_OK;
}

/* kept: the previous scene, or NULL. */
static mcv_result open_scene(mcv_renderer *r, const mcv_scene *scene, uint32_t sensor,
                             mcv_device_scene *kept) {
    const double start = mcv_seconds();
    MCV_TRY(mcv_device_scene_begin(&r->cl, scene, r->options->threads, kept, &r->scene, r->error));
    if (r->options->precision == MCV_PRECISION_MIXED)
        MCV_TRY(mcv_device_scene_refine(&r->cl, scene, &r->scene, r->error));
    r->stats->kept_structure = r->scene.kept_structure || r->scene.updated_structure;
    mcv_packed *packed = &r->scene.packed;
    const mcv_feature_options choices = {.mixed = r->options->precision == MCV_PRECISION_MIXED,
                                         .no_light_paths = r->options->no_light_paths,
                                         .records = r->options->records,
                                         .no_split = r->options->no_split};
    packed->features = mcv_decide_features(scene, packed, &scene->sensors[sensor], choices, NULL);
    if (packed->features & MCV_FEATURE_BIT(MOVING) && packed->features & MCV_FEATURE_BIT(MIXED))
        return mcv_fail(r->error, MCV_USAGE,
                        "%s has parts that move, whose places are known in single precision: "
                        "give --precision single, or double for the reference renderer",
                        scene->path);
    mcv_feature_names(packed->features, r->stats->features, sizeof r->stats->features);

    MCV_TRY(prepare_program(r, scene->sensors[sensor].type));
    MCV_TRY(mcv_device_scene_finish(&r->cl, kept, &r->scene, r->error));
    r->stats->seconds_build = mcv_seconds() - start - r->stats->seconds_compile;

    r->frame = (mcv_frame){.width = r->film->width,
                           .height = r->film->height,
                           .replicates = r->film->replicates,
                           .seed = r->options->seed,
                           .depth = r->options->depth};
    MCV_TRY(mcv_device_scene_place(&r->cl, scene, sensor, &r->scene, &r->frame, r->error));
    return mcv_schedule_guide(&r->schedule, &r->frame, r->stats, r->error);
}

mcv_result mcv_open_scene(mcv_renderer *r, const mcv_scene *scene, uint32_t sensor) {
    mcv_device_scene kept = r->scene;
    memset(&r->scene, 0, sizeof r->scene);
    const mcv_result result = open_scene(r, scene, sensor, kept.nodes ? &kept : NULL);
    mcv_device_scene_close(&kept);
    if (result != MCV_OK)
        mcv_device_scene_close(&r->scene); /* an incomplete scene must not be reused */
    return result;
}

void mcv_close_device(mcv_renderer *r) {
    mcv_schedule_close(&r->schedule);
    mcv_schedule_close(&r->earlier);
    mcv_device_scene_close(&r->scene);
    mcv_cl_close(&r->cl);
}

static void close_renderer(mcv_renderer *r) {
    mcv_close_device(r);
    mcv_close_others(r);
}

/*
 * The samples of the first round. If the number of samples alone ends the render, and one launch
 * holds them, all of them are one round. Otherwise the round has the samples of the first error
 * estimate, or fewer if a launch does not hold them, so that a stopped render soon has an image.
 */
static uint64_t first_round(const mcv_renderer *r) {
    const mcv_render_options *o = r->options;
    const bool ends_by_samples =
        o->last > 0 && !(o->error > 0) && !(o->seconds > 0) && !o->enough && !r->stats->interrupted;
    const uint64_t all = o->last > 0 ? o->last - o->first : MCV_MIN_SAMPLES;
    /* Records then come tile by tile of the image. */
    if (ends_by_samples && o->records) return all;
    const uint64_t fitting =
        r->schedule.capacity /
        (mcv_tiled_pixels(r->film->width, r->film->height) * r->film->replicates);
    /* Each class has its own launches; with few rounds they are larger. */
    if (r->listed) return ends_by_samples && all <= 16 * fitting ? all : MCV_FIRST_ADAPTIVE;
    if (ends_by_samples && all <= fitting) return all;
    uint64_t count = all < MCV_MIN_SAMPLES ? all : MCV_MIN_SAMPLES;
    while (count > 1 && count > fitting) count /= 2;
    return count;
}

/* Rounds take longer than expected if others use the machine. */
static const double ROUND_MARGIN = 1.15;
enum {
    LEAST_GAIN = 8
}; /* near the end of the time, a round below this share of the samples is not worth it */

uint64_t mcv_next_round(uint64_t done, uint64_t least, double per_sample, double elapsed,
                        double seconds) {
    uint64_t count = done & (~done + 1); /* its lowest bit */
    if (!(seconds > 0)) return count;
    while (count >= least && elapsed + ROUND_MARGIN * per_sample * (double)count > seconds)
        count /= 2;
    return count < least || (elapsed >= 0.8 * seconds && count < done / LEAST_GAIN) ? 0 : count;
}

/* Whether the samples so far are enough for the error, or for the caller. */
static bool is_enough(const mcv_renderer *r, double error) {
    const mcv_render_options *o = r->options;
    /* An image that is black so far may have missed a small light, and its error estimate of 0 is
     * not reliable. */
    const uint64_t enough = mcv_film_mean(r->film) > 0 ? MCV_MIN_SAMPLES : MIN_SAMPLES_BLACK;
    if (r->film->samples < enough) return false;
    return (o->error > 0 && error <= o->error) || (o->enough && o->enough(o->user, r->film));
}

/* Adds the round that was rendered. */
static mcv_result end_round(mcv_renderer *r) {
    MCV_TRY(mcv_take_splats(r, r->splats));
    if (r->splats) memcpy(r->film->splats, r->splats, 8 * mcv_film_values(r->film));
    mcv_film_add(r->film, r->round, r->part.count);
    return MCV_OK;
}

/* Decides what precedes a round; one that was resumed has begun already. */
static mcv_result begin_round(mcv_renderer *r, double error) {
    if (r->part.sums) return MCV_OK;
    if (!r->decided) MCV_TRY(mcv_adapt(r, error));
    if (r->film->samples == 0)
        r->part = (mcv_round){.first = r->options->first, .count = first_round(r)};
    return MCV_OK;
}

/*
 * Renders rounds of doubling length until the samples or the error are reached. A round is shorter
 * if a doubled one would exceed the time. Each begins at a multiple of its length, because the
 * sampler's points are evenly distributed in such ranges.
 */
static mcv_result render_rounds(mcv_renderer *r) {
    const mcv_render_options *o = r->options;
    double error = r->film->samples > 0 ? mcv_film_relative_error(r->film) : INFINITY;
    bool stop = false;
    for (;;) {
        MCV_TRY(begin_round(r, error));
        const double round_begun = mcv_seconds();
        MCV_TRY(mcv_render_pass(r, r->part.first, r->part.count, error, &stop));
        if (stop) return MCV_OK;
        MCV_TRY(end_round(r));
        const uint64_t next = r->part.first + r->part.count;
        if (o->last > 0 && next >= o->last) return MCV_OK;
        error = mcv_film_relative_error(r->film);
        const double seconds = mcv_seconds() - r->begun;
        const double per_sample =
            fmax(0, mcv_seconds() - round_begun - r->warming) / (double)r->part.count;
        r->warming = 0;
        if (is_enough(r, error)) return MCV_OK;
        const uint64_t count = mcv_next_round(r->film->samples, r->listed ? MCV_FIRST_ADAPTIVE : 1,
                                              per_sample, seconds, o->seconds);
        r->part = (mcv_round){.first = next, .count = count};
        if (count == 0 || next >= (r->listed ? MCV_MOST_ADAPTIVE : MCV_MOST_SAMPLES)) return MCV_OK;
        if (!r->stats->interrupted) continue;
        if (mcv_save_is_due(r, true)) mcv_save_unfinished(r);
        return MCV_OK;
    }
}

/* Do pixels tell directions? Their evaluation compares neighbours, and where few samples were
 * enough for the whole picture their noise would look like a defect. */
static bool tells_directions(uint32_t sensor_type) {
    return sensor_type == MCV_SENSOR_LIGHT_FIELD || sensor_type == MCV_SENSOR_FLYING_SPOT;
}

/* Whether samples may be given to noisy pixels: options that ask for it in any case have been
 * checked. */
static bool may_adapt(const mcv_renderer *r) {
    const mcv_render_options *o = r->options;
    if (o->adaptive == MCV_ADAPTIVE_AUTO && tells_directions(r->key.sensor_type)) return false;
    return o->adaptive && o->first == 0 && o->last <= MCV_MOST_ADAPTIVE && !o->records;
}

/* What precedes the rounds. */
static mcv_result begin_samples(mcv_renderer *r) {
    r->part = (mcv_round){0};
    r->decided = !may_adapt(r);
    r->sampling_begun = mcv_seconds();
    if (r->options->resume) return mcv_resume(r);
    r->part.first = r->options->first;
    r->part.count = first_round(r);
    MCV_TRY(mcv_allocate_light(r));
    return mcv_open_records(r);
}

mcv_result mcv_render_check_finite(const mcv_scene *scene, uint32_t sensor,
                                   const mcv_render_stats *stats, mcv_error *error) {
    if ((double)stats->nonfinite <= 1e-6 * (double)stats->paths) return MCV_OK;
    return mcv_fail(
        error, MCV_FAILED,
        "%s: sensors/%s: %llu values of %llu samples were not finite, more than one in a "
        "million: some light exceeds the range of a 32-bit float; none may contribute more "
        "than 10^36 to a pixel",
        scene->path, scene->sensors[sensor].name, (unsigned long long)stats->nonfinite,
        (unsigned long long)stats->paths);
}

/* Room for what light paths bring. */
static mcv_result begin_splats(mcv_renderer *r) {
    if (!r->scene.splats) return MCV_OK;
    r->splats = calloc(mcv_film_values(r->film), sizeof *r->splats);
    if (!r->splats) return mcv_fail(r->error, MCV_FAILED, "no memory for what light paths bring");
    return mcv_film_take_splats(r->film, mcv_frame_splat_value(&r->frame), r->error);
}

static mcv_result render(mcv_renderer *r, const mcv_scene *scene, uint32_t sensor) {
    const mcv_render_options *options = r->options;
    mcv_film *film = r->film;
    mcv_error *error = r->error;
    uint32_t width;
    uint32_t height;
    MCV_TRY(mcv_render_check_options(scene, sensor, options, true, error));
    mcv_sensor_film_size(&scene->sensors[sensor], &width, &height);
    const uint32_t channels = mcv_scene_channels(scene);
    MCV_TRY(mcv_film_new(film, width, height, channels, options->replicates, error));
    r->round = calloc((size_t)width * height * channels * options->replicates, sizeof(double));
    if (!r->round)
        return mcv_fail(error, MCV_FAILED, "no memory for an image of %u x %u pixels", width,
                        height);
    MCV_TRY(mcv_open_devices(r, scene, sensor));
    MCV_TRY(begin_splats(r));
    mcv_unlist_pixels(r);
    if (!options->resume) MCV_TRY(mcv_show_early(r));
    MCV_TRY(begin_samples(r));
    const mcv_result result = render_rounds(r);
    r->stats->seconds_render = mcv_seconds() - r->sampling_begun;
    r->stats->lost_energy =
        r->stats->paths > 0 ? r->stats->lost_energy / (double)r->stats->paths : 0;
    return result == MCV_OK ? mcv_render_check_finite(scene, sensor, r->stats, error) : result;
}

mcv_renderer *mcv_renderer_new(void) { return calloc(1, sizeof(mcv_renderer)); }

void mcv_renderer_free(mcv_renderer *r) {
    if (r) close_renderer(r);
    free(r);
}

static void end_render(mcv_renderer *r) {
    free(r->round);
    free(r->listed);
    free(r->records);
    free(r->splats);
    r->round = NULL;
    r->records = NULL;
    r->recording_sets = 0;
    r->record_count = 0;
    r->listed = NULL;
    r->splats = NULL;
}

mcv_result mcv_renderer_render(mcv_renderer *r, const mcv_scene *scene, uint32_t sensor,
                               const mcv_render_options *options, mcv_film *film,
                               mcv_render_stats *stats, mcv_error *error) {
    memset(film, 0, sizeof *film);
    r->options = options;
    r->stats = stats;
    r->film = film;
    r->error = error;
    const double begun = mcv_seconds();
    mcv_result result;
    do { /* on the devices that are left */
        mcv_film_free(film);
        memset(stats, 0, sizeof *stats);
        r->begun = begun;
        result = render(r, scene, sensor);
        end_render(r);
    } while (result == MCV_DEVICE && mcv_go_on_without_first(r));
    if (result == MCV_DEVICE || result == MCV_FAILED) { /* the data on the device is undefined */
        close_renderer(r);
        memset(r, 0, sizeof *r);
    }
    if (result != MCV_OK) mcv_film_free(film);
    return result;
}

mcv_result mcv_render(const mcv_scene *scene, uint32_t sensor, const mcv_render_options *options,
                      mcv_film *film, mcv_render_stats *stats, mcv_error *error) {
    mcv_renderer r = {0};
    const mcv_result result = mcv_renderer_render(&r, scene, sensor, options, film, stats, error);
    close_renderer(&r);
    return result;
}
