/* SPDX-License-Identifier: Apache-2.0 */
/* Findings about emitters: where their light goes, and how wide their cones are. */
#include "check/find.h"
#include "scene/emitters.h"
#include "scene/laser.h"
#include "scene/transform.h"
#include "scene/geometry.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* --- beams --- */

/* Has the mesh no thickness along an axis, and its normals (if any) no other component? *flat gets
 * the axis. */
static bool is_flat(const mcv_mesh *mesh, int *flat) {
    for (int axis = 0; axis < 3; ++axis) {
        bool even = true;
        for (size_t v = 0; v < mesh->vertex_count && even; ++v) {
            even = mesh->positions[3 * v + axis] == mesh->positions[axis];
            for (int k = 0; k < 3 && even && mesh->normals; ++k)
                even = k == axis || mesh->normals[3 * v + k] == 0;
        }
        *flat = axis;
        if (even) return true;
    }
    return false;
}

/* The space before a rectangle within `tangent` of its edge, per depth: an upper bound of what its
 * light can reach. */
typedef struct beam {
    double origin[3],
        axes[3][3]; /* unit: two along the rectangle, the third in the direction of emission */
    double lower[2], upper[2]; /* along the first two axes, from the origin */
    double tangent;            /* or infinite */
} beam;

static void to_beam(const beam *b, const double world[3], double local[3]) {
    const double from[3] = {world[0] - b->origin[0], world[1] - b->origin[1],
                            world[2] - b->origin[2]};
    for (int k = 0; k < 3; ++k) local[k] = mcv_dot3(from, b->axes[k]);
}

/* The beam of a flat instance. False if it is not flat, or if its triangles face both ways. */
static bool beam_of(const mcv_scene *scene, uint32_t instance, beam *b) {
    const mcv_mesh *mesh = scene->meshes + scene->instances[instance].mesh;
    const double *m = scene->instances[instance].to_world.m;
    double total[3] = {0, 0, 0};
    int flat;
    if (!is_flat(mesh, &flat)) return false;
    for (int pass = 0; pass < 2; ++pass)
        for (uint32_t t = 0; t < mesh->triangle_count; ++t) {
            double face[3];
            mcv_scene_face_normal(scene, instance, t, face);
            if (pass == 1 && mcv_dot3(face, total) < 0) return false;
            for (int k = 0; k < 3 && pass == 0; ++k) total[k] += face[k];
        }
    const int along = flat == 0 ? 1 : 0;
    if (!mcv_normalize3(total, b->axes[2]) ||
        !mcv_normalize3((const double[3]){m[along], m[3 + along], m[6 + along]}, b->axes[0]))
        return false;
    mcv_cross3(b->axes[2], b->axes[0], b->axes[1]);
    mcv_scene_vertex(scene, instance, 0, b->origin);
    for (int k = 0; k < 2; ++k) b->lower[k] = INFINITY, b->upper[k] = -INFINITY;
    for (uint32_t v = 0; v < mesh->vertex_count; ++v) {
        double world[3], local[3];
        mcv_scene_vertex(scene, instance, v, world);
        to_beam(b, world, local);
        for (int k = 0; k < 2; ++k) {
            b->lower[k] = fmin(b->lower[k], local[k]);
            b->upper[k] = fmax(b->upper[k], local[k]);
        }
    }
    return true;
}

/* Does a part of a box, given in the beam's axes, lie in the beam? Near its edge the answer may be
 * a false yes. */
static bool meets_box(const beam *b, const double lower[3], const double upper[3]) {
    if (!(upper[2] > 0)) return false;
    if (!isfinite(b->tangent)) return true;
    double aside = 0;
    for (int k = 0; k < 2; ++k) {
        const double gap = fmax(0, fmax(b->lower[k] - upper[k], lower[k] - b->upper[k]));
        aside = hypot(aside, gap);
    }
    return aside <= b->tangent * upper[2];
}

/* Does a part of an instance's box, along the beam's axes, lie in the beam? */
static bool meets_instance(const beam *b, const mcv_scene *scene, uint32_t instance) {
    const uint32_t vertices = scene->meshes[scene->instances[instance].mesh].vertex_count;
    double lower[3] = {INFINITY, INFINITY, INFINITY}, upper[3] = {-INFINITY, -INFINITY, -INFINITY};
    for (uint32_t v = 0; v < vertices; ++v) {
        double world[3], local[3];
        mcv_scene_vertex(scene, instance, v, world);
        to_beam(b, world, local);
        if (meets_box(b, local, local)) return true; /* as the box about it would */
        for (int k = 0; k < 3; ++k) {
            lower[k] = fmin(lower[k], local[k]);
            upper[k] = fmax(upper[k], local[k]);
        }
    }
    return meets_box(b, lower, upper);
}

