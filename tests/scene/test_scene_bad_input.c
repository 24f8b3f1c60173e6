/* SPDX-License-Identifier: Apache-2.0 */
/* Bad scenes: one sentence that names file, place and what would be right; never a crash, never
 * half a scene. */
#include "test.h"

#include "scene_files.h"

#include <ftw.h>
#include <jansson.h>
#include <sys/stat.h>
#include <unistd.h>

#define FILE_NAME "bad_input.gltf"

static void refuse(const char *text, const char *says) { must_refuse(FILE_NAME, text, says); }

/* --- one fault each in a small scene
 * ---------------------------------------------------------------------------- */

/* A triangle of floats at byte 0, 16-bit indices 0 1 2 at byte 36; data of 44 bytes. */
#define BUFFER \
    "\"buffers\":[{\"byteLength\":44,\"uri\":\"data:application/octet-stream;base64,%s\"}]"
#define VIEWS \
    "\"bufferViews\":[{\"buffer\":0,\"byteLength\":36},{\"buffer\":0,\"byteOffset\":36," \
    "\"byteLength\":8}]"
#define ACCESSORS \
    "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\"}," \
    "{\"bufferView\":1,\"componentType\":5123,\"count\":3,\"type\":\"SCALAR\"}]"
#define MESHES "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"indices\":1}]}]"
#define NODES "\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"mesh\":0}]"
#define ASSET "{\"asset\":{\"version\":\"2.0\"},"
#define SCENE ASSET BUFFER "," VIEWS "," ACCESSORS "," MESHES "," NODES "}"

#define MATERIAL(type) \
    ASSET "\"materials\":[{\"name\":\"g\",\"extensions\":{\"MCVISI_materials\":{\"type\":" type \
          "}}}]}"
#define SPECTRUM(object) ASSET "\"extensions\":{\"MCVISI_spectrum\":" object "}}"

static const float triangle[3][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};

static char *data_of(const float positions[3][3], uint16_t last) {
    unsigned char bytes[44] = {0};
    const uint16_t indices[3] = {0, 1, last};
    memcpy(bytes, positions, 36);
    memcpy(bytes + 36, indices, sizeof indices);
    return base64(bytes, sizeof bytes);
}

/* The scene with the first `from` replaced by `to`. */
static char *broken(const char *scene, const char *from, const char *to) {
    const char *at = strstr(scene, from);
    if (!at) fail_msg("the test looks for %s, which is not in the scene", from);
    return text_of("%.*s%s%s", (int)(at - scene), scene, to, at + strlen(from));
}

