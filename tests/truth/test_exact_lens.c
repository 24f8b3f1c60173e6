/* SPDX-License-Identifier: Apache-2.0 */
/* The report's lens as exact surfaces and as the fine mesh: the same image, in a hundredth of the
 * memory. */
#include "scene_builder.h"

#include "analysis/compare.h"
#include "mcvisi/surfaces/solid.h"
#include "render/render.h"
#include "loader/load.h"

#include <time.h>

static mcv_scene *load(const char *name) {
    const char *overrides[] = {"sensors/camera/spatialResolution=[20, 15]",
                               "sensors/camera/pixelSize=32um"};
    char path[4096];
    mcv_scene *scene;
    snprintf(path, sizeof path, "%s/scenes/%s", MCV_SOURCE_DIR, name);
    BUILD(mcv_scene_load(path, (mcv_overrides){overrides, 2}, &scene, &builder_error));
    return scene;
}

static mcv_film render(const mcv_scene *scene, uint32_t seed, double *rate) {
    mcv_render_options options = mcv_render_defaults();
    mcv_render_stats stats;
    mcv_film film;
    struct timespec before, after;
    options.replicates = 16;
    options.last = 16;
    options.seed = seed;
    clock_gettime(CLOCK_MONOTONIC, &before);
    BUILD(mcv_render(scene, 0, &options, &film, &stats, &builder_error));
    clock_gettime(CLOCK_MONOTONIC, &after);
    *rate = (double)stats.paths / ((double)(after.tv_sec - before.tv_sec) +
                                   1e-9 * (double)(after.tv_nsec - before.tv_nsec));
    assert_int_equal(stats.unmatched, 0);
    return film;
}

/* And a lens that is stronger by a tenth is told from it: the comparison has the power that it
 * takes. */
static void same_image(void **state) {
    (void)state;
    mcv_scene *mesh = load("report-clean.glb"), *exact = load("report-exact.gltf"),
              *other = load("report-exact.gltf");
    mcv_comparison same, different;
    double rates[3];
    for (int k = 0; k < 2; ++k) other->solids[0].caps[k].curvature *= 1.1;
    mcv_film of_mesh = render(mesh, 1, rates), of_exact = render(exact, 2, rates + 1),
             of_other = render(other, 3, rates + 2);
    BUILD(mcv_compare_films(&of_mesh, &of_exact, &same, &builder_error));
    BUILD(mcv_compare_films(&of_mesh, &of_other, &different, &builder_error));
    print_message("  mesh and exact: %s\n  a tenth stronger: %s\n", same.reason, different.reason);
    print_message("  %.3g and %.3g paths per second, with what loading and compiling take\n",
                  rates[0], rates[1]);
    if (same.different) fail_msg("%s", same.reason);
    assert_true(different.different);

    /* Of the mesh, that of the lens and its mount, what a renderer needs at least, without an
     * acceleration structure. */
    uint32_t vertices = 0;
    for (uint32_t i = 0; i < mesh->mesh_count; ++i) vertices += mesh->meshes[i].vertex_count;
    const size_t bytes[2] = {24 * (size_t)vertices + 12 * (size_t)mesh->triangle_count,
                             exact->solid_count * sizeof(mcv_device_solid)};
    print_message("  %zu bytes and %zu: a %zuth\n", bytes[0], bytes[1], bytes[0] / bytes[1]);
    assert_true(bytes[0] > 100 * bytes[1]);
    mcv_film_free(&of_mesh);
    mcv_film_free(&of_exact);
    mcv_film_free(&of_other);
    mcv_scene_free(mesh);
    mcv_scene_free(exact);
    mcv_scene_free(other);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(same_image)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
