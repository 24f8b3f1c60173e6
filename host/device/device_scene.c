/* SPDX-License-Identifier: Apache-2.0 */
#include "device/device_scene.h"

#include <pthread.h>
#include <stdlib.h>
#include <string.h>

#include "device/hierarchy.h"
#include "device/keep_hierarchy.h"
#include "device/light.h"
#include "scene/motion.h"
#include "scene/sensors.h"

/* The device structs of all sensors, for the size of the buffer. */
typedef union any_sensor {
#define MCV_X(name, key, NAME) mcv_##name name;
    MCV_SENSORS(MCV_X)
#undef MCV_X
} any_sensor;

/* The sources of the buffers. */
typedef struct plan {
    const char *what;
    size_t bytes;
    const void *data;
} plan;

/* The size of an optional array, 0 if the scene lacks it. */
static size_t present(const void *data, size_t bytes) { return data ? bytes : 0; }

/* Takes the buffer from the previous scene if that has one of this size. */
static void take_buffer(mcv_device_scene *kept, mcv_device_scene *d, size_t bytes, uint32_t index) {
    if (kept->contents[index].bytes != bytes) return;
    d->buffers[index] = kept->buffers[index];
    kept->buffers[index] = NULL;
}

/* The acceleration structure is new or already taken. mcv_keep_hierarchy has computed
 * the digest of the positions. */
static mcv_result fill_buffer(mcv_cl *cl, const plan *p, uint32_t index, mcv_device_scene *kept,
                              mcv_device_scene *d, mcv_error *error) {
    const bool structure = index == MCV_BUFFER_nodes || index == MCV_BUFFER_leaves;
    cl_mem *buffer = &d->buffers[index];
    if (p->bytes == 0) return MCV_OK;
    if (structure) return mcv_cl_buffer(cl, p->what, p->bytes, p->data, buffer, error);
    if (index != MCV_BUFFER_positions)
        d->contents[index] =
            p->data ? mcv_digest_of(p->data, p->bytes) : (mcv_digest){.bytes = p->bytes};
    if (kept) take_buffer(kept, d, p->bytes, index);
    if (!*buffer) return mcv_cl_buffer(cl, p->what, p->bytes, p->data, buffer, error);
    return kept && p->data && !mcv_digest_same(&kept->contents[index], &d->contents[index])
               ? mcv_cl_write(cl, *buffer, 0, p->bytes, p->data, error)
               : MCV_OK;
}

/* bvh is NULL if the structure of the previous scene is already taken. */
static mcv_result fill_buffers(mcv_cl *cl, const mcv_bvh *bvh, mcv_device_scene *kept,
                               mcv_device_scene *d, mcv_error *error) {
    const mcv_packed *p = &d->packed;
    const size_t vertices = p->vertex_count;
    const size_t triangles = p->triangle_count;
    const bool dielectric = p->features >> MCV_FEATURE_DIELECTRIC & 1;
    const size_t tables = !dielectric                                 ? 0
                          : p->features >> MCV_FEATURE_DISPERSION & 1 ? 3
                                                                      : 1; /* of media */
    const bool mixed = p->features >> MCV_FEATURE_MIXED & 1;
    const bool textures = p->features >> MCV_FEATURE_TEXTURE & 1;
    const plan plans[] = {
#define MCV_X(space, type, name, what, bytes, data) {what, bytes, data},
        MCV_BUFFERS(MCV_X)
#undef MCV_X
    };
    size_t total = 0;
    for (uint32_t i = 0; i < MCV_SCENE_ARGUMENTS; ++i) total += plans[i].bytes;
    if (total > cl->memory) {
        return mcv_fail(
            error, MCV_DEVICE,
            "the scene needs %.1f MiB, but %s has %.1f MiB: use fewer triangles or another device",
            (double)total / 0x1p20, cl->name, (double)cl->memory / 0x1p20);
    }
    for (uint32_t i = 0; i < MCV_SCENE_ARGUMENTS; ++i)
        MCV_TRY(fill_buffer(cl, plans + i, i, kept, d, error));
    return MCV_OK;
}

/* The large arrays, which only the device needs. */
static void free_vertices(mcv_packed *packed) {
    float **const arrays[] = {&packed->positions, &packed->normals,       &packed->texcoords,
                              &packed->tangents,  &packed->position_lows, &packed->normal_lows};
    uint32_t **const tables[] = {&packed->triangles, &packed->emitter_cdf, &packed->texels};
    for (size_t i = 0; i < sizeof arrays / sizeof arrays[0]; ++i) {
        free(*arrays[i]);
        *arrays[i] = NULL;
    }
    for (size_t i = 0; i < sizeof tables / sizeof tables[0]; ++i) {
        free(*tables[i]);
        *tables[i] = NULL;
    }
}

