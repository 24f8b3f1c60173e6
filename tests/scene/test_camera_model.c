/* SPDX-License-Identifier: Apache-2.0 */
/* The camera model in the headers of images: points lie where the sensors' camera rays say, and
 * every file gives it back. */
#include "scene_builder.h"
#include "scene_files.h"

#include "analysis/render_error.h"
#include "io/exr.h"
#include "core/output_file.h"
#include "io/values.h"
#include "reference/sensor_ray.h"
#include "scene/camera_model.h"
#include "scene/params.h"
#include "scene/sensors.h"
#include "loader/load.h"

#include <unistd.h>

#define PROGRAM MCV_BINARY_DIR "/mcvisi"

static uint32_t state_of_random = 1;

static double uniform(void) {
    return (state_of_random = state_of_random * 1664525u + 1013904223u) / 4294967296.0;
}

/* --- projection
 * -------------------------------------------------------------------------------------------------
 */

enum { PLAIN, READ_OUT, VARIANTS };

/* The film is 40 x 30 (macro) pixels; read out of it are 24 x 16 from (6, 4), 2 x 4 as one; the
 * axis meets it beside its middle. */
static mcv_scene *scene_of(uint32_t type, int variant) {
    const double k = 1.0 / 3, forward[3] = {2 * k, -k, -2 * k}, up[3] = {k, -2 * k, 2 * k};
    mcv_scene *scene = mcv_scene_new("model");
    mcv_sensor sensor = sensor_defaults(type);
    uint32_t *resolution = mcv_params_find(mcv_sensor_table(type), "resolution", &sensor.as);
    uint32_t *region = mcv_params_find(mcv_sensor_table(type), "regionOfInterest", &sensor.as);
    uint32_t *binning = mcv_params_find(mcv_sensor_table(type), "binning", &sensor.as);
    double *pixel = mcv_params_find(mcv_sensor_table(type), "pixelSize", &sensor.as);
    double *principal = mcv_params_find(mcv_sensor_table(type), "principalPoint", &sensor.as);
    if (type == MCV_SENSOR_PINHOLE) {
        sensor.as.pinhole.imageDistance = 16e-3;
    } else if (type == MCV_SENSOR_TELECENTRIC) {
        sensor.as.telecentric.magnification = 0.25;
        sensor.as.telecentric.workingDistance = 0.11;
        sensor.as.telecentric.fNumber = 8;
        sensor.as.telecentric.lensDiameter = 0.1;
    } else if (type == MCV_SENSOR_THIN_LENS) {
        sensor.as.thin_lens.focalLength = 25e-3;
        sensor.as.thin_lens.focusDistance = 0.3;
        sensor.as.thin_lens.fNumber = 4;
    } else if (type == MCV_SENSOR_FLYING_SPOT) {
        sensor.as.flying_spot.wavelength = 660e-9;
        sensor.as.flying_spot.beamDiameter[0] = sensor.as.flying_spot.beamDiameter[1] = 1e-4;
        sensor.as.flying_spot.widthMeasure = 1;
        sensor.as.flying_spot.workingDistance = 0.11;
    } else {
        sensor.as.light_field.focalLength = 25e-3;
        sensor.as.light_field.focusDistance = 0.3;
        sensor.as.light_field.fNumber = 4;
        sensor.as.light_field.angularResolution[0] = 5;
        sensor.as.light_field.angularResolution[1] = 3;
        resolution = sensor.as.light_field.spatialResolution;
    }
    memcpy(resolution, (const uint32_t[2]){40, 30}, 2 * sizeof *resolution);
    memcpy(pixel, (const double[2]){5e-6, 4e-6}, 2 * sizeof *pixel);
    const bool scans = type == MCV_SENSOR_FLYING_SPOT;
    if (variant == READ_OUT) {
        memcpy(region, (const uint32_t[4]){6, 4, 24, 16}, 4 * sizeof *region);
        if (!scans) memcpy(binning, (const uint32_t[2]){2, 4}, 2 * sizeof *binning);
        memcpy(principal, (const double[2]){17.3, 41.9}, 2 * sizeof *principal);
    }
    add_sensor(scene, type, &sensor, looking((const double[3]){0.01, 0.2, -0.13}, forward, up));
    return scene;
}

