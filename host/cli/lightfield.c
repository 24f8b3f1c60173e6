/* SPDX-License-Identifier: Apache-2.0 */
/* mcvisi lightfield: sub-aperture views and the Earth Mover's gradient of a light field image. */
#include "analysis/contrast.h"
#include "analysis/lightfield_file.h"
#include "cli/command.h"
#include "core/basics.h"
#include "cli/report.h"
#include "io/figure.h"
#include "core/output_file.h"
#include "io/png.h"

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

/* Attributes that are no longer valid: the result has no macro pixels and no black level. */
static bool is_past(const char *attribute) {
    return strcmp(attribute, "mcvisi:angularResolution") == 0 ||
           strcmp(attribute, "mcvisi:blackLevel") == 0;
}

/* Writes the parts with their own attributes and the still valid ones of their source. */
static mcv_result write_exr(const char *path, const mcv_exr *source, const mcv_exr_part *parts,
                            uint32_t part_count, const mcv_attribute *own, uint32_t own_count,
                            mcv_error *error) {
    mcv_attribute *attributes = malloc((own_count + source->attribute_count) * sizeof *attributes);
    uint32_t count = own_count;
    if (!attributes) return mcv_fail(error, MCV_FAILED, "%s: no memory for its header", path);
    memcpy(attributes, own, own_count * sizeof *own);
    for (uint32_t i = 0; i < source->attribute_count; ++i) {
        bool replaced = is_past(source->attributes[i].name);
        for (uint32_t k = 0; k < own_count; ++k)
            replaced = replaced || strcmp(own[k].name, source->attributes[i].name) == 0;
        if (!replaced) attributes[count++] = source->attributes[i];
    }
    const mcv_result result = mcv_exr_write(path, parts, part_count, attributes, count, error);
    free(attributes);
    return result;
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

/* The views of the image, and of each part that is as large: its errors. */
static mcv_result write_views_exr(const char *path, const mcv_light_field_file *file,
                                  const mcv_image *views, mcv_error *error) {
    const mcv_attribute own[] = {{.name = "mcvisi:layout", .text = "sub-aperture views"}};
    const mcv_exr *exr = &file->exr;
    mcv_exr_part *parts = calloc(exr->part_count, sizeof *parts);
    uint32_t count = 1;
    mcv_result result = MCV_OK;
    if (!parts) return mcv_fail(error, MCV_FAILED, "%s: no memory for its parts", path);
    parts[0] = (mcv_exr_part){.name = "image", .image = *views};
    for (uint32_t i = 1; i < exr->part_count && result == MCV_OK; ++i) {
        mcv_image light;
        if (exr->parts[i].image.width != file->image.width ||
            exr->parts[i].image.height != file->image.height)
            continue;
        result = mcv_light_field_light(path, exr->parts + i, &light, error);
        if (result == MCV_OK)
            result = mcv_light_field_views(&light, file->angular, &parts[count].image, error);
        if (result == MCV_OK) parts[count++].name = exr->parts[i].name;
    }
    if (result == MCV_OK) result = write_exr(path, exr, parts, count, own, 1, error);
    for (uint32_t i = 1; i < count; ++i) mcv_image_free(&parts[i].image);
    free(parts);
    return result;
}

static mcv_result write_views(const mcv_light_field_file *file, const outputs *out,
                              mcv_error *error) {
    mcv_image views;
    MCV_TRY(mcv_light_field_views(&file->image, file->angular, &views, error));
    mcv_result result = MCV_OK;
    if (out->exr) result = write_views_exr(out->exr, file, &views, error);
    if (out->png && result == MCV_OK)
        result = write_views_png(out->png, &views, file->angular, error);
    mcv_image_free(&views);
    return result;
}

/* --- gradient --- */

/* The report about a gradient. */
typedef struct account {
    mcv_spread spread;
    double seconds;
} account;

static const char *const forms[] = {"normalized", "mass"};

static mcv_result write_gradient(const mcv_command *command, const mcv_light_field_file *file,
                                 const outputs *out, account *told, mcv_error *error) {
    static const char *const units[] = {"fraction of the pupil",
                                        "fraction of the pupil x median mass"};
    const char *unit = units[command->form];
    const mcv_attribute own[] = {{.name = "mcvisi:quantity", .text = "Earth Mover's gradient"},
                                 {.name = "mcvisi:unit", .text = unit},
                                 {.name = "mcvisi:form", .text = forms[command->form]}};
    mcv_image gradient;
    char title[256];
    const double begun = mcv_seconds();
    MCV_TRY(mcv_light_field_gradient(&file->image, file->angular,
                                     command->form ? MCV_EMD_MASS : MCV_EMD_NORMALIZED,
                                     (uint32_t)command->threads, &gradient, error));
    told->seconds = mcv_seconds() - begun;
    told->spread = mcv_image_spread(&gradient, NULL);
    const mcv_color_scale scale = {.map = MCV_COLORMAP_VIRIDIS,
                                   .high = command->scale_end > 0 ? command->scale_end
                                                                  : mcv_preview_white(&gradient)};
    snprintf(title, sizeof title, "Earth Mover's gradient (%s) of %s", forms[command->form],
             command->second);
    mcv_result result = MCV_OK;
    if (out->exr)
        result =
            write_exr(out->exr, &file->exr, &(mcv_exr_part){.name = "image", .image = gradient}, 1,
                      own, sizeof own / sizeof own[0], error);
    if (out->png && result == MCV_OK)
        result = mcv_figure_write(out->png, &gradient, title, unit, &scale, error);
    mcv_image_free(&gradient);
    return result;
}

/* --- the verb --- */

static mcv_result report(const mcv_command *command, const mcv_light_field_file *file,
                         const outputs *out, const account *told, mcv_error *error) {
    const uint32_t *angular = file->angular;
    const uint32_t columns = file->image.width / angular[0], rows = file->image.height / angular[1];
    mcv_report r;
    mcv_report_begin(&r, command->json);
    mcv_report_text(&r, "image", command->second);
    mcv_report_numbers(&r, "macro_pixels", "", " x ", (const double[]){columns, rows}, 2);
    mcv_report_numbers(&r, "angular", "", " x ", (const double[]){angular[0], angular[1]}, 2);
    if (told) {
        mcv_report_text(&r, "form", forms[command->form]);
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
