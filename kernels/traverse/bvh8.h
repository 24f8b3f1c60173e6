/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A ray against the triangles of a scene: through the hierarchy of mcvisi/accel.h, and one leaf by
 * itself.
 *
 * Triangles. The vertices are moved to the ray's origin, sheared so that the ray runs along the
 * axis of its largest component, and the signs of the three edge functions decide (Woop, Benthin
 * and Wald, Watertight Ray/Triangle Intersection, JCGT 2013). Kahan's difference of products makes
 * these signs exact for the sheared vertices, which two neighbours share, so no second evaluation
 * in double is needed. An edge function that is exactly 0 is decided as if the ray were displaced
 * by (ε, ε²) in the sheared plane: a shared edge, and a shared vertex, then belong to exactly one
 * of the triangles around them. (A rule on the order of the vertices in space would do for edges,
 * but loses the vertices that come first or last among their neighbours.) Both sides of a triangle
 * are hit. Sheared coordinates below 1e-20 m would underflow in the products: nothing else is
 * assumed about the scale of the scene.
 *
 * Boxes. With u = 2^-24 and R = |origin| + extent (maximum norms), the sheared vertices are off by
 * at most 5 u R each: u R from V - o, 2 u R from the product with the shear, 2 u R from the last
 * rounding. The edge functions' relative error of 2 u moves the point on the triangle by 4 u times
 * its diameter, at most 8 u R; the distance along the ray's main axis rounds by 6 u R. The computed
 * hit so lies within 19 u R of the triangle per coordinate, and the slabs themselves round by 6 u
 * R. Boxes that are widened by 32 u R therefore contain, at the computed t, every hit the triangle
 * test can report: traversal and a loop over all triangles find the same hit, to the last bit,
 * always. The same holds where several leaves share a triangle: the point of the triangle that the
 * hit is near to lies in the box of one of them.
 */
#ifndef MCVISI_TRAVERSE_H
#define MCVISI_TRAVERSE_H

#include "mcvisi/accel.h"
#include "mcvisi/offset.h"

/* Without AVX clang warns that float8 arguments have no stable ABI; all of these calls are inlined.
 */
#ifdef __clang__
#pragma clang diagnostic ignored "-Wpsabi"
#endif

/* clang knows the mask builtins on any x86, but can only emit them with AVX. */
#if defined(__AVX__) && defined(__has_builtin)
#if __has_builtin(__builtin_ia32_movmskps256) && __has_builtin(__builtin_ia32_movmskps)
#define MCV_AVX_BUILTINS 1
#endif
#endif

/* One bit per lane with a negative (true) value. */
static inline uint mcv_mask8(int8 lanes) {
#ifdef MCV_AVX_BUILTINS
    return (uint)__builtin_ia32_movmskps256(as_float8(lanes));
#else
    const int8 bits = lanes & (int8)(1, 2, 4, 8, 16, 32, 64, 128);
    const int4 four = bits.lo | bits.hi;
    const int2 two = four.lo | four.hi;
    return (uint)(two.x | two.y);
#endif
}

#ifdef __AVX512F__
static inline uint mcv_mask16(int16 lanes) {
#if defined(MCV_AVX_BUILTINS) && defined(__AVX512DQ__)
    return (uint)__builtin_ia32_cvtd2mask512(lanes) & 0xffffu;
#else
    return mcv_mask8(lanes.lo) | mcv_mask8(lanes.hi) << 8;
#endif
}
#endif

static inline uint mcv_mask4(int4 lanes) {
#ifdef MCV_AVX_BUILTINS
    return (uint)__builtin_ia32_movmskps(as_float4(lanes));
#else
    const int4 bits = lanes & (int4)(1, 2, 4, 8);
    const int2 two = bits.lo | bits.hi;
    return (uint)(two.x | two.y);
#endif
}

/* Takes the highest bit out of a mask and returns its number. */
static inline uint mcv_pop_bit(uint *mask) {
    const uint bit = 31u - clz(*mask);
    *mask ^= 1u << bit;
    return bit;
}

