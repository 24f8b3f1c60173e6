/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Many rays through the hierarchy together (J. A. Tsakok, Faster Incoherent Rays: Multi-BVH Ray
 * Stream Tracing, HPG 2009): a node or a leaf is met once, with a list of all rays that come to it.
 * Rays from places close to each other come to much the same ones, whichever way they go then. They
 * share the branches that no processor foresees, which is where a ray alone spends its time, and a
 * leaf is tested with many of them side by side.
 *
 * They find what they find alone, to the last bit: a triangle is tested by the same arithmetic, and
 * boxes only leave out what cannot be hit (kernels/traverse/bvh8.h; any superset of the leaves in
 * any order gives the same hit).
 */
#ifndef MCVISI_BUNDLE_H
#define MCVISI_BUNDLE_H

#include "traverse/bvh8.h"

#define MCV_PACKET 256                   /* numbers in a list are bytes */
#define MCV_PACKET_ROW (MCV_PACKET + 16) /* as of MCV_ROW */

/* From so few rays on each goes on alone: nearest first is then worth more than company. */
#define MCV_PACKET_FEW 5

/* So many rays take turns where they are alone, and so many wait for that before they do. */
#define MCV_INTERLEAVED 16
#define MCV_STRAGGLERS 64

/* Rays side by side: as many as the processor's registers hold. */
#ifdef __AVX512F__
#define MCV_LANES 16
typedef float16 mcv_floats;
typedef int16 mcv_ints;
typedef uint16 mcv_uints;
#define mcv_load_lanes(from) vload16(0, from)
#define mcv_store_lanes(lanes, to) vstore16(lanes, 0, to)
#define mcv_mask_lanes mcv_mask16
#define mcv_intersect_lanes mcv_intersect_sheared16
#define mcv_as_floats as_float16
#define mcv_as_uints as_uint16
MCV_INTERSECT_SHEARED(mcv_intersect_sheared16, mcv_edge_function16, mcv_edge_rises16, float16,
                      int16, mcv_mask16)
#else
#define MCV_LANES 8
typedef float8 mcv_floats;
typedef int8 mcv_ints;
typedef uint8 mcv_uints;
#define mcv_load_lanes(from) vload8(0, from)
#define mcv_store_lanes(lanes, to) vstore8(lanes, 0, to)
#define mcv_mask_lanes mcv_mask8
#define mcv_intersect_lanes mcv_intersect_sheared8
#define mcv_as_floats as_float8
#define mcv_as_uints as_uint8
#endif

/* Hits side by side: rows of their fields' bits. */
typedef struct mcv_hits {
    uint *t, *u, *v, *triangle;
} mcv_hits;

static inline mcv_hits mcv_hits_in(uint *rows, uint step) {
    const mcv_hits hits = {rows, rows + step, rows + 2u * step, rows + 3u * step};
    return hits;
}

static inline mcv_hit mcv_hit_of(mcv_hits hits, uint i) {
    const mcv_hit hit = {as_float(hits.t[i]), as_float(hits.u[i]), as_float(hits.v[i]),
                         hits.triangle[i]};
    return hit;
}

static inline void mcv_put_hit(mcv_hits hits, uint i, mcv_hit hit) {
    hits.t[i] = as_uint(hit.t);
    hits.u[i] = as_uint(hit.u);
    hits.v[i] = as_uint(hit.v);
    hits.triangle[i] = hit.triangle;
}

/* Rays as the tests of triangles need them (mcv_shear), and what they have hit so far. */
typedef struct mcv_lanes {
    mcv_floats origin_x, origin_y, origin_z, shear_x, shear_y, scale_z;
    mcv_ints main_z, main_y; /* whether that is the main axis; else it is x */
    mcv_floats t, b, c, det; /* as of mcv_intersect_sheared8 */
    mcv_uints triangle;
} mcv_lanes;

