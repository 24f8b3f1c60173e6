/* SPDX-License-Identifier: Apache-2.0 */
/* How far edges of thick parts grow before a backlight: closed forms, renders of a wall, and what
 * is said of it. */
#include "reference_checks.h"

#include "check/findings.h"
#include "check/growth.h"
#include "check/nominal.h"

static const double thickness = 6e-3;

/*
 * A telecentric camera at z = 110 mm whose focus lies at z = `focus`, of 24 x 4 pixels of 5 µm in
 * the object; a box of 6 mm about z = 0 that fills all x below 0; a parallel light below.
 */
static mcv_scene *wall_before_light(double f_number, double focus, double half_angle,
                                    uint32_t material_type) {
    mcv_scene *scene = mcv_scene_new("wall");
    mcv_sensor sensor = sensor_defaults(MCV_SENSOR_TELECENTRIC);
    mcv_telecentric_params *p = &sensor.as.telecentric;
    p->magnification = 0.08;
    p->workingDistance = 0.11 - focus;
    p->fNumber = f_number;
    p->resolution[0] = 24, p->resolution[1] = 4;
    p->pixelSize[0] = p->pixelSize[1] = 0.08 * 5e-6;
    add_sensor(scene, MCV_SENSOR_TELECENTRIC, &sensor, looking_down_z(0, 0, 0.11));
    add_box(scene, (const double[3]){1e-3, 5e-3, thickness / 2},
            add_material(scene, material_type, NULL), looking_up_z(-1e-3, 0, 0));
    add_emitter(scene, MCV_EMITTER_PARALLEL,
                add_rectangle(scene, 0.02, 0.02, add_absorber(scene), looking_up_z(0, 0, -0.03)), 1,
                half_angle);
    return scene;
}

static mcv_growth growth_of(const mcv_scene *scene) {
    mcv_growth growth;
    assert_true(mcv_growth_of(scene, scene->sensors, &growth));
    return growth;
}

/* 2/(3π) a T of a wall, by hand: 0.08/(2 · 5.6) = 1/140. */
static void test_closed_form(void **state) {
    (void)state;
    mcv_scene *scene = wall_before_light(5.6, 0, 0.02, MCV_MATERIAL_ABSORBER);
    mcv_growth growth = growth_of(scene);
    check("thickness", growth.thickness, thickness, 1e-9); /* stored in float32 */
    check("growth, the pupil's cone", growth.edge.value, 2 / (3 * M_PI) * thickness / 140, 1e-11);
    assert_true(growth.telecentric && !growth.light_is_narrower && !growth.glossy &&
                growth.edge.uncertainty < 0.02 * growth.edge.value);
    char sentence[512];
    mcv_growth_sentence(scene, &growth, sentence);
    if (!strstr(sentence, "6 mm thick") || !strstr(sentence, "9.09 µm") ||
        !strstr(sentence, "18.2 µm") || !strstr(sentence, "f/5.6"))
        fail_msg("%s", sentence);
    /* `check` says it once, as a note about the sensor. */
    mcv_findings findings;
    int said = 0;
    BUILD(mcv_findings_of(scene, &findings, &builder_error));
    for (size_t i = 0; i < findings.count; ++i) {
        if (strcmp(findings.items[i].sentence, sentence) != 0) continue;
        ++said;
        assert_true(findings.items[i].severity == MCV_SEVERITY_NOTE &&
                    strncmp(findings.items[i].path, "sensors/", 8) == 0);
    }
    mcv_findings_free(&findings);
    assert_int_equal(said, 1);
    mcv_scene_free(scene);

    scene = wall_before_light(5.6, 0, 0.003, MCV_MATERIAL_ABSORBER);
    growth = growth_of(scene);
    check("growth, the light's cone", growth.edge.value, 2 / (3 * M_PI) * thickness * tan(0.003),
          1e-11);
    assert_true(growth.light_is_narrower);
    mcv_scene_free(scene);

    scene = wall_before_light(5.6, 0, 0.02, MCV_MATERIAL_MIRROR); /* between 0 and that: uniform */
    growth = growth_of(scene);
    check("growth, a mirror's", growth.edge.value, thickness / 140 / (3 * M_PI), 1e-11);
    check("its uncertainty", growth.edge.uncertainty, 2 / (3 * M_PI) * thickness / 140 / sqrt(12),
          1e-11);
    assert_true(growth.glossy);
    mcv_scene_free(scene);
}