static void test_single_faults(void **state) {
    (void)state;
    static const struct {
        const char *from, *to, *says;
    } cases[] = {
        {"\"2.0\"", "\"1.0\"", "asset: version \"1.0\" must be 2.x"},
        {"\"asset\"", "\"Asset\"", "must have \"asset\""},
        {"{\"asset\"", "{\"asset\":{},\"asset\"", "is not JSON: duplicate object key"},
        {"{\"asset\"", "{\"cameras\":7,\"asset\"", "cameras: must be an array, not a number"},
        {"{\"asset\"", "{\"cameras\":[],\"asset\"", "cameras: the array is empty"},
        {"\"byteLength\":44", "\"byteLength\":45", "buffers/0: byteLength 45 exceeds the 44 bytes"},
        {"\"byteLength\":44", "\"byteLength\":-1", "buffers/0/byteLength: -1 must be an integer"},
        {"\"byteLength\":44", "\"byteLength\":44.5",
         "buffers/0/byteLength: 44.5 must be an integer"},
        {"\"byteLength\":44", "\"byteLength\":\"44\"",
         "buffers/0/byteLength: must be an integer, not a string"},
        {"base64,", "base64,*", "buffers/0/uri: has broken base64"},
        {"data:application/octet-stream", "data:application/json",
         "must begin with data:application/octet-stream;base64,"},
        {"\"byteOffset\":36", "\"byteOffset\":37",
         "bufferViews/1: 8 bytes from byte 37 on exceed the 44 bytes of buffer 0"},
        {"\"byteOffset\":36", "\"byteOffset\":9007199254740992",
         "bufferViews/1: 8 bytes from byte 9007199254740992 on exceed"},
        {"\"byteOffset\":36", "\"byteOffset\":1e300",
         "bufferViews/1/byteOffset: 1e+300 must be an integer"},
        {"{\"buffer\":0", "{\"buffer\":1",
         "bufferViews/0/buffer: index 1 does not exist: buffers go from 0 to 0"},
        {"{\"bufferView\":0", "{\"bufferView\":2",
         "accessors/0/bufferView: index 2 does not exist: bufferViews go from 0 to 1"},
        {"\"count\":3", "\"count\":4",
         "accessors/0: 4 elements of 12 bytes from byte 0 on exceed the 36 bytes of bufferView 0"},
        {"\"count\":3", "\"count\":4294967295", "accessors/0: 4294967295 elements of 12 bytes"},
        {"\"count\":3", "\"count\":4294967296",
         "accessors/0/count: 4.29497e+09 must be an integer"},
        {"\"count\":3", "\"count\":0", "accessors/0/count: 0 must be an integer"},
        {"\"bufferView\":0,\"componentType\":5126,\"count\":3",
         "\"componentType\":5126,\"count\":4000000000", "without a bufferView"},
        {"\"componentType\":5126", "\"componentType\":5124",
         "accessors/0: componentType 5124 must be"},
        {"\"type\":\"VEC3\"", "\"type\":\"VEC2\"",
         "primitives/0/attributes/POSITION: must be a VEC3"},
        {"\"type\":\"VEC3\"", "\"type\":\"VEC9\"",
         "primitives/0/attributes/POSITION: must be a VEC3"},
        {"\"componentType\":5126,", "\"componentType\":5126,\"byteOffset\":2,",
         "accessors/0/byteOffset: 2, 2 in the buffer, must be a multiple"},
        {"\"byteLength\":36}", "\"byteLength\":36,\"byteStride\":8}",
         "accessors/0: elements of 12 bytes overlap"},
        {"\"byteLength\":36}", "\"byteLength\":36,\"byteStride\":7}",
         "bufferViews/0: byteStride 7 must be a multiple of 4"},
        {"\"POSITION\":0", "\"POSITION\":5",
         "primitives/0/attributes/POSITION: index 5 does not exist"},
        {"\"POSITION\":0", "\"POSITION\":0,\"NORMAL\":1",
         "primitives/0/attributes/NORMAL: must be a VEC3"},
        {"\"indices\":1", "\"indices\":0",
         "primitives/0/indices: must be a SCALAR of unsigned integers"},
        {"\"indices\":1", "\"indices\":-1", "primitives/0/indices: index -1 does not exist"},
        {"\"indices\":1", "\"indices\":1,\"mode\":7",
         "primitives/0/mode: 7 must be an integer from 0 to 6"},
        {"\"indices\":1", "\"indices\":1,\"material\":0",
         "primitives/0/material: index 0 does not exist: the file has no materials"},
        {"[{\"attributes\"", "[[{\"attributes\"", "is not JSON"},
        {"\"nodes\":[0]", "\"nodes\":[1]",
         "scenes/0/nodes/0: must be the index of a node: nodes go from 0 to 0"},
        {"\"nodes\":[0]", "\"nodes\":[0,0]", "scenes/0/nodes: node 0 occurs twice"},
        {"\"scenes\"", "\"scene\":1,\"scenes\"",
         "scene: index 1 does not exist: scenes go from 0 to 0"},
        {"{\"mesh\":0}", "{\"mesh\":1}",
         "nodes/0/mesh: index 1 does not exist: meshes go from 0 to 0"},
        {"{\"mesh\":0}", "{\"children\":[0]}", "nodes/0: is its own ancestor"},
        {"{\"mesh\":0}", "{\"children\":[1,2]},{\"children\":[2]},{}",
         "nodes/1/children: node 2 is a child of node 0 already"},
        {"{\"mesh\":0}", "{\"children\":[1]},{\"children\":[2]},{\"children\":[1]}",
         "is a child of node"},
        {"{\"mesh\":0}", "{\"rotation\":[1,1,1,1]}",
         "nodes/0: rotation must be a quaternion of length 1, not 2"},
        {"{\"mesh\":0}", "{\"translation\":[1,1]}",
         "nodes/0/translation: must be an array of 3 numbers in brackets, as in [1, 0, …]"},
        {"{\"mesh\":0}", "{\"scale\":[1,1,\"1\"]}",
         "nodes/0/scale/2: must be a number, not a string"},
        {"{\"mesh\":0}", "{\"matrix\":[1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1],\"scale\":[1,1,1]}",
         "nodes/0: has a matrix and"},
        {"{\"mesh\":0}", "{\"matrix\":[1,0,0,0,1,1,0,0,0,0,1,0,0,0,0,1]}",
         "nodes/0: its matrix shears"},
        {"{\"mesh\":0}",
         "{\"mesh\":0,\"scale\":[1e10,1,1],\"children\":[1]},{\"mesh\":0,\"scale\":[1e10,1,1]}",
         "nodes/1: it reaches to 1e+20 m"},
        {"{\"mesh\":0}",
         "{\"camera\":0}],\"cameras\":[{\"type\":\"perspective\",\"perspective\":{\"yfov\":0,"
         "\"znear\":1}}",
         "cameras/0/perspective/yfov: 0 must lie"},
        {"{\"mesh\":0}",
         "{\"camera\":0,\"scale\":[0,1,1]}],\"cameras\":[{\"type\":\"orthographic\","
         "\"orthographic\":{\"xmag\":1,\"ymag\":0,\"znear\":0,"
         "\"zfar\":1}}",
         "cameras/0/orthographic: must have xmag and ymag other than 0"},
        {"{\"mesh\":0}",
         "{\"camera\":0,\"scale\":[1,0,1]}],\"cameras\":[{\"type\":\"perspective\",\"perspective\":"
         "{\"yfov\":1,\"znear\":1}}",
         "nodes/0: its scale must not be 0"},
        {"{\"asset\"", "{\"extensionsRequired\":[\"KHR_draco_mesh_compression\"],\"asset\"",
         "extensionsRequired/0: KHR_draco_mesh_compression is required, but this program does not "
         "read it"},
        {"{\"asset\"", "{\"extensionsRequired\":[\"MCVISI_sensor\"],\"asset\"",
         "does not read it; it reads MCVISI_sensors"},
        {"{\"asset\"", "{\"images\":[{\"uri\":\"/etc/passwd\"}],\"asset\"",
         "images/0/uri: \"/etc/passwd\" is absolute"},
        {"{\"asset\"", "{\"images\":[{\"uri\":\"a/%2e%2e/../b\"}],\"asset\"",
         "leads out of the scene's directory by .."},
        {"{\"asset\"", "{\"images\":[{\"uri\":\"%2e%2e/b\"}],\"asset\"",
         "leads out of the scene's directory by .."},
        {"{\"asset\"", "{\"images\":[{\"uri\":\"file:///etc/passwd\"}],\"asset\"",
         "has a scheme: only data: URIs and files"},
        {"{\"asset\"", "{\"images\":[{\"uri\":\"a%00b\"}],\"asset\"", "has a broken % escape"},
        {"{\"asset\"", "{\"images\":[{\"uri\":\"a\\\\b\"}],\"asset\"", "has a backslash"},
    };
    char *data = data_of(triangle, 2), *scene = text_of(SCENE, data), *again;
    mcv_scene *loaded;
    mcv_error error;
    if (load_text(FILE_NAME, scene, NULL, &loaded, &error) != MCV_OK)
        fail_msg("the scene itself must load: %s", error.text);
    mcv_scene_free(loaded);
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        again = broken(scene, cases[i].from, cases[i].to);
        refuse(again, cases[i].says);
        free(again);
    }
    free(scene);
    free(data);
}

