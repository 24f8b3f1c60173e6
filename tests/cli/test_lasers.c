/* SPDX-License-Identifier: Apache-2.0 */
/* render --lasers and camera --speckle: from a scene to grey values with speckle. */
#include "test.h"

#include "program.h"

#include "io/exr.h"

#include <math.h>

/* A wall 0.2 m before a lens at f/8, in the light of a laser as wide as the field and of a sky.
 * Pixels of 5.28 µm are as wide as λ N. */
static const char scene[] =
    "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0,1,2,3]}],"
    "\"nodes\":[{\"name\":\"camera\",\"translation\":[0,0,0.2],\"extensions\":{\"MCVISI_sensors\":"
    "{\"sensor\":0}}},{\"name\":\"laser\",\"translation\":[0,0.01,0.2],\"extensions\":"
    "{\"MCVISI_emitters\":{\"emitter\":0}}},{\"name\":\"sky\",\"extensions\":{\"MCVISI_emitters\":"
    "{\"emitter\":1}}},{\"name\":\"wall\",\"translation\":[0,0,-0.01],\"extensions\":"
    "{\"MCVISI_surfaces\":{\"surface\":0}}}],"
    "\"materials\":[{\"name\":\"white\",\"extensions\":{\"MCVISI_materials\":"
    "{\"type\":\"diffuse\",\"reflectance\":0.5}}}],"
    "\"extensions\":{\"MCVISI_surfaces\":{\"surfaces\":[{\"name\":\"wall\",\"type\":\"box\","
    "\"width\":1,\"height\":1,\"depth\":0.02,\"material\":\"white\"}]},"
    "\"MCVISI_emitters\":{\"emitters\":[{\"name\":\"laser\",\"type\":\"laser\",\"wavelength\":"
    "\"660nm\",\"power\":%s,\"beamDiameter\":\"80mm\",\"widthMeasure\":\"1/e2\"},"
    "{\"name\":\"sky\",\"type\":\"environment\",\"radiance\":%s}]},"
    "\"MCVISI_sensors\":{\"sensors\":[{\"name\":\"camera\",\"type\":\"thinLens\","
    "\"focalLength\":\"25mm\",\"focusDistance\":\"200mm\",\"fNumber\":8,\"resolution\":[48,32],"
    "\"pixelSize\":\"5.28um\",\"radiometry\":\"irradiance\"}]}}}";

static void write_scene(const char *path, const char *power, const char *radiance) {
    char text[4096];
    snprintf(text, sizeof text, scene, power, radiance);
    write_file(path, text);
}

/* Standard deviation of grey values over their mean, without the black level, which is 0. */
static double contrast_of(const char *path) {
    mcv_exr exr;
    mcv_error error;
    double sum = 0, squares = 0;
    if (mcv_exr_read(path, &exr, &error) != MCV_OK) fail_msg("%s", error.text);
    const mcv_image *image = &exr.parts[0].image;
    const double count = (double)image->width * image->height;
    for (size_t i = 0; i < (size_t)count; ++i) {
        sum += (double)image->pixels[i];
        squares += (double)image->pixels[i] * (double)image->pixels[i];
    }
    mcv_exr_free(&exr);
    return sqrt(squares / count - sum * sum / (count * count)) * count / sum;
}

/*
 * p/(λN) is 1, so that C = 0.711 by the integral (tests/analysis/test_speckle.c), of the laser's
 * share of the light. Some 1200 grains leave 3 % of it, and the edge, which diffraction darkens, as
 * much: 12 % in all. Without speckle photons alone are left, 1/√8000.
 */
static void test_from_scene_to_speckle(void **state) {
    (void)state;
    write_scene("lit.gltf", "0.02", "0");
    program_well("render lit.gltf --spp 16 --device reference -o lit.exr");
    program_well("render lit.gltf --lasers 4 --spp 4 --device reference -o laser.exr");
    program_well("camera lit.exr --expose-to 0.2 --full-well 40000 --bits 16 -o plain.exr");
    program_well("camera lit.exr --expose-to 0.2 --full-well 40000 --bits 16 --speckle laser.exr "
                 "-o grey.exr");
    const double plain = contrast_of("plain.exr"), speckled = contrast_of("grey.exr");
    print_message("contrast %.4f, with speckle %.4f\n", plain, speckled);
    if (!(plain < 0.05) || !(fabs(speckled / 0.711 - 1) <= 0.12))
        fail_msg("contrast %g, with speckle %g, expected 0.711", plain, speckled);
    json_t *told = program_json("camera lit.exr --expose-to 0.2 --speckle laser.exr "
                                "--speckle-polarization 0 --speckle-patterns 2 --json -o grey.exr");
    if (!(fabs(number_at(told, "speckle_contrast") - 0.5) <= 1e-6))
        fail_msg("the contrast told is %g", number_at(told, "speckle_contrast"));
    json_decref(told);
}

/* The correlation of an image with another one, so many pixels to the right and down. */
static double correlation_of(const char *path, const char *with, uint32_t step_x, uint32_t step_y) {
    mcv_exr exr, other;
    mcv_error error;
    double sums[2] = {0, 0}, mean = 0;
    if (mcv_exr_read(path, &exr, &error) != MCV_OK ||
        mcv_exr_read(with, &other, &error) != MCV_OK) {
        fail_msg("%s", error.text);
        return 0;
    }
    const mcv_image *image = &exr.parts[0].image;
    const size_t count = (size_t)image->width * image->height;
    for (size_t i = 0; i < count; ++i) mean += (double)image->pixels[i] / (double)count;
    for (uint32_t y = 0; y + step_y < image->height; ++y)
        for (uint32_t x = 0; x + step_x < image->width; ++x) {
            const size_t at = (size_t)y * image->width + x;
            const double here = (double)image->pixels[at] - mean;
            sums[0] += here * here;
            sums[1] +=
                here *
                ((double)other.parts[0].image.pixels[at + step_y * image->width + step_x] - mean);
        }
    mcv_exr_free(&exr);
    mcv_exr_free(&other);
    return sums[1] / sums[0];
}

