/* SPDX-License-Identifier: Apache-2.0 */
/* ctest: label truth */
/* The laser: its beam's width at every distance, the power that passes an edge, what a fan brings
 * to each part of a line, what is refused. */
#include "image_emitters.h"
#include "truths.h"

#include "reference/laser.h"
#include "scene/emitters.h"
#include "scene/laser.h"

#define COMMON "\"type\":\"laser\",\"wavelength\":\"660nm\",\"power\":0.02,"
#define THREE "\"type\":\"laser\",\"wavelength\":\"660nm\",\"power\":[0.02,0.01,0.005],"
#define BEAM COMMON "\"beamDiameter\":[\"0.4mm\",\"0.3mm\"],\"widthMeasure\":\"1/e2\",\"M2\":[5,2],"
#define LINE COMMON "\"lineThickness\":\"0.6mm\",\"widthMeasure\":\"1/e2\","

static const double power = 0.02, wavelength = 660e-9;

/* The power of a Gaussian of 1/e² radius w below x: Φ of mean 0, as a knife edge measures it. */
static double below(double x, double w) { return 0.5 * erfc(-M_SQRT2 * x / w); }

static double radius(double w0, double m2, double z) {
    return hypot(w0, m2 * wavelength / (M_PI * w0) * z);
}

/* --- rays --- */

enum { RAYS = 1 << 16 };

static mcv_scene *scene_of(const char *emitter) {
    mcv_scene *scene;
    char *text = rig_text("", emitter, ONE_PIXEL, 0.1, "laser.png");
    write_png("laser.png", 6, 1);
    BUILD(load_text("laser.gltf", text, NULL, &scene, &builder_error));
    free(text);
    return scene;
}

static mcv_laser device_laser(const char *emitter) {
    mcv_scene *scene = scene_of(emitter);
    mcv_laser laser;
    mcv_laser_prepare(scene, 0, (const double[]){0, 0, 0}, &laser);
    mcv_scene_free(scene);
    return laser;
}

/*
 * The variance of N normal numbers scatters by √(2/N) = 0.55 %: 4.5 of these are 2.5 %, or half of
 * that of the width. A radius without the factor 2 of 1/e², or M² on the waist as well, is beyond.
 * The share behind an edge scatters by √(p(1-p)/N) <= 0.002.
 */
static void test_rays_are_a_beam(void **state) {
    (void)state;
    const mcv_laser laser = device_laser(BEAM "\"workingDistance\":\"200mm\"");
    const double waists[2] = {2e-4, 1.5e-4}, m2[2] = {5, 2}, distances[] = {0, 0.2, 0.35, 1};
    const uint32_t none[2] = {0, 1u << 31};
    for (size_t d = 0; d < 4; ++d) {
        double sums[2] = {0, 0}, passed[2] = {0, 0};
        ref_random random = ref_random_begin(1, 2, 3, d);
        for (int i = 0; i < RAYS; ++i) {
            float xi[4];
            mcv_vec3 origin, direction;
            for (int k = 0; k < 4; ++k) xi[k] = (float)(ref_random_bits(&random) >> 40) * 0x1p-24f;
            assert_true(mcv_laser_leave(&laser, none, xi, &origin, &direction) == 1.0f);
            const double way = distances[d] / -(double)direction.z;
            const double at[2] = {(double)origin.x + way * (double)direction.x,
                                  (double)origin.y + way * (double)direction.y};
            for (int k = 0; k < 2; ++k) {
                sums[k] += at[k] * at[k];
                passed[k] += at[k] < 0.4 * radius(waists[k], m2[k], distances[d] - 0.2);
            }
        }
        for (int k = 0; k < 2; ++k) {
            const double w = radius(waists[k], m2[k], distances[d] - 0.2),
                         seen = 2 * sqrt(sums[k] / RAYS), share = passed[k] / RAYS;
            print_message("%g m, axis %d: radius %.6g m, expected %.6g; behind the edge %.4f\n",
                          distances[d], k, seen, w, share);
            note_truth("T27 rays: radius at four distances", "device", fabs(seen / w - 1), 0.0125);
            note_truth("T27 rays: share behind a knife edge", "device", fabs(share - below(0.4, 1)),
                       0.009);
            if (!(fabs(seen / w - 1) <= 0.0125) || !(fabs(share - below(0.4, 1)) <= 0.009))
                fail_msg("%g m, axis %d: radius %g m, expected %g; %g behind the edge, expected %g",
                         distances[d], k, seen, w, share, below(0.4, 1));
        }
    }
}

