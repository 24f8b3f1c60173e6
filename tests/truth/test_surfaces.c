/* SPDX-License-Identifier: Apache-2.0 */
/* ctest: label truth */
/*
 * Exact surfaces: rays through them against closed forms, an independent program's listing and the
 * reference renderer; what goes in comes out; a lens shows what a fine mesh of it shows.
 */
#include "agreement.h"
#include "loader/load.h"

/* T1: a plate shifts a ray by t sin θ (1 - cos θ/√(n² - sin² θ)). float32: 2e-6 t. */
static void plate(void **state) {
    (void)state;
    for (int side = 0; side < 2; ++side)
        for (int reference = 0; reference < 2; ++reference)
            for (double angle = 0.1; angle < 1.5; angle += 0.2) {
                mcv_scene *scene = new_scene();
                const double n = 1.5, t = 0.01, s = sin(angle), c = cos(angle);
                mcv_solid box = element(0.1, (mcv_cap){.z = -t / 2}, (mcv_cap){.z = t / 2});
                mcv_vertex v[DEPTH + 1];
                if (side) {
                    box.side = MCV_SIDE_BOX;
                    box.half[0] = box.half[1] = 0.1;
                }
                const uint32_t glass = add_glass(scene, n, 0, 0);
                add_solid(scene, &box, glass, glass);
                const mcv_trace_ray ray = {{-0.02 * s / c, 0, -0.02}, {s, 0, c}};
                const size_t count = trace_one(scene, reference, ray, v);
                assert_int_equal(count, 3);
                /* Across the ray from where it would be without the plate. */
                const double x = v[2].position[0] - ray.origin[0],
                             z = v[2].position[2] - ray.origin[2];
                expect_near("T1 plate: shift [m]", reference, z * s - x * c,
                            t * s * (1 - c / sqrt(n * n - s * s)), reference ? 1e-15 : 2e-6 * t);
                /* At each interface 4u (1 + η tan θ_t) (accuracy of a refraction), the first of
                 * them enlarged by n c_t/c on leaving. */
                const double inner = s / n, c_t = sqrt(1 - inner * inner), u = 0x1p-24;
                const double rounding =
                    4 * u * (1 + inner / (n * c_t)) * n * c_t / c + 4 * u * (1 + n * s / c);
                expect_near("T1 plate: change of direction", reference,
                            hypot(v[2].direction[0] - s, v[2].direction[2] - c), 0,
                            reference   ? 1e-13
                            : angle < 1 ? 3e-7
                                        : rounding);
                mcv_scene_free(scene);
            }
}

/* T3: exact refraction at a sphere, R = 1, from air into glass of n = 1.5: where rays at height h
 * cross the axis, from the vertex. */
static void single_sphere(void **state) {
    (void)state;
    static const double heights[] = {0.01, 0.3, 0.7},
                        known[] = {2.999933332, 2.938906438, 2.632634207};
    for (int reference = 0; reference < 2; ++reference) {
        mcv_scene *scene = new_scene();
        const uint32_t glass = add_glass(scene, 1.5, 0, 0);
        const mcv_solid solid = element(0.9, (mcv_cap){.curvature = 1}, (mcv_cap){.z = 5});
        add_solid(scene, &solid, glass, glass);
        for (int i = 0; i < 3; ++i) {
            mcv_vertex v[DEPTH + 1];
            trace_one(scene, reference, along_z(heights[i], 0, -1), v);
            expect_near("T3 exact sphere: crossing, R = 1", reference, crossing(v + 1), known[i],
                        reference ? 1e-9 * known[i] : 2e-5 * known[i]);
        }
        mcv_scene_free(scene);
    }
}

/* T4: a ball lens, n = 1.5, R = 1: h/sin(2 (I - I')) from the centre. */
static void ball_lens(void **state) {
    (void)state;
    static const double heights[] = {0.3, 0.7}, known[] = {1.461978437, 1.277787023};
    for (int reference = 0; reference < 2; ++reference) {
        mcv_scene *scene = new_scene();
        const uint32_t glass = add_glass(scene, 1.5, 0, 0);
        const mcv_solid ball = sphere(1);
        add_solid(scene, &ball, glass, glass);
        for (int i = 0; i < 2; ++i) {
            mcv_vertex v[DEPTH + 1];
            assert_int_equal(trace_one(scene, reference, along_z(heights[i], 0, -3), v), 3);
            expect_near("T4 exact ball: crossing, R = 1", reference, crossing(v + 2), known[i],
                        reference ? 1e-9 * known[i] : 2e-5 * known[i]);
        }
        mcv_scene_free(scene);
    }
}

/* T5: rays from R/n beside the centre of a ball leave it as if from n R; up to 60°, RMS. */
static void aplanatic(void **state) {
    (void)state;
    for (int reference = 0; reference < 2; ++reference) {
        mcv_scene *scene = new_scene();
        const double n = 1.5;
        const uint32_t glass = add_glass(scene, n, 0, 0);
        const mcv_solid ball = sphere(1);
        double squares = 0;
        int rays = 0;
        add_solid(scene, &ball, glass, glass);
        for (double angle = 5; angle <= 60; angle += 2.5, ++rays) {
            const double a = angle * M_PI / 180;
            mcv_vertex v[DEPTH + 1];
            trace_one(scene, reference, (mcv_trace_ray){{0, 0, -1 / n}, {sin(a), 0, cos(a)}}, v);
            squares += pow(crossing(v + 1) + n, 2);
        }
        expect_near("T5 aplanatic points: RMS spread, R = 1", reference, sqrt(squares / rays), 0,
                    reference ? 1e-12 : 2e-6);
        mcv_scene_free(scene);
    }
}

