/* SPDX-License-Identifier: Apache-2.0 */
/* The rounds of a render of the reference renderer: threads, sums, saving. */
#include "reference/rounds.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "core/basics.h"

/* --- saving --- */

static void add_tally(ref_tally *a, const ref_tally *b) {
    a->paths += b->paths;
    a->rays += b->rays;
    a->shadow_rays += b->shadow_rays;
    a->depth_cut += b->depth_cut;
    a->nonfinite += b->nonfinite;
    a->unmatched += b->unmatched;
    a->begun += b->begun;
    a->cut += b->cut;
}

static mcv_render_stats *count_total(const ref_tally *total, mcv_render_stats *stats) {
    stats->paths = total->paths;
    stats->rays = total->rays;
    stats->shadow_rays = total->shadow_rays;
    stats->depth_cut = total->depth_cut;
    stats->nonfinite = total->nonfinite;
    stats->unmatched = total->unmatched;
    stats->throughput = total->begun;
    stats->lost_energy = total->cut;
    return stats;
}

/* The film with the rows that are done from the first on; others may be at work. */
static void save_rows(const ref_pass *r, const mcv_render_stats *stats, double *copy) {
    const mcv_film *film = r->film;
    const double now = mcv_seconds();
    mcv_render_stats counted = *stats;
    ref_tally total = r->total;
    mcv_round part = r->part;
    uint64_t rows = part.sets;
    for (; rows < film->height && atomic_load(&r->done[rows]); ++rows)
        add_tally(&total, r->rows + rows);
    for (size_t plane = 0; plane < (size_t)film->replicates * film->channels; ++plane)
        memcpy(copy + plane * film->height * film->width,
               r->sums + plane * film->height * film->width, rows * film->width * sizeof *copy);
    part.sets = rows;
    part.sums = rows > 0 ? copy : NULL;
    counted.seconds_render = now - r->begun;
    const mcv_unfinished unfinished = {.film = film,
                                       .round = &part,
                                       .seconds = now - r->start,
                                       .stats = count_total(&total, &counted)};
    r->options->saving->save(r->options->user, &unfinished);
}

static void save_if_due(const ref_pass *r, const mcv_render_stats *stats, bool ending) {
    const mcv_film *film = r->film;
    const mcv_render_options *o = r->options;
    if (!o->saving || !o->saving->due(o->user, ending)) return;
    double *copy = calloc(mcv_film_values(film), sizeof *copy);
    if (copy) save_rows(r, stats, copy); /* else the checkpoint before stays */
    free(copy);
}

/* --- reports --- */

/* What the calling thread of a round tells and saves; it alone does. */
typedef struct round_report {
    double told;  /* when it last told [s] */
    double done;  /* share of the render before the round */
    double share; /* the round's */
    double error; /* relative, before the round */
    const mcv_render_stats *stats;
} round_report;

/* Tells the caller how far the render is, who may stop it; saves where that is due. */
static void tell(ref_pass *r, round_report *report) {
    const mcv_render_options *o = r->options;
    const double now = mcv_seconds();
    if (now - report->told < 0.1) return;
    report->told = now;
    const double rows = fmin(atomic_load(&r->next), r->film->height) / r->film->height;
    if (!o->progress(o->user, report->done + report->share * rows, now - r->start, report->error))
        atomic_store(&r->stopped, true);
    else
        save_if_due(r, report->stats, false);
}

/* Whether the round goes on. Each thread asks; report NULL: a helper of the calling one. */
static bool goes_on(ref_pass *r, round_report *report) {
    if (report && r->options->progress) tell(r, report);
    return !atomic_load(&r->stopped);
}

/* --- samples --- */

/* The sensor's column or row that a sample of the film's takes: one of `stride`, at random. */
static uint32_t place_in(uint32_t at, uint32_t stride, uint32_t size, ref_random *random) {
    if (stride == 1) return at;
    const uint32_t place = (uint32_t)(((double)at + ref_random_unit(random)) * stride);
    return place < size ? place : size - 1;
}

/* The samples after which a thread looks whether to go on: some milliseconds. */
enum { SAMPLES_UNASKED = 64 };

/* Adds the samples of a power-of-two range over the film's binary tree. What it adds is of no use
 * once the round is stopped. */
