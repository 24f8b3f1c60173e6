/* SPDX-License-Identifier: Apache-2.0 */
/* ctest: timeout 600 */
/*
 * The shipped scenes, smaller, rendered by the device and by the reference: the images agree within
 * their noise (Welch's tests of analysis/compare.h), and the same tests see each planted error.
 * Seeds are fixed, so the outcome is too.
 */
#include "scene_builder.h"

#include "analysis/compare.h"
#include "reference/reference.h"
#include "render/render.h"
#include "loader/load.h"

/* test_images_slow.c sets it: all cases, of which the quick test has those that no others stand
 * for. */
#ifndef SLOW
#define SLOW 0
#endif

typedef struct image_case {
    const char *file;
    uint32_t divisor;           /* of the resolution; the field of view stays */
    uint32_t device, reference; /* samples per pixel and replicate */
} image_case;

enum { REPLICATES = 16 };

static const image_case report = {"report-clean.glb", 16, 16, 8};
static const image_case bubble = {"report-bubble.glb", 16, 16, 8};
static const image_case dent = {"report-dent.glb", 16, 16, 8};
static const image_case backlight = {"part-backlight.gltf", 10, 32, 16};
static const image_case area_light = {"part-arealight.gltf", 10, 16, 8};
static const image_case box = {"diffuse-box.gltf", 4, 16, 8};
static const image_case furnace = {"furnace.glb", 4, 8, 4};
static const image_case projector = {"projector.gltf", 8, 16, 16};
static const image_case lens_projector = {"lens-projector.gltf", 8, 16, 16};
/* As shipped: with fewer macro pixels all rays of one would meet on an edge of the display's, where
 * rounding decides. */
static const image_case display = {"light-field.gltf", 1, 8, 8};
static const image_case thin_lens = {"depth-of-field.gltf", 8, 16, 8};

static void shrink(uint32_t pixels[2], double size[2], uint32_t divisor) {
    for (int k = 0; k < 2; ++k) {
        const uint32_t fewer = pixels[k] / divisor > 0 ? pixels[k] / divisor : 1;
        size[k] *= (double)pixels[k] / fewer;
        pixels[k] = fewer;
    }
}

static mcv_scene *load(const image_case *c) {
    char path[512];
    mcv_scene *scene;
    snprintf(path, sizeof path, "%s/scenes/%s", MCV_SOURCE_DIR, c->file);
    BUILD(mcv_scene_load(path, (mcv_overrides){NULL, 0}, &scene, &builder_error));
    mcv_sensor *sensor = &scene->sensors[0];
    switch (sensor->type) {
    case MCV_SENSOR_PINHOLE:
        shrink(sensor->as.pinhole.resolution, sensor->as.pinhole.pixelSize, c->divisor);
        break;
    case MCV_SENSOR_THIN_LENS:
        shrink(sensor->as.thin_lens.resolution, sensor->as.thin_lens.pixelSize, c->divisor);
        break;
    case MCV_SENSOR_TELECENTRIC:
        shrink(sensor->as.telecentric.resolution, sensor->as.telecentric.pixelSize, c->divisor);
        break;
    default:
        shrink(sensor->as.light_field.spatialResolution, sensor->as.light_field.pixelSize,
               c->divisor);
        break;
    }
    return scene;
}

/* The last reference image, kept while tests ask for the same case. */
static const image_case *reference_case;
static mcv_film reference_film;

static const mcv_film *reference_of(const image_case *c) {
    mcv_render_options options = mcv_render_defaults();
    mcv_render_stats stats;
    if (reference_case == c) return &reference_film;
    mcv_film_free(&reference_film);
    reference_case = c;
    mcv_scene *scene = load(c);
    options.replicates = REPLICATES;
    options.last = c->reference;
    options.seed = 1;
    BUILD(mcv_reference_render(scene, 0, &options, &reference_film, &stats, &builder_error));
    print_message("%s: reference %.1f s, ", c->file, stats.seconds_render);
    mcv_scene_free(scene);
    return &reference_film;
}

static mcv_comparison compare_with_reference(const image_case *c, const mcv_scene *scene) {
    mcv_render_options options = mcv_render_defaults();
    mcv_render_stats stats;
    mcv_film film;
    mcv_comparison comparison;
    options.replicates = REPLICATES;
    options.last = c->device;
    options.seed = 2;
    const mcv_film *reference = reference_of(c);
    BUILD(mcv_render(scene, 0, &options, &film, &stats, &builder_error));
    BUILD(mcv_compare_films(&film, reference, &comparison, &builder_error));
    print_message("%s: device %.1f s, mean %.6g against %.6g; p of units %.2g, tiles %.2g, count "
                  "%.2g, image %.2g; %.2g %% would be seen\n",
                  c->file, stats.seconds_render, comparison.mean_x, comparison.mean_y,
                  comparison.p_unit, comparison.p_tiles, comparison.p_count, comparison.p_image,
                  100 * comparison.detectable);
    mcv_film_free(&film);
    return comparison;
}

