/* SPDX-License-Identifier: Apache-2.0 */
/* Parts from STL files: binary and ASCII give the same triangles, in the stated unit; whatever is
 * wrong is one sentence. */
#include "test.h"

#include <locale.h>
#include <math.h>
#include <unistd.h>

#include "check/findings.h"
#include "comma_locale.h"
#include "scene_files.h"
#include "scene/geometry.h"

/* A tetrahedron, outwards; 30 x 20 x 10. */
enum { TRIANGLES = 4, BYTES = 84 + 50 * TRIANGLES };
static const float corners[TRIANGLES][9] = {{0, 0, 0, 0, 20, 0, 30, 0, 0},
                                            {0, 0, 0, 30, 0, 0, 0, 0, 10},
                                            {0, 0, 0, 0, 0, 10, 0, 20, 0},
                                            {30, 0, 0, 0, 20, 0, 0, 0, 10}};

static void make_binary(unsigned char bytes[BYTES], const char *header) {
    memset(bytes, 0, BYTES);
    strcpy((char *)bytes, header);
    bytes[80] = TRIANGLES;
    for (int t = 0; t < TRIANGLES; ++t)
        memcpy(bytes + 84 + 50 * t + 12, corners[t], sizeof corners[t]);
}

/* With numbers as C programs, exponents and odd blanks write them. */
static char *make_ascii(void) {
    char *text = NULL;
    size_t size;
    FILE *stream = open_memstream(&text, &size);
    fputs("solid a part\r\n", stream);
    for (int t = 0; t < TRIANGLES; ++t) {
        fputs("  FACET normal 0 0 0\r\n    outer loop\r\n", stream);
        for (int v = 0; v < 3; ++v) {
            const float *p = corners[t] + 3 * v;
            fprintf(stream, "\tvertex %e  %g %.3f\r\n", (double)p[0], (double)p[1], (double)p[2]);
        }
        fputs("    endloop\r\n  endfacet\r\n", stream);
        if (t == 1) fputs("endsolid a part\r\nsolid\n", stream);
    }
    fputs("endsolid", stream);
    fclose(stream);
    return text;
}

static const char rig[] =
    "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0,1]}],\"materials\":[{"
    "\"name\":\"brass.001\"},{\"name\":"
    "\"lamp\","
    "\"emissiveFactor\":[1,1,1]},{\"name\":\"twice\"},{\"name\":\"twice\"}],\"extensionsUsed\":["
    "\"MCVISI_assets\"],\"extensions\":{"
    "\"MCVISI_assets\":{\"assets\":[{\"uri\":\"stl_part.stl\"%s}]},\"MCVISI_sensors\":{\"sensors\":"
    "[{\"type\":\"telecentric\","
    "\"magnification\":0.2,"
    "\"workingDistance\":0.1,\"fNumber\":8,\"resolution\":[100,100],\"pixelSize\":0.0001}]}},"
    "\"nodes\":[{\"name\":\"part\",\"extensions\":{"
    "\"MCVISI_assets\":{\"asset\":0}}},{\"extensions\":{\"MCVISI_sensors\":{\"sensor\":0}}}]}";

static mcv_result load_part(const void *bytes, size_t size, const char *rest, mcv_scene **scene,
                            mcv_error *error) {
    char *text = text_of(rig, rest);
    free(write_bytes("stl_part.stl", bytes, size));
    const mcv_result result = load_text("stl_rig.gltf", text, NULL, scene, error);
    free(text);
    return result;
}

static mcv_scene *must_load(const void *bytes, size_t size, const char *rest) {
    mcv_scene *scene;
    mcv_error error;
    if (load_part(bytes, size, rest, &scene, &error) != MCV_OK) fail_msg("%s", error.text);
    return scene;
}

/* Millimetres: the float32 of the file times 1e-3 in double. */
static void expect_part(const mcv_scene *scene, const char *material) {
    assert_int_equal(scene->instance_count, 1);
    assert_int_equal(scene->triangle_count, TRIANGLES);
    assert_string_equal(scene->instances[0].name, "part");
    assert_string_equal(scene->materials[scene->instances[0].material].name, material);
    for (uint32_t t = 0; t < TRIANGLES; ++t) {
        double found[3][3];
        mcv_scene_corners(scene, 0, t, found);
        for (int i = 0; i < 9; ++i)
            if (fabs(found[i / 3][i % 3] - 1e-3 * (double)corners[t][i]) > 1e-16)
                fail_msg("triangle %u: %g", t, found[i / 3][i % 3]);
    }
    uint32_t edges;
    mcv_error error;
    assert_int_equal(mcv_open_edges(scene, 0, 1, &edges, &error), MCV_OK);
    assert_int_equal(edges, 0);
}

static void test_binary(void **state) {
    unsigned char bytes[BYTES];
    (void)state;
    make_binary(bytes, "made by hand");
    mcv_scene *scene = must_load(bytes, BYTES, ",\"unit\":\"mm\",\"material\":\"brass.001\"");
    expect_part(scene, "brass.001");
    mcv_scene_free(scene);
    /* Some programs begin their binary files like the others. */
    make_binary(bytes, "solid but binary");
    scene = must_load(bytes, BYTES, ",\"unit\":\"mm\",\"material\":0");
    expect_part(scene, "brass.001");
    mcv_scene_free(scene);
}

