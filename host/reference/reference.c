/* SPDX-License-Identifier: Apache-2.0 */
#include "reference/reference.h"

#include "core/basics.h"
#include "reference/rounds.h"
#include "reference/world.h"
#include "scene/sensors.h"
#include "scene/spectra.h"

static mcv_result render(const mcv_scene *scene, uint32_t sensor, const mcv_render_options *options,
                         ref_manner how, uint32_t stride, mcv_film *film, mcv_render_stats *stats,
                         mcv_error *error) {
    const double start = mcv_seconds();
    *film = (mcv_film){0};
    *stats = (mcv_render_stats){.device = "reference (double precision)"};
    MCV_TRY(mcv_render_check_options(scene, sensor, options, false, error));
    ref_world world;
    ref_pass r = {.world = &world,
                  .sensor = &scene->sensors[sensor],
                  .options = options,
                  .film = film,
                  .stride = stride,
                  .start = start};
    mcv_sensor_film_size(r.sensor, &r.size[0], &r.size[1]);
    const uint32_t width = (r.size[0] + stride - 1) / stride,
                   height = (r.size[1] + stride - 1) / stride;
    MCV_TRY(
        mcv_film_new(film, width, height, mcv_scene_channels(scene), options->replicates, error));

    mcv_result result = ref_world_new(scene, sensor, options->depth, how, &world, error);
    if (result == MCV_OK) {
        stats->seconds_build = mcv_seconds() - start;
        result = ref_render_rounds(&r, film, stats, error);
    }
    if (result != MCV_OK) mcv_film_free(film);
    ref_world_free(&world);
    return result;
}

mcv_result ref_render(const mcv_scene *scene, uint32_t sensor, const mcv_render_options *options,
                      bool sample_emitters, mcv_film *film, mcv_render_stats *stats,
                      mcv_error *error) {
    return render(scene, sensor, options, (ref_manner){sample_emitters, false}, 1, film, stats,
                  error);
}

mcv_result mcv_reference_draft(const mcv_scene *scene, uint32_t sensor,
                               const mcv_render_options *options, uint32_t stride, mcv_film *film,
                               mcv_error *error) {
    mcv_render_stats stats;
    return render(scene, sensor, options, (ref_manner){true, true}, stride, film, &stats, error);
}

mcv_result mcv_reference_render(const mcv_scene *scene, uint32_t sensor,
                                const mcv_render_options *options, mcv_film *film,
                                mcv_render_stats *stats, mcv_error *error) {
    MCV_TRY(ref_render(scene, sensor, options, true, film, stats, error));
    const mcv_result result = mcv_render_check_finite(scene, sensor, stats, error);
    if (result != MCV_OK) mcv_film_free(film);
    return result;
}