/* The acceleration structure while a thread builds it. */
typedef struct mcv_hierarchy_build {
    const mcv_packed *packed;
    uint32_t threads;
    bool own_thread;
    pthread_t thread;
    mcv_bvh bvh;
    uint32_t moving[2]; /* where the part of what moves begins */
    mcv_result result;
    mcv_error error;
} mcv_hierarchy_build;

static void *build_hierarchy(void *user) {
    mcv_hierarchy_build *b = user;
    b->result = mcv_build_hierarchy(b->packed, b->threads, &b->bvh, b->moving, &b->error);
    return NULL;
}

mcv_result mcv_device_scene_begin(mcv_cl *cl, const mcv_scene *scene, uint32_t threads,
                                  mcv_device_scene *kept, mcv_device_scene *device,
                                  mcv_error *error) {
    memset(device, 0, sizeof *device);
    MCV_TRY(mcv_pack(scene, kept ? &kept->packed : NULL, &device->packed, error));
    mcv_hierarchy_build *b = device->in_building = calloc(1, sizeof *b);
    if (!b) return mcv_fail(error, MCV_FAILED, "no memory for the acceleration structure");
    b->packed = &device->packed;
    b->threads = threads;
    MCV_TRY(mcv_keep_hierarchy(cl, kept, threads, device, &b->bvh, error));
    device->updated_structure = b->bvh.nodes != NULL;
    if (device->kept_structure || device->updated_structure) return MCV_OK;
    b->own_thread = pthread_create(&b->thread, NULL, build_hierarchy, b) == 0;
    if (!b->own_thread) build_hierarchy(b);
    return MCV_OK;
}

mcv_result mcv_device_scene_refine(const mcv_cl *cl, const mcv_scene *scene,
                                   mcv_device_scene *device, mcv_error *error) {
    cl_device_fp_config config = 0;
    const cl_int code =
        clGetDeviceInfo(cl->device, CL_DEVICE_DOUBLE_FP_CONFIG, sizeof config, &config, NULL);
    if (code != CL_SUCCESS || !(config & CL_FP_FMA))
        return mcv_fail(error, MCV_DEVICE,
                        "%s has no double precision: give --precision single, or double for the "
                        "reference renderer",
                        cl->name);
    return mcv_pack_precise(scene, &device->packed, error);
}

static void wait_for_hierarchy(mcv_device_scene *device) {
    mcv_hierarchy_build *b = device->in_building;
    if (b && b->own_thread) pthread_join(b->thread, NULL);
    if (b) b->own_thread = false;
    free(device->packed.indices);
    device->packed.indices = NULL;
}

static void end_building(mcv_device_scene *device) {
    if (device->in_building) mcv_bvh_free(&device->in_building->bvh);
    free(device->in_building);
    device->in_building = NULL;
    free_vertices(&device->packed);
}

mcv_result mcv_device_scene_finish(mcv_cl *cl, mcv_device_scene *kept, mcv_device_scene *device,
                                   mcv_error *error) {
    wait_for_hierarchy(device);
    const mcv_hierarchy_build *b = device->in_building;
    mcv_result result = b->result;
    if (result == MCV_OK && !device->kept_structure) {
        device->node_count = b->bvh.node_count;
        device->leaf_count = b->bvh.leaf_count;
        memcpy(device->moving, b->moving, sizeof device->moving);
    }
    if (result == MCV_OK)
        result = fill_buffers(cl, &b->bvh, kept, device, error);
    else
        *error = b->error;
    end_building(device);
    return result;
}

mcv_result mcv_device_scene_open(mcv_cl *cl, const mcv_scene *scene, uint32_t threads,
                                 mcv_device_scene *device, mcv_error *error) {
    MCV_TRY(mcv_device_scene_begin(cl, scene, threads, NULL, device, error));
    return mcv_device_scene_finish(cl, NULL, device, error);
}

void mcv_device_scene_close(mcv_device_scene *device) {
    wait_for_hierarchy(device);
    end_building(device);
    for (uint32_t i = 0; i < MCV_SCENE_ARGUMENTS; ++i) mcv_cl_release(&device->buffers[i]);
    mcv_cl_release(&device->splats);
    mcv_bvh_base_free(&device->base);
    mcv_packed_free(&device->packed);
}

void mcv_frame_thin_light(mcv_frame *frame, uint32_t log2_thinning) {
    const uint64_t pixels = mcv_tiled_pixels(frame->width, frame->height);
    frame->log2_thinning = log2_thinning;
    frame->light_density =
        log2_thinning == MCV_NO_LIGHT_PATHS ? 0 : (float)(M_PI * (double)(pixels >> log2_thinning));
}

