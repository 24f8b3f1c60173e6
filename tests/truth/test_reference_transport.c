/* SPDX-License-Identifier: Apache-2.0 */
/* ctest: label truth */
/* The reference renderer's light transport: radiance and irradiance that must come out, of the
 * device too, and that both estimators agree. */
#include "reference_checks.h"

#include <float.h>

/* A diffuse floor of reflectance ρ around the origin, front up, seen by a camera of one tiny pixel.
 */
static const double reflectance = 0.6;

static void add_floor(mcv_scene *scene, double size) {
    add_rectangle(scene, size, size, add_diffuse(scene, reflectance), looking_up_z(0, 0, 0));
}

/* A regular polygon of `corners` corners about the z axis, with the front down, as the disk that
 * holds it. */
static uint32_t add_disk(mcv_scene *scene, double radius, double height, uint32_t corners) {
    float *positions = malloc(12 * (size_t)corners);
    uint32_t *indices = malloc(12 * (size_t)(corners - 2));
    assert_true(positions && indices);
    for (uint32_t i = 0; i < corners; ++i) {
        const double angle =
            -2 * M_PI * i / corners; /* clockwise from above, so counter-clockwise from the front */
        memcpy(
            positions + 3 * i,
            (float[3]){(float)(radius * cos(angle)), (float)(radius * sin(angle)), (float)height},
            12);
        if (i + 2 < corners) memcpy(indices + 3 * i, (uint32_t[3]){0, i + 1, i + 2}, 12);
    }
    const uint32_t instance = add_instance(scene,
                                           &(mcv_mesh){.vertex_count = corners,
                                                       .triangle_count = corners - 2,
                                                       .positions = positions,
                                                       .indices = indices},
                                           add_absorber(scene), mcv_transform_identity());
    free(positions);
    free(indices);
    return instance;
}

/* Lambert's formula: irradiance of a horizontal receiver at p from a polygon of radiance 1, all
 * above it. */
static double polygon_irradiance(const ref_vec *corner, int count, ref_vec p) {
    double sum = 0;
    for (int i = 0; i < count; ++i) {
        const ref_vec a = ref_sub(corner[i], p), b = ref_sub(corner[(i + 1) % count], p);
        sum += ref_angle(a, b) * ref_unit(ref_cross(a, b)).z;
    }
    return fabs(sum) / 2;
}

/*
 * T16, T18. The camera's pixel is 2e-4 m wide on the floor; the irradiance's relative curvature is
 * below 10/m², so its mean over the pixel is off by less than 10 (2e-4)²/24 < 1e-7.
 */
static void test_irradiance_of_areas(void **state) {
    const double half[2] = {0.5, 0.3}, height = 0.75;
    const ref_vec corners[4] = {{half[0] + 0.25, half[1], height},
                                {0.25 - half[0], half[1], height},
                                {0.25 - half[0], -half[1], height},
                                {half[0] + 0.25, -half[1], height}};
    mcv_render_stats stats;
    (void)state;
    for (int place = 0; place < 2; ++place) {
        const double at[3] = {place ? 0.8 : 0.1, place ? -0.3 : 0, 0};
        const double camera[3] = {at[0], at[1] - 2, 0.5};
        mcv_scene *scene = mcv_scene_new("rectangle light");
        add_floor(scene, 8);
        add_emitter(scene, MCV_EMITTER_AREA,
                    add_rectangle(scene, 2 * half[0], 2 * half[1], add_absorber(scene),
                                  looking_down_z(0.25, 0, height)),
                    3, 0);
        add_spot_camera(scene, camera, at, 2e-5);
        const double truth = reflectance / M_PI * 3 * polygon_irradiance(corners, 4, ref_from(at));
        check_mean("T18 rectangle, sampled", render_mean(scene, 8192, 8, true, &stats), truth,
                   1e-7 * truth);
        check_mean("T18 rectangle, found by chance", render_mean(scene, 8192, 8, false, &stats),
                   truth, 1e-7 * truth);
        check_device_mean("T18 rectangle, sampled", scene, 8192, 8, truth, 1e-7 * truth);
        mcv_scene_free(scene);

        /* A polygon of N corners in the disk lacks (2π/N)²/6 of its area, and no more of the light
         * than twice that. */
        enum { CORNERS = 256 };
        const double a2 = 0.16, z2 = height * height, rho2 = at[0] * at[0] + at[1] * at[1];
        scene = mcv_scene_new("disk light");
        add_floor(scene, 8);
        add_emitter(scene, MCV_EMITTER_AREA, add_disk(scene, 0.4, height, CORNERS), 3, 0);
        add_spot_camera(scene, camera, at, 2e-5);
        const double disk = reflectance / 2 * 3 *
                            (1 - (z2 + rho2 - a2) / sqrt(pow(z2 + rho2 + a2, 2) - 4 * a2 * rho2));
        check_mean("T16 disk, sampled", render_mean(scene, 8192, 8, true, &stats), disk,
                   pow(2 * M_PI / CORNERS, 2) / 3 * disk);
        check_device_mean("T16 disk, sampled", scene, 8192, 8, disk,
                          pow(2 * M_PI / CORNERS, 2) / 3 * disk);
        mcv_scene_free(scene);
    }
}

