/* SPDX-License-Identifier: Apache-2.0 */
/* Bounding balls of all specular and near-specular bodies. Light paths start towards them. */
#include "device/pack_steps.h"

#include <math.h>

#include "scene/solid.h"

/* A ball, re-centred. */
typedef struct ball {
    double centre[3], radius;
} ball;

/* Do light paths continue at this instance, because it is smooth or near-specular? */
static bool carries(const mcv_packed *packed, uint32_t instance) {
    const mcv_device_material *material = &packed->materials[packed->instances[instance].material];
    return material->near_specular ||
           (!material->scattering_sides && material->type != MCV_MATERIAL_ABSORBER);
}

/* The smallest one around two. */
static ball join(const ball *a, const ball *b) {
    double way[3], distance = 0;
    for (int k = 0; k < 3; ++k) {
        way[k] = b->centre[k] - a->centre[k];
        distance += way[k] * way[k];
    }
    distance = sqrt(distance);
    if (distance + b->radius <= a->radius) return *a;
    if (distance + a->radius <= b->radius) return *b;
    ball both = {.radius = (distance + a->radius + b->radius) / 2};
    for (int k = 0; k < 3; ++k)
        both.centre[k] = a->centre[k] + way[k] * (both.radius - a->radius) / distance;
    return both;
}

/* The growth of two balls' disks if one ball replaces them [m²/π]; 0 if they almost coincide. */
static double growth(const ball *a, const ball *b) {
    const double r = join(a, b).radius;
    return r * r - a->radius * a->radius - b->radius * b->radius;
}

/* Adds a ball to the list. Joins the two that grow least while this shrinks their area, or while
 * there are too many. */
static void add_ball(ball *balls, uint32_t *count, ball more) {
    balls[(*count)++] = more;
    while (*count > 1) {
        uint32_t a = 0, b = 1;
        for (uint32_t i = 0; i < *count; ++i)
            for (uint32_t j = i + 1; j < *count; ++j)
                if (growth(balls + i, balls + j) < growth(balls + a, balls + b)) a = i, b = j;
        if (*count <= MCV_MAX_BALLS && growth(balls + a, balls + b) > 0) return;
        balls[a] = join(balls + a, balls + b);
        balls[b] = balls[--*count];
    }
}

/* About the middle of the instance's box. */
static ball ball_of_mesh(const mcv_packed *packed, uint32_t instance, uint32_t triangle_count) {
    ball b = {.radius = 0};
    const mcv_box3d *box = packed->boxes + instance;
    for (int k = 0; k < 3; ++k)
        b.centre[k] = 0.5 * (box->lower[k] + box->upper[k]) - packed->centre[k];
    const uint32_t *corners =
        packed->triangles + 4 * (size_t)packed->instances[instance].first_triangle;
    for (size_t i = 0; i < 4 * (size_t)triangle_count; ++i) {
        const float *p = packed->positions + 3 * (size_t)corners[i];
        double squared = 0;
        if (i % 4 == 3) continue;
        for (int k = 0; k < 3; ++k)
            squared += ((double)p[k] - b.centre[k]) * ((double)p[k] - b.centre[k]);
        b.radius = fmax(b.radius, squared);
    }
    b.radius = sqrt(b.radius);
    return b;
}

static ball ball_of_solid(const mcv_packed *packed, const mcv_solid *solid) {
    float corners[24];
    const double *m = solid->to_world.m;
    ball b;
    mcv_solid_box(solid, corners);
    const double middle = 0.5 * ((double)corners[2] + (double)corners[23]),
                 height = (double)corners[23] - middle;
    const double across =
        solid->side == MCV_SIDE_BOX ? hypot(solid->half[0], solid->half[1]) : solid->radius;
    b.radius = solid->side == MCV_SIDE_SPHERE ? solid->radius : hypot(across, height);
    for (int k = 0; k < 3; ++k) b.centre[k] = m[9 + k] + m[3 * k + 2] * middle - packed->centre[k];
    return b;
}

void mcv_find_balls(const mcv_scene *scene, mcv_packed *packed) {
    ball balls[MCV_MAX_BALLS + 1];
    uint32_t count = 0;
    for (uint32_t i = 0; i < packed->instance_count; ++i) {
        const uint32_t triangles = scene->meshes[scene->instances[i].mesh].triangle_count;
        if (triangles > 0 && carries(packed, i))
            add_ball(balls, &count, ball_of_mesh(packed, i, triangles));
    }
    for (uint32_t i = 0; i < scene->solid_count; ++i) {
        bool any = false;
        for (int k = 0; k < 3; ++k) any = any || carries(packed, scene->solids[i].instances[k]);
        if (any) add_ball(balls, &count, ball_of_solid(packed, scene->solids + i));
    }
    for (uint32_t i = 0; i < count; ++i) {
        double size = balls[i].radius;
        for (int k = 0; k < 3; ++k) {
            size += fabs(balls[i].centre[k]);
            packed->balls[i].centre[k] = (float)balls[i].centre[k];
        }
        packed->balls[i].radius = (float)(balls[i].radius + size * 0x1p-22);
    }
    packed->ball_count = count;
}