/* The slopes that next-event estimation draws at a point have the mean x/R(z) and the standard
 * deviation Θ/2 w0/w; both scatter by 1/√N of the latter, and a sum of normals by √(1/2N). */
static void test_slopes_at_a_point(void **state) {
    (void)state;
    const mcv_laser laser = device_laser(BEAM "\"workingDistance\":\"200mm\"");
    const uint32_t none[2] = {0, 1u << 31};
    const double z = 0.45, from_waist = z - 0.2, w0 = 1.5e-4, theta = 2 * wavelength / (M_PI * w0),
                 rayleigh = w0 / theta, y = 3e-4;
    const double mean = y * from_waist / (from_waist * from_waist + rayleigh * rayleigh),
                 spread = theta / 2 / hypot(1, from_waist / rayleigh);
    double sum = 0, squares = 0;
    ref_random random = ref_random_begin(1, 2, 3, 4);
    for (int i = 0; i < RAYS; ++i) {
        const float xi = (float)ref_random_unit(&random), eta = (float)ref_random_unit(&random);
        const mcv_laser_sight sight = mcv_laser_look(&laser, none, mcv_vec(0, (float)y, (float)-z),
                                                     xi < 1 ? xi : 0, eta < 1 ? eta : 0);
        const double slope = (y - (double)sight.exit.y) / z;
        sum += slope;
        squares += (slope - mean) * (slope - mean);
    }
    const double seen = sqrt(squares / RAYS);
    if (!(fabs(sum / RAYS - mean) <= 5 * spread / sqrt(RAYS)) ||
        !(fabs(seen / spread - 1) <= 5 / sqrt(2.0 * RAYS)))
        fail_msg("mean %g, expected %g; spread %g, expected %g", sum / RAYS, mean, seen, spread);
}

/* exp(-2 r²/w²) = 1/2 at r = FWHM/2: a diameter of 1 mm is a radius w of 0.5 mm by 1/e², of
 * 1 mm/√(2 ln 2) = 0.8493 mm by FWHM, rounded to float32. */
static void test_measures(void **state) {
    (void)state;
    const mcv_laser by_e2 = device_laser(COMMON "\"beamDiameter\":1e-3,\"widthMeasure\":\"1/e2\""),
                    by_half =
                        device_laser(COMMON "\"beamDiameter\":1e-3,\"widthMeasure\":\"FWHM\"");
    assert_true(by_e2.waist[0] == 5e-4f && by_e2.waist[1] == 5e-4f);
    assert_true(fabs((double)by_half.waist[1] - 8.49321800288e-4) <= 6e-8 * 8.5e-4);
}

/* --- pictures --- */

enum { SIDE = 32 };

/* A wall across the beam at a distance, and a telecentric camera of this field that sees it from
 * so far before: its right is the emitter's right. */
static mcv_scene *wall_scene(const char *emitter, double distance, double before, double width,
                             double height) {
    mcv_scene *scene = scene_of(emitter);
    mcv_sensor camera = sensor_defaults(MCV_SENSOR_TELECENTRIC);
    mcv_telecentric_params *p = &camera.as.telecentric;
    add_rectangle(scene, 2, 2, add_diffuse(scene, 0.5), looking_up_z(0, 0, -distance));
    p->magnification = 1;
    p->workingDistance = before;
    p->numericalAperture = 1e-6;
    p->resolution[0] = p->resolution[1] = SIDE;
    p->pixelSize[0] = width / SIDE;
    p->pixelSize[1] = height / SIDE;
    add_sensor(scene, MCV_SENSOR_TELECENTRIC, &camera, looking_down_z(0, 0, before - distance));
    return scene;
}

/* The power on each pixel of the wall: π/ρ L times its area; π/ρ of the film's mean. */
static void powers_of(const mcv_scene *scene, bool reference, uint64_t samples, double area,
                      double *powers) {
    mcv_film film = render_by(reference, scene, scene->sensor_count - 1, samples, 1);
    mcv_image mean, error;
    BUILD(mcv_film_develop(&film, &mean, &error, &builder_error));
    for (int i = 0; i < SIDE * SIDE; ++i) powers[i] = mean.pixels[i] * M_PI / 0.5 * area;
    mcv_image_free(&mean);
    mcv_image_free(&error);
    mcv_film_free(&film);
}