/* The components of a vector along the axes x, y, z of the rays. */
#define MCV_LANES_OF(rays, if_z, if_y, if_x) \
    ((rays)->main_z ? (mcv_floats)(if_z) : (rays)->main_y ? (mcv_floats)(if_y) : (mcv_floats)(if_x))

/* The slabs of the rays, as in mcv_ray_frame. */
typedef struct mcv_slabs {
    mcv_floats inverse[3], near_offset[3], far_offset[3];
} mcv_slabs;

/* One row of the given rays; neighbours: they follow each other. */
#define MCV_TAKE_LANES(row, step, numbers, neighbours, lanes) \
    do { \
        if (neighbours) { \
            (lanes) = mcv_load_lanes((row) + (numbers)[0]); \
        } else { \
            uint mcv_taken[MCV_LANES]; \
            /* Unrolled, or the compiler makes a loop of gathers, which are slower. */ \
            _Pragma("unroll") for (uint mcv_lane = 0; mcv_lane < MCV_LANES; ++mcv_lane) \
                mcv_taken[mcv_lane] = (row)[(numbers)[mcv_lane] * (step)]; \
            (lanes) = mcv_load_lanes(mcv_taken); \
        } \
    } while (0)

/* Whether the numbers of the rays follow each other. */
static inline int mcv_are_neighbours(const uint *numbers) {
    uint apart = 0;
    for (uint i = 0; i < MCV_LANES; ++i) apart |= numbers[i] ^ (numbers[0] + i);
    return apart == 0;
}

/* mcv_ray_setup of the rays of these numbers; neighbours: they follow each other in rows. */
static inline __attribute__((always_inline)) void
mcv_lanes_setup(mcv_rows origins, mcv_rows directions, const uint *numbers, int neighbours,
                float extent, mcv_slabs *slabs, mcv_lanes *rays) {
    mcv_uints rows[6];
#pragma unroll
    for (uint k = 0; k < 3; ++k) {
        MCV_TAKE_LANES(origins.base + k * origins.component, origins.step, numbers, neighbours,
                       rows[k]);
        MCV_TAKE_LANES(directions.base + k * directions.component, directions.step, numbers,
                       neighbours, rows[3 + k]);
    }
    const mcv_floats ox = mcv_as_floats(rows[0]), oy = mcv_as_floats(rows[1]),
                     oz = mcv_as_floats(rows[2]);
    const mcv_floats x = mcv_as_floats(rows[3]), y = mcv_as_floats(rows[4]),
                     z = mcv_as_floats(rows[5]);
    const mcv_floats dx = fabs(x), dy = fabs(y), dz = fabs(z);
    const mcv_floats reach = max(fabs(ox), max(fabs(oy), fabs(oz))) + extent;
    const mcv_floats margin = 32.0f * MCV_UNIT_ROUNDOFF * reach;
    const mcv_floats least = max(dx, max(dy, dz)) * 0x1p-64f;
#pragma unroll
    for (int axis = 0; axis < 3; ++axis) {
        const mcv_floats origin = axis == 0   ? ox
                                  : axis == 1 ? oy
                                              : oz,
                         direction = axis == 0   ? x
                                     : axis == 1 ? y
                                                 : z;
        const mcv_floats inverse =
            1.0f / (fabs(direction) < least ? copysign(least, direction) : direction);
        const mcv_floats spread = margin * fabs(inverse);
        slabs->inverse[axis] = inverse;
        slabs->near_offset[axis] = -origin * inverse - spread;
        slabs->far_offset[axis] = -origin * inverse + spread;
    }
    rays->main_z = (dz >= dx) & (dz >= dy);
    rays->main_y = dy >= dx;
    const mcv_floats along = MCV_LANES_OF(rays, z, y, x);
    rays->origin_x = MCV_LANES_OF(rays, ox, oz, oy);
    rays->origin_y = MCV_LANES_OF(rays, oy, ox, oz);
    rays->origin_z = MCV_LANES_OF(rays, oz, oy, ox);
    rays->shear_x = MCV_LANES_OF(rays, x, z, y) / along;
    rays->shear_y = MCV_LANES_OF(rays, y, x, z) / along;
    rays->scale_z = 1.0f / along;
}

