/* SPDX-License-Identifier: Apache-2.0 */
/* The part of a surface that a defect lies on: triangles in its footprint that hang together with
 * the one at its middle (facets.h). */
#include "defects/facets.h"

#include "scene/geometry.h"
#include "scene/transform.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* A triangle that the footprint reaches, on whichever surface. */
typedef struct candidate {
    uint32_t instance, triangle;
    double corners[3][3]; /* u, v, height */
    double away;          /* distance of the centre */
    size_t joined;        /* to this one, or itself */
} candidate;

/* An edge of a candidate that the footprint reaches, its ends in order. */
typedef struct border {
    double ends[6];
    size_t candidate;
} border;

typedef struct search {
    const mcv_ground *ground;
    candidate *candidates;
    border *borders;
    size_t count, room, border_count;
} search;

mcv_ground mcv_ground_of(const mcv_scene *scene, mcv_known_meshes *known,
                         const mcv_defect *defect) {
    return (mcv_ground){.scene = scene,
                        .defect = defect,
                        .footprint = mcv_defect_footprint(defect),
                        .known = known};
}

static bool add_candidate(search *s, const candidate *one) {
    if (s->count == s->room) {
        const size_t room = s->room ? 2 * s->room : 256;
        candidate *larger = realloc(s->candidates, room * sizeof *larger);
        if (!larger) return false;
        s->candidates = larger;
        s->room = room;
    }
    s->candidates[s->count] = *one;
    s->candidates[s->count].joined = s->count;
    ++s->count;
    return true;
}

static void local_corners(const mcv_ground *ground, uint32_t instance, uint32_t triangle,
                          double corners[3][3]) {
    const mcv_mesh *mesh = ground->scene->meshes + ground->scene->instances[instance].mesh;
    uint32_t vertices[3];
    mcv_scene_triangle(ground->scene, instance, triangle, vertices);
    for (int k = 0; k < 3; ++k)
        mcv_ground_point(ground, instance, mesh->positions + 3 * (size_t)vertices[k], corners[k]);
}

/* The distance between the origin and a triangle, as far as its corners and its plane tell: that of
 * the plane where the origin lies above the triangle, else that of the nearest edge. */
static double distance_of(const double c[3][3]) {
    double e[2][3], n[3], least = INFINITY;
    bool above = true;
    for (int i = 0; i < 3; ++i) e[0][i] = c[1][i] - c[0][i], e[1][i] = c[2][i] - c[0][i];
    mcv_cross3(e[0], e[1], n);
    const double length = hypot(hypot(n[0], n[1]), n[2]);
    for (int k = 0; k < 3; ++k) {
        const double *a = c[k], *b = c[(k + 1) % 3];
        const double edge[3] = {b[0] - a[0], b[1] - a[1], b[2] - a[2]};
        const double squared = edge[0] * edge[0] + edge[1] * edge[1] + edge[2] * edge[2];
        const double along = -(a[0] * edge[0] + a[1] * edge[1] + a[2] * edge[2]);
        const double t = squared > 0 ? fmin(1, fmax(0, along / squared)) : 0;
        double cross[3];
        least =
            fmin(least, hypot(hypot(a[0] + t * edge[0], a[1] + t * edge[1]), a[2] + t * edge[2]));
        mcv_cross3(edge, (const double[3]){-a[0], -a[1], -a[2]}, cross);
        above = above && cross[0] * n[0] + cross[1] * n[1] + cross[2] * n[2] >= 0;
    }
    if (!above || !(length > 0)) return least;
    return fabs(c[0][0] * n[0] + c[0][1] * n[1] + c[0][2] * n[2]) / length;
}

/* In the tangent plane, or more than that. */
static double longest_side(const double c[3][3]) {
    double most = 0;
    for (int k = 1; k < 3; ++k)
        for (int i = 0; i < 2; ++i) most = fmax(most, fabs(c[k][i] - c[0][i]));
    return most * M_SQRT2;
}

bool mcv_ground_spares(const mcv_ground *ground, uint32_t instance, uint32_t triangle) {
    double c[3][3];
    local_corners(ground, instance, triangle, c);
    const double rise = fmax(fabs(c[1][2] - c[0][2]), fabs(c[2][2] - c[0][2])),
                 side = longest_side((const double(*)[3])c), longest = 2 * (side + rise);
    return mcv_ground_is_far(ground, c[0], side, longest / MCV_GRADING);
}

static mcv_spread spread_of(const mcv_ground *ground, uint32_t instance, const mcv_box *box) {
    return mcv_box_spread(box, &ground->scene->instances[instance].to_world, ground->defect->centre,
                          (const double(*)[3])ground->defect->axes);
}

/* As mcv_ground_is_far of whichever point the box may hold. */
static bool is_spread_far(const mcv_ground *ground, const mcv_spread *s, double reach,
                          double beyond) {
    double nearest[3] = {0, 0, 0};
    for (int k = 0; k < 2; ++k)
        nearest[k] = fmax(0, fabs(s->middle[k]) - s->half[k]) * (1 - 1e-9); /* rounding */
    return mcv_ground_is_far(ground, nearest, reach, beyond);
}

