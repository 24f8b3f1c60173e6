/* SPDX-License-Identifier: Apache-2.0 */
/* ctest: label truth */
/* ctest: timeout 600 */
/* Closed forms that the device and the reference must both meet, beside those of test_surfaces.c
 * and test_reference_*.c. */
#include "reference_checks.h"

#include "mcvisi/surfaces/solid.h"
#include "reference/random.h"
#include "render/render.h"
#include "loader/load.h"

/* Which of the tests run: no file of them shall take long. */
#ifndef LOSSLESS
#define LOSSLESS 0
#endif
#ifndef SLOW
#define SLOW 0
#endif

static const mcv_transform unmoved = {{1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0}};

/* Vertices of some rays by one of the renderers; the caller frees them. */
static mcv_vertex *trace_by(bool reference, const mcv_scene *scene, const mcv_trace_ray *rays,
                            size_t n, uint32_t depth, size_t *count) {
    mcv_render_options options = mcv_render_defaults();
    mcv_vertex *vertices = NULL;
    options.depth = depth;
    checked = reference ? "reference" : "device";
    BUILD((reference ? mcv_reference_trace : mcv_trace)(scene, rays, n, &options, &vertices, count,
                                                        &builder_error));
    return vertices;
}

static mcv_estimate mean_by(bool reference, const mcv_scene *scene, uint32_t samples,
                            uint32_t depth) {
    mcv_render_stats stats;
    checked = reference ? "reference" : "device";
    return reference ? render_mean(scene, samples, depth, true, &stats)
                     : device_mean(scene, samples, depth, &stats);
}

static void add_solid(mcv_scene *scene, mcv_solid solid, uint32_t material) {
    solid.to_world = unmoved;
    BUILD(mcv_scene_add_solid(scene, &solid, "solid", material, material, &builder_error));
}

static double axis_crossing(const mcv_vertex *v) {
    const double *p = v->position, *d = v->direction;
    return p[2] - d[2] * (p[0] * d[0] + p[1] * d[1]) / (d[0] * d[0] + d[1] * d[1]);
}

/*
 * T9. Where a ray at height h crosses the axis behind a thick lens, against the exact rays'
 * recursion: and for h -> 0 the back focal distance. Heights of 0.1 to 0.3 R; the paraxial limit by
 * h = 1e-3 R, whose aberration is below h²/R² = 1e-6 of f, in double.
 */
static void test_thick_lens(void **state) {
    const double r1 = 0.05, r2 = -0.07, thickness = 0.008, n = 1.5;
    const double f = 1 / ((n - 1) * (1 / r1 - 1 / r2 + (n - 1) * thickness / (n * r1 * r2)));
    const double back = f * (1 - (n - 1) * thickness / (n * r1));
    mcv_scene *scene = mcv_scene_new("thick lens");
    (void)state;
    add_solid(scene,
              (mcv_solid){.side = MCV_SIDE_CYLINDER,
                          .radius = 0.018,
                          .caps = {{.curvature = 1 / r1}, {.z = thickness, .curvature = 1 / r2}}},
              add_glass(scene, n, 0, 0));
    for (int reference = 0; reference < 2; ++reference)
        for (double share = 0.001; share < 0.35; share = share < 0.01 ? 0.1 : share + 0.05) {
            /* The exact ray in double: refraction angles at both spheres. */
            const double height = share * r1, i = asin(height / r1),
                         turned = i - asin(height / r1 / n);
            const double z = r1 - r1 * cos(i),
                         x_axis = z + height / tan(turned); /* crossing behind the first surface */
            const double centre = thickness + r2, p = (x_axis - centre) * sin(turned) /
                                                      -r2; /* sine of the incidence at the second */
            const double inside = asin(p), outside = asin(n * p),
                         slope = turned + (outside - inside);
            const double crossing = centre + -r2 * p * n / sin(slope);
            const mcv_trace_ray ray = {{height, 0, -0.02}, {0, 0, 1}};
            size_t count;
            mcv_vertex *v = trace_by(reference, scene, &ray, 1, 8, &count);
            assert_int_equal(count, 4);
            /* A direction off by some 8 u moves the crossing by that times f over the slope; 1e-5
             * are asked for from 0.1 R on. */
            if (share > 0.01)
                check("T9 thick exact lens: crossing over f", axis_crossing(&v[2]) / f,
                      crossing / f, reference ? 1e-12 : 1e-5);
            if (share < 0.01 && reference)
                check("T9 thick exact lens: back focal distance over f",
                      (axis_crossing(&v[2]) - thickness) / f, back / f, 2e-6);
            free(v);
        }
    mcv_scene_free(scene);
}

