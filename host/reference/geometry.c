/* SPDX-License-Identifier: Apache-2.0 */
/* Rays against triangles, under the tree of boxes. */
#include "reference/geometry.h"

#include "reference/motion.h"
#include "reference/solids.h"
#include "scene/geometry.h"
#include "scene/materials.h"

#include <float.h>
#include <stdlib.h>

enum { STACK_SIZE = 96 };

/* A ray with its largest direction component on the axis `along`; the others are sheared to 0
 * (Woop, Benthin and Wald 2013). */
typedef struct ray {
    ref_vec origin, inverse; /* inverse: 1/direction per axis */
    int across[2], along;
    double shear[2], scale;
} ray;

static ray ray_new(ref_vec origin, ref_vec direction) {
    ray r = {.origin = origin, .inverse = {1 / direction.x, 1 / direction.y, 1 / direction.z}};
    const double x = fabs(direction.x), y = fabs(direction.y), z = fabs(direction.z);
    r.along = x >= y && x >= z ? 0 : y >= z ? 1 : 2;
    r.across[0] = (r.along + 1) % 3;
    r.across[1] = (r.along + 2) % 3;
    r.scale = 1 / ref_component(direction, r.along);
    for (int i = 0; i < 2; ++i)
        r.shear[i] = ref_component(direction, r.across[i]) / ref_component(direction, r.along);
    return r;
}

/*
 * The slab test. The far distance is widened by twice its rounding error, 2 γ(3) < 4 DBL_EPSILON
 * (Ize 2013). A 0 · ∞ compares false and leaves its slab out.
 */
static bool meets_box(const ray *r, const ref_node *node, double nearest, double *enter) {
    double near = 0, far = nearest;
    for (int axis = 0; axis < 3; ++axis) {
        const double inverse = ref_component(r->inverse, axis), o = ref_component(r->origin, axis);
        const double a = (ref_component(node->low, axis) - o) * inverse,
                     b = (ref_component(node->high, axis) - o) * inverse;
        const double t0 = signbit(inverse) ? b : a,
                     t1 = (signbit(inverse) ? a : b) * (1 + 4 * DBL_EPSILON);
        if (t0 > near) near = t0;
        if (t1 < far) far = t1;
    }
    *enter = near;
    return near <= far;
}

/* Also gives the side: front is true where the ray comes from the triangle's front. */
static bool meets_triangle(const ray *r, const ref_triangle *triangle, ref_hit *hit, bool *front) {
    double x[3], y[3], z[3], edge[3];
    for (int i = 0; i < 3; ++i) {
        const ref_vec v = ref_sub(triangle->corner[i], r->origin);
        z[i] = ref_component(v, r->along);
        x[i] = ref_component(v, r->across[0]) - r->shear[0] * z[i];
        y[i] = ref_component(v, r->across[1]) - r->shear[1] * z[i];
    }
    int positive = 0;
    for (int i = 0; i < 3; ++i) {
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        edge[i] = x[j] * y[k] - y[j] * x[k];
        /* A zero gets the sign it has where the ray is moved across by (ε, ε²), ε > 0 as small as
         * you like. */
        const double sign = edge[i] != 0 ? edge[i] : y[j] != y[k] ? y[j] - y[k] : x[k] - x[j];
        positive += sign > 0;
    }
    const double sum = edge[0] + edge[1] + edge[2];
    if ((positive != 0 && positive != 3) || sum == 0) return false;
    for (int i = 0; i < 3; ++i) hit->weights[i] = edge[i] / sum;
    hit->distance =
        (hit->weights[0] * z[0] + hit->weights[1] * z[1] + hit->weights[2] * z[2]) * r->scale;
    hit->triangle = triangle;
    /* Seen along the ray, corners that run counter-clockwise about +along face it. */
    *front = (sum > 0) != (r->scale > 0);
    return hit->distance > 0;
}

static bool is_among(const uint32_t *numbers, uint32_t count, uint32_t number) {
    for (uint32_t i = 0; i < count; ++i)
        if (numbers[i] == number) return true;
    return false;
}

