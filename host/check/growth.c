/* SPDX-License-Identifier: Apache-2.0 */
#include "check/growth.h"

#include "check/find.h"
#include "core/basics.h"
#include "scene/emitters.h"
#include "scene/geometry.h"
#include "scene/materials.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

/* First-order optics neglect the fall-off over the cone and the reflection of matte walls. Both are
 * below the square of the cone's tangent. */
static const double left_out = 0.01;

/* Depths of an instance along the sensor's axis. */
static void depths_of(const mcv_scene *scene, uint32_t instance, const mcv_sensor *sensor,
                      double depths[2]) {
    const double *m = sensor->to_world.m, forward[3] = {-m[2], -m[5], -m[8]};
    const mcv_mesh *mesh = scene->meshes + scene->instances[instance].mesh;
    for (uint32_t v = 0; v < mesh->vertex_count; ++v) {
        double world[3];
        mcv_scene_vertex(scene, instance, v, world);
        const double depth = mcv_dot3(world, forward) - mcv_dot3(m + 9, forward);
        depths[0] = fmin(depths[0], depth);
        depths[1] = fmax(depths[1], depth);
    }
}

/* --- the backlight --- */

/* Does the emitter's surface, by its first triangle, face the sensor within 60° of its axis? */
static bool faces(const mcv_scene *scene, const mcv_emitter *emitter, const mcv_sensor *sensor) {
    const double *m = sensor->to_world.m, forward[3] = {-m[2], -m[5], -m[8]};
    double normal[3];
    if (emitter->instance == MCV_NONE ||
        scene->meshes[scene->instances[emitter->instance].mesh].triangle_count == 0)
        return false;
    mcv_scene_face_normal(scene, emitter->instance, 0, normal);
    return mcv_dot3(normal, forward) < -0.5 * sqrt(mcv_dot3(normal, normal));
}

/* The farthest emitter that faces the sensor; *depth gets its depth. */
static uint32_t find_backlight(const mcv_scene *scene, const mcv_sensor *sensor, double *depth) {
    uint32_t found = MCV_NONE;
    *depth = 0;
    for (uint32_t i = 0; i < scene->emitter_count; ++i) {
        double depths[2] = {INFINITY, -INFINITY};
        if (!faces(scene, scene->emitters + i, sensor)) continue;
        depths_of(scene, scene->emitters[i].instance, sensor, depths);
        if (depths[0] <= *depth) continue;
        *depth = depths[0];
        found = i;
    }
    return found;
}

/* --- the part --- */

static bool is_opaque(const mcv_scene *scene, uint32_t instance) {
    const uint32_t type = scene->materials[scene->instances[instance].material].type;
    return !mcv_material_has_medium(type) && !mcv_material_is_plate(type);
}

static bool is_glossy(const mcv_scene *scene, uint32_t instance) {
    const uint32_t type = scene->materials[scene->instances[instance].material].type;
    return type != MCV_MATERIAL_DIFFUSE && type != MCV_MATERIAL_ABSORBER &&
           !mcv_material_has_own_bsdf(type);
}

static bool casts_shadow(const mcv_scene *scene, uint32_t instance, const mcv_sensor *sensor,
                         double backlight, double depths[2]) {
    depths[0] = INFINITY;
    depths[1] = -INFINITY;
    if (scene->instances[instance].emitter != MCV_NONE || !is_opaque(scene, instance)) return false;
    depths_of(scene, instance, sensor, depths);
    return depths[0] > 0 && depths[1] < backlight;
}

/* The tangent of the sensor's acceptance cone from the plane in focus; NaN without an aperture. */
static double pupil(const mcv_sensor *sensor) {
    if (sensor->type == MCV_SENSOR_LIGHT_FIELD) return NAN; /* each view has its own aperture */
    return mcv_sensor_optics(sensor).numerical_aperture;
}

bool mcv_growth_of(const mcv_scene *scene, const mcv_sensor *sensor, mcv_growth *growth) {
    double backlight;
    const uint32_t emitter = find_backlight(scene, sensor, &backlight);
    *growth = (mcv_growth){.emitter = emitter,
                           .backlight = backlight,
                           .instance = MCV_NONE,
                           .cone = pupil(sensor),
                           .f_number = mcv_sensor_optics(sensor).f_number,
                           .telecentric = sensor->type == MCV_SENSOR_TELECENTRIC};
    if (growth->emitter == MCV_NONE || !(growth->cone > 0)) return false;
    for (uint32_t first = 0, last; first < scene->instance_count; first = last) {
        double node[2] = {INFINITY, -INFINITY}, depths[2];
        bool glossy = false;
        last = mcv_body_end(scene, first);
        for (uint32_t i = first; i < last; ++i) {
            if (!casts_shadow(scene, i, sensor, backlight, depths)) continue;
            node[0] = fmin(node[0], depths[0]);
            node[1] = fmax(node[1], depths[1]);
            glossy = glossy || is_glossy(scene, i);
        }
        if (!(node[1] - node[0] > growth->thickness)) continue;
        growth->thickness = node[1] - node[0];
        growth->instance = first;
        growth->glossy = glossy;
    }
    if (growth->instance == MCV_NONE) return false;
    const double half_angle = mcv_emitter_half_angle(scene->emitters + growth->emitter);
    if (half_angle < M_PI / 2 && tan(half_angle) < growth->cone) {
        growth->cone = tan(half_angle);
        growth->light_is_narrower = true;
    }
    const double whole = 2 / (3 * M_PI) * growth->cone * growth->thickness;
    growth->edge = growth->glossy ? (mcv_quantity){whole / 2, whole / sqrt(12)}
                                  : (mcv_quantity){whole, left_out * whole};
    return true;
}

