/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Where the time of a render goes: bench_stages [--quick] [OUTPUT.json].
 *
 * For each scene that ships, at fewer pixels on the same field of view, one launch of the samples 4
 * … 7 of four replicates:
 *   - seconds, items and bytes of path state of each stage, in the tile schedule (ticks of the
 * processor, kernels/schedule/clock.h) and as its peer in the stream schedule (one launch a stage);
 *   - the rays of that launch, taken from the stream schedule, in the order and the way
 * (kernels/traverse/trace_packet.h) of the tile schedule, through kernels/test/intersect.cl and
 * nothing else: rays per second as the peer of the stages that intersect;
 *   - the second half of a render of eight samples, which begins those very paths, with all that
 * the host does then: its rays per second over those of the bare traversal are the share of the
 * time that the render has for what it is about. All cores.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "drive.h"
#include "device/features.h"
#include "harness.h"
#include "recorder.h"

/* What each stage reads and writes of a path (the heads of the files in kernels/stage). */
static const int traffic[STAGE_COUNT][16] = {
    [STAGE_generate_rays] = {FIELD_origin, FIELD_direction, FIELD_weight, FIELD_throughput,
                             FIELD_radiance, FIELD_media, FIELD_density, FIELD_origin_surface},
    [STAGE_intersect_closest] = {FIELD_origin, FIELD_direction, FIELD_origin_surface, FIELD_hit},
    [STAGE_sample_emitters] = {FIELD_hit, FIELD_direction, FIELD_throughput, FIELD_media,
                               FIELD_shadow_origin, FIELD_shadow_direction, FIELD_shadow_target,
                               FIELD_shadow_origin_surface, FIELD_shadow_light},
    [STAGE_intersect_shadow] = {FIELD_shadow_origin, FIELD_shadow_direction, FIELD_shadow_target,
                                FIELD_shadow_origin_surface, FIELD_shadow_light, FIELD_radiance,
                                FIELD_radiance},
    [STAGE_shade_surfaces] = {FIELD_hit, FIELD_origin, FIELD_direction, FIELD_direction,
                              FIELD_throughput, FIELD_throughput, FIELD_radiance, FIELD_radiance,
                              FIELD_media, FIELD_media, FIELD_density, FIELD_density,
                              FIELD_origin_surface},
    [STAGE_accumulate_film] = {FIELD_weight, FIELD_radiance},
};

static double bytes_per_item(const mcv_packed *packed, int stage) {
    uint32_t words[FIELD_COUNT], sum = 0;
    recorder_field_words(packed, words);
    for (const int *field = traffic[stage]; *field != FIELD_END; ++field) sum += words[*field];
    return 4.0 * sum;
}

/* --- bare traversal
 * --------------------------------------------------------------------------------------------- */

typedef struct replay {
    mcv_cl *cl;
    const mcv_device_scene *scene;
    cl_program program;
    cl_kernel kernels[RECORDED_KINDS];
    cl_mem rays[RECORDED_KINDS], hits[RECORDED_KINDS];
    cl_uint counts[RECORDED_KINDS];
    int only; /* of the stages: 0 the closest, 1 the shadow rays */
} replay;

static const char *const kernel_names[RECORDED_KINDS] = {"closest_many", "closest_many", "any_many",
                                                         "closest_many"};

static mcv_result replay_open(const drive *d, const ray_list lists[RECORDED_KINDS], replay *r,
                              mcv_error *error) {
    *r = (replay){.cl = d->cl, .scene = &d->device};
    MCV_TRY(mcv_cl_build(r->cl, "test/intersect", "", &r->program, error));
    for (int k = 0; k < RECORDED_KINDS; ++k) {
        r->counts[k] = (cl_uint)lists[k].count;
        MCV_TRY(mcv_cl_kernel(r->program, kernel_names[k], &r->kernels[k], error));
        MCV_TRY(mcv_cl_buffer(r->cl, "the rays", lists[k].count * sizeof(batch_ray), lists[k].rays,
                              &r->rays[k], error));
        MCV_TRY(mcv_cl_buffer(r->cl, "the hits", lists[k].count * sizeof(mcv_hit), NULL,
                              &r->hits[k], error));
    }
    return MCV_OK;
}

