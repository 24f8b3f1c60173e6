/* SPDX-License-Identifier: Apache-2.0 */
/* Routes of the light in a pixel: shares with closed forms, and their words. */
#include "facing_rig.h"
#include "transport.h"

#include <jansson.h>
#include <math.h>

/* A camera looks down at a grey sheet under two point lights of 1 and 3 W/sr, 1 m above the middle
 * of what it sees, and a sky. */
#define SCENE(sky) \
    "{\"asset\": {\"version\": \"2.0\"}, \"scene\": 0, \"scenes\": [{\"nodes\": [0, 1, 2, 3" sky \
    "]}]," \
    " \"extensions\": {\"MCVISI_sensors\": {\"sensors\": [{\"name\": \"camera\"," \
    " \"type\": \"pinhole\", \"imageDistance\": \"10mm\", \"resolution\": [9, 9]," \
    " \"pixelSize\": \"1um\"}]}, \"MCVISI_emitters\": {\"emitters\": [" \
    " {\"name\": \"weak\", \"type\": \"point\", \"intensity\": 1}," \
    " {\"name\": \"strong\", \"type\": \"point\", \"intensity\": 3}," \
    " {\"name\": \"sky\", \"type\": \"environment\", \"radiance\": 0.5}]}}," \
    " \"materials\": [{\"name\": \"white\", \"extensions\": {\"MCVISI_materials\": " \
    "{\"type\": \"diffuse\", \"reflectance\": 0.5}}}]," \
    " \"nodes\": [{\"name\": \"camera\", \"translation\": [0, 0, 2]," \
    "   \"extensions\": {\"MCVISI_sensors\": {\"sensor\": 0}}}," \
    "  {\"name\": \"weak\", \"translation\": [0, 0, 1]," \
    "   \"extensions\": {\"MCVISI_emitters\": {\"emitter\": 0}}}," \
    "  {\"name\": \"strong\", \"translation\": [0, 0, 1]," \
    "   \"extensions\": {\"MCVISI_emitters\": {\"emitter\": 1}}}," \
    "  {\"name\": \"sheet\", \"mesh\": 0}," \
    "  {\"name\": \"sky\", \"extensions\": {\"MCVISI_emitters\": {\"emitter\": 2}}}]," \
    " \"meshes\": [{\"primitives\": [{\"attributes\": {\"POSITION\": 0}, \"indices\": 1," \
    " \"material\": 0}]}]," \
    " \"buffers\": [{\"byteLength\": 60, \"uri\": \"data:application/octet-stream;base64," \
    "AADIwQAAyMEAAAAAAADIQQAAyMEAAAAAAADIQQAAyEEAAAAAAADIwQAAyEEAAAAAAAABAAIAAAACAAMA\"}]," \
    " \"bufferViews\": [{\"buffer\": 0, \"byteLength\": 48}," \
    " {\"buffer\": 0, \"byteOffset\": 48, \"byteLength\": 12}]," \
    " \"accessors\": [{\"bufferView\": 0, \"componentType\": 5126, \"count\": 4, \"type\": " \
    "\"VEC3\"," \
    " \"min\": [-25, -25, 0], \"max\": [25, 25, 0]}," \
    " {\"bufferView\": 1, \"componentType\": 5123, \"count\": 6, \"type\": \"SCALAR\"}]}"

static json_t *explain_rig(mcv_rig *rig, const char *options) {
    mcv_session *session = open_session(NULL);
    char *report = NULL;
    json_error_t wrong;
    WELL(mcv_session_explain(session, rig, options, &report, &error));
    json_t *found = json_loads(report, 0, &wrong);
    assert_non_null(found);
    mcv_text_free(report);
    mcv_rig_free(rig);
    mcv_session_close(session);
    return found;
}

static json_t *explain(const char *scene, const char *options) {
    return explain_rig(parse_rig(scene), options);
}

