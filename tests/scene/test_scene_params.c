/* SPDX-License-Identifier: Apache-2.0 */
/* Quantities with units, parameter tables, and what sensors and emitters derive from their
 * parameters. */
#include "test.h"

#include "scene_files.h"
#include "sensor_json.h"

#include "scene/emitters.h"
#include "scene/params.h"
#include "scene/schema.h"
#include "scene/sensors.h"

#include <float.h>

/* A double computed by n roundings is off by at most n DBL_EPSILON/2, relatively; twice that leaves
 * room for the test's own. */
static void assert_near(double value, double truth, double roundings, const char *what) {
    const double bound = roundings * DBL_EPSILON * fabs(truth);
    if (!(fabs(value - truth) <= bound))
        fail_msg("%s is %.17g, must be %.17g within %g", what, value, truth, bound);
}

/* A float rounded once from such a double. */
static void assert_float(float value, double truth, const char *what) {
    if (!(fabs((double)value - truth) <= (FLT_EPSILON / 2 + 16 * DBL_EPSILON) * fabs(truth)))
        fail_msg("%s is %.9g, must be %.17g rounded to float", what, (double)value, truth);
}

static void assert_says(const mcv_error *error, const char *words) {
    if (!strstr(error->text, words))
        fail_msg("the sentence \"%s\" must say \"%s\"", error->text, words);
}

static void test_quantities(void **state) {
    (void)state;
    static const struct {
        const char *text;
        mcv_param_kind kind;
        double value;
    } good[] = {{"25mm", MCV_PARAM_length, 25e-3},
                {"10inch", MCV_PARAM_length, 0.254},
                {"3.45um", MCV_PARAM_length, 3.45e-6},
                {"3.45 µm", MCV_PARAM_length, 3.45e-6},
                {"500nm", MCV_PARAM_length, 500e-9},
                {"-1.5e2cm", MCV_PARAM_length, -1.5},
                {"2m", MCV_PARAM_length, 2},
                {"180deg", MCV_PARAM_angle, M_PI},
                {"5mrad", MCV_PARAM_angle, 5e-3},
                {"1rad", MCV_PARAM_angle, 1},
                {"90deg", MCV_PARAM_choice, M_PI / 2},
                {".5", MCV_PARAM_length, 0.5},
                {"7", MCV_PARAM_number, 7}};
    static const struct {
        const char *text;
        mcv_param_kind kind;
    } bad[] = {
        {"25 parsec", MCV_PARAM_length}, {"25deg", MCV_PARAM_length}, {"25mm", MCV_PARAM_angle},
        {"25mm", MCV_PARAM_number},      {"mm", MCV_PARAM_length},    {"", MCV_PARAM_length},
        {"inf", MCV_PARAM_length},       {"nan", MCV_PARAM_length},   {"0x10", MCV_PARAM_length},
        {"1e999m", MCV_PARAM_length},    {"25mm2", MCV_PARAM_length}, {"+-3", MCV_PARAM_length}};
    for (size_t i = 0; i < sizeof good / sizeof good[0]; ++i) {
        double value = NAN;
        if (!mcv_parse_quantity(good[i].text, good[i].kind, &value))
            fail_msg("\"%s\" must be a quantity", good[i].text);
        assert_near(value, good[i].value, 2, good[i].text);
    }
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; ++i) {
        double value;
        if (mcv_parse_quantity(bad[i].text, bad[i].kind, &value))
            fail_msg("\"%s\" must be refused, not %g", bad[i].text, value);
    }
}

#define TELECENTRIC_FILM "\"resolution\":[2448,2048],\"pixelSize\":\"3.45um\""

/* design.md §3: f = W m/(1+m), b = f(1+m), D_t = 2 f NA, NA = m/(2N), D_l = field diagonal + 2 W
 * NA. */
