/* SPDX-License-Identifier: Apache-2.0 */
/* Lens files of design programs: what is read of them, and what is refused and how. Their optics:
 * test_lens_optics.c. */
#include "lens_files.h"

#include "lens/glass_codes.h"
#include "scene/params.h"
#include "scene/spectra.h"

static const char zemax[] =
    "VERS 150514\r\nMODE SEQ\r\nNAME \xd8"
    "20 Singlet\r\nUNIT MM X W X CM MR CPMM\r\nENPD 10\r\n"
    "SURF 0\r\n  TYPE STANDARD\r\n  CURV 0.0 0 0\r\n  DISZ INFINITY\r\n  DIAM 0 0\r\n"
    "SURF 1\r\n  STOP\r\n  TYPE EVENASPH\r\n  CURV 2.0E-2 0\r\n  PARM 1 0\r\n  PARM 2 5.5E-6\r\n  "
    "DISZ 5\r\n"
    "  GLAS N-BK7 0 0 1.5 4.0E+1\r\n  CONI -6.3E-1\r\n  DIAM 1.0E+1 1\r\n"
    "SURF 2\r\n  TYPE STANDARD\r\n  CURV 0.0\r\n  DISZ 40\r\n  DIAM 1.0E+1 1\r\n"
    "SURF 3\r\n  TYPE STANDARD\r\n  CURV 0.0\r\n  DISZ 0\r\n  DIAM 1 0\r\n";

static const char codev[] = "RDM;LEN\nTITLE 'Doublet'\nEPD 20 ! mm\nDIM M\nYAN 0.0 1.0\nSO 0.0 "
                            "1e10\nS 61.47 6 NBK7_SCHOTT\n  STO\n"
                            "S -44.64 2.5 SF5_SCHOTT\n  K 0\nS -129.94 95\nSI 0 0\nGO\n";

static mcv_scene *import(const char *path, const char *text) {
    lens_read lens = read_lens(path, text);
    return load_lens(&lens);
}

static void near(double got, double expected) {
    if (fabs(got - expected) > 1e-9 * fabs(expected)) fail_msg("%.12g, not %.12g", got, expected);
}

static void check_zemax(const char *path) {
    lens_read lens;
    BUILD(mcv_lens_file_read(path, &(mcv_lens_options){0}, &lens.document, &lens.report,
                             &builder_error));
    mcv_scene *scene = load_lens(&lens);
    assert_int_equal(scene->solid_count, 1);
    const mcv_solid *solid = scene->solids;
    near(solid->caps[0].curvature, 20);
    near(solid->caps[0].conic, -0.63);
    near(solid->caps[0].asphere[0], 5.5e3); /* 1/mm³ to 1/m³ */
    near(solid->caps[1].z, 5e-3);
    near(solid->radius, 10e-3);
    near(scene->materials[0].as.dielectric.ior[0], mcv_glass_index(1, 587.5618e-9));
    assert_non_null(strstr(scene->instances[0].name, "\xc3\x98"
                                                     "20 Singlet"));
    mcv_scene_free(scene);
    remove(path);
}

/* In each encoding: the Ø of its name is one character of Latin-1 and of UTF-16, two bytes of
 * UTF-8. */
static void test_zemax(void **state) {
    (void)state;
    static const struct {
        const char *mark;
        size_t mark_size, width;
        int low; /* of a pair: where its low byte stands */
        bool utf8;
    } encodings[] = {
        {"", 0, 1, 0, false},         {"", 0, 1, 0, true},          {"\xef\xbb\xbf", 3, 1, 0, true},
        {"\xff\xfe", 2, 2, 0, false}, {"\xfe\xff", 2, 2, 1, false}, {"", 0, 2, 0, false},
        {"", 0, 2, 1, false}};
    for (size_t k = 0; k < sizeof encodings / sizeof encodings[0]; ++k) {
        char bytes[4096];
        size_t size = encodings[k].mark_size;
        memcpy(bytes, encodings[k].mark, size);
        for (const char *c = zemax; *c; ++c) {
            if (encodings[k].utf8 && *c == '\xd8') bytes[size++] = '\xc3';
            const char byte = (char)(encodings[k].utf8 && *c == '\xd8' ? '\x98' : *c);
            if (encodings[k].width == 2 && encodings[k].low == 1) bytes[size++] = 0;
            bytes[size++] = byte;
            if (encodings[k].width == 2 && encodings[k].low == 0) bytes[size++] = 0;
        }
        write_bytes("test_lens_file.ZMX", bytes, size);
        check_zemax("test_lens_file.ZMX");
    }
}

