/* SPDX-License-Identifier: Apache-2.0 */
/* ctest: label slow */
/* ctest: timeout 900 */
/* How often the stated errors of deflections cover the truth. */
#include "transport.h"

#include <math.h>

enum { PLACES_X = 40, PLACES_Y = 10, PLACES = PLACES_X * PLACES_Y, SEEDS = 4 };

static mcv_picture *deflection_of(mcv_session *session, const mcv_rig *rig, int samples, int seed) {
    char options[256];
    mcv_picture *picture = NULL, *histogram = NULL;
    snprintf(options, sizeof options,
             "{\"spp\": %d, \"seed\": %d, \"replicates\": 16, \"set\": "
             "[\"sensors/camera/regionOfInterest=[60,55,40,10]\"]}",
             samples, seed);
    mcv_transport *transport = transport_of(session, rig, options);
    WELL(mcv_transport_deflection(transport, NULL, NULL, &picture, &histogram, NULL, &error));
    mcv_picture_free(histogram);
    mcv_transport_free(transport);
    return picture;
}

/*
 * Coverage of 95 % intervals by Student's t with 15 degrees of freedom, 2.131, of the deflections
 * of the report's lens in x and y, against one of 64 times the samples, whose own error is an
 * eighth: it widens differences by 0.8 %, which takes 0.2 % from the coverage. 3200 intervals:
 * their share has the standard deviation 0.4 %. The asked range is 92 to 98 %.
 */
static void test_errors_cover(void **state) {
    (void)state;
    mcv_session *session = open_session(NULL);
    mcv_rig *rig = NULL;
    int covered = 0, all = 0;
    WELL(mcv_rig_open(MCV_SOURCE_DIR "/scenes/report-clean.glb", &rig, &error));
    mcv_picture *truth = deflection_of(session, rig, 64 * 64, 100);
    const float *exact = planes_of(truth, 0);
    for (int seed = 1; seed <= SEEDS; ++seed) {
        mcv_picture *found = deflection_of(session, rig, 64, seed);
        const float *mean = planes_of(found, 0), *deviation = planes_of(found, 1);
        for (int i = 0; i < 2 * PLACES; ++i) {
            if (!(deviation[i] > 0)) continue;
            ++all;
            covered += fabs((double)mean[i] - (double)exact[i]) <= 2.131 * (double)deviation[i];
        }
        mcv_picture_free(found);
    }
    const double share = (double)covered / all;
    print_message("%.2f %% of %d intervals cover the truth\n", 100 * share, all);
    assert_true(all > 3000);
    if (!(share >= 0.92 && share <= 0.98))
        fail_msg("%.2f %% of %d intervals cover the truth", 100 * share, all);
    mcv_picture_free(truth);
    mcv_rig_free(rig);
    mcv_session_close(session);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_errors_cover)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
