/* SPDX-License-Identifier: Apache-2.0 */
/* Camera models from files of other programs. */
#include "calibration/calibration.h"

#include "core/output_file.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

enum { MOST_PIXELS = 1 << 16, MOST_BYTES = 1 << 24 };

/* --- what all formats set --- */

mcv_result mcv_calibration_check_numbers(const char *path, const double *numbers, size_t count,
                                         mcv_error *error) {
    for (size_t i = 0; i < count; ++i)
        if (!isfinite(numbers[i]))
            return mcv_fail(error, MCV_BAD_INPUT,
                            "%s: has distortion, of %g: must be finite numbers", path, numbers[i]);
    return MCV_OK;
}

mcv_result mcv_calibration_set_size(const char *path, const double size[2], mcv_calibration *camera,
                                    mcv_error *error) {
    for (int i = 0; i < 2; ++i) {
        if (!(size[i] >= 1 && size[i] <= MOST_PIXELS && size[i] == floor(size[i])))
            return mcv_fail(error, MCV_BAD_INPUT,
                            "%s: the image's %s of %g is not from 1 to %d whole pixels", path,
                            i ? "height" : "width", size[i], MOST_PIXELS);
        camera->model.size[i] = (uint32_t)size[i];
    }
    return MCV_OK;
}

static bool is_rotation(const double r[9]) {
    bool right = true;
    for (int i = 0; i < 9; ++i) {
        double product = 0; /* R R^T, by rows */
        for (int k = 0; k < 3; ++k) product += r[3 * (i / 3) + k] * r[3 * (i % 3) + k];
        right = right && fabs(product - (i % 4 == 0)) < 1e-6;
    }
    const double third[3] = {r[1] * r[5] - r[2] * r[4], r[2] * r[3] - r[0] * r[5],
                             r[0] * r[4] - r[1] * r[3]};
    return right && third[0] * r[6] + third[1] * r[7] + third[2] * r[8] > 0;
}

static mcv_result check(const char *path, const mcv_calibration *camera, const double scale[2],
                        const double centre[2], mcv_error *error) {
    const mcv_camera_model *m = &camera->model;
    for (int i = 0; i < 2; ++i) {
        if (!(scale[i] > 0) || !isfinite(scale[i]) || !isfinite(centre[i]) || !(m->pixel[i] >= 0) ||
            !isfinite(m->pixel[i]))
            return mcv_fail(error, MCV_BAD_INPUT,
                            "%s: focal lengths and sizes of pixels must be numbers above 0", path);
    }
    if (!is_rotation(m->rotation))
        return mcv_fail(error, MCV_BAD_INPUT,
                        "%s: its rotation is none: rows must have the length 1, be at right angles "
                        "and right-handed, to 1e-6",
                        path);
    for (int i = 0; i < 3; ++i)
        if (!isfinite(m->translation[i]))
            return mcv_fail(error, MCV_BAD_INPUT, "%s: its place is not finite", path);
    return MCV_OK;
}

mcv_result mcv_calibration_set_perspective(const char *path, const double focal[2],
                                           const double centre[2], mcv_calibration *camera,
                                           mcv_error *error) {
    mcv_camera_model *m = &camera->model;
    const double k[9] = {focal[0], 0, centre[0], 0, focal[1], centre[1], 0, 0, 1};
    memcpy(m->k, k, sizeof m->k);
    return check(path, camera, focal, centre, error);
}

mcv_result mcv_calibration_set_telecentric(const char *path, const double object_pixel[2],
                                           const double centre[2], mcv_calibration *camera,
                                           mcv_error *error) {
    mcv_camera_model *m = &camera->model;
    m->telecentric = true;
    for (int i = 0; i < 2; ++i) {
        m->object_pixel[i] = object_pixel[i];
        for (int j = 0; j < 3; ++j) m->affine[4 * i + j] = m->rotation[3 * i + j] / object_pixel[i];
        m->affine[4 * i + 3] = m->translation[i] / object_pixel[i] + centre[i];
    }
    return check(path, camera, object_pixel, centre, error);
}

