/* SPDX-License-Identifier: Apache-2.0 */
/* glTF files, written here, to scenes: geometry, instances, materials, textures, cameras, elements,
 * --set. */
#include "test.h"

#include "scene_files.h"
#include "scene/geometry.h"
#include "scene/spectra.h"

#include <float.h>
#include <math.h>
#include <time.h>

static mcv_scene *must_load(const char *text, const char *set) {
    mcv_scene *scene;
    mcv_error error;
    if (load_text("scene_load.gltf", text, set, &scene, &error) != MCV_OK)
        fail_msg("must load: %s", error.text);
    return scene;
}

/* `roundings` operations on numbers of size `scale`, in double. */
static void assert_close(double value, double truth, double scale, int roundings,
                         const char *what) {
    if (!(fabs(value - truth) <= roundings * DBL_EPSILON * scale))
        fail_msg("%s is %.17g, must be %.17g", what, value, truth);
}

static void assert_warns(const mcv_scene *scene, const char *words) {
    for (uint32_t i = 0; i < scene->warning_count; ++i)
        if (strstr(scene->warnings[i], words)) return;
    fail_msg("a warning must say \"%s\"; there are %u%s%s", words, scene->warning_count,
             scene->warning_count ? ", the first: " : "",
             scene->warning_count ? scene->warnings[0] : "");
}

/* A document with the mesh of one primitive and these buffer contents, nodes and more members of
 * the root. */
#define HEAD "{\"asset\":{\"version\":\"2.0\"},\"scenes\":[{\"nodes\":[0]}],"

static const float square[4][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}};

/* The square as two triangles, with a material or other members of the primitive, and the rest of
 * the root. */
static char *square_scene(const char *primitive, const char *rest) {
    static const uint16_t indices[6] = {0, 1, 2, 2, 1, 3};
    static const float uv[4][2] = {{0, 0}, {1, 0}, {0, 1}, {1, 1}};
    unsigned char bytes[sizeof square + sizeof uv + sizeof indices];
    memcpy(bytes, square, sizeof square);
    memcpy(bytes + sizeof square, uv, sizeof uv);
    memcpy(bytes + sizeof square + sizeof uv, indices, sizeof indices);
    char *data = base64(bytes, sizeof bytes);
    char *text = text_of(
        HEAD
        "\"buffers\":[{\"byteLength\":92,\"uri\":\"data:application/octet-stream;base64,%s\"}],"
        "\"bufferViews\":[{\"buffer\":0,\"byteLength\":48},{\"buffer\":0,\"byteOffset\":48,"
        "\"byteLength\":32},"
        "{\"buffer\":0,\"byteOffset\":80,\"byteLength\":12}],"
        "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":4,\"type\":\"VEC3\"},"
        "{\"bufferView\":1,\"componentType\":5126,\"count\":4,\"type\":\"VEC2\"},"
        "{\"bufferView\":2,\"componentType\":5123,\"count\":6,\"type\":\"SCALAR\"}],"
        "\"meshes\":[{\"name\":\"square\",\"primitives\":[{\"attributes\":{\"POSITION\":0,"
        "\"TEXCOORD_0\":1},\"indices\":2%s}]}],"
        "%s}",
        data, primitive, rest);
    free(data);
    return text;
}

/* --- geometry
 * ---------------------------------------------------------------------------------------------------
 */

/* Writes vertices and indices of these types as one primitive and expects these triangles (of
 * corner numbers). */
static void check_primitive(int mode, uint32_t index_type, const uint32_t *list,
                            uint32_t list_count, const uint32_t *triangles,
                            uint32_t triangle_count) {
    unsigned char indices[64] = {0};
    const size_t width = index_type == 5121 ? 1 : index_type == 5123 ? 2 : 4;
    for (uint32_t i = 0; i < list_count; ++i)
        memcpy(indices + i * width, list + i, width); /* little-endian */
    char *positions = base64(square, sizeof square), *index_data = base64(indices, sizeof indices);
    char *text = text_of(
        HEAD
        "\"nodes\":[{\"mesh\":0}],"
        "\"buffers\":[{\"byteLength\":48,\"uri\":\"data:application/octet-stream;base64,%s\"},"
        "{\"byteLength\":64,\"uri\":\"data:application/gltf-buffer;base64,%s\"}],"
        "\"bufferViews\":[{\"buffer\":0,\"byteLength\":48},{\"buffer\":1,\"byteLength\":64}],"
        "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":4,\"type\":\"VEC3\"},"
        "{\"bufferView\":1,\"componentType\":%u,\"count\":%u,\"type\":\"SCALAR\"}],"
        "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"mode\":%d%s}]}]}",
        positions, index_data, index_type ? index_type : 5121, list_count ? list_count : 1, mode,
        index_type ? ",\"indices\":1" : "");
    mcv_scene *scene = must_load(text, NULL);
    if (scene->triangle_count != triangle_count)
        fail_msg("mode %d, indices %u: %u triangles, must be %u", mode, index_type,
                 scene->triangle_count, triangle_count);
    for (uint32_t t = 0; t < triangle_count; ++t) {
        double corners[3][3];
        mcv_scene_corners(scene, mcv_scene_instance_of(scene, t), t, corners);
        for (int c = 0; c < 3; ++c)
            for (int i = 0; i < 3; ++i)
                if (corners[c][i] != (double)square[triangles[3 * t + (uint32_t)c]][i])
                    fail_msg("mode %d, indices %u, triangle %u, corner %d: %g, must be vertex %u",
                             mode, index_type, t, c, corners[c][i], triangles[3 * t + (uint32_t)c]);
    }
    mcv_scene_free(scene);
    free(text);
    free(positions);
    free(index_data);
}

static void test_primitives(void **state) {
    (void)state;
    static const uint32_t list[] = {2, 1, 0, 1, 2, 3}, strip[] = {0, 1, 2, 3},
                          joined[] = {0, 1, 2, 2, 3, 3, 1, 0};
    static const uint32_t fan_triangles[] = {1, 3, 0, 3, 2, 0}, fan[] = {0, 1, 3, 2};
    static const uint32_t strip_triangles[] = {0, 1, 2, 1, 3, 2},
                          plain_fan_triangles[] = {1, 2, 0, 2, 3, 0}, one[] = {0, 1, 2};
    /* Of the strip 0 1 2 2 3 3 1 0 the triangles without a repeated vertex: 0 1 2, and 3 1 0 (even:
     * in order). */
    static const uint32_t joined_triangles[] = {0, 1, 2, 3, 0, 1};
    static const uint32_t types[] = {5121, 5123, 5125};
    for (int i = 0; i < 3; ++i) {
        check_primitive(4, types[i], list, 6, list, 2);
        check_primitive(5, types[i], strip, 4, strip_triangles, 2);
        check_primitive(5, types[i], joined, 8, joined_triangles, 2);
        check_primitive(6, types[i], fan, 4, fan_triangles, 2);
    }
    check_primitive(4, 0, NULL, 0, one, 1); /* four vertices: one triangle and one left over */
    check_primitive(5, 0, NULL, 0, strip_triangles, 2);
    check_primitive(6, 0, NULL, 0, plain_fan_triangles, 2);
    check_primitive(1, 5121, list, 6, NULL, 0); /* lines */
}

/* Interleaved vertices, 16-bit normalized normals and positions by KHR_mesh_quantization, sparse
 * replacement. */
