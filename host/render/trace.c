/* SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "device/device_scene.h"
#include "device/features.h"
#include "render/render.h"

enum { MAX_BATCH = 16384, MAX_BATCH_BYTES = 64 << 20 };

typedef struct tracer {
    mcv_cl cl;
    mcv_device_scene scene;
    cl_program program;
    cl_kernel kernel;
    cl_mem paths, rays, vertices, counts;
    uint32_t batch, stride;
    mcv_device_ray *host_rays;
    mcv_device_vertex *host_vertices;
    uint32_t *host_counts;
} tracer;

static mcv_result open_tracer(tracer *t, const mcv_scene *scene, size_t ray_count,
                              const mcv_render_options *options, mcv_error *error) {
    char defines[2048];
    MCV_TRY(mcv_cl_open(options->device, &t->cl, error));
    MCV_TRY(mcv_device_scene_begin(&t->cl, scene, options->threads, NULL, &t->scene, error));
    if (options->precision == MCV_PRECISION_MIXED) {
        const mcv_feature_options mixed = {.mixed = true};
        t->scene.packed.features = mcv_decide_features(scene, &t->scene.packed, NULL, mixed, NULL);
        MCV_TRY(mcv_device_scene_refine(&t->cl, scene, &t->scene, error));
    }
    MCV_TRY(mcv_device_scene_finish(&t->cl, NULL, &t->scene, error));
    const mcv_packed *packed = &t->scene.packed;
    mcv_feature_defines(packed->features, packed->channels, MCV_SENSOR_PINHOLE, MCV_SAMPLER_SOBOL,
                        MCV_BLOCK, defines, sizeof defines);
    MCV_TRY(mcv_cl_build(&t->cl, "schedule/trace", defines, &t->program, error));
    MCV_TRY(mcv_cl_kernel(t->program, "trace_paths", &t->kernel, error));

    t->stride = options->depth + 1;
    const size_t fits = MAX_BATCH_BYTES / (t->stride * sizeof(mcv_device_vertex));
    t->batch = (uint32_t)(fits < 1 ? 1 : fits < MAX_BATCH ? fits : MAX_BATCH);
    if (ray_count < t->batch) t->batch = (uint32_t)ray_count;
    const size_t vertices = (size_t)t->batch * t->stride;
    t->host_rays = malloc(t->batch * sizeof *t->host_rays);
    t->host_vertices = malloc(vertices * sizeof *t->host_vertices);
    t->host_counts = malloc(t->batch * sizeof *t->host_counts);
    if (!t->host_rays || !t->host_vertices || !t->host_counts) {
        return mcv_fail(error, MCV_FAILED, "no memory for the vertices of %u paths of depth %u",
                        t->batch, options->depth);
    }
    const size_t words = mcv_path_words(packed->features, packed->channels);
    MCV_TRY(mcv_cl_buffer(&t->cl, "the paths", 4 * words * t->batch, NULL, &t->paths, error));
    MCV_TRY(
        mcv_cl_buffer(&t->cl, "the rays", t->batch * sizeof *t->host_rays, NULL, &t->rays, error));
    MCV_TRY(mcv_cl_buffer(&t->cl, "the vertices", vertices * sizeof *t->host_vertices, NULL,
                          &t->vertices, error));
    MCV_TRY(mcv_cl_buffer(&t->cl, "the numbers of vertices", 4 * (size_t)t->batch, NULL, &t->counts,
                          error));
    mcv_frame frame = {.depth = options->depth,
                       .environment_emitter = packed->environment_emitter,
                       .solid_count = packed->solid_count};
    memcpy(frame.environment, packed->environment, sizeof frame.environment);
    return mcv_cl_write(&t->cl, t->scene.frame, 0, sizeof frame, &frame, error);
}

static void close_tracer(tracer *t) {
    mcv_cl_release(&t->paths);
    mcv_cl_release(&t->rays);
    mcv_cl_release(&t->vertices);
    mcv_cl_release(&t->counts);
    if (t->kernel) clReleaseKernel(t->kernel);
    if (t->program) clReleaseProgram(t->program);
    mcv_device_scene_close(&t->scene);
    mcv_cl_close(&t->cl);
    free(t->host_rays);
    free(t->host_vertices);
    free(t->host_counts);
}

static mcv_result device_ray(const tracer *t, const mcv_scene *scene, const mcv_trace_ray *ray,
                             size_t index, mcv_device_ray *out, mcv_error *error) {
    const mcv_packed *packed = &t->scene.packed;
    const double *d = ray->direction;
    const double length = sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
    const bool finite =
        isfinite(ray->origin[0]) && isfinite(ray->origin[1]) && isfinite(ray->origin[2]);
    if (!finite || !isfinite(length) || !(length > 0)) {
        return mcv_fail(error, MCV_BAD_INPUT,
                        "ray %zu: origin and direction must be finite and the direction not zero",
                        index);
    }
    for (int k = 0; k < 3; ++k) {
        const double origin = ray->origin[k] - packed->centre[k], direction = d[k] / length;
        out->origin[k] = (float)origin;
        out->direction[k] = (float)direction;
        out->origin_low[k] = (float)(origin - out->origin[k]);
        out->direction_low[k] = (float)(direction - out->direction[k]);
    }
    out->media = mcv_media_around(scene, packed, ray->origin);
    memset(out->padding, 0, sizeof out->padding);
    return MCV_OK;
}

static mcv_vertex host_vertex(const mcv_packed *packed, const mcv_device_vertex *from, uint32_t ray,
                              uint32_t index) {
    mcv_vertex to = {
        .ray = ray, .index = index, .primitive = from->primitive, .event = from->event};
    to.distance = from->distance + (double)from->distance_low;
    if (to.primitive != MCV_NONE &&
        to.primitive >= MCV_EXACT) /* 4 per solid there, 3 here, after the triangles */
        to.primitive =
            packed->triangle_count + 3 * mcv_solid_of(to.primitive) + mcv_piece_of(to.primitive);
    for (int k = 0; k < 3; ++k) {
        to.position[k] = from->position[k] + (double)from->position_low[k] + packed->centre[k];
        to.normal[k] = from->normal[k] + (double)from->normal_low[k];
        to.direction[k] = from->direction[k] + (double)from->direction_low[k];
    }
    to.ior = from->medium > 0
                 ? sqrt(1 / (double)packed->medium_table[0][from->medium].inverse_index_squared)
                 : 1;
    to.transmittance = from->transmittance;
    to.radiance = from->radiance;
    return to;
}

