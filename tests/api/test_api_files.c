/* SPDX-License-Identifier: Apache-2.0 */
/* Calls of the public interface that read and write the files of the program's verbs: what is in
 * memory and what is in the file is the same. No OpenCL device is needed. */
#include "api.h"

#include "program.h"

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

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_rays_of_a_file),
    };
    mkdir("no vendors", 0777);
    setenv("OCL_ICD_VENDORS", "no vendors", 1);
    return cmocka_run_group_tests(tests, enter_folder, leave_folder);
}
