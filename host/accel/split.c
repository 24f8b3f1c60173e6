/* SPDX-License-Identifier: Apache-2.0 */
#include "accel/split.h"

#include <math.h>
#include <pthread.h>

enum {
    MOST_BINS = 32,
    SPATIAL_BINS = 16,
    MOST_BINNERS = 16,     /* threads that bin one record */
    LEAST_SHARE = 1 << 16, /* references that are worth a thread: some ms */
};

/*
 * Spatial splits are looked for where the sides of the best other split overlap by this share of
 * the root's area, of the node's own and, since large triangles reach far over the plane, of its
 * width. Stich et al. have 1e-5 for the first only: the cost of the trees is the same to 1e-2, and
 * a smooth mesh takes a fifth of the time.
 */
static const float least_overlap = 1e-4f, least_own_overlap = 0.1f, least_width_overlap = 0.05f;

/* A plane: bins below `split` go left. */
typedef struct binning {
    int axis;
    uint32_t bins, split;
    float origin, scale;
} binning;

/* Unlike fminf and fmaxf, one instruction each: no NaN comes here. */
static inline float smaller(float a, float b) { return a < b ? a : b; }
static inline float larger(float a, float b) { return a > b ? a : b; }

typedef struct candidate {
    float cost; /* infinite: there is none */
    binning plane;
    mcv_box left, right;
    uint32_t left_count, right_count;
} candidate;

mcv_box mcv_box_empty(void) {
    return (mcv_box){{INFINITY, INFINITY, INFINITY, INFINITY},
                     {-INFINITY, -INFINITY, -INFINITY, -INFINITY}};
}

mcv_record mcv_record_empty(uint32_t begin, uint32_t end, uint32_t limit) {
    return (mcv_record){begin, end, limit, mcv_box_empty(), mcv_box_empty()};
}

static inline mcv_box reference_box(const mcv_reference *r) {
    return (mcv_box){{r->lower[0], r->lower[1], r->lower[2], 0.0f},
                     {r->upper[0], r->upper[1], r->upper[2], 0.0f}};
}

static binning bin_axis(const mcv_box *range, int axis, uint32_t bins) {
    const float width = range->upper[axis] - range->lower[axis];
    const float scale = (float)bins * 0.99999f / width;
    return (binning){axis, bins, 0, range->lower[axis], isfinite(scale) ? scale : 0.0f};
}

static inline uint32_t bin_of(const binning *b, const mcv_reference *r) {
    return (uint32_t)((r->lower[b->axis] + r->upper[b->axis] - b->origin) * b->scale);
}

/* Leaves hold whole blocks, so blocks are what a side costs. */
static inline float side_cost(const mcv_box *bounds, uint32_t count) {
    const uint32_t blocks = (count + MCV_LEAF_TRIANGLES - 1) / MCV_LEAF_TRIANGLES;
    return mcv_box_area(bounds) * (float)blocks;
}

/* The cheapest plane between bins that begin `entries` and end `exits` references; keeps *best if
 * that is cheaper. */
static void sweep(const binning *plane, const mcv_box *bounds, const uint32_t *entries,
                  const uint32_t *exits, candidate *best) {
    mcv_box right[MOST_BINS];
    uint32_t right_count[MOST_BINS];
    mcv_box side = mcv_box_empty();
    uint32_t count = 0;
    for (uint32_t i = plane->bins; i-- > 1;) {
        mcv_box_add(&side, &bounds[i]);
        count += exits[i];
        right[i] = side;
        right_count[i] = count;
    }
    side = mcv_box_empty();
    count = 0;
    for (uint32_t i = 1; i < plane->bins; ++i) {
        mcv_box_add(&side, &bounds[i - 1]);
        count += entries[i - 1];
        if (count == 0 || right_count[i] == 0) continue;
        const float cost = side_cost(&side, count) + side_cost(&right[i], right_count[i]);
        if (cost < best->cost) {
            *best = (candidate){cost, *plane, side, right[i], count, right_count[i]};
            best->plane.split = i;
        }
    }
}

/* A range of references sorted into the bins of all axes. */
typedef struct object_bins {
    const mcv_splitter *splitter;
    const binning *axes;
    uint32_t begin, end;
    mcv_box bounds[3][MOST_BINS];
    uint32_t counts[3][MOST_BINS];
} object_bins;

