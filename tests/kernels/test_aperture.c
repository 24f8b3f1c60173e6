/* SPDX-License-Identifier: Apache-2.0 */
/* Apertures that are no full disc: places of rays, moments, weights, the way back of light paths,
 * and the baseline of two half apertures in rendered pictures. */
#include "elements.h"
#include "sensor_json.h"

#include "scene/aperture.h"

enum { CASES = 1 << 16 };
static const double radius = 0.004, image_distance = 0.02, pixel = 20e-6;

/* Grey cells without symmetry, which reach beyond the disc. */
static mcv_mask grey_mask(void) {
    mcv_mask mask = {.side = 5};
    for (int i = 0; i < 25; ++i) mask.values[i] = (float)((i * 7 + i * i) % 5) / 4;
    return mask;
}

static mcv_sensor lens_with(uint32_t type, int shape, int radiometry) {
    mcv_sensor sensor = sensor_defaults(type);
    if (type == MCV_SENSOR_THIN_LENS) {
        mcv_thin_lens_params *p = &sensor.as.thin_lens;
        p->focalLength = 0.018;
        p->imageDistance = image_distance;
        p->lensDiameter = 2 * radius;
        p->resolution[0] = p->resolution[1] = 64;
        p->pixelSize[0] = p->pixelSize[1] = pixel;
        p->radiometry = radiometry;
        p->aperture = shape;
        if (shape == MCV_APERTURE_HALF || shape == MCV_APERTURE_BLADES) p->apertureRotation = 0.7;
        if (shape == MCV_APERTURE_MASK) p->apertureMask = grey_mask();
    } else {
        mcv_telecentric_params *p = &sensor.as.telecentric;
        p->focalLength = 0.04;
        p->imageDistance = 0.06;
        p->stopDiameter = 2 * radius;
        p->resolution[0] = p->resolution[1] = 64;
        p->pixelSize[0] = p->pixelSize[1] = pixel;
        p->radiometry = radiometry;
        p->aperture = shape;
        if (shape == MCV_APERTURE_HALF || shape == MCV_APERTURE_BLADES) p->apertureRotation = 0.7;
        if (shape == MCV_APERTURE_MASK) p->apertureMask = grey_mask();
    }
    return sensor;
}

/* Sobol-like: a lattice of pairs in (0, 1)², and pixels that do not matter. */
static void make_cases(size_t words, uint32_t *cases) {
    for (size_t i = 0; i < CASES; ++i) {
        uint32_t *c = cases + words * i;
        c[0] = (uint32_t)(i % 64), c[1] = (uint32_t)(i / 64 % 64);
        c[2] = c[3] = as_uint(0.5F);
        c[4] = as_uint((float)((double)(i % 256) / 256 + 0x1p-9));
        c[5] = as_uint((float)((double)(i / 256) / 256 + 0x1p-9));
        if (words > 6) c[6] = as_uint(0.3F);
    }
}

