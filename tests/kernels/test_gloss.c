/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Surfaces of microfacets on the device: against the reference renderer's, against themselves with
 * the directions exchanged, and their energy and choice of directions against what they say of it.
 */
#include "gloss_bench.h"

/*
 * Bound of the relative error of the microfacet lobe in float32, u = 2^-24. The sum of o and i, of
 * length s, is off by 4 u, the unit normal h by e = 4 u/s + 4 u; D goes with the slope of h over α,
 * at most 4 e/α; the cosine o·h with e/(o·h); refraction divides by s² again and takes a root that
 * vanishes at total reflection, where its square c₂² is off by 4 u; 40 u for the other operations.
 */
static double lobe_error(const bench *b, ref_vec o, ref_vec i) {
    const double u = 0x1p-24;
    const bool bends = i.z < 0 && b->gloss.material->type == MCV_MATERIAL_DIELECTRIC;
    const double eta = b->element->eta;
    const ref_vec sum =
        bends ? ref_add(ref_scale(eta, o), i) : ref_add(o, (ref_vec){i.x, i.y, fabs(i.z)});
    const double s = ref_length(sum), e = 4 * u / s + 4 * u, c = fabs(ref_dot(o, sum)) / s,
                 behind = fabs(ref_dot(i, sum)) / s;
    const double c2 =
        b->gloss.material->type == MCV_MATERIAL_DIELECTRIC ? 1 - eta * eta * (1 - c * c) : 1;
    const double root = c2 > 0 ? 8 * u / c2 + 4 * e * c / c2 : 0;
    return 4 * e / b->alpha + 2 * e / c + (bends ? 4 * e / s + 2 * e / behind : 0) + root + 40 * u;
}

/* The largest entry of the device's table about a direction, and the least mean. */
static double largest_near(const bench *b, ref_vec w) {
    const mcv_device_glossy *m = &b->element->material;
    const float *rows = (const float *)(const void *)(b->element + 1) + b->element->table;
    const uint32_t size = 2 + 2 * m->azimuths * MCV_ALBEDO_COSINES;
    const uint32_t column = (uint32_t)(sqrt(fabs(w.z)) * (MCV_ALBEDO_COSINES - 1));
    double most = 0;
    for (uint32_t row = 0; row < m->azimuths * m->roughnesses; ++row)
        for (uint32_t k = 0; k < 2; ++k)
            most = fmax(most, rows[row / m->azimuths * size + 2 +
                                   2 * (row % m->azimuths * MCV_ALBEDO_COSINES + column) +
                                   k * (b->gloss.material->type == MCV_MATERIAL_DIELECTRIC)]);
    return most;
}

static double least_mean(const bench *b) {
    const float *means = (const float *)(const void *)(b->element + 1) + b->element->table;
    const uint32_t size = 2 + 2 * b->element->material.azimuths * MCV_ALBEDO_COSINES;
    if (b->gloss.material->type == MCV_MATERIAL_DIELECTRIC)
        return fmin((double)means[0], (double)means[1]);
    return means[(uint32_t)b->element->layer * size];
}

/*
 * f cosθ and density, device against reference, over uniform directions and over such as light
 * takes. The albedos of both are integrals by different quadratures, interpolated over different
 * grids; an entry is off by ε = 2e-3, most at grazing, or 4e-3 where it is interpolated between 17
 * azimuths too or has a kink at the critical angle. The cosine lobe m(o) m(i)/M is then off by ε
 * (m(o) + m(i))/M, and its chance by ε; that of glass's microfacets, (1 - m) (1 - w m) with w <= 1,
 * by 2 ε.
 */
