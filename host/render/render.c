/* SPDX-License-Identifier: Apache-2.0 */
#include "render/render.h"

#include <math.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>

#include "core/basics.h"
#include "film/film.h"
#include "render/adaptive.h"
#include "render/schedule.h"

enum {
    MAX_LOG2_SAMPLES = 16, /* per launch and set */
    MIN_SAMPLES = 4,       /* per replicate, before an error estimate may stop the render */
    MIN_SAMPLES_BLACK = 256,
    LOOK_SHARE = 32,     /* a first look takes this part of the samples that it decides about: */
    LEAST_LOOK = 4,      /* per pixel, over all of its replicates, */
    MOST_LOOK = 1024,    /* for which more would tell little more; */
    LOOK_REPLICATES = 8, /* at most */
    WORTH_A_LOOK = 64,   /* samples per pixel, over all replicates */
    FIRST_ADAPTIVE = 1 << -MCV_LOWEST_LEVEL, /* samples per replicate of the first adaptive round:
                                                each pixel has one */
    MAX_CLASSES = MCV_HIGHEST_LEVEL - MCV_LOWEST_LEVEL + 1,
};

mcv_render_options mcv_render_defaults(void) {
    return (mcv_render_options){
        .sampler = MCV_SAMPLER_SOBOL, .replicates = 4, .depth = 32, .schedule = MCV_SCHEDULE_AUTO};
}

/* What a program is specialised for, and the sizes of a schedule's buffers follow from. */
typedef struct program_key {
    uint32_t features, channels, sensor_type, sampler, schedule, slice, depth;
} program_key;

/* The pixels that take 2^level times the samples: they stand together in the list. */
typedef struct pixel_class {
    int level;
    uint32_t first, count;
} pixel_class;

typedef struct mcv_renderer renderer;

struct mcv_renderer {
    /* Kept between renders: */
    mcv_cl cl;
    mcv_device_scene scene;
    mcv_schedule schedule, earlier; /* the one at work; another, to go back to when a number crosses
                                       a limit and back */
    program_key key, earlier_key;
    /* Of one render: */
    const mcv_render_options *options;
    mcv_render_stats *stats;
    mcv_film *film;
    double *round; /* like the film's sums: those of the samples of this round */
    mcv_frame frame;
    uint32_t *listed; /* the pixels by class; NULL: all in their order, in one class */
    pixel_class classes[MAX_CLASSES];
    uint32_t class_count;
    double begun;   /* when */
    double warming; /* seconds of the first launch that its stages did not take: drivers compile
                       there what they left out before */
    mcv_error *error;
};

static uint32_t floor_log2(uint64_t x) {
    uint32_t k = 0;
    while (x >>= 1) ++k;
    return k;
}

static const uint32_t LOOK_SEED = 0x7f4a7c15u,
                      ADAPTIVE_SEED =
                          0x2545f491u; /* change the user's seed for a first look, and after it */
static const double SOBOL_FALL =
    1.25; /* power by which the variance falls with the samples; 1 of random numbers */
/* Adaptive sampling must take less of the samples that all pixels would need alike: noisy pixels
 * cost more. */
static const double WORTH = 0.9;

static const uint64_t MOST_SAMPLES = 0x80000000u, MOST_ADAPTIVE = 0x80000000u >> MCV_HIGHEST_LEVEL;

static bool is_power_of_two(uint64_t x) { return x > 0 && (x & (x - 1)) == 0; }

