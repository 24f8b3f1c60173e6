/* SPDX-License-Identifier: Apache-2.0 */
/* mcvisi import: a lens file of a design program to a glTF file with exact surfaces, for a scene to
 * place. */
#include "cli/verbs.h"
#include "cli/tell.h"
#include "verbs/report.h"
#include "core/output_file.h"
#include "verbs/import.h"

#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Prints a figure and, in brackets, the value that the file states. */
static void print_figure(const char *name, double value, double stated, const char *before,
                         double unit, const char *after) {
    printf("%s ", name);
    if (isnan(value))
        printf("none");
    else
        printf("%s%.6g%s", before, value / unit, after);
    if (!isnan(stated)) printf(" (the file states %s%.6g%s)", before, stated / unit, after);
    printf("\n");
}

static void print_report(const mcv_lens_report *report) {
    print_figure("focal length", report->focal_length, report->stated_focal_length, "", 1e-3,
                 " mm");
    if (isinf(report->object_distance)) {
        print_figure("back focus", report->back_focus, report->stated_image_distance, "", 1e-3,
                     " mm");
    } else {
        print_figure("back focus", report->back_focus, NAN, "", 1e-3, " mm");
        print_figure("object distance", report->object_distance, NAN, "", 1e-3, " mm");
        print_figure("image distance", report->image_distance, report->stated_image_distance, "",
                     1e-3, " mm");
    }
    print_figure(report->working ? "working f-number" : "f-number", report->f_number,
                 report->stated_f_number, "f/", 1, "");
    printf("wavelength %.5g nm\n", 1e9 * report->wavelength);
    for (int i = 0; i < report->warning_count; ++i) mcv_tell("warning", report->warnings[i]);
}

mcv_result mcv_verb_import(const mcv_command *command, mcv_error *error) {
    const char *from = command->argument, *dot = strrchr(from, '.');
    char path[PATH_MAX];
    mcv_lens_report report;
    const int stem = dot ? (int)(dot - from) : (int)strlen(from);
    const int length = command->lens ? snprintf(path, sizeof path, "%s", command->lens)
                                     : snprintf(path, sizeof path, "%.*s.gltf", stem, from);
    if (length >= PATH_MAX)
        return mcv_fail(error, MCV_USAGE, "the path of the lens is longer than %d bytes", PATH_MAX);
    if (mcv_same_file(path, from))
        return mcv_fail(error, MCV_USAGE, "%s is the lens file: give the lens another name", path);
    char *text;
    MCV_TRY(mcv_import(command, &text, &report, error));
    const mcv_result result = mcv_output_whole(path, text, strlen(text), error);
    free(text);
    if (result != MCV_OK) return result;
    printf("%s\n", path);
    print_report(&report);
    return MCV_OK;
}
