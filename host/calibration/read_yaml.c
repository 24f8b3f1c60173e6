/* SPDX-License-Identifier: Apache-2.0 */
/* Camera models of OpenCV (cv::FileStorage) and ROS (CameraInfo): keys at the begin of a line, with
 * a number, a word, or a list of numbers. */
#include "calibration/calibration.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* A file, and where to say what is wrong with it. */
typedef struct yaml {
    const char *path, *text;
    mcv_error *error;
} yaml;

/* What follows "KEY:" up to the next key; NULL where there is none. */
static const char *find(const char *text, const char *key, size_t *length) {
    const size_t size = strlen(key);
    for (const char *line = text, *next; line; line = next) {
        next = strchr(line, '\n');
        if (next) ++next;
        if (strncmp(line, key, size) != 0 || line[size] != ':') continue;
        const char *value = line + size + 1, *end = value;
        do {
            end += strcspn(end, "\n");
            end += *end == '\n';
        } while ((*end && strchr(" \t\r\n#", *end)) || (end[0] == '-' && end[1] == ' '));
        *length = (size_t)(end - value);
        return value;
    }
    return NULL;
}

/* The value of a key, once in the file; *value is NULL where the key is missing. */
static mcv_result find_once(const yaml *y, const char *key, const char **value, size_t *length) {
    size_t other;
    *value = find(y->text, key, length);
    if (*value && find(*value + *length, key, &other))
        return mcv_fail(y->error, MCV_BAD_INPUT, "%s: %s stands there twice: leave one camera",
                        y->path, key);
    return MCV_OK;
}

static bool has(const yaml *y, const char *key) {
    size_t length;
    return find(y->text, key, &length) != NULL;
}

/* The numbers of a value: in brackets, also nested ones, or each behind a dash. Words before them
 * are passed over (rows, cols, dt), and the key `data` begins them. At most `most` are kept.
 * Returns how many there are, -1 if something else stands among them. */
static int parse_list(const char *value, size_t length, double *numbers, int most) {
    const char *const end = value + length, *at = memchr(value, '[', length);
    const char *data = memmem(value, length, "data:", 5);
    if (data) at = data + 5;
    if (!at) at = value;
    int count = 0, depth = 0;
    while (at < end) {
        if (*at == '#') {
            at += strcspn(at, "\n");
        } else if (strchr(" \t\r\n,", *at) || (*at == '-' && at[1] == ' ')) {
            ++at;
        } else if (*at == '[') {
            ++depth;
            ++at;
        } else if (*at == ']') {
            ++at;
            if (--depth <= 0) return depth < 0 ? -1 : count;
        } else {
            char *after;
            const double number = strtod(at, &after);
            /* Behind a list with dashes another key may follow. */
            if (after == at) return depth == 0 && count > 0 && at[-1] != '-' ? count : -1;
            if (*after && !strchr(" \t\r\n,]#", *after)) return -1;
            if (count < most) numbers[count] = number;
            ++count;
            at = after;
        }
    }
    return depth == 0 ? count : -1;
}

/* Takes from `least` to `most` numbers of a key. *count is 0 where the key is missing. */
static mcv_result take_list(const yaml *y, const char *key, double *numbers, int least, int most,
                            int *count) {
    const char *value;
    char wanted[32];
    size_t length;
    *count = 0;
    MCV_TRY(find_once(y, key, &value, &length));
    if (!value) return MCV_OK;
    *count = parse_list(value, length, numbers, most);
    if (*count >= least && *count <= most) return MCV_OK;
    if (least == most)
        snprintf(wanted, sizeof wanted, "%d", most);
    else
        snprintf(wanted, sizeof wanted, "%d to %d", least, most);
    return mcv_fail(y->error, MCV_BAD_INPUT, "%s: %s: must be %s numbers in brackets, as in [0, 1]",
                    y->path, key, wanted);
}

/* As many numbers; *is_there is false where the key is missing. */
static mcv_result take(const yaml *y, const char *key, double *numbers, int count, bool *is_there) {
    int found;
    MCV_TRY(take_list(y, key, numbers, count, count, &found));
    *is_there = found > 0;
    return MCV_OK;
}

static mcv_result need(const yaml *y, const char *key, double *numbers, int count) {
    bool is_there;
    MCV_TRY(take(y, key, numbers, count, &is_there));
    if (is_there) return MCV_OK;
    return mcv_fail(y->error, MCV_BAD_INPUT, "%s: %s is missing: %d numbers in brackets", y->path,
                    key, count);
}

static void get_word(const yaml *y, const char *key, char *word, size_t size) {
    size_t length;
    const char *value = find(y->text, key, &length);
    word[0] = '\0';
    if (!value) return;
    value += strspn(value, " \t\"'");
    snprintf(word, size, "%.*s", (int)strcspn(value, " \t\"'\r\n"), value);
}

/* --- what a camera has --- */

static mcv_result contradict(const yaml *y, const char *a, const char *b) {
    return mcv_fail(y->error, MCV_BAD_INPUT, "%s: %s and %s contradict each other", y->path, a, b);
}

/* The pose by our keys, or by R and T of OpenCV, which are nothing without each other: R alone may
 * be ROS's rectification. */