/* T14 with unpolarised light at each interface: T = (1 - R)/(1 + R). The pixel's width of 2e-6 rad
 * changes T by less than 1e-5 of it. */
static void test_slab(void **state) {
    mcv_render_stats stats;
    (void)state;
    for (int degrees = 0; degrees <= 80; degrees += 20) {
        const double angle = degrees * M_PI / 180;
        mcv_scene *scene = mcv_scene_new("slab");
        add_box(scene, (const double[3]){60, 60, 0.125}, add_glass(scene, 1.5, 0, 0),
                mcv_transform_identity());
        add_emitter(scene, MCV_EMITTER_AREA,
                    add_rectangle(scene, 400, 400, add_absorber(scene), looking_up_z(0, 0, -1)), 1,
                    0);
        add_spot_camera(scene, (const double[3]){sin(angle), 0, cos(angle)},
                        (const double[3]){0, 0, 0}, 1e-6);
        /* Neither is seen: slab and furnace have one program. */
        add_sphere(scene, 0.1, 8, add_absorber(scene), looking_down_z(0, 10, 5));
        add_environment(scene, 0);
        const ref_surface surface = {.geometric = {0, 0, 1}, .normal = {0, 0, 1}};
        const ref_interaction meeting =
            ref_make_interaction(&surface, (ref_vec){-sin(angle), 0, -cos(angle)});
        const double r = ref_reflectance(&meeting, 1, 1.5), truth = (1 - r) / (1 + r);
        char what[64];
        snprintf(what, sizeof what, "T14 slab at %d degrees", degrees);
        /* Depth 64 leaves R^62. */
        check_mean(what, render_mean(scene, 8192, 64, true, &stats), truth,
                   1e-5 * truth + pow(r, 62));
        check_device_mean(what, scene, 8192, 64, truth, 1e-5 * truth + pow(r, 62));
        mcv_scene_free(scene);
    }
}

/* The sheet is the slab without its thickness. */
static void test_sheet(void **state) {
    const double angle = 1, share = 0.7;
    mcv_render_stats stats;
    mcv_scene *scene = mcv_scene_new("sheet");
    (void)state;
    const uint32_t sheet = add_material(scene, MCV_MATERIAL_SHEET,
                                        &(mcv_material){.as.sheet = {1.5, {share, share, share}}});
    add_rectangle(scene, 4, 4, sheet, looking_up_z(0, 0, 0));
    add_emitter(scene, MCV_EMITTER_AREA,
                add_rectangle(scene, 40, 40, add_absorber(scene), looking_up_z(0, 0, -1)), 1, 0);
    add_spot_camera(scene, (const double[3]){sin(angle), 0, cos(angle)}, (const double[3]){0, 0, 0},
                    1e-6);
    const ref_surface surface = {.geometric = {0, 0, 1}, .normal = {0, 0, 1}};
    const ref_interaction meeting =
        ref_make_interaction(&surface, (ref_vec){-sin(angle), 0, -cos(angle)});
    const double r = ref_reflectance(&meeting, 1, 1.5), truth = share * (1 - r) / (1 + r);
    check_mean("sheet: transmittance", render_mean(scene, 8192, 8, true, &stats), truth,
               1e-5 * truth);
    mcv_scene_free(scene);
}

/* T15: glass of any shape vanishes in an even surrounding, but for what the depth cuts; inside it
 * there is n² L. */
