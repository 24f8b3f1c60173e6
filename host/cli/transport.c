/* SPDX-License-Identifier: Apache-2.0 */
/* mcvisi transport, relight and deflection: light transport matrices, and what is made of them. */
#include "cli/client.h"
#include "cli/interrupt.h"
#include "cli/progress.h"
#include "cli/verbs.h"

#include <stdlib.h>
#include <string.h>

mcv_result mcv_verb_transport(const mcv_command *command, mcv_error *error) {
    mcv_command named = *command;
    mcv_client client = {0};
    mcv_transport *transport = NULL;
    char *report = NULL, *name = NULL;
    mcv_progress_shown shown = {.open = false};
    mcv_result result =
        command->matrix ? MCV_OK : mcv_client_name(command->argument, ".npz", &name, error);
    if (name) named.matrix = name;
    if (result == MCV_OK) result = mcv_client_open(&named, command->argument, &client, error);
    if (result == MCV_OK)
        result = mcv_session_transport(client.session, client.rig, client.options,
                                       mcv_progress_show, &shown, &transport, &report, error);
    if (shown.open) mcv_progress_end(&shown.line);
    if (result == MCV_OK) result = mcv_client_print(report, command->json, error);
    mcv_transport_free(transport);
    mcv_client_close(&client);
    free(name);
    return result == MCV_INTERRUPTED ? mcv_interrupt_result() : result;
}

/* All images of a sequence. */
static mcv_result light_sequence(const mcv_transport *transport, const char *options, char **report,
                                 mcv_error *error) {
    size_t count = 0;
    MCV_TRY(mcv_transport_sequence(transport, options, NULL, 0, &count, NULL, error));
    mcv_picture **pictures = calloc(count, sizeof(mcv_picture *));
    if (!pictures) return mcv_fail(error, MCV_FAILED, "no memory for %zu images", count);
    const mcv_result result =
        mcv_transport_sequence(transport, options, pictures, count, &count, report, error);
    for (size_t i = 0; i < count; ++i) mcv_picture_free(pictures[i]);
    free(pictures);
    return result;
}

mcv_result mcv_verb_relight(const mcv_command *command, mcv_error *error) {
    mcv_transport *transport = NULL;
    mcv_picture *picture = NULL;
    char *options = NULL, *report = NULL;
    if (!command->relit && !command->relit_png)
        return mcv_fail(error, MCV_USAGE,
                        "--output is missing: give the file of the image, as in -o relit.exr");
    mcv_result result = mcv_client_options(command, NULL, &options, error);
    if (result == MCV_OK) result = mcv_transport_read(command->argument, &transport, error);
    if (result == MCV_OK && command->sequence)
        result = light_sequence(transport, options, &report, error);
    else if (result == MCV_OK)
        result = mcv_transport_relight(transport, NULL, 0, options, &picture, &report, error);
    if (result == MCV_OK) result = mcv_client_print(report, command->json, error);
    mcv_picture_free(picture);
    mcv_transport_free(transport);
    free(options);
    return result;
}

/* The matrix of a file, or of a scene, which is rendered. */
static mcv_result open_matrix(const mcv_command *command, const char *const *own,
                              mcv_transport **transport, mcv_error *error) {
    const size_t length = strlen(command->argument);
    mcv_client client = {0};
    mcv_progress_shown shown = {.open = false};
    char *options = NULL;
    if (length > 4 && strcmp(command->argument + length - 4, ".npz") == 0)
        return mcv_transport_read(command->argument, transport, error);
    mcv_result result = mcv_client_options(command, own, &options, error);
    if (result == MCV_OK) result = mcv_client_open(command, command->argument, &client, error);
    if (result == MCV_OK)
        result = mcv_session_transport(client.session, client.rig, options, mcv_progress_show,
                                       &shown, transport, NULL, error);
    if (shown.open) mcv_progress_end(&shown.line);
    mcv_client_close(&client);
    free(options);
    return result == MCV_INTERRUPTED ? mcv_interrupt_result() : result;
}

mcv_result mcv_verb_deflection(const mcv_command *command, mcv_error *error) {
    static const char *const own[] = {"output", "png", "histogram", "reference", "scale-end", NULL};
    mcv_transport *transport = NULL;
    mcv_picture *picture = NULL;
    char *options = NULL, *report = NULL;
    if (!command->deflected && !command->deflected_png && !command->directions)
        return mcv_fail(error, MCV_USAGE,
                        "--output is missing: give F.exr for the values, or --png F.png");
    mcv_result result = mcv_client_options(command, NULL, &options, error);
    if (result == MCV_OK) result = open_matrix(command, own, &transport, error);
    if (result == MCV_OK)
        result = mcv_transport_deflection(transport, NULL, options, &picture, NULL, &report, error);
    if (result == MCV_OK) result = mcv_client_print(report, command->json, error);
    mcv_picture_free(picture);
    mcv_transport_free(transport);
    free(options);
    return result;
}

mcv_result mcv_verb_inverse(const mcv_command *command, mcv_error *error) {
    mcv_transport *transport = NULL;
    mcv_picture *pattern = NULL;
    char *options = NULL, *report = NULL;
    if (!command->inverse && !command->inverse_png)
        return mcv_fail(error, MCV_USAGE,
                        "--output is missing: give the file of the pattern, as in -o pattern.exr");
    mcv_result result = mcv_client_options(command, NULL, &options, error);
    if (result == MCV_OK) result = mcv_transport_read(command->argument, &transport, error);
    if (result == MCV_OK)
        result = mcv_transport_inverse(transport, options, &pattern, &report, error);
    if (result == MCV_OK) result = mcv_client_print(report, command->json, error);
    mcv_picture_free(pattern);
    mcv_transport_free(transport);
    free(options);
    return result;
}
