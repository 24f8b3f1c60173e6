/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Lens files whose first-order figures are known: a thick singlet (closed form), an achromat of
 * catalogue glasses and a double Gauss (as published), each in the ways that Zemax and CODE V write
 * it: equal files give equal lenses, and rays through them meet where was said.
 */
#include "lens_files.h"

#include "reference/reference.h"

/* 12 digits in the file, and as many that trigonometry and division keep. */
static const double digits = 1e-9;

/* --- the thick singlet
 * ------------------------------------------------------------------------------------------ */

/* n = 1.5 at all wavelengths, radii 50 and -80 mm, 5 mm thick; object 200 mm before the first
 * vertex, where the stop is; EPD 10 mm. */
static const double n = 1.5, c_1 = 1 / 50.0, c_2 = -1 / 80.0, thick = 5, distance = 200, pupil = 10;

static double power(void) { return (n - 1) * (c_1 - c_2 + (n - 1) * thick * c_1 * c_2 / n); }
static double back_focus(void) { return (1 - (n - 1) / n * thick * c_1) / power(); }
static double front_focus(void) { return -(1 + (n - 1) / n * thick * c_2) / power(); }

/* Newton's formula: x x' = -f². */
static double image_distance(void) {
    return back_focus() + 1 / (power() * power()) / (distance + front_focus());
}
static double magnification(void) { return -1 / (power() * (distance + front_focus())); }

static void check_singlet(const lens_read *lens, bool finite) {
    assert_within(lens->report.focal_length, 1e-3 / power(), digits, "focal length");
    assert_within(lens->report.back_focus, 1e-3 * back_focus(), digits, "back focus");
    assert_within(lens->report.image_distance, 1e-3 * (finite ? image_distance() : back_focus()),
                  digits, "image distance");
}

/* Radius or curvature, with and without RDM, GO and SI, and the option. */
static void test_radius_or_curvature(void **state) {
    (void)state;
    static const char radii[] = "S 50 5 1.5\nS -80 %.9f\n",
                      curvatures[] = "S 0.02 5 1.5\nS -0.0125 %.9f\n";
    static const struct {
        const char *before, *lens, *behind;
        mcv_lens_shape shape;
        const char *warning;
    } cases[] = {
        {"RDM;LEN\nEPD 10\nSO 0 1e10\n", radii, "SI 0 0\nGO\n", MCV_LENS_SHAPE_AUTO, NULL},
        {"RDM Y\nLEN\nEPD 10\nSO 0 1e10\n", radii, "SI 0 0", MCV_LENS_SHAPE_AUTO, NULL},
        {"LEN\nRDM N\nEPD 10\nSO 0 0.1E14\n", curvatures, "SI 0 0\nGO", MCV_LENS_SHAPE_AUTO, NULL},
        {"epd 10\nso 0 1e10\n", radii, "si 0 0\n", MCV_LENS_SHAPE_AUTO, "are read as radii"},
        {"epd 10\nso 0 1e10\n", curvatures, "si 0 0\n", MCV_LENS_SHAPE_AUTO,
         "are read as curvatures"},
        {"EPD 10\n", curvatures, "SI\n", MCV_LENS_SHAPE_AUTO, "are read as curvatures"},
        {"EPD 10\nSO 0 1e10\n", radii, "SI 0 0\n", MCV_LENS_SHAPE_RADIUS, NULL},
        {"RDM\nEPD 10\nSO 0 1e10\n", curvatures, "SI 0 0\n", MCV_LENS_SHAPE_CURVATURE, NULL},
        {"EPD 10\nSO 0 1e10\n", radii, "GO\n", MCV_LENS_SHAPE_AUTO, "are read as radii"},
        {"EPD 10\nSO 0 1e10\n", radii, "", MCV_LENS_SHAPE_AUTO, "without SI and GO"},
        {"EPD 10\nSO 0 1e10\nS1 0 5 1.5\nRDY S1 50\nS 0\nCUY S2 -0.0125\nTHI S2 ", "%.9f\n",
         "SI 0 0\n", MCV_LENS_SHAPE_AUTO, NULL},
    };
    lens_read first = {0};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        char text[1024];
        int length = snprintf(text, sizeof text, "%s", cases[i].before);
        length +=
            snprintf(text + length, sizeof text - (size_t)length, cases[i].lens, back_focus());
        snprintf(text + length, sizeof text - (size_t)length, "%s", cases[i].behind);
        lens_read lens = read_lens_as("test_lens_optics.seq", text, cases[i].shape);
        check_singlet(&lens, false);
        if (cases[i].warning && !warns(&lens, cases[i].warning))
            fail_msg("case %zu: no warning \"%s\"", i, cases[i].warning);
        if (!cases[i].warning && warns(&lens, "are read as"))
            fail_msg("case %zu: %s", i, lens.report.warnings[0]);
        if (i > 0 && !same_document(lens.document, first.document, digits))
            fail_msg("case %zu: not the lens of case 0", i);
        if (i > 0)
            json_decref(lens.document);
        else
            first = lens;
    }
    json_decref(first.document);
    /* Neither reading focuses 20 mm behind the lens, and nothing says how wide it is. */
    refuse_lens("test_lens_optics.seq", "SO 0 1e10\nS 50 5 1.5\nS -80 20\nSI 0 0\n",
                "give --curvature radius or --curvature curvature");
}