static void test_accessors(void **state) {
    (void)state;
    struct {
        float position[3];
        int8_t normal[4];
        uint16_t uv[2];
    } vertices[3] = {{{0, 0, 0}, {0, 0, 127, 0}, {0, 0}},
                     {{1, 0, 0}, {0, -127, 0, 0}, {65535, 0}},
                     {{0, 1, 0}, {-128, 0, 0, 0}, {0, 65535}}};
    struct {
        uint8_t index[4];
        float position[3];
    } sparse = {{2}, {0, 5, 7}};
    unsigned char bytes[sizeof vertices + sizeof sparse];
    memcpy(bytes, vertices, sizeof vertices);
    memcpy(bytes + sizeof vertices, &sparse, sizeof sparse);
    char *data = base64(bytes, sizeof bytes);
    char *text = text_of(HEAD "\"extensionsUsed\":[\"KHR_mesh_quantization\"],"
                              "\"extensionsRequired\":[\"KHR_mesh_quantization\"],"
                              "\"nodes\":[{\"mesh\":0}],\"buffers\":[{\"byteLength\":76,\"uri\":"
                              "\"data:application/octet-stream;base64,%s\"}],"
                              "\"bufferViews\":[{\"buffer\":0,\"byteLength\":60,\"byteStride\":20},"
                              "{\"buffer\":0,\"byteOffset\":60,\"byteLength\":16}],"
                              "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":3,"
                              "\"type\":\"VEC3\",\"sparse\":{\"count\":1,"
                              "\"indices\":{\"bufferView\":1,\"componentType\":5121},\"values\":{"
                              "\"bufferView\":1,\"byteOffset\":4}}},"
                              "{\"bufferView\":0,\"byteOffset\":12,\"componentType\":5120,"
                              "\"count\":3,\"type\":\"VEC3\",\"normalized\":true},"
                              "{\"bufferView\":0,\"byteOffset\":16,\"componentType\":5123,"
                              "\"count\":3,\"type\":\"VEC2\",\"normalized\":true}],"
                              "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0,"
                              "\"NORMAL\":1,\"TEXCOORD_0\":2}}]}]}",
                         data);
    mcv_scene *scene = must_load(text, NULL);
    static const float positions[9] = {0, 0, 0, 1, 0, 0, 0, 5, 7},
                       normals[9] = {0, 0, 1, 0, -1, 0, -1, 0, 0}, uvs[6] = {0, 0, 1, 0, 0, 1};
    assert_int_equal(scene->mesh_count, 1);
    assert_memory_equal(scene->meshes[0].positions, positions, sizeof positions);
    for (int i = 0; i < 9; ++i) assert_true(scene->meshes[0].normals[i] == normals[i]);
    assert_memory_equal(scene->meshes[0].texcoords, uvs, sizeof uvs);
    mcv_scene_free(scene);
    free(text);
    free(data);
}

/* Vertex normals come unit; one of length 0 is taken from the faces around, with a warning. */
static void test_normals(void **state) {
    (void)state;
    const float normals[4][3] = {{0, 0, 2}, {3, 0, 4}, {0, 0, 0}, {0, 0, 1e-30f}};
    unsigned char bytes[sizeof square + sizeof normals];
    memcpy(bytes, square, sizeof square);
    memcpy(bytes + sizeof square, normals, sizeof normals);
    char *data = base64(bytes, sizeof bytes);
    char *text = text_of(
        HEAD
        "\"nodes\":[{\"mesh\":0}],\"buffers\":[{\"byteLength\":96,\"uri\":\"data:application/"
        "octet-stream;base64,%s\"}],"
        "\"bufferViews\":[{\"buffer\":0,\"byteLength\":48},{\"buffer\":0,\"byteOffset\":48,"
        "\"byteLength\":48}],"
        "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":4,\"type\":\"VEC3\"},"
        "{\"bufferView\":1,\"componentType\":5126,\"count\":4,\"type\":\"VEC3\"}],"
        "\"meshes\":[{\"primitives\":[{\"mode\":5,\"attributes\":{\"POSITION\":0,\"NORMAL\":1}}]}]"
        "}",
        data);
    mcv_scene *scene = must_load(text, NULL);
    const float unit[4][3] = {{0, 0, 1}, {0.6f, 0, 0.8f}, {0, 0, 1}, {0, 0, 1}};
    assert_memory_equal(scene->meshes[0].normals, unit, sizeof unit);
    assert_warns(scene, "1 normals of length 0");
    mcv_scene_free(scene);
    free(text);
    free(data);
}

/*
 * Three levels, the middle one a matrix: translate by (1, 2, 3), rotate by 90° about z, scale by
 * (2, 3, 4). By hand p -> (1 - 3 p_y, 2 + 2 p_x, 3 + 4 p_z). The quaternion's cosine of 90° is off
 * by a few roundings.
 */
static void test_hierarchy(void **state) {
    (void)state;
    char *text = square_scene(
        "", "\"nodes\":[{\"children\":[1],\"translation\":[1,2,3]},"
            "{\"children\":[2],\"matrix\":[0,1,0,0, -1,0,0,0, 0,0,1,0, 0,0,0,1]},"
            "{\"name\":\"leaf\",\"mesh\":0,\"scale\":[2,3,4],\"rotation\":[0,0,0,1]}]");
    mcv_scene *scene = must_load(text, NULL);
    assert_int_equal(scene->instance_count, 1);
    assert_string_equal(scene->instances[0].name, "leaf");
    double corners[3][3];
    mcv_scene_corners(scene, 0, 1, corners); /* vertices 2 1 3 */
    static const double truth[3][3] = {{-2, 2, 3}, {1, 4, 3}, {-2, 4, 3}};
    for (int c = 0; c < 3; ++c)
        for (int i = 0; i < 3; ++i) assert_close(corners[c][i], truth[c][i], 4, 8, "corner");
    mcv_scene_free(scene);
    free(text);

    text = square_scene("", "\"nodes\":[{\"mesh\":0,\"rotation\":[0,0,0.7071068,0.7071068],"
                            "\"translation\":[1,2,3],\"scale\":[2,3,4]}]");
    scene = must_load(text, NULL);
    mcv_scene_corners(scene, 0, 1, corners);
    for (int c = 0; c < 3; ++c)
        for (int i = 0; i < 3; ++i)
            assert_close(corners[c][i], truth[c][i], 4, 8, "corner by quaternion");
    mcv_scene_free(scene);
    free(text);
}

/* A mirrored square keeps its front: the face's normal is the image of +z, and the corners still
 * run around it. */
static void test_mirrored(void **state) {
    (void)state;
    static const char *const scales[] = {"[-1,1,1]", "[1,1,-1]", "[-1,-1,-1]", "[-2,3,1]"};
    static const double fronts[] = {1, -1, -1, 1}; /* z of the front: mirroring z turns it to -z */
    for (int k = 0; k < 4; ++k) {
        char *rest = text_of("\"nodes\":[{\"mesh\":0,\"scale\":%s}]", scales[k]);
        char *text = square_scene("", rest);
        mcv_scene *scene = must_load(text, NULL);
        for (uint32_t t = 0; t < 2; ++t) {
            double c[3][3], n[3][3];
            mcv_scene_corners(scene, 0, t, c);
            mcv_scene_vertex_normals(scene, 0, t, n);
            const double z = (c[1][0] - c[0][0]) * (c[2][1] - c[0][1]) -
                             (c[1][1] - c[0][1]) * (c[2][0] - c[0][0]);
            if (!(z * fronts[k] > 0))
                fail_msg("scale %s: winding gives z = %g, must have the sign of %g", scales[k], z,
                         fronts[k]);
            if (n[0][2] != fronts[k])
                fail_msg("scale %s: normal %g, must be %g", scales[k], n[0][2], fronts[k]);
        }
        mcv_scene_free(scene);
        free(text);
        free(rest);
    }
}

/*
 * A scene made by hand. A vertex normal n goes through a scale s as n/s: for n = (0.6, 0, 0.8) and
 * s = (-2, 3, 1) along
 * (-0.3, 0, 0.8), also where the scale mirrors. What a file may not hold is refused here too.
 */
