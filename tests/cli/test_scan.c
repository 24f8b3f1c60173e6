/* SPDX-License-Identifier: Apache-2.0 */
/* mcvisi scan: profiles of a head that moves, its figures, the budget of heights, and bad input. */
#include "test.h"

#include "program.h"
#include "range_image.h"

#include <math.h>

/* A laser line on a plate, and a camera 30° aside whose film is tilted so that the plane of the
 * light is in focus. A pixel stands for 45 µm along the line and 5 µm cos 10.893°/(sin 30°/9) =
 * 88.38 µm of height. The plate's top is half a pixel below the film's middle. */
static const char scene[] =
    "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0,1,2,3]}],"
    "\"extensions\":{\"MCVISI_sensors\":{\"sensors\":[{\"name\":\"camera\",\"type\":\"thinLens\","
    "\"focalLength\":\"25mm\",\"focusDistance\":\"250mm\",\"fNumber\":8,\"resolution\":[48,48],"
    "\"pixelSize\":\"5um\",\"tilt\":\"10.893deg\",\"tiltDirection\":\"180deg\","
    "\"radiometry\":\"irradiance\"}]},"
    "\"MCVISI_emitters\":{\"emitters\":[{\"name\":\"laser\",\"type\":\"laser\",\"wavelength\":"
    "\"660nm\",\"power\":0.02,\"lineThickness\":\"200um\",\"widthMeasure\":\"1/e2\","
    "\"workingDistance\":\"200mm\",\"fanAngle\":\"20deg\"},"
    "{\"name\":\"sky\",\"type\":\"environment\",\"radiance\":0}]},"
    "\"MCVISI_surfaces\":{\"surfaces\":[{\"name\":\"plate\",\"type\":\"box\",\"width\":\"100mm\","
    "\"height\":\"10mm\",\"depth\":\"100mm\",\"material\":\"grey\"}]}},"
    "\"materials\":[{\"name\":\"grey\",\"extensions\":{\"MCVISI_materials\":"
    "{\"type\":\"diffuse\",\"reflectance\":0.5}}}],"
    "\"nodes\":[{\"name\":\"camera\",\"extensions\":{\"MCVISI_pose\":{\"target\":[0,0,0],"
    "\"distance\":\"250mm\",\"elevation\":\"60deg\"},\"MCVISI_sensors\":{\"sensor\":0}}},"
    "{\"name\":\"laser\",\"extensions\":{\"MCVISI_pose\":{\"target\":[0,0,0],\"distance\":"
    "\"200mm\",\"elevation\":\"90deg\"},\"MCVISI_emitters\":{\"emitter\":0}}},"
    "{\"name\":\"plate\",\"translation\":[0,-0.00504,0],\"extensions\":{\"MCVISI_surfaces\":"
    "{\"surface\":0}}},{\"name\":\"sky\",\"extensions\":{\"MCVISI_emitters\":{\"emitter\":1}}}]}";

static int write_scene(void **state) {
    if (enter_folder(state) != 0) return -1;
    write_file("head.gltf", scene);
    return 0;
}

/*
 * A ledge of 2 mm: the third profile lies 1.4 mm beside its middle, and sees nothing. In both
 * others its top is 0.20004 m below the laser. Photons leave some 0.02 pixels, 2 µm, of a place;
 * the mean of 48 has 0.3 µm, and 6 µm are a place that is off by 0.07 pixels. A camera that stood
 * still would be off by 0.7 mm/tan 30°.
 */
static void test_moving_head(void **state) {
    (void)state;
    uint32_t count;
    program_well("scan head.gltf --set surfaces/plate/depth=2mm --device reference --spp 64 "
                 "--speckle off --expose-to 0.5 --profiles 3 --feed 0.7mm -o z.exr -o z.csv");
    for (uint32_t row = 0; row < 2; ++row) {
        const double z = row_mean("z.exr", "image", row, &count),
                     y = row_mean("z.exr", "y", row, &count);
        assert_int_equal(count, 48);
        if (!(fabs(z + 0.20004) <= 6e-6) || !(fabs(y + 7e-4 * row) <= 1e-9))
            fail_msg("profile %u: z %g m, y %g m", row, z, y);
    }
    (void)row_mean("z.exr", "image", 2, &count);
    assert_int_equal(count, 0);
    /* Places count from the whole film's beginning, of which only rows by the line are rendered. */
    const double place = row_mean("z.exr", "place", 1, &count);
    if (!(fabs(place - 24.45) <= 0.1)) fail_msg("place %g", place);
}

