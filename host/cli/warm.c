/* SPDX-License-Identifier: Apache-2.0 */
/* mcvisi warm: compiles ahead what renders of scenes, or of the rigs of `mcvisi new`, need. */
#include "cli/client.h"
#include "cli/verbs.h"
#include "core/output_file.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* A part of 10 mm: what a rig's programs are does not depend on its shape. */
static const char PART[] = "solid part\n"
                           "facet normal 0 0 -1\nouter loop\n"
                           "vertex 0 0 0\nvertex 0 10 0\nvertex 10 0 0\n"
                           "endloop\nendfacet\n"
                           "facet normal 0 -1 0\nouter loop\n"
                           "vertex 0 0 0\nvertex 10 0 0\nvertex 0 0 10\n"
                           "endloop\nendfacet\n"
                           "facet normal -1 0 0\nouter loop\n"
                           "vertex 0 0 0\nvertex 0 0 10\nvertex 0 10 0\n"
                           "endloop\nendfacet\n"
                           "facet normal 1 1 1\nouter loop\n"
                           "vertex 10 0 0\nvertex 0 10 0\nvertex 0 0 10\n"
                           "endloop\nendfacet\n"
                           "endsolid part\n";

static const struct {
    const char *kind, *light;
} RIGS[] = {{"telecentric", "backlight"}, {"telecentric", "ring"}, {"telecentric", "coaxial"},
            {"telecentric", "dome"},      {"entocentric", "ring"}, {"entocentric", "backlight"},
            {"entocentric", "coaxial"},   {"entocentric", "dome"}, {"lightfield", "auto"},
            {"transparent", "auto"}};

/* As one line of JSON, which names the rig. */
static mcv_result print_line(const char *report, const char *name, mcv_error *error) {
    json_t *document = json_loads(report, 0, NULL);
    if (name) json_object_set_new(document, "rig", json_string(name));
    char *text = json_dumps(document, JSON_COMPACT | JSON_REAL_PRECISION(17));
    json_decref(document);
    if (!text) return mcv_fail(error, MCV_FAILED, "no memory for the JSON");
    mcv_client_line(text);
    free(text);
    return MCV_OK;
}

static mcv_result warm_rig(const mcv_command *command, const mcv_client *client, const mcv_rig *rig,
                           const char *name, mcv_error *error) {
    char *report;
    MCV_TRY(mcv_session_warm(client->session, rig, client->options, &report, error));
    mcv_result result = MCV_OK;
    if (command->json) {
        result = print_line(report, name, error);
    } else {
        if (name) printf("mcvisi new %s\n", name);
        mcv_client_text(report);
    }
    mcv_text_free(report);
    if (result == MCV_OK && fflush(stdout) != 0)
        result = mcv_fail(error, MCV_FAILED, "standard output: %s", strerror(errno));
    return result;
}

static mcv_result warm_file(const mcv_command *command, const mcv_client *client, const char *path,
                            mcv_error *error) {
    mcv_rig *rig;
    MCV_TRY(mcv_rig_open(path, &rig, error));
    const mcv_result result = warm_rig(command, client, rig, NULL, error);
    mcv_rig_free(rig);
    return result;
}

static mcv_result warm_new(const mcv_command *command, const mcv_client *client, const char *part,
                           mcv_error *error) {
    for (size_t i = 0; i < sizeof RIGS / sizeof RIGS[0]; ++i) {
        char options[80], name[80], *report;
        mcv_rig *rig;
        snprintf(options, sizeof options, "{\"light\": \"%s\", \"unit\": \"mm\"}", RIGS[i].light);
        snprintf(name, sizeof name, "%s --light %s", RIGS[i].kind, RIGS[i].light);
        MCV_TRY(mcv_rig_new(RIGS[i].kind, part, options, &rig, &report, error));
        mcv_text_free(report);
        const mcv_result result = warm_rig(command, client, rig, name, error);
        mcv_rig_free(rig);
        MCV_TRY(result);
    }
    return MCV_OK;
}

/* The rigs of `mcvisi new` around a part in a folder that is removed again. */
static mcv_result warm_all_new(const mcv_command *command, const mcv_client *client,
                               mcv_error *error) {
    const char *base = getenv("TMPDIR");
    char folder[PATH_MAX], part[PATH_MAX + 16];
    snprintf(folder, sizeof folder, "%s/mcvisi-XXXXXX", base && base[0] ? base : "/tmp");
    if (!mkdtemp(folder))
        return mcv_fail(error, MCV_FAILED, "%s: cannot be made: %s", folder, strerror(errno));
    snprintf(part, sizeof part, "%s/part.stl", folder);
    mcv_result result = mcv_output_whole(part, PART, sizeof PART - 1, error);
    if (result == MCV_OK) result = warm_new(command, client, part, error);
    unlink(part);
    rmdir(folder);
    return result;
}

mcv_result mcv_verb_warm(const mcv_command *command, mcv_error *error) {
    const mcv_list *scenes = &command->arguments;
    mcv_client client;
    mcv_result result = mcv_client_open(command, NULL, &client, error);
    if (result == MCV_OK && scenes->count == 0) result = warm_all_new(command, &client, error);
    for (size_t i = 0; result == MCV_OK && i < scenes->count; ++i)
        result = warm_file(command, &client, scenes->items[i], error);
    mcv_client_close(&client);
    return result;
}
