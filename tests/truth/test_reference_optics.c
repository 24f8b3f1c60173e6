/* SPDX-License-Identifier: Apache-2.0 */
/* ctest: label truth */
/* The reference renderer's geometry and interfaces against closed forms. T numbers: the truths'
 * usual names in this project. */
#include "reference_checks.h"

#include <float.h>

#include "reference/interface.h"
#include "reference/random.h"
#include "scene/geometry.h"

/*
 * Rounding of traced coordinates of size <= 4: a path of this file takes fewer than 64 operations
 * per vertex, each off by DBL_EPSILON/2 at most; refraction away from grazing amplifies less than
 * tenfold.
 */
#define ROUNDING (64 * 4 * 10 * DBL_EPSILON / 2)

static void test_plate_shifts(void **state) { /* T1 */
    mcv_scene *scene = mcv_scene_new("plate");
    const double thickness = 0.25, n = 1.5;
    (void)state;
    add_box(scene, (const double[3]){8, 8, thickness / 2}, add_glass(scene, n, 0, 0),
            mcv_transform_identity());
    for (int degrees = 0; degrees <= 60; degrees += 15) {
        const double angle = degrees * M_PI / 180;
        const mcv_trace_ray ray = {{0.1, 0.05, -1},
                                   {sin(angle) * 0.6, sin(angle) * 0.8, cos(angle)}};
        size_t count;
        mcv_vertex *v = trace(scene, &ray, 1, 8, &count);
        assert_int_equal(count, 4); /* start, in, out, miss */
        assert_int_equal(v[3].event, MCV_EVENT_MISS);
        assert_true(v[1].ior == n && v[2].ior == 1);
        const ref_vec d = ref_from(ray.direction), out = ref_from(v[2].direction);
        const double shift =
            ref_length(ref_cross(ref_sub(ref_from(v[2].position), ref_from(ray.origin)), d));
        const double expected =
            thickness * sin(angle) * (1 - cos(angle) / sqrt(n * n - sin(angle) * sin(angle)));
        check("T1 plate: shift [m]", shift, expected, ROUNDING);
        check("T1 plate: change of direction", ref_length(ref_sub(out, d)), 0, ROUNDING);
        /* Two interfaces of the same reflectance. */
        double s, p;
        ref_fresnel(1, n, cos(angle), &s, &p);
        check("T1 plate: transmittance", v[2].transmittance, pow(1 - (s + p) / 2, 2), ROUNDING);
        free(v);
    }
    mcv_scene_free(scene);
}

static void test_prism_deviates(void **state) { /* T2 */
    /* The edges run along z; apex above. Coordinates that float32 holds exactly. */
    const double w = 0.5, h = 0.75, n = 1.5, apex = 2 * atan(w / h);
    float positions[] = {-0.5f, 0, 0, 0.5f, 0, 0, 0, 0.75f, 0,
                         -0.5f, 0, 1, 0.5f, 0, 1, 0, 0.75f, 1};
    uint32_t indices[] = {3, 4, 5, 0, 2, 1, 0, 1, 4, 0, 4, 3, 1, 2, 5, 1, 5, 4, 2, 0, 3, 2, 3, 5};
    mcv_scene *scene = mcv_scene_new("prism");
    (void)state;
    add_instance(
        scene,
        &(mcv_mesh){
            .vertex_count = 6, .triangle_count = 8, .positions = positions, .indices = indices},
        add_glass(scene, n, 0, 0), mcv_transform_identity());
    double least = INFINITY;
    for (int degrees = 56; degrees <= 80; degrees += 4) {
        const double angle = degrees * M_PI / 180, direction = angle - apex / 2;
        const mcv_trace_ray ray = {{-0.25 - 2 * cos(direction), 0.375 - 2 * sin(direction), 0.3},
                                   {cos(direction), sin(direction), 0}};
        size_t count;
        mcv_vertex *v = trace(scene, &ray, 1, 8, &count);
        assert_int_equal(count, 4);
        const double deviation = ref_angle(ref_from(ray.direction), ref_from(v[2].direction));
        const double expected =
            angle +
            asin(sin(apex) * sqrt(n * n - sin(angle) * sin(angle)) - cos(apex) * sin(angle)) - apex;
        check("T2 prism: deviation [rad]", deviation, expected, ROUNDING);
        least = fmin(least, deviation);
        free(v);
    }
    /* The minimum itself lies between the angles tried. */
    assert_true(least >= 2 * asin(n * sin(apex / 2)) - apex);
    mcv_scene_free(scene);
}

