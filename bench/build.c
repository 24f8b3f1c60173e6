/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Building the acceleration structure against Embree 3's builders, on all cores: bench_build
 * [--quick] [OUTPUT.json].
 *
 *   - Triangles per second against rtcCommitScene, which builds what Embree itself traces, of
 * medium and of high quality, and against rtcBuildBVH, Embree's builder for
 * structures of others, with eight children and leaves of four triangles;
 *   - the SAH cost, nodes and blocks of four triangles that a random line through the scene visits,
 * of ours and of what rtcBuildBVH makes, and rays per second of our kernels through either, on one
 * core by the processor's clock. High quality has as many spare references as ours; its calls back
 * for each split make it so slow that it is built once, up to 500 000 triangles;
 *   - the nodes and leaves that the rays of the benchmarks test in either, one by one;
 *   - bytes per triangle, against Embree's robust scene of high quality.
 */
#include <math.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#include "embree_builder.h"
#include "steps.h"
#include "workload.h"

enum { MEDIUM, HIGH, QUALITIES };
/* A robust scene of high quality has no spatial splits: Embree 3 builds it as one of medium
 * quality. Only without RTC_SCENE_FLAG_ROBUST are there any. */
enum { SPLIT = QUALITIES, COMMITS };
static const struct {
    enum RTCSceneFlags flags;
    enum RTCBuildQuality quality;
    const char *name;
} commits[COMMITS] = {[MEDIUM] = {RTC_SCENE_FLAG_ROBUST, RTC_BUILD_QUALITY_MEDIUM, "robust medium"},
                      [HIGH] = {RTC_SCENE_FLAG_ROBUST, RTC_BUILD_QUALITY_HIGH, "robust high"},
                      [SPLIT] = {RTC_SCENE_FLAG_NONE, RTC_BUILD_QUALITY_HIGH, "high, splits"}};
enum { SPLIT_MOST = 500000 }; /* triangles for rtcBuildBVH of high quality: 30 µs each */
static const enum RTCBuildQuality qualities[QUALITIES] = {RTC_BUILD_QUALITY_MEDIUM,
                                                          RTC_BUILD_QUALITY_HIGH};
static const char *const quality_names[QUALITIES] = {"medium", "high"};

typedef struct means {
    bench_mean builder, commit[COMMITS], cost[QUALITIES], steps[QUALITIES], rays[QUALITIES], bytes;
} means;

/* Half the surface of a child's box. */
static double area_of(const mcv_node *node, uint32_t i) {
    double d[3];
    for (int axis = 0; axis < 3; ++axis)
        d[axis] = (double)node->bounds[axis][1][i] - (double)node->bounds[axis][0][i];
    return d[0] * d[1] + d[1] * d[2] + d[2] * d[0];
}

/* Nodes and leaves that a line through the root's box visits on average. */
static double sah_cost(const mcv_bvh *bvh) {
    mcv_node whole;
    double sum = 0;
    for (int axis = 0; axis < 3; ++axis) {
        whole.bounds[axis][0][0] = INFINITY;
        whole.bounds[axis][1][0] = -INFINITY;
        for (uint32_t i = 0; i < MCV_BVH_WIDTH; ++i) {
            whole.bounds[axis][0][0] =
                fminf(whole.bounds[axis][0][0], bvh->nodes->bounds[axis][0][i]);
            whole.bounds[axis][1][0] =
                fmaxf(whole.bounds[axis][1][0], bvh->nodes->bounds[axis][1][i]);
        }
    }
    for (uint32_t i = 0; i < bvh->node_count; ++i) {
        for (uint32_t k = 0; k < MCV_BVH_WIDTH; ++k) {
            if (bvh->nodes[i].child[k] != MCV_NONE) sum += area_of(bvh->nodes + i, k);
        }
    }
    return 1 + sum / area_of(&whole, 0);
}

static double bytes_of(const mcv_bvh *bvh) {
    return (double)bvh->node_count * sizeof *bvh->nodes +
           (double)bvh->leaf_count * sizeof *bvh->leaves;
}

/* --- sides
 * ------------------------------------------------------------------------------------------------------
 */

typedef struct our_build {
    const mesh *mesh;
    mcv_bvh made;
} our_build;

static mcv_result our_run(void *user, mcv_error *error) {
    our_build *b = user;
    mcv_bvh_free(&b->made);
    return mcv_bvh_build(b->mesh->positions, b->mesh->indices, b->mesh->triangle_count, 0, &b->made,
                         error);
}

/* Builds again, as after a change. */
static mcv_result commit_run(void *user, mcv_error *error) {
    RTCScene scene = user;
    RTCGeometry geometry = rtcGetGeometry(scene, 0);
    (void)error;
    rtcUpdateGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0);
    rtcCommitGeometry(geometry);
    rtcCommitScene(scene);
    return MCV_OK;
}

static atomic_llong embree_bytes;

