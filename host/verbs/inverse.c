/* SPDX-License-Identifier: Apache-2.0 */
#include "verbs/inverse.h"

#include "core/basics.h"
#include "core/output_file.h"
#include "io/exr_make.h"
#include "verbs/transport.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* --- options --- */

static mcv_result check_exr(const char *option, const char *path, mcv_error *error) {
    if (!path) return MCV_OK;
    if (!mcv_ends_in(path, ".exr"))
        return mcv_fail(error, MCV_USAGE, "--%s %s: must end in .exr", option, path);
    return mcv_output_check(path, error);
}

mcv_result mcv_inverse_plan(const mcv_command *command, mcv_error *error) {
    MCV_TRY(check_exr("output", command->inverse, error));
    MCV_TRY(check_exr("good-image", command->good_image, error));
    MCV_TRY(check_exr("defect-image", command->bad_image, error));
    if (command->bad_image && !command->bad)
        return mcv_fail(error, MCV_USAGE, "--defect-image: needs the matrix --defect F.npz");
    return command->inverse_png ? mcv_output_check(command->inverse_png, error) : MCV_OK;
}

mcv_result mcv_inverse_read(const mcv_command *command, const mcv_matrix *matrix,
                            mcv_inverse *inverse, mcv_error *error) {
    char item[300];
    const char *shown;
    mcv_error why;
    *inverse =
        (mcv_inverse){.method = command->method ? MCV_INVERSE_LEAST_SQUARES : MCV_INVERSE_REPLAY,
                      .dark = command->field == 1,
                      .damping = command->damping,
                      .bits = (uint32_t)command->pattern_bits};
    snprintf(item, sizeof item, "%s%s", command->emitter ? command->emitter : "",
             command->emitter ? "=" : "");
    if (mcv_pattern_group(matrix, "emitter", item, &inverse->group, &shown, &why) == MCV_OK)
        return MCV_OK;
    if (command->emitter)
        return mcv_fail(error, MCV_USAGE,
                        "--emitter %s: the matrix has no emitter of this name with pixels",
                        command->emitter);
    return mcv_fail(error, MCV_USAGE,
                    "the matrix has no emitter with pixels, or several of which --emitter must "
                    "name one");
}

/* --- pictures --- */

mcv_result mcv_inverse_make(const mcv_matrix *matrix, const mcv_inverse *inverse, mcv_exr *exr,
                            mcv_error *error) {
    const mcv_attribute attributes[] = {
        {.name = "mcvisi:quantity", .text = "pattern"},
        {.name = "mcvisi:unit", .text = ""},
        {.name = "mcvisi:errorFreedom", .numbers = {matrix->replicates - 1.0}, .count = 1}};
    mcv_image pattern, deviation;
    *exr = (mcv_exr){0};
    MCV_TRY(mcv_inverse_pattern(matrix, inverse, &pattern, &deviation, error));
    mcv_result result = mcv_exr_add_part(exr, "image", pattern, NULL, error);
    if (result == MCV_OK)
        result = mcv_exr_add_part(exr, "error", deviation, NULL, error);
    else
        mcv_image_free(&deviation);
    if (result == MCV_OK) result = mcv_exr_set_attributes(exr, attributes, 3, error);
    if (result != MCV_OK) mcv_exr_free(exr);
    return result;
}

mcv_result mcv_inverse_shown(const mcv_inverse *inverse, const mcv_exr *picture,
                             const mcv_matrix *matrix, const char *path, float **pattern,
                             mcv_error *error) {
    const mcv_element_group *from = inverse->group, *to = mcv_matrix_group(matrix, from->emitter);
    const mcv_image *image = &picture->parts[0].image;
    if (!to || to->width != from->width || to->height != from->height)
        return mcv_fail(error, MCV_BAD_INPUT, "%s: has no emitter \"%s\" with %u x %u pixels", path,
                        from->emitter, from->width, from->height);
    float *shown = calloc((size_t)matrix->element_count * matrix->channels + 1, sizeof *shown);
    if (!shown) return mcv_fail(error, MCV_FAILED, "no memory for a pattern");
    for (size_t i = 0; i < (size_t)to->width * to->height; ++i)
        for (uint32_t c = 0; c < matrix->channels; ++c)
            shown[(to->first + i) * matrix->channels + c] = image->pixels[i];
    *pattern = shown;
    return MCV_OK;
}

/* --- what is told --- */

void mcv_inverse_report(const mcv_inverse *inverse, const mcv_exr *picture, mcv_report *report) {
    static const char *const methods[] = {"replay", "least-squares"};
    const mcv_image *pattern = &picture->parts[0].image, *deviation = &picture->parts[1].image;
    const size_t count = (size_t)pattern->width * pattern->height;
    double sum = 0, lit = 0, squares = 0;
    for (size_t i = 0; i < count; ++i) {
        sum += (double)pattern->pixels[i];
        lit += pattern->pixels[i] > 0;
        squares += pow((double)deviation->pixels[i], 2);
    }
    mcv_report_text(report, "emitter", inverse->group->emitter);
    mcv_report_text(report, "field", inverse->dark ? "dark" : "bright");
    if (!inverse->dark) mcv_report_text(report, "method", methods[inverse->method]);
    mcv_report_numbers(report, "size", "", " x ", (const double[]){pattern->width, pattern->height},
                       2);
    mcv_report_number(report, "bits", "", inverse->bits);
    mcv_report_number(report, "lit_elements", "", lit / (double)count);
    mcv_report_number(report, "mean", "", sum / (double)count);
    if (lit > 0) mcv_report_number(report, "pattern_error", "", sqrt(squares / lit));
}
