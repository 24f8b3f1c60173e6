/* SPDX-License-Identifier: Apache-2.0 */
/*
 * One thread and two give the same bits. PoCL reads its number of threads once per process, so each
 * render has a process of its own; on other platforms both are the same and the test still holds.
 */
#include "scene_builder.h"

#include <sys/wait.h>
#include <unistd.h>

#include "render/render.h"

enum { PIXELS = 24, REPLICATES = 4, VALUES = PIXELS * PIXELS * REPLICATES };

static mcv_result render_sums(double *sums) {
    mcv_scene *scene = mcv_scene_new("threads");
    mcv_render_options options = mcv_render_defaults();
    mcv_render_stats stats;
    mcv_film film;
    add_sphere(scene, 0.3, 16, add_glass(scene, 1.5, 1, 0), mcv_transform_identity());
    add_rectangle(scene, 2, 2, add_diffuse(scene, 0.6), looking_up_z(0, 0, -0.5));
    add_emitter(scene, MCV_EMITTER_AREA,
                add_rectangle(scene, 0.3, 0.3, add_absorber(scene), looking_down_z(0.4, 0.4, 1)), 3,
                0);
    add_pinhole(scene, PIXELS, 0.9, looking_down_z(0.05, 0, 1.5));
    options.last = 64;
    options.replicates = REPLICATES;
    const mcv_result result = mcv_render(scene, 0, &options, &film, &stats, &builder_error);
    if (result == MCV_OK) memcpy(sums, film.sums, VALUES * sizeof(double));
    mcv_film_free(&film);
    mcv_scene_free(scene);
    return result;
}

/* Renders in a child with the given number of threads. */
static void render_with(const char *threads, double *sums) {
    int ends[2];
    assert_int_equal(pipe(ends), 0);
    const pid_t child = fork();
    assert_true(child >= 0);
    if (child == 0) {
        setenv("POCL_MAX_PTHREAD_COUNT", threads, 1);
        const mcv_result result = render_sums(sums);
        const char *bytes = (const char *)sums;
        size_t left = result == MCV_OK ? VALUES * sizeof(double) : 0;
        while (left > 0) {
            const ssize_t written = write(ends[1], bytes, left);
            if (written <= 0) break;
            bytes += written;
            left -= (size_t)written;
        }
        _exit(result == MCV_OK && left == 0 ? 0 : 1);
    }
    close(ends[1]);
    size_t got = 0;
    ssize_t more;
    while ((more = read(ends[0], (char *)sums + got, VALUES * sizeof(double) - got)) > 0)
        got += (size_t)more;
    close(ends[0]);
    int status;
    assert_int_equal(waitpid(child, &status, 0), child);
    assert_true(WIFEXITED(status) && WEXITSTATUS(status) == 0);
    assert_int_equal(got, VALUES * sizeof(double));
}

static void test_threads(void **state) {
    static double one[VALUES];
    static double two[VALUES];
    double total = 0;
    (void)state;
    render_with("1", one);
    render_with("2", two);
    for (size_t i = 0; i < VALUES; ++i) {
        total += one[i];
        if (memcmp(&one[i], &two[i], sizeof(double)) != 0)
            fail_msg("sum %zu: %.17g with one thread, %.17g with two", i, one[i], two[i]);
    }
    assert_true(total > 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_threads)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