/* Mean of x, y and r² over the open area, in radii; and what of the disc is open. */
static void moments_of(const mcv_aperture_shape *s, double moments[3], double *open) {
    const double n = s->blades;
    moments[0] = moments[1] = 0;
    moments[2] = 0.5;
    *open = 1;
    if (s->shape == MCV_APERTURE_RING) {
        moments[2] = (1 + s->ratio * s->ratio) / 2;
        *open = 1 - s->ratio * s->ratio;
    } else if (s->shape == MCV_APERTURE_HALF) {
        moments[0] = 4 / (3 * M_PI) * cos(s->rotation);
        moments[1] = 4 / (3 * M_PI) * sin(s->rotation);
        *open = 0.5;
    } else if (s->shape == MCV_APERTURE_BLADES) {
        moments[2] = (2 + cos(2 * M_PI / n)) / 6;
        *open = n * sin(2 * M_PI / n) / (2 * M_PI);
    } else if (s->shape == MCV_APERTURE_MASK) {
        /* By squares of 1/1000 of the radius, some 6000 of which lie on the rim: 2e-3 at most. */
        double sum[4] = {0};
        for (int j = -1000; j < 1000; ++j)
            for (int i = -1000; i < 1000; ++i) {
                const double x = (i + 0.5) / 1000, y = (j + 0.5) / 1000, r2 = x * x + y * y;
                const int column = (i + 1000) / 400, row = (999 - j) / 400;
                const double v = r2 < 1 ? (double)s->mask->values[5 * row + column] * 1e-6 : 0;
                sum[0] += v, sum[1] += v * x, sum[2] += v * y, sum[3] += v * r2;
            }
        for (int k = 0; k < 3; ++k) moments[k] = sum[k + 1] / sum[0];
        *open = sum[0] / M_PI;
    } else if (s->shape == MCV_APERTURE_CODED) {
        /* By the cells, of which the squares mod p say which are open. */
        double sum[4] = {0};
        for (uint32_t j = 0; j < s->order; ++j)
            for (uint32_t i = 1; i < s->order; ++i) {
                bool squares[2] = {false, false};
                for (uint32_t k = 1; k < s->order; ++k) {
                    squares[0] = squares[0] || k * k % s->order == i;
                    squares[1] = squares[1] || k * k % s->order == j;
                }
                if (j > 0 && squares[0] != squares[1]) continue;
                const double cell = M_SQRT2 / s->order, x = (i + 0.5) * cell - M_SQRT1_2,
                             y = M_SQRT1_2 - (j + 0.5) * cell;
                sum[0] += 1, sum[1] += x, sum[2] += y;
                sum[3] += x * x + y * y + cell * cell / 6;
            }
        for (int k = 0; k < 3; ++k) moments[k] = sum[k + 1] / sum[0];
        *open = sum[0] * 2 / (s->order * s->order) / M_PI;
    }
}

/* The weight of a ray through the disc: of a mask, that of its cells over the part in the disc. */
static double boost_of(const mcv_aperture_shape *s) {
    double sum = 0;
    for (int i = 0; s->shape == MCV_APERTURE_MASK && i < 25; ++i) sum += (double)s->mask->values[i];
    return sum > 0 ? sum * 4 / 25 / (M_PI * mcv_aperture_open(s)) : 1;
}

/*
 * A lattice of 256 x 256 pairs integrates these moments within 1/256 of the largest slope, 2e-3
 * measured at most; a wrong shape is off by some hundredths.
 */
static void check_moments(uint32_t type, int shape, int radiometry, uint32_t *cases,
                          float *sights) {
    mcv_scene *scene = mcv_scene_new("sensor");
    const mcv_sensor values = lens_with(type, shape, radiometry);
    add_sensor(scene, type, &values, mcv_transform_identity());
    const mcv_sensor *sensor = &scene->sensors[0];
    const mcv_aperture_shape s = mcv_sensor_aperture(sensor);
    double truth[3], open, found[4] = {0};
    moments_of(&s, truth, &open);
    assert_true(fabs(mcv_aperture_open(&s) - open) < (shape == MCV_APERTURE_MASK ? 2e-3 : 1e-12));
    const double boost = boost_of(&s);
    make_cases(6, cases);
    device_sights(sensor, CASES, cases, sights);
    for (size_t i = 0; i < CASES; ++i) {
        const float *out = sights + 7 * i;
        /* On the lens, or by the direction on the stop. */
        const double scale = type == MCV_SENSOR_THIN_LENS ? 1 / radius : -0.04 / radius,
                     x = scale * (double)out[type == MCV_SENSOR_THIN_LENS ? 0 : 3],
                     y = scale * (double)out[type == MCV_SENSOR_THIN_LENS ? 1 : 4];
        /* A/h² cos⁴, of the whole disc times the open share: near the axis cos⁴ is 0.96 at least.
         */
        const double h = type == MCV_SENSOR_THIN_LENS ? image_distance : 0.02,
                     whole = M_PI * radius * radius / (h * h),
                     d = 1 + (double)out[3] * out[3] + (double)out[4] * out[4],
                     weight = radiometry == MCV_RADIOMETRY_RADIANCE
                                  ? (double)out[6]
                                  : (double)out[6] * d * d / (whole * mcv_aperture_open(&s));
        if (weight == 0 && shape == MCV_APERTURE_MASK) continue; /* beyond the disc */
        assert_true(x * x + y * y <= 1 + 1e-5);
        if (!(fabs(weight / boost - 1) < 1e-5))
            fail_msg("aperture %d: a weight of %g", shape, weight);
        found[3] += weight / CASES;
        if (shape == MCV_APERTURE_RING) assert_true(x * x + y * y >= s.ratio * s.ratio - 1e-5);
        if (shape == MCV_APERTURE_HALF) assert_true(x * cos(0.7) + y * sin(0.7) > -1e-5);
        found[0] += weight * x / CASES, found[1] += weight * y / CASES;
        found[2] += weight * (x * x + y * y) / CASES;
    }
    for (int k = 0; k < 4; ++k)
        if (!(fabs(found[k] - (k < 3 ? truth[k] : 1)) < 4e-3))
            fail_msg("aperture %d: moment %d is %g", shape, k, found[k]);
    mcv_scene_free(scene);
}

