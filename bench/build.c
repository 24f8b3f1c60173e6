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

/* --- Embree's builder
 * ------------------------------------------------------------------------------------------- */

/* A node with `count` triangles, or an inner one. */
typedef struct embree_node {
    uint32_t triangles[MCV_LEAF_TRIANGLES], triangle_count;
    uint32_t child_count;
    struct embree_node *children[MCV_BVH_WIDTH];
    struct RTCBounds bounds[MCV_BVH_WIDTH];
} embree_node;

typedef struct embree_builder {
    const mesh *mesh;
    enum RTCBuildQuality quality;
    struct RTCBuildPrimitive *all, *primitives; /* as they are, and what a build uses up */
    size_t capacity;
    RTCBVH bvh;
    embree_node *root;
    mcv_bvh made; /* the same in our layout */
} embree_builder;

static void *create_node(RTCThreadLocalAllocator allocator, unsigned count, void *user) {
    embree_node *node = rtcThreadLocalAlloc(allocator, sizeof *node, 16);
    (void)user;
    node->triangle_count = 0;
    node->child_count = count;
    return node;
}

static void set_children(void *user, void **children, unsigned count, void *builder) {
    embree_node *node = user;
    (void)builder;
    for (unsigned i = 0; i < count; ++i) node->children[i] = children[i];
}

static void set_bounds(void *user, const struct RTCBounds **bounds, unsigned count, void *builder) {
    embree_node *node = user;
    (void)builder;
    for (unsigned i = 0; i < count; ++i) node->bounds[i] = *bounds[i];
}

static void *create_leaf(RTCThreadLocalAllocator allocator,
                         const struct RTCBuildPrimitive *primitives, size_t count, void *user) {
    embree_node *leaf = create_node(allocator, 0, user);
    /* Two parts of one triangle may meet again. */
    for (size_t i = 0; i < count; ++i) {
        bool there = false;
        for (uint32_t k = 0; k < leaf->triangle_count; ++k)
            there = there || leaf->triangles[k] == primitives[i].primID;
        if (!there) leaf->triangles[leaf->triangle_count++] = primitives[i].primID;
    }
    return leaf;
}

static const float *corner_of(const mesh *m, uint32_t triangle, int corner) {
    return m->positions + 3 * (size_t)m->indices[3 * (size_t)triangle + (size_t)corner];
}

static void grow(float lower[3], float upper[3], const float p[3]) {
    for (int k = 0; k < 3; ++k) {
        lower[k] = fminf(lower[k], p[k]);
        upper[k] = fmaxf(upper[k], p[k]);
    }
}

/* The boxes of the parts of a triangle on both sides of a plane, within the box of what is split.
 */
static void split_primitive(const struct RTCBuildPrimitive *primitive, unsigned axis, float plane,
                            struct RTCBounds *left, struct RTCBounds *right, void *user) {
    const embree_builder *b = user;
    const float lower[3] = {primitive->lower_x, primitive->lower_y, primitive->lower_z};
    const float upper[3] = {primitive->upper_x, primitive->upper_y, primitive->upper_z};
    float low[2][3], high[2][3];
    for (int k = 0; k < 6; ++k) {
        low[k / 3][k % 3] = INFINITY;
        high[k / 3][k % 3] = -INFINITY;
    }
    for (int corner = 0; corner < 3; ++corner) {
        const float *p = corner_of(b->mesh, primitive->primID, corner),
                    *q = corner_of(b->mesh, primitive->primID, (corner + 1) % 3);
        if (p[axis] <= plane) grow(low[0], high[0], p);
        if (p[axis] >= plane) grow(low[1], high[1], p);
        if ((p[axis] < plane) == (q[axis] < plane)) continue;
        const double t = ((double)plane - p[axis]) / ((double)q[axis] - p[axis]);
        float crossing[3];
        for (int k = 0; k < 3; ++k) crossing[k] = (float)(p[k] + t * ((double)q[k] - p[k]));
        crossing[axis] = plane;
        for (int side = 0; side < 2; ++side) grow(low[side], high[side], crossing);
    }
    for (int k = 0; k < 6; ++k) {
        low[k / 3][k % 3] = fmaxf(low[k / 3][k % 3], lower[k % 3]);
        high[k / 3][k % 3] = fminf(high[k / 3][k % 3], upper[k % 3]);
    }
    *left = (struct RTCBounds){low[0][0],  low[0][1],  low[0][2],  0,
                               high[0][0], high[0][1], high[0][2], 0};
    *right = (struct RTCBounds){low[1][0],  low[1][1],  low[1][2],  0,
                                high[1][0], high[1][1], high[1][2], 0};
}

static mcv_result builder_open(RTCDevice device, const mesh *m, enum RTCBuildQuality quality,
                               embree_builder *b, mcv_error *error) {
    const uint32_t n = m->triangle_count;
    b->mesh = m;
    b->quality = quality;
    b->capacity = n + n / 10 * 3;
    b->all = malloc(n * sizeof *b->all);
    b->primitives = aligned_alloc(64, (b->capacity * sizeof *b->primitives + 63) / 64 * 64);
    b->bvh = rtcNewBVH(device);
    if (!b->all || !b->primitives)
        return mcv_fail(error, MCV_FAILED, "no memory for Embree's builder");
    for (uint32_t i = 0; i < n; ++i) {
        float lower[3] = {INFINITY, INFINITY, INFINITY},
              upper[3] = {-INFINITY, -INFINITY, -INFINITY};
        for (int corner = 0; corner < 3; ++corner) grow(lower, upper, corner_of(m, i, corner));
        b->all[i] = (struct RTCBuildPrimitive){lower[0], lower[1], lower[2], 0,
                                               upper[0], upper[1], upper[2], i};
    }
    return MCV_OK;
}

