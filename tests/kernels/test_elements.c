/* SPDX-License-Identifier: Apache-2.0 */
/* ctest: label truth */
/*
 * Sensors, emitters and interfaces on the device against the reference's formulas in double, a
 * million cases each. u = 2^-24 is the relative error of one float32 operation; every bound counts
 * operations.
 */
#include "elements.h"

#include "reference/interface.h"
#include "reference/random.h"
#include "reference/sensor_ray.h"
#include "scene/emitters.h"
#include "scene/sensors.h"
#include "truths.h"

enum { CASES = 1 << 20 };
static const double u = 0x1p-24;

static ref_random random_numbers;

static double uniform(double low, double high) {
    return low + (high - low) * ref_random_unit(&random_numbers);
}

static float random_float(void) {
    return (float)(ref_random_bits(&random_numbers) >> 40) * 0x1p-24f;
}

static ref_vec random_direction(void) {
    const double z = uniform(-1, 1);
    const double around = uniform(0, 2 * M_PI);
    const double r = sqrt(1 - z * z);
    return (ref_vec){r * cos(around), r * sin(around), z};
}

static void run(const char *kernel_name, uint32_t sensor_type, const void *first,
                size_t first_bytes, const void *in, size_t in_bytes, void *out, size_t out_bytes) {
    run_elements(kernel_name, sensor_type, first, first_bytes, CASES, in, in_bytes, out, out_bytes);
}

/* Sensors */

/* What the sensor's numbers allow, for the bounds. */
typedef struct sensor_case {
    const char *name;
    mcv_sensor sensor;
    double aperture;       /* radius of what is sampled, times its factor to the lens [m] */
    double image_to_lens;  /* largest |s| times its factor to the lens [m] */
    double kappa;          /* |d direction / d origin| [1/m] */
    double direct;         /* largest |s/b| */
    double aperture_slope; /* aperture radius times its factor to the direction */
} sensor_case;

static void check_whole_or_part(const sensor_case *c) {
    mcv_scene *scene = mcv_scene_new("sensor");
    add_sensor(scene, c->sensor.type, &c->sensor, mcv_transform_identity());
    const mcv_sensor *sensor = &scene->sensors[0];
    uint32_t width;
    uint32_t height;
    mcv_sensor_film_size(sensor, &width, &height);
    uint32_t *cases = malloc(6 * sizeof(uint32_t) * CASES);
    float *sights = malloc(7 * sizeof(float) * CASES);
    assert_non_null(cases);
    assert_non_null(sights);
    random_numbers.state = 1;
    for (size_t i = 0; i < CASES; ++i) {
        cases[6 * i] = (uint32_t)uniform(0, width);
        cases[6 * i + 1] = (uint32_t)uniform(0, height);
        for (int k = 2; k < 6; ++k) cases[6 * i + k] = as_uint(random_float());
    }
    device_sights(sensor, CASES, cases, sights);

    /*
     * A disk point: three roundings in the ratio and the angle (3 u π/4), sine and cosine within
     * 8e-8, two products: 7 u of the radius. The pixel coordinate rounds once, its factor once, the
     * sum and the product of the other once: 4 u of |s|, 8 u of the disk. A direction: the same of
     * its two terms. A weight: A/h² rounds once, |d|² within 3 u and what d's own error brings,
     * squared and divided: 10 u + 4 times the error of d. A point within its error of the lens's
     * rim may fall on either side. A principal point that is no multiple of half a pixel rounds
     * once more, and pixels are then up to one off the middle of the largest |s|: 2 u.
     */
    const double origin_bound = 8 * u * c->aperture + 6 * u * c->image_to_lens;
    const double direction_bound =
        6 * u * c->direct + 8 * u * c->aperture_slope + c->kappa * origin_bound;
    double worst_origin = 0;
    double worst_direction = 0;
    double worst_weight = 0;
    size_t at_rim = 0;
    for (size_t i = 0; i < CASES; ++i) {
        const uint32_t *in = cases + 6 * i;
        const float *out = sights + 7 * i;
        const ref_sensor_ray sight = reference_sight(sensor, in);
        /* The node looks along -z: the optical frame's z turns. */
        const ref_vec d = {sight.direction.x / -sight.direction.z,
                           sight.direction.y / -sight.direction.z, 1};
        worst_origin =
            fmax(worst_origin, fmax(fabs(out[0] - sight.origin.x), fabs(out[1] - sight.origin.y)));
        worst_direction = fmax(worst_direction, fmax(fabs(out[3] - d.x), fabs(out[4] - d.y)));
        assert_true(out[2] == 0 && out[5] == 1);
        if ((out[6] > 0) != (sight.weight > 0))
            ++at_rim;
        else if (sight.weight > 0)
            worst_weight = fmax(worst_weight, fabs(out[6] / sight.weight - 1));
    }
    print_message("%s: origin %.2g of %.2g m, direction %.2g of %.2g, weight %.2g of %.2g, %zu of "
                  "%d at the rim\n",
                  c->name, worst_origin, origin_bound, worst_direction, direction_bound,
                  worst_weight, 10 * u + 4 * direction_bound, at_rim, CASES);
    if (strncmp(c->name, "light field", 11) == 0) {
        note_truth("T24 light field: place on the lens [m]", "device", worst_origin, origin_bound);
        note_truth("T24 light field: direction", "device", worst_direction, direction_bound);
    }
    assert_true(worst_origin <= origin_bound);
    assert_true(worst_direction <= direction_bound);
    assert_true(worst_weight <= 10 * u + 4 * direction_bound);
    /* Points within the error of the rim: their share of the area is below 4 x error / radius. */
    assert_true(at_rim <= 4 + 100 * CASES * u);
    free(cases);
    free(sights);
    mcv_scene_free(scene);
}