/* Options that make no sense, before any work. */
static mcv_result check_options(const mcv_scene *scene, uint32_t sensor,
                                const mcv_render_options *options, mcv_error *error) {
    if (scene->sensor_count == 0) {
        return mcv_fail(
            error, MCV_BAD_INPUT,
            "%s: the scene has no sensor: give a node a glTF camera or an MCVISI_sensors sensor",
            scene->path);
    }
    if (sensor >= scene->sensor_count) {
        return mcv_fail(error, MCV_USAGE, "%s: there is no sensor %u: the scene has %u",
                        scene->path, sensor, scene->sensor_count);
    }
    if (options->replicates < 1 || options->replicates > 64)
        return mcv_fail(error, MCV_USAGE, "replicates must be 1 to 64, not %u",
                        options->replicates);
    if (options->depth < 1 || options->depth > 1000000)
        return mcv_fail(error, MCV_USAGE, "depth must be 1 to 1000000, not %u", options->depth);
    if (options->precision > MCV_PRECISION_MIXED)
        return mcv_fail(
            error, MCV_USAGE,
            "precision must be single or mixed on a device: double is the reference renderer's");
    if (options->slice % MCV_BLOCK != 0 || options->slice > 4096) {
        return mcv_fail(error, MCV_USAGE,
                        "a slice must be a multiple of %d paths of at most 4096, not %u", MCV_BLOCK,
                        options->slice);
    }
    if (options->last == 0 && !(options->error > 0) && !(options->seconds > 0)) {
        return mcv_fail(error, MCV_USAGE,
                        "nothing says when to stop: give samples, an error or a time");
    }
    if (options->last > MOST_SAMPLES ||
        ((options->first > 0 || options->last > 0) && options->first >= options->last)) {
        return mcv_fail(error, MCV_USAGE, "the sample range %llu:%llu is empty or ends beyond 2^31",
                        (unsigned long long)options->first, (unsigned long long)options->last);
    }
    if (options->adaptive && options->first > 0)
        return mcv_fail(
            error, MCV_USAGE,
            "adaptive sampling is of a whole render: no part of its samples can be rendered alone");
    if (options->adaptive && options->last > MOST_ADAPTIVE)
        return mcv_fail(error, MCV_USAGE,
                        "adaptive sampling gives pixels at most 2^28 samples per replicate on the "
                        "average, not %llu",
                        (unsigned long long)options->last);
    const uint64_t count = options->last - options->first;
    if (options->last > 0 && (!is_power_of_two(count) || options->first % count != 0)) {
        return mcv_fail(error, MCV_USAGE,
                        "the sample range %llu:%llu must hold a power of two of samples per "
                        "replicate and begin at a multiple of it",
                        (unsigned long long)options->first, (unsigned long long)options->last);
    }
    return MCV_OK;
}

/* A program for the scene: that at work, the one before, or a new one. */
static mcv_result open_schedule(renderer *r, uint32_t sensor_type) {
    const mcv_render_options *o = r->options;
    const program_key key = {r->scene.packed.features,
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
        const program_key other = r->key;
        r->schedule = r->earlier;
        r->key = r->earlier_key;
        r->earlier = schedule;
        r->earlier_key = other;
    }
    /* Both are of other scenes: that at work is the earlier one from now on. */
    mcv_schedule_close(&r->earlier);
    r->earlier = r->schedule;
    r->earlier_key = r->key;
    r->key = key;
    const mcv_result result =
        mcv_schedule_open(&r->cl, &r->scene, sensor_type, o, &r->schedule, r->error);
    if (result != MCV_OK) mcv_schedule_close(&r->schedule);
    return result;
}

/* kept: the scene before, or NULL. */
static mcv_result open_scene(renderer *r, const mcv_scene *scene, uint32_t sensor,
                             mcv_device_scene *kept) {
    const double start = mcv_seconds();
    if (!r->cl.context) MCV_TRY(mcv_cl_open(r->options->device, &r->cl, r->error));
    memcpy(r->stats->device, r->cl.name, sizeof r->stats->device);
    memcpy(r->stats->driver, r->cl.version, sizeof r->stats->driver);
    MCV_TRY(mcv_device_scene_begin(&r->cl, scene, r->options->threads, kept, &r->scene, r->error));
    if (r->options->precision == MCV_PRECISION_MIXED)
        MCV_TRY(mcv_device_scene_refine(&r->cl, scene, &r->scene, r->error));
    r->stats->kept_structure = r->scene.kept_structure;
    mcv_packed *packed = &r->scene.packed;
    packed->features = mcv_sensor_features(packed, &scene->sensors[sensor]);
    if (r->options->no_light_paths) packed->features &= ~(1u << MCV_FEATURE_LIGHT_TRACING);
    if (r->options->no_split) packed->features &= ~(1u << MCV_FEATURE_SPLIT);
    mcv_feature_names(packed->features, r->stats->features, sizeof r->stats->features);

    const double compile = mcv_seconds();
    if (r->options->progress)
        r->options->progress(r->options->user, (double)NAN, compile - r->begun, INFINITY);
    MCV_TRY(open_schedule(r, scene->sensors[sensor].type));
    r->stats->seconds_compile = mcv_seconds() - compile;
    MCV_TRY(mcv_device_scene_finish(&r->cl, kept, &r->scene, r->error));
    r->stats->seconds_build = mcv_seconds() - start - r->stats->seconds_compile;

    r->frame = (mcv_frame){.width = r->film->width,
                           .height = r->film->height,
                           .replicates = r->film->replicates,
                           .seed = r->options->seed,
                           .depth = r->options->depth};
    MCV_TRY(mcv_device_scene_place(&r->cl, scene, sensor, &r->scene, &r->frame, r->error));
    if (r->scene.splats) {
        const double paths =
            (double)(mcv_tiled_pixels(r->film->width, r->film->height) >> r->frame.log2_thinning);
        MCV_TRY(
            mcv_film_take_splats(r->film, 1 / ((double)r->frame.splat_scale * paths), r->error));
    }
    return mcv_schedule_aim(&r->schedule, &r->frame, r->stats, r->error);
}

