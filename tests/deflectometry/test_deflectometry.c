/* SPDX-License-Identifier: Apache-2.0 */
/* Deflectometry of scenes, by the public interface: a mirror that is tilted, dented, rough, and
 * seen with noise; bad input. */
#include "found.h"

#include <math.h>

static const double ALIAS = 1.2e-5; /* see test_tilt_of_a_flat_mirror */

enum { WIDTH = 60, HEIGHT = 50, COUNT = WIDTH * HEIGHT };

/* A mirror in the plane of "table"; camera and screen 250 mm away, 25° to both sides. In the middle
 * the screen stands across the light. A pixel of the camera sees 0.6 mm of the mirror and 1.2 mm of
 * the screen, whose pixels are 0.25 mm wide. Periods are 8 mm across and 6.4 mm down. */
static mcv_rig *rig_of(const char *mirror, const char *material, const char *more) {
    char text[8192];
    const int length = snprintf(
        text, sizeof text,
        "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0,1,2,3]}],"
        "\"extensions\":{%s\"MCVISI_sensors\":{\"sensors\":[{\"name\":\"camera\",\"type\":"
        "\"pinhole\",\"imageDistance\":\"25mm\",\"resolution\":[60,50],\"pixelSize\":\"60um\"}]},"
        "\"MCVISI_emitters\":{\"emitters\":[{\"name\":\"screen\",\"type\":\"screen\","
        "\"pixelPitch\":\"0.25mm\",\"radiance\":100,\"pattern\":{\"type\":\"phaseShift\","
        "\"steps\":4,\"periods\":40,\"resolution\":[1280,1024]}}]}},"
        "\"materials\":[{\"name\":\"chrome\",\"extensions\":{\"MCVISI_materials\":{%s}}}],"
        "\"buffers\":[{\"byteLength\":60,\"uri\":\"data:application/octet-stream;base64,"
        "zczMvc3MzL0AAAAAzczMPc3MzL0AAAAAzczMPc3MzD0AAAAAzczMvc3MzD0AAAAAAAABAAIAAAACAAMA\"}],"
        "\"bufferViews\":[{\"buffer\":0,\"byteLength\":48},{\"buffer\":0,\"byteOffset\":48,"
        "\"byteLength\":12}],\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":4,"
        "\"type\":\"VEC3\",\"min\":[-0.1,-0.1,0],\"max\":[0.1,0.1,0]},{\"bufferView\":1,"
        "\"componentType\":5123,\"count\":6,\"type\":\"SCALAR\"}],"
        "\"meshes\":[{\"name\":\"plate\",\"primitives\":[{\"attributes\":{\"POSITION\":0},"
        "\"indices\":1,\"material\":0}]}],\"nodes\":[{\"name\":\"table\"},"
        "{\"name\":\"mirror\",\"mesh\":0,\"scale\":[0.3,0.3,1]%s},"
        "{\"name\":\"camera\",\"extensions\":{\"MCVISI_pose\":{\"target\":[0,0,0],\"distance\":"
        "\"250mm\",\"azimuth\":\"-25deg\"},\"MCVISI_sensors\":{\"sensor\":0}}},"
        "{\"name\":\"screen\",\"extensions\":{\"MCVISI_pose\":{\"target\":[0,0,0],\"distance\":"
        "\"250mm\",\"azimuth\":\"25deg\"},\"MCVISI_emitters\":{\"emitter\":0}}}]}",
        more, material, mirror);
    assert_true(length < (int)sizeof text);
    return parse_rig(text);
}

#define MIRROR "\"type\":\"mirror\""

/*
 * A mirror tilted by 10 mrad about y has the slope -tan(10 mrad) across, none down, and the heights
 * of that plane. The screen shows steps of its pixels p: the fringe's aliases about 1/p are p/P of
 * it, and seen over w = 1.2 mm they bend its phase by 2 p/P/(π w/p) at most: places by p²/(π² w) =
 * 5.3 µm, slopes over 0.5 m (cos 25° across the plane of incidence) by 1.2e-5. Over 60 pixels this
 * is periodic: a twentieth of it is left in the mean. Slopes of the scene are known to float32:
 * 1e-7.
 */
