/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Parts that move while lights and camera stand still, on the device in both schedules and in the
 * reference renderer: what is seen of them, their shading, shadows of them and on them, and light
 * through moving glass.
 */
#include "moving_edge.h"
#include "scene_files.h"

#include "scene/motion.h"
#include "scene/transform.h"

static void let_move(mcv_scene *scene, uint32_t instance, mcv_node_motion motion) {
    scene->instances[instance].moves = true;
    scene->part_motion = motion;
}

static void add_directional(mcv_scene *scene, const double forward[3], const double up[3]) {
    mcv_emitter light = {.name = (char *)"light",
                         .type = MCV_EMITTER_DIRECTIONAL,
                         .instance = MCV_NONE,
                         .texture = MCV_NONE};
    mcv_params_set_defaults(mcv_emitter_table(MCV_EMITTER_DIRECTIONAL), &light.as);
    for (int k = 0; k < 3; ++k) light.as.directional.irradiance[k] = 1;
    light.to_world = looking((const double[3]){0, 0, 0}, forward, up);
    BUILD(mcv_scene_add_emitter(scene, &light, &builder_error));
}

/* A black half plane before a camera that sees it from above, its edge at x = 0. */
static mcv_scene *half_plane(const char *camera, mcv_node_motion motion) {
    mcv_scene *scene = mcv_scene_new("parts");
    const mcv_sensor sensor = camera_with(camera);
    add_environment(scene, 1);
    let_move(scene,
             add_rectangle(scene, 0.4, 0.4, add_absorber(scene), looking_up_z(0.2, 0, -depth)),
             motion);
    add_sensor(scene, MCV_SENSOR_PINHOLE, &sensor, looking_down_z(0, 0, 0));
    return scene;
}

/* As test_blur and test_rolling of test_motion.c, with their tolerances: only the sign differs from
 * a camera that moves. */
static void test_seen(void **state) {
    (void)state;
    mcv_scene *blurred = half_plane(",\"exposureTime\":0.01",
                                    (mcv_node_motion){.velocity = {9 * seen / 0.01, 0, 0}});
    mcv_scene *rolling = half_plane(",\"shutter\":\"rolling\",\"lineTime\":1e-4",
                                    (mcv_node_motion){.velocity = {0.2 * seen / 1e-4, 0, 0}});
    for (int reference = 0; reference < 2; ++reference) {
        const edge e = edge_in(reference, blurred, 1, false),
                   skewed = edge_in(reference, rolling, 1, false);
        const double truth = fabs(sinc(9 * frequency)) * pow(sinc(frequency), 2);
        expect("blurred part, place", e.middle, SIZE / 2.0 + 4.5, 0.05);
        expect("blurred part, variance", e.variance, 81 / 12.0 + 1 / 6.0, 0.25);
        expect("blurred part, transfer function", e.transfer, truth, 0.01 * truth);
        expect("rolling shutter, columns per row", skewed.slope, 0.2, 2e-3);
    }
    mcv_scene_free(blurred);
    mcv_scene_free(rolling);
}

/* At a flash the picture is that of a part that lies where the moving one is then. */
static void test_turned(void **state) {
    (void)state;
    const double angle = 0.3 * 0.5;
    const mcv_node_motion motion = {
        .velocity = {0, 0.004, 0}, .axis = {0, 0, 1}, .centre = {0.01, 0, 0}, .rate = 0.3};
    mcv_scene *scene =
        half_plane(",\"exposureTime\":1,\"strobeDelay\":0.5,\"strobeTime\":1e-6", motion);
    mcv_scene *still = half_plane("", (mcv_node_motion){.rate = 0});
    /* Turned about (0.01, 0), then moved up by 2 mm. */
    const double c = cos(angle), s = sin(angle);
    mcv_transform *at = &still->instances[0].to_world, before = *at,
                  turn = {{c, -s, 0, s, c, 0, 0, 0, 1, 0.01 - 0.01 * c, -0.01 * s + 0.002, 0}};
    *at = mcv_transform_compose(&turn, &before);
    const edge truth = edge_in(false, still, 1, false);
    for (int reference = 0; reference < 2; ++reference) {
        const edge e = edge_in(reference, scene, 1, false);
        expect("turned part, middle", e.middle, truth.middle, 0.05);
        expect("turned part, columns per row", e.slope, truth.slope, 2e-3);
    }
    assert_true(fabs(truth.slope) > 0.1);
    mcv_scene_free(scene);
    mcv_scene_free(still);
}