/* All of a sensor's image, and a binned part of it about a principal point off the middle. */
static void check_sensor(const sensor_case *c) {
    check_whole_or_part(c);
    sensor_case part = *c;
    uint32_t width, height;
    mcv_sensor_film_size(&c->sensor, &width, &height);
    const double principal[2] = {0.47 * width, 0.51 * height};
    const uint32_t region[4] = {17, 5, 96, 80};
    const uint32_t binning[2] = {3, 4};
#define SET_READOUT(p) \
    do { \
        memcpy((p)->principalPoint, principal, sizeof principal); \
        memcpy((p)->regionOfInterest, region, sizeof region); \
        memcpy((p)->binning, binning, sizeof binning); \
    } while (0)
    if (part.sensor.type == MCV_SENSOR_PINHOLE) SET_READOUT(&part.sensor.as.pinhole);
    if (part.sensor.type == MCV_SENSOR_THIN_LENS) SET_READOUT(&part.sensor.as.thin_lens);
    if (part.sensor.type == MCV_SENSOR_TELECENTRIC) SET_READOUT(&part.sensor.as.telecentric);
    if (part.sensor.type == MCV_SENSOR_LIGHT_FIELD) SET_READOUT(&part.sensor.as.light_field);
    /* The farthest pixel is 0.53 of the film away instead of 0.5. */
    part.image_to_lens *= 1.06;
    part.direct *= 1.06;
    check_whole_or_part(&part);
}

#define SET_FILM(p, columns, rows, width, height) \
    do { \
        (p)->resolution[0] = (columns), (p)->resolution[1] = (rows); \
        (p)->pixelSize[0] = (width), (p)->pixelSize[1] = (height); \
    } while (0)

static void test_pinhole(void **state) {
    sensor_case c = {.name = "pinhole", .sensor = sensor_defaults(MCV_SENSOR_PINHOLE)};
    mcv_pinhole_params *p = &c.sensor.as.pinhole;
    (void)state;
    p->imageDistance = 0.016;
    SET_FILM(p, 1279, 1024, 5e-6, 4e-6);
    c.direct = 640 * 5e-6 / 0.016;
    check_sensor(&c);
}

static void test_thin_lens(void **state) {
    sensor_case c = {.name = "thin lens", .sensor = sensor_defaults(MCV_SENSOR_THIN_LENS)};
    mcv_thin_lens_params *p = &c.sensor.as.thin_lens;
    (void)state;
    p->focalLength = 0.025;
    p->imageDistance = 0.0256;
    p->lensDiameter = 0.006;
    SET_FILM(p, 2448, 2048, 3.45e-6, 3.45e-6);
    p->radiometry = MCV_RADIOMETRY_IRRADIANCE;
    c.aperture = 0.003;
    c.kappa = 1 / 0.025 - 1 / 0.0256;
    c.direct = 1224 * 3.45e-6 / 0.0256;
    c.aperture_slope = c.kappa * 0.003;
    check_sensor(&c);
}

