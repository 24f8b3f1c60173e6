/* SPDX-License-Identifier: Apache-2.0 */
/* Images from light transport matrices, for the public interface. */
#include "api/handles.h"
#include "core/basics.h"
#include "core/output_file.h"
#include "verbs/measure.h"
#include "verbs/transport.h"

#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

mcv_result mcv_transport_light(const mcv_transport *transport, const float *pattern,
                               mcv_picture **picture, mcv_error *error) {
    const mcv_matrix *m = &transport->matrix;
    mcv_image mean, deviation;
    MCV_TRY(mcv_matrix_relight(m, pattern, &mean, &deviation, error));
    char *attributes = m->attributes ? json_dumps(m->attributes, JSON_REAL_PRECISION(17)) : NULL;
    const mcv_result result =
        mcv_picture_make(m->width, m->height, m->channels, mean.pixels,
                         m->replicates > 1 ? deviation.pixels : NULL, attributes, picture, error);
    free(attributes);
    mcv_image_free(&mean);
    mcv_image_free(&deviation);
    return result;
}

static mcv_result check_relit(const mcv_command *command, mcv_error *error) {
    if (command->relit && !mcv_ends_in(command->relit, ".exr"))
        return mcv_fail(error, MCV_USAGE, "--output %s: must end in .exr", command->relit);
    if (command->relit) MCV_TRY(mcv_output_check(command->relit, error));
    return command->relit_png ? mcv_output_check(command->relit_png, error) : MCV_OK;
}

/* The figures of --region, by the rules of `mcvisi measure`. */
static mcv_result measure(const mcv_command *command, const mcv_picture *picture,
                          mcv_report *report, mcv_error *error) {
    mcv_command measured = *command;
    const char *region = command->lit_region;
    if (!region && command->fit == 0) return MCV_OK;
    measured.region = (mcv_list){&region, region ? 1 : 0};
    measured.background = command->lit_background;
    mcv_report_open(report, "figures");
    const mcv_result result = mcv_measure(&measured, picture, NULL, NULL, report, error);
    mcv_report_close(report);
    return result;
}

static mcv_result tell_relit(const mcv_command *command, const mcv_transport *transport,
                             const mcv_picture *picture, const mcv_fitted *fitted, double seconds,
                             char **report, mcv_error *error) {
    mcv_report r;
    if (!report) return MCV_OK;
    MCV_TRY(mcv_report_keep(&r, command->json, error));
    mcv_report_text(&r, "matrix", transport->path);
    mcv_report_number(&r, "seconds", "s", seconds);
    if (command->relit) mcv_report_text(&r, "image", command->relit);
    if (command->relit_png) mcv_report_text(&r, "preview", command->relit_png);
    if (fitted->weights) mcv_fitted_report(fitted, &transport->matrix, &r);
    const mcv_result result = measure(command, picture, &r, error);
    if (result == MCV_OK) return mcv_report_take(&r, report, error);
    mcv_report_free(&r);
    return result;
}

static mcv_result write_relit(const mcv_command *command, const mcv_picture *picture,
                              mcv_error *error) {
    if (command->relit) MCV_TRY(mcv_picture_write(picture, command->relit, NULL, error));
    return command->relit_png ? mcv_picture_write(picture, command->relit_png, NULL, error)
                              : MCV_OK;
}

static mcv_result light_command(const mcv_command *command, const mcv_transport *transport,
                                float *pattern, mcv_picture **picture, char **report,
                                mcv_error *error) {
    mcv_fitted fitted = {NULL};
    const double begun = mcv_seconds();
    mcv_result result = MCV_OK;
    if (command->fit > 0)
        result = mcv_fitted_find(command, &transport->matrix, pattern, &fitted, error);
    if (result == MCV_OK) result = mcv_transport_light(transport, pattern, picture, error);
    const double seconds = mcv_seconds() - begun;
    if (result == MCV_OK) result = write_relit(command, *picture, error);
    if (result == MCV_OK)
        result = tell_relit(command, transport, *picture, &fitted, seconds, report, error);
    mcv_fitted_free(&fitted);
    return result;
}

static mcv_result check_pattern(const mcv_matrix *m, const float *pattern, size_t count,
                                mcv_error *error) {
    const size_t values = (size_t)m->element_count * m->channels;
    if (count != values)
        return mcv_fail(error, MCV_USAGE,
                        "a pattern of %zu values: must be %zu, %u elements of %u channels", count,
                        values, m->element_count, m->channels);
    for (size_t i = 0; i < count; ++i)
        if (!(pattern[i] >= 0 && pattern[i] <= 3.4e38f))
            return mcv_fail(error, MCV_BAD_INPUT,
                            "the pattern's value %zu is %g: must be finite and not negative", i,
                            (double)pattern[i]);
    return MCV_OK;
}

/* The given pattern, or that of the options; the caller frees it. */
static mcv_result take_pattern(const mcv_command *command, const mcv_matrix *m, const float *given,
                               size_t count, float **pattern, mcv_error *error) {
    *pattern = NULL;
    if (!given) return mcv_pattern_read(command, m, pattern, error);
    MCV_TRY(check_pattern(m, given, count, error));
    *pattern = malloc((count + 1) * sizeof **pattern);
    if (!*pattern) return mcv_fail(error, MCV_FAILED, "no memory for a pattern");
    memcpy(*pattern, given, count * sizeof **pattern);
    return MCV_OK;
}

