/* SPDX-License-Identifier: Apache-2.0 */
/* A packet of rays: what the tests need of each, and what each has hit so far. */
#ifndef MCVISI_KERNELS_PACKET_H
#define MCVISI_KERNELS_PACKET_H

#include "traverse/bvh8.h"
#include "traverse/lane_rays.h"

#define MCV_PACKET 256                   /* numbers in a list are bytes */
#define MCV_PACKET_ROW (MCV_PACKET + 16) /* as of MCV_ROW */

/* Rays side by side, as in mcv_slabs and mcv_shear. */
typedef struct mcv_packet {
    float inverse[3][MCV_PACKET_ROW], near_offset[3][MCV_PACKET_ROW], far_offset[3][MCV_PACKET_ROW];
    float origin[3][MCV_PACKET_ROW], slope[2][MCV_PACKET_ROW], scale[MCV_PACKET_ROW];
    uint main_axis[MCV_PACKET_ROW];
    float t[MCV_PACKET_ROW]; /* hits are looked for up to here; negative: the ray is done */
    mcv_hit hits[MCV_PACKET];
} mcv_packet;

/* Not inlined, as all rays of a program begin in the same way. */
static inline __attribute__((noinline)) void mcv_packet_setup(mcv_rows origins, mcv_rows directions,
                                                              const uint *numbers, uint count,
                                                              float extent, mcv_hits hits,
                                                              mcv_packet *p) {
    for (uint first = 0; first < count; first += MCV_LANES) {
        uint own[MCV_LANES]; /* the last ray in place of those that are missing */
        mcv_lane_slabs slabs;
        mcv_lanes rays;
        for (uint i = 0; i < MCV_LANES; ++i) own[i] = numbers[min(first + i, count - 1u)];
        mcv_lanes_setup(origins, directions, own, 0, extent, &slabs, &rays);
#pragma unroll
        for (int axis = 0; axis < 3; ++axis) {
            mcv_store_lanes(slabs.inverse[axis], p->inverse[axis] + first);
            mcv_store_lanes(slabs.near_offset[axis], p->near_offset[axis] + first);
            mcv_store_lanes(slabs.far_offset[axis], p->far_offset[axis] + first);
            mcv_store_lanes(rays.shear.origin[axis], p->origin[axis] + first);
        }
        mcv_store_lanes(rays.shear.slope[0], p->slope[0] + first);
        mcv_store_lanes(rays.shear.slope[1], p->slope[1] + first);
        mcv_store_lanes(rays.shear.scale, p->scale + first);
        mcv_store_lanes(MCV_MAIN(&rays.shear, (mcv_uints)(2u), (mcv_uints)(1u), (mcv_uints)(0u)),
                        p->main_axis + first);
    }
    for (uint i = 0; i < count; ++i) {
        p->hits[i] = mcv_hit_of(hits, numbers[i]);
        p->t[i] = p->hits[i].t;
    }
}

/* So many of a packet's origins are looked at. */
#define MCV_ORIGIN_SAMPLES 16u

/* Whether rays begin within an eighth of the scene. */
MCV_LOOP_FUNCTION int mcv_begin_near(mcv_rows origins, const uint *numbers, uint count,
                                     float extent) {
    float widest = 0.0f;
    for (uint axis = 0; axis < 3; ++axis) {
        float low = INFINITY, high = -INFINITY;
        for (uint i = 0; i < MCV_ORIGIN_SAMPLES; ++i) {
            const uint number = numbers[i * count / MCV_ORIGIN_SAMPLES];
            const float o =
                as_float(origins.base[number * origins.step + axis * origins.component]);
            low = o < low ? o : low;
            high = o > high ? o : high;
        }
        widest = high - low > widest ? high - low : widest;
    }
    return widest < 0.125f * extent;
}

MCV_LOOP_FUNCTION mcv_slabs mcv_packet_slabs(const mcv_packet *p, uint i) {
    mcv_slabs slabs;
#pragma unroll
    for (int axis = 0; axis < 3; ++axis) {
        slabs.inverse[axis] = p->inverse[axis][i];
        slabs.near_offset[axis] = p->near_offset[axis][i];
        slabs.far_offset[axis] = p->far_offset[axis][i];
    }
    return slabs;
}

