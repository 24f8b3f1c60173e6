/* SPDX-License-Identifier: Apache-2.0 */
/* Camera models in the formats of other programs: each gives the camera back, and a point lies
 * where the program that reads the format puts it. No OpenCL device is needed. */
#include "api.h"

#include "program.h"

#include <math.h>

/* Two cameras that look askew at the world: not square pixels, a region of interest, binning, and
 * an axis beside the middle. */
#define READOUT \
    "\"resolution\": [400, 300], \"pixelSize\": [\"5um\", \"4um\"], " \
    "\"regionOfInterest\": [60, 40, 240, 160], \"binning\": [2, 4], " \
    "\"principalPoint\": [173.3, 141.9]"
static const char rig_text[] =
    "{\"asset\": {\"version\": \"2.0\"}, \"scene\": 0, \"scenes\": [{\"nodes\": [0, 1]}],"
    " \"extensionsUsed\": [\"MCVISI_sensors\"],"
    " \"extensions\": {\"MCVISI_sensors\": {\"sensors\": ["
    "{\"name\": \"cam 1\", \"type\": \"pinhole\", \"imageDistance\": \"16mm\", " READOUT "},"
    "{\"name\": \"tele\", \"type\": \"telecentric\", \"magnification\": 0.3, \"workingDistance\": "
    "\"120mm\", \"fNumber\": 8, " READOUT "}]}},"
    " \"nodes\": ["
    "{\"name\": \"a\", \"translation\": [0.01, 0.2, -0.13], \"rotation\": [0.3, -0.5, 0.1, "
    "0.8062257748298549], \"extensions\": {\"MCVISI_sensors\": {\"sensor\": 0}}},"
    "{\"name\": \"b\", \"translation\": [0.05, -0.02, 0.3], \"rotation\": [-0.7, 0.1, 0.5, 0.5], "
    "\"extensions\": {\"MCVISI_sensors\": {\"sensor\": 1}}}]}";

static const char empty[] = "{\"asset\": {\"version\": \"2.0\"}, \"scene\": 0, \"scenes\": []}";

static const char *const formats[] = {"json", "opencv", "ros", "halcon", "colmap"};
enum { JSON, OPENCV, ROS, HALCON, COLMAP, FORMATS };

/* The sensor's model in a format, which is also in the file or folder "model1" …; freed by the
 * caller. */
static char *export_model(const mcv_rig *rig, const char *sensor, int format) {
    char options[128], *text = NULL;
    snprintf(options, sizeof options,
             "{\"sensor\": \"%s\", \"format\": \"%s\", \"output\": \"model%d\"}", sensor,
             formats[format], format);
    WELL(mcv_rig_camera_model(rig, options, &text, &error));
    char *copy = strdup(text);
    mcv_text_free(text);
    return copy;
}

static json_t *model_of(const mcv_rig *rig, const char *sensor) {
    char *text = export_model(rig, sensor, JSON);
    json_t *model = json_loads(text, 0, NULL);
    assert_non_null(model);
    free(text);
    return model;
}

/* Equal but for rounding: some ten operations on numbers of this size. */
static void expect_equal(const json_t *a, const json_t *b, const char *key, double scale) {
    const json_t *x = json_object_get(a, key), *y = json_object_get(b, key);
    if (!x || json_array_size(x) != json_array_size(y)) fail_msg("%s is not there twice", key);
    for (size_t i = 0; i < json_array_size(x); ++i) {
        const json_t *row = json_array_get(x, i), *other = json_array_get(y, i);
        const size_t count = json_is_array(row) ? json_array_size(row) : 1;
        for (size_t j = 0; j < count; ++j) {
            const double p = json_number_value(json_is_array(row) ? json_array_get(row, j) : row),
                         q = json_number_value(json_is_array(row) ? json_array_get(other, j)
                                                                  : other);
            if (!(fabs(p - q) <= 1e-12 * fmax(scale, fabs(p))))
                fail_msg("%s %zu, %zu: %.17g comes back as %.17g", key, i, j, p, q);
        }
    }
}

