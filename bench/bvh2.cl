/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A ray through a binary hierarchy as textbooks have it: slabs, the nearer child first, triangles
 * by Möller and Trumbore (Fast, Minimum Storage Ray-Triangle Intersection, 1997). Not watertight.
 */
#include "bvh2.h"
#include "mcvisi/accel.h"

typedef struct bvh2_ray {
    float origin[3], t_max;
    float direction[3], unused;
} bvh2_ray;

static int bvh2_meet_triangle(__global const bvh2_triangle *triangle, const float *o,
                              const float *d, mcv_hit *hit) {
    float p[3], s[3], q[3];
    __global const float *e = triangle->edges[0], *f = triangle->edges[1];
    for (int k = 0; k < 3; ++k) {
        const int i = (k + 1) % 3, j = (k + 2) % 3;
        p[k] = d[i] * f[j] - d[j] * f[i];
        s[k] = o[k] - triangle->corner[k];
    }
    for (int k = 0; k < 3; ++k) {
        const int i = (k + 1) % 3, j = (k + 2) % 3;
        q[k] = s[i] * e[j] - s[j] * e[i];
    }
    const float det = e[0] * p[0] + e[1] * p[1] + e[2] * p[2];
    if (det == 0.0f) return 0;
    const float inverse = 1.0f / det;
    const float u = (s[0] * p[0] + s[1] * p[1] + s[2] * p[2]) * inverse;
    if (u < 0.0f || u > 1.0f) return 0;
    const float v = (d[0] * q[0] + d[1] * q[1] + d[2] * q[2]) * inverse;
    if (v < 0.0f || u + v > 1.0f) return 0;
    const float t = (f[0] * q[0] + f[1] * q[1] + f[2] * q[2]) * inverse;
    if (t <= 0.0f || t >= hit->t) return 0;
    hit->t = t;
    hit->u = u;
    hit->v = v;
    hit->primitive = triangle->number;
    return 1;
}

/* Where the ray enters a box, or INFINITY. */
static float bvh2_enter(__global const bvh2_node *node, const float *o, const float *inverse,
                        float t_max) {
    float near = 0.0f, far = t_max;
    for (int k = 0; k < 3; ++k) {
        const float a = (node->lower[k] - o[k]) * inverse[k],
                    b = (node->upper[k] - o[k]) * inverse[k];
        near = max(near, min(a, b));
        far = min(far, max(a, b));
    }
    return near <= far ? near : INFINITY;
}

static inline __attribute__((always_inline)) mcv_hit
bvh2_traverse(__global const bvh2_node *nodes, __global const bvh2_triangle *triangles,
              __global const bvh2_ray *ray, int any) {
    float o[3], d[3], inverse[3], entries[BVH2_LEVELS];
    uint waiting[BVH2_LEVELS];
    uint count = 0, current = 0;
    mcv_hit hit = {ray->t_max, 0.0f, 0.0f, MCV_NONE};
    for (int k = 0; k < 3; ++k) {
        o[k] = ray->origin[k];
        d[k] = ray->direction[k];
        inverse[k] = 1.0f / d[k];
    }
    for (;;) {
        __global const bvh2_node *node = nodes + current;
        if (node->count > 0) {
            int found = 0;
            for (uint i = 0; i < node->count; ++i)
                found |= bvh2_meet_triangle(triangles + node->first + i, o, d, &hit);
            if (any && found) return hit;
        } else {
            const float left = bvh2_enter(nodes + node->first, o, inverse, hit.t);
            const float right = bvh2_enter(nodes + node->first + 1, o, inverse, hit.t);
            const uint nearer = right < left ? 1u : 0u;
            if (max(left, right) < INFINITY) {
                entries[count] = max(left, right);
                waiting[count++] = node->first + (1u - nearer);
            }
            if (min(left, right) < INFINITY) {
                current = node->first + nearer;
                continue;
            }
        }
        do {
            if (count == 0) return hit;
            --count;
        } while (entries[count] > hit.t);
        current = waiting[count];
    }
}

__kernel __attribute__((reqd_work_group_size(1, 1, 1))) void
bvh2_closest(__global const bvh2_node *nodes, __global const bvh2_triangle *triangles,
             __global const bvh2_ray *rays, __global mcv_hit *hits, uint count, uint slice) {
    const uint first = (uint)get_group_id(0) * slice;
    const uint last = min(first + slice, count);
    for (uint i = first; i < last; ++i) hits[i] = bvh2_traverse(nodes, triangles, rays + i, 0);
}

__kernel __attribute__((reqd_work_group_size(1, 1, 1))) void
bvh2_any(__global const bvh2_node *nodes, __global const bvh2_triangle *triangles,
         __global const bvh2_ray *rays, __global int *found, uint count, uint slice) {
    const uint first = (uint)get_group_id(0) * slice;
    const uint last = min(first + slice, count);
    for (uint i = first; i < last; ++i)
        found[i] = bvh2_traverse(nodes, triangles, rays + i, 1).primitive != MCV_NONE;
}
