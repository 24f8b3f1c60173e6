/* SPDX-License-Identifier: Apache-2.0 */
/* The emitters that next-event estimation samples, and the tables by which they are chosen. */
#include "device/pack_steps.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "device/light.h"
#include "scene/emitters.h"
#include "scene/laser.h"
#include "scene/mesh.h"
#include "scene/geometry.h"
#include "scene/texture.h"

/* The radiance of an emitter where its image has such a value, over all channels. */
static double sum_of_channels(const mcv_emitter *emitter, const double image[3]) {
    return emitter->radiance[0] * image[0] + emitter->radiance[1] * image[1] +
           emitter->radiance[2] * image[2];
}

/* Power over all channels. For emitters at infinity, the power that falls on the scene's bounding
 * ball. size: of the scene, mcv_packed_size. */
static double emitter_power(const mcv_scene *scene, double size, const mcv_emitter *emitter) {
    double mean[3];
    mcv_emitter_image_mean(scene, emitter, mean);
    const double brightness = sum_of_channels(emitter, mean);
    const double disk = M_PI * pow(size / 2, 2);
    if (emitter->type == MCV_EMITTER_DIRECTIONAL) return brightness * disk;
    if (emitter->type == MCV_EMITTER_ENVIRONMENT)
        return brightness * mcv_emitter_solid_angle(emitter) * disk;
    return brightness * mcv_emitter_unit_power(scene, emitter);
}

/*
 * A sixteenth of all choices is shared equally among all emitters with power: a weak emitter may be
 * the only one nearby, and emitters without extent are found in no other way.
 */
static void share_choices(double *powers, uint32_t count) {
    double total = 0;
    uint32_t shining = 0;
    for (uint32_t i = 0; i < count; ++i) {
        total += powers[i];
        shining += powers[i] > 0;
    }
    for (uint32_t i = 0; i < count; ++i)
        if (powers[i] > 0) powers[i] = 15 * powers[i] + total / shining;
}

/* The middle of the instance's box, re-centred. */
static void find_middle(const mcv_packed *packed, uint32_t instance, float middle[3]) {
    const mcv_box3d *box = &packed->boxes[instance];
    for (int k = 0; k < 3; ++k)
        middle[k] = (float)(0.5 * (box->lower[k] + box->upper[k]) - packed->centre[k]);
}

/* The fields that depend on the type. */
static void prepare_emitter(const mcv_scene *scene, const mcv_packed *packed, uint32_t index,
                            mcv_device_emitter *to) {
    switch (scene->emitters[index].type) {
    case MCV_EMITTER_PARALLEL:
    case MCV_EMITTER_TELECENTRIC_PROJECTOR:
        to->type = MCV_EMITTER_PARALLEL;
        mcv_parallel_prepare(scene, index, &to->parallel);
        break;
    case MCV_EMITTER_LIGHT_FIELD_EMITTER:
        mcv_light_field_emitter_prepare(scene, index, &to->light_field);
        break;
    case MCV_EMITTER_PROJECTOR:
        mcv_projector_prepare(scene, index, &to->projector);
        break;
    case MCV_EMITTER_ENVIRONMENT:
        mcv_environment_prepare(scene, index, &to->environment);
        break;
    case MCV_EMITTER_COLLIMATED_BEAM:
        mcv_collimated_beam_prepare(scene, index, &to->beam);
        break;
#define MCV_X(name, key, NAME) case MCV_EMITTER_##NAME:
        MCV_POINT_LIGHTS(MCV_X)
#undef MCV_X
        to->type = MCV_EMITTER_POINT;
        mcv_point_light_prepare(scene, index, packed->centre, &to->light);
        break;
#define MCV_X(name, key, NAME) case MCV_EMITTER_##NAME:
        MCV_SURFACE_LIGHTS(MCV_X)
#undef MCV_X
        to->type = MCV_EMITTER_AREA;
        mcv_surface_light_prepare(scene, index, &to->surface_light);
        break;
    case MCV_EMITTER_LASER:
        mcv_laser_prepare(scene, index, packed->centre, &to->laser);
        memcpy(to->middle, to->laser.position, sizeof to->middle);
        break;
    case MCV_EMITTER_DIRECTIONAL:
        mcv_directional_prepare(scene, index, &to->directional);
        break;
    default:
        break;
    }
}

static double length(const double v[3]) { return hypot(hypot(v[0], v[1]), v[2]); }

/* The vectors from the re-centred middle to a triangle's corners. */
static void ways_to(const mcv_scene *scene, const mcv_packed *packed, uint32_t instance,
                    uint32_t triangle, const float middle[3], double ways[3][3]) {
    mcv_scene_corners(scene, instance, triangle, ways);
    for (int c = 0; c < 3; ++c)
        for (int k = 0; k < 3; ++k) ways[c][k] -= packed->centre[k] + (double)middle[k];
}

/*
 * The region that the emitter can light, and how its light falls with distance
 * (kernels/light/selection.h). An emitter at infinity has the power that falls on the scene's
 * bounding ball. size: of the scene, mcv_packed_size.
 */