/* A ray for the tests of triangles: x, y, z are the rows (times 4) of the axes such that z is the
 * ray's main axis. */
typedef struct mcv_shear {
    uint row_x, row_y, row_z;
    float origin_x, origin_y, origin_z;
    float shear_x, shear_y, scale_z; /* direction x / z, y / z, 1 / z */
} mcv_shear;

/* What all tests of one ray share. */
typedef struct mcv_ray_frame {
    /* Slabs: t = bound * inverse + offset, the offsets with the margin of 32 u R. */
    float inverse[3], near_offset[3], far_offset[3];
    uint near_row[3]; /* 0: the lower bound is met first, 1: the upper */
    mcv_shear shear;
} mcv_ray_frame;

/*
 * The margin must not turn a slab into inf - inf, so directions along an axis plane get a component
 * of 2^-64 of the largest: over the length R it moves a point by far less than the margin.
 */
static inline mcv_ray_frame mcv_ray_setup(mcv_vec3 origin, mcv_vec3 direction, float extent) {
    mcv_ray_frame ray;
    const float o[3] = {origin.x, origin.y, origin.z};
    const float d[3] = {direction.x, direction.y, direction.z};
    const float dx = fabs(d[0]), dy = fabs(d[1]), dz = fabs(d[2]);
    const float largest = max(dx, max(dy, dz));
    const float reach = max(fabs(o[0]), max(fabs(o[1]), fabs(o[2]))) + extent;
    const float margin = 32.0f * MCV_UNIT_ROUNDOFF * reach;
    const float least = largest * 0x1p-64f;
    for (int axis = 0; axis < 3; ++axis) {
        const float inverse = 1.0f / (fabs(d[axis]) < least ? copysign(least, d[axis]) : d[axis]);
        const float spread = margin * fabs(inverse);
        ray.inverse[axis] = inverse;
        ray.near_offset[axis] = -o[axis] * inverse - spread;
        ray.far_offset[axis] = -o[axis] * inverse + spread;
        ray.near_row[axis] = inverse < 0.0f ? 1u : 0u;
    }
    const int main_z = dz >= dx && dz >= dy;
    const int main_y = !main_z && dy >= dx;
    ray.shear.row_x = main_z ? 0u : main_y ? 8u : 4u;
    ray.shear.row_y = main_z ? 4u : main_y ? 0u : 8u;
    ray.shear.row_z = main_z ? 8u : main_y ? 4u : 0u;
    ray.shear.origin_x = main_z ? o[0] : main_y ? o[2] : o[1];
    ray.shear.origin_y = main_z ? o[1] : main_y ? o[0] : o[2];
    ray.shear.origin_z = main_z ? o[2] : main_y ? o[1] : o[0];
    const float along = main_z ? d[2] : main_y ? d[1] : d[0];
    ray.shear.shear_x = (main_z ? d[0] : main_y ? d[2] : d[1]) / along;
    ray.shear.shear_y = (main_z ? d[1] : main_y ? d[0] : d[2]) / along;
    ray.shear.scale_z = 1.0f / along;
    return ray;
}

static inline mcv_hit mcv_miss(float t_max) {
    mcv_hit hit;
    hit.t = t_max;
    hit.u = hit.v = 0.0f;
    hit.triangle = MCV_NONE;
    return hit;
}

/* The children whose boxes the ray meets at 0 <= t <= t_max, one bit each, and where it enters
 * them. */
static inline uint mcv_intersect_boxes(__global const mcv_node *node, const mcv_ray_frame *ray,
                                       float t_max, float8 *entry) {
    float8 near = (float8)(0.0f), far = (float8)(t_max);
#pragma unroll
    for (int axis = 0; axis < 3; ++axis) {
        const float8 first = *(__global const float8 *)node->bounds[axis][ray->near_row[axis]];
        const float8 second =
            *(__global const float8 *)node->bounds[axis][1u - ray->near_row[axis]];
        near =
            max(near, fma(first, (float8)(ray->inverse[axis]), (float8)(ray->near_offset[axis])));
        far = min(far, fma(second, (float8)(ray->inverse[axis]), (float8)(ray->far_offset[axis])));
    }
    *entry = near;
    return mcv_mask8(near <= far);
}

