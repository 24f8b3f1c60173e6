/* SPDX-License-Identifier: Apache-2.0 */
/* The files of views and gradients, and what is told of them. */
#include "analysis/contrast.h"
#include "core/basics.h"
#include "core/output_file.h"
#include "io/figure.h"
#include "io/png.h"
#include "verbs/lightfield.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* --- where to --- */

mcv_result mcv_processed_plan(const mcv_command *command, mcv_processed_files *out,
                              mcv_error *error) {
    const char *path = command->processed;
    *out = (mcv_processed_files){0};
    if (!path && command->picture)
        return mcv_fail(error, MCV_USAGE, "--png goes with --output F.exr: give both");
    if (!path) return MCV_OK;
    *out = (mcv_processed_files){.exr = mcv_ends_in(path, ".exr") ? path : NULL,
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
    return command->ratio ? mcv_output_check(command->ratio, error) : MCV_OK;
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

mcv_result mcv_views_write(const mcv_light_field_file *file, const mcv_processed_files *out,
                           const mcv_exr *views, mcv_error *error) {
    if (out->exr) MCV_TRY(write_exr(out->exr, views, error));
    return out->png ? write_views_png(out->png, &views->parts[0].image, file->angular, error)
                    : MCV_OK;
}

/* --- gradient --- */

/* The gradient over its noise floor. */
static mcv_result write_ratio(const mcv_command *command, const mcv_exr *gradient,
                              mcv_error *error) {
    char title[256];
    const mcv_image *ratio = mcv_exr_image(gradient, MCV_GRADIENT_RATIO);
    if (!command->ratio) return MCV_OK;
    if (!ratio)
        return mcv_fail(error, MCV_BAD_INPUT,
                        "--ratio %s: %s states no standard errors, from which the noise floor "
                        "follows",
                        command->ratio, command->second);
    const mcv_color_scale scale = {.map = MCV_COLORMAP_VIRIDIS, .high = mcv_preview_white(ratio)};
    snprintf(title, sizeof title, "Earth Mover's gradient over its noise floor, of %s",
             command->second);
    return mcv_figure_write(command->ratio, ratio, title, "noise floors", &scale, error);
}

mcv_result mcv_gradient_write(const mcv_command *command, const mcv_processed_files *out,
                              const mcv_exr *gradient, mcv_error *error) {
    char title[256];
    const mcv_image *image = &gradient->parts[0].image;
    const mcv_color_scale scale = {.map = MCV_COLORMAP_VIRIDIS,
                                   .high = command->scale_end > 0 ? command->scale_end
                                                                  : mcv_preview_white(image)};
    snprintf(title, sizeof title, "Earth Mover's gradient (%s) of %s", mcv_emd_forms[command->form],
             command->second);
    if (out->exr) MCV_TRY(write_exr(out->exr, gradient, error));
    MCV_TRY(write_ratio(command, gradient, error));
    return out->png
               ? mcv_figure_write(out->png, image, title,
                                  mcv_exr_attribute(gradient, "mcvisi:unit")->text, &scale, error)
               : MCV_OK;
}

/* --- what is told --- */

void mcv_processed_report(const mcv_command *command, const mcv_light_field_file *file,
                          const mcv_processed_files *out, const mcv_exr *gradient, double seconds,
                          mcv_report *r) {
    const uint32_t *angular = file->angular;
    const uint32_t columns = file->image.width / angular[0], rows = file->image.height / angular[1];
    mcv_report_text(r, "image", command->second);
    mcv_report_numbers(r, "macro_pixels", "", " x ", (const double[]){columns, rows}, 2);
    mcv_report_numbers(r, "angular", "", " x ", (const double[]){angular[0], angular[1]}, 2);
    if (gradient) {
        const mcv_spread spread = mcv_image_spread(&gradient->parts[0].image, NULL);
        const mcv_image *noise_floor = mcv_exr_image(gradient, MCV_GRADIENT_FLOOR),
                        *ratio = mcv_exr_image(gradient, MCV_GRADIENT_RATIO);
        mcv_report_text(r, "form", mcv_emd_forms[command->form]);
        mcv_report_number(r, "mean", "", spread.mean);
        mcv_report_number(r, "deviation", "", spread.deviation);
        mcv_report_number(r, "largest", "", spread.largest);
        if (noise_floor) {
            mcv_report_number(r, "noise_floor", "", mcv_image_spread(noise_floor, NULL).mean);
            mcv_report_number(r, "largest_over_floor", "", mcv_image_spread(ratio, NULL).largest);
        }
        mcv_report_number(r, "seconds", "s", seconds);
    }
    if (out->exr) mcv_report_text(r, "values", out->exr);
    if (out->png) mcv_report_text(r, "picture", out->png);
    if (gradient && command->ratio) mcv_report_text(r, "ratio", command->ratio);
}
