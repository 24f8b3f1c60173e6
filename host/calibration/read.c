/* SPDX-License-Identifier: Apache-2.0 */
/* Camera models from files of other programs. */
#include "calibration/calibration.h"

#include "core/output_file.h"

#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

enum { MOST_PIXELS = 1 << 16, MOST_BYTES = 1 << 24 };

/* --- what all formats set --- */

mcv_result mcv_calibration_refuse_distortion(const char *path, const double *numbers, size_t count,
                                             mcv_error *error) {
    for (size_t i = 0; i < count; ++i)
        if (numbers[i] != 0)
            return mcv_fail(error, MCV_BAD_INPUT,
                            "%s: has distortion, of %g: the cameras have none: undistort the "
                            "pictures, and give the model of those",
                            path, numbers[i]);
    return MCV_OK;
}

static mcv_result check(const char *path, const mcv_calibration *camera, const double scale[2],
                        const double centre[2], mcv_error *error) {
    const mcv_camera_model *m = &camera->model;
    for (int i = 0; i < 2; ++i) {
        if (m->size[i] < 1 || m->size[i] > MOST_PIXELS)
            return mcv_fail(error, MCV_BAD_INPUT,
                            "%s: the image's %s is missing, or not from 1 to %d pixels", path,
                            i ? "height" : "width", MOST_PIXELS);
        if (!(scale[i] > 0) || !isfinite(scale[i]) || !isfinite(centre[i]) || !(m->pixel[i] >= 0) ||
            !isfinite(m->pixel[i]))
            return mcv_fail(error, MCV_BAD_INPUT,
                            "%s: focal lengths and sizes of pixels must be numbers above 0", path);
    }
    for (int i = 0; i < 9; ++i) {
        double product = 0; /* R R^T, by rows */
        for (int k = 0; k < 3; ++k)
            product += m->rotation[3 * (i / 3) + k] * m->rotation[3 * (i % 3) + k];
        if (!(fabs(product - (i % 4 == 0)) < 1e-6) || !isfinite(m->translation[i % 3]))
            return mcv_fail(error, MCV_BAD_INPUT, "%s: its rotation is none, or its place no place",
                            path);
    }
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

static mcv_result load(const char *path, char **text, mcv_error *error) {
    uint8_t *bytes;
    size_t size;
    MCV_TRY(mcv_file_load(path, &bytes, &size, error));
    *text = size < MOST_BYTES && !memchr(bytes, 0, size) ? malloc(size + 1) : NULL;
    if (*text) {
        memcpy(*text, bytes, size);
        (*text)[size] = '\0';
    }
    free(bytes);
    if (*text) return MCV_OK;
    mcv_fail(error, MCV_BAD_INPUT, "%s: is no text of a camera", path);
    return MCV_BAD_INPUT;
}

/* The next line that is neither empty nor a comment; it is ended. */
static char *next_line(char **rest) {
    while (*rest && **rest) {
        char *line = *rest, *end = strchr(line, '\n');
        *rest = end ? end + 1 : NULL;
        if (end) *end = '\0';
        line += strspn(line, " \t\r");
        if (line[0] && line[0] != '#') return line;
    }
    return NULL;
}

/* --- COLMAP --- */

/* Numbers with blanks between them, at most `most`; *text is what follows. */
static int take_numbers(const char **text, double *numbers, int most) {
    int count = 0;
    for (char *end; count < most; ++count, *text = end) {
        numbers[count] = strtod(*text, &end);
        if (end == *text) break;
    }
    return count;
}

static void take_word(const char **text, char *word, size_t size) {
    *text += strspn(*text, " \t");
    const size_t length = strcspn(*text, " \t\r");
    snprintf(word, size, "%.*s", (int)(length < size ? length : size - 1), *text);
    *text += length;
}

/* Distortion stands after the focal lengths and the centre. */
static mcv_result read_colmap_camera(const char *path, char *text, mcv_calibration *camera,
                                     mcv_error *error) {
    enum { MOST = 12 };
    static const char *const known[] = {"PINHOLE", "SIMPLE_PINHOLE", "SIMPLE_RADIAL",
                                        "RADIAL",  "OPENCV",         "FULL_OPENCV"};
    char model[32] = "", *rest = text;
    const char *line = next_line(&rest);
    double id, size[2], n[MOST] = {0};
    bool right = line && take_numbers(&line, &id, 1) == 1, is_known = false;
    if (right) take_word(&line, model, sizeof model);
    const bool one = strncmp(model, "SIMPLE_", 7) == 0 || strcmp(model, "RADIAL") == 0;
    const int needed = one ? 3 : 4;
    for (size_t i = 0; i < sizeof known / sizeof known[0]; ++i)
        is_known = is_known || strcmp(model, known[i]) == 0;
    right = right && is_known && take_numbers(&line, size, 2) == 2 &&
            take_numbers(&line, n, MOST) >= needed;
    if (!right)
        return mcv_fail(error, MCV_BAD_INPUT,
                        "%s: must have a line as in `1 PINHOLE 640 480 FX FY CX CY`", path);
    if (next_line(&rest))
        return mcv_fail(error, MCV_BAD_INPUT, "%s: has several cameras: leave one of them", path);
    for (int i = 0; i < 2; ++i)
        camera->model.size[i] = size[i] >= 1 && size[i] < 1e9 ? (uint32_t)size[i] : 0;
    MCV_TRY(mcv_calibration_refuse_distortion(path, n + needed, MOST - (size_t)needed, error));
    const double focal[2] = {n[0], n[one ? 0 : 1]}, centre[2] = {n[needed - 2], n[needed - 1]};
    return mcv_calibration_set_perspective(path, focal, centre, camera, error);
}

static mcv_result read_colmap_pose(const char *path, char *text, mcv_calibration *camera,
                                   mcv_error *error) {
    enum { COUNT = 9 }; /* image, q, t, camera */
    char *rest = text;
    const char *line = next_line(&rest);
    double n[COUNT];
    if (!line) return MCV_OK;
    if (take_numbers(&line, n, COUNT) < COUNT)
        return mcv_fail(error, MCV_BAD_INPUT,
                        "%s: must have a line as in `1 QW QX QY QZ TX TY TZ 1 NAME`", path);
    take_word(&line, camera->name, sizeof camera->name);
    /* The line after it is of points, and may be empty. */
    if (rest) rest = strchr(rest, '\n');
    if (next_line(&rest))
        return mcv_fail(error, MCV_BAD_INPUT, "%s: has several images: leave one of them", path);
    mcv_rotation_of_quaternion(n + 1, camera->model.rotation);
    memcpy(camera->model.translation, n + 5, sizeof camera->model.translation);
    camera->posed = true;
    return MCV_OK;
}

static mcv_result read_colmap(const char *folder, mcv_calibration *camera, mcv_error *error) {
    char path[2][PATH_MAX], *text;
    for (int i = 0; i < 2; ++i)
        if (snprintf(path[i], PATH_MAX, "%s/%s", folder, mcv_colmap_files[i]) >= PATH_MAX)
            return mcv_fail(error, MCV_BAD_INPUT, "%s: the path is too long", folder);
    MCV_TRY(load(path[1], &text, error));
    mcv_result result = read_colmap_pose(path[1], text, camera, error);
    free(text);
    if (result == MCV_OK) result = load(path[0], &text, error);
    MCV_TRY(result);
    result = read_colmap_camera(path[0], text, camera, error);
    free(text);
    return result;
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
    if (macro)
        return mcv_fail(error, MCV_BAD_INPUT,
                        "%s: is of a light field camera, whose lens is not in its model: describe "
                        "it by a sensor of type lightField",
                        path);
    mcv_calibration_centre(&camera->model, centre);
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
    if (strstr(text, "area_scan_") || strstr(text, "ParGroup:"))
        return mcv_calibration_read_halcon(path, text, camera, error);
    return mcv_calibration_read_yaml(path, text, camera, error);
}

mcv_result mcv_calibration_read(const char *path, mcv_calibration *camera, mcv_error *error) {
    static const double identity[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    struct stat status;
    char *text;
    *camera = (mcv_calibration){
        .model = {
            .macro = {1, 1}, .focused_depth = NAN, .f_number = NAN, .numerical_aperture = NAN}};
    memcpy(camera->model.rotation, identity, sizeof identity);
    if (stat(path, &status) == 0 && S_ISDIR(status.st_mode))
        return read_colmap(path, camera, error);
    MCV_TRY(load(path, &text, error));
    const mcv_result result = read_text(path, text, camera, error);
    free(text);
    return result;
}