/*
 * Which lanes of sheared triangles, x, y and z of three corners each, are hit with 0 < t <= t_max
 * (one bit each; 0: the rest is unknown), where, and the weights b/det and c/det of the corners 1
 * and 2. RISES is the sign of a zero edge function of P to Q for a ray displaced by (ε, ε²): true
 * is positive. The lanes are triangles of one ray, or rays of one triangle: the same arithmetic, so
 * the same bits.
 *
 * t > 0 is certain if the triangle lies ahead of the origin as a whole: t is then a mean of
 * positive numbers. Otherwise t must exceed its error bound (the idea of Physically Based
 * Rendering, the bound for this code). X, Y, Z are the largest |coordinates| of the sheared
 * vertices, z being the unscaled depth with range r over the vertices, s the shear. A sheared x
 * rounds by δx = γ(3) (X + |s| Z), and the edge functions are those of the rounded vertices: the
 * computed depth is that of the triangle's plane not on the ray but at most (δx, δy) beside it, so
 * off by |∂z/∂x| δx + |∂z/∂y| δy. The plane's slope is (n_x, n_y) / det from the computed vertices,
 * whose differences are off by 2 δ: n_x by 4 r δy, and with its rounding by less than 10 r δy. det,
 * three edge functions, is off by 3 (2 (X δy + Y δx) + 4 u X Y); where that exceeds |det|, the
 * triangle is seen edge-on and nothing is known. The rest rounds by 12 u Z: 7 for the mean and 4
 * for the edge functions as weights.
 */
#define MCV_INTERSECT_SHEARED(NAME, EDGE, RISES, FLOAT, INT, MASK) \
    static inline FLOAT EDGE(FLOAT px, FLOAT py, FLOAT qx, FLOAT qy) { \
        const FLOAT product = py * qx; \
        return fma(px, qy, -product) + fma(-py, qx, product); \
    } \
    static inline INT RISES(FLOAT px, FLOAT py, FLOAT qx, FLOAT qy) { \
        return (py > qy) | ((py == qy) & (px < qx)); \
    } \
    static inline __attribute__((always_inline)) uint NAME( \
        const FLOAT *x, const FLOAT *y, const FLOAT *z, FLOAT shear_x, FLOAT shear_y, \
        FLOAT scale_z, FLOAT t_max, INT *met, FLOAT *t_met, FLOAT *b_met, FLOAT *c_met, \
        FLOAT *det_met) { \
        const FLOAT a = EDGE(x[2], y[2], x[1], y[1]); \
        const FLOAT b = EDGE(x[0], y[0], x[2], y[2]); \
        const FLOAT c = EDGE(x[1], y[1], x[0], y[0]); \
        /* min and max may lose a NaN; det and t keep it, and t > 0 is then false. */ \
        INT inside = (min(a, min(b, c)) >= 0.0f) | (max(a, max(b, c)) <= 0.0f); \
        if (!MASK(inside)) return 0; \
        if (MASK(inside & ((a == 0.0f) | (b == 0.0f) | (c == 0.0f)))) { \
            const INT left = ((a > 0.0f) | ((a == 0.0f) & RISES(x[2], y[2], x[1], y[1]))) & \
                             ((b > 0.0f) | ((b == 0.0f) & RISES(x[0], y[0], x[2], y[2]))) & \
                             ((c > 0.0f) | ((c == 0.0f) & RISES(x[1], y[1], x[0], y[0]))); \
            const INT right = ((a < 0.0f) | ((a == 0.0f) & RISES(x[1], y[1], x[2], y[2]))) & \
                              ((b < 0.0f) | ((b == 0.0f) & RISES(x[2], y[2], x[0], y[0]))) & \
                              ((c < 0.0f) | ((c == 0.0f) & RISES(x[0], y[0], x[1], y[1]))); \
            inside = left | right; \
        } \
        const FLOAT det = a + b + c; \
        const FLOAT depth = fma(a, z[0], fma(b, z[1], c * z[2])) / det; \
        const FLOAT t = depth * scale_z; \
        inside &= (det != 0.0f) & (t > 0.0f) & (t <= t_max); \
        const FLOAT sign = scale_z < 0.0f ? (FLOAT)(-1.0f) : (FLOAT)(1.0f); \
        const FLOAT front = min(z[0] * sign, min(z[1] * sign, z[2] * sign)); \
        uint mask = MASK(inside); \
        if (!mask) return 0; \
        if (MASK(inside & (front <= 0.0f))) { \
            const FLOAT back = max(z[0] * sign, max(z[1] * sign, z[2] * sign)); \
            const FLOAT big_x = max(fabs(x[0]), max(fabs(x[1]), fabs(x[2]))); \
            const FLOAT big_y = max(fabs(y[0]), max(fabs(y[1]), fabs(y[2]))); \
            const FLOAT big_z = max(fabs(front), fabs(back)); \
            const FLOAT error_x = MCV_GAMMA(3) * (big_x + fabs(shear_x) * big_z); \
            const FLOAT error_y = MCV_GAMMA(3) * (big_y + fabs(shear_y) * big_z); \
            const FLOAT error_det = 3.0f * (2.0f * (big_x * error_y + big_y * error_x) + \
                                            4.0f * MCV_UNIT_ROUNDOFF * big_x * big_y); \
            const FLOAT sure_det = fabs(det) - error_det; \
            const FLOAT range = back - front; \
            const FLOAT x1 = x[1] - x[0], y1 = y[1] - y[0], z1 = z[1] - z[0], x2 = x[2] - x[0], \
                        y2 = y[2] - y[0], z2 = z[2] - z[0]; \
            const FLOAT slope_x = fabs(y1 * z2 - z1 * y2) + 10.0f * range * error_y; \
            const FLOAT slope_y = fabs(z1 * x2 - x1 * z2) + 10.0f * range * error_x; \
            const FLOAT error_depth = (slope_x * error_x + slope_y * error_y) / sure_det + \
                                      12.0f * MCV_UNIT_ROUNDOFF * big_z; \
            inside &= (front > 0.0f) | ((sure_det > 0.0f) & (depth * sign > error_depth)); \
            mask = MASK(inside); \
            if (!mask) return 0; \
        } \
        *met = inside; \
        *t_met = t; \
        *b_met = b; \
        *c_met = c; \
        *det_met = det; \
        return mask; \
    }

