/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Sensors that move, on the device and in the reference renderer: blur, rolling shutter, lines,
 * TDI, encoders and strobes, by the place and the width of an edge in the picture, and its transfer
 * function.
 */
#include "moving_edge.h"
#include "scene_files.h"

#include "scene/motion.h"

/* A camera before a black half plane: its edge lies at x = 0, or at y = 0. */
static mcv_scene *scene_of(const mcv_sensor *camera, mcv_transform at, bool across) {
    mcv_scene *scene = mcv_scene_new("motion");
    add_environment(scene, 1);
    add_rectangle(scene, 0.4, 0.4, add_absorber(scene),
                  looking_up_z(across ? 0 : 0.2, across ? 0.2 : 0, -depth));
    add_sensor(scene, MCV_SENSOR_PINHOLE, camera, at);
    return scene;
}

static edge measure(bool reference, const mcv_sensor *camera, mcv_transform at, bool across) {
    mcv_scene *scene = scene_of(camera, at, across);
    const edge e = edge_in(reference, scene, 1, across);
    mcv_scene_free(scene);
    return e;
}

static const mcv_transform *here(void) {
    static mcv_transform at;
    at = looking_down_z(0, 0, 0);
    return &at;
}

/* The edge of a camera that moves by 9 pixels while it is exposed is a ramp of that width: a
 * variance of 81/12, and 1/6 of pixels, which is |sinc(ν v t)| as a transfer function; the middle
 * lies half of the way back. 48 rows of 256 samples leave 0.02 pixels, and 0.1 of the variance. A
 * pixel's error of 1/32 at most, over nine pixels and 48 rows, is one of 2 sin(π/16) √9/32/√48 =
 * 0.005 of the transfer function, were samples not stratified; 1 % of it is 0.0055. */
static void test_blur(void **state) {
    (void)state;
    mcv_sensor camera = camera_with(",\"exposureTime\":0.01");
    camera.motion.velocity[0] = 9 * seen / 0.01;
    for (int reference = 0; reference < 2; ++reference) {
        const edge e = measure(reference, &camera, *here(), false);
        expect("blurred edge, place", e.middle, SIZE / 2.0 - 4.5, 0.05);
        expect("blurred edge, variance", e.variance, 81 / 12.0 + 1 / 6.0, 0.25);
        const double truth = fabs(sinc(9 * frequency)) * pow(sinc(frequency), 2);
        expect("blurred edge, transfer function", e.transfer, truth, 0.01 * truth);
    }
}

/* Rolling shutter: row r is v r t_row behind; without an exposure no row is blurred. A strobe
 * within all exposures freezes the picture. */
static void test_rolling(void **state) {
    (void)state;
    mcv_sensor camera = camera_with(",\"shutter\":\"rolling\",\"lineTime\":1e-4");
    camera.motion.velocity[0] = 0.2 * seen / 1e-4;
    mcv_sensor flash =
        camera_with(",\"shutter\":\"rolling\",\"lineTime\":1e-4,\"exposureTime\":0.01,"
                    "\"strobeDelay\":0.006,\"strobeTime\":1e-5");
    flash.motion = camera.motion;
    for (int reference = 0; reference < 2; ++reference) {
        const edge e = measure(reference, &camera, *here(), false),
                   frozen = measure(reference, &flash, *here(), false);
        expect("rolling shutter, columns per row", e.slope, -0.2, 2e-3);
        expect("rolling shutter, middle", e.middle, SIZE / 2.0 - 0.2 * (SIZE - 1) / 2, 0.05);
        expect("strobe, columns per row", frozen.slope, 0, 2e-3);
        expect("strobe, middle", frozen.middle, SIZE / 2.0 - 0.2 * 60.05, 0.05);
        assert_true(e.variance < 0.3 && frozen.variance < 0.3);
    }
}

/* A line camera that moves by a pixel per line sees squares as squares: the edge at y = 0 lies in
 * the line in which the camera stands there. TDI of N stages with a mismatch of δ pixels per line
 * blurs by N stages δ apart, a variance of (N² - 1) δ²/12, whose transfer function is sin(πNδν)/(N
 * sin(πδν)). */
