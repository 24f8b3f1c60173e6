/* SPDX-License-Identifier: Apache-2.0 */
/* Principal point, region of interest and binning: each pixel sees what the same pixels of the
 * whole film see. */
#include "reference_checks.h"

#include "scene/sensors.h"

#include <float.h>

/* Which sensors are rendered with: no file of tests shall take long. */
#ifndef FIRST_RENDERED
#define FIRST_RENDERED MCV_SENSOR_PINHOLE
#define END_RENDERED MCV_SENSOR_TELECENTRIC
#endif

enum { WIDTH = 24, HEIGHT = 16, J = 3, K = 2 };
static const double pixel = 100e-6;

/* What of a film is read out. */
typedef struct part {
    double principal_point[2];
    uint32_t region[4], binning[2];
} part;

static const part whole = {{NAN, NAN}, {MCV_NONE, MCV_NONE, MCV_NONE, MCV_NONE}, {1, 1}};

#define SET_PART(p, r) \
    do { \
        memcpy((p)->principalPoint, (r)->principal_point, sizeof(r)->principal_point); \
        memcpy((p)->regionOfInterest, (r)->region, sizeof(r)->region); \
        memcpy((p)->binning, (r)->binning, sizeof(r)->binning); \
    } while (0)

#define SET_FILM(p, r) \
    do { \
        (p)->resolution[0] = WIDTH, (p)->resolution[1] = HEIGHT; \
        (p)->pixelSize[0] = (p)->pixelSize[1] = pixel; \
        SET_PART(p, r); \
    } while (0)

#define SET_LENS(p) \
    do { \
        (p)->fNumber = 4; \
        (p)->radiometry = MCV_RADIOMETRY_IRRADIANCE; \
    } while (0)

/* One sensor of each type, with WIDTH x HEIGHT pixels, macro pixels of the light field camera, in
 * focus at 0.25 m. */
static mcv_sensor sensor_of(uint32_t type, const part *read) {
    mcv_sensor sensor = sensor_defaults(type);
    switch (type) {
    case MCV_SENSOR_PINHOLE: {
        mcv_pinhole_params *p = &sensor.as.pinhole;
        p->imageDistance = 0.03;
        SET_FILM(p, read);
        break;
    }
    case MCV_SENSOR_THIN_LENS: {
        mcv_thin_lens_params *p = &sensor.as.thin_lens;
        p->focalLength = 0.025;
        p->focusDistance = 0.25;
        SET_LENS(p);
        SET_FILM(p, read);
        break;
    }
    case MCV_SENSOR_TELECENTRIC: {
        mcv_telecentric_params *p = &sensor.as.telecentric;
        p->magnification = 0.125;
        p->workingDistance = 0.25;
        SET_LENS(p);
        SET_FILM(p, read);
        break;
    }
    case MCV_SENSOR_FLYING_SPOT: {
        mcv_flying_spot_params *p = &sensor.as.flying_spot;
        p->wavelength = 660e-9;
        p->beamDiameter[0] = p->beamDiameter[1] = 4 * pixel;
        p->widthMeasure = 1;
        p->workingDistance = 0.2;
        SET_FILM(p, read);
        break;
    }
    default: {
        mcv_light_field_params *p = &sensor.as.light_field;
        p->focalLength = 0.025;
        p->focusDistance = 0.25;
        SET_LENS(p);
        p->spatialResolution[0] = WIDTH, p->spatialResolution[1] = HEIGHT;
        p->angularResolution[0] = J;
        p->angularResolution[1] = K;
        p->pixelSize[0] = p->pixelSize[1] = pixel / 2;
        SET_PART(p, read);
        break;
    }
    }
    return sensor;
}

/* A lit diffuse wall with a bright corner, nearer than the focus: no two pixels alike. */
static mcv_scene *scene_of(uint32_t type, const part *read) {
    mcv_scene *scene = mcv_scene_new("readout");
    const mcv_sensor sensor = sensor_of(type, read);
    add_rectangle(scene, 0.1, 0.1, add_diffuse(scene, 0.5), looking_up_z(0, 0, -0.22));
    add_emitter(
        scene, MCV_EMITTER_AREA,
        add_rectangle(scene, 0.008, 0.005, add_absorber(scene), looking_up_z(0.003, 0.002, -0.2)),
        1, 0);
    add_environment(scene, 0.5);
    add_sensor(scene, type, &sensor, looking_down_z(0, 0, 0));
    return scene;
}