void mcv_growth_sentence(const mcv_scene *scene, const mcv_growth *growth, char text[512]) {
    const double most = (growth->glossy ? 2 : 1) * growth->edge.value;
    const char *emitter = scene->emitters[growth->emitter].name;
    char by[64], label[MCV_LABEL];
    if (growth->light_is_narrower)
        snprintf(by, sizeof by, "in its light's cone of %.2g°", atan(growth->cone) * 180 / M_PI);
    else
        snprintf(by, sizeof by, "at f/%.3g", growth->f_number);
    snprintf(text, 512,
             "before emitter \"%.*s\" the edges of %s, %.3g mm thick, grow by %s %.3g µm each %s, "
             "a width by %.3g µm%s",
             mcv_whole_characters(emitter, 60), emitter,
             mcv_instance_label(scene, growth->instance, label), 1e3 * growth->thickness,
             growth->glossy ? "up to" : "about", 1e6 * most, by, 2e6 * most,
             growth->telecentric
                 ? ": `measure --nominal` takes it off"
                 : " on the axis; elsewhere perspective shows one rim or the other");
}

mcv_result mcv_find_growth(const mcv_scene *scene, mcv_findings *findings, mcv_error *error) {
    for (uint32_t i = 0; i < scene->sensor_count; ++i) {
        const mcv_sensor *sensor = scene->sensors + i;
        mcv_growth growth;
        char sentence[512];
        if (!mcv_growth_of(scene, sensor, &growth)) continue;
        mcv_growth_sentence(scene, &growth, sentence);
        MCV_TRY(mcv_findings_add(findings, MCV_SEVERITY_NOTE, "sensors", sensor->name, NULL, error,
                                 "%s", sentence));
    }
    return MCV_OK;
}

/* --- at an edge of the image --- */

/* A corner in the frame of the edge: along it, across it towards the bright side [pixel], and the
 * depth [m]. */
typedef struct corner {
    double along, across, depth;
} corner;

/* Points of the contour: across [m] and depth [m]. */
typedef struct contour {
    double (*points)[2];
    size_t count, capacity;
} contour;

enum { MOST_CORNERS = 3 + 4 };

static double side_of(const corner *c, int plane, double length, double reach) {
    switch (plane) {
    case 0:
        return length / 2 - c->along;
    case 1:
        return length / 2 + c->along;
    case 2:
        return reach - c->across;
    default:
        return reach + c->across;
    }
}

/* Clips a polygon at a plane and keeps the inner side (Sutherland and Hodgman); returns the number
 * of corners. */
static int clip(const corner *in, int count, int plane, double length, double reach, corner *out) {
    int kept = 0;
    for (int i = 0; i < count; ++i) {
        const corner *a = in + i, *b = in + (i + 1) % count;
        const double sa = side_of(a, plane, length, reach), sb = side_of(b, plane, length, reach);
        if (sa >= 0) out[kept++] = *a;
        if ((sa >= 0) == (sb >= 0)) continue;
        const double t = sa / (sa - sb);
        out[kept++] =
            (corner){a->along + t * (b->along - a->along), a->across + t * (b->across - a->across),
                     a->depth + t * (b->depth - a->depth)};
    }
    return kept;
}

static bool add_points(contour *c, const corner *corners, int count, double pixel) {
    if (c->count + (size_t)count > c->capacity) {
        const size_t capacity = 2 * c->capacity + MOST_CORNERS;
        double(*points)[2] = realloc(c->points, capacity * sizeof *points);
        if (!points) return false;
        c->points = points;
        c->capacity = capacity;
    }
    for (int i = 0; i < count; ++i) {
        c->points[c->count][0] = corners[i].across * pixel;
        c->points[c->count++][1] = corners[i].depth;
    }
    return true;
}

