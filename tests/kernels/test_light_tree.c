/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The light tree: each emitter is chosen as often as its chance says, and that is the chance which
 * weighs what a path meets by itself; the chances add up to 1; nothing that lights a place is out
 * of reach; both schedules and the reference see the same picture; it is there where it pays.
 */
#include "elements.h"
#include "scene_builder.h"
#include "estimates.h"

#include "analysis/compare.h"
#include "device/device_scene.h"
#include "device/features.h"
#include "mcvisi/light_tree.h"
#include "reference/random.h"
#include "reference/reference.h"

enum { CASES = 1 << 16, LAMPS = 48, EMITTERS = LAMPS + 6, RECEIVERS = 6 };

static void add_light(mcv_scene *scene, uint32_t type, mcv_transform to_world) {
    mcv_emitter light = {.name = (char *)"light", .type = type};
    light.instance = light.texture = MCV_NONE;
    light.to_world = to_world;
    mcv_params_set_defaults(mcv_emitter_table(type), &light.as);
    for (int k = 0; k < 3; ++k) {
        if (type == MCV_EMITTER_POINT) light.as.point.intensity[k] = 1e-3;
        if (type == MCV_EMITTER_SPOT) light.as.spot.intensity[k] = 1e-3;
        if (type == MCV_EMITTER_DIRECTIONAL) light.as.directional.irradiance[k] = 1e-3;
    }
    BUILD(mcv_scene_add_emitter(scene, &light, &builder_error));
}

/* Lamps close above a wide floor, each of which lights little of it, some of them tilted; a lamp
 * all around; lights without extent, a sun, a narrow cone. */
static mcv_scene *make_scene(bool few) {
    mcv_scene *scene = mcv_scene_new("many lamps");
    ref_random random = {1};
    const uint32_t black = add_absorber(scene), grey = add_diffuse(scene, 0.5);
    add_rectangle(scene, 4, 4, grey, looking_up_z(0, 0, 0));
    add_box(scene, (const double[]){0.2, 0.3, 0.1}, grey, looking_up_z(0.3, 0.2, 0.1));
    for (int i = 0; i < LAMPS; ++i) {
        const double x = 4 * ref_random_unit(&random) - 2, y = 4 * ref_random_unit(&random) - 2,
                     z = 0.25 + 0.3 * ref_random_unit(&random), tilt = i % 4 ? 0 : 0.7;
        const double at[3] = {x, y, few ? z + 40 : z}, down[3] = {sin(tilt), 0, -cos(tilt)},
                     up[3] = {0, 1, 0};
        add_emitter(scene, MCV_EMITTER_AREA,
                    add_rectangle(scene, 0.2, 0.15, black, looking(at, down, up)),
                    1 + 2 * ref_random_unit(&random), 0);
    }
    if (few) return scene;
    add_emitter(scene, MCV_EMITTER_AREA,
                add_sphere(scene, 0.05, 8, black, looking_down_z(-1, 1, 0.5)), 5, 0);
    add_emitter(scene, MCV_EMITTER_PARALLEL,
                add_rectangle(scene, 0.2, 0.2, black, looking_down_z(1, 1, 0.5)), 1e3, 0.02);
    add_light(scene, MCV_EMITTER_POINT, looking_down_z(0.5, -0.5, 0.4));
    add_light(scene, MCV_EMITTER_SPOT, looking_down_z(-0.5, -0.5, 0.4));
    add_light(scene, MCV_EMITTER_SPOT, looking_down_z(-0.5, 0.5, 0.4));
    add_light(scene, MCV_EMITTER_DIRECTIONAL, looking_down_z(0, 0, 1));
    return scene;
}

/* Receivers, and their normals: the floor; in the middle of a lamp's cluster, aslant; on the wall
 * of the box; both sides; close to a lamp; high above, where nothing shines. */
static const double receivers[RECEIVERS][6] = {
    {0.1, -0.7, 0, 0, 0, 1}, {-0.9, 0.3, 0.3, 0.6, 0, 0.8}, {0.5, 0.2, 0.1, 1, 0, 0},
    {1, 1, 0.1, 0, 0, 0},    {-1.5, -1.2, 0.2, 0, 0, 1},    {0, 0, 0.2, 0, 0, -1}};