/* What the scene before has in common with this one is taken over. */
static mcv_result open_renderer(renderer *r, const mcv_scene *scene, uint32_t sensor) {
    mcv_device_scene kept = r->scene;
    memset(&r->scene, 0, sizeof r->scene);
    const mcv_result result = open_scene(r, scene, sensor, kept.nodes ? &kept : NULL);
    mcv_device_scene_close(&kept);
    if (result != MCV_OK) mcv_device_scene_close(&r->scene); /* half a scene is nothing to keep */
    return result;
}

static void close_renderer(renderer *r) {
    mcv_schedule_close(&r->schedule);
    mcv_schedule_close(&r->earlier);
    mcv_device_scene_close(&r->scene);
    mcv_cl_close(&r->cl);
}

/* Of all replicates. */
static size_t film_values(const mcv_film *film) {
    return (size_t)film->width * film->height * film->channels * film->replicates;
}

/* Where in the image the pixel of this number lies, tile by tile; false if its 8 x 8 tile sticks
 * out there. */
static bool find_tiled_pixel(const mcv_film *film, uint32_t number, size_t *pixel) {
    const uint32_t tiles = (film->width + 7) / 8;
    const uint32_t column = (number >> 6) % tiles * 8 + (number & 7);
    const uint32_t row = (number >> 6) / tiles * 8 + (number >> 3 & 7);
    *pixel = (size_t)row * film->width + column;
    return column < film->width && row < film->height;
}

/* The same in the order in which pixels are rendered. */
static bool find_pixel(const renderer *r, uint32_t number, size_t *pixel) {
    if (!r->listed) return find_tiled_pixel(r->film, number, pixel);
    *pixel = r->listed[number];
    return true;
}

/* Some sets of a round: what their launches leave on the device, on its way into the round. */
typedef struct readback {
    uint32_t first_set, sets;
    uint32_t launched_blocks, blocks_per_set; /* of one launch; of the round */
    uint32_t first_block;                     /* of the launch that was read */
    float *read;                              /* its sums */
    double *blocks;                           /* [set][channel][block] */
    double share; /* of a sample in the round: 1 over what the class takes more of them */
    bool pending; /* `read` holds sums that are not yet added */
} readback;

/* The sum of a set's samples in the round, once all of its launches are read. */
static double sum_of_set(const readback *h, uint32_t set, uint32_t channel, uint32_t channels) {
    const size_t at = (size_t)set * channels + channel;
    if (h->blocks_per_set == 1) return (double)h->read[2 * at] + (double)h->read[2 * at + 1];
    return mcv_tree_sum(h->blocks + at * h->blocks_per_set, h->blocks_per_set, 1);
}