static double number(const json_t *of, const char *key) {
    return json_number_value(json_object_get(of, key));
}

static void expect_route(const json_t *routes, size_t i, const char *name, double share,
                         double tolerance) {
    const json_t *route = json_array_get(routes, i), *found = json_object_get(route, "share");
    assert_string_equal(json_string_value(json_object_get(route, "name")), name);
    if (!(fabs(number(found, "value") - share) <= tolerance))
        fail_msg("%s: share %.9g ± %.2g, expected %.9g", name, number(found, "value"),
                 number(found, "uncertainty"), share);
    /* Where each path has the same share, so has each replicate. */
    if (!(number(found, "uncertainty") <= tolerance))
        fail_msg("%s: share ± %.2g", name, number(found, "uncertainty"));
}

/* Both lights are at one place: each path finds them with shares of 1 and 3 to 4, exactly but for
 * the roundings of a few products. The sheet is lit as L = ρ/π I/r². */
static void test_shares_of_two_lights(void **state) {
    (void)state;
    json_t *found = explain(SCENE(""), "{\"pixel\": \"4,4\", \"spp\": 64}");
    const json_t *routes = json_object_get(found, "routes");
    assert_int_equal(json_array_size(routes), 2);
    expect_route(routes, 0, "camera <- node \"sheet\" scatters <- emitter \"strong\"", 0.75, 1e-14);
    expect_route(routes, 1, "camera <- node \"sheet\" scatters <- emitter \"weak\"", 0.25, 1e-14);
    /* The pixel is seen within 1e-4 rad of the foot, where cos^4 is 1 to 1e-7. */
    const double value = number(json_object_get(found, "value"), "value");
    if (!(fabs(value - 0.5 * 4 / M_PI) <= 1e-6)) fail_msg("value %.9g, expected 2/π", value);
    const json_t *path = json_object_get(json_array_get(routes, 0), "path");
    assert_int_equal(json_array_size(path), 3);
    const double z[] = {2, 0, 1};
    for (size_t i = 0; i < 3; ++i)
        assert_true(fabs(json_number_value(json_array_get(json_array_get(path, i), 2)) - z[i]) <
                    1e-6);
    json_decref(found);
}

/*
 * A pixel that sees 2 x 2 m of the sheet: light comes from its middle most of all, as cos^4 of
 * either slope falls. Of 1024 points some 30 lie within 0.2 m.
 */
static void test_strongest_path(void **state) {
    (void)state;
    mcv_rig *rig = parse_rig(SCENE(""));
    WELL(mcv_rig_set(rig, "sensors/camera/pixelSize", "10mm", &error));
    json_t *found = explain_rig(rig, "{\"pixel\": \"4,4\", \"spp\": 1024}");
    const json_t *routes = json_object_get(found, "routes");
    for (size_t i = 0; i < 2; ++i) {
        const json_t *path = json_object_get(json_array_get(routes, i), "path"),
                     *foot = json_array_get(path, 1);
        const double x = json_number_value(json_array_get(foot, 0)),
                     y = json_number_value(json_array_get(foot, 1));
        if (!(hypot(x, y) < 0.2)) fail_msg("the path meets the sheet at %g, %g", x, y);
    }
    json_decref(found);
}

/* A surface that scatters a path several times in a row counts once. */
static void test_routes_within_a_box(void **state) {
    (void)state;
    mcv_rig *rig = NULL;
    bool again = false;
    WELL(mcv_rig_open(MCV_SOURCE_DIR "/scenes/diffuse-box.gltf", &rig, &error));
    json_t *found = explain_rig(
        rig, "{\"pixel\": \"30,20\", \"resolution\": \"64x48\", \"spp\": 64, \"routes\": 100}");
    const json_t *route;
    size_t i;
    json_array_foreach(json_object_get(found, "routes"), i, route) {
        const char *name = json_string_value(json_object_get(route, "name"));
        if (strstr(name, "scatters 2 times")) fail_msg("%s", name);
        again = again || strstr(name, "scatters once or more");
    }
    assert_true(again);
    json_decref(found);
}