static void test_bad_data(void **state) {
    (void)state;
    static const float bad[] = {NAN, INFINITY, -INFINITY};
    for (int i = 0; i < 3; ++i) {
        float positions[3][3];
        memcpy(positions, triangle, sizeof positions);
        positions[1][2] = bad[i];
        char *data = data_of((const float(*)[3])positions, 2), *scene = text_of(SCENE, data);
        refuse(scene, "meshes/0/primitives/0/POSITION: vertex 1 has the coordinate");
        free(scene);
        free(data);
    }
    char *data = data_of(triangle, 3), *scene = text_of(SCENE, data);
    refuse(scene, "meshes/0/primitives/0/indices: index 3 of triangle 0 does not exist: "
                  "vertices go from 0 to 2");
    free(scene);
    free(data);
    data = data_of(triangle, 65535);
    scene = text_of(SCENE, data);
    refuse(scene, "meshes/0/primitives/0/indices: 65535 restarts a primitive");
    free(scene);
    free(data);
    refuse(ASSET "\"buffers\":[{\"byteLength\":44}]," VIEWS "," ACCESSORS "," MESHES "," NODES "}",
           "buffer 0 has no data: give it a uri");
}

#define EXTENSION(emitters, sensors, nodes) \
    ASSET "\"extensions\":{\"MCVISI_emitters\":{\"emitters\":[" emitters \
          "]},\"MCVISI_sensors\":{\"sensors\":[" sensors "]}}," \
          "\"scenes\":[{\"nodes\":[0]}],\"nodes\":[" nodes "]}"
#define CAM \
    "{\"name\":\"cam\",\"type\":\"pinhole\",\"imageDistance\":1,\"resolution\":1,\"pixelSize\":1}"
#define LAMP "{\"name\":\"lamp\",\"type\":\"area\",\"size\":1,\"radiance\":1}"

#define POSED(pose) \
    ASSET "\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"name\":\"n\",\"extensions\":{\"MCVISI_" \
          "pose\":{" pose "}}}]}"
#define PLACED(asset) ASSET "\"extensions\":{\"MCVISI_assets\":{\"assets\":[" asset "]}}}"

