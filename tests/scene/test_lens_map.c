/* SPDX-License-Identifier: Apache-2.0 */
/* Tilted films and lens distortion: both ways, closed forms, datasheets, what is refused. */
#include "test.h"

#include "sensor_json.h"

#include "reference/random.h"
#include "scene/camera_model.h"
#include "scene/lens_map.h"

#define FILM "\"resolution\":[1600,1200],\"pixelSize\":\"5um\""
#define THIN "{\"focalLength\":\"16mm\",\"imageDistance\":\"17mm\",\"fNumber\":4," FILM

static mcv_sensor sensor_from(uint32_t type, const char *json) {
    mcv_sensor sensor;
    mcv_error error;
    if (sensor_of(type, json, &sensor, &error) != MCV_OK) fail_msg("%s: %s", json, error.text);
    return sensor;
}

static const char *const lenses[] = {
    THIN ",\"k1\":-0.2,\"k2\":0.08,\"k3\":-0.01,\"p1\":1e-3,\"p2\":-2e-3}",
    THIN ",\"k1\":0.3,\"k2\":0.1,\"k4\":0.4,\"k5\":0.02,\"k6\":0.01,\"s1\":2e-3,\"s2\":-1e-3,"
         "\"s3\":1e-3,\"s4\":5e-4}",
    THIN ",\"kappa\":-2000}",
    THIN ",\"kappa\":1500,\"tilt\":\"12deg\",\"tiltDirection\":\"30deg\"}",
    THIN ",\"k1\":-0.1,\"tiltX\":\"8deg\",\"tiltY\":\"-5deg\"}",
};
enum { LENSES = sizeof lenses / sizeof lenses[0] };

/* Places of the whole film come back within 1e-9 of its distance, slopes of rays too. */
static void test_both_ways(void **state) {
    ref_random random = {1};
    (void)state;
    for (int lens = 0; lens < LENSES; ++lens) {
        const mcv_sensor sensor = sensor_from(MCV_SENSOR_THIN_LENS, lenses[lens]);
        mcv_lens_map map = mcv_sensor_lens_map(&sensor);
        mcv_lens_map_find_reach(&map);
        assert_true(mcv_lens_map_is_used(&map));
        for (int i = 0; i < 20000; ++i) {
            const double film[2] = {(ref_random_unit(&random) - 0.5) * 8e-3 / 17e-3,
                                    (ref_random_unit(&random) - 0.5) * 6e-3 / 17e-3};
            double u[2], back[2], again[2], stretch;
            assert_true(mcv_lens_map_look(&map, film, u, &stretch));
            assert_true(mcv_lens_map_meet(&map, u, back));
            assert_true(mcv_lens_map_look(&map, back, again, &stretch));
            for (int k = 0; k < 2; ++k)
                if (!(fabs(back[k] - film[k]) < 1e-9 && fabs(again[k] - u[k]) < 1e-9))
                    fail_msg("%s: %.17g comes back as %.17g", lenses[lens], film[k], back[k]);
        }
    }
}

/* A tilt about the image's x or y is the same by HALCON's and by OpenCV's angles. */
static void test_tilts_agree(void **state) {
    (void)state;
    for (int axis = 0; axis < 2; ++axis) {
        mcv_lens_map halcon = mcv_lens_map_none(), opencv = halcon;
        mcv_lens_map_tilt(&halcon, 0.2, axis * M_PI / 2);
        mcv_lens_map_tilt_xy(&opencv, axis ? 0 : 0.2, axis ? 0.2 : 0);
        for (int k = 0; k < 6; ++k)
            assert_true(fabs(halcon.axes[k / 3][k % 3] - opencv.axes[k / 3][k % 3]) < 1e-15);
    }
}

/* The film's points in space, by the turned axes: a place 1 along the axis of the tilt keeps its
 * distance; one 1 across it lies at b + sin(tilt), cos(tilt) off. */
static void test_tilted_film(void **state) {
    mcv_lens_map map = mcv_lens_map_none();
    double u[2], stretch;
    (void)state;
    mcv_lens_map_tilt(&map, 0.3, 0);
    assert_true(mcv_lens_map_look(&map, (const double[2]){0.5, 0}, u, &stretch));
    assert_true(stretch == 1 && u[0] == 0.5 && u[1] == 0);
    assert_true(mcv_lens_map_look(&map, (const double[2]){0, 0.5}, u, &stretch));
    assert_true(fabs(stretch - (1 + 0.5 * sin(0.3))) < 1e-15);
    assert_true(fabs(u[1] - 0.5 * cos(0.3) / stretch) < 1e-15);
}

