/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The light tree: emitters in clusters that lie close together and shine the same way, so that a
 * surface chooses among many by what they may bring to it (kernels/light/tree.h). The split of a
 * cluster and the cone of directions follow Conty Estevez and Kulla, Importance Sampling of Many
 * Lights with Adaptive Tree Splitting, Proc. ACM CGIT 1(2), 2018; a cluster's extent is the sphere
 * around its box, which stands for it on the device as well.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "device/pack_steps.h"
#include "mcvisi/light_tree.h"
#include "scene/emitters.h"
#include "scene/geometry.h"
#include "scene/mesh.h"

enum { BINS = 16, LEVELS = 32, PLACES = 256 }; /* a level is a bit of mcv_device_emitter.trail */

/* The tree is used if choice by power has this many times the second moment. */
static const double WORTH = 2;

/* What is known of an emitter or a cluster. */
typedef struct light_bounds {
    double lower[3], upper[3]; /* re-centred; of emitters without a place: lower > upper */
    double axis[3];            /* unit */
    double spread;             /* largest angle of a normal to the axis */
    double widest;             /* largest angle of light to its normal */
    double power;
    double per_narrowest, per_widening; /* power over these */
} light_bounds;

typedef struct tree_builder {
    mcv_packed *packed;
    light_bounds *bounds; /* of each emitter */
    uint32_t *order;      /* emitters with power; those of a cluster lie side by side */
    uint32_t node_count;
} tree_builder;

static bool has_place(const light_bounds *b) { return b->lower[0] <= b->upper[0]; }

static double dot(const double a[3], const double b[3]) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static double angle_between(const double a[3], const double b[3]) {
    return acos(fmin(fmax(dot(a, b), -1), 1));
}

/* The narrowest cone around two cones of normals. */
static void join_cones(const light_bounds *a, const light_bounds *b, light_bounds *to) {
    const light_bounds *wide = a->spread >= b->spread ? a : b, *narrow = wide == a ? b : a;
    const double between = angle_between(wide->axis, narrow->axis),
                 spread = (wide->spread + between + narrow->spread) / 2;
    double across[3], axis[3], joint = fmin(fmax(wide->spread, spread), M_PI);
    memcpy(axis, wide->axis, sizeof axis);
    if (between + narrow->spread > wide->spread && joint < M_PI) {
        /* The axis turns towards the other one. */
        const double turn = spread - wide->spread, along = dot(narrow->axis, wide->axis);
        for (int k = 0; k < 3; ++k) across[k] = narrow->axis[k] - along * wide->axis[k];
        const double length = sqrt(dot(across, across));
        for (int k = 0; k < 3 && length > 0; ++k)
            axis[k] = cos(turn) * wide->axis[k] + sin(turn) / length * across[k];
        joint = length > 0 ? joint : M_PI; /* opposite directions */
    }
    to->widest = fmax(a->widest, b->widest);
    to->spread = joint;
    memcpy(to->axis, axis, sizeof axis);
}

/* Adds an emitter or a cluster to another one; one without power is empty. */
static void join(light_bounds *to, const light_bounds *b) {
    if (!(to->power > 0)) {
        *to = *b;
        return;
    }
    join_cones(to, b, to);
    for (int k = 0; k < 3; ++k) {
        to->lower[k] = fmin(to->lower[k], b->lower[k]);
        to->upper[k] = fmax(to->upper[k], b->upper[k]);
    }
    to->power += b->power;
    to->per_narrowest += b->per_narrowest;
    to->per_widening += b->per_widening;
}

static light_bounds bounds_of(const tree_builder *b, uint32_t first, uint32_t count) {
    light_bounds all = {0};
    for (uint32_t i = 0; i < count; ++i) join(&all, &b->bounds[b->order[first + i]]);
    return all;
}

/* The largest angle between the mean of a surface's normals, which becomes the axis, and one of
 * them. */
