/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Eight rays that go much the same way, through the hierarchy together: what they share is computed once, and what differs side by
 * side in float8. They find what they find alone, to the last bit: a triangle is tested by the same arithmetic, and boxes only
 * leave out what cannot be hit (kernels/traverse.h; any superset of the leaves gives the same hit).
 *
 * The hull of a bundle. All rays have the same main axis z and run the same way along it. Let h be the depth along it from a start that
 * no ray lies before. A ray is x(h) = x0 + s h with |s| <= 1, so the bundle lies between min x0 + min s h and max x0 + max s h, which
 * over a box's range of h are largest at one of its ends: one test for all eight children. With R of the largest ray, a hit lies
 * within 19 u R of its box in x and in z (as much again in x), x0 rounds by 9 u R and x(h) by as much: 64 u R is the margin, also of the
 * start, so that h of a box that reaches back to an origin is not negative, and of the depth behind which nothing is looked for.
 */
#ifndef MCVISI_BUNDLE_H
#define MCVISI_BUNDLE_H

#include "traverse.h"

#define MCV_BUNDLE 8
#define MCV_LANES(v, c) (float8)(v[0].c, v[1].c, v[2].c, v[3].c, v[4].c, v[5].c, v[6].c, v[7].c)

typedef struct mcv_bundle {
    float8 inverse[3], near_offset[3], far_offset[3]; /* slabs, as in mcv_ray_frame */
    float8 t;                                         /* nothing behind it is looked for; negative: the ray is done */
    float8 speed, ahead;                              /* h = t speed + ahead */
    float shear[2][MCV_BUNDLE], scale[MCV_BUNDLE], origin[3][MCV_BUNDLE];
    uint x, y, z; /* the axes, z the main one */
    float sign, start, margin;
    float least_place[2], most_place[2], least_slope[2], most_slope[2];
    float depth; /* h of the farthest t */
} mcv_bundle;

static inline float mcv_least_lane(float8 lanes) {
    const float4 four = min(lanes.lo, lanes.hi);
    const float2 two = min(four.lo, four.hi);
    return min(two.x, two.y);
}

static inline float mcv_most_lane(float8 lanes) {
    const float4 four = max(lanes.lo, lanes.hi);
    const float2 two = max(four.lo, four.hi);
    return max(two.x, two.y);
}

static inline void mcv_bundle_limit(mcv_bundle *b, float8 t) {
    b->t = t;
    b->depth = mcv_most_lane(fma(t, b->speed, b->ahead)) + b->margin;
}

