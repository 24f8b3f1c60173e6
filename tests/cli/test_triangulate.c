/* SPDX-License-Identifier: Apache-2.0 */
/* mcvisi triangulate: from a scene of a laser head to profiles, their files, and bad input. */
#include "test.h"

#include "laser_head.h"
#include "program.h"
#include "range_image.h"

#include <math.h>

/* Images of the plate as it is, and 0.3 mm lower and 0.2 mm towards the camera. */
static int make_images(void **state) {
    if (enter_folder(state) != 0) return -1;
    write_file("head.gltf", laser_head);
    program_well("render head.gltf --spp 256 --device reference -o high.exr");
    program_well("render head.gltf --spp 256 --device reference -o low.exr "
                 "--set 'nodes/plate/translation=[0,-0.0053,0.0002]'");
    program_well("render head.gltf --spp 256 --device reference -o ahead.exr --set "
                 "'nodes/camera/target=[0,0,0.0002]' --set 'nodes/laser/target=[0,0,0.0002]'");
    program_well("render head.gltf --lasers 4 --spp 64 --device reference -o laser.exr");
    program_well("camera high.exr --expose-to 0.5 --wavelength 660nm -o 0.exr");
    program_well("camera low.exr --expose-to 0.5 --wavelength 660nm -o 1.exr");
    program_well("camera ahead.exr --expose-to 0.5 --wavelength 660nm -o 2.exr");
    program_well("camera high.exr --expose-to 0.2 --wavelength 660nm --speckle laser.exr "
                 "-o speckled.exr");
    program_well("camera high.exr --expose-to 0.5 --wavelength 660nm -o 0.png");
    return 0;
}

/* An array of 2 x 48 x 5 doubles has the range image's x, y, z, u(z) and place, but for its
 * float32. */
static void must_hold_heights(const char *array, const char *range) {
    static const char *const parts[] = {"x", "y", "image", "error", "place"};
    double sums[2][5] = {{0}}, numbers[5];
    char header[129] = "";
    FILE *file = fopen(array, "rb");
    assert_non_null(file);
    assert_int_equal(fread(header, 1, 128, file), 128);
    assert_non_null(
        strstr(header + 10, "'descr': '<f8', 'fortran_order': False, 'shape': (2,48,5,)"));
    for (int i = 0; i < 2 * 48; ++i) {
        assert_int_equal(fread(numbers, sizeof *numbers, 5, file), 5);
        for (int k = 0; k < 5; ++k) sums[i / 48][k] += numbers[k] / 48;
    }
    assert_int_equal(fread(numbers, 1, 1, file), 0);
    fclose(file);
    for (uint32_t row = 0; row < 2; ++row)
        for (int k = 0; k < 5; ++k) {
            const double mean = row_mean(range, parts[k], row, NULL);
            if (!(fabs(sums[row][k] - mean) <= 0x1p-23 * (fabs(mean) + 1e-3)))
                fail_msg("%s of profile %u: %g, and %g in the range image", parts[k], row,
                         sums[row][k], mean);
        }
}

/*
 * Heights are those of the plate: its top is 0.2 m below the laser, and 0.3 mm lower in the second
 * image. A place's uncertainty, some 0.02 pixels, is 2 µm; the mean of 48 has 0.3 µm, and 6 µm are
 * a place that is off by 0.07 pixels. In the plate's coordinates both tops are at 5 mm, and the
 * second profile lies 0.2 mm further back.
 */
static void test_heights(void **state) {
    (void)state;
    program_well("triangulate 0.exr 1.exr --laser laser --feed 0.2mm -o z.exr -o z.csv -o z.ply -o "
                 "z.npz -o z.npy");
    must_hold_heights("z.npy", "z.exr");
    assert_true(fabs(row_mean("z.exr", "image", 0, NULL) + 0.2) <= 6e-6);
    assert_true(fabs(row_mean("z.exr", "image", 1, NULL) + 0.2003) <= 6e-6);
    assert_true(fabs(row_mean("z.exr", "mask", 1, NULL) - 1) <= 1e-9);
    assert_true(fabs(row_mean("z.exr", "y", 1, NULL) - row_mean("z.exr", "y", 0, NULL) + 2e-4) <=
                1e-9);
    const double u = row_mean("z.exr", "error", 0, NULL);
    if (!(u > 1e-7 && u < 5e-6)) fail_msg("u(z) is %g m", u);
    program_well("triangulate 0.exr 1.exr --laser laser --frame plate -o p.exr");
    for (uint32_t row = 0; row < 2; ++row)
        if (!(fabs(row_mean("p.exr", "y", row, NULL) - 5e-3) <= 6e-6))
            fail_msg("the plate's top is at %g m", row_mean("p.exr", "y", row, NULL));
    assert_true(fabs(row_mean("p.exr", "image", 1, NULL) - row_mean("p.exr", "image", 0, NULL) +
                     2e-4) <= 1e-9);
}

