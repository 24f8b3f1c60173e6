/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Cuts triangles along the outline of a defect: an edge whose ends lie on either side of it is cut
 * where the outline crosses it. That point depends on the edge alone, so that both its triangles
 * get the same one and a closed mesh stays closed.
 */
#include "defects/facets.h"

#include "scene/transform.h"

#include <float.h>
#include <math.h>

/* --- cutting --- */

static double outline_at(const mcv_ground *ground, uint32_t instance, const mcv_corner *corner) {
    double p[3];
    mcv_ground_point(ground, instance, corner->position, p);
    return mcv_defect_outline(ground->defect, p);
}

/* The point of the edge where the outline's function is 0, found by halving the edge until doubles
 * have no value between. The first end by order of position is the start. */
static mcv_corner crossing(const mcv_ground *ground, uint32_t instance, const mcv_corner *a,
                           const mcv_corner *b) {
    const bool forwards = mcv_corner_compare(a, b) < 0;
    const mcv_corner *start = forwards ? a : b, *end = forwards ? b : a;
    double p[3], q[3], low = 0, high = 1;
    mcv_ground_point(ground, instance, start->position, p);
    mcv_ground_point(ground, instance, end->position, q);
    const bool within = mcv_defect_outline(ground->defect, p) > 0;
    for (double t = 0.5; t > low && t < high; t = 0.5 * (low + high)) {
        double r[3];
        for (int i = 0; i < 3; ++i) r[i] = p[i] + t * (q[i] - p[i]);
        if ((mcv_defect_outline(ground->defect, r) > 0) == within)
            low = t;
        else
            high = t;
    }
    return mcv_corner_between(start, end, high);
}

/* The three parts of a facet whose corner `lone` lies on another side than the others: its tip, and
 * what remains as two. */
static void part(const mcv_ground *ground, const mcv_facet *facet, int lone, mcv_facet parts[3]) {
    const mcv_corner *a = &facet->corners[lone], *b = &facet->corners[(lone + 1) % 3],
                     *c = &facet->corners[(lone + 2) % 3];
    const mcv_corner ab = crossing(ground, facet->instance, a, b),
                     ac = crossing(ground, facet->instance, a, c);
    for (int i = 0; i < 3; ++i) {
        parts[i] = *facet;
        parts[i].within = i == 0 ? facet->within : !facet->within;
    }
    parts[0].corners[0] = *a;
    parts[0].corners[1] = parts[1].corners[0] = parts[2].corners[0] = ab;
    parts[0].corners[2] = parts[2].corners[2] = ac;
    parts[1].corners[1] = *b;
    parts[1].corners[2] = parts[2].corners[1] = *c;
    parts[0].fixed = 1 << 1 | 1 << 2;
    parts[1].fixed = 1 << 0;
    parts[2].fixed = 1 << 0 | 1 << 2;
}

static bool cut_facet(const mcv_ground *ground, mcv_facets *facets, size_t number) {
    mcv_facet facet = facets->items[number];
    bool within[3];
    int count = 0;
    for (int k = 0; k < 3; ++k) {
        within[k] = outline_at(ground, facet.instance, &facet.corners[k]) > 0;
        count += within[k];
    }
    facets->items[number].within = count == 3;
    if (count == 0 || count == 3) return true;
    int lone = 0;
    while (within[lone] != (count == 1)) ++lone;
    mcv_facet parts[3];
    facet.within = count == 1;
    part(ground, &facet, lone, parts);
    facets->items[number] = parts[0];
    return mcv_facets_add(facets, parts + 1) && mcv_facets_add(facets, parts + 2);
}

/* --- what is cut off --- */

/* Does the facet face the cut's plane, or for a ball the tangent plane, from above? Walls along the
 * normal may lean by the rounding of their vertices. */
static bool faces_up(const mcv_ground *ground, const mcv_facet *facet) {
    double p[3][3], longest = 0, largest = 0;
    for (int k = 0; k < 3; ++k) {
        mcv_ground_point(ground, facet->instance, facet->corners[k].position, p[k]);
        for (int i = 0; i < 3; ++i)
            largest = fmax(largest, fabs((double)facet->corners[k].position[i]));
    }
    for (int k = 0; k < 3; ++k) {
        const double *a = p[k], *b = p[(k + 1) % 3];
        longest = fmax(longest, hypot(hypot(b[0] - a[0], b[1] - a[1]), b[2] - a[2]));
    }
    const mcv_transform *t = &ground->scene->instances[facet->instance].to_world;
    const double sign = mcv_transform_determinant(t) < 0 ? -1 : 1;
    const double area = sign * ((p[1][0] - p[0][0]) * (p[2][1] - p[0][1]) -
                                (p[2][0] - p[0][0]) * (p[1][1] - p[0][1]));
    const double scale = cbrt(fabs(mcv_transform_determinant(t)));
    return area >= -8 * (double)FLT_EPSILON * scale * largest * longest;
}

mcv_result mcv_facets_cut(mcv_facets *facets, const mcv_ground *ground, const mcv_json_path *place,
                          mcv_error *error) {
    const bool cut = mcv_defect_kind_of(ground->defect->type) == MCV_KIND_CUT;
    const size_t count = facets->count;
    for (size_t f = 0; f < count; ++f)
        if (facets->items[f].inside && !cut_facet(ground, facets, f))
            return mcv_fail_memory(place, error);
    for (size_t f = 0; f < facets->count && cut; ++f)
        if (facets->items[f].within && !faces_up(ground, facets->items + f))
            return mcv_fail_at(place, error,
                               "the part overhangs where it is cut off: give another direction, or "
                               "cut less");
    return MCV_OK;
}
