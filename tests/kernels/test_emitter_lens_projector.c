/* SPDX-License-Identifier: Apache-2.0 */
/* The projector: which pixel a place on its lens shows, where its picture lands, how much it sends,
 * what is refused. */
#include "image_emitters.h"

#include "scene/emitters.h"

enum { WIDTH = 6, HEIGHT = 4, PIXELS = 24 };

static const double focal_length = 0.02, throw = 0.3, diameter = 0.01, pixel = 1.19e-4;
#define NAMED \
    "\"type\":\"projector\",\"focalLength\":\"20mm\",\"focusDistance\":0.3,\"lensDiameter\":" \
    "\"10mm\",\"pixelSize\":\"119um\","
#define CAMERA "\"type\":\"pinhole\",\"imageDistance\":1,\"resolution\":[1,1],\"pixelSize\":1e-6"

/*
 * The pixel that the lens shows at (x, y) to an eye on the axis at the depth z: its ray has d_x/d_z
 * = -x/z. False where it is dark. *edge is set to the distance from the next edge, in pixels, or of
 * the disk's, in lens diameters.
 */
static bool shown(double x, double y, double z, bool mirror, int *column, int *row, double *edge) {
    const double b = 1 / (1 / focal_length - 1 / throw);
    const double across = WIDTH / 2.0 + (mirror ? -1 : 1) * b / pixel * x * (1 / throw -1 / z);
    const double down = HEIGHT / 2.0 - b / pixel * y * (1 / throw -1 / z);
    const double rim = hypot(x, y) / diameter - 0.5;
    *edge =
        fmin(*edge, fmin(fabs(rim), fmin(fabs(across - round(across)), fabs(down - round(down)))));
    *column = (int)floor(across);
    *row = (int)floor(down);
    return rim <= 0 && *column >= 0 && *column < WIDTH && *row >= 0 && *row < HEIGHT;
}

/*
 * A pinhole camera on the axis looks at the lens: before the plane in focus it sees the image
 * turned by 180° in it, behind upright, but for left and right, because it faces the projector.
 * Camera pixels in which more than one value lies are left out: the corners tell. Some 5 products
 * of float32, and a sum of equal values: 1e-6.
 */
static void expect_lens(bool reference, const char *rig, bool mirror, bool pattern, double z) {
    mcv_scene *scene;
    mcv_image mean, error;
    int compared = 0, bright = 0;
    char *emitter = text_of(NAMED "%s,\"mirror\":%s,\"radiance\":2",
                            pattern ? "\"pattern\":{\"type\":\"phaseShift\",\"steps\":4,"
                                      "\"periods\":1,\"resolution\":[6,4]},\"index\":1"
                                    : "\"image\":0",
                            mirror ? "true" : "false");
    char *sensor = text_of(
        "\"type\":\"pinhole\",\"imageDistance\":1,\"resolution\":[24,24],\"pixelSize\":%.17g",
        diameter / z / PIXELS);
    char *text = rig_text(rig, emitter, sensor, z, "lens_projector.png");
    BUILD(load_text("lens_projector.gltf", text, NULL, &scene, &builder_error));
    mcv_film film = render_by(reference, scene, 0, 4, 1);
    BUILD(mcv_film_develop(&film, &mean, &error, &builder_error));
    for (int i = 0; i < PIXELS * PIXELS; ++i) {
        int columns[4], rows[4];
        bool lit[4], one = true;
        double edge = 1;
        for (int corner = 0; corner < 4; ++corner) {
            const double x = -((i % PIXELS + (corner & 1)) / (double)PIXELS - 0.5) * diameter;
            const double y = (0.5 - (i / PIXELS + (corner >> 1)) / (double)PIXELS) * diameter;
            /* A hundredth inwards, so that equal edges do not count. */
            lit[corner] =
                shown(x * 0.9999, y * 0.9999, z, mirror, columns + corner, rows + corner, &edge);
            one = one && lit[corner] == lit[0] &&
                  (!lit[0] || (columns[corner] == columns[0] && rows[corner] == rows[0]));
        }
        if (!one) continue;
        uint8_t rgb[3] = {0, 0, 0};
        if (lit[0]) value_of(WIDTH, HEIGHT, (uint32_t)columns[0], (uint32_t)rows[0], rgb);
        ++compared;
        bright += lit[0];
        for (int k = 0; k < (int)mean.channels; ++k) {
            const double value =
                pattern ? 0.5 + 0.5 * cos(2 * M_PI * ((columns[0] + 0.5) / WIDTH - 0.25))
                        : linear(rgb[k]);
            const double expected = lit[0] ? 2 * value : 0,
                         seen = mean.pixels[k * PIXELS * PIXELS + i];
            if (!(fabs(seen - expected) <= 1e-6 * expected))
                fail_msg("%s, rig {%s}, mirror %d, from %g m: pixel (%d, %d) channel %d is %.9g, "
                         "expected %.9g of (%d, %d)",
                         reference ? "reference" : "device", rig, mirror, z, i % PIXELS, i / PIXELS,
                         k, seen, expected, columns[0], rows[0]);
        }
    }
    assert_true(compared > PIXELS * PIXELS / 3 && bright > PIXELS * PIXELS / 4 &&
                bright < compared);
    mcv_image_free(&mean);
    mcv_image_free(&error);
    mcv_film_free(&film);
    mcv_scene_free(scene);
    free(text);
    free(sensor);
    free(emitter);
}

