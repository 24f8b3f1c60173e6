/* SPDX-License-Identifier: Apache-2.0 */
/* ctest: label slow */
/* What Blender really exports, where `./run deps peers` has put it: blender_peer.py says what the
 * part is. */
#include "program.h"

#include <math.h>
#include <stdbool.h>

#define PYTHON MCV_SOURCE_DIR "/build/peers/bin/python"

/* The part in the test's folder, exported once for all tests; *state stays NULL without Blender. */
static int export_part(void **state) {
    static bool exported;
    *state = NULL;
    if (!exported &&
        (access(PYTHON, X_OK) != 0 || system(PYTHON " -c 'import bpy' >/dev/null 2>&1") != 0)) {
        puts("Blender is not there: `./run deps peers` installs it");
        return 0;
    }
    if (!exported &&
        system(PYTHON " " MCV_SOURCE_DIR "/tests/peers/blender_peer.py . >blender.log 2>&1") != 0) {
        puts(read_whole("blender.log"));
        return -1;
    }
    exported = true;
    *state = &exported;
    return 0;
}

/* The defaults leave cameras and lights out; names hold dots; the part hangs below an empty. */
static void test_what_it_exports(void **state) {
    if (!*state) skip();
    json_t *document = json_load_file("part.gltf", 0, NULL);
    assert_non_null(document);
    assert_null(json_object_get(document, "cameras"));
    assert_null(json_object_get(json_object_get(document, "extensions"), "KHR_lights_punctual"));
    assert_non_null(strstr(read_whole("part.gltf"), "\"name\":\"Cube.001\""));
    json_decref(document);
    program_fails("render part.gltf", 3, "the scene has no sensor");
}

/* Metres, whichever the file; and the STL files, which Blender writes with z up, hold the same
 * part. */
static void test_size(void **state) {
    static const char *const parts[] = {"part.glb", "part.gltf", "part.stl --unit m",
                                        "ascii.stl --unit m"};
    if (!*state) skip();
    for (int i = 0; i < 4; ++i) {
        char line[128];
        snprintf(line, sizeof line, "new telecentric %s -o size.gltf", parts[i]);
        program_well(line);
        if (!strstr(said, "50mm x 30mm x 12mm, 24 triangles")) fail_msg("%s: %s", parts[i], said);
    }
}

/*
 * The silhouette of 40 x 30 and 10 x 10 mm has the border 160 mm, which lies 6 mm before and behind
 * the plane in focus: a ray of slope t misses it by 6 mm |t| more, 4 NA/(3 pi) in the mean over the
 * round stop. Five standard errors; corners: a square of 20 um of 3000 mm^2.
 */
static void test_silhouette(void **state) {
    if (!*state) skip();
    program_well("new telecentric part.glb -o rig.gltf");
    json_t *checked = program_json("check rig.gltf --json");
    const double w = number_at(checked, "sensors/0/optics/field_of_view/0"),
                 h = number_at(checked, "sensors/0/optics/field_of_view/1");
    const double grown =
        0.160 * 0.006 * 4 / (3 * M_PI) * number_at(checked, "sensors/0/optics/numerical_aperture");
    json_decref(checked);
    program_well("render rig.gltf -o part.exr --resolution 160x128 --spp 64");
    json_t *figures =
        program_json("measure part.exr --region all=0,0,160,128 --region border=0,0,160,4 --json");
    const double all = number_at(figures, "regions/0/mean/value"),
                 u = number_at(figures, "regions/0/mean/uncertainty");
    const double bright = number_at(figures, "regions/1/mean/value");
    json_decref(figures);
    const double covered = 1 - all / bright,
                 truth = (0.040 * 0.030 + 0.010 * 0.010 + grown) / (w * h);
    print_message("covered %.6f, by the sides %.6f, standard error %.6f\n", covered, truth,
                  u / bright);
    if (!(fabs(covered - truth) <= 5 * u / bright + 1e-6))
        fail_msg("covered %.6f, must be %.6f", covered, truth);
}

/* A name with a dot is one name of a path: the tab moves by 30 mm and no longer touches the plate.
 */
static void test_names_with_dots(void **state) {
    if (!*state) skip();
    json_t *checked = program_json("check lit.glb --set nodes/Cube.001/translation/x=0.055 --json");
    assert_true(fabs(number_at(checked, "size/0") - 0.080) < 1e-7); /* float32 of places of 0.1 m */
    json_decref(checked);
    program_fails("check lit.glb --set nodes/Cube.002/translation/x=0", 3,
                  "did you mean \"Cube.001\"");
}

/* With the two that the defaults leave out: Blender's 1000 W, exported in candela, are 1000 W
 * again, to float32 and its 683 lm/W. */
static void test_camera_and_light(void **state) {
    if (!*state) skip();
    json_t *checked = program_json("check lit.glb --json");
    assert_true(fabs(number_at(checked, "emitters/0/power/0") - 1000) < 1e-3);
    assert_true(fabs(number_at(checked, "sensors/0/position/0") - 7.358891) <
                1e-6); /* where Blender's first camera stands */
    json_decref(checked);
    program_well("render lit.glb --resolution 64x36 --spp 16 -o lit.exr");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(test_what_it_exports, export_part),
        cmocka_unit_test_setup(test_size, export_part),
        cmocka_unit_test_setup(test_silhouette, export_part),
        cmocka_unit_test_setup(test_names_with_dots, export_part),
        cmocka_unit_test_setup(test_camera_and_light, export_part),
    };
    return cmocka_run_group_tests(tests, enter_folder, leave_folder);
}
