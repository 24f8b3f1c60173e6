/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The two schedules of the same stages. Tile: one launch per frame, a slice of paths per work-item,
 * for CPUs. Stream: one launch per stage, for GPUs. Both give the same bits.
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
 * Stream: the number of depths that the host launches ahead of the device, so that neither waits;
 * the number of depths between two collections of the launches' times.
 */
enum { MCV_DEPTHS_AHEAD = 4, MCV_TIMED_DEPTHS = 64, MCV_MAX_LAUNCHES = 4 * MCV_TIMED_DEPTHS + 8 };

typedef struct mcv_schedule {
    mcv_cl *cl;
    const mcv_device_scene *scene;
    uint32_t kind;     /* MCV_SCHEDULE_TILE or _STREAM */
    uint32_t capacity; /* largest number of paths of a launch */
    uint32_t slice;    /* paths per slice (tile) */
    uint32_t branches; /* largest number of branches of a path */
    uint32_t depth;
    cl_program program;
    cl_kernel
        kernels[MCV_STREAM_KERNEL_COUNT]; /* tile: generate_rays stands for all stages; stream: NULL
                                             if the scene does not need the stage */
    cl_mem paths, sums, counters;
    uint32_t counter_sets;  /* of the current launch */
    cl_mem queues, lengths; /* stream */
    struct {                /* the current launch */
        mcv_frame frame;
        uint32_t depth;                     /* the next to be launched */
        cl_uint living[MCV_DEPTHS_AHEAD];   /* active paths after the latest depths, by depth modulo
                                               MCV_DEPTHS_AHEAD … */
        cl_event answers[MCV_DEPTHS_AHEAD]; /* … valid when these events are complete */
    } stream;
    cl_event launches[MCV_MAX_LAUNCHES]; /* launches since the last wait, with their kernels, for
                                            the times of the stages */
    uint32_t launched[MCV_MAX_LAUNCHES];
    uint32_t launch_count;
} mcv_schedule;

/* Opens a schedule: chooses it by the device if options->schedule is auto, builds the program and
 * allocates the buffers. Close it even after a failure. */
mcv_result mcv_schedule_open(mcv_cl *cl, const mcv_device_scene *scene, uint32_t sensor_type,
                             const mcv_render_options *options, mcv_schedule *schedule,
                             mcv_error *error);
void mcv_schedule_close(mcv_schedule *schedule);

/* Fills in the pixels' pupil guides. To be called before the first start if the features include
 * PUPIL_GUIDE. */
mcv_result mcv_schedule_guide(mcv_schedule *schedule, const mcv_frame *frame,
                              mcv_render_stats *stats, mcv_error *error);

/* Starts to render the frame's paths, and as many light paths unless its pixels are listed. The
 * caller may do other work until it waits. */
mcv_result mcv_schedule_start(mcv_schedule *schedule, const mcv_frame *frame,
                              mcv_render_stats *stats, mcv_error *error);

/* Renders the frame's light paths alone and waits for them. */
mcv_result mcv_schedule_trace_light(mcv_schedule *schedule, const mcv_frame *frame,
                                    mcv_render_stats *stats, mcv_error *error);

/* Adds the seconds to those of the stage. */
void mcv_add_stage(mcv_render_stats *stats, const char *name, double seconds);

/* After a failure: waits for what runs and forgets it, so that another launch can start. */
void mcv_schedule_abandon(mcv_schedule *schedule);

/* Waits for the launch. schedule->sums then holds two floats per channel and block of samples. */
mcv_result mcv_schedule_wait(mcv_schedule *schedule, mcv_render_stats *stats, mcv_error *error);

#endif