/*
 * The report's lens, a mesh with interpolated normals: where rays of 0.1 to 0.3 of its
 * semi-diameter and more cross the axis, against exact spheres of its radii. They come from the
 * side of the panel, along -z.
 */
static void test_report_lens(void **state) {
    const double r = 0.31, thickness = 0.006, n = 1.5168, middle = -0.301022;
    char path[512];
    mcv_scene *scenes[2];
    (void)state;
    snprintf(path, sizeof path, "%s/scenes/report-clean.glb", MCV_SOURCE_DIR);
    BUILD(mcv_scene_load(path, (mcv_overrides){NULL, 0}, &scenes[0], &builder_error));
    scenes[1] = mcv_scene_new("exact");
    mcv_solid lens = {.side = MCV_SIDE_CYLINDER,
                      .radius = 0.014,
                      .caps = {{.z = -thickness / 2, .curvature = 1 / r},
                               {.z = thickness / 2, .curvature = -1 / r}},
                      .to_world = {{1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, middle}}};
    const uint32_t glass = add_glass(scenes[1], n, 0, 0);
    BUILD(mcv_scene_add_solid(scenes[1], &lens, "lens", glass, glass, &builder_error));
    for (int device = 0; device < 2; ++device)
        for (int i = 0; i < 12; ++i) {
            const double h = 0.0014 + 0.0009 * i, around = 0.3 + 2.4 * i;
            const mcv_trace_ray ray = {{h * cos(around), h * sin(around), middle + 0.01},
                                       {0, 0, -1}};
            double crossings[2];
            for (int k = 0; k < 2; ++k) {
                size_t count;
                mcv_vertex *v = trace_by(k == 1 || device == 0, scenes[k], &ray, 1, 2, &count);
                assert_true(count >= 3 && v[2].event == MCV_EVENT_REFRACT);
                crossings[k] = axis_crossing(&v[2]) - middle;
                free(v);
            }
            checked = device ? "device" : "reference";
            check("T10 the report's lens, a mesh: crossing over the exact one's",
                  crossings[0] / crossings[1], 1, 1e-3);
        }
    mcv_scene_free(scenes[0]);
    mcv_scene_free(scenes[1]);
}

/* T10: 1 where facets are flat, 2 where normals are interpolated, and an exact surface has no error
 * to fall. */
