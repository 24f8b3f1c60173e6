/* SPDX-License-Identifier: Apache-2.0 */
/* From a part to a rig that renders: `mcvisi new`, and what Blender's exporter writes. */
#include "program.h"

#include <math.h>

/* Boxes that lie each way, their middle anywhere; [mm]. */
static const struct {
    double lower[3], upper[3];
} boxes[] = {
    {{10, 20, 5}, {50, 50, 17}},          /* seen along z */
    {{-3, -1, -2}, {-1, 5, 6}},           /* along x */
    {{0, 100, 0}, {0.4, 100.1, 0.9}},     /* along y, and upright */
    {{-300, -20, -100}, {500, 30, 1200}}, /* large */
};

static const char *const kinds[] = {"telecentric", "entocentric", "lightfield"};

static void test_every_box_fits(void **state) {
    char line[256];
    (void)state;
    for (size_t b = 0; b < sizeof boxes / sizeof boxes[0]; ++b)
        for (size_t k = 0; k < 3; ++k) {
            double sides[3];
            write_box_stl("box.stl", boxes[b].lower, boxes[b].upper);
            snprintf(line, sizeof line, "new %s box.stl --unit mm -o rig.gltf", kinds[k]);
            program_well(line);
            json_t *checked = program_json("check rig.gltf --json");
            for (int i = 0; i < 3; ++i) sides[i] = 1e-3 * (boxes[b].upper[i] - boxes[b].lower[i]);
            for (int i = 0; i < 3; ++i)
                for (int j = i + 1; j < 3; ++j)
                    if (sides[j] > sides[i]) {
                        const double larger = sides[j];
                        sides[j] = sides[i];
                        sides[i] = larger;
                    }
            const double w = number_at(checked, "sensors/0/optics/field_of_view/0"),
                         h = number_at(checked, "sensors/0/optics/field_of_view/1");
            /* A tenth of room at least; not more than the next of the series (1.5) and the film's other shape make. */
            if (!(w >= 1.1 * sides[0] && h >= 1.1 * sides[1])) fail_msg("box %zu, %s: field %g x %g m", b, kinds[k], w, h);
            if (!(w <= 2 * sides[0] || h <= 2 * sides[1])) fail_msg("box %zu, %s: field %g x %g m is too large", b, kinds[k], w, h);
            if (json_array_size(json_object_get(checked, "warnings"))) fail_msg("box %zu, %s: check warns: %s", b, kinds[k], said);
            json_decref(checked);
        }
}

/*
 * The silhouette of a box 40 mm x 30 mm covers what its sides say: each edge pixel counts by its share, so that the mean of the image
 * tells the area, to its own noise, and nothing of the part leaves the picture, so all of the border is bright. The box reaches 6 mm
 * before and behind the plane in focus, where a ray of slope t misses it by 6 mm |t| more: 4 NA/(3 pi) in the mean over the round stop.
 */
static void test_silhouette_has_the_size(void **state) {
    (void)state;
    write_box_stl("box.stl", boxes[0].lower, boxes[0].upper);
    program_well("new telecentric box.stl --unit mm -o rig.gltf");
    json_t *checked = program_json("check rig.gltf --json");
    const double w = number_at(checked, "sensors/0/optics/field_of_view/0"), h = number_at(checked, "sensors/0/optics/field_of_view/1");
    const double grown = 2 * (0.040 + 0.030) * 0.006 * 4 / (3 * M_PI) * number_at(checked, "sensors/0/optics/numerical_aperture");
    json_decref(checked);
    program_well("render rig.gltf -o box.exr --resolution 160x128 --spp 64");
    json_t *figures = program_json("measure box.exr --region all=0,0,160,128 --region border=0,0,160,4 --json");
    const double all = number_at(figures, "regions/0/mean/value"), u = number_at(figures, "regions/0/mean/uncertainty");
    const double bright = number_at(figures, "regions/1/mean/value");
    json_decref(figures);
    const double covered = 1 - all / bright, truth = (0.040 * 0.030 + grown) / (w * h);
    print_message("covered %.6f, by the sides %.6f, standard error %.6f\n", covered, truth, u / bright);
    /* 5 standard errors of the mean; corners: a square of 10 um of the 2100 mm^2. */
    if (!(fabs(covered - truth) <= 5 * u / bright + 1e-6)) fail_msg("covered %.6f, must be %.6f", covered, truth);
}

static void test_each_renders(void **state) {
    (void)state;
    write_box_stl("box.stl", boxes[1].lower, boxes[1].upper);
    for (size_t k = 0; k < 3; ++k) {
        char line[256];
        snprintf(line, sizeof line, "new %s box.stl --unit cm -o rig.gltf", kinds[k]);
        program_well(line);
        json_t *summary = program_json(k == 2 ? "render rig.gltf --resolution 20x16 --spp 4 --json"
                                              : "render rig.gltf --resolution 80x64 --spp 4 --json");
        if (!(number_at(summary, "mean") > 0)) fail_msg("%s: the picture is black", kinds[k]);
        json_decref(summary);
    }
}

/* Lines that a person can edit: one for each thing, and a note. */
static void test_is_readable(void **state) {
    (void)state;
    write_box_stl("a part.stl", boxes[0].lower, boxes[0].upper);
    program_well("new telecentric 'a part.stl' --unit mm");
    const char *text = read_whole("a part-telecentric.gltf");
    size_t lines = 0, length = 0;
    for (const char *c = text; *c; ++c) {
        lines += *c == '\n';
        length = *c == '\n' ? 0 : length + 1;
        assert_true(length < 400);
    }
    assert_true(lines > 20 && lines < 60);
    assert_non_null(strstr(text, "\"note\": \"A telecentric camera"));
    assert_non_null(strstr(text, "\"uri\": \"a%20part.stl\", \"unit\": \"mm\""));
    program_well("check 'a part-telecentric.gltf'");
}

