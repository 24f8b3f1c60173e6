/* SPDX-License-Identifier: Apache-2.0 */
/* Parts as CAD programs and Blender export them (tests/scripts/parts.py) render in rigs of `mcvisi
 * new`, without being patched. */
#include "program.h"

#include <math.h>

static int make_parts(void **state) {
    return enter_folder(state) || system("python3 -B " MCV_SOURCE_DIR "/tests/scripts/parts.py .")
               ? -1
               : 0;
}

static void expect_sound(const char *rig) {
    char line[256];
    snprintf(line, sizeof line, "check %s", rig);
    program_well(line);
    if (strstr(said, "open at") || strstr(said, "lights nothing") || strstr(said, "sees nothing"))
        fail_msg("%s: %s", rig, said);
}

/*
 * The bores' area counts in the mean of a silhouette: the bracket covers 60 mm x 40 mm but for pi
 * (5^2 + 4^2) mm^2. The plate lies 8.5 to 12.5 mm behind the focus, the wall's edge as far before:
 * rims cut the cone, so edges grow by up to 4 NA/(3 pi) 12.5 mm.
 */
static void test_bracket(void **state) {
    (void)state;
    program_well("new telecentric bracket.stl --unit mm --view front");
    expect_sound("bracket-telecentric.gltf");
    json_t *checked = program_json("check bracket-telecentric.gltf --json");
    const double field = number_at(checked, "sensors/0/optics/field_of_view/0") *
                         number_at(checked, "sensors/0/optics/field_of_view/1");
    const double grown =
        4 / (3 * M_PI) * number_at(checked, "sensors/0/optics/numerical_aperture") * 0.0125;
    json_decref(checked);
    program_well("render bracket-telecentric.gltf --resolution 160x128 --spp 64 -o bracket.exr");
    json_t *figures = program_json(
        "measure bracket.exr --region all=0,0,160,128 --region border=0,0,160,4 --json");
    const double bright = number_at(figures, "regions/1/mean/value"),
                 u = number_at(figures, "regions/0/mean/uncertainty") / bright;
    const double covered = field * (1 - number_at(figures, "regions/0/mean/value") / bright);
    json_decref(figures);
    const double truth = 60e-3 * 40e-3 - M_PI * (25e-6 + 16e-6),
                 most = truth + grown * (2 * (60e-3 + 40e-3) + 2 * M_PI * 9e-3);
    print_message("covers %.2f mm2, must be %.2f to %.2f\n", 1e6 * covered, 1e6 * truth,
                  1e6 * most);
    /* A 96-gon is smaller than its circle by (2 pi/96)^2/6 of its area. */
    assert_true(covered >= truth - 5 * u * field &&
                covered <= most + 5 * u * field + M_PI * 41e-6 * 7.2e-4);
}

/* Puts materials into a rig of `new`, as a person would write them. */
static void dress_vial(const char *rig) {
    json_error_t wrong;
    json_t *root = json_load_file(rig, 0, &wrong);
    assert_non_null(root);
    json_t *entry = json_array_get(
        json_object_get(json_object_get(json_object_get(root, "extensions"), "MCVISI_assets"),
                        "assets"),
        0);
    json_object_set_new(entry, "materials",
                        json_pack("{s:s, s:s}", "Glass.001", "glass", "Water", "water"));
    json_object_set_new(entry, "nodeMaterials", json_pack("{s:s}", "Cap", "white"));
    json_object_set_new(
        root, "materials",
        json_pack("[{s:s, s:{s:{s:s, s:s}}}, {s:s, s:{s:{s:s, s:s}}}, {s:s, s:{s:{s:s, s:f}}}]",
                  "name", "glass", "extensions", "MCVISI_materials", "type", "dielectric", "glass",
                  "N-BK7", "name", "water", "extensions", "MCVISI_materials", "type", "dielectric",
                  "glass", "water", "name", "white", "extensions", "MCVISI_materials", "type",
                  "diffuse", "reflectance", 0.8));
    json_array_append_new(json_object_get(root, "extensionsUsed"), json_string("MCVISI_materials"));
    assert_int_equal(json_dump_file(root, rig, 0), 0);
    json_decref(root);
}

/*
 * Blender's glass without a thickness is a thin pane; the rig's glass and water are bodies. The
 * water touches the glass inside of its box: paths keep track of where they are.
 */
