/* SPDX-License-Identifier: Apache-2.0 */
/* The check of the public interface. */
#include "verbs/check.h"

#include "api/handles.h"

#include <stdlib.h>

static mcv_result report_scene(const mcv_command *command, const mcv_scene *scene, char **report,
                               mcv_error *error) {
    mcv_report r;
    mcv_result result = mcv_report_keep(&r, command->json, error);
    if (result == MCV_OK) result = mcv_check(command, scene, &r, error);
    if (result == MCV_OK) return mcv_report_take(&r, report, error);
    mcv_report_free(&r);
    return result;
}

static mcv_result report_strict(const mcv_command *command, const mcv_rig *rig, char **report,
                                mcv_error *error) {
    mcv_report r;
    mcv_result result = mcv_report_keep(&r, command->json, error);
    if (result == MCV_OK) result = mcv_check_strict(command, &rig->document, &r, error);
    if (result == MCV_OK) return mcv_report_take(&r, report, error);
    mcv_report_free(&r);
    return result;
}

static mcv_result check(mcv_session *session, const mcv_rig *rig, const char *options,
                        char **report, mcv_error *error) {
    const char *const arguments[2] = {rig ? rig->document.path : NULL};
    mcv_options_given given;
    mcv_scene *scene = NULL;
    MCV_TRY(mcv_options_read(options, session->defaults, MCV_VERB_CHECK, arguments, NULL, &given,
                             error));
    const bool defines = given.command.defines;
    mcv_result result = MCV_OK;
    if (given.command.strict) {
        result = rig ? report_strict(&given.command, rig, report, error)
                     : mcv_fail(error, MCV_USAGE, "mcv_session_check: rig must not be NULL");
        mcv_options_free(&given);
        return result;
    }
    if (rig)
        result = mcv_session_scene(session, rig, &given.command, &scene, error);
    else if (!defines)
        result = mcv_fail(error, MCV_USAGE, "mcv_session_check: rig must not be NULL");
    if (result == MCV_OK)
        result = (defines ? mcv_check_defines : report_scene)(&given.command, scene, report, error);
    mcv_scene_free(scene);
    if (result != MCV_OK) {
        free(*report);
        *report = NULL;
    }
    mcv_options_free(&given);
    return result;
}

mcv_result mcv_session_check(mcv_session *session, const mcv_rig *rig, const char *options,
                             char **report, mcv_error *error) {
    mcv_result result;
    MCV_NEED(report);
    *report = NULL;
    MCV_NEED(session);
    MCV_TRY(mcv_session_begin(session, error));
    MCV_INSIDE(result, check(session, rig, options, report, error));
    mcv_session_end(session);
    return result;
}
