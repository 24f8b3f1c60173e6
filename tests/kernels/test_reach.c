/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Emitters are chosen by what they may bring to a surface: what cannot reach it changes nothing,
 * not even the noise; what can is found as often as its light is weighed: light adds up.
 */
#include "scene_builder.h"

#include "analysis/compare.h"
#include "render/render.h"

/* Which of the tests run: no file of them shall take long. test_reach_glossy.c: glossy surfaces. */
#ifndef GLOSSY_SURFACES
#define GLOSSY_SURFACES 0
#endif

enum { PIXELS = 4, SAMPLES = 2048 };

static void render(const mcv_scene *scene, uint32_t replicates, uint64_t samples, uint32_t seed,
                   mcv_film *film) {
    mcv_render_options options = mcv_render_defaults();
    mcv_render_stats stats;
    options.replicates = replicates;
    options.last = samples;
    options.seed = seed;
    options.no_light_paths = true; /* they choose otherwise, and would be a second program */
    BUILD(mcv_render(scene, 0, &options, film, &stats, &builder_error));
}

static void add_lamp(mcv_scene *scene, mcv_transform to_world, double radiance) {
    add_emitter(scene, MCV_EMITTER_AREA,
                add_rectangle(scene, 0.5, 0.5, add_absorber(scene), to_world), radiance, 0);
}

static void add_light(mcv_scene *scene, uint32_t type, mcv_emitter light, mcv_transform to_world) {
    light.name = (char *)"light";
    light.type = type;
    light.instance = light.texture = MCV_NONE;
    light.to_world = to_world;
    BUILD(mcv_scene_add_emitter(scene, &light, &builder_error));
}

/* A spot light of an intensity of 1, and half-angles of its cone. */
static void add_spot(mcv_scene *scene, double inner, double outer, mcv_transform to_world) {
    mcv_emitter light = {0};
    mcv_params_set_defaults(mcv_emitter_table(MCV_EMITTER_SPOT), &light.as);
    for (int k = 0; k < 3; ++k) light.as.spot.intensity[k] = 1;
    light.as.spot.innerConeAngle = inner;
    light.as.spot.outerConeAngle = outer;
    add_light(scene, MCV_EMITTER_SPOT, light, to_world);
}

/* None of these reaches the middle of the floor from above. */
typedef enum unreachable {
    BELOW,
    TURNED_AWAY,
    NARROW_BESIDE,
    SPOT_ELSEWHERE,
    BELOW_AND_TILTED,
    UNREACHABLES
} unreachable;
static const char *const unreachable_names[] = {"a lamp below", "a lamp that shines away",
                                                "a narrow cone beside", "a spot light beside",
                                                "a tilted lamp below"};

static void add_unreachable(mcv_scene *scene, unreachable what) {
    const double s = sqrt(0.5);
    switch (what) {
    case BELOW:
        add_lamp(scene, looking_up_z(0, 0, -0.1), 300);
        return;
    case TURNED_AWAY:
        add_lamp(scene, looking_up_z(0.8, 0, 1), 300);
        return;
    case NARROW_BESIDE:
        add_emitter(scene, MCV_EMITTER_PARALLEL,
                    add_rectangle(scene, 0.5, 0.5, add_absorber(scene), looking_down_z(0.8, 0, 1)),
                    3e6, 1e-3);
        return;
    case SPOT_ELSEWHERE:
        add_spot(scene, 0.1, 0.2, looking_down_z(0.8, 0, 1));
        return;
    default: /* its corners stay 0.1 m below the floor */
        add_lamp(scene,
                 looking((const double[]){0, 0, -0.1 - 0.25 * s}, (const double[]){s, 0, s},
                         (const double[]){0, 1, 0}),
                 300);
    }
}

/* Lets light through. Where the test needs none it lies below the floor: all scenes share one
 * program. */
