/* SPDX-License-Identifier: Apache-2.0 */
/* What `mcvisi camera` tells. */
#include "verbs/grey_picture.h"

#include <math.h>
#include <stdio.h>

void mcv_grey_report(const mcv_command *command, const char *path, const char *preview,
                     const mcv_exr *grey_values, const mcv_read_out *out, mcv_report *report) {
    const mcv_camera *camera = &out->camera;
    const mcv_exposure *exposure = &out->exposure;
    const mcv_image *grey = &grey_values->parts[0].image;
    const size_t count = (size_t)grey->width * grey->height * grey->channels;
    char per_unit[64];
    double mean = 0;
    for (size_t i = 0; i < count; ++i) mean += (double)grey->pixels[i] / (double)count;
    snprintf(per_unit, sizeof per_unit, "e-/(%s)", out->unit);
    const double *e = camera->electrons_per_unit;
    mcv_report_text(report, "image", path);
    if (preview) mcv_report_text(report, "preview", preview);
    mcv_report_numbers(report, "size", "", " x ", (const double[]){grey->width, grey->height}, 2);
    mcv_report_number(report, "channels", "", grey->channels);
    mcv_report_text(report, "lens_mtf", out->lens[0] ? out->lens : "none");
    if (out->speckle > 0) mcv_report_number(report, "speckle_contrast", "", out->speckle);
    if (e[0] == e[1] && e[1] == e[2])
        mcv_report_number(report, "electrons_per_unit", per_unit, e[0]);
    else
        mcv_report_spectrum(report, "electrons_per_unit", per_unit, e);
    mcv_report_number(report, "electrons", "e-", exposure->electrons);
    const double level = command->expose_to * command->full_well;
    if (isfinite(out->level)) mcv_report_quantity(report, "level", "e-", level, level * out->level);
    mcv_report_number(report, "dark_electrons", "e-", camera->dark_electrons);
    mcv_report_number(report, "brightest", "e-", exposure->brightest);
    mcv_report_number(report, "full_well", "e-", camera->full_well);
    mcv_report_number(report, "gain", "DN/e-", camera->gain);
    mcv_report_number(report, "grey_value", "DN", mean);
    mcv_report_number(report, "saturated", "", (double)exposure->saturated / (double)count);
    mcv_report_number(report, "below_zero", "", (double)exposure->below_zero / (double)count);
}

void mcv_grey_warn(const char *path, const mcv_exr *grey, const mcv_read_out *out,
                   mcv_report *report) {
    const mcv_exposure *exposure = &out->exposure;
    const mcv_image *image = &grey->parts[0].image;
    const double count = (double)image->width * image->height * image->channels;
    char text[1024];
    if (exposure->saturated == 0) return;
    snprintf(text, sizeof text,
             "%.512s: %llu of %.0f values (%.3g %%) are saturated; the brightest has %.4g of %.4g "
             "e- on average",
             path, (unsigned long long)exposure->saturated, count,
             100 * (double)exposure->saturated / count, exposure->brightest, out->camera.full_well);
    mcv_report_tell(report, "warning", text);
}
