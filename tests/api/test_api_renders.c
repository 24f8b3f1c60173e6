/* SPDX-License-Identifier: Apache-2.0 */
/* ctest: label slow */
/* 1000 renders in one process: neither memory nor file descriptors grow. */
#include "api.h"

#include <dirent.h>
#include <time.h>
#include <unistd.h>

static double now(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static size_t resident_bytes(void) {
    char line[256];
    FILE *file = fopen("/proc/self/statm", "r");
    assert_non_null(file);
    assert_non_null(fgets(line, sizeof line, file));
    fclose(file);
    const char *resident = strchr(line, ' '); /* the second number, in pages */
    assert_non_null(resident);
    return strtoul(resident, NULL, 10) * (size_t)sysconf(_SC_PAGESIZE);
}

static size_t open_files(void) {
    size_t count = 0;
    DIR *folder = opendir("/proc/self/fd");
    assert_non_null(folder);
    while (readdir(folder)) ++count;
    closedir(folder);
    return count;
}

/* Each render changes the rig, and goes on to grey values and a measurement. */
static void one_round(mcv_session *session, mcv_rig *rig, int i) {
    mcv_picture *grey = NULL;
    char value[32], *report = NULL, *stats = NULL;
    snprintf(value, sizeof value, "%dum", 1000 + i);
    WELL(mcv_rig_set(rig, "sensors/camera/stopDiameter", value, &error));
    mcv_picture *picture = NULL;
    WELL(mcv_session_render(session, rig, "{\"spp\": 4}", NULL, NULL, &picture, &stats, &error));
    WELL(mcv_picture_camera(picture, "{\"expose_to\": 0.5}", &grey, NULL, &error));
    WELL(mcv_picture_measure(grey, NULL, NULL, NULL, &report, &error));
    mcv_text_free(report);
    mcv_text_free(stats);
    mcv_picture_free(grey);
    mcv_picture_free(picture);
}

static void test_nothing_grows(void **state) {
    enum { WARM = 100, ROUNDS = 1000 };
    mcv_session *session = open_session(NULL);
    mcv_rig *rig = NULL;
    size_t before = 0, files = 0;
    double begun = 0;
    (void)state;
    WELL(mcv_rig_open(MCV_SOURCE_DIR "/scenes/telecentric-edge.gltf", &rig, &error));
    for (int i = 0; i < WARM + ROUNDS; ++i) {
        one_round(session, rig, i);
        if (i != WARM - 1) continue;
        before = resident_bytes();
        files = open_files();
        begun = now();
    }
    const size_t after = resident_bytes();
    print_message("%.1f ms a round; memory %.1f MB, then %.1f MB; %zu files, then %zu\n",
                  1e3 * (now() - begun) / ROUNDS, 1e-6 * (double)before, 1e-6 * (double)after,
                  files, open_files());
    assert_int_equal(open_files(), files);
    /* A leak of one picture of 96 x 64 floats in each round would be 25 MB. */
    assert_true(after < before + 5000000);
    mcv_rig_free(rig);
    mcv_session_close(session);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_nothing_grows)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
