/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Rays per second against Embree 3 (rtcIntersect1, rtcOccluded1 and packets, high build quality):
 * bench_traversal [--quick] [OUTPUT.json].
 *
 * Our rays go the way that the renderer would take (kernels/traverse/trace_packet.h). On one core
 * the peers are Embree's robust scene, whose answers are comparable to ours, ray by ray and in
 * packets of 8 and of 16, its fast one, and a scalar binary hierarchy of ours (bvh2.cl), timed by
 * the processor's clock, which other programs disturb less; on all cores Embree's robust scene, by
 * the wall's. The core scaling of a row is our speed-up from one core to all over Embree's, by the
 * wall's clock. The summary holds geometric means of the ratios to robust Embree on one core.
 */
#include <math.h>
#include <stdlib.h>

#include "bvh2.h"
#include "workload.h"

enum { OURS, OURS_ALL, ROBUST, ROBUST_ALL, PACKETS_8, PACKETS_16, FAST, PLAIN, SIDES };
static const char *const peer_names[SIDES] = {[OURS] = "ourselves",
                                              [OURS_ALL] = "ourselves",
                                              [ROBUST] = "Embree robust",
                                              [ROBUST_ALL] = "Embree robust",
                                              [PACKETS_8] = "Embree robust, packets of 8",
                                              [PACKETS_16] = "Embree robust, packets of 16",
                                              [FAST] = "Embree fast",
                                              [PLAIN] = "scalar BVH2"};

/* Bounces only ask for the closest hit. */
static const bool is_asked[RAY_KINDS][2] = {
    [PRIMARY] = {true, true}, [DIFFUSE] = {true, true}, [GLOSSY] = {true, false},
    [LATER] = {true, false},  [SHADOW] = {true, true},  [RANDOM] = {true, true}};

typedef struct means {
    bench_mean closest[RAY_KINDS], any, scaling, packets[2], fast, plain;
    double least; /* ratio of a row to robust single rays */
} means;

typedef struct mesh_bench {
    bench *b;
    const char *name;
    caster one, all, plain; /* ours on one core and on all; the binary hierarchy on one */
    RTCScene robust, fast;
    workload_rays *rays;
    mcv_hit *hits, *others;
    int *found, *other_found;
    means *means;
    mcv_error *error;
} mesh_bench;

/* Our answers against those of a side that has run: closest hits, and whether there is any. */
static mcv_result compare(const mesh_bench *m, int kind, int side, bool any, const mcv_hit *hits,
                          const int *found) {
    const uint32_t count = m->rays->count;
    double different = 0;
    for (uint32_t i = 0; any && i < count; ++i)
        different += (found[i] != (m->hits[i].primitive != MCV_NONE)) / (double)count;
    if (!any) different = share_that_differs(m->hits, hits, count);
    /* Ours must agree with each other; the others are not watertight or have other boxes. */
    if (different <= (side <= OURS_ALL ? 0 : 1e-3)) return MCV_OK;
    return mcv_fail(m->error, MCV_FAILED, "%s, %s: %.2f %% of the %s hits differ between us and %s",
                    m->name, ray_kind_names[kind], 100 * different, any ? "any" : "closest",
                    peer_names[side]);
}

/* Runs each side once and compares what it finds. */
static mcv_result check(const mesh_bench *m, int kind, bool any, bench_side sides[SIDES]) {
    for (int side = 0; side < SIDES; ++side) {
        MCV_TRY(sides[side].run(sides[side].user, m->error));
        if (sides[side].run == embree_run) {
            MCV_TRY(compare(m, kind, side, any, m->others, m->other_found));
            continue;
        }
        const caster *c = ((const cast *)sides[side].user)->caster;
        /* The first to run are the closest hits of ours. */
        mcv_hit *hits = side == OURS ? m->hits : m->others;
        MCV_TRY(mcv_cl_read(c->cl, c->out, 0,
                            m->rays->count * (any ? sizeof *m->found : sizeof *hits),
                            any ? (void *)m->found : (void *)hits, m->error));
        MCV_TRY(compare(m, kind, side, any, hits, m->found));
    }
    return MCV_OK;
}

/* The median over the repetitions of how much better we use all cores. */
static double core_scaling(const bench *b, const bench_side sides[SIDES]) {
    double ratios[BENCH_REPETITIONS];
    for (int r = 0; r < b->repetitions; ++r) {
        double seconds[SIDES];
        for (int i = 0; i < SIDES; ++i) seconds[i] = sides[i].seconds[r].by[BENCH_WALL];
        ratios[r] = seconds[OURS] / seconds[OURS_ALL] * seconds[ROBUST_ALL] / seconds[ROBUST];
    }
    return bench_median(ratios, b->repetitions);
}

