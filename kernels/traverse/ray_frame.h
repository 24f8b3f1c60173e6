/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What all tests of a ray share, for one ray and for rays side by side: its slabs, against boxes,
 * and its shear, against triangles (traverse/triangle.h).
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
#ifndef MCVISI_KERNELS_RAY_FRAME_H
#define MCVISI_KERNELS_RAY_FRAME_H

#include "mcvisi/accel.h"
#include "mcvisi/offset.h"
#include "traverse/lanes.h"

/*
 * SLABS: t = bound * inverse + offset, the offsets with the margin of 32 u R. The margin must not
 * turn a slab into inf - inf, so directions along an axis plane get a component of 2^-64 of the
 * largest: over the length R it moves a point by far less than the margin.
 *
 * SHEAR: the ray's main axis is z, y or x; a triangle's coordinates along the axes (x, y, z),
 * (z, x, y) or (y, z, x) are sheared by the slopes x / z and y / z of the direction.
 */
#define MCV_RAY_SETUP(NAME, SLABS, SHEAR, FLOAT, INT) \
    typedef struct SLABS { \
        FLOAT inverse[3], near_offset[3], far_offset[3]; \
    } SLABS; \
    typedef struct SHEAR { \
        INT main_z, main_y;               /* whether that is the main axis; else it is x */ \
        FLOAT origin[3], slope[2], scale; /* scale: 1 / z */ \
    } SHEAR; \
    MCV_LOOP_FUNCTION void NAME(const FLOAT *o, const FLOAT *d, float extent, SLABS *slabs, \
                                SHEAR *shear) { \
        const FLOAT x = fabs(d[0]), y = fabs(d[1]), z = fabs(d[2]); \
        const FLOAT a = fabs(o[0]), b = fabs(o[1]), c = fabs(o[2]); \
        const FLOAT larger = x > y ? x : y, farther = a > b ? a : b; \
        const FLOAT least = (larger > z ? larger : z) * 0x1p-64f; \
        const FLOAT margin = 32.0f * MCV_UNIT_ROUNDOFF * ((farther > c ? farther : c) + extent); \
        _Pragma("unroll") for (int axis = 0; axis < 3; ++axis) { \
            const FLOAT flat = d[axis] < 0.0f ? -least : least; \
            const FLOAT inverse = 1.0f / (fabs(d[axis]) < least ? flat : d[axis]); \
            const FLOAT spread = margin * fabs(inverse); \
            slabs->inverse[axis] = inverse; \
            slabs->near_offset[axis] = -o[axis] * inverse - spread; \
            slabs->far_offset[axis] = -o[axis] * inverse + spread; \
        } \
        const INT over_x = z >= x, over_y = z >= y; \
        shear->main_z = over_x & over_y; \
        shear->main_y = y >= x; \
        const FLOAT along = MCV_MAIN(shear, d[2], d[1], d[0]); \
        shear->origin[0] = MCV_MAIN(shear, o[0], o[2], o[1]); \
        shear->origin[1] = MCV_MAIN(shear, o[1], o[0], o[2]); \
        shear->origin[2] = MCV_MAIN(shear, o[2], o[1], o[0]); \
        shear->slope[0] = MCV_MAIN(shear, d[0], d[2], d[1]) / along; \
        shear->slope[1] = MCV_MAIN(shear, d[1], d[0], d[2]) / along; \
        shear->scale = 1.0f / along; \
    }
#define MCV_MAIN(shear, if_z, if_y, if_x) \
    ((shear)->main_z ? (if_z) : (shear)->main_y ? (if_y) : (if_x))

MCV_RAY_SETUP(mcv_setup_ray, mcv_slabs, mcv_shear, float, int)
MCV_RAY_SETUP(mcv_setup_lanes, mcv_lane_slabs, mcv_lane_shear, mcv_floats, mcv_ints)

