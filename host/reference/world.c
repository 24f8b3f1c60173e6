/* SPDX-License-Identifier: Apache-2.0 */
#include "reference/world.h"

#include <stdlib.h>

/* The media around the sensor. */
static mcv_result find_media(const mcv_scene *scene, uint32_t sensor, ref_world *world,
                             mcv_error *error) {
    const double *m = scene->sensors[sensor].to_world.m;
    const double lens[3] = {m[9], m[10], m[11]};
    int *winding = calloc(scene->instance_count + (size_t)1, sizeof *winding);
    if (!winding) return mcv_fail(error, MCV_FAILED, "no memory for the media around the sensor");
    const mcv_result result =
        ref_media_at(&world->geometry, ref_from(lens), winding, &world->media, error);
    free(winding);
    return result;
}

mcv_result ref_world_new(const mcv_scene *scene, uint32_t sensor, uint32_t depth, ref_manner how,
                         ref_world *world, mcv_error *error) {
    *world = (ref_world){.scene = scene, .depth = depth, .sample_emitters = how.sample_emitters};
    MCV_TRY(ref_geometry_new(scene, &world->geometry, error));
    MCV_TRY(ref_emitters_new(scene, &world->emitters, error));
    MCV_TRY(ref_gloss_tables_new(scene, how.draft, &world->gloss, error));
    return find_media(scene, sensor, world, error);
}

void ref_world_free(ref_world *world) {
    ref_emitters_free(&world->emitters);
    ref_gloss_tables_free(&world->gloss);
    ref_geometry_free(&world->geometry);
}