static void test_telecentric(void **state) {
    sensor_case c = {.name = "telecentric", .sensor = sensor_defaults(MCV_SENSOR_TELECENTRIC)};
    mcv_telecentric_params *p = &c.sensor.as.telecentric;
    (void)state;
    p->focalLength = 0.022;
    p->imageDistance = 0.0275;
    p->stopDiameter = 0.004;
    p->lensDiameter = 0.03; /* the field's corners are vignetted */
    SET_FILM(p, 2448, 2048, 3.45e-6, 3.45e-6);
    p->radiometry = MCV_RADIOMETRY_IRRADIANCE;
    c.aperture = 0.002 * 5;
    c.image_to_lens = 1224 * 3.45e-6 * 4;
    c.aperture_slope = 0.002 / 0.022;
    check_sensor(&c);
}

static void test_light_field(void **state) {
    (void)state;
    for (int circle = 0; circle < 2; ++circle) {
        sensor_case c = {.name = circle ? "light field, circle" : "light field",
                         .sensor = sensor_defaults(MCV_SENSOR_LIGHT_FIELD)};
        mcv_light_field_params *p = &c.sensor.as.light_field;
        p->focalLength = 0.05;
        p->imageDistance = 0.06;
        p->lensDiameter = 0.02;
        p->spatialResolution[0] = 160;
        p->spatialResolution[1] = 120;
        p->angularResolution[0] = 9;
        p->angularResolution[1] = 7;
        p->pixelSize[0] = p->pixelSize[1] = 4e-6;
        p->radiometry = MCV_RADIOMETRY_IRRADIANCE;
        p->aperture = circle ? MCV_APERTURE_CIRCLE : MCV_APERTURE_SQUARE;
        c.aperture = 0.01;
        c.kappa = 1 / 0.05 - 1 / 0.06;
        c.direct = 720 * 4e-6 / 0.06;
        c.aperture_slope = c.kappa * 0.01;
        check_sensor(&c);
    }
}

/*
 * What light paths need of a sensor: the place on the film that a camera ray comes from; W =
 * weight/(A Ω) of it, A the lens's area as seen from a depth z and Ω a pixel's solid angle in
 * tangents; a pixel's footprint Ω z². The places are found to 2^-20 of the width; the others take
 * below 16 roundings. Of a light field camera the place is a pixel's middle; what lies within
 * rounding of its edge is left out.
 */
