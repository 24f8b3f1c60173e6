/* SPDX-License-Identifier: Apache-2.0 */
/* The telecentric projector: which pixel shines where, how much, and what is refused. */
#include "image_emitters.h"

#include "scene/emitters.h"

enum { WIDTH = 6, HEIGHT = 4 };

#define NAMED "\"type\":\"telecentricProjector\",\"size\":[\"6mm\",\"4mm\"],"
#define CAMERA \
    "\"type\":\"telecentric\",\"magnification\":1,\"workingDistance\":\"0.1m\"," \
    "\"numericalAperture\":0.02," \
    "\"resolution\":[6,4],\"pixelSize\":\"1mm\""

/*
 * A telecentric camera of scale 1 in focus on the projector, pixel on pixel: each sees one pixel of
 * the image, whose cone holds the camera's. The camera's right is the projector's left: it sees the
 * image mirrored, and unmirrored with "mirror". A sample within rounding (1e-7 of the field) of a
 * pixel's edge may show the neighbour; none of these fixed 6144 does. Beyond that the device
 * multiplies some 4 numbers of float32 and adds 256 up exactly enough: 1e-6.
 */
static void expect_pixels(bool reference, const char *rig, bool mirror, const char *text) {
    mcv_scene *scene;
    BUILD(load_text("projector.gltf", text, NULL, &scene, &builder_error));
    mcv_film film = render_by(reference, scene, 0, 16, 1);
    mcv_image mean, error;
    BUILD(mcv_film_develop(&film, &mean, &error, &builder_error));
    assert_int_equal(mean.channels, 3);
    for (uint32_t row = 0; row < HEIGHT; ++row) {
        for (uint32_t column = 0; column < WIDTH; ++column) {
            uint8_t rgb[3];
            value_of(WIDTH, HEIGHT, mirror ? column : WIDTH - 1 - column, row, rgb);
            for (uint32_t k = 0; k < 3; ++k) {
                const double expected = 2 * linear(rgb[k]),
                             seen = mean.pixels[(k * HEIGHT + row) * WIDTH + column];
                if (!(fabs(seen - expected) <= 1e-6 * expected))
                    fail_msg(
                        "%s, rig {%s}, mirror %d: pixel (%u, %u) channel %u is %.9g, expected %.9g",
                        reference ? "reference" : "device", rig, mirror, column, row, k, seen,
                        expected);
            }
        }
    }
    mcv_image_free(&mean);
    mcv_image_free(&error);
    mcv_film_free(&film);
    mcv_scene_free(scene);
}

static void test_each_pixel_is_where_it_belongs(void **state) {
    (void)state;
    write_png("projector.png", WIDTH, HEIGHT);
    for (int i = 0; i < 8; ++i) {
        const bool mirror = i & 1, reference = i & 2;
        const char *rig = rigs[i >> 2];
        char *emitter =
            text_of(NAMED "\"image\":%s,\"mirror\":%s,\"halfAngle\":\"3deg\",\"radiance\":2",
                    mirror ? "0" : "\"picture\"", mirror ? "true" : "false");
        char *text = rig_text(rig, emitter, CAMERA, 0.1, "projector.png");
        expect_pixels(reference, rig, mirror, text);
        free(text);
        free(emitter);
    }
}

/* The same values from an OpenEXR file, which holds them as they are (rounded to float32: 6e-8). */
static void test_openexr_is_linear(void **state) {
    (void)state;
    mcv_image image;
    BUILD(mcv_image_new(&image, WIDTH, HEIGHT, 3, &builder_error));
    for (uint32_t i = 0; i < WIDTH * HEIGHT; ++i) {
        uint8_t rgb[3];
        value_of(WIDTH, HEIGHT, i % WIDTH, i / WIDTH, rgb);
        for (uint32_t k = 0; k < 3; ++k)
            image.pixels[k * WIDTH * HEIGHT + i] =
                (float)(4 * linear(rgb[k])); /* above 1, as EXR can be */
    }
    const mcv_exr_part part = {.name = "part", .image = image};
    BUILD(mcv_exr_write(MCV_BINARY_DIR "/tests/projector.exr", &part, 1, NULL, 0, &builder_error));
    char *text = rig_text(
        "", NAMED "\"image\":{\"uri\":\"projector.exr\"},\"halfAngle\":\"3deg\",\"radiance\":0.5",
        CAMERA, 0.1, "projector.png");
    expect_pixels(false, "", false, text);
    expect_pixels(true, "", false, text);
    free(text);

    image.pixels[WIDTH * HEIGHT + 7] = NAN;
    BUILD(mcv_exr_write(MCV_BINARY_DIR "/tests/projector_nan.exr", &part, 1, NULL, 0,
                        &builder_error));
    static const bad_emitter cases[] = {
        {NAMED "\"image\":{\"uri\":\"projector_nan.exr\"},\"halfAngle\":1,\"radiance\":1",
         "emitters/e/image: \"projector_nan.exr\" has the value nan in column 1, row 1"},
        {NAMED "\"image\":{\"uri\":\"projector_nan.exr\"},\"halfAngle\":1,\"radiance\":1",
         "has the value -1 in column 1, row 1"}};
    refuse_emitters(&cases[0], 1, "projector.png");
    image.pixels[WIDTH * HEIGHT + 7] = -1;
    BUILD(mcv_exr_write(MCV_BINARY_DIR "/tests/projector_nan.exr", &part, 1, NULL, 0,
                        &builder_error));
    refuse_emitters(&cases[1], 1, "projector.png");
    mcv_image_free(&image);
}