/* Of double arithmetic on metres, of which 1e6 pixels make one: 1e-9 pixels; the accuracy that is
 * promised is asked for. */
static const double bound = 1e-6;

static void expect_seen(const mcv_camera_model *model, const ref_sensor_ray *sight, double distance,
                        double column, double row, const char *what) {
    const ref_vec o = sight->origin, d = sight->direction;
    const double point[3] = {o.x + distance * d.x, o.y + distance * d.y, o.z + distance * d.z};
    double pixel[2], back[3];
    assert_true(mcv_camera_model_project(model, point, pixel));
    if (!(fabs(pixel[0] - column) <= bound && fabs(pixel[1] - row) <= bound))
        fail_msg("%s: seen in (%.9f, %.9f), projected to (%.9f, %.9f)", what, column, row, pixel[0],
                 pixel[1]);
    mcv_camera_model_unproject(model, pixel, mcv_camera_model_depth(model, point), back);
    for (int k = 0; k < 3; ++k) /* rounding of 1 m */
        if (!(fabs(back[k] - point[k]) <= 1e-12))
            fail_msg("%s: coordinate %d comes back as %.15f, not %.15f", what, k, back[k],
                     point[k]);
}

/*
 * Points on chief rays, at any depth; and points in the plane in focus, on rays through all of the
 * pupil. A light field camera's rays of one macro pixel all look at its middle; of binned ones at
 * that of the one that the samples choose. The axis of a flying spot's beam is the ray of the
 * numbers 0; its other rays lie about it.
 */
static void check_projection(uint32_t type, int variant) {
    char what[64];
    mcv_camera_model model;
    mcv_scene *scene = scene_of(type, variant);
    const mcv_sensor *sensor = scene->sensors;
    const bool light_field = type == MCV_SENSOR_LIGHT_FIELD, scans = type == MCV_SENSOR_FLYING_SPOT;
    BUILD(mcv_camera_model_of(scene, sensor, &model, &builder_error));
    const mcv_readout readout = mcv_sensor_readout(sensor);
    snprintf(what, sizeof what, "%s, variant %d", mcv_sensor_types[type], variant);
    for (int i = 0; i < 1000; ++i) {
        const uint32_t column = (uint32_t)(uniform() * model.size[0]),
                       row = (uint32_t)(uniform() * model.size[1]);
        const double x = scans ? 0 : uniform(), y = uniform(), u = scans ? 0 : uniform(),
                     v = uniform();
        double seen[2] = {column + x, row + y};
        if (scans) seen[0] = column + 0.5, seen[1] = row + 0.5;
        if (light_field) {
            seen[0] = 5 * (column / 5 + (floor(u * readout.binning[0]) + 0.5) / readout.binning[0]);
            seen[1] = 3 * (row / 3 + (floor(v * readout.binning[1]) + 0.5) / readout.binning[1]);
        }
        const ref_sensor_ray any = ref_sensor_ray_sample(sensor, column, row, x, y, u, v);
        if (isfinite(model.focused_depth)) {
            double here[3], there[3];
            const double start[3] = {any.origin.x, any.origin.y, any.origin.z};
            for (int k = 0; k < 3; ++k) here[k] = start[k];
            there[0] = here[0] + any.direction.x, there[1] = here[1] + any.direction.y,
            there[2] = here[2] + any.direction.z;
            const double at = mcv_camera_model_depth(&model, here),
                         step = mcv_camera_model_depth(&model, there) - at;
            expect_seen(&model, &any, (model.focused_depth - at) / step, seen[0], seen[1], what);
        }
        /* The middle of 5 x 3 pixels is pixel (2, 1). */
        const ref_sensor_ray chief =
            light_field
                ? ref_sensor_ray_sample(sensor, column / 5 * 5 + 2, row / 3 * 3 + 1, 0.5, 0.5, u, v)
                : ref_sensor_ray_sample(sensor, column, row, x, y, 0, 0);
        expect_seen(&model, &chief, 0.02 + uniform(), seen[0], seen[1], what);
    }
    mcv_camera_model_free(&model);
    mcv_scene_free(scene);
}

