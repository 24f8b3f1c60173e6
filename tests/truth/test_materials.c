/* SPDX-License-Identifier: Apache-2.0 */
/* Materials and textures as the device and the reference render them, in three channels, against
 * closed forms. */
#include "estimates.h"

#include <complex.h>

#include "reference/reference.h"
#include "render/render.h"

/* Which of the tests run: no file of them shall take long. */
enum { PART_SMOOTH, PART_ROUGH, PART_IMAGES, PART_TEXTURES, PART_SHEETS };
#ifndef PART
#define PART PART_SMOOTH
#endif

enum { SAMPLES = 256, PIXELS = 4 };

/*
 * Each channel's mean against its value. The camera sees 1 mm from 1 m: angles of 7e-4 rad change
 * lengths and reflectances by their square, 5e-7; some 20 roundings to float32 make 1e-6,
 * mcv_exp_minus 3e-7.
 */
static void expect_film(const char *what, mcv_film film, mcv_render_stats stats,
                        const double expected[3], double bound) {
    const size_t pixels = (size_t)film.width * film.height;
    assert_int_equal(film.channels, 3);
    assert_int_equal(stats.unmatched, 0);
    for (uint32_t c = 0; c < 3; ++c) {
        char channel[128];
        snprintf(channel, sizeof channel, "%s, channel %u", what, c);
        expect_estimate(channel, film_estimate(&film, c * pixels, pixels), expected[c], 0.01,
                        bound);
    }
    mcv_film_free(&film);
}

static void expect_within(const char *what, const mcv_scene *scene, const double expected[3],
                          double bound) {
    mcv_render_options options = mcv_render_defaults();
    mcv_render_stats stats;
    mcv_film film;
    options.replicates = REPLICATES;
    options.last = SAMPLES;
    BUILD(render_again(scene, 0, &options, &film, &stats, &builder_error));
    expect_film(what, film, stats, expected, bound);
    char reference[64];
    snprintf(reference, sizeof reference, "%s, reference", what);
    BUILD(mcv_reference_render(scene, 0, &options, &film, &stats, &builder_error));
    expect_film(reference, film, stats, expected, bound);
}

static void expect(const char *what, const mcv_scene *scene, const double expected[3]) {
    expect_within(what, scene, expected, 2e-6);
}

/*
 * Device against reference, whose albedos agree within 1e-3 or so (test_gloss.c); of the light that
 * surfaces of microfacets spread, one part in five at most comes of them, on two bounces.
 */
static void expect_same(const char *what, const mcv_scene *scene) {
    mcv_render_options options = mcv_render_defaults();
    mcv_render_stats stats;
    mcv_film film[2];
    options.replicates = REPLICATES;
    options.last = 4 * SAMPLES;
    BUILD(render_again(scene, 0, &options, &film[0], &stats, &builder_error));
    BUILD(mcv_reference_render(scene, 0, &options, &film[1], &stats, &builder_error));
    const size_t pixels = (size_t)film[0].width * film[0].height;
    for (size_t i = 0; i < 3 * pixels; ++i) {
        const mcv_estimate m[2] = {film_estimate(&film[0], i, 1), film_estimate(&film[1], i, 1)};
        const double error = sqrt(m[0].variance + m[1].variance);
        print_message("%s, pixel %zu, channel %zu: %.6g ± %.2g, reference %.6g ± %.2g\n", what,
                      i % pixels, i / pixels, m[0].mean, sqrt(m[0].variance), m[1].mean,
                      sqrt(m[1].variance));
        if (!(error <= 0.03 * m[1].mean))
            fail_msg("%s: the standard error %g is above 3 %%", what, error);
        if (!(fabs(m[0].mean - m[1].mean) <= 6.1 * error + 1e-3 * m[1].mean))
            fail_msg("%s, value %zu: %g, reference %g, standard error %g", what, i, m[0].mean,
                     m[1].mean, error);
    }
    mcv_film_free(&film[0]);
    mcv_film_free(&film[1]);
}

/*
 * Programs are compiled for what a scene holds: with patches of these materials, 0.1 mm wide where
 * no ray of a mirror or a plate goes and one of 10^9 others, many scenes have one program.
 */
enum { SMOOTH_PATCHES = 1, SPREADING_PATCHES = 2, GLASS_PATCH = 4 };