static inline mcv_ray_frame mcv_packet_ray(const mcv_packet *p, uint i) {
    mcv_ray_frame ray;
    ray.slabs = mcv_packet_slabs(p, i);
    mcv_set_rows(p->main_axis[i], &ray);
#pragma unroll
    for (int axis = 0; axis < 3; ++axis) ray.shear.origin[axis] = p->origin[axis][i];
    ray.shear.slope[0] = p->slope[0][i];
    ray.shear.slope[1] = p->slope[1][i];
    ray.shear.scale = p->scale[i];
    return ray;
}

/* Takes a ray's hit if it is closer than the one that it has. */
static inline void mcv_packet_take(mcv_packet *p, uint i, int any, mcv_hit hit) {
    mcv_hit *before = p->hits + i;
    if (hit.primitive == MCV_NONE ||
        !(hit.t < before->t || (hit.t == before->t && hit.primitive < before->primitive)))
        return;
    *before = hit;
    p->t[i] = any ? -1.0f : hit.t;
}

/* A leaf against the rays of a list. */
static inline __attribute__((noinline)) void mcv_packet_leaf(__global const mcv_leaf *leaf,
                                                             mcv_packet *p, const uchar *list,
                                                             uint count, int any) {
    for (uint first = 0; first < count; first += MCV_LANES) {
        uint i[MCV_LANES], main_axis[MCV_LANES], triangles[MCV_LANES];
        float o[3][MCV_LANES], slope[2][MCV_LANES], scale[MCV_LANES], t[MCV_LANES], u[MCV_LANES],
            v[MCV_LANES];
        mcv_lanes rays;
#pragma unroll
        for (uint k = 0; k < MCV_LANES; ++k) {
            const uint ray = list[min(first + k, count - 1u)];
            i[k] = ray;
            triangles[k] = p->hits[ray].primitive;
            main_axis[k] = p->main_axis[ray];
            o[0][k] = p->origin[0][ray], o[1][k] = p->origin[1][ray], o[2][k] = p->origin[2][ray];
            slope[0][k] = p->slope[0][ray], slope[1][k] = p->slope[1][ray];
            scale[k] = p->scale[ray];
            t[k] = p->t[ray];
        }
        const mcv_uints axis = mcv_load_lanes(main_axis);
        rays.shear.main_z = axis == 2u;
        rays.shear.main_y = axis == 1u;
#pragma unroll
        for (int k = 0; k < 3; ++k) rays.shear.origin[k] = mcv_load_lanes(o[k]);
        rays.shear.slope[0] = mcv_load_lanes(slope[0]);
        rays.shear.slope[1] = mcv_load_lanes(slope[1]);
        rays.shear.scale = mcv_load_lanes(scale);
        rays.t = mcv_load_lanes(t);
        rays.b = rays.c = rays.det = (mcv_floats)(1.0f);
        rays.primitive = mcv_load_lanes(triangles);
        uint changed = 0;
        for (uint lane = 0; lane < MCV_LEAF_TRIANGLES && leaf->triangle[lane] != MCV_NONE; ++lane)
            changed |= mcv_lanes_hit(MCV_CORNERS_OF(leaf, lane), leaf->triangle[lane], any, &rays);
        if (!changed) continue;
        mcv_store_lanes(rays.t, t);
        mcv_store_lanes(rays.b / rays.det, u);
        mcv_store_lanes(rays.c / rays.det, v);
        mcv_store_lanes(rays.primitive, triangles);
        do {
            const uint k = mcv_pop_bit(&changed);
            mcv_hit *hit = p->hits + i[k];
            p->t[i[k]] = t[k];
            hit->primitive = triangles[k];
            if (any) continue;
            hit->t = t[k];
            hit->u = u[k];
            hit->v = v[k];
        } while (changed);
    }
}

#endif