MCV_INTERSECT_SHEARED(mcv_intersect_sheared4, mcv_edge_function4, mcv_edge_rises4, float4, int4,
                      mcv_mask4)
MCV_INTERSECT_SHEARED(mcv_intersect_sheared8, mcv_edge_function8, mcv_edge_rises8, float8, int8,
                      mcv_mask8)

/*
 * Tests the four triangles of a leaf against a ray. A hit with 0 < t < hit->t replaces *hit; so
 * does one with the same t and a lower number. Returns whether there was one. With `after`, only
 * what comes after that hit in this order counts.
 */
static inline __attribute__((always_inline)) int
mcv_intersect_leaf_after(__global const mcv_leaf *leaf, const mcv_shear *ray, const mcv_hit *after,
                         mcv_hit *hit) {
    float4 x[3], y[3], z[3];
#pragma unroll
    for (int corner = 0; corner < 3; ++corner) {
        __global const float *rows = (__global const float *)leaf->vertex[corner];
        z[corner] = *(__global const float4 *)(rows + ray->row_z) - (float4)(ray->origin_z);
        x[corner] = fma((float4)(-ray->shear_x), z[corner],
                        *(__global const float4 *)(rows + ray->row_x) - (float4)(ray->origin_x));
        y[corner] = fma((float4)(-ray->shear_y), z[corner],
                        *(__global const float4 *)(rows + ray->row_y) - (float4)(ray->origin_y));
    }
    float4 t, b, c, det;
    int4 met;
    uint mask =
        mcv_intersect_sheared4(x, y, z, (float4)(ray->shear_x), (float4)(ray->shear_y),
                               (float4)(ray->scale_z), (float4)(hit->t), &met, &t, &b, &c, &det);
    if (!mask) return 0;

    float lane_t[4], lane_b[4], lane_c[4], lane_det[4];
    vstore4(t, 0, lane_t);
    vstore4(b, 0, lane_b);
    vstore4(c, 0, lane_c);
    vstore4(det, 0, lane_det);
    int found = 0;
    do {
        const uint lane = mcv_pop_bit(&mask);
        const uint triangle = leaf->triangle[lane];
        if (after &&
            !(lane_t[lane] > after->t || (lane_t[lane] == after->t && triangle > after->triangle)))
            continue;
        /* A miss so far (MCV_NONE) has t_max, which is not a hit itself. */
        if (lane_t[lane] < hit->t ||
            (lane_t[lane] == hit->t && hit->triangle != MCV_NONE && triangle < hit->triangle)) {
            hit->t = lane_t[lane];
            hit->u = lane_b[lane] / lane_det[lane];
            hit->v = lane_c[lane] / lane_det[lane];
            hit->triangle = triangle;
            found = 1;
        }
    } while (mask);
    return found;
}