bool mcv_ground_spares_box(const mcv_ground *ground, uint32_t instance, const mcv_box *box) {
    const mcv_spread s = spread_of(ground, instance, box);
    const double side = 2 * (s.half[0] + s.half[1]), longest = side + 2 * s.half[2];
    return s.middle[2] - s.half[2] > ground->high || s.middle[2] + s.half[2] < ground->low ||
           is_spread_far(ground, &s, side, longest / MCV_GRADING);
}

/* Has the box no candidate? */
static bool is_box_beside(const mcv_ground *ground, uint32_t instance, const mcv_box *box) {
    const mcv_spread s = spread_of(ground, instance, box);
    return s.middle[2] + s.half[2] < ground->footprint.lowest ||
           is_spread_far(ground, &s, 2 * M_SQRT2 * fmax(s.half[0], s.half[1]), 0);
}

/* False without memory. */
static bool try_candidate(search *s, uint32_t instance, uint32_t triangle) {
    const mcv_ground *ground = s->ground;
    candidate one = {.instance = instance, .triangle = triangle};
    local_corners(ground, instance, triangle, one.corners);
    const double(*c)[3] = (const double(*)[3])one.corners;
    if (mcv_ground_is_far(ground, c[0], longest_side(c), 0)) return true;
    if (fmax(fmax(c[0][2], c[1][2]), c[2][2]) <= ground->footprint.lowest ||
        mcv_ground_triangle_distance(ground, c) >= ground->footprint.radius)
        return true;
    one.away = distance_of(c);
    return add_candidate(s, &one);
}

static bool find_candidates(search *s) {
    const mcv_ground *ground = s->ground;
    const mcv_scene *scene = ground->scene;
    for (uint32_t i = ground->defect->instances[0]; i < ground->defect->instances[1]; ++i) {
        const uint32_t mesh = scene->instances[i].mesh, count = scene->meshes[mesh].triangle_count;
        const mcv_mesh_boxes *boxes = mcv_known_boxes(ground->known, scene, mesh);
        if (!boxes) return false;
        const uint8_t *gone = mcv_known_gone(ground->known, mesh);
        if (is_box_beside(ground, i, &boxes->all)) continue;
        for (uint32_t t = 0; t < count; ++t) {
            if (t % MCV_BOX_TRIANGLES == 0 &&
                is_box_beside(ground, i, boxes->items + t / MCV_BOX_TRIANGLES)) {
                t += MCV_BOX_TRIANGLES - 1;
                continue;
            }
            if (gone && gone[t]) continue;
            if (!try_candidate(s, i, t)) return false;
        }
    }
    return true;
}

/* --- what hangs together --- */

static int compare_borders(const void *a, const void *b) {
    const border *p = a, *q = b;
    for (int i = 0; i < 6; ++i)
        if (p->ends[i] != q->ends[i]) return p->ends[i] < q->ends[i] ? -1 : 1;
    return p->candidate < q->candidate ? -1 : p->candidate > q->candidate;
}

static bool same_edge(const border *a, const border *b) {
    for (int i = 0; i < 6; ++i)
        if (a->ends[i] != b->ends[i]) return false;
    return true;
}

static bool find_borders(search *s) {
    s->borders = malloc((3 * s->count + 1) * sizeof *s->borders);
    if (!s->borders) return false;
    for (size_t i = 0; i < s->count; ++i)
        for (int k = 0; k < 3; ++k) {
            const double *a = s->candidates[i].corners[k],
                         *b = s->candidates[i].corners[(k + 1) % 3];
            bool swapped = false;
            for (int j = 2; j >= 0; --j)
                if (a[j] != b[j]) swapped = a[j] > b[j];
            border *one = s->borders + s->border_count;
            for (int j = 0; j < 3; ++j) {
                one->ends[j] = swapped ? b[j] : a[j];
                one->ends[3 + j] = swapped ? a[j] : b[j];
            }
            one->candidate = i;
            if (fmax(a[2], b[2]) > s->ground->footprint.lowest &&
                mcv_ground_edge_distance(s->ground, one->ends, one->ends + 3) <
                    s->ground->footprint.radius)
                ++s->border_count;
        }
    qsort(s->borders, s->border_count, sizeof *s->borders, compare_borders);
    return true;
}

static size_t root_of(search *s, size_t i) {
    while (s->candidates[i].joined != i) {
        s->candidates[i].joined = s->candidates[s->candidates[i].joined].joined;
        i = s->candidates[i].joined;
    }
    return i;
}

