/* SPDX-License-Identifier: Apache-2.0 */
/* The figure `bound` of experiments: the Cramér-Rao bound of a parameter, against its closed form,
 * over masks, lenses and noise. */
#include "experiment_files.h"

#include "blurred_edge.h"

#define RENDERS "--device reference --depth 1 --spp 2048 "
/* Nearer by 2 mm about 120 mm, which changes the blur by 1/20. */
#define STEP "--set nodes/plate/shiftZ=-1mm --bound nodes/plate/shiftZ=2mm "
#define CAMERA "--electrons-per-unit 1000 --lens-mtf none --read-noise "

/* Within 3 % as pixels, step and electrons allow (test_api_detect), and the render's noise that the
 * figure states, four of its uncertainties. */
static void must_be(double value, double uncertainty, double truth, const char *what) {
    print_message("  %s: %.4g mm +- %.2g, must be %.4g mm\n", what, 1e3 * value, 1e3 * uncertainty,
                  1e3 * truth);
    if (!(fabs(value - truth) < 0.03 * truth + 4 * uncertainty))
        fail_msg("%s: %g m, must be %g m", what, value, truth);
    if (!(uncertainty < 0.05 * truth)) fail_msg("%s: +- %g m says nothing", what, uncertainty);
}

static void test_over_masks_and_lenses(void **state) {
    static const char *const shapes[] = {"half", "disc"};
    (void)state;
    for (int i = 0; i < 2; ++i) {
        char line[512];
        double row[5];
        snprintf(line, sizeof line,
                 "sweep s.gltf --set sensors/cam/aperture=%s --vary sensors/cam/lensDiameter=6mm,"
                 "8mm " RENDERS STEP CAMERA "500 --metric bound --best bound=smallest -o %s.csv",
                 shapes[i], shapes[i]);
        program_well(line);
        snprintf(line, sizeof line, "%s.csv", shapes[i]);
        const char *table = read_whole(line);
        read_numbers(table, 0, row, 4);
        must_be(row[2], row[3], edge_bound(0.003, i == 0, 0.5), shapes[i]);
        read_numbers(table, 1, row, 4);
        must_be(row[2], row[3], edge_bound(0.004, i == 0, 0.5), shapes[i]);
    }
    assert_non_null(strstr(read_whole("half.html"), "bound [mm]"));
}

/* It is what detect --step tells of the two pictures, but for their float32. */
static void test_is_what_detect_says(void **state) {
    double row[6];
    (void)state;
    program_well(
        "sweep s.gltf --set sensors/cam/aperture=half --vary sensors/cam/lensDiameter=8mm " RENDERS
            STEP CAMERA "500 --metric bound -o b.csv");
    read_numbers(read_whole("b.csv"), 0, row, 4);
    program_well("render s.gltf " RENDERS
                 "--parts replicates --set sensors/cam/aperture=half --set "
                 "nodes/plate/shiftZ=-1mm -o far.exr");
    program_well("render s.gltf " RENDERS
                 "--parts replicates --set sensors/cam/aperture=half --set "
                 "nodes/plate/shiftZ=1mm -o near.exr");
    json_t *report = program_json("detect near.exr far.exr --step 2mm --json " CAMERA "500");
    const double value = number_at(report, "bound/value");
    if (!(fabs(row[2] / value - 1) < 1e-4)) fail_msg("%.9g, and detect says %.9g", row[2], value);
    json_decref(report);
}

/* Of half of the rows it is √2 larger, and with twice the noise twice as large. The parameter may
 * vary itself. */
static void test_rows_and_noise(void **state) {
    double row[8];
    (void)state;
    program_well("sweep s.gltf --vary nodes/plate/shiftZ=-1mm --set sensors/cam/aperture=half "
                 "--bound nodes/plate/shiftZ=2mm " RENDERS CAMERA
                 "1000 --region top=0,0,48,8 --metric top.bound -o b.csv");
    read_numbers(read_whole("b.csv"), 0, row, 4);
    must_be(row[2], row[3], sqrt(2) * edge_bound(0.004, true, 1), "8 rows, twice the noise");
}

/* It falls with the root of the radius: the widest lens is best. */
static void test_optimize(void **state) {
    (void)state;
    json_t *report = program_json("optimize s.gltf --vary sensors/cam/lensDiameter=4mm..8mm "
                                  "--device reference --depth 1 --spp 256 " STEP CAMERA
                                  "500 --metric bound --objective bound=smallest --evaluations 20 "
                                  "--json -o o.csv");
    const double best = number_at(report, "winner/parameters/lensDiameter");
    if (!(best > 0.0075)) fail_msg("the best lens has %g m", best);
    json_decref(report);
}

static void test_bad_input(void **state) {
    (void)state;
#define SWEEP "sweep s.gltf --vary sensors/cam/lensDiameter=8mm --metric "
    program_fails(SWEEP "bound", 2, "give --bound PATH=STEP");
    program_fails(SWEEP "bound --bound nodes/plate/shiftZ=1mm", 2, "--expose-to");
    program_fails(SWEEP "bound --expose-to 0.5 --bound nodes/plate/shiftZ", 2, "PATH=STEP");
    program_fails(SWEEP "bound --expose-to 0.5 --bound nodes/plate/shiftZ=0", 2, "above 0");
    program_fails(SWEEP "bound --expose-to 0.5 --bound nodes/plaet/shiftZ=1mm", 3, "plaet");
    program_fails(SWEEP "bound --expose-to 0.5 --bound sensors/cam/type=1", 3, "is no number");
    program_fails(SWEEP "bound --expose-to 0.5 --bound nodes/plate/shiftZ=1mm --until bound=1", 2,
                  "leave out --until");
    program_fails(SWEEP "bound --expose-to 0.5 --bound nodes/plate/shiftZ=1mm --replicates 1", 2,
                  "give --replicates 2 or more");
    program_fails(SWEEP "all.bound --expose-to 0.5 --bound nodes/plate/shiftZ=1mm", 2, "\"all\"");
    program_fails("sweep s.gltf --vary sensors/cam/aperture=half,disc --metric bound --expose-to "
                  "0.5 --bound sensors/cam/aperture=1",
                  2, "are words");
    /* A step that nothing in the picture tells. */
    program_fails(SWEEP "bound --expose-to 0.5 --bound nodes/sky/shiftX=1mm " RENDERS, 1,
                  "render more samples, or take a larger step");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        FRESH(test_over_masks_and_lenses, EDGE), FRESH(test_is_what_detect_says, EDGE),
        FRESH(test_rows_and_noise, EDGE), FRESH(test_optimize, EDGE), FRESH(test_bad_input, EDGE)};
    return cmocka_run_group_tests(tests, enter_folder, leave_folder);
}