double mcv_frame_splat_value(const mcv_frame *frame) {
    const uint64_t pixels = mcv_tiled_pixels(frame->width, frame->height);
    if (frame->log2_thinning == MCV_NO_LIGHT_PATHS) return 0;
    return 1 / ((double)frame->splat_scale * (double)(pixels >> frame->log2_thinning));
}

static mcv_result open_splats(mcv_cl *cl, const mcv_sensor *sensor, mcv_device_scene *device,
                              mcv_frame *frame, mcv_error *error) {
    const mcv_packed *packed = &device->packed;
    const uint32_t replicates =
        frame->replicates > MCV_LIGHT_REPLICATES ? frame->replicates : MCV_LIGHT_REPLICATES;
    const size_t bytes = 8 * (size_t)frame->width * frame->height * packed->channels * replicates;
    frame->light_cdf = packed->light_cdf;
    frame->ball_count = packed->ball_count;
    memcpy(frame->balls, packed->balls, sizeof frame->balls);
    frame->splat_scale = (float)(1 / mcv_splat_unit(packed, sensor, frame));
    frame->log2_pixels = 6;
    while ((uint64_t)1 << frame->log2_pixels < mcv_tiled_pixels(frame->width, frame->height))
        ++frame->log2_pixels;
    mcv_frame_thin_light(frame, mcv_light_thinning(packed, sensor));
    MCV_TRY(mcv_cl_buffer(cl, "what light paths bring", bytes, NULL, &device->splats, error));
    return mcv_cl_clear(cl, device->splats, bytes, error);
}

mcv_result mcv_device_scene_place(mcv_cl *cl, const mcv_scene *scene, uint32_t sensor,
                                  mcv_device_scene *device, mcv_frame *frame, mcv_error *error) {
    const mcv_sensor *from = &scene->sensors[sensor];
    any_sensor prepared;
    memset(&prepared, 0, sizeof prepared);
    switch (from->type) {
#define MCV_X(name, key, NAME) \
    case MCV_SENSOR_##NAME: \
        mcv_##name##_prepare(&from->as.name, &prepared.name); \
        break;
        MCV_SENSORS(MCV_X)
#undef MCV_X
    default:
        return mcv_fail(error, MCV_FAILED, "sensor %u has the unknown type %u", sensor, from->type);
    }
    const mcv_readout readout = mcv_sensor_readout(from);
    frame->row_pitch = readout.film[0] * readout.angular[0];
    frame->first_pixel = readout.first[1] * readout.angular[1] * frame->row_pitch +
                         readout.first[0] * readout.angular[0];
    const mcv_packed *packed = &device->packed;
    frame->emitter_count = packed->emitter_count;
    frame->light_tree_depth = packed->light_tree_depth;
    frame->solid_count = packed->solid_count;
    frame->triangle_count = packed->triangle_count;
    frame->instance_count = packed->instance_count;
    frame->initial_media = mcv_media_around(scene, packed, from->to_world.m + 9);
    uint32_t filling = 0;
    while (filling < MCV_MAX_MEDIA && frame->initial_media >> filling != 0) ++filling;
    for (int k = 0; k < 3; ++k)
        frame->sensor_index_squared[k] =
            filling > 0 ? 1.0f / packed->medium_table[k][filling].inverse_index_squared : 1.0f;
    memcpy(frame->environment, packed->environment, sizeof frame->environment);
    frame->environment_emitter = packed->environment_emitter;
    frame->environment_element = packed->environment_element;
    mcv_pack_placement(packed, &from->to_world, frame->to_world, frame->to_world_low);
    mcv_motion_prepare(from, &frame->motion);
    mcv_part_motion_prepare(scene, packed->centre, &frame->part_motion);
    frame->moving_nodes = device->moving[0];
    frame->moving_leaves = device->moving[1];
    if (packed->features >> MCV_FEATURE_PUPIL_GUIDE & 1) {
        const size_t bytes = sizeof(mcv_device_pupil_guide) * frame->width * frame->height;
        MCV_TRY(mcv_cl_buffer(cl, "the pupil guides", bytes, NULL, &device->pupil_guides, error));
    }
    if (packed->features >> MCV_FEATURE_LIGHT_TRACING & 1)
        MCV_TRY(open_splats(cl, from, device, frame, error));
    return mcv_cl_write(cl, device->sensor, 0, sizeof prepared, &prepared, error);
}

void mcv_device_scene_arguments(const mcv_device_scene *device,
                                mcv_arg arguments[MCV_SCENE_ARGUMENTS]) {
    for (uint32_t i = 0; i < MCV_SCENE_ARGUMENTS; ++i) arguments[i] = MCV_ARG(device->buffers[i]);
}
