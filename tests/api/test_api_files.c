/* SPDX-License-Identifier: Apache-2.0 */
/* Calls of the public interface that read and write the files of the program's verbs: what is in
 * memory and what is in the file is the same. No OpenCL device is needed. */
#include "api.h"

#include "program.h"

#include <pthread.h>
#include <unistd.h>

static void test_rays_of_a_file(void **state) {
    static const double rays[] = {0, 0, 0, 0, 0, -1};
    mcv_session *session = open_session("{\"device\": \"reference\"}");
    mcv_rig *rig = parse_rig(sky_rig);
    char *csv = NULL, *same = NULL, *report = NULL;
    (void)state;
    WELL(mcv_session_trace(session, rig, rays, 1, NULL, &csv, NULL, &error));
    write_file("rays.csv", "x,y,z,dx,dy,dz\n0,0,0,0,0,-2\n");
    WELL(mcv_session_trace(session, rig, NULL, 0, "{\"rays\": \"rays.csv\", \"output\": \"t.csv\"}",
                           &same, &report, &error));
    assert_string_equal(same, csv);
    assert_string_equal(read_whole("t.csv"), csv);
    assert_string_equal(report, "{\"rays\":1}");
    mcv_text_free(same);
    mcv_text_free(report);
    mcv_text_free(csv);
    FAILS(MCV_USAGE, "there are rays in memory, too",
          mcv_session_trace(session, rig, rays, 1, "{\"rays\": \"rays.csv\"}", NULL, NULL, &error));
    FAILS(MCV_USAGE, "--rays is missing",
          mcv_session_trace(session, rig, NULL, 0, NULL, NULL, NULL, &error));
    mcv_rig_free(rig);
    mcv_session_close(session);
}

/* --- renders --- */

/* What a call has told, and when it is stopped. */
typedef struct told {
    char text[8192];
    unsigned reports, writing, begun;
    bool stop;
} told;

static bool on_told(void *user, const char *report) {
    told *t = user;
    ++t->reports;
    strncat(t->text, report, sizeof t->text - strlen(t->text) - 1);
    return true;
}

static bool on_progress(void *user, const mcv_progress *progress) {
    told *t = user;
    assert_string_equal(progress->sensor, "camera");
    t->begun += progress->fraction == 0;
    t->writing += progress->writing;
    return !(t->stop && progress->writing);
}

static void expect_part(const char *path, const char *name, float value) {
    mcv_picture *picture = NULL;
    WELL(mcv_picture_read(path, &picture, &error));
    const mcv_part part = part_of(picture, 0);
    assert_string_equal(part.name, name);
    for (size_t i = 0; i < (size_t)part.width * part.height; ++i)
        assert_true(part.planes[i] == value);
    mcv_picture_free(picture);
}

static void test_renders_into_files(void **state) {
    static const char options[] = "{\"spp\": 4, \"output\": \"sky.exr\", \"camera\": \"grey.npy\", "
                                  "\"electrons_per_unit\": 1000, \"noise_free\": true}";
    mcv_session *session = open_session("{\"device\": \"reference\"}");
    mcv_rig *rig = parse_rig(sky_rig);
    told t = {.reports = 0};
    (void)state;
    WELL(mcv_session_render_files(session, rig, options, on_progress, on_told, &t, &error));
    assert_int_equal(t.begun, 1);
    assert_int_equal(t.writing, 1);
    expect_part("sky.exr", "image", 2.5F);  /* as bright as the sky */
    expect_part("grey.npy", "image", 1024); /* 2500 of 10000 electrons, of 12 bits: 1023.75 */
    json_t *summary = json_loads(t.text, JSON_DISABLE_EOF_CHECK, NULL);
    assert_string_equal(json_string_value(json_object_get(summary, "image")), "sky.exr");
    assert_true(number_at(summary, "samples") == 4);
    json_decref(summary);
    /* Stopped while it writes: what is there is whole. */
    t = (told){.stop = true};
    FAILS(MCV_INTERRUPTED, "saved in again.exr",
          mcv_session_render_files(session, rig,
                                   "{\"spp\": 4, \"output\": \"again.exr\", \"json\": false}",
                                   on_progress, on_told, &t, &error));
    expect_part("again.exr", "image", 2.5F);
    assert_non_null(strstr(t.text, "camera: 16 x 12 pixels, 4 samples each"));
    FAILS(MCV_USAGE, "belongs to --camera",
          mcv_session_render_files(session, rig, "{\"spp\": 4, \"expose_to\": 0.5}", NULL, NULL,
                                   NULL, &error));
    FAILS(MCV_BAD_INPUT, "cannot be written",
          mcv_session_render_files(session, rig, "{\"spp\": 4, \"output\": \"nowhere/x.exr\"}",
                                   NULL, NULL, NULL, &error));
    mcv_rig_free(rig);
    mcv_session_close(session);
}