/* With a sky of L = 0.5 all around, the sheet adds ρ L = 0.25 to 2/π. The sky is found by the paths
 * that leave the sheet, all with the same value. */
static void test_share_of_a_sky(void **state) {
    (void)state;
    const double sky = 0.25 / (0.25 + 2 / M_PI);
    json_t *found = explain(SCENE(", 4"), "{\"pixel\": \"4,4\", \"spp\": 4096}");
    const json_t *routes = json_object_get(found, "routes");
    assert_int_equal(json_array_size(routes), 3);
    expect_route(routes, 0, "camera <- node \"sheet\" scatters <- emitter \"strong\"",
                 0.75 * (1 - sky), 1e-6);
    expect_route(routes, 1, "camera <- node \"sheet\" scatters <- emitter \"sky\"", sky, 1e-6);
    json_decref(found);
}

/* The mean of a pixel's channels. */
static double mean_of_pixel(const mcv_picture *picture, uint32_t part_number, uint32_t column,
                            uint32_t row) {
    mcv_part part = {.size = sizeof part};
    double mean = 0;
    WELL(mcv_picture_part(picture, part_number, &part, &error));
    for (uint32_t c = 0; c < part.channels; ++c)
        mean += (double)part.planes[((size_t)c * part.height + row) * part.width + column] /
                part.channels;
    return mean;
}

/* A camera looks along the axis of a lens of n = 1.5 into a sky. */
static const char lens_scene[] =
    "{\"asset\": {\"version\": \"2.0\"}, \"scene\": 0, \"scenes\": [{\"nodes\": [0, 1, 2]}],"
    " \"extensions\": {\"MCVISI_sensors\": {\"sensors\": [{\"name\": \"camera\","
    " \"type\": \"pinhole\", \"imageDistance\": \"10mm\", \"resolution\": [9, 9],"
    " \"pixelSize\": \"1um\"}]}, \"MCVISI_emitters\": {\"emitters\": ["
    " {\"name\": \"sky\", \"type\": \"environment\", \"radiance\": 1}]},"
    " \"MCVISI_surfaces\": {\"surfaces\": [{\"type\": \"lens\", \"surfaces\": ["
    "{\"radius\": \"310mm\", \"semiDiameter\": \"14mm\", \"thickness\": \"6mm\","
    " \"material\": \"glass\"}, {\"radius\": \"-310mm\", \"semiDiameter\": \"14mm\"}]}]}},"
    " \"materials\": [{\"name\": \"glass\", \"extensions\": {\"MCVISI_materials\":"
    " {\"type\": \"dielectric\", \"ior\": 1.5}}}],"
    " \"nodes\": [{\"name\": \"camera\", \"translation\": [0, 0, 0.1],"
    "   \"extensions\": {\"MCVISI_sensors\": {\"sensor\": 0}}},"
    "  {\"name\": \"lens\", \"extensions\": {\"MCVISI_surfaces\": {\"surface\": 0}}},"
    "  {\"name\": \"sky\", \"extensions\": {\"MCVISI_emitters\": {\"emitter\": 0}}}]}";

/*
 * The ghosts of a lens by brightness. Light that meets its faces head on is reflected by R = 0.04:
 * (1 - R)² passes, R is reflected in front, R (1 - R)² behind, R² (1 - R)² passes after two
 * reflections inside. All shares add up to 1, as the sky is even. Angles are below 1e-3 there,
 * which changes R by 1e-6. Four and a half deviations of binomial shares: 1e-5 of chance.
 */