static void test_telecentric_datasheet(void **state) {
    (void)state;
    mcv_sensor sensor;
    mcv_error error;
    assert_int_equal(
        sensor_of(
            MCV_SENSOR_TELECENTRIC,
            "{\"magnification\":0.25,\"workingDistance\":\"110mm\",\"fNumber\":8," TELECENTRIC_FILM
            "}",
            &sensor, &error),
        MCV_OK);
    const mcv_telecentric_params *p = &sensor.as.telecentric;
    assert_near(p->focalLength, 22e-3, 4, "f");
    assert_near(p->imageDistance, 27.5e-3, 4, "b");
    assert_near(p->numericalAperture, 1.0 / 64, 16, "NA");
    assert_near(p->stopDiameter, 2 * 22e-3 / 64, 16, "D_t");
    assert_near(p->lensDiameter, hypot(2448, 2048) * 3.45e-6 / 0.25 + 2 * 0.11 / 64, 16, "D_l");

    /* The four of the report give the datasheet back, and both sets together are no contradiction.
     */
    char *json = text_of(
        "{\"focalLength\":%.17g,\"imageDistance\":%.17g,\"stopDiameter\":%.17g,\"lensDiameter\":%."
        "17g,"
        "\"magnification\":0.25,\"workingDistance\":\"110mm\",\"fNumber\":8," TELECENTRIC_FILM "}",
        p->focalLength, p->imageDistance, p->stopDiameter, p->lensDiameter);
    mcv_sensor again;
    assert_int_equal(sensor_of(MCV_SENSOR_TELECENTRIC, json, &again, &error), MCV_OK);
    free(json);
    assert_near(again.as.telecentric.numericalAperture, 1.0 / 64, 32,
                "NA from the report's parameters");

    /* Any two of f, b, m, W fix the other two. b - f loses a factor b/(b - f) = 5 of precision. */
    static const char *const pairs[] = {
        "\"focalLength\":\"22mm\",\"imageDistance\":\"27.5mm\"",
        "\"focalLength\":\"22mm\",\"magnification\":0.25",
        "\"focalLength\":\"22mm\",\"workingDistance\":\"110mm\"",
        "\"imageDistance\":\"27.5mm\",\"magnification\":0.25",
        "\"imageDistance\":\"27.5mm\",\"workingDistance\":\"110mm\""};
    for (size_t i = 0; i < sizeof pairs / sizeof pairs[0]; ++i) {
        json = text_of("{%s,\"fNumber\":8," TELECENTRIC_FILM "}", pairs[i]);
        if (sensor_of(MCV_SENSOR_TELECENTRIC, json, &again, &error) != MCV_OK)
            fail_msg("%s: %s", pairs[i], error.text);
        assert_near(again.as.telecentric.focalLength, 22e-3, 20, pairs[i]);
        assert_near(again.as.telecentric.imageDistance, 27.5e-3, 20, pairs[i]);
        assert_near(again.as.telecentric.magnification, 0.25, 40, pairs[i]);
        assert_near(again.as.telecentric.workingDistance, 0.11, 40, pairs[i]);
        free(json);
    }
}