/* While a render is in its callback, other sessions in another thread render into its files. */
static void *render_the_same(void *rig) {
    mcv_session *session = open_session("{\"device\": \"reference\"}");
    mcv_picture *picture = NULL;
    FAILS(MCV_BAD_INPUT, "one.checkpoint: is being written by another thread of this process",
          mcv_session_render_files(session, rig, "{\"spp\": 8, \"output\": \"one.exr\"}", NULL,
                                   NULL, NULL, &error));
    FAILS(MCV_BAD_INPUT, "one.checkpoint: is being written by another thread of this process",
          mcv_session_render(session, rig, "{\"spp\": 8, \"checkpoint\": \"one.checkpoint\"}", NULL,
                             NULL, &picture, NULL, &error));
    assert_null(picture);
    WELL(mcv_session_render_files(session, rig, "{\"spp\": 4, \"output\": \"other.exr\"}", NULL,
                                  NULL, NULL, &error));
    mcv_session_close(session);
    return NULL;
}

static bool on_progress_of_one(void *user, const mcv_progress *progress) {
    pthread_t thread;
    if (!progress->writing) return true;
    assert_int_equal(access("one.checkpoint.lock", F_OK), 0);
    assert_int_equal(pthread_create(&thread, NULL, render_the_same, user), 0);
    assert_int_equal(pthread_join(thread, NULL), 0);
    return true;
}

static void test_renders_in_threads(void **state) {
    mcv_session *session = open_session("{\"device\": \"reference\"}");
    mcv_rig *rig = parse_rig(sky_rig);
    mcv_picture *picture = NULL;
    (void)state;
    WELL(mcv_session_render_files(session, rig, "{\"spp\": 4, \"output\": \"one.exr\"}",
                                  on_progress_of_one, NULL, rig, &error));
    expect_part("one.exr", "image", 2.5F);
    expect_part("other.exr", "image", 2.5F);
    assert_int_not_equal(access("one.checkpoint.lock", F_OK), 0);
    /* Into memory: locked only where there is a checkpoint, and as long as it runs. */
    for (int i = 0; i < 2; ++i) {
        WELL(mcv_session_render(session, rig, "{\"spp\": 4, \"checkpoint\": \"one.checkpoint\"}",
                                NULL, NULL, &picture, NULL, &error));
        mcv_picture_free(picture);
    }
    assert_int_not_equal(access("one.checkpoint.lock", F_OK), 0);
    mcv_rig_free(rig);
    mcv_session_close(session);
}

/* --- pictures --- */

static void test_work_on_pictures_into_files(void **state) {
    static const float planes[16] = {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16};
    mcv_session *session = open_session("{\"device\": \"reference\"}");
    mcv_rig *rig = parse_rig(sky_rig);
    mcv_picture *light = NULL, *views = NULL, *grey = NULL;
    mcv_picture *a = render(session, rig, "{\"spp\": 4, \"parts\": \"replicates\"}");
    char *report = NULL;
    bool different = true;
    (void)state;
    WELL(mcv_picture_make(4, 4, 1, planes, NULL,
                          "{\"mcvisi:quantity\": \"irradiance\", \"mcvisi:unit\": \"W/m^2\"}",
                          &light, &error));
    WELL(mcv_picture_views(light, "{\"angular\": \"2x2\", \"output\": \"views.exr\"}", &views,
                           &report, &error));
    assert_non_null(strstr(report, "\"values\":\"views.exr\""));
    mcv_text_free(report);
    mcv_picture_free(views);
    WELL(mcv_picture_read("views.exr", &views, &error));
    assert_true(part_of(views, 0).planes[1] == 3); /* the first of each macro pixel */
    mcv_picture_free(views);
    FAILS(MCV_USAGE, "must end in .png or .exr",
          mcv_picture_views(light, "{\"angular\": \"2x2\", \"output\": \"v.jpg\"}", &views, NULL,
                            &error));
    FAILS(MCV_USAGE, "--png goes with --output",
          mcv_picture_views(light, "{\"angular\": \"2x2\", \"png\": \"v.png\"}", &views, NULL,
                            &error));
    WELL(mcv_picture_camera(light,
                            "{\"electrons_per_unit\": 100, \"bits\": 8, \"noise_free\": true, "
                            "\"output\": \"grey.png\", \"lens_mtf\": \"none\", \"json\": false}",
                            &grey, &report, &error));
    assert_non_null(strstr(report, "grey.png"));
    mcv_text_free(report);
    mcv_picture_free(grey);
    WELL(mcv_picture_read("grey.png", &grey, &error));
    /* 100 of 10000 electrons are 2.55 of 255. */
    assert_true(part_of(grey, 0).planes[0] == 3 && part_of(grey, 0).planes[1] == 5);
    mcv_picture_free(grey);
    WELL(mcv_picture_compare(a, a, "{\"output\": \"d.png\", \"json\": false}", &different, NULL,
                             &report, &error));
    assert_false(different);
    assert_non_null(strstr(report, "different               no"));
    assert_int_equal(access("d.png", R_OK), 0);
    mcv_text_free(report);
    FAILS(MCV_USAGE, "no option of this call",
          mcv_picture_compare(a, a, "{\"spp\": 4}", NULL, NULL, NULL, &error));
    mcv_picture_free(a);
    mcv_picture_free(light);
    mcv_rig_free(rig);
    mcv_session_close(session);
}