static void *fill_bins(void *user) {
    object_bins *b = user;
    for (int axis = 0; axis < 3; ++axis) {
        for (uint32_t i = 0; i < b->axes[axis].bins; ++i) {
            b->bounds[axis][i] = mcv_box_empty();
            b->counts[axis][i] = 0;
        }
    }
    for (uint32_t i = b->begin; i < b->end; ++i) {
        const mcv_reference *here = b->splitter->references + i;
        const mcv_box added = reference_box(here);
        for (int axis = 0; axis < 3; ++axis) {
            const uint32_t bin = bin_of(&b->axes[axis], here);
            mcv_box_add(&b->bounds[axis][bin], &added);
            ++b->counts[axis][bin];
        }
    }
    return NULL;
}

static void merge_bins(object_bins *into, const object_bins *other) {
    for (int axis = 0; axis < 3; ++axis) {
        for (uint32_t i = 0; i < into->axes[axis].bins; ++i) {
            mcv_box_add(&into->bounds[axis][i], &other->bounds[axis][i]);
            into->counts[axis][i] += other->counts[axis][i];
        }
    }
}

/* Shares the range among as many threads; where one cannot be started, its part is done here. */
static void fill_bins_together(object_bins *all, uint32_t threads) {
    const uint32_t begin = all->begin, count = all->end - all->begin;
    object_bins parts[MOST_BINNERS];
    pthread_t handles[MOST_BINNERS];
    bool started[MOST_BINNERS];
    for (uint32_t i = 1; i < threads; ++i) {
        parts[i].splitter = all->splitter;
        parts[i].axes = all->axes;
        parts[i].begin = begin + (uint32_t)((uint64_t)count * i / threads);
        parts[i].end = begin + (uint32_t)((uint64_t)count * (i + 1) / threads);
        started[i] = pthread_create(handles + i, NULL, fill_bins, parts + i) == 0;
    }
    all->end = begin + count / threads;
    fill_bins(all);
    for (uint32_t i = 1; i < threads; ++i) {
        if (started[i])
            pthread_join(handles[i], NULL);
        else
            fill_bins(parts + i);
        merge_bins(all, parts + i);
    }
}

/* Nothing is found if all centroids fall into one bin on every axis. */
static candidate find_object_split(const mcv_splitter *s, const mcv_record *r) {
    const uint32_t count = mcv_record_count(r), wanted = 4 + count / 16;
    binning axes[3];
    candidate best = {.cost = INFINITY};
    for (int axis = 0; axis < 3; ++axis)
        axes[axis] = bin_axis(&r->centroids, axis, wanted < MOST_BINS ? wanted : MOST_BINS);
    object_bins all;
    all.splitter = s;
    all.axes = axes;
    all.begin = r->begin;
    all.end = r->end;
    /* While few records are so large, few threads have one. */
    const uint32_t threads = count / LEAST_SHARE < s->threads ? count / LEAST_SHARE : s->threads;
    if (threads > 1)
        fill_bins_together(&all, threads < MOST_BINNERS ? threads : MOST_BINNERS);
    else
        fill_bins(&all);
    for (int axis = 0; axis < 3; ++axis)
        sweep(&axes[axis], all.bounds[axis], all.counts[axis], all.counts[axis], &best);
    return best;
}

/* ---- through space
 * ---------------------------------------------------------------------------------------------- */

/* Between bins i - 1 and i. */
static float plane_of(const binning *b, uint32_t i) { return b->origin + (float)i / b->scale; }

static uint32_t spatial_bin(const binning *b, float x) {
    const float bin = (x - b->origin) * b->scale;
    return bin > 0.0f ? bin < (float)(b->bins - 1) ? (uint32_t)bin : b->bins - 1 : 0;
}

static float round_down(double x) {
    return (double)(float)x > x ? nextafterf((float)x, -INFINITY) : (float)x;
}
static float round_up(double x) {
    return (double)(float)x < x ? nextafterf((float)x, INFINITY) : (float)x;
}

static bool clip_to(mcv_reference *part, const mcv_reference *whole, const mcv_box *bounds) {
    bool some = true;
    for (int k = 0; k < 3; ++k) {
        part->lower[k] = larger(whole->lower[k], bounds->lower[k]);
        part->upper[k] = smaller(whole->upper[k], bounds->upper[k]);
        some = some && part->lower[k] <= part->upper[k];
    }
    part->triangle = whole->triangle;
    part->unused = 0;
    return some;
}