static void test_each_pixel_is_where_it_belongs(void **state) {
    (void)state;
    write_png("lens_projector.png", WIDTH, HEIGHT);
    for (int i = 0; i < 8; ++i) expect_lens(i & 2, rigs[i >> 2], i & 1, false, 0.15);
    for (int i = 0; i < 4; ++i) expect_lens(i & 2, rigs[1], false, i & 1, 0.6);
}

/* From where a pixel's picture is sharp the whole lens has its value, from 1 % of a pixel outside
 * of the picture it is dark. */
static void test_in_focus_the_lens_is_filled(void **state) {
    (void)state;
    static const struct {
        double column, row;
        int lit;
    } cases[] = {{0.01, 0.01, 1}, {5.99, 0.01, 1}, {0.01, 3.99, 1}, {4.5, 2.5, 1},
                 {-0.01, 1, 0},   {6.01, 1, 0},    {1, -0.01, 0},   {1, 4.01, 0}};
    const double b = 1 / (1 / focal_length - 1 / throw);
    for (size_t i = 0; i < 2 * sizeof cases / sizeof cases[0]; ++i) {
        mcv_scene *scene;
        const bool reference = i & 1;
        const double column = cases[i / 2].column, row = cases[i / 2].row;
        const double x = (column - WIDTH / 2.0) * pixel / b * throw,
                     y = (HEIGHT / 2.0 - row) * pixel / b * throw;
        const double length = sqrt(x * x + y * y + throw *throw), across = hypot(x, throw);
        const double forward[3] = {-x / length, -y / length, throw / length},
                     right[3] = {throw / across, 0, x / across};
        const double up[3] = {right[1] * forward[2] - right[2] * forward[1],
                              right[2] * forward[0] - right[0] * forward[2],
                              right[0] * forward[1] - right[1] * forward[0]};
        char *text =
            rig_text("", NAMED "\"image\":0,\"radiance\":2", CAMERA, 0.1, "lens_projector.png");
        BUILD(load_text("lens_projector.gltf", text, NULL, &scene, &builder_error));
        /* A field of 9.5 mm at the lens, whose diagonal of 13 mm is more than the disk: of it the
         * middle 9.5/√2 mm count. */
        add_pinhole(scene, 1, 0.0095 / sqrt(2) / length,
                    looking((const double[]){x, y, -throw}, forward, up));
        mcv_film film = render_by(reference, scene, 1, 16, 1);
        uint8_t rgb[3] = {0, 0, 0};
        if (cases[i / 2].lit) value_of(WIDTH, HEIGHT, (uint32_t)column, (uint32_t)row, rgb);
        for (uint32_t k = 0; k < 3; ++k) {
            double seen = 0;
            for (uint32_t r = 0; r < REPLICATES; ++r)
                seen += film.sums[r * 3 + k] / REPLICATES / 16;
            const double expected = cases[i / 2].lit ? 2 * linear(rgb[k]) : 0;
            if (!(fabs(seen - expected) <= 1e-6 * expected))
                fail_msg("%s: from the picture of (%g, %g) channel %u of the lens is %.9g, "
                         "expected %.9g",
                         reference ? "reference" : "device", column, row, k, seen, expected);
        }
        mcv_film_free(&film);
        mcv_scene_free(scene);
        free(text);
    }
}

/* Sharp on the floor; far out of focus from a lens as wide as its throw; and in focus at infinity.
 */
static void test_power_arrives(void **state) {
    (void)state;
    static const double power[3] = {1, 2, 0.25};
    static const struct {
        const char *lens;
        double field;
    } cases[] = {
        {"\"focalLength\":0.02,\"focusDistance\":0.2,\"fNumber\":2,\"pixelSize\":\"0.5mm\"", 0.05},
        {"\"focalLength\":0.05,\"focusDistance\":0.1,\"lensDiameter\":0.1,\"pixelSize\":[0.004,0."
         "006]",
         0.25},
        {"\"focalLength\":0.02,\"imageDistance\":0.02,\"lensDiameter\":0.004,\"pixelSize\":\"0."
         "5mm\"",
         0.06},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        char *emitter =
            text_of("\"type\":\"projector\",\"image\":0,%s,\"power\":[1,2,0.25]", cases[i].lens);
        char *text = rig_text("", emitter, CAMERA, 0.1, "lens_projector.png");
        expect_power(text, power, cases[i].field, 0, cases[i].lens);
        free(text);
        free(emitter);
    }
}