/* Returns 0 for rays that have no hull: of different main axes or not finite. They must go alone. */
static inline int mcv_bundle_setup(const float8 o[3], const float8 d[3], float8 t_max, float extent, mcv_bundle *b) {
    const float8 dx = fabs(d[0]), dy = fabs(d[1]), dz = fabs(d[2]);
    const float8 largest = max(dx, max(dy, dz));
    const float8 reach = max(fabs(o[0]), max(fabs(o[1]), fabs(o[2]))) + extent;
    const uint all = (1u << MCV_BUNDLE) - 1u;
    const uint main_z = mcv_mask8((dz >= dx) & (dz >= dy)), main_y = mcv_mask8(dy >= dx);
    if (mcv_mask8((largest > 0.0f) & (reach + largest < INFINITY)) != all) return 0;
    if (main_z != 0u ? main_z != all : main_y != 0u && main_y != all) return 0;
    b->z = main_z ? 2u : main_y ? 1u : 0u;
    b->x = b->z == 2u ? 0u : b->z + 1u;
    b->y = b->z == 0u ? 2u : b->z - 1u;
    const float8 along = d[b->z];
    const uint negative = mcv_mask8(along < 0.0f);
    if (negative != 0u && negative != all) return 0;

    const float8 spread = 32.0f * MCV_UNIT_ROUNDOFF * reach;
    const float8 least = largest * 0x1p-64f;
#pragma unroll
    for (int axis = 0; axis < 3; ++axis) {
        b->inverse[axis] = 1.0f / (fabs(d[axis]) < least ? copysign(least, d[axis]) : d[axis]);
        b->near_offset[axis] = -o[axis] * b->inverse[axis] - spread * fabs(b->inverse[axis]);
        b->far_offset[axis] = -o[axis] * b->inverse[axis] + spread * fabs(b->inverse[axis]);
    }
    b->sign = negative ? -1.0f : 1.0f;
    b->margin = 64.0f * MCV_UNIT_ROUNDOFF * mcv_most_lane(reach);
    const float first = mcv_least_lane(b->sign * o[b->z]) - b->margin;
    b->start = b->sign * first;
    b->speed = fabs(along);
    b->ahead = b->sign * o[b->z] - first;
    vstore8(1.0f / along, 0, b->scale);
    vstore8(o[b->z], 0, b->origin[2]);
#pragma unroll
    for (int k = 0; k < 2; ++k) {
        const uint axis = k ? b->y : b->x;
        const float8 shear = d[axis] / along;
        const float8 place = fma(shear, b->start - o[b->z], o[axis]);
        vstore8(shear, 0, b->shear[k]);
        vstore8(o[axis], 0, b->origin[k]);
        b->least_place[k] = mcv_least_lane(place) - b->margin;
        b->most_place[k] = mcv_most_lane(place) + b->margin;
        b->least_slope[k] = mcv_least_lane(b->sign * shear);
        b->most_slope[k] = mcv_most_lane(b->sign * shear);
    }
    mcv_bundle_limit(b, t_max);
    return 1;
}

/* The children whose boxes the hull meets, one bit each, and the depths where they begin. */
static inline uint mcv_intersect_hull(__global const mcv_node *node, const mcv_bundle *b, float8 *entry) {
    const uint first = b->sign < 0.0f ? 1u : 0u;
    const float8 near = max(b->sign * (*(__global const float8 *)node->bounds[b->z][first] - b->start), 0.0f);
    const float8 far = b->sign * (*(__global const float8 *)node->bounds[b->z][1u - first] - b->start);
    int8 outside = (far < 0.0f) | (near > b->depth);
#pragma unroll
    for (int k = 0; k < 2; ++k) {
        const uint axis = k ? b->y : b->x;
        const float8 low = b->least_place[k], high = b->most_place[k];
        const float8 lower = min(fma(near, (float8)(b->least_slope[k]), low), fma(far, (float8)(b->least_slope[k]), low));
        const float8 upper = max(fma(near, (float8)(b->most_slope[k]), high), fma(far, (float8)(b->most_slope[k]), high));
        outside |= *(__global const float8 *)node->bounds[axis][0] > upper;
        outside |= *(__global const float8 *)node->bounds[axis][1] < lower;
    }
    *entry = near;
    return mcv_mask8(~outside);
}

/* The rays that meet the box of one child, one bit each. */
static inline uint mcv_meet_box(__global const mcv_node *node, uint child, const mcv_bundle *b) {
    float8 near = (float8)(0.0f), far = b->t;
#pragma unroll
    for (int axis = 0; axis < 3; ++axis) {
        const float8 lower = node->bounds[axis][0][child] * b->inverse[axis];
        const float8 upper = node->bounds[axis][1][child] * b->inverse[axis];
        near = max(near, min(lower, upper) + b->near_offset[axis]);
        far = min(far, max(lower, upper) + b->far_offset[axis]);
    }
    return mcv_mask8(near <= far);
}

