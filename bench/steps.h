/* SPDX-License-Identifier: Apache-2.0 */
/* What rays that go alone test in a hierarchy: counts, which no other program disturbs. */
#ifndef MCVISI_BENCH_STEPS_H
#define MCVISI_BENCH_STEPS_H

#include "workload.h"

/* Means per ray. */
typedef struct steps {
    double nodes, leaves, triangles;
} steps;

/* Of a traversal in the order of kernels/traverse/bvh8.h: the nearest child first, or any order
 * that ends at the first hit. The arithmetic is double and has no margins. */
steps steps_count(const mcv_bvh *bvh, const batch_ray *rays, uint32_t count, bool any);

#endif