/* 1/f = 1/w + 1/b and N = b/D_l, from either of each pair; both together are no contradiction. */
static void test_focus_and_f_number(void **state) {
    static const uint32_t types[] = {MCV_SENSOR_THIN_LENS, MCV_SENSOR_LIGHT_FIELD};
    static const char *const films[] = {"\"resolution\":4",
                                        "\"spatialResolution\":4,\"angularResolution\":3"};
    static const char *const focus[] = {"\"focusDistance\":\"400mm\"",
                                        "\"imageDistance\":\"26.6666666666666667mm\"",
                                        "\"focusDistance\":0.4,\"imageDistance\":0.026667"};
    static const char *const aperture[] = {"\"fNumber\":4",
                                           "\"lensDiameter\":\"6.66666666666666667mm\"",
                                           "\"fNumber\":4,\"lensDiameter\":0.006667"};
    (void)state;
    for (int i = 0; i < 2 * 3 * 3; ++i) {
        const int type = i / 9, by_focus = i / 3 % 3, by_aperture = i % 3;
        mcv_sensor sensor;
        mcv_error error;
        char *json = text_of("{\"focalLength\":\"25mm\",%s,%s,%s,\"pixelSize\":1e-5}",
                             focus[by_focus], aperture[by_aperture], films[type]);
        if (sensor_of(types[type], json, &sensor, &error) != MCV_OK)
            fail_msg("%s: %s", json, error.text);
        const mcv_thin_lens_params *t = &sensor.as.thin_lens;
        const mcv_light_field_params *l = &sensor.as.light_field;
        /* Rounded b is off by 1.25e-5 and D_l by 5e-5, counted in roundings; what is given stays as
         * it is. */
        const double rounded_b = by_focus == 2 ? 1.3e-5 / DBL_EPSILON : 0;
        const double rounded_d = by_aperture == 2 ? 6e-5 / DBL_EPSILON : 0;
        assert_near(type ? l->imageDistance : t->imageDistance, 0.025 * 0.4 / 0.375, 4 + rounded_b,
                    "b");
        assert_near(type ? l->focusDistance : t->focusDistance, 0.4, 128 + rounded_b,
                    "w"); /* b - f cancels to 1/16 */
        assert_near(type ? l->lensDiameter : t->lensDiameter, 0.1 / 15, 8 + rounded_b + rounded_d,
                    "D_l");
        assert_near(type ? l->fNumber : t->fNumber, 4, 8 + rounded_b + rounded_d, "N");
        assert_near(mcv_sensor_optics(&sensor).f_number, type ? l->fNumber : t->fNumber,
                    8 + 1.5 * (rounded_b + rounded_d), "N of the optics");
        free(json);
    }
    /* Focus at infinity and behind the lens have no focusDistance. */
    for (int i = 0; i < 2; ++i) {
        mcv_sensor sensor;
        mcv_error error;
        char *json = text_of("{\"focalLength\":0.025,\"imageDistance\":%g,\"fNumber\":4,"
                             "\"resolution\":4,\"pixelSize\":1e-5}",
                             i ? 0.02 : 0.025);
        if (sensor_of(MCV_SENSOR_THIN_LENS, json, &sensor, &error) != MCV_OK)
            fail_msg("%s: %s", json, error.text);
        assert_true(isnan(sensor.as.thin_lens.focusDistance));
        free(json);
    }
}

#define LENS_FILM "\"resolution\":4,\"pixelSize\":1e-5"

