/* SPDX-License-Identifier: Apache-2.0 */
/* The device structs of emitters. */
#include "scene/emitter_shape.h"

#include "scene/sensors.h"
#include "scene/geometry.h"

#include <float.h>

/*
 * Do all vertices of all triangles have the same normal, and does the cone about it leave all
 * triangles on their front? Nothing emits from the back, whatever the normals say.
 */
static bool common_cone(const mcv_scene *scene, uint32_t instance, double beta, double normal[3]) {
    const uint32_t count = scene->meshes[scene->instances[instance].mesh].triangle_count;
    for (uint32_t t = 0; t < count; ++t) {
        double normals[3][3], face[3];
        mcv_scene_vertex_normals(scene, instance, t, normals);
        mcv_scene_face_normal(scene, instance, t, face);
        const double length = hypot(hypot(face[0], face[1]), face[2]);
        if (length > 0 &&
            !(face[0] * normals[0][0] + face[1] * normals[0][1] + face[2] * normals[0][2] >
              sin(beta) * length))
            return false;
        if (t == 0) memcpy(normal, normals[0], sizeof normals[0]);
        for (int corner = 0; corner < 3;
             ++corner) /* The device holds the axis in float32: what rounds to it is it. */
            for (int i = 0; i < 3; ++i)
                if ((float)normals[corner][i] != (float)normal[i]) return false;
    }
    return count > 0;
}

void mcv_parallel_prepare(const mcv_scene *scene, uint32_t index, mcv_parallel *device) {
    const mcv_emitter *emitter = scene->emitters + index;
    const double beta = mcv_emitter_half_angle(emitter);
    double axis[3] = {0, 0, 0};
    const bool common = common_cone(scene, emitter->instance, beta, axis);
    *device = (mcv_parallel){
        .tangent_squared = (float)(tan(beta) * tan(beta)),
        .sin_half = (float)sin(beta / 2),
        .solid_angle = (float)mcv_emitter_solid_angle(emitter),
        .from_receiver = common && beta <= M_PI / 6,
        .axis = {(float)axis[0], (float)axis[1], (float)axis[2]},
    };
}

void mcv_light_field_emitter_prepare(const mcv_scene *scene, uint32_t index,
                                     mcv_light_field_emitter *device) {
    const mcv_light_field_emitter_params *p = &scene->emitters[index].as.light_field_emitter;
    const double *m = scene->instances[scene->emitters[index].instance].to_world.m;
    *device = (mcv_light_field_emitter){.macro_width = p->spatialResolution[0],
                                        .macro_height = p->spatialResolution[1],
                                        .angular_width = p->angularResolution[0],
                                        .angular_height = p->angularResolution[1]};
    for (int i = 0; i < 3; ++i) {
        device->x[i] = (float)(m[3 * i] / p->angularRange);
        device->y[i] = (float)(m[3 * i + 1] / p->angularRange);
    }
}

/* The direction of the node's -z in the world. */
static void forward(const mcv_transform *rigid, float axis[3]) {
    for (int i = 0; i < 3; ++i) axis[i] = (float)-rigid->m[3 * i + 2];
}

void mcv_environment_prepare(const mcv_scene *scene, uint32_t index, mcv_environment *device) {
    const mcv_texture *image = scene->textures + scene->emitters[index].texture;
    const double *m = scene->emitters[index].to_world.m;
    *device = (mcv_environment){.width = image->width, .height = image->height};
    for (int i = 0; i < 3; ++i) {
        device->x[i] = (float)m[3 * i];
        device->y[i] = (float)m[3 * i + 1];
        device->z[i] = (float)m[3 * i + 2];
    }
}

void mcv_projector_prepare(const mcv_scene *scene, uint32_t index, mcv_projector *device) {
    const mcv_projector_params *p = &scene->emitters[index].as.projector;
    const mcv_transform *to_world = &scene->instances[scene->emitters[index].instance].to_world;
    const double kappa = mcv_kappa(p->focalLength, p->imageDistance);
    double edge[2];
    mcv_image_tangents(p, scene->textures + scene->emitters[index].texture, edge);
    *device = (mcv_projector){.blur = {(float)(kappa * p->lensDiameter / (2 * edge[0])),
                                       (float)(kappa * p->lensDiameter / (2 * edge[1]))}};
    for (int i = 0; i < 3; ++i) {
        device->x[i] = (float)(to_world->m[3 * i] / (p->mirror ? -2 * edge[0] : 2 * edge[0]));
        device->y[i] = (float)(to_world->m[3 * i + 1] / (-2 * edge[1]));
    }
    forward(to_world, device->axis);
}

void mcv_collimated_beam_prepare(const mcv_scene *scene, uint32_t index,
                                 mcv_collimated_beam *device) {
    const mcv_collimated_beam_params *p = &scene->emitters[index].as.collimated_beam;
    const mcv_transform *to_world = &scene->instances[scene->emitters[index].instance].to_world;
    *device =
        (mcv_collimated_beam){.half_width = (float)(p->size[0] / 2),
                              .half_height = (float)(p->size[1] / 2),
                              .radius_squared = (float)(mcv_beam_radius(p) * mcv_beam_radius(p))};
    for (int i = 0; i < 3; ++i) {
        device->x[i] = (float)to_world->m[3 * i];
        device->y[i] = (float)to_world->m[3 * i + 1];
    }
    forward(to_world, device->axis);
}

void mcv_surface_light_prepare(const mcv_scene *scene, uint32_t index, mcv_surface_light *device) {
    const mcv_emitter *emitter = scene->emitters + index;
    const mcv_screen_params *p = &emitter->as.screen;
    *device = (mcv_surface_light){.distribution = emitter->type};
    if (emitter->type != MCV_EMITTER_SCREEN) return;
    if (!mcv_screen_has_structure(emitter)) { /* one without the feature SCREEN */
        device->distribution = MCV_EMITTER_AREA;
        return;
    }
    uint32_t pixels[2];
    mcv_picture_resolution(&p->pattern, scene->textures + emitter->texture, pixels);
    device->as.screen = (mcv_screen){.exponent = (float)p->falloffExponent,
                                     .columns = pixels[0],
                                     .rows = pixels[1],
                                     .lit = {(float)(1 - p->pixelGap[0] / p->pixelPitch[0]),
                                             (float)(1 - p->pixelGap[1] / p->pixelPitch[1])}};
}

void mcv_point_light_prepare(const mcv_scene *scene, uint32_t index, const double centre[3],
                             mcv_point_light *device) {
    const mcv_emitter *emitter = scene->emitters + index;
    const double range = *mcv_emitter_range(emitter);
    *device = (mcv_point_light){.distribution = emitter->type,
                                .edge = 1,
                                .inverse_range_4 = isnan(range) ? 0 : (float)pow(range, -4)};
    for (int i = 0; i < 3; ++i)
        device->position[i] = (float)(emitter->to_world.m[9 + i] - centre[i]);
    forward(&emitter->to_world, device->axis);
    if (emitter->type == MCV_EMITTER_SPOT) {
        const double outer = mcv_half_sine_squared(emitter->as.spot.outerConeAngle),
                     inner = mcv_half_sine_squared(emitter->as.spot.innerConeAngle);
        device->edge = (float)outer;
        device->as.spot.slope =
            (float)fmin(1 / (outer - inner), FLT_MAX); /* finite for a sharp edge, too */
    }
}

void mcv_directional_prepare(const mcv_scene *scene, uint32_t index, mcv_directional *device) {
    forward(&scene->emitters[index].to_world, device->axis);
}
