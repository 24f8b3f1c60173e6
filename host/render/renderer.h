/* SPDX-License-Identifier: Apache-2.0 */
/* What the files of the renderer share: its state, and the steps of a render. */
#ifndef MCVISI_HOST_RENDER_RENDERER_H
#define MCVISI_HOST_RENDER_RENDERER_H

#include "render/adaptive.h"
#include "render/render.h"
#include "render/schedule.h"
#include "render/unfinished.h"

enum {
    MCV_MAX_CLASSES = MCV_HIGHEST_LEVEL - MCV_LOWEST_LEVEL + 1,
    MCV_MIN_SAMPLES = 4, /* per replicate, before an error estimate may stop the render */
    /* Samples per replicate of the first adaptive round, in which each pixel has at least one. */
    MCV_FIRST_ADAPTIVE = 1 << -MCV_LOWEST_LEVEL,
};

/* Per replicate. */
#define MCV_MOST_SAMPLES ((uint64_t)0x80000000u)
#define MCV_MOST_ADAPTIVE (MCV_MOST_SAMPLES >> MCV_HIGHEST_LEVEL)

/* What a program is specialised for; the sizes of a schedule's buffers follow from it. */
typedef struct mcv_program_key {
    uint64_t features;
    uint32_t channels, sensor_type, sampler, schedule, slice, depth;
} mcv_program_key;

/* The pixels with 2^level times the samples; they are consecutive in the list. */
typedef struct mcv_pixel_class {
    int level;
    uint32_t first, count;
} mcv_pixel_class;

struct mcv_renderer {
    /* Kept between renders: */
    struct mcv_other_device *others[MCV_MOST_DEVICES - 1]; /* share the samples of the image; the
                                                              first device has pilots, too */
    uint32_t other_count;
    mcv_cl cl;
    mcv_device_scene scene;
    mcv_schedule schedule, earlier; /* the current one, and a previous one to return to when a
                                       parameter crosses a limit and comes back */
    mcv_program_key key, earlier_key;
    /* Of one render: */
    const mcv_render_options *options;
    mcv_render_stats *stats;
    mcv_film *film;
    double *round; /* sums of this round's samples, laid out as the film's */
    mcv_frame frame;
    uint32_t *listed; /* the pixels by class; NULL: all in their order, one class */
    mcv_pixel_class classes[MCV_MAX_CLASSES];
    uint32_t class_count;
    uint64_t *splats;    /* what light paths have brought, taken off the devices; NULL without */
    uint32_t *records;   /* of a launch, as read from the device */
    size_t record_count; /* of those, what the options' sink has not taken */
    uint32_t recording_sets; /* a launch had room for the records of so many sets; 0: of all */
    mcv_round part;          /* where the image's round stands; its sums are `round` */
    bool in_round; /* samples of the image are rendered: not those of a pilot or a picture */
    bool decided;  /* about adaptive sampling */
    double begun;  /* start time, earlier by what a resumed render took before */
    double sampling_begun; /* the same for its samples */
    double warming;        /* seconds of the first launch beyond its stages, in which drivers finish
                              compiling */
    mcv_error *error;
};

/* render.c */

/* Makes the scene ready on the open device. It reuses what the device's previous scene has in
 * common with this one. */
mcv_result mcv_open_scene(mcv_renderer *r, const mcv_scene *scene, uint32_t sensor);

/* Gives back what is on the device, and the device. */
void mcv_close_device(mcv_renderer *r);

/* devices.c: several devices render the same image. Each has a renderer of its own. */

typedef struct mcv_other_device {
    mcv_renderer renderer;
    mcv_render_options options; /* no calls, no records */
    mcv_render_stats stats;
    mcv_error error;
} mcv_other_device;

/* Opens the devices of the options unless they are open, and makes the scene ready on each. Devices
 * that fail are given up, with a sentence, as long as one is left. */
mcv_result mcv_open_devices(mcv_renderer *r, const mcv_scene *scene, uint32_t sensor);
void mcv_close_others(mcv_renderer *r);

/* Gives a device up, and tells the user: the other of this index, or the first one, for which
 * another one takes its place. */
void mcv_give_up_other(mcv_renderer *r, uint32_t index, const mcv_error *why);
void mcv_give_up_first(mcv_renderer *r, const mcv_error *why);

/* Gives the first device up if there is another one. The render is to begin again. */
bool mcv_go_on_without_first(mcv_renderer *r);

/* Adds what light paths have brought on the first device, where it is zero then. Nothing is added
 * on failure. */
mcv_result mcv_take_splats(mcv_renderer *r, uint64_t *splats);

