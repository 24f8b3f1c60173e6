/* SPDX-License-Identifier: Apache-2.0 */
/* What the benchmarks of the acceleration structure follow through what, and Embree's part of it.
 */
#ifndef MCVISI_BENCH_WORKLOAD_H
#define MCVISI_BENCH_WORKLOAD_H

#include "scene/scene.h"
#include <embree3/rtcore.h>

#include "harness.h"
#include "mesh.h"
#include "rays.h"

/* Bumpy spheres of 10, 69, 300 and 1998 thousand triangles, the CAD assembly, and machined parts
 * (cad_mesh.h) of slivers and of even triangles, about the cube [-1, 1]³. */
enum { WORKLOAD_MESHES = 8 };
typedef struct workload_mesh {
    char name[32];
    mesh mesh;
} workload_mesh;

/* Free it with mesh_free. */
mcv_result workload_load(int i, workload_mesh *made, mcv_error *error);

/* The triangles of all instances of a scene, without shared vertices. Free it with mesh_free. */
mesh mesh_of_scene(const mcv_scene *scene);

/* --quick and --only leave out some. */
bool workload_wanted(const bench *b, int i);

/*
 * Primary rays from a camera outside, in the order of the renderer's tiles: diffuse ones from the
 * points that those hit, in cosine-distributed directions, half of them into the inside; glossy
 * ones, reflected by facets whose slopes spread by 0.3; random ones between points of the bounding
 * cube. The diffuse ones' next bounces are `later`. Shadow rays lead from the points that the
 * primary ones hit to a ring of light around the camera.
 */
enum { PRIMARY, DIFFUSE, GLOSSY, LATER, SHADOW, RANDOM, RAY_KINDS };
extern const char *const ray_kind_names[RAY_KINDS];
enum { MOST_RAYS = 512 * 512 };
typedef struct workload_rays {
    uint32_t count;
    batch_ray rays[RAY_KINDS][MOST_RAYS];
} workload_rays;

/* Of a mesh as its surfaces were diffuse, or glossy. `hits` are room for those of primary and
 * diffuse rays, by Embree. */
void workload_make_rays(const bench *b, const mesh *m, RTCScene scene, mcv_hit *hits,
                        workload_rays *made);

/* Ours: a hierarchy on a device and the kernels of kernels/test/intersect.cl, those that the
 * renderer would take, and those by which each ray goes alone from the root. */
enum { CLOSEST_MANY, ANY_MANY, CLOSEST_ALONE, ANY_ALONE, CASTER_KERNELS };
typedef struct caster {
    mcv_cl *cl;
    cl_program program;
    cl_kernel kernels[CASTER_KERNELS];
    cl_mem nodes, leaves, rays, out;
    cl_uint count; /* of the rays */
} caster;
mcv_result caster_open(mcv_cl *cl, const mcv_bvh *bvh, caster *c, mcv_error *error);
void caster_close(caster *c);
mcv_result caster_take(caster *c, const batch_ray *rays, uint32_t count, mcv_error *error);

/* As bench_sides run them: the rays through one of the kernels, launch to finish. */
typedef struct cast {
    caster *caster;
    cl_kernel kernel;
} cast;
mcv_result cast_run(void *user, mcv_error *error);

/* Embree's: a scene of a build quality; triangles are shared with the mesh. */
RTCScene embree_scene(RTCDevice device, const mesh *m, enum RTCSceneFlags flags,
                      enum RTCBuildQuality quality);
typedef struct embree_cast {
    RTCScene scene;
    const batch_ray *rays;
    uint32_t count, threads, width; /* rays in a packet: 1, 8 or 16; of 8 and 16 one thread */
    bool any;
    mcv_hit *hits; /* closest */
    int *found;    /* any */
} embree_cast;
mcv_result embree_run(void *user, mcv_error *error);

/* The share of the rays whose hits differ: other triangles count where distances are not within
 * 1e-5 as well. Fast tests do lose edges. */
double share_that_differs(const mcv_hit *a, const mcv_hit *b, uint32_t count);

#endif