static inline __attribute__((always_inline)) int
mcv_intersect_leaf(__global const mcv_leaf *leaf, const mcv_shear *ray, mcv_hit *hit) {
    return mcv_intersect_leaf_after(leaf, ray, 0, hit);
}

/* Begins to fetch a child that waits: by its turn it has come. Only where all memory is the host's;
 * clang has no global form. */
static inline void mcv_prefetch_child(__global const mcv_node *nodes,
                                      __global const mcv_leaf *leaves, uint child) {
#ifdef MCV_AVX_BUILTINS
    const int is_leaf = (child & MCV_CHILD_LEAF) != 0;
    const char *line = (const char *)(is_leaf ? (size_t)(leaves + (child & ~MCV_CHILD_LEAF))
                                              : (size_t)(nodes + child));
    __builtin_prefetch(line);
    __builtin_prefetch(line + 64);
    __builtin_prefetch(line + 128);
    if (!is_leaf) __builtin_prefetch(line + 192);
#else
    (void)nodes, (void)leaves, (void)child;
#endif
}

/* A child that waits its turn: where the ray enters its box (not below 0, so that its bits order as
 * it does), and its number. */
static inline ulong mcv_wait(float entry, uint child) {
    return (ulong)as_uint(entry) << 32 | child;
}
static inline float mcv_waiting_entry(ulong waiting) { return as_float((uint)(waiting >> 32)); }

/*
 * One step of a traversal: tests the node or leaf *current, which is then the next one: the nearest
 * first or, where any hit will do, in the order of the lanes. 0 at the end: there is none that
 * could hold a closer hit, or something is hit and any hit will do.
 */
static inline __attribute__((always_inline)) int
mcv_traverse_step(__global const mcv_node *nodes, __global const mcv_leaf *leaves,
                  const mcv_ray_frame *ray, int any, mcv_hit *hit, uint *current, uint *count,
                  ulong *waiting) {
    if (*current & MCV_CHILD_LEAF) {
        if (mcv_intersect_leaf(leaves + (*current & ~MCV_CHILD_LEAF), &ray->shear, hit) && any)
            return 0;
    } else {
        __global const mcv_node *node = nodes + *current;
        float8 entry;
        uint mask = mcv_intersect_boxes(node, ray, hit->t, &entry);
        if (any) {
            while (mask) {
                const uint child = node->child[mcv_pop_bit(&mask)];
                mcv_prefetch_child(nodes, leaves, child);
                waiting[(*count)++] = child;
            }
        } else if (mask) {
            uint lane = mcv_pop_bit(&mask);
            if (!mask) {
                *current = node->child[lane];
                return 1;
            }
            float t[8];
            vstore8(entry, 0, t);
            ulong nearest = mcv_wait(t[lane], node->child[lane]);
            mcv_prefetch_child(nodes, leaves, (uint)nearest);
            /* The nearest goes on; the others wait with the nearer on top. */
            const uint bottom = *count;
            do {
                lane = mcv_pop_bit(&mask);
                ulong other = mcv_wait(t[lane], node->child[lane]);
                mcv_prefetch_child(nodes, leaves, (uint)other);
                const ulong least = min(nearest, other);
                other = max(nearest, other);
                nearest = least;
                uint place = (*count)++;
                for (; place > bottom && waiting[place - 1] < other; --place)
                    waiting[place] = waiting[place - 1];
                waiting[place] = other;
            } while (mask);
            *current = (uint)nearest;
            return 1;
        }
    }
    ulong next;
    do {
        if (*count == 0) return 0;
        next = waiting[--*count];
    } while (mcv_waiting_entry(next) > hit->t);
    *current = (uint)next;
    return 1;
}

