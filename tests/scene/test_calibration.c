/* SPDX-License-Identifier: Apache-2.0 */
/* Files of cameras by host/calibration alone: random cameras come back from each format, other
 * ways to write the same are read, and what is damaged or not clear is refused. */
#include "test.h"

#include "calibration/calibration.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

static mcv_error error;

static void write_text(const char *path, const char *text) {
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    assert_true(fputs(text, file) >= 0);
    assert_int_equal(fclose(file), 0);
}

/* --- round trips --- */

static double uniform(void) {
    static uint32_t state = 1;
    return (state = state * 1664525u + 1013904223u) / 4294967296.0;
}

/* Rotations of all kinds: about one axis by quarter turns too, where angles are not unique and a
 * component of the quaternion is 0. */
static void draw_rotation(int number, double r[9]) {
    double q[4];
    for (int i = 0; i < 4; ++i) q[i] = uniform() - 0.5;
    if (number % 4 == 1)
        for (int i = 0; i < 4; ++i) q[i] = i == 0 || i == 1 + number % 3 ? 1 : 0; /* 90° */
    if (number % 4 == 2)
        for (int i = 0; i < 4; ++i) q[i] = i == 1 + number % 3; /* 180° */
    if (number % 4 == 3)
        for (int i = 1; i < 4; ++i) q[i] *= 1e-9; /* almost none */
    mcv_rotation_of_quaternion(q, r);
}

static mcv_calibration draw_camera(int number) {
    mcv_calibration c = {.posed = true};
    mcv_camera_model *m = &c.model;
    const double focal = 100 + 4000 * uniform(),
                 centre[2] = {3000 * uniform() - 500, 2000 * uniform() - 500};
    *m = (mcv_camera_model){
        .macro = {1, 1},
        .size = {1 + (uint32_t)(4000 * uniform()), 1 + (uint32_t)(3000 * uniform())},
        .pixel = {1e-6 + 1e-5 * uniform(), 1e-6 + 1e-5 * uniform()},
        .focused_depth = 0.01 + uniform(),
        .f_number = 1 + 20 * uniform(),
        .numerical_aperture = NAN,
        .bits = NAN,
        .black_level = NAN,
        .gain = NAN};
    draw_rotation(number, m->rotation);
    for (int i = 0; i < 3; ++i) m->translation[i] = pow(10, 4 * uniform() - 3) * (uniform() - 0.5);
    if (number % 2) {
        const double magnification = 0.02 + 2 * uniform();
        for (int i = 0; i < 2; ++i) m->object_pixel[i] = m->pixel[i] / magnification;
        assert_int_equal(
            mcv_calibration_set_telecentric("drawn", m->object_pixel, centre, &c, &error), MCV_OK);
    } else {
        const double k[2] = {focal, focal * m->pixel[0] / m->pixel[1]};
        assert_int_equal(mcv_calibration_set_perspective("drawn", k, centre, &c, &error), MCV_OK);
    }
    return c;
}

/* Rounding of some ten operations, and angles of up to 360. */
static void expect_near(const double *a, const double *b, int count, double scale, const char *what,
                        int format, int number) {
    for (int i = 0; i < count; ++i)
        if (!(fabs(a[i] - b[i]) <= 1e-12 * fmax(scale, fabs(a[i]))))
            fail_msg("camera %d, format %d: %s %d: %.17g comes back as %.17g", number, format, what,
                     i, a[i], b[i]);
}

static void check_round_trip(int number, mcv_calibration_format format) {
    const mcv_calibration drawn = draw_camera(number);
    const mcv_camera_model *a = &drawn.model;
    mcv_calibration_texts texts;
    mcv_calibration read;
    char path[64];
    const bool telecentric = a->telecentric,
               refused = telecentric &&
                         (format == MCV_CALIBRATION_ROS || format == MCV_CALIBRATION_COLMAP);
    const mcv_result result = mcv_calibration_write(a, "top", format, &texts, &error);
    assert_int_equal(result, refused ? MCV_BAD_INPUT : MCV_OK);
    if (refused) return;
    mkdir("drawn", 0777);
    for (int i = 0; i < MCV_CALIBRATION_FILES && texts.items[i]; ++i) {
        snprintf(path, sizeof path, "drawn/%s", mcv_colmap_files[i]);
        write_text(texts.items[1] ? path : "drawn.text", texts.items[i]);
    }
    if (mcv_calibration_read(texts.items[1] ? "drawn" : "drawn.text", &read, &error) != MCV_OK)
        fail_msg("camera %d, format %d: %s\n%s", number, format, error.text, texts.items[0]);
    const mcv_camera_model *b = &read.model;
    assert_true(read.posed);
    assert_int_equal(b->telecentric, telecentric);
    assert_memory_equal(a->size, b->size, sizeof a->size);
    expect_near(a->rotation, b->rotation, 9, 1, "R", format, number);
    expect_near(a->translation, b->translation, 3, 1, "t", format, number);
    if (telecentric)
        expect_near(a->affine, b->affine, 8, 1 / a->object_pixel[0], "A", format, number);
    else
        expect_near(a->k, b->k, 9, 1000, "K", format, number);
    if (format != MCV_CALIBRATION_COLMAP)
        expect_near(a->pixel, b->pixel, 2, 0, "pixel", format, number);
    if (format == MCV_CALIBRATION_OPENCV) {
        expect_near(&a->focused_depth, &b->focused_depth, 1, 0, "working distance", format, number);
        expect_near(&a->f_number, &b->f_number, 1, 0, "f-number", format, number);
    }
    mcv_calibration_texts_free(&texts);
}

