/* SPDX-License-Identifier: Apache-2.0 */
#include "cli/early.h"

#include "cli/interrupt.h"
#include "core/basics.h"
#include "core/output_file.h"
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

/* Nanoseconds for which kernels compile before the reference begins: compiled ones are loaded
 * then. */
static const long PATIENCE = 600 * 1000 * 1000;

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
    const char *path = early->files->png;
    if (!early->written && access(path, F_OK) == 0 &&
        mcv_file_load(path, &early->older, &early->older_size, &ignored) != MCV_OK)
        return; /* it could not be put back */
    scale_up(early, coarse, stride, &preview);
    if (mcv_png_write_preview(path, coarse, early->files->unit, &preview, &ignored) != MCV_OK)
        return;
    early->written = true;
    early->line.picture = path;
    if (early->seconds == 0) early->seconds = mcv_seconds() - early->begun;
}

/* --- the reference's picture --- */

/* An mcv_pass_told of the draft. */
static bool draft_goes_on(void *user, double fraction, double seconds, double error) {
    mcv_early *early = user;
    (void)fraction;
    (void)seconds;
    (void)error;
    pthread_mutex_lock(&early->lock);
    const bool goes_on = !early->late && mcv_interrupt == 0;
    pthread_mutex_unlock(&early->lock);
    return goes_on;
}

/* True if the device renders soon. */
static bool device_is_ready(mcv_early *early) {
    struct timespec until;
    clock_gettime(CLOCK_REALTIME, &until);
    until.tv_nsec += PATIENCE;
    until.tv_sec += until.tv_nsec / 1000000000;
    until.tv_nsec %= 1000000000;
    pthread_mutex_lock(&early->lock);
    int code = 0;
    while (!early->late && code == 0)
        code = pthread_cond_timedwait(&early->changed, &early->lock, &until);
    const bool ready = early->late;
    pthread_mutex_unlock(&early->lock);
    return ready;
}

static void *make_draft(void *user) {
    mcv_early *early = user;
    mcv_render_options options = mcv_render_defaults();
    uint32_t width, height, stride = 1;
    mcv_film film;
    mcv_image picture;
    mcv_error ignored;
    if (device_is_ready(early)) return NULL;
    mcv_sensor_film_size(early->scene->sensors + early->sensor, &width, &height);
    while ((uint64_t)((width + stride - 1) / stride) * ((height + stride - 1) / stride) >
           DRAFT_PIXELS)
        ++stride;
    options.replicates = 1;
    options.last = DRAFT_SAMPLES;
    options.seed = early->options->seed;
    options.depth = early->options->depth;
    options.threads = 1; /* another one compiles */
    options.progress = draft_goes_on;
    options.user = early;
    if (mcv_reference_draft(early->scene, early->sensor, &options, stride, &film, &ignored) !=
        MCV_OK)
        return NULL;
    if (film.samples > 0 && mcv_film_develop(&film, &picture, NULL, &ignored) == MCV_OK) {
        pthread_mutex_lock(&early->lock);
        if (!early->late) {
            write_preview(early, &picture, stride,
                          "coarse, by the reference renderer while kernels compile");
            mcv_progress_report(&early->line, NAN, mcv_seconds() - early->begun, INFINITY);
        }
        pthread_mutex_unlock(&early->lock);
        mcv_image_free(&picture);
    }
    mcv_film_free(&film);
    return NULL;
}

/* --- the callbacks of the render --- */

/* An mcv_pass_told: a fraction of NaN says that kernels begin to compile. */
static bool report(void *user, double fraction, double seconds, double error) {
    mcv_early *early = user;
    const bool compiles = isnan(fraction);
    pthread_mutex_lock(&early->lock);
    if (compiles && !early->has_thread && early->scene->triangle_count <= MOST_TRIANGLES)
        early->has_thread = pthread_create(&early->thread, NULL, make_draft, early) == 0;
    if (!compiles && !early->late) {
        early->late = true;
        pthread_cond_signal(&early->changed);
    }
    const bool goes_on = mcv_progress_report(&early->line, fraction, seconds, error);
    pthread_mutex_unlock(&early->lock);
    return goes_on;
}

/* An mcv_picture_told. */
static void show(void *user, const mcv_image *picture, uint32_t stride) {
    mcv_early *early = user;
    pthread_mutex_lock(&early->lock);
    early->late = true;
    write_preview(early, picture, stride,
                  "coarse, by the device before the first samples of the image");
    pthread_mutex_unlock(&early->lock);
}

void mcv_early_begin(mcv_early *early, const mcv_scene *scene, uint32_t sensor,
                     const mcv_render_files *files, const char *label,
                     mcv_render_options *options) {
    *early = (mcv_early){.scene = scene,
                         .sensor = sensor,
                         .files = files,
                         .options = options,
                         .begun = mcv_seconds(),
                         .line = mcv_progress_stderr(label, &mcv_interrupt)};
    pthread_mutex_init(&early->lock, NULL);
    pthread_cond_init(&early->changed, NULL);
    options->progress = report;
    options->picture = show;
    options->user = early;
}

void mcv_early_end(mcv_early *early) {
    pthread_mutex_lock(&early->lock);
    early->late = true;
    pthread_cond_signal(&early->changed);
    pthread_mutex_unlock(&early->lock);
    if (early->has_thread) pthread_join(early->thread, NULL);
    early->has_thread = false;
    mcv_progress_end(&early->line);
}

void mcv_early_withdraw(mcv_early *early) {
    mcv_error ignored;
    if (!early->written) return;
    if (early->older)
        mcv_output_whole(early->files->png, early->older, early->older_size, &ignored);
    else
        unlink(early->files->png);
    early->written = false;
}

void mcv_early_free(mcv_early *early) {
    pthread_cond_destroy(&early->changed);
    pthread_mutex_destroy(&early->lock);
    free(early->older);
    early->older = NULL;
}
