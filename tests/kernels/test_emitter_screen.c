/* SPDX-License-Identifier: Apache-2.0 */
/* The screen: where its pixels and the gaps between them lie, what they send into which direction,
 * its power, its shape, and what is refused. */
#include "image_emitters.h"

#include "scene/emitters.h"

enum { WIDTH = 6, HEIGHT = 4, PARTS = 10 };

#define NAMED "\"type\":\"screen\",\"pixelPitch\":\"1mm\","
#define TENTHS \
    "\"type\":\"telecentric\",\"magnification\":1,\"workingDistance\":\"0.1m\"," \
    "\"numericalAperture\":1e-5,\"resolution\":[60,40],\"pixelSize\":\"0.1mm\""

/*
 * A telecentric camera of scale 1 in focus on the screen sees a tenth of a pixel's width in each of
 * its own, upright. The lit part of a pixel begins within the second tenth across and within the
 * third one down, which are left out: power says whether it begins in the right place. The device
 * rounds v^γ to float32 and multiplies some 4 numbers: 1e-6; 1e-5 rad off the normal are nothing.
 */
static void expect_tenths(bool reference, const char *rig) {
    mcv_scene *scene;
    mcv_image mean, error;
    char *text = rig_text(rig,
                          NAMED "\"image\":0,\"pixelGap\":[\"0.25mm\",\"0.45mm\"],\"gamma\":1.7,"
                                "\"falloffExponent\":3,\"radiance\":2",
                          TENTHS, 0.1, "screen.png");
    BUILD(load_text("screen.gltf", text, NULL, &scene, &builder_error));
    mcv_film film = render_by(reference, scene, 0, 4, 1);
    BUILD(mcv_film_develop(&film, &mean, &error, &builder_error));
    for (uint32_t y = 0; y < HEIGHT * PARTS; ++y)
        for (uint32_t x = 0; x < WIDTH * PARTS; ++x) {
            const uint32_t across = x % PARTS < 5 ? x % PARTS : PARTS - 1 - x % PARTS,
                           down = y % PARTS < 5 ? y % PARTS : PARTS - 1 - y % PARTS;
            uint8_t rgb[3];
            if (across == 1 || down == 2) continue;
            value_of(WIDTH, HEIGHT, x / PARTS, y / PARTS, rgb);
            for (uint32_t k = 0; k < 3; ++k) {
                const double lit = across > 0 && down > 1 ? 1 : 0,
                             expected = lit * 2 * pow(linear(rgb[k]), 1.7),
                             seen = mean.pixels[(k * mean.height + y) * mean.width + x];
                if (!(fabs(seen - expected) <= 1e-6 * expected))
                    fail_msg("%s: (%u, %u) channel %u is %.9g, expected %.9g",
                             reference ? "reference" : "device", x, y, k, seen, expected);
            }
        }
    mcv_image_free(&mean);
    mcv_image_free(&error);
    mcv_film_free(&film);
    mcv_scene_free(scene);
    free(text);
}

static void test_pixels_and_gaps_lie_where_they_belong(void **state) {
    (void)state;
    write_png("screen.png", WIDTH, HEIGHT);
    for (int i = 0; i < 4; ++i) expect_tenths(i & 1, rigs[i >> 1]);
}

/* L cos^n θ: a camera of one ray (aperture 1e-6 rad) tilted about the middle of a lit pixel. The
 * logarithm and the exponential of the device have errors of 4e-7 x ln(2^n) and 3e-7. */
static void test_radiance_falls_with_the_angle(void **state) {
    (void)state;
    static const double exponents[] = {0, 1, 3.5}, angles[] = {0, M_PI / 6, M_PI / 3, 1.4};
    for (int i = 0; i < 24; ++i) {
        const double n = exponents[i / 2 % 3], a = angles[i / 6];
        mcv_scene *scene;
        char *emitter = text_of(NAMED "\"pattern\":{\"type\":\"grayCode\",\"resolution\":[1,1]},"
                                      "\"index\":1,\"falloffExponent\":%g,\"radiance\":3",
                                n),
             *text = rig_text("", emitter, ONE_PIXEL, 0.1, "screen.png");
        BUILD(load_text("screen_angle.gltf", text, NULL, &scene, &builder_error));
        mcv_sensor camera = sensor_defaults(MCV_SENSOR_TELECENTRIC);
        camera.as.telecentric.magnification = 1;
        camera.as.telecentric.workingDistance = 0.1;
        camera.as.telecentric.numericalAperture = 1e-6;
        camera.as.telecentric.resolution[0] = camera.as.telecentric.resolution[1] = 1;
        camera.as.telecentric.pixelSize[0] = camera.as.telecentric.pixelSize[1] = 1e-6;
        add_sensor(scene, MCV_SENSOR_TELECENTRIC, &camera,
                   looking((const double[]){0.1 * sin(a), 0, -0.1 * cos(a)},
                           (const double[]){-sin(a), 0, cos(a)}, (const double[]){0, 1, 0}));
        mcv_film film = render_by(i & 1, scene, 1, 1, 1);
        const double expected = 3 * pow(cos(a), n), seen = mcv_film_mean(&film);
        if (!(fabs(seen - expected) <= 5e-6 * expected))
            fail_msg("%s: n %g at %g rad: %.9g, expected %.9g", i & 1 ? "reference" : "device", n,
                     a, seen, expected);
        mcv_film_free(&film);
        mcv_scene_free(scene);
        free(emitter);
        free(text);
    }
}

