/* SPDX-License-Identifier: Apache-2.0 */
/* Makes the tree of boxes about the scene's triangles. */
#include "reference/geometry.h"

#include "reference/solids.h"

#include <float.h>
#include <stdlib.h>

enum { BINS = 16, LEAF_SIZE = 4, SAH_DEPTH = 32 };

static ref_vec lower(ref_vec a, ref_vec b) {
    return (ref_vec){fmin(a.x, b.x), fmin(a.y, b.y), fmin(a.z, b.z)};
}

static ref_vec upper(ref_vec a, ref_vec b) {
    return (ref_vec){fmax(a.x, b.x), fmax(a.y, b.y), fmax(a.z, b.z)};
}

typedef struct bounds {
    ref_vec low, high;
} bounds;

static const bounds nothing = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};

static bounds join(bounds a, bounds b) {
    return (bounds){lower(a.low, b.low), upper(a.high, b.high)};
}

static bounds triangle_bounds(const ref_triangle *t) {
    return (bounds){lower(t->corner[0], lower(t->corner[1], t->corner[2])),
                    upper(t->corner[0], upper(t->corner[1], t->corner[2]))};
}

static ref_vec centre(const ref_triangle *t) {
    const bounds b = triangle_bounds(t);
    return ref_scale(0.5, ref_add(b.low, b.high));
}

static double half_area(bounds b) {
    const ref_vec d = ref_sub(b.high, b.low);
    return d.x >= 0 ? d.x * d.y + d.y * d.z + d.z * d.x : 0;
}

static int bin_of(const ref_triangle *t, int axis, double low, double high) {
    const int bin = (int)(BINS * (ref_component(centre(t), axis) - low) / (high - low));
    return bin < 0 ? 0 : bin < BINS ? bin : BINS - 1;
}

/* The number of triangles left of the cheapest of the planes between the bins, or 0 where none
 * divides the node. */
static uint32_t divide(ref_triangle *triangles, uint32_t count, bounds centres, bool by_cost) {
    const ref_vec extent = ref_sub(centres.high, centres.low);
    const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0
                     : extent.y >= extent.z                       ? 1
                                                                  : 2;
    const double low = ref_component(centres.low, axis), high = ref_component(centres.high, axis);
    if (!by_cost || !(high > low)) return count / 2; /* in the order they have: bounds the depth */

    bounds box[BINS];
    uint32_t number[BINS] = {0};
    for (int b = 0; b < BINS; ++b) box[b] = nothing;
    for (uint32_t i = 0; i < count; ++i) {
        const int b = bin_of(&triangles[i], axis, low, high);
        box[b] = join(box[b], triangle_bounds(&triangles[i]));
        ++number[b];
    }
    double right_cost[BINS];
    bounds right = nothing;
    uint32_t right_count = 0;
    for (int b = BINS - 1; b > 0; --b) {
        right = join(right, box[b]);
        right_count += number[b];
        right_cost[b] = right_count * half_area(right);
    }
    bounds left = nothing;
    uint32_t left_count = 0;
    int best = 1;
    double best_cost = INFINITY;
    for (int b = 1; b < BINS; ++b) {
        left = join(left, box[b - 1]);
        left_count += number[b - 1];
        const double cost = left_count * half_area(left) + right_cost[b];
        if (cost < best_cost) best_cost = cost, best = b;
    }
    uint32_t i = 0, end = count;
    while (i < end) {
        if (bin_of(&triangles[i], axis, low, high) < best) {
            ++i;
        } else {
            const ref_triangle swap = triangles[i];
            triangles[i] = triangles[--end];
            triangles[end] = swap;
        }
    }
    return i == 0 || i == count ? count / 2 : i;
}