static void test_reference(void **state) {
    float *cases = floats(6 * CASES), *results = floats(2 * CASES);
    (void)state;
    for (int k = 0; k < SUBJECTS; ++k) {
        const subject *s = &subjects[k];
        bench b = open_bench(s, s->inside, true);
        ref_random random = {(uint64_t)k};
        for (size_t n = 0; n < CASES; ++n) {
            const ref_vec o = put(cases + 6 * n, direction(&random, 1e-3, 1));
            ref_vec i = direction(&random, -1, 1);
            if (n % 2) i = ref_gloss_sample(&b.gloss, o, &random);
            put(cases + 6 * n + 3, i.z == 0 ? direction(&random, -1, 1) : i);
        }
        on_device(&b, "evaluate_gloss", cases, 2, results);
        double worst = 0;
        for (size_t n = 0; n < CASES; ++n) {
            const float *c = cases + 6 * n;
            const ref_vec o = {c[0], c[1], c[2]}, i = {c[3], c[4], c[5]};
            double value[3];
            const double density = ref_gloss_evaluate(&b.gloss, o, i, value),
                         expected[2] = {value[0], density};
            const double error = lobe_error(&b, o, i),
                         share = (largest_near(&b, o) + largest_near(&b, i)) / least_mean(&b);
            const bool glass = s->type == MCV_MATERIAL_DIELECTRIC;
            const double entry = glass || b.element->material.azimuths > 1 ? 4e-3 : 2e-3;
            const double spread = entry * fabs(i.z) / M_PI * (2 + share);
            for (int what = 0; what < 2; ++what) {
                const double off = fabs(results[2 * n + (size_t)what] - expected[what]);
                const double bound = error * expected[what] + spread +
                                     (glass ? 4 : 2) * entry * expected[what] * what;
                worst = fmax(worst, off / bound);
                if (!(off <= bound) && error < 0.1)
                    fail_msg(
                        "%s, %s of o (%g %g %g), i (%g %g %g): %.8g, expected %.8g within %.2g",
                        s->name, what ? "density" : "value", o.x, o.y, o.z, i.x, i.y, i.z,
                        results[2 * n + (size_t)what], expected[what], bound);
            }
        }
        print_message("%s: at most %.2f of the bound\n", s->name, worst);
        close_bench(&b);
    }
    free(cases);
    free(results);
}

/* f(o, i)/n_i² = f(i, o)/n_o²; of the L/n² that the device carries f cosθ_i/cosθ_i is the same both
 * ways, times n_i² of where light comes from: f(o, i) n_o² = f(i, o) n_i². */
static void test_reciprocity(void **state) {
    float *cases = floats(6 * CASES), *there = floats(2 * CASES), *back = floats(2 * CASES);
    (void)state;
    for (int k = 0; k < SUBJECTS; ++k) {
        const subject *s = &subjects[k];
        bench b = open_bench(s, s->inside, false);
        const bool glass = s->type == MCV_MATERIAL_DIELECTRIC;
        ref_random random = {(uint64_t)k + 100};
        double worst = 0;
        for (int far = 0; far < 2; ++far) {
            bench reverse = open_bench(s, glass && far ? !s->inside : s->inside, false);
            for (size_t n = 0; n < CASES; ++n) {
                put(cases + 6 * n, direction(&random, 0.01, 1));
                ref_vec i = direction(&random, 0.01, 1);
                if (far) i.z = -i.z;
                put(cases + 6 * n + 3, i);
            }
            on_device(&b, "evaluate_gloss", cases, 2, there);
            for (size_t n = 0; n < CASES; ++n) {
                float *c = cases + 6 * n;
                for (int axis = 0; axis < 3;
                     ++axis) { /* turned about so that the light's side is +z */
                    const float swap = c[axis];
                    c[axis] = far && axis == 2 ? -c[3 + axis] : c[3 + axis];
                    c[3 + axis] = far && axis == 2 ? -swap : swap;
                }
            }
            on_device(&reverse, "evaluate_gloss", cases, 2, back);
            const double ratio = glass && far ? b.element->eta * b.element->eta : 1; /* n_o²/n_i² */
            for (size_t n = 0; n < CASES; ++n) {
                const float *c = cases + 6 * n;
                const ref_vec i = {c[0], c[1], far ? -c[2] : c[2]},
                              o = {c[3], c[4], far ? -c[5] : c[5]};
                const double forth = there[2 * n] / fabs(i.z) * ratio,
                             other = back[2 * n] / fabs(o.z),
                             error = lobe_error(&b, o, i) + lobe_error(&reverse,
                                                                       (ref_vec){c[0], c[1], c[2]},
                                                                       (ref_vec){c[3], c[4], c[5]});
                if (error > 0.1) continue;
                worst = fmax(worst, fabs(forth - other) / (error * forth + 1e-6));
                if (!(fabs(forth - other) <= error * forth + 1e-6))
                    fail_msg("%s: f of o (%g %g %g), i (%g %g %g): %.8g there, %.8g back", s->name,
                             o.x, o.y, o.z, i.x, i.y, i.z, forth, other);
            }
            close_bench(&reverse);
        }
        print_message("%s: at most %.2f of the bound\n", s->name, worst);
        close_bench(&b);
    }
    free(cases);
    free(there);
    free(back);
}

/* The surface's albedo, 1 where nothing is lost: within 1 %, the goal (standard error
 * below 3.5e-3). */
