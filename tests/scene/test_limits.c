/* SPDX-License-Identifier: Apache-2.0 */
/* Memory of a scene is told before it is taken, counted once for each file, and bounded. */
#include "test.h"

#include "scene/memory.h"
#include "scene_files.h"

#include <sys/resource.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#define HEAD "{\"asset\":{\"version\":\"2.0\"},"

static mcv_result load_within(const char *path, uint64_t memory, mcv_scene **scene,
                              mcv_error *error) {
    error->text[0] = '\0';
    return mcv_scene_load_cached(path, (mcv_overrides){NULL, 0}, memory, NULL, scene, error);
}

/* Loads in a child, whose peak of resident memory is its own; 0 where it loads and takes less than
 * `most` bytes more. */
static int load_in_child(const char *path, double most) {
    const pid_t child = fork();
    assert_true(child >= 0);
    if (child == 0) {
        struct rusage before, after;
        mcv_scene *scene;
        mcv_error error;
        getrusage(RUSAGE_SELF, &before);
        if (load_within(path, 0, &scene, &error) != MCV_OK) {
            fprintf(stderr, "%s\n", error.text);
            _exit(1);
        }
        getrusage(RUSAGE_SELF, &after);
#ifdef __SANITIZE_ADDRESS__
        most = INFINITY; /* it takes memory of its own */
#endif
        _exit(1024.0 * (double)(after.ru_maxrss - before.ru_maxrss) < most ? 0 : 2);
    }
    int status;
    assert_int_equal(waitpid(child, &status, 0), child);
    return WIFEXITED(status) ? WEXITSTATUS(status) : 100;
}

/* A limit refuses with the sentence and its name, and within a second. */
static void refuse_within(const char *path, uint64_t memory, const char *says) {
    mcv_scene *scene;
    mcv_error error;
    struct timespec begin, end;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &begin);
    assert_int_equal(load_within(path, memory, &scene, &error), MCV_BAD_INPUT);
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &end);
    if (!strstr(error.text, says) || !strstr(error.text, "by --memory"))
        fail_msg("\"%s\" must say \"%s\"", error.text, says);
    assert_true((double)(end.tv_sec - begin.tv_sec) + 1e-9 * (double)(end.tv_nsec - begin.tv_nsec) <
                1);
}

#define TRIANGLE \
    "\"bufferViews\":[{\"buffer\":0,\"byteOffset\":%llu,\"byteLength\":36}],\"accessors\":[{" \
    "\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\"}]," \
    "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0}}]}],"

