/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The two ways to drive the same stages: tile (one launch per pass, a slice of paths per work-item,
 * for CPUs) and stream (one launch per stage, for GPUs). Both give the same bits.
 */
#ifndef MCVISI_HOST_RENDER_SCHEDULE_H
#define MCVISI_HOST_RENDER_SCHEDULE_H

#include "device/device_scene.h"
#include "render/render.h"

/* X(kernel of kernels/schedule/stream.cl): the stages in their order, then the count. */
#define MCV_STREAM_KERNELS(X) MCV_STAGES(X) X(count_rays, 1)
#define MCV_X(stage, runs) MCV_KERNEL_##stage,
enum { MCV_STREAM_KERNELS(MCV_X) MCV_STREAM_KERNEL_COUNT };
#undef MCV_X

/*
 * Stream: how many depths the host is ahead of the device, so that neither waits, and how many
 * there are between two times that the launches are forgotten.
 */
enum { MCV_DEPTHS_AHEAD = 4, MCV_TIMED_DEPTHS = 64, MCV_MAX_LAUNCHES = 4 * MCV_TIMED_DEPTHS + 8 };

typedef struct mcv_schedule {
    mcv_cl *cl;
    const mcv_device_scene *scene;
    uint32_t kind;     /* MCV_SCHEDULE_TILE or _STREAM */
    uint32_t capacity; /* paths of a launch at most */
    uint32_t slice;    /* paths per slice (tile) */
    uint32_t branches; /* of a path at most */
    uint32_t depth;
    cl_program program;
    cl_kernel
        kernels[MCV_STREAM_KERNEL_COUNT]; /* tile: for generate_rays that of all stages; stream:
                                             NULL where the scene needs no such stage */
    cl_mem paths, sums, counters;
    uint32_t counter_sets;  /* of the launch under way */
    cl_mem queues, lengths; /* stream */
    struct {                /* of the launch under way */
        mcv_frame frame;
        uint32_t depth;                     /* the next to be launched */
        cl_uint living[MCV_DEPTHS_AHEAD];   /* after the latest depths, by depth modulo
                                               MCV_DEPTHS_AHEAD … */
        cl_event answers[MCV_DEPTHS_AHEAD]; /* … once they are read */
    } stream;
    cl_event launches[MCV_MAX_LAUNCHES]; /* since the last wait, with their kernels: for the stages'
                                            times */
    uint32_t launched[MCV_MAX_LAUNCHES];
    uint32_t launch_count;
} mcv_schedule;

/* Chooses by the device where options->schedule is auto, builds the program, allocates. Close it
 * even after a failure. */
mcv_result mcv_schedule_open(mcv_cl *cl, const mcv_device_scene *scene, uint32_t sensor_type,
                             const mcv_render_options *options, mcv_schedule *schedule,
                             mcv_error *error);
void mcv_schedule_close(mcv_schedule *schedule);

/* Before the first start with features that aim: fills in the pixels' aims. */
mcv_result mcv_schedule_aim(mcv_schedule *schedule, const mcv_frame *frame, mcv_render_stats *stats,
                            mcv_error *error);

/* Begins to render the frame's paths, with as many light paths where its pixels are not listed; the
 * caller may do other work until it waits.
 */
mcv_result mcv_schedule_start(mcv_schedule *schedule, const mcv_frame *frame,
                              mcv_render_stats *stats, mcv_error *error);

/* The frame's light paths alone, and waits for them. */
mcv_result mcv_schedule_trace_light(mcv_schedule *schedule, const mcv_frame *frame,
                                    mcv_render_stats *stats, mcv_error *error);

/* Waits for what was started; schedule->sums then holds two floats per channel and block of
 * samples. */
mcv_result mcv_schedule_wait(mcv_schedule *schedule, mcv_render_stats *stats, mcv_error *error);

#endif