/*
 * The power on a pixel is the product of two differences of error functions, whatever the slopes.
 * A pixel's 64 samples are strewn over it by Sobol' points on the device, and by chance in the
 * reference. The beam changes by 12 % of its peak across a pixel at most, a spread of 3.5 %: by
 * chance this leaves 0.44 % of the peak, of which 4.5 standard deviations are 2 %. The power of
 * the columns up to an edge is what a knife edge lets pass: some 150 lit pixels of 0.4 % of the
 * power leave 0.02 %.
 */
static void test_beam_on_a_wall(void **state) {
    (void)state;
    const double distance = 0.5, width = 5.4e-3, step = width / SIDE;
    const double w[2] = {radius(2e-4, 5, 0.3), radius(1.5e-4, 2, 0.3)};
    for (int reference = 0; reference < 2; ++reference) {
        mcv_scene *scene =
            wall_scene(BEAM "\"workingDistance\":\"200mm\"", distance, 0.5, width, width);
        double powers[SIDE * SIDE], left = 0;
        powers_of(scene, reference, 64, step * step, powers);
        const double peak = power * step * step * 2 / (M_PI * w[0] * w[1]);
        for (int column = 0; column < SIDE; ++column) {
            const double x = (column - SIDE / 2) * step;
            for (int row = 0; row < SIDE; ++row) {
                const double y = (SIDE / 2 - 1 - row) * step, seen = powers[row * SIDE + column];
                const double expected = power * (below(x + step, w[0]) - below(x, w[0])) *
                                        (below(y + step, w[1]) - below(y, w[1]));
                left += seen;
                note_truth("T27 beam on a wall: irradiance over its peak 2P/(pi w^2)",
                           reference ? "reference" : "device", fabs(seen - expected) / peak,
                           reference ? 2e-2 : 2e-3);
                if (!(fabs(seen - expected) <= (reference ? 2e-2 : 2e-3) * peak))
                    fail_msg("%s: pixel (%d, %d) gets %g W, expected %g",
                             reference ? "reference" : "device", column, row, seen, expected);
            }
            note_truth("T27 beam on a wall: share that passes a knife edge",
                       reference ? "reference" : "device",
                       fabs(left / power - below(x + step, w[0])), 1e-3);
            if (!(fabs(left / power - below(x + step, w[0])) <= 1e-3))
                fail_msg("%s: %g of the power before the edge at %g m, expected %g",
                         reference ? "reference" : "device", left / power, x + step,
                         below(x + step, w[0]));
        }
        mcv_scene_free(scene);
    }
}

/*
 * A black plate stands in the beam: of the power, the share that reaches the wall behind it is that
 * of the beam before its edge, by the width there. In the waist each point of the wall gets light
 * of the whole width, and a ray from the waist's middle would pass whole. The camera stands behind
 * the plate. 512 samples by chance know a pixel's share to 0.022, and the power of some 65
 * pixels to 0.0028; 4.5 of that are 0.0125, and four times as much of the reference's 32. The field
 * leaves out 1e-6.
 */
static void test_behind_a_knife_edge(void **state) {
    (void)state;
    static const struct {
        int axis;
        double distance, edge;
    } cases[] = {{0, 0.2, 1e-4}, {0, 0.3, -2e-4}, {1, 0.2, -5e-5}};
    const double width = 8e-3, waists[2] = {2e-4, 1.5e-4}, m2[2] = {5, 2};
    for (size_t i = 0; i < 6; ++i) {
        const bool reference = i >= 3;
        const double bound = reference ? 0.05 : 0.0125;
        const int axis = cases[i % 3].axis;
        const double edge = cases[i % 3].edge, distance = cases[i % 3].distance,
                     expected = below(edge, radius(waists[axis], m2[axis], distance - 0.2));
        mcv_scene *scene = wall_scene(BEAM "\"workingDistance\":\"200mm\"", 0.5, 0.1, width, width);
        double powers[SIDE * SIDE], sum = 0;
        add_rectangle(scene, 0.1, 0.1, add_diffuse(scene, 0),
                      looking_up_z(axis ? 0 : edge + 0.05, axis ? edge + 0.05 : 0, -distance));
        powers_of(scene, reference, reference ? 32 : 512, width * width / (SIDE * SIDE), powers);
        for (int k = 0; k < SIDE * SIDE; ++k) sum += powers[k];
        print_message("edge at %g m, axis %d: %.4f passes, expected %.4f\n", distance, axis,
                      sum / power, expected);
        note_truth("T27 beam behind a knife edge: share of the power",
                   reference ? "reference" : "device", fabs(sum / power - expected), bound);
        if (!(fabs(sum / power - expected) <= bound))
            fail_msg("%s: edge at %g m, axis %d: %g of the power passes, expected %g",
                     reference ? "reference" : "device", distance, axis, sum / power, expected);
        mcv_scene_free(scene);
    }
}