static uint32_t add_translucent(mcv_scene *scene, double share) {
    mcv_material material = {.texture = MCV_NONE};
    for (int k = 0; k < 3; ++k)
        material.as.diffuse.reflectance[k] = material.as.diffuse.transmittance[k] = share;
    return add_material(scene, MCV_MATERIAL_DIFFUSE, &material);
}

static mcv_scene *lit_floor(void) {
    mcv_scene *scene = mcv_scene_new("floor");
    add_rectangle(scene, 1, 1, add_diffuse(scene, 0.5), looking_up_z(0, 0, 0));
    add_lamp(scene, looking_down_z(0.2, 0, 1), 3);
    add_pinhole(scene, PIXELS, 0.1, looking_down_z(0, 0, 0.5));
    return scene;
}

static void set_dark(mcv_emitter *emitter) {
    for (int k = 0; k < 3; ++k) emitter->radiance[k] = 0;
}

/*
 * The same emitter is chosen with the same numbers: what changes is the density's rounding, some
 * ten times 2^-24. The others of them are there without light, and so is a ball below the floor:
 * all share their program with the lights that add up.
 */
static void test_what_cannot_reach(void **state) {
    mcv_scene *one = lit_floor();
    mcv_film alone;
    (void)state;
    render(one, 4, 16, 0, &alone);
    for (unreachable what = 0; what < UNREACHABLES; ++what) {
        mcv_scene *two = lit_floor();
        mcv_film both;
        for (unreachable other = 0; other < UNREACHABLES; ++other) {
            const uint32_t first = two->emitter_count;
            add_unreachable(two, other);
            if (other != what) set_dark(two->emitters + first);
        }
        add_sphere(two, 0.1, 16, add_translucent(two, 0.3), looking_down_z(0.1, 0, -2));
        render(two, 4, 16, 0, &both);
        double worst = 0;
        for (size_t i = 0; i < (size_t)4 * PIXELS * PIXELS; ++i)
            worst = fmax(worst, fabs(both.sums[i] / alone.sums[i] - 1));
        if (!(worst <= 2e-6))
            fail_msg("%s changes the floor by %.2g, at most 2e-6 expected", unreachable_names[what],
                     worst);
        mcv_film_free(&both);
        mcv_scene_free(two);
    }
    mcv_film_free(&alone);
    mcv_scene_free(one);
}

enum { LIGHTS = 7 };
typedef enum floor_kind { OPAQUE, TRANSLUCENT, GLOSSY, FLOORS } floor_kind;
static const char *const floor_names[] = {"opaque", "translucent", "glossy"};

static uint32_t add_rough_metal(mcv_scene *scene, double roughness) {
    mcv_material metal = {.texture = MCV_NONE};
    mcv_params_set_defaults(mcv_material_table(MCV_MATERIAL_CONDUCTOR), &metal.as);
    for (int k = 0; k < 3; ++k) {
        metal.as.conductor.n[k] = 1.1;
        metal.as.conductor.k[k] = 6.7;
    }
    metal.as.conductor.roughness = roughness;
    return add_material(scene, MCV_MATERIAL_CONDUCTOR, &metal);
}

/* Gloss above a base that scatters light, too. */
static uint32_t add_half_metal(mcv_scene *scene) {
    mcv_material paint = {.texture = MCV_NONE, .surface_texture = MCV_NONE};
    mcv_params_set_defaults(mcv_material_table(MCV_MATERIAL_METALLIC_ROUGHNESS), &paint.as);
    paint.as.metallic_roughness.metallic = 0.5;
    paint.as.metallic_roughness.roughness = 0.4;
    return add_material(scene, MCV_MATERIAL_METALLIC_ROUGHNESS, &paint);
}