static void test_mesh_convergence(void **state) {
    enum { RAYS = 2000, LEVELS = 4 };
    static mcv_trace_ray rays[RAYS];
    ref_random random = {7};
    (void)state;
    for (int i = 0; i < RAYS; ++i) {
        const double h = 0.1 + 0.2 * ref_random_unit(&random),
                     around = 2 * M_PI * ref_random_unit(&random);
        rays[i] = (mcv_trace_ray){{h * cos(around), h * sin(around), -3}, {0, 0, 1}};
    }
    for (int reference = 0; reference < 2; ++reference)
        for (int kind = 0; kind < 3; ++kind) {
            static const char *const names[] = {"flat", "interpolated", "exact"};
            double xy = 0, xx = 0, worst = 0;
            for (int level = 0; level < LEVELS; ++level) {
                const uint32_t rings = 32u << level;
                mcv_scene *scene = mcv_scene_new("sphere");
                const uint32_t glass = add_glass(scene, 1.5, 0, 0);
                double error = 0;
                size_t count;
                char series[64];
                if (kind == 2) {
                    add_solid(scene, (mcv_solid){.side = MCV_SIDE_SPHERE, .radius = 1}, glass);
                } else {
                    mcv_scene *parts = mcv_scene_new("parts");
                    add_sphere(parts, 1, rings, add_glass(parts, 1.5, 0, 0), unmoved);
                    mcv_mesh mesh = parts->meshes[0];
                    if (kind == 0) mesh.normals = NULL;
                    /* Its poles lie beside, so that facets are about square where the rays meet
                     * them. */
                    add_instance(scene, &mesh, glass,
                                 (mcv_transform){{0, 0, -1, 0, 1, 0, 1, 0, 0, 0, 0, 0}});
                    mcv_scene_free(parts);
                }
                mcv_vertex *v = trace_by(reference, scene, rays, RAYS, 1, &count);
                assert_int_equal(count, 2 * RAYS);
                for (int i = 0; i < RAYS; ++i) {
                    const double h = hypot(rays[i].origin[0], rays[i].origin[1]),
                                 crossing = h / 1.5 / sin(asin(h) - asin(h / 1.5));
                    const double off = fabs(axis_crossing(&v[2 * i + 1]) - crossing);
                    error += off / RAYS;
                    worst = worse(worst, off / crossing);
                }
                free(v);
                mcv_scene_free(scene);
                snprintf(series, sizeof series, "%s, %s", checked, names[kind]);
                note_point("Error of a sphere's focus over rings of its mesh", series, rings,
                           error);
                const double x = (level - 0.5 * (LEVELS - 1)) * log(2);
                xy += x * log(error);
                xx += x * x;
            }
            if (kind == 0) check("T10 error over mesh fineness, flat: - slope", -xy / xx, 1, 0.1);
            if (kind == 1)
                check("T10 error over mesh fineness, interpolated: - slope", -xy / xx, 2, 0.2);
            /* Against the exact ray at the same height, 0.1 to 0.3 R. */
            if (kind == 2)
                check("T10 exact sphere: worst crossing", 1 + worst, 1, reference ? 1e-13 : 1e-5);
        }
}

/*
 * T17: a sphere of radiance L gives π L (r/d)² cosθ. The mesh's faces lie between `least` and 1
 * from its centre, so that its outline does. A receiver of albedo 0.6 seen by one narrow pixel.
 */
static void test_sphere_light(void **state) {
    const double r = 0.3, height = 1, aside = 0.5, d2 = height * height + aside * aside;
    enum { RINGS = 128 };
    mcv_scene *scene = mcv_scene_new("sphere light");
    (void)state;
    add_rectangle(scene, 8, 8, add_diffuse(scene, 0.6), looking_up_z(0, 0, 0));
    add_emitter(scene, MCV_EMITTER_AREA,
                add_sphere(scene, r, RINGS, add_absorber(scene), looking_down_z(aside, 0, height)),
                3, 0);
    add_spot_camera(scene, (const double[3]){0, -2, 0.5}, (const double[3]){0, 0, 0}, 2e-5);
    const double truth = 0.6 * 3 * r * r / d2 * height / sqrt(d2),
                 least = 1 - pow(M_PI / RINGS, 2) / 4;
    for (int reference = 0; reference < 2; ++reference)
        check_mean("T17 sphere light", mean_by(reference, scene, 8192, 8), truth,
                   (1 - least * least) * truth + 1e-6 * truth);
    mcv_scene_free(scene);
}

/*
 * T19, T20 in a closed diffuse sphere of radius 1, of a mesh whose area is known: what is inside,
 * of flux Φ, makes the mean radiance of all light that has been scattered ρ Φ/(π A (1 - ρ)). A
 * point light in the middle, and a parallel emitter so small that it hides nothing: of its light
 * the wall beside, which it does not light, sees all but the first bounce.
 */
