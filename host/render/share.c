/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Several devices share a pass over a class of pixels. Its sets are cut into tiles, which go in
 * their order to whoever is free. A pixel's sums do not depend on who rendered it, and light paths
 * are summed in integers: the bits are those of one device.
 *
 * A device that fails is given its tile again. If it fails once more in the pass, it is given up,
 * and the others render what it leaves. What light paths brought on a device lies on it until it is
 * taken off: where there are light paths, tiles are safe only then.
 */
#include "render/pass.h"

#include <math.h>
#include <pthread.h>
#include <stdlib.h>

enum {
    TILES_PER_DEVICE = 8, /* at least, where there are so many sets: the last ones end together */
    MOST_FAILURES = 1,    /* of a device in a pass */
};

/* Of a tile: nobody has it; it is safe; worker i renders it, or has rendered it. */
enum { TILE_FREE, TILE_SAFE, TILE_TAKEN, TILE_DONE = TILE_TAKEN + MCV_MOST_DEVICES };

typedef struct worker {
    struct share *share;
    mcv_renderer *at; /* its device */
    mcv_class_pass pass;
    mcv_render_stats stats; /* of tiles that are not yet safe, and of the first sample */
    mcv_error error;
    pthread_t thread;
    bool started, lost;
    uint32_t failures;
} worker;

typedef struct share {
    mcv_renderer *r, first; /* the first device has a copy, which is at work */
    worker workers[MCV_MOST_DEVICES];
    uint32_t worker_count;
    uint64_t begin, end; /* sets */
    uint32_t tile_sets;
    /* Under the lock: */
    pthread_mutex_t lock;
    pthread_cond_t changed;
    unsigned char *tiles;
    size_t tile_count, next, done; /* those from `next` on were never taken */
    size_t lowest;                 /* none below is free */
    uint32_t busy, news;           /* workers in a tile; tiles that have ended since last asked */
    bool hold, over;               /* only tiles below `next` may be taken; none at all */
} share;

/* --- workers --- */

static uint32_t number_of(const worker *w) { return (uint32_t)(w - w->share->workers); }

static size_t lowest_free(share *s) {
    while (s->lowest < s->tile_count && s->tiles[s->lowest] != TILE_FREE) ++s->lowest;
    return s->lowest;
}

static mcv_result render_tile(worker *w, size_t tile) {
    const share *s = w->share;
    const uint64_t set = s->begin + (uint64_t)tile * s->tile_sets;
    const uint64_t sets = s->end - set < s->tile_sets ? s->end - set : s->tile_sets;
    for (uint64_t sample = 0; sample < w->pass.count;)
        MCV_TRY(mcv_class_pass_launch(w->at, &w->pass, set, (uint32_t)sets, &sample));
    mcv_class_pass_read(w->at, &w->pass);
    return MCV_OK;
}

/* What the worker has rendered since its tiles were safe is to be rendered again. */
static void release_tiles(worker *w) {
    share *s = w->share;
    for (size_t i = 0; i < s->next; ++i) {
        if (s->tiles[i] != TILE_DONE + number_of(w)) continue;
        s->tiles[i] = TILE_FREE;
        --s->done;
    }
    s->lowest = 0;
    w->stats = (mcv_render_stats){.seconds_first_sample = w->stats.seconds_first_sample};
}

/* After a failure, before the lock is taken: the device is to be as it was. */
static bool restore_device(worker *w) {
    mcv_renderer *at = w->at;
    mcv_error ignored;
    mcv_schedule_abandon(&at->schedule);
    w->pass.readback.pending = false;
    return !at->scene.splats || (mcv_cl_clear(&at->cl, at->scene.splats,
                                              8 * mcv_film_values(at->film), &ignored) == MCV_OK &&
                                 mcv_cl_finish(&at->cl, &ignored) == MCV_OK);
}