/* Where a ray at height h along the axis crosses it, from the sphere's centre: after one surface of
 * radius r, and after two. */
static double crossing_of_surface(double h, double n, double r) {
    return h / n / sin(asin(h / r) - asin(h / (n * r)));
}

static double crossing_of_ball(double h, double n, double r_in, double r_out) {
    return h / sin(asin(h / r_in) - asin(h / (n * r_in)) + asin(h / r_out) - asin(h / (n * r_out)));
}

/* The place where the line comes closest to the z axis. */
static double axis_crossing(const mcv_vertex *v) {
    const double *p = v->position, *d = v->direction;
    return p[2] - d[2] * (p[0] * d[0] + p[1] * d[1]) / (d[0] * d[0] + d[1] * d[1]);
}

/* The distances of a mesh's facets and vertices from the origin: a hit lies between them. */
static void find_radii(const mcv_scene *scene, double *least, double *most) {
    *least = INFINITY;
    *most = 0;
    for (uint32_t t = 0; t < scene->triangle_count; ++t) {
        double c[3][3];
        mcv_scene_corners(scene, 0, t, c);
        const ref_vec a = ref_from(c[0]), normal = ref_unit(ref_cross(ref_sub(ref_from(c[1]), a),
                                                                      ref_sub(ref_from(c[2]), a)));
        *least = fmin(*least, ref_dot(a, normal));
        for (int i = 0; i < 3; ++i) *most = fmax(*most, ref_length(ref_from(c[i])));
    }
}

/*
 * T3, T4. On a sphere the interpolated normal at a point q of a facet is q/|q|: the mesh refracts
 * like spheres of the radii between its facets' and its vertices' distances from the centre. Stored
 * normals and vertices are off by √3 FLOAT_ROUNDING each, which tilts the normal by their sum; a
 * tilt turns the refracted ray by less than itself and moves the crossing by that times the way to
 * it over the sine of the crossing angle.
 */
static void check_ball(mcv_transform to_world, const char *name) {
    mcv_scene *scene = mcv_scene_new("ball");
    const double n = 1.5, tilt = 2 * sqrt(3) * FLOAT_ROUNDING;
    double least, most, worst = 0, worst_bound = 0;
    add_sphere(scene, 1, 150, add_glass(scene, n, 0, 0), to_world);
    find_radii(scene, &least, &most);
    enum { RAYS = 200 };
    mcv_trace_ray rays[RAYS];
    for (int i = 0; i < RAYS; ++i) {
        const double h = 0.1 + 0.6 * i / RAYS, around = 0.1 + 2.4 * i;
        rays[i] = (mcv_trace_ray){{h * cos(around), h * sin(around), -3}, {0, 0, 1}};
    }
    size_t count;
    mcv_vertex *vertices = trace(scene, rays, RAYS, 8, &count);
    assert_int_equal(count, 4 * RAYS); /* start, in, out, miss */
    for (int i = 0; i < RAYS; ++i) {
        const mcv_vertex *v = &vertices[4 * i];
        const double h = 0.1 + 0.6 * i / RAYS;
        const double low = crossing_of_surface(h, n, least), high = crossing_of_surface(h, n, most);
        const double exact = crossing_of_surface(h, n, 1), bend = asin(h) - asin(h / n);
        const double slack = tilt * (1 + exact) / sin(bend), single = axis_crossing(&v[1]);
        if (single < fmin(low, high) - slack || single > fmax(low, high) + slack)
            fail_msg("T3 %s: h = %g crosses at %.9g, not between %.9g and %.9g", name, h, single,
                     low, high);
        worst = worse(worst, fabs(single / exact - 1));
        worst_bound =
            fmax(worst_bound, (fmax(fabs(low - exact), fabs(high - exact)) + slack) / exact);

        double bottom = INFINITY, top = 0;
        for (int k = 0; k < 4; ++k) {
            const double c = crossing_of_ball(h, n, k & 1 ? least : most, k & 2 ? least : most);
            bottom = fmin(bottom, c);
            top = fmax(top, c);
        }
        /* Two tilts; the first also moves the second hit, by less than the ball's diameter times
         * it. */
        const double slack2 = 4 * tilt * 2 / sin(2 * bend), both = axis_crossing(&v[2]);
        if (both < bottom - slack2 || both > top + slack2)
            fail_msg("T4 %s: h = %g crosses at %.9g, not between %.9g and %.9g", name, h, both,
                     bottom, top);
    }
    free(vertices);
    print_message("  T3 %s: largest relative error %.2g, bound %.2g\n", name, worst, worst_bound);
    mcv_scene_free(scene);
}

