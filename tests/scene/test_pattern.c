/* SPDX-License-Identifier: Apache-2.0 */
/* Sequences of patterns: decoded from rendered images to the projector's columns and rows; Gray
 * code; what is refused. */
#include "image_emitters.h"

#include "scene/pattern.h"

enum { WIDTH = 44, HEIGHT = 20, PIXELS = WIDTH * HEIGHT };

/* A camera of scale 1 in focus on the projector, pixel on pixel; "mirror" turns the left that faces
 * it into the right again. */
#define EMITTER(pattern) \
    "\"type\":\"telecentricProjector\",\"size\":[\"44mm\",\"20mm\"],\"mirror\":true," \
    "\"halfAngle\":\"3deg\",\"radiance\":2,\"pattern\":{" \
    "\"resolution\":[44,20]," pattern "}"
#define CAMERA \
    "\"type\":\"telecentric\",\"magnification\":1,\"workingDistance\":\"0.1m\"," \
    "\"numericalAperture\":0.02," \
    "\"resolution\":[44,20],\"pixelSize\":\"1mm\""

/* What the camera sees of one of the sequence, by --set; over the radiance. */
static void see(const char *text, uint32_t index, bool reference, double seen[PIXELS]) {
    char *set = text_of("emitters/e/index=%u", index);
    mcv_scene *scene;
    mcv_image mean, error;
    BUILD(load_text("pattern.gltf", text, set, &scene, &builder_error));
    mcv_film film = render_by(reference, scene, 0, 1, 1);
    assert_int_equal(film.channels, 1);
    BUILD(mcv_film_develop(&film, &mean, &error, &builder_error));
    for (int i = 0; i < PIXELS; ++i) seen[i] = mean.pixels[i] / 2;
    mcv_image_free(&mean);
    mcv_image_free(&error);
    mcv_film_free(&film);
    mcv_scene_free(scene);
    free(set);
}

/*
 * N images give the phase of each pixel back, with it the column or row within a period. Values are
 * right to 1e-6 (float32: some 4 factors and a sum of 16), so the sums over N images are off by at
 * most N 1e-6, of an amplitude N/4: the phase by √2 · 4e-6.
 */
static void decode_phase(const char *pattern, uint32_t steps, double periods, bool horizontal,
                         bool reference) {
    double sine[PIXELS] = {0}, cosine[PIXELS] = {0}, seen[PIXELS];
    char *text = rig_text("", pattern, CAMERA, 0.1, "none.png");
    for (uint32_t k = 0; k < steps; ++k) {
        see(text, k, reference, seen);
        for (int i = 0; i < PIXELS; ++i) {
            sine[i] += seen[i] * sin(2 * M_PI * k / steps);
            cosine[i] += seen[i] * cos(2 * M_PI * k / steps);
        }
    }
    free(text);
    for (int i = 0; i < PIXELS; ++i) {
        const double at = (horizontal ? i / WIDTH : i % WIDTH) + 0.5,
                     across = horizontal ? HEIGHT : WIDTH;
        const double off =
            remainder(atan2(sine[i], cosine[i]) - 2 * M_PI * periods * at / across, 2 * M_PI);
        if (!(fabs(off) <= sqrt(2) * 4e-6))
            fail_msg("%s, %s: pixel (%d, %d) decodes %g pixels beside its place", pattern,
                     reference ? "reference" : "device", i % WIDTH, i / WIDTH,
                     off * across / (2 * M_PI * periods));
    }
}

static void test_phase_shift(void **state) {
    (void)state;
    for (int reference = 0; reference < 2; ++reference) {
        decode_phase(EMITTER("\"type\":\"phaseShift\",\"steps\":3,\"periods\":1"), 3, 1, false,
                     reference);
        decode_phase(EMITTER("\"type\":\"phaseShift\",\"steps\":4,\"periods\":2.5,\"orientation\":"
                             "\"horizontal\""),
                     4, 2.5, true, reference);
    }
}