/* A head that passes over a plate at rest: in the plate's coordinates its line goes along; in those
 * of the laser nothing tells of the way, but --feed. */
static void test_moving_head(void **state) {
    (void)state;
    program_well("triangulate 0.exr 2.exr --laser laser --frame plate -o h.exr");
    assert_true(fabs(row_mean("h.exr", "image", 1, NULL) - row_mean("h.exr", "image", 0, NULL) -
                     2e-4) <= 1e-9);
    for (uint32_t row = 0; row < 2; ++row)
        if (!(fabs(row_mean("h.exr", "y", row, NULL) - 5e-3) <= 6e-6))
            fail_msg("the plate's top is at %g m", row_mean("h.exr", "y", row, NULL));
    program_fails("triangulate 0.exr 2.exr --laser laser", 2, "give --feed D, or --frame NODE");
    program_fails("triangulate 0.exr 2.exr --laser laser --frame plate --feed 0.2mm", 2,
                  "--frame plate moves from image to image by itself: leave out --feed");
    program_well("triangulate 0.exr 2.exr --laser laser --feed 0.2mm -o h.exr");
    assert_true(fabs(row_mean("h.exr", "y", 1, NULL) - row_mean("h.exr", "y", 0, NULL) + 2e-4) <=
                1e-9);
}

/* A place in pixels needs no header but that of grey values; extractors agree. */
static void test_places(void **state) {
    (void)state;
    static const char *const extractors[] = {"cog",        "parabola", "logGauss",
                                             "blaisRioux", "gauss",    "steger"};
    for (int i = 0; i < 6; ++i) {
        char line[128];
        snprintf(line, sizeof line, "triangulate 0.png --extractor %s --json -o p.csv",
                 extractors[i]);
        json_t *told = program_json(line);
        assert_true(number_at(told, "seen") == 48);
        json_decref(told);
        FILE *file = fopen("p.csv", "r");
        char row[256];
        assert_non_null(file);
        assert_non_null(fgets(row, sizeof row, file));
        assert_string_equal(row, "profile,column,state,place_px,u_place_px,peak,sum,sigma_px\n");
        assert_non_null(fgets(row, sizeof row, file));
        const char *seen = strstr(row, "0,0,seen,");
        const double place = seen ? strtod(seen + strlen("0,0,seen,"), NULL) : NAN;
        fclose(file);
        /* The light meets the axis: the middle of 48 rows. */
        if (!(fabs(place - 24) <= 0.1)) fail_msg("%s: place %g", extractors[i], place);
    }
}

/*
 * Speckle is in the uncertainty, which heights about a straight line show: 48 places, nearly
 * independent, know their spread to 10 %, and 4.5 of that with 5 % of the integral are 50 %.
 */
static void test_speckle(void **state) {
    (void)state;
    json_t *plain = program_json("triangulate 0.exr --laser laser --json"),
           *speckled = program_json("triangulate speckled.exr --laser laser --json");
    const double u = number_at(speckled, "height_uncertainty"),
                 seen = number_at(speckled, "about_straight_lines");
    print_message("u(z) %.3g m, seen %.3g m\n", u, seen);
    assert_true(u > 3 * number_at(plain, "height_uncertainty"));
    if (!(fabs(seen / u - 1) <= 0.5)) fail_msg("u(z) %g m, seen %g m", u, seen);
    json_decref(plain);
    json_decref(speckled);
}

/*
 * The rig of `new laser`: its line is on a box's top, 12 mm above the origin, whichever side it is
 * seen from, and in focus: at f/1.4 the line of a top that is 2 mm lower is as thin as that of the
 * film's own plane, to a tenth. With pixels of 200 um the film is tilted by 32 degrees: the other
 * way, the two differ by 15 %. The line's standard deviation is a pixel, by the rig; the film's 64
 * pixels make a pixel 1 mm of height, of which 0.05 are allowed.
 */
