/* SPDX-License-Identifier: Apache-2.0 */
/* ctest: label truth */
/* ctest: label slow */
/* ctest: timeout 900 */
/* How the error of an image falls with its samples: as their inverse root with random points,
 * faster with Sobol' points. */
#include "scene_builder.h"

#include "convergence.h"
#include "truths.h"

/*
 * The slope of ln RMSE over ln samples. The RMSE of P pixels with noise of their own is uncertain
 * by 1/√(2P) in its logarithm. At most half of the 192 pixels are on no edge and have little: P =
 * 96 gives 0.07. Eight points at multiples of ln 4 have a sum of squares of 42 ln²4 about their
 * mean, so that the slope is uncertain by 0.07/√(42 ln²4) = 0.008: the 0.05 that is asked for are
 * six standard errors.
 */
static void test_slopes(void **state) {
    mcv_scene *scene = NULL;
    mcv_film truth = {0};
    mcv_render_stats stats;
    convergence_point random[CONVERGENCE_STEPS] = {{0}}, sobol[CONVERGENCE_STEPS] = {{0}};
    (void)state;
    BUILD(load_small("part-backlight.gltf", &scene, &builder_error));
    BUILD(render_truth(scene, CONVERGENCE_STEPS, &truth, &stats, &builder_error));
    BUILD(converge(scene, MCV_PRECISION_SINGLE, MCV_SAMPLER_RANDOM, &truth, CONVERGENCE_STEPS,
                   random, &builder_error));
    BUILD(converge(scene, MCV_PRECISION_SINGLE, MCV_SAMPLER_SOBOL, &truth, CONVERGENCE_STEPS, sobol,
                   &builder_error));
    const double slope = slope_of_rmse(random, CONVERGENCE_STEPS),
                 steeper = slope_of_rmse(sobol, CONVERGENCE_STEPS);
    print_message("slope %.3f random, %.3f Sobol'; RMSE %.3g and %.3g after %llu samples\n", slope,
                  steeper, random[CONVERGENCE_STEPS - 1].errors.rmse,
                  sobol[CONVERGENCE_STEPS - 1].errors.rmse,
                  (unsigned long long)random[CONVERGENCE_STEPS - 1].samples);
    note_truth("T10 RMSE over random samples, a part: slope + 1/2", "device", fabs(slope + 0.5),
               0.05);
    for (int i = 0; i < CONVERGENCE_STEPS; ++i) {
        note_point("RMSE by the image mean over samples", "part, random", (double)random[i].samples,
                   random[i].errors.rmse / mcv_film_mean(&truth));
        note_point("RMSE by the image mean over samples", "part, Sobol'", (double)sobol[i].samples,
                   sobol[i].errors.rmse / mcv_film_mean(&truth));
    }
    if (fabs(slope + 0.5) > 0.05)
        fail_msg("the slope with random points is %.3f instead of -0.50 +- 0.05", slope);
    if (!(steeper < slope - 0.05))
        fail_msg(
            "the slope with Sobol' points, %.3f, is not steeper than that with random ones, %.3f",
            steeper, slope);
    mcv_film_free(&truth);
    mcv_scene_free(scene);
}

/* The report's lens before a light field camera: at most -0.58 with Sobol' points. */
static void test_slope_of_the_report(void **state) {
    mcv_scene *scene = NULL;
    mcv_film truth = {0};
    mcv_render_stats stats;
    convergence_point sobol[CONVERGENCE_STEPS] = {{0}};
    (void)state;
    BUILD(load_small("report-clean.glb", &scene, &builder_error));
    BUILD(render_truth(scene, CONVERGENCE_STEPS, &truth, &stats, &builder_error));
    BUILD(converge(scene, MCV_PRECISION_SINGLE, MCV_SAMPLER_SOBOL, &truth, CONVERGENCE_STEPS, sobol,
                   &builder_error));
    const double slope = slope_of_rmse(sobol, CONVERGENCE_STEPS);
    print_message("report: slope %.3f Sobol'\n", slope);
    for (int i = 0; i < CONVERGENCE_STEPS; ++i)
        note_point("RMSE by the image mean over samples", "report, Sobol'",
                   (double)sobol[i].samples, sobol[i].errors.rmse / mcv_film_mean(&truth));
    note_truth("T10 RMSE over Sobol' samples, the report's lens: slope + 1", "device",
               fmax(0, slope + 1), 0.42);
    if (!(slope <= -0.58))
        fail_msg("the slope with Sobol' points is %.3f, not -0.58 or steeper", slope);
    mcv_film_free(&truth);
    mcv_scene_free(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_slopes),
                                       cmocka_unit_test(test_slope_of_the_report)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
