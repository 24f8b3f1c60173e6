/* SPDX-License-Identifier: Apache-2.0 */
/* Materials of the scene in place of an asset's own, by name and by node; and texts as CAD
 * exporters write them. */
#include "test.h"

#include "scene_files.h"

static mcv_error error;

#define TRIANGLE(material) "{\"attributes\":{\"POSITION\":0}" material "}"
#define MESH(primitives) "{\"primitives\":[" primitives "]}"

/*
 * A vial as a CAD program exports it: an assembly with parts below it, one of them twice; Blender's
 * glass without a thickness, a lamp, a material without a name, a mesh without a material; texts
 * that go on behind U+0000.
 */
/* clang-format off */
static const char vial[] =
    "{\"asset\":{\"version\":\"2.0\",\"generator\":\"CAD \\u0000 "
    "3\"},\"scene\":0,\"scenes\":[{\"nodes\":[0]}],"
    "\"extensionsUsed\":[\"VENDOR_history\"],\"extensions\":{\"VENDOR_history\":{\"steps\":"
    "\"\\u0000\\u0000\"}},"
    "\"nodes\":[{\"name\":\"Vial\",\"children\":[1,2,3,4,5],\"extras\":{\"id\\u0000\":"
    "\"x\\u0000y\"}},{\"name\":\"Body/1\",\"mesh\":0},"
    "{\"name\":\"Cap\",\"mesh\":1,\"children\":[6]},{\"name\":\"Screw\",\"mesh\":2},{\"name\":"
    "\"Screw\",\"mesh\":2},{\"mesh\":3,"
    "\"name\":\"Lamp\"},{\"name\":\"Rubber seal\\u0000\",\"mesh\":3}],"
    "\"materials\":[{\"name\":\"Glass.001\",\"pbrMetallicRoughness\":{\"roughnessFactor\":0,"
    "\"metallicFactor\":0},\"extensions\":{"
    "\"KHR_materials_transmission\":{\"transmissionFactor\":1}}},{\"name\":\"Rubber\"},{},{"
    "\"name\":\"Glow\",\"emissiveFactor\":[1,1,1]}],"
    "\"meshes\":["
    MESH(TRIANGLE(",\"material\":0")) ","
    MESH(TRIANGLE(",\"material\":1") "," TRIANGLE("")) ","
    MESH(TRIANGLE(",\"material\":2")) ","
    MESH(TRIANGLE(",\"material\":3"))
    "],"
    "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\","
    "\"min\":[0,0,0],\"max\":[1,1,0]}],"
    "\"bufferViews\":[{\"buffer\":0,\"byteLength\":36}],"
    "\"buffers\":[{\"byteLength\":36,\"uri\":\"data:application/octet-stream;base64,"
    "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA\"}]}";
/* clang-format on */

/* The rig with the rest of the entry. */
static mcv_result load_rig(const char *rest, const char *set, mcv_scene **scene) {
    free(write_bytes("replaced_vial.gltf", vial, strlen(vial)));
    char *text = text_of(
        "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0]}],\"materials\":["
        "{\"name\":\"glass\",\"extensions\":{\"MCVISI_materials\":{\"type\":\"dielectric\","
        "\"glass\":\"N-BK7\"}}},"
        "{\"name\":\"steel\",\"extensions\":{\"MCVISI_materials\":{\"type\":\"conductor\","
        "\"metal\":\"iron\"}}},"
        "{\"name\":\"light\",\"emissiveFactor\":[1,1,1]}],"
        "\"extensions\":{\"MCVISI_assets\":{\"assets\":[{\"name\":\"part\",\"uri\":\"replaced_vial."
        "gltf\"%s}]}},"
        "\"nodes\":[{\"extensions\":{\"MCVISI_assets\":{\"asset\":0}}}]}",
        rest);
    const mcv_result result = load_text("replaced_rig.gltf", text, set, scene, &error);
    free(text);
    return result;
}