static void test_integrating_sphere(void **state) {
    enum { RINGS = 96 };
    const double rho = 0.7, side = 0.004, beta = 0.9;
    (void)state;
    for (int parallel = 0; parallel < 2; ++parallel) {
        mcv_scene *parts = mcv_scene_new("parts"), *scene = mcv_scene_new("integrating sphere");
        add_sphere(parts, 1, RINGS, add_absorber(parts), unmoved);
        add_inside_out(scene, &parts->meshes[0], add_diffuse(scene, rho));
        double flux = 4 * M_PI;
        if (parallel) {
            flux = M_PI * pow(sin(beta), 2) * side * side * 1e6;
            add_emitter(
                scene, MCV_EMITTER_PARALLEL,
                add_rectangle(scene, side, side, add_absorber(scene), looking_down_z(0, 0, 0)), 1e6,
                beta);
        } else {
            mcv_emitter point = {.name = (char *)"point",
                                 .type = MCV_EMITTER_POINT,
                                 .instance = MCV_NONE,
                                 .texture = MCV_NONE};
            mcv_params_set_defaults(mcv_emitter_table(point.type), &point.as);
            for (int k = 0; k < 3; ++k) point.as.point.intensity[k] = 1;
            point.to_world = unmoved;
            BUILD(mcv_scene_add_emitter(scene, &point, &builder_error));
        }
        add_spot_camera(scene, (const double[3]){0, 0.3, 0.1}, (const double[3]){0, 0.4, 0.8}, 0.2);
        const double truth = (parallel ? rho : 1) * rho * flux / (M_PI * 4 * M_PI * (1 - rho));
        /*
         * The mesh is a ball whose faces lie up to (π/96)²/4 nearer: its area, and the distance of
         * the light, are off by twice that; it is no perfect integrating sphere by as much once
         * more.
         */
        const double slack = 6 * pow(M_PI / RINGS, 2) / 4 * truth;
        for (int reference = 0; reference < 2; ++reference)
            check_mean(parallel ? "T20 power of a parallel emitter, all caught"
                                : "T19 point light in a diffuse sphere",
                       mean_by(reference, scene,
                               reference ? 2048
                               : SLOW    ? 65536
                                         : 16384,
                               100),
                       truth, slack);
        mcv_scene_free(parts);
        mcv_scene_free(scene);
    }
}

/* T20: twice the light is twice the image to the bit, and two lights together are the sum of both
 * within their noise. */
