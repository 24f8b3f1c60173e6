/* SPDX-License-Identifier: Apache-2.0 */
#include "render/schedule.h"
#include "device/features.h"

#include <stdlib.h>
#include <string.h>

enum {
    DEFAULT_SLICE = 1024, /* the last iterations of a loop over few paths are not vectorised */
    MAX_SLICES = 1024,    /* enough for an even load, few enough to bound the state */
    MAX_SLOTS = 4096,     /* paths of a slice: its state is on a thread's stack */
    MAX_STREAM_PATHS = 1 << 20,
    MAX_STREAM_SLOTS = 1 << 22, /* most paths use fewer branches than they may */
    STREAM_GROUP = 64,          /* as in kernels/schedule/stream.cl, which cannot read this */
    STREAM_ARGUMENTS = MCV_SCENE_ARGUMENTS + 7,
};

/* The state of a launch's paths may take a quarter of the largest buffer of the device. */
static uint32_t fitting_paths(const mcv_cl *cl, size_t bytes_per_path, uint32_t most) {
    const size_t fitting = cl->largest_allocation / 4 / bytes_per_path;
    return fitting < most ? (uint32_t)fitting : most;
}

static bool guides(const mcv_schedule *s) {
    return s->scene->packed.features >> MCV_FEATURE_PUPIL_GUIDE & 1;
}

static bool traces_light(const mcv_schedule *s) {
    return s->scene->packed.features >> MCV_FEATURE_LIGHT_TRACING & 1;
}

static mcv_result open_tile(mcv_schedule *s, const char *options, mcv_error *error) {
    MCV_TRY(mcv_cl_build(s->cl, "schedule/tile", options, &s->program, error));
    if (guides(s))
        MCV_TRY(
            mcv_cl_kernel(s->program, "guide_pupils", &s->kernels[MCV_KERNEL_guide_pupils], error));
    if (traces_light(s))
        MCV_TRY(mcv_cl_kernel(s->program, "trace_emitter_paths",
                              &s->kernels[MCV_KERNEL_trace_emitter_paths], error));
    return mcv_cl_kernel(s->program, "render_tile", &s->kernels[MCV_KERNEL_generate_rays], error);
}