/* T6, T7: a hyperboloid (k = -n²) sends parallel light from glass, an ellipsoid (k = -1/n²) from
 * air into one point. */
static void conics_focus(void **state) {
    (void)state;
    const double n = 1.5, r = 1;
    for (int reference = 0; reference < 2; ++reference) {
        mcv_scene *scenes[2] = {new_scene(), new_scene()};
        const mcv_solid plano =
            element(0.9, (mcv_cap){.z = -1.5}, (mcv_cap){.curvature = -1 / r, .conic = -n * n});
        const mcv_solid rod =
            element(0.6, (mcv_cap){.curvature = 1 / r, .conic = -1 / (n * n)}, (mcv_cap){.z = 5});
        const double focus[2] = {r / (n - 1), n * r / (n - 1)};
        for (int i = 0; i < 2; ++i) {
            const uint32_t glass = add_glass(scenes[i], n, 0, 0);
            add_solid(scenes[i], i ? &rod : &plano, glass, glass);
            for (double h = 0.05; h < 0.6; h += 0.05) {
                mcv_vertex v[DEPTH + 1];
                const size_t count = trace_one(scenes[i], reference, along_z(h, 0, -2), v);
                assert_true(count >= 2);
                const mcv_vertex *last = v + (i ? 1 : 2);
                /* How far from the axis it crosses the focal plane: 1e-6 of the focal length. */
                const double at = last->position[0] + (focus[i] - last->position[2]) *
                                                          last->direction[0] / last->direction[2];
                expect_near(i ? "T7 ellipsoid: spot, f = 3" : "T6 hyperboloid: spot, f = 2",
                            reference, at, 0, reference ? 1e-14 : 1e-6 * focus[i]);
            }
            mcv_scene_free(scenes[i]);
        }
    }
}

/* T8: mirrors. A paraboloid focuses at R/2; a sphere from its centre at R/(2 cos θ), sin θ = h/R.
 */
static void mirrors(void **state) {
    (void)state;
    for (int reference = 0; reference < 2; ++reference)
        for (int conic = -1; conic <= 0; ++conic) {
            mcv_scene *scene = new_scene();
            mcv_solid mirror = {.side = MCV_SIDE_OPEN,
                                .radius = 0.9,
                                .caps = {{.curvature = -1, .conic = conic}},
                                .to_world = unmoved};
            add_solid(scene, &mirror, add_material(scene, MCV_MATERIAL_MIRROR, NULL), 0);
            for (double h = 0.05; h < 0.65; h += 0.05) {
                mcv_vertex v[DEPTH + 1];
                trace_one(scene, reference, along_z(h, 0, -3), v);
                const double focus = conic ? -0.5 : -1 + 1 / (2 * sqrt(1 - h * h));
                expect_near(conic ? "T8 paraboloid: focus, R = 1"
                                  : "T8 spherical mirror: crossing, R = 1",
                            reference, crossing(v + 1), focus, reference ? 1e-13 : 2e-6 / h);
            }
            mcv_scene_free(scene);
        }
}

/*
 * T8: an ellipsoid (k = -e², R = 3/2, e = 1/2) sends light from one focus, R/(1 + e) before the
 * vertex, into the other, R/(1 - e) before it, both ways and at all angles: how far from it rays
 * pass. float32: 1e-6 of the path of 2 R/(1 - e²), 16 u, as the hit, the normal and the reflected
 * direction are off by some 4 u each, the normal's twice.
 */
static void ellipsoid_mirror(void **state) {
    (void)state;
    const double r = 1.5, e = 0.5, foci[2] = {-r / (1 + e), -r / (1 - e)},
                 path = 2 * r / (1 - e * e);
    for (int reference = 0; reference < 2; ++reference) {
        mcv_scene *scene = new_scene();
        mcv_solid mirror = {.side = MCV_SIDE_OPEN,
                            .radius = 1.4,
                            .caps = {{.curvature = -1 / r, .conic = -e * e}},
                            .to_world = unmoved};
        add_solid(scene, &mirror, add_material(scene, MCV_MATERIAL_MIRROR, NULL), 0);
        for (int back = 0; back < 2; ++back)
            for (double height = 0.05; height < 1.4; height += 0.09) {
                /* Towards the mirror at this height. */
                const double sag =
                    height * height / r / (1 + sqrt(1 - (1 - e * e) * height * height / (r * r)));
                const double x = height * cos(height), y = height * sin(height),
                             z = -sag - foci[back];
                const double distance = sqrt(height * height + z * z);
                mcv_vertex v[DEPTH + 1];
                const mcv_trace_ray ray = {{0, 0, foci[back]},
                                           {x / distance, y / distance, z / distance}};
                assert_true(trace_one(scene, reference, ray, v) >= 2);
                const double *p = v[1].position, *d = v[1].direction,
                             to[3] = {-p[0], -p[1], foci[!back] - p[2]};
                const double along = to[0] * d[0] + to[1] * d[1] + to[2] * d[2];
                assert_true(along > 0);
                double miss = 0;
                for (int k = 0; k < 3; ++k) miss += pow(to[k] - along * d[k], 2);
                expect_near("T8 ellipsoid mirror: rays past the other focus, 2a = 4", reference,
                            sqrt(miss), 0, reference ? 1e-14 * path : 1e-6 * path);
            }
        mcv_scene_free(scene);
    }
}

/*
 * T9: CODE V's listing of a double Gauss: the axial marginal ray's heights at its eleven surfaces,
 * with its indices of six digits [mm]. Within 5e-5 mm (its own digits) and, in single precision,
 * 2e-4 mm.
 */
