/* SPDX-License-Identifier: Apache-2.0 */
/* Places in the coordinates of a part: where they lie in the image, what is refused, and that they
 * end in lengths. */
#include "scene_builder.h"
#include "scene_files.h"

#include "analysis/part_place.h"
#include "io/grid.h"

#include <jansson.h>
#include <unistd.h>

#define PROGRAM MCV_BINARY_DIR "/mcvisi"

/*
 * 100 x 80 pixels of 20 µm in the object about the axis z, 110 mm above z = 0; a node turned by 90°
 * about z, whose x is the world's y and whose y is -x; one far away, one above the camera.
 */
static mcv_scene *scene_of(uint32_t type) {
    mcv_scene *scene = mcv_scene_new("places");
    mcv_sensor sensor = sensor_defaults(type);
    double *pixel = mcv_params_find(mcv_sensor_table(type), "pixelSize", &sensor.as);
    uint32_t *resolution = mcv_params_find(mcv_sensor_table(type), "resolution", &sensor.as);
    pixel[0] = pixel[1] = 5e-6;
    resolution[0] = 100, resolution[1] = 80;
    if (type == MCV_SENSOR_TELECENTRIC) {
        sensor.as.telecentric.magnification = 0.25;
        sensor.as.telecentric.workingDistance = 0.11;
        sensor.as.telecentric.fNumber = 8;
    } else {
        sensor.as.pinhole.imageDistance = 0.0275; /* 20 µm a pixel in 110 mm, 10 µm in 55 mm */
    }
    add_sensor(scene, type, &sensor, looking_down_z(0, 0, 0.11));
    const mcv_transform turned = {{0, -1, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0}},
                        far = looking_up_z(1, 0, 0), above = looking_up_z(0, 0, 1);
    BUILD(mcv_scene_add_frame(scene, "part", false, &turned, &builder_error));
    BUILD(mcv_scene_add_frame(scene, "far + away", false, &far, &builder_error));
    BUILD(mcv_scene_add_frame(scene, "above", false, &above, &builder_error));
    return scene;
}

static void expect_place(const mcv_camera_model *model, const char *text, const char *expected) {
    char *out;
    BUILD(mcv_part_place_resolve("--edge", text, model, &out, &builder_error));
    if (strcmp(out, expected) != 0) fail_msg("%s: %s instead of %s", text, out, expected);
    free(out);
}

static void expect_refused(const mcv_camera_model *model, const char *text, const char *part) {
    char *out;
    mcv_error error = {""};
    assert_int_equal(mcv_part_place_resolve("--edge", text, model, &out, &error), MCV_USAGE);
    if (!strstr(error.text, part) || !strstr(error.text, text))
        fail_msg("%s: %s", text, error.text);
    assert_null(out);
}

static void test_places_become_pixels(void **state) {
    mcv_camera_model model;
    (void)state;
    mcv_scene *scene = scene_of(MCV_SENSOR_TELECENTRIC);
    BUILD(mcv_camera_model_of(scene, scene->sensors, &model, &builder_error));
    /* (0.2, 0.1) mm of the part is (-0.1, 0.2) mm of the world: 5 columns left of 50, 10 rows above
     * 40; the size is 20 x 10 pixels. */
    expect_place(&model, "a=@part:0.2mm,0.1mm,0mm,0.4mm,0.2mm", "a=35,25,20,10");
    expect_place(&model, "@part:200um, 1e-4, -3cm, 0.4 mm, 2e-4",
                 "35,25,20,10"); /* any depth, any unit, or metres */
    expect_place(&model, "a=@part:0.2mm,0.1mm,0mm,0.4mm,0.2mm+1,2,30,40+@part:0,0,0,1mm,1mm",
                 "a=35,25,20,10+1,2,30,40+25,15,50,50");
    expect_place(&model, "a=1,2,30,40", "a=1,2,30,40");
    expect_place(&model, "mask.png", "mask.png");
    expect_refused(&model, "a=@far + away:0,0,0,1mm,1mm", "column 50050");
    expect_refused(&model, "a=@prat:0,0,0,1mm,1mm", "did you mean \"part\"");
    expect_refused(&model, "a=@part:0,0,0,1mm", "lengths with units");
    expect_refused(&model, "a=@part:0,0,0,1mm,1mm,1mm", "lengths with units");
    expect_refused(&model, "a=@part:0,0,0,1deg,1mm", "lengths with units");
    expect_refused(&model, "a=@part:0,0,0,0mm,1mm", "lengths with units");
    expect_refused(&model, "a=@part", "lengths with units");
    expect_refused(&model, "a=@part:0.9mm,0,0,1mm,1mm",
                   "from row -30 to 20"); /* 45 rows above 40, 50 high */
    expect_refused(&model, "a=@part:1mm,-20,0,1mm,1mm",
                   "a length without a unit is in metres"); /* 20 m away */
    expect_refused(NULL, "a=@part:0,0,0,1mm,1mm", "--scene");
    mcv_camera_model_free(&model);
    mcv_scene_free(scene);

    scene = scene_of(MCV_SENSOR_PINHOLE);
    BUILD(mcv_camera_model_of(scene, scene->sensors, &model, &builder_error));
    expect_place(&model, "a=@part:0.2mm,0.1mm,0mm,0.4mm,0.2mm", "a=35,25,20,10");
    expect_place(&model, "a=@part:0.1mm,50um,55mm,0.2mm,0.1mm",
                 "a=35,25,20,10"); /* half as far, twice as large */
    expect_refused(&model, "a=@above:0,0,0,1mm,1mm", "behind the camera");
    mcv_camera_model_free(&model);
    mcv_scene_free(scene);
}

