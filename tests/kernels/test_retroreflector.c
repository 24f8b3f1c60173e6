/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Retroreflectors on the device: against the reference renderer's, against themselves with the
 * directions exchanged, their energy, and both renderers' choice of directions against its density.
 * The surface's normal is z.
 */
#include "elements.h"
#include "estimates.h"

#include "reference/retroreflector.h"

enum { CASES = 1 << 14 };

#define GREY(x) \
    { (x), (x), (x) }
#define DEGREES(x) ((x)*M_PI / 180)

static const struct {
    const char *name;
    mcv_retroreflector_params params;
} subjects[] = {
    {"prisms", {GREY(0.7), DEGREES(30), DEGREES(0.2), GREY(0.05), 0}},
    {"beads", {GREY(0.4), DEGREES(45), DEGREES(1.5), GREY(0.3), 0}},
    {"at all angles", {GREY(1), DEGREES(90), DEGREES(0.5), GREY(0), 0}},
    {"blurred", {GREY(0.5), DEGREES(60), DEGREES(40), GREY(0.5), 0}},
    {"narrowest", {GREY(0.9), DEGREES(20), 1e-6, GREY(0.1), 0}},
};
enum { SUBJECTS = sizeof subjects / sizeof subjects[0] };

static mcv_device_material pack(const mcv_retroreflector_params *params) {
    mcv_packed packed;
    mcv_scene *scene = mcv_scene_new("retroreflector");
    const uint32_t number = add_material(scene, MCV_MATERIAL_RETROREFLECTOR,
                                         &(mcv_material){.as.retroreflector = *params});
    add_box(scene, (const double[]){1, 1, 1}, number, mcv_transform_identity());
    BUILD(mcv_pack(scene, NULL, &packed, &builder_error));
    const mcv_device_material material = packed.materials[0];
    mcv_packed_free(&packed);
    mcv_scene_free(scene);
    return material;
}

static void on_device(const mcv_device_material *material, const char *kernel, const float *cases,
                      size_t outputs, float *results) {
    run_elements(kernel, MCV_SENSOR_PINHOLE, material, sizeof *material, CASES, cases,
                 6 * sizeof(float) * CASES, results, outputs * sizeof(float) * CASES);
}

/* Of s²(θ) = 1/(1 + x²), x = q tan²θ: 1 - cos²θ is off by 2 u, so that x is by q 2 u/cos²θ and 6 u
 * of itself. */
static double efficiency_error(const mcv_retroreflector_params *p, ref_vec w) {
    const double q = pow(tan(p->entranceAngle), -2), x = q * (w.x * w.x + w.y * w.y) / (w.z * w.z);
    return 2 * x / (1 + x * x) * 0x1p-24 * (2 * q / (w.z * w.z) + 6 * x);
}

/*
 * f cosθ and density, device against reference, over uniform directions and over those chosen. u =
 * 2^-24: the cross product's components are good to 2 u, its square to 6 u, the unit vectors to 4 u
 * each, 20 other operations; the cosine of δ is off by 3 u, which counts where it is small: 4 u a²
 * of the lobe.
 */
static void test_reference(void **state) {
    const double u = 0x1p-24;
    float *cases = floats(6 * CASES), *results = floats(4 * CASES);
    (void)state;
    for (int k = 0; k < SUBJECTS; ++k) {
        const mcv_retroreflector_params *p = &subjects[k].params;
        const mcv_device_material material = pack(p);
        ref_random random = {(uint64_t)k};
        double worst = 0;
        for (size_t n = 0; n < CASES; ++n) {
            const ref_vec o = put(cases + 6 * n, direction(&random, 1e-3, 1));
            ref_vec i =
                n % 2 ? ref_retroreflector_sample(p, o, &random) : direction(&random, 1e-3, 1);
            if (i.z < 1e-3) i = direction(&random, 1e-3, 1);
            put(cases + 6 * n + 3, i);
        }
        on_device(&material, "evaluate_retroreflector", cases, 4, results);
        for (size_t n = 0; n < CASES; ++n) {
            const float *c = cases + 6 * n, *r = results + 4 * n;
            const ref_vec o = {c[0], c[1], c[2]}, i = {c[3], c[4], c[5]};
            double value[3];
            const double density = ref_retroreflector_evaluate(p, o, i, value),
                         expected[2] = {value[0], density};
            const double error = 40 * u + efficiency_error(p, o) + efficiency_error(p, i),
                         rest = 4 * u * material.as.retroreflector.spread *
                                material.as.retroreflector.spread;
            for (int what = 0; what < 2; ++what) {
                const double off = fabs(r[what] - expected[what]),
                             bound = error * expected[what] + rest;
                worst = fmax(worst, off / bound);
                if (!(off <= bound))
                    fail_msg(
                        "%s, %s of o (%g %g %g), i (%g %g %g): %.8g, expected %.8g within %.2g",
                        subjects[k].name, what ? "density" : "value", o.x, o.y, o.z, i.x, i.y, i.z,
                        r[what], expected[what], bound);
            }
            const double efficiency = ref_retroreflector_efficiency(p, o),
                         chance = ref_retroreflector_chance(p, o);
            if (!(fabs(r[2] - efficiency) <= error * efficiency) ||
                !(fabs(r[3] - chance) <= error * chance))
                fail_msg(
                    "%s, o (%g %g %g): efficiency %.8g, expected %.8g; chance %.8g, expected %.8g",
                    subjects[k].name, o.x, o.y, o.z, r[2], efficiency, r[3], chance);
        }
        print_message("%s: at most %.2f of the bound\n", subjects[k].name, worst);
    }
    free(cases);
    free(results);
}