static void check_round_trip(const mcv_rig *rig, const char *sensor, int format) {
    char file[16], *report = NULL;
    mcv_rig *made = parse_rig(empty);
    const bool telecentric = strcmp(sensor, "tele") == 0;
    free(export_model(rig, sensor, format));
    snprintf(file, sizeof file, "model%d", format);
    WELL(mcv_rig_add_camera(made, file, "{\"sensor\": \"again\"}", &report, &error));
    assert_null(strstr(report, "no pose"));
    mcv_text_free(report);
    json_t *a = model_of(rig, sensor), *b = model_of(made, "again");
    assert_string_equal(json_string_value(json_object_get(a, "model")),
                        json_string_value(json_object_get(b, "model")));
    expect_equal(a, b, "size", 1);
    expect_equal(a, b, telecentric ? "A" : "K", 1);
    expect_equal(a, b, "R", 1);
    expect_equal(a, b, "t", 1);
    if (format != COLMAP) expect_equal(a, b, "pixelSize", 0); /* COLMAP has none */
    json_decref(a);
    json_decref(b);
    mcv_rig_free(made);
}

static void test_every_format_gives_the_camera_back(void **state) {
    mcv_rig *rig = parse_rig(rig_text);
    char *text = NULL;
    (void)state;
    for (int format = 0; format < FORMATS; ++format) check_round_trip(rig, "cam 1", format);
    for (int format = 0; format < FORMATS; ++format)
        if (format != ROS && format != COLMAP) check_round_trip(rig, "tele", format);
    FAILS(MCV_BAD_INPUT, "ROS has no such model",
          mcv_rig_camera_model(rig, "{\"sensor\": 1, \"format\": \"ros\"}", &text, &error));
    FAILS(MCV_USAGE, "give their folder",
          mcv_rig_camera_model(rig, "{\"sensor\": 0, \"format\": \"colmap\"}", &text, &error));
    FAILS(MCV_USAGE, "choose one by --sensor", mcv_rig_camera_model(rig, NULL, &text, &error));
    assert_null(text);
    mcv_rig_free(rig);
}

/* --- projection by each program's own rules --- */

/* The numbers after a word, with anything between them. */
static void numbers_after(const char *text, const char *word, double *numbers, int count) {
    const char *found = strstr(text, word);
    assert_non_null(found);
    size_t at = (size_t)(found - text) + strlen(word);
    for (int i = 0; i < count;) {
        char *end;
        assert_true(text[at] != '\0');
        numbers[i] = strtod(text + at, &end);
        i += end != text + at; /* else it is no number */
        at = end != text + at ? (size_t)(end - text) : at + 1;
    }
}

static void transform(const double r[9], const double t[3], const double x[3], double p[3]) {
    for (int i = 0; i < 3; ++i)
        p[i] = r[3 * i] * x[0] + r[3 * i + 1] * x[1] + r[3 * i + 2] * x[2] + t[i];
}

static void matrix_of(const json_t *model, const char *key, double *numbers) {
    size_t i, j;
    const json_t *row, *number;
    json_array_foreach(json_object_get(model, key), i, row) {
        if (json_is_number(row)) *numbers++ = json_number_value(row);
        json_array_foreach((json_t *)row, j, number) { *numbers++ = json_number_value(number); }
    }
}

/* OpenCV and ROS: (u, v, w) = K (R X + t), and the centre of the first pixel is (0, 0). */
static void project_yaml(const char *text, const double x[3], double pixel[2]) {
    double k[11] = {0}, r[11] = {0}, t[5] = {0}, p[3]; /* rows and columns stand before */
    numbers_after(text, "camera_matrix:", k, 11);
    numbers_after(text, "rotation:", r, 11);
    numbers_after(text, "tvec:", t, 5);
    transform(r + 2, t + 2, x, p);
    for (int i = 0; i < 2; ++i)
        pixel[i] = (k[2 + 3 * i] * p[0] + k[3 + 3 * i] * p[1] + k[4 + 3 * i] * p[2]) / p[2] + 0.5;
}

static void project_affine(const char *text, const double x[3], double pixel[2]) {
    double a[14] = {0};
    numbers_after(text, "projection_matrix: !!opencv-matrix", a, 14);
    for (int i = 0; i < 2; ++i) {
        const double *row = a + 2 + (size_t)4 * i;
        pixel[i] = row[0] * x[0] + row[1] * x[1] + row[2] * x[2] + row[3] + 0.5;
    }
}