static void test_made_by_hand(void **state) {
    (void)state;
    float positions[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0},
          normals[9] = {0.6f, 0, 0.8f, 0.6f, 0, 0.8f, 0.6f, 0, 0.8f};
    uint32_t indices[3] = {0, 1, 2}, outside[3] = {0, 1, 3};
    static const double scales[][3] = {{1, 1, 1}, {-2, 3, 1}, {1, 1, -1}, {-2, -3, -1}};
    mcv_error error = {""};
    mcv_scene *scene = mcv_scene_new("by hand");
    assert_non_null(scene);
    mcv_material material = {.name = "m", .type = MCV_MATERIAL_MIRROR, .texture = MCV_NONE};
    mcv_params_set_defaults(mcv_material_table(material.type), &material.as);
    mcv_mesh mesh = {.vertex_count = 3,
                     .triangle_count = 1,
                     .positions = positions,
                     .normals = normals,
                     .indices = indices};
    assert_int_equal(mcv_scene_add_material(scene, &material, &error), MCV_OK);
    assert_int_equal(mcv_scene_add_mesh(scene, &mesh, &error), MCV_OK);
    for (uint32_t k = 0; k < 4; ++k) {
        const double *s = scales[k];
        const mcv_instance instance = {.to_world = {{s[0], 0, 0, 0, s[1], 0, 0, 0, s[2], 5, 6, 7}}};
        assert_int_equal(mcv_scene_add_instance(scene, &instance, &error), MCV_OK);
        assert_int_equal(mcv_scene_instance_of(scene, k), k);
        double n[3][3], truth[3] = {0.6 / s[0], 0, 0.8 / s[2]};
        const double length = sqrt(truth[0] * truth[0] + truth[2] * truth[2]);
        mcv_scene_vertex_normals(scene, k, 0, n);
        for (int i = 0; i < 3; ++i) /* the normal is stored as float: off by FLT_EPSILON / 2,
                                       stretched by at most 3 */
            if (!(fabs(n[1][i] - truth[i] / length) <= 2 * (double)FLT_EPSILON))
                fail_msg("scale %g %g %g: normal[%d] is %g, must be %g", s[0], s[1], s[2], i,
                         n[1][i], truth[i] / length);
    }
    mcv_material wrong = {.name = "w",
                          .type = MCV_MATERIAL_DIELECTRIC,
                          .texture = MCV_NONE,
                          .as.dielectric = {.ior = {NAN, NAN, NAN}}};
    assert_int_equal(mcv_scene_add_material(scene, &wrong, &error), MCV_BAD_INPUT);
    assert_non_null(strstr(error.text, "w/ior: nan must lie from 1 to 10"));
    mesh.indices = outside;
    assert_int_equal(mcv_scene_add_mesh(scene, &mesh, &error), MCV_BAD_INPUT);
    assert_non_null(
        strstr(error.text, "by hand: meshes/1/indices: index 3 of triangle 0 does not exist"));
    assert_int_equal(mcv_scene_add_instance(scene, &(mcv_instance){.mesh = 1}, &error),
                     MCV_BAD_INPUT);
    material.as.mirror.reflectance[1] = 1.5;
    assert_int_equal(mcv_scene_add_material(scene, &material, &error), MCV_BAD_INPUT);
    assert_non_null(
        strstr(error.text, "by hand: materials/m/reflectance: 1.5 must lie from 0 to 1"));
    assert_int_equal(scene->mesh_count + scene->material_count, 2);
    mcv_scene_free(scene);
}

/* --- materials and textures
 * ------------------------------------------------------------------------------------- */

static void test_materials(void **state) {
    (void)state;
    static const char materials[] =
        "\"nodes\":[{\"mesh\":0}],\"materials\":["
        "{\"name\":\"plastic\",\"pbrMetallicRoughness\":{\"baseColorFactor\":[0.1,0.2,0.3,1],"
        "\"metallicFactor\":0}},"
        "{\"name\":\"glass\",\"pbrMetallicRoughness\":{\"metallicFactor\":0,\"roughnessFactor\":0},"
        "\"extensions\":{"
        "\"KHR_materials_transmission\":{\"transmissionFactor\":1},\"KHR_materials_ior\":{\"ior\":"
        "1.7},"
        "\"KHR_materials_volume\":{\"thicknessFactor\":0.01,\"attenuationDistance\":0.5,"
        "\"attenuationColor\":[1,0.25,0]}}},"
        "{\"name\":\"pane\",\"pbrMetallicRoughness\":{\"baseColorFactor\":[0.9,0.9,0.9,1],"
        "\"metallicFactor\":0,\"roughnessFactor\":0},"
        "\"extensions\":{\"KHR_materials_transmission\":{\"transmissionFactor\":1}}},"
        "{\"name\":\"mirror\",\"pbrMetallicRoughness\":{\"roughnessFactor\":0}},"
        "{\"name\":\"bubble\",\"extensions\":{\"MCVISI_materials\":{\"type\":\"dielectric\","
        "\"ior\":1,\"priority\":1}}},"
        "{\"name\":\"black\",\"alphaMode\":\"MASK\",\"extensions\":{\"MCVISI_materials\":{\"type\":"
        "\"absorber\"}}}]";
    char *text = square_scene(",\"material\":1", materials);
    mcv_scene *scene = must_load(text, NULL);
    assert_int_equal(scene->material_count, 6);
    const mcv_material *m = scene->materials;
    static const uint32_t types[] = {MCV_MATERIAL_METALLIC_ROUGHNESS,
                                     MCV_MATERIAL_DIELECTRIC,
                                     MCV_MATERIAL_SHEET,
                                     MCV_MATERIAL_MIRROR,
                                     MCV_MATERIAL_DIELECTRIC,
                                     MCV_MATERIAL_ABSORBER};
    for (int i = 0; i < 6; ++i)
        if (m[i].type != types[i])
            fail_msg("material %s has type %u, must have %u", m[i].name, m[i].type, types[i]);
    const mcv_metallic_roughness_params *plastic = &m[0].as.metallic_roughness;
    assert_true(plastic->baseColor[1] == 0.2 && plastic->metallic == 0 && plastic->roughness == 1 &&
                plastic->ior == 1.5);
    assert_true(m[1].as.dielectric.ior[0] == 1.7);
    assert_true(m[1].as.dielectric.absorption[0] == 0);
    assert_close(m[1].as.dielectric.absorption[1], 2 * log(4), 4, 4,
                 "absorption: colour 1/4 after 0.5 m");
    assert_true(m[1].as.dielectric.absorption[2] == 1e30);
    assert_true(m[2].as.sheet.ior == 1.5 && m[2].as.sheet.transmittance[0] == 0.9);
    assert_true(m[3].as.mirror.reflectance[0] == 1);
    assert_true(m[4].as.dielectric.ior[0] == 1 && m[4].as.dielectric.priority == 1);
    assert_warns(scene, "materials black: rendered opaque");
    assert_int_equal(scene->instances[0].material, 1);
    assert_int_equal(mcv_scene_channels(scene), 3);
    mcv_scene_free(scene);
    free(text);

    /* Without a material, and grey throughout: one channel. */
    text = square_scene("", "\"nodes\":[{\"mesh\":0}]");
    scene = must_load(text, NULL);
    assert_int_equal(scene->materials[scene->instances[0].material].type, MCV_MATERIAL_DIFFUSE);
    assert_int_equal(mcv_scene_channels(scene), 1);
    assert_warns(scene, "without a material");
    mcv_scene_free(scene);
    free(text);
}

/* A PNG of 2 x 2 pixels, 8-bit RGB, stored uncompressed: red, green; blue, grey 128. */
static const unsigned char png[] = {
    0x89, 0x50, 0x4e, 0x47, 0x0d, 0x0a, 0x1a, 0x0a, 0x00, 0x00, 0x00, 0x0d, 0x49, 0x48,
    0x44, 0x52, 0x00, 0x00, 0x00, 0x02, 0x00, 0x00, 0x00, 0x02, 0x08, 0x02, 0x00, 0x00,
    0x00, 0xfd, 0xd4, 0x9a, 0x73, 0x00, 0x00, 0x00, 0x19, 0x49, 0x44, 0x41, 0x54, 0x78,
    0x01, 0x01, 0x0e, 0x00, 0xf1, 0xff, 0x00, 0xff, 0x00, 0x00, 0x00, 0xff, 0x00, 0x00,
    0x00, 0x00, 0xff, 0x80, 0x80, 0x80, 0x1c, 0xf4, 0x04, 0x7e, 0xc2, 0xc6, 0x4b, 0x45,
    0x00, 0x00, 0x00, 0x00, 0x49, 0x45, 0x4e, 0x44, 0xae, 0x42, 0x60, 0x82};
static const unsigned char pixels[16] = {255, 0, 0,   255, 0,   255, 0,   255,
                                         0,   0, 255, 255, 128, 128, 128, 255};

/* The same picture as a data: URI, a file beside the scene with a blank in its name, and from a
 * bufferView. */
