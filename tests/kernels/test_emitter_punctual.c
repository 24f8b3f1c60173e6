/* SPDX-License-Identifier: Apache-2.0 */
/* Point, spot and directional light, given directly and by KHR_lights_punctual: closed forms,
 * units, power, what is refused. */
#include "image_emitters.h"

#include "scene/emitters.h"

static const double rho = 0.5;

/* A floor of 20 m at z = 0 that looks up, and a camera of a single pixel of 1 µm that looks at its
 * place (x, 0) from aside. */
static void add_floor(mcv_scene *scene) {
    add_rectangle(scene, 20, 20, add_diffuse(scene, rho), looking_up_z(0, 0, 0));
}

static double seen_at(mcv_scene *scene, double x, bool reference) {
    const double s = sqrt(0.5), from[3] = {x, -s, s}, forward[3] = {0, s, -s};
    add_pinhole(scene, 1, 1e-6, looking(from, forward, (const double[]){0, s, s}));
    mcv_film film = render_by(reference, scene, scene->sensor_count - 1, 1, 1);
    const double seen = mcv_film_mean(&film);
    mcv_film_free(&film);
    return seen;
}

static mcv_emitter light_of(uint32_t type, mcv_transform to_world) {
    mcv_emitter light = {.name = (char *)"light",
                         .type = type,
                         .instance = MCV_NONE,
                         .texture = MCV_NONE,
                         .to_world = to_world};
    mcv_params_set_defaults(mcv_emitter_table(type), &light.as);
    return light;
}

static void fill(double spectrum[3], double value) {
    for (int k = 0; k < 3; ++k) spectrum[k] = value;
}

/*
 * Each has no noise but that of the pixel's micrometre, over which the light changes by 1 µm times
 * `slope` (relative, 1/m); some 20 roundings of float32 make 2e-6.
 */
static void expect_at(const char *what, mcv_scene *scene, double x, double expected, double slope) {
    for (int reference = 0; reference < 2; ++reference) {
        const double seen = seen_at(scene, x, reference);
        if (!(fabs(seen - expected) <= (2e-6 + 1e-6 * slope) * expected))
            fail_msg("%s at x = %g m: %s %.9g, expected %.9g, off %.2g", what, x,
                     reference ? "reference" : "device", seen, expected, seen / expected - 1);
    }
}

/* E = I h/r³, times 1 - (r/R)⁴. */
static void test_point(void **state) {
    (void)state;
    static const double heights[] = {0.01, 0.3, 2}, offsets[] = {0, 0.1, 1.5}, ranges[] = {NAN, 2};
    for (int i = 0; i < 18; ++i) {
        const double h = heights[i % 3], x = offsets[i / 3 % 3], range = ranges[i / 9],
                     r = hypot(h, x);
        mcv_scene *scene = mcv_scene_new("point");
        mcv_emitter light = light_of(
            MCV_EMITTER_POINT, looking_up_z(0, 0, h)); /* which way it looks is of no account */
        fill(light.as.point.intensity, 7);
        light.as.point.range = range;
        add_floor(scene);
        BUILD(mcv_scene_add_emitter(scene, &light, &builder_error));
        const double left = isnan(range) ? 1 : fmax(0, 1 - pow(r / range, 4));
        expect_at("point", scene, x, rho / M_PI * 7 * h / pow(r, 3) * left,
                  4 / r + (left < 1 && left > 0 ? 4 / (left * range) : 0));
        mcv_scene_free(scene);
    }
}

/* Down from h with the axis at 0: E = I a² cos³θ/h². Narrow cones are wide on the floor when the
 * light is far up. */