/* --- sweeps and checks --- */

static void test_reports_for_people(void **state) {
    mcv_session *session = open_session("{\"device\": \"reference\"}");
    mcv_rig *rig = parse_rig(sky_rig);
    told t = {.reports = 0};
    char *report = NULL;
    (void)state;
    WELL(mcv_session_sweep(session, rig,
                           "{\"vary\": \"emitters/sky/radiance=1,2\", \"metric\": "
                           "\"m:=image.mean\", \"region\": \"image=0,0,8,8\", \"spp\": 4, "
                           "\"json\": false}",
                           on_told, &t, &report, &error));
    assert_non_null(strstr(t.text, "1/2  radiance 1; m 1 ± 0\n2/2  radiance 2; m 2 ± 0\n"));
    assert_non_null(strstr(report, "largest m: 2 ± 0 at radiance 2\n2 sets, 0 failed"));
    mcv_text_free(report);
    report = NULL;
    FAILS(MCV_FAILED, "all 2 sets failed",
          mcv_session_sweep(session, rig,
                            "{\"vary\": \"emitters/sky/radiance=-1,-2\", \"metric\": "
                            "\"m:=image.mean\", \"region\": \"image=0,0,8,8\", \"spp\": 4}",
                            NULL, NULL, &report, &error));
    assert_non_null(strstr(report, "\"failed\":2"));
    mcv_text_free(report);
    WELL(mcv_session_check(session, rig, "{\"defines\": true}", &report, &error));
    assert_int_equal(strncmp(report, "-D", 2), 0);
    mcv_text_free(report);
    WELL(mcv_session_check(session, NULL, "{\"defines\": true}", &report, &error));
    assert_non_null(strchr(strchr(report, '\n') + 1, '\n')); /* a line for each type of sensor */
    mcv_text_free(report);
    FAILS(MCV_USAGE, "rig must not be NULL",
          mcv_session_check(session, NULL, NULL, &report, &error));
    mcv_rig_free(rig);
    mcv_session_close(session);
}

static void test_rigs_into_files(void **state) {
    static const double lower[3] = {0, 0, 0}, upper[3] = {20, 10, 5};
    mcv_rig *rig = NULL;
    char *report = NULL;
    (void)state;
    write_box_stl("box.stl", lower, upper);
    WELL(mcv_rig_new("telecentric", "box.stl",
                     "{\"unit\": \"mm\", \"output\": \"box.gltf\", \"json\": false}", &rig, &report,
                     &error));
    assert_int_equal(strncmp(report, "box.gltf\n  part            20mm x 10mm x 5mm", 44), 0);
    assert_string_equal(mcv_rig_path(rig), "box.gltf");
    mcv_text_free(report);
    mcv_rig_free(rig);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_rays_of_a_file),
        cmocka_unit_test(test_renders_into_files),
        cmocka_unit_test(test_renders_in_threads),
        cmocka_unit_test(test_work_on_pictures_into_files),
        cmocka_unit_test(test_reports_for_people),
        cmocka_unit_test(test_rigs_into_files),
    };
    mkdir("no vendors", 0777);
    setenv("OCL_ICD_VENDORS", "no vendors", 1);
    return cmocka_run_group_tests(tests, enter_folder, leave_folder);
}