static void add_patches(mcv_scene *scene, unsigned kinds) {
    static const struct {
        unsigned kind;
        uint32_t type;
        mcv_material material;
    } patches[] = {
        {SMOOTH_PATCHES | GLASS_PATCH,
         MCV_MATERIAL_DIELECTRIC,
         {.as.dielectric = {{1.5, 1.5, 1.5}, {1, 1, 1}, .coating = 0.005}}},
        {SMOOTH_PATCHES, MCV_MATERIAL_SHEET, {.as.sheet = {1.5, {1, 1, 1}}}},
        {SMOOTH_PATCHES, MCV_MATERIAL_MIRROR, {.as.mirror = {{1, 1, 1}}}},
        {SPREADING_PATCHES,
         MCV_MATERIAL_DIFFUSE,
         {.as.diffuse = {{0.5, 0.5, 0.5}, {0.25, 0.25, 0.25}}}},
        {SPREADING_PATCHES,
         MCV_MATERIAL_RETROREFLECTOR,
         {.as.retroreflector = {{0.5, 0.5, 0.5}, 0.6, 0, {0.25, 0.25, 0.25}}}},
        {SPREADING_PATCHES,
         MCV_MATERIAL_CONDUCTOR,
         {.as.conductor = {{0.2, 0.2, 0.2}, {3, 3, 3}, 0.5}}},
    };
    for (size_t i = 0; i < sizeof patches / sizeof patches[0]; ++i)
        if (patches[i].kind & kinds)
            add_rectangle(scene, 1e-4, 1e-4,
                          add_material(scene, patches[i].type, &patches[i].material),
                          looking_up_z(0.3 + 0.01 * (double)i, 0.8, 0.9));
}

/* A camera that looks down from 1 m above the origin onto a lamp of radiance L below it. */
static mcv_scene *lamp_scene(void) {
    mcv_scene *scene = mcv_scene_new("lamp");
    add_pinhole(scene, PIXELS, 1e-3, looking_down_z(0, 0, 1));
    add_emitter(scene, MCV_EMITTER_AREA,
                add_rectangle(scene, 1, 1, add_absorber(scene), looking_up_z(0, 0, -0.5)), 3, 0);
    add_patches(scene, SMOOTH_PATCHES);
    return scene;
}

/* A slab of n = 1.5, 0.1 m thick: T = (1 - R)² a/(1 - R² a²), a = exp(-σ d), R = 0.04. */
static void test_absorbing_slab(void **state) {
    const mcv_material glass = {.as.dielectric = {{1.5, 1.5, 1.5}, {0, 5, 20}, 0}};
    mcv_scene *scene = lamp_scene();
    double expected[3];
    (void)state;
    add_box(scene, (const double[]){0.3, 0.3, 0.05},
            add_material(scene, MCV_MATERIAL_DIELECTRIC, &glass), mcv_transform_identity());
    for (int c = 0; c < 3; ++c) {
        /* Halves and tenths round to float32 in the mesh: the box is 0.1 m thick within 2e-8. */
        const double a = exp(-glass.as.dielectric.absorption[c] * 0.1);
        expected[c] = 3 * 0.96 * 0.96 * a / (1 - 0.0016 * a * a);
    }
    expect("slab", scene, expected);
    mcv_scene_free(scene);
}

/* A sheet passes the share 1 - 2 R/(1 + R) = 2 n/(n² + 1), times its transmittance. */
static void test_sheet(void **state) {
    const mcv_material pane = {.as.sheet = {1.5, {1, 0.5, 0.25}}};
    mcv_scene *scene = lamp_scene();
    double expected[3];
    (void)state;
    add_rectangle(scene, 0.5, 0.5, add_material(scene, MCV_MATERIAL_SHEET, &pane),
                  looking_up_z(0, 0, 0));
    for (int c = 0; c < 3; ++c)
        expected[c] = 3 * 2 * 1.5 / (1.5 * 1.5 + 1) * pane.as.sheet.transmittance[c];
    expect("sheet", scene, expected);
    mcv_scene_free(scene);
}

/* The same in water, n = 4/3, with the index of the sheet relative to it. A black plate behind the
 * camera ends what the sheet reflects. */
static void test_sheet_in_water(void **state) {
    const mcv_material pane = {.as.sheet = {1.5, {1, 0.5, 0.25}}};
    const double n = 1.5 / (4 / 3.0);
    mcv_scene *scene = lamp_scene();
    double expected[3];
    (void)state;
    add_box(scene, (const double[]){2, 2, 2}, add_glass(scene, 4 / 3.0, 0, 0),
            mcv_transform_identity());
    add_rectangle(scene, 3, 3, add_absorber(scene), looking_down_z(0, 0, 1.5));
    add_rectangle(scene, 0.5, 0.5, add_material(scene, MCV_MATERIAL_SHEET, &pane),
                  looking_up_z(0, 0, 0));
    for (int c = 0; c < 3; ++c)
        expected[c] = 3 * 2 * n / (n * n + 1) * pane.as.sheet.transmittance[c];
    expect("sheet in water", scene, expected);
    mcv_scene_free(scene);
}

/*
 * Through an open mesh into a medium that never ends: what absorbs at all leaves nothing of the
 * light from infinitely far away, of the environment that a ray meets as of a directional light
 * that a floor looks for, past the mesh.
 */