/* The doublet: two bodies in contact; semi-diameters from the bundle, 10 mm and what 1° of field
 * adds. */
static void test_codev(void **state) {
    (void)state;
    mcv_scene *scene = import("test_lens_file.seq", codev);
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
    static const char singlet[] =
        "SO 0 1e10\n%sS 50 5 NBK7\nCIR 10\nS -50 10\nCIR 10\n%sSI 0 0\nGO\n";
    static const struct {
        const char *before, *behind;
        double z;
    } cases[] = {{"S 0 15\nSTO\nCIR 2\nS 0 5\n", "", -20e-3}, {"", "S 0 10\nSTO\nCIR 2\n", 15e-3}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        char text[2048];
        snprintf(text, sizeof text, singlet, cases[i].before, cases[i].behind);
        mcv_scene *scene = import("test_lens_file.seq", text);
        assert_int_equal(scene->solid_count, 2);
        near(scene->solids[0].caps[1].z, 5e-3);
        near(scene->solids[1].hole, 2e-3);
        near(scene->solids[1].to_world.m[11], cases[i].z);
        mcv_scene_free(scene);
    }
}

/* Names with and without their maker, codes of n_d and V_d, private glasses. */
static void test_glasses(void **state) {
    (void)state;
    static const struct {
        const char *glass;
        double index, abbe; /* at d */
    } cases[] = {{"1.5168", 1.5168, 0},
                 {"1.5168:64.17", 1.5168, 64.17},
                 {"517642", 1.517, 64.2},
                 {"517.642", 1.517, 64.2},
                 {"517642.0", 1.517642, 0},
                 {"500.700", 1.5, 70},
                 {"516800.641673", 1.5168, 64.1673},
                 {"N-BAK1", 1.5725, 57.55},
                 {"NBAK1_SCHOTT", 1.5725, 57.55},
                 {"SLAH64_OHARA", 1.788001, 47.37},
                 {"j-lak14", 1.6968, 55.52},
                 {"HK9L_CDGM", 1.5168, 64.21},
                 {"BK7", 1.5168, 64.17},
                 {"caf2", 1.43385, 95},
                 {"'MINE'", 1.6, 0},
                 {"'YOURS'", 1.62, 36.38}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        char text[2048];
        snprintf(text, sizeof text,
                 "RDM\nPRV\nPWL 656.3 587.6 486.1\n'MINE' 1.6 1.6 1.6\n'YOURS' 1.61506 1.62000 "
                 "1.63211\nEND\nSO 0 1e10\nS 50 5 %s\nCIR "
                 "10\nS -50 10\nCIR 10\nSI 0 0\nGO\n",
                 cases[i].glass);
        lens_read lens = read_lens("test_lens_file.seq", text);
        const double power = 1 / lens.report.focal_length, m = cases[i].index, t = 5e-3, c = 20;
        const double expected = (m - 1) * (2 * c - (m - 1) * t * c * c / m);
        if (fabs(power / expected - 1) > 1e-5 / (m - 1)) /* two units of the index's sixth digit */
            fail_msg("%s: power %.8g, not %.8g", cases[i].glass, power, expected);
        mcv_scene *scene = load_lens(&lens);
        const double abbe = scene->materials[0].as.dielectric.abbeNumber;
        if (scene->materials[0].as.dielectric.glass == 0 && fabs(abbe - cases[i].abbe) > 0.02)
            fail_msg("%s: V %g", cases[i].glass, abbe);
        mcv_scene_free(scene);
    }
}