static void test_vial(void **state) {
    (void)state;
    program_well("new entocentric vial.glb --light backlight --view front");
    program_well("check vial-entocentric.gltf");
    assert_non_null(strstr(said, "Glass.001: sheet"));
    dress_vial("vial-entocentric.gltf");
    expect_sound("vial-entocentric.gltf");
    assert_non_null(strstr(said, "glass: dielectric"));
    assert_non_null(strstr(said, "water: dielectric"));
    assert_non_null(strstr(said, "white: diffuse"));
    assert_null(strstr(said, "Glass.001"));
    assert_non_null(strstr(said, "contact "));
    json_t *summary =
        program_json("render vial-entocentric.gltf --resolution 80x64 --spp 16 --json");
    json_decref(summary);
    const char *warned = read_whole("program.err");
    if (strstr(warned, "left a medium")) fail_msg("%s", warned);
}

/* A cover of clear plastic from an ASCII STL file. */
static void test_cover(void **state) {
    (void)state;
    program_well("new transparent cover.stl --unit mm --material PMMA");
    expect_sound("cover-transparent.gltf");
    assert_non_null(strstr(said, "normals "));
    program_well("render cover-transparent.gltf --resolution 40x30 --spp 16");
    assert_null(strstr(said, "left a medium"));
    program_well("lightfield emd-gradient cover-transparent.exr -o gradient.exr");
    /* Light that passes beside the part goes straight on, that through its steep rim does not: in
     * its middle row, 50 of 76.75 mm wide. */
    json_t *figures =
        program_json("measure gradient.exr --region beside=1,1,4,4 --region rim=9,13,3,4 --json");
    const double beside = number_at(figures, "regions/0/mean/value"),
                 rim = number_at(figures, "regions/1/mean/value");
    json_decref(figures);
    print_message("gradient beside the part %.4f, at its rim %.4f\n", beside, rim);
    assert_true(rim > 5 * beside);
}

/*
 * From a place x in focus the panel's cone lies about x on the camera's lens, at the distance s. A
 * weak lens in that plane turns light by x/F, so that it lies about x (1 - s/F): two places that
 * are 2 p apart differ by 2 p |1 - s/F| of a lens b/N wide. The cone stays on the lens wherever the
 * part is, so that the gradient is half of √2 times that from the middle to the rim. F of a
 * plano-convex lens of glass is R/(n - 1), 1/1000 more where it is seen from 1 mm. The rest of 3 %
 * is for the noise of 256 samples in a macro pixel and for its 9 x 9 directions, which round the
 * cone off.
 */
static void test_deflection(void **state) {
    (void)state;
    program_well("new transparent weak.stl --unit mm --material N-BK7");
    expect_sound("weak-transparent.gltf");
    json_t *checked = program_json("check weak-transparent.gltf --json");
    const double f = 0.3, n = 2.8, field = number_at(checked, "sensors/0/optics/field_of_view/0"),
                 s = number_at(checked, "sensors/0/optics/working_distance");
    json_decref(checked);
    program_well("render weak-transparent.gltf --resolution 40x30 --spp 256 -o weak.exr");
    program_well("lightfield emd-gradient weak.exr -o gradient.exr");
    json_t *figures = program_json("measure gradient.exr --region middle=18,13,4,4 --region "
                                   "left=10,13,3,4 --region low=18,21,4,3 --json");
    const double pupil = f * s / (s - f) / n, focal = 1.292 / 0.5168,
                 expected = 0.5 * M_SQRT2 * 2 * field / 40 * fabs(1 - s / focal) / pupil;
    for (int k = 0; k < 3; ++k) {
        char path[64];
        snprintf(path, sizeof path, "regions/%d/mean/value", k);
        const double gradient = number_at(figures, path);
        print_message("region %d: gradient %.5f, expected %.5f\n", k, gradient, expected);
        if (!(fabs(gradient / expected - 1) <= 0.03))
            fail_msg("region %d: gradient %.5f, expected %.5f", k, gradient, expected);
    }
    json_decref(figures);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_bracket), cmocka_unit_test(test_vial),
                                       cmocka_unit_test(test_cover),
                                       cmocka_unit_test(test_deflection)};
    return cmocka_run_group_tests(tests, make_parts, leave_folder);
}