/* f(o, i) = f(i, o), of the same operations but for the order of a sum or two: 20 u. */
static void test_reciprocity(void **state) {
    float *cases = floats(6 * CASES), *there = floats(4 * CASES), *back = floats(4 * CASES);
    (void)state;
    for (int k = 0; k < SUBJECTS; ++k) {
        const mcv_device_material material = pack(&subjects[k].params);
        ref_random random = {(uint64_t)k + 100};
        for (size_t n = 0; n < CASES; ++n) {
            const ref_vec o = put(cases + 6 * n, direction(&random, 0.01, 1));
            ref_vec i = n % 2 ? ref_retroreflector_sample(&subjects[k].params, o, &random)
                              : direction(&random, 0.01, 1);
            if (i.z < 0.01) i = direction(&random, 0.01, 1);
            put(cases + 6 * n + 3, i);
        }
        on_device(&material, "evaluate_retroreflector", cases, 4, there);
        for (size_t n = 0; n < CASES; ++n)
            for (int axis = 0; axis < 3; ++axis) {
                float *c = cases + 6 * n + axis;
                const float swap = c[0];
                c[0] = c[3];
                c[3] = swap;
            }
        on_device(&material, "evaluate_retroreflector", cases, 4, back);
        for (size_t n = 0; n < CASES; ++n) {
            const double forth = there[4 * n] / cases[6 * n + 2],
                         other = back[4 * n] / cases[6 * n + 5];
            if (!(fabs(forth - other) <= 20 * 0x1p-24 * forth))
                fail_msg("%s: case %zu: %.8g there, %.8g back", subjects[k].name, n, forth, other);
        }
    }
    free(cases);
    free(there);
    free(back);
}

/*
 * The albedo, the mean of f cosθ/density over stratified choices, is at most the sum of the shares.
 * Where the lobe is narrow it is R s²(θ) + D: over the lobe cosθ_i/max(…) falls short of 1 by a
 * tanθ times the mean of |tanδ cosφ|/2a = 1/2, and s(θ_i) by its slope, below 4/sin 2θ, times as
 * much: 5 a (1 + tanθ)/sin 2θ bounds both. The weights are at most 1: their mean over 2^14 choices
 * is off by less than 5/2 2^-7.
 */
static void test_energy(void **state) {
    static const double cosines[] = {0.1, 0.3, 0.7, 0.95};
    float *cases = floats(6 * CASES), *directions = floats(3 * CASES), *results = floats(4 * CASES);
    (void)state;
    for (int k = 0; k < SUBJECTS; ++k) {
        const mcv_retroreflector_params *p = &subjects[k].params;
        const mcv_device_material material = pack(p);
        ref_random random = {(uint64_t)k + 200};
        for (size_t angle = 0; angle < sizeof cosines / sizeof cosines[0]; ++angle) {
            const double z = cosines[angle], sine = sqrt(1 - z * z), phi = 0.7 * (double)angle;
            const ref_vec o = {sine * cos(phi), sine * sin(phi), z};
            double sum = 0;
            for (size_t n = 0; n < CASES; ++n) {
                put(cases + 6 * n, o);
                cases[6 * n + 3] =
                    (float)(((double)(n % 128) + ref_random_unit(&random) * 0.999) / 128);
                cases[6 * n + 4] =
                    (float)(((double)(n / 128) + ref_random_unit(&random) * 0.999) / (CASES / 128));
                cases[6 * n + 5] = (float)(ref_random_unit(&random) * 0.9999999);
            }
            on_device(&material, "sample_retroreflector", cases, 3, directions);
            for (size_t n = 0; n < CASES; ++n)
                memcpy(cases + 6 * n + 3, directions + 3 * n, 3 * sizeof(float));
            on_device(&material, "evaluate_retroreflector", cases, 4, results);
            for (size_t n = 0; n < CASES; ++n)
                if (results[4 * n + 1] > 0) sum += results[4 * n] / results[4 * n + 1] / CASES;
            const double whole =
                p->reflectance[0] * ref_retroreflector_efficiency(p, o) + p->diffuseReflectance[0];
            const double noise = 2.5 / 128, less = 5 * material.as.retroreflector.spread *
                                                   (1 + sine / z) / (2 * sine * z);
            print_message("%s, cosine %g: albedo %.5f of at most %.5f\n", subjects[k].name, z, sum,
                          whole);
            if (!(sum <= p->reflectance[0] + p->diffuseReflectance[0] + 1e-5) ||
                !(fabs(sum - whole) <= noise + less))
                fail_msg("%s, cosine %g: albedo %.5f, expected %.5f - %.2g", subjects[k].name, z,
                         sum, whole, less);
        }
    }
    free(cases);
    free(directions);
    free(results);
}