static bool meets_a_mesh(const beam *b, const mcv_scene *scene, uint32_t except) {
    for (uint32_t i = 0; i < scene->instance_count; ++i)
        if (i != except && meets_instance(b, scene, i)) return true;
    return false;
}

/* Does a part of an instance lie before the sensor's lens? */
static bool before(const mcv_sensor *sensor, const mcv_scene *scene, uint32_t instance) {
    const mcv_view view = {.sensor = sensor};
    for (uint32_t v = 0; v < scene->meshes[scene->instances[instance].mesh].vertex_count; ++v) {
        double world[3], local[3];
        mcv_scene_vertex(scene, instance, v, world);
        mcv_view_point(&view, world, local);
        if (local[2] > 0) return true;
    }
    return false;
}

static bool meets_lens(const beam *b, const mcv_sensor *sensor) {
    const double radius = mcv_lens_radius(sensor);
    double centre[3], lower[3], upper[3];
    to_beam(b, sensor->to_world.m + 9, centre);
    for (int k = 0; k < 3; ++k) {
        lower[k] = centre[k] - radius;
        upper[k] = centre[k] + radius;
    }
    return meets_box(b, lower, upper);
}

/* The tangent of the widest angle of emission from the normal; infinite without a bound. */
static double widest(const mcv_scene *scene, const mcv_emitter *emitter) {
    const double half_angle = mcv_emitter_half_angle(emitter);
    if (emitter->type ==
        MCV_EMITTER_PROJECTOR) { /* the image's corner, seen from the lens's edge */
        const mcv_projector_params *p = &emitter->as.projector;
        uint32_t pixels[2];
        mcv_picture_resolution(&p->pattern, scene->textures + emitter->texture, pixels);
        return hypot(pixels[0] * p->pixelSize[0], pixels[1] * p->pixelSize[1]) /
                   (2 * p->imageDistance) +
               fabs(mcv_kappa(p->focalLength, p->imageDistance)) * p->lensDiameter / 2;
    }
    if (emitter->type == MCV_EMITTER_COLLIMATED_BEAM) return 0;
    if (emitter->type != MCV_EMITTER_LIGHT_FIELD_EMITTER)
        return half_angle < M_PI / 2 ? tan(half_angle) : INFINITY; /* NaN: no cone */
    const double sine =
        M_SQRT2 *
        emitter->as.light_field_emitter.angularRange; /* in the corner of the J x K directions */
    return sine < 1 ? sine / sqrt(1 - sine * sine) : INFINITY;
}

/* --- unlit --- */

/* What a user turns to turn an emitter: its node, if it has a name. */
static const char *turned_by(const mcv_scene *scene, const mcv_emitter *emitter,
                             const char **name) {
    const char *node =
        emitter->instance == MCV_NONE ? "" : scene->instances[emitter->instance].name;
    *name = *node ? node : emitter->name;
    return *node ? "nodes" : "emitters";
}

static bool lights_nothing(const mcv_scene *scene, const mcv_emitter *emitter) {
    beam b = {.tangent = INFINITY};
    if (emitter->type == MCV_EMITTER_SPOT) {
        const double *m = emitter->to_world.m, angle = emitter->as.spot.outerConeAngle;
        for (int k = 0; k < 3; ++k) {
            b.origin[k] = m[9 + k];
            for (int i = 0; i < 3; ++i) b.axes[i][k] = (i == 2 ? -1 : 1) * m[3 * k + i];
        }
        b.tangent = angle < M_PI / 2 ? tan(angle) : INFINITY;
        return !meets_a_mesh(&b, scene, MCV_NONE);
    }
    if (emitter->type == MCV_EMITTER_LASER) {
        memcpy(b.origin, emitter->to_world.m + 9, sizeof b.origin);
        mcv_laser_axes(emitter, b.axes);
        b.tangent = mcv_laser_tangent(&emitter->as.laser);
        return !meets_a_mesh(&b, scene, MCV_NONE);
    }
    if (emitter->instance == MCV_NONE || !beam_of(scene, emitter->instance, &b)) return false;
    b.tangent = widest(scene, emitter);
    for (uint32_t i = 0; i < scene->sensor_count; ++i)
        if (meets_lens(&b, scene->sensors + i) &&
            before(scene->sensors + i, scene, emitter->instance))
            return false;
    return !meets_a_mesh(&b, scene, emitter->instance);
}

mcv_result mcv_find_unlit(const mcv_scene *scene, mcv_findings *findings, mcv_error *error) {
    for (uint32_t i = 0; i < scene->emitter_count; ++i) {
        const mcv_emitter *emitter = scene->emitters + i;
        if (!lights_nothing(scene, emitter)) continue;
        const char *name, *kind = turned_by(scene, emitter, &name);
        MCV_TRY(mcv_findings_add(
            findings, MCV_SEVERITY_ERROR, kind, name, NULL, error,
            "emitter \"%s\" lights nothing: no part and no sensor lies before its front (-z): "
            "turn it",
            emitter->name));
    }
    return MCV_OK;
}