/* A diffuse plate turns under a light that stands still: the mean of E ρ/π cos(α + ωt) over the
 * exposure, α = 0.2 and ωt up to 0.8. The camera sees it all along its axis of turns. */
static void test_shading(void **state) {
    (void)state;
    const double begin = 0.2, end = 1.0, reflectance = 0.6;
    mcv_scene *scene = mcv_scene_new("parts");
    const mcv_sensor sensor = camera_with(",\"exposureTime\":0.01");
    let_move(
        scene,
        add_rectangle(scene, 4, 4, add_diffuse(scene, reflectance), looking_up_z(0, 0, -depth)),
        (mcv_node_motion){
            .axis = {0, 1, 0}, .centre = {0, 0, -depth}, .rate = (end - begin) / 0.01});
    add_directional(scene, (const double[3]){sin(begin), 0, -cos(begin)},
                    (const double[3]){0, 1, 0});
    add_sensor(scene, MCV_SENSOR_PINHOLE, &sensor, looking_down_z(0, 0, 0));
    const double truth = reflectance / M_PI * (sin(end) - sin(begin)) / (end - begin);
    mcv_render_stats stats;
    check_device_mean("a plate that turns under a light", scene, 64, 2, truth, 0);
    check_mean("a plate that turns under a light, reference",
               render_mean(scene, 64, 2, true, &stats), truth, 0);
    mcv_scene_free(scene);
}

/* A black screen half way between floor and light, beside what the camera sees. Light falls at 45
 * degrees, so that the shadow's edge lies at x = 0 and moves with the screen. */
static mcv_scene *shadow(bool screen_moves) {
    const mcv_node_motion motion = {.velocity = {9 * seen / 0.01, 0, 0}};
    const double slant = sqrt(0.5), height = 0.1;
    mcv_scene *scene = mcv_scene_new("parts");
    const mcv_sensor sensor = camera_with(",\"exposureTime\":0.01");
    const uint32_t floor = add_rectangle(scene, 4, 4, add_diffuse(scene, 0.5),
                                         looking_up_z(0, 0, -depth)),
                   screen = add_rectangle(scene, 0.06, 1, add_absorber(scene),
                                          looking_up_z(-height + 0.03, 0, height - depth));
    let_move(scene, screen_moves ? screen : floor, motion);
    add_directional(scene, (const double[3]){slant, 0, -slant}, (const double[3]){0, 1, 0});
    add_sensor(scene, MCV_SENSOR_PINHOLE, &sensor, looking_down_z(0, 0, 0));
    return scene;
}

/* The shadow of a moving screen is blurred as a moving edge is; that of one that stands still on a
 * moving floor is not. The tolerances are those of test_seen: the floor's light does not vary. */
static void test_shadows(void **state) {
    (void)state;
    mcv_scene *moving = shadow(true), *still = shadow(false);
    for (int reference = 0; reference < 2; ++reference) {
        const edge e = edge_in(reference, moving, 2, false),
                   sharp = edge_in(reference, still, 2, false);
        expect("moving shadow, place", e.middle, SIZE / 2.0 + 4.5, 0.05);
        expect("moving shadow, variance", e.variance, 81 / 12.0 + 1 / 6.0, 0.25);
        expect("shadow on a moving floor, place", sharp.middle, SIZE / 2.0, 0.05);
        assert_true(sharp.variance < 0.3);
    }
    mcv_scene_free(moving);
    mcv_scene_free(still);
}

/* Everything is as bright as the sky seen through a block of glass, however it moves: what goes in
 * comes out, and no ray takes a surface for another one or meets the same one twice. The limit of
 * 64 surfaces cuts 3e-5 of the light. */
static mcv_scene *block(void) {
    mcv_scene *scene = mcv_scene_new("parts");
    const mcv_sensor sensor = camera_with(",\"exposureTime\":0.01");
    const double half[3] = {0.004, 0.004, 0.001};
    const uint32_t glass = add_glass(scene, 1.5, 0, 0);
    add_environment(scene, 1);
    let_move(
        scene, add_box(scene, half, glass, looking_up_z(-0.003, 0, -depth)),
        (mcv_node_motion){
            .velocity = {0.6, 0, 0}, .axis = {0.6, 0, 0.8}, .centre = {0.5, 0.1, -0.2}, .rate = 3});
    add_sensor(scene, MCV_SENSOR_PINHOLE, &sensor, looking_down_z(0, 0, 0));
    return scene;
}