static void test_glass_furnace(void **state) {
    enum { SAMPLES = 16 }; /* no path differs from another: more of them would tell no more */
    mcv_render_stats stats;
    (void)state;
    for (int inside = 0; inside < 2; ++inside) {
        mcv_scene *scene = mcv_scene_new("glass furnace");
        add_environment(scene, 2);
        /* As bright as what is around it. */
        add_emitter(scene, MCV_EMITTER_AREA,
                    add_rectangle(scene, 1, 1, add_absorber(scene), looking_up_z(0, 0, -10)), 2, 0);
        add_sphere(scene, 1, 24, add_glass(scene, 1.5, 0, 0), mcv_transform_identity());
        add_pinhole(scene, 12, 1, looking_down_z(0, 0, inside ? 0 : 3));
        const double truth = inside ? 2 * 1.5 * 1.5 : 2;
        for (uint32_t depth = 2; depth <= 100; depth += 98) {
            const mcv_estimate estimate = render_mean(scene, SAMPLES, depth, true, &stats);
            char what[64];
            snprintf(what, sizeof what, "T15 %s a glass mesh, depth %u: mean + lost",
                     inside ? "inside" : "outside", depth);
            /* Each path that is not cut brings the same: sums of equal terms over a tree of depth
             * log2 of their number. */
            check(what, estimate.mean + truth * stats.lost_energy, truth, 32 * DBL_EPSILON * truth);
            assert_true(depth == 2 ? stats.lost_energy > 0 : stats.lost_energy < 1e-4);
            mcv_render_stats device;
            const mcv_estimate there = device_mean(scene, SAMPLES, depth, &device);
            checked = "device";
            /* Lost energy is counted in steps of 2^-11 of each path, each rounded: by chance up to
             * a few 2^-12/√paths of all. */
            check(what, there.mean + truth * device.lost_energy, truth, 1e-4 * truth);
            checked = "reference";
            assert_int_equal(stats.unmatched, 0);
        }
        mcv_scene_free(scene);
    }
}

/* T19: closed diffuse bodies that emit. L = L_e (1 - ρ^k)/(1 - ρ) for paths of k surfaces. */
static void test_diffuse_furnace(void **state) {
    const double rho = 0.5;
    mcv_render_stats stats;
    (void)state;
    for (int shape = 0; shape < 2; ++shape) {
        mcv_scene *parts = mcv_scene_new("parts"), *scene = mcv_scene_new("diffuse furnace");
        if (shape)
            add_box(parts, (const double[3]){1, 1.5, 2}, add_absorber(parts),
                    mcv_transform_identity());
        else
            add_sphere(parts, 1, 12, add_absorber(parts), mcv_transform_identity());
        add_emitter(scene, MCV_EMITTER_AREA,
                    add_inside_out(scene, &parts->meshes[0], add_diffuse(scene, rho)), 3, 0);
        add_pinhole(scene, 4, 1, looking_down_z(0.1, 0.2, 0.3));
        /* Without roulette, up to depth 7, each path found by chance brings exactly the sum. */
        const mcv_estimate exact = render_mean(scene, 16, 7, false, &stats);
        const double truth = 3 * (1 - pow(rho, 7)) / (1 - rho);
        check(shape ? "T19 box, depth 7" : "T19 sphere, depth 7", exact.mean, truth,
              32 * DBL_EPSILON * truth);
        check("T19 lost energy", stats.lost_energy, pow(rho, 7),
              1e-12); /* 10^4 roundings of a sum */
        check_mean(shape ? "T19 box, depth 7, sampled" : "T19 sphere, depth 7, sampled",
                   render_mean(scene, 128, 7, true, &stats), truth, 0);
        check_mean(shape ? "T19 box, with roulette" : "T19 sphere, with roulette",
                   render_mean(scene, 128, 60, true, &stats), 3 / (1 - rho),
                   3 * pow(rho, 60) / (1 - rho));
        check_device_mean(shape ? "T19 box, depth 7, sampled" : "T19 sphere, depth 7, sampled",
                          scene, 128, 7, truth, 0);
        check_device_mean(shape ? "T19 box, with roulette" : "T19 sphere, with roulette", scene,
                          128, 60, 3 / (1 - rho), 3 * pow(rho, 60) / (1 - rho));
        mcv_scene_free(parts);
        mcv_scene_free(scene);
    }
}