static void test_textures(void **state) {
    (void)state;
    char *data = base64(png, sizeof png);
    free(write_bytes("scene load.png", png, sizeof png));
    char *images[] = {text_of("{\"uri\":\"data:image/png;base64,%s\"}", data),
                      text_of("{\"uri\":\"./scene%%20load.png\"}")};
    for (int k = 0; k < 2; ++k) {
        /* The normal texture's image does not exist, and nobody asks for it. */
        char *rest =
            text_of("\"nodes\":[{\"mesh\":0}],\"materials\":[{\"emissiveFactor\":[1,1,1],"
                    "\"emissiveTexture\":{\"index\":1},"
                    "\"normalTexture\":{\"index\":2},\"pbrMetallicRoughness\":{"
                    "\"baseColorTexture\":{\"index\":0}}}],"
                    "\"textures\":[{\"source\":1,\"sampler\":0},{\"source\":1},{\"source\":0}],"
                    "\"samplers\":[{\"wrapS\":33071,\"wrapT\":33648,\"magFilter\":9728}],"
                    "\"images\":[{\"uri\":\"missing.png\"},%s]",
                    images[k]);
        char *text = square_scene(",\"material\":0", rest);
        mcv_scene *scene = must_load(text, NULL);
        assert_int_equal(scene->texture_count, 2);
        const mcv_texture *texture = scene->textures + scene->materials[0].texture;
        assert_int_equal(texture->width, 2);
        assert_int_equal(texture->height, 2);
        assert_memory_equal(texture->rgba, pixels, sizeof pixels);
        assert_int_equal(texture->wrap_s, 33071);
        assert_int_equal(texture->wrap_t, 33648);
        assert_true(texture->nearest);
        assert_int_equal(scene->emitter_count, 1);
        assert_false(scene->textures[scene->emitters[0].texture].nearest);
        assert_int_equal(scene->textures[scene->emitters[0].texture].wrap_s, 10497);
        mcv_scene_free(scene);
        free(text);
        free(rest);
        free(images[k]);
    }
    free(data);
}

/*
 * KHR_texture_transform. The extension's own examples: the lower left quarter of the image by an
 * offset of (0, 1), a rotation of π/2 and a scale of ½, so that (0, 0) (1, 0) (0, 1) of the mesh
 * lie at (0, 1) (0, ½) (½, 1); an image with its origin below by an offset of (0, 1) and a scale of
 * (1, -1). Four uses of one picture, of which two are alike, share its pixels.
 */
static void test_texture_transform(void **state) {
    static const char format[] =
        "\"nodes\":[{\"mesh\":0}],\"extensionsRequired\":[\"KHR_texture_transform\"],\"images\":[{"
        "\"uri\":\"data:image/png;base64,%s\"}],"
        "\"textures\":[{\"source\":0}],\"materials\":[{\"pbrMetallicRoughness\":{"
        "\"baseColorTexture\":{\"index\":0,\"extensions\":{"
        "\"KHR_texture_transform\":{\"offset\":[0,1],\"rotation\":1.5707963267948966,\"scale\":[0."
        "5,0.5]}}},"
        "\"metallicRoughnessTexture\":{\"index\":0,\"texCoord\":5,\"extensions\":{\"KHR_texture_"
        "transform\":{\"scale\":[2,3],"
        "\"texCoord\":0}}}},\"emissiveFactor\":[1,1,1],\"emissiveTexture\":{\"index\":0,"
        "\"texCoord\":1}},"
        "{\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":0,\"extensions\":{\"KHR_"
        "texture_transform\":{\"offset\":[0,1],"
        "\"scale\":[1,-1]}}}},\"emissiveFactor\":[1,1,1],\"emissiveTexture\":{\"index\":0,"
        "\"extensions\":{\"KHR_texture_transform\":"
        "{\"scale\":[1,-1],\"rotation\":0,\"offset\":[0,1]}}}},"
        "{\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":0,\"texCoord\":1,"
        "\"extensions\":{\"KHR_texture_transform\":{"
        "\"texCoord\":2}}}}}]";
    static const double expected[4][6] = {
        {0, 0.5, 0, -0.5, 0, 1}, {1, 0, 0, 0, -1, 1}, {2, 0, 0, 0, 3, 0}, {0}};
    (void)state;
    char *data = base64(png, sizeof png), *rest = text_of(format, data);
    char *text = square_scene(",\"material\":0", rest), *with_set;
    mcv_scene *scene;
    mcv_error error;
    assert_int_equal(load_text("scene_load.gltf", text, NULL, &scene, &error), MCV_BAD_INPUT);
    assert_non_null(strstr(error.text, "must have TEXCOORD_1 for the texture of its material 0"));
    free(text);
    text = square_scene(",\"material\":0", rest);
    char *set = strstr(text, "\"TEXCOORD_0\":1");
    assert_non_null(set);
    with_set = text_of("%.*s\"TEXCOORD_1\":1,%s", (int)(set - text), text, set);
    scene = must_load(with_set, NULL);
    assert_warns(scene, "only the sets TEXCOORD_0 and TEXCOORD_1");
    const mcv_material *m = scene->materials;
    assert_int_equal(m[2].texture, MCV_NONE);
    const uint32_t numbers[4] = {m[0].texture, m[1].texture, m[0].surface_texture,
                                 scene->emitters[0].texture};
    for (int k = 0; k < 4; ++k) {
        const mcv_texture *texture = scene->textures + numbers[k];
        assert_int_equal(texture->texcoord_set, k == 3);
        assert_int_equal(texture->is_transformed, k < 3);
        if (k != 2) assert_ptr_equal(texture->rgba, scene->textures[m[0].texture].rgba);
        for (int i = 0; i < 6; ++i)
            assert_close(texture->transform[i], expected[k][i], 1, 2, "the transform");
    }
    assert_int_equal(
        scene->texture_count,
        6); /* as it is, three times placed otherwise; as data, once placed otherwise */
    assert_non_null(scene->meshes[0].texcoords1);
    mcv_scene_free(scene);
    free(with_set);
    free(text);
    free(rest);
    free(data);
}

/* A camera's node that mirrors: the image is not mirrored, and a warning says so; one that is
 * turned half round gives none. */
static void test_mirrored_sensor(void **state) {
    (void)state;
    for (int mirrored = 0; mirrored < 2; ++mirrored) {
        char *rest = text_of(
            "\"nodes\":[{\"mesh\":0,\"children\":[1]},{\"name\":\"eye\",\"camera\":0,\"scale\":[-1,"
            "%d,1]}],"
            "\"cameras\":[{\"type\":\"perspective\",\"perspective\":{\"yfov\":0.5,\"znear\":0.1}}]",
            mirrored ? 1 : -1);
        char *text = square_scene("", rest);
        mcv_scene *scene = must_load(text, NULL);
        uint32_t count = 0;
        for (uint32_t i = 0; i < scene->warning_count; ++i)
            count += strstr(scene->warnings[i], "sensor \"eye\": its node mirrors") != NULL;
        assert_int_equal(count, mirrored);
        mcv_scene_free(scene);
        free(text);
        free(rest);
    }
}

/* The same of an emitter's image; light that has none is the same either way. */
static void test_mirrored_emitter(void **state) {
    static const struct {
        const char *emitter;
        int scale;
        bool warns;
    } cases[] = {
#define STRIPES \
    "\"halfAngle\":0.1,\"radiance\":1,\"pattern\":{\"type\":\"grayCode\",\"resolution\":[8,8]}"
        {"\"type\":\"telecentricProjector\",\"size\":0.1," STRIPES, -1, true},
        {"\"type\":\"telecentricProjector\",\"size\":0.1," STRIPES, 1, false},
        {"\"type\":\"area\",\"size\":0.1,\"radiance\":1", -1, false},
        {"\"type\":\"point\",\"intensity\":1", -1, false},
        {"\"type\":\"ring\",\"innerDiameter\":0.1,\"outerDiameter\":0.2,\"radiance\":1", -1, false},
#undef STRIPES
    };
    (void)state;
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; ++k) {
        char text[640];
        uint32_t count = 0;
        snprintf(text, sizeof text,
                 "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0]}],"
                 "\"nodes\":[{\"scale\":[%d,1,1],\"extensions\":{\"MCVISI_emitters\":{\"emitter\":"
                 "0}}}],\"extensions\":{\"MCVISI_emitters\":{\"emitters\":[{\"name\":\"e\",%s}]}}}",
                 cases[k].scale, cases[k].emitter);
        mcv_scene *scene = must_load(text, NULL);
        for (uint32_t i = 0; i < scene->warning_count; ++i)
            count += strstr(scene->warnings[i], "emitter \"e\": its node mirrors") != NULL;
        if (count != cases[k].warns)
            fail_msg("%s: %u warnings of a node that mirrors", cases[k].emitter, count);
        mcv_scene_free(scene);
    }
}