static void test_random_cameras_come_back(void **state) {
    enum { CAMERAS = 400 };
    (void)state;
    for (int number = 0; number < CAMERAS; ++number)
        for (int format = 0; format <= MCV_CALIBRATION_COLMAP; ++format)
            check_round_trip(number, (mcv_calibration_format)format);
}

/* --- other ways to write a camera of 640 x 480 pixels, f = 800, c = (320, 240) from the corner ---
 */

#define SIZE "image_width: 640\nimage_height: 480\n"
#define ROWS(data) "camera_matrix:\n  data: " data "\n"
#define K ROWS("[800, 0, 319.5, 0, 800, 239.5, 0, 0, 1]")
#define TUPLE "CamParam := ['area_scan_division', 0.008, 0, 1e-05, 1e-05, 319.5, 239.5, 640, 480]\n"
#define DAT \
    "Focus:foc: 0.008;\n  DOUBLE:0.0:;\nSx:sx: 1e-05;\nSy:sy: 1e-05;\nCx:cx: 319.5;\nCy:cy: " \
    "239.5;\nImageWidth:imgw: 640;\nImageHeight:imgh: 480;\n"

/* The position, too, where the file has one: t = (1, 2, 3). */
static void reads(const char *text, bool posed) {
    static const double k[9] = {800, 0, 320, 0, 800, 240, 0, 0, 1}, place[3] = {1, 2, 3};
    mcv_calibration camera;
    write_text("other.text", text);
    if (mcv_calibration_read("other.text", &camera, &error) != MCV_OK)
        fail_msg("%s\nis refused: %s", text, error.text);
    for (int i = 0; i < 9; ++i)
        if (!(fabs(camera.model.k[i] - k[i]) < 1e-9))
            fail_msg("%s\nK %d is %.17g", text, i, camera.model.k[i]);
    assert_int_equal(camera.posed, posed);
    for (int i = 0; posed && i < 3; ++i) assert_true(camera.model.translation[i] == place[i]);
}

static void test_other_ways_to_write_it(void **state) {
    (void)state;
    reads("\n\n" SIZE K, false); /* the search for a key stood still at an empty first line */
    reads("\xef\xbb\xbf" SIZE K, false); /* a mark of UTF-8 */
    reads("image_width: 640\r\nimage_height: 480\r\n" ROWS("[800, 0, 319.5,\r\n 0, 800, 239.5,\r\n"
                                                           " 0, 0, 1]\r"),
          false);
    /* PyYAML's dump, by lists with dashes, sorted, and nested as numpy's tolist() */
    reads("camera_matrix:\n  cols: 3\n  data:\n  - 800.0\n  - 0.0\n  - 319.5\n  - 0.0\n  - 800.0\n"
          "  - 239.5\n  - 0.0\n  - 0.0\n  - 1.0\n  rows: 3\n" SIZE,
          false);
    reads("camera_matrix:\n- - 800.0\n  - 0.0\n  - 319.5\n- - 0.0\n  - 800.0\n  - 239.5\n- - 0.0\n"
          "  - 0.0\n  - 1.0\ndistortion_coefficients:\n- 0.0\n- 0.0\n- -0.0\n" SIZE,
          false);
    reads(SIZE "camera_matrix: [[800, 0, 319.5], [0, 800, 239.5], [0, 0, 1]] # K\n", false);
    reads(SIZE K "R: [1, 0, 0, 0, 1, 0, 0, 0, 1]\n", false); /* ROS's rectification */
    reads(SIZE K "R: [1, 0, 0, 0, 1, 0, 0, 0, 1]\nT: [1, 2, 3]\n", true);
    reads(SIZE K "rvec: [0, 0, 1.5]\ntvec: [1, 2, 3]\n", true);
    reads("* a camera that was\n  * CamParam := ['area_scan_division', 0.1, 0, 1, 1, 1, 1, 1, "
          "1]\n" TUPLE "create_pose (1, 2, 3, 10, 20, 30, 'Rp+T', 'gba', 'point', Pose)\n",
          true);
    reads(TUPLE TUPLE, false);
    reads("ParGroup: Camera: Parameter;\nKappa:kappa: 0;\n" DAT, false);
}