static void test_ball_lens(void **state) {
    (void)state;
    /* The formulas themselves, against published values. */
    check("T3 formula, h = 0.3", 1 + crossing_of_surface(0.3, 1.5, 1), 2.938906438, 5e-10);
    check("T4 formula, h = 0.7", crossing_of_ball(0.7, 1.5, 1, 1), 1.277787023, 5e-10);
    check_ball(mcv_transform_identity(), "ball");
    const double c = cos(0.3), s = sin(0.3);
    check_ball((mcv_transform){{-c, s, 0, s, c, 0, 0, 0, 1, 0, 0, 0}}, "mirrored ball");
}

static void test_mesh_converges(void **state) { /* T10 */
    double error[2] = {0, 0};
    (void)state;
    for (int level = 0; level < 2; ++level) {
        mcv_scene *scene = mcv_scene_new("sphere");
        enum { RAYS = 500 };
        mcv_trace_ray rays[RAYS];
        ref_random random = {7};
        add_sphere(scene, 1, level ? 96 : 24, add_glass(scene, 1.5, 0, 0),
                   mcv_transform_identity());
        for (int i = 0; i < RAYS; ++i) {
            const double h = 0.1 + 0.2 * ref_random_unit(&random),
                         around = 2 * M_PI * ref_random_unit(&random);
            rays[i] = (mcv_trace_ray){{h * cos(around), h * sin(around), -3}, {0, 0, 1}};
        }
        size_t count;
        mcv_vertex *v = trace(scene, rays, RAYS, 1, &count);
        assert_int_equal(count, 2 * RAYS);
        for (int i = 0; i < RAYS; ++i) {
            const double h = hypot(rays[i].origin[0], rays[i].origin[1]);
            error[level] +=
                fabs(axis_crossing(&v[2 * i + 1]) - crossing_of_surface(h, 1.5, 1)) / RAYS;
        }
        free(v);
        mcv_scene_free(scene);
    }
    /* Sag and normals are quadratic in the edge; 0.2 leaves room for the mean over facets of
     * unequal shape. */
    check("T10 order of convergence with interpolated normals", log(error[0] / error[1]) / log(4),
          2, 0.2);
}

static void test_fresnel(void **state) { /* T12, T13 */
    double s, p;
    (void)state;
    ref_fresnel(1, 1.5, 1, &s, &p);
    check("T12 normal incidence", 0.5 * (s + p), 0.04, 4 * DBL_EPSILON);
    ref_fresnel(1, 1.5, cos(M_PI / 3), &s, &p);
    check("T12 60 degrees, perpendicular", s, 0.1765714881, 5e-11); /* published with 10 digits */
    check("T12 60 degrees, parallel", p, 0.0018019375, 5e-11);
    ref_fresnel(1, 1.5, cos(atan(1.5)), &s, &p);
    check("T12 Brewster's angle, parallel", p, 0, 1e-12);
    const double critical = asin(1 / 1.5);
    check("T12 critical angle [degrees]", critical * 180 / M_PI, 41.8103149, 5e-8);
    for (int decade = -2; decade >= -8; --decade) {
        const double off = pow(10, decade);
        ref_fresnel(1.5, 1, cos(critical + off), &s, &p);
        assert_true(s == 1 && p == 1);
        ref_fresnel(1.5, 1, cos(critical - off), &s, &p);
        /* 1 - R_s = 4 √(2δ)/(n²-1)^¼ to first order in √δ: the next is of the order of its square.
         */
        const double first = 4 * sqrt(2 * off) / pow(1.25, 0.25);
        check("T12 just below the critical angle, 1 - R_s", 1 - s, first, first * first);
    }
    /* Diffuse light by the midpoint rule in sin²θ, whose error falls at least with the step to 3/2
     * (root at grazing, kink at critical). */
    enum { STEPS = 1000000 };
    double outside = 0, inside = 0;
    const ref_surface surface = {.geometric = {0, 0, 1}, .normal = {0, 0, 1}};
    for (int i = 0; i < STEPS; ++i) {
        const double sine = sqrt((i + 0.5) / STEPS);
        const ref_interaction meeting =
            ref_make_interaction(&surface, (ref_vec){sine, 0, -sqrt(1 - sine * sine)});
        outside += ref_reflectance(&meeting, 1, 1.5) / STEPS;
        inside += ref_reflectance(&meeting, 1.5, 1) / STEPS;
    }
    check("T13 diffuse light from outside", outside, 0.0917779594, 10 * pow(STEPS, -1.5));
    check("T13 diffuse light from inside", inside, 0.5963457598, 10 * pow(STEPS, -1.5));
}