/*
 * Its power at radiance 1 against the integral over lens and image by the midpoint rule, in which
 * the place on the lens is ρ, φ and the image's is x, y over b: ∫∫ dA dx dy/(1 + |(x, y) - κ o|²)².
 * Each of four sides, of at most s = 1, is cut in N = 40: the rule is off by s²/24 N² = 2.6e-5
 * times the second derivative, of at most 4 times the value in its side's direction, where all four
 * add up.
 */
static void test_unit_power(void **state) {
    (void)state;
    enum { STEPS = 40 };
    static const double lenses[][3] = {{0.02, 0.0214, 0.01},
                                       {0.05, 0.1, 0.1},
                                       {0.03, 0.03, 0.02},
                                       {0.03, 0.025, 0.05}};          /* f, b, D */
    static const double halves[][2] = {{0.002, 0.001}, {0.01, 0.03}}; /* of the image [m] */
    for (size_t i = 0; i < 8; ++i) {
        const double *lens = lenses[i / 2], *half = halves[i % 2],
                     kappa = 1 / lens[0] - 1 / lens[1];
        mcv_emitter emitter = {.type = MCV_EMITTER_PROJECTOR, .texture = MCV_NONE};
        emitter.as.projector.pattern.type = MCV_NONE;
        emitter.as.projector.focalLength = lens[0];
        emitter.as.projector.imageDistance = lens[1];
        emitter.as.projector.lensDiameter = lens[2];
        for (int k = 0; k < 2; ++k) emitter.as.projector.pixelSize[k] = 2 * half[k];
        double sum = 0;
        /* Mirror images of the place and turns of the lens give the same. */
        for (int r = 0; r < STEPS; ++r)
            for (int a = 0; a < STEPS; ++a) {
                const double radius = (r + 0.5) / STEPS * lens[2] / 2,
                             angle = 2 * M_PI * (a + 0.5) / STEPS;
                const double o_x = kappa * radius * cos(angle), o_y = kappa * radius * sin(angle);
                for (int s = 0; s < STEPS; ++s)
                    for (int t = 0; t < STEPS; ++t) {
                        const double x = ((s + 0.5) / STEPS - 0.5) * 2 * half[0] / lens[1] - o_x;
                        const double y = ((t + 0.5) / STEPS - 0.5) * 2 * half[1] / lens[1] - o_y;
                        sum += radius / ((1 + x * x + y * y) * (1 + x * x + y * y));
                    }
            }
        sum *= lens[2] / 2 / STEPS * 2 * M_PI / STEPS * 4 * half[0] * half[1] /
               (lens[1] * lens[1] * STEPS * STEPS);
        const double power = mcv_emitter_unit_power(NULL, &emitter);
        if (!(fabs(power - sum) <= 4 * 4 * 2.6e-5 * sum))
            fail_msg("lens %zu, image %zu: power %.9g, expected %.9g", i / 2, i % 2, power, sum);
    }
}

static void test_bad_input(void **state) {
    (void)state;
    static const bad_emitter cases[] = {
        {NAMED "\"radiance\":1", "emitters/e/image: is missing"},
        {NAMED "\"image\":0", "emitters/e: needs radiance"},
        {NAMED "\"image\":0,\"radiance\":1,\"size\":1", "emitters/e: unknown key \"size\""},
        {NAMED "\"image\":0,\"radiance\":1,\"imageDistance\":\"25mm\"",
         "emitters/e/focusDistance: 0.3 contradicts focalLength and imageDistance"},
        {"\"type\":\"projector\",\"image\":0,\"radiance\":1,\"focalLength\":0.02,\"lensDiameter\":"
         "0.01,\"pixelSize\":1e-4",
         "emitters/e: needs imageDistance or focusDistance"},
        {"\"type\":\"projector\",\"image\":0,\"radiance\":1,\"focalLength\":0.02,\"focusDistance\":"
         "0.01,\"fNumber\":2,\"pixelSize\":1e-4",
         "emitters/e/focusDistance: 0.01 m must exceed focalLength 0.02 m"},
        {"\"type\":\"projector\",\"image\":0,\"radiance\":1,\"focalLength\":0.02,\"focusDistance\":"
         "1,\"pixelSize\":1e-4",
         "emitters/e: needs lensDiameter or fNumber"},
        {"\"type\":\"projector\",\"image\":0,\"radiance\":1,\"focalLength\":0.02,\"focusDistance\":"
         "1,\"fNumber\":2",
         "emitters/e/pixelSize: is missing"},
    };
    refuse_emitters(cases, sizeof cases / sizeof cases[0], "lens_projector.png");
    refuse_images(NAMED "\"radiance\":1,", 8, 4);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_each_pixel_is_where_it_belongs),
        cmocka_unit_test(test_in_focus_the_lens_is_filled),
        cmocka_unit_test(test_power_arrives),
        cmocka_unit_test(test_unit_power),
        cmocka_unit_test(test_bad_input),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