/* --- GLB and files
 * ---------------------------------------------------------------------------------------------- */

/* A GLB whose chunk holds a picture behind the square's positions, and a buffer in a file that is
 * longer than it says. */
static void test_glb(void **state) {
    (void)state;
    unsigned char chunk[sizeof square + sizeof png], uv[64] = {0};
    memcpy(chunk, square, sizeof square);
    memcpy(chunk + sizeof square, png, sizeof png);
    free(write_bytes("scene_load.bin", uv, sizeof uv));
    char *json = text_of(
        HEAD
        "\"nodes\":[{\"mesh\":0}],\"buffers\":[{\"byteLength\":%zu},{\"byteLength\":32,\"uri\":"
        "\"scene_load.bin\"}],"
        "\"bufferViews\":[{\"buffer\":0,\"byteLength\":48},{\"buffer\":0,\"byteOffset\":48,"
        "\"byteLength\":%zu},"
        "{\"buffer\":1,\"byteLength\":32}],\"images\":[{\"bufferView\":1,\"mimeType\":\"image/"
        "png\"}],"
        "\"textures\":[{\"source\":0}],"
        "\"materials\":[{\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":0}}}],"
        "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":4,\"type\":\"VEC3\"},"
        "{\"bufferView\":2,\"componentType\":5126,\"count\":4,\"type\":\"VEC2\"}],"
        "\"meshes\":[{\"primitives\":[{\"mode\":5,\"attributes\":{\"POSITION\":0,\"TEXCOORD_0\":1},"
        "\"material\":0}]}]}",
        sizeof chunk, sizeof png);
    size_t size;
    unsigned char *glb = glb_of(json, chunk, sizeof chunk, &size);
    char *path = write_bytes("scene_load.glb", glb, size);
    mcv_scene *scene;
    mcv_error error;
    if (load_file(path, &scene, &error) != MCV_OK) fail_msg("must load: %s", error.text);
    assert_string_equal(scene->path, path);
    assert_int_equal(scene->triangle_count, 2);
    assert_memory_equal(scene->meshes[0].positions, square, sizeof square);
    assert_memory_equal(scene->textures[0].rgba, pixels, sizeof pixels);
    mcv_scene_free(scene);
    free(path);
    free(glb);
    free(json);
}

/* --- sensors and emitters
 * --------------------------------------------------------------------------------------- */

static void test_cameras(void **state) {
    (void)state;
    static const char text[] =
        "{\"asset\":{\"version\":\"2.0\"},\"scenes\":[{},{\"nodes\":[0,1]}],\"scene\":1,\"nodes\":["
        "{\"camera\":0,\"name\":\"eye\",\"scale\":[3,3,3],\"translation\":[1,2,3]},{\"camera\":1,"
        "\"rotation\":[0,1,0,0]}],"
        "\"cameras\":[{\"type\":\"perspective\",\"perspective\":{\"yfov\":0.5,\"aspectRatio\":1.6,"
        "\"znear\":0.1}},"
        "{\"name\":\"plan\",\"type\":\"orthographic\",\"orthographic\":{\"xmag\":0.2,\"ymag\":0.1,"
        "\"znear\":0,\"zfar\":4}}]}";
    mcv_scene *scene = must_load(text, NULL);
    assert_int_equal(scene->sensor_count, 2);
    const mcv_pinhole_params *p = &scene->sensors[0].as.pinhole;
    assert_int_equal(scene->sensors[0].type, MCV_SENSOR_PINHOLE);
    assert_string_equal(scene->sensors[0].name, "eye");
    assert_int_equal(p->resolution[0], 1024);
    assert_int_equal(p->resolution[1], 640);
    assert_close(2 * atan(640 * p->pixelSize[1] / (2 * p->imageDistance)), 0.5, 1, 8,
                 "vertical angle of view");
    assert_close(1024 * p->pixelSize[0] / (640 * p->pixelSize[1]), 1.6, 2, 8, "aspect ratio");
    /* The node's scale is no business of a sensor. */
    const double eye[12] = {1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 2, 3};
    for (int i = 0; i < 12; ++i)
        assert_close(scene->sensors[0].to_world.m[i], eye[i], 3, 8, "pose of the camera");

    const mcv_telecentric_params *t = &scene->sensors[1].as.telecentric;
    assert_int_equal(scene->sensors[1].type, MCV_SENSOR_TELECENTRIC);
    assert_string_equal(scene->sensors[1].name, "plan");
    assert_close(t->resolution[0] * t->pixelSize[0] / t->magnification, 0.4, 1, 16,
                 "width of the field");
    assert_close(t->resolution[1] * t->pixelSize[1] / t->magnification, 0.2, 1, 16,
                 "height of the field");
    /* A point at the lens: blurred to 2 NA W, a thousandth of an object pixel. */
    assert_true(2 * t->numericalAperture * t->workingDistance < 1.01e-3 * t->pixelSize[0]);
    const double plan[12] = {-1, 0, 0, 0, 1, 0, 0, 0, -1, 0, 0, 0};
    for (int i = 0; i < 12; ++i)
        assert_close(scene->sensors[1].to_world.m[i], plan[i], 1, 8, "turned camera");
    mcv_scene_free(scene);
}

#define ELEMENTS(emitters, sensors) \
    "\"extensionsUsed\":[\"MCVISI_sensors\",\"MCVISI_emitters\",\"EXT_lights_image_based\"]," \
    "\"extensions\":{" \
    "\"MCVISI_emitters\":{\"emitters\":[" emitters "]},\"MCVISI_sensors\":{\"sensors\":[" sensors \
    "]}},"
#define PINHOLE \
    "{\"name\":\"cam\",\"type\":\"pinhole\",\"imageDistance\":\"16mm\",\"resolution\":[640,480]," \
    "\"pixelSize\":\"5um\"}"

/* A rectangle is as large as it says under a scaled node, looks along the node's -z and absorbs. */
static void test_rectangle(void **state) {
    (void)state;
    char *text =
        square_scene("", ELEMENTS("{\"name\":\"back\",\"type\":\"parallel\",\"size\":[\"40mm\","
                                  "\"30mm\"],\"halfAngle\":\"30deg\","
                                  "\"power\":[1,2,3]},{\"type\":\"environment\"}",
                                  PINHOLE) "\"nodes\":[{\"children\":[1,2,3,4],\"scale\":[2,2,-2]},"
                                           "{\"name\":\"light\",\"translation\":[0,0,5],"
                                           "\"extensions\":{\"MCVISI_emitters\":{\"emitter\":0}}},"
                                           "{\"extensions\":{\"MCVISI_emitters\":{\"emitter\":1}}},"
                                           "{\"extensions\":{\"MCVISI_sensors\":{\"sensor\":0}}},{"
                                           "\"extensions\":{\"MCVISI_sensors\":{\"sensor\":0}}}]");
    mcv_scene *scene = must_load(text, NULL);
    assert_int_equal(scene->emitter_count, 2);
    assert_int_equal(scene->instance_count, 1);
    const mcv_emitter *e = scene->emitters;
    assert_string_equal(e->name, "back");
    assert_string_equal(scene->instances[0].name, "light");
    assert_int_equal(scene->instances[0].emitter, 0);
    assert_int_equal(scene->materials[scene->instances[0].material].type, MCV_MATERIAL_ABSORBER);
    /* The rectangle's corners are floats. */
    assert_true(fabs(e->area - 12e-4) <= 2 * (double)FLT_EPSILON * 12e-4);
    for (int i = 0; i < 3; ++i)
        assert_true(fabs(e->radiance[i] - (1 + i) / (M_PI * 0.25 * 12e-4)) <=
                    2 * (double)FLT_EPSILON * e->radiance[i]);
    assert_int_equal(scene->emitters[1].type, MCV_EMITTER_ENVIRONMENT);
    assert_int_equal(scene->emitters[1].instance, MCV_NONE);
    for (uint32_t t = 0; t < 2; ++t) {
        double n[3][3], c[3][3];
        mcv_scene_vertex_normals(scene, 0, t, n);
        mcv_scene_corners(scene, 0, t, c);
        /* The node's -z is the world's +z: its parent mirrors z. */
        assert_true(n[0][0] == 0 && n[0][1] == 0 && n[0][2] == 1);
        assert_true(c[0][2] == -10);
    }
    assert_int_equal(scene->sensor_count, 2);
    assert_string_equal(scene->sensors[0].name, "cam");
    assert_string_equal(scene->sensors[1].name, "cam-2");
    assert_int_equal(mcv_scene_channels(scene), 3);
    assert_warns(scene, "ignored: extensions EXT_lights_image_based");
    mcv_scene_free(scene);
    free(text);
}

