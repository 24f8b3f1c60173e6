/* SPDX-License-Identifier: Apache-2.0 */
/* What `mcvisi check` says about scenes that cannot work: emitters, open bodies, units, pupils that
 * are not filled. */
#include "reference_checks.h"

#include "check/findings.h"
#include "reference/filling.h"
#include "scene/emitters.h"

/* How many of the scene's findings say this. */
static int findings(const mcv_scene *scene, const char *words) {
    int count = 0;
    mcv_findings found;
    BUILD(mcv_findings_of(scene, &found, &builder_error));
    for (size_t i = 0; i < found.count; ++i)
        count += strstr(found.items[i].sentence, words) != NULL;
    mcv_findings_free(&found);
    return count;
}

static void expect(mcv_scene *scene, const char *words, int expected, const char *what) {
    const int count = findings(scene, words);
    if (count != expected)
        fail_msg("%s: \"%s\" was said %d times instead of %d", what, words, count, expected);
    mcv_scene_free(scene);
}

/* m = 1/4, so 10 mm of field in focus at 0.25 m; the lens is 58 mm wide or so. */
static mcv_sensor telecentric(double f_number) {
    mcv_sensor sensor = sensor_defaults(MCV_SENSOR_TELECENTRIC);
    mcv_telecentric_params *p = &sensor.as.telecentric;
    p->magnification = 0.25;
    p->workingDistance = 0.25;
    p->fNumber = f_number;
    p->resolution[0] = p->resolution[1] = 250;
    p->pixelSize[0] = p->pixelSize[1] = 10e-6;
    return sensor;
}

static mcv_scene *with_camera(mcv_transform to_world) {
    mcv_scene *scene = mcv_scene_new("setup");
    const mcv_sensor sensor = telecentric(8);
    add_sensor(scene, MCV_SENSOR_TELECENTRIC, &sensor, to_world);
    return scene;
}

static void add_panel(mcv_scene *scene, mcv_transform to_world) {
    add_emitter(scene, MCV_EMITTER_PARALLEL,
                add_rectangle(scene, 0.1, 0.1, add_absorber(scene), to_world), 1, 0.02);
}

/* An emitter with an image of one white pixel, on a rectangle that faces the camera; the scene
 * takes its other parameters from `values`. */
static mcv_scene *before_picture(mcv_emitter *values, double f_number) {
    static const uint8_t white[4] = {255, 255, 255, 255};
    mcv_scene *scene = mcv_scene_new("picture");
    const mcv_sensor sensor = telecentric(f_number);
    const mcv_texture texture = {.name = (char *)"white",
                                 .width = 1,
                                 .height = 1,
                                 .wrap_s = 33071,
                                 .wrap_t = 33071,
                                 .nearest = true,
                                 .rgba = (uint8_t *)white};
    float positions[] = {-0.05f, -0.05f, 0, 0.05f, -0.05f, 0, 0.05f, 0.05f, 0, -0.05f, 0.05f, 0},
          texcoords[] = {0, 1, 1, 1, 1, 0, 0, 0};
    uint32_t indices[] = {0, 2, 1, 0, 3, 2};
    const mcv_mesh mesh = {.vertex_count = 4,
                           .triangle_count = 2,
                           .positions = positions,
                           .texcoords = texcoords,
                           .indices = indices};
    add_sensor(scene, MCV_SENSOR_TELECENTRIC, &sensor, looking_down_z(0, 0, 0));
    BUILD(mcv_scene_add_texture(scene, &texture, &builder_error));
    values->name = (char *)"picture";
    values->texture = MCV_NONE;
    values->instance = add_instance(scene, &mesh, add_absorber(scene), looking_up_z(0, 0, -0.3));
    BUILD(mcv_scene_add_emitter(scene, values, &builder_error));
    return scene;
}

/* A projector of one square pixel of this side, 100 mm behind a lens of 100 mm, that throws it to a
 * depth. */
static mcv_emitter projector_of(double side, double depth) {
    mcv_emitter projector = {.type = MCV_EMITTER_PROJECTOR};
    mcv_params_set_defaults(mcv_emitter_table(projector.type), &projector.as);
    mcv_projector_params *p = &projector.as.projector;
    p->image = 0;
    p->imageDistance = p->lensDiameter = 0.1;
    p->focalLength = 1 / (1 / 0.1 + 1 / depth);
    p->pixelSize[0] = p->pixelSize[1] = side;
    for (int k = 0; k < 3; ++k) p->radiance[k] = 1;
    return projector;
}

