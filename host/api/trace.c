/* SPDX-License-Identifier: Apache-2.0 */
/* Rays of the public interface. */
#include "verbs/trace.h"

#include "api/handles.h"
#include "core/output_file.h"
#include "verbs/rays.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Rays of a call, which owns their copy. */
typedef struct ray_list {
    mcv_trace_ray *items;
    size_t count;
} ray_list;

static mcv_result copy_rays(const double *numbers, size_t count, ray_list *r, mcv_error *error) {
    r->items = malloc((count + 1) * sizeof *r->items);
    r->count = count;
    if (!r->items) return mcv_fail(error, MCV_FAILED, "no memory for %zu rays", count);
    for (size_t i = 0; i < count; ++i) {
        const double *n = numbers + 6 * i;
        bool right = hypot(hypot(n[3], n[4]), n[5]) > 0;
        for (int k = 0; k < 6; ++k) right = right && isfinite(n[k]);
        if (!right)
            return mcv_fail(error, MCV_BAD_INPUT,
                            "ray %zu: all numbers must be finite, and its direction must have a "
                            "length",
                            i);
        memcpy(r->items[i].origin, n, sizeof r->items[i].origin);
        memcpy(r->items[i].direction, n + 3, sizeof r->items[i].direction);
    }
    return MCV_OK;
}

static mcv_result tell(const mcv_scene *scene, const ray_list *r, char **report, mcv_error *error) {
    mcv_report told;
    if (!report) return MCV_OK;
    MCV_TRY(mcv_report_keep(&told, true, error));
    for (uint32_t i = 0; i < scene->warning_count; ++i)
        mcv_report_tell(&told, "warning", scene->warnings[i]);
    mcv_report_number(&told, "rays", "", (double)r->count);
    return mcv_report_take(&told, report, error);
}

static mcv_result trace_scene(const mcv_command *command, const mcv_scene *scene, const ray_list *r,
                              char **csv, char **report, mcv_error *error) {
    char *text;
    size_t size;
    MCV_TRY(mcv_trace_table(command, scene, r->items, r->count, &text, &size, error));
    mcv_result result =
        command->paths ? mcv_output_whole(command->paths, text, size, error) : MCV_OK;
    if (result == MCV_OK) result = tell(scene, r, report, error);
    if (result == MCV_OK && csv)
        *csv = text;
    else
        free(text);
    return result;
}

static mcv_result trace_rig(mcv_session *session, const mcv_rig *rig, const mcv_command *command,
                            const double *numbers, ray_list *r, char **csv, char **report,
                            mcv_error *error) {
    mcv_scene *scene;
    uint32_t precision;
    if (!numbers && !command->rays)
        return mcv_fail(error, MCV_USAGE, "--rays is missing: give a table of rays x,y,z,dx,dy,dz");
    if (numbers && command->rays)
        return mcv_fail(error, MCV_USAGE,
                        "options: --rays %s: there are rays in memory, too: give one of both",
                        command->rays);
    MCV_TRY(mcv_precision_read(command, &precision, error));
    if (command->paths) MCV_TRY(mcv_output_check(command->paths, error));
    MCV_TRY(numbers ? copy_rays(numbers, r->count, r, error)
                    : mcv_rays_read(command->rays, &r->items, &r->count, error));
    MCV_TRY(mcv_scene_load_document(&rig->document,
                                    (mcv_overrides){command->set.items, command->set.count},
                                    (uint64_t)command->memory, session->assets, &scene, error));
    const mcv_result result = trace_scene(command, scene, r, csv, report, error);
    mcv_scene_free(scene);
    return result;
}

static mcv_result trace(mcv_session *session, const mcv_rig *rig, const double *numbers,
                        size_t ray_count, const char *options, char **csv, char **report,
                        mcv_error *error) {
    const char *const arguments[2] = {rig->document.path};
    mcv_options_given given;
    ray_list r = {NULL, ray_count};
    MCV_TRY(mcv_options_read(options, session->defaults, MCV_VERB_TRACE, arguments, NULL, &given,
                             error));
    const mcv_result result =
        trace_rig(session, rig, &given.command, numbers, &r, csv, report, error);
    free(r.items);
    mcv_options_free(&given);
    return result;
}

mcv_result mcv_session_trace(mcv_session *session, const mcv_rig *rig, const double *rays,
                             size_t ray_count, const char *options, char **csv, char **report,
                             mcv_error *error) {
    mcv_result result;
    if (csv) *csv = NULL;
    if (report) *report = NULL;
    MCV_NEED(session);
    MCV_NEED(rig);
    if (ray_count > 0) MCV_NEED(rays);
    MCV_TRY(mcv_session_begin(session, error));
    MCV_INSIDE(result, trace(session, rig, rays, ray_count, options, csv, report, error));
    mcv_session_end(session);
    return result;
}
