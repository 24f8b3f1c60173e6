/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Rays per second against Embree 3 (rtcIntersect1 and rtcOccluded1, robust and fast scenes of high build quality), one core:
 * bench_traversal [OUTPUT.json], by default beside the program.
 *
 * The meshes are bumpy spheres of four sizes and the CAD assembly that ships with the scenes. Primary rays come from a camera outside;
 * diffuse rays leave the points they hit in cosine-distributed directions; random rays connect points of the bounding cube. Our rays go one
 * by one, in turns (kernels/traverse.h) or in bundles (kernels/bundle.h): the rows have all; the summary takes bundles for primary rays,
 * and turns for diffuse and random rays through MCV_MANY_TRIANGLES and more. Repetitions of all sides take turns too; a row gives medians,
 * and as spread the largest deviation of any repetition of ours or the peer's from its median. The summary holds the geometric means over
 * the meshes of the ratios to robust Embree, whose answers are comparable to ours.
 */
#include <embree3/rtcore.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "mesh.h"
#include "scene/scene.h"
#include "mcvisi/sampling.h"
#include "rays.h"

enum { REPETITIONS = 7, SIDE = 512, RAYS = SIDE * SIDE };
enum { PRIMARY, DIFFUSE, RANDOM, KINDS };
enum { OURS, TURNS, BUNDLES, ROBUST, FAST, SYSTEMS };

static const char *const kind_names[KINDS] = {"primary", "diffuse", "random"};
static const char *const peer_names[SYSTEMS] = {"", "", "", "Embree robust", "Embree fast"};

/* Processor time of all threads, of which one works at a time: other programs on the machine do not count. */
static double now(void) {
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static int by_value(const void *a, const void *b) {
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double median(const double values[REPETITIONS]) {
    double sorted[REPETITIONS];
    memcpy(sorted, values, sizeof sorted);
    qsort(sorted, REPETITIONS, sizeof *sorted, by_value);
    return sorted[REPETITIONS / 2];
}

static double spread(const double values[REPETITIONS]) {
    const double middle = median(values);
    double largest = 0.0;
    for (int i = 0; i < REPETITIONS; ++i) largest = fmax(largest, fabs(values[i] / middle - 1.0));
    return largest;
}

static RTCScene embree_scene(RTCDevice device, const mesh *m, enum RTCSceneFlags flags) {
    RTCScene scene = rtcNewScene(device);
    rtcSetSceneFlags(scene, flags);
    rtcSetSceneBuildQuality(scene, RTC_BUILD_QUALITY_HIGH);
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    void *vertices = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 12, m->vertex_count);
    void *indices = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12, m->triangle_count);
    memcpy(vertices, m->positions, 12 * (size_t)m->vertex_count);
    memcpy(indices, m->indices, 12 * (size_t)m->triangle_count);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene, geometry);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(scene);
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

static void embree_closest(RTCScene scene, const batch_ray *rays, mcv_hit *hits) {
    struct RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    for (uint32_t i = 0; i < RAYS; ++i) {
        struct RTCRayHit query = {.ray = embree_ray(rays + i), .hit = {.geomID = RTC_INVALID_GEOMETRY_ID}};
        rtcIntersect1(scene, &context, &query);
        const bool hit = query.hit.geomID != RTC_INVALID_GEOMETRY_ID;
        hits[i] = (mcv_hit){query.ray.tfar, query.hit.u, query.hit.v, hit ? query.hit.primID : MCV_NONE};
    }
}

static void embree_any(RTCScene scene, const batch_ray *rays, int *found) {
    struct RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    for (uint32_t i = 0; i < RAYS; ++i) {
        struct RTCRay query = embree_ray(rays + i);
        rtcOccluded1(scene, &context, &query);
        found[i] = query.tfar < 0.0f;
    }
}