static void builder_close(embree_builder *b) {
    free(b->all);
    free(b->primitives);
    if (b->bvh) rtcReleaseBVH(b->bvh);
    mcv_bvh_free(&b->made);
}

static mcv_result builder_run(void *user, mcv_error *error) {
    embree_builder *b = user;
    memcpy(b->primitives, b->all, b->mesh->triangle_count * sizeof *b->all);
    struct RTCBuildArguments arguments = rtcDefaultBuildArguments();
    arguments.buildQuality = b->quality;
    arguments.maxBranchingFactor = MCV_BVH_WIDTH;
    arguments.maxDepth = MCV_BVH_LEVELS - 1;
    arguments.sahBlockSize = arguments.maxLeafSize = MCV_LEAF_TRIANGLES;
    arguments.bvh = b->bvh;
    arguments.primitives = b->primitives;
    arguments.primitiveCount = b->mesh->triangle_count;
    arguments.primitiveArrayCapacity = b->capacity;
    arguments.createNode = create_node;
    arguments.setNodeChildren = set_children;
    arguments.setNodeBounds = set_bounds;
    arguments.createLeaf = create_leaf;
    arguments.splitPrimitive = split_primitive;
    arguments.userPtr = b;
    b->root = rtcBuildBVH(&arguments);
    return b->root ? MCV_OK : mcv_fail(error, MCV_FAILED, "Embree built nothing");
}

/* --- the same in our layout
 * ------------------------------------------------------------------------------------- */

static void count_nodes(const embree_node *node, uint32_t level, mcv_bvh *made, uint32_t *levels) {
    if (level > *levels) *levels = level;
    ++made->node_count;
    for (uint32_t i = 0; i < node->child_count; ++i) {
        if (node->children[i]->child_count == 0)
            ++made->leaf_count;
        else
            count_nodes(node->children[i], level + 1, made, levels);
    }
}

static void place_leaf(const mesh *m, const embree_node *from, mcv_leaf *leaf) {
    *leaf = (mcv_leaf){.triangle = {MCV_NONE, MCV_NONE, MCV_NONE, MCV_NONE}};
    for (uint32_t lane = 0; lane < from->triangle_count; ++lane) {
        leaf->triangle[lane] = from->triangles[lane];
        for (int i = 0; i < 9; ++i)
            leaf->vertex[i / 3][i % 3][lane] = corner_of(m, from->triangles[lane], i / 3)[i % 3];
    }
}

/* Depth first, as ours. */
static uint32_t place_node(const mesh *m, const embree_node *from, float extent, mcv_bvh *made) {
    const uint32_t here = made->node_count++;
    mcv_node *node = made->nodes + here;
    node->extent = extent;
    for (uint32_t i = 0; i < MCV_BVH_WIDTH; ++i) {
        node->child[i] = MCV_NONE;
        for (int axis = 0; axis < 3; ++axis) {
            node->bounds[axis][0][i] =
                i < from->child_count ? (&from->bounds[i].lower_x)[axis] : INFINITY;
            node->bounds[axis][1][i] =
                i < from->child_count ? (&from->bounds[i].upper_x)[axis] : -INFINITY;
        }
        if (i >= from->child_count || from->children[i]->child_count > 0) continue;
        place_leaf(m, from->children[i], made->leaves + made->leaf_count);
        node->child[i] = MCV_CHILD_LEAF | made->leaf_count++;
    }
    for (uint32_t i = 0; i < from->child_count; ++i) {
        if (from->children[i]->child_count > 0)
            node->child[i] = place_node(m, from->children[i], extent, made);
    }
    return here;
}

static mcv_result builder_convert(embree_builder *b, float extent, mcv_error *error) {
    uint32_t levels = 0;
    mcv_bvh *made = &b->made;
    if (b->root->child_count == 0) return mcv_fail(error, MCV_FAILED, "Embree built a single leaf");
    count_nodes(b->root, 1, made, &levels);
    if (levels > MCV_BVH_LEVELS)
        return mcv_fail(error, MCV_FAILED, "Embree's hierarchy has %u levels, ours at most %d",
                        levels, MCV_BVH_LEVELS);
    made->nodes = aligned_alloc(128, made->node_count * sizeof *made->nodes);
    made->leaves = aligned_alloc(128, (made->leaf_count * sizeof *made->leaves + 127) / 128 * 128);
    if (!made->nodes || !made->leaves)
        return mcv_fail(error, MCV_FAILED, "no memory for Embree's hierarchy");
    made->node_count = made->leaf_count = 0;
    place_node(b->mesh, b->root, extent, made);
    return MCV_OK;
}

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
                                     {builder_run, m->builders + MEDIUM, {{{0}}}, 0}};
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
        MCV_TRY(builder_open(device, t, qualities[q], m->builders + q, m->error));
    for (int k = 0; k < COMMITS; ++k) {
        m->scenes[k] = embree_scene(device, t, commits[k].flags, commits[k].quality);
        const long long before = atomic_load(&embree_bytes);
        rtcCommitScene(m->scenes[k]);
        if (k == HIGH) bytes = (double)(atomic_load(&embree_bytes) - before);
    }
    MCV_TRY(bench_seconds_of(m));
    const int built = t->triangle_count <= SPLIT_MOST ? 2 : 1;
    if (built > HIGH) MCV_TRY(builder_run(m->builders + HIGH, m->error));
    const mcv_bvh *bvhs[1 + QUALITIES] = {&m->ours.made, &m->builders[MEDIUM].made,
                                          &m->builders[HIGH].made};
    for (int q = 0; q < built; ++q) {
        MCV_TRY(builder_convert(m->builders + q, m->ours.made.nodes->extent, m->error));
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
    for (int q = 0; q < QUALITIES; ++q) builder_close(m.builders + q);
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