static void test_refused_sensors(void **state) {
    (void)state;
    static const struct {
        uint32_t type;
        const char *json, *says;
    } cases[] = {
        {MCV_SENSOR_TELECENTRIC,
         "{\"focalLength\":\"25mm\",\"imageDistance\":\"25mm\",\"fNumber\":8," TELECENTRIC_FILM "}",
         "rig.gltf: cam/imageDistance: 0.025 m must exceed focalLength 0.025 m"},
        {MCV_SENSOR_TELECENTRIC,
         "{\"focalLength\":0,\"imageDistance\":1,\"fNumber\":8," TELECENTRIC_FILM "}",
         "rig.gltf: cam/focalLength: 0 must be above 0"},
        {MCV_SENSOR_TELECENTRIC,
         "{\"focalLength\":\"25mm\",\"workingDistance\":\"20mm\",\"fNumber\":8," TELECENTRIC_FILM
         "}",
         "cam/workingDistance: 0.02 m must exceed focalLength 0.025 m"},
        {MCV_SENSOR_TELECENTRIC,
         "{\"focalLength\":\"22mm\",\"magnification\":0.25,\"workingDistance\":\"111mm\","
         "\"fNumber\":8," TELECENTRIC_FILM "}",
         "cam/workingDistance: 0.111 contradicts focalLength and magnification, from which 0.11 "
         "follows"},
        {MCV_SENSOR_TELECENTRIC,
         "{\"magnification\":0.25,\"workingDistance\":\"110mm\",\"fNumber\":8,"
         "\"numericalAperture\":0.02," TELECENTRIC_FILM "}",
         "cam/fNumber: 8 contradicts numericalAperture, from which 6.25 follows"},
        {MCV_SENSOR_TELECENTRIC, "{\"magnification\":0.25,\"fNumber\":8," TELECENTRIC_FILM "}",
         "needs two of focalLength"},
        {MCV_SENSOR_TELECENTRIC,
         "{\"magnification\":0.25,\"workingDistance\":1," TELECENTRIC_FILM "}",
         "needs stopDiameter"},
        {MCV_SENSOR_THIN_LENS,
         "{\"focalLength\":0.025,\"imageDistance\":0.026,\"focusDistance\":0.6,\"fNumber\":"
         "4," LENS_FILM "}",
         "cam/focusDistance: 0.6 contradicts focalLength and imageDistance, from which 0.65 "
         "follows"},
        {MCV_SENSOR_THIN_LENS,
         "{\"focalLength\":0.025,\"imageDistance\":0.025,\"focusDistance\":0.6,\"fNumber\":"
         "4," LENS_FILM "}",
         "cam/focusDistance: 0.6 contradicts focalLength and imageDistance, from which inf "
         "follows"},
        {MCV_SENSOR_THIN_LENS,
         "{\"focalLength\":0.025,\"focusDistance\":0.025,\"fNumber\":4," LENS_FILM "}",
         "cam/focusDistance: 0.025 m must exceed focalLength 0.025 m"},
        {MCV_SENSOR_THIN_LENS,
         "{\"focalLength\":0.025,\"imageDistance\":0.026,\"lensDiameter\":0.005,\"fNumber\":"
         "5," LENS_FILM "}",
         "cam/fNumber: 5 contradicts imageDistance and lensDiameter, from which 5.2 follows"},
        {MCV_SENSOR_THIN_LENS, "{\"focalLength\":0.025,\"fNumber\":4," LENS_FILM "}",
         "cam: needs imageDistance or focusDistance"},
        {MCV_SENSOR_LIGHT_FIELD,
         "{\"focalLength\":0.025,\"focusDistance\":1,\"spatialResolution\":1,\"angularResolution\":"
         "1,\"pixelSize\":1}",
         "cam: needs lensDiameter or fNumber"},
        {MCV_SENSOR_PINHOLE,
         "{\"imageDistance\":1,\"resolution\":[1,1],\"pixelSize\":1,\"radiometry\":\"irradiance\"}",
         "cam/radiometry: a pinhole has no aperture"},
        {MCV_SENSOR_PINHOLE, "{\"resolution\":[1,1],\"pixelSize\":1}",
         "cam/imageDistance: is missing"},
        {MCV_SENSOR_PINHOLE, "{\"imagedistance\":1}",
         "unknown key \"imagedistance\": did you mean \"imageDistance\"?"},
        {MCV_SENSOR_PINHOLE, "{\"wavelength\":1}",
         "unknown key \"wavelength\": known are imageDistance, resolution"},
        {MCV_SENSOR_PINHOLE, "{\"imageDistance\":\"5deg\"}",
         "cam/imageDistance: \"5deg\" must be a length"},
        {MCV_SENSOR_PINHOLE, "{\"imageDistance\":[1]}", "cam/imageDistance: must be a length"},
        {MCV_SENSOR_PINHOLE, "{\"resolution\":[640]}",
         "cam/resolution: has 1 values, but must have 2"},
        {MCV_SENSOR_PINHOLE, "{\"resolution\":[640,480.5]}",
         "cam/resolution/1: 480.5 must be an integer from 1 to 65536"},
        {MCV_SENSOR_PINHOLE, "{\"resolution\":0}",
         "cam/resolution: 0 must be an integer from 1 to 65536"},
        {MCV_SENSOR_PINHOLE, "{\"resolution\":1e10}", "cam/resolution: 1e+10 must be an integer"},
        {MCV_SENSOR_PINHOLE, "{\"radiometry\":\"luminance\"}",
         "\"luminance\" must be \"radiance\" or \"irradiance\""},
        {MCV_SENSOR_LIGHT_FIELD, "{\"aperture\":1}",
         "cam/aperture: must be \"square\" or \"circle\""},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        mcv_sensor sensor;
        mcv_error error;
        const mcv_result result = sensor_of(cases[i].type, cases[i].json, &sensor, &error);
        if (result != MCV_BAD_INPUT)
            fail_msg("%s gave %d, must be bad input", cases[i].json, result);
        assert_says(&error, cases[i].says);
    }
}

/* The device structs against the report's quantities, computed another way: d = w - o with the
 * focused point w in metres. */