static void double_gauss(void **state) {
    (void)state;
    static const struct {
        double radius, thickness, index, semi_diameter;
    } surfaces[] = {{56.20238, 8.75, 1.622292, 27},   {152.2858, 0.5, 1, 26},
                    {37.68262, 12.5, 1.607379, 23.5}, {INFINITY, 3.8, 1.603417, 22},
                    {24.2313, 30.117402, 1, 22},      {-28.37731, 3.8, 1.603417, 20},
                    {INFINITY, 11, 1.620408, 20},     {-37.92546, 0.5, 1, 20},
                    {177.41176, 7, 1.620408, 20},     {-79.41143, 0, 1, 20}};
    /* The fifth distance is that to the stop and on, of which the listing has the ray's height too
     * (15.702464 at 16.369445 mm). */
    static const double heights[] = {25.000000, 24.109772, 22.844992, 20.958242, 16.784894,
                                     14.610682, 15.815163, 16.882946, 16.583956, 16.261006};
    enum { N = sizeof surfaces / sizeof surfaces[0] };
    mcv_scene *scene = new_scene();
    double z = 0;
    for (int i = 0; i < N; ++i) {
        if (surfaces[i].index != 1) {
            const mcv_cap a = {.z = z * 1e-3, .curvature = 1e3 / surfaces[i].radius};
            const mcv_cap b = {.z = (z + surfaces[i].thickness) * 1e-3,
                               .curvature = 1e3 / surfaces[i + 1].radius};
            mcv_solid solid = element(
                1e-3 * fmax(surfaces[i].semi_diameter, surfaces[i + 1].semi_diameter), a, b);
            solid.cemented = i > 0 && surfaces[i - 1].index != 1;
            add_solid(scene, &solid, add_glass(scene, surfaces[i].index, 0, 0),
                      add_absorber(scene));
        }
        z += surfaces[i].thickness;
    }
    for (int by = 0; by < RAY_TRACERS; ++by) {
        mcv_vertex v[DEPTH + 1];
        const size_t count = trace_one(scene, by, along_z(25e-3, 0, -20e-3), v);
        assert_int_equal(count, N + 1);
        for (int i = 0; i < N; ++i) {
            char what[48];
            snprintf(what, sizeof what, "T9 double Gauss: height %d [mm]", i + 1);
            expect_near(what, by, 1e3 * v[i + 1].position[0], heights[i],
                        by == BY_DEVICE ? 2e-4 : 5e-5);
        }
        /* In its focus, 61.487536 - 0.400269 mm behind the last vertex. */
        const mcv_vertex *last = v + N;
        const double image = z * 1e-3 + 61.087267e-3;
        const double x = last->position[0] +
                         (image - last->position[2]) * last->direction[0] / last->direction[2];
        expect_near("T9 double Gauss: aberration [mm]", by, 1e3 * x, 0.014138,
                    by == BY_DEVICE ? 3e-4 : 1e-4);
    }
    mcv_scene_free(scene);
}

/* Cemented surfaces, plane, conic and aspheric, are met once, by both bodies together, from both
 * sides and at all heights. */
static void cemented_once(void **state) {
    (void)state;
    static const mcv_cap shared[] = {{0},
                                     {.curvature = 26, .conic = -1.4},
                                     {.asphere = {2e3, -3e6}},
                                     {.curvature = 26, .conic = -1.4, .asphere = {-52}}};
    for (size_t kind = 0; kind < sizeof shared / sizeof shared[0]; ++kind) {
        mcv_scene *scene = new_scene();
        mcv_solid first = element(8e-3, (mcv_cap){.z = -4e-3, .curvature = -17}, shared[kind]);
        mcv_solid second = element(8e-3, shared[kind], (mcv_cap){.z = 6e-3, .curvature = -20});
        second.cemented = true;
        add_solid(scene, &first, add_glass(scene, 1.8, 0, 0), add_absorber(scene));
        add_solid(scene, &second, add_glass(scene, 1.5, 0, 0), add_absorber(scene));
        mcv_trace_ray rays[40];
        for (int i = 0; i < 40; ++i) {
            rays[i] = along_z(i / 20 * 1e-3, i % 20 * 0.3e-3, -20e-3);
            if (i >= 20) rays[i].origin[2] = 20e-3, rays[i].direction[2] = -1;
        }
        for (int reference = 0; reference < 2; ++reference) {
            const traced t = follow(scene, reference, rays, 40);
            size_t next = 0;
            for (uint32_t i = 0; i < 40; ++i) {
                const mcv_vertex *v = t.vertices + next;
                size_t count = 0;
                for (; next < t.count && t.vertices[next].ray == i; ++next)
                    count += t.vertices[next].event != MCV_EVENT_MISS;
                if (count != 4 || v[2].event != MCV_EVENT_REFRACT ||
                    v[3].event != MCV_EVENT_REFRACT)
                    fail_msg("kind %zu, %s, ray %u: %zu vertices, not 4", kind,
                             reference ? "reference" : "device", i, count);
                assert_true(fabs(v[2].ior - (i < 20 ? 1.5 : 1.8)) < 1e-6);
            }
            free(t.vertices);
        }
        mcv_scene_free(scene);
    }
}

/* --- many rays
 * --------------------------------------------------------------------------------------------------
 */