/* --- hidden --- */

/* Does a point of its plane, in the beam's axes, lie on a flat emitter? The hole of a ring does
 * not. */
static bool lies_on(const mcv_scene *scene, uint32_t instance, const beam *b, const double p[3]) {
    const mcv_mesh *mesh = scene->meshes + scene->instances[instance].mesh;
    for (uint32_t t = 0; t < mesh->triangle_count; ++t) {
        double corners[3][3], local[3][3];
        int left = 0;
        mcv_scene_corners(scene, instance, t, corners);
        for (int k = 0; k < 3; ++k) to_beam(b, corners[k], local[k]);
        for (int k = 0; k < 3; ++k) {
            const double *from = local[k], *to = local[(k + 1) % 3];
            left +=
                (to[0] - from[0]) * (p[1] - from[1]) - (to[1] - from[1]) * (p[0] - from[0]) >= 0;
        }
        if (left == 3)
            return true; /* corners run counter-clockwise from the front, and so do the beam's axes
                          */
    }
    return false;
}

static mcv_result find_hidden_from(const mcv_scene *scene, const mcv_emitter *emitter,
                                   const beam *b, const mcv_sensor *sensor, mcv_findings *findings,
                                   mcv_error *error) {
    const double *m = sensor->to_world.m, axis[3] = {-m[2], -m[5], -m[8]};
    const char *name, *kind = turned_by(scene, emitter, &name);
    double lens[3], place[3];
    char text[32];
    to_beam(b, m + 9, lens);
    if (lens[2] > 0 && !before(sensor, scene, emitter->instance) &&
        lies_on(scene, emitter->instance, b, lens))
        return mcv_findings_add(
            findings, MCV_SEVERITY_WARNING, kind, name, NULL, error,
            "emitter \"%s\" stands %s behind sensor \"%s\": the sensor does not see it, and the "
            "camera's body would block it; a backlight belongs beyond the part, facing the sensor",
            emitter->name, mcv_length_in_words(lens[2], text), sensor->name);
    const double approach = mcv_dot3(axis, b->axes[2]),
                 depth = -lens[2] / approach; /* where the axis crosses its plane */
    for (int k = 0; k < 3; ++k) place[k] = lens[k] + depth * mcv_dot3(axis, b->axes[k]);
    if (!(lens[2] < 0 && approach > 0) || !lies_on(scene, emitter->instance, b, place))
        return MCV_OK;
    return mcv_findings_add(
        findings, MCV_SEVERITY_WARNING, kind, name, NULL, error,
        "sensor \"%s\" looks at the back of emitter \"%s\", at a depth of %s, and the back "
        "is dark: turn the emitter, so that its front (-z) faces the sensor",
        sensor->name, emitter->name, mcv_length_in_words(depth, text));
}

mcv_result mcv_find_hidden(const mcv_scene *scene, mcv_findings *findings, mcv_error *error) {
    for (uint32_t i = 0; i < scene->emitter_count; ++i) {
        const mcv_emitter *emitter = scene->emitters + i;
        beam b = {.tangent = 0};
        if (emitter->instance == MCV_NONE || !beam_of(scene, emitter->instance, &b)) continue;
        for (uint32_t s = 0; s < scene->sensor_count; ++s)
            MCV_TRY(find_hidden_from(scene, emitter, &b, scene->sensors + s, findings, error));
    }
    return MCV_OK;
}

/* --- bare_angle --- */

/* A cone of 0.1 rad or more with at most two digits was probably meant in degrees: 10 degrees in
 * radians have more digits. */
static bool is_suspicious(double angle) {
    char text[32];
    snprintf(text, sizeof text, "%.1e", angle); /* two digits */
    return angle >= 0.1 && strtod(text, NULL) == angle;
}

mcv_result mcv_find_bare_angle(const mcv_scene *scene, mcv_findings *findings, mcv_error *error) {
    for (uint32_t i = 0; i < scene->emitter_count; ++i) {
        const mcv_emitter *emitter = scene->emitters + i;
        const bool spot = emitter->type == MCV_EMITTER_SPOT;
        const double angle =
            spot ? emitter->as.spot.outerConeAngle : mcv_emitter_half_angle(emitter);
        const char *key = spot ? "outerConeAngle" : "halfAngle";
        if (!emitter->bare_angle || !is_suspicious(angle)) continue;
        MCV_TRY(mcv_findings_add(
            findings, MCV_SEVERITY_WARNING, "emitters", emitter->name, key, error,
            "%s %g of emitter \"%s\" has no unit, so it is in radians: %.3g degrees; write "
            "\"%gdeg\" for degrees, or \"%grad\" for radians",
            key, angle, emitter->name, angle * 180 / M_PI, angle, angle));
    }
    return MCV_OK;
}