/* The pixels of a SIDE x SIDE image in Morton order, as a renderer's tiles would come. */
static void make_primary(batch_ray *rays) {
    for (uint32_t i = 0; i < RAYS; ++i) {
        uint32_t x = 0, y = 0;
        for (int bit = 0; bit < 16; ++bit) {
            x |= (i >> 2 * bit & 1) << bit;
            y |= (i >> (2 * bit + 1) & 1) << bit;
        }
        rays[i] = (batch_ray){
            {0.3f, 0.4f, 3.0f}, INFINITY, {1.1f * (((float)x + 0.5f) / SIDE - 0.5f), 1.1f * (((float)y + 0.5f) / SIDE - 0.5f), -1.0f}, 0};
    }
}

static void make_diffuse(const mesh *m, const batch_ray *primary, const mcv_hit *hits, batch_ray *rays) {
    uint64_t seed = 1;
    for (uint32_t i = 0; i < RAYS; ++i) {
        mcv_hit hit = hits[i];
        mcv_vec3 p[3], normal;
        /* A primary ray that misses is replaced by a point of any triangle that has an area. */
        for (;;) {
            if (hit.triangle == MCV_NONE) {
                hit.triangle = (uint32_t)(random_bits(&seed) % m->triangle_count);
                hit.u = 0.5f * (float)random_unit(&seed);
                hit.v = 0.5f * (float)random_unit(&seed);
            }
            for (int k = 0; k < 3; ++k) {
                const float *q = m->positions + 3 * (size_t)m->indices[3 * (size_t)hit.triangle + k];
                p[k] = mcv_vec(q[0], q[1], q[2]);
            }
            normal = mcv_normalize(mcv_cross(mcv_sub(p[1], p[0]), mcv_sub(p[2], p[0])));
            if (mcv_dot(normal, normal) > 0.5f) break;
            hit.triangle = MCV_NONE;
        }
        const mcv_vec3 incoming = mcv_vec(primary[i].direction[0], primary[i].direction[1], primary[i].direction[2]);
        if (mcv_dot(normal, incoming) > 0.0f) normal = mcv_scale(normal, -1.0f);
        /* Half of them towards the inside, as into glass: outside a sphere most bounces would leave the scene. */
        if (i % 2) normal = mcv_scale(normal, -1.0f);
        const mcv_vec3 d = mcv_from_frame(mcv_sample_cosine((float)random_unit(&seed), (float)random_unit(&seed)), normal);
        /* Far enough from the surface that Embree, which has no error bounds, does not hit it again. */
        mcv_vec3 o = mcv_scale(p[0], 1.0f - hit.u - hit.v);
        o = mcv_along(mcv_along(o, hit.u, p[1]), hit.v, p[2]);
        o = mcv_along(o, 1e-4f, normal);
        rays[i] = (batch_ray){{o.x, o.y, o.z}, INFINITY, {d.x, d.y, d.z}, 0};
    }
}

static void make_random(batch_ray *rays) {
    uint64_t seed = 2;
    for (uint32_t i = 0; i < RAYS; ++i) {
        rays[i].t_max = INFINITY;
        for (int k = 0; k < 3; ++k) rays[i].origin[k] = (float)(2.4 * random_unit(&seed) - 1.2);
        for (int k = 0; k < 3; ++k) rays[i].direction[k] = (float)(2.4 * random_unit(&seed) - 1.2) - rays[i].origin[k];
    }
}

/* Different triangles count where the distances are not within 1e-5 as well: fast Embree does lose rays on edges. */
static double share_that_differs(const mcv_hit *a, const mcv_hit *b) {
    uint32_t different = 0;
    for (uint32_t i = 0; i < RAYS; ++i) {
        const bool same_miss = a[i].triangle == MCV_NONE && b[i].triangle == MCV_NONE;
        different += !(same_miss || a[i].triangle == b[i].triangle || fabsf(a[i].t - b[i].t) < 1e-5f * fabsf(a[i].t));
    }
    return (double)different / RAYS;
}

