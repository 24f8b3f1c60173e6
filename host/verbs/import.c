/* SPDX-License-Identifier: Apache-2.0 */
#include "verbs/import.h"

#include "core/basics.h"
#include "loader/load.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* What the reader lets pass the loader may still refuse. */
static mcv_result check(const char *from, const char *text, mcv_error *error) {
    mcv_document document;
    mcv_scene *scene = NULL;
    mcv_error refusal;
    MCV_TRY(mcv_document_parse(from, text, strlen(text), &document, error));
    const mcv_result result =
        mcv_scene_load_document(&document, (mcv_overrides){NULL, 0}, 0, NULL, &scene, &refusal);
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

/* A figure and, in brackets, the value that the file states. */
static void print_figure(FILE *out, const char *name, double value, double stated,
                         const char *before, double unit, const char *after) {
    fprintf(out, "%s ", name);
    if (isnan(value))
        fprintf(out, "none");
    else
        fprintf(out, "%s%.6g%s", before, value / unit, after);
    if (!isnan(stated)) fprintf(out, " (the file states %s%.6g%s)", before, stated / unit, after);
    fprintf(out, "\n");
}

static void print_lens(FILE *out, const mcv_lens_report *lens, const char *path) {
    if (path) {
        mcv_print_line(out, path);
        fputc('\n', out);
    }
    print_figure(out, "focal length", lens->focal_length, lens->stated_focal_length, "", 1e-3,
                 " mm");
    if (isinf(lens->object_distance)) {
        print_figure(out, "back focus", lens->back_focus, lens->stated_image_distance, "", 1e-3,
                     " mm");
    } else {
        print_figure(out, "back focus", lens->back_focus, NAN, "", 1e-3, " mm");
        print_figure(out, "object distance", lens->object_distance, NAN, "", 1e-3, " mm");
        print_figure(out, "image distance", lens->image_distance, lens->stated_image_distance, "",
                     1e-3, " mm");
    }
    print_figure(out, lens->working ? "working f-number" : "f-number", lens->f_number,
                 lens->stated_f_number, "f/", 1, "");
    fprintf(out, "wavelength %.5g nm\n", 1e9 * lens->wavelength);
}

static void report_figures(const mcv_lens_report *lens, mcv_report *report) {
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
}

void mcv_import_report(const mcv_lens_report *lens, const char *path, mcv_report *report) {
    if (report->json)
        report_figures(lens, report);
    else
        print_lens(report->out, lens, path);
    for (int i = 0; i < lens->warning_count; ++i)
        mcv_report_tell(report, "warning", lens->warnings[i]);
}
