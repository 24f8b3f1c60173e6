/* SPDX-License-Identifier: Apache-2.0 */
/* What the public interface does with two pictures, and with those of light field cameras. */
#include "api/handles.h"
#include "io/exr_make.h"
#include "verbs/compare.h"
#include "verbs/lightfield.h"

#include <stdlib.h>

static mcv_result make_difference(const mcv_compared *a, const mcv_compared *b,
                                  mcv_picture **difference, mcv_error *error) {
    static const mcv_attribute own[] = {
        {.name = "mcvisi:quantity", .text = "difference in standard errors"},
        {.name = "mcvisi:unit", .text = ""}};
    mcv_image image;
    mcv_exr exr = {0};
    MCV_TRY(mcv_compare_difference(&a->measured, &b->measured, &image, error));
    mcv_result result = mcv_exr_add_part(&exr, "image", image, NULL, error);
    if (result == MCV_OK)
        result = mcv_exr_set_attributes(&exr, own, sizeof own / sizeof own[0], error);
    if (result == MCV_OK) return mcv_picture_of(&exr, "the difference", difference, error);
    mcv_exr_free(&exr);
    return result;
}

static mcv_result compare_both(const mcv_compared *a, const mcv_compared *b,
                               mcv_picture **difference, char **report, mcv_error *error) {
    mcv_comparison comparison;
    mcv_report r;
    MCV_TRY(mcv_compare(a, b, &comparison, error));
    MCV_TRY(mcv_report_keep(&r, true, error));
    mcv_compare_report(a, b, &comparison, &r);
    MCV_TRY(mcv_report_take(&r, report, error));
    if (!difference) return MCV_OK;
    const mcv_result result = make_difference(a, b, difference, error);
    if (result == MCV_OK) return MCV_OK;
    free(*report);
    *report = NULL;
    return result;
}

static mcv_result compare(const mcv_picture *a, const mcv_picture *b, mcv_picture **difference,
                          char **report, mcv_error *error) {
    mcv_compared x, y = {.film = {0}};
    mcv_result result = mcv_compared_read(&a->exr, a->path, &x, error);
    if (result == MCV_OK) result = mcv_compared_read(&b->exr, b->path, &y, error);
    if (result == MCV_OK) result = compare_both(&x, &y, difference, report, error);
    mcv_film_free(&x.film);
    mcv_film_free(&y.film);
    return result;
}

mcv_result mcv_picture_compare(const mcv_picture *a, const mcv_picture *b, mcv_picture **difference,
                               char **report, mcv_error *error) {
    mcv_result result;
    MCV_NEED(report);
    *report = NULL;
    if (difference) *difference = NULL;
    MCV_NEED(a);
    MCV_NEED(b);
    MCV_INSIDE(result, compare(a, b, difference, report, error));
    return result;
}

/* --- light fields --- */

static mcv_result make_views(const mcv_command *command, const mcv_light_field_file *file,
                             mcv_exr *views, mcv_error *error) {
    (void)command;
    return mcv_views_make(file, views, error);
}

/* Makes one of a light field image what `make` makes. */
static mcv_result process(const mcv_picture *picture, const char *verb, const char *options,
                          mcv_result (*make)(const mcv_command *, const mcv_light_field_file *,
                                             mcv_exr *, mcv_error *),
                          mcv_picture **made, mcv_error *error) {
    static const char *const without[] = {"output", "png", "scale-end", "json", NULL};
    const char *const arguments[2] = {verb, picture->path};
    mcv_options_given given;
    mcv_light_field_file file;
    mcv_exr copy, exr;
    MCV_TRY(
        mcv_options_read(options, NULL, MCV_VERB_LIGHTFIELD, arguments, without, &given, error));
    mcv_result result = mcv_exr_copy(&picture->exr, &copy, error);
    if (result == MCV_OK)
        result = mcv_light_field_of(&copy, picture->path, given.command.angular, &file, error);
    if (result == MCV_OK) {
        result = make(&given.command, &file, &exr, error);
        mcv_light_field_free(&file);
    }
    mcv_options_free(&given);
    return result == MCV_OK ? mcv_picture_of(&exr, picture->path, made, error) : result;
}

mcv_result mcv_picture_views(const mcv_picture *picture, const char *options, mcv_picture **views,
                             mcv_error *error) {
    mcv_result result;
    MCV_NEED(views);
    *views = NULL;
    MCV_NEED(picture);
    MCV_INSIDE(result, process(picture, "views", options, make_views, views, error));
    return result;
}

mcv_result mcv_picture_emd_gradient(const mcv_picture *picture, const char *options,
                                    mcv_picture **gradient, mcv_error *error) {
    mcv_result result;
    MCV_NEED(gradient);
    *gradient = NULL;
    MCV_NEED(picture);
    MCV_INSIDE(result,
               process(picture, "emd-gradient", options, mcv_gradient_make, gradient, error));
    return result;
}