static void test_lines(void **state) {
    (void)state;
    const double speed = seen / 1e-4;
    mcv_sensor line = camera_with(",\"shutter\":\"line\",\"lineTime\":1e-4,\"exposureTime\":0");
    mcv_sensor tdi = camera_with(",\"shutter\":\"line\",\"lineTime\":1e-4,\"exposureTime\":0,"
                                 "\"stages\":16");
    const mcv_transform above = looking_down_z(0, 20 * seen, 0);
    line.motion.velocity[1] = tdi.motion.velocity[1] = -speed;
    for (int reference = 0; reference < 2; ++reference) {
        /* Line r looks at 20 - r - (y - 1/2) pixels, y in its row: half of line 20 is dark. */
        const edge e = measure(reference, &line, above, true);
        expect("line, place", e.middle, 20.5, 0.05);
        expect("line, variance", e.variance, 0.25, 0.03);
        /* The picture moves up by a row per line, as the charges do. */
        const edge matched = measure(reference, &tdi, above, true);
        expect("TDI, place", matched.middle, 20.5, 0.05);
        expect("TDI, variance", matched.variance, 0.25, 0.03);
        /* Half a pixel too much per line: a third of a line for each stage, and pixels of 2/3. */
        mcv_sensor off = tdi;
        off.motion.velocity[1] = -1.5 * speed;
        const edge mismatched = measure(reference, &off, looking_down_z(0, 30 * seen, 0), true);
        expect("TDI mismatched, place", mismatched.middle, 20.5, 0.1);
        expect("TDI mismatched, variance", mismatched.variance,
               255 / 12.0 / 9 + 4 / 9.0 / 12 + 1 / 12.0, 0.15);
        const double truth = sin(16 * M_PI / 3 * frequency) / (16 * sin(M_PI / 3 * frequency)) *
                             sinc(2 / 3.0 * frequency) * sinc(frequency);
        expect("TDI mismatched, transfer function", mismatched.transfer, truth, 0.01 * truth);
    }
}

/* What 64 stages with a mismatch of 0.01 pixels leave at 1/4 and 1/2 per pixel, from the moments of
 * the device's header: a picture that moves by 1.01 rows per line time. Floats leave 1e-6 of times
 * of up to 64 lines. */
static void test_stages(void **state) {
    static const double truths[] = {0.958428, 0.839903};
    (void)state;
    mcv_sensor camera = camera_with(",\"shutter\":\"line\",\"lineTime\":1,\"exposureTime\":0,"
                                    "\"stages\":64");
    mcv_motion motion;
    mcv_motion_prepare(&camera, &motion);
    for (int i = 0; i < 2; ++i) {
        const double nu = 0.25 * (1 + i);
        double complex sum = 0;
        for (uint32_t stage = 0; stage < 64; ++stage) {
            const mcv_moment m = mcv_expose(&motion, 7, 0.5f, ((float)stage + 0.5f) / 64);
            sum += cexp(I * 2 * M_PI * nu * (1.01 * m.time - m.stage)) / 64;
        }
        expect("64 stages, transfer function", cabs(sum), truths[i], 1e-4);
    }
}

/* --- encoders --- */

static const char encoder[] =
    ",\"shutter\":\"line\",\"lineTime\":1e-4,\"exposureTime\":0,\"encoderJitter\":1.5e-4,"
    "\"encoderRipple\":3e-4,\"encoderPeriod\":16,\"encoderSeed\":%d";

static mcv_sensor encoder_camera(int seed) {
    char json[256];
    snprintf(json, sizeof json, encoder, seed);
    return camera_with(json);
}

/* The jitter of many lines is normal; without jitter the ripple is a sine. Five standard errors of
 * n = 65536 numbers: of the mean, of the variance, of the fourth moment. */
static void test_encoder_statistics(void **state) {
    enum { LINES = 65536 };
    (void)state;
    mcv_sensor camera = encoder_camera(3);
    mcv_motion motion;
    mcv_motion_prepare(&camera, &motion);
    double sum = 0, squares = 0, fourth = 0, next = 0, before = 0;
    for (uint32_t line = 0; line < LINES; ++line) {
        /* Whole periods down: the ripple is 0. */
        const double z = mcv_line_error(&motion, line, 16) / 1.5e-4;
        sum += z / LINES, squares += z * z / LINES, fourth += z * z * z * z / LINES;
        next += z * before / LINES, before = z;
    }
    const double error = 5 / sqrt(LINES);
    expect("jitter, mean", sum, 0, error);
    expect("jitter, variance", squares, 1, error * sqrt(2));
    expect("jitter, fourth moment", fourth, 3, error * sqrt(96));
    expect("jitter, line by line", next, 0, error);
    /* A stage is exposed when its own line begins; floats leave 1e-9 s of these times. */
    motion.stages = 4;
    const mcv_moment moment = mcv_expose(&motion, 7, 0.5f, 2.5f / 4);
    assert_true(fabs(moment.time - 7.5 * 1e-4 - mcv_line_error(&motion, 9, 7.5f)) < 1e-9);
    motion.jitter = 0;
    for (int row = 0; row < 48; ++row)
        assert_true(fabs(mcv_line_error(&motion, 5, (float)row) - 3e-4 * sin(2 * M_PI * row / 16)) <
                    1e-6 * 3e-4);
}