/* The root of the surface at the centre; SIZE_MAX without one. */
static size_t join(search *s) {
    size_t nearest = SIZE_MAX;
    for (size_t i = 1; i < s->border_count; ++i)
        if (same_edge(s->borders + i - 1, s->borders + i))
            s->candidates[root_of(s, s->borders[i - 1].candidate)].joined =
                root_of(s, s->borders[i].candidate);
    for (size_t i = 0; i < s->count; ++i)
        if (nearest == SIZE_MAX || s->candidates[i].away < s->candidates[nearest].away) nearest = i;
    return nearest == SIZE_MAX ? nearest : root_of(s, nearest);
}

/* --- all of it --- */

/* The cosine between a candidate's face and the defect's normal; 1 for a face without area. */
static double facing(const candidate *one) {
    double e[2][3], n[3];
    for (int i = 0; i < 3; ++i) {
        e[0][i] = one->corners[1][i] - one->corners[0][i];
        e[1][i] = one->corners[2][i] - one->corners[0][i];
    }
    mcv_cross3(e[0], e[1], n);
    return mcv_normalize3(n, n) ? n[2] : 1;
}

/* Surfaces that are steeper against the tangent plane are another side of the part. */
static const double steepest = 60 * M_PI / 180;

/* Does a cut reach a triangle of another surface? */
static bool is_cut(const mcv_ground *ground, const candidate *one) {
    const mcv_defect *d = ground->defect;
    double above[3][3];
    bool within = false;
    for (int k = 0; k < 3; ++k) {
        memcpy(above[k], one->corners[k], sizeof above[k]);
        above[k][2] += d->depth - d->size / 2; /* from the middle of a chip's ball */
        within = within || mcv_defect_outline(d, one->corners[k]) > 0;
    }
    return within ||
           (d->type == MCV_DEFECT_CHIP && distance_of((const double(*)[3])above) < d->size / 2);
}

/* The height of a triangle above or below the centre; NaN where it lies beside. */
static double height_at_centre(const double c[3][3]) {
    double shares[3], sum = 0, height = 0;
    for (int k = 0; k < 3; ++k) {
        const double *a = c[(k + 1) % 3], *b = c[(k + 2) % 3];
        shares[k] = a[0] * b[1] - a[1] * b[0];
        sum += shares[k];
    }
    for (int k = 0; k < 3; ++k) {
        if (!(shares[k] / sum >= 0)) return NAN;
        height += shares[k] / sum * c[k][2];
    }
    return height;
}

/* Does the defect push its surface through another one, where it is deepest? What lies nearer than
 * a thousandth of the depth is the surface itself, twice in the file. */
static mcv_result check_depth(const mcv_ground *ground, const candidate *other,
                              const mcv_json_path *place, mcv_error *error) {
    const mcv_defect_kind kind = mcv_defect_kind_of(ground->defect->type);
    double slope[2];
    if (kind != MCV_KIND_RELIEF && kind != MCV_KIND_PIT) return MCV_OK;
    const double deepest = mcv_defect_height(ground->defect, 0, 0, slope),
                 height = height_at_centre((const double(*)[3])other->corners);
    if (!(height > deepest && height < deepest / 1000)) return MCV_OK;
    return mcv_fail_at(place, error,
                       "goes through its part: it is %.3g m deep, and the part is %.3g m thick "
                       "there: make it shallower",
                       -deepest, -height);
}

static mcv_result mark(search *s, mcv_ground *ground, mcv_marks *marks, const mcv_json_path *place,
                       mcv_error *error) {
    const size_t root = join(s);
    const double margin = ground->footprint.radius;
    const bool cut = mcv_defect_kind_of(ground->defect->type) == MCV_KIND_CUT;
    ground->low = INFINITY;
    ground->high = -INFINITY;
    for (size_t i = 0; i < s->count; ++i) {
        const candidate *one = s->candidates + i;
        if (root_of(s, i) != root && cut && is_cut(ground, one))
            return mcv_fail_at(place, error,
                               "reaches another side of its part: move it, or make it smaller");
        if (root_of(s, i) != root) MCV_TRY(check_depth(ground, one, place, error));
        if (root_of(s, i) != root) continue;
        const double cosine = facing(one);
        if (cosine < cos(steepest) && !cut)
            return mcv_fail_at(place, error,
                               "reaches round an edge of its part, where the surface is turned by "
                               "%.3g deg: move it, or make it smaller",
                               acos(fmax(-1, cosine)) * 180 / M_PI);
        if (marks && !mcv_marks_add(marks, one->instance, one->triangle))
            return mcv_fail_memory(place, error);
        for (int k = 0; k < 3; ++k) {
            ground->low = fmin(ground->low, one->corners[k][2] - margin);
            ground->high = fmax(ground->high, one->corners[k][2] + margin);
        }
    }
    return MCV_OK;
}

mcv_result mcv_ground_find(mcv_ground *ground, mcv_marks *marks, const mcv_json_path *place,
                           mcv_error *error) {
    search s = {.ground = ground};
    const bool memory = find_candidates(&s) && find_borders(&s);
    const mcv_result result =
        memory ? mark(&s, ground, marks, place, error) : mcv_fail_memory(place, error);
    free(s.candidates);
    free(s.borders);
    return result;
}