static void add_one_of_many(mcv_scene *scene, int which) {
    const double s = sqrt(0.5);
    mcv_emitter sun = {0};
    switch (which) {
    case 0:
        add_lamp(scene, looking_down_z(0.3, 0.1, 0.8), 1);
        return;
    case 1:
        add_lamp(scene, looking_up_z(0, 0, -0.5), 1);
        return;
    case 2:
        add_lamp(scene,
                 looking((const double[]){-0.6, 0, 0.2}, (const double[]){s, 0, -s},
                         (const double[]){0, 1, 0}),
                 1);
        return;
    case 3: /* a box shines all around, from below the floor to above it */
        add_emitter(scene, MCV_EMITTER_AREA,
                    add_box(scene, (const double[]){0.05, 0.05, 0.2}, add_absorber(scene),
                            looking_down_z(0, 0.4, 0)),
                    1, 0);
        return;
    case 4:
        add_emitter(
            scene, MCV_EMITTER_PARALLEL,
            add_rectangle(scene, 0.3, 0.3, add_absorber(scene), looking_down_z(-0.1, 0, 0.9)), 5,
            0.2);
        return;
    case 5:
        add_spot(scene, 0.2, 0.4,
                 looking((const double[]){0.4, -0.3, 0.6}, (const double[]){-0.6, 0, -0.8},
                         (const double[]){0, 1, 0}));
        return;
    default:
        for (int k = 0; k < 3; ++k) sun.as.directional.irradiance[k] = 0.2;
        add_light(scene, MCV_EMITTER_DIRECTIONAL, sun,
                  looking((const double[]){0, 0, 0}, (const double[]){0, 0.6, -0.8},
                          (const double[]){1, 0, 0}));
    }
}

/* A floor of some kind, a ball of interpolated normals on it, and lights of all sorts around, all
 * or one. */
static mcv_scene *many_lights(floor_kind kind, int only) {
    mcv_scene *scene = mcv_scene_new("lights");
    const uint32_t opaque = add_diffuse(scene, 0.4), film = add_translucent(scene, 0.4);
    const uint32_t below = kind == TRANSLUCENT ? film
                           : kind == OPAQUE    ? opaque
                                               : add_rough_metal(scene, 0.4);
    add_rectangle(scene, 1, 1, below, looking_up_z(0, 0, 0));
    if (kind == OPAQUE) add_rectangle(scene, 0.1, 0.1, film, looking_up_z(0, 0, -2));
    add_sphere(scene, 0.1, 16, kind == GLOSSY ? add_half_metal(scene) : add_diffuse(scene, 0.6),
               looking_down_z(0.1, 0, 0.1));
    /* Bodies of lamps stay where their light is left out. */
    for (int i = 0; i < LIGHTS; ++i) {
        const uint32_t before = scene->emitter_count;
        add_one_of_many(scene, i);
        if (only < LIGHTS && only != i && scene->emitter_count > before)
            set_dark(scene->emitters + before);
    }
    add_pinhole(scene, PIXELS, 1, looking_down_z(0, 0, 0.75));
    return scene;
}

/* Light adds up: each alone is found without a choice. */
static void test_lights_add_up(void **state) {
    (void)state;
    for (floor_kind kind = GLOSSY_SURFACES ? GLOSSY : OPAQUE;
         kind < (GLOSSY_SURFACES ? FLOORS : GLOSSY); ++kind) {
        mcv_film all = {0}, one = {0}, sum = {0};
        mcv_comparison c;
        for (int i = 0; i <= LIGHTS; ++i) {
            mcv_scene *scene = many_lights(kind, i);
            mcv_film *film = i == 0 ? &sum : i == LIGHTS ? &all : &one;
            render(scene, 16, SAMPLES, 100 * (uint32_t)i, film);
            for (size_t k = 0; film == &one && k < (size_t)16 * PIXELS * PIXELS; ++k)
                sum.sums[k] += one.sums[k];
            if (film == &one) mcv_film_free(&one);
            mcv_scene_free(scene);
        }
        BUILD(mcv_compare_films(&all, &sum, &c, &builder_error));
        print_message("%s floor: means %.6g and %.6g; %s\n", floor_names[kind], c.mean_x, c.mean_y,
                      c.reason);
        if (c.different)
            fail_msg("%s floor under all lights and the sum of each: %s", floor_names[kind],
                     c.reason);
        mcv_film_free(&all);
        mcv_film_free(&sum);
    }
}