static void replay_close(replay *r) {
    for (int k = 0; k < RECORDED_KINDS; ++k) {
        if (r->kernels[k]) clReleaseKernel(r->kernels[k]);
        mcv_cl_release(&r->rays[k]);
        mcv_cl_release(&r->hits[k]);
    }
    if (r->program) clReleaseProgram(r->program);
}

static mcv_result replay_run(void *user, mcv_error *error) {
    replay *r = user;
    const cl_uint slice = RAYS_PER_GROUP;
    for (int k = 0; k < RECORDED_KINDS; ++k) {
        if (r->counts[k] == 0 ||
            (r->only == 0 ? k >= RECORDED_SHADOW_ANY : k < RECORDED_SHADOW_ANY))
            continue;
        MCV_TRY(MCV_LAUNCH(r->cl, r->kernels[k], (r->counts[k] + slice - 1) / slice, 1, error,
                           MCV_ARG(r->scene->nodes), MCV_ARG(r->scene->leaves), MCV_ARG(r->rays[k]),
                           MCV_ARG(r->hits[k]), MCV_ARG(r->counts[k]), MCV_ARG(slice)));
    }
    return mcv_cl_finish(r->cl, error);
}

/* The bare traversal finds what the render found. */
static mcv_result replay_check(replay *r, const ray_list lists[RECORDED_KINDS], mcv_error *error) {
    r->only = 0;
    MCV_TRY(replay_run(r, error));
    for (int k = RECORDED_FIRST; k <= RECORDED_LATER; ++k) {
        mcv_hit *hits = malloc((lists[k].count + 1) * sizeof *hits);
        if (!hits) return mcv_fail(error, MCV_FAILED, "no memory to compare hits");
        mcv_result result =
            mcv_cl_read(r->cl, r->hits[k], 0, lists[k].count * sizeof *hits, hits, error);
        for (size_t i = 0; result == MCV_OK && i < lists[k].count; ++i) {
            if (memcmp(hits + i, lists[k].hits + i, sizeof *hits) != 0)
                result = mcv_fail(
                    error, MCV_FAILED,
                    "ray %zu of path %u hits triangle %u at %a in the render, %u at %a by itself",
                    i, lists[k].paths[i], lists[k].hits[i].primitive, (double)lists[k].hits[i].t,
                    hits[i].primitive, (double)hits[i].t);
        }
        free(hits);
        MCV_TRY(result);
    }
    return MCV_OK;
}

/* --- a whole render
 * --------------------------------------------------------------------------------------------- */

/* The second half of it: from when half of the samples are there. */
typedef struct half_render {
    const mcv_scene *scene;
    uint64_t samples; /* per replicate */
    mcv_render_stats stats;
    bench_seconds begin, end;
    uint64_t rays_at_begin, rays_at_end;
} half_render;

static bool note_progress(void *user, double fraction, double seconds, double error) {
    half_render *h = user;
    (void)seconds, (void)error;
    h->end = bench_now();
    h->rays_at_end = h->stats.rays + h->stats.shadow_rays;
    if (fraction > 0.5) return true;
    h->begin = h->end;
    h->rays_at_begin = h->rays_at_end;
    return true;
}

static mcv_result render_half(half_render *h, bench_seconds *seconds, mcv_error *error) {
    mcv_render_options options = mcv_render_defaults();
    mcv_film film;
    options.replicates = DRIVE_REPLICATES;
    options.no_light_paths = options.no_split = true; /* as the launches */
    options.last = h->samples;
    options.seconds =
        1e6; /* never; a render that samples alone may end would make one round of both halves */
    options.progress = note_progress;
    options.user = h;
    MCV_TRY(mcv_render(h->scene, 0, &options, &film, &h->stats, error));
    mcv_film_free(&film);
    for (int c = 0; c < 2; ++c) seconds->by[c] = h->end.by[c] - h->begin.by[c];
    return MCV_OK;
}

/* --- a scene
 * ----------------------------------------------------------------------------------------------------
 */

/* A drive whose stages are timed each by itself. */
typedef struct staged {
    drive drive;
    bench_side stages[STAGE_COUNT];
    int runs; /* the first is not counted */
} staged;

