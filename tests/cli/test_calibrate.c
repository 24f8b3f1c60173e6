/* SPDX-License-Identifier: Apache-2.0 */
/* The plane of a laser's light from images of a target: triangulate --calibrate, --calibration, and
 * what calibration, distortion and pose bring to the budget of a scan. */
#include "test.h"

#include "laser_head.h"
#include "program.h"
#include "range_image.h"

#include <math.h>

/* Three steps of a staircase, 0.6 mm apart. */
static int make_images(void **state) {
    static const char *const places[] = {"nodes/plate/translation=[0,-0.0056,0]",
                                         "nodes/plate/translation=[0,-0.005,0]",
                                         "nodes/plate/translation=[0,-0.0044,0]"};
    char line[256];
    if (enter_folder(state) != 0) return -1;
    write_file("head.gltf", laser_head);
    for (int i = 0; i < 3; ++i) {
        snprintf(line, sizeof line,
                 "render head.gltf --spp 64 --device reference --set '%s' -o light.exr", places[i]);
        program_well(line);
        snprintf(line, sizeof line, "camera light.exr --expose-to 0.5 --wavelength 660nm -o %d.exr",
                 i);
        program_well(line);
    }
    return 0;
}

/*
 * Places are known to some 0.02 pixels, 2 µm of height and 1 µm from the plane: residuals are that
 * small. 144 points 0.5 mm about their middle know the plane to 0.1 µm there and to 0.2 mrad, and
 * heights 0.6 mm from the middle to 0.3 µm by chance; but the line's light is not even across it,
 * some 0.5 µm. So heights by the calibration agree with those by the node to 3 µm.
 */
static void test_staircase(void **state) {
    (void)state;
    json_t *told = program_json("triangulate 0.exr 1.exr 2.exr --calibrate plane.json "
                                "--target plate:y=5mm --json");
    const json_t *found = json_object_get(told, "calibration");
    const double residual = number_at(found, "residual");
    assert_true(number_at(found, "points") == 144);
    if (!(residual > 1e-7 && residual < 2e-6)) fail_msg("residual %g m", residual);
    json_decref(told);
    for (int i = 0; i < 3; ++i) {
        char line[128];
        for (int by = 0; by < 2; ++by) {
            snprintf(line, sizeof line, "triangulate %d.exr --laser laser %s -o %s.exr", i,
                     by ? "--calibration plane.json" : "", by ? "by" : "true");
            program_well(line);
        }
        const double off =
            row_mean("by.exr", "image", 0, NULL) - row_mean("true.exr", "image", 0, NULL);
        if (!(fabs(off) <= 3e-6)) fail_msg("step %d: heights differ by %g m", i, off);
    }
}

/* Heights come from the plane of the file. The light lies in the world's plane z = 0; one that is
 * 0.1 mm nearer to the camera is met 0.1 mm/tan 30° higher, where the camera looks. It is
 * (0, -cos 30°, sin 30°) · (p - (0, 0, 0.25 m)) = 0.1 mm in the camera's coordinates: y down, z
 * forward, the world's z is (0, sin 60°, -cos 60°). */
static void test_plane_of_file(void **state) {
    (void)state;
    write_file("near.json", "{\"lightPlane\": {\"point\": [0, 8.660254e-5, 0.24995], \"normal\": "
                            "[0, 0.8660254037844387, -0.5]}}");
    program_well("triangulate 1.exr --laser laser -o true.exr");
    program_well("triangulate 1.exr --laser laser --calibration near.json -o near.exr");
    const double off =
        row_mean("near.exr", "image", 0, NULL) - row_mean("true.exr", "image", 0, NULL);
    if (!(fabs(fabs(off) - 1e-4 / tan(M_PI / 6)) <= 2e-6)) fail_msg("heights differ by %g m", off);
}

static double in_budget(const json_t *told, const char *key) {
    return number_at(json_object_get(told, "budget"), key);
}

/*
 * In the budget calibration is as large as the file says: a plane 0.1 mm aside brings 173.2 µm,
 * which all together have, too. A camera that stands aside by 10 µm brings 10 µm/sin 30°, one that
 * is turned by 0.005° 0.25 m of that over sin 30°: 48.0 µm. Other turns and shifts go along the
 * line or the axis; places up to 1 mm off change that by 1 %.
 */
