/* SPDX-License-Identifier: Apache-2.0 */
/* Tilt and distortion as OpenCV has them, where `./run deps peers` has put OpenCV: 1e-6 pixels
 * there and back. */
#include "test.h"

#include "sensor_json.h"

#include "calibration/calibration.h"
#include "reference/random.h"
#include "scene/camera_model.h"

#include <stdlib.h>
#include <unistd.h>

#define PYTHON MCV_SOURCE_DIR "/build/peers/bin/python"
#define THIN \
    "{\"focalLength\":\"16mm\",\"imageDistance\":\"17mm\",\"fNumber\":8," \
    "\"resolution\":[1600,1200],\"pixelSize\":\"5um\",\"principalPoint\":[812.3,577.4],"

static const struct {
    const char *name, *json;
} cameras[] = {
    {"radial", THIN "\"k1\":-0.2,\"k2\":0.08,\"k3\":-0.01,\"p1\":1e-3,\"p2\":-2e-3}"},
    {"rational", THIN "\"k1\":0.3,\"k2\":0.1,\"k3\":0.01,\"k4\":0.4,\"k5\":0.02,\"k6\":0.01}"},
    {"prism", THIN "\"k1\":-0.1,\"s1\":2e-3,\"s2\":-1e-3,\"s3\":1e-3,\"s4\":5e-4}"},
    {"tilted", THIN "\"k1\":-0.1,\"p1\":1e-3,\"tiltX\":\"8deg\",\"tiltY\":\"-5deg\"}"},
    {"tilt_alone", THIN "\"tilt\":\"-20deg\",\"tiltDirection\":\"90deg\"}"},
};
enum { CAMERAS = sizeof cameras / sizeof cameras[0], POINTS = 1000 };

static void write_text(const char *name, const char *ending, const char *text) {
    char path[64];
    snprintf(path, sizeof path, "%s.%s", name, ending);
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    assert_true(fputs(text, file) >= 0);
    assert_int_equal(fclose(file), 0);
}

static void write_camera(const char *name, const char *json) {
    ref_random random = {5};
    mcv_scene *scene = mcv_scene_new("rig.gltf");
    mcv_sensor sensor;
    mcv_camera_model model;
    mcv_calibration_texts texts;
    mcv_error error;
    char *table = NULL;
    size_t size;
    assert_non_null(scene);
    if (sensor_of(MCV_SENSOR_THIN_LENS, json, &sensor, &error) != MCV_OK)
        fail_msg("%s", error.text);
    /* Any pose that is not simple. */
    sensor.to_world = mcv_transform_identity();
    const double turned[9] = {0.36, 0.48, -0.8, -0.8, 0.6, 0, 0.48, 0.64, 0.6};
    memcpy(sensor.to_world.m, turned, sizeof turned);
    for (int i = 0; i < 3; ++i) sensor.to_world.m[9 + i] = 0.1 * (i + 1);
    assert_int_equal(mcv_camera_model_of(scene, &sensor, &model, &error), MCV_OK);
    if (mcv_calibration_write(&model, name, MCV_CALIBRATION_OPENCV, &texts, &error) != MCV_OK)
        fail_msg("%s", error.text);
    write_text(name, "yml", texts.items[0]);
    FILE *out = open_memstream(&table, &size);
    assert_non_null(out);
    for (int i = 0; i < POINTS; ++i) {
        const double pixel[2] = {1600 * ref_random_unit(&random), 1200 * ref_random_unit(&random)};
        double world[3], seen[2];
        mcv_camera_model_unproject(&model, pixel, 0.2 + ref_random_unit(&random), world);
        if (!mcv_camera_model_project(&model, world, seen)) fail_msg("%s: sees nothing", name);
        fprintf(out, "%.17g %.17g %.17g %.17g %.17g\n", world[0], world[1], world[2], seen[0],
                seen[1]);
    }
    assert_int_equal(fclose(out), 0);
    write_text(name, "txt", table);
    free(table);
    mcv_calibration_texts_free(&texts);
    mcv_camera_model_free(&model);
    mcv_scene_free(scene);
}

static void test_opencv_agrees(void **state) {
    char command[1024] = PYTHON " -B " MCV_SOURCE_DIR "/tests/peers/distortion_peer.py";
    (void)state;
    if (access(PYTHON, X_OK) != 0 || system(PYTHON " -c 'import cv2' 2>/dev/null") != 0) {
        puts("OpenCV is not there: `./run deps peers` installs it");
        skip();
    }
    for (int i = 0; i < CAMERAS; ++i) {
        write_camera(cameras[i].name, cameras[i].json);
        strcat(strcat(command, " "), cameras[i].name);
    }
    assert_int_equal(system(command), 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_opencv_agrees)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