/* Adds what was read; after the last launch of the sets, their sums go into the round. */
static void accumulate_readback(const renderer *r, readback *h) {
    const mcv_film *film = r->film;
    const uint32_t channels = film->channels;
    const size_t pixels = (size_t)film->width * film->height;
    if (!h->pending) return;
    h->pending = false;
    for (uint32_t set = 0; h->blocks_per_set > 1 && set < h->sets; ++set) {
        for (uint32_t b = 0; b < h->launched_blocks; ++b) {
            for (uint32_t c = 0; c < channels; ++c) {
                const float *pair =
                    h->read + 2 * (((size_t)set * h->launched_blocks + b) * channels + c);
                h->blocks[((size_t)set * channels + c) * h->blocks_per_set + h->first_block + b] =
                    (double)pair[0] + (double)pair[1];
            }
        }
    }
    if (h->first_block + h->launched_blocks < h->blocks_per_set) return;
    /* Sets are replicates of one pixel, then those of the next. */
    for (uint32_t i = 0; i < h->sets;) {
        size_t pixel;
        const bool inside = find_pixel(r, (h->first_set + i) / film->replicates, &pixel);
        for (uint32_t replicate = (h->first_set + i) % film->replicates;
             replicate < film->replicates && i < h->sets; ++replicate, ++i)
            for (uint32_t c = 0; inside && c < channels; ++c)
                r->round[((size_t)replicate * channels + c) * pixels + pixel] =
                    h->share * sum_of_set(h, i, c, channels);
    }
}

static double stage_seconds(const mcv_render_stats *stats) {
    double seconds = 0;
    for (uint32_t i = 0; i < stats->stage_count; ++i) seconds += stats->stages[i].seconds;
    return seconds;
}

/* One launch: 2^frame.log2_samples samples of `sets` sets. While it runs, what the one before left
 * is brought in. */
static mcv_result launch(renderer *r, uint32_t sets, uint32_t first_block, readback *h) {
    const double begun = mcv_seconds();
    r->frame.path_count = sets << r->frame.log2_samples;
    MCV_TRY(mcv_schedule_start(&r->schedule, &r->frame, r->stats, r->error));
    accumulate_readback(r, h);
    MCV_TRY(mcv_schedule_wait(&r->schedule, r->stats, r->error));
    MCV_TRY(mcv_cl_read(&r->cl, r->schedule.sums, 0,
                        8 * (size_t)sets * h->launched_blocks * r->film->channels, h->read,
                        r->error));
    h->first_set = r->frame.first_set;
    h->sets = sets;
    h->first_block = first_block;
    h->pending = true;
    if (r->stats->seconds_first_sample > 0) return MCV_OK;
    r->warming = fmax(0, mcv_seconds() - begun - stage_seconds(r->stats));
    r->stats->seconds_first_sample = mcv_seconds() - r->begun;
    return MCV_OK;
}

/* Tells the caller how far the render is, with so much of a round; false: it is to stop now. */
static bool go_on(const renderer *r, double samples, double error) {
    const mcv_render_options *o = r->options;
    if (!o->progress) return true;
    const double seconds = mcv_seconds() - r->begun;
    double fraction = o->last > 0 ? samples / (double)(o->last - o->first) : 0;
    if (o->seconds > 0 && seconds / o->seconds > fraction) fraction = seconds / o->seconds;
    /* The error falls at least as fast as the root of the samples grows. */
    if (o->error > 0 && error > 0 && isfinite(error))
        fraction =
            fmax(fraction, fmin(1, pow(o->error / error, 2) * samples / (double)r->film->samples));
    if (o->progress(o->user, fraction, seconds, error)) return true;
    r->stats->interrupted = true;
    /* The first round is always finished: a stopped render has an image. */
    return r->film->samples == 0;
}

static uint64_t times_power(uint64_t count, int level) {
    return level < 0 ? count >> -level : count << level;
}

/*
 * All samples [first, first + count), times 2^level, of the class's pixels into r->round; count is
 * a power of two. *stop is set when the caller's progress function asked for it: the round is not
 * whole then.
 */
