/* SPDX-License-Identifier: Apache-2.0 */
/* The public interface on an OpenCL device: threads, and the bits of the program. */
#include "api.h"

#include "program.h"

#include <pthread.h>
#include <stdatomic.h>

static const char scene[] = MCV_SOURCE_DIR "/scenes/telecentric-edge.gltf";
static const char options[] = "{\"spp\": 16, \"seed\": 3}";

static mcv_rig *open_rig(void) {
    mcv_rig *rig = NULL;
    WELL(mcv_rig_open(scene, &rig, &error));
    return rig;
}

static void expect_same(const mcv_picture *a, const mcv_picture *b) {
    assert_int_equal(mcv_picture_part_count(a), mcv_picture_part_count(b));
    for (uint32_t i = 0; i < mcv_picture_part_count(a); ++i) {
        const mcv_part x = part_of(a, i), y = part_of(b, i);
        assert_string_equal(x.name, y.name);
        assert_int_equal(x.width, y.width);
        assert_int_equal(x.height, y.height);
        assert_int_equal(x.channels, y.channels);
        assert_memory_equal(x.planes, y.planes, sizeof(float) * x.width * x.height * x.channels);
    }
}

static void test_same_bits_as_the_program(void **state) {
    mcv_session *session = open_session(NULL);
    mcv_rig *rig = open_rig();
    mcv_picture *written = NULL, *grey = NULL, *grey_written = NULL;
    char line[512];
    (void)state;
    snprintf(line, sizeof line,
             "render %s --spp 16 --seed 3 --set sensors/camera/stopDiameter=3mm -o program.exr "
             "--camera program.tif --expose-to 0.5",
             scene);
    program_well(line);
    WELL(mcv_rig_set(rig, "sensors/camera/stopDiameter", "3mm", &error));
    mcv_picture *picture = render(session, rig, options);
    WELL(mcv_picture_read("program.exr", &written, &error));
    expect_same(picture, written);
    WELL(mcv_picture_camera(picture, "{\"expose_to\": 0.5, \"seed\": 3}", &grey, NULL, &error));
    WELL(mcv_picture_read("program.tif", &grey_written, &error));
    assert_memory_equal(part_of(grey, 0).planes, part_of(grey_written, 0).planes,
                        sizeof(float) * 96 * 64);
    mcv_picture_free(grey);
    mcv_picture_free(grey_written);
    mcv_picture_free(written);
    mcv_picture_free(picture);
    mcv_rig_free(rig);
    mcv_session_close(session);
}

/* --- threads --- */

typedef struct job {
    mcv_session *session;
    const mcv_rig *rig;
    mcv_picture *picture;
    unsigned busy;
} job;

static void *render_often(void *user) {
    job *j = user;
    for (int i = 0; i < 5; ++i) {
        mcv_error error = {""};
        mcv_picture *picture = NULL;
        const mcv_result result =
            mcv_session_render(j->session, j->rig, options, NULL, NULL, &picture, NULL, &error);
        j->busy += result == MCV_USAGE;
        if (result != MCV_OK) continue;
        mcv_picture_free(j->picture);
        j->picture = picture;
    }
    return NULL;
}

/* One rig, which nobody changes, and a session for each thread. */
static void test_sessions_in_threads(void **state) {
    mcv_rig *rig = open_rig();
    job jobs[2] = {{.rig = rig}, {.rig = rig}};
    pthread_t threads[2];
    (void)state;
    for (int i = 0; i < 2; ++i) {
        jobs[i].session = open_session(NULL);
        assert_int_equal(pthread_create(threads + i, NULL, render_often, jobs + i), 0);
    }
    for (int i = 0; i < 2; ++i) assert_int_equal(pthread_join(threads[i], NULL), 0);
    for (int i = 0; i < 2; ++i) assert_int_equal(jobs[i].busy, 0);
    assert_non_null(jobs[0].picture);
    assert_non_null(jobs[1].picture);
    expect_same(jobs[0].picture, jobs[1].picture);
    for (int i = 0; i < 2; ++i) {
        mcv_picture_free(jobs[i].picture);
        mcv_session_close(jobs[i].session);
    }
    mcv_rig_free(rig);
}

/* A session moves from one thread to another. */
static void test_session_in_a_foreign_thread(void **state) {
    mcv_rig *rig = open_rig();
    job j = {.session = open_session(NULL), .rig = rig};
    pthread_t thread;
    (void)state;
    mcv_picture *here = render(j.session, rig, options);
    assert_int_equal(pthread_create(&thread, NULL, render_often, &j), 0);
    assert_int_equal(pthread_join(thread, NULL), 0);
    assert_non_null(j.picture);
    expect_same(here, j.picture);
    mcv_picture_free(j.picture);
    mcv_picture_free(here);
    mcv_rig_free(rig);
    mcv_session_close(j.session);
}

typedef struct waiting {
    job other;
    unsigned calls;
} waiting;

/* While a render is in its callback, another thread is turned away. */
static bool on_progress(void *user, const mcv_progress *progress) {
    waiting *w = user;
    pthread_t thread;
    (void)progress;
    if (w->calls++) return true;
    assert_int_equal(pthread_create(&thread, NULL, render_often, &w->other), 0);
    assert_int_equal(pthread_join(thread, NULL), 0);
    return true;
}

static void test_one_session_in_two_threads(void **state) {
    mcv_rig *rig = open_rig();
    waiting w = {.other = {.session = open_session(NULL), .rig = rig}};
    mcv_picture *picture = NULL;
    (void)state;
    WELL(
        mcv_session_render(w.other.session, rig, options, on_progress, &w, &picture, NULL, &error));
    assert_true(w.calls > 0);
    assert_int_equal(w.other.busy, 5);
    assert_null(w.other.picture);
    mcv_picture_free(picture);
    mcv_rig_free(rig);
    mcv_session_close(w.other.session);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_same_bits_as_the_program),
        cmocka_unit_test(test_sessions_in_threads),
        cmocka_unit_test(test_session_in_a_foreign_thread),
        cmocka_unit_test(test_one_session_in_two_threads),
    };
    return cmocka_run_group_tests(tests, enter_folder, leave_folder);
}
