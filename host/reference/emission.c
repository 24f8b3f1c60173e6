/* SPDX-License-Identifier: Apache-2.0 */
#include "reference/emission.h"

#include <stdlib.h>

#include "reference/texture.h"
#include "scene/emitters.h"
#include "scene/geometry.h"

/* Half-angle of the cone into which every point emits, or 0. */
static double cone_of(const mcv_emitter *emitter) {
    if (emitter->type == MCV_EMITTER_PARALLEL) return emitter->as.parallel.halfAngle;
    return emitter->type == MCV_EMITTER_TELECENTRIC_PROJECTOR
               ? emitter->as.telecentric_projector.halfAngle
               : 0;
}

/* The share of its radiance that an emitter's surface sends at an angle from its normal. */
static double share_at(const mcv_emitter *emitter, double angle) {
    switch (emitter->type) {
    case MCV_EMITTER_PARALLEL:
    case MCV_EMITTER_TELECENTRIC_PROJECTOR:
        return angle <= cone_of(emitter) ? 1 : 0;
    case MCV_EMITTER_SCREEN:
        return pow(cos(angle), emitter->as.screen.falloffExponent);
    default:
        return 1;
    }
}

static void triangle_of(const mcv_scene *scene, uint32_t instance, uint32_t local,
                        ref_vec corner[3]) {
    double corners[3][3];
    mcv_scene_corners(scene, instance, local, corners);
    for (int i = 0; i < 3; ++i) corner[i] = ref_from(corners[i]);
}

/* Sets the axis, and the half-angle of the cone that holds the emission of every point: β and how
 * far the normals spread. */
static void find_cone(const mcv_scene *scene, const mcv_emitter *source, uint32_t triangle_count,
                      ref_emitter *emitter) {
    double normals[3][3], spread = 0;
    ref_vec sum = {0, 0, 0};
    for (uint32_t local = 0; local < triangle_count; ++local) {
        mcv_scene_vertex_normals(scene, source->instance, local, normals);
        for (int i = 0; i < 3; ++i) sum = ref_add(sum, ref_from(normals[i]));
    }
    if (!(ref_dot(sum, sum) > 0)) return;
    emitter->axis = ref_unit(sum);
    for (uint32_t local = 0; local < triangle_count; ++local) {
        mcv_scene_vertex_normals(scene, source->instance, local, normals);
        for (int i = 0; i < 3; ++i)
            spread = fmax(spread, ref_angle(emitter->axis, ref_from(normals[i])));
    }
    const double half_angle = cone_of(source);
    if (spread < half_angle && spread + half_angle < M_PI / 2)
        emitter->half_angle = spread + half_angle;
}

static mcv_result emitter_new(const mcv_scene *scene, uint32_t index, ref_emitter *emitter,
                              mcv_error *error) {
    const mcv_emitter *source = &scene->emitters[index];
    const uint32_t triangle_count =
        scene->meshes[scene->instances[source->instance].mesh].triangle_count;
    emitter->index = index;
    emitter->areas = malloc((triangle_count + (size_t)1) * sizeof *emitter->areas);
    if (!emitter->areas)
        return mcv_fail(error, MCV_FAILED, "reference renderer: no memory for emitter \"%s\" of %s",
                        source->name, scene->path);
    for (uint32_t local = 0; local < triangle_count; ++local) {
        ref_vec c[3];
        triangle_of(scene, source->instance, local, c);
        const double area = 0.5 * ref_length(ref_cross(ref_sub(c[1], c[0]), ref_sub(c[2], c[0])));
        emitter->areas[local] = emitter->area += area;
        emitter->centre =
            ref_add(emitter->centre, ref_scale(area / 3, ref_add(c[0], ref_add(c[1], c[2]))));
    }
    if (emitter->area > 0) emitter->centre = ref_scale(1 / emitter->area, emitter->centre);
    if (cone_of(source) > 0) find_cone(scene, source, triangle_count, emitter);
    return MCV_OK;
}