/* A file of 2 GB, of which an accessor needs 36 bytes: at its begin, and at its end. */
static void test_sparse_buffer(void **state) {
    (void)state;
    static const float corners[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    const unsigned long long size = 2000000000;
    for (int at_end = 0; at_end < 2; ++at_end) {
        const unsigned long long offset = at_end ? size - 36 : 0;
        char *bin = write_bytes("limits.bin", corners, sizeof corners);
        FILE *file = fopen(bin, "r+b");
        assert_int_equal(fseeko(file, (off_t)offset, SEEK_SET), 0);
        assert_int_equal(fwrite(corners, 1, sizeof corners, file), sizeof corners);
        fclose(file);
        assert_int_equal(truncate(bin, (off_t)size), 0);
        char *text = text_of(HEAD TRIANGLE "\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"mesh\":0}],"
                                           "\"buffers\":[{\"uri\":\"limits.bin\",\"byteLength\":"
                                           "%llu}]}",
                             offset, size);
        char *path = write_bytes("limits.gltf", text, strlen(text));
        assert_int_equal(load_in_child(path, 20e6), 0);
        mcv_scene *scene;
        mcv_error error;
        if (load_within(path, 1000000, &scene, &error) != MCV_OK) fail_msg("%s", error.text);
        assert_memory_equal(scene->meshes[0].positions, corners, sizeof corners);
        mcv_scene_free(scene);
        unlink(bin);
        free(bin);
        free(text);
        free(path);
    }
}

static uint32_t crc_of(const uint8_t *bytes, size_t size) {
    uint32_t crc = ~0u;
    for (size_t i = 0; i < size; ++i) {
        crc ^= bytes[i];
        for (int k = 0; k < 8; ++k) crc = crc >> 1 ^ (crc & 1 ? 0xedb88320u : 0);
    }
    return ~crc;
}

static void put(uint8_t *p, uint32_t value) {
    for (int i = 0; i < 4; ++i) p[i] = (uint8_t)(value >> (24 - 8 * i));
}

static size_t add_chunk(uint8_t *png, size_t at, const char *type, const uint8_t *data,
                        uint32_t size) {
    put(png + at, size);
    memcpy(png + at + 4, type, 4);
    memcpy(png + at + 8, data, size);
    put(png + at + 8 + size, crc_of(png + at + 4, size + 4));
    return at + 12 + size;
}

/* A black PNG of one bit per pixel: stored deflate blocks of at most 65535 bytes. */
static char *write_black(const char *name, uint32_t side) {
    const size_t row = 1 + (side + 7) / 8, raw = row * side;
    uint8_t *png = calloc(1, raw + raw / 65535 * 5 + 200),
            *data = calloc(1, raw + raw / 65535 * 5 + 20);
    static const uint8_t signature[8] = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
    uint8_t head[13] = {0};
    put(head, side);
    put(head + 4, side);
    head[8] = 1;
    memcpy(png, signature, 8);
    size_t at = add_chunk(png, 8, "IHDR", head, 13), size = 2;
    data[0] = 0x78;
    data[1] = 0x01;
    for (size_t left = raw; left;) {
        const size_t block = left < 65535 ? left : 65535;
        left -= block;
        data[size] = left == 0;
        data[size + 1] = (uint8_t)(block & 0xff);
        data[size + 2] = (uint8_t)(block >> 8);
        data[size + 3] = (uint8_t)~data[size + 1];
        data[size + 4] = (uint8_t)~data[size + 2];
        size += 5 + block;
    }
    put(data + size, (uint32_t)(raw % 65521) << 16 | 1); /* Adler-32 of zeros */
    at = add_chunk(png, at, "IDAT", data, (uint32_t)size + 4);
    at = add_chunk(png, at, "IEND", head, 0);
    char *path = write_bytes(name, png, at);
    free(png);
    free(data);
    return path;
}

/* Twelve images of one file are one picture: eight bytes of each pixel, once. */
static void test_images_of_one_file(void **state) {
    (void)state;
    enum { SIDE = 2000, COUNT = 12 };
    char *png = write_black("limits.png", SIDE), *images = strdup(""), *textures = strdup(""),
         *materials = strdup("");
    for (int i = 0; i < COUNT; ++i) {
        const char *comma = i ? "," : "";
        char *parts[] = {images, textures, materials};
        images = text_of("%s%s{\"uri\":\"%slimits.png\"}", parts[0], comma, i % 2 ? "./" : "");
        textures = text_of("%s%s{\"source\":%d,\"sampler\":%d}", parts[1], comma, i, i % 2);
        materials = text_of("%s%s{\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":%d}}}",
                            parts[2], comma, i);
        for (int k = 0; k < 3; ++k) free(parts[k]);
    }
    char *text = text_of(HEAD "\"samplers\":[{\"wrapS\":33071},{\"wrapS\":33648}],\"images\":[%s],"
                              "\"textures\":[%s],\"materials\":[%s]}",
                         images, textures, materials);
    char *path = write_bytes("limits_images.gltf", text, strlen(text));
    mcv_scene *scene;
    mcv_error error;
    if (load_within(path, 0, &scene, &error) != MCV_OK) fail_msg("%s", error.text);
    assert_int_equal(scene->memory.images, 8 * SIDE * SIDE);
    assert_int_equal(scene->texture_count, COUNT);
    for (uint32_t i = 0; i < COUNT; ++i) {
        assert_ptr_equal(scene->textures[i].rgba, scene->textures[0].rgba);
        assert_int_equal(scene->textures[i].wrap_s, i % 2 ? 33648 : 33071);
    }
    mcv_scene_free(scene);
    /* Decoded, copied, and the decoder's own: 12 bytes of each pixel, and its file twice. */
    assert_int_equal(load_in_child(path, 14.0 * SIDE * SIDE), 0);
    refuse_within(path, 8 * SIDE * SIDE, "images/0: with it the scene takes 32.");
    unlink(png);
    free(png);
    free(images);
    free(textures);
    free(materials);
    free(text);
    free(path);
}

