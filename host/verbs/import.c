/* SPDX-License-Identifier: Apache-2.0 */
#include "verbs/import.h"

#include "loader/load.h"

#include <stdlib.h>
#include <string.h>

/* What the reader lets pass the loader may still refuse. */
static mcv_result check(const char *from, const char *text, mcv_error *error) {
    mcv_document document;
    mcv_scene *scene = NULL;
    mcv_error refusal;
    MCV_TRY(mcv_document_parse(from, text, strlen(text), &document, error));
    const mcv_result result =
        mcv_scene_load_document(&document, (mcv_overrides){NULL, 0}, NULL, &scene, &refusal);
    mcv_scene_free(scene);
    mcv_document_free(&document);
    if (result == MCV_OK) return MCV_OK;
    const size_t length = strlen(from);
    return mcv_fail(error, MCV_BAD_INPUT, "%s: its lens is not valid in a scene%s", from,
                    strncmp(refusal.text, from, length) == 0 ? refusal.text + length
                                                             : refusal.text);
}

mcv_result mcv_import(const mcv_command *command, char **text, mcv_lens_report *lens,
                      mcv_error *error) {
    const mcv_lens_options options = {command->index.items, command->index.count,
                                      (mcv_lens_shape)command->curvature};
    json_t *scene;
    MCV_TRY(mcv_lens_file_read(command->argument, &options, &scene, lens, error));
    *text = json_dumps(scene, JSON_INDENT(1) | JSON_REAL_PRECISION(12));
    json_decref(scene);
    if (!*text) return mcv_fail(error, MCV_FAILED, "%s: no memory for its lens", command->argument);
    const mcv_result result = check(command->argument, *text, error);
    if (result == MCV_OK) return MCV_OK;
    free(*text);
    *text = NULL;
    return result;
}

void mcv_import_report(const mcv_lens_report *lens, mcv_report *report) {
    mcv_report_number(report, "focal_length", "m", lens->focal_length);
    mcv_report_number(report, "stated_focal_length", "m", lens->stated_focal_length);
    mcv_report_number(report, "back_focus", "m", lens->back_focus);
    mcv_report_number(report, "object_distance", "m", lens->object_distance);
    mcv_report_number(report, "image_distance", "m", lens->image_distance);
    mcv_report_number(report, "stated_image_distance", "m", lens->stated_image_distance);
    mcv_report_number(report, "f_number", "", lens->f_number);
    mcv_report_number(report, "stated_f_number", "", lens->stated_f_number);
    mcv_report_flag(report, "working", lens->working);
    mcv_report_number(report, "wavelength", "m", lens->wavelength);
    for (int i = 0; i < lens->warning_count; ++i)
        mcv_report_tell(report, "warning", lens->warnings[i]);
}
