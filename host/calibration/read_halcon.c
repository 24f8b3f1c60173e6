/* SPDX-License-Identifier: Apache-2.0 */
/* Camera parameters of HALCON: HDevelop code with the tuple or the operator, and the parameter
 * files
 * (.dat) of versions up to 12. */
#include "calibration/calibration.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MOST = 16 };

/* Numbers with commas between them. *text is what follows; -1 if that is part of a formula. */
static int take_numbers(const char **text, double numbers[MOST]) {
    int count = 0;
    for (char *end; count < MOST; *text = end + strspn(end, " ,\t")) {
        numbers[count] = strtod(*text, &end);
        if (end == *text) break;
        ++count;
        if (!strchr(" ,\t])", *end)) return -1;
    }
    return count;
}

/* The numbers after the name of a kind of camera: of the tuple or of the operator. *rest is what
 * follows them. 0: there are none. */
static int find_parameters(const char *text, const char *kind, double numbers[MOST],
                           const char **rest) {
    const size_t length = strlen(kind);
    for (const char *at = strstr(text, kind); at; at = strstr(at + length, kind)) {
        *rest = at + length;
        if (**rest != '\'' && **rest != ' ' && **rest != '(') continue;
        *rest += strspn(*rest, "', (");
        const int count = take_numbers(rest, numbers);
        if (count != 0) return count;
    }
    return 0;
}

static mcv_result read_pose(const char *path, const char *text, mcv_calibration *camera,
                            mcv_error *error) {
    static const char *const words[] = {"'Rp+T'", "'gba'", "'point'"};
    const char *pose = strstr(text, "create_pose");
    double numbers[MOST];
    if (!pose) return MCV_OK;
    if (strstr(pose + 1, "create_pose"))
        return mcv_fail(error, MCV_BAD_INPUT, "%s: has several poses: leave one of them", path);
    pose += strcspn(pose, "(");
    bool right = *pose == '(';
    pose += right;
    right = right && take_numbers(&pose, numbers) == 6;
    for (int i = 0; right && i < 3; ++i) {
        right = strncmp(pose, words[i], strlen(words[i])) == 0;
        pose += right ? strlen(words[i]) : 0;
        pose += strspn(pose, " ,\t");
    }
    if (!right)
        return mcv_fail(error, MCV_BAD_INPUT,
                        "%s: create_pose: must have six numbers, 'Rp+T', 'gba' and 'point'", path);
    memcpy(camera->model.translation, numbers, sizeof camera->model.translation);
    mcv_rotation_of_gba(numbers + 3, camera->model.rotation);
    camera->posed = true;
    return MCV_OK;
}

/* A kind of camera: its name, how many numbers of distortion follow the first one, and whether
 * ImagePlaneDist, Tilt and Rot follow these. */
typedef struct camera_kind {
    const char *name;
    size_t distortion;
    bool tilted, telecentric;
} camera_kind;

/* Kappa is of lengths on the film: a film distance of 1 m leaves it as it is. Where the film is
 * tilted, the distance is ImagePlaneDist. */
static mcv_result set_lens(const char *path, const double *n, const camera_kind *kind,
                           mcv_camera_model *m, mcv_error *error) {
    const double *tilt = n + 1 + kind->distortion;
    MCV_TRY(mcv_calibration_check_numbers(path, n + 1, kind->distortion + (kind->tilted ? 3 : 0),
                                          error));
    for (size_t i = 0; i < kind->distortion && kind->distortion > 1; ++i)
        if (n[1 + i] != 0)
            return mcv_fail(error, MCV_BAD_INPUT,
                            "%s: has HALCON's polynomial distortion, of %g: sensors have its "
                            "division model alone",
                            path, n[1 + i]);
    m->lens = mcv_lens_map_none();
    m->film_distance = kind->tilted ? tilt[0] : kind->telecentric ? 1 : n[0];
    if (!(m->film_distance > 0))
        return mcv_fail(error, MCV_BAD_INPUT, "%s: %s must be above 0", path,
                        kind->tilted ? "ImagePlaneDist" : "Focus");
    if (kind->tilted && !kind->telecentric && !(fabs(tilt[0] / n[0] - 1) < 1e-9))
        return mcv_fail(error, MCV_BAD_INPUT,
                        "%s: ImagePlaneDist %g m is not Focus %g m: the lens of a sensor has its "
                        "pupils in one place",
                        path, tilt[0], n[0]);
    if (kind->distortion == 1) m->lens.kappa = n[1] * m->film_distance * m->film_distance;
    if (m->lens.kappa != 0) m->lens.model = MCV_DIVISION;
    if (kind->tilted) mcv_lens_map_tilt(&m->lens, tilt[1] * M_PI / 180, tilt[2] * M_PI / 180);
    return MCV_OK;
}

