/* SPDX-License-Identifier: Apache-2.0 */
/* When the reference renderer makes a preview while kernels compile (host/api/early_preview.c). */
#include "estimates.h"

#include "api/early_preview.h"
#include "core/basics.h"
#include "peer_scenes.h"

#include <time.h>
#include <unistd.h>

static const char *const PATH = "early.png";
/* Seconds by the clock that a draft may take on a busy machine; it takes 0.3 s of an idle one. */
enum { LONGEST = 60 };

/* A white floor under a white sky, seen from above. */
static mcv_scene *new_floor(void) {
    mcv_scene *scene = new_scene();
    add_environment(scene, 1);
    add_rectangle(scene, 4, 4, add_peer_diffuse(scene, false, 0.6), looking_up_z(0, 0, 0));
    mcv_sensor sensor = sensor_defaults(MCV_SENSOR_PINHOLE);
    sensor.as.pinhole.imageDistance = 1;
    sensor.as.pinhole.resolution[0] = sensor.as.pinhole.resolution[1] = 64;
    sensor.as.pinhole.pixelSize[0] = sensor.as.pinhole.pixelSize[1] = 0.01;
    add_sensor(scene, MCV_SENSOR_PINHOLE, &sensor, looking_down_z(0, 0, 2));
    return scene;
}

static bool is_written(mcv_early *early) {
    pthread_mutex_lock(&early->lock);
    const bool written = early->written;
    pthread_mutex_unlock(&early->lock);
    return written;
}

/* A thread that computes as a compiler does has a preview meanwhile. A render that fails takes it
 * back. */
static void test_draft_while_it_compiles(void **state) {
    (void)state;
    mcv_scene *scene = new_floor();
    const mcv_render_options options = mcv_render_defaults();
    mcv_early early;
    unlink(PATH);
    mcv_early_begin(&early, scene, 0, PATH, "W/(m^2 sr)", &options);
    assert_true(mcv_early_progress(&early, (double)NAN));
    while (!is_written(&early) && mcv_seconds() - early.begun < LONGEST) {}
    mcv_early_end(&early);
    assert_true(early.written);
    assert_int_equal(access(PATH, F_OK), 0);
    assert_true(early.seconds > 0);
    mcv_early_withdraw(&early);
    assert_int_equal(access(PATH, F_OK), -1);
    mcv_early_free(&early);
    mcv_scene_free(scene);
}

/* A thread that waits for a busy machine does not compile: its kernels may still come from a
 * cache, and a draft would only delay them. */
static void test_no_draft_while_it_waits(void **state) {
    (void)state;
    mcv_scene *scene = new_floor();
    const mcv_render_options options = mcv_render_defaults();
    const struct timespec wait = {.tv_nsec = 600 * 1000 * 1000}; /* of the second by the clock */
    mcv_early early;
    unlink(PATH);
    mcv_early_begin(&early, scene, 0, PATH, "W/(m^2 sr)", &options);
    assert_true(mcv_early_progress(&early, (double)NAN));
    nanosleep(&wait, NULL);
    assert_false(mcv_early_progress(&early, 0));
    mcv_early_end(&early);
    assert_false(early.written);
    assert_int_equal(access(PATH, F_OK), -1);
    mcv_early_free(&early);
    mcv_scene_free(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_draft_while_it_compiles),
        cmocka_unit_test(test_no_draft_while_it_waits),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