/* The sums over such an image took minutes, or did not end. */
static void test_image_far_off_the_axis(void **state) {
    const mcv_json_path place = mcv_place_file("(test)");
    (void)state;
    for (int i = 0; i < 3; ++i) {
        mcv_scene *scene = mcv_scene_new("(test)");
        mcv_error error;
        mcv_emitter projector = projector_of(i == 0 ? 1.99 : 2.01, 0.5);
        projector.texture = MCV_NONE; /* a pixel, whose edges lie at tangents of 10 */
        if (i == 2) projector.as.projector.imageDistance = 1e-20;
        const mcv_result result = mcv_emitter_resolve(scene, &projector, &place, &error);
        assert_int_equal(result, i == 0 ? MCV_OK : MCV_BAD_INPUT);
        if (i > 0 && !strstr(error.text, "84 degrees off the axis")) fail_msg("%s", error.text);
        mcv_scene_free(scene);
    }
}

static void test_emitter_that_lights_nothing(void **state) {
    const double half[3] = {1e-3, 1e-3, 1e-3};
    (void)state;
    mcv_scene *scene = with_camera(looking_down_z(0, 0, 0));
    add_panel(scene, looking_up_z(0, 0, -0.3));
    expect(scene, "lights nothing", 0, "a panel that faces the camera");

    scene = with_camera(looking_down_z(0, 0, 0));
    add_panel(scene, looking_down_z(0, 0, -0.3));
    expect(scene, "emitter \"emitter\" lights nothing", 1, "a panel that faces away from all");

    scene = with_camera(looking_down_z(0, 0, 0));
    add_emitter(scene, MCV_EMITTER_AREA,
                add_rectangle(scene, 0.1, 0.1, add_absorber(scene), looking_down_z(0, 0, -0.3)), 1,
                0);
    expect(scene, "emitter \"emitter\" lights nothing", 1,
           "a lamp of all directions that faces away from all");

    scene = with_camera(looking_down_z(0, 0, 0));
    add_panel(scene, looking_down_z(0, 0, -0.3));
    add_box(scene, half, add_diffuse(scene, 0.5), looking_up_z(0, 0, -0.4));
    expect(scene, "lights nothing", 0, "a panel that faces away from the camera, but to a part");

    /* The rim of the lens reaches before the plane, though its centre does not. */
    scene = with_camera(looking((const double[3]){0, 0, 0.01}, (const double[3]){1, 0, 0},
                                (const double[3]){0, 1, 0}));
    add_panel(scene, looking_down_z(0, 0, 0));
    expect(scene, "lights nothing", 0, "a panel beside the lens");

    /* A panel of 0.1 m, parallel light of 20 mrad: at 0.3 m it reaches 50 + 6 mm to the side. Half
     * the box has 1 mm. */
    static const double asides[] = {0.0568, 0.0573};
    for (int i = 0; i < 2; ++i) {
        scene = with_camera(looking((const double[3]){0, 0, 0.1}, (const double[3]){0, 0, 1},
                                    (const double[3]){0, 1, 0}));
        add_panel(scene, looking_down_z(0, 0, 0));
        add_box(scene, half, add_diffuse(scene, 0.5), looking_up_z(asides[i], 0, -0.3));
        expect(scene, "emitter \"emitter\" lights nothing", i, "a panel whose beam passes a part");
    }

    /*
     * A projector throws a picture with half a diagonal of 2 / 20 from a lens of 100 mm: focused at
     * 0.5 m, the edge adds 0.05 / 0.5. At 0.3 m it reaches 50 + 60 mm to the side. Half the box has
     * 1 mm.
     */
    for (int i = 0; i < 2; ++i) {
        mcv_emitter projector = projector_of(0.02 / sqrt(2), 0.5);
        scene = before_picture(&projector, 8);
        scene->sensors[0].to_world = looking(
            (const double[3]){0, 0, -1}, (const double[3]){0, 0, -1}, (const double[3]){0, 1, 0});
        add_box(scene, half, add_diffuse(scene, 0.5), looking_up_z(i ? 0.1115 : 0.1109, 0, 0));
        expect(scene, "emitter \"picture\" lights nothing", i,
               "a projector whose beam passes a part");
    }

    scene = with_camera(looking_down_z(0, 0, 0));
    add_emitter(scene, MCV_EMITTER_AREA,
                add_sphere(scene, 0.01, 8, add_absorber(scene), looking_up_z(0, 0, 0.2)), 1, 0);
    expect(scene, "lights nothing", 0, "a sphere shines everywhere");
}

