/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The preview before the image: coarse pictures under the preview's name, each of which replaces
 * the one before as a whole, so that a user soon sees what is rendered. While kernels compile, the
 * reference renderer makes the first one, in a thread; the device makes another before its first
 * round. A file says in its header what it is (io/png.h). None is written of a render that is done
 * before.
 */
#ifndef MCVISI_HOST_CLI_EARLY_H
#define MCVISI_HOST_CLI_EARLY_H

#include "cli/picture.h"
#include "report/progress.h"

#include <pthread.h>

typedef struct mcv_early {
    const mcv_scene *scene;
    uint32_t sensor;
    const mcv_render_files *files;
    const mcv_render_options *options; /* of the render */
    double begun;
    double seconds; /* from `begun` to the first preview; 0: none so far */
    mcv_progress_line line;
    pthread_t thread;
    bool has_thread;
    pthread_mutex_t lock; /* of all that follows, and of `line` and `seconds` */
    pthread_cond_t changed;
    bool late;      /* the device renders, or the render has ended: the reference comes too late */
    bool written;   /* a preview lies under the name … */
    uint8_t *older; /* … in place of this file; NULL: there was none */
    size_t older_size;
} mcv_early;

/* Sets the callbacks of the options, which `early` keeps. End or withdraw must follow. */
void mcv_early_begin(mcv_early *early, const mcv_scene *scene, uint32_t sensor,
                     const mcv_render_files *files, const char *label, mcv_render_options *options);

/* No more previews: waits for the thread and clears the line of progress. */
void mcv_early_end(mcv_early *early);

/* After the end of a render that has no image: the preview's file is again what it was before. */
void mcv_early_withdraw(mcv_early *early);

/* Frees what begin and its callbacks took. */
void mcv_early_free(mcv_early *early);

#endif