static void test_bad_input(void **state) {
    (void)state;
    write_box_stl("box.stl", boxes[0].lower, boxes[0].upper);
    write_file("empty.stl", "");
    write_file("cut.stl", "solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\n");
    write_file("comma.stl", "solid x\nfacet normal 0 0 1\nouter loop\nvertex 0,5 0 0\n");
    program_fails("new telecentric box.stl", 2, "is 40 x 30 x 12 of it; give --unit");
    program_fails("new telecentric box.stl --unit nm", 3, "is --unit right");
    program_fails("new telecentric box.stl --unit furlong", 2, "must be one of");
    program_fails("new periscope box.stl --unit mm", 2, "must be `new telecentric`");
    program_fails("new telecentric none.stl --unit mm", 3, "none.stl");
    program_fails("new telecentric empty.stl --unit mm", 3, "is empty");
    program_fails("new telecentric cut.stl --unit mm", 3, "truncated");
    program_fails("new telecentric comma.stl --unit mm", 3, "line 4");
    program_fails("new telecentric part.step --unit mm", 2, "convert");
    mkdir("below", 0777);
    program_fails("new telecentric box.stl --unit mm -o below/rig.gltf", 2, "copy it there");
    assert_int_not_equal(access("below/rig.gltf", F_OK), 0);
    program_well("new telecentric box.stl --unit m -o rig.gltf");
    assert_non_null(strstr(said, "is --unit right"));
}

/*
 * As Blender's exporter writes a scene by default: neither cameras nor lights, names with dots, a node per object with rotation and
 * scale, +Y up, metres; an exporter's extras; a material of its own making, double-sided.
 */
static const char blender[] =
    "{\"asset\":{\"generator\":\"Khronos glTF Blender I/O v4.2.70\",\"version\":\"2.0\"},\"scene\":0,"
    "\"extensionsUsed\":[\"KHR_materials_specular\",\"KHR_materials_ior\"],"
    "\"scenes\":[{\"name\":\"Scene\",\"nodes\":[1],\"extras\":{\"glTF2ExportSettings\":{\"export_cameras\":false}}}],"
    "\"nodes\":[{\"mesh\":0,\"name\":\"Bracket.001\",\"rotation\":[0,0.7071068286895752,0,0.7071068286895752],\"scale\":[0.02,0.02,0.02]},"
    "{\"children\":[0],\"name\":\"Empty.002\",\"translation\":[0.1,0.05,-0.2]}],"
    "\"materials\":[{\"doubleSided\":true,\"name\":\"Material.001\",\"extensions\":{\"KHR_materials_specular\":{\"specularFactor\":0.5},"
    "\"KHR_materials_ior\":{\"ior\":1.45}},\"pbrMetallicRoughness\":{\"baseColorFactor\":[0.8,0.8,0.8,1],\"metallicFactor\":0,"
    "\"roughnessFactor\":0.5}}],"
    "\"meshes\":[{\"name\":\"Mesh.003\",\"primitives\":[{\"attributes\":{\"POSITION\":0},\"indices\":1,\"material\":0}]}],"
    "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":4,\"max\":[1,1,0.5],\"min\":[-1,-1,0],\"type\":\"VEC3\"},"
    "{\"bufferView\":1,\"componentType\":5123,\"count\":12,\"type\":\"SCALAR\"}],"
    "\"bufferViews\":[{\"buffer\":0,\"byteLength\":48,\"byteOffset\":0,\"target\":34962},"
    "{\"buffer\":0,\"byteLength\":24,\"byteOffset\":48,\"target\":34963}],"
    "\"buffers\":[{\"byteLength\":72,\"uri\":\"part.bin\"}]}";

static void test_blender(void **state) {
    const float positions[12] = {-1, -1, 0, 1, -1, 0, 0, 1, 0, 0, 0, 0.5f};
    const uint16_t indices[12] = {0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3};
    (void)state;
    FILE *file = fopen("part.bin", "wb");
    assert_non_null(file);
    fwrite(positions, 4, 12, file);
    fwrite(indices, 2, 12, file);
    assert_int_equal(fclose(file), 0);
    write_file("part.gltf", blender);
    program_well("new entocentric part.gltf -o rig.gltf");
    json_t *rig = json_load_file("rig.gltf", 0, NULL);
    /* In the world: z' = -x, x' = z, twice 20 mm across and 10 mm deep, below a parent that is moved. */
    assert_true(fabs(number_at(rig, "nodes/1/translation/0") - 0.105) < 1e-6);
    assert_true(fabs(number_at(rig, "nodes/1/translation/1") - 0.05) < 1e-6);
    assert_true(fabs(number_at(rig, "nodes/1/translation/2") + 0.2) < 1e-6);
    json_decref(rig);
    json_t *checked = program_json("check rig.gltf --json");
    assert_true(number_at(checked, "sensors/0/optics/field_of_view/0") >= 0.044);
    json_decref(checked);
    program_well("render rig.gltf --resolution 40x32 --spp 4");
    /* Names with dots are names: the path ends at a slash. */
    program_well("check part.gltf --set nodes/Empty.002/translation/x=0.2 --set materials/Material.001/roughnessFactor=1 || true");
    assert_null(strstr(said, "there is no"));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_every_box_fits), cmocka_unit_test(test_silhouette_has_the_size),
        cmocka_unit_test(test_each_renders),   cmocka_unit_test(test_is_readable),
        cmocka_unit_test(test_bad_input),      cmocka_unit_test(test_blender),
    };
    return cmocka_run_group_tests(tests, enter_folder, leave_folder);
}