/* What stands at a place of the grid lies there: the same numbers, projected. */
static void test_grid_tells_what_projection_says(void **state) {
    (void)state;
    for (uint32_t type = 0; type < 2; ++type) {
        mcv_camera_model model;
        const mcv_placement *node;
        double a[3][3];
        mcv_scene *scene = scene_of(type ? MCV_SENSOR_TELECENTRIC : MCV_SENSOR_PINHOLE);
        BUILD(mcv_camera_model_of(scene, scene->sensors, &model, &builder_error));
        BUILD(mcv_camera_model_node(&model, "part", "", &node, &builder_error));
        mcv_grid_coordinates(&model, node, a);
        for (int i = 0; i < 20; ++i) {
            const double column = 5 * i, row = 80 - 3 * i;
            double local[3], world[3], pixel[2];
            for (int k = 0; k < 3; ++k) local[k] = a[k][0] * column + a[k][1] * row + a[k][2];
            mcv_transform_point(&node->to_world, local, world);
            assert_true(mcv_camera_model_project(&model, world, pixel));
            if (!(fabs(pixel[0] - column) < 1e-6 && fabs(pixel[1] - row) < 1e-6))
                fail_msg("(%g, %g) mm drawn at (%g, %g) lies at (%.9g, %.9g)", 1e3 * local[0],
                         1e3 * local[1], column, row, pixel[0], pixel[1]);
        }
        mcv_camera_model_free(&model);
        mcv_scene_free(scene);
    }
    assert_true(fabs(mcv_grid_step(76.8, 8) - 10) < 1e-9 &&
                fabs(mcv_grid_step(0.08, 8) - 0.01) < 1e-12);
    assert_true(fabs(mcv_grid_step(1, 8) - 0.2) < 1e-12 && fabs(mcv_grid_step(3, 8) - 0.5) < 1e-12);
}

/* --- through the program
 * ---------------------------------------------------------------------------------------- */

/* A panel 0.61 mm wide that shines at the camera, in the plane in focus; 64 x 48 pixels of 20 µm.
 */
static const char rig[] =
    "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0,1]}],"
    "\"extensionsUsed\":[\"MCVISI_sensors\",\"MCVISI_"
    "emitters\"],"
    "\"extensions\":{\"MCVISI_sensors\":{\"sensors\":[{\"name\":\"cam\",\"type\":\"telecentric\","
    "\"magnification\":0.25,"
    "\"workingDistance\":\"110mm\",\"fNumber\":8,\"resolution\":[64,48],\"pixelSize\":\"5um\"}]},"
    "\"MCVISI_emitters\":{\"emitters\":[{\"name\":\"lit\",\"type\":\"area\",\"size\":[\"0.61mm\","
    "\"0.61mm\"],\"radiance\":1}]}},"
    "\"nodes\":[{\"name\":\"cam\",\"translation\":[0,0,0.11],\"extensions\":{\"MCVISI_sensors\":{"
    "\"sensor\":0}}},"
    "{\"name\":\"panel\",\"rotation\":[0,1,0,0],\"extensions\":{\"MCVISI_emitters\":{\"emitter\":0}"
    "}}]}";

static int run(const char *line, const char *out) {
    char *command = text_of("%s %s >%s 2>part_place.err", PROGRAM, line, out);
    const int status = system(command);
    free(command);
    return status;
}