static void test_points_lie_where_rays_see_them(void **state) {
    (void)state;
    for (uint32_t type = 0; type < MCV_SENSOR_COUNT; ++type)
        for (int variant = 0; variant < VARIANTS; ++variant) check_projection(type, variant);
}

/* What the header of mcv_camera_model says of its numbers, by hand: f_x = b over the pixel, c from
 * the corner, y down, z forward. */
static void test_numbers_by_hand(void **state) {
    mcv_camera_model model;
    double pixel[2];
    (void)state;
    mcv_scene *scene = mcv_scene_new("by hand");
    add_pinhole(scene, 100, 0.5, looking_down_z(0, 0, 2));
    scene->sensors[0].as.pinhole.imageDistance = 0.02;
    scene->sensors[0].as.pinhole.pixelSize[0] = scene->sensors[0].as.pinhole.pixelSize[1] = 1e-4;
    BUILD(mcv_camera_model_of(scene, scene->sensors, &model, &builder_error));
    assert_true(model.k[0] == 0.02 / 1e-4 && model.k[4] == 0.02 / 1e-4 && model.k[2] == 50 &&
                model.k[5] == 50);
    /* 1 m before the camera, 0.1 m to the right and 0.2 m up: 20 columns right of the middle, 40
     * rows above it. */
    assert_true(mcv_camera_model_project(&model, (const double[3]){0.1, 0.2, 1}, pixel));
    assert_true(fabs(pixel[0] - 70) < 1e-9 && fabs(pixel[1] - 10) < 1e-9);
    assert_true(model.rotation[0] == 1 && model.rotation[4] == -1 && model.rotation[8] == -1 &&
                model.translation[2] == 2);
    assert_false(
        mcv_camera_model_project(&model, (const double[3]){0, 0, 3}, pixel)); /* behind it */
    mcv_camera_model_free(&model);
    mcv_scene_free(scene);

    scene = scene_of(MCV_SENSOR_TELECENTRIC, PLAIN);
    BUILD(mcv_camera_model_of(scene, scene->sensors, &model, &builder_error));
    assert_true(model.telecentric && fabs(model.object_pixel[0] - 20e-6) < 1e-18 &&
                fabs(model.object_pixel[1] - 16e-6) < 1e-18);
    assert_true(fabs(model.focused_depth - 0.11) < 1e-15);
    mcv_camera_model_free(&model);
    mcv_scene_free(scene);
}

/* --- text
 * -------------------------------------------------------------------------------------------------------
 */

static void expect_same(const mcv_camera_model *a, const mcv_camera_model *b) {
    assert_int_equal(a->telecentric, b->telecentric);
    assert_memory_equal(a->size, b->size, sizeof a->size);
    assert_memory_equal(a->macro, b->macro, sizeof a->macro);
    assert_memory_equal(a->k, b->k, sizeof a->k);
    assert_memory_equal(a->affine, b->affine, sizeof a->affine);
    assert_memory_equal(a->rotation, b->rotation, sizeof a->rotation);
    assert_memory_equal(a->translation, b->translation, sizeof a->translation);
    assert_memory_equal(a->pixel, b->pixel, sizeof a->pixel);
    assert_memory_equal(a->object_pixel, b->object_pixel, sizeof a->object_pixel);
    assert_true(a->focused_depth == b->focused_depth ||
                (!isfinite(a->focused_depth) && !isfinite(b->focused_depth)));
    assert_true(a->f_number == b->f_number || (isnan(a->f_number) && isnan(b->f_number)));
    assert_true(a->bits == b->bits || (isnan(a->bits) && isnan(b->bits)));
    assert_int_equal(a->node_count, b->node_count);
    for (uint32_t i = 0; i < a->node_count; ++i) {
        assert_string_equal(a->nodes[i].name, b->nodes[i].name);
        assert_memory_equal(&a->nodes[i].to_world, &b->nodes[i].to_world,
                            sizeof a->nodes[i].to_world);
    }
}