/* The reference sees through the same aperture: its rays are uniform on the disc, and their weights
 * open it. 2^18 samples on a lattice; a wrong shape is off by some hundredths. */
static void test_reference(void **state) {
    (void)state;
    for (int shape = MCV_APERTURE_RING; shape <= MCV_APERTURE_MASK; ++shape) {
        mcv_scene *scene = mcv_scene_new("sensor");
        const mcv_sensor values = lens_with(MCV_SENSOR_THIN_LENS, shape, MCV_RADIOMETRY_RADIANCE);
        double truth[3], open, found[4] = {0};
        add_sensor(scene, MCV_SENSOR_THIN_LENS, &values, mcv_transform_identity());
        const mcv_aperture_shape s = mcv_sensor_aperture(scene->sensors);
        moments_of(&s, truth, &open);
        for (int i = 0; i < 512; ++i)
            for (int k = 0; k < 512; ++k) {
                const ref_sensor_ray ray = ref_sensor_ray_sample(scene->sensors, 32, 32, 0.5, 0.5,
                                                                 (i + 0.5) / 512, (k + 0.5) / 512);
                const double x = ray.origin.x / radius, y = ray.origin.y / radius,
                             weight = ray.weight / (512 * 512);
                found[0] += weight * x, found[1] += weight * y;
                found[2] += weight * (x * x + y * y), found[3] += weight;
            }
        for (int k = 0; k < 4; ++k)
            if (!(fabs(found[k] - (k < 3 ? truth[k] : 1)) < 4e-3))
                fail_msg("aperture %d: moment %d is %g", shape, k, found[k]);
        mcv_scene_free(scene);
    }
}

/* Cells that all pass are the disc, and two of four are a half, whose centroid is 4/(3π) aside. */
static void test_masks(void **state) {
    mcv_aperture device;
    mcv_mask all = {.side = 7}, half = {.side = 2, .values = {0, 1, 0, 1}};
    mcv_aperture_shape s = {
        .shape = MCV_APERTURE_MASK, .ratio = NAN, .rotation = NAN, .mask = &all};
    (void)state;
    for (int i = 0; i < 49; ++i) all.values[i] = 1;
    assert_true(fabs(mcv_aperture_open(&s) - 1) < 1e-12);
    s.mask = &half;
    assert_true(fabs(mcv_aperture_open(&s) - 0.5) < 1e-12);
    mcv_aperture_prepare(&s, false, &device);
    assert_true(fabs((double)device.weight - 4 / M_PI) < 1e-6);
    double sum = 0, moment = 0;
    for (int i = 0; i < 512; ++i)
        for (int k = 0; k < 512; ++k) {
            const mcv_pupil_sample p =
                mcv_sample_aperture(&device, ((float)i + 0.5f) / 512, ((float)k + 0.5f) / 512);
            sum += (double)p.weight / (512 * 512), moment += (double)(p.weight * p.x) / (512 * 512);
        }
    /* Lattice points near the rim: 1/512 of the moments at most. */
    assert_true(fabs(sum - 1) < 2e-3 && fabs(moment - 4 / (3 * M_PI)) < 2e-3);
}