static void find_reach(const mcv_scene *scene, const mcv_packed *packed, double size,
                       const mcv_emitter *from, mcv_device_emitter *to) {
    to->radius = -1;
    to->narrowest =
        (float)(size / 2 * (size / 2) * (from->type == MCV_EMITTER_ENVIRONMENT ? 4 : 1));
    if (from->type == MCV_EMITTER_ENVIRONMENT || from->type == MCV_EMITTER_DIRECTIONAL ||
        from->type == MCV_EMITTER_LASER)
        return;
    const bool has_surface = mcv_emitter_has_surface(from->type);
    const double area = has_surface ? from->area : 0,
                 beam = from->type == MCV_EMITTER_COLLIMATED_BEAM;
    to->narrowest = (float)(area / M_PI);
    to->widening =
        beam ? 0 : (float)(mcv_emitter_unit_power(scene, from) / (M_PI * (has_surface ? area : 1)));
    to->radius = 0;
    if (!has_surface) {
        memcpy(to->middle, to->light.position, sizeof to->middle);
        return;
    }
    double radius = 0, facing[3] = {0, 0, 0}, ways[3][3];
    for (uint32_t t = 0; t < to->triangle_count; ++t) {
        double face[3];
        mcv_scene_face_normal(scene, from->instance, t, face);
        ways_to(scene, packed, from->instance, t, to->middle, ways);
        for (int c = 0; c < 3; ++c) radius = fmax(radius, length(ways[c]));
        for (int k = 0; k < 3 && length(face) > 0; ++k)
            facing[k] += face[k] / length(face) / to->triangle_count;
    }
    /* The margin is four times the rounding of the corners. */
    to->radius = nextafterf((float)(radius + size * 0x1p-22), INFINITY);
    /* Flat within the resolution of float coordinates: if normals differ, their mean is shorter
     * than 1 by the square of the angle. */
    bool is_flat = length(facing) > 1 - 1e-12;
    for (uint32_t t = 0; is_flat && t < to->triangle_count; ++t) {
        ways_to(scene, packed, from->instance, t, to->middle, ways);
        for (int c = 0; c < 3; ++c) {
            const double height =
                ways[c][0] * facing[0] + ways[c][1] * facing[1] + ways[c][2] * facing[2];
            is_flat = is_flat && fabs(height) <= 0x1p-20 * (radius + length(packed->centre));
        }
    }
    for (int k = 0; is_flat && k < 3; ++k) to->facing[k] = (float)facing[k];
}

/* The triangles' shares of the area, from entry `next` of the table on. */
static void pack_surface(const mcv_scene *scene, mcv_packed *packed, const mcv_emitter *from,
                         uint32_t number, size_t next, double *areas) {
    mcv_device_emitter *to = &packed->emitters[number];
    to->cdf = (uint32_t)next;
    to->triangle_count = scene->meshes[scene->instances[from->instance].mesh].triangle_count;
    for (uint32_t t = 0; t < to->triangle_count; ++t)
        areas[t] = mcv_scene_triangle_area(scene, from->instance, t);
    mcv_write_cdf(packed->emitter_cdf + next, to->triangle_count, areas);
    find_middle(packed, from->instance, to->middle);
    packed->instances[from->instance].emitter = number;
}

bool mcv_is_sampled(const mcv_emitter *emitter) {
    return emitter->type != MCV_EMITTER_ENVIRONMENT || emitter->texture != MCV_NONE;
}

uint32_t mcv_emitter_elements(const mcv_scene *scene, const mcv_emitter *emitter) {
    if (!emitter->by_pixel) return 1;
    const mcv_texture *image = scene->textures + emitter->texture;
    return image->width * image->height;
}

/* Entries of an environment's image in the table of shares: of its rows, then of each row's pixels.
 */
size_t mcv_environment_entries(const mcv_texture *image) {
    return image->height + 1 + (size_t)image->height * (image->width + 1);
}

/*
 * The shares of rows and pixels in the sky's light beyond its mean over all directions, from entry
 * `next` of the table on. What is not brighter than the mean surfaces find well by themselves (MIS
 * compensation: Karlik et al., MIS Compensation, ACM TOG 38(6), 2019); a sky of one colour is
 * shared as it is.
 */
