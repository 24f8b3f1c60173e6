/* SPDX-License-Identifier: Apache-2.0 */
/* Tables and lens files by the first byte: rays, Zemax, CODE V, cameras of other programs, and the
 * options of verbs as JSON. */
#include "fuzz.h"

#include "calibration/calibration.h"
#include "lens/lens_file.h"
#include "options/command.h"
#include "verbs/rays.h"

static void read_lens(const char *path, mcv_error *error) {
    const mcv_lens_options options = {0};
    mcv_lens_report report = {0};
    json_t *scene = NULL;
    const mcv_result result = mcv_lens_file_read(path, &options, &scene, &report, error);
    fuzz_sentence(result, error);
    if (result == MCV_OK) json_decref(scene);
}

static void read_options(const uint8_t *data, size_t size, mcv_error *error) {
    const char *const arguments[2] = {"scene.gltf", NULL};
    mcv_options_given given;
    char *text = calloc(1, size + 1);
    if (!text) return;
    memcpy(text, data, size);
    const mcv_result result =
        mcv_options_read(text, NULL, size % MCV_VERB_COUNT, arguments, NULL, &given, error);
    fuzz_sentence(result, error);
    if (result == MCV_OK) mcv_options_free(&given);
    free(text);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    static const char *const names[] = {"in.csv", "in.zmx", "in.seq", "in.yaml", "in.dat"};
    mcv_error error = {""};
    mcv_trace_ray *rays = NULL;
    mcv_calibration camera;
    size_t count;
    if (size < 1) return 0;
    const unsigned kind = data[0] % 6;
    if (kind == 5) {
        read_options(data + 1, size - 1, &error);
        return 0;
    }
    fuzz_file(names[kind], data + 1, size - 1);
    if (kind == 0) {
        fuzz_sentence(mcv_rays_read(names[0], &rays, &count, &error), &error);
        free(rays);
    } else if (kind < 3) {
        read_lens(names[kind], &error);
    } else {
        fuzz_sentence(mcv_calibration_read(names[kind], &camera, &error), &error);
    }
    return 0;
}