/* The mean of h over the disk of tangents; across the wall their density is a half circle. */
static double mean_shadow(const contour *c, double cone) {
    enum { STEPS = 64 };
    double sum = 0;
    for (int i = 0; i < STEPS; ++i) {
        /* u = a cos φ at φ = kπ/(n + 1) with the weights sin²φ: the Gauss-Chebyshev rule of the
         * second kind. */
        const double angle = M_PI * (i + 1) / (STEPS + 1), u = cone * cos(angle);
        double h = -INFINITY;
        for (size_t k = 0; k < c->count; ++k) h = fmax(h, c->points[k][0] - u * c->points[k][1]);
        sum += 2.0 / (STEPS + 1) * sin(angle) * sin(angle) * h;
    }
    return sum;
}

static double outermost(const contour *c) {
    double h = -INFINITY;
    for (size_t k = 0; k < c->count; ++k) h = fmax(h, c->points[k][0]);
    return h;
}

/* Clips triangles between the sensor and the backlight to the surroundings of the edge. */
static bool gather(const mcv_scene *scene, const mcv_camera_model *model, double backlight,
                   uint32_t instance, const double point[2], const double normal[2], double length,
                   double reach, double pixel, contour *found) {
    const mcv_mesh *mesh = scene->meshes + scene->instances[instance].mesh;
    for (uint32_t t = 0; t < mesh->triangle_count; ++t) {
        double corners[3][3];
        corner polygons[2][MOST_CORNERS];
        int count = 3;
        mcv_scene_corners(scene, instance, t, corners);
        for (int k = 0; k < 3; ++k) {
            const double depth = mcv_camera_model_depth(model, corners[k]);
            double at[2];
            if (!(depth > 0 && depth < backlight) ||
                !mcv_camera_model_project(model, corners[k], at))
                count = 0;
            if (count == 0) break;
            const double dx = at[0] - point[0], dy = at[1] - point[1];
            polygons[0][k] =
                (corner){dy * normal[0] - dx * normal[1], dx * normal[0] + dy * normal[1], depth};
        }
        for (int plane = 0; plane < 4 && count > 0; ++plane)
            count =
                clip(polygons[plane % 2], count, plane, length, reach, polygons[(plane + 1) % 2]);
        if (!add_points(found, polygons[0], count, pixel)) return false;
    }
    return true;
}

mcv_result mcv_growth_at(const mcv_scene *scene, const mcv_camera_model *model,
                         const mcv_growth *growth, const double point[2], const double normal[2],
                         double length, double reach, mcv_quantity *edge, mcv_error *error) {
    const mcv_instance *node = scene->instances + growth->instance;
    const double pixel =
        hypot(normal[0] * model->object_pixel[0], normal[1] * model->object_pixel[1]);
    contour found = {0};
    bool enough = true, glossy = false;
    for (uint32_t i = 0; i < scene->instance_count && enough; ++i) {
        if (scene->instances[i].emitter != MCV_NONE || !is_opaque(scene, i)) continue;
        const size_t before = found.count;
        enough =
            gather(scene, model, growth->backlight, i, point, normal, length, reach, pixel, &found);
        glossy = glossy || (found.count > before && is_glossy(scene, i));
    }
    const double whole = found.count ? mean_shadow(&found, growth->cone) - outermost(&found) : NAN;
    free(found.points);
    if (!enough)
        return mcv_fail(error, MCV_FAILED, "no memory for the contour of node \"%s\"", node->name);
    if (isnan(whole))
        return mcv_fail(
            error, MCV_FAILED,
            "no contour of a part lies within %.3g pixels of it, so its growth is not known",
            reach);
    *edge = glossy ? (mcv_quantity){whole / 2, whole / sqrt(12)}
                   : (mcv_quantity){whole, left_out * whole};
    return MCV_OK;
}

mcv_result mcv_growth_of_circle(const mcv_scene *scene, const mcv_camera_model *model,
                                const mcv_growth *growth, const double centre[2], double radius,
                                bool bright_inside, double reach, mcv_quantity *edge,
                                mcv_error *error) {
    /* An arc of this length [pixel] deviates from its tangent by at most 1/2R, which is small
     * against the reach. */
    enum { DIRECTIONS = 16, LENGTH = 2 };
    mcv_quantity mean = {0, 0};
    for (int i = 0; i < DIRECTIONS; ++i) {
        const double angle = 2 * M_PI * (i + 0.5) / DIRECTIONS, sign = bright_inside ? -1 : 1;
        const double point[2] = {centre[0] + radius * cos(angle), centre[1] + radius * sin(angle)};
        const double normal[2] = {sign * cos(angle), sign * sin(angle)};
        mcv_quantity here = {NAN, NAN};
        MCV_TRY(mcv_growth_at(scene, model, growth, point, normal, LENGTH, reach, &here, error));
        mean.value += here.value / DIRECTIONS;
        mean.uncertainty += here.uncertainty / DIRECTIONS;
    }
    *edge = mean;
    return MCV_OK;
}
