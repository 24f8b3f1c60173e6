/* SPDX-License-Identifier: Apache-2.0 */
/* Many rays and hits in memory, as a traversal reads and writes them. */
#ifndef MCVISI_KERNELS_ROWS_H
#define MCVISI_KERNELS_ROWS_H

#include "mcvisi/accel.h"
#include "mcvisi/vector.h"

/* Vectors in memory, of bits: component k of number i is base[i * step + k * component]. */
#ifndef MCV_ROWS_SPACE
#define MCV_ROWS_SPACE __global
#endif
typedef struct mcv_rows {
    MCV_ROWS_SPACE const uint *base;
    uint step, component;
} mcv_rows;

/* Hits side by side: rows of their fields' bits. */
typedef struct mcv_hits {
    uint *t, *u, *v, *primitive;
} mcv_hits;

static inline mcv_hits mcv_hits_in(uint *rows, uint step) {
    const mcv_hits hits = {rows, rows + step, rows + 2u * step, rows + 3u * step};
    return hits;
}

static inline mcv_hit mcv_hit_of(mcv_hits hits, uint i) {
    const mcv_hit hit = {as_float(hits.t[i]), as_float(hits.u[i]), as_float(hits.v[i]),
                         hits.primitive[i]};
    return hit;
}

static inline void mcv_put_hit(mcv_hits hits, uint i, mcv_hit hit) {
    hits.t[i] = as_uint(hit.t);
    hits.u[i] = as_uint(hit.u);
    hits.v[i] = as_uint(hit.v);
    hits.primitive[i] = hit.primitive;
}

static inline mcv_hit mcv_miss(float t_max) {
    mcv_hit hit;
    hit.t = t_max;
    hit.u = hit.v = 0.0f;
    hit.primitive = MCV_NONE;
    return hit;
}

#endif