/* A triangle of a leaf: its first coordinate. */
#define MCV_CORNERS_OF(leaf, lane) ((__global const float *)(leaf)->vertex + (lane))

/*
 * One triangle against all rays, as mcv_intersect_leaf does it with all of a leaf and one ray; of a
 * ray that has hit t is -1 where any hit will do. Returns those that have hit, one bit each.
 */
static inline __attribute__((always_inline)) uint
mcv_lanes_hit(__global const float *corners, uint number, int any, mcv_lanes *rays) {
    const mcv_uints triangle = (mcv_uints)(number);
    mcv_floats x[3], y[3], z[3], t, b, c, det;
    mcv_ints met;
#pragma unroll
    for (int corner = 0; corner < 3; ++corner) {
        __global const float *v = corners + 3 * MCV_LEAF_TRIANGLES * corner;
        const float p = v[0], q = v[MCV_LEAF_TRIANGLES], r = v[2 * MCV_LEAF_TRIANGLES];
        z[corner] = MCV_LANES_OF(rays, r, q, p) - rays->origin_z;
        x[corner] = fma(-rays->shear_x, z[corner], MCV_LANES_OF(rays, p, r, q) - rays->origin_x);
        y[corner] = fma(-rays->shear_y, z[corner], MCV_LANES_OF(rays, q, p, r) - rays->origin_y);
    }
    if (!mcv_intersect_lanes(x, y, z, rays->shear_x, rays->shear_y, rays->scale_z, rays->t, &met,
                             &t, &b, &c, &det))
        return 0;
    if (any) {
        met &= t < rays->t;
        rays->triangle = met ? triangle : rays->triangle;
        rays->t = met ? (mcv_floats)(-1.0f) : rays->t;
        return mcv_mask_lanes(met);
    }
    met &= (t < rays->t) |
           ((t == rays->t) & (rays->triangle != MCV_NONE) & (triangle < rays->triangle));
    rays->t = met ? t : rays->t;
    rays->b = met ? b : rays->b;
    rays->c = met ? c : rays->c;
    rays->det = met ? det : rays->det;
    rays->triangle = met ? triangle : rays->triangle;
    return mcv_mask_lanes(met);
}

/* ---- few triangles
 * ---------------------------------------------------------------------------------------------- */

/* Whether the root is all there is: then there is nothing to list. */
static inline int mcv_is_flat(__global const mcv_node *root) {
    uint bits = MCV_CHILD_LEAF;
    for (uint i = 0; i < MCV_BVH_WIDTH; ++i) bits &= root->child[i]; /* MCV_NONE has it, too */
    return bits != 0u;
}

