/* SPDX-License-Identifier: Apache-2.0 */
/* ctest: label slow */
/*
 * What a hundred emitters cost against one of the same size and power. Where they are alike at all
 * places they are chosen by power: at most 1.2 times the time per sample. Where each place is lit
 * by one or two of them alone, the light tree takes at most half of the time to an error that
 * choice by power would take.
 *
 * A diffuse ball on a floor under a panel of 200 mm, whole or cut into 10 x 10; diffuse, and
 * parallel with cones so narrow that both are sampled as cones. Processor seconds per sample of the
 * least of TURNS renders that take turns; set-up is taken off by rendering few samples, too.
 */
#include "estimates.h"
#include "scene_builder.h"

#include "render/render.h"

#include <time.h>

enum { PIXELS = 64, FEW = 4, MANY = 64, TURNS = 5 };

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

/* Also the image's relative variance, for one sample. */
static double seconds_of(const mcv_scene *scene, uint64_t samples, double *variance) {
    mcv_render_options options = mcv_render_defaults();
    mcv_render_stats stats;
    mcv_film film;
    struct timespec begun, ended;
    options.last = samples;
    options.sampler = MCV_SAMPLER_RANDOM;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &begun);
    BUILD(mcv_render(scene, 0, &options, &film, &stats, &builder_error));
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &ended);
    *variance = variance_of(&film);
    mcv_film_free(&film);
    return (double)(ended.tv_sec - begun.tv_sec) + 1e-9 * (double)(ended.tv_nsec - begun.tv_nsec);
}

/* Chosen by power through a search, a sample has 1.01 times as many instructions (callgrind), and
 * larger boxes to look through. */
static void compare(uint32_t type, const char *name, double each[2], double variances[2]) {
    static const int sides[2] = {1, 10};
    mcv_scene *scenes[2];
    double least[2][2] = {{INFINITY, INFINITY},
                          {INFINITY, INFINITY}}; /* of few and of many samples */
    double unused;
    for (int i = 0; i < 2; ++i) scenes[i] = make_scene(type, sides[i]);
    for (int turn = 0; turn < TURNS; ++turn)
        for (int i = 0; i < 2; ++i) {
            least[i][0] = fmin(least[i][0], seconds_of(scenes[i], FEW, &unused));
            least[i][1] = fmin(least[i][1], seconds_of(scenes[i], MANY, &variances[i]));
        }
    for (int i = 0; i < 2; ++i) {
        each[i] = (least[i][1] - least[i][0]) /
                  (4.0 * (MANY - FEW) * PIXELS * PIXELS); /* of 4 replicates */
        mcv_scene_free(scenes[i]);
    }
    print_message(
        "%s: one %.3g ns, a hundred %.3g ns per sample: ratio %.3f; variances %.3g, %.3g\n", name,
        1e9 * each[0], 1e9 * each[1], each[1] / each[0], variances[0], variances[1]);
}

/* Chosen by power, the one of a hundred that lights a place is found by one sample in a hundred:
 * the variance of the direct light is 99 of its squared mean. */
static void test_parallel(void **state) {
    double each[2], variances[2];
    (void)state;
    compare(MCV_EMITTER_PARALLEL, "parallel", each, variances);
    if (!(each[1] * variances[1] <= 0.5 * each[0] * 99))
        fail_msg("parallel: a hundred emitters cost %.3f times one, their variance is %.3g",
                 each[1] / each[0], variances[1]);
}

static void test_area(void **state) {
    double each[2], variances[2];
    (void)state;
    compare(MCV_EMITTER_AREA, "area", each, variances);
    if (!(each[1] <= 1.2 * each[0]))
        fail_msg("area: a hundred emitters cost %.3f times one", each[1] / each[0]);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_parallel),
                                       cmocka_unit_test(test_area)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