/*
 * The parts of a reference on either side of a plane: boxes around the triangle's part on that
 * side, within the reference's box. A side may have none, and is said so; never both. Corners on
 * the plane are rounded outwards from double, whose own error, 2^-29 of the float's, is nothing to
 * the margin of traversal (kernels/traverse/bvh8.h): what is in the box lies in one part or the
 * other.
 */
static void split_reference(const mcv_splitter *s, const mcv_reference *whole, int axis,
                            float plane, mcv_reference *left, bool *has_left, mcv_reference *right,
                            bool *has_right) {
    mcv_box bounds[2] = {mcv_box_empty(), mcv_box_empty()};
    const uint32_t *corners = s->indices + 3 * (size_t)whole->triangle;
    const float *a = s->positions + 3 * (size_t)corners[2];
    for (int corner = 0; corner < 3; ++corner) {
        const float *b = s->positions + 3 * (size_t)corners[corner];
        for (int side = 0; side < 2; ++side) {
            if (side == 0 ? b[axis] > plane : b[axis] < plane) continue;
            for (int k = 0; k < 3; ++k) {
                bounds[side].lower[k] = smaller(bounds[side].lower[k], b[k]);
                bounds[side].upper[k] = larger(bounds[side].upper[k], b[k]);
            }
        }
        if ((a[axis] < plane && b[axis] > plane) || (a[axis] > plane && b[axis] < plane)) {
            const double t = ((double)plane - a[axis]) / ((double)b[axis] - a[axis]);
            for (int k = 0; k < 3; ++k) {
                const double x = k == axis ? (double)plane : a[k] + t * ((double)b[k] - a[k]);
                const float down = round_down(x), up = round_up(x);
                for (int side = 0; side < 2; ++side) {
                    bounds[side].lower[k] = smaller(bounds[side].lower[k], down);
                    bounds[side].upper[k] = larger(bounds[side].upper[k], up);
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

static inline mcv_box point_box(const float *p) {
    return (mcv_box){{p[0], p[1], p[2], 0.0f}, {p[0], p[1], p[2], 0.0f}};
}

/*
 * Adds the boxes of a reference's parts in bins first … last: those of the pieces of its triangle's
 * edges. They only serve to choose a plane, so float will do, and for a triangle that crosses just
 * one, so will the halves of its box.
 */
static void add_parts(const mcv_splitter *s, const mcv_reference *whole, const binning *b,
                      uint32_t first, uint32_t last, mcv_box *bounds) {
    const int axis = b->axis;
    const mcv_box box = reference_box(whole);
    if (last <= first + 1) {
        mcv_box left = box, right = box;
        if (last > first) {
            left.upper[axis] = smaller(left.upper[axis], plane_of(b, last));
            right.lower[axis] = larger(right.lower[axis], plane_of(b, last));
        }
        mcv_box_add(&bounds[first], &left);
        mcv_box_add(&bounds[last], &right);
        return;
    }
    mcv_box parts[SPATIAL_BINS];
    for (uint32_t i = first; i <= last; ++i) parts[i] = mcv_box_empty();
    const uint32_t *corners = s->indices + 3 * (size_t)whole->triangle;
    for (int corner = 0; corner < 3; ++corner) {
        const float *p = s->positions + 3 * (size_t)corners[corner],
                    *q = s->positions + 3 * (size_t)corners[(corner + 1) % 3];
        const float *low = p[axis] <= q[axis] ? p : q, *high = low == p ? q : p;
        const uint32_t bin = spatial_bin(b, p[axis]), from = spatial_bin(b, low[axis]),
                       to = spatial_bin(b, high[axis]);
        const mcv_box here = point_box(p);
        if (bin >= first && bin <= last) mcv_box_add(&parts[bin], &here);
        for (uint32_t i = from < first ? first : from; i < to && i < last; ++i) {
            const float plane = plane_of(b, i + 1),
                        t = (plane - low[axis]) / (high[axis] - low[axis]);
            const float crossing[3] = {low[0] + t * (high[0] - low[0]),
                                       low[1] + t * (high[1] - low[1]),
                                       low[2] + t * (high[2] - low[2])};
            const mcv_box there = point_box(crossing);
            mcv_box_add(&parts[i], &there);
            mcv_box_add(&parts[i + 1], &there);
        }
    }
    for (uint32_t i = first; i <= last; ++i) {
        mcv_box part;
        for (int k = 0; k < 4; ++k) {
            part.lower[k] = larger(parts[i].lower[k], box.lower[k]);
            part.upper[k] = smaller(parts[i].upper[k], box.upper[k]);
        }
        if (part.lower[0] <= part.upper[0] && part.lower[1] <= part.upper[1] &&
            part.lower[2] <= part.upper[2])
            mcv_box_add(&bounds[i], &part);
    }
}

static candidate find_spatial_split(const mcv_splitter *s, const mcv_record *r) {
    candidate best = {.cost = INFINITY};
    for (int axis = 0; axis < 3; ++axis) {
        const binning bins = bin_axis(&r->bounds, axis, SPATIAL_BINS);
        mcv_box bounds[SPATIAL_BINS];
        uint32_t entries[SPATIAL_BINS] = {0}, exits[SPATIAL_BINS] = {0};
        if (!(bins.scale > 0.0f)) continue;
        for (uint32_t i = 0; i < SPATIAL_BINS; ++i) bounds[i] = mcv_box_empty();
        for (uint32_t i = r->begin; i < r->end; ++i) {
            const mcv_reference *here = s->references + i;
            const uint32_t first = spatial_bin(&bins, here->lower[axis]),
                           last = spatial_bin(&bins, here->upper[axis]);
            add_parts(s, here, &bins, first, last, bounds);
            ++entries[first];
            ++exits[last];
        }
        sweep(&bins, bounds, entries, exits, &best);
    }
    return best;
}

static float area_with(const mcv_box *a, const mcv_reference *r) {
    mcv_box both = reference_box(r);
    mcv_box_add(&both, a);
    return mcv_box_area(&both);
}

/*
 * Sorts the references into both sides. One that lies on both is split while there is room, unless
 * it costs less on one side as a whole. False if a side stays empty.
 */
static bool split_space(const mcv_splitter *s, const mcv_record *r, const candidate *by,
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
            if (end == r->limit || smaller(only_left, only_right) <= both) {
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

/* ---- both
 * -------------------------------------------------------------------------------------------------------
 */

static void split_objects(const mcv_splitter *s, const mcv_record *r, const binning *plane,
                          mcv_record *left, mcv_record *right) {
    uint32_t i = r->begin, j = r->end;
    *left = *right = mcv_record_empty(0, 0, 0);
    while (i < j) {
        mcv_reference *here = s->references + i;
        if (bin_of(plane, here) < plane->split) {
            mcv_record_add(left, here);
            ++i;
        } else {
            mcv_record_add(right, here);
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

/* Shares what room is left in proportion to the numbers of references: the right side moves up. */
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

static bool overlaps(const mcv_splitter *s, const mcv_record *r, const candidate *split) {
    const int axis = split->plane.axis;
    mcv_box both;
    for (int i = 0; i < 4; ++i) {
        both.lower[i] = larger(split->left.lower[i], split->right.lower[i]);
        both.upper[i] = smaller(split->left.upper[i], split->right.upper[i]);
    }
    const float area = mcv_box_area(&both);
    return area > least_overlap * s->root_area &&
           area > least_own_overlap * mcv_box_area(&r->bounds) &&
           both.upper[axis] - both.lower[axis] >
               least_width_overlap * (r->bounds.upper[axis] - r->bounds.lower[axis]);
}

void mcv_record_split(const mcv_splitter *s, const mcv_record *r, bool halve, mcv_record *left,
                      mcv_record *right) {
    candidate best = {.cost = INFINITY};
    if (!halve) best = find_object_split(s, r);
    if (!(best.cost < INFINITY)) {
        split_halves(s, r, left, right);
        return;
    }
    if (r->end < r->limit && overlaps(s, r, &best)) {
        const candidate spatial = find_spatial_split(s, r);
        if (spatial.cost < best.cost) {
            if (split_space(s, r, &spatial, left, right))
                share_room(s, r, left, right);
            else
                split_halves(s, r, left, right);
            return;
        }
    }
    split_objects(s, r, &best.plane, left, right);
    share_room(s, r, left, right);
}