static void test_tilt_of_a_flat_mirror(void **state) {
    (void)state;
    const double angle = 0.01;
    char turned[128];
    mcv_session *session = open_session(NULL);
    snprintf(turned, sizeof turned, ",\"rotation\":[0,%.17g,0,%.17g]", sin(angle / 2),
             cos(angle / 2));
    for (int tilted = 0; tilted < 2; ++tilted) {
        mcv_rig *rig = rig_of(tilted ? turned : "", MIRROR, "");
        found f = find(session, rig, "{\"plane\": \"table\", \"spp\": 1024}");
        const double slope = tilted ? -tan(angle) : 0;
        const float *z = map_of(&f, "image", 1), *place = map_of(&f, "place", 2),
                    *p = map_of(&f, "slope", 2);
        const double u = told(&f, NULL, "slope_uncertainty_x"),
                     v = told(&f, NULL, "slope_uncertainty_y");
        print_message("tilt %.9f %.9f, expected %.9f 0\n", told(&f, NULL, "tilt_x"),
                      told(&f, NULL, "tilt_y"), slope);
        assert_float_equal(told(&f, NULL, "tilt_x"), slope, 6e-7);
        assert_float_equal(told(&f, NULL, "tilt_y"), 0, 6e-7);
        assert_float_equal(told(&f, NULL, "pixels"), COUNT, 0);
        for (int i = 0; i < COUNT; ++i) {
            /* Of 6000 normal errors 5 deviations are not passed; pixels differ little. */
            assert_float_equal(p[i], slope, ALIAS + 5 * u);
            assert_float_equal(p[COUNT + i], 0, ALIAS + 5 * v);
            /* The plane through the origin; 30 mm times the tilt's error, and 1.2e-5 over 3 mm of a
             * period of the alias, by 2π. */
            assert_float_equal(z[i], slope * place[i], 0.03 * 6e-7 + 6e-9 + 5e-9);
        }
        drop(&f);
        mcv_rig_free(rig);
    }
    mcv_session_close(session);
}

/*
 * A dent of 1 µm, s = 2 mm: slopes are -h' with 0.6065 d/s = 3.03e-4 at r = s, and the place on the
 * screen moves by twice as much times 250 mm. The mesh has slopes within 1 % of the largest one
 * (docs/elements/defects), a pixel of w = 0.7 mm takes w²/(12 s²) = 1 % from it, and the sampling
 * by 0.7 mm may miss it by 1.5 %. Errors of slopes as above.
 */
static void test_dent_of_a_micrometre(void **state) {
    (void)state;
    const double d = 1e-6, s = 2e-3, largest = 0.60653066 * d / s;
    mcv_session *session = open_session(NULL);
    mcv_rig *flat = rig_of("", MIRROR, ""),
            *dented = rig_of("", MIRROR,
                             "\"MCVISI_defects\":{\"defects\":[{\"name\":\"dent\",\"type\":"
                             "\"dent\",\"node\":\"mirror\",\"at\":[0.002,0.001,0],\"size\":"
                             "\"8mm\",\"depth\":\"1um\"}]},");
    found a = find(session, flat, "{\"plane\": \"table\", \"spp\": 1024}"),
          b = find(session, dented,
                   "{\"plane\": \"table\", \"spp\": 1024, \"remove-form\": \"plane\"}");
    const float *place = map_of(&b, "place", 2), *p = map_of(&b, "slope", 2),
                *before = map_of(&a, "screen", 2), *after = map_of(&b, "screen", 2),
                *z = map_of(&b, "image", 1);
    const double u = told(&b, NULL, "slope_uncertainty_x"),
                 v = told(&b, NULL, "slope_uncertainty_y");
    double most = 0, moved = 0, lowest = 0;
    for (int i = 0; i < COUNT; ++i) {
        const double x = place[i] - 0.002, y = place[COUNT + i] - 0.001,
                     h = d / (s * s) * exp(-(x * x + y * y) / (2 * s * s));
        assert_float_equal(p[i], h * x, 0.03 * largest + ALIAS + 5 * u);
        assert_float_equal(p[COUNT + i], h * y, 0.03 * largest + ALIAS + 5 * v);
        most = fmax(most, fabs((double)p[i]));
        moved = fmax(moved, fabs((double)after[i] - (double)before[i]) * 0.25e-3);
        lowest = fmin(lowest, (double)z[i]);
    }
    print_message("largest slope %.4f of 0.6065 d/s, shift %.4f of 2 · 250 mm times it, depth "
                  "%.1f nm\n",
                  most / largest, moved / (0.5 * largest), -lowest * 1e9);
    const double errors = (ALIAS + 5 * u) / largest;
    assert_float_equal(most / largest, 1, 0.035 + errors);
    /* Both maps have errors. */
    assert_float_equal(moved / (0.5 * largest), 1, 0.035 + 2 * errors);
    /* The middle is missed by up to half a pixel, 1.5 %; a pixel takes w²/(12 s²) = 1 %; the plane
     * takes 2π s² of 40 mm x 30 mm, 2 %; and errors as of the flat mirror. */
    assert_float_equal(-lowest, d, 0.045 * d + 3e-8);
    drop(&a);
    drop(&b);
    mcv_rig_free(flat);
    mcv_rig_free(dented);
    mcv_session_close(session);
}