/* With windings: counts every hit instead of keeping the closest. */
static bool traverse(const ref_geometry *geometry, uint32_t root, const ray *r,
                     const ref_skip *skip, ref_hit *closest, int *windings) {
    closest->distance = INFINITY;
    closest->triangle = NULL;
    if (!geometry->nodes) return false;
    struct {
        uint32_t node;
        double enter; /* where the ray enters its box */
    } stack[STACK_SIZE];
    int top = 0;
    if (meets_box(r, geometry->nodes + root, INFINITY, &stack[0].enter)) stack[top++].node = root;
    while (top > 0) {
        const ref_node *node = &geometry->nodes[stack[--top].node];
        if (stack[top].enter > closest->distance) continue;
        if (node->count == 0) {
            double near[2] = {INFINITY, INFINITY};
            bool met[2];
            for (int i = 0; i < 2; ++i)
                met[i] = meets_box(r, &geometry->nodes[node->first + (uint32_t)i],
                                   closest->distance, &near[i]);
            const uint32_t nearer = near[1] < near[0];
            for (uint32_t k = 0; k < 2; ++k) {
                const uint32_t child = k == 0 ? 1 - nearer : nearer;
                if (!met[child]) continue;
                stack[top].node = node->first + child;
                stack[top++].enter = near[child];
            }
            continue;
        }
        for (uint32_t i = node->first; i < node->first + node->count; ++i) {
            const ref_triangle *triangle = &geometry->triangles[i];
            ref_hit hit;
            bool front;
            if (is_among(skip->numbers, skip->count, triangle->number) ||
                !meets_triangle(r, triangle, &hit, &front))
                continue;
            if (windings) {
                windings[triangle->instance] += front ? -1 : 1;
            } else if (hit.distance < closest->distance ||
                       (hit.distance == closest->distance &&
                        (!closest->triangle || triangle->number < closest->triangle->number))) {
                *closest = hit;
            }
        }
    }
    return closest->triangle != NULL;
}

/* The ray starts on the first `begun` of the skipped ones, which the exact ones of which it may
 * meet again; it has passed the others. */
static bool next_hit(const ref_geometry *geometry, ref_vec origin, ref_vec direction,
                     const ref_skip *skip, uint32_t begun, ref_hit *hit) {
    const mcv_scene *scene = geometry->scene;
    const ray r = ray_new(origin, direction);
    traverse(geometry, 0, &r, skip, hit, NULL);
    if (geometry->moving > 0) {
        const mcv_node_motion *motion = &scene->part_motion;
        const ray rest = ray_new(ref_point_at_rest(motion, geometry->time, origin),
                                 ref_direction_at_rest(motion, geometry->time, direction));
        ref_hit moving;
        if (traverse(geometry, geometry->moving, &rest, skip, &moving, NULL) &&
            moving.distance < hit->distance)
            *hit = moving;
    }
    for (uint32_t i = 0; i < REF_PIECES * scene->solid_count; ++i) {
        const ref_triangle *piece = geometry->pieces + i;
        double distances[REF_MEETINGS];
        if (is_among(skip->numbers + begun, skip->count - begun, piece->number)) continue;
        const int n =
            ref_meet_piece(scene->solids + i / REF_PIECES, (int)(i % REF_PIECES), origin, direction,
                           is_among(skip->numbers, begun, piece->number), distances);
        for (int k = 0; k < n; ++k)
            if (distances[k] < hit->distance)
                *hit = (ref_hit){.distance = distances[k],
                                 .triangle = piece,
                                 .position = ref_add(origin, ref_scale(distances[k], direction))};
    }
    return hit->triangle != NULL;
}

bool ref_next_hit(const ref_geometry *geometry, ref_vec origin, ref_vec direction,
                  const ref_skip *skip, ref_hit *hit) {
    return next_hit(geometry, origin, direction, skip, skip->count, hit);
}

bool ref_closest_hit(const ref_geometry *geometry, ref_vec origin, ref_vec direction, uint32_t skip,
                     ref_hit *hit) {
    return ref_next_hit(geometry, origin, direction,
                        &(ref_skip){.count = skip != MCV_NONE, .numbers = {skip}}, hit);
}

static bool is_dielectric(const mcv_scene *scene, const ref_hit *hit) {
    return mcv_material_has_medium(
        scene->materials[scene->instances[hit->triangle->instance].material].type);
}