static void test_ghosts_of_a_lens(void **state) {
    (void)state;
    enum { PATHS = 1 << 18 };
    static const struct {
        const char *name;
        double share;
    } ghosts[] = {
        {"camera <- node \"lens\" refracts 2 times <- emitter \"sky\"", 0.96 * 0.96},
        {"camera <- node \"lens\" reflects <- emitter \"sky\"", 0.04},
        {"camera <- node \"lens\" refracts <- node \"lens\" reflects <- node \"lens\" refracts <- "
         "emitter \"sky\"",
         0.04 * 0.96 * 0.96},
        {"camera <- node \"lens\" refracts <- node \"lens\" reflects 2 times <- node \"lens\" "
         "refracts <- emitter \"sky\"",
         0.04 * 0.04 * 0.96 * 0.96},
    };
    json_t *found = explain(lens_scene, "{\"pixel\": \"4,4\", \"spp\": 262144}");
    const json_t *routes = json_object_get(found, "routes");
    assert_true(json_array_size(routes) >= 4);
    assert_true(fabs(number(json_object_get(found, "value"), "value") - 1) < 1e-6);
    for (size_t i = 0; i < 4; ++i) {
        const double share = ghosts[i].share;
        expect_route(routes, i, ghosts[i].name, share,
                     4.5 * sqrt(share * (1 - share) / PATHS) + 1e-6);
    }
    json_decref(found);
}

/* The value is the pixel of the reference renderer: paths are the same, numbered alike. */
static void test_value_is_the_render(void **state) {
    (void)state;
    mcv_rig *rig = NULL;
    mcv_session *session = open_session(NULL);
    mcv_picture *picture = NULL;
    char *report = NULL;
    json_error_t wrong;
    WELL(mcv_rig_open(MCV_SOURCE_DIR "/scenes/caustic.gltf", &rig, &error));
    WELL(mcv_session_explain(session, rig,
                             "{\"pixel\": \"7,9\", \"resolution\": \"16x12\", \"spp\": 256}",
                             &report, &error));
    json_t *found = json_loads(report, 0, &wrong);
    mcv_text_free(report);
    WELL(mcv_session_render(session, rig,
                            "{\"device\": \"reference\", \"resolution\": \"16x12\", \"spp\": 256, "
                            "\"replicates\": 16}",
                            NULL, NULL, &picture, NULL, &error));
    const double rendered = mean_of_pixel(picture, 0, 7, 9);
    const double value = number(json_object_get(found, "value"), "value");
    /* One rounding to float of each channel. */
    if (!(fabs(value - rendered) <= 0x1p-23 * rendered))
        fail_msg("explained %.9g, rendered %.9g", value, rendered);
    const double deviation = number(json_object_get(found, "value"), "uncertainty"),
                 stated = mean_of_pixel(picture, 1, 7, 9);
    /* The film's sums are of floats: 16 replicates of one rounding each, over the deviation. */
    if (!(fabs(deviation - stated) <= 0x1p-23 * (rendered + stated)))
        fail_msg("explained ± %.9g, rendered ± %.9g", deviation, stated);
    json_decref(found);
    mcv_picture_free(picture);
    mcv_rig_free(rig);
    mcv_session_close(session);
}

/* Pixel (5, 4) of the facing rig sees 0 to 0.5 mm. The projector's column 3 covers 0.3 mm of that,
 * column 4 the rest, and row 2 all. The pixel of the projector that lights most of the pixel, with
 * its share: 0.6 of 16384 random places, whose standard error is 0.0038; four and a half of these.
 */
static void test_pixel_of_a_projector(void **state) {
    (void)state;
    write_grey(8, 6);
    json_t *found = explain_rig(open_text("explain-facing.gltf", facing_rig),
                                "{\"pixel\": \"5,4\", \"svg\": \"explained.svg\"}");
    const json_t *routes = json_object_get(found, "routes"), *route = json_array_get(routes, 0),
                 *pixel = json_object_get(route, "emitter_pixel");
    assert_int_equal(json_array_size(routes), 1);
    assert_int_equal(json_array_size(pixel), 2);
    assert_int_equal((int)json_number_value(json_array_get(pixel, 0)), 3);
    assert_int_equal((int)json_number_value(json_array_get(pixel, 1)), 2);
    assert_float_equal(number(route, "share_of_pixel"), 0.6, 0.017);
    json_decref(found);
}