static mcv_result relight(const mcv_transport *transport, const float *given, size_t count,
                          const char *options, mcv_picture **picture, char **report,
                          mcv_error *error) {
    const char *const arguments[2] = {transport->path};
    mcv_options_given read;
    float *pattern = NULL;
    MCV_TRY(mcv_options_read(options, NULL, MCV_VERB_RELIGHT, arguments, NULL, &read, error));
    const mcv_command *command = &read.command;
    mcv_result result = check_relit(command, error);
    if (result == MCV_OK && command->sequence)
        result = mcv_fail(error, MCV_USAGE, "sequence: mcv_transport_sequence makes its images");
    if (result == MCV_OK)
        result = take_pattern(command, &transport->matrix, given, count, &pattern, error);
    if (result == MCV_OK)
        result = light_command(command, transport, pattern, picture, report, error);
    free(pattern);
    mcv_options_free(&read);
    if (result == MCV_OK) return MCV_OK;
    mcv_picture_free(*picture);
    *picture = NULL;
    return result;
}

mcv_result mcv_transport_relight(const mcv_transport *transport, const float *pattern, size_t count,
                                 const char *options, mcv_picture **picture, char **report,
                                 mcv_error *error) {
    mcv_result result;
    MCV_NEED(picture);
    *picture = NULL;
    if (report) *report = NULL;
    MCV_NEED(transport);
    MCV_INSIDE(result, relight(transport, pattern, count, options, picture, report, error));
    return result;
}

/* --- sequences --- */

/* PATH-NUMBER.ending. */
static mcv_result number_path(const char *path, uint32_t number, char to[PATH_MAX],
                              mcv_error *error) {
    const char *ending = strrchr(path, '.');
    const size_t stem = ending ? (size_t)(ending - path) : strlen(path);
    if (snprintf(to, PATH_MAX, "%.*s-%u%s", (int)stem, path, number, path + stem) < PATH_MAX)
        return MCV_OK;
    return mcv_fail(error, MCV_USAGE, "--output %s: the path is too long", path);
}

static mcv_result write_numbered(const mcv_command *command, uint32_t number,
                                 const mcv_picture *picture, mcv_error *error) {
    char exr[PATH_MAX], png[PATH_MAX];
    mcv_command numbered = *command;
    if (command->relit) MCV_TRY(number_path(command->relit, number, exr, error));
    if (command->relit_png) MCV_TRY(number_path(command->relit_png, number, png, error));
    numbered.relit = command->relit ? exr : NULL;
    numbered.relit_png = command->relit_png ? png : NULL;
    return write_relit(&numbered, picture, error);
}

static mcv_result tell_sequence(const mcv_command *command, const mcv_transport *transport,
                                const mcv_sequence *sequence, double seconds, char **report,
                                mcv_error *error) {
    mcv_report r;
    if (!report) return MCV_OK;
    MCV_TRY(mcv_report_keep(&r, command->json, error));
    mcv_report_text(&r, "matrix", transport->path);
    mcv_report_text(&r, "emitter", sequence->group->emitter);
    mcv_report_text(&r, "pattern", mcv_pattern_types[sequence->pattern.type]);
    mcv_report_number(&r, "images", "", mcv_pattern_count(&sequence->pattern));
    mcv_report_number(&r, "seconds", "s", seconds);
    return mcv_report_take(&r, report, error);
}

static mcv_result light_sequence(const mcv_command *command, const mcv_transport *transport,
                                 const mcv_sequence *sequence, mcv_picture **pictures,
                                 char **report, mcv_error *error) {
    const double begun = mcv_seconds();
    float *pattern;
    mcv_result result = mcv_pattern_read(command, &transport->matrix, &pattern, error);
    for (uint32_t i = 0; i < mcv_pattern_count(&sequence->pattern) && result == MCV_OK; ++i) {
        mcv_sequence_show(sequence, transport->matrix.channels, i, pattern);
        result = mcv_transport_light(transport, pattern, pictures + i, error);
        if (result == MCV_OK) result = write_numbered(command, i, pictures[i], error);
    }
    free(pattern);
    return result == MCV_OK
               ? tell_sequence(command, transport, sequence, mcv_seconds() - begun, report, error)
               : result;
}

static mcv_result make_sequence(const mcv_transport *transport, const char *options,
                                mcv_picture **pictures, size_t room, size_t *count, char **report,
                                mcv_error *error) {
    const char *const arguments[2] = {transport->path};
    mcv_options_given read;
    mcv_sequence sequence;
    MCV_TRY(mcv_options_read(options, NULL, MCV_VERB_RELIGHT, arguments, NULL, &read, error));
    mcv_result result = check_relit(&read.command, error);
    if (result == MCV_OK && (!read.command.sequence || read.command.fit > 0))
        result = mcv_fail(error, MCV_USAGE, "sequence: must be a pattern, without a fit");
    if (result == MCV_OK)
        result = mcv_sequence_read(&read.command, &transport->matrix, &sequence, error);
    if (result == MCV_OK) *count = mcv_pattern_count(&sequence.pattern);
    if (result == MCV_OK && pictures && *count > room)
        result = mcv_fail(error, MCV_USAGE, "the sequence has %zu images, there is room for %zu",
                          *count, room);
    else if (result == MCV_OK && pictures)
        result = light_sequence(&read.command, transport, &sequence, pictures, report, error);
    mcv_options_free(&read);
    for (size_t i = 0; pictures && result != MCV_OK && i < room; ++i) {
        mcv_picture_free(pictures[i]);
        pictures[i] = NULL;
    }
    return result;
}

mcv_result mcv_transport_sequence(const mcv_transport *transport, const char *options,
                                  mcv_picture **pictures, size_t room, size_t *count, char **report,
                                  mcv_error *error) {
    mcv_result result;
    MCV_NEED(count);
    *count = 0;
    if (report) *report = NULL;
    for (size_t i = 0; pictures && i < room; ++i) pictures[i] = NULL;
    MCV_NEED(transport);
    MCV_INSIDE(result, make_sequence(transport, options, pictures, room, count, report, error));
    return result;
}