static double member(const json_t *told, const char *group, const char *key) {
    return number_at(json_object_get(told, group), key);
}

/*
 * Of 240 places a root mean square is known to 5 %, and 4.5 of that are 22 %. Speckle, photons and
 * rounding are independent; the run of all together has the same speckle and the same photons as
 * those of each alone, but that bright grains have more photons. The line's bend of 0.1 of its
 * length is 0.1 · 2 tan(10°) 0.2 m (2φ/20°)², which is 1/tan 30° of that in height; φ = x/0.2 m,
 * and x⁴ has the mean X⁴/5 within ±X = 1.08 mm. The bend is steeper than that of its middle by 1 %
 * at most. On a plate alone there is no multipath.
 */
static void test_budget(void **state) {
    (void)state;
    json_t *told = program_json("scan head.gltf --device reference --expose-to 0.2 --bits 8 "
                                "--read-noise 10 --profiles 5 --feed 1mm --budget --json "
                                "--set emitters/laser/straightness=0.1");
    const double speckle = member(told, "budget", "speckle"),
                 u = number_at(told, "height_uncertainty"), sum = member(told, "budget", "sum"),
                 all = member(told, "budget", "all_together"), bow = member(told, "budget", "bow"),
                 noise = member(told, "budget", "photons_and_read_noise"),
                 render = member(told, "budget", "render");
    const double largest =
        0.1 * 2 * tan(M_PI / 18) * 0.2 * pow(2 * 5.4e-3 / (M_PI / 9), 2) / tan(M_PI / 6);
    print_message("speckle %.3g m, stated %.3g; sum %.3g, all %.3g; bow %.3g, expected %.3g; noise "
                  "%.3g; render %.3g\n",
                  speckle, u, sum, all, bow, largest / sqrt(5), noise, render);
    assert_true(member(told, "budget", "multipath") == 0);
    if (!(fabs(bow / (largest / sqrt(5)) - 1) <= 0.05)) fail_msg("bow %g m", bow);
    if (!(fabs(speckle / u - 1) <= 0.3)) fail_msg("speckle %g m, stated %g m", speckle, u);
    if (!(fabs(sum / all - 1) <= 0.22)) fail_msg("sum %g m, all together %g m", sum, all);
    /* Diffraction's tails reach beyond a window of 15 pixels. */
    const double locking = member(told, "budget", "peak_locking");
    if (!(locking > 1e-8 && locking < 2e-6)) fail_msg("peak locking %g m", locking);
    assert_true(noise > 0 && noise < speckle && render > 0 && render < 0.1 * all);
    json_decref(told);
}

/* How the heights of two profiles about their means correlate. */
static double correlation(const char *path) {
    mcv_exr exr;
    mcv_error error;
    double sums[3] = {0}, means[2];
    if (mcv_exr_read(path, &exr, &error) != MCV_OK) fail_msg("%s", error.text);
    const mcv_image *z = &exr.parts[0].image;
    for (uint32_t row = 0; row < 2; ++row) means[row] = row_mean(path, "image", row, NULL);
    for (uint32_t i = 0; i < z->width; ++i) {
        const double a = (double)z->pixels[i] - means[0],
                     b = (double)z->pixels[z->width + i] - means[1];
        if (isnan(a) || isnan(b)) continue;
        sums[0] += a * a, sums[1] += a * b, sums[2] += b * b;
    }
    mcv_exr_free(&exr);
    return sums[1] / sqrt(sums[0] * sums[2]);
}

/*
 * Speckle belongs to the part. 5 µm are 0.1 grains on the film and a fortieth of the line: both
 * profiles have the same grains, of which |µ|² correlates by 0.98. 1 mm beside it are others, of
 * 48 columns as wide as a grain: 4.5/√48 is 0.65.
 */