/* Those of the renderer's catalogue are not in the list, in which each glass stands once. */
static void test_glass_codes(void **state) {
    (void)state;
    const char *const *names = mcv_param_options("glass");
    for (const mcv_glass_code *a = mcv_glass_codes; a->name; ++a) {
        if (!(a->index > 1.3 && a->index < 2.3 && a->abbe > 10 && a->abbe < 110))
            fail_msg("%s: %g, %g", a->name, a->index, a->abbe);
        for (int i = 1; names[i]; ++i)
            if (strcasecmp(a->name, names[i]) == 0) fail_msg("%s is in the catalogue", a->name);
        for (const mcv_glass_code *b = a + 1; b->name; ++b)
            if (strcasecmp(a->name, b->name) == 0) fail_msg("%s stands twice", a->name);
    }
}

/* CODE V's ways of writing: case, continuation, comments, several statements in a line, surfaces
 * named from elsewhere. */
static void test_codev_grammar(void **state) {
    (void)state;
    static const char *const same[] = {
        "RDM;LEN\nTITLE 'a; b & c ! d'\nEPD 10\nDIM M\nSO 0 1e10\nS 50 5 517.642\nSTO\nCIR "
        "7\nASP\nK "
        "-0.5\nA 1e-6;B -2e-9\nS -80 40\nCIR 7\nSI 0 0\nGO\n",
        "rdm y; len\r\ntit 'a'\r\nepd &\r\n 10 ! of the pupil & no more\r\ndim mm\r\nso 0 "
        "&\r\n1e10\r\ns 50 "
        "5 517.642; sto; cir clr 7\r\nk -.5; a 1e-6; "
        "b &  ! on\r\n -2e-9; c 0; d 0\r\ns -80 40 air\r\n cir edg 7\r\nsi\r\n",
        "RDM\nEPD 10\nS1 50 5 517.642\nS2 -80 40\nSI 0 0\nSTO S1\nCIR S1..2 7\nASP S1\nK S1 "
        "-0.5\nA S1 "
        "1e-6\nB S1 -2e-9\nTHI S2 Z2 7\nZOO 2\nZOO THI S2 40 50\n",
        "RDM N\nEPD 10\nS 0 5\nRDY 50\nGLA 517.642\nSTO\nCIR 7\nK -0.5\nA 1e-6\nB -2e-9\nS -0.0125 "
        "40\nCIR "
        "7\nCIR EDG 9\nXDE 0.0\nSI 0 0\nGO\n"};
    lens_read first = read_lens("test_lens_file.seq", same[0]);
    for (size_t i = 1; i < sizeof same / sizeof same[0]; ++i) {
        lens_read lens = read_lens("test_lens_file.seq", same[i]);
        if (!same_document(lens.document, first.document, 1e-12))
            fail_msg("sequence %zu is another lens", i);
        if (i == 2 && !warns(&lens, "zoom positions"))
            fail_msg("its zoom positions are passed over in silence");
        json_decref(lens.document);
    }
    json_decref(first.document);
}

/* The Zemax file with one word in place of another. */
static void replace(char text[2048], const char *word, const char *by) {
    const char *at = strstr(zemax, word);
    assert_non_null(at);
    snprintf(text, 2048, "%.*s%s%s", (int)(at - zemax), zemax, by, at + strlen(word));
}

