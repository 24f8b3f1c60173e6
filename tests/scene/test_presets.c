/* SPDX-License-Identifier: Apache-2.0 */
/* Ring, bar, dome and coaxial: the power and the irradiance that their manual pages promise, by
 * closed forms; what is refused. */
#include "reference_checks.h"
#include "scene_files.h"

#include "render/render.h"
#include "scene/emitters.h"

static const double reflectance = 0.5;

/* The light on its node, turned and moved, which nothing may depend on; scaled, which sizes do not
 * follow. */
static const double at[3] = {0.3, -0.2, 0.7};
static const double sides[3][3] = {
    {0.8, 0, -0.6}, {0, 1, 0}, {0.6, 0, 0.8}}; /* the node's axes: the rotation below */

static char *rig(const char *emitter, const char *node) {
    return text_of("{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0]}],"
                   "\"nodes\":[{\"name\":\"light\",%s"
                   "\"translation\":[0.3,-0.2,0.7],\"rotation\":[0,%.17g,0,%.17g],\"extensions\":{"
                   "\"MCVISI_emitters\":{\"emitter\":0}}}],"
                   "\"extensions\":{\"MCVISI_emitters\":{\"emitters\":[{\"name\":\"e\",%s}]}}}",
                   node, sqrt(0.1), sqrt(0.9), emitter);
}

static void in_world(const double p[3], double out[3]) {
    for (int k = 0; k < 3; ++k)
        out[k] = at[k] + p[0] * sides[0][k] + p[1] * sides[1][k] + p[2] * sides[2][k];
}

static mcv_scene *load(const char *emitter) {
    mcv_scene *scene;
    char *text = rig(emitter, "\"scale\":[2,3,4],");
    BUILD(load_text("preset.gltf", text, NULL, &scene, &builder_error));
    free(text);
    return scene;
}

/* Adds a diffuse plate at (0, 0, -h) of the node, facing the light, and a camera at `from` that
 * looks at its middle. */
static void look_at_plate(mcv_scene *scene, double h, double size, const double from[3]) {
    double eye[3], target[3];
    in_world(from, eye);
    in_world((const double[3]){0, 0, -h}, target);
    const mcv_transform plate =
        looking(target, sides[2], sides[1]); /* its front, -z of it, looks along the node's +z */
    add_rectangle(scene, size, size, add_diffuse(scene, reflectance), plate);
    add_spot_camera(scene, eye, target, 1e-4);
}

/* Rays that meet the light by chance only need many. */
static uint64_t samples_of(const char *emitter) {
    if (!strstr(emitter, "coaxial")) return 1 << 10;
    return strstr(emitter, "halfAngle") ? 1 << 16 : 1 << 14;
}

/* Both renderers must see ρ E/π, E being known within `slack`, its relative error. */
static void expect_irradiance(const char *emitter, double h, double size, const double from[3],
                              double irradiance, double slack, const char *what) {
    mcv_scene *scene = load(emitter);
    look_at_plate(scene, h, size, from);
    const double radiance = reflectance * irradiance / M_PI;
    for (int reference = 0; reference < 2; ++reference) {
        mcv_render_options options = mcv_render_defaults();
        mcv_render_stats stats = {0};
        mcv_film film = {0};
        char name[96];
        options.replicates = REPLICATES;
        options.last = samples_of(emitter);
        options.seed = 1;
        /* The closed form is of light that comes straight: what plate and splitter throw back and
         * forth adds 0.0015 of it at most. */
        if (strstr(emitter, "coaxial")) options.depth = 3;
        BUILD((reference ? mcv_reference_render : mcv_render)(scene, 0, &options, &film, &stats,
                                                              &builder_error));
        const mcv_estimate estimate = film_estimate(&film, 0, 1);
        snprintf(name, sizeof name, "%s, %s", what, reference ? "reference" : "device");
        if (irradiance > 0) {
            check_mean(name, estimate, radiance, slack * radiance);
            /* It must be known well enough to tell. */
            if (!(sqrt(estimate.variance) <= 0.01 * radiance))
                fail_msg("%s: standard error %g of %g", name, sqrt(estimate.variance), radiance);
        } else {
            check(name, estimate.mean, 0, 0);
        }
        mcv_film_free(&film);
    }
    mcv_scene_free(scene);
}