/* Sixteen small lamps in a ring, 45 degrees above the middle of a metal of α = 0.05, seen from as
 * high: one of them is where a mirror would have it. What is dark or below shares the program of
 * the glossy floor's lights. */
static mcv_scene *metal_in_a_ring(void) {
    enum { LAMPS = 16 };
    mcv_scene *scene = mcv_scene_new("ring");
    const double s = sqrt(0.5);
    add_rectangle(scene, 1, 1, add_rough_metal(scene, sqrt(0.05)), looking_up_z(0, 0, 0));
    add_sphere(scene, 0.1, 16, add_half_metal(scene), looking_down_z(0, 0, -2));
    for (int i = 0; i < LIGHTS; ++i) {
        add_one_of_many(scene, i);
        set_dark(scene->emitters + i);
    }
    for (int i = 0; i < LAMPS; ++i) {
        const double turn = 2 * M_PI * i / LAMPS, c = cos(turn), d = sin(turn);
        add_emitter(scene, MCV_EMITTER_AREA,
                    add_rectangle(scene, 0.005, 0.005, add_absorber(scene),
                                  looking((const double[]){s * c, s * d, s},
                                          (const double[]){-s * c, -s * d, -s},
                                          (const double[]){-d, c, 0})),
                    1, 0);
    }
    add_pinhole(scene, PIXELS, 0.001,
                looking((const double[]){-0.3 * s, 0, 0.3 * s}, (const double[]){s, 0, -s},
                        (const double[]){0, 1, 0}));
    return scene;
}

/*
 * Of lamps with the shares s_k of the light and the chances p_k, one random choice varies by Σ
 * s_k²/p_k - 1 of its square. The lamp in the mirror has the slope 0, those beside it 0.14 = 2.8 α
 * and so (1 + 2.8²)² = 78 times less light: it has 0.97 of all. In equal parts 0.97² 16 - 1 = 14
 * is expected; by what comes, of which a sixteenth is left to equal parts, at most 16/15 - 1 =
 * 0.07. Masking and Fresnel's factor, which the choice leaves out, only change the shares of the
 * others, 0.03 in all. The first samples of 1024 replicates and pixels are independent; they give a
 * variance to 5 %, three of which are 0.01: at most 0.08, and 0.1 with what a lamp varies in
 * itself.
 */
static void test_lobe_chooses(void **state) {
    enum { REPLICATES = 64, VALUES = REPLICATES * PIXELS * PIXELS };
    mcv_scene *scene = metal_in_a_ring();
    mcv_film film;
    double sum = 0, squares = 0;
    (void)state;
    render(scene, REPLICATES, 1, 0, &film);
    for (size_t i = 0; i < VALUES; ++i) {
        sum += film.sums[i];
        squares += film.sums[i] * film.sums[i];
    }
    const double mean = sum / VALUES;
    const double variance = (squares / VALUES - mean * mean) / (mean * mean);
    print_message("a sample varies by %.3g of its mean squared\n", variance);
    assert_true(mean > 0);
    if (!(variance < 0.1))
        fail_msg("a sample varies by %.3g of its mean squared, at most 0.1 expected", variance);
    mcv_film_free(&film);
    mcv_scene_free(scene);
}

int main(void) {
    const struct CMUnitTest even[] = {cmocka_unit_test(test_what_cannot_reach),
                                      cmocka_unit_test(test_lights_add_up)};
    const struct CMUnitTest glossy[] = {cmocka_unit_test(test_lights_add_up),
                                        cmocka_unit_test(test_lobe_chooses)};
    return GLOSSY_SURFACES ? cmocka_run_group_tests(glossy, NULL, NULL)
                           : cmocka_run_group_tests(even, NULL, NULL);
}