static void multiply(const double a[9], const double b[9], double c[9]) {
    for (int i = 0; i < 9; ++i) {
        c[i] = 0;
        for (int k = 0; k < 3; ++k) c[i] += a[i / 3 * 3 + k] * b[3 * k + i % 3];
    }
}

/* HALCON: R = R_x R_y R_z, p = R X + T, u = Focus p_x / p_z (telecentric: Magnification p_x),
 * column = u / Sx + Cx; the centre of the first pixel is (0, 0). */
static void project_halcon(const char *text, bool telecentric, const double x[3], double pixel[2]) {
    double n[8] = {0}, pose[6] = {0}, s[3], c[3], half[9], r[9], p[3];
    numbers_after(text, "division'", n, 8);
    numbers_after(text, "create_pose", pose, 6);
    for (int i = 0; i < 3; ++i) {
        s[i] = sin(pose[3 + i] * M_PI / 180);
        c[i] = cos(pose[3 + i] * M_PI / 180);
    }
    multiply((const double[9]){1, 0, 0, 0, c[0], -s[0], 0, s[0], c[0]},
             (const double[9]){c[1], 0, s[1], 0, 1, 0, -s[1], 0, c[1]}, half);
    multiply(half, (const double[9]){c[2], -s[2], 0, s[2], c[2], 0, 0, 0, 1}, r);
    transform(r, pose, x, p);
    for (int i = 0; i < 2; ++i)
        pixel[i] = n[0] * p[i] / (telecentric ? 1 : p[2]) / n[2 + i] + n[4 + i] + 0.5;
}

/* COLMAP: q X q* + t, column = f_x x/z + c_x; the corner of the first pixel is (0, 0). */
static void project_colmap(const double x[3], double pixel[2]) {
    double n[6] = {0}, pose[7] = {0}, cross[2][3], p[3];
    char *cameras = strdup(read_whole("model4/cameras.txt")),
         *images = strdup(read_whole("model4/images.txt"));
    numbers_after(cameras, "1 PINHOLE", n, 6);
    numbers_after(images, "\n1 ", pose, 7);
    free(cameras);
    free(images);
    const double *v = pose + 1;
    for (int i = 0; i < 3; ++i)
        cross[0][i] =
            v[(i + 1) % 3] * x[(i + 2) % 3] - v[(i + 2) % 3] * x[(i + 1) % 3] + pose[0] * x[i];
    for (int i = 0; i < 3; ++i) {
        cross[1][i] =
            v[(i + 1) % 3] * cross[0][(i + 2) % 3] - v[(i + 2) % 3] * cross[0][(i + 1) % 3];
        p[i] = x[i] + 2 * cross[1][i] + pose[4 + i];
    }
    for (int i = 0; i < 2; ++i) pixel[i] = n[2 + i] * p[i] / p[2] + n[4 + i];
}

/* Points before the camera, which our own model projects; 1e-9 of some hundred pixels is rounding.
 */
static void check_projection(const mcv_rig *rig, const char *sensor, int format) {
    const bool telecentric = strcmp(sensor, "tele") == 0;
    char *text = export_model(rig, sensor, format);
    json_t *model = model_of(rig, sensor);
    double k[9] = {0}, r[9] = {0}, t[3] = {0};
    matrix_of(model, telecentric ? "A" : "K", k);
    matrix_of(model, "R", r);
    matrix_of(model, "t", t);
    for (int n = 0; n < 27; ++n) {
        const double p[3] = {0.02 * (n % 3 - 1) - t[0], 0.03 * (n / 3 % 3 - 1) - t[1],
                             0.2 + 0.1 * (n / 9) - t[2]};
        double x[3], pixel[2] = {0}, own[2];
        for (int i = 0; i < 3; ++i) x[i] = r[i] * p[0] + r[3 + i] * p[1] + r[6 + i] * p[2];
        for (int i = 0; i < 2; ++i) {
            const double *a = k + (size_t)4 * i;
            own[i] = telecentric ? a[0] * x[0] + a[1] * x[1] + a[2] * x[2] + a[3]
                                 : k[4 * i] * (p[i] + t[i]) / (p[2] + t[2]) + k[3 * i + 2];
        }
        if (format == HALCON)
            project_halcon(text, telecentric, x, pixel);
        else if (format == COLMAP)
            project_colmap(x, pixel);
        else if (telecentric)
            project_affine(text, x, pixel);
        else
            project_yaml(text, x, pixel);
        for (int i = 0; i < 2; ++i)
            if (!(fabs(pixel[i] - own[i]) <= 1e-9 * fmax(1, fabs(own[i]))))
                fail_msg("%s, %s: %.12f, not %.12f", formats[format], sensor, pixel[i], own[i]);
    }
    json_decref(model);
    free(text);
}

