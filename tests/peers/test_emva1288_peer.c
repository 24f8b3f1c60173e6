/* SPDX-License-Identifier: Apache-2.0 */
/* ctest: label slow */
/* The camera as its own standard's reference implementation evaluates it, where `./run deps peers`
 * has put that. */
#include "test.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <unistd.h>

#include "analysis/camera.h"
#include "io/values.h"

#define PYTHON MCV_SOURCE_DIR "/build/peers/bin/python"

enum { WIDTH = 400, HEIGHT = 300, LEVELS = 85, STACK = 16 };

/*
 * Saturation is where the temporal variance is largest: some 2.3 standard deviations below the full
 * well, as the brightest pixels run full first. With 100 000 electrons shot noise (0.3 %) and PRNU
 * (0.2 %) leave 0.8 % of that.
 */
static const mcv_camera camera = {
    .electrons_per_unit = {0.6, 0.6, 0.6}, /* eta: the light counts photons */
    .dark_electrons = 44,
    .full_well = 100000,
    .gain = 0.5,
    .read_noise = 10,
    .dsnu = 9,
    .prnu = 0.002,
    .bits = 16,
    .black_level = 200,
    .specimen = 12};

/* Frames of a flat field of so many photons. */
static void take(const char *kind, double photons, int frames) {
    static uint32_t seed;
    mcv_image light;
    mcv_error error = {""};
    assert_int_equal(mcv_image_new(&light, WIDTH, HEIGHT, 1, &error), MCV_OK);
    for (size_t i = 0; i < (size_t)WIDTH * HEIGHT; ++i) light.pixels[i] = (float)photons;
    for (int n = 0; n < frames; ++n) {
        char path[64];
        mcv_camera c = camera;
        mcv_exposure exposure;
        c.seed = ++seed;
        snprintf(path, sizeof path, "%s-%.1f-%d.bin", kind, photons, n);
        assert_int_equal(mcv_camera_expose(&c, &light, NULL, &exposure, &error), MCV_OK);
        void *values = mcv_values_pack(&exposure.grey, 16);
        FILE *file = fopen(path, "wb");
        assert_true(file && values &&
                    fwrite(values, 2, (size_t)WIDTH * HEIGHT, file) == (size_t)WIDTH * HEIGHT);
        assert_int_equal(fclose(file), 0);
        free(values);
        mcv_exposure_free(&exposure);
    }
    mcv_image_free(&light);
}

/* Of the full well: in steps of 1.5 % up to 90 %, of 0.25 % where it saturates. */
static double share_of(int level) {
    return level <= 60 ? 0.015 * level : 0.95 + 0.0025 * (level - 61);
}

static void expect_near(const char *name, double found, double truth, double tolerance) {
    print_message("%s: %g instead of %g, %.2f %% off\n", name, found, truth,
                  100 * (found / truth - 1));
    if (!(fabs(found / truth - 1) <= tolerance))
        fail_msg("%s is %g instead of %g", name, found, truth);
}

/*
 * As asked: K within 0.5 %, dark noise, full well, DSNU and PRNU within 2 %, linearity error below
 * 0.1 %. With 120 000 pixels a variance has a standard error of 0.4 %, the line through 46 of them
 * one of 0.1 %.
 */
static void test_against_the_reference_implementation(void **state) {
    char folder[] = "test_emva1288.XXXXXX";
    enum { K, SIGMA_D, FULL_WELL, DSNU, PRNU, ETA, LE_MIN, LE_MAX, COUNT };
    double found[COUNT];
    char line[512] = "";
    (void)state;
    if (access(PYTHON, X_OK) != 0 || system(PYTHON " -c 'import emva1288' 2>/dev/null") != 0) {
        puts("emva1288 is not there: `./run deps peers` installs it");
        skip();
    }
    assert_true(mkdtemp(folder) && chdir(folder) == 0);
    for (int level = 0; level <= LEVELS; ++level)
        take("level", camera.full_well / 0.6 * share_of(level), 2);
    take("half", 0, STACK);
    take("half", camera.full_well / 0.6 / 2, STACK);
    FILE *peer = popen(PYTHON " " MCV_SOURCE_DIR "/tests/peers/emva1288_peer.py 400", "r");
    assert_non_null(peer);
    assert_non_null(fgets(line, sizeof line, peer));
    assert_int_equal(pclose(peer), 0);
    char *rest = line;
    for (int i = 0; i < COUNT; ++i) found[i] = strtod(rest, &rest);
    assert_int_equal(chdir(".."), 0);
    char command[64];
    snprintf(command, sizeof command, "rm -r %s", folder);
    assert_int_equal(system(command), 0);
    expect_near("K", found[K], 0.5, 0.005);
    expect_near("quantum efficiency", found[ETA], 60, 0.005);
    expect_near("sigma_d", found[SIGMA_D], 12, 0.02); /* √(10² + 44) */
    expect_near("u_e.sat", found[FULL_WELL], 1e5, 0.02);
    expect_near("DSNU", found[DSNU], 9, 0.02);
    expect_near("PRNU", found[PRNU], 0.2, 0.02);
    print_message("linearity error %g … %g %%\n", found[LE_MIN], found[LE_MAX]);
    assert_true(found[LE_MIN] > -0.1 && found[LE_MAX] < 0.1);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_against_the_reference_implementation)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