static void test_bad_elements(void **state) {
    (void)state;
    static const struct {
        const char *text, *says;
    } cases[] = {
        {EXTENSION(LAMP, "{\"type\":\"thinLens\",\"focallength\":1}", "{}"),
         "sensors/0: unknown key \"focallength\": did you mean \"focalLength\"?"},
        {EXTENSION(LAMP, "{\"name\":\"cam\",\"type\":\"fisheye\"}", "{}"),
         "sensors/cam/type: unknown type \"fisheye\": known are pinhole"},
        {EXTENSION(LAMP, "{\"name\":\"cam\",\"type\":\"thinlens\"}", "{}"),
         "did you mean \"thinLens\"?"},
        {EXTENSION(LAMP, "{\"name\":\"cam\"}", "{}"), "sensors/cam/type: is missing"},
        {EXTENSION(LAMP, "{\"name\":3}", "{}"), "sensors/0/name: must be a string"},
        {EXTENSION(LAMP, "7", "{}"), "sensors/0: must be an object"},
        {EXTENSION("{\"type\":\"parallel\",\"size\":1,\"halfAngle\":0,\"radiance\":1}", CAM, "{}"),
         "emitters/0/halfAngle: 0 is a collimated beam"},
        {EXTENSION("{\"type\":\"parallel\",\"size\":1,\"halfAngle\":\"91deg\",\"radiance\":1}", CAM,
                   "{}"),
         "emitters/0/halfAngle: 1.58825 must be above 0"},
        {EXTENSION("{\"type\":\"area\",\"size\":1}", CAM, "{}"), "emitters/0: needs radiance"},
        {EXTENSION("{\"type\":\"area\",\"size\":1,\"radiance\":1,\"power\":1}", CAM, "{}"),
         "emitters/0: has both radiance 1 and power 1"},
        {EXTENSION("{\"type\":\"area\",\"size\":0,\"radiance\":1}", CAM, "{}"),
         "emitters/0/size: 0 must be above 0"},
        {EXTENSION("{\"type\":\"area\",\"radiance\":1}", CAM,
                   "{\"name\":\"n\",\"extensions\":{\"MCVISI_emitters\":{\"emitter\":0}}}"),
         "emitters/0: needs size, because its node \"n\" has no mesh"},
        {EXTENSION(LAMP, CAM, "{\"extensions\":{\"MCVISI_emitters\":{\"emitter\":1}}}"),
         "nodes/0/extensions/MCVISI_emitters/emitter: index 1 does not exist: emitters go from "
         "0 to 0"},
        {EXTENSION(LAMP, CAM, "{\"extensions\":{\"MCVISI_sensors\":{\"Sensor\":0}}}"),
         "nodes/0/extensions/MCVISI_sensors: unknown key \"Sensor\": did you mean \"sensor\"?"},
        {EXTENSION(LAMP, CAM, "{\"extensions\":{\"MCVISI_sensors\":{}}}"),
         "must have the index \"sensor\""},
        {EXTENSION("{\"type\":\"environment\"},{\"type\":\"environment\"}", CAM,
                   "{\"children\":[1],\"extensions\":{\"MCVISI_emitters\":{\"emitter\":0}}},{"
                   "\"extensions\":{\"MCVISI_emitters\":{"
                   "\"emitter\":1}}}"),
         "is an environment already: a scene has at most one"},
        {ASSET "\"extensions\":{\"MCVISI_sensors\":{\"sensor\":[]}}}",
         "unknown key \"sensor\": did you mean \"sensors\"?"},
        {ASSET "\"materials\":[{\"name\":\"g\",\"extensions\":{\"MCVISI_materials\":{\"type\":"
               "\"dielectric\",\"IOR\":2}}}]}",
         "materials/g: unknown key \"IOR\": did you mean \"ior\"?"},
        {ASSET "\"materials\":[{\"name\":\"g\",\"extensions\":{\"MCVISI_materials\":{\"type\":"
               "\"dielectric\",\"ior\":0.5}}}]}",
         "materials/g/ior: 0.5 must lie from 1 to 10"},
        {ASSET "\"materials\":[{\"name\":\"g\",\"extensions\":{\"MCVISI_materials\":{\"type\":"
               "\"dielectric\",\"priority\":0.5}}}]}",
         "materials/g: priority 0.5 must be an integer"},
        {ASSET "\"materials\":[{\"name\":\"g\",\"extensions\":{\"MCVISI_materials\":{\"type\":"
               "\"beamSplitter\",\"reflectance\":0.75}}}]}",
         "materials/g: reflectance 0.75 and transmittance 0.5 must not be more than 1 together"},
        {MATERIAL("\"dielectric\",\"roughness\":1.5"),
         "materials/g/roughness: 1.5 must lie from 0 to 1"},
        {MATERIAL("\"dielectric\",\"roughness\":-0.1"),
         "materials/g/roughness: -0.1 must lie from 0 to 1"},
        {MATERIAL("\"dielectric\",\"coating\":2"), "materials/g/coating: 2 must lie from 0 to 1"},
        {MATERIAL("\"dielectric\",\"anisotropy\":-1"),
         "materials/g/anisotropy: -1 must lie from 0 to 1"},
        {MATERIAL("\"conductor\",\"n\":-1,\"k\":1"), "materials/g/n: -1 must lie from 0 to 100"},
        {MATERIAL("\"conductor\",\"n\":1,\"k\":[1,1,-2]"),
         "materials/g/k: -2 must lie from 0 to 100"},
        {MATERIAL("\"conductor\",\"n\":1"), "materials/g: n and k must be given together"},
        {MATERIAL("\"conductor\",\"n\":[1,2],\"k\":1"),
         "materials/g/n: has 2 values, but must have 3"},
        {MATERIAL("\"conductor\",\"metal\":\"unobtainium\""),
         "materials/g/metal: \"unobtainium\" must be \"aluminium\" or"},
        {MATERIAL("\"conductor\",\"roughness\":\"nan\""),
         "materials/g/roughness: \"nan\" must be a number"},
        {MATERIAL("\"metallicRoughness\",\"ior\":0.9"),
         "materials/g/ior: 0.9 must lie from 1 to 10"},
        {MATERIAL("\"metallicRoughness\",\"metallic\":2"),
         "materials/g/metallic: 2 must lie from 0 to 1"},
        {MATERIAL("\"diffuse\",\"transmittance\":0.75"),
         "materials/g: reflectance 0.5 and transmittance 0.75 must not be more than 1"},
        {MATERIAL("\"retroreflector\",\"divergence\":\"100deg\""),
         "materials/g/divergence: 1.74533 must lie from 0 to 1.5"},
        {MATERIAL("\"retroreflector\",\"entranceAngle\":0"),
         "materials/g/entranceAngle: 0 must be above 0"},
        {MATERIAL("\"retroreflector\",\"diffuseReflectance\":0.1"),
         "materials/g: reflectance 1 and diffuseReflectance 0.1 must not be more than 1 together"},
        {SPECTRUM("1"), "extensions/MCVISI_spectrum: must be an object"},
        {SPECTRUM("{\"wavelength\":1e-7}"),
         "MCVISI_spectrum: unknown key \"wavelength\": did you mean \"wavelengths\"?"},
        {SPECTRUM("{}"),
         "MCVISI_spectrum/wavelengths: must be a length such as \"587.6nm\", or three"},
        {SPECTRUM("{\"wavelengths\":[5e-7,6e-7]}"),
         "MCVISI_spectrum/wavelengths: must be a length such as \"587.6nm\", or three"},
        {SPECTRUM("{\"wavelengths\":\"587.6\"}"),
         "MCVISI_spectrum/wavelengths: 587.6 m must be from 100 nm to 100 um"},
        {SPECTRUM("{\"wavelengths\":[\"600nm\",\"-500nm\",\"400nm\"]}"),
         "MCVISI_spectrum/wavelengths: -5e-07 m must be from 100 nm"},
        {ASSET "\"materials\":[{\"pbrMetallicRoughness\":{\"baseColorFactor\":[2,0,0,1]}}]}",
         "materials/0/pbrMetallicRoughness/baseColorFactor/0: 2 must lie from 0 to 1"},
        {ASSET "\"materials\":[{\"extensions\":{\"KHR_materials_ior\":{\"ior\":0.5}}}]}",
         "KHR_materials_ior: ior 0.5 must be 1 or more"},
        {POSED("\"distance\":1"), "nodes/n/target: is missing"},
        {POSED("\"target\":\"m\",\"distance\":1"), "nodes/n/target: there is no node \"m\""},
        {POSED("\"target\":7,\"distance\":1"), "nodes/n/target: index 7 does not exist"},
        {POSED("\"target\":[1,2],\"distance\":1"),
         "nodes/n/target: a point must have 3 coordinates"},
        {POSED("\"target\":[1,2,\"3deg\"],\"distance\":1"),
         "nodes/n/target: coordinate 2 must be a length"},
        {POSED("\"target\":\"n\",\"distance\":1"), "nodes/n: its place follows from itself"},
        {POSED("\"target\":[0,0,0]"), "nodes/n/distance: is missing"},
        {POSED("\"target\":[0,0,0],\"distance\":0"), "nodes/n/distance: 0 must be above 0"},
        {POSED("\"target\":[0,0,0],\"distance\":1,\"azimut\":1"),
         "nodes/n: unknown key \"azimut\": did you mean \"azimuth\"?"},
        {PLACED("{}"), "assets/0/uri: is missing"},
        {PLACED("{\"uri\":\"part.obj\"}"),
         "assets/0/uri: \"part.obj\" must be a .gltf, .glb or .stl file"},
        {PLACED("{\"uri\":\"part.glb\",\"creaseAngle\":-0.5}"),
         "assets/0/creaseAngle: -0.5 must lie from 0 to 3.14159"},
        {PLACED("{\"uri\":\"part.stl\",\"unit\":\"mm\",\"creaseAngle\":4}"),
         "assets/0/creaseAngle: 4 must lie from 0 to 3.14159"},
        {PLACED("{\"uri\":\"part.stl\",\"unit\":\"mm\",\"materials\":{}}"),
         "assets/0/materials: is for .gltf and .glb files"},
        {PLACED("{\"uri\":\"part.stl\",\"unit\":\"mm\",\"nodeMaterials\":{}}"),
         "assets/0/nodeMaterials: is for .gltf and .glb files"},
        {PLACED("{\"uri\":\"../part.glb\"}"),
         "assets/0/uri: \"../part.glb\" leads out of the scene's directory"},
        {PLACED("{\"uri\":\"missing.glb\"}"),
         "assets/0/uri: \"" MCV_BINARY_DIR "/tests/missing.glb\" cannot be opened"},
        {PLACED("{\"uri\":\"missing.glb\",\"unit\":\"foot\"}"),
         "assets/0/unit: \"foot\" must be one of"},
        {PLACED("{\"name\":\"me\",\"uri\":\"" FILE_NAME "\"}"),
         "assets/me: an asset may not place assets itself"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i)
        refuse(cases[i].text, cases[i].says);
}

/* An emitter on a mesh takes no size, and needs triangles that have an area. */
static void test_bad_emitting_meshes(void **state) {
    (void)state;
    static const float line[3][3] = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}};
    char *data = data_of(triangle, 2);
    char *text = text_of(ASSET "\"extensions\":{\"MCVISI_emitters\":{\"emitters\":[" LAMP
                               "]}}," BUFFER "," VIEWS "," ACCESSORS "," MESHES
                               ",\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"mesh\":0,"
                               "\"extensions\":{\"MCVISI_emitters\":{\"emitter\":0}}}]}",
                         data);
    refuse(text, "emitters/lamp: size is for a node without a mesh");
    free(text);
    free(data);
    data = data_of(line, 2);
    text = text_of(ASSET "\"extensions\":{\"MCVISI_emitters\":{\"emitters\":[{\"type\":\"area\","
                         "\"radiance\":1}]}}," BUFFER "," VIEWS "," ACCESSORS "," MESHES
                         ",\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"mesh\":0,\"extensions\":{"
                         "\"MCVISI_emitters\":{\"emitter\":0}}}]}",
                   data);
    refuse(text, "has an area of 0 m²");
    free(text);
    free(data);
}

