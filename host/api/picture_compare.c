/* SPDX-License-Identifier: Apache-2.0 */
/* What the public interface does with two pictures. */
#include "api/handles.h"
#include "core/output_file.h"
#include "io/exr_make.h"
#include "options/option_table.h"
#include "verbs/compare.h"

#include <string.h>

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

static mcv_result compare_both(const mcv_command *command, const mcv_compared *a,
                               const mcv_compared *b, bool *different, mcv_picture **difference,
                               char **report, mcv_error *error) {
    mcv_comparison comparison;
    mcv_report r;
    MCV_TRY(mcv_compare(a, b, &comparison, error));
    if (command->difference)
        MCV_TRY(mcv_compare_draw(command->difference, a, b, comparison.different, error));
    if (difference) MCV_TRY(make_difference(a, b, difference, error));
    if (different) *different = comparison.different;
    if (!report) return MCV_OK;
    MCV_TRY(mcv_report_keep(&r, command->json, error));
    mcv_compare_report(a, b, &comparison, &r);
    return mcv_report_take(&r, report, error);
}

static mcv_result compare_pictures(const mcv_command *command, const mcv_picture *a,
                                   const mcv_picture *b, bool *different, mcv_picture **difference,
                                   char **report, mcv_error *error) {
    mcv_compared x, y = {.film = {0}};
    if (command->difference) MCV_TRY(mcv_output_check(command->difference, error));
    mcv_result result = mcv_compared_read(&a->exr, a->path, &x, error);
    if (result == MCV_OK) result = mcv_compared_read(&b->exr, b->path, &y, error);
    if (result == MCV_OK)
        result = compare_both(command, &x, &y, different, difference, report, error);
    mcv_film_free(&x.film);
    mcv_film_free(&y.film);
    return result;
}

/* Options that are for the renders of a comparison, which are done. */
static void list_others(const char *names[MCV_OPTION_COUNT + 1]) {
    size_t count = 0;
    for (size_t i = 0; i < MCV_OPTION_COUNT; ++i) {
        const mcv_option *o = mcv_options + i;
        if (o->verbs & MCV_IN_COMPARE && strcmp(o->name, "output") != 0 &&
            strcmp(o->name, "json") != 0)
            names[count++] = o->name;
    }
    names[count] = NULL;
}

static mcv_result compare(const mcv_picture *a, const mcv_picture *b, const char *options,
                          bool *different, mcv_picture **difference, char **report,
                          mcv_error *error) {
    const char *without[MCV_OPTION_COUNT + 1];
    const char *const arguments[2] = {a->path, b->path};
    mcv_options_given given;
    list_others(without);
    MCV_TRY(mcv_options_read(options, NULL, MCV_VERB_COMPARE, arguments, without, &given, error));
    const mcv_result result =
        compare_pictures(&given.command, a, b, different, difference, report, error);
    mcv_options_free(&given);
    if (result == MCV_OK || !difference) return result;
    mcv_picture_free(*difference);
    *difference = NULL;
    return result;
}

mcv_result mcv_picture_compare(const mcv_picture *a, const mcv_picture *b, const char *options,
                               bool *different, mcv_picture **difference, char **report,
                               mcv_error *error) {
    mcv_result result;
    if (different) *different = false;
    if (difference) *difference = NULL;
    if (report) *report = NULL;
    MCV_NEED(a);
    MCV_NEED(b);
    MCV_INSIDE(result, compare(a, b, options, different, difference, report, error));
    return result;
}