static mcv_result open_stream(mcv_schedule *s, const char *options, mcv_error *error) {
    MCV_FEATURE_VARIABLES(s->scene->packed.features)
    MCV_TRY(mcv_cl_build(s->cl, "schedule/stream", options, &s->program, error));
#define MCV_X(stage, runs) \
    if (runs) MCV_TRY(mcv_cl_kernel(s->program, #stage, &s->kernels[MCV_KERNEL_##stage], error));
    MCV_STREAM_KERNELS(MCV_X)
#undef MCV_X
    const size_t path_bytes =
        4 * (size_t)mcv_path_words(s->scene->packed.features, s->scene->packed.channels);
    const size_t slots = (size_t)s->capacity * s->branches;
    MCV_TRY(
        mcv_cl_buffer(s->cl, "the paths of a launch", path_bytes * slots, NULL, &s->paths, error));
    MCV_TRY(
        mcv_cl_buffer(s->cl, "the queues", 3 * sizeof(cl_uint) * slots, NULL, &s->queues, error));
    return mcv_cl_buffer(s->cl, "the lengths of the queues", 2 * sizeof(cl_uint) * (s->depth + 1),
                         NULL, &s->lengths, error);
}

mcv_result mcv_schedule_open(mcv_cl *cl, const mcv_device_scene *scene, uint32_t sensor_type,
                             const mcv_render_options *options, mcv_schedule *schedule,
                             mcv_error *error) {
    mcv_schedule *s = schedule;
    char defines[2048];
    const mcv_packed *packed = &scene->packed;
    memset(s, 0, sizeof *s);
    s->branches = mcv_path_branches(packed->features);
    const size_t path_bytes =
        4 * (size_t)mcv_path_words(packed->features, packed->channels) * s->branches;
    s->cl = cl;
    s->scene = scene;
    s->depth = options->depth;
    s->kind = options->schedule;
    if (s->kind == MCV_SCHEDULE_AUTO) s->kind = cl->cpu ? MCV_SCHEDULE_TILE : MCV_SCHEDULE_STREAM;
    s->slice = options->slice > 0 ? options->slice : DEFAULT_SLICE;
    if (s->slice > MAX_SLOTS / s->branches) s->slice = MAX_SLOTS / s->branches;
    const uint32_t unit = s->kind == MCV_SCHEDULE_TILE ? s->slice : MCV_BLOCK;
    const uint32_t streamed = MAX_STREAM_SLOTS / s->branches < MAX_STREAM_PATHS
                                  ? MAX_STREAM_SLOTS / s->branches
                                  : MAX_STREAM_PATHS;
    s->capacity = fitting_paths(cl, path_bytes,
                                s->kind == MCV_SCHEDULE_TILE ? MAX_SLICES * s->slice : streamed) /
                  unit * unit;
    if (s->capacity == 0)
        return mcv_fail(error, MCV_DEVICE, "%s: too little memory for a slice of %u paths",
                        cl->name, unit);

    mcv_feature_defines(packed->features, packed->channels, sensor_type, options->sampler, s->slice,
                        defines, sizeof defines);
    MCV_TRY(s->kind == MCV_SCHEDULE_TILE ? open_tile(s, defines, error)
                                         : open_stream(s, defines, error));
    const size_t counter_sets = s->kind == MCV_SCHEDULE_TILE ? s->capacity / s->slice : 1;
    MCV_TRY(mcv_cl_buffer(cl, "the sums of a launch", 8 * (size_t)s->capacity * packed->channels,
                          NULL, &s->sums, error));
    return mcv_cl_buffer(cl, "the counters of a launch",
                         sizeof(cl_uint) * counter_sets * MCV_COUNTER_COUNT, NULL, &s->counters,
                         error);
}

/* Forgets pending reads: their targets are no longer valid. */
static void forget_answers(mcv_schedule *s) {
    for (int i = 0; i < MCV_DEPTHS_AHEAD; ++i) {
        if (!s->stream.answers[i]) continue;
        clWaitForEvents(1, &s->stream.answers[i]);
        clReleaseEvent(s->stream.answers[i]);
        s->stream.answers[i] = NULL;
    }
}

void mcv_schedule_abandon(mcv_schedule *schedule) {
    forget_answers(schedule);
    if (schedule->launch_count > 0) clFinish(schedule->cl->queue);
    for (uint32_t i = 0; i < schedule->launch_count; ++i) clReleaseEvent(schedule->launches[i]);
    schedule->launch_count = 0;
}

void mcv_schedule_close(mcv_schedule *schedule) {
    mcv_schedule_abandon(schedule);
    mcv_cl_release(&schedule->paths);
    mcv_cl_release(&schedule->sums);
    mcv_cl_release(&schedule->counters);
    mcv_cl_release(&schedule->queues);
    mcv_cl_release(&schedule->lengths);
    for (size_t i = 0; i < MCV_STREAM_KERNEL_COUNT; ++i) {
        if (schedule->kernels[i]) clReleaseKernel(schedule->kernels[i]);
    }
    if (schedule->program) clReleaseProgram(schedule->program);
    memset(schedule, 0, sizeof *schedule);
}

static mcv_result add_counters(mcv_schedule *s, mcv_render_stats *stats, mcv_error *error) {
    const size_t bytes = sizeof(cl_uint) * s->counter_sets * MCV_COUNTER_COUNT;
    cl_uint *counters = malloc(bytes);
    if (!counters) return mcv_fail(error, MCV_FAILED, "no memory for the counters of a launch");
    const mcv_result result = mcv_cl_read(s->cl, s->counters, 0, bytes, counters, error);
    for (uint32_t i = 0; result == MCV_OK && i < s->counter_sets; ++i) {
        const cl_uint *c = counters + (size_t)i * MCV_COUNTER_COUNT;
        stats->paths += c[MCV_COUNTER_paths];
        stats->rays += c[MCV_COUNTER_rays];
        stats->shadow_rays += c[MCV_COUNTER_shadow_rays];
        stats->depth_cut += c[MCV_COUNTER_depth_cut];
        stats->lost_energy += c[MCV_COUNTER_lost] * 0x1p-11;
        stats->nonfinite += c[MCV_COUNTER_nonfinite];
        stats->unmatched += c[MCV_COUNTER_unmatched];
        stats->saturated += c[MCV_COUNTER_saturated];
    }
    free(counters);
    return result;
}

static mcv_result launch(mcv_schedule *s, uint32_t kernel, size_t global, size_t local,
                         const mcv_arg *arguments, size_t count, mcv_error *error) {
    const uint32_t i = s->launch_count;
    MCV_TRY(mcv_cl_launch(s->cl, s->kernels[kernel], global, local, arguments, count,
                          &s->launches[i], error));
    s->launched[i] = kernel;
    ++s->launch_count;
    return MCV_OK;
}

void mcv_add_stage(mcv_render_stats *stats, const char *name, double seconds) {
    uint32_t stage = 0;
    while (stage < stats->stage_count && strcmp(stats->stages[stage].name, name) != 0) ++stage;
    if (stage == stats->stage_count) stats->stages[stats->stage_count++].name = name;
    stats->stages[stage].seconds += seconds;
}

/* After a wait: adds up the times of the stages. */
static void add_times(mcv_schedule *s, mcv_render_stats *stats) {
    static const char *const names[] = {
#define MCV_X(stage, runs) #stage,
        MCV_STREAM_KERNELS(MCV_X)
#undef MCV_X
    };
    for (uint32_t i = 0; i < s->launch_count; ++i) {
        const bool tile =
            s->kind == MCV_SCHEDULE_TILE && s->launched[i] == MCV_KERNEL_generate_rays;
        const char *name = tile ? "render_tile" : names[s->launched[i]];
        mcv_add_stage(stats, name, mcv_cl_seconds(s->launches[i]));
    }
    s->launch_count = 0;
}

static mcv_result start_tile(mcv_schedule *s, const mcv_frame *frame, mcv_error *error) {
    mcv_arg arguments[MCV_SCENE_ARGUMENTS + 2];
    mcv_device_scene_arguments(s->scene, arguments);
    arguments[MCV_SCENE_ARGUMENTS] = MCV_ARG(s->sums);
    arguments[MCV_SCENE_ARGUMENTS + 1] = MCV_ARG(s->counters);
    s->counter_sets = (frame->path_count + s->slice - 1) / s->slice;
    return launch(s, MCV_KERNEL_generate_rays, s->counter_sets, 1, arguments,
                  MCV_SCENE_ARGUMENTS + 2, error);
}

static mcv_result launch_stage(mcv_schedule *s, uint32_t kernel, size_t items, mcv_error *error) {
    mcv_arg arguments[STREAM_ARGUMENTS];
    const cl_uint slots = s->capacity * s->branches;
    mcv_device_scene_arguments(s->scene, arguments);
    arguments[MCV_SCENE_ARGUMENTS] = MCV_ARG(s->paths);
    arguments[MCV_SCENE_ARGUMENTS + 1] = MCV_ARG(s->sums);
    arguments[MCV_SCENE_ARGUMENTS + 2] = MCV_ARG(s->counters);
    arguments[MCV_SCENE_ARGUMENTS + 3] = MCV_ARG(s->queues);
    arguments[MCV_SCENE_ARGUMENTS + 4] = MCV_ARG(s->lengths);
    arguments[MCV_SCENE_ARGUMENTS + 5] = MCV_ARG(slots);
    arguments[MCV_SCENE_ARGUMENTS + 6] = MCV_ARG(s->stream.depth);
    return launch(s, kernel, items, STREAM_GROUP, arguments, STREAM_ARGUMENTS, error);
}

/* Launches the stages of the next depth, for at most `items` paths, and starts reading the number
 * of active paths. */
static mcv_result launch_depth(mcv_schedule *s, size_t items, mcv_render_stats *stats,
                               mcv_error *error) {
    const uint32_t depth = s->stream.depth;
    const uint32_t asked = depth % MCV_DEPTHS_AHEAD;
    MCV_TRY(launch_stage(s, MCV_KERNEL_intersect_closest, items, error));
    if (s->kernels[MCV_KERNEL_sample_emitters] && depth + 1 < s->stream.frame.depth) {
        MCV_TRY(launch_stage(s, MCV_KERNEL_sample_emitters, items, error));
        MCV_TRY(launch_stage(s, MCV_KERNEL_intersect_shadow, items, error));
    }
    MCV_TRY(launch_stage(s, MCV_KERNEL_shade_surfaces, items, error));
    const cl_int code = clEnqueueReadBuffer(
        s->cl->queue, s->lengths, CL_FALSE, sizeof(cl_uint) * (depth + 1), sizeof(cl_uint),
        &s->stream.living[asked], 0, NULL, &s->stream.answers[asked]);
    MCV_TRY(mcv_cl_check(s->cl, code, "reading from the device", error));
    ++s->stream.depth;
    if (s->stream.depth % MCV_TIMED_DEPTHS > 0) return MCV_OK;
    MCV_TRY(mcv_cl_finish(s->cl, error));
    add_times(s, stats);
    return MCV_OK;
}

/* The largest number of active paths: a path splits at most once at each depth. */
static uint32_t most_paths(const mcv_schedule *s, uint32_t paths, uint32_t depths) {
    return paths * (depths + 1 < s->branches ? depths + 1 : s->branches);
}

/* The number of active paths MCV_DEPTHS_AHEAD depths ago, waiting for it if necessary, times the
 * splits that may have followed. */
static mcv_result living_paths(mcv_schedule *s, cl_uint *living, mcv_error *error) {
    const uint32_t asked = s->stream.depth % MCV_DEPTHS_AHEAD;
    const uint32_t most = s->stream.frame.path_count * s->branches;
    *living = most;
    if (s->stream.depth < MCV_DEPTHS_AHEAD) return MCV_OK;
    MCV_TRY(mcv_cl_check(s->cl, clWaitForEvents(1, &s->stream.answers[asked]),
                         "waiting for the device", error));
    clReleaseEvent(s->stream.answers[asked]);
    s->stream.answers[asked] = NULL;
    *living = s->stream.living[asked];
    if (*living < most)
        *living = most_paths(s, *living, MCV_DEPTHS_AHEAD) < most
                      ? most_paths(s, *living, MCV_DEPTHS_AHEAD)
                      : most;
    return MCV_OK;
}

/* Launches the first depths of a frame without waiting. */
static mcv_result start_stream(mcv_schedule *s, const mcv_frame *frame, mcv_render_stats *stats,
                               mcv_error *error) {
    s->stream.frame = *frame;
    s->stream.depth = 0;
    s->counter_sets = 1;
    MCV_TRY(mcv_cl_clear(s->cl, s->lengths, 2 * sizeof(cl_uint) * (s->depth + 1), error));
    MCV_TRY(mcv_cl_clear(s->cl, s->counters, sizeof(cl_uint) * MCV_COUNTER_COUNT, error));
    MCV_TRY(launch_stage(s, MCV_KERNEL_generate_rays, frame->path_count, error));
    while (s->stream.depth < frame->depth && s->stream.depth < MCV_DEPTHS_AHEAD)
        MCV_TRY(launch_depth(s, most_paths(s, frame->path_count, s->stream.depth), stats, error));
    return MCV_OK;
}

/* Launches the other depths while paths are active, then the film. */
static mcv_result finish_stream(mcv_schedule *s, mcv_render_stats *stats, mcv_error *error) {
    const mcv_frame *frame = &s->stream.frame;
    const uint32_t block = mcv_block_size(frame->log2_samples);
    while (s->stream.depth < frame->depth) {
        cl_uint living;
        MCV_TRY(living_paths(s, &living, error));
        if (living == 0) break;
        MCV_TRY(launch_depth(s, living, stats, error));
    }
    MCV_TRY(launch_stage(s, MCV_KERNEL_accumulate_film, frame->path_count / block, error));
    MCV_TRY(launch_stage(s, MCV_KERNEL_count_rays, 1, error));
    forget_answers(s);
    return MCV_OK;
}

mcv_result mcv_schedule_guide(mcv_schedule *schedule, const mcv_frame *frame,
                              mcv_render_stats *stats, mcv_error *error) {
    mcv_schedule *s = schedule;
    mcv_arg arguments[MCV_SCENE_ARGUMENTS + 1];
    if (!guides(s)) return MCV_OK;
    const bool tile = s->kind == MCV_SCHEDULE_TILE;
    const size_t pixels = (size_t)frame->width * frame->height;
    MCV_TRY(mcv_cl_write(s->cl, s->scene->frame, 0, sizeof *frame, frame, error));
    mcv_device_scene_arguments(s->scene, arguments);
    arguments[MCV_SCENE_ARGUMENTS] = MCV_ARG(s->scene->pupil_guides);
    MCV_TRY(launch(s, MCV_KERNEL_guide_pupils, tile ? (pixels + s->slice - 1) / s->slice : pixels,
                   tile ? 1 : STREAM_GROUP, arguments, MCV_SCENE_ARGUMENTS + 1, error));
    MCV_TRY(mcv_cl_finish(s->cl, error));
    add_times(s, stats);
    return MCV_OK;
}

/* Launches the light paths of a frame, one for about 2^log2_thinning of its camera paths. The
 * stream schedule has a work-item for each camera path, most of which find that they have none. The
 * tile schedule has one for 2^log2_thinning slices. What they count is added to the counters. */
static mcv_result start_light(mcv_schedule *s, const mcv_frame *frame, mcv_error *error) {
    mcv_arg arguments[MCV_SCENE_ARGUMENTS + 2];
    if (!traces_light(s) || !(frame->light_density > 0)) return MCV_OK;
    mcv_device_scene_arguments(s->scene, arguments);
    arguments[MCV_SCENE_ARGUMENTS] = MCV_ARG(s->scene->splats);
    arguments[MCV_SCENE_ARGUMENTS + 1] = MCV_ARG(s->counters);
    const bool tile = s->kind == MCV_SCHEDULE_TILE;
    const size_t span = (size_t)s->slice
                        << frame->log2_thinning; /* for one work-item of the tile schedule */
    return launch(s, MCV_KERNEL_trace_emitter_paths,
                  tile ? (frame->path_count + span - 1) / span : frame->path_count,
                  tile ? 1 : STREAM_GROUP, arguments, MCV_SCENE_ARGUMENTS + 2, error);
}

mcv_result mcv_schedule_start(mcv_schedule *schedule, const mcv_frame *frame,
                              mcv_render_stats *stats, mcv_error *error) {
    MCV_TRY(mcv_cl_write(schedule->cl, schedule->scene->frame, 0, sizeof *frame, frame, error));
    MCV_TRY(schedule->kind == MCV_SCHEDULE_TILE ? start_tile(schedule, frame, error)
                                                : start_stream(schedule, frame, stats, error));
    if (!frame->listed) MCV_TRY(start_light(schedule, frame, error));
    return mcv_cl_check(schedule->cl, clFlush(schedule->cl->queue), "starting the device's work",
                        error);
}

mcv_result mcv_schedule_trace_light(mcv_schedule *schedule, const mcv_frame *frame,
                                    mcv_render_stats *stats, mcv_error *error) {
    mcv_schedule *s = schedule;
    s->counter_sets =
        s->kind == MCV_SCHEDULE_TILE ? (frame->path_count + s->slice - 1) / s->slice : 1;
    MCV_TRY(mcv_cl_write(s->cl, s->scene->frame, 0, sizeof *frame, frame, error));
    MCV_TRY(mcv_cl_clear(s->cl, s->counters, sizeof(cl_uint) * s->counter_sets * MCV_COUNTER_COUNT,
                         error));
    MCV_TRY(start_light(s, frame, error));
    MCV_TRY(mcv_cl_finish(s->cl, error));
    MCV_TRY(add_counters(s, stats, error));
    add_times(s, stats);
    return MCV_OK;
}

mcv_result mcv_schedule_wait(mcv_schedule *schedule, mcv_render_stats *stats, mcv_error *error) {
    if (schedule->kind == MCV_SCHEDULE_STREAM) MCV_TRY(finish_stream(schedule, stats, error));
    MCV_TRY(add_counters(schedule, stats, error));
    add_times(schedule, stats);
    return MCV_OK;
}
