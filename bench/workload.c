/* SPDX-License-Identifier: Apache-2.0 */
#include "workload.h"

#include <math.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "mcvisi/accel.h"
#include "scene/scene.h"
#include "scene/geometry.h"
#include "cad_mesh.h"
#include "loader/load.h"

/* --- meshes
 * -----------------------------------------------------------------------------------------------------
 */

static const struct {
    const char *name;
    uint32_t squares;         /* of a sphere's side */
    uint32_t segments, bores; /* of a machined part; neither: the assembly */
    bool even, quick;
} meshes[WORKLOAD_MESHES] = {
    {"sphere 10k", 29, 0, 0, false, true},    {"sphere 69k", 76, 0, 0, false, true},
    {"sphere 300k", 158, 0, 0, false, false}, {"sphere 1998k", 408, 0, 0, false, false},
    {"CAD 121k", 0, 0, 0, false, true},       {"slivers 17k", 0, 24, 6, false, true},
    {"slivers 450k", 0, 64, 20, false, true}, {"even 500k", 0, 24, 14, true, false}};

bool workload_wanted(const bench *b, int i) {
    return b->only ? strstr(meshes[i].name, b->only) != NULL : meshes[i].quick || !b->quick;
}

mesh mesh_of_scene(const mcv_scene *scene, const double centre[3]) {
    mesh m = mesh_new(3 * scene->triangle_count, scene->triangle_count);
    for (uint32_t i = 0; i < m.triangle_count; ++i) {
        const uint32_t instance = mcv_scene_instance_of(scene, i);
        double corners[3][3];
        mcv_scene_corners(scene, instance, i - scene->instances[instance].first_triangle, corners);
        for (uint32_t k = 0; k < 9; ++k)
            m.positions[9 * (size_t)i + k] = (float)(corners[k / 3][k % 3] - centre[k % 3]);
    }
    for (uint32_t i = 0; i < m.vertex_count; ++i) m.indices[i] = i;
    return m;
}

/* The CAD assembly, moved and scaled into the cube [-1, 1]³. */
static mcv_result load_assembly(mesh *m, mcv_error *error) {
    mcv_scene *scene;
    MCV_TRY(mcv_scene_load(MCV_SOURCE_DIR "/scenes/2CylinderEngine.glb", (mcv_overrides){0}, &scene,
                           error));
    *m = mesh_of_scene(scene, (const double[3]){0, 0, 0});
    mcv_scene_free(scene);
    float lower[3] = {INFINITY, INFINITY, INFINITY}, upper[3] = {-INFINITY, -INFINITY, -INFINITY},
          half = 0;
    for (uint32_t i = 0; i < 3 * m->vertex_count; ++i) {
        lower[i % 3] = fminf(lower[i % 3], m->positions[i]);
        upper[i % 3] = fmaxf(upper[i % 3], m->positions[i]);
    }
    for (int k = 0; k < 3; ++k) half = fmaxf(half, 0.5f * (upper[k] - lower[k]));
    for (uint32_t i = 0; i < 3 * m->vertex_count; ++i)
        m->positions[i] = (m->positions[i] - 0.5f * (lower[i % 3] + upper[i % 3])) / half;
    return MCV_OK;
}

mcv_result workload_load(int i, workload_mesh *made, mcv_error *error) {
    snprintf(made->name, sizeof made->name, "%s", meshes[i].name);
    if (meshes[i].segments)
        made->mesh = cad_mesh(meshes[i].segments, meshes[i].bores, meshes[i].even);
    else if (meshes[i].squares)
        made->mesh = mesh_sphere(meshes[i].squares, 0.1);
    else
        return load_assembly(&made->mesh, error);
    return MCV_OK;
}

double share_that_differs(const mcv_hit *a, const mcv_hit *b, uint32_t count) {
    uint32_t different = 0;
    for (uint32_t i = 0; i < count; ++i) {
        const bool same_miss = a[i].primitive == MCV_NONE && b[i].primitive == MCV_NONE;
        different += !(same_miss || a[i].primitive == b[i].primitive ||
                       fabsf(a[i].t - b[i].t) < 1e-5f * fabsf(a[i].t));
    }
    return (double)different / count;
}