static inline __attribute__((always_inline)) void
mcv_take_flat(__global const mcv_node *root, __global const mcv_leaf *leaves, mcv_rows origins,
              mcv_rows directions, const uint *numbers, uint count, int any, mcv_hits hits) {
    __global const float *corners[MCV_BVH_WIDTH * MCV_LEAF_TRIANGLES];
    uint triangles[MCV_BVH_WIDTH * MCV_LEAF_TRIANGLES];
    uint triangle_count = 0;
    for (uint child = 0; child < MCV_BVH_WIDTH; ++child) {
        if (root->child[child] == MCV_NONE) continue;
        __global const mcv_leaf *leaf = leaves + (root->child[child] & ~MCV_CHILD_LEAF);
        for (uint lane = 0; lane < MCV_LEAF_TRIANGLES && leaf->triangle[lane] != MCV_NONE; ++lane) {
            corners[triangle_count] = MCV_CORNERS_OF(leaf, lane);
            triangles[triangle_count++] = leaf->triangle[lane];
        }
    }
    if (triangle_count == 0) return;
    for (uint first = 0; first < count; first += MCV_LANES) {
        const uint *own = numbers + first;
        uint last[MCV_LANES]; /* the last one in place of those that are not there */
        mcv_slabs slabs;
        mcv_lanes rays;
        mcv_uints start, t;
        if (count - first < MCV_LANES) {
            for (uint i = 0; i < MCV_LANES; ++i) last[i] = numbers[min(first + i, count - 1u)];
            own = last;
        }
        const int neighbours = origins.step == 1u && mcv_are_neighbours(own);
        mcv_lanes_setup(origins, directions, own, neighbours, root->extent, &slabs, &rays);
        MCV_TAKE_LANES(hits.t, 1u, own, neighbours, t);
        MCV_TAKE_LANES(hits.triangle, 1u, own, neighbours, start);
        rays.t = mcv_as_floats(t);
        rays.triangle = start;
        rays.b = rays.c = rays.det = (mcv_floats)(1.0f);
        uint changed = 0;
        for (uint i = 0; i < triangle_count; ++i)
            changed |= mcv_lanes_hit(corners[i], triangles[i], any, &rays);
        if (!changed) continue;
        const mcv_uints u = mcv_as_uints(rays.b / rays.det), v = mcv_as_uints(rays.c / rays.det);
        if (neighbours) {
            mcv_store_lanes(rays.triangle, hits.triangle + own[0]);
            if (any) continue;
            const mcv_ints met = rays.triangle != start;
            mcv_store_lanes(mcv_as_uints(rays.t), hits.t + own[0]);
            mcv_store_lanes(met ? u : mcv_load_lanes(hits.u + own[0]), hits.u + own[0]);
            mcv_store_lanes(met ? v : mcv_load_lanes(hits.v + own[0]), hits.v + own[0]);
            continue;
        }
        uint met[4][MCV_LANES];
        mcv_store_lanes(mcv_as_uints(rays.t), met[0]);
        mcv_store_lanes(u, met[1]);
        mcv_store_lanes(v, met[2]);
        mcv_store_lanes(rays.triangle, met[3]);
        do {
            const uint k = mcv_pop_bit(&changed), i = own[k];
            hits.triangle[i] = met[3][k];
            if (any) continue;
            hits.t[i] = met[0][k];
            hits.u[i] = met[1][k];
            hits.v[i] = met[2][k];
        } while (changed);
    }
}

/* ---- many triangles
 * --------------------------------------------------------------------------------------------- */

/* Rays side by side: slabs as in mcv_ray_frame, the rest as in mcv_shear. */
typedef struct mcv_packet {
    float inverse[3][MCV_PACKET_ROW], near_offset[3][MCV_PACKET_ROW], far_offset[3][MCV_PACKET_ROW];
    float origin[3][MCV_PACKET_ROW], shear[2][MCV_PACKET_ROW], scale[MCV_PACKET_ROW];
    uint main_axis[MCV_PACKET_ROW];
    float t[MCV_PACKET_ROW]; /* nothing behind it is looked for; negative: the ray is done */
} mcv_packet;

static inline __attribute__((always_inline)) void
mcv_packet_setup(mcv_rows origins, mcv_rows directions, const uint *numbers, uint count,
                 float extent, const mcv_hit *hits, mcv_packet *b) {
    for (uint first = 0; first < count; first += MCV_LANES) {
        uint own[MCV_LANES]; /* the last one in place of those that are not there */
        mcv_slabs slabs;
        mcv_lanes rays;
        for (uint i = 0; i < MCV_LANES; ++i) own[i] = numbers[min(first + i, count - 1u)];
        mcv_lanes_setup(origins, directions, own, 0, extent, &slabs, &rays);
#pragma unroll
        for (int axis = 0; axis < 3; ++axis) {
            mcv_store_lanes(slabs.inverse[axis], b->inverse[axis] + first);
            mcv_store_lanes(slabs.near_offset[axis], b->near_offset[axis] + first);
            mcv_store_lanes(slabs.far_offset[axis], b->far_offset[axis] + first);
        }
        mcv_store_lanes(rays.origin_x, b->origin[0] + first);
        mcv_store_lanes(rays.origin_y, b->origin[1] + first);
        mcv_store_lanes(rays.origin_z, b->origin[2] + first);
        mcv_store_lanes(rays.shear_x, b->shear[0] + first);
        mcv_store_lanes(rays.shear_y, b->shear[1] + first);
        mcv_store_lanes(rays.scale_z, b->scale + first);
        mcv_store_lanes(rays.main_z   ? (mcv_uints)(2u)
                        : rays.main_y ? (mcv_uints)(1u)
                                      : (mcv_uints)(0u),
                        b->main_axis + first);
    }
    for (uint i = 0; i < count; ++i) b->t[i] = hits[i].t;
}