/* Lenses of all kinds; each frame turned and moved. */
static mcv_scene *many_lenses(int kind, uint32_t *glass) {
    mcv_scene *scene = new_scene();
    *glass = add_glass(scene, 1.5, 0, 0);
    mcv_solid solid = sphere(0.02);
    const mcv_cap convex = {.z = -0.004, .curvature = 1 / 0.05},
                  concave = {.z = -0.004, .curvature = -1 / 0.04};
    if (kind == 1) solid = element(0.02, convex, (mcv_cap){.z = 0.0045, .curvature = -1 / 0.05});
    if (kind == 2)
        solid = element(0.02, concave, (mcv_cap){.z = 0.004, .curvature = 1 / 0.03, .conic = -0.5});
    if (kind == 3)
        solid = element(0.02, convex, (mcv_cap){.z = 0.002, .curvature = 1 / 0.06}); /* meniscus */
    if (kind == 4) /* the asphere of a condenser, bulging */
        solid = element(
            0.015,
            (mcv_cap){
                .z = -0.006, .curvature = 73.79474729, .conic = -0.6301, .asphere = {5.513e3}},
            (mcv_cap){.z = 0.006});
    if (kind == 5) /* a wavy plate */
        solid = element(0.02, (mcv_cap){.z = -0.004, .asphere = {4e4, -1.2e8}},
                        (mcv_cap){.z = 0.004, .curvature = 5, .asphere = {-2e4, 3e7}});
    if (kind == 6)
        solid = element(0.02, (mcv_cap){.z = -0.005, .curvature = 30, .cylindrical = true},
                        (mcv_cap){.z = 0.005, .curvature = -10});
    if (kind == 7)
        solid = element(0.01, (mcv_cap){.z = -0.02, .curvature = 100},
                        (mcv_cap){.z = 0.02, .curvature = -100}); /* rod with hemispheres */
    if (kind == 8) {
        solid = element(0.02, (mcv_cap){.z = -0.004}, (mcv_cap){.z = 0.004});
        solid.side = MCV_SIDE_BOX;
        solid.half[0] = 0.02, solid.half[1] = 0.01;
    }
    const double c = 0.8, s = 0.6;
    solid.to_world = (mcv_transform){{c, 0, s, 0, 1, 0, -s, 0, c, 0.013, -0.021, 0.034}};
    add_solid(scene, &solid, *glass, *glass);
    return scene;
}
enum { KINDS = 9 };

/* A ray from about the lens into it; a fifth of them to points on the circles where surface and
 * edge join. */
static mcv_trace_ray random_ray(const mcv_scene *scene, uint64_t *seed, bool *at_join) {
    const mcv_solid *solid = scene->solids;
    mcv_trace_ray ray;
    const double radius =
        solid->side == MCV_SIDE_BOX ? hypot(solid->half[0], solid->half[1]) : solid->radius;
    double to[3], from[3], local[3];
    const double angle = 2 * M_PI * uniform(seed),
                 r = uniform(seed) < 0.2 ? radius : radius * sqrt(uniform(seed));
    local[0] = r * cos(angle), local[1] = r * sin(angle);
    *at_join = r == radius;
    const mcv_cap *cap = solid->caps + (uniform(seed) < 0.5);
    local[2] = solid->side == MCV_SIDE_SPHERE ? radius * (2 * uniform(seed) - 1) : cap->z;
    if (r == radius && solid->side == MCV_SIDE_CYLINDER)
        local[2] = mcv_cap_height(cap, local[0] * (1 - 1e-15), local[1] * (1 - 1e-15));
    if (!isfinite(local[2])) local[2] = cap->z;
    mcv_transform_point(&solid->to_world, local, to);
    const double z = 2 * uniform(seed) - 1, phi = 2 * M_PI * uniform(seed);
    local[0] = 0.1 * sqrt(1 - z * z) * cos(phi), local[1] = 0.1 * sqrt(1 - z * z) * sin(phi),
    local[2] = 0.1 * z;
    mcv_transform_point(&solid->to_world, local, from);
    for (int k = 0; k < 3; ++k) {
        /* Both renderers must be given the same ray. */
        ray.origin[k] = (float)from[k];
        ray.direction[k] = to[k] - ray.origin[k];
    }
    return ray;
}

/*
 * Device and reference meet the same surfaces in the same places. The directions after a few
 * refractions differ by some 1e-7 times their amplification; what meets an edge within that may go
 * another way, as half of the fifth that is aimed at edges does: of the others at most one ray in
 * two hundred, for they are reflected many times. Every ray that is in glass comes out again:
 * inside and outside take turns.
 */
static void against_reference(void **state) {
    (void)state;
    enum { RAYS = 1000 };
    for (int kind = 0; kind < KINDS; ++kind) {
        uint32_t glass;
        mcv_scene *scene = many_lenses(kind, &glass);
        mcv_trace_ray *rays = calloc(RAYS, sizeof *rays);
        bool *at_join = calloc(RAYS, sizeof *at_join);
        uint64_t seed = 77 + (uint64_t)kind;
        for (int i = 0; i < RAYS; ++i) rays[i] = random_ray(scene, &seed, at_join + i);
        const traced device = follow(scene, false, rays, RAYS),
                     reference = follow(scene, true, rays, RAYS);
        size_t d = 0, r = 0;
        int other = 0, met = 0;
        double farthest = 0;
        for (uint32_t i = 0; i < RAYS; ++i) {
            bool same = true;
            double before = 1;
            for (; d < device.count && device.vertices[d].ray == i; ++d) {
                const mcv_vertex *a = device.vertices + d, *b = reference.vertices + r;
                if (r == reference.count || b->ray != i || a->event != b->event ||
                    (a->primitive != b->primitive))
                    same = false;
                if (a->event == MCV_EVENT_REFRACT && !((a->ior == 1) != (before == 1)))
                    fail_msg("kind %d, ray %u goes from n = %g to %g", kind, i, before, a->ior);
                if (a->event == MCV_EVENT_MISS && before != 1)
                    fail_msg("kind %d, ray %u is lost in the glass", kind, i);
                before = a->ior;
                if (!same) continue;
                if (a->event != MCV_EVENT_MISS) {
                    double off = 0;
                    for (int k = 0; k < 3; ++k)
                        off = fmax(off, fabs(a->position[k] - b->position[k]));
                    if (b->index <= 2 && !at_join[i]) farthest = fmax(farthest, off);
                    met += b->index > 0;
                }
                ++r;
            }
            while (r < reference.count && reference.vertices[r].ray == i) ++r;
            other += !same && !at_join[i];
        }
        print_message("kind %d: %d meetings, %d rays go other ways, first two within %.2g m\n",
                      kind, met, other, farthest);
        assert_true(met > RAYS);
        free(at_join);
        if (other > RAYS / 200) fail_msg("kind %d: %d of %d rays go other ways", kind, other, RAYS);
        /* Of a ray from 0.1 m: 5u (dist + r)/cos i at the first surface; i is up to some 89°. */
        if (kind != 5 && farthest > 1e-4) fail_msg("kind %d: off by %g m", kind, farthest);
        free(device.vertices);
        free(reference.vertices);
        free(rays);
        mcv_scene_free(scene);
    }
}