static void test_endless_medium(void **state) {
    const mcv_material gas = {.as.dielectric = {{1, 1, 1}, {0, 1e-3, 20}, 0}};
    const double s = sqrt(0.5);
    (void)state;
    for (int with_floor = 0; with_floor < 2; ++with_floor) {
        mcv_scene *scene = mcv_scene_new("endless");
        add_pinhole(scene, PIXELS, 1e-3, looking_down_z(0, 0, 1));
        add_rectangle(scene, 0.1, 0.1, add_material(scene, MCV_MATERIAL_DIELECTRIC, &gas),
                      looking_up_z(0, 0, 0.5));
        if (with_floor) {
            mcv_emitter sun = {
                .name = (char *)"sun", .type = MCV_EMITTER_DIRECTIONAL, .texture = MCV_NONE};
            sun.to_world = looking((const double[]){0, 0, 0}, (const double[]){-s, 0, -s},
                                   (const double[]){0, 1, 0});
            for (int c = 0; c < 3; ++c) sun.as.directional.irradiance[c] = 3;
            add_rectangle(scene, 1, 1, add_diffuse(scene, 0.5), looking_up_z(0, 0, 0));
            BUILD(mcv_scene_add_emitter(scene, &sun, &builder_error));
            expect("endless medium, directional light", scene,
                   (const double[]){0.5 / M_PI * 3 * s, 0, 0});
        } else {
            add_environment(scene, 2);
            add_patches(scene, SPREADING_PATCHES | GLASS_PATCH);
            expect("endless medium, environment", scene, (const double[]){2, 0, 0});
        }
        mcv_scene_free(scene);
    }
}

/* A mirror at 45° shows the lamp at the side; the one below is hidden. */
static void test_mirror(void **state) {
    const mcv_material silver = {.as.mirror = {{0.9, 0.5, 0.125}}};
    const double s = sqrt(0.5);
    mcv_scene *scene = lamp_scene();
    (void)state;
    add_rectangle(
        scene, 0.5, 0.5, add_material(scene, MCV_MATERIAL_MIRROR, &silver),
        looking((const double[]){0, 0, 0}, (const double[]){s, 0, s}, (const double[]){0, 1, 0}));
    add_emitter(scene, MCV_EMITTER_AREA,
                add_rectangle(scene, 0.5, 0.5, add_absorber(scene),
                              looking((const double[]){1, 0, 0}, (const double[]){-1, 0, 0},
                                      (const double[]){0, 1, 0})),
                2, 0);
    expect("mirror", scene, (const double[]){1.8, 1, 0.25});
    mcv_scene_free(scene);
}

/* A beam splitter at 45° adds its share of the lamp at the side to its share of the one behind it.
 */
static void test_beam_splitter(void **state) {
    const mcv_material splitter = {.as.beam_splitter = {{0.5, 0.25, 1}, {0.375, 0.75, 0}}};
    const double s = sqrt(0.5);
    (void)state;
    for (int side = 0; side < 2; ++side) { /* both sides are alike */
        mcv_scene *scene = lamp_scene();
        add_rectangle(scene, 0.5, 0.5, add_material(scene, MCV_MATERIAL_BEAM_SPLITTER, &splitter),
                      looking((const double[]){0, 0, 0},
                              side ? (const double[]){-s, 0, -s} : (const double[]){s, 0, s},
                              (const double[]){0, 1, 0}));
        add_emitter(scene, MCV_EMITTER_AREA,
                    add_rectangle(scene, 0.5, 0.5, add_absorber(scene),
                                  looking((const double[]){1, 0, 0}, (const double[]){-1, 0, 0},
                                          (const double[]){0, 1, 0})),
                    2, 0);
        expect("beam splitter", scene,
               (const double[]){2 * 0.5 + 3 * 0.375, 2 * 0.25 + 3 * 0.75, 2});
        mcv_scene_free(scene);
    }
}

/* A plate of a material under radiance 1 from everywhere, seen obliquely: it is as bright where it
 * loses nothing. */
