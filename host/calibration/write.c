/* SPDX-License-Identifier: Apache-2.0 */
/* Camera models as files of other programs. Every number is read back bit for bit. */
#include "calibration/calibration.h"

#include "core/basics.h"

#include <jansson.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

const char *const mcv_colmap_files[MCV_CALIBRATION_FILES] = {"cameras.txt", "images.txt",
                                                             "points3D.txt"};

/* Pixels of programs whose first pixel has its centre at 0. */
static const double half = 0.5;

void mcv_calibration_centre(const mcv_camera_model *model, double centre[2]) {
    for (int i = 0; i < 2; ++i)
        centre[i] = model->telecentric
                        ? model->affine[4 * i + 3] - model->translation[i] / model->object_pixel[i]
                        : model->k[3 * i + 2];
}

/* With a point or an exponent, for readers that tell whole numbers apart. + 0: no -0. */
static void put_numbers(FILE *out, const double *numbers, size_t count, const char *between) {
    for (size_t i = 0; i < count; ++i) {
        char text[32];
        snprintf(text, sizeof text, "%.17g", numbers[i] + 0.0);
        fprintf(out, "%s%s%s", i ? between : "", text, strpbrk(text, ".e") ? "" : ".0");
    }
}

/* A name as one word: of letters, digits and some signs. */
static void put_name(FILE *out, const char *name) {
    for (; *name; ++name) {
        const unsigned char c = (unsigned char)*name;
        const bool plain = (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') ||
                           (c >= 'A' && c <= 'Z') || c == '-' || c == '_' || c == '.' || c >= 0x80;
        fputc(plain ? c : '_', out);
    }
}

/* --- OpenCV and ROS: YAML --- */

/* OpenCV has its own mark of a matrix, which other YAML has not. */
static void put_matrix(FILE *out, bool opencv, const char *key, size_t rows, size_t columns,
                       const double *numbers) {
    fprintf(out, "%s:%s\n  rows: %zu\n  cols: %zu\n%s  data: [ ", key,
            opencv ? " !!opencv-matrix" : "", rows, columns, opencv ? "  dt: d\n" : "");
    put_numbers(out, numbers, rows * columns, ", ");
    fputs(" ]\n", out);
}

/* Keys of ours, which other readers pass over. */
static void put_pose(FILE *out, bool opencv, const mcv_camera_model *m) {
    double vector[3];
    mcv_rotation_to_vector(m->rotation, vector);
    fputs("# from the world to the camera (x right, y down, z forward): R X + t, in metres\n", out);
    put_matrix(out, opencv, "rotation", 3, 3, m->rotation);
    put_matrix(out, opencv, "rvec", 3, 1, vector);
    put_matrix(out, opencv, "tvec", 3, 1, m->translation);
    fputs("# of a pixel on the sensor, in metres\n", out);
    put_matrix(out, opencv, "pixel_size", 1, 2, m->pixel);
}

static void put_k(FILE *out, bool opencv, const mcv_camera_model *m) {
    double coefficients[MCV_OPENCV_COEFFICIENTS];
    const int count = mcv_lens_to_opencv(&m->lens, coefficients);
    const double k[9] = {m->k[0], 0, m->k[2] - half, 0, m->k[4], m->k[5] - half, 0, 0, 1};
    put_matrix(out, opencv, "camera_matrix", 3, 3, k);
    if (!opencv)
        fprintf(out, "distortion_model: %s\n", count > 5 ? "rational_polynomial" : "plumb_bob");
    put_matrix(out, opencv, "distortion_coefficients", 1, (size_t)count, coefficients);
}

static void put_affine(FILE *out, const mcv_camera_model *m) {
    double p[12] = {0};
    memcpy(p, m->affine, sizeof m->affine);
    p[3] -= half;
    p[7] -= half;
    p[11] = 1;
    fputs(
        "# (column, row, 1) = projection_matrix (X, Y, Z, 1), X in metres: OpenCV has no model of "
        "its own for this\n",
        out);
    put_matrix(out, true, "projection_matrix", 3, 4, p);
    fputs("# of a pixel in the object, in metres\n", out);
    put_matrix(out, true, "object_pixel_size", 1, 2, m->object_pixel);
}

static void put_head(FILE *out, const mcv_camera_model *m, const char *name) {
    fputs("# pixels: the centre of the first one is (0, 0)\n", out);
    fprintf(out, "image_width: %u\nimage_height: %u\ncamera_name: ", m->size[0], m->size[1]);
    put_name(out, name);
    fputc('\n', out);
}

static void put_opencv(FILE *out, const mcv_camera_model *m, const char *name) {
    fputs("%YAML:1.0\n---\n", out);
    put_head(out, m, name);
    fprintf(out, "model: %s\n", m->telecentric ? "telecentric" : "perspective");
    if (m->telecentric)
        put_affine(out, m);
    else
        put_k(out, true, m);
    put_pose(out, true, m);
    if (isfinite(m->focused_depth)) fprintf(out, "working_distance: %.17g\n", m->focused_depth);
    if (isfinite(m->f_number)) fprintf(out, "f_number: %.17g\n", m->f_number);
}

static void put_ros(FILE *out, const mcv_camera_model *m, const char *name) {
    static const double identity[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    const double p[12] = {m->k[0], 0, m->k[2] - half, 0, 0, m->k[4], m->k[5] - half, 0, 0, 0, 1, 0};
    put_head(out, m, name);
    put_k(out, false, m);
    put_matrix(out, false, "rectification_matrix", 3, 3, identity);
    put_matrix(out, false, "projection_matrix", 3, 4, p);
    put_pose(out, false, m);
}

/* --- HALCON --- */

/* As the arguments of the operator and as the tuple that it makes. */
static void put_halcon_numbers(FILE *out, const mcv_camera_model *m) {
    double centre[2], lens[5];
    size_t count = 2;
    mcv_calibration_centre(m, centre);
    lens[0] = m->telecentric ? m->pixel[0] / m->object_pixel[0] : m->k[0] * m->pixel[0];
    /* A camera without distortion need not have a film's distance. */
    lens[1] =
        m->lens.model == MCV_DIVISION ? m->lens.kappa / (m->film_distance * m->film_distance) : 0;
    if (m->lens.tilted) {
        lens[2] = m->film_distance;
        mcv_lens_to_halcon(&m->lens, &lens[3], &lens[4]);
        count = 5;
    }
    const double rest[4] = {m->pixel[0], m->pixel[1], centre[0] - half, centre[1] - half};
    put_numbers(out, lens, count, ", ");
    fputs(", ", out);
    put_numbers(out, rest, 4, ", ");
    fprintf(out, ", %u, %u", m->size[0], m->size[1]);
}

static void put_halcon(FILE *out, const mcv_camera_model *m, const char *name) {
    static const char *const types[2][2] = {
        {"area_scan_division", "area_scan_telecentric_division"},
        {"area_scan_tilt_division", "area_scan_tilt_object_side_telecentric_division"}};
    const char *type = types[m->lens.tilted][m->telecentric];
    double angles[3];
    char *numbers = NULL;
    size_t size;
    FILE *list = open_memstream(&numbers, &size);
    mcv_rotation_to_gba(m->rotation, angles);
    if (list) {
        put_halcon_numbers(list, m);
        (void)mcv_text_close(list, &numbers);
    }
    if (!numbers) return;
    fputs("* HALCON: parameters of the camera ", out);
    put_name(out, name);
    fprintf(out,
            ".\n* Lengths are in metres, angles in degrees. The centre of the first pixel is (0, "
            "0).\n* %s, Kappa, %sSx, Sy, Cx, Cy, ImageWidth, ImageHeight\nCamParam := ['%s', %s]\n"
            "gen_cam_par_%s (%s, CamParam)\n",
            m->telecentric ? "Magnification" : "Focus",
            m->lens.tilted ? "ImagePlaneDist, Tilt, Rot, " : "", type, numbers, type, numbers);
    fputs("* The world in the camera's coordinates.\ncreate_pose (", out);
    put_numbers(out, m->translation, 3, ", ");
    fputs(", ", out);
    put_numbers(out, angles, 3, ", ");
    fputs(", 'Rp+T', 'gba', 'point', WorldInCamera)\n", out);
    free(numbers);
}

/* --- COLMAP --- */

static void put_colmap(FILE *out, const mcv_camera_model *m, const char *name, int file) {
    double q[4];
    mcv_rotation_to_quaternion(m->rotation, q);
    if (file == 0) {
        double c[MCV_OPENCV_COEFFICIENTS];
        const bool distorts = m->lens.model != 0,
                   full = mcv_lens_to_opencv(&m->lens, c) > 5 || c[4] != 0;
        /* COLMAP's order is OpenCV's. */
        const double numbers[12] = {m->k[0], m->k[4], m->k[2], m->k[5], c[0], c[1],
                                    c[2],    c[3],    c[4],    c[5],    c[6], c[7]};
        fprintf(
            out,
            "# CAMERA_ID, MODEL, WIDTH, HEIGHT, FX, FY, CX, CY%s\n# The first pixel's corner is "
            "(0, 0).\n1 %s %u %u ",
            !distorts ? ""
            : full    ? ", K1, K2, P1, P2, K3, K4, K5, K6"
                      : ", K1, K2, P1, P2",
            !distorts ? "PINHOLE"
            : full    ? "FULL_OPENCV"
                      : "OPENCV",
            m->size[0], m->size[1]);
        put_numbers(out, numbers, !distorts ? 4 : full ? 12 : 8, " ");
        fputc('\n', out);
    } else if (file == 1) {
        fputs("# IMAGE_ID, QW, QX, QY, QZ, TX, TY, TZ, CAMERA_ID, NAME\n# From the world to the "
              "camera, in metres. The second line of an image is of its points.\n1 ",
              out);
        put_numbers(out, q, 4, " ");
        fputc(' ', out);
        put_numbers(out, m->translation, 3, " ");
        fputs(" 1 ", out);
        put_name(out, name);
        fputs("\n\n", out);
    } else {
        fputs("# POINT3D_ID, X, Y, Z, R, G, B, ERROR, TRACK\n", out);
    }
}

/* --- all --- */

/* The same as in headers, on several lines. */
static char *make_json(const mcv_camera_model *model) {
    char *line = mcv_camera_model_write(model);
    json_t *object = line ? json_loads(line, 0, NULL) : NULL;
    free(line);
    char *dumped = json_dumps(object, JSON_INDENT(2) | JSON_ENSURE_ASCII | JSON_REAL_PRECISION(17));
    char *text = NULL;
    json_decref(object);
    if (dumped && asprintf(&text, "%s\n", dumped) < 0) text = NULL;
    free(dumped);
    return text;
}

static char *make(const mcv_camera_model *model, const char *name, mcv_calibration_format format,
                  int file) {
    char *text = NULL;
    size_t size;
    if (format == MCV_CALIBRATION_JSON) return make_json(model);
    FILE *out = open_memstream(&text, &size);
    if (!out) return NULL;
    if (format == MCV_CALIBRATION_OPENCV) put_opencv(out, model, name);
    if (format == MCV_CALIBRATION_ROS) put_ros(out, model, name);
    if (format == MCV_CALIBRATION_HALCON) put_halcon(out, model, name);
    if (format == MCV_CALIBRATION_COLMAP) put_colmap(out, model, name, file);
    (void)mcv_text_close(out, &text);
    return text;
}

mcv_result mcv_calibration_write(const mcv_camera_model *model, const char *name,
                                 mcv_calibration_format format, mcv_calibration_texts *texts,
                                 mcv_error *error) {
    static const char *const programs[] = {
#define MCV_X(NAME, word, program) program,
        MCV_CALIBRATIONS(MCV_X)
#undef MCV_X
    };
    const int count = format == MCV_CALIBRATION_COLMAP ? MCV_CALIBRATION_FILES : 1;
    *texts = (mcv_calibration_texts){{NULL}};
    if (format != MCV_CALIBRATION_JSON && model->macro[0] * model->macro[1] > 1)
        return mcv_fail(error, MCV_BAD_INPUT,
                        "sensor %s is a light field camera: %s has no macro pixels: take --format "
                        "json",
                        name, programs[format]);
    if (model->line && format != MCV_CALIBRATION_JSON)
        return mcv_fail(error, MCV_BAD_INPUT,
                        "sensor %s has a \"line\" shutter: %s has no rows that are times: take "
                        "--format json",
                        name, programs[format]);
    if (model->telecentric && (format == MCV_CALIBRATION_ROS || format == MCV_CALIBRATION_COLMAP))
        return mcv_fail(error, MCV_BAD_INPUT,
                        "sensor %s is telecentric: %s has no such model: take --format opencv, "
                        "halcon or json",
                        name, programs[format]);
    MCV_TRY(mcv_calibration_check_lens(model, name, format, programs[format], error));
    for (int i = 0; i < count; ++i) {
        texts->items[i] = make(model, name, format, i);
        if (texts->items[i]) continue;
        mcv_calibration_texts_free(texts);
        return mcv_fail(error, MCV_FAILED, "no memory for the camera model");
    }
    return MCV_OK;
}

void mcv_calibration_texts_free(mcv_calibration_texts *texts) {
    for (int i = 0; i < MCV_CALIBRATION_FILES; ++i) free(texts->items[i]);
    *texts = (mcv_calibration_texts){{NULL}};
}