static mcv_result bench_kind(mesh_bench *m, int kind, bool any) {
    bench *b = m->b;
    const int kernel = any ? ANY_MANY : CLOSEST_MANY;
    const char *what = any ? "any" : "closest";
    caster *one = &m->one, *all = &m->all, *plain = &m->plain;
    cast casts[SIDES] = {[OURS] = {one, one->kernels[kernel]},
                         [OURS_ALL] = {all, all->kernels[kernel]},
                         [PLAIN] = {plain, plain->kernels[kernel]}};
    embree_cast robust = {m->robust, m->rays->rays[kind], m->rays->count, 1, 1,
                          any,       m->others,           m->other_found};
    embree_cast robust_all = robust, packets_8 = robust, packets_16 = robust, fast = robust;
    robust_all.threads = b->cl.units;
    packets_8.width = 8;
    packets_16.width = 16;
    fast.scene = m->fast;
    bench_side sides[SIDES] = {[OURS] = {cast_run, casts + OURS, {{{0}}}, 0},
                               [OURS_ALL] = {cast_run, casts + OURS_ALL, {{{0}}}, 0},
                               [ROBUST] = {embree_run, &robust, {{{0}}}, 0},
                               [PACKETS_8] = {embree_run, &packets_8, {{{0}}}, 0},
                               [PACKETS_16] = {embree_run, &packets_16, {{{0}}}, 0},
                               [FAST] = {embree_run, &fast, {{{0}}}, 0},
                               [ROBUST_ALL] = {embree_run, &robust_all, {{{0}}}, 0},
                               [PLAIN] = {cast_run, casts + PLAIN, {{{0}}}, 0}};
    MCV_TRY(check(m, kind, any, sides));
    MCV_TRY(bench_time(b, sides, SIDES, m->error));
    double ratios[SIDES];
    for (int peer = ROBUST; peer < SIDES; ++peer) {
        if (peer == ROBUST_ALL) continue;
        ratios[peer] =
            bench_row(b, BENCH_CPU, sides + OURS, sides + peer, m->rays->count, "Mrays/s",
                      "%s, %s %s, %s", m->name, what, ray_kind_names[kind], peer_names[peer]);
        bench_more(b, "cores", 1);
    }
    bench_row(b, BENCH_WALL, sides + OURS_ALL, sides + ROBUST_ALL, m->rays->count, "Mrays/s",
              "%s, %s %s, Embree robust on %u cores", m->name, what, ray_kind_names[kind],
              b->cl.units);
    const double scaling = core_scaling(b, sides);
    bench_more(b, "cores", b->cl.units);
    bench_more(b, "core_scaling", scaling);
    bench_mean_add(any ? &m->means->any : &m->means->closest[kind], ratios[ROBUST]);
    m->means->least = fmin(m->means->least, ratios[ROBUST]);
    for (int i = 0; i < 2; ++i) bench_mean_add(&m->means->packets[i], ratios[PACKETS_8 + i]);
    bench_mean_add(&m->means->fast, ratios[FAST]);
    bench_mean_add(&m->means->plain, ratios[PLAIN]);
    bench_mean_add(&m->means->scaling, scaling);
    return MCV_OK;
}

static mcv_result open_ours(mesh_bench *m, mcv_cl *core, const mesh *t) {
    mcv_bvh bvh;
    MCV_TRY(mcv_bvh_build(t->positions, t->indices, t->triangle_count, 0, &bvh, m->error));
    mcv_result result = caster_open(core, &bvh, &m->one, m->error);
    if (result == MCV_OK) result = caster_open(&m->b->cl, &bvh, &m->all, m->error);
    mcv_bvh_free(&bvh);
    return result;
}

static mcv_result open_plain(mesh_bench *m, mcv_cl *core, const mesh *t) {
    bvh2 plain;
    m->plain.cl = core;
    MCV_TRY(bvh2_program(core, &m->plain.program, m->error));
    MCV_TRY(
        mcv_cl_kernel(m->plain.program, "bvh2_closest", &m->plain.kernels[CLOSEST_MANY], m->error));
    MCV_TRY(mcv_cl_kernel(m->plain.program, "bvh2_any", &m->plain.kernels[ANY_MANY], m->error));
    MCV_TRY(bvh2_build(t->positions, t->indices, t->triangle_count, &plain, m->error));
    mcv_result result = mcv_cl_buffer(core, "the nodes", plain.node_count * sizeof *plain.nodes,
                                      plain.nodes, &m->plain.nodes, m->error);
    if (result == MCV_OK) {
        result =
            mcv_cl_buffer(core, "the triangles", plain.triangle_count * sizeof *plain.triangles,
                          plain.triangles, &m->plain.leaves, m->error);
    }
    bvh2_free(&plain);
    return result;
}