static void expect_furnace(const char *what, mcv_material material, uint32_t type, double expected,
                           bool body) {
    const double s = sqrt(0.5);
    mcv_scene *scene = mcv_scene_new("furnace");
    const double half[3] = {0.5, 0.5, 0.05};
    add_pinhole(
        scene, PIXELS, 1e-3,
        looking((const double[]){s, 0, s}, (const double[]){-s, 0, -s}, (const double[]){0, 1, 0}));
    if (body)
        add_box(scene, half, add_material(scene, type, &material), mcv_transform_identity());
    else
        add_rectangle(scene, 2, 2, add_material(scene, type, &material), looking_up_z(0, 0, 0));
    mcv_emitter sky = {.name = (char *)"sky",
                       .type = MCV_EMITTER_ENVIRONMENT,
                       .instance = MCV_NONE,
                       .texture = MCV_NONE};
    mcv_params_set_defaults(mcv_emitter_table(sky.type), &sky.as);
    memcpy(sky.as.environment.radiance, (double[3]){1, 2, 3}, sizeof(double[3]));
    BUILD(mcv_scene_add_emitter(scene, &sky, &builder_error));
    add_patches(scene, SPREADING_PATCHES | GLASS_PATCH);
    expect_within(what, scene, (const double[]){expected, 2 * expected, 3 * expected}, 0.01);
    mcv_scene_free(scene);
}

/* Rough surfaces keep the light within 1 %, the goal. A path may meet 32 surfaces, which is enough
 * of a slab. */
static void test_rough_furnace(void **state) {
    (void)state;
    expect_furnace("rough metal", (mcv_material){.as.conductor = {{0, 0, 0}, {3, 3, 3}, 0.7}},
                   MCV_MATERIAL_CONDUCTOR, 1, false);
    expect_furnace("brushed metal",
                   (mcv_material){.as.conductor = {{0, 0, 0}, {3, 3, 3}, 0.4, 0.8, 0.3}},
                   MCV_MATERIAL_CONDUCTOR, 1, false);
    expect_furnace("white plastic",
                   (mcv_material){.surface_texture = MCV_NONE,
                                  .as.metallic_roughness = {{1, 1, 1}, 0, 1.5, 0, 0, 0.5}},
                   MCV_MATERIAL_METALLIC_ROUGHNESS, 1, false);
    expect_furnace("frosted glass",
                   (mcv_material){.as.dielectric = {{1.5, 1.5, 1.5}, {0, 0, 0}, 0, 0.6}},
                   MCV_MATERIAL_DIELECTRIC, 1, true);
}

/* A smooth metal at 45°: Fresnel's reflectance by the complex index; without k and with n < sin 45°
 * all is reflected. */
static void test_conductor(void **state) {
    const mcv_material metal = {.as.conductor = {{0.27, 0.2, 1.4}, {3.41, 0, 7.5}}};
    const double s = sqrt(0.5);
    double expected[3];
    mcv_scene *scene = lamp_scene();
    (void)state;
    add_rectangle(
        scene, 0.5, 0.5, add_material(scene, MCV_MATERIAL_CONDUCTOR, &metal),
        looking((const double[]){0, 0, 0}, (const double[]){s, 0, s}, (const double[]){0, 1, 0}));
    add_emitter(scene, MCV_EMITTER_AREA,
                add_rectangle(scene, 0.5, 0.5, add_absorber(scene),
                              looking((const double[]){1, 0, 0}, (const double[]){-1, 0, 0},
                                      (const double[]){0, 1, 0})),
                2, 0);
    for (int c = 0; c < 3; ++c) {
        const double complex square =
                                 cpow(metal.as.conductor.n[c] - metal.as.conductor.k[c] * I, 2),
                             root = csqrt(square - 0.5);
        const double r_s = cabs((s - root) / (s + root)),
                     r_p = cabs((square * s - root) / (square * s + root));
        expected[c] = r_s * r_s + r_p * r_p;
    }
    expect("conductor", scene, expected);
    mcv_scene_free(scene);
}

/* R of a coating by its definition, at an interface from n1 into n2. */
static double coated(double r0, double n1, double n2, double angle) {
    const double c1 = cos(angle), c2 = sqrt(1 - pow(n1 / n2 * sin(angle), 2)),
                 f0 = pow((n1 - n2) / (n1 + n2), 2);
    const double f = (pow((n1 * c1 - n2 * c2) / (n1 * c1 + n2 * c2), 2) +
                      pow((n2 * c1 - n1 * c2) / (n2 * c1 + n1 * c2), 2)) /
                     2;
    return r0 + (1 - r0) * (f - f0) / (1 - f0);
}

/*
 * A coated slab at normal incidence and turned by 60° before a lamp: T = (1 - R)² a/(1 - R² a²), a
 * = exp(-σ d/cosθ'). In water it is bare: slabs of reflectance 2 R/(1 + R) and then the water's two
 * surfaces, each added to what lies behind it.
 */
