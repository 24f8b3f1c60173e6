/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Rectangular lamps, which surfaces look for by solid angle: what a receiver sees of one and the
 * places that it chooses, against the same in double precision; which meshes are rectangles, and
 * where places on them lie; what a floor gets close by, and how much less it varies than by area. u
 * = 2^-24 is the relative error of one float32 operation.
 */
#include "estimates.h"

#include "mcvisi/rectangle.h"
#include "reference/random.h"
#include "device/pack.h"

static const double u = 0x1p-24, rho = 0.5;

static ref_random random_numbers;

static double uniform(double low, double high) {
    return low + (high - low) * ref_random_unit(&random_numbers);
}

static float random_float(void) {
    return (float)(ref_random_bits(&random_numbers) >> 40) * 0x1p-24f;
}

/* --- solid angles and places
 * ---------------------------------------------------------------------------------------- */

/* Seen from the origin, at the height z. */
typedef struct sides {
    double x0, x1, y0, y1, z;
} sides;

static double corner_angle(double x, double y, double z) {
    return atan2(x * y, z * sqrt(x * x + y * y + z * z));
}

static double solid_angle(const sides *r) {
    return corner_angle(r->x1, r->y1, r->z) - corner_angle(r->x0, r->y1, r->z) -
           corner_angle(r->x1, r->y0, r->z) + corner_angle(r->x0, r->y0, r->z);
}

/* The shares of the solid angle that a place has below it: of all, and of its line along y. */
static void shares_at(const sides *r, double x, double y, double shares[2]) {
    sides part = *r;
    const double d = hypot(x, r->z);
    part.x1 = x;
    shares[0] = solid_angle(&part) / solid_angle(r);
    shares[1] = (y / hypot(d, y) - r->y0 / hypot(d, r->y0)) /
                (r->y1 / hypot(d, r->y1) - r->y0 / hypot(d, r->y0));
}

/*
 * Lamps about as large as they are far away, thin bars, and a lamp a thousandth of its size away. A
 * solid angle is the difference of two angles with an error of 3 u each (a cosine or sine of two,
 * their product), found by an arc tangent within 4e-7. So is t, whose error is that of a share over
 * the solid angle; c = x/√(x² + z²) has 4 u, which is 4 u (1 + (x/z)²) of x, and of t, for dt/dx <=
 * 2 z/(x² + z²), up to 8 u √(1 + (x/z)²); and as much along y. On the average nothing is left of
 * errors of either sign, but 1e-6.
 */
static void test_solid_angles(void **state) {
    static const struct {
        const char *what;
        double width, height, off, z;
    } cases[] = {{"lamp", 1, 1, 1, 0.5},
                 {"bar", 0.01, 2, 0.2, 0.1},
                 {"lamp close by", 1, 1, 0.4, 1e-3},
                 {"small lamp", 1e-3, 2e-3, 1e-3, 1e-3}};
    enum { VIEWS = 200000 };
    (void)state;
    random_numbers.state = 1;
    for (size_t c = 0; c < sizeof cases / sizeof cases[0]; ++c) {
        double worst = 0, sum = 0, off = 0, mean[2] = {0, 0};
        size_t seen = 0;
        for (size_t i = 0; i < VIEWS; ++i) {
            mcv_rectangle r = {.width = (float)(cases[c].width * uniform(0.5, 1)),
                               .height = (float)(cases[c].height * uniform(0.5, 1))};
            const double around = cases[c].off;
            const float z = (float)(cases[c].z * uniform(0.5, 1.5));
            r.corner[0] = (float)uniform(-r.width - around, around);
            r.corner[1] = (float)uniform(-r.height - around, around);
            r.x[0] = r.y[1] = 1;
            const sides exact = {(double)r.corner[0], (double)r.corner[0] + (double)r.width,
                                 (double)r.corner[1], (double)r.corner[1] + (double)r.height,
                                 (double)z};
            const mcv_rectangle_view view =
                mcv_view_rectangle(&r, mcv_vec(0, 0, 1), mcv_vec(0, 0, z));
            const double angle = solid_angle(&exact);
            worst = fmax(worst, fabs((double)view.solid_angle - angle));
            if (!mcv_samples_solid_angle(view)) continue;
            float s, t;
            const float xi = random_float(), eta = random_float();
            double shares[2];
            mcv_sample_rectangle(&r, view, xi, eta, &s, &t);
            assert_true(s >= 0 && s <= 1 && t >= 0 && t <= 1);
            shares_at(&exact, exact.x0 + (double)s * (double)r.width,
                      exact.y0 + (double)t * (double)r.height, shares);
            sum += (double)view.solid_angle / angle - 1;
            mean[0] += shares[0] - (double)xi;
            mean[1] += shares[1] - (double)eta;
            const double reach =
                hypot(fmax(-exact.x0, exact.x1), fmax(-exact.y0, exact.y1)) / exact.z;
            const double tolerance = (4e-7 + 6 * u + 8 * u * hypot(1, reach)) / angle;
            off = fmax(off, fmax(fabs(shares[0] - (double)xi), fabs(shares[1] - (double)eta)) /
                                tolerance);
            ++seen;
        }
        for (int k = 0; k < 2; ++k) mean[k] /= (double)seen;
        sum /= (double)seen;
        print_message("%s: %zu views; solid angle within %.2g sr, on average off by %.1g of "
                      "itself; shares within %.2g of what they may, "
                      "on average off by "
                      "%.1g, %.1g\n",
                      cases[c].what, seen, worst, sum, off, mean[0], mean[1]);
        assert_true(seen > VIEWS / 20);
        if (!(worst <= 2 * 3 * u + 4e-7))
            fail_msg("%s: a solid angle is off by %g sr", cases[c].what, worst);
        if (!(fabs(sum) <= 1e-6))
            fail_msg("%s: solid angles are off by %g on the average", cases[c].what, sum);
        if (!(off <= 1))
            fail_msg("%s: a share is off by %g times what it may be", cases[c].what, off);
        if (!(fmax(fabs(mean[0]), fabs(mean[1])) <= 1e-6))
            fail_msg("%s: shares are off by %g and %g on the average", cases[c].what, mean[0],
                     mean[1]);
    }
}

