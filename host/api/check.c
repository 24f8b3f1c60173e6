/* SPDX-License-Identifier: Apache-2.0 */
/* What the public interface does with a rig beside rendering it. */
#include "verbs/check.h"

#include "api/handles.h"
#include "verbs/trace.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static mcv_result report_scene(const mcv_command *command, const mcv_scene *scene, char **report,
                               mcv_error *error) {
    mcv_report r;
    mcv_result result = mcv_report_keep(&r, command->json, error);
    if (result == MCV_OK) result = mcv_check(command, scene, &r, error);
    if (result == MCV_OK) return mcv_report_take(&r, report, error);
    mcv_report_free(&r);
    return result;
}

static mcv_result check(mcv_session *session, const mcv_rig *rig, const char *options,
                        char **report, mcv_error *error) {
    static const char *const without[] = {"defines", NULL};
    const char *const arguments[2] = {rig->document.path};
    mcv_options_given given;
    mcv_scene *scene = NULL;
    MCV_TRY(mcv_options_read(options, session->defaults, MCV_VERB_CHECK, arguments, without, &given,
                             error));
    mcv_result result = mcv_session_scene(session, rig, &given.command, &scene, error);
    if (result == MCV_OK) result = report_scene(&given.command, scene, report, error);
    mcv_scene_free(scene);
    mcv_options_free(&given);
    return result;
}

mcv_result mcv_session_check(mcv_session *session, const mcv_rig *rig, const char *options,
                             char **report, mcv_error *error) {
    mcv_result result;
    MCV_NEED(report);
    *report = NULL;
    MCV_NEED(session);
    MCV_NEED(rig);
    MCV_TRY(mcv_session_begin(session, error));
    MCV_INSIDE(result, check(session, rig, options, report, error));
    mcv_session_end(session);
    return result;
}

/* --- rays --- */

static mcv_result read_rays(const double *numbers, size_t count, mcv_trace_ray **rays,
                            mcv_error *error) {
    *rays = malloc((count + 1) * sizeof **rays);
    if (!*rays) return mcv_fail(error, MCV_FAILED, "no memory for %zu rays", count);
    for (size_t i = 0; i < count; ++i) {
        const double *n = numbers + 6 * i;
        mcv_trace_ray *ray = *rays + i;
        bool right = hypot(hypot(n[3], n[4]), n[5]) > 0;
        for (int k = 0; k < 6; ++k) right = right && isfinite(n[k]);
        if (!right) {
            free(*rays);
            return mcv_fail(error, MCV_BAD_INPUT,
                            "ray %zu: all numbers must be finite, and its direction must have a "
                            "length",
                            i);
        }
        memcpy(ray->origin, n, sizeof ray->origin);
        memcpy(ray->direction, n + 3, sizeof ray->direction);
    }
    return MCV_OK;
}

static mcv_result trace_scene(mcv_session *session, const mcv_rig *rig, const mcv_command *command,
                              const double *numbers, size_t count, char **csv, mcv_error *error) {
    mcv_scene *scene;
    mcv_trace_ray *rays;
    size_t size;
    MCV_TRY(mcv_scene_load_document(&rig->document,
                                    (mcv_overrides){command->set.items, command->set.count},
                                    session->assets, &scene, error));
    mcv_result result = read_rays(numbers, count, &rays, error);
    if (result == MCV_OK) {
        result = mcv_trace_table(command, scene, rays, count, csv, &size, error);
        free(rays);
    }
    mcv_scene_free(scene);
    return result;
}

static mcv_result trace(mcv_session *session, const mcv_rig *rig, const double *rays,
                        size_t ray_count, const char *options, char **csv, mcv_error *error) {
    static const char *const without[] = {"rays", "output", NULL};
    const char *const arguments[2] = {rig->document.path};
    mcv_options_given given;
    MCV_TRY(mcv_options_read(options, session->defaults, MCV_VERB_TRACE, arguments, without, &given,
                             error));
    const mcv_result result =
        trace_scene(session, rig, &given.command, rays, ray_count, csv, error);
    mcv_options_free(&given);
    return result;
}

mcv_result mcv_session_trace(mcv_session *session, const mcv_rig *rig, const double *rays,
                             size_t ray_count, const char *options, char **csv, mcv_error *error) {
    mcv_result result;
    MCV_NEED(csv);
    *csv = NULL;
    MCV_NEED(session);
    MCV_NEED(rig);
    if (ray_count > 0) MCV_NEED(rays);
    MCV_TRY(mcv_session_begin(session, error));
    MCV_INSIDE(result, trace(session, rig, rays, ray_count, options, csv, error));
    mcv_session_end(session);
    return result;
}
