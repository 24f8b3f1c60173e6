/* SPDX-License-Identifier: Apache-2.0 */
#include "verbs/surface_part.h"

#include "analysis/surface_noise.h"
#include "io/exr_make.h"
#include "reference/surface_places.h"

mcv_result mcv_surface_part_add(const ref_geometry *geometry, const mcv_sensor *sensor, uint32_t q,
                                mcv_exr *laser, mcv_error *error) {
    mcv_image places;
    MCV_TRY(ref_surface_places(geometry, sensor, q, &places, error));
    return mcv_exr_add_part(laser, MCV_SURFACE_PART, places, mcv_surface_channels, error);
}

mcv_result mcv_surface_part_of(const mcv_scene *scene, uint32_t sensor, uint32_t q, mcv_exr *laser,
                               mcv_error *error) {
    ref_geometry geometry;
    MCV_TRY(ref_geometry_new(scene, &geometry, error));
    const mcv_result result =
        mcv_surface_part_add(&geometry, scene->sensors + sensor, q, laser, error);
    ref_geometry_free(&geometry);
    return result;
}