typedef struct bench {
    tracer tracer;
    RTCDevice embree;
    FILE *json;
    const char *separator;
    double log_ratio[KINDS], log_any; /* sums over the meshes */
    int meshes;
} bench;

/* Launch to finish, buffers in place. */
static mcv_result time_ours(bench *b, cl_kernel kernel, cl_mem rays, cl_mem out, double *seconds, mcv_error *error) {
    const cl_uint count = RAYS, slice = RAYS_PER_GROUP;
    const double start = now();
    MCV_TRY(MCV_LAUNCH(&b->tracer.cl, kernel, count / slice, 1, error, MCV_ARG(b->tracer.nodes), MCV_ARG(b->tracer.leaves), MCV_ARG(rays),
                       MCV_ARG(out), MCV_ARG(count), MCV_ARG(slice)));
    MCV_TRY(mcv_cl_finish(&b->tracer.cl, error));
    *seconds = now() - start;
    return MCV_OK;
}

static void report(bench *b, const char *what, double times[SYSTEMS][REPETITIONS], int way) {
    const double ours = 1e-6 * RAYS / median(times[way]);
    for (int peer = ROBUST; peer < SYSTEMS; ++peer) {
        const double theirs = 1e-6 * RAYS / median(times[peer]);
        const double range = fmax(spread(times[way]), spread(times[peer]));
        printf("%-38s %-14s %8.2f %8.2f %7.2f %6.0f %%\n", what, peer_names[peer], ours, theirs, ours / theirs, 100.0 * range);
        fprintf(b->json,
                "%s\n  {\"case\": \"%s, %s\", \"unit\": \"Mrays/s\", \"ours\": %.3f, \"peer\": %.3f, \"ratio\": %.3f, \"spread\": %.3f}",
                b->separator, what, peer_names[peer], ours, theirs, ours / theirs, range);
        b->separator = ",";
    }
    fflush(stdout);
}

static mcv_result bench_rays(bench *b, const char *mesh_name, uint32_t triangles, int kind, RTCScene scenes[SYSTEMS], const batch_ray *rays,
                             mcv_hit *hits, mcv_error *error) {
    static mcv_hit theirs[RAYS];
    static int found[RAYS];
    double closest[SYSTEMS][REPETITIONS], any[SYSTEMS][REPETITIONS];
    char what[80];
    cl_mem in, out;
    MCV_TRY(tracer_run(&b->tracer, b->tracer.closest, rays, RAYS, hits, error));
    MCV_TRY(tracer_run(&b->tracer, b->tracer.any, rays, RAYS, found, error));
    for (uint32_t i = 0; i < RAYS; ++i) {
        if (found[i] != (hits[i].triangle != MCV_NONE)) {
            return mcv_fail(error, MCV_FAILED, "%s, %s: any and closest disagree about ray %u", mesh_name, kind_names[kind], i);
        }
    }
    for (int peer = ROBUST; peer < SYSTEMS; ++peer) {
        embree_closest(scenes[peer], rays, theirs);
        const double different = share_that_differs(hits, theirs);
        if (different > 1e-3) {
            return mcv_fail(error, MCV_FAILED, "%s, %s: %.2f %% of the hits differ from %s", mesh_name, kind_names[kind], 100.0 * different,
                            peer_names[peer]);
        }
    }
    MCV_TRY(mcv_cl_buffer(&b->tracer.cl, "the rays", RAYS * sizeof *rays, rays, &in, error));
    MCV_TRY(mcv_cl_buffer(&b->tracer.cl, "the hits", RAYS * sizeof *hits, NULL, &out, error));
    for (int i = 0; i < REPETITIONS; ++i) {
        MCV_TRY(time_ours(b, b->tracer.closest, in, out, &closest[OURS][i], error));
        MCV_TRY(time_ours(b, b->tracer.closest_turns, in, out, &closest[TURNS][i], error));
        MCV_TRY(time_ours(b, b->tracer.closest_bundles, in, out, &closest[BUNDLES][i], error));
        MCV_TRY(time_ours(b, b->tracer.any, in, out, &any[OURS][i], error));
        MCV_TRY(time_ours(b, b->tracer.any_turns, in, out, &any[TURNS][i], error));
        MCV_TRY(time_ours(b, b->tracer.any_bundles, in, out, &any[BUNDLES][i], error));
        for (int peer = ROBUST; peer < SYSTEMS; ++peer) {
            const double start = now();
            embree_closest(scenes[peer], rays, theirs);
            const double middle = now();
            embree_any(scenes[peer], rays, found);
            closest[peer][i] = middle - start;
            any[peer][i] = now() - middle;
        }
    }
    mcv_cl_release(&in);
    mcv_cl_release(&out);
    for (int way = OURS; way <= BUNDLES; ++way) {
        const char *how = way == TURNS ? " in turns" : way == BUNDLES ? " bundled" : "";
        snprintf(what, sizeof what, "closest %s %s%s", kind_names[kind], mesh_name, how);
        report(b, what, closest, way);
        snprintf(what, sizeof what, "any %s %s%s", kind_names[kind], mesh_name, how);
        report(b, what, any, way);
    }
    const int chosen = kind == PRIMARY ? BUNDLES : triangles >= MCV_MANY_TRIANGLES ? TURNS : OURS;
    b->log_ratio[kind] += log(median(closest[ROBUST]) / median(closest[chosen]));
    b->log_any += log(median(any[ROBUST]) / median(any[chosen])) / KINDS;
    return MCV_OK;
}

