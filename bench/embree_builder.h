/* SPDX-License-Identifier: Apache-2.0 */
/* rtcBuildBVH, Embree's builder for hierarchies of others, and what it makes in our layout. */
#ifndef MCVISI_BENCH_EMBREE_BUILDER_H
#define MCVISI_BENCH_EMBREE_BUILDER_H

#include "workload.h"

typedef struct embree_node embree_node;

typedef struct embree_builder {
    const mesh *mesh;
    enum RTCBuildQuality quality;
    struct RTCBuildPrimitive *all, *primitives; /* as they are, and what a build uses up */
    size_t capacity;
    RTCBVH bvh;
    embree_node *root;
    mcv_bvh made; /* the same in our layout */
} embree_builder;

/* Gets ready to build for a mesh, which is to stay. Close it even after a failure. */
mcv_result embree_builder_open(RTCDevice device, const mesh *m, enum RTCBuildQuality quality,
                               embree_builder *b, mcv_error *error);
void embree_builder_close(embree_builder *b);

/* Builds: a side of bench_time, of which `user` is the builder. */
mcv_result embree_builder_run(void *user, mcv_error *error);

/* Writes what was built in our layout; extent: of the root (mcvisi/accel.h). */
mcv_result embree_builder_convert(embree_builder *b, float extent, mcv_error *error);

#endif
