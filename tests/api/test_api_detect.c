/* SPDX-License-Identifier: Apache-2.0 */
/* mcvisi detect and mcv_picture_detect: a closed form through renders of the reference renderer,
 * and what is refused. No OpenCL device is needed. */
#include "api.h"

#include "blurred_edge.h"
#include "program.h"

#include <math.h>

#define RENDER "render sky.gltf --device reference --spp 8 --parts replicates "

/* The sky is 2.5 without the defect and 2.6 with it, without noise. */
static int make_pictures(void **state) {
    if (enter_folder(state)) return -1;
    write_file("sky.gltf", sky_rig);
    program_well(RENDER "-o without.exr");
    program_well(RENDER "--set emitters/sky/radiance=2.6 -o with.exr");
    program_well(RENDER "--resolution 8x6 -o small.exr");
    program_well("render sky.gltf --device reference --spp 8 -o lone.exr");
    program_well(RENDER "--replicates 2 -o two.exr");
    return 0;
}

/* 1000 electrons per unit; 12 bits of 10000 electrons: Δ = 100, σ² = 2500 + 1/(12 K²) with K =
 * 0.4095, in each of 16 x 12 pixels. Pixels are float32: 1e-5 of Δ. */
static void tells_the_closed_form(void **state) {
    const double variance = 2500 + 1 / (12 * 0.4095 * 0.4095);
    (void)state;
    json_t *report =
        program_json("detect with.exr without.exr --electrons-per-unit 1000 --json -o mask.png");
    const double squared = 192 * 1e4 / variance, value = number_at(report, "detectability/value");
    if (fabs(value / sqrt(squared) - 1) > 1e-5)
        fail_msg("d' is %.9g, must be %.9g", value, sqrt(squared));
    assert_true(fabs(number_at(report, "detectability/low") / value - 1) < 1e-5);
    assert_true(fabs(number_at(report, "contrast/value") / 0.04 - 1) < 1e-5);
    assert_true(fabs(number_at(report, "rms_contrast/value") / 0.04 - 1) < 1e-5);
    assert_true(fabs(number_at(report, "mean") / 2500 - 1) < 1e-5);
    assert_true(fabs(number_at(report, "noise") / sqrt(variance) - 1) < 1e-5);
    assert_true(number_at(report, "values") == 192);
    assert_true(number_at(report, "visible") == 0); /* 2 σ each */
    json_decref(report);
    assert_int_equal(access("mask.png", F_OK), 0);
    /* A quarter of the pixels has half of d', and each shows it from 1.9 σ on. */
    report = program_json("detect with.exr without.exr --electrons-per-unit 1000 --json "
                          "--within 4,3,8,6 --visible 1.9");
    assert_true(fabs(number_at(report, "detectability/value") / (sqrt(squared) / 2) - 1) < 1e-5);
    assert_true(number_at(report, "visible") == 48);
    json_decref(report);
    /* Without a defect there is nothing to find: hits are as rare as false calls. */
    report = program_json("detect without.exr without.exr --electrons-per-unit 1000 --json");
    assert_true(number_at(report, "detectability/high") == 0);
    assert_true(fabs(number_at(report, "found_at_1_percent_false_calls") - 0.01) < 1e-9);
    json_decref(report);
}

static void the_library_gives_sigmas(void **state) {
    mcv_picture *with = NULL, *without = NULL, *visible = NULL;
    mcv_part part = {.size = sizeof part};
    char *report = NULL;
    (void)state;
    WELL(mcv_picture_read("with.exr", &with, &error));
    WELL(mcv_picture_read("without.exr", &without, &error));
    WELL(mcv_picture_detect(with, without, "{\"electrons_per_unit\": 1000}", &visible, &report,
                            &error));
    assert_non_null(strstr(report, "\"detectability\""));
    mcv_text_free(report);
    WELL(mcv_picture_part(visible, 0, &part, &error));
    const double sigmas = 100 / sqrt(2500 + 1 / (12 * 0.4095 * 0.4095));
    assert_int_equal(part.width, 16);
    for (int i = 0; i < 192; ++i) assert_true(fabs((double)part.planes[i] / sigmas - 1) < 1e-5);
    FAILS(MCV_USAGE, "exactly once",
          mcv_picture_detect(with, without, NULL, NULL, &report, &error));
    assert_null(report);
    mcv_picture_free(with);
    mcv_picture_free(without);
    mcv_picture_free(visible);
}