/* Two squares of areas 1 and 6 share 14 W: both have the radiance 14/(π 7), and add up. */
static void test_power_of_meshes(void **state) {
    (void)state;
    char *data = base64(square, sizeof square);
    char *text = text_of(
        HEAD ELEMENTS(
            "{\"type\":\"area\",\"power\":14}",
            PINHOLE) "\"buffers\":[{\"byteLength\":48,\"uri\":\"data:application/"
                     "octet-stream;base64,%s\"}],"
                     "\"bufferViews\":[{\"buffer\":0,\"byteLength\":48}],\"accessors\":[{"
                     "\"bufferView\":0,\"componentType\":5126,"
                     "\"count\":4,\"type\":\"VEC3\"},{\"bufferView\":0,\"componentType\":5126,"
                     "\"count\":3,\"type\":\"VEC3\"}],"
                     "\"meshes\":[{\"primitives\":[{\"mode\":5,\"attributes\":{\"POSITION\":0}},"
                     "{\"attributes\":{\"POSITION\":1}}]}],"
                     "\"nodes\":[{\"mesh\":0,\"scale\":[2,3,1],\"extensions\":{\"MCVISI_emitters\":"
                     "{\"emitter\":0}}}]}",
        data);
    mcv_scene *scene = must_load(text, NULL);
    assert_int_equal(scene->emitter_count, 2);
    assert_close(scene->emitters[0].area, 6, 6, 8, "area of the square");
    assert_close(scene->emitters[1].area, 3, 3, 8, "area of the triangle");
    for (uint32_t i = 0; i < 2; ++i) {
        assert_close(scene->emitters[i].radiance[0], 14 / (M_PI * 9), 1, 16, "common radiance");
        assert_int_equal(scene->instances[scene->emitters[i].instance].emitter, i);
    }
    assert_warns(scene, "sensors/0 \"cam\" is on no node");
    mcv_scene_free(scene);
    free(text);
    free(data);
}

/* --- --set
 * ------------------------------------------------------------------------------------------------------
 */

static void test_overrides(void **state) {
    (void)state;
    char *text = square_scene(
        ",\"material\":0",
        ELEMENTS("{\"name\":\"a/b\",\"type\":\"area\",\"size\":1,\"radiance\":1}",
                 PINHOLE) "\"materials\":[{\"name\":\"glass\",\"extensions\":{\"MCVISI_materials\":"
                          "{\"type\":\"dielectric\"}}},"
                          "{\"name\":\"paint\",\"pbrMetallicRoughness\":{\"metallicFactor\":0}}],"
                          "\"nodes\":[{\"name\":\"Camera.001\",\"mesh\":0,\"children\":[1,2]},"
                          "{\"extensions\":{\"MCVISI_emitters\":{\"emitter\":0}}},{\"extensions\":{"
                          "\"MCVISI_sensors\":{\"sensor\":0}}}]");
    static const struct {
        const char *set;
        size_t offset;
        double value;
        char of; /* s: first sensor, e: emitter, m: first material, n: second material, t: first
                    instance's transform */
    } cases[] = {
        {"sensors/cam/imageDistance=25mm", offsetof(mcv_sensor, as.pinhole.imageDistance), 25e-3,
         's'},
        {"sensors/0/pixelSize=[\"1um\",2e-6]", offsetof(mcv_sensor, as.pinhole.pixelSize[1]), 2e-6,
         's'},
        {"emitters/a/b/radiance=3", offsetof(mcv_emitter, radiance), 3, 'e'},
        {"materials/glass/ior=1.52", offsetof(mcv_material, as.dielectric.ior[0]), 1.52, 'm'},
        {"materials/glass/extensions/MCVISI_materials/priority=2",
         offsetof(mcv_material, as.dielectric.priority), 2, 'm'},
        {"materials/paint/baseColorFactor/g=0.25",
         offsetof(mcv_material, as.diffuse.reflectance[1]), 0.25, 'n'},
        {"materials/paint/pbrMetallicRoughness/baseColorFactor=[0.5,0,0,1]",
         offsetof(mcv_material, as.diffuse.reflectance[0]), 0.5, 'n'},
        {"nodes/Camera.001/translation/z=-3mm", offsetof(mcv_transform, m[11]), -3e-3, 't'},
        {"nodes/0/translation=[1,\"2cm\",3]", offsetof(mcv_transform, m[10]), 2e-2, 't'},
        {"nodes/0/scale/1=4", offsetof(mcv_transform, m[4]), 4, 't'},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        mcv_scene *scene = must_load(text, cases[i].set);
        const void *base = cases[i].of == 's'   ? (const void *)scene->sensors
                           : cases[i].of == 'e' ? (const void *)scene->emitters
                           : cases[i].of == 'm' ? (const void *)scene->materials
                           : cases[i].of == 'n' ? (const void *)(scene->materials + 1)
                                                : (const void *)&scene->instances[0].to_world;
        double value;
        memcpy(&value, (const char *)base + cases[i].offset, sizeof value);
        if (value != cases[i].value)
            fail_msg("--set %s gave %.17g, must give %.17g", cases[i].set, value, cases[i].value);
        mcv_scene_free(scene);
    }
    static const struct {
        const char *set, *says;
        mcv_result result;
    } wrong[] = {
        {"sensors/cam/imagedistance=1",
         "unknown key \"imagedistance\": did you mean \"imageDistance\"?", MCV_BAD_INPUT},
        {"sensors/can/imageDistance=1", "there is no \"can\" in sensors; did you mean \"cam\"?",
         MCV_BAD_INPUT},
        {"sensors/7/imageDistance=1", "there is no \"7\" in sensors", MCV_BAD_INPUT},
        {"sensor/cam/imageDistance=1", "did you mean \"sensors\"?", MCV_BAD_INPUT},
        {"nodes/0/transation/z=1", "there is no \"transation\"; did you mean \"translation\"?",
         MCV_BAD_INPUT},
        {"nodes/0/translation/q=1", "\"q\" is not an element of an array of 3", MCV_BAD_INPUT},
        {"nodes/0=1", "name a member of it", MCV_BAD_INPUT},
        {"materials/paint/emissivefactor=1", "did you mean \"emissiveFactor\"?", MCV_BAD_INPUT},
        {"cameras/0/perspective/yfov=1", "the file has no cameras", MCV_BAD_INPUT},
        {"sensors/cam/imageDistance", "must be PATH=VALUE", MCV_USAGE},
        {"=1", "must be PATH=VALUE", MCV_USAGE},
    };
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; ++i) {
        mcv_scene *scene;
        mcv_error error;
        const mcv_result result = load_text("scene_load.gltf", text, wrong[i].set, &scene, &error);
        if (result != wrong[i].result || scene)
            fail_msg("--set %s gave %d, must give %d", wrong[i].set, result, wrong[i].result);
        if (!strstr(error.text, wrong[i].says))
            fail_msg("--set %s: \"%s\" must say \"%s\"", wrong[i].set, error.text, wrong[i].says);
    }
    free(text);
}

/* One name on two nodes. */
static void test_ambiguous_name(void **state) {
    (void)state;
    static const char text[] = "{\"asset\":{\"version\":\"2.0\"},\"nodes\":[{\"name\":\"a\"},{"
                               "\"name\":\"b\"},{\"name\":\"a\"}]}";
    mcv_scene *scene;
    mcv_error error;
    assert_int_equal(load_text("scene_load.gltf", text, "nodes/a/translation/x=1", &scene, &error),
                     MCV_BAD_INPUT);
    if (!strstr(error.text, "ambiguous: use one of nodes/0, nodes/2"))
        fail_msg("\"%s\" must list the candidates", error.text);
    mcv_scene_free(must_load(text, "nodes/2/translation/x=1"));
}

/* --- poses and assets
 * ------------------------------------------------------------------------------------------- */

/* The camera of this node's MCVISI_pose, with nodes "part" at (1, 2, 3) below a turned parent and
 * "other" posed itself. */