/* The share of a fan's power up to the tangent t, of half-angle `half`. */
static double fan_below(int profile, double half, double t) {
    const double angle = fmin(fmax(atan(t), -half), half);
    uint8_t rgb[3];
    double share = 0, all = 0;
    switch (profile) {
    case 0:
        return (tan(angle) / tan(half) + 1) / 2;
    case 1:
        return (angle / half + 1) / 2;
    case 2:
        return (erf(M_SQRT2 * angle / half) / erf(M_SQRT2) + 1) / 2;
    default:
        for (uint32_t k = 0; k < 6; ++k) {
            value_of(6, 1, k, 0, rgb);
            const double sent = linear(rgb[0]) + linear(rgb[1]) + linear(rgb[2]);
            share += sent * fmin(fmax((angle / half + 1) / 2 * 6 - k, 0), 1);
            all += sent;
        }
        return share / all;
    }
}

/*
 * What each column of the wall gets of a line, by the integral of its profile over the angle, and
 * the line's thickness and bend: mean and variance of the rows, w²/4 and a row's h²/12. The fan's
 * ends and the table's steps lie within pixels, of which 1024 samples find the share to 2 %.
 */
static void test_lines_on_a_wall(void **state) {
    (void)state;
    static const char *const profiles[] = {"plane", "angle", "gaussian",
                                           "table\",\"image\":\"picture"};
    const double distance = 0.2, half = 20 * M_PI / 180, width = 0.18, height = 3e-3;
    for (int i = 0; i < 6; ++i) {
        const int profile = i < 4 ? i : i - 2;
        const bool reference = i >= 4; /* of the two last ones, which differ most */
        char *emitter =
            text_of(LINE "\"M2\":3,\"workingDistance\":\"100mm\",\"fanAngle\":\"40deg\","
                         "\"straightness\":0.004,\"fanProfile\":\"%s\"",
                    profiles[profile]);
        mcv_scene *scene = wall_scene(emitter, distance, 0.5, width, height);
        double powers[SIDE * SIDE];
        powers_of(scene, reference, 64, width * height / (SIDE * SIDE), powers);
        for (int column = 0; column < SIDE; ++column) {
            const double x = (column - SIDE / 2) * width / SIDE, row_height = height / SIDE;
            const double t0 = x / distance, t1 = (x + width / SIDE) / distance,
                         expected =
                             power * (fan_below(profile, half, t1) - fan_below(profile, half, t0));
            double sum = 0, mean = 0, squares = 0;
            for (int row = 0; row < SIDE; ++row) {
                const double y = (SIDE / 2 - 0.5 - row) * row_height,
                             seen = powers[row * SIDE + column];
                sum += seen;
                mean += seen * y;
                squares += seen * y * y;
            }
            if (!(fabs(sum - expected) <= 0.02 * expected + 1e-9))
                fail_msg("%s, \"%s\": column %d gets %g W, expected %g",
                         reference ? "reference" : "device", profiles[profile], column, sum,
                         expected);
            const double t = (t0 + t1) / 2, rho = distance * hypot(1, t), angle = atan(t);
            if (!(fabs(t) < 0.9 * tan(half))) continue;
            /* Within a column the bend changes by 2 β dφ/φ ρ: 3e-5 m at most. */
            const double bent = 2 * tan(half) * 0.004 * pow(angle / half, 2) * rho,
                         w = radius(3e-4, 3, rho - 0.1),
                         seen =
                             2 * sqrt(squares / sum - pow(mean / sum, 2) - pow(row_height, 2) / 12);
            note_truth("T27 line on a wall: thickness", reference ? "reference" : "device",
                       fabs(seen / w - 1), 0.01);
            if (!(fabs(mean / sum - bent) <= 1e-5) || !(fabs(seen / w - 1) <= 0.01))
                fail_msg("%s, \"%s\": column %d is %g m thick and %g m aside, expected %g and %g",
                         reference ? "reference" : "device", profiles[profile], column, seen,
                         mean / sum, w, bent);
        }
        mcv_scene_free(scene);
        free(emitter);
    }
}

