/* SPDX-License-Identifier: Apache-2.0 */
/* Halves the edges of triangles near a defect until they are short enough (facets.h). */
#include "defects/facets.h"

#include "scene/memory.h"
#include "scene/transform.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

bool mcv_facets_add(mcv_facets *facets, const mcv_facet *facet) {
    if (facets->count == facets->room) {
        const size_t room = facets->room ? 2 * facets->room : 256;
        mcv_facet *larger = realloc(facets->items, room * sizeof *larger);
        if (!larger) return false;
        facets->items = larger;
        facets->room = room;
    }
    facets->items[facets->count++] = *facet;
    return true;
}

void mcv_ground_point(const mcv_ground *ground, uint32_t instance, const float position[3],
                      double local[3]) {
    const mcv_defect *d = ground->defect;
    double world[3];
    mcv_transform_point(&ground->scene->instances[instance].to_world,
                        (const double[3]){position[0], position[1], position[2]}, world);
    for (int k = 0; k < 3; ++k) {
        local[k] = 0;
        for (int i = 0; i < 3; ++i) local[k] += (world[i] - d->centre[i]) * d->axes[k][i];
    }
}

/* --- distances in the tangent plane --- */

static double to_segment(const double p[2], const double a[2], const double b[2]) {
    const double e[2] = {b[0] - a[0], b[1] - a[1]}, from[2] = {p[0] - a[0], p[1] - a[1]};
    const double squared = e[0] * e[0] + e[1] * e[1];
    double t = squared > 0 ? (from[0] * e[0] + from[1] * e[1]) / squared : 0;
    t = fmin(1, fmax(0, t));
    return hypot(from[0] - t * e[0], from[1] - t * e[1]);
}

/* On which side of the line through a and b lies p? */
static double side_of(const double a[2], const double b[2], const double p[2]) {
    return (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]);
}

double mcv_ground_edge_distance(const mcv_ground *ground, const double a[3], const double b[3]) {
    const double half = ground->footprint.half_length, p[2] = {-half, 0}, q[2] = {half, 0};
    if (side_of(a, b, p) * side_of(a, b, q) < 0 && side_of(p, q, a) * side_of(p, q, b) < 0)
        return 0;
    return fmin(fmin(to_segment(p, a, b), to_segment(q, a, b)),
                fmin(to_segment(a, p, q), to_segment(b, p, q)));
}

double mcv_ground_triangle_distance(const mcv_ground *ground, const double c[3][3]) {
    const double p[2] = {-ground->footprint.half_length, 0};
    const double sides[3] = {side_of(c[0], c[1], p), side_of(c[1], c[2], p),
                             side_of(c[2], c[0], p)};
    if ((sides[0] > 0 && sides[1] > 0 && sides[2] > 0) ||
        (sides[0] < 0 && sides[1] < 0 && sides[2] < 0))
        return 0;
    return fmin(mcv_ground_edge_distance(ground, c[0], c[1]),
                fmin(mcv_ground_edge_distance(ground, c[1], c[2]),
                     mcv_ground_edge_distance(ground, c[2], c[0])));
}

bool mcv_ground_is_far(const mcv_ground *ground, const double p[3], double reach, double beyond) {
    const mcv_footprint *f = &ground->footprint;
    const double least = f->half_length + f->fine + f->radius + reach + beyond;
    return p[0] * p[0] + p[1] * p[1] > least * least;
}

/* --- halving --- */

static int compare_positions(const float a[3], const float b[3]) {
    for (int i = 0; i < 3; ++i)
        if (a[i] != b[i]) return a[i] < b[i] ? -1 : 1;
    return 0;
}

static void mix(const float *a, const float *b, double t, int count, float *between) {
    for (int i = 0; i < count; ++i) between[i] = (float)((1 - t) * a[i] + t * b[i]);
}

bool mcv_ground_splits(const mcv_ground *ground, uint32_t instance, const mcv_corner *a,
                       const mcv_corner *b) {
    const mcv_footprint *f = &ground->footprint;
    const int order = compare_positions(a->position, b->position);
    double p[3], q[3];
    float middle[3];
    mix(a->position, b->position, 0.5, 3, middle);
    if (compare_positions(middle, a->position) == 0 || compare_positions(middle, b->position) == 0)
        return false;
    /* In one order, so that rounding is the same on both sides. */
    mcv_ground_point(ground, instance, (order < 0 ? a : b)->position, p);
    mcv_ground_point(ground, instance, (order < 0 ? b : a)->position, q);
    if (fmin(p[2], q[2]) > ground->high || fmax(p[2], q[2]) < ground->low) return false;
    const double u = fabs(q[0] - p[0]), v = fabs(q[1] - p[1]), most = u + v + fabs(q[2] - p[2]);
    if (mcv_ground_is_far(ground, p, u + v, most / MCV_GRADING)) return false;
    const double length = hypot(hypot((q[0] - p[0]) / f->stretch, q[1] - p[1]), q[2] - p[2]);
    if (length <= f->edge) return false;
    const double beyond = fmax(0, mcv_ground_edge_distance(ground, p, q) - f->fine);
    return length > f->edge + MCV_GRADING * beyond;
}

int mcv_corner_compare(const mcv_corner *a, const mcv_corner *b) {
    return compare_positions(a->position, b->position);
}