/* A leaf against some of the rays. */
static inline void mcv_bundle_leaf(__global const mcv_leaf *leaf, mcv_bundle *b, uint rays, int any, mcv_hit *hits) {
    float t[MCV_BUNDLE];
    int changed = 0;
    vstore8(b->t, 0, t);
    while (rays) {
        const uint i = mcv_pop_bit(&rays);
        const mcv_shear ray = {4u * b->x,       4u * b->y,      4u * b->z,      b->origin[0][i], b->origin[1][i],
                               b->origin[2][i], b->shear[0][i], b->shear[1][i], b->scale[i]};
        if (t[i] >= 0.0f && mcv_intersect_leaf(leaf, &ray, hits + i)) {
            t[i] = any ? -1.0f : hits[i].t;
            changed = 1;
        }
    }
    if (changed) mcv_bundle_limit(b, vload8(0, t));
}

/*
 * A child waits with the rays that meet it: they take the place of the last bits of the depth where it begins, which so may only
 * become less.
 */
static inline ulong mcv_wait_with(float entry, uint rays, uint child) { return mcv_wait(as_float((as_uint(entry) & ~255u) | rays), child); }
static inline float mcv_depth_of(ulong waiting) { return as_float((uint)(waiting >> 32) & ~255u); }

static inline __attribute__((always_inline)) void mcv_bundle_traverse(__global const mcv_node *nodes, __global const mcv_leaf *leaves,
                                                                      mcv_bundle *b, int any, mcv_hit *hits) {
    ulong waiting[MCV_BVH_STACK];
    ulong next = 0;
    uint count = 0;
    do {
        const uint current = (uint)next;
        if (current & MCV_CHILD_LEAF) {
            mcv_bundle_leaf(leaves + (current & ~MCV_CHILD_LEAF), b, (uint)(next >> 32) & 255u, any, hits);
            if (any && !mcv_mask8(b->t >= 0.0f)) return;
        } else {
            __global const mcv_node *node = nodes + current;
            float8 begin;
            float entry[MCV_BVH_WIDTH];
            uint mask = mcv_intersect_hull(node, b, &begin);
            vstore8(begin, 0, entry);
            const uint bottom = count;
            while (mask) {
                const uint lane = mcv_pop_bit(&mask);
                const uint rays = mcv_meet_box(node, lane, b);
                if (!rays) continue;
                mcv_prefetch_child(nodes, leaves, node->child[lane]);
                const ulong other = mcv_wait_with(entry[lane], rays, node->child[lane]);
                uint place = count++;
                for (; place > bottom && waiting[place - 1] < other; --place) waiting[place] = waiting[place - 1];
                waiting[place] = other;
            }
        }
        do {
            if (count == 0) return;
            next = waiting[--count];
        } while (mcv_depth_of(next) > b->depth);
    } while (1);
}

/* ---- few triangles ---------------------------------------------------------------------------------------------- */

/* Whether the root is all there is: then eight rays go together, whichever way each goes. */
static inline int mcv_is_flat(__global const mcv_node *root) {
    uint bits = MCV_CHILD_LEAF;
    for (uint i = 0; i < MCV_BVH_WIDTH; ++i) bits &= root->child[i]; /* MCV_NONE has it, too */
    return bits != 0u;
}

/* Eight rays as the tests of triangles need them (mcv_shear), and what they have hit so far. */
typedef struct mcv_lanes {
    float8 origin_x, origin_y, origin_z, shear_x, shear_y, scale_z;
    int8 main_z, main_y; /* whether that is the main axis; else it is x */
    float8 t, u, v;
    uint8 triangle;
} mcv_lanes;

/* The coordinates of a vertex along the axes x, y, z of the rays. */
#define MCV_LANES_OF(rays, if_z, if_y, if_x) ((rays)->main_z ? (float8)(if_z) : (rays)->main_y ? (float8)(if_y) : (float8)(if_x))

