/* SPDX-License-Identifier: Apache-2.0 */
/* From triangles to references before a structure is built, and from references to leaves after
 * it. */
#include "accel/bvh_builder.h"

#include <math.h>

void mcv_bvh_share(const mcv_bvh_worker *w, uint32_t n, uint32_t *begin, uint32_t *end) {
    *begin = (uint32_t)((uint64_t)n * w->number / w->builder->threads);
    *end = (uint32_t)((uint64_t)n * (w->number + 1) / w->builder->threads);
}

void mcv_bvh_make_references(mcv_bvh_worker *w) {
    mcv_bvh_builder *b = w->builder;
    uint32_t begin, end;
    mcv_bvh_share(w, b->triangle_count, &begin, &end);
    mcv_record all = mcv_record_empty(begin, end, end);
    for (uint32_t i = begin; i < end; ++i) {
        mcv_reference *r = b->splitter.references + i;
        *r = (mcv_reference){
            {INFINITY, INFINITY, INFINITY}, i, {-INFINITY, -INFINITY, -INFINITY}, 0};
        for (int corner = 0; corner < 3; ++corner) {
            const float *p =
                b->splitter.positions + 3 * (size_t)b->splitter.indices[3 * (size_t)i + corner];
            for (int axis = 0; axis < 3; ++axis) {
                r->lower[axis] = p[axis] < r->lower[axis] ? p[axis] : r->lower[axis];
                r->upper[axis] = p[axis] > r->upper[axis] ? p[axis] : r->upper[axis];
            }
        }
        mcv_record_add(&all, r);
    }
    w->bounds = all.bounds;
    w->centroids = all.centroids;
}

void mcv_bvh_fill_leaves(mcv_bvh_worker *w) {
    mcv_bvh_builder *b = w->builder;
    uint32_t begin, end;
    mcv_bvh_share(w, b->leaf_count, &begin, &end);
    for (uint32_t i = begin; i < end; ++i) {
        mcv_leaf *leaf = b->bvh->leaves + i;
        const mcv_binary *content = mcv_bvh_binary(b, b->leaf_binaries[i]);
        const uint32_t first = content->children[0], count = content->children[1] & ~MCV_CHILD_LEAF;
        *leaf = (mcv_leaf){.triangle = {MCV_NONE, MCV_NONE, MCV_NONE, MCV_NONE}};
        uint32_t lane = 0;
        for (uint32_t k = first; k < first + count; ++k) {
            const uint32_t triangle = b->splitter.references[k].triangle;
            /* Two parts of one triangle may end in one leaf. */
            bool there = false;
            for (uint32_t before = 0; before < lane; ++before)
                there = there || leaf->triangle[before] == triangle;
            if (there) continue;
            leaf->triangle[lane] = triangle;
            for (int corner = 0; corner < 3; ++corner) {
                const float *p = b->splitter.positions +
                                 3 * (size_t)b->splitter.indices[3 * (size_t)triangle + corner];
                for (int axis = 0; axis < 3; ++axis) leaf->vertex[corner][axis][lane] = p[axis];
            }
            ++lane;
        }
    }
}
