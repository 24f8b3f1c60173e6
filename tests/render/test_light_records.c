/* SPDX-License-Identifier: Apache-2.0 */
/* Records of what light paths bring. */
#include "records.h"

/*
 * Light paths are recorded instead of splatted. The image without records has the same light paths;
 * each splat is rounded at random by less than one unit.
 */
static void test_light_paths_are_recorded(void **state) {
    (void)state;
    sums s = {0};
    mcv_scene *scene = load("caustic.gltf");
    mcv_render_options options = mcv_render_defaults();
    mcv_render_stats stats;
    mcv_film whole, film = record(scene, MCV_SCHEDULE_TILE, 0, &s);
    double of_film = 0, of_records = 0, of_camera = 0;
    options.last = SAMPLES;
    options.depth = DEPTH;
    BUILD(mcv_render(scene, 0, &options, &whole, &stats, &builder_error));
    assert_non_null(strstr(stats.features, "light-tracing"));
    for (size_t i = 0; i < mcv_film_values(&whole); ++i) {
        of_film += whole.sums[i];
        of_camera += film.sums[i];
        of_records += s.cells[i];
    }
    const double rounding =
        (2 * DEPTH + 5) * 0x1p-24 * of_film + (double)s.count * whole.splat_value;
    print_message("caustic: %.9g of the film, %.9g of %zu records, %.3g without light paths\n",
                  of_film, of_records, s.count, of_camera);
    if (!(fabs(of_records - of_film) <= rounding))
        fail_msg("records %.9g, film %.9g, may differ by %.2g", of_records, of_film, rounding);
    if (!(of_camera < of_film - rounding)) fail_msg("light paths bring nothing");
    mcv_film_free(&film);
    mcv_film_free(&whole);
    free(s.cells);
    mcv_scene_free(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_light_paths_are_recorded)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