static void test_power_is_linear(void **state) {
    mcv_film films[2];
    mcv_estimate parts[3];
    (void)state;
    for (int i = 0; i < 5; ++i) {
        mcv_scene *scene = mcv_scene_new("linear");
        mcv_render_options options = mcv_render_defaults();
        mcv_render_stats stats;
        const double factor = i == 4 ? 0x1p30 : 1;
        add_rectangle(scene, 2, 2, add_diffuse(scene, 0.6), looking_up_z(0, 0, 0));
        add_sphere(scene, 0.3, 16, add_glass(scene, 1.5, 1, 0), looking_down_z(0, 0, 0.4));
        if (i != 1)
            add_emitter(
                scene, MCV_EMITTER_AREA,
                add_rectangle(scene, 0.5, 0.5, add_absorber(scene), looking_down_z(0.4, 0, 1)),
                2 * factor, 0);
        if (i != 0)
            add_emitter(
                scene, MCV_EMITTER_PARALLEL,
                add_rectangle(scene, 0.5, 0.5, add_absorber(scene), looking_down_z(-0.4, 0, 1)),
                5 * factor, 0.3);
        /* What does not shine is there all the same. */
        if (i == 1) add_rectangle(scene, 0.5, 0.5, add_absorber(scene), looking_down_z(0.4, 0, 1));
        if (i == 0) add_rectangle(scene, 0.5, 0.5, add_absorber(scene), looking_down_z(-0.4, 0, 1));
        add_pinhole(scene, 16, 1,
                    looking((const double[3]){0, -2, 0.6}, (const double[3]){0, 1, 0},
                            (const double[3]){0, 0, 1}));
        options.replicates = REPLICATES;
        options.last = 64;
        options.seed = i < 3 ? (uint32_t)i : 9;
        options.no_light_paths = true;
        mcv_film film;
        BUILD(mcv_render(scene, 0, &options, &film, &stats, &builder_error));
        if (i < 3) parts[i] = film_estimate(&film, 0, (size_t)film.width * film.height);
        if (i >= 3)
            films[i - 3] = film;
        else
            mcv_film_free(&film);
        mcv_scene_free(scene);
    }
    double worst = 0;
    for (size_t i = 0; i < (size_t)16 * 16 * REPLICATES; ++i)
        worst = worse(worst, fabs(films[0].sums[i] * 0x1p30 - films[1].sums[i]));
    checked = "device";
    check("T20 2^30 times the power: bits", worst, 0, 0);
    const mcv_estimate sum = {parts[2].mean - parts[0].mean - parts[1].mean,
                              parts[0].variance + parts[1].variance + parts[2].variance, 15};
    const double bound = student_two_sided_quantile(LEVEL, 15) * sqrt(sum.variance);
    check("T20 two lights are the sum of both", sum.mean, 0, bound);
    mcv_film_free(&films[0]);
    mcv_film_free(&films[1]);
}

/*
 * T20: light of a cone through a plate of glass onto a diffuse floor, where none is sampled from
 * camera paths: traced forward, from the light, by the device, and backward, found by chance, by
 * both renderers. Both means have noise; their difference has none beyond it.
 */
static void test_forward_and_backward(void **state) {
    mcv_scene *scene = mcv_scene_new("forward and backward");
    mcv_estimate means[3]; /* forward, backward on the device, backward by the reference */
    (void)state;
    add_rectangle(scene, 2, 2, add_diffuse(scene, 0.6), looking_up_z(0, 0, 0));
    add_box(scene, (const double[3]){0.8, 0.8, 0.02}, add_glass(scene, 1.5, 0, 0),
            looking_up_z(0, 0, 0.2));
    add_emitter(scene, MCV_EMITTER_PARALLEL,
                add_rectangle(scene, 0.4, 0.4, add_absorber(scene), looking_down_z(0, 0, 0.3)), 5,
                0.4);
    add_pinhole(scene, 8, 0.5,
                looking((const double[3]){0, -0.4, 0.1}, (const double[3]){0, 0.96, -0.28},
                        (const double[3]){0, 0.28, 0.96}));
    for (int i = 0; i < 3; ++i) {
        mcv_render_options options = mcv_render_defaults();
        mcv_render_stats stats = {0};
        mcv_film film = {0};
        options.replicates = REPLICATES;
        options.last = 2048;
        options.depth = 16;
        options.seed = (uint32_t)i + 1;
        options.no_light_paths = i > 0;
        BUILD((i == 2 ? mcv_reference_render : mcv_render)(scene, 0, &options, &film, &stats,
                                                           &builder_error));
        if (i == 0) assert_non_null(strstr(stats.features, "light-tracing"));
        means[i] = image_estimate(&film);
        print_message("  %d: %.7g, standard error %.2g of it\n", i, means[i].mean,
                      sqrt(means[i].variance) / means[i].mean);
        mcv_film_free(&film);
    }
    for (int i = 1; i < 3; ++i) {
        const double mean = means[0].mean,
                     error = sqrt(means[0].variance + means[i].variance) / mean;
        checked = i == 2 ? "reference" : "device";
        assert_true(error < 0.005);
        check("T20 forward light paths over backward camera paths", means[i].mean / mean, 1,
              student_two_sided_quantile(LEVEL, REPLICATES - 1) * error);
    }
    mcv_scene_free(scene);
}