/* All of the power falls on a floor that lies aslant to the camera, of three crossed lines with a
 * boresight, and of three spots. Both are wide: the pictures shall have no pixels that only double
 * precision tells from 0. */
static void test_power(void **state) {
    (void)state;
    static const char *const of[] = {
        THREE "\"lineThickness\":\"40mm\",\"widthMeasure\":\"FWHM\",\"fanAngle\":\"60deg\","
              "\"fanProfile\":\"gaussian\",\"lineCount\":3,\"interBeamAngle\":\"6deg\","
              "\"boresightX\":\"20mrad\",\"boresightY\":\"-10mrad\"",
        THREE "\"beamDiameter\":\"50mm\",\"widthMeasure\":\"FWHM\",\"lineCount\":3,"
              "\"interBeamAngle\":\"6deg\",\"boresightX\":\"20mrad\""};
    for (size_t i = 0; i < 2; ++i) {
        char *text = rig_text("", of[i], ONE_PIXEL, 0.1, "laser.png");
        const double each[3] = {0.02, 0.01, 0.005};
        write_png("laser.png", 6, 1);
        expect_power(text, each, 0.3, 0, i ? "spots" : "lines");
        free(text);
    }
}

/* --- bad input --- */

static void test_bad_input(void **state) {
    (void)state;
    static const bad_emitter cases[] = {
        {COMMON "\"beamDiameter\":1e-3", "emitters/e/widthMeasure: is missing: say what "
                                         "beamDiameter 0.001 m is, \"1/e2\" or \"FWHM\""},
        {COMMON "\"lineThickness\":1e-3,\"fanAngle\":1", "emitters/e/widthMeasure: is missing"},
        {COMMON "\"widthMeasure\":\"FWHM\"", "emitters/e/beamDiameter: is missing"},
        {COMMON "\"widthMeasure\":\"FWHM\",\"fanAngle\":1", "emitters/e/lineThickness: is missing"},
        {COMMON "\"lineThickness\":1e-3,\"widthMeasure\":\"FWHM\"",
         "emitters/e: has lineThickness, but a laser without fanAngle is a beam: give "
         "beamDiameter"},
        {BEAM "\"fanAngle\":1", "emitters/e: has beamDiameter, but a fanAngle makes it a line"},
        {COMMON "\"beamDiameter\":1e-3,\"widthMeasure\":\"1/e2\",\"M2\":0.9", "emitters/e/M2: "},
        {LINE "\"fanAngle\":0", "emitters/e/fanAngle: "},
        {LINE "\"fanAngle\":\"121deg\"", "emitters/e/fanAngle: "},
        {LINE "\"fanAngle\":1,\"fanProfile\":\"table\"", "emitters/e/image: is missing"},
        {LINE "\"fanAngle\":1,\"image\":0", "emitters/e/fanProfile: must be \"table\""},
        {LINE "\"fanAngle\":1,\"lineCount\":2", "emitters/e/interBeamAngle: must be above 0"},
        {LINE "\"fanAngle\":1,\"lineCount\":64,\"interBeamAngle\":0.1",
         "emitters/e/interBeamAngle: 0.1 rad turns the outermost of 64 lines by 3.15 rad"},
        {BEAM "\"straightness\":0.01", "emitters/e: has straightness, but draws no line"},
        {COMMON "\"beamDiameter\":\"1um\",\"widthMeasure\":\"1/e2\",\"M2\":2",
         "emitters/e: a waist of 1/e² radius 5e-07 m diverges by 0.84"},
        {"\"type\":\"laser\",\"power\":1", "emitters/e/wavelength: is missing"},
        {"\"type\":\"laser\",\"wavelength\":6e-7", "emitters/e/power: is missing"},
    };
    write_png("laser.png", 6, 1);
    refuse_emitters(cases, sizeof cases / sizeof cases[0], "laser.png");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_rays_are_a_beam),
        cmocka_unit_test(test_slopes_at_a_point),
        cmocka_unit_test(test_measures),
        cmocka_unit_test(test_beam_on_a_wall),
        cmocka_unit_test(test_behind_a_knife_edge),
        cmocka_unit_test(test_lines_on_a_wall),
        cmocka_unit_test(test_power),
        cmocka_unit_test(test_bad_input),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
