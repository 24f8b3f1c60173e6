/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Places and heights of a plane without noise, from rendered pictures, against closed forms: what
 * the head finds, how a lens skews the line, and what diffraction does.
 */
/* ctest: label truth */
#include "program.h"

#include "laser_head.h"
#include "truths.h"

#include "triangulation/laser_line.h"

#include <math.h>

/* The head of laser_head: a thin lens at f/8, 0.25 m away, whose film is tilted by τ. The plate
 * rises to the right by `slope`, so that its line crosses a pixel from column to column. */
enum { COLUMNS = 12, WIDE = 36, ROWS = 24, WINDOW = 15 };
static const double theta = M_PI / 6, distance = 0.25, focal_length = 0.025, pixel = 5e-6,
                    tilt = 10.893 * M_PI / 180, slope = 0.15, wavelength = 660e-9, f_number = 8;

/* The same with a telecentric camera, whose film stands straight: it sees no perspective. */
static const double magnification = 0.125;

static char *telecentric_head(void) {
    static const char lens[] =
        "\"type\":\"thinLens\",\"focalLength\":\"25mm\",\"focusDistance\":\"250mm\",";
    static const char tilted[] = "\"tilt\":\"10.893deg\",\"tiltDirection\":\"180deg\",";
    const char *at = strstr(laser_head, lens), *then = strstr(laser_head, tilted);
    char *text = NULL;
    assert_true(at && then);
    const char *between = at + strlen(lens);
    assert_true(asprintf(&text,
                         "%.*s\"type\":\"telecentric\",\"magnification\":%g,\"workingDistance\":"
                         "\"250mm\",%.*s%s",
                         (int)(at - laser_head), laser_head, magnification, (int)(then - between),
                         between, then + strlen(tilted)) > 0);
    return text;
}

static int write_scenes(void **state) {
    if (enter_folder(state) != 0) return -1;
    char *text = telecentric_head();
    write_file("thin.gltf", laser_head);
    write_file("telecentric.gltf", text);
    free(text);
    return 0;
}

/* The plate's picture without noise. */
static void expose(const char *scene, const char *thickness, int columns, int samples,
                   const char *lens) {
    const double half = atan(slope) / 2, top = 5e-3;
    char line[512];
    snprintf(line, sizeof line,
             "render %s --spp %d --light-paths off --adaptive off "
             "--set sensors/camera/resolution=[%d,%d] --set emitters/laser/lineThickness=%s "
             "--set nodes/plate/rotation=[0,0,%.17g,%.17g] "
             "--set nodes/plate/translation=[%.17g,%.17g,0] -o lit.exr",
             scene, samples, columns, ROWS, thickness, sin(half), cos(half), top * sin(2 * half),
             -top * cos(2 * half));
    program_well(line);
    snprintf(line, sizeof line,
             "camera lit.exr --expose-to 0.5 --wavelength 660nm --noise-free --bits 16 --lens-mtf "
             "%s -o grey.exr",
             lens);
    program_well(line);
}

static const char *const extractors[MCV_LINE_EXTRACTOR_COUNT] = {
    "cog", "parabola", "logGauss", "blaisRioux", "gauss", "steger"};

/* x, y, z, u(z) and place of a column. */
typedef double point[5];

static void triangulate(int extractor, int columns, point *points) {
    char line[256], header[128];
    snprintf(line, sizeof line, "triangulate grey.exr --laser laser --extractor %s -o z.npy",
             extractors[extractor]);
    program_well(line);
    FILE *file = fopen("z.npy", "rb");
    assert_non_null(file);
    assert_int_equal(fread(header, 1, sizeof header, file), sizeof header);
    assert_int_equal(fread(points, sizeof *points, (size_t)columns + 1, file), columns);
    fclose(file);
}

/* --- the picture by closed forms --- */

static double image_distance(void) { return focal_length * distance / (distance - focal_length); }

/*
 * The irradiance of a place of the tilted film, x to the right and s down from the axis. Its chief
 * ray meets the plate y = a x at z beside the light's plane, where the light is exp(-z²/(2σ²)); the
 * other rays meet it in that plane. The place is b - s sinτ behind the lens, and gets cosθ_film
 * cosθ_lens/ρ² of the light.
 */