uint32_t ref_hits_together(const ref_geometry *geometry, ref_vec origin, ref_vec direction,
                           const ref_skip *skip, const ref_hit *hit, ref_hit hits[REF_SKIPS]) {
    uint32_t count = 1;
    ref_skip passed = *skip;
    hits[0] = *hit;
    if (!is_dielectric(geometry->scene, hit)) return 1;
    while (count < REF_SKIPS && passed.count < REF_SKIPS) {
        const ref_hit *last = hits + count - 1;
        const double slant = fabs(ref_dot(direction, ref_surface_at(geometry, last).geometric));
        ref_hit next;
        passed.numbers[passed.count++] = last->triangle->number;
        if (!next_hit(geometry, origin, direction, &passed, skip->count, &next) ||
            !is_dielectric(geometry->scene, &next))
            break;
        if ((next.distance - last->distance) * slant > geometry->touch) break;
        /* A body that is left again at once is a small one, not one in contact. */
        for (uint32_t i = 0; i < count; ++i)
            if (hits[i].triangle->instance == next.triangle->instance) return count;
        hits[count++] = next;
    }
    return count;
}

void ref_add_windings(const ref_geometry *geometry, ref_vec origin, ref_vec direction,
                      int *winding) {
    const ray r = ray_new(origin, direction);
    const ref_skip none = {0};
    ref_hit unused;
    traverse(geometry, 0, &r, &none, &unused, winding);
    if (geometry->moving > 0) traverse(geometry, geometry->moving, &r, &none, &unused, winding);
    for (uint32_t i = 0; i < geometry->scene->solid_count; ++i)
        if (ref_solid_holds(geometry->scene->solids + i, origin))
            ++winding[geometry->scene->solids[i].instances[0]];
}

static void move(const ref_geometry *geometry, ref_surface *surface) {
    const mcv_node_motion *motion = &geometry->scene->part_motion;
    ref_vec *const directions[3] = {&surface->geometric, &surface->normal, &surface->tangent};
    surface->position = ref_moved_point(motion, geometry->time, surface->position);
    for (int i = 0; i < 3; ++i)
        *directions[i] = ref_moved_direction(motion, geometry->time, *directions[i]);
}

ref_surface ref_surface_at(const ref_geometry *geometry, const ref_hit *hit) {
    const mcv_scene *scene = geometry->scene;
    const ref_triangle *triangle = hit->triangle;
    const mcv_instance *instance = &scene->instances[triangle->instance];
    const mcv_mesh *mesh = &scene->meshes[instance->mesh];
    const uint32_t local = triangle->number - instance->first_triangle;
    ref_surface surface = {.instance = triangle->instance, .number = triangle->number};
    if (triangle->number >= scene->triangle_count) {
        const uint32_t piece = triangle->number - scene->triangle_count;
        surface.position = hit->position;
        ref_on_piece(scene->solids + piece / REF_PIECES, (int)(piece % REF_PIECES),
                     &surface.position, &surface.normal);
        surface.geometric = surface.normal;
        return surface;
    }
    const ref_vec *corner = triangle->corner;
    surface.geometric =
        ref_unit(ref_cross(ref_sub(corner[1], corner[0]), ref_sub(corner[2], corner[0])));
    surface.normal = surface.geometric;
    double normals[3][3];
    uint32_t vertices[3];
    mcv_scene_triangle(scene, triangle->instance, local, vertices);
    if (mesh->normals) mcv_scene_vertex_normals(scene, triangle->instance, local, normals);
    ref_vec sum = {0, 0, 0};
    for (int i = 0; i < 3; ++i) {
        surface.position = ref_add(surface.position, ref_scale(hit->weights[i], corner[i]));
        if (mesh->normals) sum = ref_add(sum, ref_scale(hit->weights[i], ref_from(normals[i])));
        const float *const sets[2] = {mesh->texcoords, mesh->texcoords1};
        for (int k = 0; k < 4; ++k)
            if (sets[k / 2])
                surface.texcoord[k / 2][k % 2] +=
                    hit->weights[i] * sets[k / 2][2 * (size_t)vertices[i] + (size_t)(k % 2)];
    }
    if (ref_dot(sum, sum) > 0) surface.normal = ref_unit(sum);
    for (int i = 0; mesh->tangents && i < 3; ++i) {
        double tangent[4];
        mcv_scene_tangent(scene, triangle->instance, vertices[i], tangent);
        surface.tangent = ref_add(surface.tangent, ref_scale(hit->weights[i], ref_from(tangent)));
        if (i == 0) surface.hand = tangent[3];
    }
    surface.tangent = ref_sub(surface.tangent,
                              ref_scale(ref_dot(surface.tangent, surface.normal), surface.normal));
    if (ref_dot(surface.tangent, surface.tangent) > 0) surface.tangent = ref_unit(surface.tangent);
    if (instance->moves) move(geometry, &surface);
    return surface;
}
