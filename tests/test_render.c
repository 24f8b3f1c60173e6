/* SPDX-License-Identifier: Apache-2.0 */
/* Rendering on the device: truths that every image must keep. */
#include "scene_builder.h"

#include "render/render.h"

/* Image mean of one channel, and its standard error over the replicates. */
typedef struct mean_value {
    double mean, error;
} mean_value;

static mean_value mean_of(const mcv_film *film, uint32_t channel) {
    const size_t pixels = (size_t)film->width * film->height;
    double sum = 0;
    double squares = 0;
    for (uint32_t r = 0; r < film->replicates; ++r) {
        double total = 0;
        for (size_t i = 0; i < pixels; ++i) total += film->sums[((size_t)r * film->channels + channel) * pixels + i];
        total /= (double)pixels * (double)film->samples;
        sum += total;
        squares += total * total;
    }
    const double n = film->replicates;
    return (mean_value){sum / n, n > 1 ? sqrt(fmax(0, squares / n - sum / n * sum / n) / (n - 1)) : INFINITY};
}

static mcv_render_stats last_stats;

static mean_value render_mean(const mcv_scene *scene, uint32_t replicates, uint32_t samples, uint32_t depth) {
    mcv_render_options options = mcv_render_defaults();
    mcv_film film;
    mcv_error error = {""};
    options.replicates = replicates;
    options.last = samples;
    options.depth = depth;
    if (mcv_render(scene, 0, &options, &film, &last_stats, &error) != MCV_OK) fail_msg("%s", error.text);
    const mean_value mean = mean_of(&film, 0);
    mcv_film_free(&film);
    return mean;
}

/* Sums of exactly equal values: nothing but the rounding of one division per pixel. */
static void test_environment_alone_is_exact(void **state) {
    mcv_scene *scene = mcv_scene_new("environment");
    (void)state;
    add_environment(scene, 0.75);
    add_pinhole(scene, 12, 1, looking_down_z(0, 0, 0));
    const mean_value m = render_mean(scene, 4, 8, 4);
    assert_true(fabs(m.mean - 0.75) <= 1e-15);
    assert_int_equal(last_stats.paths, 12 * 12 * 4 * 8);
    assert_int_equal(last_stats.nonfinite, 0);
    mcv_scene_free(scene);
}

/* T15: a lossless body of any shape vanishes in a uniform surrounding; the paths that the depth limit cuts are all that is missing. */
static void test_glass_furnace(void **state) {
    mcv_scene *scene = mcv_scene_new("furnace");
    (void)state;
    add_environment(scene, 1);
    add_sphere(scene, 0.5, 24, add_glass(scene, 1.5, 0, 0), mcv_transform_identity());
    add_pinhole(scene, 32, 0.5, looking_down_z(0, 0, 3));
    const mean_value m = render_mean(scene, 4, 64, 100);
    print_message("furnace: mean - 1 = %.3g, lost %.3g, unmatched %llu\n", m.mean - 1, last_stats.lost_energy,
                  (unsigned long long)last_stats.unmatched);
    /* Every finished path brings 1/n² n² of the vacuum: the mean misses just the cut paths. */
    assert_true(fabs(m.mean + last_stats.lost_energy - 1) <= 1e-6);
    assert_int_equal(last_stats.unmatched, 0);
    mcv_scene_free(scene);
}

/* T19: a closed diffuse box that emits: L = Le/(1 - ρ). */
static void test_diffuse_furnace(void **state) {
    mcv_scene *scene = mcv_scene_new("closed box");
    const double half[3] = {1, 1.5, 2};
    (void)state;
    for (int k = 0; k < 3; ++k) {
        for (int side = -1; side <= 1; side += 2) {
            double at[3] = {0, 0, 0};
            double forward[3] = {0, 0, 0};
            double up[3] = {0, 0, 0};
            at[k] = side * half[k];
            forward[k] = -side;
            up[(k + 1) % 3] = 1;
            const mcv_transform placed = looking(at, forward, up);
            /* right = forward x up lies along axis k + 2 */
            const uint32_t wall = add_rectangle(scene, 2 * half[(k + 2) % 3], 2 * half[(k + 1) % 3], add_diffuse(scene, 0.5), placed);
            add_emitter(scene, MCV_EMITTER_AREA, wall, 0.5, 0);
        }
    }
    add_pinhole(scene, 16, 1, looking_down_z(0.1, 0.2, 0.3));
    const mean_value m = render_mean(scene, 16, 64, 64);
    print_message("diffuse furnace: mean %.6f ± %.2g, expected 1\n", m.mean, m.error);
    /* 16 replicates, Student's t with 15 degrees of freedom: 6.1 standard errors happen with probability 2e-5. */
    assert_true(m.error < 0.003);
    assert_true(fabs(m.mean - 1) <= 6.1 * m.error + 1e-6);
    mcv_scene_free(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_environment_alone_is_exact),
        cmocka_unit_test(test_glass_furnace),
        cmocka_unit_test(test_diffuse_furnace),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