/* share.c: as mcv_render_class, for samples of the image by all devices. */
mcv_result mcv_share_class(mcv_renderer *r, mcv_pixel_class class, uint64_t first, uint64_t count,
                           double done_before, bool *stop);

/* pass.c */

/* Where in the image the pixel of this number lies, block by block; false if its block of 8 x 8
 * pixels sticks out there. */
bool mcv_find_blocked_pixel(const mcv_film *film, uint32_t number, size_t *pixel);

/*
 * Renders samples [first, first + count), times 2^level, of the class's pixels into r->round; count
 * is a power of two. *stop is set if the caller's progress function asked for it; the round is then
 * incomplete.
 */
mcv_result mcv_render_class(mcv_renderer *r, mcv_pixel_class class, uint64_t first, uint64_t count,
                            double done_before, bool *stop);

/* Renders samples [first, first + count) of all pixels into r->round; count is a power of two. It
 * goes on behind what is done of r->part. */
mcv_result mcv_render_pass(mcv_renderer *r, uint64_t first, uint64_t count, double done_before,
                           bool *stop);

/* The light paths of samples [first, first + count) of the first so many pixels, where camera paths
 * are launched without them. */
mcv_result mcv_render_light(mcv_renderer *r, uint64_t pixels, uint64_t first, uint64_t count);

/* records.c: nothing without options->records */

/* Makes room for the records of a launch. From now on launches record. */
mcv_result mcv_open_records(mcv_renderer *r);

/* Before a launch: it has no records yet. */
mcv_result mcv_clear_records(mcv_renderer *r);

/* After a launch: reads its records. If they did not fit, the launch is repeated in parts. */
mcv_result mcv_read_records(mcv_renderer *r);

/* Gives the options' sink the records that were read: best while the device has another launch. */
mcv_result mcv_give_records(mcv_renderer *r);

/* save.c */

/* Whether the options ask to save the render now; `ending`: it ends here before it is done. */
bool mcv_save_is_due(const mcv_renderer *r, bool ending);

/* Saves the render, whose round stands as r->part says; its splats are taken off the devices. */
void mcv_save_unfinished(mcv_renderer *r);

/* Goes on as options->resume says, before the first samples. */
mcv_result mcv_resume(mcv_renderer *r);

/* early_picture.c */

/* Gives options->picture a coarse picture, which takes a hundredth of the render or less; nothing
 * of a render that will be done in a moment. Its samples do not enter the image, nor the
 * statistics. */
mcv_result mcv_show_early(mcv_renderer *r);

/* light_pilot.c */

/*
 * The k with which one light path for every 2^k pixels brings an error in the least time, from the
 * variances and times of camera paths, and of light paths with k = begun.
 */
uint32_t mcv_best_thinning(double camera_variance, double light_variance, double camera_time,
                           double light_time, uint32_t begun);

/*
 * The squares that camera paths without light paths lack in a pilot's sum of them, because they
 * have missed rare light of which light paths know. missed: that light; uncertain: its standard
 * deviation; brightest: the most that a path can meet. Light in portions of at most b has squares
 * of at most b times its sum.
 */
double mcv_missed_squares(double missed, double uncertain, double brightest);

/* Before the first samples: decides by a pilot how many light paths there are, or that there are
 * none, if the options ask for it. The image shares no random number with the pilot, so that it is
 * unbiased. */
mcv_result mcv_allocate_light(mcv_renderer *r);

/* Writes into the statistics how many there are. */
void mcv_count_light_paths(mcv_renderer *r);

/* pilot.c */

/* Changes the user's seed for pilots. */
#define MCV_PILOT_SEED 0x7f4a7c15u

/* Lists the pixels by their levels, all in one class where these are not known; of blocks of 8 x 8
 * pixels one in `stride`, spread over the image. */
mcv_result mcv_list_pixels(mcv_renderer *r, uint32_t stride);

/* Gives the device the first `count` of r->listed, and frames their numbers. */
mcv_result mcv_upload_list(mcv_renderer *r, size_t count);

/* Lists the pixels by the film's levels, for the random numbers that follow a pilot. */
mcv_result mcv_begin_levels(mcv_renderer *r);

/* All pixels in their order, in one class. */
void mcv_unlist_pixels(mcv_renderer *r);

/*
 * Decides about adaptive sampling once the number of samples can be predicted. It renders a pilot;
 * if adaptive sampling pays, it empties the film and starts again with other random numbers and
 * with levels of samples. Nothing that entered the decision is part of the image, so the image is
 * unbiased. r->decided: the pilot was rendered.
 */
mcv_result mcv_adapt(mcv_renderer *r, double error);

#endif