static void test_budget(void **state) {
    (void)state;
    json_t *told = program_json("scan head.gltf --device reference --expose-to 0.2 --spp 64 "
                                "--speckle off --budget --json --calibration near.json --pose "
                                "10um,0.005deg");
    const double calibration = in_budget(told, "calibration"),
                 all = in_budget(told, "all_together"), pose = in_budget(told, "pose");
    if (!(fabs(calibration - 1e-4 / tan(M_PI / 6)) <= 2e-6) ||
        !(fabs(all / calibration - 1) <= 0.02))
        fail_msg("calibration %g m, all together %g m", calibration, all);
    if (!(fabs(pose / 48.0e-6 - 1) <= 0.01)) fail_msg("pose %g m", pose);
    json_decref(told);
    program_fails("scan head.gltf --expose-to 0.2 --budget --pose 10um", 2,
                  "--pose 10um: must be D,A");
    program_fails("scan head.gltf --expose-to 0.2 --pose 10um,1deg", 2,
                  "--pose is a cause of the budget");
}

/*
 * k1 of 1000 moves a place at the slope r by k1 r³ h: the light crosses the axis, so that a place
 * u beside it along the line and none across moves across by nothing. The plate 0.6 mm lower lies
 * 6.8 pixels, 34 µm, from the axis: r is 1.22e-3 in the middle and 4.49e-3 at the ends, h 27.78 mm;
 * across, k1 r² 34 µm have the root of the mean square 1000 · 34 µm · 1.11e-5 over the 48 places,
 * or 0.075 pixels, of 88.4 µm each. Pixels are not the film's middle's by 1 %, and light that is
 * rendered anew places the line to 0.3 µm.
 */
static void test_distortion(void **state) {
    (void)state;
    json_t *told =
        program_json("scan head.gltf --device reference --expose-to 0.2 --spp 256 "
                     "--speckle off --budget --json --distortion ignored --set "
                     "sensors/camera/k1=1000 --set nodes/plate/translation=[0,-0.0056,0]");
    const double off = in_budget(told, "distortion");
    double squares = 0;
    for (int i = 0; i < 48; ++i) {
        const double across = 6.8 * 5e-6, along = (i - 23.5) * 5e-6, h = 25e-3 * 250 / 225,
                     r2 = (across * across + along * along) / (h * h);
        squares += pow(1000 * r2 * across / 5e-6 * 88.38e-6, 2) / 48;
    }
    if (!(fabs(off / sqrt(squares) - 1) <= 0.06))
        fail_msg("distortion %g m, expected %g m", off, sqrt(squares));
    json_decref(told);
}

static void test_bad_input(void **state) {
    (void)state;
    program_fails("triangulate 0.exr --calibrate p.json --target plate:y=5mm", 3,
                  "give images with the target at two heights or more");
    program_fails("triangulate 0.exr 1.exr --calibrate p.json", 2, "belong together");
    program_fails("triangulate 0.exr 1.exr --calibrate p.json --target plate", 2,
                  "--target plate: must be NODE:AXIS=D");
    program_fails("triangulate 0.exr 1.exr --calibrate p.json --target plat:y=5mm", 2,
                  "did you mean \"plate\"");
    program_fails("triangulate 0.exr 1.exr --calibrate none/p.json --target plate:y=5mm", 3,
                  "none");
    program_fails("triangulate 0.exr --laser laser --calibration none.json", 3, "none.json");
    program_fails("triangulate 0.exr --calibration plane.json", 2, "give --laser NODE");
    program_fails("triangulate 0.exr --laser laser --calibration head.gltf", 3,
                  "head.gltf: is no calibration");
    /* The world's y axis, along which the laser shines. */
    write_file("along.json", "{\"lightPlane\": {\"point\": [0, 0, 0.25], \"normal\": "
                             "[0, 0.5, 0.8660254037844387]}}");
    program_fails("triangulate 0.exr --laser laser --calibration along.json", 3,
                  "along.json: lightPlane/normal is the z axis of --laser laser in 0.exr");
    program_fails("triangulate 0.exr 1.exr --calibrate p.json --target plate:y=5mm --calibration "
                  "plane.json",
                  2, "in a call of its own");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_staircase), cmocka_unit_test(test_plane_of_file),
        cmocka_unit_test(test_budget),    cmocka_unit_test(test_distortion),
        cmocka_unit_test(test_bad_input),
    };
    return cmocka_run_group_tests(tests, make_images, leave_folder);
}