static void test_absorption(void **state) {
    mcv_scene *scene = mcv_scene_new("grey plate");
    const double sigma = 3, thickness = 0.5, angle = 0.7;
    (void)state;
    add_box(scene, (const double[3]){8, 8, thickness / 2}, add_glass(scene, 1, sigma, 0),
            mcv_transform_identity());
    const mcv_trace_ray rays[] = {{{0.1, 0.05, -1}, {sin(angle), 0, cos(angle)}},
                                  {{0.1, 0.05, 0}, {0, 0, 1}}};
    size_t count;
    mcv_vertex *v = trace(scene, rays, 2, 8, &count);
    assert_int_equal(count, 4 + 3);
    check("absorption: exp(-sigma d / cos)", v[3].transmittance,
          exp(-sigma * thickness / cos(angle)), ROUNDING);
    check("absorption: from inside", v[6].transmittance, exp(-sigma * thickness / 2), ROUNDING);
    assert_int_equal(v[1].event, MCV_EVENT_PASS);
    free(v);
    mcv_scene_free(scene);
}

static void test_total_reflection(void **state) {
    /* A cube traps light of 45° in the plane of four faces for ever: the depth ends it. */
    mcv_scene *scene = mcv_scene_new("cube");
    (void)state;
    add_box(scene, (const double[3]){0.5, 0.5, 0.5}, add_glass(scene, 1.5, 0, 0),
            mcv_transform_identity());
    const mcv_trace_ray ray = {{0.1, 0, 0.05}, {1, 1, 0}};
    enum { DEPTH = 1000 };
    size_t count;
    mcv_vertex *v = trace(scene, &ray, 1, DEPTH, &count);
    assert_int_equal(count, DEPTH + 1);
    for (size_t i = 1; i < count; ++i) assert_int_equal(v[i].event, MCV_EVENT_REFLECT);
    /* Each reflection turns one component and rounds it a few times. */
    check("direction after 1000 reflections", fabs(v[DEPTH].direction[0]), sqrt(0.5),
          4 * DEPTH * DBL_EPSILON);
    check("transmittance after 1000 reflections", v[DEPTH].transmittance, 1, 0);
    free(v);
    mcv_scene_free(scene);
}

/* A glass ball with an air bubble, as an inner shell of the same mesh turned inside out or as a
 * body of higher priority. */
