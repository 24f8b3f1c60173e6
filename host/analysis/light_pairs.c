/* SPDX-License-Identifier: Apache-2.0 */
#include "analysis/light_pairs.h"

#include "io/exr_make.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* The camera that exposes the picture without the defect: --expose-to takes its level from it. */
static mcv_result choose_camera(const mcv_camera_settings *settings,
                                const mcv_light_picture *picture, mcv_read_out *out,
                                mcv_error *error) {
    mcv_exr light;
    MCV_TRY(mcv_camera_check_settings(settings, error));
    MCV_TRY(mcv_exr_copy(picture->exr, &light, error)); /* it is blurred in place */
    const mcv_result result = mcv_camera_read_out(settings, picture->path, &light, out, error);
    if (result == MCV_OK) mcv_exposure_free(&out->exposure);
    mcv_exr_free(&light);
    return result;
}

/* Replicate r as the electrons that the lens lets through. */
static mcv_result read_replicate(const mcv_camera_settings *settings, const mcv_light_picture *from,
                                 const mcv_camera *camera, uint32_t r, double *electrons,
                                 mcv_error *error) {
    const mcv_film *film = from->film;
    const size_t plane = (size_t)film->width * film->height, count = plane * film->channels;
    mcv_exr_part part = from->exr->parts[0];
    mcv_exr one = *from->exr; /* the header, for the lens */
    mcv_correlation unused;
    char words[128];
    MCV_TRY(mcv_image_new(&part.image, film->width, film->height, film->channels, error));
    one.parts = &part;
    one.part_count = 1;
    for (size_t i = 0; i < count; ++i)
        part.image.pixels[i] = (float)fmax(0, film->sums[r * count + i] / (double)film->samples);
    const mcv_result result = mcv_camera_blur(settings, from->path, &one, words, &unused, error);
    for (size_t i = 0; i < count; ++i) {
        const size_t channel = i / plane;
        electrons[r * count + i] =
            camera->electrons_per_unit[channel < 3 ? channel : 2] * (double)part.image.pixels[i];
    }
    mcv_image_free(&part.image);
    return result;
}

mcv_result mcv_light_pairs_read(const mcv_camera_settings *settings,
                                const mcv_light_picture pictures[2], mcv_light_pairs *read,
                                mcv_error *error) {
    const mcv_film *film = pictures[0].film;
    mcv_read_out out;
    *read = (mcv_light_pairs){.lens = ""};
    MCV_TRY(choose_camera(settings, pictures + 1, &out, error));
    for (int i = 0; i < 2; ++i) {
        read->electrons[i] = malloc(mcv_film_values(film) * sizeof(double));
        if (!read->electrons[i])
            return mcv_fail(error, MCV_FAILED, "no memory for %u replicates", film->replicates);
        for (uint32_t r = 0; r < film->replicates; ++r)
            MCV_TRY(
                read_replicate(settings, pictures + i, &out.camera, r, read->electrons[i], error));
    }
    read->pairs = (mcv_pairs){.width = film->width,
                              .height = film->height,
                              .channels = film->channels,
                              .replicates = film->replicates,
                              .with = read->electrons[0],
                              .without = read->electrons[1],
                              .correlation = out.correlation};
    read->camera = out.camera;
    memcpy(read->lens, out.lens, sizeof read->lens);
    return MCV_OK;
}

void mcv_light_pairs_free(mcv_light_pairs *read) {
    for (int i = 0; i < 2; ++i) free(read->electrons[i]);
}