static void test_coating(void **state) {
    const double water = 1.33;
    const mcv_material glass = {
        .as.dielectric = {
            .ior = {1.5, 1.5, 1.5}, .absorption = {0, 5, 20}, .priority = 1, .coating = 0.005}};
    double expected[3];
    (void)state;
    for (int turned = 0; turned < 2; ++turned) {
        const double angle = turned * M_PI / 3, r = coated(0.005, 1, 1.5, angle),
                     way = 0.04 / sqrt(1 - pow(sin(angle) / 1.5, 2));
        mcv_scene *scene = lamp_scene();
        add_box(scene, (const double[]){0.4, 0.4, 0.02},
                add_material(scene, MCV_MATERIAL_DIELECTRIC, &glass),
                looking((const double[]){0, 0, 0}, (const double[]){sin(angle), 0, cos(angle)},
                        (const double[]){0, 1, 0}));
        for (int c = 0; c < 3; ++c) {
            const double a = exp(-glass.as.dielectric.absorption[c] * way);
            expected[c] = 3 * (1 - r) * (1 - r) * a / (1 - r * r * a * a);
        }
        expect(turned ? "coated slab, 60°" : "coated slab", scene, expected);
        mcv_scene_free(scene);
    }
    const double wet = pow((1.5 - water) / (1.5 + water), 2),
                 dry = pow((water - 1) / (water + 1), 2);
    mcv_scene *scene = lamp_scene();
    add_box(scene, (const double[]){0.4, 0.4, 0.1}, add_glass(scene, water, 0, 0),
            mcv_transform_identity());
    add_box(scene, (const double[]){0.3, 0.3, 0.02},
            add_material(scene, MCV_MATERIAL_DIELECTRIC, &glass), mcv_transform_identity());
    for (int c = 0; c < 3; ++c) {
        const double a = exp(-glass.as.dielectric.absorption[c] * 0.04);
        const double t = (1 - wet) * (1 - wet) * a / (1 - wet * wet * a * a), r = wet * (1 + a * t);
        const double first = (1 - dry) * t / (1 - dry * r),
                     behind = r + t * t * dry / (1 - dry * r);
        expected[c] = 3 * first * (1 - dry) / (1 - dry * behind);
    }
    expect("coated slab in water", scene, expected);
    mcv_scene_free(scene);
}

/* A translucent sheet in a furnace, and with a lamp of radiance 3 that fills the half space behind
 * it: 3 times the transmittance. */
static void test_translucent(void **state) {
    const mcv_material paper = {
        .as.diffuse = {{0.5, 0.25, 0.125}, {0.25, 0.25, 0.125}}}; /* chances 2/3 and 1/3 */
    (void)state;
    mcv_scene *scene = mcv_scene_new("furnace");
    add_pinhole(scene, PIXELS, 1e-3, looking_down_z(0, 0, 1));
    add_rectangle(scene, 2, 2, add_material(scene, MCV_MATERIAL_DIFFUSE, &paper),
                  looking_up_z(0, 0, 0));
    mcv_emitter sky = {.name = (char *)"sky",
                       .type = MCV_EMITTER_ENVIRONMENT,
                       .instance = MCV_NONE,
                       .texture = MCV_NONE};
    mcv_params_set_defaults(mcv_emitter_table(sky.type), &sky.as);
    memcpy(sky.as.environment.radiance, (double[3]){1, 1, 1}, sizeof(double[3]));
    BUILD(mcv_scene_add_emitter(scene, &sky, &builder_error));
    add_patches(scene, SPREADING_PATCHES | GLASS_PATCH);
    expect("translucent sheet in a furnace", scene, (const double[]){0.75, 0.5, 0.25});
    mcv_scene_free(scene);

    /* A lamp 1 m wide, 0.1 m below the middle: the disk's share of the half space would be R²/(R² +
     * h²); that of a square by its four quarters, each 1/2π 2 a/√(1 + a²) atan(a/√(1 + a²)) with a
     * = 5. */
    const double a = 5, root = sqrt(1 + a * a),
                 share = 4 * (2 * a / root * atan(a / root)) / (2 * M_PI);
    scene = mcv_scene_new("backlight");
    add_pinhole(scene, PIXELS, 1e-6, looking_down_z(0, 0, 1));
    add_rectangle(scene, 2, 2, add_material(scene, MCV_MATERIAL_DIFFUSE, &paper),
                  looking_up_z(0, 0, 0));
    add_emitter(scene, MCV_EMITTER_AREA,
                add_rectangle(scene, 1, 1, add_absorber(scene), looking_up_z(0, 0, -0.1)), 3, 0);
    expect("translucent sheet before a lamp", scene,
           (const double[]){0.75 * share, 0.75 * share, 0.375 * share});
    mcv_scene_free(scene);
}

/*
 * Through a beam splitter at 45°, onto a retroreflector that is tilted by 30°: the lamp beside the
 * camera's axis shines by R T times the share that the angle leaves, 1/(1 + (tan 30°/tan θ_h)⁴). In
 * a furnace it is as bright as what it returns and what it scatters.
 */