static uint32_t across(uint32_t type) { return type == MCV_SENSOR_LIGHT_FIELD ? J : 1; }
static uint32_t down(uint32_t type) { return type == MCV_SENSOR_LIGHT_FIELD ? K : 1; }

/* A flying spot scanner is the last of the sensors, and refuses to bin. */
enum { BINNING_SENSORS = MCV_SENSOR_FLYING_SPOT };

/* The reference's ray of each sample of a binned region is the ray of the pixel of the whole film
 * that it falls into. */
static void test_rays_are_those_of_the_film(void **state) {
    const part read = {{NAN, NAN}, {5, 3, 12, 8}, {3, 2}};
    (void)state;
    for (uint32_t type = 0; type < BINNING_SENSORS; ++type) {
        mcv_scene *full = scene_of(type, &whole);
        mcv_scene *binned = scene_of(type, &read);
        const uint32_t j = across(type), k = down(type);
        ref_random random = {3};
        double worst = 0;
        for (int i = 0; i < 10000; ++i) {
            const uint32_t column = (uint32_t)(4 * j * ref_random_unit(&random)),
                           row = (uint32_t)(4 * k * ref_random_unit(&random));
            const double x = ref_random_unit(&random), y = ref_random_unit(&random);
            const double u = ref_random_unit(&random), v = ref_random_unit(&random);
            const ref_sensor_ray sight =
                ref_sensor_ray_sample(&binned->sensors[0], column, row, x, y, u, v);
            ref_sensor_ray same;
            if (type == MCV_SENSOR_LIGHT_FIELD) {
                /* (u, v) says which macro pixel, j and k stay. */
                const uint32_t m = 5 + column / J * 3 + (uint32_t)(3 * u),
                               n = 3 + row / K * 2 + (uint32_t)(2 * v);
                same = ref_sensor_ray_sample(&full->sensors[0], m * J + column % J, n * K + row % K,
                                             x, y, 0, 0);
            } else {
                const double place_x = 5 + 3 * (column + x), place_y = 3 + 2 * (row + y);
                same =
                    ref_sensor_ray_sample(&full->sensors[0], (uint32_t)place_x, (uint32_t)place_y,
                                          place_x - floor(place_x), place_y - floor(place_y), u, v);
            }
            worst = worse(worst, ref_length(ref_sub(sight.origin, same.origin)) / 0.1);
            worst = worse(worst, ref_length(ref_sub(sight.direction, same.direction)));
            worst = worse(worst, fabs(sight.weight - same.weight));
        }
        char what[64];
        snprintf(what, sizeof what, "%s: rays of a binned region",
                 (const char *[]){"pinhole", "thin lens", "telecentric", "light field"}[type]);
        /* A place of up to 24 pixels rounds a few times, in fractions of at most 0.1 m and 1 rad;
         * the weight is below 1. */
        check(what, worst, 0, 32 * DBL_EPSILON);
        mcv_scene_free(full);
        mcv_scene_free(binned);
    }
}

/* The pixel's corner at the principal point lies on the axis. */
static void test_principal_point(void **state) {
    const part read = {{6, 4}, {MCV_NONE, MCV_NONE, MCV_NONE, MCV_NONE}, {1, 1}};
    (void)state;
    for (uint32_t type = 0; type < MCV_SENSOR_LIGHT_FIELD; ++type) {
        mcv_scene *scene = scene_of(type, &read);
        const ref_sensor_ray sight = ref_sensor_ray_sample(&scene->sensors[0], 6, 4, 0, 0, 0, 0);
        assert_true(sight.origin.x == 0 && sight.origin.y == 0);
        assert_true(sight.direction.x == 0 && sight.direction.y == 0 && sight.direction.z == -1);
        /* The field shifts by what the axis does: 18 + 6 columns instead of 12 + 12. */
        const mcv_optics optics = mcv_sensor_optics(&scene->sensors[0]);
        if (type == MCV_SENSOR_PINHOLE)
            check("pinhole: angle of view off the axis [rad]", optics.field_angle[0],
                  atan(18 * pixel / 0.03) + atan(6 * pixel / 0.03), 8 * DBL_EPSILON);
        mcv_scene_free(scene);
    }
    /* In sensor pixels, whatever the macro pixels: the centre of macro pixel (1, 2) is 1.5 J, 2.5
     * K. */
    const part macro = {{1.5 * J, 2.5 * K}, {MCV_NONE, MCV_NONE, MCV_NONE, MCV_NONE}, {1, 1}};
    mcv_scene *scene = scene_of(MCV_SENSOR_LIGHT_FIELD, &macro);
    const ref_sensor_ray sight = ref_sensor_ray_sample(&scene->sensors[0], J + J / 2, 2 * K + K / 2,
                                                       0.5, 0, 0, 0); /* J is odd, K even */
    assert_true(hypot(sight.origin.x, sight.origin.y) == 0);
    assert_true(sight.direction.z == -1);
    mcv_scene_free(scene);
}

