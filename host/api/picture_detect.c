/* SPDX-License-Identifier: Apache-2.0 */
/* Detectability of defects, of the public interface. */
#include "verbs/detect.h"

#include "api/handles.h"
#include "core/output_file.h"
#include "io/exr_make.h"

static mcv_result make_picture(mcv_image *sigmas, mcv_picture **visible, mcv_error *error) {
    static const mcv_attribute own[] = {
        {.name = "mcvisi:quantity", .text = "difference in deviations of the noise"},
        {.name = "mcvisi:unit", .text = ""}};
    mcv_exr exr = {0};
    const mcv_image image = *sigmas;
    *sigmas = (mcv_image){0};
    mcv_result result = mcv_exr_add_part(&exr, "image", image, NULL, error);
    if (result == MCV_OK)
        result = mcv_exr_set_attributes(&exr, own, sizeof own / sizeof own[0], error);
    if (result == MCV_OK) return mcv_picture_of(&exr, "the difference", visible, error);
    mcv_exr_free(&exr);
    return result;
}

static mcv_result detect_with(const mcv_command *command, const mcv_picture *with,
                              const mcv_picture *without, mcv_picture **visible, char **report,
                              mcv_error *error) {
    mcv_detected detected;
    mcv_report r;
    if (command->mask) MCV_TRY(mcv_output_check(command->mask, error));
    if (command->truth) MCV_TRY(mcv_output_check(command->truth, error));
    if (command->detected) MCV_TRY(mcv_output_check(command->detected, error));
    MCV_TRY(mcv_detect_pictures(command, &with->exr, with->path, &without->exr, without->path,
                                &detected, error));
    mcv_result result = mcv_detect_look(command, &detected, error);
    if (result == MCV_OK && command->mask) result = mcv_detect_save(command, &detected, error);
    const mcv_detect_view view = {command,       &detected,  &with->exr,
                                  &without->exr, with->path, without->path};
    if (result == MCV_OK && command->detected)
        result = mcv_detect_write_page(command->detected, &view, error);
    if (result == MCV_OK && report) result = mcv_report_keep(&r, command->json, error);
    if (result == MCV_OK && report) {
        mcv_detect_report(command, &detected, &r);
        result = mcv_report_take(&r, report, error);
    }
    if (result == MCV_OK && visible) result = make_picture(&detected.sigmas, visible, error);
    mcv_detected_free(&detected);
    return result;
}

static mcv_result detect(const mcv_picture *with, const mcv_picture *without, const char *options,
                         mcv_picture **visible, char **report, mcv_error *error) {
    const char *const arguments[2] = {with->path, without->path};
    mcv_options_given given;
    MCV_TRY(mcv_options_read(options, NULL, MCV_VERB_DETECT, arguments, NULL, &given, error));
    const mcv_result result = detect_with(&given.command, with, without, visible, report, error);
    mcv_options_free(&given);
    if (result == MCV_OK || !visible) return result;
    mcv_picture_free(*visible);
    *visible = NULL;
    return result;
}

mcv_result mcv_picture_detect(const mcv_picture *with, const mcv_picture *without,
                              const char *options, mcv_picture **visible, char **report,
                              mcv_error *error) {
    mcv_result result;
    if (visible) *visible = NULL;
    if (report) *report = NULL;
    MCV_NEED(with);
    MCV_NEED(without);
    MCV_INSIDE(result, detect(with, without, options, visible, report, error));
    return result;
}