static void test_points_lie_where_each_program_puts_them(void **state) {
    mcv_rig *rig = parse_rig(rig_text);
    (void)state;
    for (int format = OPENCV; format < FORMATS; ++format) check_projection(rig, "cam 1", format);
    check_projection(rig, "tele", OPENCV);
    check_projection(rig, "tele", HALCON);
    mcv_rig_free(rig);
}

/* --- files of other programs --- */

/* The file's camera comes with what it does not state told. */
static void expect_camera(const char *text, const double k[4], const char *told) {
    mcv_rig *rig = parse_rig(empty);
    char *report = NULL;
    double found[9] = {0};
    write_file("other", text);
    WELL(mcv_rig_add_camera(rig, "other", "{\"sensor\": \"c\", \"pixel_size\": \"4um\"}", &report,
                            &error));
    if (!strstr(report, told)) fail_msg("%s: is not told: %s", told, report);
    json_t *model = model_of(rig, "c");
    matrix_of(model, "K", found);
    const double own[4] = {found[0], found[4], found[2], found[5]};
    for (int i = 0; i < 4; ++i) /* of doubles */
        if (!(fabs(own[i] - k[i]) <= 1e-12 * k[i]))
            fail_msg("%d: %.17g, not %.17g", i, own[i], k[i]);
    json_decref(model);
    mcv_text_free(report);
    mcv_rig_free(rig);
}

/* As cv2.FileStorage, the calibrator of ROS and HALCON 12 write them. */
static void test_files_of_other_programs(void **state) {
    static const double k[4] = {800, 800, 320, 240};
    (void)state;
    expect_camera(
        "%YAML:1.0\n---\nimage_width: 640\nimage_height: 480\ncamera_matrix: "
        "!!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n   data: [ 800., 0., 3.195e+02, "
        "0.,\n       800., 239.5, 0., 0., 1. ]\ndistortion_coefficients: !!opencv-matrix\n  "
        " rows: 5\n   cols: 1\n   dt: d\n   data: [ 0., 0., 0., 0., 0. ]\n",
        k, "states no pose");
    expect_camera(
        "image_width: 640\nimage_height: 480\ncamera_name: narrow\ncamera_matrix:\n  rows: "
        "3\n  cols: 3\n  data: [800, 0, 319.5, 0, 800, 239.5, 0, 0, 1]\ndistortion_model: "
        "plumb_bob\ndistortion_coefficients:\n  rows: 1\n  cols: 5\n  data: [0, 0, 0, 0, "
        "0]\n",
        k, "no size of a pixel");
    expect_camera("ParGroup: Camera: Parameter;\n  \"Internal camera parameters\";\n\nFocus:foc: "
                  "0.008;\n  DOUBLE:0.0:;\n  \"Focal length of the lens [meter]\";\n\nKappa:kappa: "
                  "0;\n\nSx:sx: 1e-05;\n\nSy:sy: 1e-05;\n\nCx:cx: 319.5;\n\nCy:cy: "
                  "239.5;\n\nImageWidth:imgw: 640;\n\nImageHeight:imgh: 480;\n",
                  k, "states no pose");
    expect_camera("gen_cam_par_area_scan_polynomial (0.008, 0, 0, 0, 0, 0, 1e-05, 1e-05, 319.5, "
                  "239.5, 640, 480, CameraParam)\n",
                  k, "states no pose");
    mkdir("colmap", 0777);
    write_file("colmap/cameras.txt", "# one\n7 SIMPLE_RADIAL 640 480 800 320 240 0\n");
    write_file("colmap/images.txt", "1 1 0 0 0 0 0 0 7 a.png\n2.5 7 -1\n");
    mcv_rig *rig = parse_rig(empty);
    WELL(mcv_rig_add_camera(rig, "colmap", NULL, NULL, &error));
    mcv_rig_free(rig);
}