static void test_spot(void **state) {
    (void)state;
    static const struct {
        double inner, outer, height;
    } cones[] = {{0, 0.78539816339744831, 1},
                 {0.3, 0.5, 1},
                 {0, 1.5707963267948966, 1},
                 {1e-3, 2e-3, 5},
                 {0, 1e-3, 5},
                 {0.19, 0.2, 2}};
    static const double places[] = {0, 0.3, 0.6, 0.9, 1.1};
    for (size_t i = 0; i < sizeof cones / sizeof cones[0]; ++i) {
        for (size_t k = 0; k < sizeof places / sizeof places[0]; ++k) {
            const double h = cones[i].height, theta = fmin(places[k] * cones[i].outer, 1.2),
                         x = h * tan(theta);
            mcv_scene *scene = mcv_scene_new("spot");
            mcv_emitter light = light_of(MCV_EMITTER_SPOT, looking_down_z(0, 0, h));
            fill(light.as.spot.intensity, 7);
            light.as.spot.innerConeAngle = cones[i].inner;
            light.as.spot.outerConeAngle = cones[i].outer;
            add_floor(scene);
            BUILD(mcv_scene_add_emitter(scene, &light, &builder_error));
            /* (cosθ - cosθ_o)/(cosθ_i - cosθ_o) by sums to products, which loses no digits. */
            const double o = cones[i].outer, n = cones[i].inner;
            const double a =
                sin((o + theta) / 2) * sin((o - theta) / 2) / (sin((o + n) / 2) * sin((o - n) / 2));
            const double share = pow(fmin(fmax(a, 0), 1), 2);
            /*
             * Along x, a² changes by 2 a'/(a h) with a' = sinθ/(cosθ_i - cosθ_o); the direction is
             * known to some 2e-7 in float32, which is less than 1 µm/h for heights of 1 to 5 m.
             */
            const double slope =
                a > 0 && a < 1 ? 2 / a * sin(theta) / (2 * sin((o + n) / 2) * sin((o - n) / 2)) : 0;
            expect_at("spot", scene, x, rho / M_PI * 7 * share * pow(cos(theta), 3) / (h * h),
                      4 / h + slope);
            mcv_scene_free(scene);
        }
    }
}

/* Inner and outer cone the same: full inside, dark outside. */
static void test_sharp_spot(void **state) {
    (void)state;
    static const double places[] = {0, 0.5, 0.99, 1.01, 1.5};
    for (size_t k = 0; k < sizeof places / sizeof places[0]; ++k) {
        const double theta = places[k] * 0.3;
        mcv_scene *scene = mcv_scene_new("sharp");
        mcv_emitter light = light_of(MCV_EMITTER_SPOT, looking_down_z(0, 0, 1));
        fill(light.as.spot.intensity, 7);
        light.as.spot.innerConeAngle = light.as.spot.outerConeAngle = 0.3;
        add_floor(scene);
        BUILD(mcv_scene_add_emitter(scene, &light, &builder_error));
        expect_at("sharp spot", scene, tan(theta),
                  places[k] < 1 ? rho / M_PI * 7 * pow(cos(theta), 3) : 0, 4);
        mcv_scene_free(scene);
    }
}

/*
 * A lamp of 4 pi 1e-10 W 10 mm over the floor and one of 4 pi W a kilometre up light it alike: what
 * is chosen by power alone would leave out the former. Each has no noise; that of the choice
 * between them shows in the replicates.
 */
static void test_dim_beside_bright(void **state) {
    (void)state;
    const double expected = rho / M_PI * (1e-10 / 1e-4 + 1 / 1e6);
    mcv_scene *scene = mcv_scene_new("dim and bright");
    add_floor(scene);
    for (int i = 0; i < 2; ++i) {
        mcv_emitter light = light_of(MCV_EMITTER_POINT, looking_up_z(0, 0, i ? 1000 : 0.01));
        fill(light.as.point.intensity, i ? 1 : 1e-10);
        BUILD(mcv_scene_add_emitter(scene, &light, &builder_error));
    }
    const double s = sqrt(0.5);
    add_pinhole(
        scene, 1, 1e-6,
        looking((const double[]){0, -s, s}, (const double[]){0, s, -s}, (const double[]){0, s, s}));
    mcv_film film = render_by(false, scene, 0, 1024, 1);
    expect_estimate("dim beside bright", image_estimate(&film), expected, 0.05, 1e-5);
    mcv_film_free(&film);
    mcv_scene_free(scene);
}