/* --- meshes that are rectangles
 * -------------------------------------------------------------------------------------- */

static const mcv_transform askew = {{0.48, 0.64, -0.6, -0.8, 0.6, 0, 0.36, 0.48, 0.8, 0.3, -2, 1}};

/* A lamp of those triangles; its emitter as it is packed. */
static mcv_device_emitter pack_lamp(const float *positions, uint32_t vertices,
                                    const uint32_t *indices, uint32_t triangles,
                                    mcv_packed *packed) {
    mcv_scene *scene = mcv_scene_new("rectangle");
    const mcv_mesh mesh = {.vertex_count = vertices,
                           .triangle_count = triangles,
                           .positions = (float *)positions,
                           .indices = (uint32_t *)indices};
    add_rectangle(scene, 4, 4, add_diffuse(scene, rho), looking_up_z(0, 0, -5));
    add_emitter(scene, MCV_EMITTER_AREA, add_instance(scene, &mesh, add_absorber(scene), askew), 3,
                0);
    BUILD(mcv_pack(scene, NULL, packed, &builder_error));
    const mcv_device_emitter emitter = packed->emitters[0];
    mcv_scene_free(scene);
    return emitter;
}

/* Each of both triangles from each of its corners: places on the rectangle are where the triangles
 * have them, within roundings of 2 m. */
static void test_orders_of_corners(void **state) {
    static const float positions[] = {-0.3f, -0.1f, 0, 0.3f,  -0.1f, 0,
                                      0.3f,  0.1f,  0, -0.3f, 0.1f,  0};
    (void)state;
    for (uint32_t order = 0; order < 9; ++order) {
        static const uint32_t one[] = {0, 2, 1}, other[] = {0, 3, 2};
        uint32_t indices[6];
        mcv_packed packed;
        for (uint32_t c = 0; c < 3; ++c) {
            indices[c] = one[(c + order) % 3];
            indices[3 + c] = other[(c + order / 3) % 3];
        }
        const mcv_device_emitter e = pack_lamp(positions, 4, indices, 2, &packed);
        const mcv_rectangle *r = &e.rectangle;
        assert_true(packed.features >> MCV_FEATURE_RECTANGLE & 1);
        assert_true(fabs((double)r->width - 0.2) <= 4 * u &&
                    fabs((double)r->height - 0.6) <= 4 * u);
        for (int i = 0; i < 100; ++i) {
            /* Places with s > t lie on one triangle, those with s < t on the other, or with s + t
             * about 1. */
            const float s = random_float(), t = random_float();
            int within = 0;
            for (uint32_t k = 0; k < 2; ++k) {
                const float *a = r->to_triangle[k];
                const float at[2] = {a[0] + a[1] * s + a[2] * t, a[3] + a[4] * s + a[5] * t};
                const uint32_t *corners =
                    packed.triangles +
                    4 * ((size_t)packed.instances[e.instance].first_triangle + k);
                within += at[0] >= 0 && at[1] >= 0 && at[0] + at[1] <= 1;
                for (int axis = 0; axis < 3; ++axis) {
                    double p[3];
                    for (int c = 0; c < 3; ++c)
                        p[c] = (double)packed.positions[3 * (size_t)corners[c] + axis];
                    const double there =
                        p[0] + (double)at[0] * (p[1] - p[0]) + (double)at[1] * (p[2] - p[0]);
                    const double here = (double)r->corner[axis] +
                                        (double)s * (double)r->width * (double)r->x[axis] +
                                        (double)t * (double)r->height * (double)r->y[axis];
                    if (!(fabs(there - here) <= 8 * u * 2))
                        fail_msg("order %u: a place is off by %g m", order, there - here);
                }
            }
            assert_int_equal(within, 1);
        }
        mcv_packed_free(&packed);
    }
}