static void refused(const char *text, const char *says) {
    mcv_rig *rig = parse_rig(empty);
    write_file("other", text);
    FAILS(MCV_BAD_INPUT, says, mcv_rig_add_camera(rig, "other", NULL, NULL, &error));
    mcv_rig_free(rig);
}

#define YAML "image_width: 640\nimage_height: 480\n"
#define K_OF(data) "camera_matrix:\n  data: [" data "]\n"
#define K K_OF("800, 0, 320, 0, 800, 240, 0, 0, 1")

static void test_what_is_refused(void **state) {
    mcv_rig *rig = parse_rig(rig_text);
    (void)state;
    refused(YAML K "distortion_model: equidistant\n", "is none of the sensors'");
    refused(YAML K "distortion_coefficients:\n  data: "
                   "[0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0]\n",
            "must be 1 to 14 numbers");
    refused("CamParam := ['area_scan_polynomial', 0.008, 0, 0, 0, 0, 1e-9, 1e-05, 1e-05, 320, 240, "
            "640, 480]\n",
            "polynomial distortion, of 1e-09");
    refused("CamParam := ['area_scan_tilt_division', 0.008, 0, 0.009, 5, 90, 1e-05, 1e-05, 320, "
            "240, 640, 480]\n",
            "ImagePlaneDist 0.009 m is not Focus 0.008 m");
    refused("CamParam := ['area_scan_tilt_object_side_telecentric_division', 0.5, 0, 0, 5, 90, "
            "1e-05, 1e-05, 320, 240, 640, 480]\n",
            "ImagePlaneDist must be above 0");
    refused("CamParam := ['area_scan_division', 0.008, 0]\n", "must have 8 numbers");
    refused(YAML K_OF("800, 0, 320"), "must be 9 numbers in brackets");
    refused(YAML K_OF("800, 1, 320, 0, 800, 240, 0, 0, 1"), "skew");
    refused(YAML K_OF("nan, 0, 320, 0, 800, 240, 0, 0, 1"), "above 0");
    refused("image_width: 0\nimage_height: 480\n" K, "the image's width");
    refused(YAML K "rotation:\n  data: [1, 0, 0, 0, 1, 0, 0, 0, 2]\ntvec: [0, 0, 0]\n",
            "its rotation is none");
    refused("hello", "image_width");
    refused("{\"a\": 1}", "no camera model");
    mkdir("several", 0777);
    write_file("several/cameras.txt", "1 OPENCV 640 480 800 800 320 240 0 0 0.01 0\n");
    write_file("several/images.txt", "1 1 0 0 0 0 0 0 1 a.png\n\n2 1 0 0 0 0 0 0 1 b.png\n\n");
    FAILS(MCV_BAD_INPUT, "several images", mcv_rig_add_camera(rig, "several", NULL, NULL, &error));
    write_file("several/images.txt", "1 1 0 0 0 0 0 0 1 a.png\n\n");
    FAILS(MCV_BAD_INPUT, "nowhere", mcv_rig_add_camera(rig, "nowhere", NULL, NULL, &error));
    write_file("other", YAML K);
    FAILS(MCV_USAGE, "has a sensor \"tele\" already",
          mcv_rig_add_camera(rig, "other", "{\"sensor\": \"tele\"}", NULL, &error));
    FAILS(MCV_USAGE, "--pixel-size -3um: ",
          mcv_rig_add_camera(rig, "other", "{\"pixel_size\": \"-3um\"}", NULL, &error));
    mcv_rig_free(rig);
}

/* --- tilt and distortion --- */