/* Exitance π L sin²β: that is what a receiver close by gets, whose cone lies in the emitter. */
static void test_parallel_exitance(void **state) {
    const double angles[] = {1e-4, 0.02, 0.3, 0.9};
    mcv_render_stats stats;
    (void)state;
    for (int i = 0; i < 4; ++i) {
        mcv_scene *scene = mcv_scene_new("parallel light");
        add_floor(scene, 8);
        add_emitter(scene, MCV_EMITTER_PARALLEL,
                    add_rectangle(scene, 4, 4, add_absorber(scene), looking_down_z(0, 0, 1)), 3,
                    angles[i]);
        add_spot_camera(scene, (const double[3]){6, 0, 0.5}, (const double[3]){0, 0, 0}, 1e-6);
        const double truth = reflectance * 3 * pow(sin(angles[i]), 2);
        char what[64];
        snprintf(what, sizeof what, "parallel emitter of half-angle %g, sampled", angles[i]);
        const mcv_estimate sampled = render_mean(scene, 1024, 4, true, &stats);
        if (angles[i] < 1e-3) {
            /* All that varies over so narrow a cone is the cosine, by β²/2, and the weight against
             * cosθ/π, by πβ² of which chance finds nothing. */
            check(what, sampled.mean, truth, 4 * angles[i] * angles[i] * truth);
        } else {
            check_mean(what, sampled, truth, 0);
        }
        if (angles[i] > 0.1)
            check_mean("  found by chance", render_mean(scene, 8192, 4, false, &stats), truth, 0);
        mcv_scene_free(scene);
    }
}

/* The emitter seen directly: a disk of radius b tanβ on the image; and the cone's edge, down to
 * angles no float32 cosine can tell. */
static void test_parallel_cone(void **state) {
    mcv_render_stats stats;
    mcv_scene *scene = mcv_scene_new("parallel light seen");
    (void)state;
    const uint32_t light = add_rectangle(scene, 4, 4, add_absorber(scene), looking_down_z(0, 0, 1));
    add_emitter(scene, MCV_EMITTER_PARALLEL, light, 3, 0.3);
    add_pinhole(scene, 16, 1, looking_up_z(0, 0, 0));
    /* Behind the camera: the program is that of test_next_event. */
    add_sphere(scene, 0.1, 8, add_diffuse(scene, reflectance), looking_down_z(0, 0, -1));
    const double truth = 3 * M_PI * pow(tan(0.3), 2);
    check_mean("T21 cone seen by a pinhole: solid angle on the image",
               render_mean(scene, 256, 4, true, &stats), truth, 0);
    check_device_mean("T21 cone seen by a pinhole: solid angle on the image", scene, 256, 4, truth,
                      0);

    for (int decade = -6; decade < 0; ++decade) {
        const double beta = pow(10, decade);
        scene->emitters[0].as.parallel.halfAngle = beta;
        for (int side = -1; side <= 1; side += 2) {
            double radiance[3];
            /* Angles come from an arc tangent of the cross product, right to a few ulp. */
            const double angle = beta * (1 + side * 16 * DBL_EPSILON);
            const ref_surface surface = {
                .instance = light, .geometric = {0, 0, -1}, .normal = {0, 0, -1}};
            ref_emitted(scene, &surface, (ref_vec){sin(angle), 0, -cos(angle)}, radiance);
            if ((radiance[0] > 0) != (side < 0))
                fail_msg("half-angle %g: emission at %.17g is %g", beta, angle, radiance[0]);
        }
    }
    mcv_scene_free(scene);
}

/* A bit of everything that both estimators must agree on. `brighter` scales one light: the test
 * must tell. */
static mcv_scene *mixed_scene(double brighter) {
    mcv_scene *scene = mcv_scene_new("mixed");
    add_environment(scene, 0.05);
    add_floor(scene, 4);
    add_sphere(scene, 0.4, 12, add_diffuse(scene, 0.8),
               (mcv_transform){{1, 0, 0, 0, 1, 0, 0, 0, 1, -0.6, 0.3, 0.4}});
    add_sphere(scene, 0.3, 12, add_glass(scene, 1.5, 0.5, 0),
               (mcv_transform){{1, 0, 0, 0, 1, 0, 0, 0, 1, 0.5, 0.2, 0.35}});
    add_rectangle(scene, 1, 1,
                  add_material(scene, MCV_MATERIAL_MIRROR,
                               &(mcv_material){.as.mirror.reflectance = {0.9, 0.9, 0.9}}),
                  looking((const double[3]){0, 0.9, 0.5}, (const double[3]){0, -1, 0},
                          (const double[3]){0, 0, 1}));
    add_emitter(scene, MCV_EMITTER_AREA,
                add_sphere(scene, 0.5, 6, add_diffuse(scene, 0.3),
                           (mcv_transform){{1, 0, 0, 0, 1, 0, 0, 0, 1, 0.5, -0.8, 1.5}}),
                brighter, 0);
    add_emitter(scene, MCV_EMITTER_PARALLEL,
                add_rectangle(scene, 1.5, 1.5, add_absorber(scene), looking_down_z(-0.5, 0, 2)), 2,
                0.4);
    mcv_mesh dome = scene->meshes[1]; /* smooth, so no common normal: by area */
    add_emitter(scene, MCV_EMITTER_PARALLEL,
                add_instance(scene, &dome, add_absorber(scene),
                             (mcv_transform){{1, 0, 0, 0, 1, 0, 0, 0, 1, 1.2, 0.5, 1.2}}),
                2, 0.5);
    const double s = sqrt(0.5);
    add_pinhole(scene, 8, 1.2,
                looking((const double[3]){0, -2.2, 2.2}, (const double[3]){0, s, -s},
                        (const double[3]){0, s, s}));
    return scene;
}