/* Where smooth surfaces may bring light of a lamp without extent, what is missing is told. */
static void test_missing_light_is_told(void **state) {
    (void)state;
    mcv_rig *rig = parse_rig(SCENE(""));
    json_t *found = explain(SCENE(""), "{\"pixel\": \"4,4\", \"spp\": 64}");
    assert_null(json_object_get(found, "notes"));
    json_decref(found);
    WELL(mcv_rig_set(rig, "materials/white/extensions/MCVISI_materials/type", "mirror", &error));
    found = explain_rig(rig, "{\"pixel\": \"4,4\", \"spp\": 64}");
    char *notes = json_dumps(json_object_get(found, "notes"), 0);
    assert_non_null(notes);
    if (!strstr(notes, "light of emitter \\\"weak\\\"")) fail_msg("%s", notes);
    free(notes);
    json_decref(found);
}

/* The drawing has a line for each route, and colours that any program knows. */
static void test_drawing(void **state) {
    (void)state;
    static char text[1 << 16];
    json_t *found = explain(SCENE(""), "{\"pixel\": \"4,4\", \"spp\": 64, \"svg\": \"drawn.svg\"}");
    assert_string_equal(json_string_value(json_object_get(found, "drawing")), "drawn.svg");
    json_decref(found);
    FILE *file = fopen("drawn.svg", "r");
    assert_non_null(file);
    text[fread(text, 1, sizeof text - 1, file)] = '\0';
    fclose(file);
    assert_true(strncmp(text, "<svg xmlns=\"http://www.w3.org/2000/svg\"", 39) == 0);
    assert_non_null(strstr(text, "<title>route 1</title>"));
    assert_non_null(strstr(text, "<title>route 2</title>"));
    assert_non_null(strstr(text, ".ray0{stroke:#0072b2}"));
    assert_true(!strstr(text, "var(") && !strstr(text, "<figure>"));
    assert_string_equal(text + strlen(text) - 7, "</svg>\n");
    remove("drawn.svg");
}

static void test_bad_pixels(void **state) {
    (void)state;
    mcv_rig *rig = parse_rig(SCENE(""));
    mcv_session *session = open_session(NULL);
    char *report = NULL;
    FAILS(MCV_USAGE, "--pixel is missing",
          mcv_session_explain(session, rig, NULL, &report, &error));
    FAILS(MCV_USAGE, "must be column and row",
          mcv_session_explain(session, rig, "{\"pixel\": \"4\"}", &report, &error));
    FAILS(MCV_USAGE, "must be column and row",
          mcv_session_explain(session, rig, "{\"pixel\": \"4,-1\"}", &report, &error));
    FAILS(MCV_USAGE, "must end in .svg",
          mcv_session_explain(session, rig, "{\"pixel\": \"4,4\", \"svg\": \"a.png\"}", &report,
                              &error));
    FAILS(MCV_USAGE, "the image has 9 x 9, from 0,0 to 8,8",
          mcv_session_explain(session, rig, "{\"pixel\": \"9,0\"}", &report, &error));
    mcv_rig_free(rig);
    mcv_session_close(session);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_shares_of_two_lights),  cmocka_unit_test(test_share_of_a_sky),
        cmocka_unit_test(test_strongest_path),        cmocka_unit_test(test_routes_within_a_box),
        cmocka_unit_test(test_ghosts_of_a_lens),      cmocka_unit_test(test_value_is_the_render),
        cmocka_unit_test(test_pixel_of_a_projector),  cmocka_unit_test(test_drawing),
        cmocka_unit_test(test_missing_light_is_told), cmocka_unit_test(test_bad_pixels),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