/* The values as documented, to float32. */
static void test_values(void **state) {
    (void)state;
    const mcv_pattern pattern = {
        .type = MCV_PATTERN_PHASE_SHIFT, .steps = 5, .periods = 7, .resolution = {1000, 10}};
    assert_int_equal(mcv_pattern_count(&pattern), 5);
    for (uint32_t k = 0; k < 5; ++k) {
        mcv_texture texture = {0};
        const mcv_json_path place = mcv_place_file("pattern");
        BUILD(mcv_pattern_image(&pattern, k, &texture, &place, &builder_error));
        assert_int_equal(texture.width, 1000);
        assert_int_equal(texture.height, 1);
        for (uint32_t x = 0; x < 1000; ++x) {
            const double expected =
                0.5 + 0.5 * cos(2 * M_PI * 7 * (x + 0.5) / 1000 - 2 * M_PI * k / 5);
            for (uint32_t c = 0; c < 3; ++c)
                if (!(fabs(texture.linear[3 * x + c] - expected) <= 0x1p-24))
                    fail_msg("image %u, column %u is %.9g instead of %.9g", k, x,
                             texture.linear[3 * x + c], expected);
        }
        free(texture.linear);
    }
}

/* Each pixel is brighter in its bit's image or in the inverse one; the bits are a Gray code of its
 * place. */
static void decode_bits(const char *pattern, uint32_t bits, bool horizontal, bool reference) {
    uint32_t code[PIXELS] = {0};
    double seen[PIXELS], inverse[PIXELS];
    char *text = rig_text("", pattern, CAMERA, 0.1, "none.png");
    for (uint32_t b = 0; b < bits; ++b) {
        see(text, b, reference, seen);
        see(text, bits + b, reference, inverse);
        for (int i = 0; i < PIXELS; ++i) code[i] = code[i] << 1 | (seen[i] > inverse[i]);
    }
    free(text);
    for (int i = 0; i < PIXELS; ++i) {
        uint32_t place = code[i];
        for (uint32_t shift = 1; shift < 32; shift <<= 1) place ^= place >> shift;
        if ((int)place != (horizontal ? i / WIDTH : i % WIDTH))
            fail_msg("%s, %s: pixel (%d, %d) decodes to %u", pattern,
                     reference ? "reference" : "device", i % WIDTH, i / WIDTH, place);
    }
}

static void test_gray_code(void **state) {
    (void)state;
    decode_bits(EMITTER("\"type\":\"grayCode\""), 6, false, false);
    decode_bits(EMITTER("\"type\":\"grayCode\""), 6, false, true);
    decode_bits(EMITTER("\"type\":\"grayCode\",\"orientation\":\"horizontal\""), 5, true, false);

    /* Widths around a power of two, and the least. */
    static const uint32_t widths[] = {1, 2, 3, 4, 5, 1023, 1024, 1025, 65536},
                          counts[] = {2, 2, 4, 4, 6, 20, 20, 22, 32};
    for (int w = 0; w < 9; ++w) {
        const mcv_pattern pattern = {.type = MCV_PATTERN_GRAY_CODE, .resolution = {widths[w], 7}};
        const uint32_t bits = mcv_pattern_count(&pattern) / 2;
        assert_int_equal(2 * bits, counts[w]);
        for (uint32_t x = 0; x < widths[w]; ++x) {
            uint32_t changes = 0, binary = 0, bit = 0;
            for (uint32_t b = 0; b < bits; ++b) {
                const double value = mcv_pattern_value(&pattern, b, x);
                assert_true(value == 0 || value == 1);
                assert_true(mcv_pattern_value(&pattern, bits + b, x) == 1 - value);
                changes += x > 0 && value != mcv_pattern_value(&pattern, b, x - 1);
                bit ^= value == 1;
                binary = binary << 1 | bit;
            }
            if (changes != (x > 0))
                fail_msg("%u wide: column %u differs in %u bits from the one before", widths[w], x,
                         changes);
            if (binary != x) fail_msg("%u wide: column %u decodes to %u", widths[w], x, binary);
        }
    }
}

/* Power counts the pattern's mean: whole periods have the mean 1/2, Gray code and its inverse make
 * 1 together. */
