/* SPDX-License-Identifier: Apache-2.0 */
/* Lens files of design programs: what is read of them, and what is refused and how. */
#include "scene_builder.h"

#include "scene/lens_file.h"

static const char zemax[] = "VERS 150514\r\nMODE SEQ\r\nNAME Singlet\r\nUNIT MM X W X CM MR CPMM\r\nENPD 10\r\n"
                            "SURF 0\r\n  TYPE STANDARD\r\n  CURV 0.0 0 0\r\n  DISZ INFINITY\r\n  DIAM 0 0\r\n"
                            "SURF 1\r\n  STOP\r\n  TYPE EVENASPH\r\n  CURV 2.0E-2 0\r\n  PARM 1 0\r\n  PARM 2 5.5E-6\r\n  DISZ 5\r\n"
                            "  GLAS N-BK7 0 0 1.5 4.0E+1\r\n  CONI -6.3E-1\r\n  DIAM 1.0E+1 1\r\n"
                            "SURF 2\r\n  TYPE STANDARD\r\n  CURV 0.0\r\n  DISZ 40\r\n  DIAM 1.0E+1 1\r\n"
                            "SURF 3\r\n  TYPE STANDARD\r\n  CURV 0.0\r\n  DISZ 0\r\n  DIAM 1 0\r\n";

static const char codev[] = "RDM;LEN\nTITLE 'Doublet'\nEPD 20 ! mm\nDIM M\nYAN 0.0 1.0\nSO 0.0 1e10\nS 61.47 6 NBK7_SCHOTT\n  STO\n"
                            "S -44.64 2.5 SF5_SCHOTT\n  K 0\nS -129.94 95\nSI 0 0\nGO\n";

static void write_file(const char *path, const char *text, bool wide) {
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    if (wide) fwrite("\xff\xfe", 1, 2, file);
    for (const char *c = text; *c; ++c) {
        fputc(*c, file);
        if (wide) fputc(0, file);
    }
    assert_int_equal(fclose(file), 0);
}

static mcv_scene *import(const char *path, const char *text, bool wide) {
    json_t *document;
    mcv_scene *scene;
    write_file(path, text, wide);
    BUILD(mcv_lens_file_read(path, NULL, 0, &document, &builder_error));
    assert_int_equal(json_dump_file(document, "test_lens_file.gltf", 0), 0);
    json_decref(document);
    BUILD(mcv_scene_load("test_lens_file.gltf", (mcv_overrides){NULL, 0}, &scene, &builder_error));
    remove("test_lens_file.gltf");
    remove(path);
    return scene;
}

static void near(double got, double expected) {
    if (fabs(got - expected) > 1e-9 * fabs(expected)) fail_msg("%.12g, not %.12g", got, expected);
}

static void test_zemax(void **state) {
    (void)state;
    for (int wide = 0; wide < 2; ++wide) {
        mcv_scene *scene = import("test_lens_file.zmx", zemax, wide);
        assert_int_equal(scene->solid_count, 1);
        const mcv_solid *solid = scene->solids;
        near(solid->caps[0].curvature, 20);
        near(solid->caps[0].conic, -0.63);
        near(solid->caps[0].asphere[0], 5.5e3); /* 1/mm³ to 1/m³ */
        near(solid->caps[1].z, 5e-3);
        near(solid->radius, 10e-3);
        near(scene->materials[0].as.dielectric.ior[0], mcv_glass_index(1, 587.6e-9));
        mcv_scene_free(scene);
    }
}

/* The doublet: two bodies in contact; semi-diameters from the bundle, 10 mm and what 1° of field adds. */
static void test_codev(void **state) {
    (void)state;
    mcv_scene *scene = import("test_lens_file.seq", codev, false);
    assert_int_equal(scene->solid_count, 2);
    assert_true(scene->solids[1].cemented);
    near(scene->solids[0].caps[0].curvature, 1 / 61.47e-3);
    near(scene->solids[1].caps[0].curvature, -1 / 44.64e-3);
    near(scene->solids[1].caps[1].z, 8.5e-3);
    assert_true(scene->solids[0].radius >= 10e-3 && scene->solids[0].radius < 11e-3);
    mcv_scene_free(scene);
}

/* A stop 20 mm before the singlet, or 10 mm behind it, is a disc in that place. */
static void test_stops(void **state) {
    (void)state;
    static const char singlet[] = "SO 0 1e10\n%sS 50 5 NBK7\nCIR 10\nS -50 10\nCIR 10\n%sSI 0 0\nGO\n";
    static const struct {
        const char *before, *behind;
        double z;
    } cases[] = {{"S 0 15\nSTO\nCIR 2\nS 0 5\n", "", -20e-3}, {"", "S 0 10\nSTO\nCIR 2\n", 15e-3}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        char text[2048];
        snprintf(text, sizeof text, singlet, cases[i].before, cases[i].behind);
        mcv_scene *scene = import("test_lens_file.seq", text, false);
        assert_int_equal(scene->solid_count, 2);
        near(scene->solids[0].caps[1].z, 5e-3);
        near(scene->solids[1].hole, 2e-3);
        near(scene->solids[1].to_world.m[11], cases[i].z);
        mcv_scene_free(scene);
    }
}