static inline mcv_ray_frame mcv_packet_ray(const mcv_packet *b, uint i) {
    const uint z = b->main_axis[i];
    mcv_ray_frame ray;
#pragma unroll
    for (int axis = 0; axis < 3; ++axis) {
        ray.inverse[axis] = b->inverse[axis][i];
        ray.near_offset[axis] = b->near_offset[axis][i];
        ray.far_offset[axis] = b->far_offset[axis][i];
        ray.near_row[axis] = as_uint(ray.inverse[axis]) >> 31;
    }
    ray.shear.row_x = z == 2u ? 0u : 4u * (z + 1u);
    ray.shear.row_y = z == 0u ? 8u : 4u * (z - 1u);
    ray.shear.row_z = 4u * z;
    ray.shear.origin_x = b->origin[0][i];
    ray.shear.origin_y = b->origin[1][i];
    ray.shear.origin_z = b->origin[2][i];
    ray.shear.shear_x = b->shear[0][i];
    ray.shear.shear_y = b->shear[1][i];
    ray.shear.scale_z = b->scale[i];
    return ray;
}

/* mcv_intersect_boxes of a ray of a bundle. */
static inline uint mcv_packet_boxes(__global const mcv_node *node, const mcv_packet *b, uint i,
                                    float8 *entry) {
    float8 near = (float8)(0.0f), far = (float8)(b->t[i]);
#pragma unroll
    for (int axis = 0; axis < 3; ++axis) {
        const float inverse = b->inverse[axis][i];
        const uint near_row = as_uint(inverse) >> 31;
        const float8 first = *(__global const float8 *)node->bounds[axis][near_row];
        const float8 second = *(__global const float8 *)node->bounds[axis][1u - near_row];
        near = max(near, fma(first, (float8)(inverse), (float8)(b->near_offset[axis][i])));
        far = min(far, fma(second, (float8)(inverse), (float8)(b->far_offset[axis][i])));
    }
    *entry = near;
    return mcv_mask8(near <= far);
}

