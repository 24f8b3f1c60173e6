/* SPDX-License-Identifier: Apache-2.0 */
/* Keys of a laser triangulation head that its scan would refuse, or whose heights are none. */
#include "check/find.h"

#include "scene/camera_model.h"
#include "scene/laser.h"
#include "scene/transform.h"

#include <math.h>

typedef struct head {
    const mcv_scene *scene;
    const mcv_sensor *sensor;
    const mcv_laser_triangulation_params *params;
} head;

/* node: NULL where there is none, which is told. */
static mcv_result find_node(const head *h, const mcv_camera_model *model, const char *key,
                            const char *name, const mcv_placement **node, mcv_findings *findings,
                            mcv_error *error) {
    mcv_error why = {""};
    if (mcv_camera_model_node(model, name, key, node, &why) == MCV_OK) return MCV_OK;
    *node = NULL;
    return mcv_findings_add(findings, MCV_SEVERITY_WARNING, "sensors", h->sensor->name, key, error,
                            "sensor \"%s\": a scan without options is refused: %s", h->sensor->name,
                            why.text);
}

/* Heights are z of the frame: across the light they would tell of the feed. */
static mcv_result find_across(const head *h, const mcv_placement *laser, const mcv_placement *frame,
                              mcv_findings *findings, mcv_error *error) {
    mcv_transform axes[2];
    double cosine = 0;
    if (!mcv_transform_rigid(&laser->to_world, axes) ||
        !mcv_transform_rigid(&frame->to_world, axes + 1))
        return MCV_OK;
    for (int k = 0; k < 3; ++k) cosine += axes[0].m[3 * k + 2] * axes[1].m[3 * k + 2];
    if (fabs(cosine) > 0.5) return MCV_OK;
    return mcv_findings_add(
        findings, MCV_SEVERITY_WARNING, "sensors", h->sensor->name, "frame", error,
        "sensor \"%s\": heights are z of node \"%s\", which runs across the light, not along it: "
        "leave out frame, for those of the laser",
        h->sensor->name, h->params->frame);
}

static mcv_result find_filter(const head *h, mcv_findings *findings, mcv_error *error) {
    const double centre = h->params->filter, width = h->params->filterWidth;
    double own, linewidth;
    if (isnan(centre) != isnan(width))
        return mcv_findings_add(findings, MCV_SEVERITY_WARNING, "sensors", h->sensor->name,
                                "filter", error,
                                "sensor \"%s\": a scan without options is refused: filter and "
                                "filterWidth make a filter together",
                                h->sensor->name);
    if (isnan(centre) || !mcv_scene_is_laser_lit(h->scene, &own, &linewidth) ||
        fabs(own - centre) <= width / 2)
        return MCV_OK;
    return mcv_findings_add(
        findings, MCV_SEVERITY_WARNING, "sensors", h->sensor->name, "filter", error,
        "sensor \"%s\": a scan without options is refused: the laser's %.6g nm lie outside of "
        "the filter's band, %.6g … %.6g nm",
        h->sensor->name, own * 1e9, (centre - width / 2) * 1e9, (centre + width / 2) * 1e9);
}

static mcv_result find_head(const head *h, mcv_findings *findings, mcv_error *error) {
    const mcv_laser_triangulation_params *p = h->params;
    const mcv_placement *laser = NULL, *frame = NULL;
    mcv_camera_model model;
    MCV_TRY(mcv_camera_model_of(h->scene, h->sensor, &model, error));
    mcv_result result =
        find_node(h, &model, "laser", p->laser[0] ? p->laser : "laser", &laser, findings, error);
    if (result == MCV_OK && p->frame[0])
        result = find_node(h, &model, "frame", p->frame, &frame, findings, error);
    if (result == MCV_OK && laser && frame) result = find_across(h, laser, frame, findings, error);
    mcv_camera_model_free(&model);
    if (result == MCV_OK && p->profiles > 1 && !(fabs(p->feed) > 0))
        result = mcv_findings_add(findings, MCV_SEVERITY_WARNING, "sensors", h->sensor->name,
                                  "feed", error,
                                  "sensor \"%s\": a scan without options is refused: feed is "
                                  "missing, or 0, between %u profiles",
                                  h->sensor->name, p->profiles);
    return result == MCV_OK ? find_filter(h, findings, error) : result;
}

mcv_result mcv_find_head(const mcv_scene *scene, mcv_findings *findings, mcv_error *error) {
    for (uint32_t i = 0; i < scene->sensor_count; ++i) {
        const mcv_sensor *s = scene->sensors + i;
        const head h = {scene, s, &s->as.laser_triangulation};
        if (s->is_head) MCV_TRY(find_head(&h, findings, error));
    }
    return MCV_OK;
}
