/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A ray against triangles.
 *
 * The vertices are moved to the ray's origin, sheared so that the ray runs along the
 * axis of its largest component, and the signs of the three edge functions decide (Woop, Benthin
 * and Wald, Watertight Ray/Triangle Intersection, JCGT 2013). Kahan's difference of products makes
 * these signs exact for the sheared vertices, which two neighbours share, so no second evaluation
 * in double is needed. An edge function that is exactly 0 is decided as if the ray were displaced
 * by (ε, ε²) in the sheared plane: a shared edge, and a shared vertex, then belong to exactly one
 * of the triangles around them. (A rule on the order of the vertices in space would do for edges,
 * but loses the vertices that come first or last among their neighbours.) Both sides of a triangle
 * are hit. Sheared coordinates below 1e-20 m would underflow in the products: nothing else is
 * assumed about the scale of the scene.
 */
#ifndef MCVISI_KERNELS_TRIANGLE_H
#define MCVISI_KERNELS_TRIANGLE_H

#include "mcvisi/accel.h"
#include "mcvisi/offset.h"
#include "traverse/lanes.h"
#include "traverse/ray_frame.h"

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
    MCV_LOOP_FUNCTION uint NAME(const FLOAT *x, const FLOAT *y, const FLOAT *z, FLOAT shear_x, \
                                FLOAT shear_y, FLOAT scale_z, FLOAT t_max, INT *met, FLOAT *t_met, \
                                FLOAT *b_met, FLOAT *c_met, FLOAT *det_met) { \
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
MCV_INTERSECT_SHEARED(mcv_intersect_lanes, mcv_edge_function_lanes, mcv_edge_rises_lanes,
                      mcv_floats, mcv_ints, mcv_mask_lanes)

/*
 * Tests the four triangles of a leaf against a ray. A hit with 0 < t < hit->t replaces *hit; so
 * does one with the same t and a lower number. Returns whether there was one. With `after`, only
 * what comes after that hit in this order counts.
 */
MCV_LOOP_FUNCTION int mcv_intersect_leaf_after(__global const mcv_leaf *leaf,
                                               const mcv_ray_frame *ray, const mcv_hit *after,
                                               mcv_hit *hit) {
    const mcv_shear *shear = &ray->shear;
    float4 x[3], y[3], z[3];
#pragma unroll
    for (int corner = 0; corner < 3; ++corner) {
        __global const float *rows = (__global const float *)leaf->vertex[corner];
        z[corner] = *(__global const float4 *)(rows + ray->row[2]) - (float4)(shear->origin[2]);
        x[corner] =
            fma((float4)(-shear->slope[0]), z[corner],
                *(__global const float4 *)(rows + ray->row[0]) - (float4)(shear->origin[0]));
        y[corner] =
            fma((float4)(-shear->slope[1]), z[corner],
                *(__global const float4 *)(rows + ray->row[1]) - (float4)(shear->origin[1]));
    }
    float4 t, b, c, det;
    int4 met;
    uint mask =
        mcv_intersect_sheared4(x, y, z, (float4)(shear->slope[0]), (float4)(shear->slope[1]),
                               (float4)(shear->scale), (float4)(hit->t), &met, &t, &b, &c, &det);
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
            !(lane_t[lane] > after->t || (lane_t[lane] == after->t && triangle > after->primitive)))
            continue;
        /* A miss so far (MCV_NONE) has t_max, which is not a hit itself. */
        if (lane_t[lane] < hit->t ||
            (lane_t[lane] == hit->t && hit->primitive != MCV_NONE && triangle < hit->primitive)) {
            hit->t = lane_t[lane];
            hit->u = lane_b[lane] / lane_det[lane];
            hit->v = lane_c[lane] / lane_det[lane];
            hit->primitive = triangle;
            found = 1;
        }
    } while (mask);
    return found;
}

MCV_LOOP_FUNCTION int mcv_intersect_leaf(__global const mcv_leaf *leaf, const mcv_ray_frame *ray,
                                         mcv_hit *hit) {
    return mcv_intersect_leaf_after(leaf, ray, 0, hit);
}

#endif