/* A leaf against the rays of a list. */
static inline __attribute__((noinline)) void mcv_packet_leaf(__global const mcv_leaf *leaf,
                                                             mcv_packet *b, const uchar *list,
                                                             uint count, int any, mcv_hit *hits) {
    for (uint first = 0; first < count; first += MCV_LANES) {
        uint i[MCV_LANES], main_axis[MCV_LANES], triangles[MCV_LANES];
        float o[3][MCV_LANES], shear[2][MCV_LANES], scale[MCV_LANES], t[MCV_LANES], u[MCV_LANES],
            v[MCV_LANES];
        mcv_lanes rays;
        uint changed = 0;
#pragma unroll
        for (uint k = 0; k < MCV_LANES; ++k) {
            const uint ray = list[min(first + k, count - 1u)];
            i[k] = ray;
            triangles[k] = hits[ray].triangle;
            main_axis[k] = b->main_axis[ray];
            o[0][k] = b->origin[0][ray], o[1][k] = b->origin[1][ray], o[2][k] = b->origin[2][ray];
            shear[0][k] = b->shear[0][ray], shear[1][k] = b->shear[1][ray];
            scale[k] = b->scale[ray];
            t[k] = b->t[ray];
        }
        const mcv_uints axis = mcv_load_lanes(main_axis);
        rays.main_z = axis == 2u;
        rays.main_y = axis == 1u;
        rays.origin_x = mcv_load_lanes(o[0]);
        rays.origin_y = mcv_load_lanes(o[1]);
        rays.origin_z = mcv_load_lanes(o[2]);
        rays.shear_x = mcv_load_lanes(shear[0]);
        rays.shear_y = mcv_load_lanes(shear[1]);
        rays.scale_z = mcv_load_lanes(scale);
        rays.t = mcv_load_lanes(t);
        rays.b = rays.c = rays.det = (mcv_floats)(1.0f);
        rays.triangle = mcv_load_lanes(triangles);
        for (uint lane = 0; lane < MCV_LEAF_TRIANGLES && leaf->triangle[lane] != MCV_NONE; ++lane)
            changed |= mcv_lanes_hit(MCV_CORNERS_OF(leaf, lane), leaf->triangle[lane], any, &rays);
        if (!changed) continue;
        mcv_store_lanes(rays.t, t);
        mcv_store_lanes(rays.b / rays.det, u);
        mcv_store_lanes(rays.c / rays.det, v);
        mcv_store_lanes(rays.triangle, triangles);
        do {
            const uint k = mcv_pop_bit(&changed);
            mcv_hit *hit = hits + i[k];
            b->t[i[k]] = t[k];
            hit->triangle = triangles[k];
            if (any) continue;
            hit->t = t[k];
            hit->u = u[k];
            hit->v = v[k];
        } while (changed);
    }
}

/* A ray that goes on alone from a node or leaf. */
typedef struct mcv_straggler {
    uint ray, child;
} mcv_straggler;

/* A ray's hit if it is closer than the one that it has. */
static inline void mcv_packet_take(mcv_packet *b, uint i, int any, mcv_hit hit, mcv_hit *hits) {
    if (hit.triangle == MCV_NONE ||
        !(hit.t < hits[i].t || (hit.t == hits[i].t && hit.triangle < hits[i].triangle)))
        return;
    hits[i] = hit;
    b->t[i] = any ? -1.0f : hit.t;
}

static inline __attribute__((noinline)) void
mcv_trace_straggler(__global const mcv_node *nodes, __global const mcv_leaf *leaves, mcv_packet *b,
                    mcv_straggler straggler, int any, mcv_hit *hits) {
    const mcv_ray_frame ray = mcv_packet_ray(b, straggler.ray);
    mcv_hit hit = hits[straggler.ray];
    ulong waiting[MCV_BVH_STACK];
    uint current = straggler.child, count = 0;
    while (mcv_traverse_step(nodes, leaves, &ray, any, &hit, &current, &count, waiting)) {}
    mcv_packet_take(b, straggler.ray, any, hit, hits);
}

/* A ray on its way alone. */
typedef struct mcv_traversal {
    mcv_ray_frame ray;
    mcv_hit hit;
    uint number, current, count;
    ulong waiting[MCV_BVH_STACK];
} mcv_traversal;

/*
 * Several rays take turns, a step each: while one waits for memory the others compute. A ray that
 * goes on from two places at once does not know of there what it has hit here until it has arrived.
 */
