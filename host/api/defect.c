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

static mcv_result edit(const mcv_rig *rig, const mcv_command *command, json_t *root,
                       mcv_report *report, mcv_error *error) {
    char *name = NULL;
    mcv_result result = mcv_defect_add(command, root, &name, error);
    if (result == MCV_OK) result = try_scene(rig, root, report, error);
    free(name);
    return result;
}

static mcv_result add_defect(mcv_rig *rig, const char *type, const char *options, char **report,
                             mcv_error *error) {
    static const char *const without[] = {"output", NULL};
    const char *const arguments[2] = {rig->document.path, type};
    mcv_options_given given;
    MCV_TRY(mcv_options_read(options, NULL, MCV_VERB_DEFECT, arguments, without, &given, error));
    const mcv_result result = mcv_rig_change(rig, &given.command, edit, report, error);
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
