/* SPDX-License-Identifier: Apache-2.0 */
/* The files of deflectometry, and what is told of it. */
#include "verbs/deflectometry.h"

#include <math.h>
#include <stdlib.h>

#include "core/basics.h"
#include "core/output_file.h"
#include "io/exr_make.h"
#include "io/figure.h"

/* One or two maps as a part; NaN where the part is not seen. */
static mcv_result add_maps(const mcv_shape *s, mcv_exr *exr, const char *name, const double *first,
                           const double *second, mcv_error *error) {
    static const char *const names[] = {"X", "Y"};
    const size_t count = (size_t)s->width * s->height;
    mcv_image image;
    MCV_TRY(mcv_image_new(&image, s->width, s->height, second ? 2 : 1, error));
    for (size_t i = 0; i < count; ++i) {
        image.pixels[i] = s->valid[i] ? (float)first[i] : NAN;
        if (second) image.pixels[count + i] = s->valid[i] ? (float)second[i] : NAN;
    }
    return mcv_exr_add_part(exr, name, image, second ? names : NULL, error);
}

/* The slopes as a picture has them: x to the right, y up. */
static mcv_result write_slopes(const char *path, const mcv_image *slopes, mcv_error *error) {
    const size_t plane = (size_t)slopes->width * slopes->height;
    mcv_image down;
    MCV_TRY(mcv_image_copy(slopes, &down, error));
    for (size_t i = plane; i < 2 * plane; ++i) down.pixels[i] = -down.pixels[i];
    const mcv_result result =
        mcv_vector_figure_write(path, &down, "Slopes in x and y", "slope [rad]", 0, error);
    mcv_image_free(&down);
    return result;
}

/* A member of what was decoded, across columns and across rows. */
enum { PLACE, MODULATION };

/* The part of the slopes. */
enum { SLOPES = 2 };

static mcv_result add_decoded(const mcv_deflectometry *d, mcv_exr *exr, const char *name,
                              int member, mcv_error *error) {
    const size_t count = (size_t)d->shape.width * d->shape.height;
    double *values = malloc((2 * count + 1) * sizeof *values);
    if (!values) return mcv_fail(error, MCV_FAILED, "no memory for a map");
    for (size_t i = 0; i < 2 * count; ++i) {
        const mcv_decoded *of = d->decoded[i / count] + i % count;
        values[i] = member == PLACE ? of->place : of->modulation;
    }
    const mcv_result result = add_maps(&d->shape, exr, name, values, values + count, error);
    free(values);
    return result;
}

mcv_result mcv_deflectometry_picture(const mcv_deflectometry *d, mcv_picture **picture,
                                     mcv_error *error) {
    static const mcv_attribute own[] = {{.name = "mcvisi:quantity", .text = "height"},
                                        {.name = "mcvisi:unit", .text = "m"}};
    const mcv_shape *s = &d->shape;
    mcv_exr exr = {0};
    mcv_result result = add_maps(s, &exr, "image", s->z, NULL, error);
    if (result == MCV_OK) result = add_maps(s, &exr, "error", s->u_z, NULL, error);
    if (result == MCV_OK) result = add_maps(s, &exr, "slope", s->p, s->q, error);
    if (result == MCV_OK) result = add_maps(s, &exr, "slope error", s->u_p, s->u_q, error);
    if (result == MCV_OK) result = add_maps(s, &exr, "place", s->x, s->y, error);
    if (result == MCV_OK) result = add_decoded(d, &exr, "screen", PLACE, error);
    if (result == MCV_OK) result = add_decoded(d, &exr, "modulation", MODULATION, error);
    if (result == MCV_OK) result = mcv_exr_set_attributes(&exr, own, 2, error);
    if (result == MCV_OK) return mcv_picture_of(&exr, "heights", picture, error);
    mcv_exr_free(&exr);
    return result;
}

mcv_result mcv_deflectometry_check(const mcv_command *command, mcv_error *error) {
    if (!command->plane)
        return mcv_fail(error, MCV_USAGE,
                        "--plane is missing: name the node about whose x-y plane the part lies");
    if (command->shape && !mcv_ends_in(command->shape, ".exr"))
        return mcv_fail(error, MCV_USAGE, "--output %s: must end in .exr", command->shape);
    if (command->shape_png && !mcv_ends_in(command->shape_png, ".png"))
        return mcv_fail(error, MCV_USAGE, "--png %s: must end in .png", command->shape_png);
    if (command->slope_png && !mcv_ends_in(command->slope_png, ".png"))
        return mcv_fail(error, MCV_USAGE, "--slope-png %s: must end in .png", command->slope_png);
    if (command->shape) MCV_TRY(mcv_output_check(command->shape, error));
    if (command->slope_png) MCV_TRY(mcv_output_check(command->slope_png, error));
    return command->shape_png ? mcv_output_check(command->shape_png, error) : MCV_OK;
}