static void sum_samples(ref_pass *r, round_report *report, uint32_t column, uint32_t row,
                        uint32_t replicate, uint64_t first, uint64_t count, ref_tally *tally,
                        double sum[3]) {
    if (count > 1) {
        double other[3] = {0};
        sum[0] = sum[1] = sum[2] = 0;
        if (count == SAMPLES_UNASKED && !goes_on(r, report)) return;
        sum_samples(r, report, column, row, replicate, first, count / 2, tally, sum);
        sum_samples(r, report, column, row, replicate, first + count / 2, count / 2, tally, other);
        for (int channel = 0; channel < 3; ++channel) sum[channel] += other[channel];
        return;
    }
    ref_random random = ref_random_begin(r->options->seed, (uint64_t)row * r->film->width + column,
                                         replicate, first);
    double place[4];
    for (int i = 0; i < 4; ++i) place[i] = ref_random_unit(&random);
    const uint32_t at[2] = {place_in(column, r->stride, r->size[0], &random),
                            place_in(row, r->stride, r->size[1], &random)};
    const ref_sensor_ray sensor_ray =
        ref_sensor_ray_draw(r->world->scene, r->sensor, at[0], at[1], place, &random);
    ref_path_value(r->world, &sensor_ray, &random, tally, NULL, sum);
    /* Values that an image of floats cannot represent count as not finite. */
    if (!(fmax(fabs(sum[0]), fmax(fabs(sum[1]), fabs(sum[2]))) <= FLT_MAX) ||
        !isfinite(sum[0] + sum[1] + sum[2])) {
        ++tally->nonfinite;
        sum[0] = sum[1] = sum[2] = 0;
    }
}

/* Renders the next row; false if none is left, or the round is stopped. */
static bool render_row(ref_pass *r, round_report *report) {
    const uint32_t row = atomic_fetch_add(&r->next, 1);
    const mcv_film *film = r->film;
    if (row >= film->height) return false;
    for (uint32_t replicate = 0; replicate < film->replicates; ++replicate) {
        for (uint32_t column = 0; column < film->width; ++column) {
            double sum[3] = {0};
            sum_samples(r, report, column, row, replicate, r->part.first, r->part.count,
                        &r->rows[row], sum);
            if (!goes_on(r, report)) return false;
            for (uint32_t channel = 0; channel < film->channels; ++channel)
                r->sums[(((size_t)replicate * film->channels + channel) * film->height + row) *
                            film->width +
                        column] = sum[channel];
        }
    }
    atomic_store(&r->done[row], true);
    return true;
}

static void *render_rows(void *argument) {
    while (render_row(argument, NULL)) {}
    return NULL;
}

uint32_t ref_thread_count(const mcv_render_options *options, uint32_t rows) {
    const long cores = sysconf(_SC_NPROCESSORS_ONLN);
    const uint32_t wanted = options->threads > 0 ? options->threads
                            : cores > 0          ? (uint32_t)cores
                                                 : 1;
    return wanted < rows ? wanted : rows;
}

static mcv_result resume(ref_pass *r, mcv_film *film, mcv_render_stats *stats, mcv_error *error) {
    const mcv_unfinished *u = r->options->resume;
    MCV_TRY(mcv_unfinished_restore(r->options, film, stats, error));
    r->part = *u->round;
    r->part.sums = NULL;
    if (r->part.sets > film->height || !u->round->sums) r->part.sets = 0;
    if (u->round->sums) memcpy(r->sums, u->round->sums, mcv_film_values(film) * sizeof *r->sums);
    r->total = (ref_tally){.paths = stats->paths,
                           .rays = stats->rays,
                           .shadow_rays = stats->shadow_rays,
                           .depth_cut = stats->depth_cut,
                           .nonfinite = stats->nonfinite,
                           .unmatched = stats->unmatched,
                           .begun = u->stats->throughput,
                           .cut = u->stats->lost_energy};
    r->start -= u->seconds;
    r->begun -= u->stats->seconds_render;
    return MCV_OK;
}

/* --- rounds --- */

/* Renders a round on several threads, of which the calling one alone reports progress and saves.
 * False: stopped by the caller. */
