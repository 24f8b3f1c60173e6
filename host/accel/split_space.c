/* SPDX-License-Identifier: Apache-2.0 */
/* Spatial splits: a triangle on both sides goes into both. */
#include "accel/split_bins.h"

enum {
    SPATIAL_BINS = 16,
    SAMPLES = 256, /* references of ordinary size by which a plane is chosen */
};
/* Of the node's width: larger references are all looked at, as one may fill most of a side. Axes
 * along which a node is shorter than this share of its length gain next to nothing. */
static const float large_share = 0.9f, least_length = 0.5f;

/* Between bins i - 1 and i. */
static float plane_of(const mcv_binning *b, uint32_t i) { return b->origin + (float)i / b->scale; }

static uint32_t spatial_bin(const mcv_binning *b, float x) {
    const float bin = (x - b->origin) * b->scale;
    return bin > 0.0f ? bin < (float)(b->bins - 1) ? (uint32_t)bin : b->bins - 1 : 0;
}

static float round_down(double x) {
    return (double)(float)x > x ? nextafterf((float)x, -INFINITY) : (float)x;
}
static float round_up(double x) {
    return (double)(float)x < x ? nextafterf((float)x, INFINITY) : (float)x;
}

static bool clip_to(mcv_reference *part, const mcv_reference *whole, const mcv_box3f *bounds) {
    bool some = true;
    for (int k = 0; k < 3; ++k) {
        part->lower[k] = mcv_larger(whole->lower[k], bounds->lower[k]);
        part->upper[k] = mcv_smaller(whole->upper[k], bounds->upper[k]);
        some = some && part->lower[k] <= part->upper[k];
    }
    part->triangle = whole->triangle;
    part->unused = 0;
    return some;
}

/*
 * Splits a reference at a plane. Each part is the box of the triangle's part on that side, within
 * the reference's box. One part may be empty, which is reported; never both. Corners on the plane
 * are computed in double and rounded outwards. The error of double, 2^-29 of the float's, is
 * negligible against the margin of traversal (kernels/traverse/bvh8.h): each point of the box lies
 * in one part or the other.
 */
static void split_reference(const mcv_splitter *s, const mcv_reference *whole, int axis,
                            float plane, mcv_reference *left, bool *has_left, mcv_reference *right,
                            bool *has_right) {
    mcv_box3f bounds[2] = {mcv_box3f_empty(), mcv_box3f_empty()};
    const uint32_t *corners = s->indices + 3 * (size_t)whole->triangle;
    const float *a = s->positions + 3 * (size_t)corners[2];
    for (int corner = 0; corner < 3; ++corner) {
        const float *b = s->positions + 3 * (size_t)corners[corner];
        for (int side = 0; side < 2; ++side) {
            if (side == 0 ? b[axis] > plane : b[axis] < plane) continue;
            for (int k = 0; k < 3; ++k) {
                bounds[side].lower[k] = mcv_smaller(bounds[side].lower[k], b[k]);
                bounds[side].upper[k] = mcv_larger(bounds[side].upper[k], b[k]);
            }
        }
        if ((a[axis] < plane && b[axis] > plane) || (a[axis] > plane && b[axis] < plane)) {
            const double t = ((double)plane - a[axis]) / ((double)b[axis] - a[axis]);
            for (int k = 0; k < 3; ++k) {
                const double x = k == axis ? (double)plane : a[k] + t * ((double)b[k] - a[k]);
                const float down = round_down(x), up = round_up(x);
                for (int side = 0; side < 2; ++side) {
                    bounds[side].lower[k] = mcv_smaller(bounds[side].lower[k], down);
                    bounds[side].upper[k] = mcv_larger(bounds[side].upper[k], up);
                }
            }
        }
        a = b;
    }
    *has_left = clip_to(left, whole, &bounds[0]);
    *has_right = clip_to(right, whole, &bounds[1]);
    if (*has_left || *has_right) return;
    *left = *whole;
    *has_left = true;
}

static inline mcv_box3f point_box(const float *p) {
    return (mcv_box3f){{p[0], p[1], p[2], 0.0f}, {p[0], p[1], p[2], 0.0f}};
}