/* HALCON's division model: κ there and back within 1e-12, in metres on the film. */
static void test_division(void **state) {
    const mcv_sensor sensor = sensor_from(MCV_SENSOR_THIN_LENS, lenses[2]);
    const mcv_lens_map map = mcv_sensor_lens_map(&sensor);
    (void)state;
    for (int i = 1; i < 100; ++i) {
        const double q = i * 5e-5, kappa = -2000, truth = q / (1 + kappa * q * q),
                     s[2] = {0.6 * q / 17e-3, 0.8 * q / 17e-3};
        double u[2], back[2];
        assert_true(mcv_lens_map_undistort(&map, s, u));
        assert_true(fabs(hypot(u[0], u[1]) * 17e-3 - truth) < 1e-12 * truth);
        mcv_lens_map_distort(&map, u, back);
        assert_true(fabs(back[0] - s[0]) < 1e-12 * s[0] && fabs(back[1] - s[1]) < 1e-12 * s[1]);
    }
}

/* A datasheet's percentages, read back in the picture that the lens makes: the straight line
 * through both upper corners, and the farthest corner. */
static void test_datasheet(void **state) {
    static const double stated[] = {-0.03, -0.001, 0.001, 0.02};
    (void)state;
    for (int i = 0; i < 4; ++i) {
        char json[512];
        double middle[2], u[2], stretch;
        const double corner[2] = {4e-3 / 17e-3, -3e-3 / 17e-3};
        snprintf(json, sizeof json, THIN ",\"tvDistortion\":%.17g}", stated[i]);
        mcv_sensor sensor = sensor_from(MCV_SENSOR_THIN_LENS, json);
        mcv_lens_map map = mcv_sensor_lens_map(&sensor);
        assert_true(mcv_lens_map_look(&map, corner, u, &stretch));
        assert_true(mcv_lens_map_meet(&map, (const double[2]){0, u[1]}, middle));
        const double bend = (middle[1] - corner[1]) / (6e-3 / 17e-3);
        if (!(fabs(bend - stated[i]) < 1e-10))
            fail_msg("a line bends by %.12g, not %.12g", bend, stated[i]);
        snprintf(json, sizeof json, THIN ",\"geometricDistortion\":%.17g}", stated[i]);
        sensor = sensor_from(MCV_SENSOR_THIN_LENS, json);
        map = mcv_sensor_lens_map(&sensor);
        assert_true(mcv_lens_map_look(&map, corner, u, &stretch));
        const double r = hypot(corner[0], corner[1]), ideal = hypot(u[0], u[1]);
        assert_true(fabs((r - ideal) / ideal - stated[i]) < 1e-10);
    }
}

/* The camera model's projection and its inverse, and what it writes and reads. */
static void test_camera_model(void **state) {
    ref_random random = {2};
    (void)state;
    for (int lens = 0; lens < LENSES; ++lens) {
        mcv_scene *scene = mcv_scene_new("rig.gltf");
        mcv_sensor sensor = sensor_from(MCV_SENSOR_THIN_LENS, lenses[lens]);
        mcv_camera_model model, copy;
        mcv_error error;
        bool is_one;
        assert_non_null(scene);
        sensor.to_world = mcv_transform_identity();
        assert_int_equal(mcv_camera_model_of(scene, &sensor, &model, &error), MCV_OK);
        char *text = mcv_camera_model_write(&model);
        if (mcv_camera_model_read(text, "a file", &copy, &is_one, &error) != MCV_OK)
            fail_msg("%s", error.text);
        assert_true(is_one);
        for (int i = 0; i < 1000; ++i) {
            const double pixel[2] = {1600 * ref_random_unit(&random),
                                     1200 * ref_random_unit(&random)};
            double world[3], back[2], read[2];
            mcv_camera_model_unproject(&model, pixel, 0.3, world);
            assert_true(mcv_camera_model_project(&model, world, back));
            assert_true(mcv_camera_model_project(&copy, world, read));
            for (int k = 0; k < 2; ++k) {
                assert_true(fabs(back[k] - pixel[k]) < 1e-6);
                assert_true(fabs(read[k] - back[k]) < 1e-9);
            }
        }
        free(text);
        mcv_camera_model_free(&model);
        mcv_camera_model_free(&copy);
        mcv_scene_free(scene);
    }
}