static void add_frames(mcv_scene *scene, int count) {
    char name[32];
    for (int i = 0; i < count; ++i) {
        mcv_transform to_world =
            looking((const double[3]){uniform(), uniform(), uniform()},
                    (const double[3]){0.6, 0.8, 0}, (const double[3]){0, 0, 1});
        snprintf(name, sizeof name, i == 0 ? "Prüfling \"1\"" : "node %d", i);
        BUILD(mcv_scene_add_frame(scene, name, i % 2, &to_world, &builder_error));
    }
}

static void test_text_gives_every_bit_back(void **state) {
    (void)state;
    for (uint32_t type = 0; type < MCV_SENSOR_COUNT; ++type) {
        mcv_scene *scene = scene_of(type, READ_OUT);
        mcv_camera_model model, read;
        bool is_one;
        add_frames(scene, 7);
        BUILD(mcv_camera_model_of(scene, scene->sensors, &model, &builder_error));
        if (type == MCV_SENSOR_TELECENTRIC)
            model.bits = 12, model.black_level = 16, model.gain = 0.4;
        char *text = mcv_camera_model_write(&model);
        for (const char *c = text; *c; ++c) assert_true(*c >= ' ' && *c <= '~');
        BUILD(mcv_camera_model_read(text, "image", &read, &is_one, &builder_error));
        assert_true(is_one);
        expect_same(&model, &read);
        free(text);
        mcv_camera_model_free(&read);
        mcv_camera_model_free(&model);
        mcv_scene_free(scene);
    }
}

/* A text without any of its members, or with another there, is refused by a sentence with the file
 * and the member, or is not missed. */
static void test_damaged_texts(void **state) {
    static const char *const needed[] = {"R",           "t",     "A",    "pixelSize",
                                         "objectPixel", "model", "size", "nodes"};
    static const char *const wrong[][2] = {{"objectPixel", "[0,1]"}, {"objectPixel", "[1,-1]"},
                                           {"size", "[40.5,30]"},    {"pixelSize", "[0,1]"},
                                           {"nodes", "[1]"},         {"nodes", "[[]]"},
                                           {"bits", "\"12\""},       {"macroPixel", "[0,1]"}};
    mcv_camera_model model, read;
    mcv_error error = {""};
    bool is_one;
    (void)state;
    mcv_scene *scene = scene_of(MCV_SENSOR_TELECENTRIC, PLAIN);
    add_frames(scene, 1);
    BUILD(mcv_camera_model_of(scene, scene->sensors, &model, &builder_error));
    char *text = mcv_camera_model_write(&model);
    for (size_t i = 0; i < sizeof needed / sizeof needed[0]; ++i) {
        json_t *object = json_loads(text, 0, NULL);
        for (int change = 0; change < 2; ++change) {
            json_object_set_new(object, needed[i], change ? json_string("1") : json_integer(1));
            char *damaged = json_dumps(object, 0);
            assert_int_equal(mcv_camera_model_read(damaged, "image.png", &read, &is_one, &error),
                             MCV_BAD_INPUT);
            if (!strstr(error.text, "image.png") || !strstr(error.text, needed[i]))
                fail_msg("%s: %s", needed[i], error.text);
            free(damaged);
        }
        json_decref(object);
    }
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; ++i) {
        json_t *object = json_loads(text, 0, NULL);
        json_object_set_new(object, wrong[i][0], json_loads(wrong[i][1], JSON_DECODE_ANY, NULL));
        char *damaged = json_dumps(object, 0);
        if (mcv_camera_model_read(damaged, "image.png", &read, &is_one, &error) != MCV_BAD_INPUT ||
            !strstr(error.text, wrong[i][0]))
            fail_msg("%s %s: %s", wrong[i][0], wrong[i][1], error.text);
        free(damaged);
        json_decref(object);
    }
    static const char *const others[] = {"",
                                         "{}",
                                         "[]",
                                         "a picture of a bracket",
                                         "{\"format\":7}",
                                         "{\"format\":\"mcvisi camera model 1"};
    for (size_t i = 0; i < sizeof others / sizeof others[0]; ++i) {
        assert_int_equal(mcv_camera_model_read(others[i], "image.png", &read, &is_one, &error),
                         MCV_OK);
        assert_false(is_one);
    }
    assert_int_equal(mcv_camera_model_read(NULL, "image.png", &read, &is_one, &error), MCV_OK);
    assert_false(is_one);
    free(text);
    mcv_camera_model_free(&model);
    mcv_scene_free(scene);
}