/*
 * Slopes of a GGX surface of width α have the density α²/(π (α² + s²)²), whose characteristic
 * function is kα K1(kα). A slope s moves the place on the screen by 2 d s in the plane of incidence
 * and by 2 d s cos 25° across it: with k = 4π d/period the contrast falls by that. d = 250 mm holds
 * in the middle; it changes by 4 % to both sides, which takes the square of it. The contrast's
 * error is that of 3000 pixels, 0.2 %. 1 % in all.
 */
static void test_rough_mirrors_lose_contrast(void **state) {
    (void)state;
    static const char *const groups[] = {"across_columns", "across_rows"};
    const double alpha = 0.002;
    char rough[96];
    mcv_session *session = open_session(NULL);
    snprintf(rough, sizeof rough,
             "\"type\":\"conductor\",\"metal\":\"aluminium\",\"roughness\":%.17g", sqrt(alpha));
    mcv_rig *rigs[] = {rig_of("", MIRROR, ""), rig_of("", rough, "")};
    found a = find(session, rigs[0], "{\"plane\": \"table\", \"spp\": 1024}"),
          b = find(session, rigs[1], "{\"plane\": \"table\", \"spp\": 1024}");
    for (int i = 0; i < 2; ++i) {
        const double lever = 0.5 * (i == 0 ? 1 : cos(25 * M_PI / 180)),
                     k = 2 * M_PI * lever / (i == 0 ? 8e-3 : 6.4e-3),
                     expected = k * alpha * bessel_k1(k * alpha),
                     seen = told(&b, groups[i], "contrast") / told(&a, groups[i], "contrast");
        print_message("%s: contrast falls by %.4f, expected %.4f\n", groups[i], seen, expected);
        assert_float_equal(seen, expected, 0.01);
        /* The sharp mirror: a pixel sees 1.2 mm, and is best with twice that. */
        assert_float_equal(told(&a, groups[i], "best_period"), 2.4e-3, 0.1e-3);
    }
    drop(&a);
    drop(&b);
    mcv_rig_free(rigs[0]);
    mcv_rig_free(rigs[1]);
    mcv_session_close(session);
}

/*
 * Noise of the camera: the errors of slopes are what is stated. Of 3000 pixels the deviation has
 * the standard error 1.3 %; the render adds its own to the stated one, with errors of 4 replicates:
 * 5 %. Heights have few degrees of freedom, as errors of slopes add up over the whole map: a factor
 * of 2. Gray codes bear this noise; with twice as much
 * the beat errs, and says how often.
 */