static void test_sensor_that_sees_nothing(void **state) {
    const double half[3] = {1e-3, 1e-3, 1e-3};
    (void)state;
    /* Its lens has a diameter of 10 √2 mm + 2 · 0.25 m/64, NA 1/64: at 0.2 m it sees 14.1 mm from
     * its axis. The box's ball has 1.7 mm. */
    static const struct {
        double x, z;
        int expected;
    } cases[] = {
        {0, -0.2, 0}, {0, 0.2, 1}, {0.0157, -0.2, 0}, {0.0159, -0.2, 1}, {0.0159, -0.9, 0}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        mcv_scene *scene = with_camera(looking_down_z(0, 0, 0));
        add_box(scene, half, add_diffuse(scene, 0.5), looking_up_z(cases[i].x, 0, cases[i].z));
        expect(scene, "sensor \"sensor\" sees nothing", cases[i].expected, "a camera and a box");
    }
    mcv_scene *scene = with_camera(looking_down_z(0, 0, 0));
    add_environment(scene, 1);
    expect(scene, "sees nothing", 0, "a camera under the sky");
    /* A pinhole of full field 1 at distance 1 sees its corner under tan = √½. */
    scene = mcv_scene_new("pinhole");
    add_pinhole(scene, 8, 1, looking_down_z(0, 0, 0));
    add_box(scene, half, add_diffuse(scene, 0.5), looking_up_z(0.8, 0, -1));
    expect(scene, "sees nothing", 1, "a box beside a pinhole's view");
    scene = mcv_scene_new("pinhole");
    add_pinhole(scene, 8, 1, looking_down_z(0, 0, 0));
    add_box(scene, half, add_diffuse(scene, 0.5), looking_up_z(0.49, 0.49, -1));
    expect(scene, "sees nothing", 0, "a box in the corner of a pinhole's view");
}

/* A box without its last triangles, in two primitives of one node. */
static mcv_scene *box_of(uint32_t triangles, uint32_t first_primitive, uint32_t material_type) {
    static const float corners[24] = {-1, -1, -1, 1, -1, -1, -1, 1, -1, 1, 1, -1,
                                      -1, -1, 1,  1, -1, 1,  -1, 1, 1,  1, 1, 1};
    static const uint32_t indices[36] = {0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4,
                                         2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5};
    mcv_scene *scene = mcv_scene_new("box");
    const uint32_t material = material_type == MCV_MATERIAL_DIELECTRIC ? add_glass(scene, 1.5, 0, 0)
                                                                       : add_diffuse(scene, 0.5);
    for (int part = 0; part < 2; ++part) {
        const uint32_t from = part ? first_primitive : 0, to = part ? triangles : first_primitive;
        if (to > from)
            add_instance(scene,
                         &(mcv_mesh){.vertex_count = 8,
                                     .triangle_count = to - from,
                                     .positions = (float *)corners,
                                     .indices = (uint32_t *)indices + 3 * (size_t)from},
                         material, mcv_transform_identity());
    }
    return scene;
}

static void test_open_bodies(void **state) {
    (void)state;
    /* A triangle has three edges; the two of a face share the diagonal; a face's neighbours share
     * its four sides. */
    static const struct {
        uint32_t triangles, first_primitive, edges;
    } cases[] = {{12, 12, 0}, {12, 7, 0}, {11, 11, 3}, {10, 10, 4}, {10, 3, 4}, {12, 0, 0}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        mcv_scene *scene =
            box_of(cases[i].triangles, cases[i].first_primitive, MCV_MATERIAL_DIELECTRIC);
        uint32_t edges;
        char words[64];
        BUILD(mcv_open_edges(scene, 0, scene->instance_count, &edges, &builder_error));
        if (edges != cases[i].edges)
            fail_msg("box of %u triangles: %u open edges instead of %u", cases[i].triangles, edges,
                     cases[i].edges);
        snprintf(words, sizeof words, "open at %u edges", cases[i].edges);
        expect(scene, words, cases[i].edges > 0, "a box of glass");
    }
    expect(box_of(10, 10, MCV_MATERIAL_DIFFUSE), "open at", 0, "an open box that is no volume");

    /* The seams of a sphere whose vertices stand twice or, at its poles, many times. */
    mcv_scene *scene = mcv_scene_new("sphere");
    add_sphere(scene, 0.01, 16, add_glass(scene, 1.5, 0, 0), looking_up_z(0.3, 0.1, 0.2));
    expect(scene, "open at", 0, "a sphere of glass");
}