static void test_directional(void **state) {
    (void)state;
    for (int i = 0; i < 4; ++i) {
        const double tilt = 0.3 * i, forward[3] = {sin(tilt), 0, -cos(tilt)};
        mcv_scene *scene = mcv_scene_new("sun");
        mcv_emitter light =
            light_of(MCV_EMITTER_DIRECTIONAL,
                     looking((const double[]){0, 0, -3}, forward, (const double[]){0, 1, 0}));
        fill(light.as.directional.irradiance, 7);
        add_floor(scene);
        BUILD(mcv_scene_add_emitter(scene, &light, &builder_error));
        expect_at("directional", scene, 0.2, rho / M_PI * 7 * cos(tilt), 0);
        /* A plate a metre up throws its shadow aside: by tan(tilt). */
        add_rectangle(scene, 0.1, 0.1, add_absorber(scene), looking_down_z(0.2 - tan(tilt), 0, 1));
        for (int reference = 0; reference < 2; ++reference)
            assert_true(seen_at(scene, 0.2, reference) == 0);
        expect_at("directional, beside the shadow", scene, 0.26, rho / M_PI * 7 * cos(tilt), 0);
        mcv_scene_free(scene);
    }
}

/* Mean and error over the replicates of a scene with one of each, and a parallel and an area
 * emitter: the chances of the choice add up. */
static void test_all_together(void **state) {
    (void)state;
    mcv_scene *scene = mcv_scene_new("together");
    /* Some of each light's watts: emitters are chosen by power, of the directional one by what
     * falls on a ball around the floor. */
    add_rectangle(scene, 2, 2, add_diffuse(scene, rho), looking_up_z(0, 0, 0));
    add_box(scene, (const double[]){0.05, 0.02, 0.1}, add_diffuse(scene, 0.7),
            looking_up_z(-0.1, 0, 0.1));
    mcv_emitter point = light_of(MCV_EMITTER_POINT, looking_up_z(0.2, 0, 0.4)),
                spot = light_of(MCV_EMITTER_SPOT, looking_down_z(-0.2, 0.1, 0.5));
    mcv_emitter sun = light_of(MCV_EMITTER_DIRECTIONAL,
                               looking((const double[]){0, 0, 0}, (const double[]){0.6, 0, -0.8},
                                       (const double[]){0, 1, 0}));
    fill(point.as.point.power, 1);
    fill(spot.as.spot.power, 0.3);
    fill(sun.as.directional.irradiance, 0.2);
    BUILD(mcv_scene_add_emitter(scene, &point, &builder_error));
    BUILD(mcv_scene_add_emitter(scene, &spot, &builder_error));
    BUILD(mcv_scene_add_emitter(scene, &sun, &builder_error));
    add_emitter(scene, MCV_EMITTER_AREA,
                add_rectangle(scene, 0.1, 0.1, add_absorber(scene), looking_down_z(0, 0.2, 0.6)),
                20, 0);
    add_emitter(scene, MCV_EMITTER_PARALLEL,
                add_rectangle(scene, 0.3, 0.3, add_absorber(scene), looking_down_z(0, 0, 0.7)),
                3000, 0.02);
    add_environment(scene, 0.05);
    add_pinhole(scene, 8, 0.6,
                looking((const double[]){0, -0.6, 0.45}, (const double[]){0, 0.8, -0.6},
                        (const double[]){0, 0.6, 0.8}));
    /* As many samples for both: replicates of few are skewed, and the rank test would see that. */
    mcv_film film = render_by(false, scene, 0, 64, 1), expected = render_by(true, scene, 0, 64, 2);
    expect_same_picture("all together", &film, &expected);
    mcv_film_free(&film);
    mcv_film_free(&expected);
    mcv_scene_free(scene);
}

/* A cone of 0.3 rad lights a disk of 0.12 m on the wall of expect_power, which a telecentric camera
 * sees whole. */