static void build(ref_geometry *geometry, uint32_t node, uint32_t *node_count, uint32_t first,
                  uint32_t count, int depth) {
    bounds all = nothing, centres = nothing;
    for (uint32_t i = first; i < first + count; ++i) {
        const ref_vec c = centre(&geometry->triangles[i]);
        all = join(all, triangle_bounds(&geometry->triangles[i]));
        centres = join(centres, (bounds){c, c});
    }
    geometry->nodes[node] = (ref_node){all.low, all.high, first, count};
    if (count <= LEAF_SIZE) return;
    const uint32_t left = divide(geometry->triangles + first, count, centres, depth < SAH_DEPTH);
    const uint32_t children = *node_count;
    *node_count += 2;
    geometry->nodes[node].first = children;
    geometry->nodes[node].count = 0;
    build(geometry, children, node_count, first, left, depth + 1);
    build(geometry, children + 1, node_count, first + left, count - left, depth + 1);
}

/* The diagonal of the scene's box; exact bodies have the corners of theirs as vertices. */
static double diagonal(const mcv_scene *scene) {
    bounds all = nothing;
    for (uint32_t i = 0; i < scene->instance_count; ++i) {
        const mcv_mesh *mesh = &scene->meshes[scene->instances[i].mesh];
        for (uint32_t v = 0; v < mesh->vertex_count; ++v) {
            const double local[3] = {mesh->positions[3 * v], mesh->positions[3 * v + 1],
                                     mesh->positions[3 * v + 2]};
            double placed[3];
            mcv_transform_point(&scene->instances[i].to_world, local, placed);
            all = join(all, (bounds){ref_from(placed), ref_from(placed)});
        }
    }
    return all.low.x <= all.high.x ? ref_length(ref_sub(all.high, all.low)) : 0;
}

mcv_result ref_geometry_new(const mcv_scene *scene, ref_geometry *geometry, mcv_error *error) {
    *geometry = (ref_geometry){.scene = scene};
    const size_t count = scene->triangle_count;
    geometry->pieces =
        calloc(REF_PIECES * (size_t)scene->solid_count + 1, sizeof *geometry->pieces);
    if (!geometry->pieces)
        return mcv_fail(error, MCV_FAILED,
                        "reference renderer: no memory for the exact surfaces of %s", scene->path);
    for (uint32_t i = 0; i < REF_PIECES * scene->solid_count; ++i)
        geometry->pieces[i] =
            (ref_triangle){.instance = scene->solids[i / REF_PIECES].instances[i % REF_PIECES],
                           .number = scene->triangle_count + i};
    geometry->touch = FLT_EPSILON * 2 * diagonal(scene);
    if (count == 0) return MCV_OK;
    geometry->triangles = malloc(count * sizeof *geometry->triangles);
    geometry->nodes = malloc(2 * count * sizeof *geometry->nodes);
    if (!geometry->triangles || !geometry->nodes) {
        ref_geometry_free(geometry);
        return mcv_fail(
            error, MCV_FAILED,
            "reference renderer: no memory for the %zu triangles of %s; %.1f GB are needed", count,
            scene->path,
            1e-9 * (double)(count * (sizeof *geometry->triangles + 2 * sizeof *geometry->nodes)));
    }
    uint32_t number = 0, kept = 0;
    for (uint32_t i = 0; i < scene->instance_count; ++i) {
        for (uint32_t local = 0; local < scene->meshes[scene->instances[i].mesh].triangle_count;
             ++local, ++number) {
            double corners[3][3];
            mcv_scene_corners(scene, i, local, corners);
            const ref_triangle t = {
                {ref_from(corners[0]), ref_from(corners[1]), ref_from(corners[2])}, i, number};
            const ref_vec normal =
                ref_cross(ref_sub(t.corner[1], t.corner[0]), ref_sub(t.corner[2], t.corner[0]));
            if (ref_length(normal) > 0)
                geometry->triangles[kept++] = t; /* a triangle without area has no side to meet */
        }
    }
    uint32_t node_count = 1;
    build(geometry, 0, &node_count, 0, kept, 0);
    return MCV_OK;
}

void ref_geometry_free(ref_geometry *geometry) {
    free(geometry->triangles);
    free(geometry->nodes);
    free(geometry->pieces);
    *geometry = (ref_geometry){0};
}