/* One triangle of a leaf against all rays, as mcv_intersect_leaf does it with all of them and one ray. */
static inline __attribute__((always_inline)) void mcv_lanes_meet(__global const mcv_leaf *leaf, uint lane, int any, mcv_lanes *rays) {
    const uint8 triangle = (uint8)(leaf->triangle[lane]);
    float8 x[3], y[3], z[3], t, b, c, det;
    int8 met;
#pragma unroll
    for (int corner = 0; corner < 3; ++corner) {
        const float p = leaf->vertex[corner][0][lane], q = leaf->vertex[corner][1][lane], r = leaf->vertex[corner][2][lane];
        z[corner] = MCV_LANES_OF(rays, r, q, p) - rays->origin_z;
        x[corner] = fma(-rays->shear_x, z[corner], MCV_LANES_OF(rays, p, r, q) - rays->origin_x);
        y[corner] = fma(-rays->shear_y, z[corner], MCV_LANES_OF(rays, q, p, r) - rays->origin_y);
    }
    if (!mcv_meet_sheared8(x, y, z, rays->shear_x, rays->shear_y, rays->scale_z, rays->t, &met, &t, &b, &c, &det)) return;
    if (any) {
        rays->triangle = met ? triangle : rays->triangle;
        rays->t = met ? (float8)(-1.0f) : rays->t;
        return;
    }
    met &= (t < rays->t) | ((t == rays->t) & (rays->triangle != MCV_NONE) & (triangle < rays->triangle));
    rays->t = met ? t : rays->t;
    rays->u = met ? b / det : rays->u;
    rays->v = met ? c / det : rays->v;
    rays->triangle = met ? triangle : rays->triangle;
}

static inline __attribute__((always_inline)) void mcv_flat_traverse(__global const mcv_node *root, __global const mcv_leaf *leaves,
                                                                    const float8 o[3], const float8 d[3], int any, mcv_lanes *rays) {
    const float8 dx = fabs(d[0]), dy = fabs(d[1]), dz = fabs(d[2]);
    const float8 reach = max(fabs(o[0]), max(fabs(o[1]), fabs(o[2]))) + root->extent;
    const float8 spread = 32.0f * MCV_UNIT_ROUNDOFF * reach;
    const float8 least = max(dx, max(dy, dz)) * 0x1p-64f;
    float8 inverse[3], near_offset[3], far_offset[3];
#pragma unroll
    for (int axis = 0; axis < 3; ++axis) {
        inverse[axis] = 1.0f / (fabs(d[axis]) < least ? copysign(least, d[axis]) : d[axis]);
        near_offset[axis] = -o[axis] * inverse[axis] - spread * fabs(inverse[axis]);
        far_offset[axis] = -o[axis] * inverse[axis] + spread * fabs(inverse[axis]);
    }
    rays->main_z = (dz >= dx) & (dz >= dy);
    rays->main_y = dy >= dx;
    const float8 along = MCV_LANES_OF(rays, d[2], d[1], d[0]);
    rays->origin_x = MCV_LANES_OF(rays, o[0], o[2], o[1]);
    rays->origin_y = MCV_LANES_OF(rays, o[1], o[0], o[2]);
    rays->origin_z = MCV_LANES_OF(rays, o[2], o[1], o[0]);
    rays->shear_x = MCV_LANES_OF(rays, d[0], d[2], d[1]) / along;
    rays->shear_y = MCV_LANES_OF(rays, d[1], d[0], d[2]) / along;
    rays->scale_z = 1.0f / along;
    for (uint child = 0; child < MCV_BVH_WIDTH; ++child) {
        if (root->child[child] == MCV_NONE) continue;
        __global const mcv_leaf *leaf = leaves + (root->child[child] & ~MCV_CHILD_LEAF);
        float8 near = (float8)(0.0f), far = rays->t;
#pragma unroll
        for (int axis = 0; axis < 3; ++axis) {
            const float8 lower = root->bounds[axis][0][child] * inverse[axis];
            const float8 upper = root->bounds[axis][1][child] * inverse[axis];
            near = max(near, min(lower, upper) + near_offset[axis]);
            far = min(far, max(lower, upper) + far_offset[axis]);
        }
        if (!mcv_mask8(near <= far)) continue;
        for (uint lane = 0; lane < MCV_LEAF_TRIANGLES; ++lane)
            if (leaf->triangle[lane] != MCV_NONE) mcv_lanes_meet(leaf, lane, any, rays);
    }
}