/* 256 times 2^24 is 2^32, not 0. */
static void test_sizes_that_overflow(void **state) {
    mcv_camera_model model = {.size = {0, 0}, .macro = {1 << 24, 1 << 24}};
    (void)state;
    assert_false(mcv_camera_model_fit(&model, 256, 256));
}

/*
 * An image with a contour through its cells, whose errors are 0.25 DN on one side and 3 DN on the
 * other, in two channels: the text gives back each pixel's error, to half a thousandth. A text of
 * older versions, which tells neither edges apart nor of channels, does as well. One with too few
 * numbers, absurdly many cells or a correlation below -1 is refused.
 */
static void test_error_of_the_render(void **state) {
    static const char *const lists[] = {"level",          "milliBelow",        "milliAbove",
                                        "microEdgeBelow", "correlation",       "cells",
                                        "channels",       "channelCorrelation"};
    enum { WIDTH = 41, HEIGHT = 19, COUNT = 2 * WIDTH * HEIGHT };
    float values[COUNT], errors[COUNT];
    const mcv_image grey = {.width = WIDTH, .height = HEIGHT, .channels = 2, .pixels = values};
    const mcv_image known = {.width = WIDTH, .height = HEIGHT, .channels = 2, .pixels = errors};
    mcv_image found;
    mcv_camera_model model, read;
    mcv_error error = {""};
    bool is_one;
    (void)state;
    mcv_scene *scene = scene_of(MCV_SENSOR_TELECENTRIC, PLAIN);
    BUILD(mcv_camera_model_of(scene, scene->sensors, &model, &builder_error));
    for (size_t i = 0; i < COUNT; ++i) {
        const bool bright = 3 * (i % WIDTH) > 2 * (i / WIDTH % HEIGHT) + 17;
        values[i] = (float)((bright ? 3000 : 200) + i % 7);
        errors[i] = bright ? 3 : 0.25F;
    }
    BUILD(mcv_render_error_of(&grey, &known, &(mcv_correlation){4, 2, 0.5, 0.3}, 0.75, 3,
                              &model.render_error, &builder_error));
    char *text = mcv_camera_model_write(&model);
    json_t *older = json_loads(text, 0, NULL);
    json_object_del(json_object_get(older, "renderError"), "microEdgeBelow");
    json_object_del(json_object_get(older, "renderError"), "microEdgeAbove");
    json_object_del(json_object_get(older, "renderError"), "channelCorrelation");
    char *texts[] = {text, json_dumps(older, 0)};
    json_decref(older);
    for (int k = 0; k < 2; ++k) {
        BUILD(mcv_camera_model_read(texts[k], "image", &read, &is_one, &builder_error));
        const mcv_render_error *told = &read.render_error;
        assert_true(told->correlation[0] == 4 && told->correlation[1] == 2 &&
                    told->correlation[2] == 0.5 && told->freedom == 3 &&
                    told->shared == (k == 0 ? 0.75 : 1));
        BUILD(mcv_render_error_image(told, &grey, &found, &builder_error));
        /* A cell of one side alone is told apart by its own noise. */
        for (size_t i = 0; i < COUNT; ++i)
            if (fabs((double)found.pixels[i] - (double)errors[i]) > 0.5e-3)
                fail_msg("value %zu: an error of %g instead of %g", i, found.pixels[i], errors[i]);
        mcv_image_free(&found);
        mcv_camera_model_free(&read);
    }
    free(texts[1]);
    for (size_t i = 0; i < sizeof lists / sizeof lists[0]; ++i) {
        json_t *object = json_loads(text, 0, NULL),
               *render = json_object_get(object, "renderError"),
               *list = json_object_get(render, lists[i]);
        if (i < 5)
            json_array_remove(list, 0);
        else
            json_object_set_new(render, lists[i],
                                i == 5   ? json_pack("[i,i]", 1 << 24, 1 << 24)
                                : i == 6 ? json_integer(1 << 20)
                                         : json_real(-1.001));
        char *damaged = json_dumps(object, 0);
        mcv_camera_model none;
        assert_int_equal(mcv_camera_model_read(damaged, "image.png", &none, &is_one, &error),
                         MCV_BAD_INPUT);
        if (!strstr(error.text, "image.png") || !strstr(error.text, "renderError"))
            fail_msg("%s: %s", lists[i], error.text);
        free(damaged);
        json_decref(object);
    }
    free(text);
    mcv_camera_model_free(&model);
    mcv_scene_free(scene);
}