static void test_power(void **state) {
    (void)state;
    double power[2];
    char *text = rig_text(
        "",
        "\"type\":\"telecentricProjector\",\"size\":[0.01,0.02],\"halfAngle\":0.1,\"power\":3,"
        "\"pattern\":{\"type\":\"phaseShift\",\"steps\":3,\"periods\":4,\"resolution\":[100,50]}",
        CAMERA, 0.1, "none.png");
    for (uint32_t i = 0; i < 2; ++i) {
        mcv_scene *scene;
        BUILD(load_text("pattern.gltf", text, i ? "emitters/e/index=2" : NULL, &scene,
                        &builder_error));
        power[i] = scene->emitters[0].radiance[0] * M_PI * sin(0.1) * sin(0.1) * 2e-4 / 2;
        if (!(fabs(power[i] - 3) <= 1e-6 * 3))
            fail_msg("image %u: its radiance makes %.9g W instead of 3", i,
                     power[i]); /* float32 values */
        mcv_scene_free(scene);
    }
    free(text);
}

static void test_bad_input(void **state) {
    (void)state;
#define PROJECTOR "\"type\":\"telecentricProjector\",\"size\":1,\"halfAngle\":0.1,\"radiance\":1,"
    static const bad_emitter cases[] = {
        {PROJECTOR "\"pattern\":1", "emitters/e/pattern: must be an object with a \"type\""},
        {PROJECTOR "\"pattern\":{}",
         "emitters/e/pattern/type: is missing: one of phaseShift, grayCode"},
        {PROJECTOR "\"pattern\":{\"type\":\"grey\"}", "unknown type \"grey\""},
        {PROJECTOR "\"pattern\":{\"type\":\"graycode\"}", "did you mean \"grayCode\"?"},
        {PROJECTOR "\"pattern\":{\"type\":\"grayCode\"}",
         "emitters/e/pattern/resolution: is missing"},
        {PROJECTOR "\"pattern\":{\"type\":\"grayCode\",\"resolution\":[8,0]}",
         "emitters/e/pattern/resolution/1: 0 must be an integer from 1"},
        {PROJECTOR "\"pattern\":{\"type\":\"grayCode\",\"resolution\":8,\"steps\":3}",
         "emitters/e/pattern: unknown key \"steps\""},
        {PROJECTOR "\"pattern\":{\"type\":\"grayCode\",\"resolution\":8,\"orientation\":\"up\"}",
         "\"up\" must be \"vertical\" or \"horizontal\""},
        {PROJECTOR "\"pattern\":{\"type\":\"phaseShift\",\"resolution\":8,\"periods\":1}",
         "emitters/e/pattern/steps: is missing"},
        {PROJECTOR
         "\"pattern\":{\"type\":\"phaseShift\",\"resolution\":8,\"periods\":1,\"steps\":2}",
         "emitters/e/pattern/steps: 2 must be an integer from 3"},
        {PROJECTOR
         "\"pattern\":{\"type\":\"phaseShift\",\"resolution\":8,\"periods\":0,\"steps\":3}",
         "emitters/e/pattern/periods: 0 must be above 0"},
        {PROJECTOR "\"pattern\":{\"type\":\"grayCode\",\"resolution\":8},\"image\":0",
         "emitters/e: has both image and pattern"},
        {PROJECTOR "\"pattern\":{\"type\":\"grayCode\",\"resolution\":8},\"index\":6",
         "emitters/e/index: 6 is outside the sequence, whose 6 images are 0 to 5"},
        {PROJECTOR "\"pattern\":{\"type\":\"grayCode\",\"resolution\":8},\"index\":-1",
         "emitters/e/index: -1 must be an integer"},
        {PROJECTOR "\"pattern\":{\"type\":\"grayCode\",\"resolution\":8},\"index\":0.5",
         "emitters/e/index: 0.5 must be an integer"},
        {PROJECTOR "\"image\":0,\"index\":1",
         "emitters/e/index: is the index in a pattern's sequence, but there is no pattern"},
        {PROJECTOR "\"index\":0", "emitters/e/image: is missing"},
        {"\"type\":\"lightField\",\"size\":1,\"spatialResolution\":1,\"angularResolution\":1,"
         "\"radiance\":1,\"pattern\":{\"type\":"
         "\"grayCode\",\"resolution\":1}",
         "unknown key \"pattern\""},
    };
    refuse_emitters(cases, sizeof cases / sizeof cases[0], "none.png");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_values),    cmocka_unit_test(test_phase_shift),
        cmocka_unit_test(test_gray_code), cmocka_unit_test(test_power),
        cmocka_unit_test(test_bad_input),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