/* --- files
 * ------------------------------------------------------------------------------------------------------
 */

static void refuse_file(const char *path, const char *says) {
    mcv_scene *scene = (mcv_scene *)1;
    mcv_error error;
    const mcv_result result = load_file(path, &scene, &error);
    if (result != MCV_BAD_INPUT || scene || !strstr(error.text, says) || !strstr(error.text, path))
        fail_msg("%s gave %d \"%s\", must be refused with \"%s\"", path, result, error.text, says);
}

static void test_bad_files(void **state) {
    (void)state;
    char *fifo = text_of("%s/tests/bad_input.fifo", MCV_BINARY_DIR),
         *link = text_of("%s/tests/bad_input.link", MCV_BINARY_DIR);
    refuse_file(MCV_BINARY_DIR "/tests/no such file.gltf",
                "cannot be opened: No such file or directory");
    refuse_file(MCV_BINARY_DIR, "is a directory, but must be a file");
    refuse_file("/dev/zero", "must be a regular file");
    unlink(fifo);
    assert_int_equal(mkfifo(fifo, 0600), 0);
    refuse_file(fifo, "must be a regular file"); /* and does not wait for a writer */
    unlink(link);
    assert_int_equal(symlink("/etc/hostname", link), 0);
    refuse("", "is not JSON");
    refuse("[]", "must be a JSON object");
    refuse("{\"asset\":{\"version\":\"2.0\"}} x", "is not JSON");
    refuse(ASSET "\"buffers\":[{\"byteLength\":4,\"uri\":\"missing.bin\"}]}", "buffers/0/uri: ");
    refuse(ASSET "\"buffers\":[{\"byteLength\":4,\"uri\":\"bad_input.fifo\"}]}",
           "must be a regular file");
    refuse(ASSET "\"buffers\":[{\"byteLength\":4,\"uri\":\"../tests\"}]}",
           "leads out of the scene's directory");
    refuse(ASSET "\"buffers\":[{\"byteLength\":4,\"uri\":\"bad_input.link\"}]}",
           "is a link that leads out of the scene's directory");
    refuse(ASSET "\"buffers\":[{\"byteLength\":4000,\"uri\":\"bad_input.gltf\"}]}",
           "but byteLength is 4000");
    unlink(fifo);
    unlink(link);
    free(fifo);
    free(link);
    /* Pictures that are asked for. */
#define PICTURE(uri) \
    ASSET "\"images\":[{\"uri\":\"" uri "\"}],\"textures\":[{\"source\":0}]," \
          "\"materials\":[{\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":0}}}]}"
    refuse(PICTURE("missing.png"), "images/0/uri: ");
    refuse(PICTURE("bad_input.gltf"), "images/0: is neither a PNG nor a JPEG");
    refuse(PICTURE("data:image/png;base64,AAAA"), "images/0: is neither a PNG nor a JPEG");
    /* A PNG's head that promises 60000 x 60000 pixels. */
    refuse(PICTURE("data:image/png;base64,iVBORw0KGgoAAAANSUhEUgAA6mAAAOpgCAIAAAAA"),
           "images/0: has more than 2^27 pixels");
}