static void test_speckle_of_part(void **state) {
    (void)state;
    program_well("scan head.gltf --device reference --expose-to 0.2 --noise-free --spp 256 "
                 "--profiles 2 --feed 5um -o near.exr");
    program_well("scan head.gltf --device reference --expose-to 0.2 --noise-free --spp 256 "
                 "--profiles 2 --feed 1mm -o far.exr");
    const double together = correlation("near.exr"), apart = correlation("far.exr");
    if (!(together > 0.9) || !(fabs(apart) < 0.65))
        fail_msg("correlation %g 5 um aside, %g 1 mm aside", together, apart);
}

/*
 * 1000 profiles per second, 0.1 mm apart, of 0.4 ms: the part moves by 40 µm, of which the camera
 * sees cos 30° at m = 1/9, and 1.22 λN are 6.442 µm: 1 + 3.849/6.442 = 1.5975 patterns. The tilt of
 * the film takes the lengths on it from those across the axis by 1/cos 10.893° at its middle.
 */
static void test_motion(void **state) {
    (void)state;
    const char *line = "scan head.gltf --device reference --spp 16 --exposure-time 0.4ms --feed "
                       "0.1mm --profiles 2 --profile-rate 1000 --json";
    json_t *told = program_json(line);
    const double patterns = member(told, "head", "speckle_patterns_by_motion"),
                 expected = 1 + 40e-6 * cos(M_PI / 6) / 9 / 6.442e-6 / cos(10.893 * M_PI / 180);
    if (!(fabs(patterns / expected - 1) <= 0.005))
        fail_msg("%g patterns, expected %g", patterns, expected);
    json_decref(told);
    program_fails(
        "scan head.gltf --exposure-time 2ms --feed 0.1mm --profiles 2 --profile-rate 1000", 2,
        "is longer than the time from profile to profile, 0.001 s");
    program_fails("scan head.gltf --expose-to 0.5 --feed 0.1mm --profiles 2 --profile-rate 9", 2,
                  "--profile-rate needs --feed and --exposure-time");
}

/* The figures of data sheets: 48 pixels of 88 µm, 47 of 45 µm; perspective changes the first by
 * some percent over its range. */
static void test_figures(void **state) {
    (void)state;
    json_t *told = program_json("scan head.gltf --device reference --spp 16 --speckle off "
                                "--exposure-time 1ms --json");
    const struct {
        const char *key;
        double value, within;
    } cases[] = {{"measuring_range", 48 * 88.38e-6, 0.05},
                 {"reference_width", 47 * 45e-6, 0.01},
                 {"resolution_x", 45e-6, 0.01},
                 {"points_per_profile", 48, 0},
                 {"height_of_a_pixel", 88.38e-6, 0.002},
                 {"profile_rate_at_most", 1000, 1e-9}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        const double seen = member(told, "head", cases[i].key);
        if (!(fabs(seen / cases[i].value - 1) <= cases[i].within))
            fail_msg("%s: %g, expected %g", cases[i].key, seen, cases[i].value);
    }
    json_decref(told);
}

/* The grey values of a scan with speckle, filter and noise are images as `camera` makes them: by
 * `triangulate` they have the same heights, to the bit. */
static void test_raw_images(void **state) {
    (void)state;
    program_well("scan head.gltf --device reference --expose-to 0.2 --profiles 2 --feed 0.3mm "
                 "--filter 660nm --filter-width 3nm --images raw -o whole.exr");
    program_well("triangulate raw0000.exr raw0001.exr --laser laser --feed 0.3mm -o parts.exr");
    static const char *const names[] = {"image", "error", "x", "y"};
    for (uint32_t row = 0; row < 2; ++row)
        for (size_t i = 0; i < sizeof names / sizeof names[0]; ++i) {
            uint32_t seen, again;
            const double a = row_mean("whole.exr", names[i], row, &seen),
                         b = row_mean("parts.exr", names[i], row, &again);
            if (!(a == b) || seen != again || seen < 40)
                fail_msg("%s of row %u: %g of %u and %g of %u", names[i], row, a, seen, b, again);
        }
    program_fails("scan head.gltf --expose-to 0.2 --device reference --images none/raw", 3,
                  "none/raw0000.exr");
}