static mcv_result bench_opened(mesh_bench *m, mcv_cl *core, const mesh *t) {
    MCV_TRY(open_ours(m, core, t));
    MCV_TRY(open_plain(m, core, t));
    rtcCommitScene(m->robust);
    rtcCommitScene(m->fast);
    workload_make_rays(m->b, t, m->robust, m->others, m->rays);
    for (int kind = 0; kind < RAY_KINDS; ++kind) {
        caster *const casters[] = {&m->one, &m->all, &m->plain};
        for (int i = 0; i < 3; ++i)
            MCV_TRY(caster_take(casters[i], m->rays->rays[kind], m->rays->count, m->error));
        for (int any = 0; any < 2; ++any)
            if (is_asked[kind][any]) MCV_TRY(bench_kind(m, kind, any));
    }
    return MCV_OK;
}

static mcv_result bench_mesh(bench *b, mcv_cl *core, RTCDevice embree, int i, means *all,
                             mcv_error *error) {
    workload_mesh w = {0};
    MCV_TRY(workload_load(i, &w, error));
    mesh_bench m = {
        .b = b,
        .name = w.name,
        .robust = embree_scene(embree, &w.mesh, RTC_SCENE_FLAG_ROBUST, RTC_BUILD_QUALITY_HIGH),
        .fast = embree_scene(embree, &w.mesh, RTC_SCENE_FLAG_NONE, RTC_BUILD_QUALITY_HIGH),
        .rays = malloc(sizeof *m.rays),
        .hits = malloc(MOST_RAYS * sizeof *m.hits),
        .others = malloc(MOST_RAYS * sizeof *m.others),
        .found = malloc(MOST_RAYS * sizeof *m.found),
        .other_found = malloc(MOST_RAYS * sizeof *m.other_found),
        .means = all,
        .error = error};
    const bool memory = m.rays && m.hits && m.others && m.found && m.other_found;
    const mcv_result result = memory ? bench_opened(&m, core, &w.mesh)
                                     : mcv_fail(error, MCV_FAILED, "no memory for the rays");
    caster_close(&m.one);
    caster_close(&m.all);
    caster_close(&m.plain);
    rtcReleaseScene(m.robust);
    rtcReleaseScene(m.fast);
    free(m.rays);
    free(m.hits);
    free(m.others);
    free(m.found);
    free(m.other_found);
    mesh_free(&w.mesh);
    return result;
}

static mcv_result run(bench *b, mcv_error *error) {
    means all = {.least = INFINITY};
    mcv_cl core;
    MCV_TRY(bench_cores(&b->cl, 1, &core, error));
    RTCDevice embree = rtcNewDevice(NULL);
    bench_title(
        "Traversal: ours and its peers, one core by the processor's clock, all by the wall's");
    mcv_result result = MCV_OK;
    for (int i = 0; i < WORKLOAD_MESHES && result == MCV_OK; ++i) {
        if (workload_wanted(b, i)) result = bench_mesh(b, &core, embree, i, &all, error);
    }
    rtcReleaseDevice(embree);
    mcv_cl_close(&core);
    MCV_TRY(result);
    bench_summary(b, "closest_primary", bench_mean_value(&all.closest[PRIMARY]));
    bench_summary(b, "closest_diffuse", bench_mean_value(&all.closest[DIFFUSE]));
    bench_summary(b, "closest_glossy", bench_mean_value(&all.closest[GLOSSY]));
    bench_summary(b, "closest_later", bench_mean_value(&all.closest[LATER]));
    bench_summary(b, "closest_random", bench_mean_value(&all.closest[RANDOM]));
    bench_summary(b, "any_hit", bench_mean_value(&all.any));
    bench_summary(b, "least_row", all.least);
    bench_summary(b, "packets_8", bench_mean_value(&all.packets[0]));
    bench_summary(b, "packets_16", bench_mean_value(&all.packets[1]));
    bench_summary(b, "core_scaling", bench_mean_value(&all.scaling));
    bench_summary(b, "embree_fast", bench_mean_value(&all.fast));
    bench_summary(b, "scalar_bvh2", bench_mean_value(&all.plain));
    return MCV_OK;
}

int main(int argc, char **argv) { return bench_main(argc, argv, "traversal", run); }
