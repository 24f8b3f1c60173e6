/* SPDX-License-Identifier: Apache-2.0 */
/* Defects look at the triangles near them: how processor time grows with meshes and defects. */
#include "test.h"

#include "loader/load.h"
#include "scene_files.h"

#include <time.h>
#include <unistd.h>

#define HEAD \
    "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0]}]," \
    "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"indices\":1}]}],"

/* `instances` of a strip of `triangles` triangles, 10 mm wide, whose facets of 0.1 mm rise by
 * `rise` in turn, and `count` dents by chance. */
static char *write_strips(uint32_t triangles, uint32_t instances, float rise, uint32_t count,
                          const char *size) {
    const uint32_t pairs = triangles / 2;
    float *positions = malloc(6 * sizeof *positions * (pairs + 1));
    uint32_t *indices = malloc(6 * sizeof *indices * pairs);
    char *nodes = malloc(64 * (instances + 1)), *list = malloc(16 * (instances + 1)), *end = nodes,
         *next = list;
    assert_true(positions && indices && nodes && list);
    for (uint32_t i = 0; i <= pairs; ++i) {
        const float corners[6] = {1e-4f * (float)i, 0,     i % 2 ? rise : 0,
                                  1e-4f * (float)i, 1e-2f, i % 2 ? rise : 0};
        memcpy(positions + 6 * i, corners, sizeof corners);
    }
    for (uint32_t i = 0; i < pairs; ++i) {
        const uint32_t a = 2 * i, two[6] = {a, a + 2, a + 1, a + 1, a + 2, a + 3};
        memcpy(indices + 6 * i, two, sizeof two);
    }
    for (uint32_t i = 0; i < instances; ++i) {
        end += sprintf(end, ",{\"mesh\":0,\"translation\":[0,%g,0]}", 0.02 * i);
        next += sprintf(next, "%s%u", i ? "," : "", i + 1);
    }
    char *bin = write_bytes("times_strip.bin", positions, 6 * sizeof *positions * (pairs + 1)),
         *more = write_bytes("times_indices.bin", indices, 6 * sizeof *indices * pairs);
    char *text = text_of(
        HEAD "\"nodes\":[{\"name\":\"part\",\"children\":[%s]}%s],\"buffers\":[{\"uri\":"
             "\"times_strip.bin\",\"byteLength\":%u},{\"uri\":\"times_indices.bin\","
             "\"byteLength\":%u}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":%u},{\"buffer\":1,"
             "\"byteLength\":%u}],\"accessors\":[{\"bufferView\":0,\"componentType\":5126,"
             "\"count\":%u,\"type\":\"VEC3\"},{\"bufferView\":1,\"componentType\":5125,\"count\":"
             "%u,\"type\":\"SCALAR\"}],\"extensions\":{\"MCVISI_defects\":{\"defects\":[{\"name\":"
             "\"d\",\"type\":\"dent\",\"node\":\"part\",\"size\":\"%s\",\"count\":%u}]}}}",
        list, nodes, 24 * (pairs + 1), 24 * pairs, 24 * (pairs + 1), 24 * pairs, 2 * (pairs + 1),
        6 * pairs, size, count);
    char *path = write_bytes("times.gltf", text, strlen(text));
    void *const all[] = {positions, indices, nodes, list, bin, more, text};
    for (size_t i = 0; i < sizeof all / sizeof *all; ++i) free(all[i]);
    return path;
}

/* Seconds of processor time until the file is loaded, or refused with this sentence. */
static double seconds_for(char *path, const char *says) {
    mcv_scene *scene = NULL;
    mcv_error error = {""};
    struct timespec begin, end;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &begin);
    const mcv_result result =
        mcv_scene_load_cached(path, (mcv_overrides){NULL, 0}, 0, NULL, &scene, &error);
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &end);
    if ((result == MCV_OK) != !says || (says && !strstr(error.text, says)))
        fail_msg("\"%s\" must say \"%s\"", error.text, says ? says : "");
    if (result == MCV_OK) mcv_scene_free(scene);
    free(path);
    return (double)(end.tv_sec - begin.tv_sec) + 1e-9 * (double)(end.tv_nsec - begin.tv_nsec);
}

/* A dent that fits nowhere is tried in a thousand places, of which each looks at the strips around
 * it. Eight times as many strips took eight times as long. Half way between, as times vary. */
static void test_tries_look_at_what_is_near(void **state) {
    (void)state;
    const double few = seconds_for(write_strips(200, 50, 1e-4f, 1, "1mm"), "(in 1000 places"),
                 many = seconds_for(write_strips(200, 400, 1e-4f, 1, "1mm"), "(in 1000 places");
    print_message("50 strips: %.2g s, 400: %.2g s\n", few, many);
    if (many > 4.5 * few) fail_msg("50 strips take %g s, 400 %g s", few, many);
}

/* A mesh is changed where a defect lies, and is not made anew for each: eight times as many dents
 * on one plate take eight times as long. When each copied all that earlier ones had made, they took
 * 25 times as long. */
static void test_dents_on_one_plate(void **state) {
    (void)state;
    const double few = seconds_for(write_strips(2, 1, 0, 20, "10um"), NULL),
                 many = seconds_for(write_strips(2, 1, 0, 160, "10um"), NULL);
    print_message("20 dents: %.2g s, 160: %.2g s\n", few, many);
    if (many > 13 * few) fail_msg("20 dents take %g s, 160 %g s", few, many);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_tries_look_at_what_is_near),
                                       cmocka_unit_test(test_dents_on_one_plate)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