static void test_no_rectangles(void **state) {
    static const struct {
        const char *what;
        float positions[15];
        uint32_t vertices, triangles, indices[9];
    } cases[] = {
        {"trapezium", {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1.1f, 0}, 4, 2, {0, 1, 2, 0, 2, 3}},
        {"rhombus", {0, 0, 0, 1, 0, 0, 1.1f, 1, 0, 0.1f, 1, 0}, 4, 2, {0, 1, 2, 0, 2, 3}},
        {"folded", {0, 0, 0, 1, 0, 0, 1, 1, 0.01f, 0, 1, 0}, 4, 2, {0, 1, 2, 0, 2, 3}},
        {"twice the same triangle", {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0}, 4, 2, {0, 1, 2, 0, 1, 2}},
        {"facing both ways", {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0}, 4, 2, {0, 1, 2, 0, 3, 2}},
        {"triangle", {0, 0, 0, 1, 0, 0, 1, 1, 0}, 3, 1, {0, 1, 2}},
        {"three triangles",
         {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, 0, 0.5f, 0},
         5,
         3,
         {0, 1, 2, 0, 2, 4, 4, 2, 3}}};
    (void)state;
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        mcv_packed packed;
        const mcv_device_emitter e = pack_lamp(cases[i].positions, cases[i].vertices,
                                               cases[i].indices, cases[i].triangles, &packed);
        if (e.rectangle.width != 0 || packed.features >> MCV_FEATURE_RECTANGLE & 1)
            fail_msg("%s: taken for a rectangle", cases[i].what);
        mcv_packed_free(&packed);
    }
}

/* --- floors
 * ------------------------------------------------------------------------------------------------------------
 */

/* A lamp of 3 W/(m² sr) over a floor, seen in a spot about the origin by a pinhole in between. */
static mcv_scene *floor_scene(double width, double height, double x, double z, bool even) {
    mcv_scene *scene = mcv_scene_new("floor");
    const float half[2] = {(float)(width / 2), (float)(height / 2)};
    const float corners[] = {-half[0], -half[1], 0,       half[0], -half[1], 0, half[0], half[1],
                             0,        -half[0], half[1], 0,       0,        0, 0};
    const uint32_t two[] = {0, 2, 1, 0, 3, 2}, four[] = {0, 4, 1, 1, 4, 2, 2, 4, 3, 3, 4, 0};
    const mcv_mesh mesh = {.vertex_count = 5,
                           .triangle_count = even ? 2 : 4,
                           .positions = (float *)corners,
                           .indices = (uint32_t *)(even ? two : four)};
    mcv_transform above = {{1, 0, 0, 0, 1, 0, 0, 0, 1, x, 0, z}};
    add_rectangle(scene, 4, 4, add_diffuse(scene, rho), looking_up_z(0, 0, 0));
    add_emitter(scene, MCV_EMITTER_AREA, add_instance(scene, &mesh, add_absorber(scene), above), 3,
                0);
    add_pinhole(scene, 8, 0.02, looking_down_z(0, 0, z / 2));
    return scene;
}

static mcv_film render(const mcv_scene *scene, uint32_t sampler) {
    mcv_render_options options = mcv_render_defaults();
    mcv_render_stats stats;
    mcv_film film;
    options.replicates = REPLICATES;
    options.last = 256;
    options.sampler = sampler;
    BUILD(render_again(scene, 0, &options, &film, &stats, &builder_error));
    return film;
}

