/* SPDX-License-Identifier: Apache-2.0 */
/* The reference renderer answers its caller within a piece of a round. */
#include "reference_checks.h"

#include <time.h>

static mcv_scene *grey_floor(void) {
    mcv_scene *scene = mcv_scene_new("floor");
    add_environment(scene, 1);
    add_rectangle(scene, 4, 4, add_diffuse(scene, 0.5), looking_up_z(0, 0, 0));
    add_pinhole(scene, 1, 1, looking_down_z(0, 0, 2));
    return scene;
}

/* The longest time between two reports, by the processor's clock of the calling thread [s]. */
typedef struct reports {
    double last, longest;
} reports;

static double thread_seconds(void) {
    struct timespec now;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static bool stop_after_two_seconds(void *user, double fraction, double seconds, double error) {
    reports *told = user;
    const double now = thread_seconds();
    (void)fraction, (void)error;
    told->longest = fmax(told->longest, now - told->last);
    told->last = now;
    return seconds < 2;
}

/*
 * A round grows to half of the time so far, and an image of one pixel has no rows between which to
 * ask. A caller is still asked each 0.1 s, so that a signal is answered within it. The limit is
 * twice as long: a busy machine shortens the processor's time between two reports, and a piece of
 * the work is some milliseconds.
 */
static void test_long_rounds_of_one_pixel_stop(void **state) {
    mcv_render_stats stats;
    mcv_scene *scene = grey_floor();
    mcv_render_options options = options_of(1 << 24, 16);
    reports told = {.last = thread_seconds()};
    (void)state;
    options.replicates = 2;
    options.threads = 1;
    options.progress = stop_after_two_seconds;
    options.user = &told;
    mcv_film film = render_with(scene, &options, true, &stats);
    assert_true(stats.interrupted && film.samples > 0 && film.samples < 1 << 24);
    if (!(told.longest < 0.2))
        fail_msg("the caller was not asked for %.2f s of processor time", told.longest);
    mcv_film_free(&film);
    mcv_scene_free(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_long_rounds_of_one_pixel_stop),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