static void test_power_arrives(void **state) {
    (void)state;
    static const double power[3] = {1, 2, 0.25};
    char *text = rig_text(
        "", "\"type\":\"spot\",\"innerConeAngle\":0.1,\"outerConeAngle\":0.3,\"power\":[1,2,0.25]",
        ONE_PIXEL, 0.1, "beam.png");
    char *image = strstr(text, "\"images\"");
    memset(image, ' ', (size_t)(strstr(image, "],") + 2 - image));
    expect_power(text, power, 0.14, 0, "spot");
    free(text);

    /* Power and intensity agree with the integral over the cone, here by the midpoint rule: its
     * error falls as 1/steps². */
    enum { STEPS = 100000 };
    mcv_emitter spot = light_of(MCV_EMITTER_SPOT, looking_up_z(0, 0, 0));
    spot.as.spot.innerConeAngle = 0.4;
    spot.as.spot.outerConeAngle = 1.1;
    double integral = 0;
    for (int i = 0; i < STEPS; ++i) {
        const double theta = 1.1 * (i + 0.5) / STEPS,
                     a = (cos(theta) - cos(1.1)) / (cos(0.4) - cos(1.1));
        integral += pow(fmin(a, 1), 2) * 2 * M_PI * sin(theta) * 1.1 / STEPS;
    }
    if (!(fabs(mcv_emitter_unit_power(NULL, &spot) - integral) <= 1e-8 * integral))
        fail_msg("power of unit intensity is %.12g, expected %.12g",
                 mcv_emitter_unit_power(NULL, &spot), integral);
}

#define KHR(lights, node) \
    "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0]}]," \
    "\"extensionsRequired\":[\"KHR_lights_punctual\"]," \
    "\"extensionsUsed\":[\"KHR_lights_punctual\"],\"extensions\":{\"KHR_lights_punctual\":{" \
    "\"lights\":[" lights "]}}," \
    "\"nodes\":[{\"name\":\"lamp\",\"translation\":[1,2,3],\"rotation\":[0,1,0,0],\"scale\":[2,2," \
    "2]," \
    "\"extensions\":{\"KHR_lights_punctual\":" node "}}]}"

/* candela/683 is W/sr, lux/683 W/m²; the node's -z, here +z of the world, is where a light looks;
 * scale has no effect. */
static void test_khr_lights_punctual(void **state) {
    (void)state;
    mcv_scene *scene;
    BUILD(load_text("khr.gltf",
                    KHR("{\"type\":\"spot\",\"intensity\":1366,\"color\":[1,0.5,0],\"range\":4,"
                        "\"spot\":{\"innerConeAngle\":0.1}}",
                        "{\"light\":0,\"extras\":1}"),
                    NULL, &scene, &builder_error));
    assert_int_equal(scene->emitter_count, 1);
    const mcv_emitter *light = scene->emitters;
    assert_int_equal(light->type, MCV_EMITTER_SPOT);
    assert_string_equal(light->name, "lamp");
    for (int k = 0; k < 3; ++k) assert_true(fabs(light->radiance[k] - (2 - k)) < 1e-12);
    assert_true(light->as.spot.range == 4 && light->as.spot.innerConeAngle == 0.1 &&
                light->as.spot.outerConeAngle == 0.78539816339744831);
    assert_true(light->to_world.m[9] == 1 && light->to_world.m[10] == 2 &&
                light->to_world.m[11] == 3);
    assert_true(fabs(light->to_world.m[8] + 1) < 1e-12);
    mcv_scene_free(scene);

    /* What Blender writes for a spot without a soft edge that is as wide as can be: half of
     * float32's pi, which is more than pi/2. */
    BUILD(load_text("khr.gltf",
                    KHR("{\"type\":\"spot\",\"spot\":{\"innerConeAngle\":1.5707963705062866,"
                        "\"outerConeAngle\":1.5707963705062866}}",
                        "{\"light\":0}"),
                    NULL, &scene, &builder_error));
    assert_true(scene->emitters->as.spot.innerConeAngle == M_PI / 2 &&
                scene->emitters->as.spot.outerConeAngle == M_PI / 2);
    mcv_scene_free(scene);

    BUILD(load_text(
        "khr.gltf",
        KHR("{\"type\":\"point\"},{\"name\":\"sun\",\"type\":\"directional\",\"intensity\":68300}",
            "{\"light\":1}"),
        NULL, &scene, &builder_error));
    assert_int_equal(scene->emitter_count, 1);
    assert_int_equal(scene->emitters[0].type, MCV_EMITTER_DIRECTIONAL);
    assert_string_equal(scene->emitters[0].name, "sun");
    assert_true(fabs(scene->emitters[0].radiance[0] - 100) < 1e-10);
    mcv_scene_free(scene);
}