typedef struct chances {
    double counted[EMITTERS], said[EMITTERS], none;
} chances;

/* The first `count` cases; of an emitter's chance one tells all. */
static void launch(const mcv_device_scene *scene, cl_program program, uint32_t emitter,
                   size_t count, const float *in, float *out) {
    mcv_arg arguments[MCV_SCENE_ARGUMENTS + 3];
    cl_kernel kernel;
    cl_mem cases, results;
    const cl_uint number = emitter;
    const size_t bytes = 8 * sizeof(float) * count;
    BUILD(mcv_cl_kernel(program, "choose_emitter", &kernel, &builder_error));
    BUILD(mcv_cl_buffer(&cl, "cases", bytes, in, &cases, &builder_error));
    BUILD(mcv_cl_buffer(&cl, "results", bytes, NULL, &results, &builder_error));
    mcv_device_scene_arguments(scene, arguments);
    arguments[MCV_SCENE_ARGUMENTS] = MCV_ARG(number);
    arguments[MCV_SCENE_ARGUMENTS + 1] = MCV_ARG(cases);
    arguments[MCV_SCENE_ARGUMENTS + 2] = MCV_ARG(results);
    BUILD(mcv_cl_launch(&cl, kernel, count, 64, arguments, MCV_SCENE_ARGUMENTS + 3, NULL,
                        &builder_error));
    BUILD(mcv_cl_read(&cl, results, 0, bytes, out, &builder_error));
    mcv_cl_release(&cases);
    mcv_cl_release(&results);
    clReleaseKernel(kernel);
}

/* The numbers ξ are even, so an emitter is counted to one case at each end of its two ranges: 4 of
 * them. Choices by power have 20 bits, 2^-24 of all at each end. */
static void check_receiver(int number, const chances *c, const mcv_packed *packed) {
    const double *at = receivers[number];
    const mcv_vec3 receiver = mcv_vec((float)(at[0] - packed->centre[0]),
                                      (float)(at[1] - packed->centre[1]),
                                      (float)(at[2] - packed->centre[2])),
                   normal = mcv_vec((float)at[3], (float)at[4], (float)at[5]);
    double sum = c->none;
    for (int e = 0; e < EMITTERS; ++e) {
        sum += c->said[e];
        if (!(fabs(c->counted[e] - c->said[e]) <= 4.0 / CASES + 0x1p-23))
            fail_msg("receiver %d: emitter %d is chosen %.6g times of 1, its chance is %.6g",
                     number, e, c->counted[e], c->said[e]);
    }
    /* Products of the tree's levels round by some 2^-22 each. */
    if (!(fabs(sum - 1) <= EMITTERS * 4.0 / CASES * (c->none > 0) + 1e-5))
        fail_msg("receiver %d: the chances add up to %.7g", number, sum);
    /* What may bring something has more than its share of the choices by power. */
    for (uint32_t i = 0; i < packed->light_node_count; ++i) {
        const mcv_light_node *node = packed->light_tree + i;
        if (node->emitter == MCV_NONE || !(mcv_cluster_importance(node, receiver, normal) > 0))
            continue;
        const double by_power = (double)packed->emitters[node->emitter].probability / 16;
        if (!(c->said[node->emitter] > by_power))
            fail_msg("receiver %d: emitter %u, which may light it, has the chance %.3g", number,
                     node->emitter, c->said[node->emitter]);
    }
    print_message("receiver %d: nothing is chosen %.3g times of 1\n", number, c->none);
}