/* ---- many rays -------------------------------------------------------------------------------------------------- */

/* The hits of the rays indices[0 … count - 1] as mcv_take_turns has them, eight neighbours at a time. */
static inline __attribute__((always_inline)) void mcv_take_bundles(__global const mcv_node *nodes, __global const mcv_leaf *leaves,
                                                                   mcv_rows origins, mcv_rows directions, const uint *indices, uint count,
                                                                   int any, mcv_hit *hits) {
    const int flat = mcv_is_flat(nodes);
    for (uint first = 0; first < count; first += MCV_BUNDLE, hits += MCV_BUNDLE) {
        const uint used = min(count - first, (uint)MCV_BUNDLE);
        mcv_vec3 o[MCV_BUNDLE], d[MCV_BUNDLE];
        float t[MCV_BUNDLE];
        /* Unrolled, or the compiler makes a loop of gathers, which are slower. */
#pragma unroll
        for (uint i = 0; i < MCV_BUNDLE; ++i) {
            const uint ray = indices[first + min(i, used - 1u)];
            o[i] = mcv_row(origins, ray);
            d[i] = mcv_row(directions, ray);
            t[i] = i < used ? hits[i].t : -1.0f;
        }
        const float8 origin[3] = {MCV_LANES(o, x), MCV_LANES(o, y), MCV_LANES(o, z)};
        const float8 direction[3] = {MCV_LANES(d, x), MCV_LANES(d, y), MCV_LANES(d, z)};
        if (flat) {
            mcv_lanes rays;
            float u[MCV_BUNDLE], v[MCV_BUNDLE];
            uint triangle[MCV_BUNDLE];
            rays.t = vload8(0, t);
            rays.u = rays.v = (float8)(0.0f);
            rays.triangle = (uint8)(MCV_NONE);
            mcv_flat_traverse(nodes, leaves, origin, direction, any, &rays);
            vstore8(rays.t, 0, t);
            vstore8(rays.u, 0, u);
            vstore8(rays.v, 0, v);
            vstore8(rays.triangle, 0, triangle);
            for (uint i = 0; i < used; ++i) {
                hits[i].triangle = triangle[i];
                if (any) continue;
                hits[i].t = t[i];
                hits[i].u = u[i];
                hits[i].v = v[i];
            }
            continue;
        }
        mcv_bundle b;
        if (mcv_bundle_setup(origin, direction, vload8(0, t), nodes->extent, &b)) {
            mcv_bundle_traverse(nodes, leaves, &b, any, hits);
            continue;
        }
        for (uint i = 0; i < used; ++i) {
            const mcv_vec3 from = o[i], along = d[i];
            if (!any)
                hits[i] = mcv_intersect_closest_ray(nodes, leaves, from, along, t[i]);
            else if (mcv_intersect_any_ray(nodes, leaves, from, along, t[i]))
                hits[i].triangle = 0;
        }
    }
}

static inline __attribute__((noinline)) void mcv_intersect_closest_bundles(__global const mcv_node *nodes, __global const mcv_leaf *leaves,
                                                                           mcv_rows origins, mcv_rows directions, const uint *indices,
                                                                           uint count, mcv_hit *hits) {
    mcv_take_bundles(nodes, leaves, origins, directions, indices, count, 0, hits);
}

static inline __attribute__((noinline)) void mcv_intersect_any_bundles(__global const mcv_node *nodes, __global const mcv_leaf *leaves,
                                                                       mcv_rows origins, mcv_rows directions, const uint *indices,
                                                                       uint count, mcv_hit *hits) {
    mcv_take_bundles(nodes, leaves, origins, directions, indices, count, 1, hits);
}

#endif
