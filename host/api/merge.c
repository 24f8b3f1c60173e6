/* SPDX-License-Identifier: Apache-2.0 */
/* Joining parts of the public interface: films of renders. */
#include "api/handles.h"
#include "core/basics.h"
#include "core/output_file.h"
#include "io/png.h"
#include "verbs/merge.h"
#include "verbs/merge_tables.h"
#include "verbs/places.h"

#include <limits.h>
#include <stdio.h>
#include <string.h>

/* The preview's name: that of --png, or the image's. */
static mcv_result preview_name(const mcv_command *command, char name[PATH_MAX], mcv_error *error) {
    const char *dot = strrchr(command->merged, '.');
    const int stem = (int)(dot ? dot - command->merged : (long)strlen(command->merged));
    const int length = command->png ? snprintf(name, PATH_MAX, "%s", command->png)
                                    : snprintf(name, PATH_MAX, "%.*s.png", stem, command->merged);
    return length < PATH_MAX ? MCV_OK
                             : mcv_fail(error, MCV_USAGE, "the path of the output is too long");
}

/* Refuses outputs that cannot be written, or that are one of the parts. */
static mcv_result check_outputs(mcv_texts files, const char *image, const char *preview,
                                mcv_error *error) {
    const char *const outputs[] = {image, preview};
    if (!mcv_ends_in(image, ".exr"))
        return mcv_fail(error, MCV_USAGE, "--output %s: must end in .exr", image);
    for (int i = 0; i < 2; ++i) {
        for (size_t k = 0; k < files.count; ++k)
            if (mcv_same_file(outputs[i], files.items[k]))
                return mcv_fail(error, MCV_USAGE, "%s is one of the parts: give another name",
                                outputs[i]);
        MCV_TRY(mcv_output_check(outputs[i], error));
    }
    return MCV_OK;
}

static mcv_result write_merged(const mcv_exr *exr, const char *image, const char *preview,
                               mcv_report *report, mcv_error *error) {
    const mcv_attribute *unit = mcv_exr_attribute(exr, "mcvisi:unit");
    mcv_preview look = {.white = 0};
    MCV_TRY(mcv_exr_write(image, exr->parts, exr->part_count, exr->attributes, exr->attribute_count,
                          error));
    MCV_TRY(mcv_png_write_preview(preview, &exr->parts[0].image,
                                  unit && unit->text ? unit->text : "", &look, error));
    mcv_report_text(report, "image", image);
    mcv_report_text(report, "preview", preview);
    return MCV_OK;
}

static mcv_result merge_films(mcv_texts files, const mcv_command *command, mcv_picture **picture,
                              mcv_report *report, mcv_error *error) {
    char preview[PATH_MAX];
    mcv_exr exr;
    if (command->merged) {
        MCV_TRY(preview_name(command, preview, error));
        MCV_TRY(check_outputs(files, command->merged, preview, error));
    }
    MCV_TRY(mcv_parts_merge(files, command->parts != 0, &exr, report, error));
    const mcv_result result =
        command->merged ? write_merged(&exr, command->merged, preview, report, error) : MCV_OK;
    if (result == MCV_OK && picture)
        return mcv_picture_of(&exr, command->merged ? command->merged : files.items[0], picture,
                              error);
    mcv_exr_free(&exr);
    return result;
}

static mcv_result films_merge(mcv_texts files, const char *options, mcv_picture **picture,
                              char **report, mcv_error *error) {
    mcv_options_given given;
    mcv_report r;
    const char *const arguments[2] = {files.items[0]};
    MCV_TRY(mcv_options_read(options, NULL, MCV_VERB_MERGE, arguments, NULL, &given, error));
    mcv_result result = mcv_report_keep(&r, given.command.json, error);
    if (result == MCV_OK) result = merge_films(files, &given.command, picture, &r, error);
    mcv_options_free(&given);
    if (result == MCV_OK && report) return mcv_report_take(&r, report, error);
    mcv_report_free(&r);
    return result;
}

static mcv_result tables_merge(mcv_texts files, const char *options, char **report,
                               mcv_error *error) {
    mcv_options_given given;
    mcv_report r;
    const char *const arguments[2] = {files.items[0]};
    static const char *const without[] = {"png", "parts", NULL};
    MCV_TRY(mcv_options_read(options, NULL, MCV_VERB_MERGE, arguments, without, &given, error));
    const char *output = given.command.merged;
    mcv_result result = mcv_report_keep(&r, given.command.json, error);
    if (result == MCV_OK && !output)
        result = mcv_fail(error, MCV_USAGE, "options: output: is missing: the joined table");
    if (result == MCV_OK) result = mcv_tables_join(files, output, given.command.again, &r, error);
    mcv_options_free(&given);
    if (result == MCV_OK && report) return mcv_report_take(&r, report, error);
    mcv_report_free(&r);
    return result;
}

mcv_result mcv_tables_merge(const char *const *files, size_t count, const char *options,
                            char **report, mcv_error *error) {
    mcv_result result;
    if (report) *report = NULL;
    MCV_NEED(files);
    for (size_t i = 0; i < count; ++i) MCV_NEED(files[i]);
    if (count == 0) return mcv_fail(error, MCV_USAGE, "there are no tables to merge");
    MCV_INSIDE(result, tables_merge((mcv_texts){files, count}, options, report, error));
    return result;
}

mcv_result mcv_films_merge(const char *const *files, size_t count, const char *options,
                           mcv_picture **picture, char **report, mcv_error *error) {
    mcv_result result;
    if (picture) *picture = NULL;
    if (report) *report = NULL;
    MCV_NEED(files);
    for (size_t i = 0; i < count; ++i) MCV_NEED(files[i]);
    if (count == 0) return mcv_fail(error, MCV_USAGE, "there are no film files to merge");
    MCV_INSIDE(result, films_merge((mcv_texts){files, count}, options, picture, report, error));
    return result;
}