/* The same bundle by its pupil, f-number or numerical aperture, the same field by angle, object or
 * image height: equal semi-diameters. */
static void test_apertures_and_fields(void **state) {
    (void)state;
    const double u = pupil / 2 / distance, slope = u / fabs(magnification());
    const double field =
        3; /* mm at the object; the chief ray goes through the first vertex, where the stop is */
    const double angle = atan(field / distance) * 180 / M_PI, image = field * fabs(magnification());
    char text[1024], apertures[5][64], fields[4][64];
    lens_read first = {0};
    snprintf(apertures[0], 64, "EPD %.15g", pupil);
    snprintf(apertures[1], 64, "NAO %.15g", sin(atan(u)));
    snprintf(apertures[2], 64, "FNO %.15g", 1 / (2 * slope));
    snprintf(apertures[3], 64, "NA %.15g", sin(atan(slope)));
    snprintf(apertures[4], 64, "fno &\n %.15g", 1 / (2 * slope));
    snprintf(fields[0], 64, "YOB 0 %.15g", field);
    snprintf(fields[1], 64, "YAN 0 %.15g", angle);
    snprintf(fields[2], 64, "YIM 0 %.15g", image);
    snprintf(fields[3], 64, "XRI 0 %.15g; YRI 0", image);
    for (int i = 0; i < 20; ++i) {
        snprintf(text, sizeof text,
                 "RDM;LEN\nSO 0 %.15g\nS 50 5 1.5\nSTO\nS -80 %.9f\nSI 0 0\n%s\n%s\nGO\n", distance,
                 image_distance(), apertures[i % 5], fields[i / 5]);
        lens_read lens = read_lens("test_lens_optics.seq", text);
        check_singlet(&lens, true);
        if (i > 0 && !same_document(lens.document, first.document, digits))
            fail_msg("%s, %s: another lens", apertures[i % 5], fields[i / 5]);
        if (i > 0)
            json_decref(lens.document);
        else
            first = lens;
    }
    /* The stop's surface: pupil/2, and no chief ray; a twentieth more. */
    const json_t *body = json_array_get(
        json_object_get(
            json_object_get(json_object_get(first.document, "extensions"), "MCVISI_surfaces"),
            "surfaces"),
        0);
    const double second = json_number_value(
        json_object_get(json_array_get(json_object_get(body, "surfaces"), 1), "semiDiameter"));
    const double slope_in = (u - pupil / 2 * c_1 * (n - 1)) / n,
                 height = pupil / 2 + thick * slope_in, chief = thick * field / distance / n;
    assert_within(second, 1.05e-3 * fmax(height + chief, pupil / 2), digits, "semi-diameter");
    json_decref(first.document);
}

static const char zemax_singlet[] =
    "MODE SEQ\nNAME %sthick\nUNIT %s X W X CM MR CPMM\n%s\nFTYP 1 0 2 1\nYFLN 0 %.15g\nWAVM 1 "
    "0.5875618 1\nPWAV 1\n"
    "SURF 0\n  TYPE STANDARD\n  CURV 0.0\n  DISZ %.15g\n"
    "SURF 1\n  STOP\n  TYPE STANDARD\n  CURV %.15g\n  DISZ %.15g\n  GLAS ___BLANK 1 0 1.5 0\n"
    "SURF 2\n  TYPE STANDARD\n  CURV %.15g\n  DISZ %.15g\n"
    "SURF 3\n  TYPE STANDARD\n  CURV 0\n  DISZ 0\nTOL TOFF 0 0 0\nMNUM 1 1\n";