mcv_result ref_emitters_new(const mcv_scene *scene, ref_emitters *emitters, mcv_error *error) {
    *emitters =
        (ref_emitters){.items = calloc(scene->emitter_count + (size_t)1, sizeof *emitters->items)};
    if (!emitters->items)
        return mcv_fail(error, MCV_FAILED, "reference renderer: no memory for the emitters of %s",
                        scene->path);
    for (uint32_t i = 0; i < scene->emitter_count; ++i) {
        if (scene->emitters[i].type == MCV_EMITTER_ENVIRONMENT) {
            emitters->environment = &scene->emitters[i];
            continue;
        }
        if (!mcv_emitter_has_surface(scene->emitters[i].type) ||
            scene->emitters[i].type == MCV_EMITTER_COLLIMATED_BEAM)
            continue; /* reference/lights.h */
        ref_emitter *emitter = &emitters->items[emitters->count];
        MCV_TRY(emitter_new(scene, i, emitter, error));
        if (emitter->area > 0) {
            ++emitters->count;
        } else { /* cannot be met */
            free(emitter->areas);
            *emitter = (ref_emitter){0};
        }
    }
    return MCV_OK;
}

void ref_emitters_free(ref_emitters *emitters) {
    for (uint32_t i = 0; emitters->items && i < emitters->count; ++i)
        free(emitters->items[i].areas);
    free(emitters->items);
    *emitters = (ref_emitters){0};
}

/* Which of `count` equal parts of [0, 1] holds the share. */
static uint32_t part(double share, uint32_t count) {
    return (uint32_t)fmin(fmax(floor(share * count), 0), count - 1.0);
}

/* The axes and the centre of the emitter's rectangle. */
typedef struct rectangle {
    ref_vec x, y, z, place; /* place: from the centre */
} rectangle;

static rectangle rectangle_of(const mcv_scene *scene, const mcv_emitter *emitter,
                              const ref_surface *surface) {
    const double *m = scene->instances[emitter->instance].to_world.m;
    return (rectangle){{m[0], m[3], m[6]},
                       {m[1], m[4], m[7]},
                       {m[2], m[5], m[8]},
                       ref_sub(surface->position, (ref_vec){m[9], m[10], m[11]})};
}

static bool shows_image(const mcv_emitter *emitter) {
    return emitter->type == MCV_EMITTER_TELECENTRIC_PROJECTOR ||
           emitter->type == MCV_EMITTER_LIGHT_FIELD_EMITTER ||
           emitter->type == MCV_EMITTER_PROJECTOR;
}

static bool projector_pixel(const mcv_projector_params *p, const mcv_texture *image,
                            const rectangle *r, ref_vec direction, uint32_t pixel[2]) {
    const double ahead = -ref_dot(direction, r->z), o_x = ref_dot(r->place, r->x),
                 o_y = ref_dot(r->place, r->y), b = p->imageDistance,
                 reciprocal_throw = 1 / p->focalLength - 1 / b;
    const double right = b / p->pixelSize[0] *
                         (ref_dot(direction, r->x) / ahead + reciprocal_throw * o_x) *
                         (p->mirror ? -1 : 1);
    const bool pattern = p->pattern.type != MCV_NONE; /* whose image is a line of it */
    const double columns = pattern ? p->pattern.resolution[0] : image->width,
                 rows = pattern ? p->pattern.resolution[1] : image->height;
    const double column = columns / 2 + right;
    const double row = rows / 2 - b / p->pixelSize[1] *
                                      (ref_dot(direction, r->y) / ahead + reciprocal_throw * o_y);
    pixel[0] = part(column / columns, image->width);
    pixel[1] = part(row / rows, image->height);
    return hypot(o_x, o_y) <= p->lensDiameter / 2 && ahead > 0 && column >= 0 && column < columns &&
           row >= 0 && row < rows;
}

static bool light_field_pixel(const mcv_light_field_emitter_params *p, const rectangle *r,
                              ref_vec direction, uint32_t pixel[2]) {
    const uint32_t *macro = p->spatialResolution, *angular = p->angularResolution;
    const double right = ref_dot(direction, r->x) / p->angularRange,
                 up = ref_dot(direction, r->y) / p->angularRange;
    pixel[0] = part(0.5 + ref_dot(r->place, r->x) / p->size[0], macro[0]) * angular[0] +
               part((right + 1) / 2, angular[0]);
    pixel[1] = part(0.5 - ref_dot(r->place, r->y) / p->size[1], macro[1]) * angular[1] +
               part((1 - up) / 2, angular[1]);
    return fabs(right) <= 1 && fabs(up) <= 1;
}