static void test_chances(void **state) {
    (void)state;
    mcv_scene *scene = make_scene(false);
    mcv_device_scene device;
    cl_program program;
    char options[2048];
    float *in = malloc(8 * sizeof(float) * CASES), *out = malloc(8 * sizeof(float) * CASES);
    assert_true(in && out);
    BUILD(mcv_device_scene_open(&cl, scene, 1, &device, &builder_error));
    const mcv_packed *packed = &device.packed;
    assert_true(packed->features >> MCV_FEATURE_LIGHT_TREE & 1);
    assert_int_equal(packed->emitter_count, EMITTERS);
    const mcv_frame frame = {.emitter_count = packed->emitter_count,
                             .light_tree_depth = packed->light_tree_depth};
    BUILD(mcv_cl_write(&cl, device.frame, 0, sizeof frame, &frame, &builder_error));
    mcv_feature_defines(packed->features, packed->channels, MCV_SENSOR_PINHOLE, MCV_SAMPLER_SOBOL,
                        MCV_BLOCK, options, sizeof options);
    BUILD(mcv_cl_build(&cl, "test/emitters", options, &program, &builder_error));
    for (int r = 0; r < RECEIVERS; ++r) {
        chances c = {{0}, {0}, 0};
        for (int i = 0; i < CASES; ++i) {
            for (int k = 0; k < 3; ++k) {
                in[8 * i + k] = (float)(receivers[r][k] - packed->centre[k]);
                in[8 * i + 3 + k] = (float)receivers[r][3 + k];
            }
            in[8 * i + 6] = (float)((i + 0.5) / CASES);
            in[8 * i + 7] = 0.25f;
        }
        for (uint32_t e = 0; e < EMITTERS; ++e) {
            launch(&device, program, e, 64, in, out);
            c.said[e] = (double)out[3];
        }
        launch(&device, program, 0, CASES, in, out);
        for (int i = 0; i < CASES; ++i) {
            const float *result = out + 8 * i;
            if (result[0] < 0) {
                c.none += 1.0 / CASES;
                continue;
            }
            c.counted[(int)result[0]] += 1.0 / CASES;
            if (result[1] != result[2])
                fail_msg("receiver %d: emitter %g is chosen with the chance %.9g, and weighed with "
                         "%.9g",
                         r, (double)result[0], (double)result[1], (double)result[2]);
        }
        check_receiver(r, &c, packed);
    }
    clReleaseProgram(program);
    mcv_device_scene_close(&device);
    mcv_scene_free(scene);
    free(in);
    free(out);
}

static mcv_film render(const mcv_scene *scene, uint32_t schedule, uint64_t samples,
                       bool reference) {
    mcv_render_options options = mcv_render_defaults();
    mcv_render_stats stats = {0};
    mcv_film film = {0};
    options.replicates = REPLICATES;
    options.last = samples;
    options.schedule = schedule;
    options.seed = reference;
    BUILD((reference ? mcv_reference_render : mcv_render)(scene, 0, &options, &film, &stats,
                                                          &builder_error));
    return film;
}

static void test_pictures(void **state) {
    (void)state;
    mcv_scene *scene = make_scene(false);
    const double s = sqrt(0.5);
    add_pinhole(scene, 12, 0.8,
                looking((const double[]){1, 1, 1}, (const double[]){-s * s, -s * s, -s},
                        (const double[]){-s * s, -s * s, s}));
    mcv_film tile = render(scene, MCV_SCHEDULE_TILE, 64, false),
             stream = render(scene, MCV_SCHEDULE_STREAM, 64, false),
             reference = render(scene, MCV_SCHEDULE_AUTO, 64, true);
    assert_memory_equal(tile.sums, stream.sums, mcv_film_values(&tile) * sizeof *tile.sums);
    expect_same_picture("many lamps", &tile, &reference);
    mcv_film_free(&tile);
    mcv_film_free(&stream);
    mcv_film_free(&reference);
    mcv_scene_free(scene);
}

/* From afar all lamps are alike: the walk would bring nothing. */
static void test_is_left_out_where_it_brings_nothing(void **state) {
    (void)state;
    mcv_scene *scene = make_scene(true);
    mcv_packed packed;
    BUILD(mcv_pack(scene, NULL, &packed, &builder_error));
    assert_false(packed.features >> MCV_FEATURE_LIGHT_TREE & 1);
    assert_null(packed.light_tree);
    mcv_packed_free(&packed);
    mcv_scene_free(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_chances),
        cmocka_unit_test(test_pictures),
        cmocka_unit_test(test_is_left_out_where_it_brings_nothing),
    };
    return cmocka_run_group_tests(tests, open_device, close_device);
}
