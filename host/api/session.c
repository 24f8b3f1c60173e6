/* SPDX-License-Identifier: Apache-2.0 */
/* Sessions, devices and options of the public interface. */
#include "api/handles.h"
#include "core/json.h"
#include "options/option_table.h"
#include "verbs/render_files.h"
#include "scene/sensor_find.h"
#include "scene/sensors.h"
#include "verbs/devices.h"

#include <stdlib.h>
#include <string.h>

/* --- options and devices --- */

static mcv_result schema_of(const char *verb, char **schema, mcv_error *error) {
    unsigned index;
    MCV_TRY(mcv_verb_find(verb, &index, error));
    json_t *document = mcv_verb_schema(index);
    *schema = document ? json_dumps(document, JSON_COMPACT) : NULL;
    json_decref(document);
    return *schema ? MCV_OK : mcv_fail(error, MCV_FAILED, "no memory for the schema");
}

mcv_result mcv_options_schema(const char *verb, char **schema, mcv_error *error) {
    mcv_result result;
    MCV_NEED(schema);
    *schema = NULL;
    MCV_NEED(verb);
    MCV_INSIDE(result, schema_of(verb, schema, error));
    return result;
}

static mcv_result list_devices(char **report, mcv_error *error) {
    mcv_report r;
    mcv_error none = {""};
    MCV_TRY(mcv_report_keep(&r, true, error));
    mcv_report_list(&r, "devices");
    const mcv_result result = mcv_cl_list(mcv_report_device, &r, &none);
    mcv_report_close(&r);
    if (result != MCV_OK) mcv_report_text(&r, "message", none.text);
    return mcv_report_take(&r, report, error);
}

mcv_result mcv_devices(char **report, mcv_error *error) {
    mcv_result result;
    MCV_NEED(report);
    *report = NULL;
    MCV_INSIDE(result, list_devices(report, error));
    return result;
}

/* --- sessions --- */

static void close_session(mcv_session *session) {
    mcv_renderer_free(session->renderer);
    mcv_asset_cache_free(session->assets);
    json_decref(session->defaults);
    free(session->device);
    free(session);
}

/* The options of a session, which are those of a render. */
static mcv_result read_defaults(const char *options, json_t **defaults, mcv_error *error) {
    static const char *const of_session[] = {"device", "precision", "threads", "schedule"};
    static const char *const scene[2] = {"scene"};
    mcv_options_given given;
    size_t known = 0;
    MCV_TRY(mcv_options_read(options, NULL, MCV_VERB_RENDER, scene, NULL, &given, error));
    json_t *all = mcv_command_json(&given.command, (const char *const[]){NULL});
    *defaults = json_object();
    for (size_t i = 0; all && i < sizeof of_session / sizeof of_session[0]; ++i) {
        json_t *value = json_object_get(all, of_session[i]);
        known += value != NULL;
        if (value) mcv_json_put(defaults, of_session[i], json_incref(value));
    }
    const bool others = json_object_size(all) > known, memory = all && *defaults;
    json_decref(all);
    mcv_options_free(&given);
    if (memory && !others) return MCV_OK;
    json_decref(*defaults);
    if (!memory) return mcv_fail(error, MCV_FAILED, "no memory for the options");
    return mcv_fail(error, MCV_USAGE,
                    "options: a session takes device, precision, threads and schedule only");
}

static mcv_result open_session(const char *options, mcv_session **session, mcv_error *error) {
    json_t *defaults;
    MCV_TRY(read_defaults(options, &defaults, error));
    mcv_session *s = calloc(1, sizeof *s);
    if (!s) {
        json_decref(defaults);
        return mcv_fail(error, MCV_FAILED, "no memory for a session");
    }
    atomic_flag_clear(&s->busy);
    s->defaults = defaults;
    s->assets = mcv_asset_cache_new();
    if (!s->assets) {
        close_session(s);
        return mcv_fail(error, MCV_FAILED, "no memory for a session");
    }
    *session = s;
    return MCV_OK;
}

mcv_result mcv_session_open(const char *options, mcv_session **session, mcv_error *error) {
    mcv_result result;
    MCV_NEED(session);
    *session = NULL;
    MCV_INSIDE(result, open_session(options, session, error));
    return result;
}

void mcv_session_close(mcv_session *session) {
    if (!session) return;
    const locale_t host = mcv_border_enter();
    close_session(session);
    mcv_border_leave(host);
}

mcv_result mcv_session_begin(mcv_session *session, mcv_error *error) {
    if (!atomic_flag_test_and_set(&session->busy)) return MCV_OK;
    return mcv_fail(error, MCV_USAGE,
                    "the session is at work in another call: open a session for each thread, and "
                    "do not call it from its own callbacks");
}

void mcv_session_end(mcv_session *session) { atomic_flag_clear(&session->busy); }

mcv_result mcv_session_renderer(mcv_session *s, const char *device, mcv_renderer **renderer,
                                mcv_error *error) {
    const bool same = device && s->device ? strcmp(device, s->device) == 0 : device == s->device;
    if (!s->renderer || !same) {
        mcv_renderer_free(s->renderer);
        free(s->device);
        s->renderer = mcv_renderer_new();
        s->device = device ? strdup(device) : NULL;
        if (!s->renderer || (device && !s->device))
            return mcv_fail(error, MCV_FAILED, "no memory for a renderer");
    }
    *renderer = s->renderer;
    return MCV_OK;
}

mcv_result mcv_session_scene(mcv_session *session, const mcv_rig *rig, const mcv_command *command,
                             mcv_scene **scene, mcv_error *error) {
    MCV_TRY(mcv_scene_load_document(
        &rig->document, (mcv_overrides){command->set.items, command->set.count},
        (uint64_t)command->memory, session ? session->assets : NULL, scene, error));
    if ((*scene)->sensor_count > 0) return MCV_OK;
    const mcv_result result = mcv_fail(
        error, MCV_BAD_INPUT,
        "%s: the scene has no sensor: give a node a glTF camera or an MCVISI_sensors sensor",
        (*scene)->path);
    mcv_scene_free(*scene);
    *scene = NULL;
    return result;
}

mcv_result mcv_session_sensor(mcv_scene *scene, const mcv_command *command, uint32_t *sensor,
                              mcv_error *error) {
    *sensor = 0;
    if (command->sensor) MCV_TRY(mcv_sensor_find(scene, command->sensor, sensor, error));
    if (!command->sensor && scene->sensor_count > 1)
        return mcv_fail(error, MCV_USAGE, "%s: has %u sensors: choose one by --sensor", scene->path,
                        scene->sensor_count);
    return mcv_render_resize(command, scene, *sensor, error);
}
