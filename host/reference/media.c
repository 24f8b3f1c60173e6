/* SPDX-License-Identifier: Apache-2.0 */
#include "reference/media.h"

bool ref_media_cross(ref_media *media, uint32_t instance, bool front) {
    if (front) {
        if (media->count == REF_MEDIA_DEPTH) return false;
        media->instances[media->count++] = instance;
        return true;
    }
    for (uint32_t i = 0; i < media->count; ++i) {
        if (media->instances[i] == instance) {
            media->instances[i] = media->instances[--media->count];
            return true;
        }
    }
    return false;
}

static const mcv_dielectric_params *dielectric_of(const mcv_scene *scene, uint32_t instance) {
    return &scene->materials[scene->instances[instance].material].as.dielectric;
}

const mcv_dielectric_params *ref_media_filling(const ref_media *media, const mcv_scene *scene) {
    const mcv_dielectric_params *filling = NULL;
    uint32_t owner = 0;
    for (uint32_t i = 0; i < media->count; ++i) {
        const uint32_t instance = media->instances[i];
        const mcv_dielectric_params *candidate = dielectric_of(scene, instance);
        if (!filling || candidate->priority > filling->priority || (candidate->priority == filling->priority && instance > owner)) {
            filling = candidate;
            owner = instance;
        }
    }
    return filling;
}

mcv_result ref_media_at(const ref_geometry *geometry, ref_vec point, int *winding, ref_media *media, mcv_error *error) {
    const mcv_scene *scene = geometry->scene;
    const ref_vec anywhere = {0.3170, 0.5290, 0.7871}; /* along no axis: models have surfaces and edges there */
    media->count = 0;
    for (uint32_t i = 0; i < scene->instance_count; ++i) winding[i] = 0;
    ref_add_windings(geometry, point, anywhere, winding);
    for (uint32_t i = 0; i < scene->instance_count; ++i) {
        if (scene->materials[scene->instances[i].material].type != MCV_MATERIAL_DIELECTRIC) continue;
        for (int n = 0; n < winding[i]; ++n) {
            if (!ref_media_cross(media, i, true))
                return mcv_fail(error, MCV_BAD_INPUT, "%s: more than %d dielectric bodies overlap at (%g, %g, %g) m; use fewer", scene->path,
                                REF_MEDIA_DEPTH, point.x, point.y, point.z);
        }
    }
    return MCV_OK;
}
