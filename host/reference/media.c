/* SPDX-License-Identifier: Apache-2.0 */
#include "reference/media.h"

#include "scene/materials.h"

/* Makes the instance surround the point, or not. False: it was so already, or there is no room for
 * one more. */
static bool set_inside(ref_media *media, uint32_t instance, bool inside) {
    uint32_t i = 0;
    while (i < media->count && media->instances[i] != instance) ++i;
    if ((i < media->count) == inside || (inside && i == REF_MEDIA_DEPTH)) return false;
    if (inside)
        media->instances[media->count++] = instance;
    else
        media->instances[i] = media->instances[--media->count];
    return true;
}

bool ref_media_cross_all(ref_media *near, ref_media *far, uint32_t count, const uint32_t *instances,
                         const bool *fronts) {
    bool corrected = false;
    for (uint32_t i = 0; i < count; ++i)
        if (set_inside(near, instances[i], !fronts[i])) corrected = true;
    *far = *near;
    for (uint32_t i = 0; i < count; ++i) set_inside(far, instances[i], fronts[i]);
    return !corrected;
}

const mcv_medium_params *ref_media_filling(const ref_media *media, const mcv_scene *scene) {
    const mcv_medium_params *filling = NULL;
    uint32_t owner = 0;
    for (uint32_t i = 0; i < media->count; ++i) {
        const uint32_t instance = media->instances[i],
                       material = scene->instances[instance].material;
        const mcv_medium_params *candidate = &scene->materials[material].as.medium;
        bool wins = !filling || candidate->priority > filling->priority;
        if (filling && candidate->priority == filling->priority) {
            const uint32_t other = scene->instances[owner].material;
            wins = material != other ? material > other : instance > owner;
        }
        if (!wins) continue;
        filling = candidate;
        owner = instance;
    }
    return filling;
}

mcv_result ref_media_at(const ref_geometry *geometry, ref_vec point, int *winding, ref_media *media,
                        mcv_error *error) {
    const mcv_scene *scene = geometry->scene;
    const ref_vec anywhere = {0.3170, 0.5290,
                              0.7871}; /* along no axis: models have surfaces and edges there */
    media->count = 0;
    for (uint32_t i = 0; i < scene->instance_count; ++i) winding[i] = 0;
    ref_add_windings(geometry, point, anywhere, winding);
    for (uint32_t i = scene->instance_count; i-- > 1;)
        if (scene->instances[i].closes_previous) winding[i - 1] += winding[i];
    for (uint32_t i = 0; i < scene->instance_count; ++i) {
        if (!mcv_material_has_medium(scene->materials[scene->instances[i].material].type) ||
            winding[i] <= 0)
            continue;
        if (!set_inside(media, i, true))
            return mcv_fail(
                error, MCV_BAD_INPUT,
                "%s: more than %d dielectric bodies overlap at (%g, %g, %g) m; use fewer",
                scene->path, REF_MEDIA_DEPTH, point.x, point.y, point.z);
    }
    return MCV_OK;
}