static mcv_result pack_environment(const mcv_scene *scene, mcv_packed *packed,
                                   const mcv_emitter *from, uint32_t number, size_t next,
                                   mcv_error *error) {
    const mcv_texture *image = scene->textures + from->texture;
    bool failed = false;
    double *rows = mcv_pack_allocate(image->height, sizeof(double), &failed);
    double *pixels = mcv_pack_allocate(image->width, sizeof(double), &failed);
    double decoded[256], mean[3];
    mcv_emitter_image_mean(scene, from, mean);
    const double common = sum_of_channels(from, mean);
    mcv_srgb_table(decoded);
    for (uint32_t row = 0; !failed && row < image->height; ++row) {
        uint32_t *cdf =
            packed->emitter_cdf + next + image->height + 1 + (size_t)row * (image->width + 1);
        for (uint32_t column = 0; column < image->width; ++column) {
            double rgb[3];
            mcv_texture_value(image, decoded, column, row, rgb);
            const double light = sum_of_channels(from, rgb);
            pixels[column] = fmax(light - common, 0) + light / 64;
        }
        rows[row] = mcv_write_cdf(cdf, image->width, pixels) *
                    sin((2.0 * row + 1) * M_PI / (2.0 * image->height));
    }
    if (!failed) mcv_write_cdf(packed->emitter_cdf + next, image->height, rows);
    packed->emitters[number].cdf = (uint32_t)next;
    packed->environment_emitter = number;
    free(rows);
    free(pixels);
    return failed ? mcv_fail(error, MCV_FAILED, "%s: no memory for the environment's image",
                             scene->path)
                  : MCV_OK;
}

size_t mcv_laser_entries(const mcv_scene *scene, const mcv_emitter *emitter) {
    if (emitter->type != MCV_EMITTER_LASER || emitter->texture == MCV_NONE) return 0;
    return (size_t)scene->textures[emitter->texture].width + 1;
}

/* The columns' shares of a laser's fan, from entry `next` of the table on. */
static mcv_result pack_laser(const mcv_scene *scene, mcv_packed *packed, const mcv_emitter *from,
                             uint32_t number, size_t next, mcv_error *error) {
    const mcv_texture *image = scene->textures + from->texture;
    bool failed = false;
    double *columns = mcv_pack_allocate(image->width, sizeof(double), &failed);
    if (failed)
        return mcv_fail(error, MCV_FAILED, "%s: no memory for a laser's table", scene->path);
    mcv_laser_table(image, columns);
    mcv_write_cdf(packed->emitter_cdf + next, image->width, columns);
    packed->emitters[number].cdf = (uint32_t)next;
    free(columns);
    return MCV_OK;
}

mcv_result mcv_pack_emitters(const mcv_scene *scene, mcv_packed *packed, mcv_error *error) {
    uint32_t *cdf = packed->emitter_cdf;
    size_t next = packed->emitter_count + 1;
    const double size = mcv_packed_size(packed);
    uint32_t count = 0, elements = 0;
    bool failed = false;
    mcv_result result = MCV_OK;
    double *powers = mcv_pack_allocate(scene->emitter_count, sizeof(double), &failed);
    double *areas = mcv_pack_allocate(scene->triangle_count, sizeof(double), &failed);
    for (uint32_t i = 0; !failed && result == MCV_OK && i < scene->emitter_count; ++i) {
        const mcv_emitter *from = &scene->emitters[i];
        const uint32_t first_emitter_element = elements;
        elements += mcv_emitter_elements(scene, from);
        if (from->type == MCV_EMITTER_ENVIRONMENT)
            packed->environment_element = first_emitter_element;
        if (!mcv_is_sampled(from)) continue;
        mcv_device_emitter *to = &packed->emitters[count];
        *to = (mcv_device_emitter){.type = from->type,
                                   .instance = from->instance,
                                   .texture = from->texture,
                                   .area = (float)from->area,
                                   .first_emitter_element = first_emitter_element};
        if (from->by_pixel) to->emitter_element_width = scene->textures[from->texture].width;
        for (int k = 0; k < 3; ++k) to->radiance[k] = (float)from->radiance[k];
        if (mcv_emitter_has_surface(from->type)) {
            pack_surface(scene, packed, from, count, next, areas);
            next += to->triangle_count + 1;
        }
        if (from->type == MCV_EMITTER_ENVIRONMENT) {
            result = pack_environment(scene, packed, from, count, next, error);
            next += mcv_environment_entries(scene->textures + from->texture);
        }
        if (mcv_laser_entries(scene, from) > 0) {
            result = pack_laser(scene, packed, from, count, next, error);
            next += mcv_laser_entries(scene, from);
        }
        prepare_emitter(scene, packed, i, to);
        find_reach(scene, packed, size, from, to);
        mcv_pack_rectangle(scene, packed, to);
        powers[count++] = emitter_power(scene, size, from);
    }
    if (!failed) {
        double all = 0;
        for (uint32_t i = 0; i < count; ++i) all += powers[i];
        for (uint32_t i = 0; i < count && all > 0; ++i)
            packed->emitters[i].power = (float)(powers[i] / all);
        share_choices(powers, count);
        mcv_write_cdf(cdf, count, powers);
        for (uint32_t i = 0; i < count; ++i)
            packed->emitters[i].probability = (float)((cdf[i + 1] - cdf[i]) * 0x1p-31);
    }
    free(powers);
    free(areas);
    if (failed) return mcv_fail(error, MCV_FAILED, "%s: no memory for the emitters", scene->path);
    if (result != MCV_OK) return result;
    packed->light_cdf = (uint32_t)next;
    return count > MCV_MOST_REACHING ? mcv_pack_light_tree(scene, packed, error) : MCV_OK;
}