static void test_retroreflector(void **state) {
    const mcv_material splitter = {.as.beam_splitter = {{0.5, 0.25, 0.75}, {0.375, 0.75, 0.25}}};
    const mcv_material cube = {.as.retroreflector = {{0.9, 0.5, 0.125}, 0.6, 0, {0, 0, 0}}};
    const mcv_material tape = {.as.retroreflector = {{0.5, 0.5, 0.5}, 0.6, 0, {0.25, 0.25, 0.25}}};
    const double s = sqrt(0.5), share = 1 / (1 + pow(tan(M_PI / 6) / tan(0.6), 4));
    double expected[3];
    mcv_scene *scene = mcv_scene_new("coaxial");
    (void)state;
    add_pinhole(scene, PIXELS, 1e-3, looking_down_z(0, 0, 1));
    add_rectangle(
        scene, 0.5, 0.5, add_material(scene, MCV_MATERIAL_BEAM_SPLITTER, &splitter),
        looking((const double[]){0, 0, 0.5}, (const double[]){s, 0, s}, (const double[]){0, 1, 0}));
    add_rectangle(scene, 0.5, 0.5, add_material(scene, MCV_MATERIAL_RETROREFLECTOR, &cube),
                  looking((const double[]){0, 0, 0},
                          (const double[]){sin(M_PI / 6), 0, cos(M_PI / 6)},
                          (const double[]){0, 1, 0}));
    add_emitter(scene, MCV_EMITTER_AREA,
                add_rectangle(scene, 0.5, 0.5, add_absorber(scene),
                              looking((const double[]){-1, 0, 0.5}, (const double[]){1, 0, 0},
                                      (const double[]){0, 1, 0})),
                2, 0);
    for (int c = 0; c < 3; ++c)
        expected[c] = 2 * splitter.as.beam_splitter.reflectance[c] *
                      splitter.as.beam_splitter.transmittance[c] *
                      cube.as.retroreflector.reflectance[c] * share;
    expect("retroreflector", scene, expected);
    mcv_scene_free(scene);
    expect_furnace("tape", tape, MCV_MATERIAL_RETROREFLECTOR, 0.5 / (1 + pow(tan(0.6), -4)) + 0.25,
                   false);
}

/* Rough surfaces lit by a lamp and by a narrow cone, and through absorbing rough glass: both
 * renderers see the same. */
static void test_rough_images(void **state) {
    static const struct {
        const char *name;
        uint32_t type;
        mcv_material material;
    } cases[] = {
        {"brushed copper",
         MCV_MATERIAL_CONDUCTOR,
         {.as.conductor = {{0.27, 0.6, 1.2}, {3.4, 2.6, 2.3}, 0.4, 0.6, 0.5}}},
        {"red plastic",
         MCV_MATERIAL_METALLIC_ROUGHNESS,
         {.surface_texture = MCV_NONE,
          .as.metallic_roughness = {{0.8, 0.2, 0.1}, 0.2, 1.5, 0, 0, 0.35}}},
        {"tinted frosted pane",
         MCV_MATERIAL_METALLIC_ROUGHNESS,
         {.surface_texture = MCV_NONE,
          .as.metallic_roughness = {{0.9, 0.8, 0.7}, 0, 1.5, 0.9, 0.4, 0.3}}},
        {"opal", MCV_MATERIAL_DIFFUSE, {.as.diffuse = {{0.5, 0.6, 0.7}, {0.4, 0.2, 0.1}}}},
        {"tape",
         MCV_MATERIAL_RETROREFLECTOR,
         {.as.retroreflector = {{0.5, 0.6, 0.7}, 0.8, 0.6, {0.3, 0.2, 0.1}}}},
        {"corner cubes on paper",
         MCV_MATERIAL_RETROREFLECTOR,
         {.as.retroreflector = {{0.5, 0.6, 0.7}, 0.8, 0, {0.3, 0.2, 0.1}}}},
        {"coated, absorbing rough glass",
         MCV_MATERIAL_DIELECTRIC,
         {.as.dielectric = {{1.5, 1.5, 1.5}, {2, 5, 9}, 0, 0.5, 0, 0, 0.004}}},
    };
    (void)state;
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        const double s = sqrt(0.5);
        mcv_scene *scene = mcv_scene_new(cases[i].name);
        add_pinhole(scene, 2, 0.1,
                    looking((const double[]){s, 0, s}, (const double[]){-s, 0, -s},
                            (const double[]){0, 1, 0}));
        const uint32_t material = add_material(scene, cases[i].type, &cases[i].material);
        add_box(scene, (const double[]){0.5, 0.5, 0.05}, material, mcv_transform_identity());
        if (cases[i].type != MCV_MATERIAL_DIELECTRIC) add_patches(scene, SPREADING_PATCHES);
        add_emitter(
            scene, MCV_EMITTER_AREA,
            add_rectangle(scene, 0.6, 0.6, add_absorber(scene), looking_down_z(-0.4, 0, 0.9)), 3,
            0);
        add_emitter(scene, MCV_EMITTER_AREA,
                    add_rectangle(scene, 2, 2, add_absorber(scene), looking_up_z(0, 0, -0.5)), 1,
                    0);
        add_emitter(scene, MCV_EMITTER_PARALLEL,
                    add_rectangle(scene, 1, 1, add_absorber(scene), looking_down_z(0, 0, 1.5)), 5,
                    0.1);
        expect_same(cases[i].name, scene);
        mcv_scene_free(scene);
    }
}