/* Half a side of the box [m], the findings expected. */
static void test_units(void **state) {
    static const struct {
        double half;
        const char *words;
        int expected;
    } cases[] = {
        {12, "is 24 m wide in the 10 mm wide field of sensor \"sensor\": is its unit mm?", 1},
        {0.4, "is its unit", 0}, /* a table of 80 fields */
        {5e-3, "is its unit", 0},
        {30e-6, "is its unit", 0}, /* 60 um are more than the 40 um that a pixel sees */
        {15e-6, "is 30 µm wide, less than the 40 µm that a pixel of sensor \"sensor\" sees", 1}};
    (void)state;
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        mcv_scene *scene = with_camera(looking_down_z(0, 0, 0));
        const double half[3] = {cases[i].half, cases[i].half / 2, cases[i].half / 2};
        add_box(scene, half, add_diffuse(scene, 0.5), looking_up_z(0, 0, -0.25));
        expect(scene, cases[i].words, cases[i].expected, "a box");
    }
    /* The light may be as large as it likes. */
    mcv_scene *scene = with_camera(looking_down_z(0, 0, 0));
    add_emitter(scene, MCV_EMITTER_AREA,
                add_rectangle(scene, 20, 20, add_absorber(scene), looking_up_z(0, 0, -0.5)), 1, 0);
    expect(scene, "is its unit", 0, "a wide light");
}

static double filling_of(const mcv_scene *scene) {
    ref_filling *fillings;
    uint32_t count;
    BUILD(ref_sensor_fillings(scene, 0, &fillings, &count, &builder_error));
    assert_int_equal(count, 1);
    const double share = fillings[0].share;
    free(fillings);
    return share;
}

/*
 * A telecentric camera that faces the panel: places a on the stop see it under the angle |a|/f, so
 * the share of the stop is (f tanβ/(D_t/2))², 1 where that is more. Of 65536 rays the 4096 of one
 * stratum straddle the edge: 5 standard errors are at most 5 √(4096/4)/65536.
 */
static void test_pupil(void **state) {
    static const double f_numbers[] = {4, 8, 16};
    const double half_angle = 0.01;
    (void)state;
    for (int i = 0; i < 3; ++i) {
        mcv_scene *scene = mcv_scene_new("pupil");
        const mcv_sensor sensor = telecentric(f_numbers[i]);
        add_sensor(scene, MCV_SENSOR_TELECENTRIC, &sensor, looking_down_z(0, 0, 0));
        add_emitter(scene, MCV_EMITTER_PARALLEL,
                    add_rectangle(scene, 0.1, 0.1, add_absorber(scene), looking_up_z(0, 0, -0.3)),
                    1, half_angle);
        const double aperture = 0.25 / (2 * f_numbers[i]); /* NA = m/(2N) = D_t/2/f */
        check("share of the telecentric pupil", filling_of(scene),
              fmin(pow(tan(half_angle) / aperture, 2), 1), 5 * sqrt(4096 / 4.0) / 65536);
        mcv_scene_free(scene);
    }
    /* With a plate of glass between there is nothing to say. */
    mcv_scene *scene = with_camera(looking_down_z(0, 0, 0));
    const double plate[3] = {0.2, 0.2, 1e-3};
    ref_filling *fillings;
    uint32_t count;
    add_panel(scene, looking_up_z(0, 0, -0.3));
    add_box(scene, plate, add_glass(scene, 1.5, 0, 0), looking_up_z(0, 0, -0.2));
    BUILD(ref_sensor_fillings(scene, 0, &fillings, &count, &builder_error));
    assert_int_equal(count, 0);
    free(fillings);
    mcv_scene_free(scene);
}