static mcv_film device_film(const mcv_scene *scene, uint32_t schedule, uint32_t replicates,
                            uint32_t samples) {
    mcv_render_options options = mcv_render_defaults();
    mcv_render_stats stats;
    mcv_film film;
    options.schedule = schedule;
    options.replicates = replicates;
    options.last = samples;
    options.depth = 3;
    BUILD(render_again(scene, 0, &options, &film, &stats, &builder_error));
    return film;
}

/* A region's image is that part of the whole image, bit for bit, in both schedules; with the
 * principal point off the middle too. */
static void test_region_has_the_same_bits(void **state) {
    (void)state;
    for (uint32_t type = FIRST_RENDERED; type < END_RENDERED; ++type) {
        part all = whole;
        part read = {{NAN, NAN}, {5, 3, 12, 9}, {1, 1}};
        if (type % 2)
            all.principal_point[0] = read.principal_point[0] = 7.3,
            all.principal_point[1] = read.principal_point[1] = 9.9;
        mcv_scene *scenes[2] = {scene_of(type, &all), scene_of(type, &read)};
        const uint32_t j = across(type), k = down(type);
        for (uint32_t schedule = MCV_SCHEDULE_TILE; schedule <= MCV_SCHEDULE_STREAM; ++schedule) {
            mcv_film full = device_film(scenes[0], schedule, 2, 4);
            mcv_film film = device_film(scenes[1], schedule, 2, 4);
            size_t different = 0;
            bool varied = false;
            assert_int_equal(film.width, 12 * j);
            assert_int_equal(film.height, 9 * k);
            for (uint32_t replicate = 0; replicate < 2; ++replicate) {
                for (uint32_t row = 0; row < film.height; ++row) {
                    for (uint32_t column = 0; column < film.width; ++column) {
                        const double value =
                            film.sums[((size_t)replicate * film.height + row) * film.width +
                                      column];
                        different +=
                            value !=
                            full.sums[((size_t)replicate * full.height + row + 3 * k) * full.width +
                                      column + 5 * j];
                        varied = varied || value != film.sums[0];
                    }
                }
            }
            if (different > 0)
                fail_msg(
                    "sensor %u, schedule %u: %zu of the region's values differ from the whole's",
                    type, schedule, different);
            assert_true(varied);
            mcv_film_free(&full);
            mcv_film_free(&film);
        }
        mcv_scene_free(scenes[0]);
        mcv_scene_free(scenes[1]);
    }
}

/*
 * A binned pixel is the mean of its pixels, each replicate an estimate of the difference. Student's
 * t with 15 degrees of freedom exceeds 6.5 once in 10^5; 144 pixels are tested with fixed seeds.
 */