static void test_furnace(void **state) {
    float *cases = floats(6 * CASES), *results = floats(2 * CASES);
    (void)state;
    for (int k = 0; k < SUBJECTS; ++k) {
        const subject *s = &subjects[k];
        bench b = open_bench(s, s->inside, false);
        ref_random random = {(uint64_t)k + 200};
        for (int angle = 0; angle < ANGLES; ++angle) {
            const double z = cosines[angle],
                         sum = albedo_of(&b, z, 0.7 * angle, &random, cases, results);
            print_message("%s, cosine %g: albedo %.5f\n", s->name, z, sum);
            if (s->lossless ? !(fabs(sum - 1) <= 0.01) : !(sum <= 1 && sum > 0.1))
                fail_msg("%s, cosine %g: albedo %.5f", s->name, z, sum);
        }
        close_bench(&b);
    }
    free(cases);
    free(results);
}

enum { ROWS = 16, COLUMNS = 32, BINS = ROWS * COLUMNS + 1 };

/* By cosine and azimuth; the last for a path that ends. */
static int bin_of(ref_vec d) {
    const int row = (int)fmin(floor((d.z + 1) / 2 * ROWS), ROWS - 1);
    const int column =
        (int)fmin(floor((atan2(d.y, d.x) / (2 * M_PI) + 0.5) * COLUMNS), COLUMNS - 1);
    return d.x == 0 && d.y == 0 && d.z == 0 ? BINS - 1 : row * COLUMNS + column;
}

/*
 * Pearson's χ² of 10^6 choices of the device and 65536 of the reference in 16 x 32 bins of cosine
 * and azimuth over the sphere, and one for paths that end, against the density that goes with them,
 * integrated by 32 x 32 points a bin.
 */
static void test_choices(void **state) {
    enum { POINTS = 32, ROUNDS = 16, BATCH = CASES / (POINTS * POINTS) };
    float *cases = floats(6 * CASES), *directions = floats(3 * CASES);
    (void)state;
    for (int k = 0; k < SUBJECTS; ++k) {
        const subject *s = &subjects[k];
        bench b = open_bench(s, s->inside, true);
        ref_random random = {(uint64_t)k + 300};
        double counted[2][BINS] = {{0}}, expected[BINS] = {0}, all = 0;
        float rounded[3];
        const ref_vec o = put(rounded, (ref_vec){0.6, 0.48, 0.64});
        for (int round = 0; round < ROUNDS; ++round) {
            for (size_t n = 0; n < CASES; ++n) {
                put(cases + 6 * n, o);
                for (int j = 3; j < 6; ++j)
                    cases[6 * n + (size_t)j] = (float)(ref_random_bits(&random) >> 40) * 0x1p-24F;
            }
            on_device(&b, "sample_gloss", cases, 3, directions);
            for (size_t n = 0; n < CASES; ++n) {
                const float *d = directions + 3 * n;
                ++counted[0][bin_of((ref_vec){d[0], d[1], d[2]})];
            }
        }
        for (size_t n = 0; n < CASES; ++n)
            ++counted[1][bin_of(ref_gloss_sample(&b.gloss, o, &random))];
        for (int first = 0; first < BINS - 1; first += BATCH) {
            for (size_t n = 0; n < CASES; ++n) {
                const int bin = first + (int)(n / (POINTS * POINTS)),
                          p = (int)(n % (POINTS * POINTS));
                const double z = 2 * (bin / COLUMNS + (p / POINTS + 0.5) / POINTS) / ROWS - 1,
                             sine = sqrt(1 - z * z);
                const double phi =
                    2 * M_PI * ((bin % COLUMNS + (p % POINTS + 0.5) / POINTS) / COLUMNS - 0.5);
                put(cases + 6 * n, o);
                put(cases + 6 * n + 3, (ref_vec){sine * cos(phi), sine * sin(phi), z});
            }
            on_device(&b, "evaluate_gloss", cases, 2, directions);
            for (size_t n = 0; n < CASES; ++n)
                expected[first + (int)(n / (POINTS * POINTS))] +=
                    directions[2 * n + 1] * 4 * M_PI / (ROWS * COLUMNS * POINTS * POINTS) * ROUNDS *
                    CASES;
        }
        for (int bin = 0; bin < BINS - 1; ++bin) all += expected[bin];
        expected[BINS - 1] = fmax((double)ROUNDS * CASES - all, 0);
        expect_choices(s->name, "device", counted[0], expected, 1, BINS);
        expect_choices(s->name, "reference", counted[1], expected, 1.0 / ROUNDS, BINS);
        close_bench(&b);
    }
    free(cases);
    free(directions);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_reference), cmocka_unit_test(test_reciprocity),
        cmocka_unit_test(test_furnace), cmocka_unit_test(test_choices)};
    return cmocka_run_group_tests(tests, open_gloss, close_gloss);
}