static mcv_result run_staged(void *user, mcv_error *error) {
    staged *s = user;
    double seconds[STAGE_COUNT];
    MCV_TRY(drive_run(&s->drive, error));
    MCV_TRY(drive_stage_seconds(&s->drive, seconds, error));
    for (int i = 0; i < STAGE_COUNT && s->runs > 0; ++i)
        s->stages[i].seconds[s->runs - 1].by[BENCH_WALL] = seconds[i];
    ++s->runs;
    return MCV_OK;
}

typedef struct scene_bench {
    bench *b;
    const char *name;
    staged tile, stream;
    ray_list lists[RECORDED_KINDS];
    replay replay;
    bench_mean *share, *share_of_processor;
    mcv_error *error;
} scene_bench;

static void items_of(const mcv_render_stats *stats, double items[STAGE_COUNT]) {
    items[STAGE_generate_rays] = items[STAGE_accumulate_film] = (double)stats->paths;
    items[STAGE_intersect_closest] = items[STAGE_sample_emitters] = items[STAGE_shade_surfaces] =
        (double)stats->rays;
    items[STAGE_intersect_shadow] = (double)stats->shadow_rays;
}

static mcv_result bench_schedules(scene_bench *s) {
    bench_side sides[] = {{run_staged, &s->tile, {{{0}}}, 0}, {run_staged, &s->stream, {{{0}}}, 0}};
    drive *tile = &s->tile.drive, *stream = &s->stream.drive;
    double items[STAGE_COUNT];
    MCV_TRY(drive_run(tile, s->error));
    MCV_TRY(drive_run(stream, s->error));
    if (memcmp(tile->sums, stream->sums, tile->sum_count * sizeof *tile->sums) != 0)
        return mcv_fail(s->error, MCV_FAILED, "%s: the schedules give different images", s->name);
    MCV_TRY(bench_time(s->b, sides, 2, s->error));
    items_of(&tile->stats, items);
    for (int i = 0; i < STAGE_COUNT; ++i) {
        /* The stages come first and in this order. Pupils are aimed once and not in each launch. */
        if (!stream->schedule.kernels[i] || i == STAGE_guide_pupils) continue;
        bench_row(s->b, BENCH_WALL, s->tile.stages + i, s->stream.stages + i, 0, "s", "%s, %s",
                  s->name, stage_names[i]);
        bench_more(s->b, "items", items[i]);
        bench_more(s->b, "bytes", items[i] * bytes_per_item(&tile->device.packed, i));
        bench_more(s->b, "nanoseconds",
                   1e9 * bench_side_median(s->b, s->tile.stages + i, BENCH_WALL) / items[i]);
    }
    bench_row(s->b, BENCH_WALL, sides, sides + 1, 0, "s", "%s, whole launch", s->name);
    bench_more(s->b, "items", (double)tile->stats.paths);
    bench_more(s->b, "bytes",
               (double)tile->stats.paths * 4 *
                   mcv_path_words(tile->device.packed.features, tile->device.packed.channels));
    return MCV_OK;
}