static mcv_scene *load_pose(const char *pose, const char *set) {
    char *text = text_of(HEAD ELEMENTS("{\"type\":\"environment\"}",
                                       PINHOLE) "\"nodes\":[{\"rotation\":[0,1,0,0],\"scale\":[2,2,"
                                                "2],\"children\":[1,2,3]},{\"name\":\"part\","
                                                "\"translation\":[-0.5,1,-1.5]},"
                                                "{\"name\":\"cam\",\"extensions\":{\"MCVISI_"
                                                "sensors\":{\"sensor\":0},\"MCVISI_pose\":{%s}}},"
                                                "{\"name\":\"other\",\"extensions\":{\"MCVISI_"
                                                "pose\":{\"target\":\"part\",\"distance\":\"10cm\","
                                                "\"azimuth\":\"90deg\"}}}]}",
                         pose);
    mcv_scene *scene = must_load(text, set);
    free(text);
    return scene;
}

/* Position, x axis (right) and direction of view by hand. cos 90° and the like are off by a
 * rounding. */
static void test_pose(void **state) {
    (void)state;
    static const struct {
        const char *pose, *set;
        double position[3], right[3], view[3];
    } cases[] = {
        {"\"target\":\"part\",\"distance\":\"50cm\"", NULL, {1, 2, 3.5}, {1, 0, 0}, {0, 0, -1}},
        {"\"target\":1,\"distance\":0.5,\"azimuth\":\"90deg\"",
         NULL,
         {1.5, 2, 3},
         {0, 0, -1},
         {-1, 0, 0}},
        {"\"target\":\"part\",\"distance\":0.5,\"elevation\":\"90deg\"",
         NULL,
         {1, 2.5, 3},
         {1, 0, 0},
         {0, -1, 0}},
        {"\"target\":\"part\",\"distance\":0.5,\"elevation\":\"-90deg\",\"azimuth\":\"90deg\"",
         NULL,
         {1, 1.5, 3},
         {0, 0, -1},
         {0, 1, 0}},
        {"\"target\":[0,\"1m\",0],\"distance\":1,\"roll\":\"90deg\"",
         NULL,
         {0, 1, 1},
         {0, 1, 0},
         {0, 0, -1}},
        {"\"target\":\"other\",\"distance\":1", NULL, {1.1, 2, 4}, {1, 0, 0}, {0, 0, -1}},
        {"\"target\":\"part\",\"distance\":0.5",
         "nodes/cam/azimuth=90deg",
         {1.5, 2, 3},
         {0, 0, -1},
         {-1, 0, 0}},
    };
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; ++k) {
        mcv_scene *scene = load_pose(cases[k].pose, cases[k].set);
        assert_int_equal(scene->sensor_count, 1);
        const double *m = scene->sensors[0].to_world.m;
        for (int i = 0; i < 3; ++i) {
            assert_close(m[9 + i], cases[k].position[i], 8, 8, cases[k].pose);
            assert_close(m[3 * i], cases[k].right[i], 1, 8, cases[k].pose);
            assert_close(-m[3 * i + 2], cases[k].view[i], 1, 8, cases[k].pose);
        }
        mcv_scene_free(scene);
    }
}

/* As test_pose: a shift, a turn about one axis, and a third of a turn about the diagonal, which
 * takes x to y, y to z and z to x. What is aimed at does not take the camera along. */
static void test_misalignment(void **state) {
    (void)state;
#define STANDS "\"target\":\"part\",\"distance\":0.5"
    static const struct {
        const char *pose, *set;
        double position[3], right[3], view[3];
    } cases[] = {
        {STANDS, "nodes/cam/shiftX=50cm", {1.5, 2, 3.5}, {1, 0, 0}, {0, 0, -1}},
        {STANDS, "nodes/cam/turnY=90deg", {1, 2, 3.5}, {0, 0, -1}, {-1, 0, 0}},
        {STANDS, "nodes/part/shiftX=1", {1, 2, 3.5}, {1, 0, 0}, {0, 0, -1}},
        {STANDS "},\"MCVISI_misalignment\":{\"turnX\":\"69.28203230275509deg\",\"turnY\":"
                "\"69.28203230275509deg\",\"turnZ\":\"69.28203230275509deg\",\"shiftZ\":\"-5mm\"",
         "nodes/cam/shiftY=1mm",
         {1, 2.001, 3.495},
         {0, 1, 0},
         {-1, 0, 0}},
    };
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; ++k) {
        mcv_scene *scene = load_pose(cases[k].pose, cases[k].set);
        const double *m = scene->sensors[0].to_world.m;
        for (int i = 0; i < 3; ++i) {
            assert_close(m[9 + i], cases[k].position[i], 8, 8, cases[k].pose);
            assert_close(m[3 * i], cases[k].right[i], 1, 8, cases[k].pose);
            assert_close(-m[3 * i + 2], cases[k].view[i], 1, 8, cases[k].pose);
        }
        mcv_scene_free(scene);
    }
    /* In the axes of the parent, which is turned by 180° about y and twice as large. */
    mcv_scene *scene = load_pose(STANDS, "nodes/part/shiftX=10cm");
    for (uint32_t i = 0; i < scene->frame_count; ++i)
        if (strcmp(scene->frames[i].name, "part") == 0)
            assert_close(scene->frames[i].to_world.m[9], 0.8, 8, 8, "the part");
    mcv_scene_free(scene);
}

/* Node 0 places `count` nodes p<i>, 10 cm in front of p<i-1>; that of p0 is `first`. Reversed: each
 * stands in the file before its target. By parents: that of p<i> is c<i>, a child of c<i-1>, and
 * 1 m above it. */
enum { IN_ORDER, REVERSED, BY_PARENTS };

static char *chain_of(int kind, int count, const char *first) {
    char *text = NULL;
    size_t size;
    FILE *out = open_memstream(&text, &size);
    assert_non_null(out);
    fprintf(out, HEAD "\"nodes\":[{\"children\":[%d", 1);
    for (int i = 2; i <= count + (kind == BY_PARENTS); ++i) fprintf(out, ",%d", i);
    fputs("]}", out);
    for (int k = 0; k < count; ++k) {
        const int i = kind == REVERSED ? count - 1 - k : k;
        char *target =
            text_of(kind == BY_PARENTS ? "\"c%d\"" : "\"p%d\"", kind == BY_PARENTS ? i : i - 1);
        fprintf(out,
                ",{\"name\":\"p%d\",\"extensions\":{\"MCVISI_pose\":{\"target\":%s,"
                "\"distance\":0.1}}}",
                i, i > 0 || kind == BY_PARENTS ? target : first);
        free(target);
    }
    for (int i = 0; kind == BY_PARENTS && i < count; ++i) {
        fprintf(out, ",{\"name\":\"c%d\",\"translation\":[0,1,0]", i);
        if (i + 1 < count) fprintf(out, ",\"children\":[%d]", 2 + count + i);
        fputs("}", out);
    }
    fputs("]}", out);
    fclose(out);
    return text;
}

/* Up to 1000 targets and parents are followed, whatever the order; p<i> stands where it must. */
static void test_chains_of_poses(void **state) {
    (void)state;
    for (int kind = IN_ORDER; kind <= BY_PARENTS; ++kind) {
        const int most = kind == BY_PARENTS ? 999 : 1001;
        char *text = chain_of(kind, most, "[0,0,0]");
        mcv_scene *scene = must_load(text, NULL);
        uint32_t found = 0;
        for (uint32_t k = 0; k < scene->frame_count; ++k) {
            if (scene->frames[k].name[0] != 'p') continue;
            const long i = strtol(scene->frames[k].name + 1, NULL, 10);
            const double *at = scene->frames[k].to_world.m + 9;
            const bool high = kind == BY_PARENTS;
            assert_close(at[1], high ? (double)i + 1 : 0, most, most, "height");
            assert_close(at[2], high ? 0.1 : 0.1 * ((double)i + 1), most, most, "distance");
            ++found;
        }
        assert_int_equal(found, most);
        mcv_scene_free(scene);
        free(text);
        if (kind == BY_PARENTS) continue;
        text = chain_of(kind, most + 1, "[0,0,0]");
        must_refuse("scene_load.gltf", text,
                    "nodes/p0: its place follows from more than 1000 targets");
        free(text);
    }
    /* A circle: the first target that is met again. */
    char *text = chain_of(IN_ORDER, 3, "\"p2\"");
    must_refuse("scene_load.gltf", text, "nodes/p2: its place follows from itself");
    free(text);
    text = chain_of(REVERSED, 3, "\"p2\"");
    must_refuse("scene_load.gltf", text, "nodes/p1: its place follows from itself");
    free(text);
}