/* The length in mm between both edges, and its uncertainty. */
static double length_of(const char *line, double *uncertainty) {
    json_error_t wrong;
    if (run(line, "part_place.json") != 0) fail_msg("mcvisi %s fails, see part_place.err", line);
    json_t *report = json_load_file("part_place.json", 0, &wrong);
    const json_t *length =
        json_object_get(json_array_get(json_object_get(report, "distances"), 0), "length");
    const double value = 1e3 * json_number_value(json_object_get(length, "value"));
    *uncertainty = 1e3 * json_number_value(json_object_get(length, "uncertainty"));
    json_decref(report);
    return value;
}

static void test_measure_ends_in_millimetres(void **state) {
    static const char *const files[] = {"pp.exr", "pp-grey.png", "pp-grey.tif"};
    double uncertainty;
    (void)state;
    char *path = write_bytes("part_place.gltf", rig, strlen(rig));
    char *line = text_of("render %s --device reference --spp 256 -o pp.exr", path);
    assert_int_equal(run(line, "/dev/null"), 0);
    free(line);
    assert_int_equal(
        run("camera pp.exr --electrons-per-unit 8000 --noise-free --lens-mtf none -o pp-grey.png",
            "/dev/null"),
        0);
    assert_int_equal(
        run("camera pp.exr --electrons-per-unit 8000 --noise-free --lens-mtf none -o pp-grey.tif",
            "/dev/null"),
        0);
    for (int i = 0; i < 3; ++i) {
        /* The panel's x points to the left: its node is turned about y. */
        line = text_of("measure %s --edge right=@panel:-0.305mm,0mm,0mm,0.3mm,0.3mm --edge "
                       "left=@panel:0.305mm,0mm,0mm,0.3mm,0.3mm --json"
                       " --grid panel=pp-grid.png",
                       files[i]);
        unlink("pp-grid.png");
        const double length = length_of(line, &uncertainty);
        print_message("  %s: %.5f ± %.5f mm\n", files[i], length, uncertainty);
        /* Fifteen rows of 256 samples in the pixel that the edge cuts: 20 µm √(2 · 1/4/(256 · 15))
         * = 0.2 µm, times 4. */
        if (!(fabs(length - 0.61) < 0.001)) fail_msg("%s: %g mm instead of 0.61", files[i], length);
        assert_int_equal(access("pp-grid.png", R_OK), 0);
        free(line);
    }
    /* A header that does not tell: --scene does. */
    assert_int_equal(
        run("camera pp.exr --electrons-per-unit 8000 --noise-free --lens-mtf none -o pp-grey.npy",
            "/dev/null"),
        0);
    assert_int_not_equal(
        run("measure pp-grey.npy --edge a=@panel:-0.305mm,0,0,0.3mm,0.3mm", "/dev/null"), 0);
    line = text_of("measure pp-grey.npy --scene %s --edge a=@panel:-0.305mm,0,0,0.3mm,0.3mm --edge "
                   "b=@panel:0.305mm,0,0,0.3mm,0.3mm --json",
                   path);
    assert_true(fabs(length_of(line, &uncertainty) - 0.61) < 0.001);
    free(line);
    /* A set of a sweep takes the places of its own scene: the panel is moved by 2 pixels, and
     * measured where it is. */
    line = text_of(
        "sweep %s --vary nodes/panel/translation/0=0,4e-5 --device reference --spp 64 -o pp.csv "
        "--edge a=@panel:-0.305mm,0,0,0.3mm,0.3mm --edge b=@panel:0.305mm,0,0,0.3mm,0.3mm --metric "
        "a.position --metric b.length",
        path);
    unlink("pp.csv"); /* of an earlier run */
    if (run(line, "/dev/null") != 0) fail_msg("mcvisi %s fails, see part_place.err", line);
    free(line);
    FILE *table = fopen("pp.csv", "r");
    char row[512];
    double at[2] = {NAN, NAN}, width = NAN;
    assert_non_null(table);
    assert_non_null(fgets(row, sizeof row, table));
    for (int i = 0; i < 2; ++i) {
        assert_non_null(fgets(row, sizeof row, table));
        char *rest,
            *field =
                strtok_r(row, ",", &rest); /* set, what is swept, place, its uncertainty, width */
        for (int column = 0; field && column < 5; ++column, field = strtok_r(NULL, ",", &rest)) {
            if (column == 2) at[i] = strtod(field, NULL);
            if (column == 4) width = strtod(field, NULL);
        }
        assert_true(fabs(width - 0.61e-3) < 2e-6); /* a quarter of the samples */
    }
    fclose(table);
    assert_true(fabs(at[1] - at[0] - 2) < 0.1);
    free(path);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_places_become_pixels),
        cmocka_unit_test(test_grid_tells_what_projection_says),
        cmocka_unit_test(test_measure_ends_in_millimetres),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