static mcv_result take_pose(const yaml *y, mcv_calibration *camera) {
    mcv_camera_model *m = &camera->model;
    double vector[3] = {0}, other[9] = {0};
    bool turned, by_vector, placed;
    MCV_TRY(take(y, "rotation", m->rotation, 9, &turned));
    MCV_TRY(take(y, "rvec", vector, 3, &by_vector));
    MCV_TRY(take(y, "tvec", m->translation, 3, &placed));
    if (by_vector) mcv_rotation_of_vector(vector, other);
    for (int i = 0; turned && by_vector && i < 9; ++i)
        if (!(fabs(m->rotation[i] - other[i]) < 1e-6)) return contradict(y, "rotation", "rvec");
    if (by_vector && !turned) memcpy(m->rotation, other, sizeof other);
    turned = turned || by_vector;
    if (!turned && !placed && has(y, "R") && has(y, "T")) {
        MCV_TRY(take(y, "R", m->rotation, 9, &turned));
        MCV_TRY(take(y, "T", m->translation, 3, &placed));
    }
    if (turned != placed)
        return mcv_fail(y->error, MCV_BAD_INPUT, "%s: states a pose by half: %s is missing",
                        y->path, turned ? "tvec" : "rotation or rvec");
    camera->posed = placed;
    return MCV_OK;
}

static mcv_result take_telecentric(const yaml *y, mcv_calibration *camera) {
    mcv_camera_model *m = &camera->model;
    double p[12] = {0}, object_pixel[2] = {0}, centre[2];
    MCV_TRY(need(y, "projection_matrix", p, 12));
    MCV_TRY(need(y, "object_pixel_size", object_pixel, 2));
    for (int i = 0; i < 2; ++i)
        centre[i] = p[4 * i + 3] + 0.5 - m->translation[i] / object_pixel[i];
    MCV_TRY(mcv_calibration_set_telecentric(y->path, object_pixel, centre, camera, y->error));
    for (int i = 0; i < 2; ++i)
        for (int j = 0; j < 3; ++j)
            if (!(fabs(p[4 * i + j] - m->affine[4 * i + j]) * object_pixel[i] < 1e-6))
                return contradict(y, "projection_matrix", "rotation or object_pixel_size");
    return MCV_OK;
}

static mcv_result take_distortion(const yaml *y, mcv_lens_map *lens) {
    enum { MOST = MCV_OPENCV_COEFFICIENTS };
    double distortion[MOST] = {0};
    char model[64];
    int count;
    MCV_TRY(take_list(y, "distortion_coefficients", distortion, 1, MOST, &count));
    MCV_TRY(mcv_calibration_check_numbers(y->path, distortion, MOST, y->error));
    mcv_lens_of_opencv(distortion, lens);
    get_word(y, "distortion_model", model, sizeof model);
    if (strcmp(model, "equidistant") != 0 && strcmp(model, "fisheye") != 0) return MCV_OK;
    return mcv_fail(y->error, MCV_BAD_INPUT,
                    "%s: distortion_model %s is none of the sensors': undistort the pictures, and "
                    "give the model of those",
                    y->path, model);
}

static mcv_result take_perspective(const yaml *y, mcv_calibration *camera) {
    double k[9] = {0};
    MCV_TRY(need(y, "camera_matrix", k, 9));
    if (k[1] != 0)
        return mcv_fail(y->error, MCV_BAD_INPUT,
                        "%s: camera_matrix has a skew of %g: sensors have square corners", y->path,
                        k[1]);
    if (k[3] != 0 || k[6] != 0 || k[7] != 0 || k[8] != 1)
        return mcv_fail(y->error, MCV_BAD_INPUT,
                        "%s: camera_matrix: must be [fx, 0, cx, 0, fy, cy, 0, 0, 1]", y->path);
    MCV_TRY(take_distortion(y, &camera->model.lens));
    const double focal[2] = {k[0], k[4]}, centre[2] = {k[2] + 0.5, k[5] + 0.5};
    return mcv_calibration_set_perspective(y->path, focal, centre, camera, y->error);
}

mcv_result mcv_calibration_read_yaml(const char *path, const char *text, mcv_calibration *camera,
                                     mcv_error *error) {
    const yaml y = {path, text, error};
    mcv_camera_model *m = &camera->model;
    double size[2] = {0, 0};
    bool is_there;
    char model[64];
    if (!has(&y, "image_width") || !has(&y, "image_height"))
        return mcv_fail(error, MCV_BAD_INPUT,
                        "%s: has no image_width and image_height: must be a camera of OpenCV (as "
                        "YAML), ROS, HALCON or COLMAP, or our JSON",
                        path);
    MCV_TRY(need(&y, "image_width", size, 1));
    MCV_TRY(need(&y, "image_height", size + 1, 1));
    MCV_TRY(mcv_calibration_set_size(path, size, camera, error));
    MCV_TRY(take_pose(&y, camera));
    MCV_TRY(take(&y, "pixel_size", m->pixel, 2, &is_there));
    MCV_TRY(take(&y, "working_distance", &m->focused_depth, 1, &is_there));
    MCV_TRY(take(&y, "f_number", &m->f_number, 1, &is_there));
    get_word(&y, "camera_name", camera->name, sizeof camera->name);
    get_word(&y, "model", model, sizeof model);
    return strcmp(model, "telecentric") == 0 ? take_telecentric(&y, camera)
                                             : take_perspective(&y, camera);
}