static double irradiance(double x, double s, double a, double sigma) {
    const double across = s * cos(tilt), behind = image_distance() - s * sin(tilt),
                 rho = sqrt(x * x + across * across + behind * behind);
    const double right = x / behind, down = across / behind;
    const double fall = cos(theta) + down * sin(theta) + a * right,
                 z = distance * sin(theta) +
                     distance * cos(theta) / fall * (down * cos(theta) - sin(theta));
    return exp(-z * z / (2 * sigma * sigma)) * behind * (across * sin(tilt) + behind * cos(tilt)) /
           pow(rho, 4);
}

static void draw_column(int column, double a, double sigma, float values[ROWS]) {
    enum { ALONG = 4, ACROSS = 200 };
    for (int row = 0; row < ROWS; ++row) {
        double sum = 0;
        for (int i = 0; i < ALONG; ++i)
            for (int k = 0; k < ACROSS; ++k)
                sum += irradiance((column + (i + 0.5) / ALONG - COLUMNS / 2.0) * pixel,
                                  (row + (k + 0.5) / ACROSS - ROWS / 2.0) * pixel, a, sigma);
        values[row] = (float)sum;
    }
}

static double place_in(int extractor, const float values[ROWS]) {
    const mcv_line_settings settings = {.extractor = extractor, .window = WINDOW};
    const mcv_line_place line = mcv_line_find(&settings, values, NULL, ROWS, 1);
    assert_int_equal(line.state, MCV_LINE_SEEN);
    return line.place;
}

/* --- places --- */

/*
 * Every extractor finds in the rendered picture what it finds in the closed form's, its own bias
 * included, of a line with σ = 100 µm, two pixels. The device has the camera's place and the rays
 * of it in float32: 2⁻²⁷ m are 1.7e-4 pixels of 45 µm. Beside that Sobol' points leave 2e-5 and 16
 * bits 1e-5.
 */
static void test_places(void **state) {
    (void)state;
    const double bound = 0x1p-27 / 45e-6;
    point points[COLUMNS + 1];
    expose("thin.gltf", "400um", COLUMNS, 16384, "none");
    for (int e = 0; e < MCV_LINE_EXTRACTOR_COUNT; ++e) {
        double largest = 0;
        triangulate(e, COLUMNS, points);
        for (int column = 0; column < COLUMNS; ++column) {
            float values[ROWS];
            draw_column(column, slope, 1e-4, values);
            largest = fmax(largest, fabs(points[column][4] - place_in(e, values)));
        }
        print_message("%s: %.2g pixels beside the closed form\n", extractors[e], largest);
        note_truth("T30 plane: places by all extractors [pixels]", "device", largest, bound);
        if (!(largest <= bound)) fail_msg("%s: %g pixels off", extractors[e], largest);
    }
}

/*
 * How the lens skews the line, by its closed form. With the magnification's change along the film,
 * z = α s (1 + c s), c = cosτ (tanτ - tanθ)/b, and E = (1 + e s) exp(-z²/(2σ²)), e = 3 sinτ/b: the
 * mean moves by (e - 3 c) σ², a fitted Gaussian by (e - 3/2 c) σ², σ on the film. Pixels and higher
 * orders leave 5 % at σ = 1 pixel. The line lies on the axis.
 */
static void test_skew(void **state) {
    (void)state;
    const double sigma = 5e-5, b = image_distance(),
                 seen = sigma * cos(theta) / cos(tilt) * b / distance,
                 unit = cos(tilt) * seen * seen / b / pixel, centre = 3 * tan(theta) * unit,
                 fit = 1.5 * (tan(tilt) + tan(theta)) * unit;
    float values[ROWS];
    draw_column(COLUMNS / 2, 0, sigma, values);
    const double by_centre = place_in(MCV_LINE_COG, values) - ROWS / 2.0,
                 by_fit = place_in(MCV_LINE_GAUSS, values) - ROWS / 2.0;
    print_message("cog %.4g pixels, must be %.4g; gauss %.4g, must be %.4g\n", by_centre, centre,
                  by_fit, fit);
    if (!(fabs(by_centre / centre - 1) <= 0.05)) fail_msg("cog %g, not %g", by_centre, centre);
    if (!(fabs(by_fit / fit - 1) <= 0.05)) fail_msg("gauss %g, not %g", by_fit, fit);
}

/* --- heights --- */

/*
 * A telecentric camera skews nothing: heights are those of the plane within 1e-4 of the resolution,
 * p/(m sinθ) = 80 µm, by extractors without a bias of their own at σ = 1.08 pixels. Their alias is
 * exp(-2π²σ²)/π, 1e-11, and what a window of 6 σ leaves out is less.
 */