static void test_nodes_by_name(void **state) {
    mcv_camera_model model;
    const mcv_placement *frame;
    mcv_error error = {""};
    const mcv_transform here = looking_down_z(1, 2, 3), there = looking_down_z(4, 5, 6);
    (void)state;
    mcv_scene *scene = scene_of(MCV_SENSOR_PINHOLE, PLAIN);
    BUILD(mcv_scene_add_frame(scene, "part", true, &here, &error));
    BUILD(mcv_scene_add_frame(scene, "part", false, &there, &error));
    BUILD(mcv_scene_add_frame(scene, "bolt", true, &here, &error));
    BUILD(mcv_scene_add_frame(scene, "bolt", true, &there, &error));
    BUILD(mcv_scene_add_frame(scene, "", false, &there, &error));
    BUILD(mcv_camera_model_of(scene, scene->sensors, &model, &error));
    assert_int_equal(model.node_count, 4);
    BUILD(mcv_camera_model_node(&model, "part", "--edge", &frame, &error)); /* the rig's */
    assert_true(frame->to_world.m[9] == 4);
    assert_int_equal(mcv_camera_model_node(&model, "bolt", "--edge", &frame, &error), MCV_USAGE);
    assert_non_null(strstr(error.text, "2 nodes"));
    assert_int_equal(mcv_camera_model_node(&model, "patr", "--edge", &frame, &error), MCV_USAGE);
    assert_non_null(strstr(error.text, "did you mean \"part\""));
    /* What resembles none gets their list, if that is short. */
    assert_int_equal(mcv_camera_model_node(&model, "shaft", "--edge", &frame, &error), MCV_USAGE);
    assert_non_null(strstr(error.text, "among the 4 that it names: part, part, bolt, bolt"));
    char *name = model.nodes[1].name, wide[200] = "";
    memset(wide, 'x', sizeof wide - 1);
    model.nodes[1].name = wide;
    assert_int_equal(mcv_camera_model_node(&model, "shaft", "--edge", &frame, &error), MCV_USAGE);
    assert_string_equal(error.text, "--edge: there is no node \"shaft\" among the 4 that it names");
    model.nodes[1].name = name;
    mcv_camera_model_free(&model);
    mcv_scene_free(scene);
}

/* --- files
 * ------------------------------------------------------------------------------------------------------
 */

/*
 * A rig with a node that is scaled by 1/1000, 10, 20 and 30 mm off and turned by 90° about z, one
 * below it without a turn, 5 units off, and a telecentric camera of 20 µm pixels in the object, 110
 * mm above the plane z = 0.
 */
static const char rig[] =
    "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0,1]}],"
    "\"extensionsUsed\":[\"MCVISI_sensors\"],"
    "\"extensions\":{\"MCVISI_sensors\":{\"sensors\":[{\"name\":\"cam\",\"type\":\"telecentric\","
    "\"magnification\":0.25,"
    "\"workingDistance\":\"110mm\",\"fNumber\":8,\"resolution\":[40,30],\"pixelSize\":\"5um\","
    "\"principalPoint\":[16,8]}]}},"
    "\"nodes\":[{\"name\":\"cam\",\"translation\":[0,0,0.11],\"extensions\":{\"MCVISI_sensors\":{"
    "\"sensor\":0}}},"
    "{\"name\":\"part\",\"scale\":[0.001,0.001,0.001],\"translation\":[0.01,0.02,0.03],"
    "\"rotation\":[0,0,0.70710678118654752,0.70710678118654752],\"children\":[2]},"
    "{\"name\":\"hole\",\"translation\":[5,0,0]}]}";

