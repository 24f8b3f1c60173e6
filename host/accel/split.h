/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Splits of a node in two. The surface area heuristic over binned centroids separates objects
 * (Wald, On fast Construction of SAH-based Bounding Volume Hierarchies, 2007). Spatial splits
 * separate space and put a triangle on both sides into both (Stich, Friedrich and Dietrich, Spatial
 * Splits in Bounding Volume Hierarchies, HPG 2009).
 */
#ifndef MCVISI_HOST_ACCEL_SPLIT_H
#define MCVISI_HOST_ACCEL_SPLIT_H

#include <string.h>
#ifdef __SSE__
#include <xmmintrin.h>
#endif

#include "mcvisi/accel.h"
#include "core/error.h"

/* Four lanes, of which the last holds anything, for one vector instruction. */
typedef struct mcv_box3f {
    float lower[4], upper[4];
} mcv_box3f;

/* A triangle, or the part of one that lies in the box: its bytes are those of an mcv_box3f. */
typedef struct mcv_reference {
    float lower[3];
    uint32_t triangle;
    float upper[3];
    uint32_t unused;
} mcv_reference;

/*
 * References begin … end - 1, their box and the box of their doubled centroids (lower + upper). The
 * entries up to `limit` are free for references that spatial splits add.
 */
typedef struct mcv_record {
    uint32_t begin, end, limit;
    mcv_box3f bounds, centroids;
} mcv_record;

/* What all splits of a structure share. */
typedef struct mcv_splitter {
    const float *positions;
    const uint32_t *indices;
    mcv_reference *references;
    float root_area; /* as mcv_box_area */
    uint32_t threads;
} mcv_splitter;

mcv_box3f mcv_box3f_empty(void);
mcv_record mcv_record_empty(uint32_t begin, uint32_t end, uint32_t limit);

static inline uint32_t mcv_record_count(const mcv_record *r) { return r->end - r->begin; }

static inline void mcv_box_add(mcv_box3f *a, const mcv_box3f *b) {
#ifdef __SSE__ /* the compiler finds it only here and there */
    _mm_storeu_ps(a->lower, _mm_min_ps(_mm_loadu_ps(b->lower), _mm_loadu_ps(a->lower)));
    _mm_storeu_ps(a->upper, _mm_max_ps(_mm_loadu_ps(b->upper), _mm_loadu_ps(a->upper)));
#else
    for (int i = 0; i < 4; ++i) a->lower[i] = b->lower[i] < a->lower[i] ? b->lower[i] : a->lower[i];
    for (int i = 0; i < 4; ++i) a->upper[i] = b->upper[i] > a->upper[i] ? b->upper[i] : a->upper[i];
#endif
}

/* Half the surface; 0 for an empty box. */
static inline float mcv_box_area(const mcv_box3f *b) {
    const float x = b->upper[0] - b->lower[0], y = b->upper[1] - b->lower[1],
                z = b->upper[2] - b->lower[2];
    return x < 0.0f || y < 0.0f || z < 0.0f ? 0.0f : x * y + y * z + z * x;
}

static inline mcv_box3f mcv_reference_box(const mcv_reference *r) {
    mcv_box3f box;
    memcpy(&box, r, sizeof box);
    return box;
}

/* The doubled centroid of a reference. */
static inline void mcv_box_add_centroid(mcv_box3f *box, const mcv_reference *added) {
    mcv_box3f centroid = mcv_reference_box(added);
    for (int i = 0; i < 4; ++i) centroid.lower[i] += centroid.upper[i];
    for (int i = 0; i < 4; ++i) centroid.upper[i] = centroid.lower[i];
    mcv_box_add(box, &centroid);
}

static inline void mcv_record_add(mcv_record *r, const mcv_reference *added) {
    const mcv_box3f bounds = mcv_reference_box(added);
    mcv_box_add(&r->bounds, &bounds);
    mcv_box_add_centroid(&r->centroids, added);
}

/*
 * Splits by the cheaper heuristic, or into halves if no split is found or `halve` is set. Each side
 * gets at least one reference. Several threads bin a large record; this does not change the result,
 * because counts and boxes do not depend on the order of addition.
 */
void mcv_record_split(const mcv_splitter *s, const mcv_record *r, bool halve, mcv_record *left,
                      mcv_record *right);

#endif