/*
 * T15 for every smooth material that can be without loss: a ball of it in a uniform furnace, seen
 * from outside, is as bright as that, the energy of paths that the depth cuts added back.
 */
static void test_lossless_materials(void **state) {
#define GREY(x) \
    { (x), (x), (x) }
    static const struct {
        const char *what;
        uint32_t type;
        mcv_material material;
    } kinds[] = {
        {"glass", MCV_MATERIAL_DIELECTRIC, {.as.dielectric = {.ior = GREY(1.5)}}},
        {"diamond", MCV_MATERIAL_DIELECTRIC, {.as.dielectric = {.ior = GREY(2.4)}}},
        {"coated glass",
         MCV_MATERIAL_DIELECTRIC,
         {.as.dielectric = {.ior = GREY(1.5), .coating = 0.005}}},
        {"sheet", MCV_MATERIAL_SHEET, {.as.sheet = {.ior = 1.5, .transmittance = GREY(1)}}},
        {"mirror", MCV_MATERIAL_MIRROR, {.as.mirror = {.reflectance = GREY(1)}}},
        {"beam splitter",
         MCV_MATERIAL_BEAM_SPLITTER,
         {.as.beam_splitter = {.reflectance = GREY(0.3), .transmittance = GREY(0.7)}}},
        {"metal of no real index",
         MCV_MATERIAL_CONDUCTOR,
         {.as.conductor = {.n = GREY(0), .k = GREY(3)}}},
        {"retroreflector",
         MCV_MATERIAL_RETROREFLECTOR,
         {.as.retroreflector = {.reflectance = GREY(1), .entranceAngle = M_PI / 2}}},
    };
    (void)state;
    for (size_t k = 0; k < sizeof kinds / sizeof kinds[0]; ++k) {
        mcv_scene *scene = mcv_scene_new("lossless");
        add_environment(scene, 1);
        add_sphere(scene, 1, 24, add_material(scene, kinds[k].type, &kinds[k].material),
                   mcv_transform_identity());
        add_pinhole(scene, 16, 0.6, looking_down_z(0, 0, 3));
        /* One program for all: patches of 0.1 mm, which one ray of 10^9 meets. */
        for (size_t i = 0; i < sizeof kinds / sizeof kinds[0]; ++i)
            add_rectangle(scene, 1e-4, 1e-4, add_material(scene, kinds[i].type, &kinds[i].material),
                          looking_down_z(2, 0.1 * (double)i, 0));
        for (int reference = 0; reference < 2; ++reference) {
            char what[64];
            mcv_render_stats stats;
            snprintf(what, sizeof what, "T15 furnace: ball of %s, mean + lost", kinds[k].what);
            checked = reference ? "reference" : "device";
            const mcv_estimate mean = reference ? render_mean(scene, 64, 100, true, &stats)
                                                : device_mean(scene, 64, 100, &stats);
            check(what, mean.mean + stats.lost_energy, 1, 1e-4);
        }
        mcv_scene_free(scene);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_thick_lens),
        cmocka_unit_test(test_report_lens),
        cmocka_unit_test(test_sphere_light),
        cmocka_unit_test(test_integrating_sphere),
    };
    const struct CMUnitTest lossless[] = {cmocka_unit_test(test_lossless_materials),
                                          cmocka_unit_test(test_mesh_convergence)};
    const struct CMUnitTest long_tests[] = {cmocka_unit_test(test_power_is_linear),
                                            cmocka_unit_test(test_forward_and_backward),
                                            cmocka_unit_test(test_integrating_sphere)};
    if (LOSSLESS) return cmocka_run_group_tests(lossless, NULL, NULL);
    return SLOW ? cmocka_run_group_tests(long_tests, NULL, NULL)
                : cmocka_run_group_tests(tests, NULL, NULL);
}