/*
 * Pearson's χ² of directions, of device and reference, in 16 x 16 bins of the azimuth about o and
 * of w = (2 δ/π)^(1/8), which has room for the narrowest lobe and the widest, and in one for what
 * lies behind o's plane or below the surface; against the density that goes with them, integrated
 * by 16 x 16 points a bin.
 */
static void test_choices(void **state) {
    enum {
        ROWS = 16,
        COLUMNS = 16,
        BINS = ROWS * COLUMNS + 1,
        POINTS = 16,
        ROUNDS = 16,
        BATCH = CASES / (POINTS * POINTS)
    };
    float *cases = floats(6 * CASES), *directions = floats(3 * CASES), *results = floats(4 * CASES);
    (void)state;
    for (int k = 0; k < SUBJECTS; ++k) {
        const mcv_retroreflector_params *p = &subjects[k].params;
        const mcv_device_material material = pack(p);
        ref_random random = {(uint64_t)k + 300};
        double counted[2][BINS] = {{0}}, expected[BINS] = {0}, all = 0;
        float rounded[3];
        ref_vec x, y;
        const ref_vec o = put(rounded, (ref_vec){0.6, 0.48, 0.64});
        ref_frame(ref_unit(o), &x, &y);
        for (int round = 0; round < ROUNDS; ++round) {
            for (size_t n = 0; n < CASES; ++n) {
                put(cases + 6 * n, o);
                for (int j = 3; j < 6; ++j)
                    cases[6 * n + (size_t)j] = (float)(ref_random_bits(&random) >> 40) * 0x1p-24F;
            }
            on_device(&material, "sample_retroreflector", cases, 3, directions);
            for (size_t n = 0; n < 2 * CASES; ++n) {
                const float *f = directions + 3 * (n / 2);
                const ref_vec d =
                    n % 2 ? ref_retroreflector_sample(p, o, &random) : (ref_vec){f[0], f[1], f[2]};
                const double w = pow(ref_angle(d, o) / M_PI_2, 1.0 / 8);
                const int row = (int)fmin(floor(w * ROWS), ROWS - 1);
                const int column = (int)fmin(
                    floor((atan2(ref_dot(d, y), ref_dot(d, x)) / (2 * M_PI) + 0.5) * COLUMNS),
                    COLUMNS - 1);
                ++counted[n % 2][w >= 1 || d.z <= 0 ? BINS - 1 : row * COLUMNS + column];
            }
        }
        for (int first = 0; first < BINS - 1; first += BATCH) {
            double solid[CASES];
            for (size_t n = 0; n < CASES; ++n) {
                const int bin = first + (int)(n / (POINTS * POINTS)),
                          point = (int)(n % (POINTS * POINTS));
                const double w = (bin / COLUMNS + (point / POINTS + 0.5) / POINTS) / ROWS,
                             off = M_PI_2 * pow(w, 8);
                const double phi =
                    2 * M_PI * ((bin % COLUMNS + (point % POINTS + 0.5) / POINTS) / COLUMNS - 0.5);
                put(cases + 6 * n, o);
                put(cases + 6 * n + 3,
                    ref_add(ref_scale(cos(off), o), ref_add(ref_scale(sin(off) * cos(phi), x),
                                                            ref_scale(sin(off) * sin(phi), y))));
                solid[n] = sin(off) * M_PI_2 * 8 * pow(w, 7) * 2 * M_PI /
                           (ROWS * COLUMNS * POINTS * POINTS);
            }
            on_device(&material, "evaluate_retroreflector", cases, 4, results);
            for (size_t n = 0; n < CASES; ++n)
                expected[first + (int)(n / (POINTS * POINTS))] +=
                    results[4 * n + 1] * solid[n] * ROUNDS * CASES;
        }
        for (int bin = 0; bin < BINS - 1; ++bin) all += expected[bin];
        expected[BINS - 1] = fmax((double)ROUNDS * CASES - all, 0);
        expect_choices(subjects[k].name, "device", counted[0], expected, 1, BINS);
        expect_choices(subjects[k].name, "reference", counted[1], expected, 1, BINS);
    }
    free(cases);
    free(directions);
    free(results);
}

static int open_retroreflector(void **state) {
    element_features = MCV_FEATURE_BIT(REFLECTOR);
    return open_device(state);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_reference), cmocka_unit_test(test_reciprocity),
        cmocka_unit_test(test_energy), cmocka_unit_test(test_choices)};
    return cmocka_run_group_tests(tests, open_retroreflector, close_device);
}