static void test_nothing_to_grow(void **state) {
    mcv_growth growth;
    (void)state;
    mcv_scene *scene =
        wall_before_light(5.6, 0, 0.02, MCV_MATERIAL_DIELECTRIC); /* no opaque part */
    assert_false(mcv_growth_of(scene, scene->sensors, &growth));
    mcv_scene_free(scene);
    scene = wall_before_light(5.6, 0, 0.02, MCV_MATERIAL_ABSORBER);
    scene->instances[1].to_world = looking_down_z(0, 0, -0.03); /* turned away */
    assert_false(mcv_growth_of(scene, scene->sensors, &growth));
    scene->instances[1].to_world = looking_up_z(0, 0, 0.02); /* before the part */
    assert_false(mcv_growth_of(scene, scene->sensors, &growth));
    mcv_scene_free(scene);
    scene = wall_before_light(5.6, 0, 0.02, MCV_MATERIAL_ABSORBER);
    free(scene->sensors[0].name);
    scene->sensor_count = 0; /* the same before a pinhole, which has no cone */
    add_pinhole(scene, 8, 0.1, looking_down_z(0, 0, 0.11));
    assert_false(mcv_growth_of(scene, scene->sensors, &growth));
    mcv_scene_free(scene);
}

/*
 * By the mesh at the edge. The wall alone gives the closed form. A step 20 pixels inside does not
 * count; one 1 µm inside, 1 mm deep, cuts the shadow of rays that lean by more than 1/1000: with q
 * = 1/(1000 a) its points (0, z) and (-δ, z + d) give <(|u| d - δ)+> more, in closed form by the
 * integral of the half circle.
 */
static void test_contour_of_the_mesh(void **state) {
    (void)state;
    mcv_camera_model model;
    mcv_quantity edge;
    mcv_error error = {""};
    const double a = 1.0 / 140, point[2] = {12, 2}, normal[2] = {1, 0};
    mcv_scene *scene = wall_before_light(5.6, 1e-3, 0.02, MCV_MATERIAL_ABSORBER);
    const mcv_growth growth = growth_of(scene);
    BUILD(mcv_camera_model_of(scene, scene->sensors, &model, &builder_error));
    BUILD(mcv_growth_at(scene, &model, &growth, point, normal, 4, 6, &edge, &error));
    /* 64 nodes for a kink: within a thousandth. */
    check("growth at the wall", edge.value, 2 / (3 * M_PI) * a * thickness,
          1e-3 * growth.edge.value);

    add_box(scene, (const double[3]){0.5e-3, 5e-3, 0.5e-3}, add_absorber(scene),
            looking_up_z(-0.6e-3, 0, thickness / 2 + 0.5e-3));
    BUILD(mcv_growth_at(scene, &model, &growth, point, normal, 4, 6, &edge, &error));
    check("growth, a step far inside", edge.value, 2 / (3 * M_PI) * a * thickness,
          1e-3 * growth.edge.value);

    const double delta = 1e-6, deep = 1e-3, q = delta / (deep * a);
    add_box(scene, (const double[3]){0.5e-3, 5e-3, deep / 2}, add_absorber(scene),
            looking_up_z(-0.5e-3 - delta, 0, thickness / 2 + deep / 2));
    BUILD(mcv_growth_at(scene, &model, &growth, point, normal, 4, 6, &edge, &error));
    /* ∫_q^1 (2/π) √(1-u²) (a d u - δ) du, one side of the two. */
    const double more =
        2 / M_PI *
        (a * deep * pow(1 - q * q, 1.5) / 3 - delta * (acos(q) - q * sqrt(1 - q * q)) / 2);
    check("growth, a step at the edge", edge.value, 2 / (3 * M_PI) * a * thickness + more,
          1e-3 * growth.edge.value);
    assert_true(more > 0.05 * growth.edge.value);

    const double so_far =
        edge.value; /* a table below the light and a plate behind the camera cast no shadow */
    add_box(scene, (const double[3]){5e-3, 5e-3, 1e-3}, add_absorber(scene),
            looking_up_z(0, 0, -0.05));
    add_box(scene, (const double[3]){5e-3, 5e-3, 1e-3},
            add_material(scene, MCV_MATERIAL_MIRROR, NULL), looking_up_z(0, 0, 0.2));
    BUILD(mcv_growth_at(scene, &model, &growth, point, normal, 4, 6, &edge, &error));
    check("growth before a light on a table", edge.value, so_far, 1e-15);
    assert_true(edge.uncertainty < 0.02 * edge.value);

    assert_int_equal(mcv_growth_at(scene, &model, &growth, (const double[2]){20, 2}, normal, 4, 3,
                                   &edge, &error),
                     MCV_FAILED);
    assert_non_null(strstr(error.text, "no contour"));
    mcv_camera_model_free(&model);
    mcv_scene_free(scene);
}

