/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The preview before the image: coarse pictures under the preview's name, each of which replaces
 * the one before as a whole, so that a user soon sees what is rendered. While kernels compile, the
 * reference renderer makes the first one, in a thread; the device makes another before its first
 * round. A file says in its header what it is (io/png.h). None is written of a render that is done
 * before.
 */
#ifndef MCVISI_HOST_API_EARLY_PREVIEW_H
#define MCVISI_HOST_API_EARLY_PREVIEW_H

#include "render/render.h"

#include <pthread.h>

typedef struct mcv_early {
    const mcv_scene *scene;
    uint32_t sensor;
    const char *path, *unit;
    const mcv_render_options *options; /* of the render */
    double begun;
    clockid_t compiler; /* of the processor time of the thread that compiles … */
    bool has_clock;
    double compiler_begun; /* … and what it said when that began */
    bool has_thread;
    pthread_t thread; /* makes the draft, and alone reads the three lines below */
    mcv_film draft;
    uint32_t draft_stride;
    uint64_t draft_shown; /* its samples in the last preview */
    pthread_mutex_t lock; /* of all that follows */
    double seconds;       /* from the begin to the first preview; 0: none so far */
    bool late;      /* the device renders, or the render has ended: the reference comes too late */
    bool written;   /* a preview lies under the name … */
    uint8_t *older; /* … in place of this file; NULL: there was none */
    size_t older_size;
} mcv_early;

/* The preview's path, its unit, and the options of the render, which may still be set: all must
 * outlive it. End and free must follow. */
void mcv_early_begin(mcv_early *early, const mcv_scene *scene, uint32_t sensor, const char *path,
                     const char *unit, const mcv_render_options *options);

/* To be called as the render's progress is: NaN says that kernels begin to compile; and with 0
 * where these came from a cache. True where the reference makes a preview meanwhile. */
bool mcv_early_progress(mcv_early *early, double fraction);

/* Writes the device's picture (mcv_picture_told). */
void mcv_early_show(mcv_early *early, const mcv_image *picture, uint32_t stride);

/* No more previews: waits for the thread. */
void mcv_early_end(mcv_early *early);

/* After the end of a render that has no image: the preview's file is again what it was before. */
void mcv_early_withdraw(mcv_early *early);

/* Frees what the previews took. */
void mcv_early_free(mcv_early *early);

#endif
