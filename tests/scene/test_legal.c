/* SPDX-License-Identifier: Apache-2.0 */
/* What glTF allows and few exporters write: data: URIs of every form, integers written as 36.0, and
 * matrices whose last column is not padded. */
#include "test.h"

#include "scene_files.h"

/* One triangle from `buffer`; numbers end in `dot`. */
static char *triangle_of(const char *buffer, const char *dot) {
    return text_of("{\"asset\":{\"version\":\"2.0\"},\"scene\":0%s,\"scenes\":[{\"nodes\":[0%s]}],"
                   "\"nodes\":[{\"mesh\":0%s}],"
                   "\"buffers\":[{\"byteLength\":36%s,\"uri\":\"%s\"}],"
                   "\"bufferViews\":[{\"buffer\":0%s,\"byteOffset\":0%s,\"byteLength\":36%s,"
                   "\"byteStride\":12%s,\"target\":34962%s}],"
                   "\"accessors\":[{\"bufferView\":0%s,\"byteOffset\":0%s,\"componentType\":5126%s,"
                   "\"count\":3%s,\"type\":\"VEC3\",\"min\":[0,0,0],\"max\":[1,1,0]}],"
                   "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0%s},\"mode\":4%s}]}"
                   "]}",
                   dot, dot, dot, dot, buffer, dot, dot, dot, dot, dot, dot, dot, dot, dot, dot,
                   dot);
}

static const float corners[9] = {0, 0, 0, 1, 0, 0, 0, -1.5f, 0};

static void must_hold(const char *text) {
    mcv_scene *scene;
    mcv_error error;
    if (load_text("legal.gltf", text, NULL, &scene, &error) != MCV_OK)
        fail_msg("%s\n  %s", text, error.text);
    assert_int_equal(scene->triangle_count, 1);
    assert_memory_equal(scene->meshes[0].positions, corners, sizeof corners);
    mcv_scene_free(scene);
}

static void test_data_uris(void **state) {
    (void)state;
    char *digits = base64(corners, sizeof corners), escapes[200] = "", mixed[200] = "";
    const unsigned char *bytes = (const unsigned char *)corners;
    for (size_t i = 0; i < sizeof corners; ++i)
        snprintf(escapes + 3 * i, sizeof escapes - 3 * i, i % 2 ? "%%%02x" : "%%%02X", bytes[i]);
    for (size_t i = 0; digits[i]; ++i)
        snprintf(mixed + strlen(mixed), sizeof mixed - strlen(mixed), i % 5 ? "%c" : "%%%02X",
                 digits[i]);
    const struct {
        const char *head, *data;
    } uris[] = {{"data:application/octet-stream;base64,", digits},
                {"data:application/gltf-buffer;base64,", digits},
                {"data:Application/Octet-Stream;charset=US-ASCII;BASE64,", digits},
                {"data:application/octet-stream;base64,", mixed},
                {"data:application/octet-stream,", escapes},
                {"data:,", escapes},
                {"data:;charset=US-ASCII,", escapes}};
    for (size_t i = 0; i < sizeof uris / sizeof uris[0]; ++i) {
        char *uri = text_of("%s%s", uris[i].head, uris[i].data), *text = triangle_of(uri, "");
        must_hold(text);
        free(text);
        free(uri);
    }
    const struct {
        const char *uri, *says;
    } broken[] = {{"data:application/octet-stream,%0", "broken %-escapes"},
                  {"data:application/octet-stream,", "has no data"},
                  {"data:application/octet-stream;base64", "must begin with"},
                  {"data:application/json,%00", "must begin with"},
                  {"data:application/octet-stream,%00%00%00", "exceeds the 3 bytes of its data"},
                  {"data:application/octet-stream;base64,AAA", "broken base64"},
                  {"data:application/octet-stream;base64,AA=A", "broken base64"}};
    for (size_t i = 0; i < sizeof broken / sizeof broken[0]; ++i) {
        char *text = triangle_of(broken[i].uri, "");
        must_refuse("legal.gltf", text, broken[i].says);
        free(text);
    }
    free(digits);
}

static void test_integers(void **state) {
    (void)state;
    char *digits = base64(corners, sizeof corners);
    char *uri = text_of("data:application/octet-stream;base64,%s", digits);
    for (int i = 0; i < 3; ++i) {
        char *text = triangle_of(uri, i == 0 ? "" : i == 1 ? ".0" : ".0e0");
        must_hold(text);
        free(text);
    }
    char *text = triangle_of(uri, ".5");
    must_refuse("legal.gltf", text, "must be an integer");
    free(text);
    free(uri);
    free(digits);
}

/* Columns of matrices of small numbers begin at multiples of 4 bytes. Behind the last column
 * nothing is needed: a MAT3 of bytes takes 11. */
static void test_matrices(void **state) {
    (void)state;
    const struct {
        const char *type;
        unsigned component, count, bytes;
        bool fits;
    } cases[] = {{"MAT2", 5120, 1, 6, true},  {"MAT2", 5120, 1, 5, false},
                 {"MAT2", 5121, 3, 22, true}, {"MAT2", 5121, 3, 21, false},
                 {"MAT3", 5120, 1, 11, true}, {"MAT3", 5120, 1, 10, false},
                 {"MAT3", 5123, 2, 46, true}, {"MAT3", 5123, 2, 45, false},
                 {"MAT4", 5126, 1, 64, true}, {"MAT4", 5126, 1, 63, false}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        char *text = text_of("{\"asset\":{\"version\":\"2.0\"},\"buffers\":[{\"byteLength\":%u}],"
                             "\"bufferViews\":[{\"buffer\":0,\"byteLength\":%u}],"
                             "\"accessors\":[{\"bufferView\":0,\"componentType\":%u,\"count\":%u,"
                             "\"type\":\"%s\"}]}",
                             cases[i].bytes, cases[i].bytes, cases[i].component, cases[i].count,
                             cases[i].type);
        mcv_scene *scene;
        mcv_error error;
        const mcv_result result = load_text("legal.gltf", text, NULL, &scene, &error);
        if ((result == MCV_OK) != cases[i].fits)
            fail_msg("%s of %u in %u bytes: %d %s", cases[i].type, cases[i].component,
                     cases[i].bytes, result, error.text);
        mcv_scene_free(scene);
        free(text);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_data_uris),
                                       cmocka_unit_test(test_integers),
                                       cmocka_unit_test(test_matrices)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