/* --- files --- */

mcv_result mcv_calibration_load(const char *path, char **text, mcv_error *error) {
    static const char mark[] = "\xef\xbb\xbf"; /* that Windows sets before UTF-8 */
    uint8_t *bytes;
    size_t size;
    MCV_TRY(mcv_file_load(path, &bytes, &size, error));
    const size_t skipped = size >= 3 && memcmp(bytes, mark, 3) == 0 ? 3 : 0;
    *text = size < MOST_BYTES && !memchr(bytes, 0, size) ? malloc(size + 1) : NULL;
    if (*text) {
        memcpy(*text, bytes + skipped, size - skipped);
        (*text)[size - skipped] = '\0';
    }
    free(bytes);
    if (*text) return MCV_OK;
    mcv_fail(error, MCV_BAD_INPUT, "%s: is no text of a camera", path);
    return MCV_BAD_INPUT;
}

/* --- our own, and all --- */

static mcv_result read_json(const char *path, const char *text, mcv_calibration *camera,
                            mcv_error *error) {
    mcv_camera_model model;
    double centre[2];
    bool is_one;
    MCV_TRY(mcv_camera_model_read(text, path, &model, &is_one, error));
    if (!is_one)
        return mcv_fail(error, MCV_BAD_INPUT,
                        "%s: is no camera model of `mcvisi camera-model --format json`", path);
    const bool macro = model.macro[0] * model.macro[1] > 1;
    camera->model = model;
    camera->model.nodes = NULL; /* those of `model` are freed */
    camera->model.node_count = 0;
    camera->model.render_error.items = NULL;
    mcv_camera_model_free(&model);
    camera->posed = true;
    MCV_TRY(mcv_camera_model_check_places(&camera->model, path, error));
    if (macro)
        return mcv_fail(error, MCV_BAD_INPUT,
                        "%s: is of a light field camera, whose lens is not in its model: describe "
                        "it by a sensor of type lightField",
                        path);
    mcv_calibration_centre(&camera->model, centre);
    MCV_TRY(mcv_calibration_set_size(
        path, (const double[]){camera->model.size[0], camera->model.size[1]}, camera, error));
    const double focal[2] = {camera->model.k[0], camera->model.k[4]};
    return camera->model.telecentric
               ? mcv_calibration_set_telecentric(path, camera->model.object_pixel, centre, camera,
                                                 error)
               : mcv_calibration_set_perspective(path, focal, centre, camera, error);
}

static mcv_result read_text(const char *path, const char *text, mcv_calibration *camera,
                            mcv_error *error) {
    const char *first = text + strspn(text, " \t\r\n");
    if (first[0] == '{') return read_json(path, text, camera, error);
    if (strstr(text, "_scan_") || strstr(text, "ParGroup:"))
        return mcv_calibration_read_halcon(path, text, camera, error);
    return mcv_calibration_read_yaml(path, text, camera, error);
}

/* A name that glTF cannot hold is none. */
static void keep_name(char *name) {
    json_t *string = json_string(name);
    bool right = string != NULL;
    for (const char *c = name; *c; ++c) right = right && (unsigned char)*c >= ' ' && *c != 127;
    if (!right) name[0] = '\0';
    json_decref(string);
}

mcv_result mcv_calibration_read(const char *path, mcv_calibration *camera, mcv_error *error) {
    static const double identity[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    struct stat status;
    char *text;
    *camera = (mcv_calibration){.model = {.lens = mcv_lens_map_none(),
                                          .macro = {1, 1},
                                          .focused_depth = NAN,
                                          .f_number = NAN,
                                          .numerical_aperture = NAN}};
    memcpy(camera->model.rotation, identity, sizeof identity);
    mcv_result result = MCV_OK;
    if (stat(path, &status) == 0 && S_ISDIR(status.st_mode)) {
        result = mcv_calibration_read_colmap(path, camera, error);
    } else {
        MCV_TRY(mcv_calibration_load(path, &text, error));
        result = read_text(path, text, camera, error);
        free(text);
    }
    keep_name(camera->name);
    return result;
}