/* Glasses by their index: n - 1 as three digits or six. */
static void test_digits(void **state) {
    (void)state;
    static const struct {
        const char *glass;
        double index;
    } cases[] = {{"1.5168", 1.5168}, {"517642", 1.517}, {"517.642", 1.517}, {"516800.641673", 1.5168}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        char text[2048];
        snprintf(text, sizeof text, "SO 0 1e10\nS 50 5 %s\nCIR 10\nS -50 10\nCIR 10\nSI 0 0\nGO\n", cases[i].glass);
        mcv_scene *scene = import("test_lens_file.seq", text, false);
        near(scene->materials[0].as.dielectric.ior[0], cases[i].index);
        mcv_scene_free(scene);
    }
}

static void refuse(const char *path, const char *text, size_t length, const char *word) {
    char cut[2048];
    json_t *document;
    snprintf(cut, sizeof cut, "%.*s", (int)length, text);
    write_file(path, cut, false);
    const mcv_result result = mcv_lens_file_read(path, NULL, 0, &document, &builder_error);
    if (result != MCV_BAD_INPUT || !strstr(builder_error.text, word) || !strstr(builder_error.text, path))
        fail_msg("\"%s\" should say \"%s\"", builder_error.text, word);
    remove(path);
}

/* What would change the lens is refused if it is not known. */
static void test_unknown_statements(void **state) {
    (void)state;
    static const char *const cases[][2] = {{"RDY 50", "S radius thickness glass, not by RDY"},
                                           {"GLA NBK7", "not by GLA"},
                                           {"ASP\nJ 1e-20", "A to H, not J"},
                                           {"CIR OBS 2", "not CIR OBS"},
                                           {"STO S2", "surface 1: STO must stand below its surface, not name S2"}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        char text[2048];
        const int n = snprintf(text, sizeof text, "SO 0 1e10\nS 50 5 NBK7\nCIR 10\n%s\nS -50 10\nCIR 10\nSI 0 0\nGO\n", cases[i][0]);
        refuse("test_lens_file.seq", text, (size_t)n, cases[i][1]);
    }
    refuse("test_lens_file.seq", "EPD x\nGO\n", 9, "before the first surface: ");
}

static void test_index(void **state) {
    (void)state;
    const char *const indices[] = {"b270=1.5229"};
    char text[2048];
    json_t *document;
    strcpy(text, zemax);
    memcpy(strstr(text, "N-BK7 "), "B270  ", 6);
    write_file("test_lens_file.zmx", text, false);
    assert_int_equal(mcv_lens_file_read("test_lens_file.zmx", NULL, 0, &document, &builder_error), MCV_BAD_INPUT);
    assert_non_null(strstr(builder_error.text, "surface 1: unknown glass \"B270\""));
    BUILD(mcv_lens_file_read("test_lens_file.zmx", indices, 1, &document, &builder_error));
    json_decref(document);
    static const char *const bad[] = {"B270", "B270=", "=1.5", "B270=0.5"};
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; ++i) {
        assert_int_equal(mcv_lens_file_read("test_lens_file.zmx", bad + i, 1, &document, &builder_error), MCV_USAGE);
        assert_non_null(strstr(builder_error.text, "must be GLASS=N"));
    }
    remove("test_lens_file.zmx");
}

/* Any prefix of a file is refused or read, without a crash; all but the longest are refused. */
static void test_bad(void **state) {
    (void)state;
    char text[2048];
    for (size_t n = 0; n < strlen(codev) - 3; n += 7) refuse("test_lens_file.seq", codev, n, "");
    refuse("test_lens_file.seq", codev, strlen(codev) - 4, "truncated");
    refuse("test_lens_file.zmx", zemax, (size_t)(strstr(zemax, "DIAM 1.0E+1") - zemax), "truncated");
    refuse("test_lens_file.zmx", zemax, (size_t)(strstr(zemax, "SURF 2") - zemax), "truncated");
    refuse("test_lens_file.zmx", "hello", 5, "no lens");
    refuse("test_lens_file.txt", zemax, 100, ".zmx or .seq");
    strcpy(text, zemax);
    memcpy(strstr(text, "EVENASPH"), "TOROIDAL", 8);
    refuse("test_lens_file.zmx", text, strlen(text), "surface 1: only the types STANDARD and EVENASPH");
    strcpy(text, zemax);
    memcpy(strstr(text, "2.0E-2"), "2.0X-2", 6);
    refuse("test_lens_file.zmx", text, strlen(text), "must be a number in place of 2.0X-2");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_zemax),
        cmocka_unit_test(test_codev),
        cmocka_unit_test(test_stops),
        cmocka_unit_test(test_digits),
        cmocka_unit_test(test_unknown_statements),
        cmocka_unit_test(test_index),
        cmocka_unit_test(test_bad),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
