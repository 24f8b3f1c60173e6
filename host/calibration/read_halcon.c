/* SPDX-License-Identifier: Apache-2.0 */
/* Camera parameters of HALCON: HDevelop code with the tuple or the operator, and the parameter
 * files
 * (.dat) of versions up to 12. */
#include "calibration/calibration.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MOST = 16 };

/* Numbers with commas between them, up to the bracket. */
static int get_numbers(const char *text, double numbers[MOST]) {
    int count = 0;
    for (char *end; count < MOST; text = end + strspn(end, " ,\t")) {
        numbers[count] = strtod(text, &end);
        if (end == text) return count;
        ++count;
    }
    return count;
}

/* The numbers after the name of a kind of camera: of the tuple or of the operator. */
static int find_parameters(const char *text, const char *kind, double numbers[MOST]) {
    const size_t length = strlen(kind);
    for (const char *at = strstr(text, kind); at; at = strstr(at + length, kind)) {
        const char *rest = at + length;
        if (*rest != '\'' && *rest != ' ' && *rest != '(') continue;
        const int count = get_numbers(rest + strspn(rest, "', ("), numbers);
        if (count > 0) return count;
    }
    return 0;
}

static mcv_result read_pose(const char *path, const char *text, mcv_calibration *camera,
                            mcv_error *error) {
    const char *pose = strstr(text, "create_pose");
    double numbers[MOST];
    if (!pose) return MCV_OK;
    pose += strcspn(pose, "(");
    if (*pose != '(' || get_numbers(pose + 1, numbers) != 6 || !strstr(pose, "'Rp+T'") ||
        !strstr(pose, "'gba'") || !strstr(pose, "'point'"))
        return mcv_fail(error, MCV_BAD_INPUT,
                        "%s: create_pose: must have six numbers, 'Rp+T', 'gba' and 'point'", path);
    memcpy(camera->model.translation, numbers, sizeof camera->model.translation);
    mcv_rotation_of_gba(numbers + 3, camera->model.rotation);
    camera->posed = true;
    return MCV_OK;
}

/* Lens, distortion of `distortion` numbers, Sx, Sy, Cx, Cy, width, height. */
static mcv_result set(const char *path, const double *n, size_t distortion, bool telecentric,
                      mcv_calibration *camera, mcv_error *error) {
    mcv_camera_model *m = &camera->model;
    const double *rest = n + 1 + distortion;
    const double centre[2] = {rest[2] + 0.5, rest[3] + 0.5};
    double scale[2];
    MCV_TRY(mcv_calibration_refuse_distortion(path, n + 1, distortion, error));
    for (int i = 0; i < 2; ++i) {
        m->size[i] = rest[4 + i] >= 1 && rest[4 + i] < 1e9 ? (uint32_t)rest[4 + i] : 0;
        m->pixel[i] = rest[i];
        scale[i] = telecentric ? rest[i] / n[0] : n[0] / rest[i];
    }
    return telecentric ? mcv_calibration_set_telecentric(path, scale, centre, camera, error)
                       : mcv_calibration_set_perspective(path, scale, centre, camera, error);
}

/* "Focus:foc: 0.008;" */
static bool get_line(const char *text, const char *key, double *number) {
    const char *at = strstr(text, key);
    char *end;
    if (!at) return false;
    at += strlen(key);
    *number = strtod(at, &end);
    return end != at;
}

static mcv_result read_file(const char *path, const char *text, mcv_calibration *camera,
                            mcv_error *error) {
    static const char *const keys[] = {
        "Focus:foc:", "Kappa:kappa:", "Sx:sx:",           "Sy:sy:",
        "Cx:cx:",     "Cy:cy:",       "ImageWidth:imgw:", "ImageHeight:imgh:"};
    double n[8] = {0};
    for (int i = 0; i < 8; ++i)
        if (!get_line(text, keys[i], n + i) && i != 1)
            return mcv_fail(error, MCV_BAD_INPUT, "%s: has no line %s", path, keys[i]);
    if (n[0] == 0)
        return mcv_fail(error, MCV_BAD_INPUT,
                        "%s: a telecentric lens of HALCON up to 12 has no magnification: write the "
                        "camera by HALCON 13 or later",
                        path);
    return set(path, n, 1, false, camera, error);
}

mcv_result mcv_calibration_read_halcon(const char *path, const char *text, mcv_calibration *camera,
                                       mcv_error *error) {
    static const struct {
        const char *kind;
        int distortion;
        bool telecentric;
    } kinds[] = {{"area_scan_division", 1, false},
                 {"area_scan_polynomial", 5, false},
                 {"area_scan_telecentric_division", 1, true},
                 {"area_scan_telecentric_polynomial", 5, true}};
    double numbers[MOST];
    MCV_TRY(read_pose(path, text, camera, error));
    for (size_t i = 0; i < sizeof kinds / sizeof kinds[0]; ++i) {
        const int count = find_parameters(text, kinds[i].kind, numbers);
        if (count == 0) continue;
        if (count == 7 + kinds[i].distortion)
            return set(path, numbers, (size_t)kinds[i].distortion, kinds[i].telecentric, camera,
                       error);
        return mcv_fail(error, MCV_BAD_INPUT, "%s: %s: must have %d numbers", path, kinds[i].kind,
                        7 + kinds[i].distortion);
    }
    if (strstr(text, "ParGroup:")) return read_file(path, text, camera, error);
    return mcv_fail(error, MCV_BAD_INPUT,
                    "%s: must be an area scan camera, division or polynomial, telecentric or not",
                    path);
}