/* Roughness and metallic from a texture; and a brushed sheet that its node mirrors: tangent and
 * bitangent turn with it. */
static void test_textured_roughness(void **state) {
    float positions[] = {-0.5F, -0.5F, 0, 0.5F, -0.5F, 0, 0.5F, 0.5F, 0, -0.5F, 0.5F, 0};
    float texcoords[] = {0, 1, 1, 0.9F, 1, 0, 0, 0.2F}, other[] = {1, 1, 0.8F, 0, 0, 0.1F, 0.3F, 1};
    uint32_t indices[] = {0, 1, 2, 0, 2, 3};
    float linear[] = {0, 0.5F, 1, 0, 0.9F, 0.5F, 0, 0.7F, 0, 0, 1, 1};
    const double s = sqrt(0.5);
    (void)state;
    for (int mirrored = 0; mirrored < 2; ++mirrored) {
        mcv_scene *scene = mcv_scene_new("sheet");
        const mcv_texture texture = {.name = (char *)"image",
                                     .width = 2,
                                     .height = 2,
                                     .wrap_s = 33071,
                                     .wrap_t = 33071,
                                     .linear = linear,
                                     .is_data = true,
                                     .texcoord_set = 1,
                                     .is_transformed = true,
                                     .transform = {0.6, 0.5, -0.1, -0.4, 0.9, 0.2}};
        BUILD(mcv_scene_add_texture(scene, &texture, &builder_error));
        const mcv_material sheet = {
            .surface_texture = mirrored ? MCV_NONE : 0,
            .as.metallic_roughness = {{0.9, 0.7, 0.5}, 1, 1.5, 0, 0, 0.6, mirrored ? 0.7 : 0, 0.5}};
        add_pinhole(scene, 2, 0.1,
                    looking((const double[]){s, 0, s}, (const double[]){-s, 0, -s},
                            (const double[]){0, 1, 0}));
        mcv_transform place = mcv_transform_identity();
        if (mirrored) place.m[0] = -1;
        const mcv_mesh mesh = {.vertex_count = 4,
                               .triangle_count = 2,
                               .positions = positions,
                               .texcoords = texcoords,
                               .texcoords1 = other,
                               .indices = indices};
        add_instance(scene, &mesh, add_material(scene, MCV_MATERIAL_METALLIC_ROUGHNESS, &sheet),
                     place);
        add_emitter(
            scene, MCV_EMITTER_AREA,
            add_rectangle(scene, 0.6, 0.6, add_absorber(scene), looking_down_z(-0.4, 0.3, 0.9)), 3,
            0);
        expect_same(mirrored ? "brushed sheet, mirrored" : "textured sheet", scene);
        mcv_scene_free(scene);
    }
}

/* A lamp of 1 mm, textured, and a camera of 2 x 2 pixels that sees it whole. Its second set of
 * coordinates lies in the lower right quarter of the image. */
static mcv_scene *textured_lamp(const mcv_texture *texture, double radiance) {
    float positions[] = {-5e-4F, -5e-4F, 0, 5e-4F, -5e-4F, 0, 5e-4F, 5e-4F, 0, -5e-4F, 5e-4F, 0};
    float whole[] = {0, 1, 1, 1, 1, 0, 0, 0}, corner[] = {0.5F, 1, 1, 1, 1, 0.5F, 0.5F, 0.5F};
    uint32_t indices[] = {0, 1, 2, 0, 2, 3};
    mcv_scene *scene = mcv_scene_new("textured lamp");
    BUILD(mcv_scene_add_texture(scene, texture, &builder_error));
    add_pinhole(scene, 2, 1e-3, looking_down_z(0, 0, 1));
    const mcv_mesh mesh = {.vertex_count = 4,
                           .triangle_count = 2,
                           .positions = positions,
                           .texcoords = whole,
                           .texcoords1 = corner,
                           .indices = indices};
    mcv_emitter emitter = {
        .name = (char *)"emitter",
        .type = MCV_EMITTER_AREA,
        .instance = add_instance(scene, &mesh, add_absorber(scene), mcv_transform_identity())};
    mcv_params_set_defaults(mcv_emitter_table(MCV_EMITTER_AREA), &emitter.as);
    for (int c = 0; c < 3; ++c) emitter.as.area.radiance[c] = radiance;
    BUILD(mcv_scene_add_emitter(scene, &emitter, &builder_error));
    return scene;
}