static void test_prepare(void **state) {
    (void)state;
    mcv_sensor sensor;
    mcv_error error;
    assert_int_equal(sensor_of(MCV_SENSOR_TELECENTRIC,
                               "{\"focalLength\":0.1,\"imageDistance\":0.125,\"stopDiameter\":0.01,"
                               "\"lensDiameter\":0.5,\"resolution\":[4,6],"
                               "\"pixelSize\":[1e-3,2e-3],\"radiometry\":\"irradiance\"}",
                               &sensor, &error),
                     MCV_OK);
    mcv_telecentric t;
    mcv_telecentric_prepare(&sensor.as.telecentric, &t);
    assert_int_equal(t.centre_x.halves, 4);
    assert_int_equal(t.centre_y.halves, 6);
    assert_float(t.centre_x.low, 0, "what half pixels leave of the centre");
    assert_float(t.pixel_x, 4e-3, "pixel_x: l f/(b - f) = 4 l");
    assert_float(t.pixel_y, 8e-3, "pixel_y");
    assert_float(t.stop_radius, 5e-3, "stop radius");
    assert_float(t.stop_to_lens, 5, "b/(b - f)");
    assert_float(t.stop_to_direction, 10, "1/f");
    assert_float(t.lens_radius, 0.25, "lens radius");
    assert_float(t.etendue, M_PI / 4 * 1e-4 / (0.025 * 0.025), "étendue");

    assert_int_equal(sensor_of(MCV_SENSOR_THIN_LENS,
                               "{\"focalLength\":0.1,\"imageDistance\":0.08,\"lensDiameter\":0.05,"
                               "\"resolution\":[4,6],\"pixelSize\":1e-3,"
                               "\"radiometry\":\"irradiance\"}",
                               &sensor, &error),
                     MCV_OK);
    mcv_thin_lens l;
    mcv_thin_lens_prepare(&sensor.as.thin_lens, &l);
    assert_float(l.slope_x, 1e-3 / 0.08, "slope");
    assert_float(l.kappa, -2.5, "κ = 1/f - 1/b"); /* 10 - 12.5: the focused plane is virtual */
    assert_float(l.radius, 0.025, "radius");
    assert_float(l.etendue, M_PI / 4 * 0.0025 / 0.0064, "étendue");

    assert_int_equal(sensor_of(MCV_SENSOR_LIGHT_FIELD,
                               "{\"focalLength\":0.05,\"imageDistance\":0.06,\"lensDiameter\":0.02,"
                               "\"spatialResolution\":[160,120],"
                               "\"angularResolution\":[9,7],\"pixelSize\":4e-6,\"aperture\":"
                               "\"circle\",\"radiometry\":\"irradiance\"}",
                               &sensor, &error),
                     MCV_OK);
    mcv_light_field f;
    mcv_light_field_prepare(&sensor.as.light_field, &f);
    assert_float(f.slope_x, 36e-6 / 0.06, "slope_x");
    assert_float(f.slope_y, 28e-6 / 0.06, "slope_y");
    assert_float(f.etendue, 4e-4 / 36e-4, "étendue of the square that is sampled");
    assert_int_equal(f.circle, 1);
    uint32_t width, height;
    mcv_sensor_film_size(&sensor, &width, &height);
    assert_int_equal(width, 1440);
    assert_int_equal(height, 840);

    assert_int_equal(
        sensor_of(MCV_SENSOR_PINHOLE,
                  "{\"imageDistance\":0.016,\"resolution\":[640,480],\"pixelSize\":\"5um\"}",
                  &sensor, &error),
        MCV_OK);
    mcv_pinhole p;
    mcv_pinhole_prepare(&sensor.as.pinhole, &p);
    assert_float(p.slope_y, 5e-6 / 0.016, "slope_y");
}

/*
 * Depth of field by its definition: the image of a point at the returned depth is blurred by one
 * pixel on the film. The blur is computed from the thin lens equation: image at v = 1/(1/f - 1/z),
 * cone of diameter D, cut by the film at b.
 */
