/* SPDX-License-Identifier: Apache-2.0 */
#include "api/early_preview.h"

#include "api/border.h"
#include "core/basics.h"
#include "core/output_file.h"
#include "io/png.h"
#include "reference/reference.h"
#include "scene/sensors.h"

#include <math.h>
#include <stdlib.h>
#include <time.h>
#include <unistd.h>

enum {
    DRAFT_PIXELS = 1 << 14,   /* of the reference's picture, at most */
    DRAFT_SAMPLES = 4,        /* of each */
    MOST_TRIANGLES = 4 << 20, /* of a scene for which the reference's tree is built in time */
    MOST_PIXELS = 2 << 20,    /* of a preview: a larger film has a smaller picture */
};

/* Seconds of the compiling thread's processor before the reference begins: kernels of a cache,
 * which take a third of it, need no draft, however busy the machine is. */
static const double PATIENCE = 0.2;
/* As much by the clock, for drivers that compile elsewhere. */
static const double MOST_PATIENCE = 1;

static uint32_t least(uint32_t a, uint32_t b) { return a < b ? a : b; }

/* A preview of the film's size, or of at most MOST_PIXELS: its pixels are repeated `stride` times
 * or less. */
static void scale_up(const mcv_early *early, const mcv_image *coarse, uint32_t stride,
                     mcv_preview *preview) {
    uint32_t width, height;
    mcv_sensor_film_size(early->scene->sensors + early->sensor, &width, &height);
    const uint64_t pixels = (uint64_t)coarse->width * coarse->height;
    preview->repeat = 1;
    while (preview->repeat < stride &&
           (preview->repeat + 1) * (preview->repeat + 1) * pixels <= MOST_PIXELS)
        ++preview->repeat;
    preview->size[0] = least(width, preview->repeat * coarse->width);
    preview->size[1] = least(height, preview->repeat * coarse->height);
}

/* Writes a preview. Failures are not told: that the image cannot be written will be. */
static void write_preview(mcv_early *early, const mcv_image *coarse, uint32_t stride,
                          const char *by) {
    mcv_error ignored;
    mcv_preview preview = {.early = by};
    const char *path = early->path;
    if (!early->written && access(path, F_OK) == 0 &&
        mcv_file_load(path, &early->older, &early->older_size, &ignored) != MCV_OK)
        return; /* it could not be put back */
    scale_up(early, coarse, stride, &preview);
    if (mcv_png_write_preview(path, coarse, early->unit, &preview, &ignored) != MCV_OK) return;
    early->written = true;
    if (early->seconds == 0) early->seconds = mcv_seconds() - early->begun;
}

/* --- the reference's picture --- */

static bool device_is_ready(mcv_early *early) {
    pthread_mutex_lock(&early->lock);
    const bool ready = early->late;
    pthread_mutex_unlock(&early->lock);
    return ready;
}

static double compiler_seconds(const mcv_early *early) {
    struct timespec t;
    if (!early->has_clock || clock_gettime(early->compiler, &t) != 0) return NAN;
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* False if the device renders before kernels have taken long. */
static bool compiles_for_long(mcv_early *early) {
    const struct timespec moment = {.tv_nsec = 10 * 1000 * 1000};
    const double begun = mcv_seconds();
    while (!device_is_ready(early)) {
        if (compiler_seconds(early) - early->compiler_begun >= PATIENCE ||
            mcv_seconds() - begun >= MOST_PATIENCE)
            return true;
        nanosleep(&moment, NULL);
    }
    return false;
}

/* Writes what the draft's film has, unless the device renders. */
static void show_draft(mcv_early *early) {
    mcv_image picture;
    mcv_error ignored;
    if (mcv_film_develop(&early->draft, &picture, NULL, &ignored) != MCV_OK) return;
    pthread_mutex_lock(&early->lock);
    if (!early->late)
        write_preview(early, &picture, early->draft_stride,
                      "coarse, by the reference renderer while kernels compile");
    pthread_mutex_unlock(&early->lock);
    mcv_image_free(&picture);
    early->draft_shown = early->draft.samples;
}

/* An mcv_pass_told of the draft: each sample of its pixels is shown. */
static bool draft_goes_on(void *user, double fraction, double seconds, double error) {
    mcv_early *early = user;
    (void)fraction;
    (void)seconds;
    (void)error;
    if (device_is_ready(early)) return false;
    if (early->draft.samples > early->draft_shown) show_draft(early);
    return true;
}

static void make_draft(mcv_early *early) {
    mcv_render_options options = mcv_render_defaults();
    uint32_t width, height, stride = 1;
    mcv_error ignored;
    if (!compiles_for_long(early)) return;
    mcv_sensor_film_size(early->scene->sensors + early->sensor, &width, &height);
    while ((uint64_t)((width + stride - 1) / stride) * ((height + stride - 1) / stride) >
           DRAFT_PIXELS)
        ++stride;
    early->draft_stride = stride;
    options.replicates = 1;
    options.last = DRAFT_SAMPLES;
    options.seed = early->options->seed;
    options.depth = early->options->depth;
    options.threads = 1; /* another one compiles */
    options.progress = draft_goes_on;
    options.user = early;
    if (mcv_reference_draft(early->scene, early->sensor, &options, stride, &early->draft,
                            &ignored) == MCV_OK)
        mcv_film_free(&early->draft);
}

/* A number in the header has the point of the C locale in this thread, too. */
static void *draft_in_thread(void *user) {
    const locale_t host = mcv_border_enter();
    make_draft(user);
    mcv_border_leave(host);
    return NULL;
}

/* --- the render --- */

bool mcv_early_progress(mcv_early *early, double fraction) {
    const bool compiles = isnan(fraction);
    pthread_mutex_lock(&early->lock);
    if (compiles && !early->has_thread && early->scene->triangle_count <= MOST_TRIANGLES) {
        early->has_clock = pthread_getcpuclockid(pthread_self(), &early->compiler) == 0;
        early->compiler_begun = compiler_seconds(early);
        early->has_thread = pthread_create(&early->thread, NULL, draft_in_thread, early) == 0;
    }
    if (!compiles) early->late = true;
    const bool drafts = compiles && early->has_thread;
    pthread_mutex_unlock(&early->lock);
    return drafts;
}

void mcv_early_show(mcv_early *early, const mcv_image *picture, uint32_t stride) {
    pthread_mutex_lock(&early->lock);
    early->late = true;
    write_preview(early, picture, stride,
                  "coarse, by the device before the first samples of the image");
    pthread_mutex_unlock(&early->lock);
}

void mcv_early_begin(mcv_early *early, const mcv_scene *scene, uint32_t sensor, const char *path,
                     const char *unit, const mcv_render_options *options) {
    *early = (mcv_early){.scene = scene,
                         .sensor = sensor,
                         .path = path,
                         .unit = unit,
                         .options = options,
                         .begun = mcv_seconds()};
    pthread_mutex_init(&early->lock, NULL);
}

void mcv_early_end(mcv_early *early) {
    pthread_mutex_lock(&early->lock);
    early->late = true;
    pthread_mutex_unlock(&early->lock);
    if (early->has_thread) pthread_join(early->thread, NULL);
    early->has_thread = false;
}

void mcv_early_withdraw(mcv_early *early) {
    mcv_error ignored;
    if (!early->written) return;
    if (early->older)
        mcv_output_whole(early->path, early->older, early->older_size, &ignored);
    else
        unlink(early->path);
    early->written = false;
}

void mcv_early_free(mcv_early *early) {
    pthread_mutex_destroy(&early->lock);
    free(early->older);
    early->older = NULL;
}