/*
 * Adds the boxes of a reference's parts to the bins first … last. They are the boxes of the pieces
 * of the triangle's edges. They only serve to choose a plane, so float is enough; for a triangle
 * that crosses one plane only, the halves of its box are enough.
 */
static void add_parts(const mcv_splitter *s, const mcv_reference *whole, const mcv_binning *b,
                      uint32_t first, uint32_t last, mcv_box3f *bounds) {
    const int axis = b->axis;
    const mcv_box3f box = mcv_reference_box(whole);
    if (last <= first + 1) {
        mcv_box3f left = box, right = box;
        if (last > first) {
            left.upper[axis] = mcv_smaller(left.upper[axis], plane_of(b, last));
            right.lower[axis] = mcv_larger(right.lower[axis], plane_of(b, last));
        }
        mcv_box_add(&bounds[first], &left);
        mcv_box_add(&bounds[last], &right);
        return;
    }
    mcv_box3f parts[SPATIAL_BINS];
    for (uint32_t i = first; i <= last; ++i) parts[i] = mcv_box3f_empty();
    const uint32_t *corners = s->indices + 3 * (size_t)whole->triangle;
    for (int corner = 0; corner < 3; ++corner) {
        const float *p = s->positions + 3 * (size_t)corners[corner],
                    *q = s->positions + 3 * (size_t)corners[(corner + 1) % 3];
        const float *low = p[axis] <= q[axis] ? p : q, *high = low == p ? q : p;
        const uint32_t bin = spatial_bin(b, p[axis]), from = spatial_bin(b, low[axis]),
                       to = spatial_bin(b, high[axis]);
        const mcv_box3f here = point_box(p);
        if (bin >= first && bin <= last) mcv_box_add(&parts[bin], &here);
        for (uint32_t i = from < first ? first : from; i < to && i < last; ++i) {
            const float plane = plane_of(b, i + 1),
                        t = (plane - low[axis]) / (high[axis] - low[axis]);
            const float crossing[3] = {low[0] + t * (high[0] - low[0]),
                                       low[1] + t * (high[1] - low[1]),
                                       low[2] + t * (high[2] - low[2])};
            const mcv_box3f there = point_box(crossing);
            mcv_box_add(&parts[i], &there);
            mcv_box_add(&parts[i + 1], &there);
        }
    }
    for (uint32_t i = first; i <= last; ++i) {
        mcv_box3f part;
        for (int k = 0; k < 4; ++k) {
            part.lower[k] = mcv_larger(parts[i].lower[k], box.lower[k]);
            part.upper[k] = mcv_smaller(parts[i].upper[k], box.upper[k]);
        }
        if (part.lower[0] <= part.upper[0] && part.lower[1] <= part.upper[1] &&
            part.lower[2] <= part.upper[2])
            mcv_box_add(&bounds[i], &part);
    }
}

/* The bins of the three axes. */
typedef struct spatial_bins {
    mcv_binning axes[3];
    mcv_box3f bounds[3][SPATIAL_BINS];
    uint32_t entries[3][SPATIAL_BINS], exits[3][SPATIAL_BINS];
} spatial_bins;

/* Adds a reference that stands for so many. */
static void bin_reference(const mcv_splitter *s, const mcv_reference *here, uint32_t weight,
                          spatial_bins *b) {
    for (int axis = 0; axis < 3; ++axis) {
        if (!(b->axes[axis].scale > 0.0f)) continue;
        const uint32_t first = spatial_bin(&b->axes[axis], here->lower[axis]),
                       last = spatial_bin(&b->axes[axis], here->upper[axis]);
        add_parts(s, here, &b->axes[axis], first, last, b->bounds[axis]);
        b->entries[axis][first] += weight;
        b->exits[axis][last] += weight;
    }
}

static bool is_large(const mcv_reference *r, const float limits[3]) {
    return r->upper[0] - r->lower[0] > limits[0] || r->upper[1] - r->lower[1] > limits[1] ||
           r->upper[2] - r->lower[2] > limits[2];
}

