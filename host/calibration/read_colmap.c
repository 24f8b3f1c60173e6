/* SPDX-License-Identifier: Apache-2.0 */
/* Cameras of COLMAP: a folder with the texts of one camera and one image. */
#include "calibration/calibration.h"

#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

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

/* Numbers with blanks between them, at most `most`; *text is what follows. */
static int take_numbers(const char **text, double *numbers, int most) {
    int count = 0;
    for (char *end; count < most; ++count, *text = end) {
        numbers[count] = strtod(*text, &end);
        if (end == *text || !strchr(" \t\r", *end)) break;
    }
    *text += strspn(*text, " \t\r");
    return count;
}

static void take_word(const char **text, char *word, size_t size) {
    *text += strspn(*text, " \t");
    const size_t length = strcspn(*text, " \t\r");
    snprintf(word, size, "%.*s", (int)(length < size ? length : size - 1), *text);
    *text += length;
}

/* Models whose first numbers are one focal length, or two, and the centre; distortion follows. */
static const struct {
    const char *name;
    int focals, distortion;
} models[] = {{"SIMPLE_PINHOLE", 1, 0}, {"PINHOLE", 2, 0}, {"SIMPLE_RADIAL", 1, 1},
              {"RADIAL", 1, 2},         {"OPENCV", 2, 4},  {"FULL_OPENCV", 2, 8}};
enum { MODELS = sizeof models / sizeof models[0], MOST = 2 + 2 + 8 };

static mcv_result read_camera(const char *path, char *text, double wanted, mcv_calibration *camera,
                              mcv_error *error) {
    char model[32] = "", *rest = text;
    const char *line = next_line(&rest);
    double id = 0, size[2], n[MOST] = {0};
    int kind = 0;
    bool right = line && take_numbers(&line, &id, 1) == 1;
    if (right) take_word(&line, model, sizeof model);
    while (kind < MODELS && strcmp(models[kind].name, model) != 0) ++kind;
    if (right && kind == MODELS && model[0])
        return mcv_fail(error, MCV_BAD_INPUT,
                        "%s: the cameras have no model %s: undistort the pictures, which makes it "
                        "a PINHOLE",
                        path, model);
    right = right && kind < MODELS && take_numbers(&line, size, 2) == 2;
    const int most = right ? models[kind].focals + 2 + models[kind].distortion : 0;
    if (!right || take_numbers(&line, n, most) != most || *line)
        return mcv_fail(error, MCV_BAD_INPUT,
                        "%s: must have a line as in `1 PINHOLE 640 480 FX FY CX CY`, with as many "
                        "numbers as its model has",
                        path);
    if (next_line(&rest))
        return mcv_fail(error, MCV_BAD_INPUT, "%s: has several cameras: leave one of them", path);
    if (wanted == wanted && id != wanted)
        return mcv_fail(error, MCV_BAD_INPUT,
                        "%s: has camera %.0f, but the image is of camera %.0f", path, id, wanted);
    const int distortion = most - models[kind].distortion;
    const double focal[2] = {n[0], n[models[kind].focals - 1]},
                 centre[2] = {n[distortion - 2], n[distortion - 1]};
    /* k1, k2, p1, p2, k3 … k6 in OpenCV's order. */
    double c[MCV_OPENCV_COEFFICIENTS] = {0};
    memcpy(c, n + distortion, (size_t)models[kind].distortion * sizeof *c);
    MCV_TRY(mcv_calibration_check_numbers(path, c, MCV_OPENCV_COEFFICIENTS, error));
    mcv_lens_of_opencv(c, &camera->model.lens);
    MCV_TRY(mcv_calibration_set_size(path, size, camera, error));
    return mcv_calibration_set_perspective(path, focal, centre, camera, error);
}

/* *id becomes the number of the image's camera; NaN without an image. */
static mcv_result read_pose(const char *path, char *text, double *id, mcv_calibration *camera,
                            mcv_error *error) {
    enum { COUNT = 9 }; /* image, q, t, camera */
    char *rest = text;
    const char *line = next_line(&rest);
    double n[COUNT];
    *id = NAN;
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
    *id = n[8];
    return MCV_OK;
}

mcv_result mcv_calibration_read_colmap(const char *folder, mcv_calibration *camera,
                                       mcv_error *error) {
    char path[2][PATH_MAX], *text;
    double id;
    for (int i = 0; i < 2; ++i)
        if (snprintf(path[i], PATH_MAX, "%s/%s", folder, mcv_colmap_files[i]) >= PATH_MAX)
            return mcv_fail(error, MCV_BAD_INPUT, "%s: the path is too long", folder);
    MCV_TRY(mcv_calibration_load(path[1], &text, error));
    mcv_result result = read_pose(path[1], text, &id, camera, error);
    free(text);
    if (result == MCV_OK) result = mcv_calibration_load(path[0], &text, error);
    MCV_TRY(result);
    result = read_camera(path[0], text, id, camera, error);
    free(text);
    return result;
}