/* A camera that goes sideways by 0.4 pixels per line sees the edge in each line where it stands
 * when the encoder begins that line. Of 128 samples the pixel with the edge has an
 * error of at most 1/√512 = 0.044; 48 lines know it to 5/√96 of that. */
static void test_encoder(void **state) {
    (void)state;
    mcv_sensor camera = encoder_camera(3), other = encoder_camera(4);
    camera.motion.velocity[0] = 0.4 * seen / 1e-4;
    mcv_motion motion;
    mcv_motion_prepare(&camera, &motion);
    for (int reference = 0; reference < 2; ++reference) {
        mcv_scene *scene = scene_of(&camera, *here(), false);
        mcv_image image = picture_by(reference, scene, 1);
        double squares = 0;
        for (uint32_t line = 0; line < SIZE; ++line) {
            const double u = mcv_line_draw(3, line, 0), v = mcv_line_draw(3, line, 1),
                         late = 1.5 * sqrt(-2 * log(u)) * cos(2 * M_PI * v) +
                                3 * sin(2 * M_PI * line / 16.0);
            double place, variance;
            edge_of(&image, false, line, &place, &variance);
            squares += pow(place - SIZE / 2.0 + 0.4 * (line + late), 2) / SIZE;
        }
        mcv_image_free(&image);
        mcv_scene_free(scene);
        expect("encoder, error of a line", sqrt(squares), 0, 0.067);
    }
    assert_true(mcv_line_draw(3, 7, 0) != mcv_line_draw(4, 7, 0));
    mcv_motion_prepare(&other, &motion);
    assert_int_equal(motion.seed, 4);
}

/* At a flash the picture is that of a camera that stands where the other one is then. */
static void test_turned(void **state) {
    (void)state;
    mcv_sensor camera = camera_with(",\"exposureTime\":1,\"strobeDelay\":0.5,\"strobeTime\":1e-6");
    mcv_sensor still = camera_with("");
    const double rate = 0.3, angle = rate * 0.5;
    camera.motion.rate = rate;
    camera.motion.axis[2] = 1;
    camera.motion.centre[0] = 0.01;
    camera.motion.velocity[1] = 0.004;
    /* Turned about (0.01, 0), then moved up by 2 mm. */
    const mcv_transform at =
        looking((const double[3]){0.01 - 0.01 * cos(angle), -0.01 * sin(angle) + 0.002, 0},
                (const double[3]){0, 0, -1}, (const double[3]){-sin(angle), cos(angle), 0});
    const edge truth = measure(false, &still, at, false);
    for (int reference = 0; reference < 2; ++reference) {
        const edge e = measure(reference, &camera, *here(), false);
        expect("turned camera, middle", e.middle, truth.middle, 0.05);
        expect("turned camera, columns per row", e.slope, truth.slope, 2e-3);
    }
    assert_true(fabs(truth.slope) > 0.1);
}

#define LINES_OF ",\"shutter\":\"line\",\"lineTime\":1e-4,"

static void test_refused(void **state) {
    static const struct {
        const char *json, *says;
    } cases[] = {
        {",\"shutter\":\"rolling\"", "cam/lineTime: is missing"},
        {",\"lineTime\":1e-3", "cam/lineTime: is of a \"rolling\" or \"line\" shutter"},
        {",\"stages\":4", "cam/stages: are of a \"line\" shutter"},
        {",\"shutter\":\"line\",\"lineTime\":1e-4,\"exposureTime\":1e-3", "is less than"},
        {",\"strobeTime\":1e-3", "cam/strobeTime: needs an exposureTime"},
        {",\"strobeDelay\":1e-3", "cam/strobeDelay: needs strobeTime"},
        {",\"exposureTime\":-1", "cam/exposureTime: -1 must lie"},
        {",\"encoderJitter\":1e-5", "cam/encoderJitter: is of a \"line\" shutter"},
        {",\"encoderRipple\":1e-5", "cam/encoderRipple: is of a \"line\" shutter"},
        {LINES_OF "\"encoderRipple\":1e-5", "cam/encoderPeriod: is missing"},
        {LINES_OF "\"encoderPeriod\":10", "cam/encoderPeriod: is that of an encoderRipple"},
        {LINES_OF "\"encoderSeed\":10", "cam/encoderSeed: is that of an encoderJitter"},
    };
    (void)state;
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        char text[512];
        mcv_sensor sensor;
        mcv_error error = {""};
        snprintf(text, sizeof text,
                 "{\"imageDistance\":\"20mm\",\"resolution\":4,\"pixelSize\":\"20um\"%s}",
                 cases[i].json);
        const mcv_result result = sensor_of(MCV_SENSOR_PINHOLE, text, &sensor, &error);
        if (result != MCV_BAD_INPUT || !strstr(error.text, cases[i].says))
            fail_msg("%s gave %d, \"%s\"; must say \"%s\"", cases[i].json, result, error.text,
                     cases[i].says);
    }
}

