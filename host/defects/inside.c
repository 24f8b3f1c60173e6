/* SPDX-License-Identifier: Apache-2.0 */
/* Defects inside of bodies: bubbles, inclusions and striae as exact surfaces. */
#include "defects/facets.h"

#include "scene/geometry.h"
#include "scene/materials.h"
#include "scene/params.h"
#include "scene/solid.h"

#include <math.h>
#include <stdio.h>

/* --- the body around it --- */

/* Whether the ray from p along d crosses the triangle (Möller and Trumbore, 1997). */
static bool crosses(const double c[3][3], const double p[3], const double d[3]) {
    double e[2][3], from[3], across[3], side[3];
    for (int i = 0; i < 3; ++i) {
        e[0][i] = c[1][i] - c[0][i];
        e[1][i] = c[2][i] - c[0][i];
        from[i] = p[i] - c[0][i];
    }
    mcv_cross3(d, e[1], across);
    mcv_cross3(from, e[0], side);
    const double area = e[0][0] * across[0] + e[0][1] * across[1] + e[0][2] * across[2];
    if (area == 0) return false;
    const double u = (from[0] * across[0] + from[1] * across[1] + from[2] * across[2]) / area,
                 v = (d[0] * side[0] + d[1] * side[1] + d[2] * side[2]) / area,
                 t = (e[1][0] * side[0] + e[1][1] * side[1] + e[1][2] * side[2]) / area;
    return u >= 0 && v >= 0 && u + v <= 1 && t > 0;
}

/* Inside of the closed meshes of the instances: an odd number of crossings. The direction is askew
 * to whatever a designer draws. */
static bool mesh_holds(const mcv_scene *scene, const uint32_t instances[2], const double p[3]) {
    static const double askew[3] = {0.4853291, 0.6241097, 0.6123523};
    bool inside = false;
    for (uint32_t i = instances[0]; i < instances[1]; ++i)
        for (uint32_t t = 0; t < scene->meshes[scene->instances[i].mesh].triangle_count; ++t) {
            double c[3][3];
            mcv_scene_corners(scene, i, t, c);
            if (crosses((const double(*)[3])c, p, askew)) inside = !inside;
        }
    return inside;
}

static const mcv_solid *solid_at(const mcv_scene *scene, const uint32_t instances[2],
                                 const double p[3]) {
    for (uint32_t s = 0; s < scene->solid_count; ++s) {
        const uint32_t instance = scene->solids[s].instances[0];
        if (instance >= instances[0] && instance < instances[1] &&
            mcv_solid_holds(scene->solids + s, p))
            return scene->solids + s;
    }
    return NULL;
}

/* Does a ball of this radius about p lie inside the solid? Its 26 points to the sides, edges and
 * corners of a cube do. */
static bool solid_holds_ball(const mcv_solid *solid, const double p[3], double radius) {
    for (int k = 0; k < 27; ++k) {
        const int step[3] = {k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1};
        const double d[3] = {step[0], step[1], step[2]},
                     length = fmax(1, hypot(hypot(d[0], d[1]), d[2]));
        double q[3];
        for (int i = 0; i < 3; ++i) q[i] = p[i] + radius * d[i] / length;
        if (!mcv_solid_holds(solid, q)) return false;
    }
    return true;
}

/* --- the place --- */

/* The radius of the outermost surface. */
static double tube_radius(const mcv_defect *d, uint32_t tube) {
    const double s = d->size / 4, level = (tube + 0.5) / d->tubes;
    return s * sqrt(-2 * log(level));
}

double mcv_defect_outer_radius(const mcv_defect *d) {
    return d->type == MCV_DEFECT_STRIA ? tube_radius(d, 0) : d->size / 2;
}

/* A point of the axis; the middle for t = 0, the ends for ±1. */
static void axis_point(const mcv_defect *d, double t, double p[3]) {
    for (int i = 0; i < 3; ++i) p[i] = d->centre[i] + 0.5 * t * d->length * d->axes[2][i];
}

/* Does the body, a solid or closed meshes, hold a ball about p? */
static bool holds_ball(const mcv_scene *scene, const mcv_defect *d, const mcv_solid *solid,
                       const double p[3], double radius) {
    uint32_t instance;
    if (solid) return solid_holds_ball(solid, p, radius);
    return mcv_defect_distance(scene, d->instances, p, &instance) >= radius &&
           mesh_holds(scene, d->instances, p);
}

