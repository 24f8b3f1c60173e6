/* SPDX-License-Identifier: Apache-2.0 */
/* What emitters show by --sequence and --fit of `mcvisi relight`. */
#include "transport/fit.h"
#include "verbs/transport.h"

#include <stdlib.h>
#include <string.h>

#include "core/json.h"

/* --- sequences --- */

/* The pattern as scenes have it; its resolution is that of the emitter's image. */
static mcv_result read_pattern(const char *text, const mcv_element_group *group,
                               mcv_pattern *pattern, mcv_error *error) {
    json_error_t wrong;
    const mcv_json_path place = mcv_place_file("--sequence");
    json_t *json = json_loads(text, JSON_REJECT_DUPLICATES, &wrong);
    if (!json)
        return mcv_fail(error, MCV_USAGE,
                        "--sequence %s: must be a pattern as in scenes, such as "
                        "{\"type\": \"phaseShift\", \"steps\": 4, \"periods\": 16}: %s",
                        text, mcv_json_wrong(&wrong));
    if (json_is_object(json) && !json_object_get(json, "resolution"))
        json_object_set_new(
            json, "resolution",
            json_pack("[I, I]", (json_int_t)group->width, (json_int_t)group->height));
    const mcv_result result = mcv_pattern_parse(json, pattern, &place, error);
    json_decref(json);
    return result == MCV_BAD_INPUT ? MCV_USAGE : result;
}

mcv_result mcv_sequence_read(const mcv_command *command, const mcv_matrix *matrix,
                             mcv_sequence *sequence, mcv_error *error) {
    const char *text;
    MCV_TRY(
        mcv_pattern_group(matrix, "sequence", command->sequence, &sequence->group, &text, error));
    const mcv_element_group *g = sequence->group;
    const mcv_pattern *p = &sequence->pattern;
    MCV_TRY(read_pattern(text, g, &sequence->pattern, error));
    if (p->resolution[0] != g->width || p->resolution[1] != g->height)
        return mcv_fail(error, MCV_USAGE,
                        "--sequence: resolution is %u x %u, the image of emitter \"%s\" has "
                        "%u x %u pixels",
                        p->resolution[0], p->resolution[1], g->emitter, g->width, g->height);
    if (p->resolution[p->orientation == MCV_ORIENTATION_VERTICAL ? 0 : 1] < 2)
        return mcv_fail(error, MCV_USAGE,
                        "--sequence: the image of emitter \"%s\" has one pixel across the "
                        "stripes: give the other orientation",
                        g->emitter);
    return MCV_OK;
}

void mcv_sequence_show(const mcv_sequence *sequence, uint32_t channels, uint32_t index,
                       float *pattern) {
    const mcv_element_group *g = sequence->group;
    const bool vertical = sequence->pattern.orientation == MCV_ORIENTATION_VERTICAL;
    for (uint32_t i = 0; i < g->width * g->height; ++i) {
        const double value =
            mcv_pattern_value(&sequence->pattern, index, vertical ? i % g->width : i / g->width);
        for (uint32_t c = 0; c < channels; ++c)
            pattern[((size_t)g->first + i) * channels + c] = (float)value;
    }
}

/* --- fits --- */

static mcv_result fit_regions(const mcv_command *command, const mcv_matrix *m, const float *pattern,
                              const mcv_roi regions[2], mcv_fitted *fitted, mcv_error *error) {
    if (command->fit == 1)
        return mcv_fit_uniform(m, pattern, regions, fitted->weights, fitted->errors, error);
    return mcv_fit_contrast(m, pattern, regions, regions + 1, fitted->weights, fitted->errors,
                            error);
}

/* Reads --region, by default the whole image, and --background. */
static mcv_result read_regions(const mcv_command *command, const mcv_matrix *m, mcv_roi regions[2],
                               mcv_error *error) {
    char all[64];
    mcv_image image;
    snprintf(all, sizeof all, "0,0,%u,%u", m->width, m->height);
    MCV_TRY(mcv_image_new(&image, m->width, m->height, 1, error));
    mcv_result result =
        mcv_roi_parse(command->lit_region ? command->lit_region : all, 1, &image, regions, error);
    if (result == MCV_OK && command->lit_background)
        result = mcv_roi_parse(command->lit_background, 2, &image, regions + 1, error);
    mcv_image_free(&image);
    return result;
}

mcv_result mcv_fitted_find(const mcv_command *command, const mcv_matrix *matrix, float *pattern,
                           mcv_fitted *fitted, mcv_error *error) {
    mcv_roi regions[2] = {{.inside = NULL}};
    *fitted = (mcv_fitted){malloc(matrix->group_count * sizeof *fitted->weights),
                           malloc(matrix->group_count * sizeof *fitted->errors)};
    if (!fitted->weights || !fitted->errors)
        return mcv_fail(error, MCV_FAILED, "no memory to fit %u weights", matrix->group_count);
    if (command->fit == 2 && (!command->lit_region || !command->lit_background))
        return mcv_fail(error, MCV_USAGE, "--fit contrast: give --region and --background");
    mcv_result result = read_regions(command, matrix, regions, error);
    if (result == MCV_OK) result = fit_regions(command, matrix, pattern, regions, fitted, error);
    for (uint32_t g = 0; g < matrix->group_count && result == MCV_OK; ++g) {
        const mcv_element_group *group = matrix->groups + g;
        float *values = pattern + (size_t)group->first * matrix->channels;
        for (size_t i = 0; i < (size_t)group->width * group->height * matrix->channels; ++i)
            values[i] *= (float)fitted->weights[g];
    }
    mcv_roi_free(regions);
    mcv_roi_free(regions + 1);
    return result;
}

void mcv_fitted_report(const mcv_fitted *fitted, const mcv_matrix *matrix, mcv_report *report) {
    mcv_report_list(report, "weights");
    for (uint32_t g = 0; g < matrix->group_count; ++g) {
        mcv_report_element(report, matrix->groups[g].emitter, matrix->groups[g].type);
        mcv_report_quantity(report, "weight", "", fitted->weights[g], fitted->errors[g]);
        mcv_report_close(report);
    }
    mcv_report_close(report);
}

void mcv_fitted_free(mcv_fitted *fitted) {
    free(fitted->weights);
    free(fitted->errors);
    *fitted = (mcv_fitted){NULL};
}
