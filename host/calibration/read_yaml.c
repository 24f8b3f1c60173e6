/* SPDX-License-Identifier: Apache-2.0 */
/* Camera models of OpenCV (cv::FileStorage) and ROS (CameraInfo): keys at the begin of a line, with
 * a number, a word, or a matrix whose numbers stand in brackets. */
#include "calibration/calibration.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* What follows "KEY:" up to the next key; NULL where there is none. */
static const char *find(const char *text, const char *key, size_t *length) {
    const size_t size = strlen(key);
    for (const char *line = text; line; line = strchr(line, '\n')) {
        line += line != text;
        if (strncmp(line, key, size) != 0 || line[size] != ':') continue;
        const char *value = line + size + 1, *end = value;
        do {
            end += strcspn(end, "\n");
            end += *end == '\n';
        } while (*end == ' ' || *end == '\t' || *end == '\r' || *end == '\n');
        *length = (size_t)(end - value);
        return value;
    }
    return NULL;
}

static bool get_number(const char *text, const char *key, double *number) {
    size_t length;
    char *end;
    const char *value = find(text, key, &length);
    if (!value) return false;
    *number = strtod(value, &end);
    return end != value && end <= value + length;
}

static void get_word(const char *text, const char *key, char *word, size_t size) {
    size_t length;
    const char *value = find(text, key, &length);
    word[0] = '\0';
    if (!value) return;
    value += strspn(value, " \t\"'");
    snprintf(word, size, "%.*s", (int)strcspn(value, " \t\"'\r\n"), value);
}

/* The numbers in the brackets; at most `most`. Returns how many there are, -1 for none. */
static int get_list(const char *text, const char *key, double *numbers, int most) {
    size_t length;
    const char *value = find(text, key, &length), *open = value ? memchr(value, '[', length) : NULL;
    int count = 0;
    if (!open) return -1;
    for (++open; open < value + length && *open != ']'; ++count) {
        char *end;
        const double number = strtod(open, &end);
        if (end == open) return -1;
        if (count < most) numbers[count] = number;
        open = end + strspn(end, " \t\r\n,");
    }
    return count;
}

static bool get_matrix(const char *text, const char *key, double *numbers, int count) {
    return get_list(text, key, numbers, count) == count;
}

static void get_pose(const char *text, mcv_calibration *camera) {
    mcv_camera_model *m = &camera->model;
    double vector[3];
    const bool turned =
        get_matrix(text, "rotation", m->rotation, 9) || get_matrix(text, "R", m->rotation, 9);
    const bool by_vector = !turned && get_matrix(text, "rvec", vector, 3);
    if (by_vector) mcv_rotation_of_vector(vector, m->rotation);
    camera->posed = (turned || by_vector) && (get_matrix(text, "tvec", m->translation, 3) ||
                                              get_matrix(text, "T", m->translation, 3));
}

static mcv_result fail_size(const char *path, const char *key, const char *what, mcv_error *error) {
    return mcv_fail(error, MCV_BAD_INPUT, "%s: %s: must be %s", path, key, what);
}

static mcv_result read_telecentric(const char *path, const char *text, mcv_calibration *camera,
                                   mcv_error *error) {
    double p[12], object_pixel[2], centre[2];
    if (!get_matrix(text, "projection_matrix", p, 12))
        return fail_size(path, "projection_matrix", "3 x 4 numbers in brackets", error);
    if (!get_matrix(text, "object_pixel_size", object_pixel, 2))
        return fail_size(path, "object_pixel_size", "2 lengths in metres, in brackets", error);
    for (int i = 0; i < 2; ++i)
        centre[i] = p[4 * i + 3] + 0.5 - camera->model.translation[i] / object_pixel[i];
    return mcv_calibration_set_telecentric(path, object_pixel, centre, camera, error);
}

static mcv_result read_perspective(const char *path, const char *text, mcv_calibration *camera,
                                   mcv_error *error) {
    enum { MOST = 16 };
    double k[9], distortion[MOST] = {0};
    char model[64];
    if (!get_matrix(text, "camera_matrix", k, 9))
        return fail_size(path, "camera_matrix", "3 x 3 numbers in brackets", error);
    if (k[1] != 0)
        return mcv_fail(error, MCV_BAD_INPUT,
                        "%s: camera_matrix has a skew of %g: sensors have square corners", path,
                        k[1]);
    get_word(text, "distortion_model", model, sizeof model);
    const int count = get_list(text, "distortion_coefficients", distortion, MOST);
    if (count > MOST)
        return fail_size(path, "distortion_coefficients", "at most 14 numbers", error);
    MCV_TRY(mcv_calibration_refuse_distortion(path, distortion, MOST, error));
    if (strcmp(model, "equidistant") == 0 || strcmp(model, "fisheye") == 0)
        return mcv_fail(error, MCV_BAD_INPUT,
                        "%s: distortion_model %s is a distortion by itself: the cameras have none: "
                        "undistort the pictures, and give the model of those",
                        path, model);
    const double focal[2] = {k[0], k[4]}, centre[2] = {k[2] + 0.5, k[5] + 0.5};
    return mcv_calibration_set_perspective(path, focal, centre, camera, error);
}

mcv_result mcv_calibration_read_yaml(const char *path, const char *text, mcv_calibration *camera,
                                     mcv_error *error) {
    mcv_camera_model *m = &camera->model;
    double size[2] = {0, 0};
    char model[64];
    if (!get_number(text, "image_width", size) || !get_number(text, "image_height", size + 1))
        return mcv_fail(error, MCV_BAD_INPUT,
                        "%s: has no image_width and image_height: must be a camera of OpenCV, ROS, "
                        "HALCON or COLMAP, or our JSON",
                        path);
    for (int i = 0; i < 2; ++i) m->size[i] = size[i] >= 1 && size[i] < 1e9 ? (uint32_t)size[i] : 0;
    get_pose(text, camera);
    if (!get_matrix(text, "pixel_size", m->pixel, 2)) m->pixel[0] = m->pixel[1] = 0;
    if (!get_number(text, "working_distance", &m->focused_depth)) m->focused_depth = NAN;
    if (!get_number(text, "f_number", &m->f_number)) m->f_number = NAN;
    get_word(text, "camera_name", camera->name, sizeof camera->name);
    get_word(text, "model", model, sizeof model);
    return strcmp(model, "telecentric") == 0 ? read_telecentric(path, text, camera, error)
                                             : read_perspective(path, text, camera, error);
}