bool ref_emitting_pixel(const mcv_scene *scene, const ref_surface *surface, ref_vec direction,
                        uint32_t pixel[2]) {
    const mcv_emitter *emitter = &scene->emitters[scene->instances[surface->instance].emitter];
    if (emitter->texture == MCV_NONE) return false;
    const mcv_texture *image = &scene->textures[emitter->texture];
    const rectangle r = rectangle_of(scene, emitter, surface);
    if (emitter->type == MCV_EMITTER_PROJECTOR)
        return projector_pixel(&emitter->as.projector, image, &r, direction, pixel);
    if (emitter->type == MCV_EMITTER_LIGHT_FIELD_EMITTER)
        return light_field_pixel(&emitter->as.light_field_emitter, &r, direction, pixel);
    if (emitter->type != MCV_EMITTER_TELECENTRIC_PROJECTOR)
        return ref_nearest_texel(image, surface->texcoord, pixel);
    const mcv_telecentric_projector_params *p = &emitter->as.telecentric_projector;
    const double right = ref_dot(r.place, r.x) / p->size[0] * (p->mirror ? -1 : 1),
                 up = ref_dot(r.place, r.y) / p->size[1];
    pixel[0] = part(0.5 + right, image->width);
    pixel[1] = part(0.5 - up, image->height);
    return true;
}

/* Multiplies the radiance by the value of the image's pixel that emits in the direction. */
static void show_image(const mcv_scene *scene, const mcv_emitter *emitter,
                       const ref_surface *surface, ref_vec direction, double radiance[3]) {
    double rgb[3] = {0, 0, 0};
    uint32_t pixel[2];
    if (ref_emitting_pixel(scene, surface, direction, pixel))
        ref_texel(&scene->textures[emitter->texture], pixel[0], pixel[1], rgb);
    for (int channel = 0; channel < 3; ++channel) radiance[channel] *= rgb[channel];
}

void ref_environment(const mcv_scene *scene, const ref_emitters *emitters, ref_vec direction,
                     double radiance[3]) {
    const mcv_emitter *sky = emitters->environment;
    double rgb[3] = {1, 1, 1};
    if (sky && sky->texture != MCV_NONE) {
        const mcv_texture *image = &scene->textures[sky->texture];
        const double *m = sky->to_world.m;
        const double right = ref_dot(direction, (ref_vec){m[0], m[3], m[6]}),
                     back = ref_dot(direction, (ref_vec){m[2], m[5], m[8]});
        const double polar = ref_angle(direction, (ref_vec){m[1], m[4], m[7]});
        ref_texel(image, part(0.5 + atan2(right, -back) / (2 * M_PI), image->width),
                  part(polar / M_PI, image->height), rgb);
    }
    for (int channel = 0; channel < 3; ++channel)
        radiance[channel] = sky ? sky->radiance[channel] * rgb[channel] : 0;
}

/* Whether a place on a screen lies in the lit part of a pixel, by its distances from the edges at
 * the node's -x and -y: pixels lie symmetrically about the middle. */
static bool in_pixel(const mcv_scene *scene, const mcv_emitter *emitter,
                     const ref_surface *surface) {
    const mcv_screen_params *p = &emitter->as.screen;
    const double *m = scene->instances[emitter->instance].to_world.m;
    const ref_vec place = ref_sub(surface->position, (ref_vec){m[9], m[10], m[11]});
    double size[2];
    mcv_emitter_size(scene, emitter, size);
    for (int i = 0; i < 2; ++i) {
        const double from_edge = ref_dot(place, (ref_vec){m[i], m[3 + i], m[6 + i]}) + size[i] / 2;
        const double in_pitch = fmod(from_edge + p->pixelPitch[i], p->pixelPitch[i]);
        if (in_pitch < p->pixelGap[i] / 2 || in_pitch > p->pixelPitch[i] - p->pixelGap[i] / 2)
            return false;
    }
    return true;
}