static void mix_directions(const float a[3], const float b[3], double t, float between[3]) {
    double way[3];
    for (int i = 0; i < 3; ++i) way[i] = (1 - t) * a[i] + t * b[i];
    if (!mcv_normalize3(way, way))
        for (int i = 0; i < 3; ++i) way[i] = a[i];
    for (int i = 0; i < 3; ++i) between[i] = (float)way[i];
}

mcv_corner mcv_corner_between(const mcv_corner *a, const mcv_corner *b, double t) {
    mcv_corner m;
    mix(a->position, b->position, t, 3, m.position);
    mix_directions(a->normal, b->normal, t, m.normal);
    mix_directions(a->tangent, b->tangent, t, m.tangent);
    m.tangent[3] = a->tangent[3];
    mix(a->texcoord, b->texcoord, t, 2, m.texcoord);
    mix(a->texcoord1, b->texcoord1, t, 2, m.texcoord1);
    return m;
}

static mcv_facet facet_of(const mcv_facet *like, const mcv_corner *a, const mcv_corner *b,
                          const mcv_corner *c) {
    return (mcv_facet){.corners = {*a, *b, *c}, .instance = like->instance, .inside = like->inside};
}

static double squared_length(const mcv_corner *a, const mcv_corner *b) {
    double sum = 0;
    for (int i = 0; i < 3; ++i) {
        const double e = (double)a->position[i] - b->position[i];
        sum += e * e;
    }
    return sum;
}

/* The parts of a facet whose edges k to k + 1 are halved where `halved` says so. Their number. */
static int split(const mcv_facet *facet, const bool halved[3], mcv_facet parts[4]) {
    const int count = halved[0] + halved[1] + halved[2];
    /* Turned, so that edge 0 is the only halved one, or edge 2 the only whole one. */
    int first = 0;
    for (int k = 0; k < 3; ++k)
        if ((count == 1 && halved[k]) || (count == 2 && !halved[(k + 2) % 3])) first = k;
    const mcv_corner *a = &facet->corners[first], *b = &facet->corners[(first + 1) % 3],
                     *c = &facet->corners[(first + 2) % 3];
    const mcv_corner ab = mcv_corner_between(a, b, 0.5), bc = mcv_corner_between(b, c, 0.5),
                     ca = mcv_corner_between(c, a, 0.5);
    if (count == 1) {
        parts[0] = facet_of(facet, a, &ab, c);
        parts[1] = facet_of(facet, &ab, b, c);
        return 2;
    }
    parts[0] = facet_of(facet, &ab, b, &bc);
    if (count == 2) {
        const bool across = squared_length(a, &bc) < squared_length(&ab, c);
        parts[1] = across ? facet_of(facet, a, &ab, &bc) : facet_of(facet, a, &ab, c);
        parts[2] = across ? facet_of(facet, a, &bc, c) : facet_of(facet, &ab, &bc, c);
        return 3;
    }
    parts[1] = facet_of(facet, a, &ab, &ca);
    parts[2] = facet_of(facet, &ca, &bc, c);
    parts[3] = facet_of(facet, &ab, &bc, &ca);
    return 4;
}

/* As many as one defect may take. */
enum { MOST_FACETS = 4000000 };

/* Bytes of a facet while meshes are made: its share of a list that doubles its room, three corners
 * with their places in a table, and its mesh. */
enum { FACET_BYTES = 2 * sizeof(mcv_facet) + 5 * sizeof(mcv_corner) };

static mcv_result check_count(size_t count, const mcv_memory *memory, const mcv_json_path *place,
                              mcv_error *error) {
    const uint64_t room = mcv_memory_left(memory) / FACET_BYTES;
    if (count > MOST_FACETS)
        return mcv_fail_at(place, error,
                           "would take more than %d triangles: make it shorter or wider",
                           MOST_FACETS);
    if (count > room)
        return mcv_fail_at(place, error,
                           "would take more than %llu triangles, for which the limit of %.4g MB "
                           "has no room: make it shorter or wider, or raise the limit by --memory",
                           (unsigned long long)room, 1e-6 * (double)memory->limit);
    return MCV_OK;
}

mcv_result mcv_facets_refine(mcv_facets *facets, const mcv_ground *ground, const mcv_facet *facet,
                             const mcv_json_path *place, mcv_error *error) {
    const mcv_memory *limits = &ground->scene->memory;
    mcv_facets left = {NULL, 0, 0};
    mcv_result result = MCV_OK;
    bool memory = mcv_facets_add(&left, facet);
    while (left.count > 0 && memory && result == MCV_OK) {
        const mcv_facet one = left.items[--left.count];
        bool halved[3];
        for (int k = 0; k < 3; ++k)
            halved[k] =
                mcv_ground_splits(ground, one.instance, &one.corners[k], &one.corners[(k + 1) % 3]);
        if (!halved[0] && !halved[1] && !halved[2]) {
            memory = mcv_facets_add(facets, &one);
            result = check_count(facets->count, limits, place, error);
            continue;
        }
        mcv_facet parts[4];
        const int count = split(&one, halved, parts);
        for (int i = 0; i < count; ++i) memory = memory && mcv_facets_add(&left, parts + i);
    }
    free(left.items);
    return memory ? result : mcv_fail_memory(place, error);
}