/* A mesh that many nodes place counts for each; vertices without bytes in a file count too. */
static void test_geometry(void **state) {
    (void)state;
    enum { NODES = 1000, VERTICES = 300000 };
    char *nodes = strdup("{\"mesh\":0}"), *list = strdup("0");
    for (int i = 1; i < NODES; ++i) {
        char *old[] = {nodes, list};
        nodes = text_of("%s,{\"mesh\":0}", old[0]);
        list = text_of("%s,%d", old[1], i);
        free(old[0]);
        free(old[1]);
    }
    char *text = text_of(HEAD "\"accessors\":[{\"componentType\":5126,\"count\":%d,\"type\":"
                              "\"VEC3\"}],\"meshes\":[{\"primitives\":[{\"attributes\":{"
                              "\"POSITION\":0}}]}],\"scenes\":[{\"nodes\":[%s]}],\"nodes\":[%s]}",
                         VERTICES, list, nodes);
    char *path = write_bytes("limits_nodes.gltf", text, strlen(text));
    refuse_within(path, 1000000, "meshes/0: with it the scene takes");
    refuse_within(path, 1000000000, "nodes/");
    free(nodes);
    free(list);
    free(text);
    free(path);
}

/* A tree of JSON takes many times its text. */
static void test_json(void **state) {
    (void)state;
    enum { OBJECTS = 500000 };
    char *text = malloc(3 * OBJECTS + 200), *end = text;
    assert_non_null(text);
    end += sprintf(end, HEAD "\"extras\":[{}");
    for (int i = 1; i < OBJECTS; ++i) end += sprintf(end, ",{}");
    sprintf(end, "]}");
    char *path = write_bytes("limits_json.gltf", text, strlen(text));
    refuse_within(path, 100000000, "with it the scene takes");
    mcv_scene *scene;
    mcv_error error;
    if (load_within(path, 0, &scene, &error) != MCV_OK) fail_msg("%s", error.text);
    assert_int_equal(load_in_child(path, (double)scene->memory.files), 0); /* the bound holds */
    mcv_scene_free(scene);
    free(text);
    free(path);
}

/* Loads in a child that may take `left` bytes of addresses more; its result, 100 after a crash. */
static int load_with_addresses(const char *path, size_t left) {
    const pid_t child = fork();
    assert_true(child >= 0);
    if (child == 0) {
        char line[128] = "";
        mcv_scene *scene;
        mcv_error error;
        FILE *file = fopen("/proc/self/statm", "r");
        if (!file || !fgets(line, sizeof line, file)) _exit(101);
        fclose(file);
        const rlim_t pages = strtoul(line, NULL, 10);
        const rlim_t most = pages * (rlim_t)sysconf(_SC_PAGESIZE) + left;
        const struct rlimit limit = {most, most};
        if (setrlimit(RLIMIT_AS, &limit) != 0) _exit(102);
        const mcv_result result = load_within(path, 0, &scene, &error);
        _exit(result == MCV_OK || strstr(error.text, "no memory") ? (int)result : 103);
    }
    int status;
    assert_int_equal(waitpid(child, &status, 0), child);
    return WIFEXITED(status) ? WEXITSTATUS(status) : 100;
}