static void test_glass(void **state) {
    (void)state;
    mcv_scene *scene = block();
    mcv_render_stats stats;
    for (int reference = 0; reference < 2; ++reference) {
        const mcv_estimate mean = reference ? render_mean(scene, 32, 64, true, &stats)
                                            : device_mean(scene, 64, 64, &stats);
        expect("moving glass under an even sky", mean.mean, 1, 1e-4);
        assert_int_equal(stats.unmatched, 0);
    }
    mcv_scene_free(scene);
}

/* Both schedules make the same image, of a scene in which all happens at once. */
static void test_schedules(void **state) {
    (void)state;
    mcv_scene *scene = block();
    mcv_film films[2];
    add_rectangle(scene, 0.4, 0.4, add_diffuse(scene, 0.5), looking_up_z(0, 0, -1.5 * depth));
    add_directional(scene, (const double[3]){0.6, 0, -0.8}, (const double[3]){0, 1, 0});
    for (int k = 0; k < 2; ++k) {
        mcv_render_options options = mcv_render_defaults();
        mcv_render_stats stats;
        options.last = 64;
        options.replicates = 2;
        options.schedule = k ? MCV_SCHEDULE_STREAM : MCV_SCHEDULE_TILE;
        BUILD(mcv_render(scene, 0, &options, films + k, &stats, &builder_error));
    }
    assert_memory_equal(films[0].sums, films[1].sums,
                        sizeof(double) * 2 * SIZE * SIZE * films[0].channels);
    for (int k = 0; k < 2; ++k) mcv_film_free(films + k);
    mcv_scene_free(scene);
}

#define RIG(motion, first, second) \
    "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0,2]}]," \
    "\"extensionsUsed\":[\"MCVISI_sensors\",\"MCVISI_motion\",\"MCVISI_emitters\"]," \
    "\"extensions\":{\"MCVISI_sensors\":{\"sensors\":[{\"type\":\"pinhole\"," \
    "\"imageDistance\":1,\"resolution\":4,\"pixelSize\":1e-5,\"exposureTime\":0.1}]}," \
    "\"MCVISI_emitters\":{\"emitters\":[{\"type\":\"area\",\"size\":1,\"radiance\":1}]}}," \
    "\"nodes\":[{\"children\":[1],\"extensions\":{\"MCVISI_motion\":" motion "}}," \
    "{\"extensions\":{" first "}},{\"extensions\":{" second "}}]}"

static void test_files(void **state) {
    mcv_scene *scene;
    mcv_error error;
    (void)state;
    if (load_text("parts.gltf",
                  RIG("{\"velocity\":[1,2,3]}", "", "\"MCVISI_sensors\":{\"sensor\":0}"), NULL,
                  &scene, &error) != MCV_OK)
        fail_msg("%s", error.text);
    assert_true(scene->part_motion.velocity[2] == 3 && !mcv_moves(&scene->sensors[0].motion));
    mcv_scene_free(scene);
    must_refuse("a.gltf", RIG("{\"velocity\":[1,2,3]}", "\"MCVISI_emitters\":{\"emitter\":0}", ""),
                "lights stand still");
    must_refuse("b.gltf", RIG("{\"velocity\":[1,2,3]}", "\"MCVISI_sensors\":{\"sensor\":0}", ""),
                "is a sensor on a part that moves");
    must_refuse("c.gltf",
                RIG("{\"velocity\":[1,2,3]}", "\"MCVISI_motion\":{\"velocity\":[1,0,0]}", ""),
                "is below a node that moves");
    must_refuse("d.gltf",
                RIG("{\"velocity\":[1,2,3]}", "", "\"MCVISI_motion\":{\"velocity\":[1,0,0]}"),
                "all parts that move do so in one way");
    must_refuse("e.gltf", RIG("{\"rate\":3}", "", ""), "MCVISI_motion/axis: is missing");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_seen),    cmocka_unit_test(test_turned),
        cmocka_unit_test(test_shading), cmocka_unit_test(test_shadows),
        cmocka_unit_test(test_glass),   cmocka_unit_test(test_schedules),
        cmocka_unit_test(test_files),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
