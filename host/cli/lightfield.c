/* SPDX-License-Identifier: Apache-2.0 */
/* mcvisi lightfield: sub-aperture views and the Earth Mover's gradient of a light field image. */
#include "analysis/contrast.h"
#include "cli/verbs.h"
#include "core/basics.h"
#include "cli/tell.h"
#include "verbs/report.h"
#include "io/figure.h"
#include "core/output_file.h"
#include "io/png.h"
#include "verbs/lightfield.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* --- where to --- */

/* One may be NULL, but not both. */
typedef struct outputs {
    const char *exr, *png;
} outputs;

static mcv_result plan(const mcv_command *command, outputs *out, mcv_error *error) {
    const char *path = command->processed;
    if (!path)
        return mcv_fail(error, MCV_USAGE,
                        "--output is missing: give F.png for a picture or F.exr for the values");
    *out = (outputs){.exr = mcv_ends_in(path, ".exr") ? path : NULL,
                     .png = mcv_ends_in(path, ".png") ? path : command->picture};
    if (!mcv_ends_in(path, ".exr") && !mcv_ends_in(path, ".png"))
        return mcv_fail(error, MCV_USAGE, "--output %s: must end in .png or .exr", path);
    if (command->picture && !out->exr)
        return mcv_fail(error, MCV_USAGE, "--png goes with --output F.exr: %s is a picture already",
                        path);
    const char *const paths[] = {out->exr, out->png};
    for (int i = 0; i < 2; ++i) {
        if (!paths[i]) continue;
        if (mcv_same_file(paths[i], command->second))
            return mcv_fail(error, MCV_USAGE,
                            "%s is the light field image itself: give the output another name",
                            paths[i]);
        MCV_TRY(mcv_output_check(paths[i], error));
    }
    return MCV_OK;
}

static mcv_result write_exr(const char *path, const mcv_exr *exr, mcv_error *error) {
    return mcv_exr_write(path, exr->parts, exr->part_count, exr->attributes, exr->attribute_count,
                         error);
}

/* --- views --- */

/* The views, separated by grey lines. */
static mcv_result write_views_png(const char *path, const mcv_image *views,
                                  const uint32_t angular[2], mcv_error *error) {
    enum { LINE = 2 };
    mcv_image page;
    mcv_preview preview = {.white = mcv_preview_white(views)};
    const uint32_t width = views->width / angular[0], height = views->height / angular[1];
    MCV_TRY(mcv_image_new(&page, views->width + LINE * (angular[0] - 1),
                          views->height + LINE * (angular[1] - 1), views->channels, error));
    float *to = page.pixels;
    for (uint32_t row = 0; row < page.height * page.channels; ++row) {
        const uint32_t c = row / page.height, y = row % page.height;
        const uint32_t k = y / (height + LINE), n = y % (height + LINE);
        const float *from =
            views->pixels + ((size_t)c * views->height + (size_t)k * height + n) * views->width;
        for (uint32_t x = 0; x < page.width; ++x) {
            const uint32_t j = x / (width + LINE), m = x % (width + LINE);
            *to++ = m < width && n < height ? from[(size_t)j * width + m]
                                            : (float)(0.2 * preview.white);
        }
    }
    const mcv_result result = mcv_png_write_preview(path, &page, "", &preview, error);
    mcv_image_free(&page);
    return result;
}

static mcv_result write_views(const mcv_light_field_file *file, const outputs *out,
                              mcv_error *error) {
    mcv_exr views;
    MCV_TRY(mcv_views_make(file, &views, error));
    mcv_result result = out->exr ? write_exr(out->exr, &views, error) : MCV_OK;
    if (out->png && result == MCV_OK)
        result = write_views_png(out->png, &views.parts[0].image, file->angular, error);
    mcv_exr_free(&views);
    return result;
}

/* --- gradient --- */

/* The report about a gradient. */
typedef struct account {
    mcv_spread spread;
    double seconds;
} account;

static mcv_result write_gradient(const mcv_command *command, const mcv_light_field_file *file,
                                 const outputs *out, account *told, mcv_error *error) {
    mcv_exr gradient;
    char title[256];
    const double begun = mcv_seconds();
    MCV_TRY(mcv_gradient_make(command, file, &gradient, error));
    const mcv_image *image = &gradient.parts[0].image;
    told->seconds = mcv_seconds() - begun;
    told->spread = mcv_image_spread(image, NULL);
    const mcv_color_scale scale = {.map = MCV_COLORMAP_VIRIDIS,
                                   .high = command->scale_end > 0 ? command->scale_end
                                                                  : mcv_preview_white(image)};
    snprintf(title, sizeof title, "Earth Mover's gradient (%s) of %s", mcv_emd_forms[command->form],
             command->second);
    mcv_result result = out->exr ? write_exr(out->exr, &gradient, error) : MCV_OK;
    if (out->png && result == MCV_OK)
        result = mcv_figure_write(out->png, image, title,
                                  mcv_exr_attribute(&gradient, "mcvisi:unit")->text, &scale, error);
    mcv_exr_free(&gradient);
    return result;
}

/* --- the verb --- */

static mcv_result report(const mcv_command *command, const mcv_light_field_file *file,
                         const outputs *out, const account *told, mcv_error *error) {
    const uint32_t *angular = file->angular;
    const uint32_t columns = file->image.width / angular[0], rows = file->image.height / angular[1];
    mcv_report r;
    mcv_report_begin(&r, command->json, mcv_tell);
    mcv_report_text(&r, "image", command->second);
    mcv_report_numbers(&r, "macro_pixels", "", " x ", (const double[]){columns, rows}, 2);
    mcv_report_numbers(&r, "angular", "", " x ", (const double[]){angular[0], angular[1]}, 2);
    if (told) {
        mcv_report_text(&r, "form", mcv_emd_forms[command->form]);
        mcv_report_number(&r, "mean", "", told->spread.mean);
        mcv_report_number(&r, "deviation", "", told->spread.deviation);
        mcv_report_number(&r, "largest", "", told->spread.largest);
        mcv_report_number(&r, "seconds", "s", told->seconds);
    }
    if (out->exr) mcv_report_text(&r, "values", out->exr);
    if (out->png) mcv_report_text(&r, "picture", out->png);
    return mcv_report_end(&r, error);
}

mcv_result mcv_verb_lightfield(const mcv_command *command, mcv_error *error) {
    const bool views = strcmp(command->argument, "views") == 0;
    outputs out = {0};
    account told;
    mcv_light_field_file file;
    if (!views && strcmp(command->argument, "emd-gradient") != 0)
        return mcv_fail(error, MCV_USAGE,
                        "lightfield %s: must be `lightfield views` or `lightfield emd-gradient`",
                        command->argument);
    MCV_TRY(plan(command, &out, error));
    MCV_TRY(mcv_light_field_read(command->second, command->angular, &file, error));
    mcv_result result = views ? write_views(&file, &out, error)
                              : write_gradient(command, &file, &out, &told, error);
    if (result == MCV_OK) result = report(command, &file, &out, views ? NULL : &told, error);
    mcv_light_field_free(&file);
    return result;
}