/* A file's camera comes with the members of `lens`, a JSON object, and no others. */
static void expect_lens(const char *file, const char *lens) {
    mcv_rig *rig = parse_rig(empty);
    json_t *truth = json_loads(lens, 0, NULL);
    const json_t *value;
    const char *key;
    assert_non_null(truth);
    WELL(mcv_rig_add_camera(rig, file, "{\"sensor\": \"c\", \"pixel_size\": \"10um\"}", NULL,
                            &error));
    json_t *model = model_of(rig, "c"), *found = json_object_get(model, "lens");
    assert_non_null(found);
    json_object_foreach(truth, key, value) {
        const double is = json_number_value(json_object_get(found, key)),
                     must = json_number_value(value);
        if (!(fabs(is - must) <= 1e-12 * fabs(must)))
            fail_msg("%s: %s is %.17g, not %.17g", file, key, is, must);
    }
    if (json_object_size(found) != json_object_size(truth)) fail_msg("%s: has others, too", file);
    json_decref(truth);
    json_decref(model);
    mcv_rig_free(rig);
}

static void expect_lens_of(const char *text, const char *lens) {
    write_file("other", text);
    expect_lens("other", lens);
}

static void test_distortion_of_other_programs(void **state) {
    (void)state;
    expect_lens_of(YAML K "distortion_coefficients:\n  data: [-0.1, 0.02, 1e-3, -2e-3, 5e-3]\n",
                   "{\"filmDistance\": 8e-3, \"k1\": -0.1, \"k2\": 0.02, \"p1\": 1e-3, "
                   "\"p2\": -2e-3, \"k3\": 5e-3}");
    expect_lens_of(YAML K "distortion_coefficients:\n  data: "
                          "[0.1, 0, 0, 0, 0, 0.2, 0, 0.03, 1e-3, 2e-3, 3e-3, 4e-3, 0.1, -0.05]\n",
                   "{\"filmDistance\": 8e-3, \"k1\": 0.1, \"k4\": 0.2, \"k6\": 0.03, "
                   "\"s1\": 1e-3, \"s2\": 2e-3, \"s3\": 3e-3, \"s4\": 4e-3, \"tiltX\": 0.1, "
                   "\"tiltY\": -0.05}");
    expect_lens_of(
        "CamParam := ['area_scan_division', 0.008, -2000.0, 1e-05, 1e-05, 320, 240, 640, 480]\n",
        "{\"filmDistance\": 8e-3, \"kappa\": -2000}");
    expect_lens_of("CamParam := ['area_scan_tilt_division', 0.008, 300, 0.008, 9, 270, 1e-05, "
                   "1e-05, 320, 240, 640, 480]\n",
                   "{\"filmDistance\": 8e-3, \"kappa\": 300, \"tilt\": 0.15707963267948966, "
                   "\"tiltDirection\": 4.71238898038469}");
    expect_lens_of("CamParam := ['area_scan_tilt_object_side_telecentric_division', 0.5, 100, "
                   "0.03, 9, 0, 1e-05, 1e-05, 320, 240, 640, 480]\n",
                   "{\"filmDistance\": 0.03, \"kappa\": 100, \"tilt\": 0.15707963267948966}");
    expect_lens_of("Focus:foc: 0.008;\nParGroup:\nKappa:kappa: 3;\nSx:sx: 1e-05;\nSy:sy: "
                   "1e-05;\nCx:cx: 1;\nCy:cy: 2;\nImageWidth:imgw: 640;\nImageHeight:imgh: 480;\n",
                   "{\"filmDistance\": 8e-3, \"kappa\": 3}");
    mkdir("bent", 0777);
    write_file("bent/images.txt", "1 1 0 0 0 0 0 0 1 a.png\n\n");
    write_file("bent/cameras.txt", "1 OPENCV 640 480 800 800 320 240 0.1 0 0.01 0\n");
    expect_lens("bent", "{\"filmDistance\": 8e-3, \"k1\": 0.1, \"p1\": 0.01}");
    write_file("bent/cameras.txt", "1 FULL_OPENCV 640 480 800 800 320 240 0 0 0 0 0 0 0 0.5\n");
    expect_lens("bent", "{\"filmDistance\": 8e-3, \"k6\": 0.5}");
    write_file("bent/cameras.txt", "1 RADIAL 640 480 800 320 240 0.1 0.2\n");
    expect_lens("bent", "{\"filmDistance\": 8e-3, \"k1\": 0.1, \"k2\": 0.2}");
}