/* A lobe so narrow (n = 20) that the picture of the floor, 0.6 m wide, misses cos²²56° = 3e-6 of
 * the power at most. Light that meets the screen again is absorbed. */
static void test_power_arrives(void **state) {
    (void)state;
    static const char *const shapes[] = {"", ",\"sag\":[\"0.2mm\",\"-0.1mm\"],\"twist\":\"0.1mm\","
                                             "\"fourth\":[\"0.1mm\",0]"};
    static const double power[3] = {1, 2, 0.25};
    for (int i = 0; i < 2; ++i) {
        char *emitter = text_of(NAMED "\"image\":0,\"falloffExponent\":20,\"pixelGap\":\"0.1mm\","
                                      "\"gamma\":0.9,\"power\":[1,2,0.25]%s",
                                shapes[i]),
             *text = rig_text("", emitter, TENTHS, 0.1, "screen.png");
        write_png("screen.png", WIDTH, HEIGHT);
        expect_power(text, power, 0.6, 3e-6, i ? "bent screen" : "flat screen");
        free(emitter);
        free(text);
    }
}

/* The vertices of a bent screen lie on the polynomial, rounded to float32, on the side that emits;
 * pixel (0, 0) is at the node's +x, +y. */
static void test_screen_bends(void **state) {
    (void)state;
    mcv_scene *scene;
    char *text = rig_text("",
                          NAMED "\"image\":0,\"radiance\":1,\"sag\":[\"0.3mm\",\"0.2mm\"],"
                                "\"twist\":\"-0.1mm\",\"fourth\":[0,\"0.05mm\"]",
                          TENTHS, 0.1, "screen.png");
    write_png("screen.png", WIDTH, HEIGHT);
    BUILD(load_text("screen_bent.gltf", text, NULL, &scene, &builder_error));
    const mcv_mesh *mesh = scene->meshes + scene->instances[scene->emitters[0].instance].mesh;
    assert_true(mesh->vertex_count > 1000);
    for (uint32_t i = 0; i < mesh->vertex_count; ++i) {
        const float *p = mesh->positions + 3 * (size_t)i, *uv = mesh->texcoords + 2 * (size_t)i;
        const double x = (double)p[0] / 3e-3, y = (double)p[1] / 2e-3;
        const double rise = 3e-4 * x * x + 2e-4 * y * y - 1e-4 * x * y + 5e-5 * y * y * y * y;
        assert_float_equal(p[2], -rise, 1e-9);
        assert_float_equal(uv[0], (1 - x) / 2, 1e-6);
        assert_float_equal(uv[1], (1 - y) / 2, 1e-6);
    }
    mcv_scene_free(scene);
    free(text);
}

static void test_bad_screens_are_refused(void **state) {
    (void)state;
    static const bad_emitter cases[] = {
        {NAMED "\"radiance\":1", "emitters/e/image: is missing"},
        {"\"type\":\"screen\",\"image\":0,\"radiance\":1", "emitters/e/pixelPitch: is missing"},
        {NAMED "\"image\":0,\"radiance\":1,\"pixelGap\":\"1mm\"",
         "emitters/e/pixelGap: 0.001 m must be below pixelPitch 0.001 m"},
        {NAMED "\"image\":0,\"radiance\":1,\"gamma\":0",
         "emitters/e/gamma: 0 must lie from 0.1 to"},
        {NAMED "\"image\":0,\"radiance\":1,\"falloffExponent\":-1", "emitters/e/falloffExponent"},
        {NAMED "\"image\":0,\"radiance\":1,\"size\":1", "size"},
        {NAMED "\"image\":0", "needs radiance"},
    };
    write_png("screen.png", WIDTH, HEIGHT);
    refuse_emitters(cases, sizeof cases / sizeof cases[0], "screen.png");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_pixels_and_gaps_lie_where_they_belong),
        cmocka_unit_test(test_radiance_falls_with_the_angle),
        cmocka_unit_test(test_power_arrives),
        cmocka_unit_test(test_screen_bends),
        cmocka_unit_test(test_bad_screens_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