/*
 * The closest hit with 0 < t < t_max; on equal t the triangle with the lowest number. The direction
 * need not be unit; t counts in its length. A zero or non-finite direction hits nothing.
 */
static inline __attribute__((noinline)) mcv_hit
mcv_intersect_closest_ray(__global const mcv_node *nodes, __global const mcv_leaf *leaves,
                          mcv_vec3 origin, mcv_vec3 direction, float t_max) {
    mcv_hit hit = mcv_miss(t_max);
    const mcv_ray_frame ray = mcv_ray_setup(origin, direction, nodes->extent);
    ulong waiting[MCV_BVH_STACK];
    uint current = 0, count = 0;
    while (mcv_traverse_step(nodes, leaves, &ray, 0, &hit, &current, &count, waiting)) {}
    return hit;
}

/* Whether anything is hit with 0 < t < t_max. */
static inline __attribute__((noinline)) int mcv_intersect_any_ray(__global const mcv_node *nodes,
                                                                  __global const mcv_leaf *leaves,
                                                                  mcv_vec3 origin,
                                                                  mcv_vec3 direction, float t_max) {
    mcv_hit hit = mcv_miss(t_max);
    const mcv_ray_frame ray = mcv_ray_setup(origin, direction, nodes->extent);
    ulong waiting[MCV_BVH_STACK];
    uint current = 0, count = 0;
    while (mcv_traverse_step(nodes, leaves, &ray, 1, &hit, &current, &count, waiting)) {}
    return hit.triangle != MCV_NONE;
}

#if MCV_WITH_CONTACT
/* The next hit after another one, up to t_max. */
static __attribute__((noinline, unused)) mcv_hit
mcv_next_hit_ray(__global const mcv_node *nodes, __global const mcv_leaf *leaves, mcv_vec3 origin,
                 mcv_vec3 direction, mcv_hit after, float t_max) {
    mcv_hit hit = mcv_miss(t_max);
    const mcv_ray_frame ray = mcv_ray_setup(origin, direction, nodes->extent);
    uint waiting[MCV_BVH_STACK];
    uint count = 1;
    waiting[0] = 0;
    while (count > 0) {
        const uint current = waiting[--count];
        if (current & MCV_CHILD_LEAF) {
            mcv_intersect_leaf_after(leaves + (current & ~MCV_CHILD_LEAF), &ray.shear, &after,
                                     &hit);
            continue;
        }
        float8 entry;
        uint mask = mcv_intersect_boxes(nodes + current, &ray, hit.t, &entry);
        while (mask) waiting[count++] = nodes[current].child[mcv_pop_bit(&mask)];
    }
    return hit;
}
#endif

/* ---- many rays
 * --------------------------------------------------------------------------------------------------
 */

/* Vectors in memory, of bits: component k of number i is base[i * step + k * component]. */
#ifndef MCV_ROWS_SPACE
#define MCV_ROWS_SPACE __global
#endif
typedef struct mcv_rows {
    MCV_ROWS_SPACE const uint *base;
    uint step, component;
} mcv_rows;

static inline mcv_vec3 mcv_row(mcv_rows rows, uint i) {
    MCV_ROWS_SPACE const uint *v = rows.base + (size_t)i * rows.step;
    return mcv_vec(as_float(v[0]), as_float(v[rows.component]), as_float(v[2u * rows.component]));
}

#endif