static bool count_bytes(void *user, ssize_t bytes, bool post) {
    (void)user, (void)post;
    atomic_fetch_add(&embree_bytes, bytes);
    return true;
}

typedef struct mesh_bench {
    bench *b;
    const workload_mesh *w;
    mcv_cl *core;
    our_build ours;
    embree_builder builders[QUALITIES];
    RTCScene scenes[COMMITS];
    workload_rays *rays;
    mcv_hit *hits, *others;
    caster casters[1 + QUALITIES]; /* ours, then Embree's */
    means *means;
    mcv_error *error;
} mesh_bench;

static mcv_result bench_seconds_of(mesh_bench *m) {
    bench_side sides[2 + COMMITS] = {{our_run, &m->ours, {{{0}}}, 0},
                                     {embree_builder_run, m->builders + MEDIUM, {{{0}}}, 0}};
    const double triangles = m->w->mesh.triangle_count;
    for (int k = 0; k < COMMITS; ++k)
        sides[2 + k] = (bench_side){.run = commit_run, .user = m->scenes[k]};
    MCV_TRY(bench_time(m->b, sides, 2 + COMMITS, m->error));
    bench_mean_add(&m->means->builder, bench_row(m->b, BENCH_WALL, sides, sides + 1, triangles,
                                                 "Mtri/s", "%s, rtcBuildBVH medium", m->w->name));
    for (int k = 0; k < COMMITS; ++k) {
        bench_mean_add(&m->means->commit[k],
                       bench_row(m->b, BENCH_WALL, sides, sides + 2 + k, triangles, "Mtri/s",
                                 "%s, rtcCommitScene %s", m->w->name, commits[k].name));
    }
    return MCV_OK;
}

/* What a ray tests, in ours and in what Embree's builders make. */
static void bench_steps(mesh_bench *m, int built, int kind) {
    const mcv_bvh *bvhs[1 + QUALITIES] = {&m->ours.made, &m->builders[MEDIUM].made,
                                          &m->builders[HIGH].made};
    const steps ours = steps_count(bvhs[0], m->rays->rays[kind], m->rays->count, false);
    for (int q = 0; q < built; ++q) {
        const steps theirs = steps_count(bvhs[1 + q], m->rays->rays[kind], m->rays->count, false);
        bench_mean_add(&m->means->steps[q],
                       bench_number(m->b, ours.nodes + ours.leaves, theirs.nodes + theirs.leaves,
                                    "steps/ray", "%s, closest %s, rtcBuildBVH %s", m->w->name,
                                    ray_kind_names[kind], quality_names[q]));
        bench_more(m->b, "leaves", ours.leaves);
        bench_more(m->b, "peer_leaves", theirs.leaves);
    }
}

/* The same rays through all hierarchies, whose hits agree to the last bit. */
static mcv_result bench_rays(mesh_bench *m, int built, int kind) {
    cast casts[1 + QUALITIES];
    bench_side sides[1 + QUALITIES];
    for (int i = 0; i <= built; ++i) {
        caster *c = m->casters + i;
        casts[i] = (cast){c, c->kernels[CLOSEST_MANY]};
        sides[i] = (bench_side){.run = cast_run, .user = casts + i};
        MCV_TRY(caster_take(c, m->rays->rays[kind], m->rays->count, m->error));
        MCV_TRY(cast_run(casts + i, m->error));
        mcv_hit *hits = i == 0 ? m->hits : m->others;
        MCV_TRY(mcv_cl_read(c->cl, c->out, 0, m->rays->count * sizeof *hits, hits, m->error));
        if (memcmp(hits, m->hits, m->rays->count * sizeof *hits) != 0)
            return mcv_fail(m->error, MCV_FAILED,
                            "%s: %s rays hit other triangles through Embree's hierarchy",
                            m->w->name, ray_kind_names[kind]);
    }
    MCV_TRY(bench_time(m->b, sides, 1 + (size_t)built, m->error));
    for (int q = 0; q < built; ++q) {
        bench_mean_add(&m->means->rays[q],
                       bench_row(m->b, BENCH_CPU, sides, sides + 1 + q, m->rays->count, "Mrays/s",
                                 "%s, closest %s, rtcBuildBVH %s", m->w->name, ray_kind_names[kind],
                                 quality_names[q]));
    }
    return MCV_OK;
}