/*
 * A stop that is open on its right has grains that are longer to the side: |µ|² of its half disc,
 * integrated over pixels of λN, correlates neighbours by 0.543 across and 0.244 down.
 * 1536 pixels leave 0.026, of which 4.5 are 0.12.
 */
static void test_half_a_stop(void **state) {
    (void)state;
    write_scene("half.gltf", "0.02", "0");
    program_well("render half.gltf --spp 16 --device reference --set sensors/camera/aperture=half "
                 "-o half.exr");
    program_well("render half.gltf --lasers 4 --spp 4 --device reference "
                 "--set sensors/camera/aperture=half -o laser.exr");
    program_well("camera half.exr --expose-to 0.1 --full-well 40000 --bits 16 --speckle laser.exr "
                 "-o grey.exr");
    const double across = correlation_of("grey.exr", "grey.exr", 1, 0),
                 down = correlation_of("grey.exr", "grey.exr", 0, 1);
    print_message("neighbours: %.3f across, %.3f down\n", across, down);
    if (!(fabs(across - 0.543) <= 0.12) || !(fabs(down - 0.244) <= 0.12))
        fail_msg("neighbours: %g across, %g down", across, down);
}

/* A mask whose left half is open is a half: its cells are in the header. */
static void test_mask(void **state) {
    (void)state;
    static const char set[] = "--set sensors/camera/aperture=mask "
                              "--set 'sensors/camera/apertureMask=[[1,0],[1,0]]'";
    char line[512];
    write_scene("mask.gltf", "0.02", "0");
    snprintf(line, sizeof line, "render mask.gltf --spp 16 --device reference %s -o mask.exr", set);
    program_well(line);
    snprintf(line, sizeof line,
             "render mask.gltf --lasers 4 --spp 4 --device reference %s -o laser.exr", set);
    program_well(line);
    program_well("camera mask.exr --expose-to 0.1 --full-well 40000 --bits 16 --speckle laser.exr "
                 "-o grey.exr");
    const double across = correlation_of("grey.exr", "grey.exr", 1, 0),
                 down = correlation_of("grey.exr", "grey.exr", 0, 1);
    if (!(fabs(across - 0.543) <= 0.12) || !(fabs(down - 0.244) <= 0.12))
        fail_msg("neighbours: %g across, %g down", across, down);
}

/*
 * The wall carries its speckle: moved by three pixels, of 5.28 µm · 175/25 = 36.96 µm each, it has
 * the same grains three pixels aside. Each grain is a mean of sub-pixels whose light both renders
 * know to 1/√16 each; pixels at the border have lost what came from beyond. Where the pattern
 * belonged to the film, 1500 pixels would correlate by 0.12 at most.
 */
static void test_part_carries_its_speckle(void **state) {
    (void)state;
    write_scene("still.gltf", "0.02", "0");
    static const char *const places[] = {"0", "110.88um"};
    for (int i = 0; i < 2; ++i) {
        char line[256];
        for (int laser = 0; laser < 2; ++laser) {
            snprintf(line, sizeof line,
                     "render still.gltf --device reference --set nodes/wall/shiftX=%s --spp %s "
                     "-o %s%d.exr",
                     places[i], laser ? "16 --lasers 4" : "64", laser ? "laser" : "lit", i);
            program_well(line);
        }
        snprintf(line, sizeof line,
                 "camera lit%d.exr --expose-to 0.1 --bits 16 --noise-free --speckle laser%d.exr "
                 "-o grey%d.exr",
                 i, i, i);
        program_well(line);
    }
    const double carried = correlation_of("grey0.exr", "grey1.exr", 3, 0),
                 stays = correlation_of("grey0.exr", "grey1.exr", 0, 0);
    print_message("correlation %.3f with the wall, %.3f with the film\n", carried, stays);
    if (!(carried > 0.85) || !(fabs(stays) < 0.15))
        fail_msg("correlation %g with the wall, %g with the film", carried, stays);
}

/* The lamps' light is left out of --lasers, and refused as that of a laser. */
static void test_lamps_make_no_speckle(void **state) {
    (void)state;
    write_scene("both.gltf", "0.02", "1");
    program_well("render both.gltf --spp 4 --device reference -o both.exr");
    program_well("render both.gltf --lasers 4 --spp 4 --device reference -o laser.exr");
    program_well("camera both.exr --expose-to 0.2 --speckle laser.exr -o grey.exr");
    program_fails("camera both.exr --expose-to 0.2 --speckle both.exr -o grey.exr", 3,
                  "both.exr: is not lit by lasers of one wavelength alone");
    program_fails("camera both.exr --expose-to 0.2 --speckle laser.exr --speckle-patterns 0.5 -o "
                  "grey.exr",
                  2, "--speckle-patterns 0.5: must be at least 1");
    write_scene("dark.gltf", "0", "1");
    program_fails("render dark.gltf --lasers 4 --spp 4 --device reference -o laser.exr", 3,
                  "has no laser with power");
    program_fails("render both.gltf --lasers 65 -o laser.exr", 2, "--lasers");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_from_scene_to_speckle),
        cmocka_unit_test(test_half_a_stop),
        cmocka_unit_test(test_mask),
        cmocka_unit_test(test_part_carries_its_speckle),
        cmocka_unit_test(test_lamps_make_no_speckle),
    };
    return cmocka_run_group_tests(tests, enter_folder, leave_folder);
}