typedef struct mcv_ray_frame {
    mcv_slabs slabs;
    mcv_shear shear;
    uint row[3]; /* times 4: the axes that are x, y and z to the shear */
} mcv_ray_frame;

/* main_axis: 0, 1 or 2. */
static inline void mcv_set_rows(uint main_axis, mcv_ray_frame *ray) {
    ray->row[0] = main_axis == 2u ? 0u : 4u * (main_axis + 1u);
    ray->row[1] = main_axis == 0u ? 8u : 4u * (main_axis - 1u);
    ray->row[2] = 4u * main_axis;
}

static inline mcv_ray_frame mcv_ray_setup(mcv_vec3 origin, mcv_vec3 direction, float extent) {
    mcv_ray_frame ray;
    const float o[3] = {origin.x, origin.y, origin.z},
                d[3] = {direction.x, direction.y, direction.z};
    mcv_setup_ray(o, d, extent, &ray.slabs, &ray.shear);
    mcv_set_rows(MCV_MAIN(&ray.shear, 2u, 1u, 0u), &ray);
    return ray;
}

/* The children whose boxes the ray is in at some t_min <= t <= t_max, one bit each and as lanes,
 * and from where on. */
MCV_LOOP_FUNCTION uint mcv_intersect_boxes_between(__global const mcv_node *node,
                                                   const mcv_slabs *slabs, float t_min, float t_max,
                                                   float8 *entry, int8 *entered) {
    float8 near = (float8)(t_min), far = (float8)(t_max);
#pragma unroll
    for (int axis = 0; axis < 3; ++axis) {
        const float8 inverse = (float8)(slabs->inverse[axis]);
        const uint upper = as_uint(slabs->inverse[axis]) >> 31; /* which bound is nearer */
        const float8 first = *(__global const float8 *)node->bounds[axis][upper];
        const float8 second = *(__global const float8 *)node->bounds[axis][1u - upper];
        near = max(near, fma(first, inverse, (float8)(slabs->near_offset[axis])));
        far = min(far, fma(second, inverse, (float8)(slabs->far_offset[axis])));
    }
    *entry = near;
    *entered = near <= far;
    return mcv_mask8(*entered);
}

/* The same from the ray's origin on. */
MCV_LOOP_FUNCTION uint mcv_intersect_boxes_lanes(__global const mcv_node *node,
                                                 const mcv_slabs *slabs, float t_max, float8 *entry,
                                                 int8 *entered) {
    return mcv_intersect_boxes_between(node, slabs, 0.0f, t_max, entry, entered);
}

/* The same without the lanes. */
MCV_LOOP_FUNCTION uint mcv_intersect_boxes(__global const mcv_node *node, const mcv_slabs *slabs,
                                           float t_max, float8 *entry) {
    int8 entered;
    return mcv_intersect_boxes_lanes(node, slabs, t_max, entry, &entered);
}

/* Whether a ray enters one box before it ends, without conditional jumps. */
MCV_LOOP_FUNCTION int mcv_enters_box(const float *low, const float *high, float extent,
                                     mcv_vec3 origin, mcv_vec3 direction, float end) {
    const float o[3] = {origin.x, origin.y, origin.z},
                d[3] = {direction.x, direction.y, direction.z};
    float near = 0.0f, far = end;
    mcv_slabs slabs;
    mcv_shear shear;
    mcv_setup_ray(o, d, extent, &slabs, &shear);
#pragma unroll
    for (int axis = 0; axis < 3; ++axis) {
        const int falls = slabs.inverse[axis] < 0.0f;
        const float first = mcv_fma(falls ? high[axis] : low[axis], slabs.inverse[axis],
                                    slabs.near_offset[axis]),
                    second = mcv_fma(falls ? low[axis] : high[axis], slabs.inverse[axis],
                                     slabs.far_offset[axis]);
        near = first > near ? first : near;
        far = second < far ? second : far;
    }
    return (low[0] <= high[0]) & (near <= far);
}

#endif
