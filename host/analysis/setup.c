/* SPDX-License-Identifier: Apache-2.0 */
#include "analysis/setup.h"

#include "scene/emitters.h"
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
            mcv_scene_face_normal(scene, instance, t, face);
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

/* What lies before a disk within `tangent` of its edge, per depth: what a light can reach, or a sensor see, at the very most. */
typedef struct beam {
    double centre[3], axis[3]; /* unit */
    double radius, tangent;
} beam;

/* Does any of a ball lie in the beam? Close to its edge the answer may be yes for no. */
static bool meets_ball(const beam *b, const double centre[3], double radius) {
    const double from[3] = {centre[0] - b->centre[0], centre[1] - b->centre[1], centre[2] - b->centre[2]};
    const double depth = dot(from, b->axis), aside = sqrt(fmax(dot(from, from) - depth * depth, 0));
    if (depth + radius <= 0) return false;
    return !isfinite(b->tangent) || aside - b->radius - b->tangent * depth <= radius * hypot(1, b->tangent);
}

/* The middle of an instance's box in the world, and the distance of the farthest vertex from there. */
static void ball_of(const mcv_scene *scene, uint32_t instance, double centre[3], double *radius) {
    double lower[3], upper[3], world[3];
    const mcv_mesh *mesh = scene->meshes + scene->instances[instance].mesh;
    mcv_scene_box(scene, instance, lower, upper);
    for (int k = 0; k < 3; ++k) centre[k] = (lower[k] + upper[k]) / 2;
    *radius = 0;
    for (uint32_t v = 0; v < mesh->vertex_count; ++v) {
        mcv_scene_vertex(scene, instance, v, world);
        for (int k = 0; k < 3; ++k) world[k] -= centre[k];
        *radius = fmax(*radius, sqrt(dot(world, world)));
    }
}

static bool meets_a_part(const beam *b, const mcv_scene *scene, uint32_t except) {
    for (uint32_t i = 0; i < scene->instance_count; ++i) {
        double centre[3], radius;
        if (i == except) continue;
        ball_of(scene, i, centre, &radius);
        if (meets_ball(b, centre, radius)) return true;
    }
    return false;
}

/* The tangent of the widest angle from the normal at which it emits; infinite where it knows no such bound. */
static double widest(const mcv_scene *scene, const mcv_emitter *emitter) {
    const double half_angle = mcv_emitter_half_angle(emitter);
    if (emitter->type == MCV_EMITTER_PROJECTOR) { /* the image's corner, seen from the lens's edge */
        const mcv_projector_params *p = &emitter->as.projector;
        uint32_t pixels[2];
        mcv_projector_resolution(p, scene->textures + emitter->texture, pixels);
        return hypot(pixels[0] * p->pixelSize[0], pixels[1] * p->pixelSize[1]) / (2 * p->imageDistance) +
               fabs(mcv_kappa(p->focalLength, p->imageDistance)) * p->lensDiameter / 2;
    }
    if (emitter->type != MCV_EMITTER_LIGHT_FIELD_EMITTER) return half_angle < M_PI / 2 ? tan(half_angle) : INFINITY; /* NaN: no cone */
    const double sine = M_SQRT2 * emitter->as.light_field_emitter.angularRange; /* in the corner of the J x K directions */
    return sine < 1 ? sine / sqrt(1 - sine * sine) : INFINITY;
}

static bool lights_nothing(const mcv_scene *scene, const mcv_emitter *emitter) {
    double point[3];
    beam b = {.tangent = widest(scene, emitter)};
    if (emitter->instance == MCV_NONE) return false;
    if (!is_flat(scene->meshes + scene->instances[emitter->instance].mesh)) return false;
    if (!plane_of(scene, emitter->instance, b.axis, point)) return false;
    ball_of(scene, emitter->instance, b.centre, &b.radius);
    for (uint32_t i = 0; i < scene->sensor_count; ++i)
        if (meets_ball(&b, scene->sensors[i].to_world.m + 9, lens_radius(scene->sensors + i))) return false;
    return !meets_a_part(&b, scene, emitter->instance);
}

/* --- sensors that see nothing ----------------------------------------------------------------------------------- */

/* The slopes of all rays that enter a lens: of the chief rays, at most in a corner, and of the others to them. */
static double steepest(const mcv_sensor *sensor) {
    const mcv_readout readout = mcv_sensor_readout(sensor);
    double corner[2], b = 0, kappa = 0;
    for (int i = 0; i < 2; ++i) {
        const double edge = readout.centre[i] - readout.first[i], read = (double)readout.size[i] * readout.binning[i];
        corner[i] = fmax(fabs(edge), fabs(read - edge)) * readout.pitch[i];
    }
    switch (sensor->type) {
    case MCV_SENSOR_TELECENTRIC:
        return sensor->as.telecentric.stopDiameter / (2 * sensor->as.telecentric.focalLength);
    case MCV_SENSOR_THIN_LENS:
        b = sensor->as.thin_lens.imageDistance;
        kappa = mcv_kappa(sensor->as.thin_lens.focalLength, b);
        break;
    case MCV_SENSOR_LIGHT_FIELD:
        b = sensor->as.light_field.imageDistance;
        kappa = mcv_kappa(sensor->as.light_field.focalLength, b);
        break;
    case MCV_SENSOR_PINHOLE:
        b = sensor->as.pinhole.imageDistance;
        break;
    default:
        return INFINITY;
    }
    return hypot(corner[0], corner[1]) / b + fabs(kappa) * lens_radius(sensor);
}

static bool sees_nothing(const mcv_scene *scene, const mcv_sensor *sensor) {
    const double *m = sensor->to_world.m;
    const beam b = {{m[9], m[10], m[11]}, {-m[2], -m[5], -m[8]}, lens_radius(sensor), steepest(sensor)};
    for (uint32_t i = 0; i < scene->emitter_count; ++i)
        if (scene->emitters[i].type == MCV_EMITTER_ENVIRONMENT) return false;
    return !meets_a_part(&b, scene, MCV_NONE);
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
    double lower[3], upper[3];
    mcv_scene_box(scene, instance, lower, upper);
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
            MCV_TRY(mcv_scene_warn(
                scene, error, "emitter \"%s\" lights nothing: no part and no sensor lies where it shines, before its front (-z): turn it",
                scene->emitters[i].name));
    for (uint32_t i = 0; i < scene->sensor_count; ++i)
        if (sees_nothing(scene, scene->sensors + i))
            MCV_TRY(mcv_scene_warn(scene, error, "sensor \"%s\" sees nothing: no part and no emitter lies where it looks (-z): turn it",
                                   scene->sensors[i].name));
    MCV_TRY(warn_of_open_bodies(scene, error));
    return warn_of_units(scene, error);
}