/* The CAD assembly, moved and scaled into the cube [-1, 1]³. */
static mcv_result load_assembly(mesh *m, mcv_error *error) {
    mcv_scene *scene;
    MCV_TRY(mcv_scene_load(MCV_SOURCE_DIR "/scenes/2CylinderEngine.glb", (mcv_overrides){0}, &scene, error));
    *m = mesh_new(3 * scene->triangle_count, scene->triangle_count);
    double lower[3] = {INFINITY, INFINITY, INFINITY}, upper[3] = {-INFINITY, -INFINITY, -INFINITY}, half = 0.0;
    for (int pass = 0; pass < 2; ++pass) {
        for (uint32_t i = 0; i < m->triangle_count; ++i) {
            const uint32_t instance = mcv_scene_instance_of(scene, i);
            double corners[3][3];
            mcv_scene_corners(scene, instance, i - scene->instances[instance].first_triangle, corners);
            for (uint32_t k = 0; k < 9; ++k) {
                const double x = corners[k / 3][k % 3];
                lower[k % 3] = fmin(lower[k % 3], x);
                upper[k % 3] = fmax(upper[k % 3], x);
                if (pass) m->positions[9 * (size_t)i + k] = (float)((x - 0.5 * (lower[k % 3] + upper[k % 3])) / half);
            }
        }
        for (int k = 0; k < 3; ++k) half = fmax(half, 0.5 * (upper[k] - lower[k]));
    }
    for (uint32_t i = 0; i < m->vertex_count; ++i) m->indices[i] = i;
    mcv_scene_free(scene);
    return MCV_OK;
}