/* The materials of all instances, in their order, and how many of them emit. */
static void expect_materials(const char *rest, const char *set, const char *materials,
                             uint32_t emitters) {
    char found[512] = "";
    mcv_scene *scene;
    if (load_rig(rest, set, &scene) != MCV_OK) fail_msg("%s: %s", rest, error.text);
    for (uint32_t i = 0; i < scene->instance_count; ++i)
        snprintf(found + strlen(found), sizeof found - strlen(found), "%s%s", i ? " " : "",
                 scene->materials[scene->instances[i].material].name);
    if (strcmp(found, materials) != 0)
        fail_msg("%s: \"%s\", must be \"%s\"", rest, found, materials);
    if (scene->emitter_count != emitters)
        fail_msg("%s: %u emitters, must be %u", rest, scene->emitter_count, emitters);
    /* What is replaced is not in the scene, and nothing is said about it. */
    for (uint32_t i = 0; i < scene->material_count; ++i)
        if (strstr(rest, "\"Glass.001\":\"") && strcmp(scene->materials[i].name, "Glass.001") == 0)
            fail_msg("%s: Glass.001 is left", rest);
    mcv_scene_free(scene);
}

/* Body; cap (rubber, and its mesh without a material); seal; two screws; lamp. */
static void test_whose_material(void **state) {
    (void)state;
    expect_materials("", NULL, "Glass.001 Rubber  Glow   Glow", 2);
    expect_materials(",\"materials\":{\"Glass.001\":\"glass\"}", NULL, "glass Rubber  Glow   Glow",
                     2);
    expect_materials(",\"materials\":{\"Glass.001\":\"glass\",\"2\":1}", NULL,
                     "glass Rubber  Glow steel steel Glow", 2);
    expect_materials(",\"materials\":{\"Glow\":\"steel\"}", NULL, "Glass.001 Rubber  steel   steel",
                     0);
    expect_materials(",\"nodeMaterials\":{\"Screw\":\"steel\"}", NULL,
                     "Glass.001 Rubber  Glow steel steel Glow", 2);
    /* A node's holds for those below it, the nearest one counts, and it comes before the material's
     * name. */
    expect_materials(",\"nodeMaterials\":{\"Cap\":\"steel\"}", NULL,
                     "Glass.001 steel steel steel   Glow", 1);
    expect_materials(",\"nodeMaterials\":{\"Vial\":\"glass\",\"Cap\":\"steel\"}", NULL,
                     "glass steel steel steel glass glass glass", 0);
    expect_materials(
        ",\"nodeMaterials\":{\"Body/1\":\"steel\"},\"materials\":{\"Glass.001\":\"glass\"}", NULL,
        "steel Rubber  Glow   Glow", 2);
    expect_materials(",\"material\":\"steel\"", NULL, "steel steel steel steel steel steel steel",
                     0);
    expect_materials(",\"material\":\"steel\",\"materials\":{\"Rubber\":\"glass\"}", NULL,
                     "steel glass steel steel steel steel steel", 0);
}

/* Members of the maps need not be there before, and names may hold slashes. */
static void test_set(void **state) {
    (void)state;
    expect_materials("", "assets/part/materials/Glass.001=glass", "glass Rubber  Glow   Glow", 2);
    expect_materials(",\"materials\":{\"Glass.001\":\"glass\"}",
                     "assets/part/materials/Glass.001=steel", "steel Rubber  Glow   Glow", 2);
    expect_materials("", "assets/part/nodeMaterials/Body/1=1", "steel Rubber  Glow   Glow", 2);
    expect_materials("", "assets/0/material=steel", "steel steel steel steel steel steel steel", 0);
}

static void expect_refused(const char *rest, const char *set, const char *says) {
    mcv_scene *scene;
    if (load_rig(rest, set, &scene) == MCV_OK)
        fail_msg("%s must be refused with \"%s\"", rest, says);
    if (!strstr(error.text, says)) fail_msg("%s: \"%s\" must say \"%s\"", rest, error.text, says);
}