/* Lens, distortion, tilt, Sx, Sy, Cx, Cy, width, height. */
static mcv_result set(const char *path, const double *n, const camera_kind *kind,
                      mcv_calibration *camera, mcv_error *error) {
    mcv_camera_model *m = &camera->model;
    const double *rest = n + 1 + kind->distortion + (kind->tilted ? 3 : 0);
    const double centre[2] = {rest[2] + 0.5, rest[3] + 0.5};
    double scale[2];
    MCV_TRY(set_lens(path, n, kind, m, error));
    MCV_TRY(mcv_calibration_set_size(path, rest + 4, camera, error));
    for (int i = 0; i < 2; ++i) {
        m->pixel[i] = rest[i];
        scale[i] = kind->telecentric ? rest[i] / n[0] : n[0] / rest[i];
    }
    return kind->telecentric ? mcv_calibration_set_telecentric(path, scale, centre, camera, error)
                             : mcv_calibration_set_perspective(path, scale, centre, camera, error);
}

/* --- parameter files --- */

/* "Focus:foc: 0.008;" at the begin of a line. */
static bool get_line(const char *text, const char *key, double *number) {
    const char *at = strstr(text, key);
    char *end;
    while (at && at != text && at[-1] != '\n') at = strstr(at + 1, key);
    if (!at) return false;
    at += strlen(key);
    *number = strtod(at, &end);
    return end != at && *end == ';';
}

static mcv_result read_file(const char *path, const char *text, mcv_calibration *camera,
                            mcv_error *error) {
    static const char *const keys[] = {
        "Focus:foc:", "Kappa:kappa:", "Sx:sx:",           "Sy:sy:",
        "Cx:cx:",     "Cy:cy:",       "ImageWidth:imgw:", "ImageHeight:imgh:"};
    double n[8] = {0};
    const char *first = strstr(text, "ParGroup:");
    if (first && strstr(first + 1, "ParGroup: Camera"))
        return mcv_fail(error, MCV_BAD_INPUT, "%s: has several cameras: leave one of them", path);
    for (int i = 0; i < 8; ++i)
        if (!get_line(text, keys[i], n + i))
            return mcv_fail(error, MCV_BAD_INPUT,
                            "%s: has no line as in `%s 0.1;`: must be an area scan camera of the "
                            "division model",
                            path, keys[i]);
    if (n[0] == 0)
        return mcv_fail(error, MCV_BAD_INPUT,
                        "%s: a telecentric lens of HALCON up to 12 has no magnification: write the "
                        "camera by HALCON 13 or later",
                        path);
    return set(path, n, &(camera_kind){"", 1, false, false}, camera, error);
}

/* --- HDevelop code --- */

static const camera_kind kinds[] = {
    {"area_scan_division", 1, false, false},
    {"area_scan_polynomial", 5, false, false},
    {"area_scan_telecentric_division", 1, false, true},
    {"area_scan_telecentric_polynomial", 5, false, true},
    {"area_scan_tilt_division", 1, true, false},
    {"area_scan_tilt_polynomial", 5, true, false},
    {"area_scan_tilt_object_side_telecentric_division", 1, true, true},
    {"area_scan_tilt_object_side_telecentric_polynomial", 5, true, true}};
enum { KINDS = sizeof kinds / sizeof kinds[0] };

/* Is the camera of `numbers` the only one? A camera may stand there as tuple and as operator. */
static bool is_only(const char *text, int kind, const double *numbers, int count) {
    double others[MOST];
    for (int i = 0; i < KINDS; ++i) {
        const char *rest = text;
        for (int found; (found = find_parameters(rest, kinds[i].name, others, &rest)) != 0;)
            if (i != kind || found != count ||
                memcmp(others, numbers, (size_t)count * sizeof *others) != 0)
                return false;
    }
    return true;
}

static mcv_result read_code(const char *path, const char *text, mcv_calibration *camera,
                            mcv_error *error) {
    double numbers[MOST] = {0};
    const char *rest;
    MCV_TRY(read_pose(path, text, camera, error));
    for (int i = 0; i < KINDS; ++i) {
        const int count = find_parameters(text, kinds[i].name, numbers, &rest),
                  needed = 7 + (int)kinds[i].distortion + (kinds[i].tilted ? 3 : 0);
        if (count == 0) continue;
        if (count != needed)
            return mcv_fail(error, MCV_BAD_INPUT, "%s: %s: must have %d numbers", path,
                            kinds[i].name, needed);
        if (!is_only(text, i, numbers, count))
            return mcv_fail(error, MCV_BAD_INPUT, "%s: has several cameras: leave one of them",
                            path);
        return set(path, numbers, kinds + i, camera, error);
    }
    if (strstr(text, "ParGroup:")) return read_file(path, text, camera, error);
    return mcv_fail(error, MCV_BAD_INPUT,
                    "%s: must be an area scan camera, division or polynomial, telecentric or not",
                    path);
}

/* HDevelop's comments are lines that begin with a star. */
static void clear_comments(char *text) {
    for (char *line = text; line; line = strchr(line, '\n')) {
        line += strspn(line, " \t\r\n");
        if (*line != '*') continue;
        for (char *c = line; *c && *c != '\n'; ++c) *c = ' ';
    }
}

mcv_result mcv_calibration_read_halcon(const char *path, const char *text, mcv_calibration *camera,
                                       mcv_error *error) {
    char *code = strdup(text);
    if (!code) return mcv_fail(error, MCV_FAILED, "%s: no memory for the camera", path);
    clear_comments(code);
    const mcv_result result = read_code(path, code, camera, error);
    free(code);
    return result;
}
