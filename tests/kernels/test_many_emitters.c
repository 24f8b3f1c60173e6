/* SPDX-License-Identifier: Apache-2.0 */
/* ctest: label slow */
/*
 * The noise of a hundred emitters against one of the same size and power, at equal samples.
 * The benchmark `render` says what many lamps cost in time (mesh lamps, mesh board).
 *
 * A diffuse ball on a floor under a panel of 200 mm, whole or cut into 10 x 10; diffuse, and
 * parallel with cones so narrow that both are sampled as cones.
 */
#include "estimates.h"
#include "scene_builder.h"

#include "render/render.h"

enum { PIXELS = 64, SAMPLES = 64 };

static mcv_scene *make_scene(uint32_t type, int side) {
    mcv_scene *scene = mcv_scene_new("emitters");
    const double pitch = 0.2 / side;
    const uint32_t grey = add_diffuse(scene, 0.5), black = add_absorber(scene);
    add_rectangle(scene, 0.4, 0.4, grey, looking_up_z(0, 0, 0));
    add_sphere(scene, 0.03, 40, grey, looking_down_z(0, 0, 0.03));
    for (int i = 0; i < side * side; ++i) {
        const double x = (i % side + 0.5) * pitch - 0.1;
        const double y =
            (i / side + 0.5) * pitch - 0.1; // NOLINT(bugprone-integer-division): whole rows
        add_emitter(scene, type,
                    add_rectangle(scene, pitch, pitch, black, looking_down_z(x, y, 0.3)), 3, 0.01);
    }
    add_pinhole(scene, PIXELS, 0.5, looking_down_z(0, 0, 0.28));
    return scene;
}

/* Over the pixels, of one sample, over the squared mean of the image. */
static double variance_of(const mcv_film *film) {
    const size_t pixels = (size_t)film->width * film->height;
    double sum = 0, mean = 0;
    for (size_t i = 0; i < pixels; ++i) {
        const mcv_estimate m = film_estimate(film, i, 1);
        sum += m.variance * (double)film->samples * film->replicates;
        mean += m.mean;
    }
    return sum / (double)pixels / pow(mean / (double)pixels, 2);
}

/* Of one emitter, and of a hundred. */
static void compare(uint32_t type, const char *name, double variances[2]) {
    static const int sides[2] = {1, 10};
    for (int i = 0; i < 2; ++i) {
        mcv_scene *scene = make_scene(type, sides[i]);
        mcv_render_options options = mcv_render_defaults();
        mcv_render_stats stats;
        mcv_film film;
        options.last = SAMPLES;
        options.sampler = MCV_SAMPLER_RANDOM;
        BUILD(mcv_render(scene, 0, &options, &film, &stats, &builder_error));
        variances[i] = variance_of(&film);
        mcv_film_free(&film);
        mcv_scene_free(scene);
    }
    print_message("%s: variances of one sample: one %.3g, a hundred %.3g\n", name, variances[0],
                  variances[1]);
}

/* Chosen by power, the one of a hundred that lights a place is found by one sample in a hundred:
 * the variance of the direct light is 99 of its squared mean. A sample that is chosen by the light
 * tree may take twice as long: at a fourth of the variance it takes half of the time to an error.
 */
static void test_parallel(void **state) {
    double variances[2];
    (void)state;
    compare(MCV_EMITTER_PARALLEL, "parallel", variances);
    if (!(variances[1] <= 99 / 4.0))
        fail_msg("parallel: the variance of a hundred emitters is %.3g", variances[1]);
}

/* Where all places see all panels, the choice of one of them replaces a place on the whole panel.
 * Each alone is nearly even, so that it adds at most what a place on the panel brings. */
static void test_area(void **state) {
    double variances[2];
    (void)state;
    compare(MCV_EMITTER_AREA, "area", variances);
    if (!(variances[1] <= 2 * variances[0]))
        fail_msg("area: the variance of a hundred emitters is %.3g, of one %.3g", variances[1],
                 variances[0]);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_parallel),
                                       cmocka_unit_test(test_area)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