static mcv_result bench_opened(mesh_bench *m, RTCDevice device) {
    const mesh *t = &m->w->mesh;
    const double triangles = t->triangle_count;
    double bytes = 0;
    for (int q = 0; q < QUALITIES; ++q)
        MCV_TRY(embree_builder_open(device, t, qualities[q], m->builders + q, m->error));
    for (int k = 0; k < COMMITS; ++k) {
        m->scenes[k] = embree_scene(device, t, commits[k].flags, commits[k].quality);
        const long long before = atomic_load(&embree_bytes);
        rtcCommitScene(m->scenes[k]);
        if (k == HIGH) bytes = (double)(atomic_load(&embree_bytes) - before);
    }
    MCV_TRY(bench_seconds_of(m));
    const int built = t->triangle_count <= SPLIT_MOST ? 2 : 1;
    if (built > HIGH) MCV_TRY(embree_builder_run(m->builders + HIGH, m->error));
    const mcv_bvh *bvhs[1 + QUALITIES] = {&m->ours.made, &m->builders[MEDIUM].made,
                                          &m->builders[HIGH].made};
    for (int q = 0; q < built; ++q) {
        MCV_TRY(embree_builder_convert(m->builders + q, m->ours.made.nodes->extent, m->error));
        bench_mean_add(&m->means->cost[q],
                       bench_number(m->b, sah_cost(&m->ours.made), sah_cost(bvhs[1 + q]),
                                    "SAH cost", "%s, rtcBuildBVH %s", m->w->name,
                                    quality_names[q]));
        bench_more(m->b, "peer_bytes", bytes_of(bvhs[1 + q]));
    }
    bench_number(m->b, bytes_of(&m->ours.made) / triangles, bytes / triangles, "bytes/tri",
                 "%s, Embree robust high", m->w->name);
    bench_mean_add(&m->means->bytes, bytes_of(&m->ours.made) / triangles);
    for (int i = 0; i <= built; ++i)
        MCV_TRY(caster_open(m->core, bvhs[i], m->casters + i, m->error));
    workload_make_rays(m->b, t, m->scenes[HIGH], m->others, m->rays);
    for (int kind = 0; kind < RAY_KINDS; ++kind) {
        bench_steps(m, built, kind);
        MCV_TRY(bench_rays(m, built, kind));
    }
    return MCV_OK;
}

static mcv_result bench_mesh(bench *b, mcv_cl *core, RTCDevice device, int i, means *all,
                             mcv_error *error) {
    workload_mesh w = {0};
    MCV_TRY(workload_load(i, &w, error));
    mesh_bench m = {.b = b,
                    .w = &w,
                    .core = core,
                    .ours.mesh = &w.mesh,
                    .rays = malloc(sizeof *m.rays),
                    .hits = malloc(MOST_RAYS * sizeof *m.hits),
                    .others = malloc(MOST_RAYS * sizeof *m.others),
                    .means = all,
                    .error = error};
    const bool memory = m.rays && m.hits && m.others;
    const mcv_result result =
        memory ? bench_opened(&m, device) : mcv_fail(error, MCV_FAILED, "no memory for the rays");
    for (int k = 0; k <= QUALITIES; ++k) caster_close(m.casters + k);
    for (int q = 0; q < QUALITIES; ++q) embree_builder_close(m.builders + q);
    for (int k = 0; k < COMMITS; ++k)
        if (m.scenes[k]) rtcReleaseScene(m.scenes[k]);
    mcv_bvh_free(&m.ours.made);
    free(m.rays);
    free(m.hits);
    free(m.others);
    mesh_free(&w.mesh);
    return result;
}

static mcv_result run(bench *b, mcv_error *error) {
    means all = {0};
    mcv_cl core;
    MCV_TRY(bench_cores(&b->cl, 1, &core, error));
    RTCDevice device = rtcNewDevice(NULL);
    rtcSetDeviceMemoryMonitorFunction(device, count_bytes, NULL);
    bench_title("Building: ours and Embree's builders on all cores; rays on one");
    mcv_result result = MCV_OK;
    for (int i = 0; i < WORKLOAD_MESHES && result == MCV_OK; ++i) {
        if (workload_wanted(b, i)) result = bench_mesh(b, &core, device, i, &all, error);
    }
    rtcReleaseDevice(device);
    mcv_cl_close(&core);
    MCV_TRY(result);
    bench_summary(b, "build_medium", bench_mean_value(&all.commit[MEDIUM]));
    bench_summary(b, "build_high", bench_mean_value(&all.commit[HIGH]));
    bench_summary(b, "build_split", bench_mean_value(&all.commit[SPLIT]));
    bench_summary(b, "builder_medium", bench_mean_value(&all.builder));
    bench_summary(b, "sah_cost_medium", bench_mean_value(&all.cost[MEDIUM]));
    bench_summary(b, "sah_cost_high", bench_mean_value(&all.cost[HIGH]));
    bench_summary(b, "steps_medium", bench_mean_value(&all.steps[MEDIUM]));
    bench_summary(b, "steps_high", bench_mean_value(&all.steps[HIGH]));
    bench_summary(b, "rays_medium", bench_mean_value(&all.rays[MEDIUM]));
    bench_summary(b, "rays_high", bench_mean_value(&all.rays[HIGH]));
    bench_summary(b, "bytes_per_triangle", bench_mean_value(&all.bytes));
    return MCV_OK;
}

int main(int argc, char **argv) { return bench_main(argc, argv, "build", run); }