/* The lens of a telecentric camera is as large as what its film sees. */
static void test_lens_of_telecentric(void **state) {
    const mcv_sensor sensor = sensor_from(MCV_SENSOR_TELECENTRIC,
                                          "{\"magnification\":0.25,\"workingDistance\":\"110mm\","
                                          "\"fNumber\":8,\"geometricDistortion\":-0.02," FILM "}");
    const mcv_telecentric_params *p = &sensor.as.telecentric;
    (void)state;
    /* r' = r (1 + D): the corner sees what lies at 5 mm/(m (1 - 0.02)). */
    const double field = 2 * 5e-3 / 0.25 / 0.98, cone = 2 * 0.11 * 0.25 / 16;
    assert_true(fabs(p->lensDiameter - field - cone) < 1e-9);
}

/* The working plane that check prints: tan = tan(tilt)/m, and the depths at the image's corners lie
 * on w = w0 - y tan. */
static void test_plane_in_focus(void **state) {
    const mcv_sensor sensor =
        sensor_from(MCV_SENSOR_THIN_LENS, "{\"focalLength\":\"16mm\",\"focusDistance\":\"200mm\","
                                          "\"fNumber\":4,\"tilt\":\"-5deg\"," FILM "}");
    const mcv_optics optics = mcv_sensor_optics(&sensor);
    const double m = 16.0 / 184, tangent = tan(5 * M_PI / 180) / m, b = 16e-3 * (1 + m);
    (void)state;
    assert_true(fabs(tan(optics.object_tilt) - tangent) < 1e-9);
    for (int i = 0; i < 2; ++i) {
        /* From the film's edge, 3 mm from the axis: s = y/w there, and w = w0 + y tan. */
        const double side = i ? 1 : -1, turn = 5 * M_PI / 180,
                     s = side * 3e-3 * cos(turn) / (b - side * 3e-3 * sin(turn)),
                     depth = 0.2 / (1 - s * tangent);
        if (!(fabs(optics.plane_depths[i] - depth) < 1e-9))
            fail_msg("in focus at %.9g m, not %.9g", optics.plane_depths[i], depth);
    }
    const mcv_sensor plain = sensor_from(MCV_SENSOR_THIN_LENS, THIN "}");
    assert_true(isnan(mcv_sensor_optics(&plain).object_tilt));
}

static void test_refused(void **state) {
    static const struct {
        const char *json, *says;
    } cases[] = {
        {THIN ",\"tilt\":\"5deg\",\"tiltX\":\"5deg\"}",
         "cam/tilt: and tiltX, tiltY tell the same thing"},
        {THIN ",\"tiltDirection\":\"5deg\"}", "cam/tiltDirection: needs tilt"},
        {THIN ",\"kappa\":1,\"k1\":0.1}", "cam/kappa: is of the division model"},
        {THIN ",\"kappa\":1,\"tvDistortion\":0.01}", "cam/kappa: is of the division model"},
        {THIN ",\"tilt\":\"85deg\"}", "cam/tilt: the plane of the film meets the lens"},
        {"{\"focalLength\":\"2mm\",\"imageDistance\":\"2mm\",\"fNumber\":8," FILM
         ",\"tilt\":\"-70deg\"}",
         "cam/tilt: the film's column 0, row 1031.25 lies before the lens"},
        {THIN ",\"k1\":-6}", "cam: the distortion folds the picture"},
        {THIN ",\"kappa\":-50000}", "cam: the distortion folds the picture"},
        {THIN ",\"k1\":0.1,\"geometricDistortion\":0.02}",
         "cam/geometricDistortion: 0.02 contradicts k1 0.1"},
        {THIN ",\"tvDistortion\":-0.9}", "cam/tvDistortion: -0.9: no k1 bends lines by so much"},
        {THIN ",\"k7\":1}", "unknown key \"k7\""},
    };
    (void)state;
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        mcv_sensor sensor;
        mcv_error error = {0};
        const mcv_result result = sensor_of(MCV_SENSOR_THIN_LENS, cases[i].json, &sensor, &error);
        if (result != MCV_BAD_INPUT || !strstr(error.text, cases[i].says))
            fail_msg("%s gave %d, \"%s\"; must say \"%s\"", cases[i].json, result, error.text,
                     cases[i].says);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_both_ways),           cmocka_unit_test(test_tilts_agree),
        cmocka_unit_test(test_tilted_film),         cmocka_unit_test(test_division),
        cmocka_unit_test(test_datasheet),           cmocka_unit_test(test_camera_model),
        cmocka_unit_test(test_lens_of_telecentric), cmocka_unit_test(test_refused),
        cmocka_unit_test(test_plane_in_focus),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