/* The wall of a tube of 0.2 mm, 40 pixels, 600 pixels to the left; looking_up_z turns z, so it
 * reaches from 0 to -1 mm. */
static void add_tube(mcv_scene *scene) {
    enum { SIDES = 256 };
    static float positions[6 * SIDES];
    static uint32_t indices[6 * SIDES];
    for (uint32_t i = 0; i < SIDES; ++i) {
        const double angle = 2 * M_PI * i / SIDES;
        const uint32_t j = (i + 1) % SIDES;
        for (uint32_t up = 0; up < 2; ++up) {
            positions[3 * (2 * i + up)] = (float)(0.2e-3 * cos(angle));
            positions[3 * (2 * i + up) + 1] = (float)(0.2e-3 * sin(angle));
            positions[3 * (2 * i + up) + 2] = up ? 1e-3F : 0;
        }
        memcpy(indices + (size_t)6 * i,
               (const uint32_t[6]){2 * i, 2 * j, 2 * j + 1, 2 * i, 2 * j + 1, 2 * i + 1},
               6 * sizeof *indices);
    }
    add_instance(scene,
                 &(mcv_mesh){.vertex_count = 2 * SIDES,
                             .triangle_count = 2 * SIDES,
                             .positions = positions,
                             .indices = indices},
                 add_absorber(scene), looking_up_z(-3e-3, 0, 0));
}

/* A disk 0.4 mm across and 1 mm deep, of 256 sides: its contour is a wall all around. */
static void test_contour_of_a_circle(void **state) {
    mcv_camera_model model;
    mcv_quantity edge;
    mcv_error error = {""};
    (void)state;
    mcv_scene *scene = wall_before_light(5.6, 0, 0.02, MCV_MATERIAL_ABSORBER);
    add_tube(scene);
    const mcv_growth growth = growth_of(scene);
    BUILD(mcv_camera_model_of(scene, scene->sensors, &model, &builder_error));
    BUILD(mcv_growth_of_circle(scene, &model, &growth, (const double[2]){12 - 600, 2}, 40, false, 4,
                               &edge, &error));
    check("growth of a circle", edge.value, 2 / (3 * M_PI) / 140 * 1e-3, 1e-3 * edge.value);
    mcv_camera_model_free(&model);
    mcv_scene_free(scene);
}

/* An edge that the wall's growth has moved by so many pixels, towards `sign` in x. */
static mcv_edge grown_edge(double contour, double sign, double growth) {
    return (mcv_edge){.box = {(uint32_t)contour - 4, 0, 8, 4},
                      .across_rows = true,
                      .point = {contour + sign * growth, 2},
                      .normal = {sign, 0},
                      .position = {contour + sign * growth, 0}};
}

/*
 * What is grown comes back: an edge and a line by g, a width of 8 pixels by 2 g, the radius of a
 * pin by g, and that of a bore by -g. The uncertainty is that of g, once, twice, and twice of a
 * diameter; an edge has √2 of it.
 */
