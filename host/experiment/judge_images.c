/* SPDX-License-Identifier: Apache-2.0 */
#include "experiment/judge_images.h"

#include "core/basics.h"
#include "experiment/set_image.h"
#include "io/values.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

mcv_result mcv_judge_images_open(mcv_judge_images *images, const mcv_measuring *asked,
                                 mcv_error *error) {
    const char *given = getenv("TMPDIR");
    char real[PATH_MAX];
    *images = (mcv_judge_images){.asked = asked, .count = asked->exposures ? asked->exposures : 1};
    /* Programs may work elsewhere: the path is absolute. */
    if (!realpath(given && given[0] ? given : "/tmp", real) ||
        snprintf(images->folder, sizeof images->folder, "%s/mcvisi-XXXXXX", real) >=
            (int)sizeof images->folder ||
        !mkdtemp(images->folder)) {
        images->folder[0] = '\0';
        return mcv_fail(error, MCV_FAILED, "no folder for exposures can be made in %s: %s",
                        given && given[0] ? given : "/tmp", strerror(errno));
    }
    return MCV_OK;
}

void mcv_judge_image_path(const mcv_judge_images *images, size_t exposure, char path[PATH_MAX]) {
    snprintf(path, PATH_MAX, "%s/image-%zu.tif", images->folder, exposure);
}

void mcv_judge_images_close(mcv_judge_images *images) {
    char path[PATH_MAX];
    json_decref(images->model);
    images->model = NULL;
    if (!images->folder[0]) return;
    for (size_t k = 0; k < images->count; ++k) {
        mcv_judge_image_path(images, k, path);
        unlink(path);
    }
    rmdir(images->folder);
    images->folder[0] = '\0';
}

static uint32_t seed_of(const mcv_judge_images *images, uint64_t number, size_t exposure) {
    const uint64_t words[3] = {images->asked->camera.camera.seed, number, exposure};
    const uint64_t hash = mcv_hash_bytes(MCV_HASH_BEGIN, words, sizeof words);
    return (uint32_t)(hash ^ hash >> 32);
}

/* The camera blurs the light in place: each exposure develops it anew. */
static mcv_result expose(mcv_judge_images *images, uint64_t number, size_t exposure,
                         const mcv_scene *scene, uint32_t sensor, const mcv_film *film,
                         mcv_error *error) {
    mcv_camera_settings settings = images->asked->camera;
    mcv_set_image light;
    mcv_read_out out = {.level = 0};
    char path[PATH_MAX];
    settings.camera.seed = seed_of(images, number, exposure);
    mcv_judge_image_path(images, exposure, path);
    mcv_result result = mcv_set_image_develop(scene, sensor, film, &light, error);
    if (result == MCV_OK && exposure == 0) {
        json_decref(images->model);
        images->model = light.parts[0].image.description
                            ? json_loads(light.parts[0].image.description, 0, NULL)
                            : NULL;
    }
    if (result == MCV_OK)
        result = mcv_camera_read_out(&settings, scene->path, &light.exr, &out, error);
    if (result == MCV_OK) {
        images->bits = out.camera.bits;
        result = mcv_values_write(path, &out.exposure.grey, out.camera.bits > 8 ? 16 : 8, error);
        mcv_exposure_free(&out.exposure);
    }
    mcv_set_image_free(&light);
    return result;
}

mcv_result mcv_judge_images_make(mcv_judge_images *images, uint64_t number, const mcv_scene *scene,
                                 uint32_t sensor, const mcv_film *film, mcv_error *error) {
    for (size_t k = 0; k < images->count; ++k)
        MCV_TRY(expose(images, number, k, scene, sensor, film, error));
    return MCV_OK;
}