/* A plate in the light of a sky, seen straight from above at a scale of 1: a pixel sees 50 µm. */
#define DUG(defect) \
    "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0,1,2]}]," \
    "\"extensionsUsed\":[\"MCVISI_defects\",\"MCVISI_emitters\",\"MCVISI_sensors\"]," \
    "\"extensions\":{\"MCVISI_sensors\":{\"sensors\":[{\"name\":\"cam\",\"type\":" \
    "\"telecentric\",\"magnification\":1,\"workingDistance\":0.1,\"fNumber\":8," \
    "\"resolution\":[64,48],\"pixelSize\":5e-5}]},\"MCVISI_emitters\":{\"emitters\":[{" \
    "\"name\":\"sky\",\"type\":\"environment\",\"radiance\":1}]}," \
    "\"MCVISI_defects\":{\"defects\":[" defect "]}}," \
    "\"buffers\":[{\"byteLength\":60,\"uri\":\"data:application/octet-stream;base64," \
    "CtejvArXo7wAAAAACtejPArXo7wAAAAACtejPArXozwAAAAACtejvArXozwAAAAAAAABAAIAAAACAAMA\"}]," \
    "\"bufferViews\":[{\"buffer\":0,\"byteLength\":48},{\"buffer\":0,\"byteOffset\":48," \
    "\"byteLength\":12}],\"accessors\":[{\"bufferView\":0,\"componentType\":5126," \
    "\"count\":4,\"type\":\"VEC3\",\"min\":[-0.02,-0.02,0],\"max\":[0.02,0.02,0]}," \
    "{\"bufferView\":1,\"componentType\":5123,\"count\":6,\"type\":\"SCALAR\"}]," \
    "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"indices\":1}]}]," \
    "\"nodes\":[{\"name\":\"plate\",\"mesh\":0},{\"name\":\"cam\",\"translation\":" \
    "[0,0,0.1],\"extensions\":{\"MCVISI_sensors\":{\"sensor\":0}}},{\"name\":\"sky\"," \
    "\"extensions\":{\"MCVISI_emitters\":{\"emitter\":0}}}]}"

/* A block and a ball of glass, seen by the same camera. */
#define GLASS(surface, defect) \
    "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0,1]}]," \
    "\"extensionsUsed\":[\"MCVISI_defects\",\"MCVISI_materials\",\"MCVISI_sensors\"," \
    "\"MCVISI_surfaces\"]," \
    "\"extensions\":{\"MCVISI_sensors\":{\"sensors\":[{\"name\":\"cam\",\"type\":" \
    "\"telecentric\",\"magnification\":1,\"workingDistance\":0.1,\"fNumber\":8," \
    "\"resolution\":[64,48],\"pixelSize\":5e-5}]},\"MCVISI_surfaces\":{\"surfaces\":[{" surface \
    ",\"material\":\"glass\"}]},\"MCVISI_defects\":{\"defects\":[" defect "]}}," \
    "\"materials\":[{\"name\":\"glass\",\"extensions\":{\"MCVISI_materials\":{\"type\":" \
    "\"dielectric\",\"ior\":1.5}}}]," \
    "\"nodes\":[{\"name\":\"part\",\"extensions\":{\"MCVISI_surfaces\":{\"surface\":0}}},{" \
    "\"name\":\"cam\",\"translation\":[0,0,0.1],\"extensions\":{\"MCVISI_sensors\":{" \
    "\"sensor\":0}}}]}"
#define BLOCK "\"type\":\"box\",\"width\":0.01,\"height\":0.01,\"depth\":0.004"
#define BALL "\"type\":\"sphere\",\"radius\":1.1e-3"

/* A disc of 1 mm covers π/4 400 pixels of 50 µm. 8 x 8 rays a pixel count lattice points in a
 * circle of the radius 80: off by less than 2 √2 π 80 of 20106 (Gauss), and for chords of the
 * outline by less than (size/32)²/size² of it. A dent of 1/e² diameter 1 mm is above a hundredth up
 * to r = √(2 ln 100) s = 0.759 mm. A ball of glass shows what lies in its middle n times as large:
 * a ray that passes the middle at b outside passes it at b/n inside. */