/* Zemax's file of it is CODE V's, in each unit. */
static void test_both_programs(void **state) {
    (void)state;
    static const struct {
        const char *zemax, *codev;
        double mm;
    } units[] = {{"MM", "M", 1}, {"CM", "C", 10}, {"IN", "I", 25.4}};
    const double u = pupil / 2 / distance;
    for (int i = 0; i < 9; ++i) {
        const double mm = units[i % 3].mm;
        char text[2048], aperture[64];
        snprintf(aperture, sizeof aperture,
                 i / 3 == 0   ? "ENPD %.15g"
                 : i / 3 == 1 ? "OBNA %.15g 0"
                              : "FNUM %.15g 0",
                 i / 3 == 0   ? pupil / mm
                 : i / 3 == 1 ? sin(atan(u))
                              : 1 / power() / pupil);
        snprintf(text, sizeof text, zemax_singlet, "", units[i % 3].zemax, aperture, 3 / mm,
                 distance / mm, c_1 * mm, thick / mm, c_2 * mm, image_distance() / mm);
        lens_read zemax = read_lens("test_lens_optics.zmx", text);
        snprintf(text, sizeof text,
                 "RDM N;LEN\nEPD %.15g\nDIM %s\nWL 587.5618\nYOB 0 %.15g\nSO 0 %.15g\nS %.15g "
                 "%.15g 1.5\nSTO\nS %.15g %.15g\nSI 0 0\nGO\n",
                 pupil / mm, units[i % 3].codev, 3 / mm, distance / mm, c_1 * mm, thick / mm,
                 c_2 * mm, image_distance() / mm);
        lens_read codev = read_lens("test_lens_optics.seq", text);
        check_singlet(&zemax, true);
        check_singlet(&codev, true);
        if (!same_document(zemax.document, codev.document, digits))
            fail_msg("%s, %s: two lenses", units[i % 3].zemax, aperture);
        json_decref(zemax.document);
        json_decref(codev.document);
    }
}

/* --- published lenses
 * ------------------------------------------------------------------------------------------- */

/*
 * Edmund Optics 32-327, whose sequence by CODE V solves for the paraxial image at 95.95194415183156
 * mm; sold as f = 100 mm. Warnings: it has its stop on glass.
 */
static const char achromat[] =
    "RDM;LEN \"VERSION: 11.2\"\nTITLE 'Achromat, f=100 mm'\nEPD 25.0\nDIM M\nWL 587.6\nREF 1\nWTW "
    "1\nSO 0.0 0.1e14\n"
    "S 61.47 6.0 NBK7_SCHOTT\n  STO\n  SLB \"32327\"\n  CIR 12.5\nS -44.64 2.5 NSF5_SCHOTT\n"
    "S -129.94 95.95194415183156\n  CIR 12.5\n  PIM\nSI 0.0 0.0\nGO\n";

/* The double Gauss of CODE V's sample lenses, f/2, its paraxial image solved at 61.4875364179821
 * mm. */
static const char double_gauss[] =
    "RDM N;LEN \"VERSION: 10.7\"\nTITLE 'Double Gauss F/2'\n%s\nDIM M\nWL 656.3 587.6 486.1\nREF "
    "2\nWTW 1 1 1\nYAN 0.0 10.0 14.0\n"
    "SO 0.0 993938392063.0\nS 0.01779284094091543 8.75 NSSK2_SCHOTT\n  CCY 0\nS "
    "0.006566600536925569 0.5\n"
    "S 0.02653743294670983 12.5 NSK2_SCHOTT\nS 0.0 3.8 F5_SCHOTT\nS 0.04126892878570084 "
    "16.36944492653564\n  CCY 0; THC 0\n"
    "S 0.0 13.74795696388906\n  STO\nS -0.03523942654429074 3.8 F5_SCHOTT\nS 0.0 11.0 "
    "NSK16_SCHOTT\nS -0.02636750828657709 0.5\n"
    "S 0.005636604951748545 7.0 NSK16_SCHOTT\nS -0.0125926458590576 %s\n  PIM\nSI 0.0 0.0\nDER VAL "
    "I1 -0.6e-5\nGO\n";