static void test_binned_is_the_mean(void **state) {
    enum { BIN_X = 6, BIN_Y = 4 };
    const part read = {{NAN, NAN}, {0, 4, WIDTH, 8}, {BIN_X, BIN_Y}};
    (void)state;
    for (uint32_t type = FIRST_RENDERED; type < END_RENDERED && type < BINNING_SENSORS; ++type) {
        const uint32_t j = across(type), k = down(type);
        mcv_scene *full_scene = scene_of(type, &whole);
        mcv_scene *binned_scene = scene_of(type, &read);
        for (int on_device = 0; on_device < 2; ++on_device) {
            const mcv_render_options options = options_of(16, 3), more = options_of(64, 3);
            mcv_render_stats stats;
            mcv_film full = on_device ? device_film(full_scene, MCV_SCHEDULE_AUTO, REPLICATES, 16)
                                      : render_with(full_scene, &options, true, &stats);
            mcv_film binned = on_device
                                  ? device_film(binned_scene, MCV_SCHEDULE_AUTO, REPLICATES, 64)
                                  : render_with(binned_scene, &more, true, &stats);
            assert_int_equal(binned.width, 4 * j);
            assert_int_equal(binned.height, 2 * k);
            double worst = 0, scale = 0;
            for (uint32_t row = 0; row < binned.height; ++row) {
                for (uint32_t column = 0; column < binned.width; ++column) {
                    double differences[REPLICATES];
                    for (uint32_t r = 0; r < REPLICATES; ++r) {
                        double mean = 0;
                        for (uint32_t y = 0; y < BIN_Y; ++y) {
                            for (uint32_t x = 0; x < BIN_X; ++x) {
                                const uint32_t at_row = ((4 + row / k * BIN_Y + y) * k + row % k);
                                const uint32_t at_column =
                                    (column / j * BIN_X + x) * j + column % j;
                                mean += full.sums[((size_t)r * full.height + at_row) * full.width +
                                                  at_column] /
                                        (16 * BIN_X * BIN_Y);
                            }
                        }
                        differences[r] =
                            binned.sums[((size_t)r * binned.height + row) * binned.width + column] /
                                64 -
                            mean;
                        scale = fmax(scale, mean);
                    }
                    const mcv_estimate e = mcv_estimate_replicates(differences, REPLICATES);
                    /* Where all of the bin sees the same, the error is rounding: float32 on the
                     * device. */
                    const double rounding = scale * 0x1p-20;
                    worst = worse(worst, fmax(fabs(e.mean) - rounding, 0) /
                                             sqrt(fmax(e.variance, rounding * rounding)));
                }
            }
            print_message("  sensor %u, %s: binned pixels off by at most %.2f standard errors\n",
                          type, on_device ? "device" : "reference", worst);
            if (!(worst <= 6.5))
                fail_msg(
                    "sensor %u: a binned pixel is %g standard errors off the mean of its pixels",
                    type, worst);
            mcv_film_free(&full);
            mcv_film_free(&binned);
        }
        mcv_scene_free(full_scene);
        mcv_scene_free(binned_scene);
    }
}

/* What cannot be read out is refused, with the numbers. */
static void test_refused(void **state) {
    static const struct {
        part read;
        const char *says;
    } cases[] = {
        {{{NAN, NAN}, {0, 0, WIDTH, HEIGHT}, {5, 1}},
         "sensors/sensor/binning: 5 does not divide the 24 columns that are read out"},
        {{{NAN, NAN}, {MCV_NONE, MCV_NONE, MCV_NONE, MCV_NONE}, {1, 3}},
         "binning: 3 does not divide the 16 rows"},
        {{{NAN, NAN}, {20, 0, 5, 1}, {1, 1}},
         "regionOfInterest: columns 20 to 25 exceed the film, which has 24"},
        {{{NAN, NAN}, {0, 16, 1, 1}, {1, 1}},
         "regionOfInterest: rows 16 to 17 exceed the film, which has 16"},
        {{{NAN, NAN}, {0, 0, 4, 0}, {1, 1}}, "regionOfInterest: has no rows"},
        {{{2e6, 0}, {MCV_NONE, MCV_NONE, MCV_NONE, MCV_NONE}, {1, 1}},
         "principalPoint: 2e+06 must lie from -1e+06 to 1e+06"},
    };
    (void)state;
    for (uint32_t type = 0; type < BINNING_SENSORS; ++type) {
        for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
            mcv_scene *scene = mcv_scene_new("readout");
            mcv_sensor sensor = sensor_of(type, &cases[i].read);
            mcv_error error = {""};
            sensor.name = (char *)"sensor";
            assert_int_equal(mcv_scene_add_sensor(scene, &sensor, &error), MCV_BAD_INPUT);
            if (!strstr(error.text, cases[i].says))
                fail_msg("\"%s\" must say \"%s\"", error.text, cases[i].says);
            mcv_scene_free(scene);
        }
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_rays_are_those_of_the_film),
        cmocka_unit_test(test_principal_point),
        cmocka_unit_test(test_region_has_the_same_bits),
        cmocka_unit_test(test_binned_is_the_mean),
        cmocka_unit_test(test_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