mcv_result mcv_deflectometry_write(const mcv_command *command, const mcv_picture *picture,
                                   mcv_error *error) {
    const mcv_exr *exr = &picture->exr;
    const mcv_image *heights = &exr->parts[0].image;
    mcv_color_scale scale = {.map = MCV_COLORMAP_VIRIDIS, .low = INFINITY, .high = -INFINITY};
    for (size_t i = 0; i < (size_t)heights->width * heights->height; ++i) {
        scale.low = fmin(scale.low, (double)heights->pixels[i]);
        scale.high = fmax(scale.high, (double)heights->pixels[i]);
    }
    if (!(scale.low < scale.high)) scale.high = scale.low + 1e-9; /* a flat part: a nanometre */
    if (command->shape)
        MCV_TRY(mcv_exr_write(command->shape, exr->parts, exr->part_count, exr->attributes,
                              exr->attribute_count, error));
    if (command->shape_png)
        MCV_TRY(
            mcv_figure_write(command->shape_png, heights, "Heights", "height [m]", &scale, error));
    return command->slope_png ? write_slopes(command->slope_png, &exr->parts[SLOPES].image, error)
                              : MCV_OK;
}

/* --- what is told --- */

/* Root of the mean square of the valid pixels of a map. */
static double rms_of(const mcv_shape *s, const double *map) {
    double sum = 0;
    for (size_t i = 0; i < (size_t)s->width * s->height; ++i)
        if (s->valid[i]) sum += map[i] * map[i];
    return sqrt(sum / (double)s->valid_count);
}

static void report_fringes(const mcv_deflectometry *d, int direction, mcv_report *report) {
    const mcv_shape *s = &d->shape;
    double contrast = 0, noise = 0;
    for (size_t i = 0; i < (size_t)s->width * s->height; ++i) {
        if (!s->valid[i]) continue;
        contrast += d->decoded[direction][i].contrast / (double)s->valid_count;
        noise += pow(d->decoded[direction][i].phase_noise, 2) / (double)s->valid_count;
    }
    mcv_report_number(report, "period", "m", d->period[direction]);
    mcv_report_number(report, "contrast", "", contrast);
    mcv_report_number(report, "phase_noise", "rad", sqrt(noise));
    if (d->beats[direction] > 0) {
        /* The beat of P and P - 1 periods errs by a period and more where its noise, in periods,
         * leaves ± 1/2. */
        const double deviation =
            sqrt(noise) / (2 * M_PI) * hypot(d->beats[direction], d->beats[direction] - 1);
        mcv_report_number(report, "expected_period_errors", "",
                          deviation > 0 ? erfc(0.5 / (M_SQRT2 * deviation)) : 0);
    }
    mcv_report_number(report, "best_period", "m", d->best[direction]);
    mcv_report_number(report, "contrast_of_best", "", d->best_contrast[direction]);
}

void mcv_deflectometry_report(const mcv_deflectometry *d, mcv_report *report) {
    static const char *const directions[] = {"across_columns", "across_rows"};
    const mcv_shape *s = &d->shape;
    double low = INFINITY, high = -INFINITY;
    for (size_t i = 0; i < (size_t)s->width * s->height; ++i) {
        if (!s->valid[i]) continue;
        low = fmin(low, s->z[i]);
        high = fmax(high, s->z[i]);
    }
    mcv_report_number(report, "pixels", "", (double)s->valid_count);
    for (int k = 0; k < 2; ++k) {
        mcv_report_open(report, directions[k]);
        report_fringes(d, k, report);
        mcv_report_close(report);
    }
    mcv_report_number(report, "tilt_x", "rad", d->plane.slope[0]);
    mcv_report_number(report, "tilt_y", "rad", d->plane.slope[1]);
    if (d->form == MCV_FORM_QUADRIC) {
        mcv_report_number(report, "curvature_xx", "1/m", d->quadric.curvature[0]);
        mcv_report_number(report, "curvature_xy", "1/m", d->quadric.curvature[1]);
        mcv_report_number(report, "curvature_yy", "1/m", d->quadric.curvature[2]);
    }
    mcv_report_number(report, "height_peak_to_valley", "m", high - low);
    mcv_report_number(report, "height_rms", "m", rms_of(s, s->z));
    mcv_report_number(report, "height_uncertainty", "m", rms_of(s, s->u_z));
    mcv_report_number(report, "slope_uncertainty_x", "rad", rms_of(s, s->u_p));
    mcv_report_number(report, "slope_uncertainty_y", "rad", rms_of(s, s->u_q));
    mcv_report_number(report, "inconsistency", "m", s->residual);
}