static void check_inverse(const mcv_sensor *values, double lens_area, bool grows,
                          const double pixel[2], double slope) {
    enum { COUNT = 1 << 14 };
    mcv_scene *scene = mcv_scene_new("sensor");
    add_sensor(scene, values->type, values, mcv_transform_identity());
    const mcv_sensor *sensor = &scene->sensors[0];
    const bool whole = values->type == MCV_SENSOR_LIGHT_FIELD;
    uint32_t width, height, *cases = malloc(7 * sizeof(uint32_t) * COUNT);
    float *results = malloc(6 * sizeof(float) * COUNT);
    double worst = 0;
    size_t seen = 0;
    assert_non_null(cases);
    assert_non_null(results);
    mcv_sensor_film_size(sensor, &width, &height);
    random_numbers.state = 1;
    for (size_t i = 0; i < COUNT; ++i) {
        cases[7 * i] = (uint32_t)uniform(0, width);
        cases[7 * i + 1] = (uint32_t)uniform(0, height);
        for (int k = 2; k < 6; ++k) cases[7 * i + k] = as_uint(random_float());
        cases[7 * i + 6] = as_uint((float)uniform(0.1, 1));
    }
    run_sensor("invert_sensor", sensor, COUNT, cases, 7 * sizeof(uint32_t), results,
               6 * sizeof(float));
    for (size_t i = 0; i < COUNT; ++i) {
        const uint32_t *in = cases + 7 * i;
        const float *out = results + 6 * i;
        const double x = as_float(in[2]), y = as_float(in[3]), z = as_float(in[6]), weight = out[5];
        const double area = lens_area * (grows ? z * z : 1),
                     footprint = pixel[0] * pixel[1] * slope * slope * (grows ? 1 : z * z);
        worst = fmax(worst, fmax(fabs(out[3] / area - 1), fabs(out[4] / footprint - 1)));
        if ((out[2] > 0) != (weight > 0) || fmin(fmin(x, 1 - x), fmin(y, 1 - y)) < 1e-4) continue;
        ++seen;
        if (!(weight > 0)) continue;
        worst = fmax(worst, fabs(out[2] * area / (z * z) * footprint / weight - 1));
        const double column = in[0] + (whole ? 0.5 : x), row = in[1] + (whole ? 0.5 : y);
        if (!(fabs(out[0] - column) <= width * 0x1p-20 && fabs(out[1] - row) <= width * 0x1p-20))
            fail_msg("sensor type %u: (%.9g, %.9g) comes back as (%.9g, %.9g)", values->type,
                     column, row, (double)out[0], (double)out[1]);
    }
    print_message("area, footprint and W: off by %.2g of %.2g; %zu of %d cases\n", worst, 16 * u,
                  seen, COUNT);
    assert_true(worst <= 16 * u);
    assert_true(seen >= 0.99 * COUNT); /* the others lie at a rim, or near a pixel's edge */
    free(cases);
    free(results);
    mcv_scene_free(scene);
}

static void test_inverse_of_pinhole(void **state) {
    mcv_sensor sensor = sensor_defaults(MCV_SENSOR_PINHOLE);
    mcv_pinhole_params *p = &sensor.as.pinhole;
    (void)state;
    p->imageDistance = 0.016;
    SET_FILM(p, 120, 80, 5e-5, 4e-5);
    check_inverse(&sensor, 1, false, p->pixelSize, 1 / 0.016);
}

static void test_inverse_of_thin_lens(void **state) {
    mcv_sensor sensor = sensor_defaults(MCV_SENSOR_THIN_LENS);
    mcv_thin_lens_params *p = &sensor.as.thin_lens;
    (void)state;
    p->focalLength = 0.025;
    p->imageDistance = 0.03;
    p->lensDiameter = 0.006;
    SET_FILM(p, 120, 80, 5e-5, 4e-5);
    p->radiometry = MCV_RADIOMETRY_IRRADIANCE;
    check_inverse(&sensor, M_PI * 0.003 * 0.003, false, p->pixelSize, 1 / 0.03);
}

static void test_inverse_of_telecentric(void **state) {
    mcv_sensor sensor = sensor_defaults(MCV_SENSOR_TELECENTRIC);
    mcv_telecentric_params *p = &sensor.as.telecentric;
    (void)state;
    p->focalLength = 0.022;
    p->imageDistance = 0.0275;
    p->stopDiameter = 0.004;
    SET_FILM(p, 120, 80, 5e-5, 4e-5);
    p->radiometry = MCV_RADIOMETRY_IRRADIANCE;
    check_inverse(&sensor, M_PI * pow(0.002 / 0.022, 2), true, p->pixelSize,
                  0.022 / (0.0275 - 0.022));
}

static void test_inverse_of_light_field(void **state) {
    mcv_sensor sensor = sensor_defaults(MCV_SENSOR_LIGHT_FIELD);
    mcv_light_field_params *p = &sensor.as.light_field;
    (void)state;
    p->focalLength = 0.05;
    p->imageDistance = 0.06;
    p->lensDiameter = 0.02;
    p->spatialResolution[0] = 20, p->spatialResolution[1] = 16;
    p->angularResolution[0] = 5, p->angularResolution[1] = 4;
    p->pixelSize[0] = 5e-5, p->pixelSize[1] = 4e-5;
    p->radiometry = MCV_RADIOMETRY_IRRADIANCE;
    check_inverse(&sensor, 0.02 * 0.02, false, p->pixelSize, 1 / 0.06);
}

/* Emitters */