/*
 * On the axis at depth h, on a plane that faces the ring: ∫ L cosθ_e cosθ_r/d² 2πr ds over the
 * band, by Simpson's rule; 0 where it emits into a cone that ends before. With 1000 steps its error
 * is below 1e-9.
 */
static double ring_irradiance(double inner, double outer, double tilt, double half_angle,
                              double h) {
    enum { STEPS = 1000 };
    const double middle = (inner + outer) / 4, half = (outer - inner) / 4;
    double sum = 0;
    for (int i = 0; i <= STEPS; ++i) {
        const double s = half * (2.0 * i / STEPS - 1), r = middle + s * cos(tilt),
                     z = -s * sin(tilt) + h, d2 = r * r + z * z;
        const double emitted = (r * sin(tilt) + z * cos(tilt)) / sqrt(d2),
                     received = z / sqrt(d2); /* normal: (-sin, -cos) */
        if (emitted <= cos(half_angle) || received <= 0) continue;
        sum += (i == 0 || i == STEPS ? 1 : i % 2 ? 4 : 2) * emitted * received / d2 * r;
    }
    return sum / (3 * STEPS) * 2 * half * 2 * M_PI;
}

/* Sides of length 2π/128 r of a circle: what a facet's normal and its place are off by, relatively,
 * is at most the half-step squared. */
static const double facets = (M_PI / 128) * (M_PI / 128);

static void test_ring(void **state) {
    static const double through[3] = {0, 0, 0.3};
    const double inner = 0.04, outer = 0.07, h = 0.05;
    (void)state;
    /* Flat: closed form. The polygons have the circles' areas, what is left is of second order in
     * `facets`. */
    const double ro = outer * outer / 4, ri = inner * inner / 4,
                 form = M_PI * (ro / (ro + h * h) - ri / (ri + h * h));
    check("Simpson's rule", ring_irradiance(inner, outer, 0, M_PI / 2, h), form, 1e-9 * form);
    expect_irradiance(
        "\"type\":\"ring\",\"innerDiameter\":0.04,\"outerDiameter\":\"70mm\",\"radiance\":3", h,
        0.5, through, 3 * form, facets * facets + 1e-6, "flat ring");
    const double area = M_PI * (ro - ri);
    expect_irradiance("\"type\":\"ring\",\"innerDiameter\":0.04,\"outerDiameter\":0.07,\"power\":2",
                      h, 0.5, through, 2 / (M_PI * area) * form, facets * facets + 1e-6,
                      "flat ring of 2 W");
    expect_irradiance("\"type\":\"ring\",\"innerDiameter\":0.04,\"outerDiameter\":0.07,\"tilt\":"
                      "\"40deg\",\"power\":2",
                      h, 0.5, through,
                      2 / (M_PI * area) *
                          ring_irradiance(inner, outer, 40 * M_PI / 180, M_PI / 2, h),
                      2 * facets, "tilted ring of 2 W");
    expect_irradiance("\"type\":\"ring\",\"innerDiameter\":0.04,\"outerDiameter\":0.07,\"tilt\":"
                      "\"90deg\",\"radiance\":1",
                      0.02, 0.5, through, ring_irradiance(inner, outer, M_PI / 2, M_PI / 2, 0.02),
                      2 * facets, "low-angle ring");
    /* The middle circle's normals, at 40°, meet the axis 33 mm away; at 50 mm they miss by 11°,
     * those of the edges by 0° and 19°. */
    const double cone = 30 * M_PI / 180, sine = sin(cone);
    expect_irradiance("\"type\":\"ring\",\"innerDiameter\":0.04,\"outerDiameter\":0.07,\"tilt\":"
                      "\"40deg\",\"power\":2,\"halfAngle\":\"30deg\"",
                      h, 0.5, through,
                      2 / (M_PI * sine * sine * area) *
                          ring_irradiance(inner, outer, 40 * M_PI / 180, cone, h),
                      2 * facets, "ring of directed LEDs");
    expect_irradiance("\"type\":\"ring\",\"innerDiameter\":0.04,\"outerDiameter\":0.07,\"power\":2,"
                      "\"halfAngle\":\"10deg\"",
                      h, 0.5, through, 0, 0, "ring of LEDs that point past the axis");
}