static void test_bad_input(void **state) {
    (void)state;
    static const bad_emitter cases[] = {
        {"\"type\":\"point\"", "emitters/e: needs intensity [W/sr] or power [W]"},
        {"\"type\":\"point\",\"intensity\":1,\"power\":1",
         "emitters/e: has both intensity 1 and power 1"},
        {"\"type\":\"point\",\"radiance\":1", "emitters/e: unknown key \"radiance\""},
        {"\"type\":\"point\",\"intensity\":1,\"range\":0", "emitters/e/range: 0 must be above 0"},
        {"\"type\":\"spot\",\"intensity\":1,\"outerConeAngle\":\"91deg\"",
         "emitters/e/outerConeAngle: "},
        {"\"type\":\"spot\",\"intensity\":1,\"innerConeAngle\":1",
         "emitters/e/innerConeAngle: 1 rad must be at most outerConeAngle 0.785"},
        {"\"type\":\"directional\"", "emitters/e/irradiance: is missing"},
        {"\"type\":\"directional\",\"irradiance\":-1", "emitters/e/irradiance: -1 must lie from 0"},
    };
    static const struct {
        const char *text, *says;
    } lights[] = {
        {KHR("{\"intensity\":1}", "{\"light\":0}"),
         "KHR_lights_punctual/lights/0/type: is missing: one of point"},
        {KHR("{\"type\":\"area\"}", "{\"light\":0}"),
         "lights/0/type: unknown type \"area\": known are point, spot, directional"},
        {KHR("{\"name\":\"l\",\"type\":\"point\",\"intensity\":-1}", "{\"light\":0}"),
         "lights/l/intensity: "},
        {KHR("{\"type\":\"point\",\"color\":[1,1]}", "{\"light\":0}"), "lights/0/color: "},
        {KHR("{\"type\":\"point\",\"range\":0}", "{\"light\":0}"), "lights/0/range: "},
        {KHR("{\"type\":\"spot\",\"spot\":{\"outerConeAngle\":1.6}}", "{\"light\":0}"),
         "lights/0/spot/outerConeAngle: "},
        {KHR("{\"type\":\"spot\",\"spot\":{\"innerConeAngle\":0.8}}", "{\"light\":0}"),
         "lights/0/innerConeAngle: 0.8 rad must be at most outerConeAngle 0.785"},
        {KHR("{\"type\":\"spot\",\"spot\":7}", "{\"light\":0}"),
         "lights/0/spot: must be an object"},
        {KHR("{\"type\":\"spot\"}", "{\"light\":0}"), "lights/0/spot: is missing"},
        {KHR("7", "{\"light\":0}"), "lights/0: must be an object"},
        {KHR("{\"type\":\"point\"}", "{\"light\":1}"),
         "nodes/lamp/extensions/KHR_lights_punctual/light: "},
        {KHR("{\"type\":\"point\"}", "{}"),
         "nodes/lamp/extensions/KHR_lights_punctual: must have the index \"light\""},
    };
    refuse_emitters(cases, sizeof cases / sizeof cases[0], "beam.png");
    for (size_t i = 0; i < sizeof lights / sizeof lights[0]; ++i)
        must_refuse("khr.gltf", lights[i].text, lights[i].says);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_point),         cmocka_unit_test(test_spot),
        cmocka_unit_test(test_sharp_spot),    cmocka_unit_test(test_dim_beside_bright),
        cmocka_unit_test(test_directional),   cmocka_unit_test(test_all_together),
        cmocka_unit_test(test_power_arrives), cmocka_unit_test(test_khr_lights_punctual),
        cmocka_unit_test(test_bad_input),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