/* A camera with this lens in the format, back again. */
static void check_lens_round_trip(const char *lens, int format, const char *says) {
    char text[1024], file[16], *out = NULL, options[64];
    snprintf(text, sizeof text,
             "{\"asset\": {\"version\": \"2.0\"}, \"scene\": 0, \"scenes\": [{\"nodes\": [0]}], "
             "\"nodes\": [{\"extensions\": {\"MCVISI_sensors\": {\"sensor\": 0}}}], "
             "\"extensionsUsed\": [\"MCVISI_sensors\"], \"extensions\": {\"MCVISI_sensors\": "
             "{\"sensors\": [{\"name\": \"c\", %s, \"resolution\": [640, 480], \"pixelSize\": "
             "\"10um\"}]}}}",
             lens);
    mcv_rig *rig = parse_rig(text);
    if (says) {
        snprintf(options, sizeof options, "{\"format\": \"%s\", \"output\": \"refused\"}",
                 formats[format]);
        FAILS(MCV_BAD_INPUT, says, mcv_rig_camera_model(rig, options, &out, &error));
        mcv_rig_free(rig);
        return;
    }
    free(export_model(rig, "c", format));
    snprintf(file, sizeof file, "model%d", format);
    json_t *model = model_of(rig, "c");
    out = json_dumps(json_object_get(model, "lens"), JSON_REAL_PRECISION(17));
    expect_lens(file, out);
    free(out);
    json_decref(model);
    mcv_rig_free(rig);
}

#define PINHOLE "\"type\": \"pinhole\", \"imageDistance\": \"8mm\", "
#define TELECENTRIC \
    "\"type\": \"telecentric\", \"focalLength\": \"50mm\", \"magnification\": 0.5, " \
    "\"fNumber\": 8, "

static void test_distortion_there_and_back(void **state) {
    static const char radial[] = PINHOLE "\"k1\": -0.1, \"k2\": 0.02, \"p1\": 1e-3",
                      rational[] = PINHOLE "\"k1\": 0.1, \"k3\": 0.01, \"k5\": 0.2",
                      prism[] = PINHOLE "\"k1\": 0.1, \"s1\": 2e-3, \"tiltX\": 0.1, "
                                        "\"tiltY\": 0.05",
                      division[] = PINHOLE "\"kappa\": -300, \"tilt\": 0.1, "
                                           "\"tiltDirection\": 0.4",
                      tele[] = TELECENTRIC "\"kappa\": -300, \"tilt\": 0.1, "
                                           "\"tiltDirection\": 0.4";
    (void)state;
    for (int format = 0; format < FORMATS; ++format) {
        const char *polynomial = format == HALCON ? "the other way" : NULL;
        check_lens_round_trip(radial, format, polynomial);
        check_lens_round_trip(rational, format, polynomial);
        check_lens_round_trip(prism, format,
                              polynomial                          ? polynomial
                              : format == ROS || format == COLMAP ? "neither s1 to s4 nor a tilted"
                                                                  : NULL);
        check_lens_round_trip(
            division, format,
            format == OPENCV || format == ROS || format == COLMAP ? "no division model" : NULL);
        check_lens_round_trip(tele, format,
                              format == OPENCV ? "distortion of a telecentric lens"
                              : format == ROS || format == COLMAP ? "has no such model"
                                                                  : NULL);
    }
    check_lens_round_trip(PINHOLE "\"tilt\": 0.1, \"tiltDirection\": 0.4", OPENCV, "x and y alone");
    check_lens_round_trip(PINHOLE "\"tiltX\": 0.1, \"tiltY\": 0.1", HALCON, "both tiltX and tiltY");
}

/* --- lines --- */

static void measure_refused(const mcv_picture *picture, const char *options) {
    char *report = NULL;
    FAILS(MCV_BAD_INPUT, "are times",
          mcv_picture_measure(picture, NULL, NULL, options, &report, &error));
    assert_null(report);
}