/* A texture of 2 x 2 texels without wrapping. */
static mcv_texture texels(uint8_t rgba[16], bool nearest) {
    return (mcv_texture){.name = (char *)"image",
                         .width = 2,
                         .height = 2,
                         .wrap_s = 33071,
                         .wrap_t = 33071,
                         .nearest = nearest,
                         .rgba = rgba};
}

/*
 * A lamp with an image of 2 x 2 texels across a square of 1 mm, just what the camera sees. The
 * bilinear image, clamped at its edges, has the mean of its texels, and so has the nearest one;
 * sRGB 188 decodes to ((188/255 + 0.055)/1.055)^2.4.
 */
static void test_texture(void **state) {
    const double part = pow((188.0 / 255 + 0.055) / 1.055, 2.4);
    uint8_t rgba[] = {255, 0, 0, 255, 0, 188, 0, 255, 0, 0, 255, 255, 255, 188, 0, 255};
    (void)state;
    for (int nearest = 0; nearest < 2; ++nearest) {
        const mcv_texture texture = texels(rgba, nearest);
        mcv_scene *scene = textured_lamp(&texture, 3);
        expect(nearest ? "nearest texture" : "bilinear texture", scene,
               (const double[]){3 * 0.5, 3 * 0.5 * part, 3 * 0.25});
        mcv_scene_free(scene);
    }
}

/*
 * KHR_texture_transform on that lamp, all white but one texel of four. By the extension's own
 * examples: scale ½, turned by π/2 and moved by (0, 1) shows the lower left quarter of the image;
 * scale (1, -1) moved by (0, 1) turns it upside down. Then what lies beyond the edge is as far
 * right as can be. The last one takes another set of coordinates, all of which lie in the lower
 * right quarter.
 */
static void test_texture_transform(void **state) {
    static const struct {
        const char *name;
        uint32_t set;
        double transform[6], expected[3];
    } cases[] = {
        {"quarter turn", 0, {0, 0.5, 0, -0.5, 0, 1}, {0, 0, 1}},
        {"upside down, right half", 0, {0.5, 0, 0.5, 0, -1, 1}, {0.5, 0.5, 0}},
        {"upside down, upper right quarter", 0, {0.5, 0, 0.5, 0, -0.5, 1}, {1, 0, 0}},
        {"moved by half", 0, {1, 0, 0.5, 0, 1, 0}, {0.5, 0.5, 0}},
        {"another set", 1, {1, 0, 0, 0, 1, 0}, {1, 0, 0}},
    };
    uint8_t rgba[] = {255, 0, 0, 255, 0, 255, 0, 255, 0, 0, 255, 255, 255, 0, 0, 255};
    (void)state;
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; ++k) {
        mcv_texture texture = texels(rgba, true);
        texture.texcoord_set = cases[k].set;
        texture.is_transformed = true;
        memcpy(texture.transform, cases[k].transform, sizeof texture.transform);
        mcv_scene *scene = textured_lamp(&texture, 1);
        expect(cases[k].name, scene, cases[k].expected);
        mcv_scene_free(scene);
    }
}

int main(void) {
    const struct CMUnitTest smooth[] = {
        cmocka_unit_test(test_absorbing_slab),    cmocka_unit_test(test_sheet),
        cmocka_unit_test(test_sheet_in_water),    cmocka_unit_test(test_mirror),
        cmocka_unit_test(test_coating),           cmocka_unit_test(test_beam_splitter),
        cmocka_unit_test(test_texture),           cmocka_unit_test(test_conductor),
        cmocka_unit_test(test_texture_transform),
    };
    const struct CMUnitTest rough[] = {
        cmocka_unit_test(test_rough_furnace),
        cmocka_unit_test(test_endless_medium),
    };
    const struct CMUnitTest sheets[] = {cmocka_unit_test(test_translucent),
                                        cmocka_unit_test(test_retroreflector)};
    const struct CMUnitTest images[] = {cmocka_unit_test(test_rough_images)};
    const struct CMUnitTest textures[] = {cmocka_unit_test(test_textured_roughness)};
    switch (PART) {
    case PART_SMOOTH:
        return cmocka_run_group_tests(smooth, NULL, NULL);
    case PART_ROUGH:
        return cmocka_run_group_tests(rough, NULL, NULL);
    case PART_IMAGES:
        return cmocka_run_group_tests(images, NULL, NULL);
    case PART_TEXTURES:
        return cmocka_run_group_tests(textures, NULL, NULL);
    default:
        return cmocka_run_group_tests(sheets, NULL, NULL);
    }
}
