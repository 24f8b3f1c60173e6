/* SPDX-License-Identifier: Apache-2.0 */
/* Defects of the public interface. */
#include "verbs/defect.h"

#include "api/handles.h"

#include <stdlib.h>

/* The scene that the tree makes must load: so a defect off the surface is refused here. */
static mcv_result try_scene(const mcv_rig *rig, json_t *root, mcv_report *report,
                            mcv_error *error) {
    const mcv_document document = {.path = rig->document.path,
                                   .root = root,
                                   .binary = rig->document.binary,
                                   .fingerprint = rig->document.fingerprint};
    mcv_scene *scene = NULL;
    mcv_result result =
        mcv_scene_load_document(&document, (mcv_overrides){NULL, 0}, 0, NULL, &scene, error);
    if (result == MCV_OK) result = mcv_defect_report(scene, report, error);
    mcv_scene_free(scene);
    return result;
}

/* On a copy of the tree: after failure the rig is as it was. */
static mcv_result add(mcv_rig *rig, const mcv_command *command, char **report, mcv_error *error) {
    mcv_report r;
    char *name = NULL;
    json_t *root = json_deep_copy(rig->document.root);
    mcv_result result = mcv_report_keep(&r, command->json, error);
    if (result == MCV_OK && !root) result = mcv_fail(error, MCV_FAILED, "no memory for the rig");
    if (result == MCV_OK) result = mcv_defect_add(command, root, &name, error);
    if (result == MCV_OK) result = try_scene(rig, root, &r, error);
    free(name);
    if (result == MCV_OK && report)
        result = mcv_report_take(&r, report, error);
    else
        mcv_report_free(&r);
    if (result == MCV_OK)
        mcv_rig_take_root(rig, root);
    else
        json_decref(root);
    return result;
}

static mcv_result add_defect(mcv_rig *rig, const char *type, const char *options, char **report,
                             mcv_error *error) {
    static const char *const without[] = {"output", NULL};
    const char *const arguments[2] = {rig->document.path, type};
    mcv_options_given given;
    MCV_TRY(mcv_options_read(options, NULL, MCV_VERB_DEFECT, arguments, without, &given, error));
    const mcv_result result = add(rig, &given.command, report, error);
    mcv_options_free(&given);
    return result;
}

mcv_result mcv_rig_add_defect(mcv_rig *rig, const char *type, const char *options, char **report,
                              mcv_error *error) {
    mcv_result result;
    if (report) *report = NULL;
    MCV_NEED(rig);
    MCV_NEED(type);
    MCV_INSIDE(result, add_defect(rig, type, options, report, error));
    return result;
}