#define RIG(motion, sensor) \
    "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0,1]}]," \
    "\"extensionsUsed\":[\"MCVISI_sensors\",\"MCVISI_motion\"]," \
    "\"extensions\":{\"MCVISI_sensors\":{\"sensors\":[{\"type\":\"pinhole\"," \
    "\"imageDistance\":1,\"resolution\":4,\"pixelSize\":1e-5,\"exposureTime\":0.1}]}}," \
    "\"nodes\":[{\"extensions\":{" sensor "\"MCVISI_motion\":" motion "}},{\"extensions\":{" \
    "\"MCVISI_sensors\":{\"sensor\":0}}}]}"
#define HERE "\"MCVISI_sensors\":{\"sensor\":0},"

static void test_files(void **state) {
    mcv_scene *scene;
    mcv_error error;
    (void)state;
    if (load_text("motion.gltf", RIG("{\"velocity\":[1,2,3],\"axis\":[0,3,4],\"rate\":2}", HERE),
                  NULL, &scene, &error) != MCV_OK)
        fail_msg("%s", error.text);
    const mcv_node_motion *m = &scene->sensors[0].motion;
    assert_true(m->velocity[0] == 1 && m->velocity[2] == 3 && m->rate == 2);
    assert_true(fabs(m->axis[1] - 0.6) < 1e-15 && fabs(m->axis[2] - 0.8) < 1e-15);
    assert_true(mcv_needs_time(scene, &scene->sensors[0]));
    assert_false(mcv_needs_time(scene, &scene->sensors[1]));
    mcv_scene_free(scene);
    must_refuse("a.gltf", RIG("{\"rate\":2}", HERE), "MCVISI_motion/axis: is missing");
    must_refuse("b.gltf", RIG("{\"speed\":2}", HERE), "unknown key \"speed\"");
    must_refuse("c.gltf", RIG("{\"velocity\":[1,2]}", HERE), "velocity");
    must_refuse("e.gltf", RIG("3", HERE), "MCVISI_motion: must be an object");
}

#define SCANNER(type, more) \
    "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0]}]," \
    "\"extensionsUsed\":[\"MCVISI_sensors\"],\"extensions\":{\"MCVISI_sensors\":{\"sensors\":[{" \
    "\"type\":\"" type "\",\"focalLength\":0.02,\"focusDistance\":0.3,\"fNumber\":4," \
    "\"resolution\":[64,16],\"pixelSize\":1e-5" more "}]}}," \
    "\"nodes\":[{\"extensions\":{\"MCVISI_sensors\":{\"sensor\":0}}}]}"

/* A line-scan camera is a thin lens camera with that shutter; a rate is one over a time. */
static void test_line_scan(void **state) {
    mcv_scene *scenes[2];
    mcv_error error;
    (void)state;
    if (load_text("scan.gltf", SCANNER("lineScan", ",\"lineRate\":8000"), NULL, scenes, &error) ||
        load_text("lens.gltf",
                  SCANNER("thinLens", ",\"shutter\":\"line\",\"lineRate\":8000,\"lineTime\":"
                                      "1.25e-4"),
                  NULL, scenes + 1, &error))
        fail_msg("%s", error.text);
    assert_int_equal(scenes[0]->sensors[0].type, MCV_SENSOR_THIN_LENS);
    assert_memory_equal(&scenes[0]->sensors[0].as.thin_lens, &scenes[1]->sensors[0].as.thin_lens,
                        offsetof(mcv_thin_lens_params, end));
    for (int i = 0; i < 2; ++i) mcv_scene_free(scenes[i]);
    must_refuse("e.gltf", SCANNER("lineScan", ""), "lineTime: is missing");
    must_refuse("f.gltf", SCANNER("lineScan", ",\"shutter\":\"global\""), "must be \"line\"");
    must_refuse("g.gltf", SCANNER("lineScan", ",\"lineRate\":0"), "lineRate");
    must_refuse("h.gltf", SCANNER("lineScan", ",\"lineRate\":8000,\"lineTime\":1e-3"),
                "lineRate: 8000 Hz contradicts lineTime, 0.001 s");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_blur),
        cmocka_unit_test(test_rolling),
        cmocka_unit_test(test_lines),
        cmocka_unit_test(test_stages),
        cmocka_unit_test(test_encoder_statistics),
        cmocka_unit_test(test_encoder),
        cmocka_unit_test(test_turned),
        cmocka_unit_test(test_refused),
        cmocka_unit_test(test_files),
        cmocka_unit_test(test_line_scan),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