static void test_optics(void **state) {
    (void)state;
    mcv_sensor sensor;
    mcv_error error;
    assert_int_equal(sensor_of(MCV_SENSOR_THIN_LENS,
                               "{\"focalLength\":\"25mm\",\"imageDistance\":\"26mm\","
                               "\"lensDiameter\":\"5mm\",\"resolution\":[1000,500],"
                               "\"pixelSize\":\"4um\"}",
                               &sensor, &error),
                     MCV_OK);
    mcv_optics optics = mcv_sensor_optics(&sensor);
    assert_near(optics.focused_depth, 0.65, 64,
                "focused depth b f/(b - f)"); /* b - f cancels to 1/26 */
    assert_near(optics.magnification, 0.04, 64, "magnification");
    assert_near(optics.field[0], 0.1, 64, "field");
    assert_near(optics.f_number, 5.2, 4, "working f-number b/D");
    assert_near(optics.numerical_aperture, 2.5e-3 / 0.65, 64, "NA");
    for (int i = 0; i < 2; ++i) {
        const double v = 1 / (1 / 25e-3 - 1 / optics.depth_of_field[i]);
        const double blur = 5e-3 * fabs(v - 26e-3) / v;
        /* v - b is 2e-5 m of 26e-3: 1300 times the roundings of v. */
        assert_near(blur, 4e-6, 1300 * 16, i ? "blur at the far limit" : "blur at the near limit");
    }
    assert_true(optics.depth_of_field[0] < 0.65 && optics.depth_of_field[1] > 0.65);

    /* Focus at infinity: everything behind b D/pixel is sharp. */
    assert_int_equal(sensor_of(MCV_SENSOR_THIN_LENS,
                               "{\"focalLength\":\"25mm\",\"imageDistance\":\"25mm\","
                               "\"lensDiameter\":\"5mm\",\"resolution\":[1000,500],"
                               "\"pixelSize\":\"4um\"}",
                               &sensor, &error),
                     MCV_OK);
    optics = mcv_sensor_optics(&sensor);
    assert_true(isinf(optics.focused_depth) && isinf(optics.field[0]) &&
                isinf(optics.depth_of_field[1]));
    assert_near(optics.depth_of_field[0], 25e-3 * 5e-3 / 4e-6, 8, "near limit");

    /* Telecentric: ± pixel N/m², the textbook's depth of field in object space. */
    assert_int_equal(
        sensor_of(
            MCV_SENSOR_TELECENTRIC,
            "{\"magnification\":0.25,\"workingDistance\":\"110mm\",\"fNumber\":8," TELECENTRIC_FILM
            "}",
            &sensor, &error),
        MCV_OK);
    optics = mcv_sensor_optics(&sensor);
    assert_near(optics.depth_of_field[1] - 0.11, 3.45e-6 * 8 / 0.0625, 16 * 250,
                "depth of field"); /* 0.44 mm of 110 mm: 250 times */
    assert_near(optics.field[1], 2048 * 3.45e-6 / 0.25, 32, "field");

    assert_int_equal(sensor_of(MCV_SENSOR_LIGHT_FIELD,
                               "{\"focalLength\":0.05,\"imageDistance\":0.06,\"lensDiameter\":0.02,"
                               "\"spatialResolution\":[160,120],"
                               "\"angularResolution\":[9,9],\"pixelSize\":4e-6}",
                               &sensor, &error),
                     MCV_OK);
    optics = mcv_sensor_optics(&sensor);
    assert_near(optics.macro_pixel[0], 36e-6, 4, "macro pixel");
    assert_near(optics.focused_depth, 0.3, 32, "focused depth");
    assert_near(optics.field[0], 160 * 36e-6 / 0.2, 32, "field");
}

static void test_emitters(void **state) {
    (void)state;
    const mcv_json_path place = mcv_place_file("rig.gltf");
    mcv_error error = {""};
    mcv_emitter emitter = {.type = MCV_EMITTER_PARALLEL, .area = 0.01};
    mcv_params_set_defaults(mcv_emitter_table(emitter.type), &emitter.as);
    emitter.as.parallel.halfAngle = M_PI / 6;
    for (int i = 0; i < 3; ++i) emitter.as.parallel.power[i] = 1 + i;
    assert_int_equal(mcv_emitter_resolve(NULL, &emitter, &place, &error), MCV_OK);
    assert_near(emitter.radiance[0], 1 / (M_PI * 0.25 * 0.01), 16,
                "radiance of 1 W through 30°"); /* sin² = 1/4 */
    assert_near(emitter.radiance[2], 3 * emitter.radiance[0], 4, "third channel");
    assert_near(mcv_emitter_solid_angle(&emitter), 2 * M_PI * (1 - sqrt(3) / 2), 64,
                "solid angle 2π(1 - cos 30°)");

    /* At 1 µrad the solid angle is π β² to 1e-13; 1 - cos β would be 0. */
    emitter.as.parallel.halfAngle = 1e-6;
    assert_near(mcv_emitter_solid_angle(&emitter), M_PI * 1e-12, 512, "solid angle of 1 µrad");

    emitter.as.parallel.radiance[0] = emitter.as.parallel.radiance[1] =
        emitter.as.parallel.radiance[2] = 7;
    assert_int_equal(mcv_emitter_resolve(NULL, &emitter, &place, &error), MCV_BAD_INPUT);
    assert_says(&error, "both radiance 7 and power 1");
    mcv_params_set_defaults(mcv_emitter_table(emitter.type), &emitter.as);
    assert_int_equal(mcv_emitter_resolve(NULL, &emitter, &place, &error), MCV_BAD_INPUT);
    assert_says(&error, "needs radiance");
    emitter.as.parallel.halfAngle = 0;
    assert_int_equal(mcv_emitter_check(&emitter, &place, &error), MCV_BAD_INPUT);
    assert_says(&error, "collimated beam");

    emitter.type = MCV_EMITTER_AREA;
    mcv_params_set_defaults(mcv_emitter_table(emitter.type), &emitter.as);
    emitter.as.area.power[0] = emitter.as.area.power[1] = emitter.as.area.power[2] = 5;
    assert_int_equal(mcv_emitter_resolve(NULL, &emitter, &place, &error), MCV_OK);
    assert_near(emitter.radiance[1], 5 / (M_PI * 0.01), 8, "radiance of a Lambert emitter");
}