void ref_emitted(const mcv_scene *scene, const ref_surface *surface, ref_vec direction,
                 double radiance[3]) {
    const uint32_t index = scene->instances[surface->instance].emitter;
    radiance[0] = radiance[1] = radiance[2] = 0;
    if (index == MCV_NONE || scene->emitters[index].type == MCV_EMITTER_COLLIMATED_BEAM) return;
    if (!(ref_dot(direction, surface->normal) > 0) || !(ref_dot(direction, surface->geometric) > 0))
        return;
    const mcv_emitter *emitter = &scene->emitters[index];
    const double share = share_at(emitter, ref_angle(direction, surface->normal));
    if (share == 0) return;
    if (emitter->type == MCV_EMITTER_SCREEN && !in_pixel(scene, emitter, surface)) return;
    const bool shows = shows_image(emitter);
    ref_texture_lookup(scene, shows ? MCV_NONE : emitter->texture, surface->texcoord, radiance);
    for (int channel = 0; channel < 3; ++channel)
        radiance[channel] *= share * emitter->radiance[channel];
    if (shows) show_image(scene, emitter, surface, direction, radiance);
}

/* Whether the cone is the smaller target: its solid angle against the emitter's, were it seen face
 * on. */
static bool by_cone(const ref_emitter *emitter, ref_vec point) {
    const ref_vec d = ref_sub(emitter->centre, point);
    const double s = sin(emitter->half_angle / 2);
    return emitter->half_angle > 0 && 4 * M_PI * s * s * ref_dot(d, d) < emitter->area;
}

ref_vec ref_emitter_sample(const ref_emitter *emitter, const mcv_scene *scene, ref_vec point,
                           ref_random *random, uint32_t *number) {
    double u = ref_random_unit(random);
    const double v = ref_random_unit(random);
    if (by_cone(emitter, point)) { /* uniform in the solid angle: sin²(θ/2) is uniform */
        const double s = sin(emitter->half_angle / 2) * sqrt(u), sine = 2 * s * sqrt(1 - s * s);
        ref_vec x, y;
        ref_frame(emitter->axis, &x, &y);
        *number = MCV_NONE;
        return ref_scale(-1, ref_add(ref_scale(1 - 2 * s * s, emitter->axis),
                                     ref_add(ref_scale(sine * cos(2 * M_PI * v), x),
                                             ref_scale(sine * sin(2 * M_PI * v), y))));
    }
    const mcv_instance *instance = &scene->instances[scene->emitters[emitter->index].instance];
    const double area = u * emitter->area;
    uint32_t low = 0, high = scene->meshes[instance->mesh].triangle_count - 1;
    while (low < high) { /* the first triangle whose running sum exceeds the area */
        const uint32_t middle = low + (high - low) / 2;
        if (emitter->areas[middle] > area)
            high = middle;
        else
            low = middle + 1;
    }
    const double below = low > 0 ? emitter->areas[low - 1] : 0;
    u = sqrt((area - below) / (emitter->areas[low] - below));
    ref_vec c[3];
    triangle_of(scene, scene->emitters[emitter->index].instance, low, c);
    const ref_vec place = ref_add(ref_scale(1 - u, c[0]),
                                  ref_add(ref_scale(u * (1 - v), c[1]), ref_scale(u * v, c[2])));
    *number = instance->first_triangle + low;
    return ref_unit(ref_sub(place, point));
}

double ref_emitter_density(const ref_emitter *emitter, ref_vec point, ref_vec direction,
                           const ref_surface *surface) {
    if (by_cone(emitter, point)) {
        const double s = sin(emitter->half_angle / 2);
        return ref_angle(ref_scale(-1, direction), emitter->axis) <= emitter->half_angle
                   ? 1 / (4 * M_PI * s * s)
                   : 0;
    }
    const ref_vec d = ref_sub(surface->position, point);
    return ref_dot(d, d) / (emitter->area * fabs(ref_dot(direction, surface->geometric)));
}
