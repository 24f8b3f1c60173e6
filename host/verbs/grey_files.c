/* SPDX-License-Identifier: Apache-2.0 */
#include "verbs/grey_files.h"

#include "core/basics.h"
#include "core/output_file.h"
#include "core/parallel.h"
#include "io/exr.h"
#include "io/png.h"
#include "io/values.h"
#include "scene/camera_model.h"

#include <limits.h>
#include <stdio.h>
#include <string.h>

static bool find_preview(const mcv_command *command, const char *grey, char preview[PATH_MAX]) {
    const char *dot = strrchr(grey, '.');
    if (!dot || mcv_ends_in(grey, ".exr") || (command->bits <= 8 && !mcv_ends_in(grey, ".npy")))
        return false;
    return snprintf(preview, PATH_MAX, "%.*s-preview.png", (int)(dot - grey), grey) < PATH_MAX;
}

mcv_result mcv_grey_check_file(const mcv_command *command, const char *grey, mcv_error *error) {
    if (!mcv_values_named(grey) && !mcv_ends_in(grey, ".exr"))
        return mcv_fail(error, MCV_USAGE,
                        "%s: the name of grey values must end in .exr, " MCV_VALUES_ENDINGS, grey);
    char preview[PATH_MAX];
    const mcv_camera_settings settings = mcv_camera_settings_of(command);
    MCV_TRY(mcv_camera_check_settings(&settings, error));
    MCV_TRY(mcv_output_check(grey, error));
    return find_preview(command, grey, preview) ? mcv_output_check(preview, error) : MCV_OK;
}

/* Two files that are written in parallel. */
typedef struct values {
    const char *grey, *preview; /* NULL: none */
    const mcv_exr *picture;
    const mcv_image *shown;
    double white;
    mcv_result results[2];
    mcv_error errors[2];
} values;

static void write_one(void *user, size_t i) {
    values *v = user;
    mcv_preview shown = {.white = v->white};
    if (i == 0) v->results[0] = mcv_grey_write(v->grey, v->picture, v->errors);
    if (i == 1 && v->preview)
        v->results[1] = mcv_png_write_preview(v->preview, v->shown, "DN", &shown, v->errors + 1);
}

/* Grey values as they are, and a preview in which the largest is white: its values are no grey
 * values, and its header, that of the light, does not say so. */
static mcv_result write_values(const mcv_command *command, const mcv_exr *light,
                               const mcv_exr *grey, const char *path, mcv_error *error) {
    char preview[PATH_MAX];
    const mcv_attribute *model = mcv_exr_attribute(light, MCV_CAMERA_MODEL_KEY);
    mcv_image shown = grey->parts[0].image;
    if (shown.description) shown.description = (char *)model->text;
    values v = {.grey = path,
                .preview = find_preview(command, path, preview) ? preview : NULL,
                .picture = grey,
                .shown = &shown,
                .white = (double)((1u << command->bits) - 1)};
    mcv_in_parallel(2, write_one, &v);
    const int failed = v.results[0] == MCV_OK;
    if (v.results[failed] != MCV_OK) *error = v.errors[failed];
    return v.results[failed];
}

mcv_result mcv_grey_save(const mcv_command *command, const mcv_exr *light, const mcv_exr *grey,
                         const char *path, mcv_error *error) {
    return mcv_ends_in(path, ".exr") ? mcv_exr_write(path, grey->parts, grey->part_count,
                                                     grey->attributes, grey->attribute_count, error)
                                     : write_values(command, light, grey, path, error);
}

void mcv_grey_tell(const mcv_command *command, const char *path, const mcv_exr *grey,
                   const mcv_read_out *out, mcv_report *report) {
    char preview[PATH_MAX];
    mcv_grey_warn(path, grey, out, report);
    mcv_grey_report(command, path, find_preview(command, path, preview) ? preview : NULL, grey, out,
                    report);
}