/* --- ours
 * -------------------------------------------------------------------------------------------------------
 */

mcv_result caster_open(mcv_cl *cl, const mcv_bvh *bvh, caster *c, mcv_error *error) {
    static const char *const names[CASTER_KERNELS] = {
        "closest_many", "any_many", "intersect_closest_alone", "intersect_any_alone"};
    *c = (caster){.cl = cl};
    MCV_TRY(mcv_cl_build(cl, "test/intersect", "", &c->program, error));
    for (int i = 0; i < CASTER_KERNELS; ++i)
        MCV_TRY(mcv_cl_kernel(c->program, names[i], &c->kernels[i], error));
    MCV_TRY(mcv_cl_buffer(cl, "the nodes", bvh->node_count * sizeof *bvh->nodes, bvh->nodes,
                          &c->nodes, error));
    return mcv_cl_buffer(cl, "the leaves", bvh->leaf_count * sizeof *bvh->leaves, bvh->leaves,
                         &c->leaves, error);
}

void caster_close(caster *c) {
    for (int i = 0; i < CASTER_KERNELS; ++i) {
        if (c->kernels[i]) clReleaseKernel(c->kernels[i]);
    }
    if (c->program) clReleaseProgram(c->program);
    mcv_cl_release(&c->nodes);
    mcv_cl_release(&c->leaves);
    mcv_cl_release(&c->rays);
    mcv_cl_release(&c->out);
}

mcv_result caster_take(caster *c, const batch_ray *rays, uint32_t count, mcv_error *error) {
    mcv_cl_release(&c->rays);
    mcv_cl_release(&c->out);
    c->count = count;
    MCV_TRY(mcv_cl_buffer(c->cl, "the rays", count * sizeof *rays, rays, &c->rays, error));
    return mcv_cl_buffer(c->cl, "the hits", count * sizeof(mcv_hit), NULL, &c->out, error);
}

mcv_result cast_run(void *user, mcv_error *error) {
    const cast *k = user;
    const caster *c = k->caster;
    const cl_uint slice = RAYS_PER_GROUP;
    MCV_TRY(MCV_LAUNCH(c->cl, k->kernel, (c->count + slice - 1) / slice, 1, error,
                       MCV_ARG(c->nodes), MCV_ARG(c->leaves), MCV_ARG(c->rays), MCV_ARG(c->out),
                       MCV_ARG(c->count), MCV_ARG(slice)));
    return mcv_cl_finish(c->cl, error);
}

/* --- Embree
 * -----------------------------------------------------------------------------------------------------
 */

RTCScene embree_scene(RTCDevice device, const mesh *m, enum RTCSceneFlags flags,
                      enum RTCBuildQuality quality) {
    RTCScene scene = rtcNewScene(device);
    rtcSetSceneFlags(scene, flags);
    rtcSetSceneBuildQuality(scene, quality);
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    rtcSetGeometryBuildQuality(geometry, quality);
    void *vertices = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                             12, m->vertex_count);
    void *indices = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                            12, m->triangle_count);
    memcpy(vertices, m->positions, 12 * (size_t)m->vertex_count);
    memcpy(indices, m->indices, 12 * (size_t)m->triangle_count);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene, geometry);
    rtcReleaseGeometry(geometry);
    return scene;
}

static struct RTCRay embree_ray(const batch_ray *r) {
    return (struct RTCRay){.org_x = r->origin[0],
                           .org_y = r->origin[1],
                           .org_z = r->origin[2],
                           .dir_x = r->direction[0],
                           .dir_y = r->direction[1],
                           .dir_z = r->direction[2],
                           .tfar = r->t_max,
                           .mask = ~0u};
}

static void cast_closest(const embree_cast *c, uint32_t first, uint32_t last) {
    struct RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    for (uint32_t i = first; i < last; ++i) {
        struct RTCRayHit query = {.ray = embree_ray(c->rays + i),
                                  .hit = {.geomID = RTC_INVALID_GEOMETRY_ID}};
        rtcIntersect1(c->scene, &context, &query);
        const bool hit = query.hit.geomID != RTC_INVALID_GEOMETRY_ID;
        c->hits[i] =
            (mcv_hit){query.ray.tfar, query.hit.u, query.hit.v, hit ? query.hit.primID : MCV_NONE};
    }
}