/* What would change the lens is refused if it is not known, by file, line and surface. */
static void test_refusals(void **state) {
    (void)state;
    static const char *const codev_cases[][2] = {
        {"XTO", "line 5: surface 1: only spheres, conics and even aspheres are supported, not XTO"},
        {"DIF DOE", "not DIF"},
        {"ASP\nJ 1e-20", "line 6: surface 1: aspheres have terms from r^4 to r^18, A to H, not J"},
        {"CIR OBS 2", "not CIR OBS"},
        {"ADE 45", "tilts, decentres"},
        {"STO S7", "there is no such surface yet: S7"},
        {"CUY UMY -0.1\nCUY 0\nCUY UMY -0.1", "its curvature is solved"},
        {"K inf", "\"inf\" is too large a number"},
        {"THI 5mm", "\"5mm\" must be a number"},
        {"RMD REFL", "mirrors in lens files are not supported"},
        {"S9 4 4", "surface numbers must be consecutive"},
        {"DIM F", "DIM must be M (mm), C (cm) or I (inch), not F"},
        {"GLA UNOBTAINIUM",
         "unknown glass \"UNOBTAINIUM\": give its index with --index UNOBTAINIUM=1.5"},
        {"WL -3", "wavelengths (WL) must be above 0"}};
    for (size_t i = 0; i < sizeof codev_cases / sizeof codev_cases[0]; ++i) {
        char text[2048];
        snprintf(text, sizeof text,
                 "RDM\nSO 0 1e10\nS 50 5 NBK7\nCIR 10\n%s\nS -50 10\nCIR 10\nSI 0 0\nGO\n",
                 codev_cases[i][0]);
        refuse_lens("test_lens_file.seq", text, codev_cases[i][1]);
    }
    static const char *const zemax_cases[][3] = {
        {"EVENASPH", "TOROIDAL",
         "line 13: surface 1: only the types STANDARD and EVENASPH are supported, not TOROIDAL"},
        {"2.0E-2", "2.0X-2", "line 14: surface 1: \"2.0X-2\" must be a number"},
        {"PARM 1 0", "PARM 1 4", "not PARM 1"},
        {"N-BK7 ", "MIRROR ", "mirrors in lens files are not supported"},
        {"UNIT MM", "UNIT KM", "the UNIT must be MM, CM, IN or METER, not KM"},
        {"MODE SEQ", "MODE NSC", "only sequential lenses"},
        {"N-BK7 0 0 1.5 4", "___BLANK 1 0 .5 ", "the index of a model glass must be 1 to 10"},
        {"DISZ 5", "DISZ -", "must be a number"}};
    for (size_t i = 0; i < sizeof zemax_cases / sizeof zemax_cases[0]; ++i) {
        char text[2048];
        replace(text, zemax_cases[i][0], zemax_cases[i][1]);
        refuse_lens("test_lens_file.zmx", text, zemax_cases[i][2]);
    }
    refuse_lens("test_lens_file.seq", "EPD x\nGO\n", "line 1: \"x\" must be a number");
    refuse_lens("test_lens_file.seq", "K 1\n", "line 1: precedes the first surface, S: K");
    refuse_lens("test_lens_file.seq", "", "has no surface");
    refuse_lens("test_lens_file.zmx", "hello", "has no SURF");
    refuse_lens("test_lens_file.txt", zemax, "must be a .zmx or .seq file");
    refuse_lens("test_lens_file.zar", zemax,
                "is an archive of Zemax OpticStudio: extract it there");
    refuse_lens("test_lens_file.len", zemax, "save the lens there as a sequence");
    refuse_lens("test_lens_file.seq",
                "RDM\nEPD 4\nS 50 5 NBK7\nS -50 -3\nS 50 5 NBK7\nS -50 90\nSI\n",
                "its lens overlaps the next one already on the axis");
    refuse_lens("test_lens_file.seq", "RDM\nS 50 5 NBK7\nS -50 90\nSI\n",
                "line 2: surface 1: has no semi-diameter (DIAM, CIR), and no aperture");
    refuse_lens("test_lens_file.seq", "RDM\nNAO .02\nS 50 5 NBK7\nS -50 90\nSI\n",
                "the object is at infinity, where the object-side aperture");
}

/* What the file's semi-diameters leave no room for is cut, and said; the index beside an unknown
 * glass is taken, and said. */
static void test_warnings(void **state) {
    (void)state;
    lens_read lens =
        read_lens("test_lens_file.seq", "RDM\nS 50 1 NBK7\nCIR 12\nS 10 90\nCIR 8\nSI\nFOO 3\n");
    assert_true(warns(&lens, "line 2: surface 1: its lens is made 19.8 mm wide instead of 24 mm: "
                             "beyond, its faces have no common edge"));
    assert_true(warns(&lens, "line 7: unknown statements are ignored: FOO"));
    mcv_scene_free(load_lens(&lens));
    char text[2048];
    replace(text, "N-BK7 0 0 1.5", "XYZ-7 0 0 1.6");
    lens = read_lens("test_lens_file.zmx", text);
    assert_true(warns(&lens, "unknown glass XYZ-7: it gets the index 1.6"));
    mcv_scene_free(load_lens(&lens));
}