static void test_sentences(void **state) {
    (void)state;
    expect_refused(
        ",\"material\":\"brass\"", NULL,
        "assets/part/material: there is no material \"brass\": give the file one of this "
        "name, {\"type\": \"conductor\", \"metal\": \"iron\", \"roughness\": 0.3}; metals "
        "are aluminium, chromium, copper, gold, iron, nickel, silver, titanium");
    expect_refused("", "assets/part/nodeMaterials/Vial=aluminum", "metals are aluminium");
    expect_refused("", "assets/part/nodeMaterials/Vial=Steel", "did you mean \"steel\"?");
    expect_refused(",\"materials\":{\"Glas.001\":\"glass\"}", NULL,
                   "replaced_rig.gltf: assets/part/materials/Glas.001: there is none among "
                   "the materials of \"replaced_vial.gltf\": did you mean \"Glass.001\"?");
    expect_refused(",\"materials\":{\"Ceramics\":\"glass\"}", NULL,
                   "they are \"Glass.001\", \"Rubber\", \"Glow\"");
    expect_refused(
        ",\"nodeMaterials\":{\"cap\":\"glass\"}", NULL,
        "there is none among the nodes of \"replaced_vial.gltf\": did you mean \"Cap\"?");
    expect_refused(",\"materials\":{\"Rubber\":\"brass\"}", NULL,
                   "assets/part/materials/Rubber: there is no material \"brass\"");
    expect_refused(",\"materials\":{\"Rubber\":\"gless\"}", NULL, "did you mean \"glass\"?");
    expect_refused(",\"materials\":{\"Rubber\":3}", NULL, "assets/part/materials/Rubber: index 3");
    expect_refused(",\"materials\":{\"Rubber\":\"light\"}", NULL, "emits light");
    expect_refused(",\"materials\":[\"glass\"]", NULL, "assets/part/materials: must be an object");
    expect_refused(",\"material\":\"brass\"", NULL,
                   "assets/part/material: there is no material \"brass\"");
    expect_refused("", "assets/part/materials/Rubbr=glass", "did you mean \"Rubber\"?");
    /* A name that goes on behind U+0000 shows it as the replacement character; who asks for it
     * without is told. */
    expect_refused(",\"nodeMaterials\":{\"Rubber seal\":\"glass\"}", NULL,
                   "did you mean \"Rubber seal\xef\xbf\xbd\"?");
}

static void test_texts_with_nul(void **state) {
    mcv_scene *scene;
    (void)state;
    if (load_rig(",\"nodeMaterials\":{\"Rubber seal\\u0000\":\"glass\"}", NULL, &scene) != MCV_OK)
        fail_msg("%s", error.text);
    mcv_scene_free(scene);
    must_refuse("replaced_nul.gltf",
                "{\"asset\":{\"version\":\"2.0\"},\"buffers\":[{\"byteLength\":1,\"uri\":\"a."
                "bin\\u0000\"}]}",
                "a.bin");
    /* A backslash before a text that only looks like it. */
    must_refuse(
        "replaced_nul.gltf",
        "{\"asset\":{\"version\":\"2.0\"},\"buffers\":[{\"byteLength\":1,\"uri\":\"\\\\u0000\"}]}",
        "\\u0000");
    /* Zeros in place of the blanks that fill up a GLB's JSON. */
    const char text[] = "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0]}],"
                        "\"nodes\":[{}]}\0\0\0";
    size_t size;
    unsigned char *glb = glb_of(text, NULL, 0, &size);
    for (size_t i = size; i-- > 20 && glb[i] == ' ';) glb[i] = 0;
    assert_int_equal(glb[size - 1], 0);
    char *path = write_bytes("replaced_nul.glb", glb, size);
    if (load_file(path, &scene, &error) != MCV_OK) fail_msg("%s", error.text);
    mcv_scene_free(scene);
    free(path);
    free(glb);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_whose_material),
                                       cmocka_unit_test(test_set), cmocka_unit_test(test_sentences),
                                       cmocka_unit_test(test_texts_with_nul)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
