/* SPDX-License-Identifier: Apache-2.0 */
/* A coarse picture before the first round, for the eye: its samples do not enter the image. */
#include "render/renderer.h"

#include <math.h>
#include <stdlib.h>

enum {
    PICTURE_PIXELS = 1 << 14, /* at most */
    PICTURE_SAMPLES = 2,      /* of each */
    PATHS_FOR_PIXEL = 256,    /* of the render, at least, for each pixel of the picture */
    SHORT_RENDER = 1 << 20,   /* paths that need no picture before: half a second of a CPU */
};

/* How many columns or rows the picture has for those of the film. */
static uint32_t coarse(uint32_t side, uint32_t stride) { return (side + stride - 1) / stride; }

/* The columns and rows of the film in one of the picture, before a render of so many paths. */
static uint32_t stride_for(const mcv_film *film, double paths) {
    const double most = fmin(PICTURE_PIXELS, paths / PATHS_FOR_PIXEL);
    uint32_t stride = 1;
    while ((double)coarse(film->width, stride) * coarse(film->height, stride) > most) ++stride;
    return stride;
}

/* The film's pixel in the middle of one of the picture. */
static size_t middle(const mcv_film *film, uint32_t stride, uint32_t column, uint32_t row) {
    const uint32_t x = column * stride + stride / 2, y = row * stride + stride / 2;
    return (size_t)(y < film->height ? y : film->height - 1) * film->width +
           (x < film->width ? x : film->width - 1);
}

/* Renders the listed pixels and as many light paths. r->film is that of the picture. */
static mcv_result trace_picture(mcv_renderer *r, const mcv_image *picture, uint32_t stride,
                                uint64_t *splats, bool *stop) {
    const mcv_film *film = r->film;
    const uint32_t count = picture->width * picture->height;
    r->listed = malloc(count * sizeof *r->listed);
    if (!r->listed)
        return mcv_fail(r->error, MCV_FAILED, "no memory for a list of %u pixels", count);
    for (uint32_t i = 0; i < count; ++i)
        r->listed[i] = (uint32_t)middle(film, stride, i % picture->width, i / picture->width);
    r->class_count = 1;
    r->classes[0] = (mcv_pixel_class){0, 0, count};
    MCV_TRY(mcv_upload_list(r, count));
    MCV_TRY(mcv_render_class(r, r->classes[0], 0, PICTURE_SAMPLES, INFINITY, stop));
    if (!splats || *stop) return MCV_OK;
    MCV_TRY(mcv_render_light(r, count, 0, PICTURE_SAMPLES));
    return mcv_cl_read(&r->cl, r->scene.splats, 0, 8 * mcv_film_values(film), splats, r->error);
}

/* The light paths' share in a pixel of the picture: the mean over those of the film. */
static double splatted(const mcv_film *film, const uint64_t *splats, uint32_t stride,
                       uint32_t column, uint32_t row) {
    double sum = 0;
    uint32_t count = 0;
    for (uint32_t y = row * stride; y < (row + 1) * stride && y < film->height; ++y)
        for (uint32_t x = column * stride; x < (column + 1) * stride && x < film->width;
             ++x, ++count)
            sum += (double)splats[(size_t)y * film->width + x];
    return sum / count;
}

static void develop(const mcv_renderer *r, const uint64_t *splats, uint32_t stride,
                    mcv_image *picture) {
    const mcv_film *film = r->film;
    const size_t plane = (size_t)film->width * film->height,
                 count = (size_t)picture->width * picture->height;
    /* As many light paths as the picture has pixels stand for as many as the film has. */
    const double splat = mcv_frame_splat_value(&r->frame) / (double)count *
                         (double)mcv_tiled_pixels(film->width, film->height);
    for (uint32_t channel = 0; channel < film->channels; ++channel)
        for (uint32_t i = 0; i < count; ++i) {
            const uint32_t column = i % picture->width, row = i / picture->width;
            double value = film->sums[channel * plane + middle(film, stride, column, row)];
            if (splats)
                value += splat * splatted(film, splats + channel * plane, stride, column, row);
            picture->pixels[channel * count + i] = (float)(value / PICTURE_SAMPLES);
        }
}

/* On a film of its own, with other random numbers than the image's. */
static mcv_result render_picture(mcv_renderer *r, mcv_image *picture, uint32_t stride, bool *stop) {
    mcv_film *image = r->film, film = {0};
    double *round = r->round;
    MCV_TRY(mcv_film_new(&film, image->width, image->height, image->channels, 1, r->error));
    const size_t bytes = 8 * mcv_film_values(&film);
    uint64_t *splats = r->scene.splats ? calloc(1, bytes) : NULL;
    if (r->scene.splats && !splats) {
        mcv_film_free(&film);
        return mcv_fail(r->error, MCV_FAILED, "no memory for what light paths bring a picture");
    }
    r->film = &film;
    r->round = film.sums;
    r->frame.replicates = 1;
    r->frame.seed = r->options->seed ^ MCV_PILOT_SEED;
    mcv_result result = trace_picture(r, picture, stride, splats, stop);
    if (result == MCV_OK && !*stop) develop(r, splats, stride, picture);
    r->film = image;
    r->round = round;
    r->frame.replicates = image->replicates;
    r->frame.seed = r->options->seed;
    mcv_unlist_pixels(r);
    mcv_film_free(&film);
    free(splats);
    MCV_TRY(result);
    return r->scene.splats ? mcv_cl_clear(&r->cl, r->scene.splats, bytes, r->error) : MCV_OK;
}

mcv_result mcv_show_early(mcv_renderer *r) {
    const mcv_render_options *o = r->options;
    const mcv_film *film = r->film;
    const double paths = (double)film->width * film->height * film->replicates *
                         (double)(o->last > 0 ? o->last - o->first : SHORT_RENDER);
    const mcv_render_stats before = *r->stats;
    mcv_image picture;
    bool stop = false;
    if (!o->picture || paths <= SHORT_RENDER) return MCV_OK;
    const uint32_t stride = stride_for(film, paths);
    MCV_TRY(mcv_image_new(&picture, coarse(film->width, stride), coarse(film->height, stride),
                          film->channels, r->error));
    const mcv_result result = render_picture(r, &picture, stride, &stop);
    if (result == MCV_OK && !stop) o->picture(o->user, &picture, stride);
    mcv_image_free(&picture);
    /* Nothing of it is counted. */
    const double first_sample = r->stats->seconds_first_sample;
    const bool interrupted = r->stats->interrupted;
    *r->stats = before;
    r->stats->seconds_first_sample = first_sample;
    r->stats->interrupted = interrupted;
    return result;
}