/* A rectangle above its middle: Hottel and Sarofim's view factor of a corner, four times. */
static void test_bar(void **state) {
    static const double aside[3] = {0.3, 0.1, 0.2};
    const double h = 0.08, x = 0.1 / h, y = 0.01 / h, p = sqrt(1 + x * x), q = sqrt(1 + y * y);
    const double form = 2 * (x / p * atan(y / p) + y / q * atan(x / q));
    (void)state;
    expect_irradiance("\"type\":\"bar\",\"length\":\"200mm\",\"width\":\"20mm\",\"radiance\":3", h,
                      0.5, aside, 3 * form, 1e-6, "bar");
    expect_irradiance("\"type\":\"bar\",\"length\":\"200mm\",\"width\":\"20mm\",\"power\":3", h,
                      0.5, aside, 3 / (M_PI * 0.2 * 0.02) * form, 1e-6, "bar of 3 W");
    /* A cone sees the whole width and the length's 2 h tanβ; on the axis the bar is a strip of the
     * disk. Within: the cone of 5° holds a disk of radius 7 mm, which the bar's half-width of 10 mm
     * holds: E = π L sin²β = P/A. */
    expect_irradiance("\"type\":\"bar\",\"length\":\"200mm\",\"width\":\"20mm\",\"power\":3,"
                      "\"halfAngle\":\"5deg\"",
                      h, 0.5, aside, 3 / (0.2 * 0.02), 1e-6, "bar of directed LEDs");
}

static void test_dome(void **state) {
    static const double through[3] = {0, 0, 0.3};
    const double diameter = 0.12, hole = 0.02,
                 form = M_PI * (1 - hole * hole / (diameter * diameter));
    /* Chords of 24 steps along a quarter circle and sides of 128-gons are shorter than their arcs
     * by a 24th and a 6th of step and half-step squared. */
    const double area = M_PI * diameter * sqrt(diameter * diameter - hole * hole) / 2,
                 short_by = pow(M_PI / 48, 2) / 24 + facets;
    (void)state;
    expect_irradiance(
        "\"type\":\"dome\",\"diameter\":\"120mm\",\"holeDiameter\":\"20mm\",\"radiance\":3", 0,
        0.01, through, 3 * form, 1e-6, "dome");
    expect_irradiance(
        "\"type\":\"dome\",\"diameter\":\"120mm\",\"holeDiameter\":\"20mm\",\"power\":3", 0, 0.01,
        through, 3 / (M_PI * area) * form, short_by, "dome of 3 W");
    /* Its outside is dark: a camera beside the hole sees nothing. */
    mcv_scene *scene =
        load("\"type\":\"dome\",\"diameter\":\"120mm\",\"holeDiameter\":\"20mm\",\"radiance\":3");
    double eye[3], target[3];
    in_world((const double[3]){0.03, 0, 0.3}, eye);
    in_world((const double[3]){0.03, 0, 0}, target);
    add_spot_camera(scene, eye, target, 1e-4);
    mcv_render_stats stats;
    check("outside of the dome", render_mean(scene, 16, 8, true, &stats).mean, 0, 0);
    mcv_scene_free(scene);
}

/*
 * The half mirror shows the panel turned, 0.55 of the height above the window's middle, and cuts
 * off nothing: E is r times a rectangle's there. Beside it the plate sees the panel itself, upright
 * at the distance d and from z1 to z2 above the plate: the view factor of a rectangle that stands
 * on the plane is that of half-width a up to z2 less that up to z1. A cone that both leave whole: E
 * = r π L sin²β. Rays find the panel in the mirror by chance only.
 */