static mcv_scene *bubble_scene(bool shell) {
    mcv_scene *parts = mcv_scene_new("parts"), *scene = mcv_scene_new("bubble");
    mcv_transform inner_place = mcv_transform_identity();
    const uint32_t glass = add_glass(scene, 1.5, 0.5, 0), air = add_glass(scene, 1, 0, 1);
    inner_place.m[9] = 0.125; /* exact in float32, so that both scenes hold the same triangles */
    add_sphere(parts, 1, 40, add_glass(parts, 1.5, 0, 0), mcv_transform_identity());
    add_sphere(parts, 0.25, 24, 0, inner_place);
    const mcv_mesh *outer = &parts->meshes[0], *inner = &parts->meshes[1];
    if (!shell) {
        add_instance(scene, outer, glass, mcv_transform_identity());
        add_instance(scene, inner, air, inner_place);
    } else {
        mcv_mesh both = {.vertex_count = outer->vertex_count + inner->vertex_count,
                         .triangle_count = outer->triangle_count + inner->triangle_count};
        both.positions = malloc(12 * (size_t)both.vertex_count);
        both.normals = malloc(12 * (size_t)both.vertex_count);
        both.indices = malloc(12 * (size_t)both.triangle_count);
        assert_true(both.positions && both.normals && both.indices);
        memcpy(both.positions, outer->positions, 12 * (size_t)outer->vertex_count);
        memcpy(both.normals, outer->normals, 12 * (size_t)outer->vertex_count);
        memcpy(both.indices, outer->indices, 12 * (size_t)outer->triangle_count);
        for (uint32_t v = 0; v < inner->vertex_count; ++v) {
            for (uint32_t k = 0; k < 3; ++k) {
                const uint32_t to = 3 * (outer->vertex_count + v) + k;
                both.positions[to] = inner->positions[3 * v + k] + (k == 0 ? 0.125f : 0.0f);
                both.normals[to] = -inner->normals[3 * v + k];
            }
        }
        for (uint32_t t = 0; t < inner->triangle_count; ++t) {
            for (uint32_t k = 0; k < 3; ++k)
                both.indices[3 * (outer->triangle_count + t) + k] =
                    outer->vertex_count + inner->indices[3 * t + 2 - k];
        }
        add_instance(scene, &both, glass, mcv_transform_identity());
        free(both.positions);
        free(both.normals);
        free(both.indices);
    }
    mcv_scene_free(parts);
    return scene;
}

static void test_bubble_by_priority_is_bubble_by_shell(void **state) {
    enum { RAYS = 5000, DEPTH = 6 };
    /*
     * The shell's vertices are rounded once more in float32: by FLOAT_ROUNDING of coordinates below
     * 1/2, i.e. half of it per coordinate, √3 of that per vertex, and as much again relative to the
     * bubble's radius of 1/4 in the facets' shape. What that does to a ray is measured: no more
     * than moving the ray itself by as much. 16 covers the bubble's curvature 4 and its two
     * surfaces, twice.
     */
    const double move = 16 * sqrt(3) * FLOAT_ROUNDING / 2;
    mcv_scene *by_priority = bubble_scene(false), *by_shell = bubble_scene(true);
    static mcv_trace_ray rays[3][RAYS];
    ref_random random = {3};
    (void)state;
    for (int i = 0; i < RAYS; ++i) {
        for (int copy = 0; copy < 3; ++copy) rays[copy][i] = (mcv_trace_ray){{0, 0, -3}, {0, 0, 0}};
        const double x = 0.7 * ref_random_unit(&random) - 0.35,
                     y = 0.7 * ref_random_unit(&random) - 0.35;
        for (int copy = 0; copy < 3; ++copy) {
            rays[copy][i].direction[0] = x / 3 + (copy == 1 ? move : 0);
            rays[copy][i].direction[1] = y / 3 + (copy == 2 ? move : 0);
            rays[copy][i].direction[2] = 1;
        }
    }
    size_t count[4], at[4] = {0};
    mcv_vertex *v[4] = {trace(by_priority, rays[0], RAYS, DEPTH, &count[0]),
                        trace(by_priority, rays[1], RAYS, DEPTH, &count[1]),
                        trace(by_priority, rays[2], RAYS, DEPTH, &count[2]),
                        trace(by_shell, rays[0], RAYS, DEPTH, &count[3])};
    int compared = 0, through = 0, different = 0;
    double worst = 0, worst_bound = 0;
    for (uint32_t i = 0; i < RAYS; ++i) {
        size_t length[4];
        bool comparable = true;
        for (int c = 0; c < 4; ++c) {
            size_t end = at[c];
            while (end < count[c] && v[c][end].ray == i) ++end;
            length[c] = end - at[c];
            comparable = comparable && length[c] == length[0];
        }
        /* Rays at which facets and events change under so small a move lie on edges. */
        for (size_t k = 0; comparable && k < length[0]; ++k)
            for (int c = 1; c < 4; ++c)
                comparable = comparable && v[c][at[c] + k].event == v[0][at[0] + k].event &&
                             (c == 3 || v[c][at[c] + k].primitive == v[0][at[0] + k].primitive);
        if (comparable) {
            const mcv_vertex *last[4];
            for (int c = 0; c < 4; ++c)
                last[c] = &v[c][at[c] + length[c] - 2]; /* before the miss */
            double moved = 0;
            for (int c = 1; c < 3; ++c)
                moved +=
                    ref_length(ref_sub(ref_from(last[c]->direction), ref_from(last[0]->direction)));
            const double difference =
                ref_length(ref_sub(ref_from(last[3]->direction), ref_from(last[0]->direction)));
            ++compared;
            through += length[0] > 4;
            if (difference > worst) {
                worst = difference;
                worst_bound = moved;
            }
            if (difference > moved + move) ++different;
        }
        for (int c = 0; c < 4; ++c) at[c] += length[c];
    }
    print_message("  bubble: %d of %d rays compared, %d through it, largest difference %.2g (bound "
                  "%.2g), %d beyond their bounds\n",
                  compared, RAYS, through, worst, worst_bound + move, different);
    assert_int_equal(different, 0);
    assert_true(compared > RAYS * 9 / 10 && through > RAYS / 10);
    for (int c = 0; c < 4; ++c) free(v[c]);
    mcv_scene_free(by_priority);
    mcv_scene_free(by_shell);
}