static void test_nominal(void **state) {
    const double pixel[2] = {5e-6, 5e-6}, g = 2 / (3 * M_PI) / 140 * thickness / 5e-6,
                 g_tube = g * 1e-3 / thickness;
    mcv_scene *scene = wall_before_light(5.6, 0, 0.02, MCV_MATERIAL_ABSORBER);
    mcv_transform *wall = &scene->instances[0].to_world;
    mcv_camera_model model;
    (void)state;
    *wall = looking_up_z(-20e-6, 0, 0);
    for (int k = 0; k < 9; k += 3) wall->m[k] *= 0.02; /* from -40 µm to 0: columns 4 to 12 */
    add_tube(scene);
    const mcv_growth growth = growth_of(scene);
    BUILD(mcv_camera_model_of(scene, scene->sensors, &model, &builder_error));
    const mcv_part_view view = {scene, &model, &growth, pixel};

    mcv_found found = {.form = MCV_FORM_EDGE, .as.edge = grown_edge(12, 1, g)};
    BUILD(mcv_nominal_put_back(&view, &found, &builder_error));
    const double u = found.as.edge.position.uncertainty / M_SQRT2;
    check("an edge, put back", found.as.edge.position.value, 12, 1e-3 * g);
    check("its point, put back", found.as.edge.point[0], 12, 1e-3 * g);
    assert_true(u > 0 && u < 0.02 * g);

    found = (mcv_found){.form = MCV_FORM_LINE};
    found.as.line = (mcv_line){
        .edge = grown_edge(12, 1, g), .box_count = 2, .boxes = {{8, 0, 8, 2}, {8, 2, 8, 2}}};
    BUILD(mcv_nominal_put_back(&view, &found, &builder_error));
    check("a line, put back", found.as.line.edge.position.value, 12, 1e-3 * g);

    found = (mcv_found){.form = MCV_FORM_CALIPER};
    found.as.caliper = (mcv_caliper){.edges = {grown_edge(4, -1, g), grown_edge(12, 1, g)},
                                     .width = {8 + 2 * g, 0}};
    BUILD(mcv_nominal_put_back(&view, &found, &builder_error));
    check("a width, put back", found.as.caliper.width.value, 8, 2e-3 * g);
    check("its uncertainty", found.as.caliper.width.uncertainty, 2 * u, 1e-9);

    for (int bore = 0; bore < 2; ++bore) {
        const double radius = 40 + (bore ? -g_tube : g_tube);
        found = (mcv_found){.form = MCV_FORM_CIRCLE};
        found.as.circle = (mcv_circle){.bright = bore,
                                       .column = {12 - 600, 0},
                                       .row = {2, 0},
                                       .radius = {radius, 0},
                                       .diameter = {2 * radius, 0}};
        BUILD(mcv_nominal_put_back(&view, &found, &builder_error));
        const mcv_circle *circle = &found.as.circle;
        check(bore ? "a bore, put back" : "a pin, put back", circle->radius.value, 40,
              1e-3 * g_tube);
        check("its diameter, put back", circle->diameter.value, 80, 2e-3 * g_tube);
        check("its uncertainty", circle->diameter.uncertainty, 2 * circle->radius.uncertainty,
              1e-12);
    }
    mcv_camera_model_free(&model);
    mcv_scene_free(scene);
}

/*
 * The mean over what it is beside the wall tells how much of the field is dark: 24 columns of 5 µm,
 * of which the wall hides 12 and its growth. Beside the wall the radiance is 1 where it comes from
 * the light's cone, which fills a share of the pupil.
 */
static void check_render(const char *what, double f_number, double focus, double half_angle) {
    mcv_scene *scene = wall_before_light(f_number, focus, half_angle, MCV_MATERIAL_ABSORBER);
    const mcv_growth growth = growth_of(scene);
    mcv_render_options options = mcv_render_defaults();
    mcv_film film = {0};
    mcv_render_stats stats;
    options.replicates = REPLICATES;
    options.sampler = MCV_SAMPLER_RANDOM;
    options.last = 512;
    options.depth = 2;
    BUILD(mcv_reference_render(scene, 0, &options, &film, &stats, &builder_error));
    const double field = 24 * 5e-6, bright = fmin(1, pow(tan(half_angle) * 2 * f_number / 0.08, 2));
    const mcv_estimate mean = image_estimate(&film);
    const mcv_estimate dark = {.mean = field * (0.5 - mean.mean / bright),
                               .variance = field * field * mean.variance / (bright * bright),
                               .freedom = mean.freedom};
    check_mean(what, dark, growth.edge.value, growth.edge.uncertainty);
    if (sqrt(dark.variance) > 0.03 * growth.edge.value)
        fail_msg("%s: the error of the render is too large to tell", what);
    mcv_film_free(&film);
    mcv_scene_free(scene);
}

static void test_renders_grow_so(void **state) {
    (void)state;
    check_render("f/5.6, in focus", 5.6, 0, 0.02);
    check_render("f/11.2, in focus", 11.2, 0, 0.02);
    check_render("f/5.6, focus on the upper rim", 5.6, thickness / 2, 0.02);
    check_render("light narrower than f/5.6", 5.6, 0, 0.006);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_closed_form),
        cmocka_unit_test(test_nothing_to_grow),
        cmocka_unit_test(test_contour_of_the_mesh),
        cmocka_unit_test(test_contour_of_a_circle),
        cmocka_unit_test(test_nominal),
        cmocka_unit_test(test_renders_grow_so),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
