/* SPDX-License-Identifier: Apache-2.0 */
/* A pass over the pixels: launches of the schedule, and the readback of their results. */
#include "render/pass.h"

#include <math.h>
#include <stdlib.h>

#include "core/basics.h"

enum { MAX_LOG2_SAMPLES = 16 }; /* per launch and set */

static uint32_t floor_log2(uint64_t x) {
    uint32_t k = 0;
    while (x >>= 1) ++k;
    return k;
}

bool mcv_find_blocked_pixel(const mcv_film *film, uint32_t number, size_t *pixel) {
    const uint32_t tiles = (film->width + 7) / 8;
    const uint32_t column = (number >> 6) % tiles * 8 + (number & 7);
    const uint32_t row = (number >> 6) / tiles * 8 + (number >> 3 & 7);
    *pixel = (size_t)row * film->width + column;
    return column < film->width && row < film->height;
}

/* As mcv_find_blocked_pixel, but in the order of rendering, which a list of pixels changes. */
static bool find_pixel(const mcv_renderer *r, uint32_t number, size_t *pixel) {
    if (!r->listed) return mcv_find_blocked_pixel(r->film, number, pixel);
    *pixel = r->listed[number];
    return true;
}

/* The sum of a set's samples in the round, once all of its launches are read. */
static double sum_of_set(const mcv_readback *h, uint32_t set, uint32_t channel, uint32_t channels) {
    const size_t at = (size_t)set * channels + channel;
    if (h->blocks_per_set == 1) return (double)h->read[2 * at] + (double)h->read[2 * at + 1];
    return mcv_pairwise_sum(h->blocks + at * h->blocks_per_set, h->blocks_per_set, 1);
}

/* Adds the sums that were read; after the last launch of the sets, adds their total to the
 * round. */