/* In mixed precision the same but for the 48 bits that are kept; radii of curvature are 5 mm or
 * more. */
static void mixed_against_reference(void **state) {
    (void)state;
    enum { RAYS = 2000 };
    for (int kind = 0; kind < KINDS; ++kind) {
        uint32_t glass;
        mcv_scene *scene = many_lenses(kind, &glass);
        mcv_trace_ray *rays = calloc(RAYS, sizeof *rays);
        uint64_t seed = 770 + (uint64_t)kind;
        char what[32];
        for (int i = 0; i < RAYS;) {
            bool at_join;
            rays[i] = random_ray(scene, &seed, &at_join);
            i += !at_join;
        }
        snprintf(what, sizeof what, "kind %d", kind);
        expect_agreement(what, scene, rays, RAYS, 0.2, 0.005);
        free(rays);
        mcv_scene_free(scene);
    }
}

/*
 * Radii from 1 mm to 1e9 mm: hits lie on the sphere, 5u (dist + size). The normal turns by what the
 * point is off across the ray, over the radius: a few roundings of the coordinates (0.01 m), and
 * its own.
 */
static void radii(void **state) {
    (void)state;
    for (int reference = 0; reference < 2; ++reference)
        for (double radius = 1e-3; radius < 2e6; radius *= 10)
            for (int side = 0; side < 4;
                 ++side) { /* bulging or hollow; from outside or from within the glass */
                mcv_scene *scene = new_scene();
                const double edge = fmin(radius / 2, 0.01), thick = edge, x = edge / 3,
                             y = edge / 5, sign = side & 1 ? -1 : 1;
                const mcv_solid solid =
                    element(edge, (mcv_cap){.curvature = sign / radius}, (mcv_cap){.z = thick});
                const uint32_t glass = add_glass(scene, 1.5, 0, 0);
                mcv_vertex v[DEPTH + 1];
                add_solid(scene, &solid, glass, glass);
                const double from = side & 2 ? thick * 0.9 : -0.1, along = side & 2 ? -1 : 1;
                trace_one(scene, reference, (mcv_trace_ray){{x, y, from}, {0, 0, along}}, v);
                const double r2 = x * x + y * y,
                             z = sign * r2 / (radius * (1 + sqrt(1 - r2 / (radius * radius))));
                assert_true(fabs(v[1].ior - (side & 2 ? 1 : 1.5)) < 1e-6);
                expect_near("height", reference, v[1].position[2], z,
                            reference ? 1e-16 : 5 * 0x1p-24 * (fabs(from) + edge));
                expect_near("normal", reference, v[1].normal[0], along * sign * x / radius,
                            reference ? 1e-15
                                      : 0x1p-24 * (4 * x / radius + 2 * (0.01 + x) / radius));
                mcv_scene_free(scene);
            }
}

/* A thousand total reflections in a plate, and in a rod: it stays inside, and keeps its angle. */
static void reflections(void **state) {
    (void)state;
    mcv_scene *scene = new_scene();
    mcv_render_options options = mcv_render_defaults();
    const mcv_solid rod = element(1e-3, (mcv_cap){.z = -3}, (mcv_cap){.z = 3});
    const uint32_t glass = add_glass(scene, 1.5, 0, 0);
    const mcv_trace_ray ray = {{0.3e-3, 0, -2.9}, {0.5, 0.3, 0.8}};
    mcv_vertex *v;
    size_t count;
    add_solid(scene, &rod, glass, glass);
    options.depth = 1000;
    BUILD(mcv_trace(scene, &ray, 1, &options, &v, &count, &builder_error));
    assert_int_equal(count, 1001);
    const double z = 0.8 / sqrt(0.98);
    for (size_t i = 1; i < count; ++i) {
        assert_int_equal(v[i].event, MCV_EVENT_REFLECT);
        expect_near("radius", false, hypot(v[i].position[0], v[i].position[1]), 1e-3, 1e-9);
    }
    expect_near("slope", false, v[count - 1].direction[2], z, 1e-5);
    free(v);
    mcv_scene_free(scene);
}

/* --- images
 * -----------------------------------------------------------------------------------------------------
 */

/*
 * A furnace: lossless glass in an environment of radiance 1 is not to be seen, with every schedule
 * and in the reference. No throughput is lost, so each path's value is 1 up to the rounding of L/n²
 * (once per interface).
 */