/* The smallest p of Welch's test over pixels and the whole image, corrected for the number of tests
 * (Šidák). */
static double compare(const mcv_film *a, const mcv_film *b, double *image) {
    const size_t pixels = (size_t)a->width * a->height;
    double least = 1;
    for (size_t i = 0; i <= pixels; ++i) {
        const mcv_estimate x = film_estimate(a, i < pixels ? i : 0, i < pixels ? 1 : pixels);
        const mcv_estimate y = film_estimate(b, i < pixels ? i : 0, i < pixels ? 1 : pixels);
        const double variance = x.variance + y.variance;
        const double freedom =
            variance * variance /
            (x.variance * x.variance / x.freedom + y.variance * y.variance / y.freedom);
        const double p = student_two_sided((x.mean - y.mean) / sqrt(variance), (int)freedom);
        if (i == pixels) {
            *image = p;
            print_message(
                "  mean %.6g and %.6g, standard error of the difference %.2g of it, p %.3f\n",
                x.mean, y.mean, sqrt(variance) / x.mean, p);
        } else {
            least = fmin(least, p);
        }
    }
    return 1 - pow(1 - least, (double)pixels);
}

static void test_estimators_agree(void **state) {
    enum { SAMPLES = 256 };
    mcv_render_stats stats;
    mcv_render_options options = options_of(SAMPLES, 16);
    mcv_scene *scene = mixed_scene(2), *brighter = mixed_scene(2 * 1.02);
    double image;
    (void)state;
    mcv_film by_chance = render_with(scene, &options, false, &stats);
    options.seed = 2;
    mcv_film sampled = render_with(scene, &options, true, &stats);
    assert_true(stats.shadow_rays > 0);
    assert_int_equal(stats.unmatched, 0);
    const double pixels = compare(&by_chance, &sampled, &image);
    print_message("  sampling emitters on and off: p of the worst pixel %.3f, of the image %.3f\n",
                  pixels, image);
    assert_true(pixels >= LEVEL && image >= LEVEL);
    /* A quarter of the samples suffices to see what is planted. */
    options.last = SAMPLES / 4;
    mcv_film planted = render_with(brighter, &options, true, &stats);
    compare(&by_chance, &planted, &image);
    print_message("  with one light 2 %% brighter: p %.2g\n", image);
    assert_true(image < LEVEL); /* else the test above could not fail */
    mcv_film_free(&by_chance);
    mcv_film_free(&sampled);
    mcv_film_free(&planted);
    mcv_scene_free(scene);
    mcv_scene_free(brighter);
}

static bool same_bits(const mcv_film *a, const mcv_film *b) {
    return a->samples == b->samples &&
           memcmp(a->sums, b->sums,
                  sizeof *a->sums * a->width * a->height * a->channels * a->replicates) == 0;
}

