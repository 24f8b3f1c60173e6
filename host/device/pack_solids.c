/* SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <stdlib.h>

#include "device/pack.h"
#include "scene/solid.h"

/* The first solid that has this cap. */
static uint32_t surface_of(const mcv_solid *solids, uint32_t solid, uint32_t piece) {
    return piece == MCV_PIECE_FIRST_CAP && solids[solid].cemented
               ? 4 * (solid - 1) + MCV_PIECE_SECOND_CAP
               : 4 * solid + piece;
}

static mcv_device_cap pack_cap(const mcv_cap *cap, double middle, double radius, uint32_t surface) {
    mcv_device_cap to = {.z = (float)(cap->z - middle),
                         .curvature = (float)cap->curvature,
                         .conic = (float)cap->conic,
                         .across = cap->cylindrical ? 0.0f : 1.0f,
                         .scale = (float)(1 / (radius * radius)),
                         .surface = surface};
    for (uint32_t i = 0; i < MCV_ASPHERE_TERMS; ++i) {
        to.term[i] = (float)(cap->asphere[i] * pow(radius, 2 * i + 4));
        if (to.term[i] != 0) to.terms = i + 1;
    }
    if (to.terms > 0) to.bend = (float)mcv_cap_bend(cap, radius);
    return to;
}

/* The lens that a solid belongs to: solids first … end - 1, in a row with one frame. */
typedef struct group {
    uint32_t first, end;
    double middle; /* along the axis, about which its solids are placed */
    double bound;  /* the radius of its ball */
} group;

static void extend(const mcv_solid *solid, double lower[3], double upper[3]) {
    float corners[24];
    mcv_solid_box(solid, corners);
    for (int i = 0; i < 24; ++i) {
        lower[i % 3] = fmin(lower[i % 3], corners[i]);
        upper[i % 3] = fmax(upper[i % 3], corners[i]);
    }
}

/* Makes *g the group of solid i. To be called for all solids in order, starting with a group of
 * zeros. */
static void enter_group(const mcv_scene *scene, uint32_t i, group *g) {
    double lower[3] = {INFINITY, INFINITY, INFINITY}, upper[3] = {-INFINITY, -INFINITY, -INFINITY};
    if (i < g->end) return;
    g->first = i;
    for (; i < scene->solid_count; ++i) {
        if (memcmp(&scene->solids[i].to_world, &scene->solids[g->first].to_world,
                   sizeof(mcv_transform)) != 0)
            break;
        extend(scene->solids + i, lower, upper);
    }
    g->end = i;
    g->middle = (lower[2] + upper[2]) / 2;
    g->bound = hypot(hypot(upper[0], upper[1]), upper[2] - g->middle) * (1 + 1e-6);
}

/* Conics are convex on their outer side, for any conic constant. */
static bool is_convex(const mcv_solid *solid) {
    for (int k = 0; k < 2; ++k) {
        if (solid->caps[k].curvature * (k ? 1 : -1) > 0) return false;
        for (int i = 0; i < MCV_ASPHERE_TERMS; ++i)
            if (solid->caps[k].asphere[i] != 0) return false;
    }
    return solid->side != MCV_SIDE_OPEN;
}

static double side_radius(const mcv_solid *solid) {
    return solid->side == MCV_SIDE_BOX ? hypot(solid->half[0], solid->half[1]) : solid->radius;
}

void mcv_pack_solids(const mcv_scene *scene, mcv_packed *packed) {
    group g = {0};
    for (uint32_t i = 0; i < scene->solid_count; ++i) {
        const mcv_solid *from = scene->solids + i;
        const double *m = from->to_world.m;
        mcv_device_solid *to = packed->solids + i;
        enter_group(scene, i, &g);
        *to = (mcv_device_solid){.bound = (float)g.bound,
                                 .radius = (float)from->radius,
                                 .extent = {(float)from->half[0], (float)from->half[1]},
                                 .hole = (float)from->hole,
                                 .side = from->side,
                                 .group = g.first,
                                 .convex = is_convex(from)};
        for (int k = 0; k < 3; ++k) {
            to->origin[k] = (float)(m[9 + k] + m[3 * k + 2] * g.middle - packed->centre[k]);
            for (int axis = 0; axis < 3; ++axis) to->axes[3 * axis + k] = (float)m[3 * k + axis];
            to->instance[k] = from->instances[k];
        }
        for (uint32_t k = 0; k < 2; ++k)
            to->cap[k] = pack_cap(from->caps + k, g.middle, side_radius(from),
                                  surface_of(scene->solids, i, k));
    }
}

void mcv_pack_precise_solids(const mcv_scene *scene, mcv_packed *packed) {
    group g = {0};
    for (uint32_t i = 0; i < scene->solid_count; ++i) {
        const mcv_solid *from = scene->solids + i;
        const double *m = from->to_world.m, radius = side_radius(from);
        mcv_precise_solid *to = packed->precise_solids + i;
        enter_group(scene, i, &g);
        *to = (mcv_precise_solid){.radius = from->radius, .extent = {from->half[0], from->half[1]}};
        for (int k = 0; k < 3; ++k) {
            to->origin[k] = m[9 + k] - packed->centre[k] + m[3 * k + 2] * g.middle;
            for (int axis = 0; axis < 3; ++axis) to->axes[3 * axis + k] = m[3 * k + axis];
        }
        for (int k = 0; k < 2; ++k) {
            const mcv_cap *cap = from->caps + k;
            to->cap[k] = (mcv_precise_cap){
                cap->z - g.middle, cap->curvature, cap->conic, 1 / (radius * radius), {0}};
            for (uint32_t j = 0; j < MCV_ASPHERE_TERMS; ++j)
                to->cap[k].term[j] = cap->asphere[j] * pow(radius, 2 * j + 4);
        }
    }
}
