/* SPDX-License-Identifier: Apache-2.0 */
/* ctest: label slow */
/* ctest: timeout 900 */
/* Images relit from light transport matrices against renders, on scenes with each kind of emitter;
 * and how often the error of a relit pixel covers the truth. */
#include "../api/api.h"

#include <math.h>

#define FEW "%s\"spp\": 256, \"replicates\": 16"
#define PIXELS(size) "\"resolution\": \"" size "\", "

/* The names of scenes and their pixels; one reads out a part of its film, which keeps its size. */
static const char *const scenes[][2] = {
    {"projector.gltf", PIXELS("80x60")},        {"lens-projector.gltf", PIXELS("80x60")},
    {"light-field.gltf", PIXELS("24x18")},      {"gray-code.gltf", ""},
    {"structured-light.gltf", PIXELS("70x52")}, {"beam.gltf", PIXELS("64x48")},
    {"caustic.gltf", PIXELS("70x52")},          {"sky.gltf", PIXELS("64x48")},
    {"punctual.gltf", PIXELS("64x48")},         {"part-arealight.gltf", PIXELS("64x48")},
};

/* By pixels and by lamps: Welch's test at the level of `mcvisi compare`, 2.5e-4 for each. */
static void test_relit_images_are_rendered_ones(void **state) {
    mcv_session *session = open_session(NULL);
    (void)state;
    for (size_t i = 0; i < sizeof scenes / sizeof scenes[0]; ++i) {
        char path[512], by_pixels[256], by_lamps[256], rendering[256], *report = NULL;
        const char *const ways[] = {by_pixels, by_lamps};
        mcv_rig *rig = NULL;
        mcv_picture *rendered = NULL;
        snprintf(path, sizeof path, "%s/scenes/%s", MCV_SOURCE_DIR, scenes[i][0]);
        snprintf(rendering, sizeof rendering, "{" FEW ", \"seed\": 2}", scenes[i][1]);
        snprintf(by_pixels, sizeof by_pixels, "{" FEW ", \"seed\": 1}", scenes[i][1]);
        snprintf(by_lamps, sizeof by_lamps, "{" FEW ", \"seed\": 3, \"elements\": \"lamps\"}",
                 scenes[i][1]);
        WELL(mcv_rig_open(path, &rig, &error));
        WELL(mcv_session_render(session, rig, rendering, NULL, NULL, &rendered, NULL, &error));
        for (int way = 0; way < 2; ++way) {
            mcv_transport *transport = NULL;
            mcv_picture *relit = NULL;
            bool different = true;
            WELL(mcv_session_transport(session, rig, ways[way], NULL, NULL, &transport, NULL,
                                       &error));
            WELL(mcv_transport_relight(transport, NULL, 0, NULL, &relit, NULL, &error));
            WELL(mcv_picture_compare(relit, rendered, NULL, &different, NULL, &report, &error));
            if (different)
                fail_msg("%s by %s: relit and rendered differ: %s", scenes[i][0],
                         way ? "lamps" : "pixels", report);
            mcv_text_free(report);
            mcv_picture_free(relit);
            mcv_transport_free(transport);
        }
        mcv_picture_free(rendered);
        mcv_rig_free(rig);
    }
    mcv_session_close(session);
}

/*
 * Coverage of 95 % intervals by Student's t with 15 degrees of freedom, 2.131: over all pixels that
 * are lit, against a matrix of 256 times the samples, whose own error is a sixteenth. A share over
 * 2000 pixels or more has a standard deviation below 0.5 %; the asked range is 92 to 98 %.
 */
static void test_errors_cover(void **state) {
    mcv_session *session = open_session(NULL);
    mcv_rig *rig = NULL;
    mcv_transport *few = NULL, *many = NULL;
    mcv_picture *relit = NULL, *truth = NULL;
    mcv_part image = {.size = sizeof image}, deviation = {.size = sizeof deviation},
             exact = {.size = sizeof exact};
    size_t covered = 0, all = 0;
    (void)state;
    WELL(mcv_rig_open(MCV_SOURCE_DIR "/scenes/gray-code.gltf", &rig, &error));
    WELL(mcv_session_transport(session, rig, "{\"spp\": 256, \"replicates\": 16, \"seed\": 5}",
                               NULL, NULL, &few, NULL, &error));
    WELL(mcv_session_transport(session, rig, "{\"spp\": 65536, \"replicates\": 16, \"seed\": 6}",
                               NULL, NULL, &many, NULL, &error));
    WELL(mcv_transport_relight(few, NULL, 0, NULL, &relit, NULL, &error));
    WELL(mcv_transport_relight(many, NULL, 0, NULL, &truth, NULL, &error));
    WELL(mcv_picture_part(relit, 0, &image, &error));
    WELL(mcv_picture_part(relit, 1, &deviation, &error));
    WELL(mcv_picture_part(truth, 0, &exact, &error));
    for (size_t i = 0; i < (size_t)image.width * image.height * image.channels; ++i) {
        const double se = (double)deviation.planes[i],
                     off = fabs((double)image.planes[i] - (double)exact.planes[i]);
        if (!(se > 0)) continue;
        ++all;
        covered += off <= 2.131 * se;
    }
    const double share = (double)covered / (double)all;
    print_message("%.1f %% of %zu intervals cover the truth\n", 100 * share, all);
    if (!(all >= 2000 && share >= 0.92 && share <= 0.98))
        fail_msg("%.1f %% of %zu intervals cover the truth", 100 * share, all);
    mcv_picture_free(relit);
    mcv_picture_free(truth);
    mcv_transport_free(few);
    mcv_transport_free(many);
    mcv_rig_free(rig);
    mcv_session_close(session);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_relit_images_are_rendered_ones),
        cmocka_unit_test(test_errors_cover),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