/* The corner's part of the form factor of a parallel rectangle, times 2π. */
static double corner_factor(double x, double y, double z) {
    return x / hypot(x, z) * atan(y / hypot(x, z)) + y / hypot(y, z) * atan(x / hypot(y, z));
}

/*
 * Lamps a thousand times as large as they are far away, as far as large, beside the spot, and thin:
 * E = L π F. The spot is a hundredth of the distance, over which F varies by less than its square.
 */
static void test_floors_close_by(void **state) {
    static const struct {
        double width, height, x, z;
    } cases[] = {
        {1, 1, 0.2, 1e-3}, {1, 1, 0, 1}, {1, 0.5, 1, 0.3}, {0.01, 1, 0.1, 0.1}, {0.1, 0.1, 0, 1}};
    (void)state;
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        const double z = cases[i].z, x1 = cases[i].x + cases[i].width / 2,
                     x0 = cases[i].x - cases[i].width / 2, y = cases[i].height / 2;
        const double factor = 2 * (corner_factor(x1, y, z) - corner_factor(x0, y, z)) / (2 * M_PI);
        char what[96];
        mcv_scene *scene = floor_scene(cases[i].width, cases[i].height, cases[i].x, z, true);
        mcv_film film = render(scene, MCV_SAMPLER_SOBOL);
        snprintf(what, sizeof what, "lamp of %g x %g m, %g m beside and %g m above", cases[i].width,
                 cases[i].height, cases[i].x, z);
        expect_estimate(what, image_estimate(&film), rho * 3 * factor, 0.002, 2e-4);
        mcv_film_free(&film);
        mcv_scene_free(scene);
    }
}

/* The variance of one sample, over its mean's square, of a floor under a lamp, from independent
 * samples. */
static double variance(double width, double height, double x, double z, bool even) {
    mcv_scene *scene = floor_scene(width, height, x, z, even);
    mcv_film film = render(scene, MCV_SAMPLER_RANDOM);
    const mcv_estimate m = image_estimate(&film);
    const double samples = (double)film.samples * film.replicates * film.width * film.height;
    mcv_film_free(&film);
    mcv_scene_free(scene);
    return m.variance / (m.mean * m.mean) * samples;
}

/*
 * A bar light of 1 m x 5 mm, 30 mm over the floor and 30 mm beside the spot. The floor looks for it
 * by the density 1/Ω, and brings cosθ; by area it brings cosθ cosθ'/d². What it finds by chance has
 * a share of at most (Ω/π)² of the weight, 0.02. The variances of both, by a sum over the lamp, are
 * in the ratio that the renders must show; these know each of theirs by √(2/15) = 0.37 of itself:
 * with a quarter of that ratio chance of one in a hundred thousand is let pass.
 */
static void test_variance_of_a_bar(void **state) {
    enum { STEPS = 2000 };
    const double width = 5e-3, height = 1, x = 0.03, z = 0.03;
    double by_area[2] = {0, 0}, by_angle[2] = {0, 0}, angle = 0;
    (void)state;
    for (int i = 0; i < 20; ++i) {
        for (int k = 0; k < STEPS; ++k) {
            const double dx = x + ((i + 0.5) / 20 - 0.5) * width,
                         dy = ((k + 0.5) / STEPS - 0.5) * height;
            const double cosine = z / sqrt(dx * dx + dy * dy + z * z),
                         part = cosine * cosine * cosine;
            for (int n = 0; n < 2; ++n) {
                by_area[n] += pow(part * cosine, n + 1);
                by_angle[n] += part * pow(cosine, n + 1);
            }
            angle += part;
        }
    }
    const double count = 20.0 * STEPS;
    const double expected = (by_area[1] * count / (by_area[0] * by_area[0]) - 1) /
                            (by_angle[1] * angle / (by_angle[0] * by_angle[0]) - 1);
    const double area = variance(width, height, x, z, false),
                 rectangle = variance(width, height, x, z, true);
    print_message(
        "bar: variance %.3g by area, %.3g by solid angle, ratio %.3g, of the lamp alone %.3g\n",
        area, rectangle, area / rectangle, expected);
    assert_true(expected > 8);
    if (!(area / rectangle >= expected / 4))
        fail_msg("bar: the variance falls by %g only, not by %g", area / rectangle, expected);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_solid_angles), cmocka_unit_test(test_orders_of_corners),
        cmocka_unit_test(test_no_rectangles), cmocka_unit_test(test_floors_close_by),
        cmocka_unit_test(test_variance_of_a_bar)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