static void test_nodes_of_a_file(void **state) {
    mcv_scene *scene;
    mcv_camera_model model;
    const mcv_placement *frame;
    double world[3];
    (void)state;
    char *path = write_bytes("camera_model.gltf", rig, strlen(rig));
    BUILD(mcv_scene_load(path, (mcv_overrides){NULL, 0}, &scene, &builder_error));
    BUILD(mcv_camera_model_of(scene, scene->sensors, &model, &builder_error));
    assert_int_equal(model.node_count, 3);
    BUILD(mcv_camera_model_node(&model, "part", "", &frame, &builder_error));
    mcv_transform_point(&frame->to_world, (const double[3]){1e-3, 2e-3, 3e-3},
                        world); /* metres, whatever the scale */
    assert_true(fabs(world[0] - 8e-3) < 1e-15 && fabs(world[1] - 21e-3) < 1e-15 &&
                fabs(world[2] - 33e-3) < 1e-15);
    BUILD(mcv_camera_model_node(&model, "hole", "", &frame, &builder_error));
    mcv_transform_point(&frame->to_world, (const double[3]){0, 0, 0}, world);
    assert_true(fabs(world[0] - 10e-3) < 1e-15 && fabs(world[1] - 25e-3) < 1e-15);
    mcv_camera_model_free(&model);
    mcv_scene_free(scene);
    free(path);
}

static void run(const char *line) {
    char *command = text_of("%s %s >/dev/null 2>camera_model.err", PROGRAM, line);
    if (system(command) != 0) fail_msg("mcvisi %s fails, see camera_model.err", line);
    free(command);
}

static char *model_text_of(const char *path) {
    mcv_image image;
    mcv_exr exr;
    if (!strstr(path, ".exr")) {
        BUILD(mcv_values_read(path, &image, &builder_error));
        char *text = image.description ? strdup(image.description) : NULL;
        mcv_image_free(&image);
        return text;
    }
    BUILD(mcv_exr_read(path, &exr, &builder_error));
    const mcv_attribute *attribute = mcv_exr_attribute(&exr, MCV_CAMERA_MODEL_KEY);
    char *text = attribute ? strdup(attribute->text) : NULL;
    mcv_exr_free(&exr);
    return text;
}

/* Through the program: every file that it writes of one sensor tells the same model, grey values
 * their bits as well. */
static void test_every_file_tells(void **state) {
    static const char *const files[] = {"cm.exr",      "cm.png",      "cm-grey-preview.png",
                                        "cm-grey.exr", "cm-grey.png", "cm-grey.tif"};
    mcv_scene *scene;
    enum { FILES = sizeof files / sizeof files[0] };
    (void)state;
    char *path = write_bytes("camera_model.gltf", rig, strlen(rig));
    BUILD(mcv_scene_load(path, (mcv_overrides){NULL, 0}, &scene, &builder_error));
    for (int resized = 0; resized < 2; ++resized) {
        char *line = text_of("render %s --device reference --spp 4 -o cm.exr%s", path,
                             resized ? " --resolution 80x60" : "");
        run(line);
        free(line);
        run("camera cm.exr --electrons-per-unit 100 --bits 10 --black-level 16 -o cm-grey.exr");
        run("camera cm.exr --electrons-per-unit 100 --bits 10 --black-level 16 -o cm-grey.png");
        run("camera cm.exr --electrons-per-unit 100 --bits 10 --black-level 16 -o cm-grey.tif");
        for (int i = 0; i < FILES; ++i) {
            mcv_camera_model model;
            bool is_one;
            double pixel[2];
            char *text = model_text_of(files[i]);
            if (!text) fail_msg("%s does not tell the camera model", files[i]);
            BUILD(mcv_camera_model_read(text, files[i], &model, &is_one, &builder_error));
            if (!is_one) fail_msg("%s: %s", files[i], text);
            /* 2 mm to the right and 1 mm up in the plane in focus are 100 and 50 pixels of 20 µm;
             * the axis meets the film in (16, 8). */
            assert_true(mcv_camera_model_project(&model, (const double[3]){2e-3, 1e-3, 0}, pixel));
            if (!(fabs(pixel[0] / (1 + resized) - 116) <= bound &&
                  fabs(pixel[1] / (1 + resized) + 42) <= bound))
                fail_msg("%s: (%.9f, %.9f) instead of (116, -42), times %d", files[i], pixel[0],
                         pixel[1], 1 + resized);
            assert_true(fabs(model.object_pixel[0] * (1 + resized) - 20e-6) < 1e-18);
            assert_int_equal(model.node_count, 3);
            if (i < 3)
                assert_true(isnan(model.bits));
            else
                assert_true(model.bits == 10 && model.black_level == 16 &&
                            fabs(model.gain - 1007.0 / 10000) < 1e-15);
            assert_int_equal(model.render_error.items != NULL,
                             i > 3); /* OpenEXR has it as a part; a preview has no grey values */
            mcv_camera_model_free(&model);
            free(text);
        }
    }
    for (int i = 0; i < FILES; ++i) unlink(files[i]);
    mcv_scene_free(scene);
    free(path);
}

