/* SPDX-License-Identifier: Apache-2.0 */
/* Makes the tree of boxes about the scene's triangles. */
#include "reference/geometry.h"

#include "reference/solids.h"
#include "scene/geometry.h"

#include <float.h>
#include <stdlib.h>

enum { BINS = 16, LEAF_SIZE = 4, SAH_DEPTH = 32 };

/* NaN does not occur, and a comparison is a tenth of the time of fmin. */
static double least(double a, double b) { return a < b ? a : b; }
static double most(double a, double b) { return a > b ? a : b; }

static ref_vec lower(ref_vec a, ref_vec b) {
    return (ref_vec){least(a.x, b.x), least(a.y, b.y), least(a.z, b.z)};
}

static ref_vec upper(ref_vec a, ref_vec b) {
    return (ref_vec){most(a.x, b.x), most(a.y, b.y), most(a.z, b.z)};
}

typedef struct bounds {
    ref_vec low, high;
} bounds;

/* A triangle to be placed in the tree. */
typedef struct item {
    bounds box;
    uint32_t triangle;
} item;

static const bounds nothing = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};

static bounds join(bounds a, bounds b) {
    return (bounds){lower(a.low, b.low), upper(a.high, b.high)};
}

static bounds triangle_bounds(const ref_triangle *t) {
    return (bounds){lower(t->corner[0], lower(t->corner[1], t->corner[2])),
                    upper(t->corner[0], upper(t->corner[1], t->corner[2]))};
}

static ref_vec centre(const item *i) { return ref_scale(0.5, ref_add(i->box.low, i->box.high)); }

static double half_area(bounds b) {
    const ref_vec d = ref_sub(b.high, b.low);
    return d.x >= 0 ? d.x * d.y + d.y * d.z + d.z * d.x : 0;
}

static int bin_of(const item *i, int axis, double low, double high) {
    const int bin = (int)(BINS * (ref_component(centre(i), axis) - low) / (high - low));
    return bin < 0 ? 0 : bin < BINS ? bin : BINS - 1;
}

/* The number of items left of the cheapest of the planes between the bins, which are put there; of
 * half the items where no plane divides the node. */
static uint32_t divide(item *items, uint32_t count, bounds centres, bool by_cost) {
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
        const int b = bin_of(&items[i], axis, low, high);
        box[b] = join(box[b], items[i].box);
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
        if (bin_of(&items[i], axis, low, high) < best) {
            ++i;
        } else {
            const item swap = items[i];
            items[i] = items[--end];
            items[end] = swap;
        }
    }
    return i == 0 || i == count ? count / 2 : i;
}

static void build(ref_geometry *geometry, item *items, uint32_t node, uint32_t *node_count,
                  uint32_t first, uint32_t count, int depth) {
    bounds all = nothing, centres = nothing;
    for (uint32_t i = first; i < first + count; ++i) {
        const ref_vec c = centre(&items[i]);
        all = join(all, items[i].box);
        centres = join(centres, (bounds){c, c});
    }
    geometry->nodes[node] = (ref_node){all.low, all.high, first, count};
    if (count <= LEAF_SIZE) return;
    const uint32_t left = divide(items + first, count, centres, depth < SAH_DEPTH);
    const uint32_t children = *node_count;
    *node_count += 2;
    geometry->nodes[node].first = children;
    geometry->nodes[node].count = 0;
    build(geometry, items, children, node_count, first, left, depth + 1);
    build(geometry, items, children + 1, node_count, first + left, count - left, depth + 1);
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

/* The triangles of an instance, behind `kept` others; returns how many there are then. */
static uint32_t gather(const mcv_scene *scene, uint32_t instance, ref_triangle *triangles,
                       item *items, uint32_t kept) {
    const uint32_t first = scene->instances[instance].first_triangle,
                   count = scene->meshes[scene->instances[instance].mesh].triangle_count;
    for (uint32_t local = 0; local < count; ++local) {
        double corners[3][3];
        mcv_scene_corners(scene, instance, local, corners);
        const ref_triangle t = {{ref_from(corners[0]), ref_from(corners[1]), ref_from(corners[2])},
                                instance,
                                first + local};
        const ref_vec normal =
            ref_cross(ref_sub(t.corner[1], t.corner[0]), ref_sub(t.corner[2], t.corner[0]));
        if (!(ref_length(normal) > 0)) continue; /* without area it has no side to meet */
        triangles[kept] = t;
        items[kept] = (item){triangle_bounds(&t), kept};
        ++kept;
    }
    return kept;
}

/* The trees, and the triangles in their order; `triangles` and `items` have room for all of them.
 */
static void plant(const mcv_scene *scene, ref_geometry *geometry, ref_triangle *triangles,
                  item *items) {
    uint32_t kept = 0, node_count = 1;
    for (int moving = 0; moving < 2; ++moving) {
        const uint32_t first = kept;
        for (uint32_t i = 0; i < scene->instance_count; ++i)
            if (scene->instances[i].moves == moving)
                kept = gather(scene, i, triangles, items, kept);
        if (moving && kept == first) break;
        if (moving) geometry->moving = node_count++;
        build(geometry, items, geometry->moving, &node_count, first, kept - first, 0);
    }
    for (uint32_t i = 0; i < kept; ++i) geometry->triangles[i] = triangles[items[i].triangle];
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
    ref_triangle *triangles = malloc(count * sizeof *triangles);
    item *items = malloc(count * sizeof *items);
    geometry->triangles = malloc(count * sizeof *geometry->triangles);
    geometry->nodes = malloc(2 * count * sizeof *geometry->nodes);
    const bool room = triangles && items && geometry->triangles && geometry->nodes;
    if (room) plant(scene, geometry, triangles, items);
    free(triangles);
    free(items);
    if (room) return MCV_OK;
    ref_geometry_free(geometry);
    return mcv_fail(
        error, MCV_FAILED,
        "reference renderer: no memory for the %zu triangles of %s; %.1f GB are needed", count,
        scene->path,
        1e-9 * (double)(count * (2 * sizeof *triangles + sizeof *items + 2 * sizeof(ref_node))));
}

void ref_geometry_free(ref_geometry *geometry) {
    free(geometry->triangles);
    free(geometry->nodes);
    free(geometry->pieces);
    *geometry = (ref_geometry){0};
}