static bool render_round(ref_pass *r, pthread_t *threads, round_report *report) {
    const uint32_t height = r->film->height, wanted = ref_thread_count(r->options, height);
    uint32_t helpers = 0;
    for (uint32_t row = 0; row < height; ++row) {
        r->rows[row] = (ref_tally){0};
        atomic_store(&r->done[row], row < r->part.sets);
    }
    atomic_store(&r->next, (uint32_t)r->part.sets);
    while (helpers + 1 < wanted && pthread_create(&threads[helpers], NULL, render_rows, r) == 0)
        ++helpers; /* with fewer threads it is only slower */
    report->told = mcv_seconds();
    while (render_row(r, report)) {}
    for (uint32_t i = 0; i < helpers; ++i) pthread_join(threads[i], NULL);
    if (atomic_load(&r->stopped)) save_if_due(r, report->stats, true);
    return !atomic_load(&r->stopped);
}

/* With fewer samples the error estimate is not reliable. */
enum { FEWEST_SAMPLES = 16 };

/* Adds the round that was rendered. */
static void end_round(ref_pass *r, mcv_film *film) {
    const size_t values = mcv_film_values(film);
    for (size_t i = 0; i < values; ++i) film->sums[i] += r->sums[i];
    film->samples += r->part.count;
    for (uint32_t row = 0; row < film->height; ++row) add_tally(&r->total, &r->rows[row]);
}

static double share_done(const ref_pass *r, uint64_t wanted, double now) {
    return wanted                    ? (double)r->film->samples / (double)wanted
           : r->options->seconds > 0 ? (now - r->start) / r->options->seconds
                                     : 0;
}

static void render_rounds(ref_pass *r, mcv_film *film, pthread_t *threads,
                          mcv_render_stats *stats) {
    const mcv_render_options *o = r->options;
    const uint64_t wanted = o->last - o->first; /* 0: no end */
    double error = film->samples > 0 ? mcv_film_relative_error(film) : INFINITY;
    while (wanted == 0 || film->samples < wanted) {
        const double begun = mcv_seconds();
        round_report report = {.done = share_done(r, wanted, begun),
                               .share = wanted ? (double)r->part.count / (double)wanted : 0,
                               .error = error,
                               .stats = stats};
        if (!render_round(r, threads, &report)) return;
        end_round(r, film);
        const double end = mcv_seconds();
        if (stats->seconds_first_sample == 0) stats->seconds_first_sample = end - r->start;
        if (o->error > 0 || o->progress) error = mcv_film_relative_error(film);
        if (o->progress &&
            !o->progress(o->user, share_done(r, wanted, begun), end - r->start, error))
            atomic_store(&r->stopped, true);
        const bool enough = o->error > 0 && film->samples >= FEWEST_SAMPLES && error <= o->error;
        const uint64_t count = mcv_next_round(
            film->samples, 1, (end - begun) / (double)r->part.count, end - r->start, o->seconds);
        if (enough || count == 0 || (wanted > 0 && film->samples >= wanted)) return;
        r->part = (mcv_round){.first = o->first + film->samples, .count = count};
        if (!atomic_load(&r->stopped)) continue;
        for (uint32_t row = 0; row < film->height; ++row) atomic_store(&r->done[row], false);
        save_if_due(r, stats, true);
        return;
    }
}

mcv_result ref_render_rounds(ref_pass *r, mcv_film *film, mcv_render_stats *stats,
                             mcv_error *error) {
    pthread_t *threads = calloc(ref_thread_count(r->options, film->height), sizeof *threads);
    r->sums = calloc(mcv_film_values(film), sizeof *r->sums);
    r->rows = calloc(film->height, sizeof *r->rows);
    r->done = calloc(film->height, sizeof *r->done);
    r->part = (mcv_round){.first = r->options->first, .count = 1};
    r->begun = mcv_seconds();
    mcv_result result = MCV_OK;
    if (!threads || !r->sums || !r->rows || !r->done)
        result = mcv_fail(error, MCV_FAILED,
                          "render: no memory for a round of %u x %u pixels; give fewer replicates",
                          film->width, film->height);
    if (result == MCV_OK && r->options->resume) result = resume(r, film, stats, error);
    if (result == MCV_OK) {
        render_rounds(r, film, threads, stats);
        count_total(&r->total, stats);
        stats->lost_energy = r->total.begun > 0 ? r->total.cut / r->total.begun : 0;
        stats->seconds_render = mcv_seconds() - r->begun;
        stats->interrupted = atomic_load(&r->stopped);
    }
    free(r->done);
    free(r->rows);
    free(r->sums);
    free(threads);
    return result;
}