static void expect_same(const image_case *c) {
    mcv_scene *scene = load(c);
    const mcv_comparison comparison = compare_with_reference(c, scene);
    if (comparison.different) fail_msg("%s: %s", c->file, comparison.reason);
    mcv_scene_free(scene);
}

static void test_report_clean(void **state) {
    (void)state;
    expect_same(&report);
}

static void expect_planted(const image_case *c, const mcv_scene *scene, const char *what) {
    const mcv_comparison comparison = compare_with_reference(c, scene);
    if (!comparison.different)
        fail_msg("%s: %s was not seen: %s", c->file, what, comparison.reason);
}

static void test_wider_cone_is_seen(void **state) {
    mcv_scene *scene = load(&report);
    (void)state;
    for (uint32_t i = 0; i < scene->emitter_count; ++i)
        scene->emitters[i].as.parallel.halfAngle *= 1.01;
    expect_planted(&report, scene, "a cone 1 % larger");
    mcv_scene_free(scene);
}

static void test_report_bubble(void **state) {
    (void)state;
    expect_same(&bubble);
}

static void test_report_dent(void **state) {
    (void)state;
    expect_same(&dent);
}

static void test_part_backlight(void **state) {
    (void)state;
    expect_same(&backlight);
}

static void test_more_radiance_is_seen(void **state) {
    mcv_scene *scene = load(&backlight);
    (void)state;
    for (uint32_t i = 0; i < scene->emitter_count; ++i) {
        for (int k = 0; k < 3; ++k) scene->emitters[i].radiance[k] *= 1.01;
    }
    expect_planted(&backlight, scene, "1 % more radiance");
    mcv_scene_free(scene);
}

static void test_half_a_pixel_is_seen(void **state) {
    mcv_scene *scene = load(&backlight);
    (void)state;
    mcv_sensor *sensor = &scene->sensors[0];
    const mcv_telecentric_params *p = &sensor->as.telecentric;
    const double shift =
        0.5 * p->pixelSize[0] * p->focalLength / (p->imageDistance - p->focalLength);
    for (int k = 0; k < 3; ++k) sensor->to_world.m[9 + k] += shift * sensor->to_world.m[3 * k];
    expect_planted(&backlight, scene, "half a pixel");
    mcv_scene_free(scene);
}

static void test_longer_lens_is_seen(void **state) {
    mcv_scene *scene = load(&backlight);
    (void)state;
    scene->sensors[0].as.telecentric.focalLength *= 1.001;
    expect_planted(&backlight, scene, "a focal length 0.1 % larger");
    mcv_scene_free(scene);
}

static void test_part_arealight(void **state) {
    (void)state;
    expect_same(&area_light);
}

static void test_diffuse_box(void **state) {
    (void)state;
    expect_same(&box);
}

static void test_furnace(void **state) {
    (void)state;
    expect_same(&furnace);
}

static void test_thin_lens(void **state) {
    (void)state;
    expect_same(&thin_lens);
}

static void test_projector(void **state) {
    (void)state;
    expect_same(&projector);
}

static void test_lens_projector(void **state) {
    (void)state;
    expect_same(&lens_projector);
}

static void test_light_field_display(void **state) {
    (void)state;
    expect_same(&display);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_report_clean),
        cmocka_unit_test(test_wider_cone_is_seen),
        cmocka_unit_test(test_furnace),
        cmocka_unit_test(test_light_field_display),
    };
    const struct CMUnitTest long_tests[] = {
        cmocka_unit_test(test_report_bubble),
        cmocka_unit_test(test_report_dent),
        cmocka_unit_test(test_part_backlight),
        cmocka_unit_test(test_more_radiance_is_seen),
        cmocka_unit_test(test_half_a_pixel_is_seen),
        cmocka_unit_test(test_longer_lens_is_seen),
        cmocka_unit_test(test_part_arealight),
        cmocka_unit_test(test_diffuse_box),
        cmocka_unit_test(test_thin_lens),
        cmocka_unit_test(test_projector),
        cmocka_unit_test(test_lens_projector),
    };
    const int failed = SLOW ? cmocka_run_group_tests(long_tests, NULL, NULL)
                            : cmocka_run_group_tests(tests, NULL, NULL);
    mcv_film_free(&reference_film);
    return failed;
}