/*
 * The cone's edge is decided within the rounding of its own frame: |q_d x q_n|² and tan²β c² round
 * to a few u, so a case whose tan²θ/tan²β lies within 16 u + 4 u/tanβ of 1 may fall on either side
 * (unit float vectors turn by up to 2 u rad against each other); all others must agree with the
 * reference.
 */
static void test_parallel(void **state) {
    static const double half_angles[] = {1e-5, 1e-4, 0.5 * M_PI / 180, 0.1, 1.0, 1.5, M_PI / 2};
    float *cases = malloc(6 * sizeof(float) * CASES);
    float *shares = malloc(sizeof(float) * CASES);
    (void)state;
    assert_non_null(cases);
    assert_non_null(shares);
    for (size_t h = 0; h < sizeof half_angles / sizeof half_angles[0]; ++h) {
        const double beta = half_angles[h];
        mcv_parallel device = {.tangent_squared = (float)pow(tan(beta), 2)};
        random_numbers.state = h;
        for (size_t i = 0; i < CASES; ++i) {
            const ref_vec n = random_direction();
            const ref_vec side = ref_unit(ref_cross(n, random_direction()));
            /* Half of the cases about the edge, half anywhere up to twice the angle; some behind.
             */
            const double theta =
                i % 2 ? fmin(beta * uniform(0.99, 1.01), M_PI) : uniform(0, fmin(2 * beta, M_PI));
            const ref_vec d = ref_add(ref_scale(cos(theta), n), ref_scale(sin(theta), side));
            const double values[6] = {d.x, d.y, d.z, n.x, n.y, n.z};
            for (int k = 0; k < 6; ++k) cases[6 * i + k] = (float)values[k];
        }
        run("evaluate_parallel", MCV_SENSOR_PINHOLE, &device, sizeof device, cases,
            6 * sizeof(float) * CASES, shares, sizeof(float) * CASES);
        size_t at_edge = 0;
        size_t lit = 0;
        for (size_t i = 0; i < CASES; ++i) {
            const float *in = cases + 6 * i;
            const ref_vec d = ref_unit((ref_vec){in[0], in[1], in[2]});
            const ref_vec n = ref_unit((ref_vec){in[3], in[4], in[5]});
            const ref_vec s = ref_cross(d, n);
            const double theta = atan2(ref_length(s), ref_dot(d, n));
            /* β = 90° takes the whole front: its edge is c = 0. */
            const bool expected = theta <= beta && theta < M_PI / 2;
            lit += shares[i] > 0;
            if (expected == (shares[i] == 1.0f) && (shares[i] == 0.0f || shares[i] == 1.0f))
                continue;
            ++at_edge;
            const double off =
                beta < 1.57 ? fabs(pow(tan(theta) / tan(beta), 2) - 1) * fabs(sin(beta) * cos(beta))
                            : fabs(theta - M_PI / 2);
            if (off > 16 * u)
                fail_msg("half-angle %g: case %zu at %.9g rad is %g off the edge and got %g", beta,
                         i, theta, off, (double)shares[i]);
        }
        print_message("parallel, %g rad: %zu of %d lit, %zu at the edge decided the other way\n",
                      beta, lit, CASES, at_edge);
        assert_true(lit > CASES / 5 && lit < CASES);
    }
    free(cases);
    free(shares);
}

/* T21 in the cone's own frame: the polar angle of the same ξ, η in double; sinθ within 12 u
 * relative, the azimuth as a disk point. */