static void test_coaxial(void **state) {
    static const double aside[3] = {0.3, 0, 0.1}, above[3] = {0.002, 0.001, 0.3};
    const double width = 0.04, height = 0.05, h = 0.06, d = 0.55 * height, depth = h + d,
                 x = width / 2 / depth, y = height / 2 / depth;
    const double p = sqrt(1 + x * x), q = sqrt(1 + y * y),
                 turned = 2 * (x / p * atan(y / p) + y / q * atan(x / q));
    const double low = hypot(d, h - height / 2), high = hypot(d, h + height / 2);
    const double upright = d / low * atan(width / 2 / low) - d / high * atan(width / 2 / high);
    (void)state;
    expect_irradiance("\"type\":\"coaxial\",\"size\":[0.04,0.05],\"reflectance\":0.3,"
                      "\"transmittance\":0.6,\"radiance\":2",
                      h, 0.5, aside, 2 * (0.3 * turned + upright), 1e-6, "coaxial");
    expect_irradiance("\"type\":\"coaxial\",\"size\":[0.04,0.05],\"power\":2", h, 0.5, aside,
                      2 / (M_PI * width * height) * (0.5 * turned + upright), 1e-6,
                      "coaxial of 2 W");
    expect_irradiance("\"type\":\"coaxial\",\"size\":[0.04,0.05],\"power\":2,\"halfAngle\":0.2", h,
                      0.5, aside, 0.5 * 2 / (width * height), 1e-6, "directed coaxial of 2 W");

    mcv_scene *scene = load("\"type\":\"coaxial\",\"size\":[0.04,0.05],\"reflectance\":0.3,"
                            "\"transmittance\":0.6,\"radiance\":2,\"halfAngle\":0.1");
    double eye[3], target[3];
    mcv_render_stats stats;
    in_world(above, eye);
    in_world((const double[3]){0.002, 0.001, -h}, target);
    const mcv_material silver = {.as.mirror.reflectance = {1, 1, 1}};
    add_rectangle(scene, 0.1, 0.1, add_material(scene, MCV_MATERIAL_MIRROR, &silver),
                  looking(target, sides[2], sides[1]));
    add_spot_camera(scene, eye, target, 1e-4);
    check_mean("a mirror under a coaxial light", render_mean(scene, 4096, 8, true, &stats),
               0.3 * 0.6 * 2, 0);
    mcv_scene_free(scene);
}

/* exitance π sin²β L times area: what all of it emits. */
static void test_power(void **state) {
    static const struct {
        const char *emitter;
        double power[3], area, slack; /* of the area, relative */
    } cases[] = {
        {"\"type\":\"ring\",\"innerDiameter\":0.04,\"outerDiameter\":0.07,\"power\":2",
         {2, 2, 2},
         M_PI / 4 * (0.07 * 0.07 - 0.04 * 0.04),
         1e-6},
        {"\"type\":\"ring\",\"innerDiameter\":0.04,\"outerDiameter\":0.07,\"power\":[1,2,0.5],"
         "\"tilt\":\"60deg\",\"halfAngle\":\"20deg\"",
         {1, 2, 0.5},
         M_PI / 4 * (0.07 * 0.07 - 0.04 * 0.04),
         1e-3},
        {"\"type\":\"bar\",\"length\":0.2,\"width\":0.02,\"power\":4,\"halfAngle\":0.01",
         {4, 4, 4},
         0.004,
         1e-6},
        {"\"type\":\"dome\",\"diameter\":0.12,\"holeDiameter\":0.02,\"power\":5",
         {5, 5, 5},
         0.06 * M_PI * 0.118321595661992,
         2e-3},
    };
    (void)state;
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        mcv_scene *scene = load(cases[i].emitter);
        assert_int_equal(scene->emitter_count, 1);
        const mcv_emitter *emitter = scene->emitters;
        for (int k = 0; k < 3; ++k)
            check("power",
                  emitter->radiance[k] * mcv_emitter_projected_solid_angle(emitter) * emitter->area,
                  cases[i].power[k], 1e-14 * 5);
        check("area", emitter->area, cases[i].area, cases[i].slack * cases[i].area);
        mcv_scene_free(scene);
    }
}