static void furnace(void **state) {
    (void)state;
    for (int kind = 0; kind < KINDS; ++kind) {
        uint32_t glass;
        mcv_scene *scene = many_lenses(kind, &glass);
        mcv_sensor sensor = {.name = (char *)"camera",
                             .type = MCV_SENSOR_PINHOLE,
                             .to_world = looking_down_z(0.01, -0.02, 0.15)};
        mcv_emitter sky = {.name = (char *)"sky",
                           .type = MCV_EMITTER_ENVIRONMENT,
                           .instance = MCV_NONE,
                           .texture = MCV_NONE};
        mcv_params_set_defaults(mcv_sensor_table(sensor.type), &sensor.as);
        mcv_params_set_defaults(mcv_emitter_table(sky.type), &sky.as);
        sensor.as.pinhole.imageDistance = 0.01;
        sensor.as.pinhole.resolution[0] = sensor.as.pinhole.resolution[1] = 16;
        sensor.as.pinhole.pixelSize[0] = sensor.as.pinhole.pixelSize[1] = 0.3e-3;
        for (int k = 0; k < 3; ++k) sky.as.environment.radiance[k] = 1;
        BUILD(mcv_scene_add_emitter(scene, &sky, &builder_error));
        BUILD(mcv_scene_add_sensor(scene, &sensor, &builder_error));
        for (int renderer = 0; renderer < 3; ++renderer) {
            mcv_render_options options = mcv_render_defaults();
            mcv_render_stats stats;
            mcv_film film;
            mcv_image mean;
            options.last = 4;
            options.depth = 400;
            options.schedule = renderer == 1 ? MCV_SCHEDULE_STREAM : MCV_SCHEDULE_TILE;
            if (renderer == 2)
                BUILD(mcv_reference_render(scene, 0, &options, &film, &stats, &builder_error));
            else
                BUILD(mcv_render(scene, 0, &options, &film, &stats, &builder_error));
            const double tolerance = 1e-4;
            BUILD(mcv_film_develop(&film, &mean, NULL, &builder_error));
            for (uint32_t pixel = 0; pixel < 256; ++pixel) {
                const double value = mean.pixels[pixel];
                note_truth("T15 furnace: pixels behind exact lenses of all kinds",
                           name_of(renderer == 2), fabs(value - 1), tolerance);
                if (!(fabs(value - 1) <= tolerance))
                    fail_msg("kind %d, renderer %d, pixel %u: %.8g, not 1", kind, renderer, pixel,
                             value);
            }
            if (stats.unmatched > 0 || stats.nonfinite > 0)
                fail_msg("kind %d, renderer %d: %llu unmatched, %llu not finite", kind, renderer,
                         (unsigned long long)stats.unmatched, (unsigned long long)stats.nonfinite);
            mcv_image_free(&mean);
            mcv_film_free(&film);
        }
        mcv_scene_free(scene);
    }
}

/* --- bodies in contact
 * ------------------------------------------------------------------------------------------ */

/*
 * Three slabs of glass, their faces in the same places but cut into other triangles: a ray goes
 * from the one into the next, with no gap of air between, and through all of them as through plates
 * in contact.
 */
static void meshes_in_contact(void **state) {
    (void)state;
    enum { RAYS = 2000 };
    static const double index[] = {1.5, 1.8, 1.3};
    mcv_scene *scene = new_scene();
    for (int i = 0; i < 3; ++i)
        add_slab(scene, 3 + 2 * i, 0.002 * i, 0.002 * (i + 1), add_glass(scene, index[i], 0, 0));
    mcv_trace_ray *rays = calloc(RAYS, sizeof *rays);
    uint64_t seed = 5;
    for (int i = 0; i < RAYS; ++i) {
        /* From above or below into the middle, not to be reflected totally nor to leave by the
         * sides. */
        const double side = i % 2 ? 1 : -1, z = i % 2 ? -0.01 : 0.016;
        const double from[3] = {0.004 * (uniform(&seed) - 0.5), 0.004 * (uniform(&seed) - 0.5), z};
        const double along[3] = {0.6 * (uniform(&seed) - 0.5), 0.6 * (uniform(&seed) - 0.5), side};
        mcv_transform_point(&scene->instances[0].to_world, from, rays[i].origin);
        mcv_transform_vector(&scene->instances[0].to_world, along, rays[i].direction);
        for (int k = 0; k < 3; ++k) rays[i].origin[k] = (float)rays[i].origin[k];
    }
    for (int reference = 0; reference < 2; ++reference) {
        const traced t = follow(scene, reference, rays, RAYS);
        size_t v = 0;
        for (uint32_t i = 0; i < RAYS; ++i) {
            for (int k = 0; k < 6; ++k, ++v) {
                const double expected = k < 1 || k > 3 ? 1 : index[i % 2 ? k - 1 : 3 - k];
                if (v >= t.count || t.vertices[v].ray != i)
                    fail_msg("%s: ray %u has %d vertices, not 6", name_of(reference), i, k);
                if (fabs(t.vertices[v].ior - expected) > 1e-6)
                    fail_msg("%s: ray %u, vertex %d: n = %g, not %g", name_of(reference), i, k,
                             t.vertices[v].ior, expected);
            }
        }
        assert_int_equal(v, t.count);
        free(t.vertices);
    }
    free(rays);
    mcv_scene_free(scene);
}