/* Rays outside the cone see nothing: a camera tilted by a little more than β + its own half-angle
 * is black, by a little less it is not. */
static void test_the_cone_ends(void **state) {
    (void)state;
    static const struct {
        double tilt;
        bool lit;
    } cases[] = {{0.0499, true}, {0.0501, false}};
    for (int i = 0; i < 4; ++i) {
        const double tilt = cases[i / 2].tilt;
        mcv_scene *scene;
        char *text = rig_text("", NAMED "\"image\":0,\"halfAngle\":0.05,\"radiance\":1", CAMERA,
                              0.1, "projector.png");
        BUILD(load_text("projector.gltf", text, NULL, &scene, &builder_error));
        mcv_sensor camera = sensor_defaults(MCV_SENSOR_TELECENTRIC);
        camera.as.telecentric.magnification = 1;
        camera.as.telecentric.workingDistance = 0.1;
        camera.as.telecentric.numericalAperture =
            1e-6; /* rad, far below the 1e-4 that the tilts differ from β */
        camera.as.telecentric.resolution[0] = camera.as.telecentric.resolution[1] = 1;
        camera.as.telecentric.pixelSize[0] = camera.as.telecentric.pixelSize[1] = 1e-3;
        add_sensor(scene, MCV_SENSOR_TELECENTRIC, &camera,
                   looking((const double[]){0.1 * sin(tilt), 0, -0.1 * cos(tilt)},
                           (const double[]){-sin(tilt), 0, cos(tilt)}, (const double[]){0, 1, 0}));
        mcv_film film = render_by(i & 1, scene, 1, 4, 1);
        if ((mcv_film_mean(&film) > 0) != cases[i / 2].lit)
            fail_msg("%s: at %g rad the mean is %g", i & 1 ? "reference" : "device", tilt,
                     mcv_film_mean(&film));
        mcv_film_free(&film);
        mcv_scene_free(scene);
        free(text);
    }
}

/*
 * Next-event estimation samples the wide cone by area, the narrow one as a cone: it is the smaller
 * solid angle below β = √(A/π)/d = 0.014. Chance finds that one seldom, with a share of at most
 * sin²β = 2.5e-5 of the light by any heuristic.
 */
static void test_power_arrives(void **state) {
    (void)state;
    static const double half_angles[] = {0.2, 0.005}, power[3] = {1, 2, 0.25};
    for (int i = 0; i < 2; ++i) {
        char what[64];
        char *emitter =
            text_of(NAMED "\"image\":0,\"halfAngle\":%g,\"power\":[1,2,0.25]", half_angles[i]);
        char *text = rig_text("", emitter, CAMERA, 0.1, "projector.png");
        snprintf(what, sizeof what, "projector, cone of %g rad", half_angles[i]);
        expect_power(text, power, i == 0 ? 0.14 : 0.012, i == 0 ? 0 : 2.5e-5,
                     what); /* spots of 89 mm and 8 mm */
        free(text);
        free(emitter);
    }
}

/* A baseline JPEG of one channel and two flat blocks, 200 and 80: differences of DC 72 and -120 at
 * a step of 8, and no AC. */
static char *write_jpeg(const char *name) {
    enum { STEPS = 64 };
    static const uint8_t head[] = {0xff, 0xd8, 0xff, 0xdb, 0, 67, 0};
    static const uint8_t tail[] = {
        0xff, 0xc0, 0, 11, 8,    0, 8, 0, 16, 1, 1,    0x11, 0, /* 16 x 8 */
        0xff, 0xc4, 0, 21, 0,    0, 2, 0, 0,  0, 0,    0,    0,    0,    0,   0,
        0,    0,    0, 0,  0,    7, 8, /* DC: 00 is 7 bits, 01 is 8 bits */
        0xff, 0xc4, 0, 20, 0x10, 1, 0, 0, 0,  0, 0,    0,    0,    0,    0,   0,
        0,    0,    0, 0,  0,    0, /* AC: 0 is the end */
        0xff, 0xda, 0, 8,  1,    1, 0, 0, 63, 0, 0x24, 0x00, 0xef, 0xff, 0xd9}; /* 00 1001000 0, 00
                                                                                   0000111 0 */
    uint8_t bytes[sizeof head + STEPS + sizeof tail];
    memcpy(bytes, head, sizeof head);
    memset(bytes + sizeof head, 8, STEPS);
    memcpy(bytes + sizeof head + STEPS, tail, sizeof tail);
    return write_bytes(name, bytes, sizeof bytes);
}