static void test_heights(void **state) {
    (void)state;
    static const int unbiased[] = {MCV_LINE_COG, MCV_LINE_GAUSS, MCV_LINE_STEGER};
    const double resolution = pixel / (magnification * sin(theta));
    point points[COLUMNS + 1];
    expose("telecentric.gltf", "200um", COLUMNS, 16384, "none");
    for (int i = 0; i < 3; ++i) {
        double largest = 0;
        triangulate(unbiased[i], COLUMNS, points);
        for (int column = 0; column < COLUMNS; ++column) {
            const double *at = points[column];
            largest = fmax(largest, fabs(at[2] + 0.2 - slope * at[0]) / resolution);
        }
        print_message("%s: %.2g of the resolution\n", extractors[unbiased[i]], largest);
        note_truth("T30 heights of a rendered plane [resolution]", "device", largest, 1e-4);
        if (!(largest <= 1e-4))
            fail_msg("%s: %g of the resolution", extractors[unbiased[i]], largest);
    }
}

/* The response of pixels to a lens of which they know frequencies up to Nyquist. */
static double spread(int pixels) {
    enum { STEPS = 4000 };
    double sum = 0;
    for (int i = 0; i < STEPS; ++i) {
        const double frequency = (i + 0.5) / STEPS / 2,
                     s = fmin(frequency * wavelength * f_number / pixel, 1);
        sum += 2 / M_PI * (acos(s) - s * sqrt(1 - s * s)) * cos(2 * M_PI * frequency * pixels);
    }
    return sum / STEPS;
}

/* A column of a telecentric picture, blurred by diffraction; its line lies at `place`. */
static void draw_blurred(double place, float values[ROWS]) {
    const double sigma = 5e-5 * cos(theta) * magnification / pixel;
    for (int row = 0; row < ROWS; ++row) {
        double sum = 0;
        for (int k = 0; k < ROWS; ++k) {
            const double from = (k - place) / sigma * M_SQRT1_2,
                         to = (k + 1 - place) / sigma * M_SQRT1_2;
            sum += spread(row - k) * (erf(to) - erf(from));
        }
        values[row] = (float)sum;
    }
}

/*
 * Diffraction gives the line wings that fall as 2 λN/(π³ x²) of its light. A centre of gravity
 * leaves out more of them on one side, up to 0.01 pixels. The biases are those of
 * docs/triangulation.md, of a line that is drawn and blurred, and the rendered picture's places
 * are that line's. Only columns 14 pixels from both borders count: beyond a border the outermost
 * pixels go on, where the line should rise. 4096 samples leave 1e-4 pixels of places, and the line,
 * which runs aslant, has frequencies that are 0.3 % higher than those along a column: 0.3 % of 0.03
 * pixels.
 */
static void test_diffraction(void **state) {
    (void)state;
    static const double documented[] = {0.010, 0.033, 0.002, 0.016, 0, 0};
    point points[WIDE + 1];
    expose("telecentric.gltf", "200um", WIDE, 4096, "diffraction");
    for (int e = 0; e < MCV_LINE_EXTRACTOR_COUNT; ++e) {
        double largest = 0, bias = 0;
        float values[ROWS];
        for (int i = -20; i <= 20; ++i) {
            const double place = ROWS / 2.0 + i / 40.0;
            draw_blurred(place, values);
            bias = fmax(bias, fabs(place_in(e, values) - place));
        }
        triangulate(e, WIDE, points);
        for (int column = 14; column < WIDE - 14; ++column) {
            draw_blurred(ROWS / 2.0 - slope * sin(theta) * (column + 0.5 - WIDE / 2.0), values);
            largest = fmax(largest, fabs(points[column][4] - place_in(e, values)));
        }
        print_message("%s: bias %.4f pixels, rendered %.2g beside it\n", extractors[e], bias,
                      largest);
        if (!(fabs(bias - documented[e]) <= 5e-4))
            fail_msg("%s: bias %g pixels, documented %g", extractors[e], bias, documented[e]);
        note_truth("T30 plane: places with diffraction [pixels]", "device", largest, 2e-4);
        if (!(largest <= 2e-4)) fail_msg("%s: %g pixels off", extractors[e], largest);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_places),
        cmocka_unit_test(test_skew),
        cmocka_unit_test(test_heights),
        cmocka_unit_test(test_diffraction),
    };
    return cmocka_run_group_tests(tests, write_scenes, leave_folder);
}