static void test_cone_samples(void **state) {
    static const double half_angles[] = {1e-7, 1e-5, 1e-3, 0.1, 1.0, M_PI / 2};
    float *cases = malloc(3 * sizeof(float) * CASES);
    float *directions = malloc(3 * sizeof(float) * CASES);
    (void)state;
    assert_non_null(cases);
    assert_non_null(directions);
    for (size_t h = 0; h < sizeof half_angles / sizeof half_angles[0]; ++h) {
        random_numbers.state = h;
        for (size_t i = 0; i < CASES; ++i) {
            cases[3 * i] = random_float();
            cases[3 * i + 1] = random_float();
            cases[3 * i + 2] = (float)sin(half_angles[h] / 2);
        }
        run("sample_cones", MCV_SENSOR_PINHOLE, NULL, 0, cases, 3 * sizeof(float) * CASES,
            directions, 3 * sizeof(float) * CASES);
        double worst = 0;
        double worst_z = 0;
        for (size_t i = 0; i < CASES; ++i) {
            double radius;
            double angle;
            concentric(cases[3 * i], cases[3 * i + 1], &radius, &angle);
            const double theta = 2 * asin(radius * cases[3 * i + 2]);
            const double x = sin(theta) * cos(angle) - directions[3 * i];
            const double y = sin(theta) * sin(angle) - directions[3 * i + 1];
            const double z = cos(theta) - directions[3 * i + 2];
            worst = fmax(worst, hypot(x, y) / sin(fmin(half_angles[h], M_PI / 2)));
            worst_z = fmax(worst_z, fabs(z));
        }
        /*
         * s = sin(β/2) √ξ errs by 8 u of the largest as a disk point and rounded product; sinθ = 2
         * s √(1 - s²) by 12 u of the largest sine, cosθ = 1 - 2 s² by 4 s x 8 u s and its own
         * rounding.
         */
        const double s_max = sin(half_angles[h] / 2);
        print_message("cone of %g rad: sine within %.2f u of its largest, cosine within %.2f u\n",
                      half_angles[h], worst / u, worst_z / u);
        char what[64];
        snprintf(what, sizeof what, "T21 cone of %g rad: sine of its largest", half_angles[h]);
        note_truth(what, "device", worst, 12 * u);
        assert_true(worst <= 12 * u);
        assert_true(worst_z <= (1 + 32 * s_max * s_max) * u);
    }
    free(cases);
    free(directions);
}

/* Interfaces */

/*
 * accuracy.md 0b: direction within 4 u (1 + η tanθ_t) rad, R within 20 ulp for n1 < n2 and 16 ulp
 * (1 + |δ|/(c2 (c1 + c2))) for n1 > n2, against double of the same c1, η, δ. The inputs of the
 * reference are the device's rounded ones.
 */
static void test_refraction(void **state) {
    float *cases = malloc(8 * sizeof(float) * CASES);
    float *results = malloc(5 * sizeof(float) * CASES);
    double worst_angle = 0;
    double worst_fresnel = 0;
    size_t total = 0;
    enum { BINS = 33 }; /* the last holds what is larger */
    int histograms[2][BINS] = {{0}};
    (void)state;
    assert_non_null(cases);
    assert_non_null(results);
    random_numbers.state = 5;
    for (size_t i = 0; i < CASES; ++i) {
        const double step = pow(10, uniform(-7, 0.3));
        const double n1 = i % 2 ? 1 + step : 1;
        const double n2 = i % 2 ? 1 : 1 + step;
        const ref_vec n = random_direction();
        const ref_vec side = ref_unit(ref_cross(n, random_direction()));
        /* Angles everywhere, and crowding at grazing incidence. */
        const double theta = i % 3 ? uniform(0, M_PI / 2) : M_PI / 2 - pow(10, uniform(-6, -1));
        const ref_vec d = ref_add(ref_scale(-cos(theta), n), ref_scale(sin(theta), side));
        const double values[8] = {
            n1 / n2, (n2 - n1) * (n2 + n1) / (n2 * n2), d.x, d.y, d.z, n.x, n.y, n.z};
        for (int k = 0; k < 8; ++k) cases[8 * i + k] = (float)values[k];
    }
    run("refract_directions", MCV_SENSOR_PINHOLE, NULL, 0, cases, 8 * sizeof(float) * CASES,
        results, 5 * sizeof(float) * CASES);
    for (size_t i = 0; i < CASES; ++i) {
        const float *in = cases + 8 * i;
        const float *out = results + 5 * i;
        const ref_vec d = {in[2], in[3], in[4]};
        const ref_vec n = {in[5], in[6], in[7]};
        const double eta = in[0];
        const double delta = in[1];
        /* The device's cosine is the rounded dot product. */
        const double c1 = fmin((double)fmaf(-in[2], in[5], -fmaf(in[3], in[6], in[4] * in[7])), 1);
        if (!(c1 > 0)) continue;
        const double squared = c1 * c1 + (1 - c1 * c1) * delta;
        /* c2² rounds by u (c1² + |δ| s1² + their sum): nearer to the critical angle either answer
         * is right. */
        if (fabs(squared) <= 3 * u * (c1 * c1 + fabs(delta))) continue;
        if (squared < 0) {
            ++total;
            assert_true(out[0] == 1.0f && out[1] == 0.0f);
            continue;
        }
        const double c2 = sqrt(squared);
        const double sum = eta * c1 + c2;
        const double perpendicular = pow(delta / (sum * sum), 2);
        const double product = eta * (1 - c1 * c1);
        const double reflectance =
            0.5 * perpendicular * (1 + pow((c1 * c2 - product) / (c1 * c2 + product), 2));
        const double ulp = delta > 0 ? 20 : 16 * (1 + fabs(delta) / (c2 * (c1 + c2)));
        const double ulps = fabs(out[0] - reflectance) / (0.5 * perpendicular * 2 * u);
        ++histograms[0][(int)fmin(ulps, BINS - 1)];
        worst_fresnel = fmax(worst_fresnel, ulps / ulp);
        if (delta == 0) continue;

        const ref_vec t = ref_unit(ref_add(ref_scale(eta, d), ref_scale(-delta / sum, n)));
        const ref_vec got = {out[2], out[3], out[4]};
        const double angle = ref_length(ref_sub(got, t));
        const double tangent = sqrt(fmax(0, 1 - c2 * c2)) / c2;
        ++histograms[1][(int)fmin(angle / (2 * u), BINS - 1)];
        worst_angle = fmax(worst_angle, angle / (4 * u * (1 + eta * tangent)));
    }
    print_message("refraction: direction error at most %.2f of its bound, Fresnel %.2f of its "
                  "bound, %zu total reflections\n",
                  worst_angle, worst_fresnel, total);
    note_truth("T12 Fresnel's R of any index step and angle [20 ulp]", "device", worst_fresnel, 1);
    note_truth("T12 refracted direction of any index step and angle [4 u (1 + n tan t)]", "device",
               worst_angle, 1);
    for (int i = 0; i < BINS; ++i) {
        note_point("ULP of a refraction", "Fresnel's R", i, histograms[0][i]);
        note_point("ULP of a refraction", "direction", i, histograms[1][i]);
    }
    assert_true(total > CASES / 20);
    assert_true(worst_fresnel <= 1);
    assert_true(worst_angle <= 1);
    free(cases);
    free(results);
}