static void *work(void *user) {
    worker *w = user;
    share *s = w->share;
    pthread_mutex_lock(&s->lock);
    while (!s->over && !w->lost) {
        const size_t tile = lowest_free(s);
        if (tile == s->tile_count || (s->hold && tile >= s->next)) {
            pthread_cond_wait(&s->changed, &s->lock);
            continue;
        }
        s->tiles[tile] = (unsigned char)(TILE_TAKEN + number_of(w));
        if (tile >= s->next) s->next = tile + 1;
        ++s->busy;
        pthread_mutex_unlock(&s->lock);
        const mcv_render_stats before = w->stats;
        const mcv_result result = render_tile(w, tile);
        const bool restored = result == MCV_OK || restore_device(w);
        pthread_mutex_lock(&s->lock);
        --s->busy;
        ++s->news;
        if (result == MCV_OK) {
            s->tiles[tile] = (unsigned char)(TILE_DONE + number_of(w));
            ++s->done;
        } else {
            s->tiles[tile] = TILE_FREE;
            if (tile < s->lowest) s->lowest = tile;
            w->stats = before;
            if (w->at->scene.splats) release_tiles(w);
            w->lost = !restored || result != MCV_DEVICE || ++w->failures > MOST_FAILURES;
        }
        pthread_cond_broadcast(&s->changed);
    }
    pthread_mutex_unlock(&s->lock);
    return NULL;
}

/* --- the pass --- */

static void merge_stats(const mcv_render_stats *from, mcv_render_stats *to) {
    to->paths += from->paths;
    to->rays += from->rays;
    to->shadow_rays += from->shadow_rays;
    to->depth_cut += from->depth_cut;
    to->lost_energy += from->lost_energy;
    to->nonfinite += from->nonfinite;
    to->unmatched += from->unmatched;
    to->saturated += from->saturated;
    if (to->seconds_first_sample == 0) to->seconds_first_sample = from->seconds_first_sample;
    for (uint32_t i = 0; i < from->stage_count; ++i)
        mcv_add_stage(to, from->stages[i].name, from->stages[i].seconds);
}

/* With no worker in a tile: makes all that is done safe. False if a device failed now, so that
 * tiles are free again. */
static bool secure(share *s) {
    bool all = true;
    for (uint32_t i = 0; i < s->worker_count; ++i) {
        worker *w = s->workers + i;
        if (w->lost && w->at->scene.splats) continue;
        if (!w->lost && mcv_take_splats(w->at, s->r->splats) != MCV_OK) {
            w->lost = true;
            release_tiles(w);
            all = false;
            continue;
        }
        for (size_t tile = 0; tile < s->next; ++tile)
            if (s->tiles[tile] == TILE_DONE + i) s->tiles[tile] = TILE_SAFE;
        merge_stats(&w->stats, s->r->stats);
        w->stats = (mcv_render_stats){.seconds_first_sample = w->stats.seconds_first_sample};
    }
    return all;
}

static bool all_are_lost(const share *s) {
    for (uint32_t i = 0; i < s->worker_count; ++i)
        if (!s->workers[i].lost) return false;
    return true;
}

/* Every tile that was taken is done. */
static bool is_drained(share *s) { return s->busy == 0 && lowest_free(s) >= s->next; }

static void save(mcv_renderer *r, bool ending) {
    if (!mcv_save_is_due(r, ending)) return;
    r->part.sums = r->round;
    mcv_save_unfinished(r);
}

/* Tells of the progress, and saves, until all is done, or the caller stops it. The lock is held,
 * but not while others are at work in calls. */
static void watch(share *s, mcv_pixel_class class, uint64_t count, double done_before, bool *stop) {
    mcv_renderer *r = s->r;
    const uint64_t before = r->part.sets, all = before + (s->end - s->begin);
    while (!all_are_lost(s)) {
        if ((s->hold || s->done == s->tile_count) && is_drained(s)) {
            const bool safe = secure(s);
            if (safe) {
                r->part.sets = before + s->next * s->tile_sets;
                if (r->part.sets > all) r->part.sets = all;
                save(r, *stop);
                s->hold = false;
                if (*stop || s->next == s->tile_count) return;
            }
            pthread_cond_broadcast(&s->changed);
            if (!safe) continue;
        }
        while (s->news == 0) pthread_cond_wait(&s->changed, &s->lock);
        s->news = 0;
        const double share_done = (double)(before + s->done * s->tile_sets) / (double)all;
        pthread_mutex_unlock(&s->lock);
        if (!*stop) *stop = !mcv_class_pass_tell(r, class, count, fmin(share_done, 1), done_before);
        const bool due = mcv_save_is_due(r, *stop);
        pthread_mutex_lock(&s->lock);
        s->hold = s->hold || *stop || due;
    }
}

