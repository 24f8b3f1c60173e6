/* SPDX-License-Identifier: Apache-2.0 */
/* ctest: label truth */
/* ctest: label slow */
/* ctest: timeout 900 */
/* What takes many samples: the device against the reference to a thousandth of the image, and
 * plates at grazing angles. */
#include "convergence.h"
#include "reference_checks.h"

/*
 * A part before a panel, seen by a telecentric camera, small: both renderers' image means agree,
 * and a difference of 0.1 % of the mean would have been seen in nine of ten cases.
 */
static void test_bias(void **state) {
    mcv_film films[2];
    mcv_comparison c;
    mcv_scene *scene = NULL;
    (void)state;
    BUILD(load_small("part-backlight.gltf", &scene, &builder_error));
    for (int reference = 0; reference < 2; ++reference) {
        mcv_render_options options = mcv_render_defaults();
        mcv_render_stats stats = {0};
        options.replicates = REPLICATES;
        options.last =
            reference ? 4096 : 2048; /* the reference's points are random, the device's Sobol's */
        options.seed = (uint32_t)reference + 1;
        BUILD((reference ? mcv_reference_render : mcv_render)(scene, 0, &options, &films[reference],
                                                              &stats, &builder_error));
        assert_int_equal(stats.nonfinite, 0);
        print_message("  %s: %.1f s\n", reference ? "reference" : "device", stats.seconds_render);
    }
    BUILD(mcv_compare_films(&films[0], &films[1], &c, &builder_error));
    print_message("  means %.7g and %.7g; %.2g %% of the mean would be seen; %s\n", c.mean_x,
                  c.mean_y, 100 * c.detectable, c.reason);
    checked = "device";
    check("bias: what would be seen, of the image mean", c.detectable, 0, 1e-3);
    check("bias: image mean over the reference's, a part", c.mean_x / c.mean_y, 1, c.detectable);
    if (c.different) fail_msg("%s", c.reason);
    for (int i = 0; i < 2; ++i) mcv_film_free(&films[i]);
    mcv_scene_free(scene);
}

/*
 * T14 up to 89.9 degrees: a path inside is reflected 70 times on average there, so that 2048 are
 * allowed. Where the glance is so flat, a rounding of the direction by 2u is one of 2u/cos of its
 * cosine, to which T is proportional.
 */
static void test_grazing_slab(void **state) {
    static const double angles[] = {80, 85, 89, 89.9};
    enum { BOUNCES = 2048 };
    (void)state;
    for (int i = 0; i < 4; ++i) {
        const double angle = angles[i] * M_PI / 180, s = sin(angle), c = cos(angle), top = 0.0125;
        mcv_scene *scene = mcv_scene_new("grazing slab");
        add_box(scene, (const double[3]){60, 60, top}, add_glass(scene, 1.5, 0, 0),
                mcv_transform_identity());
        add_emitter(scene, MCV_EMITTER_AREA,
                    add_rectangle(scene, 400, 400, add_absorber(scene), looking_up_z(0, 0, -0.05)),
                    1, 0);
        add_spot_camera(scene, (const double[3]){s, 0, top + c}, (const double[3]){0, 0, top},
                        1e-7);
        const double inner = sqrt(1 - s * s / 2.25), r_s = (c - 1.5 * inner) / (c + 1.5 * inner),
                     r_p = (inner - 1.5 * c) / (inner + 1.5 * c);
        const double r = 0.5 * (r_s * r_s + r_p * r_p), truth = (1 - r) / (1 + r);
        char what[64];
        snprintf(what, sizeof what, "T14 slab at %g degrees, depth 2048", angles[i]);
        for (int reference = 0; reference < 2; ++reference) {
            mcv_render_stats stats;
            const mcv_estimate mean = reference ? render_mean(scene, 65536, BOUNCES, true, &stats)
                                                : device_mean(scene, 65536, BOUNCES, &stats);
            checked = reference ? "reference" : "device";
            check_mean(what, mean, truth,
                       truth * (1e-5 + (reference ? 0 : 4 * 0x1p-24 / c)) + pow(r, BOUNCES - 2));
        }
        mcv_scene_free(scene);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_grazing_slab),
                                       cmocka_unit_test(test_bias)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