/* A GLB that ends anywhere before its end. */
static void test_truncated_glb(void **state) {
    (void)state;
    size_t size;
    const char *json = ASSET "\"buffers\":[{\"byteLength\":36}],\"bufferViews\":[{\"buffer\":0,"
                             "\"byteLength\":36}],\"accessors\":[{\"bufferView\":0,"
                             "\"componentType\":5126,\"count\":3,\"type\":\"VEC3\"}],\"meshes\":[{"
                             "\"primitives\":[{\"attributes\":{\"POSITION\":0}}]}]," NODES "}";
    unsigned char *glb = glb_of(json, triangle, sizeof triangle, &size);
    mcv_scene *scene;
    mcv_error error;
    char *path = write_bytes("bad_input.glb", "", 0);
    FILE *file = fopen(path, "ab"); /* grown byte by byte: making files anew is slow */
    assert_non_null(file);
    for (size_t length = 0; length <= size; ++length) {
        const mcv_result result = load_file(path, &scene, &error);
        if (result != (length < size ? MCV_BAD_INPUT : MCV_OK))
            fail_msg("%zu of %zu bytes gave %d: %s", length, size, result, error.text);
        if (result == MCV_OK)
            assert_int_equal(scene->triangle_count, 1);
        else if (!strstr(error.text, path))
            fail_msg("\"%s\" must name the file", error.text);
        mcv_scene_free(scene);
        if (length < size) fputc(glb[length], file);
        fflush(file);
    }
    fclose(file);
    free(path);
    free(glb);
}

/* xorshift, seeded: the same faults in every run. */
static uint32_t random_number(uint32_t *state) {
    *state ^= *state << 13;
    *state ^= *state >> 17;
    *state ^= *state << 5;
    return *state;
}

/* A few bytes changed at random: a scene or a sentence, and in the asan preset no fault of memory.
 */