/* Rays aimed at vertices and edges of a closed mesh of integer coordinates, where edge functions
 * are exactly 0: no leak. */
static void test_closed_surfaces_do_not_leak(void **state) {
    mcv_scene *scene = mcv_scene_new("box");
    ref_geometry geometry;
    ref_random random = {11};
    int winding[1], wrong = 0;
    enum { RAYS = 200000 };
    (void)state;
    add_box(scene, (const double[3]){1, 1, 1}, add_glass(scene, 1.5, 0, 0),
            mcv_transform_identity());
    assert_int_equal(ref_geometry_new(scene, &geometry, &builder_error), MCV_OK);
    for (int i = 0; i < RAYS; ++i) {
        /* From integer points around to the middle of an edge, a face's diagonal or any of its
         * points. */
        const int a = (int)(3 * ref_random_unit(&random)), b = (int)(3 * ref_random_unit(&random));
        const double side = ref_random_unit(&random) < 0.5 ? -1 : 1;
        const double target[3] = {side, a - 1.0,
                                  b == 2 ? a - 1.0 : 2 * ref_random_unit(&random) - 1};
        double from[3];
        for (int k = 0; k < 3; ++k) from[k] = floor(17 * ref_random_unit(&random)) - 8;
        if (fabs(from[0]) == 1 || fabs(from[1]) == 1 || fabs(from[2]) == 1)
            continue; /* in a face's plane there is no inside */
        const bool inside = fabs(from[0]) < 1 && fabs(from[1]) < 1 && fabs(from[2]) < 1;
        winding[0] = 0;
        ref_add_windings(&geometry, ref_from(from), ref_sub(ref_from(target), ref_from(from)),
                         winding);
        wrong += winding[0] != inside;
    }
    print_message("  leaks: %d of %d rays at edges\n", wrong, RAYS);
    assert_int_equal(wrong, 0);
    ref_geometry_free(&geometry);
    mcv_scene_free(scene);
}

/* The tree against all triangles one by one, with another intersection formula (volumes of
 * tetrahedra). */