/* Its values count as sRGB; a flat block is decoded exactly. */
static void test_jpeg_is_srgb(void **state) {
    (void)state;
    mcv_scene *scene;
    double mean[3];
    free(write_jpeg("projector.jpg"));
    char *text = rig_text("", NAMED "\"image\":0,\"halfAngle\":0.1,\"radiance\":2", CAMERA, 0.1,
                          "projector.jpg");
    BUILD(load_text("projector_jpeg.gltf", text, NULL, &scene, &builder_error));
    const mcv_texture *image = scene->textures + scene->emitters[0].texture;
    assert_int_equal(image->width, 16);
    assert_int_equal(image->height, 8);
    for (uint32_t i = 0; i < 16 * 8; ++i)
        for (uint32_t k = 0; k < 3; ++k)
            assert_int_equal(image->rgba[4 * i + k], i % 16 < 8 ? 200 : 80);
    mcv_emitter_image_mean(scene, scene->emitters, mean);
    const double expected = (linear(200) + linear(80)) / 2;
    if (!(fabs(mean[0] - expected) <= 1e-14))
        fail_msg("mean %.17g, must be %.17g", mean[0], expected);
    mcv_scene_free(scene);
    free(text);
}

static void test_bad_input(void **state) {
    (void)state;
    static const bad_emitter cases[] = {
        {NAMED "\"halfAngle\":0.1,\"radiance\":1", "emitters/e/image: is missing"},
        {NAMED "\"image\":1,\"halfAngle\":0.1,\"radiance\":1", "emitters/e/image: "},
        {NAMED "\"image\":-1,\"halfAngle\":0.1,\"radiance\":1", "emitters/e/image: "},
        {NAMED "\"image\":0.5,\"halfAngle\":0.1,\"radiance\":1",
         "emitters/e/image: must be the index or the name"},
        {NAMED "\"image\":\"pictur\",\"halfAngle\":0.1,\"radiance\":1",
         "emitters/e/image: there is no image \"pictur\": did you mean "
         "\"picture\"?"},
        {NAMED "\"image\":{},\"halfAngle\":0.1,\"radiance\":1",
         "emitters/e/image: must have the \"uri\""},
        {NAMED "\"image\":{\"uri\":\"none.exr\"},\"halfAngle\":0.1,\"radiance\":1",
         "emitters/e/image: \"none.exr\" "},
        {NAMED "\"image\":{\"uri\":\"../x.exr\"},\"halfAngle\":0.1,\"radiance\":1",
         "emitters/e/image: \"../x.exr\" leads out"},
        {NAMED "\"image\":{\"uri\":\"projector.png\"},\"halfAngle\":0.1,\"radiance\":1",
         "emitters/e/image: \"projector.png\" cannot be read as an image"},
        {NAMED "\"image\":0,\"halfAngle\":\"91deg\",\"radiance\":1", "emitters/e/halfAngle: "},
        {NAMED "\"image\":0,\"halfAngle\":0,\"radiance\":1",
         "emitters/e/halfAngle: 0 is a collimated beam"},
        {NAMED "\"image\":0,\"halfAngle\":0.1", "emitters/e: needs radiance"},
        {NAMED "\"image\":0,\"halfAngle\":0.1,\"radiance\":1,\"mirror\":1",
         "emitters/e/mirror: must be true or false"},
        {"\"type\":\"telecentricProjector\",\"image\":0,\"halfAngle\":0.1,\"radiance\":1",
         "emitters/e/size: is missing"},
    };
    refuse_emitters(cases, sizeof cases / sizeof cases[0], "projector.png");
    refuse_images(NAMED "\"halfAngle\":0.1,\"radiance\":1,", WIDTH, HEIGHT);
    /* Black: no radiance gives it power. */
    mcv_image black;
    BUILD(mcv_image_new(&black, 2, 2, 1, &builder_error));
    BUILD(mcv_png_write_values(MCV_BINARY_DIR "/tests/projector_black.png", &black, 8,
                               &builder_error));
    mcv_image_free(&black);
    refuse_emitters(&(bad_emitter){NAMED "\"image\":0,\"halfAngle\":0.1,\"power\":1",
                                   "its image is black in channel R"},
                    1, "projector_black.png");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_each_pixel_is_where_it_belongs),
        cmocka_unit_test(test_openexr_is_linear),
        cmocka_unit_test(test_jpeg_is_srgb),
        cmocka_unit_test(test_the_cone_ends),
        cmocka_unit_test(test_power_arrives),
        cmocka_unit_test(test_bad_input),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