static void test_published(void **state) {
    (void)state;
    lens_read lens = read_lens("test_lens_optics.seq", achromat);
    assert_within(lens.report.image_distance, 95.95194415183156e-3, 1e-5,
                  "CODE V's image distance"); /* the glasses' sixth digit */
    assert_within(lens.report.focal_length, 0.1, 1e-3, "the maker's focal length");
    assert_within(lens.report.stated_focal_length, 0.1, digits, "the focal length in the title");
    assert_within(lens.report.stated_f_number, 4, 1e-3, "stated f-number");
    assert_int_equal(lens.report.warning_count, 0);
    json_decref(lens.document);

    char text[2048];
    snprintf(text, sizeof text, double_gauss, "EPD 50", "61.4875364179821");
    lens_read gauss = read_lens("test_lens_optics.seq", text);
    assert_within(gauss.report.image_distance, 61.4875364179821e-3, 1e-6,
                  "CODE V's image distance");
    assert_within(gauss.report.focal_length, 0.1, 1e-4, "focal length"); /* a design of 100 mm */
    assert_within(gauss.report.f_number, 2, 1e-4, "f-number");
    assert_int_equal(gauss.report.warning_count, 0);
    /* By f-number, and with the image to be solved for: the same lens. */
    char aperture[64];
    snprintf(aperture, sizeof aperture, "FNO %.15g", gauss.report.focal_length / 50e-3);
    snprintf(text, sizeof text, double_gauss, aperture, "0.0");
    lens_read solved = read_lens("test_lens_optics.seq", text);
    assert_true(same_document(solved.document, gauss.document, digits));
    assert_within(solved.report.stated_image_distance, 61.4875364179821e-3, 1e-6,
                  "solved image distance");
    json_decref(solved.document);
    json_decref(gauss.document);
}

/* What the file states and what is not so. */
static void test_disagreement(void **state) {
    (void)state;
    lens_read lens =
        read_lens("test_lens_optics.seq", "RDM\nTIT 'a lens, f = 60 mm'\nEPD 10\nSO 0 1e10\nS 0 "
                                          "5\nSTO\nCIR 3\nS 50 5 1.5\nS -80 50\nSI 0 0\n");
    assert_true(warns(&lens, "the focal length is 62.3") && warns(&lens, "states 60 mm"));
    assert_true(warns(&lens, "the image is 60.26") && warns(&lens, "has it at 50 mm"));
    assert_true(warns(&lens, "as written is f/10.39") && warns(&lens, "states f/6.23"));
    json_decref(lens.document);
    lens = read_lens("test_lens_optics.seq",
                     "RDM\nSO 0 1e10\nS 50 5 1.5\nCIR 4\nS -80 60.5\nCIR 4\nSI 0 0\n");
    assert_int_equal(lens.report.warning_count, 0); /* 0.4 % */
    assert_true(isnan(lens.report.stated_f_number) && isnan(lens.report.stated_focal_length));
    json_decref(lens.document);
}

/* --- rays
 * -------------------------------------------------------------------------------------------------------
 */

/*
 * A ray at height h meets the axis where first-order optics says, but for spherical aberration,
 * less than 20 h²/f of the focal length in these lenses; for h = 1e-4 f that is 2e-7.
 */
static void check_focus(const char *path, const char *text) {
    lens_read lens = read_lens(path, text);
    mcv_scene *scene = load_lens(&lens);
    mcv_render_options options = mcv_render_defaults();
    mcv_vertex *vertices;
    size_t count;
    mcv_trace_ray ray = {{0, 1e-4 * lens.report.focal_length, -0.01}, {0, 0, 1}};
    BUILD(mcv_reference_trace(scene, &ray, 1, &options, &vertices, &count, &builder_error));
    assert_true(count > 3);
    const mcv_vertex *out = vertices + count - 2; /* before the miss */
    double end = 0;
    for (uint32_t i = 0; i < scene->solid_count; ++i)
        end = fmax(end, scene->solids[i].caps[1].z + scene->solids[i].to_world.m[11]);
    const double crossing =
        out->position[2] - out->position[1] * out->direction[2] / out->direction[1];
    assert_within(crossing - end, lens.report.back_focus, 1e-6, path);
    free(vertices);
    mcv_scene_free(scene);
}

static void test_rays(void **state) {
    (void)state;
    char text[2048];
    check_focus("test_lens_optics.seq", achromat);
    snprintf(text, sizeof text, double_gauss, "EPD 50", "61.4875364179821");
    check_focus("test_lens_optics.seq", text);
    check_focus("test_lens_optics.seq", "len\ntit 'singlet'\ndim m\nso 0. 100.\ns 0.1 1 "
                                        "nbk7_schott  ! first\ns -.05 14.5\nsi 0 0\nfno "
                                        "5.0\nwl 650 550 450\nref 2\nyim 0 1");
    check_focus("test_lens_optics.seq",
                "RDM\nWL 486.1\nEPD 5\nSO 0 1e10\nS 30 4 517642\nS 0 60\nSI 0 0\n"); /* dispersion
                                                                                        of a code */
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_radius_or_curvature), cmocka_unit_test(test_apertures_and_fields),
        cmocka_unit_test(test_both_programs),       cmocka_unit_test(test_published),
        cmocka_unit_test(test_disagreement),        cmocka_unit_test(test_rays),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