/* Rows that are times show no place of the scene, and lengths are not known. */
static void test_lines_have_no_places(void **state) {
    static const char place[] = "{\"region\": \"a=@sky:0mm,0mm,-100mm,20mm,20mm\"}";
    mcv_session *session = open_session("{\"device\": \"reference\"}");
    mcv_rig *rig = parse_rig(sky_rig), *made = parse_rig(empty);
    char *report = NULL;
    (void)state;
    WELL(mcv_rig_set(rig, "sensors/camera/shutter", "line", &error));
    WELL(mcv_rig_set(rig, "sensors/camera/lineTime", "0.001", &error));
    mcv_picture *picture = render(session, rig, "{\"spp\": 4}"), *grey = NULL;
    measure_refused(picture, place);
    measure_refused(picture, "{\"grid\": \"sky=g.png\"}");
    WELL(mcv_picture_measure(picture, NULL, NULL,
                             "{\"region\": \"a=0,0,4,4\", \"grid\": \"g.png\"}", &report, &error));
    assert_null(strstr(report, "object_pixel"));
    mcv_text_free(report);
    /* The grey values' file tells the same, and their bits. */
    WELL(mcv_picture_camera(picture, "{\"expose_to\": 0.5, \"bits\": 10}", &grey, NULL, &error));
    WELL(mcv_picture_write(grey, "grey.png", NULL, &error));
    mcv_picture_free(grey);
    WELL(mcv_picture_read("grey.png", &grey, &error));
    measure_refused(grey, place);
    WELL(mcv_picture_attributes(grey, &report, &error));
    assert_non_null(strstr(report, "\\\"bits\\\":10"));
    mcv_text_free(report);
    json_t *model = model_of(rig, "camera");
    assert_string_equal(json_string_value(json_object_get(model, "model")), "line");
    assert_null(json_object_get(model, "K"));
    assert_null(json_object_get(model, "A"));
    json_decref(model);
    FAILS(MCV_BAD_INPUT, "are times", mcv_rig_add_camera(made, "model0", NULL, &report, &error));
    FAILS(MCV_BAD_INPUT, "no rows that are times",
          mcv_rig_camera_model(rig, "{\"format\": \"opencv\"}", &report, &error));
    mcv_picture_free(grey);
    mcv_picture_free(picture);
    mcv_rig_free(made);
    mcv_rig_free(rig);
    mcv_session_close(session);
}

/* --- the program --- */

static void test_the_verb(void **state) {
    char *text = NULL;
    mcv_rig *rig = parse_rig(rig_text);
    (void)state;
    write_file("rig.gltf", rig_text);
    program_well("camera-model rig.gltf --sensor \"cam 1\" --format opencv");
    WELL(mcv_rig_camera_model(rig, "{\"sensor\": 0, \"format\": \"opencv\"}", &text, &error));
    assert_string_equal(said, text);
    mcv_text_free(text);
    mcv_rig_free(rig);
    program_well("camera-model rig.gltf --sensor tele --format halcon -o tele.hdev");
    program_well("camera-model --import tele.hdev -o new.gltf");
    assert_non_null(strstr(said, "100mm")); /* HALCON does not tell the plane in focus */
    program_well("camera-model --import tele.hdev -o new.gltf --sensor second");
    json_t *checked = program_json("check new.gltf --json");
    assert_int_equal(json_array_size(json_object_get(checked, "sensors")), 2);
    assert_true(number_at(checked, "sensors/1/camera_model/size/0") == 120);
    json_decref(checked);
    program_fails("camera-model --import tele.hdev -o new.gltf", 2, "already");
    program_fails("camera-model --import tele.hdev", 2, "--output is missing");
    program_fails("camera-model rig.gltf", 2, "choose one by --sensor");
    program_fails("camera-model", 2, "RIG is missing");
    program_fails("camera-model rig.gltf --import tele.hdev -o x.gltf", 2, "leave out rig.gltf");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_every_format_gives_the_camera_back),
        cmocka_unit_test(test_points_lie_where_each_program_puts_them),
        cmocka_unit_test(test_files_of_other_programs),
        cmocka_unit_test(test_what_is_refused),
        cmocka_unit_test(test_distortion_of_other_programs),
        cmocka_unit_test(test_distortion_there_and_back),
        cmocka_unit_test(test_lines_have_no_places),
        cmocka_unit_test(test_the_verb),
    };
    return cmocka_run_group_tests(tests, enter_folder, leave_folder);
}