/* Where addresses are short, jansson's parser would read beyond a string that has no room. */
static void test_long_string(void **state) {
    (void)state;
#ifdef __SANITIZE_ADDRESS__
    skip(); /* it takes addresses of its own */
#endif
    enum { LENGTH = 1 << 21, STEP = LENGTH / 4 };
    char *text = malloc(LENGTH + 200);
    assert_non_null(text);
    const int size = sprintf(text, HEAD "\"extras\":\"%0*d\"}", LENGTH, 0);
    char *path = write_bytes("limits_string.gltf", text, (size_t)size);
    int loaded = 0, refused = 0;
    for (size_t left = STEP; left <= 10 * LENGTH; left += STEP) {
        const int code = load_with_addresses(path, left);
        if (code != MCV_OK && code != MCV_FAILED)
            fail_msg("with %zu kB more the load ends with %d", left / 1000, code);
        loaded += code == MCV_OK;
        refused += code == MCV_FAILED;
    }
    assert_true(refused > 0 && loaded > 0);
    free(text);
    free(path);
}

/* A ball that a defect makes a mesh: 8 · 182² triangles, told before they are made. */
static void test_exact_surface_with_a_defect(void **state) {
    (void)state;
    static const char text[] =
        HEAD "\"scene\":0,\"scenes\":[{\"nodes\":[0]}],\"extensions\":{\"MCVISI_surfaces\":"
             "{\"surfaces\":[{\"type\":\"sphere\",\"radius\":\"2mm\",\"material\":\"grey\"}]},"
             "\"MCVISI_defects\":{\"defects\":[{\"name\":\"dent\",\"type\":\"dent\",\"node\":"
             "\"ball\",\"at\":[0,0,0.002],\"size\":\"0.5mm\",\"depth\":\"10um\"}]}},"
             "\"materials\":[{\"name\":\"grey\",\"extensions\":{\"MCVISI_materials\":{\"type\":"
             "\"diffuse\",\"reflectance\":0.5}}}],\"nodes\":[{\"name\":\"ball\",\"extensions\":"
             "{\"MCVISI_surfaces\":{\"surface\":0}}}]}";
    char *path = write_bytes("limits_ball.gltf", text, sizeof text - 1);
    refuse_within(path, 80000000, "defects/dent/node: with it the scene takes");
    free(path);
}

/* Two nodes of one plate, 2 m wide, each with a scratch, 20 mm long; its mesh is copied for both.
 */
static char *write_scratches(const char *width) {
    static const float corners[18] = {-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, -1, 0, 1, 1, 0, -1, 1, 0};
    static const char scratch[] = "{\"name\":\"%s\",\"type\":\"scratch\",\"node\":\"%s\","
                                  "\"at\":[0,0,0],\"size\":\"%s\",\"length\":\"20mm\",\"depth\":"
                                  "\"1um\"}";
    char *bin = write_bytes("limits_plate.bin", corners, sizeof corners),
         *first = text_of(scratch, "scar", "a", width),
         *second = text_of(scratch, "nick", "b", width);
    char *text = text_of(
        HEAD
        "\"scene\":0,\"scenes\":[{\"nodes\":[0,1]}],\"nodes\":[{\"name\":\"a\",\"mesh\":0},"
        "{\"name\":\"b\",\"mesh\":0,\"translation\":[0,0,1]}],\"meshes\":[{\"primitives\":[{"
        "\"attributes\":{\"POSITION\":0}}]}],\"buffers\":[{\"uri\":\"limits_plate.bin\","
        "\"byteLength\":72}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":72}],\"accessors\":[{"
        "\"bufferView\":0,\"componentType\":5126,\"count\":6,\"type\":\"VEC3\"}],"
        "\"extensions\":{\"MCVISI_defects\":{\"defects\":[%s,%s]}}}",
        first, second);
    char *path = write_bytes("limits_scratch.gltf", text, strlen(text));
    free(bin);
    free(first);
    free(second);
    free(text);
    return path;
}

