/* SPDX-License-Identifier: Apache-2.0 */
/* Patterns of inverse schlieren, for the public interface. */
#include "api/handles.h"
#include "verbs/inverse.h"
#include "verbs/measure.h"

#include <stdlib.h>

typedef struct work {
    const mcv_command *command;
    mcv_inverse inverse;
    mcv_exr picture;
} work;

/* The figures of an image by the rules of `mcvisi measure`. */
static mcv_result measure(const work *w, const char *key, const mcv_picture *picture,
                          mcv_report *report, mcv_error *error) {
    mcv_command measured = *w->command;
    const char *region = w->command->lit_region;
    measured.region = (mcv_list){&region, region ? 1 : 0};
    measured.background = w->command->lit_background;
    mcv_report_open(report, key);
    const mcv_result result = mcv_measure(&measured, picture, NULL, NULL, report, error);
    mcv_report_close(report);
    return result;
}

/* The image of a matrix under the pattern: written where there is a path, and measured. */
static mcv_result show(const work *w, const char *key, const mcv_transport *transport,
                       const char *path, mcv_report *report, mcv_error *error) {
    float *pattern = NULL;
    mcv_picture *picture = NULL;
    MCV_TRY(mcv_inverse_shown(&w->inverse, &w->picture, &transport->matrix, transport->path,
                              &pattern, error));
    mcv_result result = mcv_transport_light(transport, pattern, &picture, error);
    if (result == MCV_OK && path) result = mcv_picture_write(picture, path, NULL, error);
    if (result == MCV_OK) result = measure(w, key, picture, report, error);
    mcv_picture_free(picture);
    free(pattern);
    return result;
}

/* The matrix of a file, whose image must have the places of the flawless part's. */
static mcv_result read_other(const char *path, const mcv_matrix *flawless, mcv_transport **other,
                             mcv_error *error) {
    if (!path) return MCV_OK;
    MCV_TRY(mcv_transport_read(path, other, error));
    const mcv_matrix *m = &(*other)->matrix;
    if (m->width == flawless->width && m->height == flawless->height &&
        m->channels == flawless->channels)
        return MCV_OK;
    return mcv_fail(
        error, MCV_BAD_INPUT,
        "%s: is of another set-up: its image has %u x %u pixels of %u channels, that of "
        "the pattern's matrix %u x %u of %u",
        path, m->width, m->height, m->channels, flawless->width, flawless->height,
        flawless->channels);
}

static mcv_result show_all(const work *w, const mcv_transport *transport, mcv_report *report,
                           mcv_error *error) {
    const mcv_command *c = w->command;
    mcv_transport *good = NULL, *bad = NULL;
    mcv_result result = read_other(c->good, &transport->matrix, &good, error);
    if (result == MCV_OK) result = read_other(c->bad, &transport->matrix, &bad, error);
    if (result == MCV_OK) {
        mcv_inverse_report(&w->inverse, &w->picture, report);
        result = show(w, "good_part", good ? good : transport, c->good_image, report, error);
    }
    if (result == MCV_OK && bad)
        result = show(w, "defective_part", bad, c->bad_image, report, error);
    mcv_transport_free(good);
    mcv_transport_free(bad);
    return result;
}

static mcv_result tell(const work *w, const mcv_transport *transport, char **report,
                       mcv_error *error) {
    mcv_report r;
    MCV_TRY(mcv_report_keep(&r, w->command->json, error));
    mcv_report_text(&r, "matrix", transport->path);
    mcv_result result = show_all(w, transport, &r, error);
    if (w->command->inverse) mcv_report_text(&r, "pattern", w->command->inverse);
    if (w->command->inverse_png) mcv_report_text(&r, "preview", w->command->inverse_png);
    if (result == MCV_OK && report) return mcv_report_take(&r, report, error);
    mcv_report_free(&r);
    return result;
}

static mcv_result write_pattern(const mcv_command *command, const mcv_picture *picture,
                                mcv_error *error) {
    if (command->inverse) MCV_TRY(mcv_picture_write(picture, command->inverse, NULL, error));
    return command->inverse_png ? mcv_picture_write(picture, command->inverse_png, NULL, error)
                                : MCV_OK;
}

static mcv_result invert(const mcv_command *command, const mcv_transport *transport,
                         mcv_picture **picture, char **report, mcv_error *error) {
    work w = {.command = command};
    MCV_TRY(mcv_inverse_plan(command, error));
    MCV_TRY(mcv_inverse_read(command, &transport->matrix, &w.inverse, error));
    MCV_TRY(mcv_inverse_make(&transport->matrix, &w.inverse, &w.picture, error));
    mcv_result result = tell(&w, transport, report, error);
    if (result != MCV_OK) {
        mcv_exr_free(&w.picture);
        return result;
    }
    MCV_TRY(mcv_picture_of(&w.picture, transport->path, picture, error));
    return write_pattern(command, *picture, error);
}

static mcv_result invert_by_options(const mcv_transport *transport, const char *options,
                                    mcv_picture **picture, char **report, mcv_error *error) {
    const char *const arguments[2] = {transport->path};
    mcv_options_given read;
    MCV_TRY(mcv_options_read(options, NULL, MCV_VERB_INVERSE, arguments, NULL, &read, error));
    const mcv_result result = invert(&read.command, transport, picture, report, error);
    mcv_options_free(&read);
    if (result == MCV_OK) return MCV_OK;
    mcv_picture_free(*picture);
    *picture = NULL;
    if (report) mcv_text_free(*report);
    if (report) *report = NULL;
    return result;
}

mcv_result mcv_transport_inverse(const mcv_transport *transport, const char *options,
                                 mcv_picture **picture, char **report, mcv_error *error) {
    mcv_result result;
    MCV_NEED(picture);
    *picture = NULL;
    if (report) *report = NULL;
    MCV_NEED(transport);
    MCV_INSIDE(result, invert_by_options(transport, options, picture, report, error));
    return result;
}
