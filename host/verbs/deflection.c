/* SPDX-License-Identifier: Apache-2.0 */
#include "verbs/deflection.h"

#include "analysis/contrast.h"
#include "core/basics.h"
#include "core/output_file.h"
#include "io/exr_make.h"
#include "io/figure.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

mcv_result mcv_deflection_plan(const mcv_command *command, mcv_error *error) {
    const char *exr = command->deflected, *png = command->deflected_png,
               *histogram = command->directions;
    if (exr && !mcv_ends_in(exr, ".exr"))
        return mcv_fail(error, MCV_USAGE, "--output %s: must end in .exr", exr);
    if (histogram && !mcv_ends_in(histogram, ".exr"))
        return mcv_fail(error, MCV_USAGE, "--histogram %s: must end in .exr", histogram);
    if (png && !mcv_ends_in(png, ".png"))
        return mcv_fail(error, MCV_USAGE, "--png %s: must end in .png", png);
    if (exr) MCV_TRY(mcv_output_check(exr, error));
    if (histogram) MCV_TRY(mcv_output_check(histogram, error));
    return png ? mcv_output_check(png, error) : MCV_OK;
}

/* --- the picture --- */

/* The parts whose places in the picture are asked for. */
enum { TRANSMITTED = 4, LOST = 6 };

/* A part that takes the image over. */
static mcv_result add(mcv_exr *exr, const char *name, mcv_image *image, const char *const *channels,
                      mcv_error *error) {
    const mcv_image taken = *image;
    *image = (mcv_image){0};
    return mcv_exr_add_part(exr, name, taken, channels, error);
}

static mcv_result add_parts(mcv_deflection *d, mcv_exr *exr, mcv_error *error) {
    static const char *const vector[] = {"x", "y"}, *const matrix[] = {"xx", "xy", "yy"};
    mcv_image lost;
    MCV_TRY(mcv_image_copy(&d->transmitted, &lost, error));
    for (size_t i = 0; i < (size_t)lost.width * lost.height; ++i)
        lost.pixels[i] = 1 - lost.pixels[i];
    MCV_TRY(add(exr, "image", &d->mean, vector, error));
    MCV_TRY(add(exr, "error", &d->mean_error, vector, error));
    MCV_TRY(add(exr, "covariance", &d->covariance, matrix, error));
    MCV_TRY(add(exr, "covariance error", &d->covariance_error, matrix, error));
    MCV_TRY(add(exr, "transmitted", &d->transmitted, NULL, error));
    MCV_TRY(add(exr, "transmitted error", &d->transmitted_error, NULL, error));
    return add(exr, "lost", &lost, NULL, error);
}

static mcv_result add_text(const mcv_matrix *matrix, const char *key, mcv_exr *exr,
                           mcv_error *error) {
    const mcv_attribute attribute = {
        .name = key, .text = json_string_value(json_object_get(matrix->attributes, key))};
    return attribute.text ? mcv_exr_set_attributes(exr, &attribute, 1, error) : MCV_OK;
}

/* The attributes of a picture: its own, and those of the matrix that still hold. */
static mcv_result add_attributes(const mcv_matrix *matrix, const mcv_attribute *own, uint32_t count,
                                 mcv_exr *exr, mcv_error *error) {
    static const char *const kept[] = {"mcvisi:version", "mcvisi:scene", "mcvisi:sensor",
                                       "mcvisi:cameraModel"};
    MCV_TRY(mcv_exr_set_attributes(exr, own, count, error));
    for (size_t i = 0; i < sizeof kept / sizeof kept[0]; ++i)
        MCV_TRY(add_text(matrix, kept[i], exr, error));
    return MCV_OK;
}

mcv_result mcv_deflection_make(mcv_deflection *d, const mcv_matrix *matrix, mcv_exr *image,
                               mcv_exr *histogram, mcv_error *error) {
    const mcv_attribute freedom = {
        .name = "mcvisi:errorFreedom", .numbers = {matrix->replicates - 1.0}, .count = 1};
    const mcv_attribute of_image[] = {{.name = "mcvisi:quantity", .text = "deflection"},
                                      {.name = "mcvisi:unit", .text = ""},
                                      freedom};
    const mcv_attribute of_histogram[] = {
        {.name = "mcvisi:quantity", .text = "share of a place's light"},
        {.name = "mcvisi:unit", .text = ""},
        {.name = "mcvisi:angularResolution", .numbers = {d->bins[0], d->bins[1]}, .count = 2},
        freedom};
    *image = *histogram = (mcv_exr){0};
    mcv_result result = add_parts(d, image, error);
    if (result == MCV_OK) result = add(histogram, "image", &d->histogram, NULL, error);
    if (result == MCV_OK) result = add(histogram, "error", &d->histogram_error, NULL, error);
    if (result == MCV_OK) result = add_attributes(matrix, of_image, 3, image, error);
    if (result == MCV_OK) result = add_attributes(matrix, of_histogram, 4, histogram, error);
    mcv_deflection_free(d);
    if (result == MCV_OK) return MCV_OK;
    mcv_exr_free(image);
    mcv_exr_free(histogram);
    return result;
}

/* --- files and words --- */

static mcv_result write_exr(const char *path, const mcv_exr *exr, mcv_error *error) {
    if (!path) return MCV_OK;
    return mcv_exr_write(path, exr->parts, exr->part_count, exr->attributes, exr->attribute_count,
                         error);
}

mcv_result mcv_deflection_write(const mcv_command *command, const mcv_exr *exr,
                                const mcv_exr *histogram, const char *name, mcv_error *error) {
    char title[256];
    MCV_TRY(write_exr(command->deflected, exr, error));
    MCV_TRY(write_exr(command->directions, histogram, error));
    if (!command->deflected_png) return MCV_OK;
    snprintf(title, sizeof title, "Deflection of %s", name);
    return mcv_vector_figure_write(command->deflected_png, &exr->parts[0].image, title,
                                   "deflection", command->strongest, error);
}

void mcv_deflection_report(const mcv_exr *exr, const mcv_exr *histogram, mcv_report *report) {
    const mcv_image *vectors = &exr->parts[0].image, *shares = &exr->parts[TRANSMITTED].image,
                    *lost = &exr->parts[LOST].image;
    const size_t plane = (size_t)vectors->width * vectors->height;
    mcv_image y = *vectors;
    double largest = NAN;
    y.pixels += plane;
    for (size_t i = 0; i < plane; ++i)
        largest = fmax(largest, (double)hypotf(vectors->pixels[i], vectors->pixels[plane + i]));
    const double size[] = {vectors->width, vectors->height};
    const double *bins = mcv_exr_numbers(histogram, "mcvisi:angularResolution", 2);
    const double means[] = {mcv_image_spread(vectors, NULL).mean, mcv_image_spread(&y, NULL).mean};
    mcv_report_numbers(report, "places", "", " x ", size, 2);
    mcv_report_numbers(report, "directions", "", " x ", bins, 2);
    mcv_report_numbers(report, "mean", "", ", ", means, 2);
    mcv_report_number(report, "largest", "", largest);
    mcv_report_number(report, "transmitted", "", mcv_image_spread(shares, NULL).mean);
    mcv_report_number(report, "lost", "", mcv_image_spread(lost, NULL).mean);
}