static void accumulate_readback(const mcv_renderer *r, mcv_readback *h) {
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
    /* The replicates of a pixel are consecutive sets. */
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

/* One launch: 2^frame.log2_samples samples of `sets` sets. While it runs, the results of the launch
 * before are accumulated. */
static mcv_result launch(mcv_renderer *r, uint32_t sets, uint32_t first_block, mcv_readback *h) {
    const double begun = mcv_seconds();
    r->frame.path_count = sets << r->frame.log2_samples;
    MCV_TRY(mcv_clear_records(r));
    MCV_TRY(mcv_schedule_start(&r->schedule, &r->frame, r->stats, r->error));
    accumulate_readback(r, h);
    MCV_TRY(mcv_give_records(r));
    MCV_TRY(mcv_schedule_wait(&r->schedule, r->stats, r->error));
    MCV_TRY(mcv_cl_read(&r->cl, r->schedule.sums, 0,
                        8 * (size_t)sets * h->launched_blocks * r->film->channels, h->read,
                        r->error));
    MCV_TRY(mcv_read_records(r));
    h->first_set = r->frame.first_set;
    h->sets = sets;
    h->first_block = first_block;
    h->pending = true;
    if (r->stats->seconds_first_sample > 0) return MCV_OK;
    r->warming = fmax(0, mcv_seconds() - begun - stage_seconds(r->stats));
    r->stats->seconds_first_sample = mcv_seconds() - r->begun;
    return MCV_OK;
}

/* Reports the progress of the render, `samples` of a round included; returns false to stop now. */
static bool go_on(const mcv_renderer *r, double samples, double error) {
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
    /* The first round is always finished: a stopped render has an image. Records of a part of a
     * round are of no use, and their first round may be the whole render. */
    return r->film->samples == 0 && !o->records;
}

/* Saves the render with what was read, if it is time. */
static mcv_result save(mcv_renderer *r, mcv_class_pass *pass, bool ending) {
    if (!r->in_round || !mcv_save_is_due(r, ending)) return MCV_OK;
    mcv_class_pass_read(r, pass);
    MCV_TRY(mcv_take_splats(r, r->splats));
    r->part.sums = r->round;
    mcv_save_unfinished(r);
    return MCV_OK;
}

static uint64_t times_power(uint64_t count, int level) {
    return level < 0 ? count >> -level : count << level;
}

mcv_result mcv_class_pass_begin(const mcv_renderer *r, mcv_pixel_class class, uint64_t first,
                                uint64_t count, mcv_class_pass *pass) {
    const mcv_film *film = r->film;
    const uint32_t capacity = r->schedule.capacity;
    *pass = (mcv_class_pass){.first = times_power(first, class.level),
                             .count = times_power(count, class.level),
                             .first_set = (uint64_t) class.first * film->replicates,
                             .set_count = (uint64_t) class.count * film->replicates};
    if (pass->first_set + pass->set_count > 0xffffffffu)
        return mcv_fail(r->error, MCV_BAD_INPUT,
                        "the image has too many pixels for %u replicates: %llu sets, at most 2^32",
                        film->replicates, (unsigned long long)(pass->first_set + pass->set_count));
    uint32_t log2_samples = floor_log2(pass->count);
    if (log2_samples > MAX_LOG2_SAMPLES) log2_samples = MAX_LOG2_SAMPLES;
    if (log2_samples > floor_log2(capacity)) log2_samples = floor_log2(capacity);
    const uint32_t launch_samples = 1u << log2_samples;
    const uint32_t block = mcv_block_size(log2_samples);
    mcv_readback *h = &pass->readback;
    pass->log2_samples = log2_samples;
    pass->sets_per_launch = capacity / launch_samples;
    *h = (mcv_readback){.launched_blocks = launch_samples / block,
                        .blocks_per_set = (uint32_t)(pass->count / block),
                        .share = ldexp(1, -class.level)};
    const size_t values = (size_t)pass->sets_per_launch * film->channels;
    h->read = malloc(8 * values * h->launched_blocks);
    h->blocks = malloc(8 * values * h->blocks_per_set);
    if (h->read && h->blocks) return MCV_OK;
    return mcv_fail(r->error, MCV_FAILED, "no memory for the sums of a launch");
}

mcv_result mcv_class_pass_launch(mcv_renderer *r, mcv_class_pass *pass, uint64_t set, uint32_t sets,
                                 uint64_t *sample) {
    mcv_readback *h = &pass->readback;
    const uint64_t first = *sample;
    *sample += (uint64_t)1 << pass->log2_samples;
    r->frame.log2_samples = pass->log2_samples;
    r->frame.first_set = (uint32_t)set;
    r->frame.first_sample = (uint32_t)(pass->first + first);
    return launch(r, sets, (uint32_t)(first >> pass->log2_samples) * h->launched_blocks, h);
}

void mcv_class_pass_read(const mcv_renderer *r, mcv_class_pass *pass) {
    accumulate_readback(r, &pass->readback);
}

void mcv_class_pass_end(mcv_class_pass *pass) {
    free(pass->readback.read);
    free(pass->readback.blocks);
}

bool mcv_class_pass_tell(const mcv_renderer *r, mcv_pixel_class class, uint64_t count, double share,
                         double error) {
    const mcv_film *film = r->film;
    const uint64_t pixels = r->listed ? (uint64_t)film->width * film->height : class.count;
    const double round = (double)count * class.count / (double)pixels;
    return go_on(r, (double)film->samples + share * round, error);
}

/* The sets of the next launch, of those that are left. */
static uint32_t next_sets(const mcv_renderer *r, const mcv_class_pass *pass, uint64_t left) {
    /* The first launch is short, so that the user soon sees progress; a renderer that has rendered
     * before skips this. */
    const bool at_once = r->stats->kept_program || r->stats->seconds_first_sample > 0;
    uint32_t most = at_once ? pass->sets_per_launch : (pass->sets_per_launch + 15) / 16;
    if (r->recording_sets > 0 && most > r->recording_sets) most = r->recording_sets;
    return (uint32_t)(left < most ? left : most);
}

/* Whether the render may stop while sets lack samples: what is saved of a round has whole sets. */
static bool may_stop_in_sets(const mcv_renderer *r) {
    return r->options->records || !r->options->saving;
}

mcv_result mcv_render_class(mcv_renderer *r, mcv_pixel_class class, uint64_t first, uint64_t count,
                            double done_before, bool *stop) {
    mcv_class_pass pass;
    mcv_result result = mcv_class_pass_begin(r, class, first, count, &pass);
    uint64_t done = r->in_round ? r->part.sets : 0, sample = 0;
    uint32_t sets = 0;
    while (result == MCV_OK && !*stop && done < pass.set_count) {
        if (sample == 0) sets = next_sets(r, &pass, pass.set_count - done);
        result = mcv_class_pass_launch(r, &pass, pass.first_set + done, sets, &sample);
        const double of_sets = sets * ((double)sample / (double)pass.count);
        const double share = ((double)done + of_sets) / (double)pass.set_count;
        if (sample < pass.count && !may_stop_in_sets(r)) continue;
        if (result == MCV_OK) *stop = !mcv_class_pass_tell(r, class, count, share, done_before);
        if (sample < pass.count) continue;
        sample = 0;
        done += sets;
        if (r->in_round) r->part.sets = done;
        if (result == MCV_OK) result = save(r, &pass, *stop);
    }
    if (result == MCV_OK) mcv_class_pass_read(r, &pass);
    if (result == MCV_OK) result = mcv_give_records(r);
    mcv_class_pass_end(&pass);
    return result;
}

mcv_result mcv_render_light(mcv_renderer *r, uint64_t pixels, uint64_t first, uint64_t count) {
    const uint32_t capacity = r->schedule.capacity;
    const uint64_t set_count = pixels * r->film->replicates;
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

mcv_result mcv_render_pass(mcv_renderer *r, uint64_t first, uint64_t count, double done_before,
                           bool *stop) {
    while (r->part.class < r->class_count) {
        r->in_round = true;
        const mcv_pixel_class class = r->classes[r->part.class];
        const mcv_result result = r->other_count > 0
                                      ? mcv_share_class(r, class, first, count, done_before, stop)
                                      : mcv_render_class(r, class, first, count, done_before, stop);
        r->in_round = false;
        if (result != MCV_OK || *stop) return result;
        ++r->part.class;
        r->part.sets = 0;
    }
    return mcv_render_light(r, mcv_tiled_pixels(r->film->width, r->film->height), first, count);
}