static mcv_result bench_mesh(bench *b, const char *kind_of_mesh, const mesh *m, mcv_error *error) {
    static batch_ray rays[KINDS][RAYS];
    static mcv_hit hits[RAYS];
    RTCScene scenes[SYSTEMS] = {NULL};
    char name[32];
    mcv_bvh bvh;
    snprintf(name, sizeof name, "%s %uk", kind_of_mesh, (m->triangle_count + 500) / 1000);

    double start = now();
    MCV_TRY(mcv_bvh_build(m->positions, m->indices, m->triangle_count, 0, &bvh, error));
    const double ours = now() - start;
    start = now();
    scenes[ROBUST] = embree_scene(b->embree, m, RTC_SCENE_FLAG_ROBUST);
    const double theirs = now() - start;
    scenes[FAST] = embree_scene(b->embree, m, RTC_SCENE_FLAG_NONE);
    const double bytes = (double)bvh.node_count * sizeof *bvh.nodes + (double)bvh.leaf_count * sizeof *bvh.leaves;
    printf("%s triangles: built in %.2f s of processor time (Embree %.2f s), %.1f bytes per triangle\n", name, ours, theirs,
           bytes / m->triangle_count);
    MCV_TRY(tracer_load(&b->tracer, &bvh, error));
    mcv_bvh_free(&bvh);

    make_primary(rays[PRIMARY]);
    make_random(rays[RANDOM]);
    MCV_TRY(bench_rays(b, name, m->triangle_count, PRIMARY, scenes, rays[PRIMARY], hits, error));
    make_diffuse(m, rays[PRIMARY], hits, rays[DIFFUSE]);
    MCV_TRY(bench_rays(b, name, m->triangle_count, DIFFUSE, scenes, rays[DIFFUSE], hits, error));
    MCV_TRY(bench_rays(b, name, m->triangle_count, RANDOM, scenes, rays[RANDOM], hits, error));
    ++b->meshes;
    rtcReleaseScene(scenes[ROBUST]);
    rtcReleaseScene(scenes[FAST]);
    return MCV_OK;
}

static mcv_result run_all(bench *b, mcv_error *error) {
    static const uint32_t sizes[] = {29, 76, 158, 408}; /* 10, 69, 300 and 1998 thousand triangles */
    MCV_TRY(tracer_open(&b->tracer, error));
    printf("%s; Mrays/s, one thread\n%-38s %-14s %8s %8s %7s %6s\n", b->tracer.cl.name, "case", "peer", "ours", "peer", "ratio", "spread");
    for (size_t i = 0; i < sizeof sizes / sizeof sizes[0]; ++i) {
        mesh m = mesh_sphere(sizes[i], 0.1);
        MCV_TRY(bench_mesh(b, "sphere", &m, error));
        mesh_free(&m);
    }
    mesh assembly;
    MCV_TRY(load_assembly(&assembly, error));
    MCV_TRY(bench_mesh(b, "CAD", &assembly, error));
    mesh_free(&assembly);
    return MCV_OK;
}

int main(int argc, char **argv) {
    bench b = {.separator = ""};
    mcv_error error = {""};
    char path[1024];
    snprintf(path, sizeof path, "%s%s", argc > 1 ? argv[1] : argv[0], argc > 1 ? "" : ".json");
    setenv("POCL_MAX_PTHREAD_COUNT", "1", 1);
    b.json = fopen(path, "w");
    if (!b.json) {
        fprintf(stderr, "bench_traversal: %s cannot be written\n", path);
        return MCV_FAILED;
    }
    b.embree = rtcNewDevice(NULL);
    fputs("{\"rows\": [", b.json);
    const mcv_result result = run_all(&b, &error);
    double mean[KINDS];
    for (int kind = 0; kind < KINDS; ++kind) mean[kind] = exp(b.log_ratio[kind] / b.meshes);
    const double any = exp(b.log_any / b.meshes);
    fprintf(b.json,
            "\n], \"summary\": {\"closest_primary\": %.3f, \"closest_diffuse\": %.3f, \"closest_random\": %.3f, \"any_hit\": %.3f}}\n",
            mean[PRIMARY], mean[DIFFUSE], mean[RANDOM], any);
    fclose(b.json);
    if (result != MCV_OK) {
        fprintf(stderr, "bench_traversal: %s\n", error.text);
        remove(path);
    } else {
        printf("geometric mean of the ratios to robust Embree: primary %.2f, diffuse %.2f, random %.2f, any hit %.2f\n", mean[PRIMARY],
               mean[DIFFUSE], mean[RANDOM], any);
    }
    tracer_close(&b.tracer);
    rtcReleaseDevice(b.embree);
    return result;
}