static inline __attribute__((always_inline)) void
mcv_trace_interleaved(__global const mcv_node *nodes, __global const mcv_leaf *leaves,
                      mcv_packet *b, const mcv_straggler *straggler, uint count, int any,
                      mcv_hit *hits) {
    mcv_traversal traversals[MCV_INTERLEAVED];
    uint order[MCV_INTERLEAVED]; /* the traversals that are under way first */
    uint next = 0, busy = 0;
    for (uint i = 0; i < MCV_INTERLEAVED; ++i) order[i] = i;
    for (;;) {
        for (uint i = 0; i < busy;) {
            mcv_traversal *t = traversals + order[i];
            if (mcv_traverse_step(nodes, leaves, &t->ray, any, &t->hit, &t->current, &t->count,
                                  t->waiting)) {
                mcv_prefetch_child(nodes, leaves, t->current);
                ++i;
                continue;
            }
            mcv_packet_take(b, t->number, any, t->hit, hits);
            --busy;
            const uint done = order[i];
            order[i] = order[busy];
            order[busy] = done;
        }
        for (; busy < MCV_INTERLEAVED && next < count; ++next) {
            const uint i = straggler[next].ray;
            if (b->t[i] < 0.0f) continue;
            mcv_traversal *t = traversals + order[busy++];
            t->ray = mcv_packet_ray(b, i);
            t->hit = hits[i];
            t->number = i;
            t->current = straggler[next].child;
            t->count = 0;
        }
        if (busy == 0) return;
    }
}

/* The rays of a list that the bit of a child chooses and that are not done; returns how many. Lists
 * end with seven that are not chosen. */
static inline __attribute__((always_inline)) uint
mcv_packet_choose(const mcv_packet *b, const uchar *from, const uchar *masks, uint count,
                  uint child, int any, uchar *list) {
    uint chosen = 0;
    for (uint first = 0; first < count; first += 8) {
#pragma unroll
        for (uint k = first; k < first + 8; ++k) {
            const uint i = from[k];
            list[chosen] = (uchar)i;
            chosen += masks[k] >> child & (any ? b->t[i] >= 0.0f : 1);
        }
    }
    vstore8((uchar8)(0), 0, list + chosen);
    return chosen;
}

/* A child that waits for its turn. */
typedef struct mcv_packet_child {
    uint child, level, lane; /* its node's level, and which of its children it is */
} mcv_packet_child;

/*
 * The hits of at most MCV_PACKET rays, all of finite origin. Each level of nodes has the list of
 * the rays that have come to its node, and for each ray the children whose boxes it meets: a
 * child's own list is made when its turn has come. The nearest is first, as the ray sees it that
 * enters it first; closest hits are looked for by the rays of each octant of directions by
 * themselves, for which that is much the same order.
 */