static mcv_result render_class(renderer *r, pixel_class class, uint64_t first, uint64_t count,
                               double done_before, bool *stop) {
    const mcv_film *film = r->film;
    const uint32_t channels = film->channels;
    const uint64_t first_set = (uint64_t) class.first * film->replicates,
                   set_count = (uint64_t) class.count * film->replicates;
    const uint64_t end_set = first_set + set_count;
    const uint32_t capacity = r->schedule.capacity;
    const double before = (double)film->samples;
    const uint64_t pixels = r->listed ? (uint64_t)film->width * film->height : class.count;
    const double round = (double)count * class.count / (double)pixels;
    first = times_power(first, class.level);
    count = times_power(count, class.level);
    uint32_t log2_samples = floor_log2(count);
    if (log2_samples > MAX_LOG2_SAMPLES) log2_samples = MAX_LOG2_SAMPLES;
    if (log2_samples > floor_log2(capacity)) log2_samples = floor_log2(capacity);
    const uint32_t launch_samples = 1u << log2_samples;
    const uint32_t block = launch_samples < MCV_BLOCK ? launch_samples : MCV_BLOCK;
    const uint32_t sets_per_launch = capacity / launch_samples;
    readback h = {.launched_blocks = launch_samples / block,
                  .blocks_per_set = (uint32_t)(count / block),
                  .share = ldexp(1, -class.level)};
    mcv_result result = MCV_OK;
    if (end_set > 0xffffffffu) {
        return mcv_fail(r->error, MCV_BAD_INPUT,
                        "the image has too many pixels for %u replicates: %llu sets, at most 2^32",
                        film->replicates, (unsigned long long)end_set);
    }
    h.read = malloc(8 * (size_t)sets_per_launch * h.launched_blocks * channels);
    h.blocks = malloc(8 * (size_t)sets_per_launch * channels * h.blocks_per_set);
    if (!h.read || !h.blocks)
        result = mcv_fail(r->error, MCV_FAILED, "no memory for the sums of a launch");

    r->frame.log2_samples = log2_samples;
    uint32_t sets = 0;
    for (uint64_t set = first_set; result == MCV_OK && !*stop && set < end_set; set += sets) {
        /* A short first launch: the user sees soon that something comes. Not where pictures have
         * come before. */
        const bool at_once = r->stats->kept_program || r->stats->seconds_first_sample > 0;
        const uint32_t most = at_once ? sets_per_launch : (sets_per_launch + 15) / 16;
        sets = (uint32_t)(end_set - set < most ? end_set - set : most);
        r->frame.first_set = (uint32_t)set;
        for (uint64_t s = 0; result == MCV_OK && s < count; s += launch_samples) {
            r->frame.first_sample = (uint32_t)(first + s);
            result = launch(r, sets, (uint32_t)(s / block), &h);
        }
        const double share = (double)(set + sets - first_set) / (double)set_count;
        if (result == MCV_OK) *stop = !go_on(r, before + share * round, done_before);
    }
    if (result == MCV_OK) accumulate_readback(r, &h);
    free(h.read);
    free(h.blocks);
    return result;
}

/* The light paths of samples [first, first + count), where camera paths are launched without them.
 */
static mcv_result render_light(renderer *r, uint64_t first, uint64_t count) {
    const uint32_t capacity = r->schedule.capacity;
    const uint64_t set_count =
        mcv_tiled_pixels(r->film->width, r->film->height) * r->film->replicates;
    if (!r->scene.splats || !r->listed) return MCV_OK;
    r->frame.log2_samples = floor_log2(count < capacity ? count : capacity);
    if (r->frame.log2_samples > MAX_LOG2_SAMPLES) r->frame.log2_samples = MAX_LOG2_SAMPLES;
    const uint32_t sets_per_launch = capacity >> r->frame.log2_samples;
    for (uint64_t set = 0; set < set_count; set += sets_per_launch) {
        const uint64_t sets = set_count - set < sets_per_launch ? set_count - set : sets_per_launch;
        r->frame.first_set = (uint32_t)set;
        r->frame.path_count = (uint32_t)sets << r->frame.log2_samples;
        for (uint64_t s = 0; s < count; s += (uint64_t)1 << r->frame.log2_samples) {
            r->frame.first_sample = (uint32_t)(first + s);
            MCV_TRY(mcv_schedule_trace_light(&r->schedule, &r->frame, r->stats, r->error));
        }
    }
    return MCV_OK;
}

/* All samples [first, first + count) of all pixels into r->round; count is a power of two. */
static mcv_result render_round(renderer *r, uint64_t first, uint64_t count, double done_before,
                               bool *stop) {
    for (uint32_t i = 0; i < r->class_count && !*stop; ++i)
        MCV_TRY(render_class(r, r->classes[i], first, count, done_before, stop));
    return *stop ? MCV_OK : render_light(r, first, count);
}

/* --- adaptive
 * ---------------------------------------------------------------------------------------------------
 */

