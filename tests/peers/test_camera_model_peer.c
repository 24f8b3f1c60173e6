/* SPDX-License-Identifier: Apache-2.0 */
/* The camera model as OpenCV takes it, where `./run deps peers` has put OpenCV: what it projects
 * lies where the picture shows it. */
#include "program.h"

#define PYTHON MCV_SOURCE_DIR "/build/peers/bin/python"
#ifndef WHAT
#define WHAT "balls"
#endif

static void test_opencv_agrees(void **state) {
    char command[1024];
    (void)state;
    if (access(PYTHON, X_OK) != 0 || system(PYTHON " -c 'import cv2' 2>/dev/null") != 0) {
        puts("OpenCV is not there: `./run deps peers` installs it");
        skip();
    }
    snprintf(command, sizeof command,
             PYTHON " -B " MCV_SOURCE_DIR "/tests/peers/camera_model_peer.py %s " MCV_BINARY_DIR
                    "/mcvisi",
             WHAT);
    assert_int_equal(system(command), 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_opencv_agrees)};
    return cmocka_run_group_tests(tests, enter_folder, leave_folder);
}
