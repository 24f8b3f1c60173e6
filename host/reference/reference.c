/* SPDX-License-Identifier: Apache-2.0 */
#include "reference/reference.h"

#include <float.h>
#include <math.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <unistd.h>

#include "core/basics.h"
#include "reference/path.h"
#include "scene/sensors.h"
#include "scene/spectra.h"

/* A pass: the samples [first, first + count) of every replicate of every pixel. Threads take whole
 * rows. */
typedef struct pass {
    const ref_world *world;
    const mcv_sensor *sensor;
    const mcv_render_options *options;
    const mcv_film *film; /* only its sizes are used */
    uint32_t stride;      /* a pixel of the film is as many of the sensor, in each direction */
    uint32_t size[2];     /* the sensor's pixels */
    double *sums;         /* laid out as the film's */
    ref_tally *rows;
    uint64_t first, count;
    atomic_uint next;
    atomic_bool stopped;
} pass;

/* The sensor's column or row that a sample of the film's takes: one of `stride`, at random. */
static uint32_t place_in(uint32_t at, uint32_t stride, uint32_t size, ref_random *random) {
    if (stride == 1) return at;
    const uint32_t place = (uint32_t)(((double)at + ref_random_unit(random)) * stride);
    return place < size ? place : size - 1;
}

/* Adds the samples of a power-of-two range over the film's binary tree. */
static void sum_samples(const pass *r, uint32_t column, uint32_t row, uint32_t replicate,
                        uint64_t first, uint64_t count, ref_tally *tally, double sum[3]) {
    if (count > 1) {
        double other[3];
        sum_samples(r, column, row, replicate, first, count / 2, tally, sum);
        sum_samples(r, column, row, replicate, first + count / 2, count / 2, tally, other);
        for (int channel = 0; channel < 3; ++channel) sum[channel] += other[channel];
        return;
    }
    ref_random random = ref_random_begin(r->options->seed, (uint64_t)row * r->film->width + column,
                                         replicate, first);
    double place[4];
    for (int i = 0; i < 4; ++i) place[i] = ref_random_unit(&random);
    const ref_sensor_ray sensor_ray = ref_sensor_ray_sample(
        r->sensor, place_in(column, r->stride, r->size[0], &random),
        place_in(row, r->stride, r->size[1], &random), place[0], place[1], place[2], place[3]);
    ref_path_value(r->world, &sensor_ray, &random, tally, sum);
    /* Values that an image of floats cannot represent count as not finite. */
    if (!(fmax(fabs(sum[0]), fmax(fabs(sum[1]), fabs(sum[2]))) <= FLT_MAX) ||
        !isfinite(sum[0] + sum[1] + sum[2])) {
        ++tally->nonfinite;
        sum[0] = sum[1] = sum[2] = 0;
    }
}

/* Renders the next row; false if none is left. */
static bool render_row(pass *r) {
    const uint32_t row = atomic_fetch_add(&r->next, 1);
    const mcv_film *film = r->film;
    if (row >= film->height || atomic_load(&r->stopped)) return false;
    for (uint32_t replicate = 0; replicate < film->replicates; ++replicate) {
        for (uint32_t column = 0; column < film->width; ++column) {
            double sum[3];
            sum_samples(r, column, row, replicate, r->first, r->count, &r->rows[row], sum);
            for (uint32_t channel = 0; channel < film->channels; ++channel)
                r->sums[(((size_t)replicate * film->channels + channel) * film->height + row) *
                            film->width +
                        column] = sum[channel];
        }
    }
    return true;
}

static void *render_rows(void *argument) {
    while (render_row(argument)) {}
    return NULL;
}

static uint32_t thread_count(const mcv_render_options *options, uint32_t rows) {
    const long cores = sysconf(_SC_NPROCESSORS_ONLN);
    const uint32_t wanted = options->threads > 0 ? options->threads
                            : cores > 0          ? (uint32_t)cores
                                                 : 1;
    return wanted < rows ? wanted : rows;
}

/* Renders a pass on several threads, of which the calling one alone reports progress. False:
 * stopped by the caller. */
static bool render_round(pass *r, pthread_t *threads, double start, double done, double share,
                         double error) {
    const uint32_t wanted = thread_count(r->options, r->film->height);
    uint32_t helpers = 0;
    atomic_store(&r->next, 0);
    while (helpers + 1 < wanted && pthread_create(&threads[helpers], NULL, render_rows, r) == 0)
        ++helpers; /* with fewer threads it is only slower */
    double told = mcv_seconds();
    while (render_row(r)) {
        if (!r->options->progress || mcv_seconds() - told < 0.1) continue;
        told = mcv_seconds();
        const double rows = fmin(atomic_load(&r->next), r->film->height) / r->film->height;
        if (!r->options->progress(r->options->user, done + share * rows, told - start, error))
            atomic_store(&r->stopped, true);
    }
    for (uint32_t i = 0; i < helpers; ++i) pthread_join(threads[i], NULL);
    return !atomic_load(&r->stopped);
}

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

/* With fewer samples the error estimate is not reliable. */
enum { FEWEST_SAMPLES = 16 };