/* --- what is refused --- */

static void refuses(const char *path, const char *says) {
    mcv_calibration camera;
    error.text[0] = '\0';
    const mcv_result result = mcv_calibration_read(path, &camera, &error);
    if (result != MCV_BAD_INPUT || !strstr(error.text, says) || !strstr(error.text, path) ||
        strchr(error.text, '\n'))
        fail_msg("%d, \"%s\" must say \"%s\"", result, error.text, says);
}

static void test_what_is_not_clear_is_refused(void **state) {
    static const char *const cases[][2] = {
        /* a list that cannot be read is not one that is missing */
        {SIZE K "distortion_coefficients: [.nan, 0, 0, 0, 0]\n",
         "distortion_coefficients: must be"},
        {SIZE K "distortion_coefficients: [0, 0, 0\n", "distortion_coefficients: must be"},
        {SIZE K "distortion_coefficients: [nan]\n", "has distortion, of nan"},
        {SIZE K "tvec: [1, 2, 3]\n", "rotation or rvec is missing"},
        {SIZE K "rvec: [0, 0, 1]\n", "tvec is missing"},
        {SIZE K "rvec: [0, 0]\ntvec: [1, 2, 3]\n", "rvec: must be 3 numbers"},
        {SIZE K "tvec: [0, 0, inf]\nrvec: [0, 0, 0]\n", "its place is not finite"},
        {SIZE K "rotation: [1, 0, 0, 0, 1, 0, 0, 0, 1]\nrvec: [0, 0, 1]\ntvec: [1, 2, 3]\n",
         "rotation and rvec contradict"},
        {SIZE K "rotation: [1, 0, 0, 0, 1, 0, 0, 0, -1]\ntvec: [1, 2, 3]\n", "right-handed"},
        {SIZE ROWS("[800, 0, 319.5, 0, 800, 239.5, 0, 0, 2]"), "must be [fx, 0, cx"},
        {SIZE ROWS("[800, 0, 319.5, 0, 800, 239.5, 0, 0, 1, 5]"), "must be 9 numbers"},
        {SIZE ROWS("[8e2x, 0, 319.5, 0, 800, 239.5, 0, 0, 1]"), "must be 9 numbers"},
        {SIZE K K, "stands there twice"},
        {"image_width: 640.5\nimage_height: 480\n" K, "width of 640.5"},
        {"image_width: many\nimage_height: 480\n" K, "image_width: must be 1 numbers"},
        {"image_width: 640\nimage_height: 70000\n" K, "height of 70000"},
        {SIZE "model: telecentric\nobject_pixel_size: [1e-5, 1e-5]\nprojection_matrix: [0, 1e5, 0, "
              "9, 1e5, 0, 0, 8, 0, 0, 0, 1]\n",
         "projection_matrix and rotation or object_pixel_size contradict"},
        {"<?xml version=\"1.0\"?>\n<opencv_storage><image_width>640</image_width>\n",
         "OpenCV (as YAML)"},
        {TUPLE "CamParam2 := ['area_scan_division', 0.008, 0, 1e-05, 1e-05, 1, 2, 640, 480]\n",
         "several cameras"},
        {TUPLE
         "gen_cam_par_area_scan_polynomial (0.008, 0, 0, 0, 0, 0, 1e-05, 1e-05, 319.5, 239.5, "
         "640, 480, C)\n",
         "several cameras"},
        {"['area_scan_division', 0.008, 0, 1e-05, 1e-05, 319.5, 239.5, 640, 480*2]\n",
         "must have 8 numbers"},
        {"['area_scan_division', 0.008, 0, 1e-05, 1e-05, 319.5, 239.5, 640, 480.5]\n",
         "height of 480.5"},
        {"['area_scan_division', 0, 0, 1e-05, 1e-05, 319.5, 239.5, 640, 480]\n", "above 0"},
        {"['line_scan_division', 0.008, 0, 1e-05, 1e-05, 1, 2, 640, 480, 0, 0, 1e-5]\n",
         "must be an area scan camera"},
        {TUPLE
         "create_pose (1, 2, 3, 10, 20, 30, 'R(p-T)', 'gba', 'point', P)\ncreate_x ('Rp+T')\n",
         "'Rp+T', 'gba' and 'point'"},
        {TUPLE "create_pose (1, 2, 3, 0, 0, 0, 'Rp+T', 'gba', 'point', P)\n"
               "create_pose (1, 2, 4, 0, 0, 0, 'Rp+T', 'gba', 'point', P)\n",
         "several poses"},
        /* without Kappa it may be of the polynomial model */
        {"ParGroup: Camera: Parameter;\nK1:k1: 2;\n" DAT, "Kappa:kappa:"},
        {"ParGroup: Camera: Parameter;\nKappa:kappa: 0;\n" DAT "ParGroup: Camera: Parameter;\n",
         "several cameras"},
        {"", "has no image_width"},
    };
    (void)state;
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        write_text("other.text", cases[i][0]);
        refuses("other.text", cases[i][1]);
    }
}