static inline __attribute__((always_inline)) void
mcv_trace_packet(__global const mcv_node *nodes, __global const mcv_leaf *leaves, mcv_rows origins,
                 mcv_rows directions, const uint *numbers, uint count, int any, int turns,
                 mcv_hits all) {
    mcv_packet b;
    mcv_hit hits[MCV_PACKET];
    uchar lists[MCV_BVH_LEVELS + 2][MCV_PACKET + 8], masks[MCV_BVH_LEVELS + 1][MCV_PACKET + 8];
    uint counts[MCV_BVH_LEVELS + 1];
    mcv_packet_child waiting[MCV_BVH_STACK + MCV_BVH_WIDTH];
    mcv_straggler straggler[MCV_STRAGGLERS];
    uint depth = 0, lonely = 0, roots = 0;
    for (uint i = 0; i < count; ++i) hits[i] = mcv_hit_of(all, numbers[i]);
    mcv_packet_setup(origins, directions, numbers, count, nodes->extent, hits, &b);
    for (uint i = 0; i < count; ++i) {
        uint octant = 0;
#pragma unroll
        for (int axis = 0; axis < 3 && !any; ++axis)
            octant = octant << 1 | as_uint(b.inverse[axis][i]) >> 31;
        lists[0][i] = (uchar)i;
        masks[0][i] = (uchar)(1u << octant);
        roots |= 1u << octant;
    }
    vstore8((uchar8)(0), 0, lists[0] + count);
    vstore8((uchar8)(0), 0, masks[0] + count);
    counts[0] = count;
    while (roots) waiting[depth++] = (mcv_packet_child){0, 0, mcv_pop_bit(&roots)};
    while (depth > 0 || lonely > 0) {
        if (turns && (depth == 0 || lonely + MCV_PACKET_FEW > MCV_STRAGGLERS)) {
            mcv_trace_interleaved(nodes, leaves, &b, straggler, lonely, any, hits);
            lonely = 0;
            continue;
        }
        const mcv_packet_child next = waiting[--depth];
        const uint level = next.level + 1;
        uchar *list = lists[level];
        const uint listed = mcv_packet_choose(&b, lists[next.level], masks[next.level],
                                              counts[next.level], next.lane, any, list);
        if (listed <= MCV_PACKET_FEW) {
            for (uint k = 0; k < listed; ++k) {
                const mcv_straggler alone = {list[k], next.child};
                if (turns)
                    straggler[lonely++] = alone;
                else
                    mcv_trace_straggler(nodes, leaves, &b, alone, any, hits);
            }
            continue;
        }
        if (next.child & MCV_CHILD_LEAF) {
            mcv_packet_leaf(leaves + (next.child & ~MCV_CHILD_LEAF), &b, list, listed, any, hits);
            continue;
        }
        __global const mcv_node *node = nodes + next.child;
        float8 least = (float8)(INFINITY);
        float begin[MCV_BVH_WIDTH];
        uint met = 0;
        for (uint k = 0; k < listed; ++k) {
            float8 entry;
            const uint mask = mcv_packet_boxes(node, &b, list[k], &entry);
            least = min(least, entry);
            masks[level][k] = (uchar)mask;
            met |= mask;
        }
        vstore8((uchar8)(0), 0, masks[level] + listed);
        vstore8(least, 0, begin);
        counts[level] = listed;
        const uint bottom = depth;
        while (met) {
            const uint lane = mcv_pop_bit(&met);
            mcv_prefetch_child(nodes, leaves, node->child[lane]);
            uint place = depth++;
            for (; place > bottom && begin[waiting[place - 1].lane] < begin[lane]; --place)
                waiting[place] = waiting[place - 1];
            waiting[place] = (mcv_packet_child){node->child[lane], level, lane};
        }
    }
    for (uint i = 0; i < count; ++i) mcv_put_hit(all, numbers[i], hits[i]);
}

/* ---- any number of rays
 * ----------------------------------------------------------------------------------------- */

/*
 * The hits of the rays numbers[0 … count - 1]: the closest or, where any hit will do, one of them,
 * of which only the triangle is known. On entry they are misses (mcv_miss) or what else the rays
 * have met, which stays where nothing closer is hit.
 */
static inline __attribute__((always_inline)) void
mcv_trace_packets(__global const mcv_node *nodes, __global const mcv_leaf *leaves, mcv_rows origins,
                  mcv_rows directions, const uint *numbers, uint count, int any, int turns,
                  mcv_hits hits) {
    if (mcv_is_flat(nodes)) {
        mcv_take_flat(nodes, leaves, origins, directions, numbers, count, any, hits);
        return;
    }
    for (uint first = 0; first < count; first += MCV_PACKET)
        mcv_trace_packet(nodes, leaves, origins, directions, numbers + first,
                         min(count - first, (uint)MCV_PACKET), any, turns, hits);
}

/* A function for each way: the rays that are left alone go at once, or in turns. */
#define MCV_TRACE_POLICY(name, any, turns) \
    static inline __attribute__((noinline)) void name( \
        __global const mcv_node *nodes, __global const mcv_leaf *leaves, mcv_rows origins, \
        mcv_rows directions, const uint *numbers, uint count, mcv_hits hits) { \
        mcv_trace_packets(nodes, leaves, origins, directions, numbers, count, any, turns, hits); \
    }
MCV_TRACE_POLICY(mcv_intersect_closest_packets, 0, 0)
MCV_TRACE_POLICY(mcv_intersect_any_packets, 1, 0)
MCV_TRACE_POLICY(mcv_intersect_closest_interleaved, 0, 1)
MCV_TRACE_POLICY(mcv_intersect_any_interleaved, 1, 1)

#endif