static void test_index(void **state) {
    (void)state;
    const char *const indices[] = {"xyz-7=1.5229"};
    char text[2048];
    lens_read lens;
    replace(text, "N-BK7 ", "XYZ-7 ");
    refuse_lens("test_lens_file.zmx", text, "surface 1: unknown glass \"XYZ-7\"");
    write_bytes("test_lens_file.zmx", text, strlen(text));
    BUILD(mcv_lens_file_read("test_lens_file.zmx", &(mcv_lens_options){indices, 1, 0},
                             &lens.document, &lens.report, &builder_error));
    mcv_scene *scene = load_lens(&lens);
    near(scene->materials[0].as.dielectric.ior[0], 1.5229);
    mcv_scene_free(scene);
    static const char *const bad[] = {"B270", "B270=", "=1.5", "B270=0.5", "B270=1.5x"};
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; ++i) {
        assert_int_equal(mcv_lens_file_read("test_lens_file.zmx",
                                            &(mcv_lens_options){bad + i, 1, 0}, &lens.document,
                                            &lens.report, &builder_error),
                         MCV_USAGE);
        assert_non_null(strstr(builder_error.text, "must be GLASS=N"));
    }
    assert_int_equal(mcv_lens_file_read("test_lens_file.zmx",
                                        &(mcv_lens_options){NULL, 0, MCV_LENS_SHAPE_RADIUS},
                                        &lens.document, &lens.report, &builder_error),
                     MCV_USAGE);
    assert_non_null(strstr(builder_error.text, "--curvature is for .seq files"));
    remove("test_lens_file.zmx");
}

/* A file cut anywhere is refused, or warned of, or holds the whole lens. */
static void test_truncated(void **state) {
    (void)state;
    static const struct {
        const char *path, *text;
    } files[] = {{"test_lens_file.seq", codev}, {"test_lens_file.zmx", zemax}};
    for (size_t k = 0; k < 2; ++k) {
        lens_read whole = read_lens(files[k].path, files[k].text), lens;
        for (size_t size = 0; size < strlen(files[k].text); ++size) {
            write_bytes(files[k].path, files[k].text, size);
            if (mcv_lens_file_read(files[k].path, &(mcv_lens_options){0}, &lens.document,
                                   &lens.report, &builder_error) != MCV_OK)
                continue;
            if (!warns(&lens, "ends without SI and GO") &&
                !same_document(lens.document, whole.document, 1e-12))
                fail_msg("%s: %zu bytes of it are another lens", files[k].path, size);
            json_decref(lens.document);
        }
        json_decref(whole.document);
        remove(files[k].path);
    }
    char cut[2048];
    snprintf(cut, sizeof cut, "%.*s", (int)(strstr(zemax, "SURF 2") - zemax), zemax);
    refuse_lens("test_lens_file.zmx", cut,
                "line 11: surface 1: is the last one but no image surface: the file is truncated");
    snprintf(cut, sizeof cut, "%.*s", (int)(strstr(zemax, "SURF 3") - zemax), zemax);
    refuse_lens("test_lens_file.zmx", cut,
                "surface 2: is the last one but no image surface: the file is truncated");
    snprintf(cut, sizeof cut, "%.*s", (int)(strstr(codev, "S -44.64") - codev), codev);
    refuse_lens("test_lens_file.seq", cut,
                "line 7: surface 1: its glass reaches the image: the file is truncated");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_zemax),       cmocka_unit_test(test_codev),
        cmocka_unit_test(test_stops),       cmocka_unit_test(test_glasses),
        cmocka_unit_test(test_glass_codes), cmocka_unit_test(test_codev_grammar),
        cmocka_unit_test(test_refusals),    cmocka_unit_test(test_warnings),
        cmocka_unit_test(test_index),       cmocka_unit_test(test_truncated),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