static void cast_any(const embree_cast *c, uint32_t first, uint32_t last) {
    struct RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    for (uint32_t i = first; i < last; ++i) {
        struct RTCRay query = embree_ray(c->rays + i);
        rtcOccluded1(c->scene, &context, &query);
        c->found[i] = query.tfar < 0.0f;
    }
}

#define PACKETS(WIDTH) \
    static void cast_packets##WIDTH(const embree_cast *c) { \
        struct RTCIntersectContext context; \
        rtcInitIntersectContext(&context); \
        for (uint32_t first = 0; first < c->count; first += WIDTH) { \
            __attribute__((aligned(64))) int valid[WIDTH]; \
            struct RTCRayHit##WIDTH q; \
            memset(&q, 0, sizeof q); \
            for (uint32_t k = 0; k < WIDTH; ++k) { \
                valid[k] = first + k < c->count ? -1 : 0; \
                const batch_ray *r = c->rays + first + (valid[k] ? k : 0); \
                q.ray.org_x[k] = r->origin[0]; \
                q.ray.org_y[k] = r->origin[1]; \
                q.ray.org_z[k] = r->origin[2]; \
                q.ray.dir_x[k] = r->direction[0]; \
                q.ray.dir_y[k] = r->direction[1]; \
                q.ray.dir_z[k] = r->direction[2]; \
                q.ray.tfar[k] = r->t_max; \
                q.ray.mask[k] = ~0u; \
                q.hit.geomID[k] = RTC_INVALID_GEOMETRY_ID; \
            } \
            if (c->any) \
                rtcOccluded##WIDTH(valid, c->scene, &context, &q.ray); \
            else \
                rtcIntersect##WIDTH(valid, c->scene, &context, &q); \
            for (uint32_t k = 0; k < WIDTH && valid[k]; ++k) { \
                const bool hit = q.hit.geomID[k] != RTC_INVALID_GEOMETRY_ID; \
                if (c->any) \
                    c->found[first + k] = q.ray.tfar[k] < 0.0f; \
                else \
                    c->hits[first + k] = (mcv_hit){q.ray.tfar[k], q.hit.u[k], q.hit.v[k], \
                                                   hit ? q.hit.primID[k] : MCV_NONE}; \
            } \
        } \
    }
PACKETS(8)
PACKETS(16)

/* Slices as large as ours, taken by whichever thread is free. */
typedef struct embree_work {
    const embree_cast *cast;
    atomic_uint next;
} embree_work;

static void *take_slices(void *user) {
    embree_work *work = user;
    const embree_cast *c = work->cast;
    for (;;) {
        const uint32_t first = RAYS_PER_GROUP * atomic_fetch_add(&work->next, 1);
        if (first >= c->count) return NULL;
        const uint32_t last = first + RAYS_PER_GROUP < c->count ? first + RAYS_PER_GROUP : c->count;
        (c->any ? cast_any : cast_closest)(c, first, last);
    }
}

mcv_result embree_run(void *user, mcv_error *error) {
    enum { MOST_THREADS = 1024 };
    embree_work work = {.cast = user};
    if (work.cast->width > 1) {
        (work.cast->width == 8 ? cast_packets8 : cast_packets16)(work.cast);
        return MCV_OK;
    }
    const uint32_t threads = work.cast->threads < MOST_THREADS ? work.cast->threads : MOST_THREADS;
    pthread_t handles[MOST_THREADS];
    uint32_t started = 1;
    while (started < threads && pthread_create(handles + started, NULL, take_slices, &work) == 0)
        ++started;
    take_slices(&work);
    for (uint32_t i = 1; i < started; ++i) pthread_join(handles[i], NULL);
    return started == threads
               ? MCV_OK
               : mcv_fail(error, MCV_FAILED, "%u threads for Embree could not be started", threads);
}