static double fall_of(const mcv_render_options *o) {
    return o->sampler == MCV_SAMPLER_RANDOM ? 1 : SOBOL_FALL;
}

/* How many samples per replicate the render is going to have, from those it has and their error;
 * infinite: nobody knows. */
static double expected_samples(const renderer *r, double error) {
    const mcv_render_options *o = r->options;
    const double samples = (double)r->film->samples;
    double expected = o->last > 0 ? (double)o->last : INFINITY;
    if (o->error > 0)
        expected = fmin(expected, samples * pow(fmax(error / o->error, 1), 2 / fall_of(o)));
    if (o->seconds > 0)
        expected = fmin(expected, samples * o->seconds / (mcv_seconds() - r->begun));
    return expected;
}

/* Lists the pixels by their levels; all in one class where these are not known. */
static mcv_result list_pixels(renderer *r) {
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
            if (find_tiled_pixel(film, i, &pixel) &&
                (film->levels ? film->levels[pixel] : 0) == level)
                r->listed[listed++] = (uint32_t)pixel;
        }
        if (listed > first)
            r->classes[r->class_count++] = (pixel_class){level, first, listed - first};
    }
    r->frame.listed = 1;
    mcv_cl_release(&r->scene.listed);
    return mcv_cl_buffer(&r->cl, "the list of pixels", count * sizeof *r->listed, r->listed,
                         &r->scene.listed, r->error);
}

/* All pixels in their order again. */
static void unlist_pixels(renderer *r) {
    free(r->listed);
    r->listed = NULL;
    r->frame.listed = 0;
    r->class_count = 1;
    r->classes[0] =
        (pixel_class){0, 0, (uint32_t)mcv_tiled_pixels(r->film->width, r->film->height)};
}

/* An empty film, to be filled with other random numbers. */
static mcv_result begin_anew(renderer *r) {
    const size_t values = film_values(r->film);
    const cl_uint nothing = 0;
    if (r->scene.splats)
        MCV_TRY_CL(clEnqueueFillBuffer(r->cl.queue, r->scene.splats, &nothing, sizeof nothing, 0,
                                       8 * values, 0, NULL, NULL),
                   r->error);
    r->film->samples = 0;
    r->frame.seed = r->options->seed ^ ADAPTIVE_SEED;
    return list_pixels(r);
}

/* So many samples per pixel (a power of two) of camera paths alone, in as many replicates as may
 * be, that the image knows nothing of. */
static mcv_result render_look(renderer *r, uint32_t samples, mcv_film *look, bool *stop) {
    mcv_film *film = r->film;
    double *round = r->round;
    const uint32_t replicates = samples < LOOK_REPLICATES ? samples : LOOK_REPLICATES;
    MCV_TRY(mcv_film_new(look, film->width, film->height, film->channels, replicates, r->error));
    r->film = look;
    r->round = look->sums;
    r->frame.replicates = replicates;
    r->frame.seed = r->options->seed ^ LOOK_SEED;
    mcv_result result = list_pixels(r);
    if (result == MCV_OK)
        result = render_class(r, r->classes[0], 0, samples / replicates, INFINITY, stop);
    r->film = film;
    r->round = round;
    r->frame.replicates = film->replicates;
    r->frame.seed = r->options->seed;
    unlist_pixels(r);
    return result;
}

/* The samples per pixel of the look that is worth its while now, over all replicates; 0: none. */
static uint32_t worthy_look(const renderer *r, double expected) {
    const double all = expected * r->film->replicates,
                 begun = (double)r->film->samples * r->film->replicates;
    if (all < WORTH_A_LOOK || expected < FIRST_ADAPTIVE) return 0;
    uint32_t samples = LEAST_LOOK;
    while (samples < MOST_LOOK && 2 * LOOK_SHARE * samples <= all) samples *= 2;
    return begun + samples < all / 4 ? samples : 0;
}

/*
 * Once it is known how many samples the render will take: looks round, and if it pays, throws away
 * what the film has and begins anew, with other random numbers and for each pixel as many samples
 * as it needs. What was known when that was decided has no part in the image, which so is right on
 * the average. *looked: it is decided.
 */