static void test_refused(void **state) {
    static const struct {
        const char *json, *says;
    } cases[] = {
        {"\"aperture\":\"square\"", "must be \"disc\" or \"ring\" or \"half\" or \"blades\""},
        {"\"aperture\":\"ring\",\"apertureRatio\":1", "apertureRatio: 1 must be"},
        {"\"apertureRatio\":0.5", "apertureRatio: is of the aperture \"ring\", not of \"disc\""},
        {"\"aperture\":\"half\",\"apertureBlades\":5", "is of the aperture \"blades\", not of"},
        {"\"aperture\":\"coded\",\"apertureOrder\":15", "apertureOrder: 15 must be a prime"},
        {"\"aperture\":\"mask\"", "apertureMask: is missing"},
        {"\"apertureMask\":[[1]]", "apertureMask: is of the aperture \"mask\", not of \"disc\""},
        {"\"aperture\":\"mask\",\"apertureMask\":[[1,0],[1]]", "has 1 numbers, but must have 2"},
        {"\"aperture\":\"mask\",\"apertureMask\":[[1,2],[1,0]]", "must be a number from 0 to 1"},
        {"\"aperture\":\"mask\",\"apertureMask\":7", "must be an array of 1 to 32 rows"},
        {"\"aperture\":\"mask\",\"apertureMask\":[[0]]", "lets no light through"},
    };
    (void)state;
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        char json[512];
        mcv_sensor sensor;
        mcv_error error = {""};
        snprintf(json, sizeof json,
                 "{\"focalLength\":0.02,\"imageDistance\":0.021,\"fNumber\":4,\"resolution\":4,"
                 "\"pixelSize\":1e-5,%s}",
                 cases[i].json);
        const mcv_result result = sensor_of(MCV_SENSOR_THIN_LENS, json, &sensor, &error);
        if (result != MCV_BAD_INPUT || !strstr(error.text, cases[i].says))
            fail_msg("%s gave %d, \"%s\"; must say \"%s\"", json, result, error.text,
                     cases[i].says);
    }
}

static void test_moments(void **state) {
    uint32_t *cases = malloc(6 * sizeof *cases * CASES);
    float *sights = floats(7 * (size_t)CASES);
    (void)state;
    assert_non_null(cases);
    for (int shape = MCV_APERTURE_RING; shape <= MCV_APERTURE_MASK; ++shape) {
        check_moments(MCV_SENSOR_THIN_LENS, shape, MCV_RADIOMETRY_RADIANCE, cases, sights);
        check_moments(MCV_SENSOR_TELECENTRIC, shape, MCV_RADIOMETRY_IRRADIANCE, cases, sights);
    }
    free(cases);
    free(sights);
}

/* W of rays through the open part: that of the disc over the open share, so that light paths bring
 * the same light as camera paths. */
static void test_way_back(void **state) {
    uint32_t *cases = malloc(7 * sizeof *cases * CASES);
    float *results = floats(6 * (size_t)CASES);
    (void)state;
    assert_non_null(cases);
    for (int shape = MCV_APERTURE_RING; shape <= MCV_APERTURE_MASK; ++shape) {
        mcv_scene *scene = mcv_scene_new("sensor");
        const mcv_sensor values = lens_with(MCV_SENSOR_THIN_LENS, shape, MCV_RADIOMETRY_IRRADIANCE);
        size_t closed = 0;
        add_sensor(scene, MCV_SENSOR_THIN_LENS, &values, mcv_transform_identity());
        const mcv_aperture_shape s = mcv_sensor_aperture(scene->sensors);
        const double slope = pixel / image_distance,
                     area = M_PI * radius * radius * mcv_aperture_open(&s) * slope * slope;
        make_cases(7, cases);
        run_sensor("invert_sensor", scene->sensors, CASES, cases, 7 * sizeof *cases, results,
                   6 * sizeof *results);
        for (size_t i = 0; i < CASES; ++i) {
            const float *out = results + 6 * i;
            if (out[2] == 0) {
                ++closed; /* at the rim */
                continue;
            }
            /* Of a mask, what the cell passes: quarters. */
            const double share = (double)out[2] * area / (double)out[5] * boost_of(&s),
                         truth = shape == MCV_APERTURE_MASK ? round(4 * share) / 4 : 1;
            if (!(fabs(share - truth) < 2e-5) || truth == 0)
                fail_msg("aperture %d: W is %g of its truth", shape, share);
        }
        const double beyond = shape == MCV_APERTURE_MASK ? 1 - 1 / boost_of(&s) : 0;
        assert_true(fabs((double)closed / CASES - beyond) < (beyond > 0 ? 4e-3 : 2e-3));
        mcv_scene_free(scene);
    }
    free(cases);
    free(results);
}