static void test_rig(void **state) {
    (void)state;
    static const struct {
        const char *view;
        int axis;
        double top;
    } cases[] = {{"front", 2, 12e-3}, {"top", 1, 8e-3}, {"back", 2, 0}};
    const double lower[3] = {-15, -8, 0}, upper[3] = {15, 8, 12};
    write_box_stl("box.stl", lower, upper);
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        static const char *const coordinates[] = {"x", "y", "image"};
        char line[256];
        double sigmas[2];
        snprintf(line, sizeof line,
                 "new laser box.stl --unit mm --resolution 64x48 --pixel-size 200um --f-number 1.4 "
                 "--view %s --force -o rig.gltf",
                 cases[i].view);
        program_well(line);
        json_t *checked = program_json("check rig.gltf --json");
        if (json_array_size(json_object_get(checked, "warnings"))) fail_msg("%s", said);
        json_decref(checked);
        for (int lower_by = 0; lower_by < 2; ++lower_by) {
            /* Away from the laser. */
            const double shift = lower_by * (i == 2 ? 2e-3 : -2e-3);
            snprintf(line, sizeof line,
                     "render rig.gltf --spp 64 --device reference -o rig.exr "
                     "--set 'nodes/part/translation=[0,%g,%g]'",
                     cases[i].axis == 1 ? shift : 0, cases[i].axis == 2 ? shift : 0);
            program_well(line);
            program_well("camera rig.exr --expose-to 0.5 --wavelength 660nm --noise-free -o r.exr");
            json_t *told = program_json("triangulate r.exr --laser laser --frame part -o r.csv -o "
                                        "range.exr --json");
            sigmas[lower_by] = number_at(told, "line_sigma");
            /* The field is wider than the part. */
            assert_true(number_at(told, "seen") >= 48 && number_at(told, "seen") <= 60);
            json_decref(told);
            const double seen = row_mean("range.exr", coordinates[cases[i].axis], 0, NULL);
            if (!(fabs(seen - cases[i].top) <= 5e-5))
                fail_msg("%s: the top is at %g m", cases[i].view, seen);
        }
        print_message("%s: sigma %.3f, lower %.3f pixels\n", cases[i].view, sigmas[0], sigmas[1]);
        if (!(fabs(sigmas[1] / sigmas[0] - 1) <= 0.1))
            fail_msg("%s: sigma %g, lower %g pixels", cases[i].view, sigmas[0], sigmas[1]);
    }
    program_fails("new laser box.stl --unit mm --light ring -o rig.gltf", 2,
                  "a triangulation head has its laser: leave it out");
}

/* The rig gives metals the index of its laser's light, in the channels that it has; where a user
 * changes that, check tells. */
static void test_wavelength_of_metal(void **state) {
    (void)state;
    static const struct {
        const char *set, *warning; /* NULL: none */
    } cases[] = {
        {"", NULL},
        {"--set spectrum/wavelengths=587.6nm",
         "the laser has 660 nm, but material \"part\" has the index at 587.6 nm"},
        {"--set 'spectrum/wavelengths=[\"660nm\",\"549nm\",\"464nm\"]' --set "
         "'emitters/laser/power=[0.02,0,0]'",
         NULL},
        {"--set 'spectrum/wavelengths=[\"660nm\",\"549nm\",\"464nm\"]' --set "
         "'emitters/laser/power=[0.02,0.02,0]'",
         "has the index at 549 nm"},
        {"--set spectrum/wavelengths=587.6nm --set emitters/laser/power=0", NULL},
    };
    const double lower[3] = {-15, -8, 0}, upper[3] = {15, 8, 12};
    write_box_stl("block.stl", lower, upper);
    program_well("new laser block.stl --unit mm --material gold -o block.gltf");
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        char line[256];
        snprintf(line, sizeof line, "check block.gltf %s", cases[i].set);
        program_well(line);
        const char *words = cases[i].warning ? cases[i].warning : "the laser has";
        if ((strstr(said, words) != NULL) != (cases[i].warning != NULL))
            fail_msg("with \"%s\": %s", cases[i].set, said);
    }
}

static void test_bad_input(void **state) {
    (void)state;
    program_fails("triangulate 0.exr 1.exr --laser laser", 2, "give --feed D, or --frame NODE");
    program_fails("triangulate 0.exr 1.exr --laser laser --frame plate --feed 1mm", 2,
                  "moves from image to image by itself: leave out --feed");
    program_fails("triangulate 0.exr --laser lamp", 2, "lamp");
    program_fails("triangulate 0.exr --window 8", 2, "--window 8: must be odd");
    program_fails("triangulate 0.exr --feed 1mm", 2, "--feed is of heights: give --laser NODE");
    program_fails("triangulate 0.exr -o z.exr", 2, "z.exr: holds heights: give --laser NODE");
    program_fails("triangulate 0.exr -o z.txt", 2, "must end in .csv, .exr, .npz, .npy or .ply");
    program_fails("triangulate 0.exr --laser laser -o 0.exr", 2, "0.exr is one of the images");
    program_fails("triangulate none.exr", 3, "none.exr");
    program_fails("triangulate", 2, "IMAGE");
    /* An image without a header of ours has places, but no heights. */
    program_well("camera high.exr --expose-to 0.5 --wavelength 660nm -o 0.npy");
    program_well("triangulate 0.npy");
    program_fails("triangulate 0.npy --laser laser", 3, "has no camera model in its header");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_heights),   cmocka_unit_test(test_moving_head),
        cmocka_unit_test(test_places),    cmocka_unit_test(test_speckle),
        cmocka_unit_test(test_rig),       cmocka_unit_test(test_wavelength_of_metal),
        cmocka_unit_test(test_bad_input),
    };
    return cmocka_run_group_tests(tests, make_images, leave_folder);
}