static mcv_result adapt(renderer *r, double error, bool *looked) {
    mcv_film *film = r->film;
    const mcv_render_options *o = r->options;
    const bool is_known =
        film->samples >= MIN_SAMPLES || !(o->error > 0 || o->seconds > 0 || o->last == 0);
    double expected = is_known ? expected_samples(r, error) : 0;
    if (!isfinite(expected)) expected = (double)LOOK_SHARE * (double)film->samples;
    const uint32_t samples = worthy_look(r, expected);
    mcv_film look = {0};
    bool stop = false;
    double gain = 0;
    if (samples == 0) return MCV_OK;
    *looked = true;
    film->levels = malloc((size_t)film->width * film->height);
    if (!film->levels) return mcv_fail(r->error, MCV_FAILED, "no memory for the levels of pixels");
    mcv_result result = render_look(r, samples, &look, &stop);
    const double begun = (double)film->samples + (double)samples / film->replicates;
    const double budget = o->last > 0 ? 1 - begun / (double)o->last : 1;
    if (result == MCV_OK)
        result = mcv_allocate_samples(&look, fall_of(o), budget, film->levels, &gain, r->error);
    mcv_film_free(&look);
    MCV_TRY(result);
    if (!r->stats->interrupted && gain > 0 && begun + expected / gain < WORTH * expected)
        return begin_anew(r);
    free(film->levels);
    film->levels = NULL;
    return MCV_OK;
}

/*
 * A render whose samples alone end it, and which one launch holds, is a single round. Otherwise the
 * first one brings what the first look at the error wants, or less where a launch does not hold
 * that: a stopped render has an image soon.
 */
static uint64_t first_round(const renderer *r) {
    const mcv_render_options *o = r->options;
    const bool ends_by_samples =
        o->last > 0 && !(o->error > 0) && !(o->seconds > 0) && !o->enough && !r->stats->interrupted;
    const uint64_t all = o->last > 0 ? o->last - o->first : MIN_SAMPLES;
    const uint64_t fitting =
        r->schedule.capacity /
        (mcv_tiled_pixels(r->film->width, r->film->height) * r->film->replicates);
    /* Each class takes launches of its own: with few rounds they are larger. */
    if (r->listed) return ends_by_samples && all <= 16 * fitting ? all : FIRST_ADAPTIVE;
    if (ends_by_samples && all <= fitting) return all;
    uint64_t count = all < MIN_SAMPLES ? all : MIN_SAMPLES;
    while (count > 1 && count > fitting) count /= 2;
    return count;
}

/* Rounds take longer than expected where others use the machine, too. */
static const double ROUND_MARGIN = 1.15;
enum {
    LEAST_GAIN = 8
}; /* late in the time: a round of less than this part of the samples changes little */

uint64_t mcv_next_round(uint64_t done, uint64_t least, double per_sample, double elapsed,
                        double seconds) {
    uint64_t count = done & (~done + 1); /* its lowest bit */
    if (!(seconds > 0)) return count;
    while (count >= least && elapsed + ROUND_MARGIN * per_sample * (double)count > seconds)
        count /= 2;
    return count < least || (elapsed >= 0.8 * seconds && count < done / LEAST_GAIN) ? 0 : count;
}

/*
 * Rounds of doubling length until the samples or the error is reached; shorter ones where a doubled
 * one would not end in time. All begin at a multiple of their length, as points of the sampler are
 * evenly spread in such ranges.
 */
static mcv_result render_rounds(renderer *r) {
    const mcv_render_options *o = r->options;
    double error = INFINITY;
    bool stop = false, looked = !o->adaptive;
    uint64_t next = o->first, count = first_round(r);
    for (;;) {
        if (!looked) MCV_TRY(adapt(r, error, &looked));
        if (r->film->samples == 0) {
            next = o->first;
            count = first_round(r);
        }
        const double round_begun = mcv_seconds();
        MCV_TRY(render_round(r, next, count, error, &stop));
        if (stop) return MCV_OK;
        if (r->film->splats)
            MCV_TRY(mcv_cl_read(&r->cl, r->scene.splats, 0, 8 * film_values(r->film),
                                r->film->splats, r->error));
        mcv_film_add(r->film, r->round, count);
        next += count;
        if (o->last > 0 && next >= o->last) return MCV_OK;
        error = mcv_film_relative_error(r->film);
        const double seconds = mcv_seconds() - r->begun;
        const double per_sample = fmax(0, mcv_seconds() - round_begun - r->warming) / (double)count;
        r->warming = 0;
        /* A picture that is black so far may have missed a small light: its error of 0 says nothing
         * yet. */
        const uint64_t enough = mcv_film_mean(r->film) > 0 ? MIN_SAMPLES : MIN_SAMPLES_BLACK;
        if (o->error > 0 && r->film->samples >= enough && error <= o->error) return MCV_OK;
        if (o->enough && r->film->samples >= enough && o->enough(o->user, r->film)) return MCV_OK;
        count = mcv_next_round(r->film->samples, r->listed ? FIRST_ADAPTIVE : 1, per_sample,
                               seconds, o->seconds);
        if (count == 0) return MCV_OK;
        if (r->stats->interrupted || next >= (r->listed ? MOST_ADAPTIVE : MOST_SAMPLES))
            return MCV_OK;
    }
}