/* Every element: its defaults pass where nothing is required, and stay unset where they must be
 * given. */
static void test_tables(void **state) {
    (void)state;
    const mcv_json_path place = mcv_place_file("defaults");
    for (uint32_t type = 0; type < MCV_MATERIAL_COUNT; ++type) {
        mcv_material material = {.type = type};
        mcv_error error;
        const mcv_param_table table = mcv_material_table(type);
        assert_true(table.struct_size <= sizeof material.as);
        mcv_params_set_defaults(table, &material.as);
        if (mcv_params_check(table, &material.as, &place, &error) != MCV_OK)
            fail_msg("%s: %s", mcv_material_types[type], error.text);
    }
    for (uint32_t type = 0; type < MCV_SENSOR_COUNT; ++type) {
        mcv_sensor sensor = {.type = type};
        mcv_error error;
        const mcv_param_table table = mcv_sensor_table(type);
        mcv_params_set_defaults(table, &sensor.as);
        assert_int_equal(mcv_params_check(table, &sensor.as, &place, &error), MCV_BAD_INPUT);
        assert_says(&error, "is missing");
        for (size_t i = 0; i < table.count; ++i)
            if (table.params[i].default_value == MCV_REQUIRED ||
                table.params[i].default_value == MCV_UNSET)
                assert_true(mcv_param_unset(table.params + i, &sensor.as));
    }
}

static char *read_text(const char *path) {
    FILE *file = fopen(path, "rb");
    if (!file) return NULL;
    char *text = calloc(1, 1 << 20);
    if (fread(text, 1, (1 << 20) - 1, file) == 0) text[0] = '\0';
    fclose(file);
    return text;
}

/* The schemas that are committed are those that the tables give. */
static void test_schemas(void **state) {
    (void)state;
    for (int i = 0; mcv_schema_names[i]; ++i) {
        char *path =
            text_of("%s/include/mcvisi/schema/%s.schema.json", MCV_SOURCE_DIR, mcv_schema_names[i]);
        char *committed = read_text(path), *written = NULL;
        size_t size;
        mcv_error error;
        FILE *stream = open_memstream(&written, &size);
        assert_int_equal(mcv_schema_write(stream, mcv_schema_names[i], &error), MCV_OK);
        fclose(stream);
        if (!committed || strcmp(committed, written) != 0)
            fail_msg("%s is not what the tables give: build the target schema and run it on "
                     "include/mcvisi/schema",
                     path);
        free(written);
        free(committed);
        free(path);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_quantities),
                                       cmocka_unit_test(test_telecentric_datasheet),
                                       cmocka_unit_test(test_focus_and_f_number),
                                       cmocka_unit_test(test_refused_sensors),
                                       cmocka_unit_test(test_prepare),
                                       cmocka_unit_test(test_optics),
                                       cmocka_unit_test(test_emitters),
                                       cmocka_unit_test(test_tables),
                                       cmocka_unit_test(test_schemas)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
