/* SPDX-License-Identifier: Apache-2.0 */
/* ctest: label slow */
/* Loading two million triangles takes at most four times the file and 300 bytes per triangle, from
 * a GLB and from a data: URI. */
#include "test.h"

#include "scene_files.h"

#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

enum { SIDE = 1000, VERTICES = (SIDE + 1) * (SIDE + 1), TRIANGLES = 2 * SIDE * SIDE };

/* A wavy terrain: positions, normals (not unit), 32-bit indices. */
static unsigned char *terrain(size_t *size) {
    *size = (size_t)VERTICES * 24 + (size_t)TRIANGLES * 12;
    unsigned char *bytes = malloc(*size);
    if (!bytes) abort();
    float *positions = (float *)(void *)bytes, *normals = positions + 3 * (size_t)VERTICES;
    uint32_t *indices = (uint32_t *)(void *)(normals + 3 * (size_t)VERTICES);
    for (uint32_t row = 0, v = 0; row <= SIDE; ++row)
        for (uint32_t column = 0; column <= SIDE; ++column, ++v) {
            const float height = 0.01f * (float)((row * column) % 17);
            memcpy(positions + 3 * (size_t)v, (float[]){(float)column, height, (float)row}, 12);
            memcpy(normals + 3 * (size_t)v, (float[]){height, 2, 0}, 12);
        }
    for (uint32_t row = 0; row < SIDE; ++row)
        for (uint32_t column = 0; column < SIDE; ++column) {
            const uint32_t v = row * (SIDE + 1) + column;
            const uint32_t quad[6] = {v, v + SIDE + 1, v + 1, v + 1, v + SIDE + 1, v + SIDE + 2};
            memcpy(indices, quad, sizeof quad);
            indices += 6;
        }
    return bytes;
}

static char *describe(size_t size, const char *uri) {
    return text_of(
        "{\"asset\":{\"version\":\"2.0\"},\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"mesh\":0}],"
        "\"buffers\":[{\"byteLength\":%zu%s%s%s}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":%"
        "zu},"
        "{\"buffer\":0,\"byteOffset\":%zu,\"byteLength\":%zu},{\"buffer\":0,\"byteOffset\":%zu,"
        "\"byteLength\":%zu}],"
        "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":%d,\"type\":\"VEC3\"},"
        "{\"bufferView\":1,\"componentType\":5126,\"count\":%d,\"type\":\"VEC3\"},"
        "{\"bufferView\":2,\"componentType\":5125,\"count\":%d,\"type\":\"SCALAR\"}],"
        "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0,\"NORMAL\":1},\"indices\":2}]"
        "}]}",
        size, uri ? ",\"uri\":\"data:application/octet-stream;base64," : "", uri ? uri : "",
        uri ? "\"" : "", (size_t)VERTICES * 12, (size_t)VERTICES * 12, (size_t)VERTICES * 12,
        (size_t)VERTICES * 24, (size_t)TRIANGLES * 12, VERTICES, VERTICES, 3 * TRIANGLES);
}

static long resident_peak(void) {
    struct rusage usage;
    getrusage(RUSAGE_SELF, &usage);
    return usage.ru_maxrss; /* KiB */
}

/* In a child, whose peak is its own. 0 where it loads all within the bound. */
static int load_in_child(const char *path) {
    struct stat status;
    mcv_scene *scene;
    mcv_error error;
    struct timespec begin, end;
    const long before = resident_peak();
    clock_gettime(CLOCK_MONOTONIC, &begin);
    if (stat(path, &status) != 0 || load_file(path, &scene, &error) != MCV_OK) return 1;
    clock_gettime(CLOCK_MONOTONIC, &end);
    const double peak = 1024.0 * (double)(resident_peak() - before);
    const double bound = 4 * (double)status.st_size + 300.0 * TRIANGLES;
    fprintf(stderr,
            "%s: %.1f MB file, peak %.1f MB (%.2f x file, %.0f B per triangle), bound %.1f MB, "
            "%.2f s\n",
            path, (double)status.st_size / 1e6, peak / 1e6, peak / (double)status.st_size,
            peak / TRIANGLES, bound / 1e6,
            (double)(end.tv_sec - begin.tv_sec) + 1e-9 * (double)(end.tv_nsec - begin.tv_nsec));
    return scene->triangle_count != TRIANGLES ? 2 : peak <= bound ? 0 : 3;
}

static void must_fit(const char *path) {
    const pid_t child = fork();
    assert_true(child >= 0);
    if (child == 0) _exit(load_in_child(path));
    int status;
    assert_int_equal(waitpid(child, &status, 0), child);
    if (!WIFEXITED(status) || WEXITSTATUS(status) != 0)
        fail_msg("%s: status %d (1: does not load, 2: triangles are missing, 3: more memory than "
                 "the bound)",
                 path, status);
}

static void test_glb(void **state) {
    (void)state;
    size_t size, glb_size;
    unsigned char *bytes = terrain(&size);
    char *json = describe(size, NULL);
    unsigned char *glb = glb_of(json, bytes, size, &glb_size);
    char *path = write_bytes("memory.glb", glb, glb_size);
    free(glb);
    free(json);
    free(bytes);
    must_fit(path);
    unlink(path);
    free(path);
}

static void test_data_uri(void **state) {
    (void)state;
    size_t size;
    unsigned char *bytes = terrain(&size);
    char *uri = base64(bytes, size), *json = describe(size, uri);
    char *path = write_bytes("memory.gltf", json, strlen(json));
    free(json);
    free(uri);
    free(bytes);
    must_fit(path);
    unlink(path);
    free(path);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_glb), cmocka_unit_test(test_data_uri)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