/* Renders and bare traversals in turns. */
static mcv_result bench_share(scene_bench *s) {
    bench *b = s->b;
    half_render half = {.scene = s->tile.drive.scene,
                        .samples = 2 * s->tile.drive.frame.first_sample};
    bench_side render = {0}, bare = {0}, bare_stages[2] = {0};
    const double closest =
        (double)s->lists[RECORDED_FIRST].count + (double)s->lists[RECORDED_LATER].count;
    const double shadow = (double)s->lists[RECORDED_SHADOW_ANY].count +
                          (double)s->lists[RECORDED_SHADOW_CLOSEST].count;
    MCV_TRY(replay_check(&s->replay, s->lists, s->error));
    for (int r = -1; r < b->repetitions; ++r) { /* the first does not count */
        const int at = r < 0 ? 0 : r;
        MCV_TRY(render_half(&half, &render.seconds[at], s->error));
        if ((double)(half.rays_at_end - half.rays_at_begin) != closest + shadow)
            return mcv_fail(s->error, MCV_FAILED,
                            "%s: %.0f rays were recorded, the render followed %.0f", s->name,
                            closest + shadow, (double)(half.rays_at_end - half.rays_at_begin));
        for (int stage = 0; stage < 2; ++stage) {
            s->replay.only = stage;
            const bench_seconds start = bench_now();
            MCV_TRY(replay_run(&s->replay, s->error));
            bare_stages[stage].seconds[at] = bench_since(start);
        }
        for (int c = 0; c < 2; ++c)
            bare.seconds[at].by[c] =
                bare_stages[0].seconds[at].by[c] + bare_stages[1].seconds[at].by[c];
    }
    bench_row(b, BENCH_WALL, s->tile.stages + STAGE_intersect_closest, bare_stages, closest,
              "Mrays/s", "%s, closest, bare", s->name);
    if (shadow > 0)
        bench_row(b, BENCH_WALL, s->tile.stages + STAGE_intersect_shadow, bare_stages + 1, shadow,
                  "Mrays/s", "%s, shadow, bare", s->name);
    bench_mean_add(s->share, bench_row(b, BENCH_WALL, &render, &bare, closest + shadow, "Mrays/s",
                                       "%s, render share", s->name));
    bench_mean_add(s->share_of_processor,
                   bench_row(b, BENCH_CPU, &render, &bare, closest + shadow, "Mrays/s",
                             "%s, render share of processor time", s->name));
    return MCV_OK;
}

static mcv_result bench_loaded(scene_bench *s, const mcv_scene *scene) {
    drive_options tile = drive_defaults(MCV_SCHEDULE_TILE),
                  stream = drive_defaults(MCV_SCHEDULE_STREAM);
    tile.clock = true;
    MCV_TRY(drive_open(&s->b->cl, scene, tile, &s->tile.drive, s->error));
    MCV_TRY(drive_open(&s->b->cl, scene, stream, &s->stream.drive, s->error));
    MCV_TRY(bench_schedules(s));
    /* Exact surfaces end rays, too: no bare traversal of triangles follows the same ones. */
    if (s->tile.drive.device.packed.features >> MCV_FEATURE_SURFACES & 1) return MCV_OK;
    MCV_TRY(record_rays(&s->stream.drive, s->tile.drive.schedule.slice, s->lists, s->error));
    MCV_TRY(replay_open(&s->stream.drive, s->lists, &s->replay, s->error));
    return bench_share(s);
}

static mcv_result bench_scene(bench *b, const char *name, bench_mean *share,
                              bench_mean *share_of_processor, mcv_error *error) {
    mcv_scene *scene = NULL;
    scene_bench *s = calloc(1, sizeof *s);
    if (!s) return mcv_fail(error, MCV_FAILED, "no memory");
    *s = (scene_bench){.b = b,
                       .name = name,
                       .share = share,
                       .share_of_processor = share_of_processor,
                       .error = error};
    mcv_result result = load_shipped(name, b->quick ? 1 << 12 : 1 << 14, &scene, error);
    if (result == MCV_OK) result = bench_loaded(s, scene);
    replay_close(&s->replay);
    for (int k = 0; k < RECORDED_KINDS; ++k) ray_list_free(s->lists + k);
    drive_close(&s->tile.drive);
    drive_close(&s->stream.drive);
    mcv_scene_free(scene);
    free(s);
    return result;
}

static mcv_result run(bench *b, mcv_error *error) {
    char *names[MAX_SCENES];
    size_t count;
    bench_mean share = {0}, share_of_processor = {0};
    MCV_TRY(shipped_scenes(b->only, names, &count, error));
    bench_title(
        "Stages: tile (ours) and stream schedule (peer); rays in a render (ours) and bare (peer)");
    mcv_result result = MCV_OK;
    for (size_t i = 0; i < count; ++i) {
        if (result == MCV_OK) result = bench_scene(b, names[i], &share, &share_of_processor, error);
        free(names[i]);
    }
    MCV_TRY(result);
    bench_summary(b, "render_share", bench_mean_value(&share));
    bench_summary(b, "render_share_of_processor", bench_mean_value(&share_of_processor));
    return MCV_OK;
}

int main(int argc, char **argv) { return bench_main(argc, argv, "stages", run); }