/* Numbers in the file have points, whatever the program that reads them thinks of commas. */
static void test_ascii_in_a_foreign_locale(void **state) {
    char *text = make_ascii(), half[8];
    (void)state;
    const bool made = make_comma_locale();
    if (made) {
        assert_non_null(setlocale(LC_ALL, "comma"));
        snprintf(half, sizeof half, "%g", 0.5);
        assert_string_equal(half, "0,5");
    }
    mcv_scene *scene = must_load(text, strlen(text), ",\"unit\":\"mm\",\"material\":\"brass.001\"");
    expect_part(scene, "brass.001");
    mcv_scene_free(scene);
    setlocale(LC_ALL, "C");
    if (system("rm -rf comma comma.definition comma.log") != 0)
        fail_msg("the locale is left behind");
    free(text);
    if (!made) skip();
}

static void expect_refused(const void *bytes, size_t size, const char *rest, const char *part) {
    mcv_scene *scene;
    mcv_error error;
    if (load_part(bytes, size, rest, &scene, &error) == MCV_OK)
        fail_msg("loaded, but should say: %s", part);
    if (!strstr(error.text, part)) fail_msg("\"%s\" is missing in: %s", part, error.text);
    assert_null(scene);
}

static void test_bad_files(void **state) {
    static const char mm[] = ",\"unit\":\"mm\"";
    unsigned char bytes[BYTES + 1];
    char *text = make_ascii();
    const size_t length = strlen(text);
    mcv_scene *scene;
    mcv_error error;
    (void)state;
    make_binary(bytes, "made by hand");
    expect_refused(bytes, 0, mm, "stl_part.stl: is empty");
    for (size_t size = 1; size < BYTES; ++size)
        expect_refused(bytes, size, mm,
                       size < 84 ? "are too few for an STL file" : "it is truncated");
    bytes[BYTES] = 0;
    expect_refused(bytes, BYTES + 1, mm, "states 4 triangles, which take 284 bytes, but has 285");
    bytes[80] = 0;
    expect_refused(bytes, 84, mm, "holds no triangle");
    bytes[80] = TRIANGLES;
    memset(bytes + 84 + 12, 0xff, 4);
    expect_refused(bytes, BYTES, mm, "must be finite");

    /* Between two solids it is whole. */
    const char *first = strstr(text, "endsolid") + strlen("endsolid");
    const size_t whole = (size_t)(first - text), next = (size_t)(strstr(first, "solid") - text);
    for (size_t size = 6; size < length - 1; size += 7)
        if (size >= whole && size <= next)
            continue;
        else if (load_part(text, size, mm, &scene, &error) == MCV_OK)
            fail_msg("%zu of %zu bytes were loaded", size, length);
        else if (!strstr(error.text, "stl_part.stl: "))
            fail_msg("%zu bytes: %s", size, error.text);
    strchr(text, 'e')[0] = 'E'; /* 3.000000E+01 */
    *strchr(strstr(text, "vertex"), '.') = ',';
    expect_refused(text, length, mm, "has a decimal comma");
    expect_refused(text, length, mm, "line 4: ");
    free(text);
    static const char *const cases[][2] = {
        {"solid\nendsolid\n", "holds no triangle"},
        {"solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 zero",
         "line 4: \"zero\" is not a number"},
        {"solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nendloop",
         "line 6: \"endloop\" must be `vertex`"},
        {"solid a\nface normal 0 0 1\n", "line 2: \"face\" must be `facet` or `endsolid`"},
        {"solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 inf\nvertex 1 0 0\nvertex 0 1 "
         "0\nendloop\nendfacet\nendsolid",
         "must be finite"},
        {"o cube\nv 1 2 3\n", "are too few for an STL file"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i)
        expect_refused(cases[i][0], strlen(cases[i][0]), mm, cases[i][1]);
}

static void test_units_and_materials(void **state) {
    unsigned char bytes[BYTES];
    mcv_error error = {""};
    (void)state;
    make_binary(bytes, "made by hand");
    expect_refused(bytes, BYTES, "", "assets/0/unit: is missing");
    expect_refused(bytes, BYTES, "", "30 x 20 x 10 units large");
    expect_refused(bytes, BYTES, ",\"unit\":\"foot\"", "must be one of nm, um, mm, cm, m, inch");
    expect_refused(bytes, BYTES, ",\"unit\":\"mm\",\"material\":\"steel\"",
                   "there is no material \"steel\"");
    expect_refused(bytes, BYTES, ",\"unit\":\"mm\",\"material\":\"twice\"", "ambiguous");
    expect_refused(bytes, BYTES, ",\"unit\":\"mm\",\"material\":7", "material: index 7");
    expect_refused(bytes, BYTES, ",\"unit\":\"mm\",\"material\":\"lamp\"", "emits light");
    /* The wrong unit is legal; `check` says the size. */
    mcv_scene *scene = must_load(bytes, BYTES, ",\"unit\":\"m\"");
    mcv_findings findings;
    bool said = false;
    assert_int_equal(mcv_findings_of(scene, &findings, &error), MCV_OK);
    for (size_t i = 0; i < findings.count; ++i)
        said = said || (strstr(findings.items[i].sentence, "\"part\" is 30 m wide") &&
                        strstr(findings.items[i].sentence, "is its unit mm?"));
    mcv_findings_free(&findings);
    assert_true(said);
    mcv_scene_free(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_binary), cmocka_unit_test(test_ascii_in_a_foreign_locale),
        cmocka_unit_test(test_bad_files), cmocka_unit_test(test_units_and_materials)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
