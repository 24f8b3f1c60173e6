/* SPDX-License-Identifier: Apache-2.0 */
#include "reference/explain.h"

#include "reference/trail.h"
#include "reference/world.h"
#include "scene/sensors.h"

static void explain_sample(const ref_world *world, const mcv_sensor *sensor,
                           const mcv_render_options *options, const uint32_t pixel[2],
                           uint32_t width, uint64_t sample, ref_trail *trail) {
    ref_tally tally = {0};
    double place[4], value[3];
    ref_random random = ref_random_begin(options->seed, (uint64_t)pixel[1] * width + pixel[0],
                                         trail->contribution.replicate, sample);
    for (int i = 0; i < 4; ++i) place[i] = ref_random_unit(&random);
    const ref_sensor_ray ray =
        ref_sensor_ray_draw(world->scene, sensor, pixel[0], pixel[1], place, &random);
    ref_path_value(world, &ray, &random, &tally, trail, value);
}

mcv_result mcv_reference_explain(const mcv_scene *scene, uint32_t sensor,
                                 const mcv_render_options *options, const uint32_t pixel[2],
                                 uint64_t samples, mcv_contribution_told *told, void *user,
                                 mcv_error *error) {
    ref_world world;
    uint32_t width, height;
    MCV_TRY(mcv_render_check_options(scene, sensor, options, false, error));
    mcv_sensor_film_size(&scene->sensors[sensor], &width, &height);
    if (pixel[0] >= width || pixel[1] >= height)
        return mcv_fail(error, MCV_USAGE, "pixel %u,%u: the image has %u x %u, from 0,0 to %u,%u",
                        pixel[0], pixel[1], width, height, width - 1, height - 1);
    const mcv_result result = ref_world_new(scene, sensor, options->depth,
                                            (ref_manner){.sample_emitters = true}, &world, error);
    ref_trail trail = {.told = told, .user = user};
    for (uint32_t r = 0; result == MCV_OK && r < options->replicates; ++r) {
        trail.contribution.replicate = r;
        for (uint64_t s = 0; s < samples; ++s)
            explain_sample(&world, &scene->sensors[sensor], options, pixel, width, s, &trail);
    }
    ref_world_free(&world);
    return result;
}