static void test_damaged(void **state) {
    (void)state;
    static const unsigned char interesting[] = "0123456789-.,:[]{}\"e \xff\x00\x80";
    size_t size;
    const char *json = ASSET
        "\"buffers\":[{\"byteLength\":44}]," VIEWS
        ",\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\"},"
        "{\"bufferView\":1,\"componentType\":5123,\"count\":3,\"type\":\"SCALAR\"},{\"bufferView\":"
        "0,\"componentType\":5126,"
        "\"count\":3,\"type\":"
        "\"VEC3\",\"sparse\":{\"count\":1,\"indices\":{\"bufferView\":1,\"componentType\":5121},"
        "\"values\":{\"bufferView\":0,"
        "\"byteOffset\":12}}}],"
        "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0,\"NORMAL\":2},\"indices\":1,"
        "\"material\":0},{\"mode\":6,"
        "\"attributes\":{"
        "\"POSITION\":2}}]}],\"materials\":[{\"emissiveFactor\":[1,1,0]}],\"cameras\":[{\"type\":"
        "\"perspective\",\"perspective\":{"
        "\"yfov\":0.5,"
        "\"znear\":0.1}}],\"extensions\":{\"MCVISI_emitters\":{\"emitters\":[" LAMP
        "]},\"MCVISI_sensors\":{\"sensors\":[" CAM "]}},"
        "\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"mesh\":0,\"children\":[1,2]},{\"camera\":0,"
        "\"rotation\":[0,1,0,0]},{\"matrix\":["
        "1,0,0,0,0,1,0,"
        "0,0,0,1,0,0,0,0,1],\"extensions\":{\"MCVISI_emitters\":{\"emitter\":0},\"MCVISI_sensors\":"
        "{\"sensor\":0}}}]}";
    unsigned char bytes[44] = {0};
    memcpy(bytes, triangle, sizeof triangle);
    memcpy(bytes + 36, (const uint16_t[]){0, 1, 2}, 6);
    unsigned char *glb = glb_of(json, bytes, sizeof bytes, &size), *damaged = malloc(size);
    uint32_t seed = 20260101, loaded = 0;
    const int runs = 5000;
    char *path = write_bytes("bad_input.glb", glb, size);
    FILE *file = fopen(path, "r+b");
    assert_non_null(file);
    for (int run = 0; run < runs; ++run) {
        memcpy(damaged, glb, size);
        for (uint32_t k = random_number(&seed) % 3; k < 3; ++k)
            damaged[12 + random_number(&seed) % (size - 12)] =
                interesting[random_number(&seed) % (sizeof interesting - 1)];
        rewind(file);
        fwrite(damaged, 1, size, file);
        fflush(file);
        mcv_scene *scene;
        mcv_error error;
        const mcv_result result = load_file(path, &scene, &error);
        if (result != MCV_OK && (result != MCV_BAD_INPUT || !error.text[0] || scene))
            fail_msg("run %d gave %d, \"%s\"", run, result, error.text);
        loaded += result == MCV_OK;
        mcv_scene_free(scene);
    }
    fclose(file);
    free(path);
    /* Both ends are met, or the damage tests nothing. */
    assert_in_range(loaded, 1, runs - 1);
    free(damaged);
    free(glb);
}

/* --- Khronos' validator
 * ----------------------------------------------------------------------------------------- */

/* Files where this program and the validator part, with the reason; whole folders end in a slash.
 */
static const struct {
    const char *path, *reason;
} exceptions[] = {
    {"/animation", "animations are not read"},
    {"/skin/", "skins are not read"},
    {"mesh/morph_", "morph targets are not read"},
    {"mesh/invalid_attribute_escaped_name", "attributes that are not read may have any name"},
    {"mesh/invalid_indexed_attribute", "attributes that are not read may have any name"},
    {"mesh/accessor_attribute_uint32", "attributes that are not read may have any type"},
    {"mesh/accessor_without_bytestride",
     "elements without byteStride lie side by side, also where attributes share a bufferView"},
    {"mesh/bufferview_target_override", "targets of bufferViews are not read"},
    {"mesh_data/index_buffer_primitive_restart",
     "no node places the mesh (test_bad_data has one that is placed)"},
    {"mesh_data/colors_non_clamped", "colours of vertices are not read"},
    {"mesh_data/normals_tangents_non_unit",
     "normals are normalised, whatever length an exporter gave them; tangents are not read"},
    {"accessor_data/out_of_range_elements", "min and max are not read"},
    {"accessor_data/invalid_elements_float",
     "no mesh uses the accessor (test_bad_data has one that is used)"},
    {"node/node_weights_invalid", "weights of morph targets are not read"},
    {"image/invalid_image_data", "no texture uses the image"},
    {"image/not_found", "no texture uses the image"},
    {"asset/min_version_valid", "it demands glTF 2.1, this program reads 2.0"},
    {"root/named_objects", "its mesh reads a buffer that has no data"},
    {"root/unused_objects", "its mesh reads a buffer that has no data"},
    {"/unexpected_extension", "extension objects in places where they mean nothing are ignored"},
    {"KHR_lights_punctual/data/light/unknown_type",
     "what kind of light it is must be known to render it"},
    {"EXT_texture_webp/", "not read"},
    {"KHR_materials_anisotropy/", "not read"},
    {"KHR_materials_variants/", "not read"},
    {"KHR_animation_pointer/", "not read"},
    {"KHR_texture_transform/", "not read"},
};

static uint32_t validated, agreed, excepted;
static char disagreements[8192];

static int compare_with_validator(const char *path, const struct stat *status, int type,
                                  struct FTW *ftw) {
    (void)status;
    (void)ftw;
    const char *suffix = strstr(path, ".report.json");
    if (type != FTW_F || !suffix || suffix[12]) return 0;
    char *file = text_of("%.*s", (int)(suffix - path), path);
    json_t *report = json_load_file(path, 0, NULL);
    const bool valid =
        json_integer_value(json_object_get(json_object_get(report, "issues"), "numErrors")) == 0;
    mcv_scene *scene;
    mcv_error error;
    const mcv_result result = load_file(file, &scene, &error);
    ++validated;
    bool except = false;
    for (size_t i = 0; i < sizeof exceptions / sizeof exceptions[0]; ++i)
        except = except || strstr(file, exceptions[i].path);
    if (result != MCV_OK && result != MCV_BAD_INPUT)
        snprintf(disagreements + strlen(disagreements),
                 sizeof disagreements - strlen(disagreements), "\n  %s gave %d", file, result);
    else if ((result == MCV_OK) == valid)
        ++agreed;
    else if (except)
        ++excepted;
    else
        snprintf(disagreements + strlen(disagreements),
                 sizeof disagreements - strlen(disagreements), "\n  %s: %s", file,
                 valid ? error.text : "accepted, though the validator finds errors");
    mcv_scene_free(scene);
    json_decref(report);
    free(file);
    return 0;
}