/* The light of the first place of a table. */
static double first_sum(const char *options) {
    char line[512], row[256];
    snprintf(line, sizeof line,
             "scan head.gltf --device reference --spp 64 --speckle off --noise-free --bits 16 "
             "--exposure-time 0.2us --set sensors/camera/tilt=0 --set "
             "sensors/camera/pixelSize=100um %s -o f.csv",
             options);
    program_well(line);
    FILE *file = fopen("f.csv", "r");
    assert_non_null(file);
    for (int i = 0; i < 2; ++i) assert_non_null(fgets(row, sizeof row, file));
    fclose(file);
    const char *cell = row;
    for (int comma = 0; comma < 6; ++comma) cell = strchr(cell, ',') + 1;
    return strtod(cell, NULL);
}

/*
 * A corner of a film of 4.8 mm, 27.78 mm behind the lens, sees by tan θ = 0.12219; 660 nm √(1 -
 * (0.12129/1.8)²) = 658.50 nm, and 1.5 nm beside the middle of a band of 3 nm half of the light
 * passes. The first column's middle, 2.35 mm aside, has sin θ = 0.08430: 0.7246 nm, 1/(1 +
 * 0.4831⁴) = 0.9483. Light that is rounded to 16 bits, and what a threshold takes off its wings,
 * leave 0.5 %.
 */
static void test_filter(void **state) {
    (void)state;
    json_t *told = program_json("scan head.gltf --device reference --spp 4 --speckle off "
                                "--exposure-time 1us --filter 660nm --filter-width 3nm --json "
                                "--set sensors/camera/tilt=0 "
                                "--set sensors/camera/pixelSize=100um");
    const double middle = member(told, "head", "filter_passes_in_the_middle"),
                 corner = member(told, "head", "filter_passes_in_a_corner");
    json_decref(told);
    if (!(fabs(middle - 1) <= 1e-9) || !(fabs(corner - 0.5) <= 0.002))
        fail_msg("%g in the middle, %g in a corner", middle, corner);
    const double share = first_sum("--filter 660nm --filter-width 3nm") / first_sum("");
    if (!(fabs(share - 0.9483) <= 0.005))
        fail_msg("%g of the light passes, expected 0.9483", share);
    program_fails("scan head.gltf --expose-to 0.5 --filter 690nm --filter-width 20nm", 2,
                  "the laser's 660 nm lie outside of the filter's band, 680 … 700 nm");
    program_fails("scan head.gltf --expose-to 0.5 --filter 660nm", 2,
                  "--filter and --filter-width make a filter together");
    program_fails(
        "scan head.gltf --expose-to 0.5 --filter 660nm --filter-width 9nm --filter-index 0.5", 2,
        "--filter-index 0.5: must be at least 1");
}

static void test_bad_input(void **state) {
    (void)state;
    program_fails("scan head.gltf --expose-to 0.5 --profiles 2", 2, "--feed is missing, or 0");
    program_fails("scan head.gltf --expose-to 0.5 --profiles 2 --feed 0", 2,
                  "--feed is missing, or 0");
    program_fails("scan head.gltf --expose-to 0.5 --feed 1mm", 2,
                  "give their number by --profiles");
    program_fails("scan head.gltf --profiles 2 --feed 1mm", 2, "--expose-to");
    program_fails("scan head.gltf --expose-to 0.5 --set emitters/sky/radiance=1", 3,
                  "a scan is of lasers of one wavelength alone: switch off other lamps");
    program_fails("scan head.gltf --expose-to 0.5 --laser lamp", 2, "lamp");
    program_fails("scan head.gltf --expose-to 0.5 --window 8", 2, "--window 8: must be odd");
    program_fails("scan head.gltf --expose-to 0.5 -o z.txt", 2, "must end in .csv");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_moving_head),     cmocka_unit_test(test_budget),
        cmocka_unit_test(test_speckle_of_part), cmocka_unit_test(test_motion),
        cmocka_unit_test(test_figures),         cmocka_unit_test(test_filter),
        cmocka_unit_test(test_raw_images),      cmocka_unit_test(test_bad_input),
    };
    return cmocka_run_group_tests(tests, write_scene, leave_folder);
}