/* The renderer of a device, as the first one stands. */
static mcv_result prepare(worker *w, mcv_pixel_class class, uint64_t first, uint64_t count) {
    const mcv_renderer *r = w->share->r;
    mcv_renderer *at = w->at;
    const bool has_list = at->frame.listed;
    at->stats = &w->stats;
    at->error = &w->error;
    at->frame = r->frame;
    at->listed = r->listed;
    at->warming = 0;
    w->stats.seconds_first_sample = r->stats->seconds_first_sample;
    if (r->listed && !has_list)
        MCV_TRY(mcv_upload_list(at, (size_t)r->film->width * r->film->height));
    return mcv_class_pass_begin(at, class, first, count, &w->pass);
}

/* The workers with their devices, and the tiles. */
static mcv_result begin(share *s, mcv_pixel_class class, uint64_t first, uint64_t count) {
    mcv_renderer *r = s->r;
    uint32_t most = 0;
    s->first = *r;
    s->worker_count = 1 + r->other_count;
    for (uint32_t i = 0; i < s->worker_count; ++i) {
        worker *w = s->workers + i;
        w->share = s;
        w->at = i == 0 ? &s->first : &r->others[i - 1]->renderer;
        w->lost = prepare(w, class, first, count) != MCV_OK;
        if (!w->lost && (most == 0 || w->pass.sets_per_launch < most))
            most = w->pass.sets_per_launch;
    }
    const uint64_t first_set = (uint64_t) class.first * r->film->replicates;
    s->begin = first_set + r->part.sets;
    s->end = first_set + (uint64_t) class.count * r->film->replicates;
    const uint64_t fine = (s->end - s->begin) / (TILES_PER_DEVICE * ((uint64_t)r->other_count + 1));
    s->tile_sets = 1 + (uint32_t)(fine < most ? fine : most > 0 ? most - 1 : 0);
    s->tile_count = (s->end - s->begin + s->tile_sets - 1) / s->tile_sets;
    s->tiles = calloc(s->tile_count, 1);
    return s->tiles ? MCV_OK : mcv_fail(r->error, MCV_FAILED, "no memory for tiles");
}

/* Gives up what is lost; an error if nothing is left. */
static mcv_result give_up_lost(share *s) {
    mcv_renderer *r = s->r;
    const bool none = all_are_lost(s);
    for (uint32_t i = r->other_count; i-- > 0;)
        if (s->workers[i + 1].lost) mcv_give_up_other(r, i, &s->workers[i + 1].error);
    if (!s->workers[0].lost) return MCV_OK;
    *r->error = s->workers[0].error;
    if (none) return MCV_DEVICE;
    mcv_give_up_first(r, &s->workers[0].error);
    return MCV_OK;
}

static void end(share *s) {
    mcv_renderer *r = s->r;
    for (uint32_t i = 0; i < s->worker_count; ++i) {
        worker *w = s->workers + i;
        if (w->started) pthread_join(w->thread, NULL);
        r->warming = fmax(r->warming, w->at->warming);
        w->at->listed = NULL;
        mcv_class_pass_end(&w->pass);
    }
    r->schedule = s->first.schedule;
    pthread_cond_destroy(&s->changed);
    pthread_mutex_destroy(&s->lock);
    free(s->tiles);
}

mcv_result mcv_share_class(mcv_renderer *r, mcv_pixel_class class, uint64_t first, uint64_t count,
                           double done_before, bool *stop) {
    share *s = calloc(1, sizeof *s);
    if (!s) return mcv_fail(r->error, MCV_FAILED, "no memory for the work of several devices");
    s->r = r;
    pthread_mutex_init(&s->lock, NULL);
    pthread_cond_init(&s->changed, NULL);
    mcv_result result = begin(s, class, first, count);
    pthread_mutex_lock(&s->lock);
    for (uint32_t i = 0; result == MCV_OK && i < s->worker_count; ++i) {
        worker *w = s->workers + i;
        w->started = !w->lost && pthread_create(&w->thread, NULL, work, w) == 0;
        if (!w->started && !w->lost) mcv_fail(&w->error, MCV_DEVICE, "no thread for a device");
        w->lost = !w->started;
    }
    if (result == MCV_OK) watch(s, class, count, done_before, stop);
    s->over = true;
    pthread_cond_broadcast(&s->changed);
    pthread_mutex_unlock(&s->lock);
    end(s);
    if (result == MCV_OK) result = give_up_lost(s);
    free(s);
    return result;
}
