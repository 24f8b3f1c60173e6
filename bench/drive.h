/* SPDX-License-Identifier: Apache-2.0 */
/* Launches of a scene by hand, for the benchmarks that look inside a render: any schedule, any
 * features, one frame again and again. */
#ifndef MCVISI_BENCH_DRIVE_H
#define MCVISI_BENCH_DRIVE_H

#include "render/schedule.h"

enum { DRIVE_REPLICATES = 4, MAX_SCENES = 64 };

/* The scenes that ship, by name, or those whose names contain `only` unless it is NULL; the caller
 * frees names[0 … count - 1]. */
mcv_result shipped_scenes(const char *only, char *names[MAX_SCENES], size_t *count,
                          mcv_error *error);

/* Loads scenes/NAME and gives its first sensor about so many pixels; one with a region of interest
 * or binning keeps its own. */
mcv_result load_shipped(const char *name, double pixels, mcv_scene **scene, mcv_error *error);

/* One launch of DRIVE_REPLICATES * 2^log2_samples samples of all pixels of the first sensor,
 * without the light paths of caustics. */
typedef struct drive {
    mcv_cl *cl;
    const mcv_scene *scene;
    mcv_device_scene device;
    mcv_schedule schedule;
    mcv_frame frame;
    mcv_render_stats stats; /* of the last run */
    float *sums;            /* of the last run */
    size_t sum_count;
    double seconds_program; /* to build it */
    bool clock;             /* the program counts ticks: see kernels/schedule/clock.h */
} drive;

typedef struct drive_options {
    uint32_t schedule; /* MCV_SCHEDULE_… */
    uint32_t log2_samples, first_sample;
    uint32_t depth;
    bool all_features; /* instead of those that the scene needs */
    bool clock;        /* tile schedule only */
} drive_options;

/* Samples [first, 2 first) of each replicate, which is how most of a render's launches look; depth
 * as usual. */
drive_options drive_defaults(uint32_t schedule);

/* Close it even after a failure. */
mcv_result drive_open(mcv_cl *cl, const mcv_scene *scene, drive_options options, drive *d,
                      mcv_error *error);
void drive_close(drive *d);

/* As a bench_side runs it: start, wait, read the sums. */
mcv_result drive_run(void *user, mcv_error *error);

enum {
#define MCV_X(stage, runs) STAGE_##stage,
    MCV_STAGES(MCV_X)
#undef MCV_X
        STAGE_COUNT
};
extern const char *const stage_names[STAGE_COUNT];

/* The least ticks of each slice and stage of all calls, one after each run of a tile schedule with
 * its clock: what other programs took is not in them. Free *least; NULL: the first call. */
mcv_result drive_least_ticks(drive *d, cl_uint **least, mcv_error *error);

/* Each stage's share of them. */
void drive_shares_of_ticks(const drive *d, const cl_uint *ticks, double shares[STAGE_COUNT]);

/* Seconds of each stage in the last run; of a tile schedule only with its clock. */
mcv_result drive_stage_seconds(drive *d, double seconds[STAGE_COUNT], mcv_error *error);

#endif
