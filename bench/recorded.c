/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Nanoseconds per ray and stage in scenes of meshes, beside Embree's on the same rays:
 * bench_recorded [--quick] [--only TEXT] [--seed N] [OUTPUT.json]. Needs `./run deps peers`, whose
 * NumPy generates the scenes (bench/mesh_scenes.py).
 *
 * Launches of each scene on one core tell the stages' times, by the least ticks of each slice. The
 * rays, taken from the stream schedule in the order of the tile schedule, then go through
 * kernels/test/intersect.cl together, as in the render, and each alone, and through robust Embree,
 * high quality, one by one and in packets of 8 and 16. All times are the processor's.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "convergence.h"
#include "image_maker.h"
#include "recorder.h"
#include "scene/sensor_find.h"
#include "workload.h"

static const char *const scene_names[] = {
    "mesh board", "mesh part",      "mesh metal part", "mesh part in the sun",
    "mesh tray",  "mesh displaced", "mesh plate"};
enum { SCENES = sizeof scene_names / sizeof scene_names[0] };
static const char *const kind_names[RECORDED_KINDS] = {"primary", "bounced", "shadow",
                                                       "shadow to its emitter"};

enum { TOGETHER, ALONE, ROBUST, PACKETS_8, PACKETS_16, SIDES };
static const char *const side_names[SIDES] = {"ourselves", "ours, each ray alone", "Embree robust",
                                              "Embree robust, packets of 8",
                                              "Embree robust, packets of 16"};

typedef struct recorded {
    bench *b;
    const char *name;
    mcv_cl *core;
    drive tile, stream;
    ray_list lists[RECORDED_KINDS];
    caster caster;
    RTCScene robust;
    bench_mean *means; /* of the kinds */
    double least;
    mcv_error *error;
} recorded;

/* A tile drive and the ticks of its runs. */
typedef struct ticking {
    drive *drive;
    drive_ticks ticks;
} ticking;

static mcv_result run_ticking(void *user, mcv_error *error) {
    ticking *t = user;
    MCV_TRY(drive_run(t->drive, error));
    return drive_add_ticks(t->drive, &t->ticks, error);
}

static double items_of(const mcv_render_stats *stats, int stage) {
    if (stage == STAGE_generate_rays || stage == STAGE_accumulate_film) return (double)stats->paths;
    return (double)(stage == STAGE_intersect_shadow ? stats->shadow_rays : stats->rays);
}

static mcv_result time_stages(recorded *r) {
    ticking tile = {&r->tile, {NULL, 0}};
    bench_side side = {.run = run_ticking, .user = &tile};
    double seconds[STAGE_COUNT];
    const mcv_result result = bench_time(r->b, &side, 1, r->error);
    if (result == MCV_OK) drive_least_seconds(&r->tile, &tile.ticks, seconds);
    free(tile.ticks.least);
    MCV_TRY(result);
    for (int i = 0; i < STAGE_COUNT; ++i) {
        const double items = items_of(&r->tile.stats, i);
        if (seconds[i] <= 0 || items <= 0) continue;
        bench_number(r->b, 1e9 * seconds[i] / items, NAN, "ns", "%s, stage %s", r->name,
                     stage_names[i]);
        bench_more(r->b, "items", items);
    }
    return MCV_OK;
}

/* Our last closest hits are those of the render. *different: the share that Embree's, in `theirs`,
 * have not: it has no error bounds, and meets the surface again that a ray leaves. */
static mcv_result check_hits(const recorded *r, int kind, const mcv_hit *theirs,
                             double *different) {
    const ray_list *list = r->lists + kind;
    const uint32_t count = (uint32_t)list->count;
    mcv_hit *ours = malloc(count * sizeof *ours);
    if (!ours) return mcv_fail(r->error, MCV_FAILED, "no memory for the hits");
    mcv_result result =
        mcv_cl_read(r->core, r->caster.out, 0, count * sizeof *ours, ours, r->error);
    const bool same = kind > RECORDED_LATER || !memcmp(ours, list->hits, count * sizeof *ours);
    if (result == MCV_OK && !same)
        result = mcv_fail(r->error, MCV_FAILED, "%s, %s: recorded rays have other hits", r->name,
                          kind_names[kind]);
    *different = share_that_differs(ours, theirs, count);
    free(ours);
    return result;
}

/* The rays of one kind on all sides. */
static mcv_result time_rays(recorded *r, int kind) {
    const ray_list *list = r->lists + kind;
    const uint32_t count = (uint32_t)list->count;
    const bool any = kind == RECORDED_SHADOW_ANY;
    double different = NAN;
    mcv_hit *hits = calloc(count, sizeof *hits);
    int *found = calloc(count, sizeof *found);
    cast together = {&r->caster, r->caster.kernels[any ? ANY_MANY : CLOSEST_MANY]},
         alone = {&r->caster, r->caster.kernels[any ? ANY_ALONE : CLOSEST_ALONE]};
    embree_cast embree[SIDES];
    bench_side sides[SIDES] = {{.run = cast_run, .user = &together},
                               {.run = cast_run, .user = &alone}};
    for (int i = ROBUST; i < SIDES; ++i) {
        embree[i] = (embree_cast){r->robust, list->rays, count, 1, 1, any, hits, found};
        embree[i].width = i == PACKETS_8 ? 8 : i == PACKETS_16 ? 16 : 1;
        sides[i] = (bench_side){.run = embree_run, .user = embree + i};
    }
    mcv_result result = hits && found ? caster_take(&r->caster, list->rays, count, r->error)
                                      : mcv_fail(r->error, MCV_FAILED, "no memory for the rays");
    if (result == MCV_OK) result = bench_time(r->b, sides, SIDES, r->error);
    if (result == MCV_OK && !any) result = check_hits(r, kind, hits, &different);
    for (int i = ALONE; i < SIDES && result == MCV_OK; ++i) {
        const double ratio = bench_row(r->b, BENCH_CPU, sides, sides + i, count, "Mrays/s",
                                       "%s, %s, %s", r->name, kind_names[kind], side_names[i]);
        bench_more(r->b, "rays", count);
        bench_more(r->b, "share_that_differs", different);
        bench_more(r->b, "nanoseconds", 1e9 * bench_side_median(r->b, sides, BENCH_CPU) / count);
        bench_more(r->b, "peer_nanoseconds",
                   1e9 * bench_side_median(r->b, sides + i, BENCH_CPU) / count);
        if (i != ROBUST) continue;
        bench_mean_add(r->means + kind, ratio);
        r->least = fmin(r->least, ratio);
    }
    free(hits);
    free(found);
    return result;
}