/* mcv_exp_minus promises 3e-7 = 5 u; the reduced argument is rounded twice by u |x| at most:
 * exp(-x) moves by as much. */
static void test_attenuation(void **state) {
    float *x = malloc(sizeof(float) * CASES);
    float *y = malloc(sizeof(float) * CASES);
    double worst = 0;
    (void)state;
    assert_non_null(x);
    assert_non_null(y);
    random_numbers.state = 3;
    for (size_t i = 0; i < CASES; ++i)
        x[i] = (float)(i % 2 ? uniform(0, 90) : pow(10, uniform(-8, 1)));
    run("attenuate", MCV_SENSOR_PINHOLE, NULL, 0, x, sizeof(float) * CASES, y,
        sizeof(float) * CASES);
    for (size_t i = 0; i < CASES; ++i) {
        if (x[i] >= 87)
            assert_true(y[i] == 0);
        else
            worst = fmax(worst, fabs(y[i] / exp(-(double)x[i]) - 1));
    }
    print_message("exp(-x): worst relative error %.2g of 3e-7\n", worst);
    assert_true(worst <= 3e-7);
    free(x);
    free(y);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_pinhole),
        cmocka_unit_test(test_thin_lens),
        cmocka_unit_test(test_telecentric),
        cmocka_unit_test(test_light_field),
        cmocka_unit_test(test_parallel),
        cmocka_unit_test(test_cone_samples),
        cmocka_unit_test(test_refraction),
        cmocka_unit_test(test_attenuation),
        cmocka_unit_test(test_inverse_of_pinhole),
        cmocka_unit_test(test_inverse_of_thin_lens),
        cmocka_unit_test(test_inverse_of_telecentric),
        cmocka_unit_test(test_inverse_of_light_field),
    };
    element_features = MCV_FEATURE_BIT(LIGHT_TRACING);
    return cmocka_run_group_tests(tests, open_device, close_device);
}
