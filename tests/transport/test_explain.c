/* SPDX-License-Identifier: Apache-2.0 */
/* Routes of the light in a pixel: shares with closed forms, and their words. */
#include "../api/api.h"

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

static json_t *explain(const char *scene, const char *options) {
    mcv_rig *rig = parse_rig(scene);
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

/* The value is the pixel of the reference renderer: paths are the same, numbered alike. */
static void test_value_is_the_render(void **state) {
    (void)state;
    mcv_rig *rig = NULL;
    mcv_session *session = open_session(NULL);
    mcv_picture *picture = NULL;
    char *report = NULL;
    json_error_t wrong;
    mcv_part part = {.size = sizeof part};
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
    WELL(mcv_picture_part(picture, 0, &part, &error));
    double rendered = 0;
    for (uint32_t c = 0; c < part.channels; ++c)
        rendered +=
            (double)part.planes[((size_t)c * part.height + 9) * part.width + 7] / part.channels;
    const double value = number(json_object_get(found, "value"), "value");
    /* One rounding to float of each channel. */
    if (!(fabs(value - rendered) <= 0x1p-23 * rendered))
        fail_msg("explained %.9g, rendered %.9g", value, rendered);
    json_decref(found);
    mcv_picture_free(picture);
    mcv_rig_free(rig);
    mcv_session_close(session);
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
    FAILS(MCV_USAGE, "the image has 9 x 9, from 0,0 to 8,8",
          mcv_session_explain(session, rig, "{\"pixel\": \"9,0\"}", &report, &error));
    mcv_rig_free(rig);
    mcv_session_close(session);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_shares_of_two_lights),
        cmocka_unit_test(test_share_of_a_sky),
        cmocka_unit_test(test_value_is_the_render),
        cmocka_unit_test(test_bad_pixels),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