/*
 * A projector's cone fills a pupil as the parallel emitter's does. A light field emitter's
 * directions are a square in the pupil, of half-width a f for sines up to a (the tangents of NA
 * 1/64 are longer by 1.2e-4): of the stop's area it takes (2 a/NA)²/π while its corners lie inside.
 * 65536 rays in 4096 strata, of which at most 4 · 64 + 1 of a pixel's 256 straddle an edge: bounds
 * as above.
 */
static void test_pupil_before_pictures(void **state) {
    const double aperture = 0.25 / 16, inside = 5 * sqrt(4096 / 4.0) / 65536;
    (void)state;
    mcv_emitter projector = {.type = MCV_EMITTER_TELECENTRIC_PROJECTOR};
    mcv_params_set_defaults(mcv_emitter_table(projector.type), &projector.as);
    mcv_telecentric_projector_params *p = &projector.as.telecentric_projector;
    p->image = 0;
    p->halfAngle = 0.01;
    p->size[0] = p->size[1] = 0.1;
    for (int k = 0; k < 3; ++k) p->radiance[k] = 1;
    mcv_scene *scene = before_picture(&projector, 8);
    check("share of the pupil before a projector", filling_of(scene), pow(tan(0.01) / aperture, 2),
          inside);
    mcv_scene_free(scene);

    /* One with a lens that throws its picture to infinity fills a square of half-width 5 mrad in
     * tangents, of which the pupil is a disk. */
    mcv_emitter lens = projector_of(0.01 * 0.1, INFINITY);
    scene = before_picture(&lens, 8);
    check("share of the pupil before a projector with a lens", filling_of(scene),
          pow(0.01 / aperture, 2) / M_PI, inside);
    mcv_scene_free(scene);

    mcv_emitter display = {.type = MCV_EMITTER_LIGHT_FIELD_EMITTER};
    mcv_params_set_defaults(mcv_emitter_table(display.type), &display.as);
    mcv_light_field_emitter_params *q = &display.as.light_field_emitter;
    q->image = 0;
    for (int k = 0; k < 2; ++k) q->spatialResolution[k] = q->angularResolution[k] = 1;
    q->angularRange = 0.6 * aperture;
    q->size[0] = q->size[1] = 0.1;
    for (int k = 0; k < 3; ++k) q->radiance[k] = 1;
    scene = before_picture(&display, 8);
    check("share of the pupil before a light field emitter", filling_of(scene), 1.44 / M_PI,
          2 * inside + 1.44 / M_PI * 3e-4);
    mcv_scene_free(scene);
}

/*
 * One macro pixel on the axis sees under κ|o|. A cone that reaches 1.1 directions from the middle
 * lights the middle and its eight neighbours (the sixteenth of a corner one nearest to the middle
 * ends at 0.75 √2 < 1.1, the next direction begins at 1.5).
 */
static void test_directions(void **state) {
    enum { J = 9 };
    const double diameter = 0.02, kappa = 1 / 0.3;
    mcv_sensor sensor = sensor_defaults(MCV_SENSOR_LIGHT_FIELD);
    mcv_light_field_params *p = &sensor.as.light_field;
    mcv_scene *scene = mcv_scene_new("directions");
    (void)state;
    p->focalLength = 0.05;
    p->focusDistance = 1 / kappa;
    p->lensDiameter = diameter;
    p->spatialResolution[0] = p->spatialResolution[1] = 1;
    p->angularResolution[0] = p->angularResolution[1] = J;
    p->pixelSize[0] = p->pixelSize[1] = 4e-6;
    add_sensor(scene, MCV_SENSOR_LIGHT_FIELD, &sensor, looking_down_z(0, 0, 0));
    add_emitter(scene, MCV_EMITTER_PARALLEL,
                add_rectangle(scene, 0.1, 0.1, add_absorber(scene), looking_up_z(0, 0, -0.2)), 1,
                atan(1.1 * kappa * diameter / J));
    check("share of the J x K directions", filling_of(scene), 9.0 / (J * J), 1e-15);
    mcv_scene_free(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_image_far_off_the_axis),
        cmocka_unit_test(test_emitter_that_lights_nothing),
        cmocka_unit_test(test_sensor_that_sees_nothing),
        cmocka_unit_test(test_open_bodies),
        cmocka_unit_test(test_units),
        cmocka_unit_test(test_pupil),
        cmocka_unit_test(test_pupil_before_pictures),
        cmocka_unit_test(test_directions),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