/* The report of `mcvisi measure` with these options. */
static json_t *measured(const char *options) {
    char *line =
             text_of("measure %s --region r=@part:-20.1mm,9.9mm,0mm,0.4mm,0.2mm --json", options),
         *command = text_of("%s %s >camera_model.json 2>camera_model.err", PROGRAM, line);
    if (system(command) != 0) fail_msg("mcvisi %s fails, see camera_model.err", line);
    json_t *report = json_load_file("camera_model.json", 0, NULL);
    assert_non_null(report);
    free(line);
    free(command);
    return report;
}

/*
 * An image of other pixels than the scene's sensor has. Its header tells that --resolution changed
 * them: scene and header then say the same places and lengths. A sensor of another film is another
 * one, and so is an image without header.
 */
static void test_resized_images_go_with_their_scene(void **state) {
    static const char *const wrong[] = {"cm.exr --set sensors/cam/pixelSize=4um", "cm-bare.png"};
    (void)state;
    char *path = write_bytes("camera_model.gltf", rig, strlen(rig));
    char *line = text_of("render %s --device reference --spp 4 -o cm.exr --resolution 80x90", path),
         *with = text_of("cm.exr --scene %s", path);
    run(line);
    json_t *header = measured("cm.exr"), *scene = measured(with);
    free(line);
    free(with);
    if (!json_equal(header, scene)) fail_msg("with --scene the report is another one");
    json_decref(header);
    json_decref(scene);
    mcv_image bare;
    BUILD(mcv_image_new(&bare, 80, 90, 1, &builder_error));
    BUILD(mcv_values_write("cm-bare.png", &bare, 8, &builder_error));
    mcv_image_free(&bare);
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; ++i) {
        char *command = text_of("%s measure %s --scene %s >/dev/null 2>camera_model.err", PROGRAM,
                                wrong[i], path);
        assert_int_not_equal(system(command), 0);
        free(command);
        uint8_t *said;
        size_t size;
        BUILD(mcv_file_load("camera_model.err", &said, &size, &builder_error));
        if (!memmem(said, size, "80 x 90 pixels, but sensor cam", 30))
            fail_msg("%s: %.*s", wrong[i], (int)size, (const char *)said);
        free(said);
    }
    unlink("cm.exr");
    unlink("cm.png");
    unlink("cm-bare.png");
    free(path);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_points_lie_where_rays_see_them),
        cmocka_unit_test(test_numbers_by_hand),
        cmocka_unit_test(test_text_gives_every_bit_back),
        cmocka_unit_test(test_damaged_texts),
        cmocka_unit_test(test_sizes_that_overflow),
        cmocka_unit_test(test_error_of_the_render),
        cmocka_unit_test(test_nodes_by_name),
        cmocka_unit_test(test_nodes_of_a_file),
        cmocka_unit_test(test_every_file_tells),
        cmocka_unit_test(test_resized_images_go_with_their_scene),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