static void test_tree_is_brute_force(void **state) {
    enum { TRIANGLES = 600, RAYS = 3000 };
    static float positions[9 * TRIANGLES];
    static uint32_t indices[3 * TRIANGLES];
    ref_random random = {5};
    mcv_scene *scene = mcv_scene_new("soup");
    ref_geometry geometry;
    int hits = 0;
    double worst = 0;
    (void)state;
    for (uint32_t i = 0; i < 3 * TRIANGLES; ++i) {
        indices[i] = i;
        for (uint32_t k = 0; k < 3; ++k) {
            const double centre =
                i % 3 ? positions[3 * (i - i % 3) + k] : 2 * ref_random_unit(&random) - 1;
            positions[3 * i + k] = (float)(centre + (i % 3 ? 0.3 * ref_random_unit(&random) : 0));
        }
    }
    add_instance(scene,
                 &(mcv_mesh){.vertex_count = 3 * TRIANGLES,
                             .triangle_count = TRIANGLES,
                             .positions = positions,
                             .indices = indices},
                 add_absorber(scene), mcv_transform_identity());
    assert_int_equal(ref_geometry_new(scene, &geometry, &builder_error), MCV_OK);
    for (int r = 0; r < RAYS; ++r) {
        ref_vec o = {2 * ref_random_unit(&random) - 1, 2 * ref_random_unit(&random) - 1,
                     2 * ref_random_unit(&random) - 1};
        ref_vec d = {2 * ref_random_unit(&random) - 1, 2 * ref_random_unit(&random) - 1,
                     2 * ref_random_unit(&random) - 1};
        if (r % 3 == 0) d.x = 0; /* along slabs, too */
        if (r % 6 == 0) d.y = -0.0;
        double best = INFINITY, amplified = 0;
        uint32_t number = MCV_NONE;
        for (uint32_t t = 0; t < TRIANGLES; ++t) {
            double c[3][3];
            mcv_scene_corners(scene, 0, t, c);
            const ref_vec a = ref_sub(ref_from(c[0]), o), b = ref_sub(ref_from(c[1]), o),
                          e = ref_sub(ref_from(c[2]), o);
            const double w0 = ref_dot(d, ref_cross(b, e)), w1 = ref_dot(d, ref_cross(e, a)),
                         w2 = ref_dot(d, ref_cross(a, b));
            if (!((w0 > 0 && w1 > 0 && w2 > 0) || (w0 < 0 && w1 < 0 && w2 < 0))) continue;
            const double distance = ref_dot(a, ref_cross(b, e)) / (w0 + w1 + w2);
            if (distance > 0 && distance < best) {
                best = distance;
                number = t;
                amplified = 1 / fabs(w0 + w1 + w2);
            }
        }
        ref_hit hit;
        const bool met = ref_closest_hit(&geometry, o, d, MCV_NONE, &hit);
        if (met != (number != MCV_NONE) || (met && hit.triangle->number != number))
            fail_msg("ray %d meets another triangle", r);
        hits += met;
        /* A triple product of vectors below 4 rounds by less than 16 · 4³ DBL_EPSILON; the
         * quotient's condition is 1/|w0 + w1 + w2|. */
        const double bound = 2 * 16 * 64 * DBL_EPSILON * amplified * (1 + best);
        if (met && fabs(hit.distance - best) > bound)
            fail_msg("ray %d: distance off by %g > %g", r, hit.distance - best, bound);
        if (met) worst = worse(worst, fabs(hit.distance - best) / bound);
    }
    print_message("  tree: %d of %d rays hit, distance off by at most %.2g of its bound\n", hits,
                  RAYS, worst);
    assert_true(hits > RAYS / 3);
    ref_geometry_free(&geometry);
    mcv_scene_free(scene);
}

static void test_bad_rays(void **state) {
    mcv_scene *scene = mcv_scene_new("empty");
    const mcv_render_options options = {.depth = 4};
    const mcv_trace_ray bad[] = {
        {{0, 0, 0}, {0, 0, 0}}, {{0, NAN, 0}, {0, 0, 1}}, {{0, 0, 0}, {0, INFINITY, 1}}};
    (void)state;
    for (size_t i = 0; i < 3; ++i) {
        mcv_vertex *v = NULL;
        size_t count = 1;
        assert_int_equal(
            mcv_reference_trace(scene, &bad[i], 1, &options, &v, &count, &builder_error),
            MCV_BAD_INPUT);
        assert_null(v);
        assert_int_equal(count, 0);
        assert_non_null(strstr(builder_error.text, "ray 0"));
    }
    mcv_scene_free(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_plate_shifts),
        cmocka_unit_test(test_prism_deviates),
        cmocka_unit_test(test_ball_lens),
        cmocka_unit_test(test_mesh_converges),
        cmocka_unit_test(test_fresnel),
        cmocka_unit_test(test_absorption),
        cmocka_unit_test(test_total_reflection),
        cmocka_unit_test(test_bubble_by_priority_is_bubble_by_shell),
        cmocka_unit_test(test_closed_surfaces_do_not_leak),
        cmocka_unit_test(test_tree_is_brute_force),
        cmocka_unit_test(test_bad_rays),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