static mcv_image render_edge(double rotation, double depth) {
    mcv_scene *scene = mcv_scene_new("edge");
    mcv_sensor camera = lens_with(MCV_SENSOR_THIN_LENS, MCV_APERTURE_HALF, 0);
    mcv_render_options options = mcv_render_defaults();
    mcv_render_stats stats;
    mcv_film film;
    mcv_image image;
    camera.as.thin_lens.apertureRotation = rotation;
    add_environment(scene, 1);
    add_rectangle(scene, 0.2, 0.2, add_absorber(scene), looking_up_z(0.1, 0, -depth));
    add_sensor(scene, MCV_SENSOR_THIN_LENS, &camera, looking_down_z(0, 0, 0));
    options.replicates = 2;
    options.last = 256;
    options.depth = 1;
    BUILD(mcv_render(scene, 0, &options, &film, &stats, &builder_error));
    BUILD(mcv_film_develop(&film, &image, NULL, &builder_error));
    mcv_film_free(&film);
    mcv_scene_free(scene);
    return image;
}

/* The mean column of the edge. */
static double place_of_edge(const mcv_image *image) {
    double first = 0, sum = 0;
    for (uint32_t row = 0; row < image->height; ++row)
        for (uint32_t i = 1; i < image->width; ++i) {
            const float *at = image->pixels + (size_t)row * image->width + i;
            sum += (double)at[0] - at[-1], first += i * ((double)at[0] - at[-1]);
        }
    return first / sum;
}

/*
 * Two half discs see an edge from two places, the centroids of the halves: they lie B = 8 r/(3π)
 * apart, so the pictures of an edge at the depth z are B b |1/z - 1/w| apart. Two pictures of 64
 * rows leave 0.01 pixels of noise (measured: 0.004) of 7.6.
 */
static void test_baseline(void **state) {
    const double f = 0.018, w = f * image_distance / (image_distance - f);
    static const double depths[] = {0.14, 0.24};
    (void)state;
    for (int i = 0; i < 2; ++i) {
        mcv_image right = render_edge(0, depths[i]), left = render_edge(M_PI, depths[i]);
        const double truth =
                         8 * radius / (3 * M_PI) * image_distance * (1 / w - 1 / depths[i]) / pixel,
                     found = place_of_edge(&right) - place_of_edge(&left);
        print_message("  edge at %g mm: %.4f pixels apart, must be %.4f\n", 1e3 * depths[i], found,
                      truth);
        if (!(fabs(found - truth) < 0.02)) fail_msg("%.4f pixels, not %.4f", found, truth);
        mcv_image_free(&right);
        mcv_image_free(&left);
    }
}

static int open_with_features(void **state) {
    element_features = MCV_FEATURE_BIT(APERTURE) | MCV_FEATURE_BIT(LIGHT_TRACING);
    return open_device(state);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_moments),  cmocka_unit_test(test_way_back),
        cmocka_unit_test(test_baseline), cmocka_unit_test(test_reference),
        cmocka_unit_test(test_masks),    cmocka_unit_test(test_refused)};
    return cmocka_run_group_tests(tests, open_with_features, close_device);
}