static double spread_of(const mcv_scene *scene, const mcv_emitter *from, double axis[3]) {
    const mcv_mesh *mesh = scene->meshes + scene->instances[from->instance].mesh;
    double face[3], sum[3] = {0, 0, 0}, spread = 0;
    /* Interpolated normals may turn a narrow cone anywhere. */
    if (mesh->normals && from->type != MCV_EMITTER_AREA) return M_PI;
    for (uint32_t t = 0; t < mesh->triangle_count; ++t) {
        mcv_scene_face_normal(scene, from->instance, t, face);
        for (int k = 0; k < 3; ++k) sum[k] += face[k];
    }
    const double length = sqrt(dot(sum, sum));
    if (!(length > 0)) return M_PI;
    for (int k = 0; k < 3; ++k) axis[k] = sum[k] / length;
    for (uint32_t t = 0; t < mesh->triangle_count; ++t) {
        mcv_scene_face_normal(scene, from->instance, t, face);
        const double size = sqrt(dot(face, face));
        for (int k = 0; k < 3 && size > 0; ++k) face[k] /= size;
        if (size > 0) spread = fmax(spread, angle_between(face, axis));
    }
    return spread;
}

/* The largest angle of light to an emitter's normals, with a margin for rounding. */
static double widest_angle(const mcv_emitter *from) {
    switch (from->type) {
    case MCV_EMITTER_PARALLEL:
    case MCV_EMITTER_TELECENTRIC_PROJECTOR:
        return fmin(mcv_emitter_half_angle(from) + 0.01, M_PI / 2);
    case MCV_EMITTER_COLLIMATED_BEAM:
        return 0.01;
    case MCV_EMITTER_SPOT:
        return fmin(from->as.spot.outerConeAngle + 0.01, M_PI / 2);
    default:
        return M_PI / 2;
    }
}

static light_bounds emitter_bounds(const mcv_scene *scene, const mcv_packed *packed,
                                   const mcv_emitter *from, const mcv_device_emitter *e) {
    light_bounds b = {.axis = {0, 0, 1},
                      .spread = M_PI,
                      .widest = widest_angle(from),
                      .power = (double)e->power,
                      .per_narrowest = (double)e->power / (double)e->narrowest,
                      .per_widening = (double)e->power / (double)e->widening};
    for (int k = 0; k < 3; ++k) {
        b.lower[k] = e->radius < 0 ? INFINITY : (double)e->middle[k];
        b.upper[k] = e->radius < 0 ? -INFINITY : (double)e->middle[k];
    }
    if (from->type == MCV_EMITTER_SPOT) {
        for (int k = 0; k < 3; ++k) b.axis[k] = (double)e->light.axis[k];
        b.spread = 0;
    }
    if (!mcv_emitter_has_surface(from->type)) return b;
    b.spread = spread_of(scene, from, b.axis);
    for (int k = 0; k < 3; ++k) {
        b.lower[k] = packed->boxes[from->instance].lower[k] - packed->centre[k];
        b.upper[k] = packed->boxes[from->instance].upper[k] - packed->centre[k];
    }
    return b;
}

static double squared_diagonal(const light_bounds *b) {
    double sum = 0;
    for (int k = 0; k < 3; ++k) sum += (b->upper[k] - b->lower[k]) * (b->upper[k] - b->lower[k]);
    return sum;
}

/* The solid angle of the directions that light may take, weighed by its cosine beyond the normals
 * (ibid., M_Ω). */
static double orientation(const light_bounds *b) {
    const double o = b->spread, w = fmin(o + b->widest, M_PI);
    return 2 * M_PI * (1 - cos(o)) +
           M_PI / 2 * (2 * w * sin(o) - cos(o - 2 * w) - 2 * o * sin(o) + cos(o));
}

static double cost_of(const light_bounds *b) {
    return b->power > 0 ? b->power * orientation(b) * squared_diagonal(b) : 0;
}

static double middle_of(const light_bounds *b, int axis) {
    return (b->lower[axis] + b->upper[axis]) / 2;
}

/* A plane between bins. */
typedef struct light_split {
    int axis;
    double origin, scale; /* bin = scale (middle - origin) */
    uint32_t bin;         /* the first one on the far side */
    double cost;
} light_split;

static uint32_t bin_of(const light_split *split, const light_bounds *b) {
    const double at = split->scale * (middle_of(b, split->axis) - split->origin);
    return (uint32_t)fmin(fmax(at, 0), BINS - 1);
}