static void test_colmap(void **state) {
    static const char *const cases[][2] = {
        {"1 OPENCV_FISHEYE 640 480 800 800 320 240 0 0 0 0\n", "no model OPENCV_FISHEYE"},
        {"1 PINHOLE 640 480 800 800 320\n", "as in `1 PINHOLE"},
        {"1 PINHOLE 640 480 800 800 320 240 0\n", "as in `1 PINHOLE"},
        {"1 PINHOLE 640 480 800 800 320 240x\n", "as in `1 PINHOLE"},
        {"1 SIMPLE_RADIAL 640 480 800 320 240\n", "as in `1 PINHOLE"},
        {"2 PINHOLE 640 480 800 800 320 240\n", "camera 2, but the image is of camera 1"},
        {"1 PINHOLE 640 0.5 800 800 320 240\n", "height of 0.5"},
        {"1 RADIAL 640 480 800 320 240 0 nan\n", "has distortion, of nan"},
        {"", "as in `1 PINHOLE"},
    };
    mcv_calibration camera;
    (void)state;
    mkdir("col", 0777);
    write_text("col/images.txt", "1 1 0 0 0 1 2 3 1 a.png\n");
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        write_text("col/cameras.txt", cases[i][0]);
        refuses("col", cases[i][1]);
    }
    write_text("col/cameras.txt",
               "# a camera\n\n1\tFULL_OPENCV 640 480 800 800 320 240 0 0 0 0 0 0 0 0 \r\n");
    assert_int_equal(mcv_calibration_read("col", &camera, &error), MCV_OK);
    assert_true(camera.model.k[2] == 320 && camera.model.translation[2] == 3 && camera.posed);
    assert_string_equal(camera.name, "a.png");
    write_text("col/images.txt", "1 0 0 0 0 1 2 3 1 a.png\n");
    refuses("col", "its rotation is none");
}

/* A name that glTF cannot hold would be lost with its sensor. */
static void test_names(void **state) {
    static const char *const names[] = {"\xff\xfe", "a\x01z", "\x7f"};
    mcv_calibration camera;
    char text[512];
    (void)state;
    for (size_t i = 0; i < sizeof names / sizeof names[0]; ++i) {
        snprintf(text, sizeof text, SIZE "camera_name: %s\n" K, names[i]);
        write_text("other.text", text);
        assert_int_equal(mcv_calibration_read("other.text", &camera, &error), MCV_OK);
        assert_string_equal(camera.name, "");
    }
    write_text("other.text", SIZE "camera_name: \"Prüfling\"\n" K);
    assert_int_equal(mcv_calibration_read("other.text", &camera, &error), MCV_OK);
    assert_string_equal(camera.name, "Prüfling");
    /* One that is too long ends at 127 bytes, in the middle of the 64th "ü". */
    char *at = text + snprintf(text, sizeof text, SIZE K "camera_name: ");
    for (int i = 0; i < 80; ++i) at += snprintf(at, 3, "ü");
    write_text("other.text", text);
    assert_int_equal(mcv_calibration_read("other.text", &camera, &error), MCV_OK);
    json_t *name = json_string(camera.name), *rig = json_object();
    assert_non_null(name);
    json_decref(name);
    assert_int_equal(mcv_calibration_add(&camera, "other.text", "\xff", 1e-6, rig, &error),
                     MCV_USAGE);
    assert_non_null(strstr(error.text, "must be UTF-8"));
    assert_int_equal(mcv_calibration_add(&camera, "other.text", "ü", 1e-6, rig, &error), MCV_OK);
    json_decref(rig);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_random_cameras_come_back),
        cmocka_unit_test(test_other_ways_to_write_it),
        cmocka_unit_test(test_what_is_not_clear_is_refused),
        cmocka_unit_test(test_colmap),
        cmocka_unit_test(test_names),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