static void tells_which_pixels_see_it(void **state) {
    const struct {
        const char *rig;
        double diameter;
    } cases[] = {{DUG("{\"type\":\"dig\",\"node\":\"plate\",\"at\":[0,0,0],\"size\":1e-3}"), 1e-3},
                 {DUG("{\"type\":\"chip\",\"node\":\"plate\",\"at\":[0,0,0],\"size\":2e-3,"
                      "\"depth\":1.3397459621556135e-4}"),
                  1e-3},
                 {DUG("{\"type\":\"dent\",\"node\":\"plate\",\"at\":[0,0,0],\"size\":1e-3}"),
                  2 * 0.25e-3 * 3.0348542587702925},
                 {GLASS(BLOCK, "{\"type\":\"bubble\",\"node\":\"part\",\"at\":[0,0,0],"
                               "\"size\":1e-3}"),
                  1e-3},
                 {GLASS(BALL, "{\"type\":\"bubble\",\"node\":\"part\",\"at\":[0,0,0],"
                              "\"size\":1e-3}"),
                  1.5e-3},
                 {GLASS(BLOCK, "{\"type\":\"crack\",\"node\":\"part\",\"at\":[0,0,0],"
                               "\"size\":1e-3,\"direction\":[0,0,1]}"),
                  1e-3},
                 {GLASS(BLOCK, "{\"type\":\"dig\",\"node\":\"part\",\"at\":[0,0,-0.002],"
                               "\"size\":1e-3}"),
                  1e-3}};
    (void)state;
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        write_file("dug.gltf", cases[i].rig);
        if (i == 0)
            program_well(
                "render dug.gltf --device reference --spp 8 --parts replicates -o dug.exr");
        json_t *report =
            program_json("detect dug.exr dug.exr --expose-to 0.5 --json --rig dug.gltf "
                         "--truth truth.png --html seen.html");
        const double r = cases[i].diameter / 2 / 50e-6, wanted = M_PI * r * r,
                     tolerance = 2 * M_SQRT2 * M_PI * r / 8 + wanted / 1024,
                     area = number_at(report, "truth/area");
        if (!(fabs(area - wanted) < tolerance))
            fail_msg("%zu: %g pixels, must be %g within %g", i, area, wanted, tolerance);
        assert_true(number_at(report, "truth/pixels") >= area);
        assert_true(number_at(report, "truth/visible") == 0);
        json_decref(report);
        assert_int_equal(access("truth.png", F_OK), 0);
        const char *page = read_whole("seen.html");
        static const char *const parts[] = {"do not differ", "looks at it", "<svg",
                                            "What was simulated, and what not", "dug.exr"};
        for (size_t k = 0; k < sizeof parts / sizeof parts[0]; ++k)
            if (!strstr(page, parts[k])) fail_msg("%zu: the page has no \"%s\"", i, parts[k]);
    }
    program_fails("detect dug.exr dug.exr --expose-to 0.5 --truth t.png", 2, "--rig is missing");
    program_fails("detect with.exr with.exr --expose-to 0.5 --rig sky.gltf", 3, "has no defect");
    program_fails("detect dug.exr dug.exr --expose-to 0.5 --rig dug.gltf --truth t.jpg", 2, ".png");
}

/* Pixels of s/11 and a step of s/20 change the bound by less than 1 %, electrons in the variance by
 * 0.2 %; the renders know d' to 1 %, as its interval says. */
static void tells_the_bound_of_a_depth(void **state) {
    static const char *const shapes[] = {"half", "disc"};
    (void)state;
    write_file("edge.gltf", EDGE);
    for (int i = 0; i < 2; ++i) {
        char text[512];
        for (int far = 0; far < 2; ++far) {
            snprintf(text, sizeof text,
                     "render edge.gltf --device reference --depth 1 --spp 1024 --parts replicates "
                     "--set sensors/cam/aperture=%s --set nodes/plate/shiftZ=%s -o %s.exr",
                     shapes[i], far ? "-1mm" : "1mm", far ? "far" : "near");
            program_well(text);
        }
        json_t *report = program_json("detect far.exr near.exr --electrons-per-unit 1000 "
                                      "--read-noise 500 --lens-mtf none --step 2mm --json");
        const double truth = edge_bound(0.004, i == 0, 500 / 1000.0),
                     value = number_at(report, "bound/value");
        print_message("  %s: u(z) %.4g mm, must be %.4g mm\n", shapes[i], 1e3 * value, 1e3 * truth);
        assert_true(number_at(report, "bound/low") <= value);
        assert_true(number_at(report, "bound/high") >= value);
        if (!(fabs(value / truth - 1) < 0.03)) fail_msg("%g m, must be %g m", value, truth);
        json_decref(report);
    }
}

static void refuses_bad_input(void **state) {
    (void)state;
    program_fails("detect with.exr small.exr --expose-to 0.5", 3, "16 x 12 pixels");
    program_fails("detect with.exr lone.exr --expose-to 0.5", 3, "--parts replicates");
    program_fails("detect with.exr two.exr --expose-to 0.5", 3, "both must have as many");
    program_fails("detect with.exr without.exr", 2, "exactly once");
    program_fails("detect with.exr", 2, "WITHOUT.exr");
    program_fails("detect with.exr without.exr --expose-to 0.5 --step 0mm", 2, "must be above 0");
    program_fails("detect with.exr without.exr --expose-to 0.5 --step 5kg", 2, "as in 1mm");
    program_fails("detect with.exr none.exr --expose-to 0.5", 3, "none.exr");
    program_fails("detect with.exr without.exr --expose-to 0.5 -o mask.jpg", 2, ".png");
    program_fails("detect with.exr without.exr --expose-to 0.5 --within 10,10,9,9", 2, "10,10,9,9");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(tells_the_closed_form), cmocka_unit_test(the_library_gives_sigmas),
        cmocka_unit_test(tells_which_pixels_see_it), cmocka_unit_test(tells_the_bound_of_a_depth),
        cmocka_unit_test(refuses_bad_input)};
    return cmocka_run_group_tests(tests, make_pictures, leave_folder);
}