/* Neither the number of threads nor a split of the samples changes a bit; another seed does. */
static void test_same_bits(void **state) {
    mcv_render_stats stats, other;
    mcv_render_options options = options_of(8, 16);
    mcv_scene *scene = mixed_scene(2);
    (void)state;
    options.threads = 1;
    mcv_film one = render_with(scene, &options, true, &stats);
    options.threads = 3;
    mcv_film three = render_with(scene, &options, true, &other);
    assert_true(same_bits(&one, &three));
    assert_true(stats.lost_energy == other.lost_energy && stats.rays == other.rays &&
                stats.paths == other.paths);
    assert_int_equal(stats.paths, 8 * 8 * 8 * REPLICATES);
    options.last = 4;
    mcv_film merged = render_with(scene, &options, true, &stats);
    options.first = 4;
    options.last = 8;
    mcv_film rest = render_with(scene, &options, true, &stats);
    assert_int_equal(mcv_film_merge(&merged, &rest, &builder_error), MCV_OK);
    assert_true(same_bits(&one, &merged));
    options.first = 0;
    options.seed = 2;
    mcv_film seeded = render_with(scene, &options, true, &stats);
    assert_false(same_bits(&one, &seeded));
    mcv_film_free(&one);
    mcv_film_free(&three);
    mcv_film_free(&merged);
    mcv_film_free(&rest);
    mcv_film_free(&seeded);
    mcv_scene_free(scene);
}

static bool stop_at_once(void *user, double fraction, double seconds, double error) {
    (void)seconds;
    (void)error;
    *(double *)user = fraction;
    return false;
}

/* Stops by error, by time and by the caller, keeping whole rounds; refuses what it cannot do. */
static void test_stops(void **state) {
    mcv_render_stats stats;
    mcv_scene *scene = mixed_scene(2);
    mcv_film film;
    (void)state;
    mcv_render_options options = options_of(0, 16);
    options.error = 0.05;
    film = render_with(scene, &options, true, &stats);
    print_message("  stopped at an error of %.3g after %llu samples\n",
                  mcv_film_relative_error(&film), (unsigned long long)film.samples);
    assert_true(mcv_film_relative_error(&film) <= 0.05);
    mcv_film_free(&film);

    options.error = 0;
    options.seconds = 0.2;
    film = render_with(scene, &options, true, &stats);
    assert_true(film.samples > 0 && !stats.interrupted);
    mcv_film_free(&film);

    double told = -1;
    options.seconds = 0;
    options.last = 1 << 20;
    options.progress = stop_at_once;
    options.user = &told;
    film = render_with(scene, &options, true, &stats);
    assert_true(stats.interrupted && told >= 0 && film.samples < 16);
    mcv_film_free(&film);

    const struct { uint64_t first, last; } bad[] = {{0, 0}, {0, 3}, {2, 6}, {8, 4}, {4, 0}};
    options = options_of(0, 16);
    for (size_t i = 0; i < sizeof bad / sizeof *bad; ++i) {
        options.first = bad[i].first;
        options.last = bad[i].last;
        assert_int_equal(mcv_reference_render(scene, 0, &options, &film, &stats, &builder_error),
                         MCV_USAGE);
        assert_null(film.sums);
    }
    options = options_of(1, 16);
    assert_int_equal(mcv_reference_render(scene, 1, &options, &film, &stats, &builder_error),
                     MCV_USAGE);
    options.replicates = 0;
    assert_int_equal(mcv_reference_render(scene, 0, &options, &film, &stats, &builder_error),
                     MCV_USAGE);
    mcv_scene_free(scene);
}

/* An open surface of glass has no inside: its unmatched sides are counted, and the light still
 * arrives. */
static void test_unmatched_sides_are_counted(void **state) {
    mcv_render_stats stats;
    mcv_scene *scene = mcv_scene_new("open glass");
    (void)state;
    add_environment(scene, 1);
    /* Sees its back without having entered it. Small, so that the oblique ray that tells the
     * sensor's media passes it by. */
    add_rectangle(scene, 0.5, 0.5, add_glass(scene, 1.5, 0, 0), looking_up_z(0, 0, 0));
    add_pinhole(scene, 2, 0.1, looking_up_z(0, 0, -1));
    const mcv_estimate estimate = render_mean(scene, 16, 8, true, &stats);
    assert_int_equal(stats.unmatched, 2 * 2 * 16 * REPLICATES);
    /* Refracted paths see 1, reflected ones 1/n² in the glass the surface says they are in. */
    assert_true(estimate.mean <= 1 && estimate.mean > 0.9);
    mcv_scene_free(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_irradiance_of_areas),
        cmocka_unit_test(test_slab),
        cmocka_unit_test(test_sheet),
        cmocka_unit_test(test_glass_furnace),
        cmocka_unit_test(test_diffuse_furnace),
        cmocka_unit_test(test_parallel_exitance),
        cmocka_unit_test(test_parallel_cone),
        cmocka_unit_test(test_estimators_agree),
        cmocka_unit_test(test_same_bits),
        cmocka_unit_test(test_stops),
        cmocka_unit_test(test_unmatched_sides_are_counted),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