/* A cemented doublet: light goes from glass to glass. */
static void cemented(void **state) {
    (void)state;
    enum { RAYS = 500 };
    mcv_scene *scene = new_scene();
    const mcv_cap between = {.z = 0.006, .curvature = -1 / 0.03};
    mcv_solid first = element(0.01, (mcv_cap){.curvature = 1 / 0.04}, between),
              second = element(0.01, between, (mcv_cap){.z = 0.009});
    second.cemented = true;
    first.to_world = second.to_world =
        (mcv_transform){{0.8, 0, 0.6, 0, 1, 0, -0.6, 0, 0.8, 0.1, -0.05, 0.02}};
    const uint32_t rim = add_absorber(scene);
    add_solid(scene, &first, add_glass(scene, 1.5, 0, 0), rim);
    add_solid(scene, &second, add_glass(scene, 1.7, 0, 0), rim);
    mcv_trace_ray rays[RAYS];
    uint64_t seed = 5;
    for (int i = 0; i < RAYS; ++i) {
        const double side = i % 2 ? 1 : -1, angle = 2 * M_PI * uniform(&seed),
                     r = 0.009 * sqrt(uniform(&seed));
        const double from[3] = {r * cos(angle), r * sin(angle), i % 2 ? -0.05 : 0.05};
        mcv_transform_point(&first.to_world, from, rays[i].origin);
        mcv_transform_vector(&first.to_world, (const double[3]){0, 0, side}, rays[i].direction);
        for (int k = 0; k < 3; ++k) rays[i].origin[k] = (float)rays[i].origin[k];
    }
    for (int reference = 0; reference < 2; ++reference) {
        const traced t = follow(scene, reference, rays, RAYS);
        const double up[] = {1, 1.5, 1.7, 1, 1}, down[] = {1, 1.7, 1.5, 1, 1};
        assert_int_equal(t.count, 5 * RAYS);
        for (size_t v = 0; v < t.count; ++v) {
            const double expected = t.vertices[v].ray % 2 ? up[v % 5] : down[v % 5];
            if (fabs(t.vertices[v].ior - expected) > 1e-6)
                fail_msg("%s: ray %u, vertex %zu: n = %g, not %g", name_of(reference),
                         t.vertices[v].ray, v % 5, t.vertices[v].ior, expected);
        }
        free(t.vertices);
    }
    mcv_scene_free(scene);
}

/* Sixteen balls in one another, each of another glass: the ray meets them in turn; it may begin in
 * the innermost. */
static void nested(void **state) {
    (void)state;
    enum { BALLS = 16 };
    mcv_scene *scene = new_scene();
    for (int i = 0; i < BALLS; ++i) {
        const mcv_solid ball = sphere(0.02 - 0.001 * i);
        const uint32_t glass = add_glass(scene, 1.3 + 0.02 * i, 0, i);
        add_solid(scene, &ball, glass, glass);
    }
    for (int reference = 0; reference < 2; ++reference) {
        mcv_vertex v[DEPTH + 1];
        assert_int_equal(trace_one(scene, reference, along_z(0.001, 0, -0.1), v), 2 * BALLS + 1);
        for (int k = 0; k <= 2 * BALLS; ++k) {
            const int depth = k <= BALLS ? k : 2 * BALLS - k;
            expect_near("index", reference, v[k].ior, depth ? 1.3 + 0.02 * (depth - 1) : 1, 1e-6);
        }
        assert_int_equal(trace_one(scene, reference, along_z(0.001, 0, 0), v), BALLS + 1);
        for (int k = 0; k <= BALLS; ++k)
            expect_near("index", reference, v[k].ior, k < BALLS ? 1.3 + 0.02 * (BALLS - 1 - k) : 1,
                        1e-6);
    }
    mcv_scene_free(scene);
}

/* --- scene files
 * ------------------------------------------------------------------------------------------------
 */

/* A scene whose one node places the definition. */
static mcv_result load_definition(const char *definition, mcv_scene **scene) {
    const char *path = "test_surfaces.gltf";
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    fprintf(file,
            "{\"asset\": {\"version\": \"2.0\"}, \"scene\": 0, \"scenes\": [{\"nodes\": [0]}], "
            "\"extensionsUsed\": [\"MCVISI_surfaces\", "
            "\"MCVISI_materials\"], \"materials\": [{\"name\": \"glass\", \"extensions\": "
            "{\"MCVISI_materials\": {\"type\": \"dielectric\", "
            "\"glass\": \"N-BK7\"}}}, {\"name\": \"pane\", \"extensions\": {\"MCVISI_materials\": "
            "{\"type\": \"sheet\"}}}], \"extensions\": "
            "{\"MCVISI_surfaces\": {\"surfaces\": [%s]}}, \"nodes\": [{\"extensions\": "
            "{\"MCVISI_surfaces\": {\"surface\": 0}}}]}",
            definition);
    assert_int_equal(fclose(file), 0);
    const mcv_result result = mcv_scene_load(path, (mcv_overrides){NULL, 0}, scene, &builder_error);
    remove(path);
    return result;
}

