/* SPDX-License-Identifier: Apache-2.0 */
/* Splits a record by the cheapest split, or into halves. */
#include "accel/split_bins.h"

/*
 * Spatial splits are looked for where the sides of the best other split overlap by this share of
 * the root's area, of the node's own and, since large triangles reach far over the plane, of its
 * width. Stich et al. have 1e-5 for the first only: the cost of the trees is the same to 1e-2, and
 * a smooth mesh takes a fifth of the time. What they gain in CAD parts, they gain near the root: of
 * fewer references the sides must overlap more, as long needles do.
 */
static const float least_overlap = 1e-4f, least_own_overlap = 0.1f, least_few_overlap = 0.4f,
                   least_width_overlap = 0.05f;
enum { FEW = 512 };

mcv_box3f mcv_box3f_empty(void) {
    return (mcv_box3f){{INFINITY, INFINITY, INFINITY, INFINITY},
                       {-INFINITY, -INFINITY, -INFINITY, -INFINITY}};
}

mcv_record mcv_record_empty(uint32_t begin, uint32_t end, uint32_t limit) {
    return (mcv_record){begin, end, limit, mcv_box3f_empty(), mcv_box3f_empty()};
}

mcv_binning mcv_bin_axis(const mcv_box3f *range, int axis, uint32_t bins) {
    const float width = range->upper[axis] - range->lower[axis];
    const float scale = (float)bins * 0.99999f / width;
    return (mcv_binning){axis, bins, 0, range->lower[axis], isfinite(scale) ? scale : 0.0f};
}

void mcv_split_sweep(const mcv_binning *plane, const mcv_box3f *bounds, const uint32_t *entries,
                     const uint32_t *exits, mcv_split_candidate *best) {
    mcv_box3f right[MCV_SPLIT_BINS];
    uint32_t right_count[MCV_SPLIT_BINS];
    mcv_box3f side = mcv_box3f_empty();
    uint32_t count = 0;
    for (uint32_t i = plane->bins; i-- > 1;) {
        mcv_box_add(&side, &bounds[i]);
        count += exits[i];
        right[i] = side;
        right_count[i] = count;
    }
    side = mcv_box3f_empty();
    count = 0;
    for (uint32_t i = 1; i < plane->bins; ++i) {
        mcv_box_add(&side, &bounds[i - 1]);
        count += entries[i - 1];
        if (count == 0 || right_count[i] == 0) continue;
        const float cost = mcv_side_cost(&side, count) + mcv_side_cost(&right[i], right_count[i]);
        if (cost < best->cost) {
            *best = (mcv_split_candidate){cost, *plane, side, right[i], count, right_count[i]};
            best->plane.split = i;
        }
    }
}

static void split_objects(const mcv_splitter *s, const mcv_record *r, const mcv_split_candidate *by,
                          mcv_record *left, mcv_record *right) {
    const mcv_binning *plane = &by->plane;
    uint32_t i = r->begin, j = r->end;
    *left = *right = mcv_record_empty(0, 0, 0);
    left->bounds = by->left;
    right->bounds = by->right;
    while (i < j) {
        mcv_reference *here = s->references + i;
        if (mcv_bin_of(plane, here) < plane->split) {
            mcv_box_add_centroid(&left->centroids, here);
            ++i;
        } else {
            mcv_box_add_centroid(&right->centroids, here);
            const mcv_reference swap = *here;
            *here = s->references[--j];
            s->references[j] = swap;
        }
    }
    left->begin = r->begin;
    left->end = right->begin = i;
    right->end = r->end;
}

static void split_halves(const mcv_splitter *s, const mcv_record *r, mcv_record *left,
                         mcv_record *right) {
    const uint32_t middle = r->begin + mcv_record_count(r) / 2;
    *left = mcv_record_empty(r->begin, middle, middle);
    *right = mcv_record_empty(middle, r->end, r->end);
    for (uint32_t i = r->begin; i < middle; ++i) mcv_record_add(left, s->references + i);
    for (uint32_t i = middle; i < r->end; ++i) mcv_record_add(right, s->references + i);
}

/* Divides the remaining room in proportion to the numbers of references; the right side moves
 * up. */
static void share_room(const mcv_splitter *s, const mcv_record *r, mcv_record *left,
                       mcv_record *right) {
    const uint32_t count_left = mcv_record_count(left), count_right = mcv_record_count(right);
    const uint64_t room = r->limit - right->end;
    const uint32_t shift = (uint32_t)(room * count_left / (count_left + count_right));
    const uint32_t moved = shift < count_right ? shift : count_right;
    for (uint32_t i = 0; i < moved; ++i)
        s->references[right->end + shift - 1 - i] = s->references[right->begin + i];
    right->begin += shift;
    right->end += shift;
    left->limit = right->begin;
    right->limit = r->limit;
}

static bool overlaps(const mcv_splitter *s, const mcv_record *r, const mcv_split_candidate *split) {
    const int axis = split->plane.axis;
    mcv_box3f both;
    for (int i = 0; i < 4; ++i) {
        both.lower[i] = mcv_larger(split->left.lower[i], split->right.lower[i]);
        both.upper[i] = mcv_smaller(split->left.upper[i], split->right.upper[i]);
    }
    const float area = mcv_box_area(&both),
                own = mcv_record_count(r) < FEW ? least_few_overlap : least_own_overlap;
    return area > least_overlap * s->root_area && area > own * mcv_box_area(&r->bounds) &&
           both.upper[axis] - both.lower[axis] >
               least_width_overlap * (r->bounds.upper[axis] - r->bounds.lower[axis]);
}

void mcv_record_split(const mcv_splitter *s, const mcv_record *r, bool halve, mcv_record *left,
                      mcv_record *right) {
    mcv_split_candidate best = {.cost = INFINITY};
    if (!halve) best = mcv_find_object_split(s, r);
    if (!(best.cost < INFINITY)) {
        split_halves(s, r, left, right);
        return;
    }
    if (r->end < r->limit && overlaps(s, r, &best)) {
        const mcv_split_candidate spatial = mcv_find_spatial_split(s, r);
        if (spatial.cost < best.cost) {
            if (mcv_split_space(s, r, &spatial, left, right))
                share_room(s, r, left, right);
            else
                split_halves(s, r, left, right);
            return;
        }
    }
    split_objects(s, r, &best, left, right);
    share_room(s, r, left, right);
}