static void test_noise_is_stated(void **state) {
    (void)state;
    mcv_session *session = open_session(NULL);
    mcv_rig *rig = rig_of("", MIRROR, "");
    found f = find(session, rig,
                   "{\"plane\": \"table\", \"spp\": 256, \"noise\": 1, \"unwrap\": \"gray\"}");
    const float *p = map_of(&f, "slope", 2), *u = map_of(&f, "slope error", 2);
    for (int way = 0; way < 2; ++way) {
        double sum = 0, stated = 0;
        for (int i = way * COUNT; i < (way + 1) * COUNT; ++i) {
            sum += (double)p[i] * (double)p[i];
            stated += (double)u[i] * (double)u[i];
        }
        print_message("deviation of slopes over stated: %.4f\n", sqrt(sum / stated));
        assert_float_equal(sqrt(sum / stated), 1, 0.05 + 0.013 * 3);
    }
    /* B = 1/2 · 100 · contrast · the pixel's share; A = 50. */
    const double expected = sqrt(2.0 / 4) / (50 * told(&f, "across_columns", "contrast"));
    assert_float_equal(told(&f, "across_columns", "phase_noise") / expected, 1, 0.03);
    const double heights = told(&f, NULL, "height_rms") / told(&f, NULL, "height_uncertainty");
    print_message("deviation of heights over stated: %.3f\n", heights);
    assert_true(heights > 0.5 && heights < 2.5);
    drop(&f);
    /* 6 % of 3000 pixels: 8 % of deviation. */
    f = find(session, rig, "{\"plane\": \"table\", \"spp\": 256, \"noise\": 2}");
    found quiet = find(session, rig, "{\"plane\": \"table\", \"spp\": 256}");
    const float *noisy = map_of(&f, "screen", 2), *right = map_of(&quiet, "screen", 2);
    const double share = told(&f, "across_columns", "expected_period_errors");
    double wrong = 0;
    for (int i = 0; i < COUNT; ++i) wrong += fabs((double)noisy[i] - (double)right[i]) > 16;
    print_message("wrong periods: %.4f, expected %.4f\n", wrong / COUNT, share);
    assert_float_equal(wrong / COUNT / share, 1, 0.25);
    /* Without a camera's noise the render's own is stated, and the alias is all that is beyond it.
     */
    const double own = told(&quiet, NULL, "slope_uncertainty_x");
    double squares = 0;
    for (int i = 0; i < COUNT; ++i)
        squares += pow((double)map_of(&quiet, "slope", 2)[i], 2) / COUNT;
    print_message("slopes by the render's noise: %.3g, stated %.3g\n", sqrt(squares), own);
    assert_true(own > 0 && sqrt(squares) <= ALIAS + 1.2 * own);
    drop(&f);
    drop(&quiet);
    mcv_rig_free(rig);
    mcv_session_close(session);
}

static void test_bad_input(void **state) {
    (void)state;
    static const struct {
        const char *options, *says;
        mcv_result code;
    } cases[] = {
        {"{}", "--plane is missing", MCV_USAGE},
        {"{\"plane\": \"tabel\"}", "tabel", MCV_USAGE},
        {"{\"plane\": \"table\", \"screen\": \"lamp\"}", "has no screen of this name", MCV_USAGE},
        {"{\"plane\": \"table\", \"output\": \"a.png\"}", "must end in .exr", MCV_USAGE},
        {"{\"plane\": \"table\", \"set\": [\"emitters/screen/pattern/periods=1\"]}",
         "at least 2 are needed", MCV_BAD_INPUT},
        {"{\"plane\": \"table\", \"set\": [\"nodes/screen/azimuth=120deg\"], \"spp\": 16}",
         "no pixel of sensor \"camera\" sees fringes", MCV_BAD_INPUT},
    };
    mcv_session *session = open_session(NULL);
    mcv_rig *rig = rig_of("", MIRROR, ""), *sky = parse_rig(sky_rig);
    mcv_picture *picture = NULL;
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        FAILS(cases[i].code, cases[i].says,
              mcv_session_deflectometry(session, rig, cases[i].options, NULL, NULL, &picture, NULL,
                                        &error));
        assert_null(picture);
    }
    FAILS(MCV_BAD_INPUT, "has no emitter of the type screen",
          mcv_session_deflectometry(session, sky, "{\"plane\": \"camera\"}", NULL, NULL, &picture,
                                    NULL, &error));
    mcv_rig_free(rig);
    mcv_rig_free(sky);
    mcv_session_close(session);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_tilt_of_a_flat_mirror),
        cmocka_unit_test(test_dent_of_a_micrometre),
        cmocka_unit_test(test_rough_mirrors_lose_contrast),
        cmocka_unit_test(test_noise_is_stated),
        cmocka_unit_test(test_bad_input),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