/* Appends to a growing array. */
static bool append(mcv_vertex **vertices, size_t *count, size_t *capacity,
                   const mcv_vertex *vertex) {
    if (*count == *capacity) {
        const size_t larger = *capacity > 0 ? 2 * *capacity : 1024;
        mcv_vertex *moved = realloc(*vertices, larger * sizeof **vertices);
        if (!moved) return false;
        *vertices = moved;
        *capacity = larger;
    }
    (*vertices)[(*count)++] = *vertex;
    return true;
}

static mcv_result trace_batch(tracer *t, const mcv_scene *scene, const mcv_trace_ray *rays,
                              size_t first, uint32_t batch, mcv_error *error) {
    mcv_arg arguments[MCV_SCENE_ARGUMENTS + 5];
    for (uint32_t i = 0; i < batch; ++i)
        MCV_TRY(device_ray(t, scene, &rays[first + i], first + i, &t->host_rays[i], error));
    MCV_TRY(mcv_cl_write(&t->cl, t->rays, 0, batch * sizeof *t->host_rays, t->host_rays, error));
    mcv_device_scene_arguments(&t->scene, arguments);
    arguments[MCV_SCENE_ARGUMENTS] = MCV_ARG(t->paths);
    arguments[MCV_SCENE_ARGUMENTS + 1] = MCV_ARG(t->stride);
    arguments[MCV_SCENE_ARGUMENTS + 2] = MCV_ARG(t->rays);
    arguments[MCV_SCENE_ARGUMENTS + 3] = MCV_ARG(t->vertices);
    arguments[MCV_SCENE_ARGUMENTS + 4] = MCV_ARG(t->counts);
    MCV_TRY(mcv_cl_launch(&t->cl, t->kernel, batch, 1, arguments, MCV_SCENE_ARGUMENTS + 5, NULL,
                          error));
    MCV_TRY(mcv_cl_read(&t->cl, t->counts, 0, 4 * (size_t)batch, t->host_counts, error));
    return mcv_cl_read(&t->cl, t->vertices, 0, (size_t)batch * t->stride * sizeof *t->host_vertices,
                       t->host_vertices, error);
}

mcv_result mcv_trace(const mcv_scene *scene, const mcv_trace_ray *rays, size_t ray_count,
                     const mcv_render_options *options, mcv_vertex **vertices, size_t *vertex_count,
                     mcv_error *error) {
    tracer t = {0};
    size_t capacity = 0;
    *vertices = NULL;
    *vertex_count = 0;
    if (ray_count == 0) return MCV_OK;
    if (options->depth < 1 || options->depth > 1000000)
        return mcv_fail(error, MCV_USAGE, "depth must be 1 to 1000000, not %u", options->depth);
    if (options->precision > MCV_PRECISION_MIXED)
        return mcv_fail(
            error, MCV_USAGE,
            "precision must be single or mixed on a device: double is for the reference renderer");
    if (ray_count > 0xffffffffu)
        return mcv_fail(error, MCV_USAGE, "at most 2^32 rays can be traced at once");
    mcv_result result = open_tracer(&t, scene, ray_count, options, error);
    for (size_t first = 0; result == MCV_OK && first < ray_count; first += t.batch) {
        const uint32_t batch =
            (uint32_t)(ray_count - first < t.batch ? ray_count - first : t.batch);
        result = trace_batch(&t, scene, rays, first, batch, error);
        for (uint32_t i = 0; result == MCV_OK && i < batch; ++i) {
            for (uint32_t k = 0; result == MCV_OK && k < t.host_counts[i]; ++k) {
                const mcv_vertex vertex =
                    host_vertex(&t.scene.packed, &t.host_vertices[(size_t)i * t.stride + k],
                                (uint32_t)(first + i), k);
                if (!append(vertices, vertex_count, &capacity, &vertex))
                    result = mcv_fail(error, MCV_FAILED, "no memory for the vertices of the paths");
            }
        }
    }
    close_tracer(&t);
    if (result != MCV_OK) {
        free(*vertices);
        *vertices = NULL;
        *vertex_count = 0;
    }
    return result;
}