static void render_rounds(pass *r, mcv_film *film, pthread_t *threads, double start,
                          mcv_render_stats *stats) {
    const mcv_render_options *options = r->options;
    const size_t values = (size_t)film->replicates * film->channels * film->height * film->width;
    const uint64_t wanted = options->last - options->first; /* 0: no end */
    ref_tally total = {0};
    double error = INFINITY;
    r->count = 1;
    while (wanted == 0 || film->samples < wanted) {
        const double begun = mcv_seconds();
        const double done = wanted                 ? (double)film->samples / (double)wanted
                            : options->seconds > 0 ? (begun - start) / options->seconds
                                                   : 0;
        r->first = options->first + film->samples;
        for (uint32_t row = 0; row < film->height; ++row) r->rows[row] = (ref_tally){0};
        if (!render_round(r, threads, start, done, wanted ? (double)r->count / (double)wanted : 0,
                          error))
            break;
        for (size_t i = 0; i < values; ++i) film->sums[i] += r->sums[i];
        film->samples += r->count;
        for (uint32_t row = 0; row < film->height; ++row) add_tally(&total, &r->rows[row]);
        const double end = mcv_seconds();
        if (stats->seconds_first_sample == 0) stats->seconds_first_sample = end - start;
        if (options->error > 0 || options->progress) error = mcv_film_relative_error(film);
        if (options->progress &&
            !options->progress(options->user,
                               wanted ? (double)film->samples / (double)wanted : done, end - start,
                               error)) {
            atomic_store(&r->stopped, true);
            break;
        }
        if (options->error > 0 && film->samples >= FEWEST_SAMPLES && error <= options->error) break;
        r->count = mcv_next_round(film->samples, 1, (end - begun) / (double)r->count, end - start,
                                  options->seconds);
        if (r->count == 0) break;
    }
    stats->paths = total.paths;
    stats->rays = total.rays;
    stats->shadow_rays = total.shadow_rays;
    stats->depth_cut = total.depth_cut;
    stats->nonfinite = total.nonfinite;
    stats->unmatched = total.unmatched;
    stats->lost_energy = total.begun > 0 ? total.cut / total.begun : 0;
    stats->seconds_render = mcv_seconds() - start - stats->seconds_build;
    stats->interrupted = atomic_load(&r->stopped);
}

/* How exact, and how soon: a draft has coarse tables, and stride x stride pixels in one. */
typedef struct manner {
    bool sample_emitters, draft;
    uint32_t stride;
} manner;

static mcv_result render(const mcv_scene *scene, uint32_t sensor, const mcv_render_options *options,
                         manner how, mcv_film *film, mcv_render_stats *stats, mcv_error *error) {
    const double start = mcv_seconds();
    *film = (mcv_film){0};
    *stats = (mcv_render_stats){.device = "reference (double precision)"};
    MCV_TRY(mcv_render_check_options(scene, sensor, options, false, error));
    ref_world world = {
        .scene = scene, .depth = options->depth, .sample_emitters = how.sample_emitters};
    pass r = {.world = &world,
              .sensor = &scene->sensors[sensor],
              .options = options,
              .film = film,
              .stride = how.stride};
    mcv_sensor_film_size(r.sensor, &r.size[0], &r.size[1]);
    const uint32_t width = (r.size[0] + how.stride - 1) / how.stride,
                   height = (r.size[1] + how.stride - 1) / how.stride;
    MCV_TRY(
        mcv_film_new(film, width, height, mcv_scene_channels(scene), options->replicates, error));

    pthread_t *threads = calloc(thread_count(options, height), sizeof *threads);
    int *winding = calloc(scene->instance_count + (size_t)1, sizeof *winding);
    r.sums = calloc((size_t)film->replicates * film->channels * height * width, sizeof *r.sums);
    r.rows = calloc(height, sizeof *r.rows);
    mcv_result result = MCV_OK;
    if (!threads || !winding || !r.sums || !r.rows)
        result = mcv_fail(error, MCV_FAILED,
                          "render: no memory for a round of %u x %u pixels; give fewer replicates",
                          width, height);
    if (result == MCV_OK) result = ref_geometry_new(scene, &world.geometry, error);
    if (result == MCV_OK) result = ref_emitters_new(scene, &world.emitters, error);
    if (result == MCV_OK) result = ref_gloss_tables_new(scene, how.draft, &world.gloss, error);
    if (result == MCV_OK) {
        const double lens[3] = {r.sensor->to_world.m[9], r.sensor->to_world.m[10],
                                r.sensor->to_world.m[11]};
        result = ref_media_at(&world.geometry, ref_from(lens), winding, &world.media, error);
    }
    if (result == MCV_OK) {
        stats->seconds_build = mcv_seconds() - start;
        render_rounds(&r, film, threads, start, stats);
    } else {
        mcv_film_free(film);
    }
    ref_emitters_free(&world.emitters);
    ref_gloss_tables_free(&world.gloss);
    ref_geometry_free(&world.geometry);
    free(r.rows);
    free(r.sums);
    free(winding);
    free(threads);
    return result;
}

mcv_result ref_render(const mcv_scene *scene, uint32_t sensor, const mcv_render_options *options,
                      bool sample_emitters, mcv_film *film, mcv_render_stats *stats,
                      mcv_error *error) {
    return render(scene, sensor, options, (manner){sample_emitters, false, 1}, film, stats, error);
}

mcv_result mcv_reference_draft(const mcv_scene *scene, uint32_t sensor,
                               const mcv_render_options *options, uint32_t stride, mcv_film *film,
                               mcv_error *error) {
    mcv_render_stats stats;
    return render(scene, sensor, options, (manner){true, true, stride}, film, &stats, error);
}

mcv_result mcv_reference_render(const mcv_scene *scene, uint32_t sensor,
                                const mcv_render_options *options, mcv_film *film,
                                mcv_render_stats *stats, mcv_error *error) {
    MCV_TRY(ref_render(scene, sensor, options, true, film, stats, error));
    const mcv_result result = mcv_render_check_finite(scene, sensor, stats, error);
    if (result != MCV_OK) mcv_film_free(film);
    return result;
}