/* A ball as large as the disc's opening at points of its rim. */
static bool disc_fits(const mcv_scene *scene, const mcv_defect *d, const mcv_solid *solid) {
    enum { STEPS = 32 };
    for (int k = 0; k < STEPS; ++k) {
        const double angle = 2 * M_PI * k / STEPS, u = d->size / 2 * cos(angle),
                     v = d->size / 2 * sin(angle);
        double p[3];
        for (int i = 0; i < 3; ++i) p[i] = d->centre[i] + u * d->axes[0][i] + v * d->axes[1][i];
        if (!holds_ball(scene, d, solid, p, d->depth / 2)) return false;
    }
    return true;
}

static bool fits(const mcv_scene *scene, const mcv_defect *d, const mcv_solid *solid) {
    enum { STEPS = 8 };
    if (d->type == MCV_DEFECT_CRACK) return disc_fits(scene, d, solid);
    for (int k = -STEPS; k <= STEPS; ++k) {
        double p[3];
        axis_point(d, (double)k / STEPS, p);
        if (!holds_ball(scene, d, solid, p, mcv_defect_outer_radius(d))) return false;
        if (d->length == 0) return true;
    }
    return true;
}

/* z along the direction, by default along the node's x axis. */
static bool make_axes(const mcv_placement *node, const double direction[3], double axes[3][3]) {
    const bool given = direction[0] != 0 || direction[1] != 0 || direction[2] != 0;
    double world[3];
    mcv_transform_vector(&node->to_world, given ? direction : (const double[3]){1, 0, 0}, world);
    if (!mcv_normalize3(world, axes[2])) return false;
    int least = 0;
    for (int i = 1; i < 3; ++i)
        if (fabs(axes[2][i]) < fabs(axes[2][least])) least = i;
    const double other[3] = {least == 0, least == 1, least == 2};
    mcv_cross3(other, axes[2], axes[0]);
    mcv_normalize3(axes[0], axes[0]);
    mcv_cross3(axes[2], axes[0], axes[1]);
    return true;
}

mcv_result mcv_defect_locate_inside(const mcv_scene *scene, const mcv_defect_site *site,
                                    mcv_defect *defect, const mcv_json_path *place,
                                    mcv_error *error) {
    const mcv_placement *node = site->found;
    const mcv_json_path here = mcv_json_path_key(place, "at"),
                        direction = mcv_json_path_key(place, "direction");
    uint32_t instance = 0;
    if (!node) MCV_TRY(mcv_defect_node(scene, site->node, &node, place, error));
    if (!site->by_point)
        return mcv_fail_at(place, error, "lies inside of its body: must have a point \"at\"");
    memcpy(defect->instances, node->instances, sizeof defect->instances);
    mcv_transform_point(&node->to_world, site->at, defect->centre);
    if (!make_axes(node, site->direction, defect->axes))
        return mcv_fail_at(&direction, error, "must be a direction");
    const mcv_solid *solid = solid_at(scene, node->instances, defect->centre);
    if (!solid && !mesh_holds(scene, node->instances, defect->centre))
        return mcv_fail_at(&here, error, "does not lie inside of node \"%s\"", site->node);
    if (!fits(scene, defect, solid))
        return mcv_fail_at(&here, error,
                           "lies so near to the surface of node \"%s\" that the defect reaches "
                           "out of it",
                           site->node);
    if (!solid) mcv_defect_distance(scene, node->instances, defect->centre, &instance);
    defect->host = scene->instances[solid ? solid->instances[0] : instance].material;
    if (mcv_material_has_medium(scene->materials[defect->host].type)) return MCV_OK;
    return mcv_fail_at(place, error, "node \"%s\" is of \"%s\": must be of a dielectric",
                       site->node, scene->materials[defect->host].name);
}

/* --- its surfaces --- */

