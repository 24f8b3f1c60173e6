/* SPDX-License-Identifier: Apache-2.0 */
/* What the public interface does with pictures of light field cameras. */
#include "api/handles.h"
#include "core/basics.h"
#include "io/exr_make.h"
#include "verbs/lightfield.h"

static mcv_result make_views(const mcv_command *command, const mcv_light_field_file *file,
                             const mcv_processed_files *files, mcv_exr *views, mcv_report *report,
                             mcv_error *error) {
    MCV_TRY(mcv_views_make(file, views, error));
    const mcv_result result = mcv_views_write(file, files, views, error);
    if (result == MCV_OK)
        mcv_processed_report(command, file, files, NULL, 0, report);
    else
        mcv_exr_free(views);
    return result;
}

static mcv_result make_gradient(const mcv_command *command, const mcv_light_field_file *file,
                                const mcv_processed_files *files, mcv_exr *gradient,
                                mcv_report *report, mcv_error *error) {
    const double begun = mcv_seconds();
    MCV_TRY(mcv_gradient_make(command, file, gradient, error));
    const double spent = mcv_seconds() - begun;
    const mcv_result result = mcv_gradient_write(command, files, gradient, error);
    if (result == MCV_OK)
        mcv_processed_report(command, file, files, gradient, spent, report);
    else
        mcv_exr_free(gradient);
    return result;
}

/* One of the two above. */
typedef mcv_result make_call(const mcv_command *command, const mcv_light_field_file *file,
                             const mcv_processed_files *files, mcv_exr *made, mcv_report *report,
                             mcv_error *error);

static mcv_result process_file(const mcv_command *command, const mcv_picture *picture,
                               make_call *make, mcv_picture **made, mcv_report *report,
                               mcv_error *error) {
    mcv_processed_files files;
    mcv_light_field_file file;
    mcv_exr copy, exr;
    MCV_TRY(mcv_processed_plan(command, &files, error));
    MCV_TRY(mcv_exr_copy(&picture->exr, &copy, error));
    MCV_TRY(mcv_light_field_of(&copy, picture->path, command->angular, &file, error));
    const mcv_result result = make(command, &file, &files, &exr, report, error);
    mcv_light_field_free(&file);
    return result == MCV_OK ? mcv_picture_of(&exr, picture->path, made, error) : result;
}

/* Makes of a light field image what `make` makes. */
static mcv_result process(const mcv_picture *picture, const char *verb, const char *options,
                          make_call *make, mcv_picture **made, char **report, mcv_error *error) {
    const char *const arguments[2] = {verb, picture->path};
    mcv_options_given given;
    mcv_report r;
    MCV_TRY(mcv_options_read(options, NULL, MCV_VERB_LIGHTFIELD, arguments, NULL, &given, error));
    mcv_result result = mcv_report_keep(&r, given.command.json, error);
    if (result == MCV_OK) result = process_file(&given.command, picture, make, made, &r, error);
    if (result == MCV_OK && report)
        result = mcv_report_take(&r, report, error);
    else
        mcv_report_free(&r);
    mcv_options_free(&given);
    if (result == MCV_OK) return MCV_OK;
    mcv_picture_free(*made);
    *made = NULL;
    return result;
}

mcv_result mcv_picture_views(const mcv_picture *picture, const char *options, mcv_picture **views,
                             char **report, mcv_error *error) {
    mcv_result result;
    MCV_NEED(views);
    *views = NULL;
    if (report) *report = NULL;
    MCV_NEED(picture);
    MCV_INSIDE(result, process(picture, "views", options, make_views, views, report, error));
    return result;
}

mcv_result mcv_picture_emd_gradient(const mcv_picture *picture, const char *options,
                                    mcv_picture **gradient, char **report, mcv_error *error) {
    mcv_result result;
    MCV_NEED(gradient);
    *gradient = NULL;
    if (report) *report = NULL;
    MCV_NEED(picture);
    MCV_INSIDE(result,
               process(picture, "emd-gradient", options, make_gradient, gradient, report, error));
    return result;
}