/* Keeps the best plane across an axis if it is better than *best. */
static void try_axis(const tree_builder *b, uint32_t first, uint32_t count, int axis,
                     light_split *best) {
    light_bounds bins[BINS] = {{.power = 0}}, near = {0};
    double least = INFINITY, most = -INFINITY, far_cost[BINS] = {0};
    for (uint32_t i = first; i < first + count; ++i) {
        const double at = middle_of(&b->bounds[b->order[i]], axis);
        least = fmin(least, at);
        most = fmax(most, at);
    }
    light_split split = {.axis = axis, .origin = least, .scale = BINS / (most - least)};
    if (!(most > least) || !isfinite(split.scale)) return;
    for (uint32_t i = first; i < first + count; ++i) {
        const light_bounds *one = &b->bounds[b->order[i]];
        join(&bins[bin_of(&split, one)], one);
    }
    light_bounds far = {0};
    for (uint32_t k = BINS - 1; k > 0; --k) {
        if (bins[k].power > 0) join(&far, &bins[k]);
        far_cost[k] = cost_of(&far);
    }
    /* The outer bins are never empty. */
    for (split.bin = 1; split.bin < BINS; ++split.bin) {
        if (bins[split.bin - 1].power > 0) join(&near, &bins[split.bin - 1]);
        split.cost = cost_of(&near) + far_cost[split.bin];
        if (split.cost < best->cost) *best = split;
    }
}

/* Moves the emitters for which the test holds to the front; returns how many. */
static uint32_t partition(const tree_builder *b, uint32_t first, uint32_t count,
                          const light_split *split) {
    uint32_t near = 0;
    for (uint32_t i = 0; i < count; ++i) {
        uint32_t *order = b->order + first;
        const light_bounds *one = &b->bounds[order[i]];
        const bool is_near = split ? bin_of(split, one) < split->bin : has_place(one);
        if (!is_near) continue;
        const uint32_t moved = order[near];
        order[near++] = order[i];
        order[i] = moved;
    }
    return near;
}

/* Sorts a cluster into two; returns the size of the first. */
static uint32_t split_cluster(const tree_builder *b, uint32_t first, uint32_t count,
                              uint32_t level) {
    light_split best = {.cost = INFINITY};
    const uint32_t placed = partition(b, first, count, NULL);
    if (placed > 0 && placed < count) return placed;
    /* The rest of the levels is just enough for halves. */
    if (placed > 0 && (uint64_t)count <= (uint64_t)1 << (LEVELS - 2 - level))
        for (int axis = 0; axis < 3; ++axis) try_axis(b, first, count, axis, &best);
    return isfinite(best.cost) ? partition(b, first, count, &best) : count / 2;
}

static void write_node(const light_bounds *b, mcv_light_node *node) {
    node->radius = has_place(b) ? (float)(sqrt(squared_diagonal(b)) / 2) : -1;
    for (int k = 0; k < 3; ++k) {
        node->centre[k] = has_place(b) ? (float)middle_of(b, k) : 0;
        node->axis[k] = (float)b->axis[k];
    }
    node->cosine = (float)cos(b->spread);
    node->sine = (float)sin(b->spread);
    node->widest = (float)cos(b->widest);
    node->power = (float)b->power;
    node->narrowest = (float)(b->power / b->per_narrowest);
    node->widening = (float)(b->power / b->per_widening);
}

/* The nodes of a cluster, the uppermost of which is `at`. `trail`: which child holds it, a bit of
 * each level. */
static void build_cluster(tree_builder *b, uint32_t at, uint32_t first, uint32_t count,
                          uint32_t level, uint32_t trail) {
    const light_bounds all = bounds_of(b, first, count);
    mcv_light_node *node = &b->packed->light_tree[at];
    write_node(&all, node);
    node->emitter = MCV_NONE;
    if (level > b->packed->light_tree_depth) b->packed->light_tree_depth = level;
    if (count == 1) {
        node->emitter = b->order[first];
        b->packed->emitters[node->emitter].trail = trail;
        return;
    }
    const uint32_t near = split_cluster(b, first, count, level);
    node->child = b->node_count;
    b->node_count += 2;
    const uint32_t child = node->child;
    build_cluster(b, child, first, near, level + 1, trail);
    build_cluster(b, child + 1, first + near, count - near, level + 1, trail | 1u << level);
}