/* Seconds of processor time for 960 poses: 8 chains of 120, or one of 960. */
static double seconds_for(int kind, int count) {
    char *text = chain_of(kind, count, "[0,0,0]");
    struct timespec begin, end;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &begin);
    for (int i = 0; i < 960 / count; ++i) mcv_scene_free(must_load(text, NULL));
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &end);
    free(text);
    return (double)(end.tv_sec - begin.tv_sec) + 1e-9 * (double)(end.tv_nsec - begin.tv_nsec);
}

/* Each pose takes as long in a long chain as in short ones, not 8 or 64 times as long. Half way
 * between, as times vary. */
static void test_time_of_chains_of_poses(void **state) {
    (void)state;
    for (int kind = IN_ORDER; kind <= BY_PARENTS; ++kind) {
        const double few = seconds_for(kind, 120), many = seconds_for(kind, 960);
        print_message("8 chains of 120 poses: %.2g s, one of 960: %.2g s\n", few, many);
        if (many > 2.8 * few)
            fail_msg("kind %d: 8 chains of 120 poses take %g s, one of 960 %g s", kind, few, many);
    }
}

/* A file in millimetres placed twice: its meshes come once, its camera not at all, its lamp glows.
 */
static void test_assets(void **state) {
    (void)state;
    char *part = square_scene(
        ",\"material\":0",
        "\"materials\":[{\"name\":\"glow\",\"emissiveFactor\":[0.5,0.5,0.5]}],"
        "\"cameras\":[{\"type\":\"perspective\",\"perspective\":{\"yfov\":0.5,\"znear\":0.1}}],"
        "\"nodes\":[{\"name\":\"plate\",\"mesh\":0,\"camera\":0,\"translation\":[1,0,0]}]");
    free(write_bytes("scene_load_part.gltf", part, strlen(part)));
    mcv_scene *scene =
        must_load(HEAD "\"extensions\":{\"MCVISI_assets\":{\"assets\":[{\"uri\":\"scene_load_part."
                       "gltf\",\"unit\":\"mm\"}]}},"
                       "\"materials\":[{\"name\":\"first\"}],\"nodes\":[{\"children\":[1],"
                       "\"extensions\":{\"MCVISI_assets\":{\"asset\":0}}},"
                       "{\"scale\":[2,2,2],\"translation\":[0,0,7],\"extensions\":{\"MCVISI_"
                       "assets\":{\"asset\":0}}}]}",
                  NULL);
    assert_int_equal(scene->mesh_count, 1);
    assert_int_equal(scene->instance_count, 2);
    assert_int_equal(scene->sensor_count, 0);
    assert_int_equal(scene->emitter_count, 2);
    assert_string_equal(scene->materials[scene->instances[1].material].name, "glow");
    static const double x[2] = {2e-3, 4e-3}, z[2] = {0, 7};
    for (uint32_t i = 0; i < 2; ++i) {
        double corners[3][3];
        mcv_scene_corners(scene, i, 0, corners);
        assert_close(corners[1][0], x[i], 1e-2, 8, "corner of the part");
        assert_close(corners[1][2], z[i], 7, 2, "corner of the part");
        assert_close(scene->emitters[i].area, x[i] * x[i] / 4, 1e-4, 16, "area of the part");
    }
    mcv_scene_free(scene);
    free(part);
}

/* A cone narrower than float32 knows directions is warned of; one that is wide enough is not. */
static void test_needles(void **state) {
    (void)state;
    for (int narrow = 0; narrow < 2; ++narrow) {
        char text[512];
        snprintf(text, sizeof text,
                 "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0]}],"
                 "\"nodes\":[{\"extensions\":{\"MCVISI_emitters\":{\"emitter\":0}}}],"
                 "\"extensions\":{\"MCVISI_emitters\":{\"emitters\":[{\"name\":\"back\",\"type\":"
                 "\"parallel\",\"size\":0.1,"
                 "\"radiance\":1,\"halfAngle\":%s}]}}}",
                 narrow ? "0.9e-7" : "1.1e-7");
        mcv_scene *scene = must_load(text, NULL);
        assert_int_equal(scene->warning_count, narrow);
        if (narrow)
            assert_warns(scene, "emitter \"back\": a half-angle of 9e-08 rad is below the "
                                "resolution of directions (1e-07 rad)");
        mcv_scene_free(scene);
    }
}

/* Extras other than a note are counted, of assets too; `check` has a note of them. */
static void test_extras(void **state) {
    (void)state;
    mcv_scene *scene = must_load("{\"asset\":{\"version\":\"2.0\",\"extras\":{\"note\":\"a "
                                 "rig\"}},\"nodes\":[{\"extras\":{\"a\":1}},"
                                 "{\"extras\":3}]}",
                                 NULL);
    assert_int_equal(scene->warning_count, 0);
    assert_int_equal(scene->ignored_extras, 2);
    mcv_scene_free(scene);
}

/*
 * A metal by name has the n and k of its table at the scene's wavelengths: a grey scene at the d
 * line, one with a given wavelength there. Copper at 582.1 and 616.8 nm: (0.70, 2.704) and
 * (0.30, 3.205) (Johnson and Christy 1972), by line between.
 */
static void test_metals(void **state) {
    (void)state;
    static const char rest[] = "\"nodes\":[{\"mesh\":0}],\"materials\":[{\"name\":\"pipe\","
                               "\"extensions\":{\"MCVISI_materials\":"
                               "{\"type\":\"conductor\",\"metal\":\"copper\"}}}]";
    static const struct {
        const char *spectrum;
        const char *set;
        double wavelength;
    } cases[] = {
        {"", NULL, 587.6e-9},
        {",\"extensions\":{\"MCVISI_spectrum\":{\"wavelengths\":\"600nm\"}}", NULL, 600e-9},
        {",\"extensions\":{\"MCVISI_spectrum\":{\"wavelengths\":\"600nm\"}}",
         "spectrum/wavelengths=0.59um", 590e-9},
        {"", "spectrum/wavelengths=600nm", 600e-9}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        char both[512];
        snprintf(both, sizeof both, "%s%s", rest, cases[i].spectrum);
        char *text = square_scene(",\"material\":0", both);
        mcv_scene *scene = must_load(text, cases[i].set);
        const mcv_conductor_params *copper = &scene->materials[0].as.conductor;
        const double share = (cases[i].wavelength * 1e9 - 582.1) / (616.8 - 582.1);
        assert_int_equal(mcv_scene_channels(scene), 1);
        assert_true(fabs(mcv_scene_wavelength(scene, 2) - cases[i].wavelength) < 1e-21);
        assert_true(fabs(copper->n[1] - (0.70 - 0.40 * share)) < 1e-12 &&
                    fabs(copper->k[1] - (2.704 + 0.501 * share)) < 1e-12);
        mcv_scene_free(scene);
        free(text);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_primitives),
                                       cmocka_unit_test(test_accessors),
                                       cmocka_unit_test(test_normals),
                                       cmocka_unit_test(test_hierarchy),
                                       cmocka_unit_test(test_mirrored),
                                       cmocka_unit_test(test_made_by_hand),
                                       cmocka_unit_test(test_materials),
                                       cmocka_unit_test(test_metals),
                                       cmocka_unit_test(test_textures),
                                       cmocka_unit_test(test_texture_transform),
                                       cmocka_unit_test(test_mirrored_sensor),
                                       cmocka_unit_test(test_mirrored_emitter),
                                       cmocka_unit_test(test_glb),
                                       cmocka_unit_test(test_cameras),
                                       cmocka_unit_test(test_rectangle),
                                       cmocka_unit_test(test_power_of_meshes),
                                       cmocka_unit_test(test_overrides),
                                       cmocka_unit_test(test_ambiguous_name),
                                       cmocka_unit_test(test_needles),
                                       cmocka_unit_test(test_extras),
                                       cmocka_unit_test(test_pose),
                                       cmocka_unit_test(test_chains_of_poses),
                                       cmocka_unit_test(test_time_of_chains_of_poses),
                                       cmocka_unit_test(test_misalignment),
                                       cmocka_unit_test(test_assets)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