static void definitions(void **state) {
    (void)state;
    mcv_scene *scene;
    BUILD(load_definition("{\"type\": \"lens\", \"surfaces\": [{\"radius\": \"50mm\", "
                          "\"semiDiameter\": \"12mm\", \"thickness\": \"5mm\", "
                          "\"material\": \"glass\"}, {\"curvature\": -20, \"conic\": -1, "
                          "\"asphere\": [1e3], \"semiDiameter\": 0.011}]}",
                          &scene));
    assert_int_equal(scene->solid_count, 1);
    assert_int_equal(scene->triangle_count, 0);
    expect_near("radius", true, scene->solids[0].radius, 0.012, 0);
    expect_near("curvature", true, scene->solids[0].caps[1].curvature, -20, 0);
    assert_true(scene->materials[scene->instances[scene->solids[0].instances[2]].material].type ==
                MCV_MATERIAL_ABSORBER);
    mcv_scene_free(scene);
    static const struct {
        const char *definition, *word;
    } bad[] = {
        {"{\"type\": \"lense\"}", "did you mean \"lens\""},
        {"{\"type\": \"sphere\"}", "radius: is missing"},
        {"{\"type\": \"sphere\", \"radius\": -1}", "above 0"},
        {"{\"type\": \"box\", \"width\": 1, \"heigth\": 1, \"depth\": 1}",
         "did you mean \"height\""},
        {"{\"type\": \"disc\", \"radius\": 1, \"holeRadius\": 2}", "must be smaller"},
        {"{\"type\": \"disc\", \"radius\": 1, \"material\": \"glass\"}", "has no inside"},
        {"{\"type\": \"sphere\", \"radius\": 1, \"material\": \"glas\"}", "no material \"glas\""},
        {"{\"type\": \"lens\", \"surfaces\": [{\"semiDiameter\": 1}]}", "2 to"},
        {"{\"type\": \"lens\", \"surfaces\": [{\"semiDiameter\": 1}, {\"semiDiameter\": 1}]}",
         "no surface has a material"},
        {"{\"type\": \"lens\", \"surfaces\": [{\"semiDiameter\": 1}, {\"semiDiameter\": 1, "
         "\"material\": 0}]}",
         "another surface behind"},
        {"{\"type\": \"lens\", \"surfaces\": [{\"radius\": 1, \"semiDiameter\": 2, \"thickness\": "
         "9, \"material\": 0}, {\"semiDiameter\": "
         "1}]}",
         "lies beyond the surface"},
        {"{\"type\": \"lens\", \"surfaces\": [{\"radius\": 2, \"semiDiameter\": 1, \"thickness\": "
         "0.1, \"material\": 0}, "
         "{\"semiDiameter\": 1}]}",
         "surfaces intersect"},
        {"{\"type\": \"lens\", \"surfaces\": [{\"radius\": 2, \"curvature\": 3, \"semiDiameter\": "
         "1, \"material\": 0}, {\"semiDiameter\": "
         "1}]}",
         "contradicts"},
        {"{\"type\": \"lens\", \"surfaces\": [{\"radius\": 0, \"semiDiameter\": 1, \"material\": "
         "0}, {\"semiDiameter\": 1}]}",
         "must not be 0"},
        {"{\"type\": \"lens\", \"surfaces\": [{\"asphere\": [1, 2, 3, 4, 5, 6, 7, 8, 9], "
         "\"semiDiameter\": 1}, {\"semiDiameter\": 1}]}",
         "at most 8"},
        {"{\"type\": \"lens\", \"surfaces\": [{\"semiDiameter\": 1, \"thickness\": 1, "
         "\"material\": 0}, {\"semiDiameter\": 1}], \"rim\": "
         "\"pane\"}",
         "the rim \"pane\" transmits light, but is not the body's material: choose an opaque "
         "one or \"glass\""},
    };
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; ++i) {
        const mcv_result result = load_definition(bad[i].definition, &scene);
        if (result != MCV_BAD_INPUT || !strstr(builder_error.text, bad[i].word) ||
            !strstr(builder_error.text, "test_surfaces.gltf"))
            fail_msg("%s: \"%s\" should say \"%s\"", bad[i].definition,
                     result == MCV_OK ? "" : builder_error.text, bad[i].word);
    }
}

/* Made by hand they fail as from a file: a rim that lets light through, a sensor's frame that is no
 * rotation. */
static void made_by_hand(void **state) {
    (void)state;
    mcv_scene *scene = new_scene();
    const uint32_t glass = add_glass(scene, 1.5, 0, 0), other = add_glass(scene, 1.7, 0, 0);
    const mcv_solid lens = element(0.01, (mcv_cap){.curvature = 1 / 0.04}, (mcv_cap){.z = 0.006});
    mcv_error error = {""};
    assert_int_equal(mcv_scene_add_solid(scene, &lens, "lens", glass, other, &error),
                     MCV_BAD_INPUT);
    if (!strstr(error.text, "lens: the rim")) fail_msg("%s", error.text);
    mcv_sensor sensor = sensor_defaults(MCV_SENSOR_PINHOLE);
    static const mcv_transform wrong[] = {{{1, 0.1, 0, 0, 1, 0, 0, 0, 1}},
                                          {{2, 0, 0, 0, 2, 0, 0, 0, 2}},
                                          {{1, 0, 0, 0, 1, 0, 0, 0, -1}},
                                          {{0}}};
    sensor.name = (char *)"cam";
    sensor.as.pinhole.imageDistance = 0.01;
    sensor.as.pinhole.resolution[0] = sensor.as.pinhole.resolution[1] = 8;
    sensor.as.pinhole.pixelSize[0] = sensor.as.pinhole.pixelSize[1] = 1e-5;
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; ++i) {
        sensor.to_world = wrong[i];
        assert_int_equal(mcv_scene_add_sensor(scene, &sensor, &error), MCV_BAD_INPUT);
        if (!strstr(error.text, "cam: its frame must be")) fail_msg("%s", error.text);
    }
    mcv_scene_free(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(plate),
        cmocka_unit_test(single_sphere),
        cmocka_unit_test(ball_lens),
        cmocka_unit_test(aplanatic),
        cmocka_unit_test(conics_focus),
        cmocka_unit_test(mirrors),
        cmocka_unit_test(ellipsoid_mirror),
        cmocka_unit_test(double_gauss),
        cmocka_unit_test(cemented_once),
        cmocka_unit_test(against_reference),
        cmocka_unit_test(mixed_against_reference),
        cmocka_unit_test(radii),
        cmocka_unit_test(reflections),
        cmocka_unit_test(furnace),
        cmocka_unit_test(meshes_in_contact),
        cmocka_unit_test(cemented),
        cmocka_unit_test(nested),
        cmocka_unit_test(definitions),
        cmocka_unit_test(made_by_hand),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