static void test_bad_input(void **state) {
    static const struct {
        const char *emitter, *node, *says;
    } cases[] = {
        {"\"type\":\"rign\"", "", "emitters/e/type: unknown type \"rign\": did you mean \"ring\"?"},
        {"\"type\":\"hemisphericalSpot\"", "", "ring, bar, dome, coaxial"},
        {"\"type\":\"ring\",\"radiance\":1", "", "emitters/e/innerDiameter: is missing"},
        {"\"type\":\"ring\",\"innerDiameter\":0.1,\"outerDiameter\":0.1,\"radiance\":1", "",
         "emitters/e/innerDiameter: 0.1 m must be less than outerDiameter, 0.1 m"},
        {"\"type\":\"ring\",\"innerDiameter\":0.1,\"outerDiameter\":0.2", "",
         "emitters/e: needs radiance"},
        {"\"type\":\"ring\",\"innerDiameter\":0.1,\"outerDiameter\":0.2,\"radiance\":1,\"power\":1",
         "", "emitters/e: has both radiance"},
        {"\"type\":\"ring\",\"innerDiameter\":0.1,\"outerDiameter\":0.2,\"radiance\":-1", "",
         "emitters/e/radiance: -1 "},
        {"\"type\":\"ring\",\"innerDiameter\":0.1,\"outerDiameter\":0.2,\"radiance\":1,\"tilt\":"
         "\"91deg\"",
         "", "emitters/e/tilt: "},
        {"\"type\":\"ring\",\"innerDiameter\":0.1,\"outerDiameter\":0.2,\"radiance\":1,\"size\":1",
         "", "emitters/e: unknown key \"size\""},
        {"\"type\":\"ring\",\"innerDiameter\":0.1,\"outerDiameter\":0.2,\"radiance\":1,"
         "\"halfAngle\":0",
         "", "emitters/e/halfAngle: 0 is"},
        {"\"type\":\"bar\",\"length\":0.1,\"width\":0.2,\"radiance\":1,\"halfAngle\":\"91deg\"", "",
         "emitters/e/halfAngle: "},
        {"\"type\":\"bar\",\"length\":0.1,\"width\":0,\"radiance\":1", "",
         "emitters/e/width: 0 must be above 0"},
        {"\"type\":\"coaxial\",\"radiance\":1", "", "emitters/e/size: is missing"},
        {"\"type\":\"coaxial\",\"size\":0.1,\"reflectance\":0.6,\"radiance\":1", "",
         "emitters/e/transmittance: 0.5 and reflectance 0.6"},
        {"\"type\":\"dome\",\"diameter\":0.1,\"holeDiameter\":0.2,\"radiance\":1", "",
         "emitters/e/holeDiameter: 0.2 m must be less than diameter"},
        {"\"type\":\"dome\",\"diameter\":0.1,\"holeDiameter\":0.02,\"radiance\":1,\"halfAngle\":1",
         "", "unknown key \"halfAngle\""},
        {"\"type\":\"dome\",\"diameter\":0.1,\"holeDiameter\":0.02,\"radiance\":1",
         "\"scale\":[0,0,0],", "scale must not be 0"},
    };
    (void)state;
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        char *text = rig(cases[i].emitter, cases[i].node);
        must_refuse("preset_bad.gltf", text, cases[i].says);
        free(text);
    }
    /* On a node that has a mesh. */
    must_refuse("preset_bad.gltf",
                "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0]}],"
                "\"nodes\":[{\"name\":\"light\",\"mesh\":0,"
                "\"extensions\":{\"MCVISI_emitters\":{\"emitter\":0}}}],"
                "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0}}]}],"
                "\"accessors\":[{\"componentType\":5126,\"type\":\"VEC3\",\"count\":3,\"min\":[0,0,"
                "0],\"max\":[0,0,0]}],"
                "\"extensions\":{\"MCVISI_emitters\":{\"emitters\":[{\"name\":\"e\",\"type\":"
                "\"bar\",\"length\":1,\"width\":1,\"radiance\":1}]}}}",
                "emitters/e: a bar has a shape of its own, but node \"light\" has a mesh");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_power),   cmocka_unit_test(test_ring),
        cmocka_unit_test(test_bar),     cmocka_unit_test(test_dome),
        cmocka_unit_test(test_coaxial), cmocka_unit_test(test_bad_input),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
