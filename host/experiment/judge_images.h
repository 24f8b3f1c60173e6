/* SPDX-License-Identifier: Apache-2.0 */
/* The exposures that programs look at (experiment/judge.h): files in a folder of their own, which
 * goes with them. */
#ifndef MCVISI_HOST_EXPERIMENT_JUDGE_IMAGES_H
#define MCVISI_HOST_EXPERIMENT_JUDGE_IMAGES_H

#include "experiment/measure.h"
#include "film/film.h"

#include <jansson.h>
#include <limits.h>

typedef struct mcv_judge_images {
    const mcv_measuring *asked;
    char folder[PATH_MAX - 64]; /* "": there is none */
    size_t count;               /* exposures of a render */
    uint64_t bits;              /* of a grey value */
    json_t *model;              /* of the camera, or NULL */
} mcv_judge_images;

/* Makes the folder, in that of the environment's TMPDIR. */
mcv_result mcv_judge_images_open(mcv_judge_images *images, const mcv_measuring *asked,
                                 mcv_error *error);
void mcv_judge_images_close(mcv_judge_images *images);

void mcv_judge_image_path(const mcv_judge_images *images, size_t exposure, char path[PATH_MAX]);

/* Writes the exposures of a render. Each has noise of its own, by the number of the scene: another
 * scene has other noise. */
mcv_result mcv_judge_images_make(mcv_judge_images *images, uint64_t number, const mcv_scene *scene,
                                 uint32_t sensor, const mcv_film *film, mcv_error *error);

#endif