mcv_split_candidate mcv_find_spatial_split(const mcv_splitter *s, const mcv_record *r) {
    mcv_split_candidate best = {.cost = INFINITY};
    spatial_bins b = {.entries = {{0}}, .exits = {{0}}};
    float limits[3], length = 0.0f;
    for (int axis = 0; axis < 3; ++axis) {
        limits[axis] = large_share * (r->bounds.upper[axis] - r->bounds.lower[axis]);
        length = mcv_larger(length, r->bounds.upper[axis] - r->bounds.lower[axis]);
    }
    for (int axis = 0; axis < 3; ++axis) {
        b.axes[axis] = mcv_bin_axis(&r->bounds, axis, SPATIAL_BINS);
        if (r->bounds.upper[axis] - r->bounds.lower[axis] < least_length * length)
            b.axes[axis].scale = 0.0f;
        for (uint32_t i = 0; i < SPATIAL_BINS; ++i) b.bounds[axis][i] = mcv_box3f_empty();
    }
    /* Of many references every few stand for their neighbours. */
    const uint32_t step = mcv_record_count(r) < 2 * SAMPLES ? 1 : mcv_record_count(r) / SAMPLES;
    for (uint32_t first = r->begin; first < r->end; first += step) {
        const uint32_t last = r->end - first < step ? r->end : first + step;
        uint32_t ordinary = 0, sample = first;
        for (uint32_t i = first; i < last; ++i) {
            if (is_large(s->references + i, limits)) {
                bin_reference(s, s->references + i, 1, &b);
            } else {
                ++ordinary;
                sample = i;
            }
        }
        if (ordinary) bin_reference(s, s->references + sample, ordinary, &b);
    }
    for (int axis = 0; axis < 3; ++axis) {
        if (b.axes[axis].scale > 0.0f)
            mcv_split_sweep(&b.axes[axis], b.bounds[axis], b.entries[axis], b.exits[axis], &best);
    }
    return best;
}

static float area_with(const mcv_box3f *a, const mcv_reference *r) {
    mcv_box3f both = mcv_reference_box(r);
    mcv_box_add(&both, a);
    return mcv_box_area(&both);
}

bool mcv_split_space(const mcv_splitter *s, const mcv_record *r, const mcv_split_candidate *by,
                     mcv_record *left, mcv_record *right) {
    const int axis = by->plane.axis;
    const float plane = plane_of(&by->plane, by->plane.split);
    const float area_left = mcv_box_area(&by->left), area_right = mcv_box_area(&by->right);
    const float count_left = (float)by->left_count, count_right = (float)by->right_count;
    mcv_reference *references = s->references;
    uint32_t i = r->begin, j = r->end;
    uint32_t end = j; /* of the parts that are added on the right */
    *left = *right = mcv_record_empty(0, 0, 0);
    while (i < j) {
        mcv_reference part_left = references[i], part_right = part_left;
        bool has_left = part_left.lower[axis] < plane || part_left.upper[axis] <= plane,
             has_right = part_left.upper[axis] > plane;
        if (has_left && has_right) {
            const mcv_reference whole = part_left;
            const float both = area_left * count_left + area_right * count_right;
            const float only_left =
                area_with(&by->left, &whole) * count_left + area_right * (count_right - 1.0f);
            const float only_right =
                area_left * (count_left - 1.0f) + area_with(&by->right, &whole) * count_right;
            if (end == r->limit || mcv_smaller(only_left, only_right) <= both) {
                has_left = only_left <= only_right;
                has_right = !has_left;
            } else {
                split_reference(s, &whole, axis, plane, &part_left, &has_left, &part_right,
                                &has_right);
            }
        }
        if (has_left) {
            mcv_record_add(left, &part_left);
            references[i++] = part_left;
            if (has_right) {
                mcv_record_add(right, &part_right);
                references[end++] = part_right;
            }
        } else {
            mcv_record_add(right, &part_right);
            references[i] = references[--j];
            references[j] = part_right;
        }
    }
    left->begin = r->begin;
    left->end = right->begin = i;
    right->end = end;
    return left->end > left->begin && right->end > right->begin;
}
