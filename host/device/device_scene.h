/* SPDX-License-Identifier: Apache-2.0 */
/* A packed scene with its acceleration structure in the device's memory, as the kernels' first
 * arguments (kernels/world.h). */
#ifndef MCVISI_HOST_DEVICE_DEVICE_SCENE_H
#define MCVISI_HOST_DEVICE_DEVICE_SCENE_H

#include "cl/cl.h"
#include "accel/update.h"
#include "device/digest.h"
#include "device/pack.h"
#include "mcvisi/buffers.h"

/* Indices of the buffers, in the order of the kernels' arguments. */
enum {
#define MCV_X(space, type, name, what, bytes, data) MCV_BUFFER_##name,
    MCV_BUFFERS(MCV_X)
#undef MCV_X
        MCV_SCENE_ARGUMENTS
};

typedef struct mcv_device_scene {
    mcv_packed packed; /* its large arrays are freed once they are on the device */
    struct mcv_hierarchy_build *in_building; /* between begin and finish */
    union {
        cl_mem buffers[MCV_SCENE_ARGUMENTS];
        struct {
#define MCV_X(space, type, name, what, bytes, data) cl_mem name;
            MCV_BUFFERS(MCV_X)
#undef MCV_X
        };
    };
    cl_mem splats; /* [replicate][channel][row][column], 64 bits each: the sums of light paths so
                      far */
    bool kept_structure;    /* the acceleration structure is that of the previous scene, refitted if
                               triangles have moved */
    bool updated_structure; /* it is new for what has changed alone (mcv_bvh_update) */
    mcv_bvh_base
        base; /* what it was made from, and those of the scenes that follow are; or empty */
    mcv_digest indices_digest; /* of the indices it was built for; for the positions see contents */
    uint32_t node_count, leaf_count;
    uint32_t moving[2];                       /* the first node and leaf of what moves */
    double structure_cost;                    /* when it was built; 0: not yet computed */
    mcv_digest contents[MCV_SCENE_ARGUMENTS]; /* of the buffers */
} mcv_device_scene;

/*
 * Packs the scene and starts a thread that builds the acceleration structure. The features, from
 * which programs are compiled, are then known. mcv_device_scene_close must be called even after a
 * failure.
 *
 * `kept` is the scene rendered before on the same device, or NULL. Buffers with the same contents
 * are taken from it, and the acceleration structure if triangles have moved only a little. Where
 * some of the triangles are new, only these are built anew. `kept` must still be closed, after
 * mcv_device_scene_finish.
 */
mcv_result mcv_device_scene_begin(mcv_cl *cl, const mcv_scene *scene, uint32_t threads,
                                  mcv_device_scene *kept, mcv_device_scene *device,
                                  mcv_error *error);

/* Between begin and finish: adds what `--precision mixed` needs. MCV_DEVICE if the device has no
 * double precision. */
mcv_result mcv_device_scene_refine(const mcv_cl *cl, const mcv_scene *scene,
                                   mcv_device_scene *device, mcv_error *error);

/* Waits for the acceleration structure, plans the buffers against the device's limits and fills
 * them. */
mcv_result mcv_device_scene_finish(mcv_cl *cl, mcv_device_scene *kept, mcv_device_scene *device,
                                   mcv_error *error);

/* Both steps, for a scene without a previous one. */
mcv_result mcv_device_scene_open(mcv_cl *cl, const mcv_scene *scene, uint32_t threads,
                                 mcv_device_scene *device, mcv_error *error);
void mcv_device_scene_close(mcv_device_scene *device);

/* Places a sensor: fills its buffer, and the fields of the frame that depend on sensor and scene
 * alone. */
mcv_result mcv_device_scene_place(mcv_cl *cl, const mcv_scene *scene, uint32_t sensor,
                                  mcv_device_scene *device, mcv_frame *frame, mcv_error *error);

void mcv_device_scene_arguments(const mcv_device_scene *device,
                                mcv_arg arguments[MCV_SCENE_ARGUMENTS]);

/* The splats have room for at least so many replicates: a pilot's. */
enum { MCV_LIGHT_REPLICATES = 4 };

/* From now on, a light path starts for every 2^log2_thinning-th pixel of the frame, or none does:
 * MCV_NO_LIGHT_PATHS, which mcv_camera_finds_light must allow. */
void mcv_frame_thin_light(mcv_frame *frame, uint32_t log2_thinning);

/* What one unit of the splats adds to a pixel's sum of samples; 0 without light paths. */
double mcv_frame_splat_value(const mcv_frame *frame);

#endif