static void test_validator_files(void **state) {
    (void)state;
    const char *folder = MCV_SOURCE_DIR "/../shared/data/gltf-validator";
    if (access(folder, R_OK) != 0) folder = MCV_SOURCE_DIR "/../../shared/data/gltf-validator";
    validated = agreed = excepted = 0;
    if (nftw(folder, compare_with_validator, 16, FTW_PHYS) != 0 || validated == 0) {
        print_message("%s is absent: skipped\n", folder);
        skip();
    }
    print_message("%u files: %u as the validator says, %u excepted\n", validated, agreed, excepted);
    if (disagreements[0]) fail_msg("accepted or refused unlike the validator:%s", disagreements);
}

/* Names that people give: each is answered with what would be right here. */
static void test_other_names(void **state) {
    static const char format[] = "{\"asset\":{\"version\":\"2.0\"},\"extensionsUsed\":[\"MCVISI_"
                                 "materials\"],\"materials\":[{\"name\":\"part\","
                                 "\"extensions\":{\"MCVISI_materials\":{%s}}}]}";
    static const char *const cases[][2] = {
        {"\"type\":\"dielectric\",\"glass\":\"BK7\"", "did you mean \"N-BK7\"?"},
        {"\"type\":\"dielectric\",\"glass\":\"sf11\"", "did you mean \"N-SF11\"?"},
        {"\"type\":\"dielectric\",\"glass\":\"acrylic\"", "did you mean \"PMMA\"?"},
        {"\"type\":\"conductor\",\"metal\":\"steel\"", "did you mean \"iron\"?"},
        {"\"type\":\"conductor\",\"metal\":\"aluminum\"", "did you mean \"aluminium\"?"},
        {"\"type\":\"steel\"",
         "materials/part/type: \"steel\" is not a type: a metal is a conductor, "
         "{\"type\": \"conductor\", \"metal\": \"iron\""},
        {"\"type\":\"steel\"",
         "metals are aluminium, chromium, copper, gold, iron, nickel, silver, titanium"},
        {"\"type\":\"gold\"", "a metal is a conductor"},
        {"\"type\":\"N-BK7\"", "a body of glass is a dielectric"},
        {"\"type\":\"wood\"", "{\"type\": \"diffuse\", \"reflectance\": 0.5}"},
        {"\"type\":\"sheets\"", "did you mean \"sheet\"?"},
    };
    (void)state;
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        char *text = text_of(format, cases[i][0]);
        must_refuse("other-names.gltf", text, cases[i][1]);
        free(text);
    }
    must_refuse("part.stl", "solid part", "`mcvisi new telecentric");
    must_refuse("part.STEP", "ISO-10303-21;",
                "with a chord tolerance of less than a tenth of a pixel");
    must_refuse("part.obj", "v 0 0 0", "must be a .gltf or .glb file");
}

#define EMITTER_OF(name, type) \
    ASSET "\"extensions\":{\"MCVISI_emitters\":{\"emitters\":[{\"name\":\"" name \
          "\",\"type\":\"" type "\"}]}}}"

/* A value of any length leaves room for its place and for what is wrong. */
static void test_long_values(void **state) {
    (void)state;
    static const struct {
        const char *text, *says;
    } cases[] = {
        {EMITTER_OF("e", "%s"), "emitters/e/type: unknown type \"%s…\": known are parallel"},
        {EMITTER_OF("%s", "laser"), "emitters/%s…/wavelength: is missing"},
        {EMITTER_OF("%s", "%s"), "emitters/%s…/type: unknown type \"%s…\": known are parallel"},
    };
    static const char *const pieces[] = {"x", "ab", "1,2,", "µ", "€", "😀"};
    for (size_t c = 0; c < sizeof cases / sizeof cases[0]; ++c)
        for (size_t p = 0; p < sizeof pieces / sizeof pieces[0]; ++p) {
            const size_t bytes = strlen(pieces[p]), count = 3000 / bytes;
            char value[3001] = "", shown[65] = "";
            for (size_t i = 0; i < count; ++i) memcpy(value + i * bytes, pieces[p], bytes + 1);
            memcpy(shown, value, 64 / bytes * bytes);
            char *text = text_of(cases[c].text, value, value),
                 *says = text_of(cases[c].says, shown, shown);
            must_refuse("bad_input.gltf", text, says);
            free(text);
            free(says);
        }
    /* Many words. */
    char value[3001] = "";
    for (size_t i = 0; i < 1000; ++i) memcpy(value + 3 * i, "µ ", 4);
    char *text = text_of(EMITTER_OF("e", "%s"), value);
    must_refuse("bad_input.gltf", text, "emitters/e/type: unknown type \"µ µ ");
    must_refuse("bad_input.gltf", text, "µ µ \": known are parallel");
    free(text);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_other_names), cmocka_unit_test(test_single_faults),
        cmocka_unit_test(test_bad_data),    cmocka_unit_test(test_bad_elements),
        cmocka_unit_test(test_long_values), cmocka_unit_test(test_bad_emitting_meshes),
        cmocka_unit_test(test_bad_files),   cmocka_unit_test(test_truncated_glb),
        cmocka_unit_test(test_damaged),     cmocka_unit_test(test_validator_files)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
