/* SPDX-License-Identifier: Apache-2.0 */
/* Deflection of light, for the public interface. */
#include "api/handles.h"
#include "verbs/deflection.h"

/* What is made. */
typedef struct made {
    mcv_exr image, histogram;
} made;

static mcv_result tell(const mcv_command *command, const made *m, const char *path, char **report,
                       mcv_error *error) {
    mcv_report r;
    if (!report) return MCV_OK;
    MCV_TRY(mcv_report_keep(&r, command->json, error));
    mcv_report_text(&r, "matrix", path);
    mcv_deflection_report(&m->image, &m->histogram, &r);
    if (command->deflected) mcv_report_text(&r, "image", command->deflected);
    if (command->directions) mcv_report_text(&r, "histogram", command->directions);
    if (command->deflected_png) mcv_report_text(&r, "picture", command->deflected_png);
    return mcv_report_take(&r, report, error);
}

static mcv_result make(const mcv_transport *transport, const mcv_transport *reference, made *m,
                       mcv_error *error) {
    mcv_deflection deflection;
    MCV_TRY(mcv_deflection_of(&transport->matrix, reference ? &reference->matrix : NULL,
                              &deflection, error));
    return mcv_deflection_make(&deflection, &transport->matrix, &m->image, &m->histogram, error);
}

/* With the reference of the options, where none is given. */
static mcv_result deflect(const mcv_command *command, const mcv_transport *transport,
                          const mcv_transport *reference, made *m, char **report,
                          mcv_error *error) {
    mcv_transport *read = NULL;
    MCV_TRY(mcv_deflection_plan(command, error));
    if (!reference && command->undisturbed)
        MCV_TRY(mcv_transport_read(command->undisturbed, &read, error));
    mcv_result result = make(transport, read ? read : reference, m, error);
    mcv_transport_free(read);
    if (result == MCV_OK)
        result = mcv_deflection_write(command, &m->image, &m->histogram, transport->path, error);
    return result == MCV_OK ? tell(command, m, transport->path, report, error) : result;
}

/* The pictures of what was made, which change owners. */
static mcv_result hand_out(made *m, const char *path, mcv_picture **picture,
                           mcv_picture **histogram, mcv_error *error) {
    MCV_TRY(mcv_picture_of(&m->image, path, picture, error));
    if (!histogram) return MCV_OK;
    const mcv_result result = mcv_picture_of(&m->histogram, path, histogram, error);
    m->histogram = (mcv_exr){0};
    if (result == MCV_OK) return MCV_OK;
    mcv_picture_free(*picture);
    *picture = NULL;
    return result;
}

static mcv_result deflect_by_options(const mcv_transport *transport, const mcv_transport *reference,
                                     const char *options, mcv_picture **picture,
                                     mcv_picture **histogram, char **report, mcv_error *error) {
    const char *const arguments[2] = {transport->path};
    mcv_options_given read;
    made m = {{0}, {0}};
    MCV_TRY(mcv_options_read(options, NULL, MCV_VERB_DEFLECTION, arguments, NULL, &read, error));
    mcv_result result = deflect(&read.command, transport, reference, &m, report, error);
    mcv_options_free(&read);
    if (result == MCV_OK)
        result = hand_out(&m, transport->path, picture, histogram, error);
    else
        mcv_exr_free(&m.image);
    mcv_exr_free(&m.histogram);
    return result;
}

mcv_result mcv_transport_deflection(const mcv_transport *transport, const mcv_transport *reference,
                                    const char *options, mcv_picture **picture,
                                    mcv_picture **histogram, char **report, mcv_error *error) {
    mcv_result result;
    MCV_NEED(picture);
    *picture = NULL;
    if (histogram) *histogram = NULL;
    if (report) *report = NULL;
    MCV_NEED(transport);
    MCV_INSIDE(result, deflect_by_options(transport, reference, options, picture, histogram, report,
                                          error));
    return result;
}