/* A dielectric inside of the host: where both overlap, it fills the space. */
static mcv_result add_medium(mcv_scene *scene, const mcv_defect *d, const double ior[3],
                             double above, mcv_error *error) {
    mcv_material material = {.name = d->name, .type = MCV_MATERIAL_DIELECTRIC, .texture = MCV_NONE};
    const mcv_medium_params *host = &scene->materials[d->host].as.medium;
    mcv_params_set_defaults(mcv_material_table(material.type), &material.as);
    memcpy(material.as.dielectric.ior, ior, sizeof material.as.dielectric.ior);
    if (d->type == MCV_DEFECT_STRIA)
        memcpy(material.as.dielectric.absorption, host->absorption, sizeof host->absorption);
    material.as.dielectric.priority = host->priority + above;
    return mcv_scene_add_material(scene, &material, error);
}

/* An inclusion of glass must have precedence over what it lies in. */
static mcv_result add_inclusion(mcv_scene *scene, const mcv_defect *d, uint32_t *material,
                                mcv_error *error) {
    const mcv_medium_params *host = &scene->materials[d->host].as.medium;
    const mcv_material *given = scene->materials + d->material;
    *material = d->material;
    if (!mcv_material_has_medium(given->type) || given->as.medium.priority > host->priority)
        return MCV_OK;
    double ior[3];
    memcpy(ior, given->as.medium.ior, sizeof ior);
    MCV_TRY(add_medium(scene, d, ior, 1, error));
    *material = scene->material_count - 1;
    memcpy(scene->materials[*material].as.medium.absorption,
           scene->materials[d->material].as.medium.absorption, sizeof ior);
    return MCV_OK;
}

static mcv_result add_ball(mcv_scene *scene, const mcv_defect *d, mcv_error *error) {
    mcv_solid ball = {
        .side = MCV_SIDE_SPHERE, .radius = d->size / 2, .to_world = mcv_transform_identity()};
    uint32_t material = MCV_NONE;
    memcpy(ball.to_world.m + 9, d->centre, sizeof d->centre);
    if (d->type == MCV_DEFECT_INCLUSION) {
        MCV_TRY(add_inclusion(scene, d, &material, error));
    } else {
        const double ior[3] = {d->index, d->index, d->index};
        MCV_TRY(add_medium(scene, d, ior, 1, error));
        material = scene->material_count - 1;
    }
    return mcv_scene_add_solid(scene, &ball, d->name, material, material, error);
}

/* A cylinder along the defect's axis, of a dielectric of its own. */
static mcv_result add_cylinder(mcv_scene *scene, const mcv_defect *d, double radius, double length,
                               const double ior[3], double above, mcv_error *error) {
    mcv_solid tube = {.side = MCV_SIDE_CYLINDER,
                      .radius = radius,
                      .caps = {{.z = -length / 2}, {.z = length / 2}}};
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) tube.to_world.m[3 * i + j] = d->axes[j][i];
        tube.to_world.m[9 + i] = d->centre[i];
    }
    MCV_TRY(add_medium(scene, d, ior, above, error));
    const uint32_t material = scene->material_count - 1;
    return mcv_scene_add_solid(scene, &tube, d->name, material, material, error);
}

/* Tube k of K, the outermost first: the host's index and (k + 1)/K of the step. */
static mcv_result add_tube(mcv_scene *scene, const mcv_defect *d, uint32_t k, mcv_error *error) {
    double ior[3];
    for (int i = 0; i < 3; ++i)
        ior[i] = scene->materials[d->host].as.medium.ior[i] + d->index * (k + 1) / d->tubes;
    return add_cylinder(scene, d, tube_radius(d, k), d->length, ior, k + 1, error);
}

uint32_t mcv_defect_bodies(const mcv_defect *defect) {
    if (!mcv_defect_is_inside(defect->type)) return 0;
    return defect->type == MCV_DEFECT_STRIA ? defect->tubes : 1;
}

mcv_result mcv_defect_embed(mcv_scene *scene, const mcv_defect *defect, mcv_error *error) {
    const double gas[3] = {defect->index, defect->index, defect->index};
    if (defect->type == MCV_DEFECT_CRACK)
        return add_cylinder(scene, defect, defect->size / 2, defect->depth, gas, 1, error);
    if (defect->type != MCV_DEFECT_STRIA) return add_ball(scene, defect, error);
    for (uint32_t k = 0; k < defect->tubes; ++k) MCV_TRY(add_tube(scene, defect, k, error));
    return MCV_OK;
}