/* How much the second moment of the light at a receiver falls if it chooses by importance instead
 * of by power: adds both to the sums. */
static void add_moments(const mcv_packed *packed, mcv_vec3 receiver, mcv_vec3 normal,
                        double moments[2]) {
    double sum = 0, by_power = 0;
    for (uint32_t i = 0; i < packed->light_node_count; ++i) {
        const mcv_light_node *node = packed->light_tree + i;
        if (node->emitter == MCV_NONE) continue;
        const double importance = (double)mcv_cluster_importance(node, receiver, normal);
        sum += importance;
        by_power += importance * importance / (double)packed->emitters[node->emitter].probability;
    }
    moments[0] += by_power;
    moments[1] += sum * sum;
}

static void add_receiver(const mcv_scene *scene, const mcv_packed *packed, uint32_t instance,
                         uint32_t triangle, double moments[2]) {
    double corners[3][3], face[3], middle[3];
    mcv_scene_corners(scene, instance, triangle, corners);
    mcv_scene_face_normal(scene, instance, triangle, face);
    const double length = sqrt(dot(face, face));
    if (!(length > 0)) return;
    for (int k = 0; k < 3; ++k)
        middle[k] = (corners[0][k] + corners[1][k] + corners[2][k]) / 3 - packed->centre[k];
    for (int side = -1; side < 2; side += 2)
        add_moments(packed, mcv_vec((float)middle[0], (float)middle[1], (float)middle[2]),
                    mcv_vec((float)(side * face[0] / length), (float)(side * face[1] / length),
                            (float)(side * face[2] / length)),
                    moments);
}

/*
 * Whether the tree pays: its walk takes up to as long as all else in a small scene. Receivers are
 * the middles of triangles that do not shine, some PLACES of equal shares of the area, seen from
 * both sides; what hides the emitters from them is left out.
 */
static bool pays(const mcv_scene *scene, const mcv_packed *packed) {
    double area = 0, so_far = 0, moments[2] = {0, 0};
    for (int turn = 0; turn < 2; ++turn) {
        double next = 0.5 * area / PLACES;
        for (uint32_t i = 0; i < scene->instance_count; ++i) {
            const uint32_t count = scene->meshes[scene->instances[i].mesh].triangle_count;
            if (packed->instances[i].emitter != MCV_NONE) continue;
            for (uint32_t t = 0; t < count; ++t) {
                const double own = mcv_scene_triangle_area(scene, i, t);
                if (turn == 0) {
                    area += own;
                    continue;
                }
                so_far += own;
                if (so_far < next) continue;
                add_receiver(scene, packed, i, t, moments);
                while (next <= so_far) next += area / PLACES;
            }
        }
    }
    return moments[0] >= WORTH * moments[1];
}

mcv_result mcv_pack_light_tree(const mcv_scene *scene, mcv_packed *packed, mcv_error *error) {
    bool failed = false;
    tree_builder b = {.packed = packed, .node_count = 1};
    uint32_t shining = 0, number = 0;
    b.bounds = mcv_pack_allocate(packed->emitter_count, sizeof *b.bounds, &failed);
    b.order = mcv_pack_allocate(packed->emitter_count, sizeof *b.order, &failed);
    packed->light_tree =
        mcv_pack_allocate(2 * (size_t)packed->emitter_count, sizeof *packed->light_tree, &failed);
    for (uint32_t i = 0; !failed && i < scene->emitter_count; ++i) {
        const mcv_emitter *from = &scene->emitters[i];
        if (!mcv_is_sampled(from)) continue;
        b.bounds[number] = emitter_bounds(scene, packed, from, &packed->emitters[number]);
        if (packed->emitters[number].power > 0) b.order[shining++] = number;
        ++number;
    }
    if (!failed && shining > 0) build_cluster(&b, 0, 0, shining, 0, 0);
    packed->light_node_count = b.node_count;
    free(b.bounds);
    free(b.order);
    if (!failed && !pays(scene, packed)) {
        free(packed->light_tree);
        packed->light_tree = NULL;
        packed->light_node_count = packed->light_tree_depth = 0;
    }
    return failed ? mcv_fail(error, MCV_FAILED, "%s: no memory for the light tree", scene->path)
                  : MCV_OK;
}
