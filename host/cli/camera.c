/* SPDX-License-Identifier: Apache-2.0 */
/* mcvisi camera: the grey values that a camera reads from a rendered image, and their files. */
#include "cli/camera.h"

#include "cli/tell.h"
#include "cli/verbs.h"
#include "core/basics.h"
#include "core/output_file.h"
#include "core/parallel.h"
#include "io/exr.h"
#include "io/png.h"
#include "io/values.h"
#include "scene/camera_model.h"
#include "verbs/grey_picture.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

bool mcv_camera_preview(const mcv_command *command, const char *grey, char preview[PATH_MAX]) {
    const char *dot = strrchr(grey, '.');
    if (!dot || mcv_ends_in(grey, ".exr") || (command->bits <= 8 && !mcv_ends_in(grey, ".npy")))
        return false;
    return snprintf(preview, PATH_MAX, "%.*s-preview.png", (int)(dot - grey), grey) < PATH_MAX;
}

mcv_result mcv_camera_check(const mcv_command *command, const char *grey, mcv_error *error) {
    if (!mcv_values_named(grey) && !mcv_ends_in(grey, ".exr"))
        return mcv_fail(error, MCV_USAGE,
                        "%s: the name of grey values must end in .exr, " MCV_VALUES_ENDINGS, grey);
    char preview[PATH_MAX];
    const mcv_camera_settings settings = mcv_camera_settings_of(command);
    MCV_TRY(mcv_camera_check_settings(&settings, error));
    MCV_TRY(mcv_output_check(grey, error));
    return mcv_camera_preview(command, grey, preview) ? mcv_output_check(preview, error) : MCV_OK;
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
                .preview = mcv_camera_preview(command, path, preview) ? preview : NULL,
                .picture = grey,
                .shown = &shown,
                .white = (double)((1u << command->bits) - 1)};
    mcv_in_parallel(2, write_one, &v);
    const int failed = v.results[0] == MCV_OK;
    if (v.results[failed] != MCV_OK) *error = v.errors[failed];
    return v.results[failed];
}

static mcv_result write_and_tell(const mcv_command *command, const mcv_exr *light,
                                 const mcv_exr *grey, const char *path, bool told,
                                 const mcv_read_out *out, mcv_error *error) {
    char preview[PATH_MAX];
    mcv_report report;
    MCV_TRY(mcv_ends_in(path, ".exr")
                ? mcv_exr_write(path, grey->parts, grey->part_count, grey->attributes,
                                grey->attribute_count, error)
                : write_values(command, light, grey, path, error));
    mcv_report_begin(&report, command->json, mcv_tell);
    mcv_grey_warn(path, grey, out, &report);
    if (!told) {
        mcv_report_free(&report);
        return MCV_OK;
    }
    mcv_grey_report(command, path, mcv_camera_preview(command, path, preview) ? preview : NULL,
                    grey, out, &report);
    return mcv_report_end(&report, error);
}

mcv_result mcv_camera_write(const mcv_command *command, const char *image, const char *path,
                            bool told, mcv_error *error) {
    mcv_exr light, grey;
    mcv_read_out out;
    MCV_TRY(mcv_exr_read(image, &light, error));
    mcv_result result = mcv_grey_make(command, image, &light, &out, &grey, error);
    if (result == MCV_OK) {
        result = write_and_tell(command, &light, &grey, path, told, &out, error);
        mcv_exr_free(&grey);
    }
    mcv_exr_free(&light);
    return result;
}

mcv_result mcv_verb_camera(const mcv_command *command, mcv_error *error) {
    if (!command->grey)
        return mcv_fail(error, MCV_USAGE,
                        "--output is missing: give the file of the grey values, as in -o grey.png");
    if (mcv_same_file(command->grey, command->argument))
        return mcv_fail(error, MCV_USAGE, "%s is the image: give the grey values another name",
                        command->grey);
    MCV_TRY(mcv_camera_check(command, command->grey, error));
    return mcv_camera_write(command, command->argument, command->grey, true, error);
}