mcv_result mcv_render_check_finite(const mcv_scene *scene, uint32_t sensor,
                                   const mcv_render_stats *stats, mcv_error *error) {
    if ((double)stats->nonfinite <= 1e-6 * (double)stats->paths) return MCV_OK;
    return mcv_fail(error, MCV_FAILED,
                    "%s: sensors/%s: %llu values of %llu samples were not finite, more than one in "
                    "a million: some light is brighter than a "
                    "float of 32 bits can hold; none may bring more than 10^36 to a pixel",
                    scene->path, scene->sensors[sensor].name, (unsigned long long)stats->nonfinite,
                    (unsigned long long)stats->paths);
}

static mcv_result render(renderer *r, const mcv_scene *scene, uint32_t sensor) {
    const mcv_render_options *options = r->options;
    mcv_film *film = r->film;
    mcv_error *error = r->error;
    uint32_t width;
    uint32_t height;
    MCV_TRY(check_options(scene, sensor, options, error));
    mcv_sensor_film_size(&scene->sensors[sensor], &width, &height);
    const uint32_t channels = mcv_scene_channels(scene);
    MCV_TRY(mcv_film_new(film, width, height, channels, options->replicates, error));
    r->round = calloc((size_t)width * height * channels * options->replicates, sizeof(double));
    if (!r->round)
        return mcv_fail(error, MCV_FAILED, "no memory for an image of %u x %u pixels", width,
                        height);
    MCV_TRY(open_renderer(r, scene, sensor));
    unlist_pixels(r);
    const double begun = mcv_seconds();
    const mcv_result result = render_rounds(r);
    r->stats->seconds_render = mcv_seconds() - begun;
    r->stats->lost_energy =
        r->stats->paths > 0 ? r->stats->lost_energy / (double)r->stats->paths : 0;
    return result == MCV_OK ? mcv_render_check_finite(scene, sensor, r->stats, error) : result;
}

mcv_renderer *mcv_renderer_new(void) { return calloc(1, sizeof(mcv_renderer)); }

void mcv_renderer_free(mcv_renderer *r) {
    if (r) close_renderer(r);
    free(r);
}

mcv_result mcv_renderer_render(mcv_renderer *r, const mcv_scene *scene, uint32_t sensor,
                               const mcv_render_options *options, mcv_film *film,
                               mcv_render_stats *stats, mcv_error *error) {
    memset(film, 0, sizeof *film);
    memset(stats, 0, sizeof *stats);
    r->options = options;
    r->stats = stats;
    r->film = film;
    r->error = error;
    r->begun = mcv_seconds();
    const mcv_result result = render(r, scene, sensor);
    free(r->round);
    free(r->listed);
    r->round = NULL;
    r->listed = NULL;
    if (result == MCV_DEVICE ||
        result == MCV_FAILED) { /* what is on the device, or on its way, may be anything */
        close_renderer(r);
        memset(r, 0, sizeof *r);
    }
    if (result != MCV_OK) mcv_film_free(film);
    return result;
}

mcv_result mcv_render(const mcv_scene *scene, uint32_t sensor, const mcv_render_options *options,
                      mcv_film *film, mcv_render_stats *stats, mcv_error *error) {
    renderer r = {0};
    const mcv_result result = mcv_renderer_render(&r, scene, sensor, options, film, stats, error);
    close_renderer(&r);
    return result;
}
