/* SPDX-License-Identifier: Apache-2.0 */
#include "analysis/setup.h"

#include "scene/sensors.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* --- emitters that light nothing -------------------------------------------------------------------------------- */

/* Has the mesh no thickness along an axis, and its normals (if any) no other component? */
static bool is_flat(const mcv_mesh *mesh) {
    for (int axis = 0; axis < 3; ++axis) {
        bool flat = true;
        for (size_t v = 0; v < mesh->vertex_count && flat; ++v) {
            flat = mesh->positions[3 * v + axis] == mesh->positions[axis];
            for (int k = 0; k < 3 && flat && mesh->normals; ++k) flat = k == axis || mesh->normals[3 * v + k] == 0;
        }
        if (flat) return true;
    }
    return false;
}

/* Not normalised; 0 for a degenerate triangle. */
static void face_normal(double corners[3][3], double normal[3]) {
    double a[3], b[3];
    for (int k = 0; k < 3; ++k) {
        a[k] = corners[1][k] - corners[0][k];
        b[k] = corners[2][k] - corners[0][k];
    }
    for (int k = 0; k < 3; ++k) normal[k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
}

static double dot(const double a[3], const double b[3]) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

/* The unit normal of a flat instance and a point on it. False where its triangles face both ways. */
static bool plane_of(const mcv_scene *scene, uint32_t instance, double normal[3], double point[3]) {
    const mcv_mesh *mesh = scene->meshes + scene->instances[instance].mesh;
    double total[3] = {0, 0, 0};
    for (int k = 0; k < 3; ++k) point[k] = 0;
    for (int pass = 0; pass < 2; ++pass)
        for (uint32_t t = 0; t < mesh->triangle_count; ++t) {
            double corners[3][3], face[3];
            mcv_scene_corners(scene, instance, t, corners);
            face_normal(corners, face);
            if (pass == 1 && dot(face, total) < 0) return false;
            for (int k = 0; k < 3 && pass == 0; ++k) total[k] += face[k];
            memcpy(point, corners[0], sizeof corners[0]);
        }
    const double length = sqrt(dot(total, total));
    for (int k = 0; k < 3; ++k) normal[k] = total[k] / length;
    return length > 0;
}

static double lens_radius(const mcv_sensor *sensor) {
    switch (sensor->type) {
    case MCV_SENSOR_THIN_LENS:
        return sensor->as.thin_lens.lensDiameter / 2;
    case MCV_SENSOR_TELECENTRIC:
        return sensor->as.telecentric.lensDiameter / 2;
    case MCV_SENSOR_LIGHT_FIELD:
        return sensor->as.light_field.lensDiameter * M_SQRT1_2; /* the square's corner */
    default:
        return 0;
    }
}

static double height_above(const double normal[3], const double point[3], const double p[3]) {
    return dot(normal, (const double[3]){p[0] - point[0], p[1] - point[1], p[2] - point[2]});
}

static bool lights_nothing(const mcv_scene *scene, const mcv_emitter *emitter) {
    double normal[3], point[3];
    if (emitter->instance == MCV_NONE) return false;
    if (!is_flat(scene->meshes + scene->instances[emitter->instance].mesh)) return false;
    if (!plane_of(scene, emitter->instance, normal, point)) return false;
    for (uint32_t i = 0; i < scene->sensor_count; ++i)
        if (height_above(normal, point, scene->sensors[i].to_world.m + 9) + lens_radius(scene->sensors + i) > 0) return false;
    for (uint32_t i = 0; i < scene->instance_count; ++i) {
        const mcv_mesh *mesh = scene->meshes + scene->instances[i].mesh;
        if (i == emitter->instance) continue;
        for (size_t v = 0; v < mesh->vertex_count; ++v) {
            const float *p = mesh->positions + 3 * v;
            double world[3];
            mcv_transform_point(&scene->instances[i].to_world, (const double[3]){p[0], p[1], p[2]}, world);
            if (height_above(normal, point, world) > 0) return false;
        }
    }
    return true;
}

/* --- parts of another unit -------------------------------------------------------------------------------------- */

/* A length as people read it. */
static const char *in_words(double metres, char text[32]) {
    const double size = fabs(metres);
    const char *unit = size >= 1 ? "m" : size >= 1e-3 ? "mm" : "um";
    snprintf(text, 32, "%.3g %s", metres * (size >= 1 ? 1 : size >= 1e-3 ? 1e3 : 1e6), unit);
    return text;
}

/* The longest side of the instance's box in the world. */
static double width_of(const mcv_scene *scene, uint32_t instance) {
    const mcv_mesh *mesh = scene->meshes + scene->instances[instance].mesh;
    double lower[3] = {INFINITY, INFINITY, INFINITY}, upper[3] = {-INFINITY, -INFINITY, -INFINITY};
    for (size_t v = 0; v < mesh->vertex_count; ++v) {
        const float *p = mesh->positions + 3 * v;
        double world[3];
        mcv_transform_point(&scene->instances[instance].to_world, (const double[3]){p[0], p[1], p[2]}, world);
        for (int k = 0; k < 3; ++k) {
            lower[k] = fmin(lower[k], world[k]);
            upper[k] = fmax(upper[k], world[k]);
        }
    }
    return fmax(upper[0] - lower[0], fmax(upper[1] - lower[1], upper[2] - lower[2]));
}

/* A floor may be this much wider than the field; millimetres read as metres make it a thousand. */
static const double too_wide = 100;

static mcv_result warn_of_units(mcv_scene *scene, mcv_error *error) {
    uint32_t widest = MCV_NONE;
    double width = 0;
    for (uint32_t i = 0; i < scene->instance_count; ++i) {
        if (scene->instances[i].emitter != MCV_NONE) continue;
        const double here = width_of(scene, i);
        if (here <= width) continue;
        width = here;
        widest = i;
    }
    if (widest == MCV_NONE) return MCV_OK;
    for (uint32_t i = 0; i < scene->sensor_count; ++i) {
        const mcv_sensor *sensor = scene->sensors + i;
        const mcv_optics optics = mcv_sensor_optics(sensor);
        const mcv_readout readout = mcv_sensor_readout(sensor);
        const double field = fmax(optics.field[0], optics.field[1]), pixel = readout.pitch[0] / fabs(optics.magnification);
        char part[32], seen[32];
        if (!isfinite(field)) continue;
        if (width > too_wide * field)
            MCV_TRY(mcv_scene_warn(scene, error, "node \"%s\" is %s wide in the %s wide field of sensor \"%s\": is its unit mm?",
                                   scene->instances[widest].name, in_words(width, part), in_words(field, seen), sensor->name));
        if (width < pixel)
            MCV_TRY(mcv_scene_warn(scene, error,
                                   "node \"%s\", the widest part, is %s wide, less than the %s that a pixel of sensor \"%s\" sees: is its "
                                   "unit too small?",
                                   scene->instances[widest].name, in_words(width, part), in_words(pixel, seen), sensor->name));
    }
    return MCV_OK;
}

/* --- open bodies ------------------------------------------------------------------------------------------------ */

static bool is_dielectric(const mcv_scene *scene, uint32_t instance) {
    return scene->materials[scene->instances[instance].material].type == MCV_MATERIAL_DIELECTRIC;
}

/* The primitives of a node stand one after the other, with one name and one place. */
static bool same_node(const mcv_instance *a, const mcv_instance *b) {
    return strcmp(a->name, b->name) == 0 && memcmp(&a->to_world, &b->to_world, sizeof a->to_world) == 0;
}

static mcv_result warn_of_open_bodies(mcv_scene *scene, mcv_error *error) {
    for (uint32_t first = 0, last; first < scene->instance_count; first = last) {
        bool dielectric = false;
        for (last = first; last < scene->instance_count && same_node(scene->instances + first, scene->instances + last); ++last)
            dielectric = dielectric || is_dielectric(scene, last);
        if (!dielectric) continue;
        uint32_t edges;
        MCV_TRY(mcv_open_edges(scene, first, last, &edges, error));
        if (edges > 0)
            MCV_TRY(mcv_scene_warn(scene, error,
                                   "node \"%s\": its mesh is open at %u edges, but its material fills a volume: close it, or use a sheet",
                                   scene->instances[first].name, edges));
    }
    return MCV_OK;
}

mcv_result mcv_setup_warn(mcv_scene *scene, mcv_error *error) {
    for (uint32_t i = 0; i < scene->emitter_count; ++i)
        if (lights_nothing(scene, scene->emitters + i))
            MCV_TRY(mcv_scene_warn(scene, error, "emitter \"%s\" lights nothing: no part and no sensor lies before its front (-z): turn it",
                                   scene->emitters[i].name));
    MCV_TRY(warn_of_open_bodies(scene, error));
    return warn_of_units(scene, error);
}