static mcv_result bench_scene(recorded *r, const mcv_scene *scene, RTCDevice embree) {
    drive_options tile = drive_defaults(MCV_SCHEDULE_TILE),
                  stream = drive_defaults(MCV_SCHEDULE_STREAM);
    mcv_bvh bvh;
    tile.clock = true;
    tile.depth = stream.depth = 8;
    MCV_TRY(drive_open(r->core, scene, tile, &r->tile, r->error));
    MCV_TRY(drive_open(r->core, scene, stream, &r->stream, r->error));
    MCV_TRY(time_stages(r));
    MCV_TRY(record_rays(&r->stream, r->tile.schedule.slice, r->lists, r->error));
    mesh m = mesh_of_scene(scene, r->tile.device.packed.centre);
    mcv_result result = mcv_bvh_build(m.positions, m.indices, m.triangle_count, 0, &bvh, r->error);
    if (result == MCV_OK) {
        result = caster_open(r->core, &bvh, &r->caster, r->error);
        mcv_bvh_free(&bvh);
    }
    r->robust = embree_scene(embree, &m, RTC_SCENE_FLAG_ROBUST, RTC_BUILD_QUALITY_HIGH);
    rtcCommitScene(r->robust);
    mesh_free(&m);
    for (int kind = 0; kind < RECORDED_KINDS && result == MCV_OK; ++kind)
        if (r->lists[kind].count > 0) result = time_rays(r, kind);
    rtcReleaseScene(r->robust);
    return result;
}

static mcv_result load_scene(const bench *b, const char *name, mcv_scene **scene,
                             mcv_error *error) {
    char path[sizeof b->stem + 64], command[3 * sizeof path];
    snprintf(path, sizeof path, "%s-meshes", b->stem);
    snprintf(command, sizeof command,
             PYTHON " '" MCV_SOURCE_DIR "/bench/mesh_scenes.py' --seed %u '%s' '%s'", b->seed, path,
             name);
    if (access(PYTHON, X_OK) != 0)
        return mcv_fail(error, MCV_FAILED, "no NumPy: `./run deps peers` installs it");
    if (system(command) != 0)
        return mcv_fail(error, MCV_FAILED, "mesh_scenes.py did not write \"%s\"", name);
    const size_t folder = strlen(path);
    snprintf(path + folder, sizeof path - folder, "/%s.gltf", name);
    for (char *c = path + folder; *c; ++c)
        if (*c == ' ') *c = '-';
    MCV_TRY(mcv_scene_load(path, (mcv_overrides){NULL, 0}, scene, error));
    const uint64_t pixels = b->quick ? 64 : 128;
    return mcv_sensor_resize((*scene)->sensors, pixels, pixels, *scene, error);
}

static mcv_result run(bench *b, mcv_error *error) {
    bench_mean means[RECORDED_KINDS] = {{0}};
    double least = INFINITY;
    mcv_cl core;
    MCV_TRY(bench_cores(&b->cl, 1, &core, error));
    RTCDevice embree = rtcNewDevice(NULL);
    bench_title("Recorded rays: ours and its peers, one core, processor time");
    mcv_result result = MCV_OK;
    for (int i = 0; i < SCENES && result == MCV_OK; ++i) {
        mcv_scene *scene = NULL;
        if (b->only && !strstr(scene_names[i], b->only)) continue;
        recorded r = {.b = b,
                      .name = scene_names[i],
                      .core = &core,
                      .means = means,
                      .least = least,
                      .error = error};
        result = load_scene(b, r.name, &scene, error);
        if (result == MCV_OK) result = bench_scene(&r, scene, embree);
        least = r.least;
        caster_close(&r.caster);
        for (int k = 0; k < RECORDED_KINDS; ++k) ray_list_free(r.lists + k);
        drive_close(&r.tile);
        drive_close(&r.stream);
        mcv_scene_free(scene);
    }
    rtcReleaseDevice(embree);
    mcv_cl_close(&core);
    MCV_TRY(result);
    for (int k = 0; k < RECORDED_SHADOW_CLOSEST; ++k)
        if (means[k].count) bench_summary(b, kind_names[k], bench_mean_value(means + k));
    if (isfinite(least)) bench_summary(b, "least_row", least);
    return MCV_OK;
}

int main(int argc, char **argv) { return bench_main(argc, argv, "recorded", run); }