/* Triangles that a defect adds are counted, and refused while they grow: a scratch of 1 µm has more
 * than four million of them, which took 700 MB whatever the limit said. */
static void test_triangles_of_a_defect(void **state) {
    (void)state;
    mcv_scene *scene;
    mcv_error error;
    char *path = write_scratches("1um");
    refuse_within(path, 50000000, "defects/scar: would take more than");
    free(path);
    path = write_scratches("100um");
    if (load_within(path, 0, &scene, &error) != MCV_OK) fail_msg("%s", error.text);
    const mcv_memory taken = scene->memory;
    if (taken.geometry < (uint64_t)MCV_TRIANGLE_BYTES * scene->triangle_count)
        fail_msg("%u triangles are counted as %llu bytes", scene->triangle_count,
                 (unsigned long long)taken.geometry);
    mcv_scene_free(scene);
    /* While it is made a facet takes 632 bytes, and 368 afterwards. So each scratch needs 0.86 of
     * what both take, and the second one 1.36 with the first: without that it has no room. */
    refuse_within(path, taken.files + taken.geometry * 12 / 10, "defects/nick: would take more");
    if (load_within(path, taken.files + taken.geometry * 15 / 10, &scene, &error) != MCV_OK)
        fail_msg("%s", error.text);
    mcv_scene_free(scene);
    free(path);
}

/* A file of `entries` entries with a thousand defects each, in or on a glass ball. */
static char *write_many(const char *type, int entries) {
    char *list = malloc(200 * (size_t)entries), *end = list;
    assert_non_null(list);
    for (int i = 0; i < entries; ++i)
        end += sprintf(end,
                       "%s{\"name\":\"d%d\",\"type\":\"%s\",\"node\":\"ball\",\"size\":1e-6,"
                       "\"count\":1000}",
                       i ? "," : "", i, type);
    char *text = text_of(
        HEAD "\"scene\":0,\"scenes\":[{\"nodes\":[0]}],\"extensions\":{\"MCVISI_surfaces\":"
             "{\"surfaces\":[{\"type\":\"sphere\",\"radius\":\"10mm\",\"material\":\"glass\"}]},"
             "\"MCVISI_defects\":{\"defects\":[%s]}},\"materials\":[{\"name\":\"glass\","
             "\"extensions\":{\"MCVISI_materials\":{\"type\":\"dielectric\"}}}],\"nodes\":[{"
             "\"name\":\"ball\",\"extensions\":{\"MCVISI_surfaces\":{\"surface\":0}}}]}",
        list);
    char *path = write_bytes("limits_many.gltf", text, strlen(text));
    free(list);
    free(text);
    return path;
}

/* Counts of defects are not expanded beyond the bodies that a scene may have, nor beyond its
 * memory: a million bubbles took 200 MB before they were counted. */
static void test_counts_of_defects(void **state) {
    (void)state;
    mcv_scene *scene;
    mcv_error error;
    char *path = write_many("bubble", 300);
    assert_int_equal(load_within(path, 0, &scene, &error), MCV_BAD_INPUT);
    if (!strstr(error.text, "defects/d1: more than 1024 bodies")) fail_msg("%s", error.text);
    refuse_within(path, 700000, "defects/d0: with it the scene takes");
    free(path);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_counts_of_defects),
                                       cmocka_unit_test(test_triangles_of_a_defect),
                                       cmocka_unit_test(test_exact_surface_with_a_defect),
                                       cmocka_unit_test(test_sparse_buffer),
                                       cmocka_unit_test(test_images_of_one_file),
                                       cmocka_unit_test(test_geometry),
                                       cmocka_unit_test(test_json),
                                       cmocka_unit_test(test_long_string)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
