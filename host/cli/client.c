/* SPDX-License-Identifier: Apache-2.0 */
#include "cli/client.h"

#include "cli/interrupt.h"
#include "cli/progress.h"
#include "cli/tell.h"
#include "core/basics.h"

#include <libgen.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static bool is_utf8(const char *text) {
    json_t *valid = json_string(text);
    json_decref(valid);
    return valid;
}

mcv_result mcv_client_options(const mcv_command *command, const char *const *without, char **text,
                              mcv_error *error) {
    static const char *const none[] = {NULL};
    *text = NULL;
    if (!without) without = none;
    for (int i = 2; i < command->argc; ++i) {
        const char *word = command->argv[i];
        bool argument = word == command->argument || word == command->second;
        for (size_t k = 0; k < command->arguments.count; ++k)
            argument = argument || word == command->arguments.items[k];
        if (!argument && !is_utf8(word))
            return mcv_fail(error, MCV_USAGE, "%s: is no UTF-8 text", word);
    }
    json_t *options = mcv_command_json(command, without);
    mcv_command_stated(command, &options);
    mcv_command_flags(command, &options);
    for (const char *const *name = without; options && *name; ++name)
        json_object_del(options, *name);
    *text = options ? json_dumps(options, JSON_COMPACT | JSON_REAL_PRECISION(17)) : NULL;
    json_decref(options);
    return *text ? MCV_OK : mcv_fail(error, MCV_FAILED, "no memory for the options");
}

mcv_result mcv_client_name(const char *path, const char *ending, char **name, mcv_error *error) {
    const char *slash = strrchr(path, '/'), *file = slash ? slash + 1 : path,
               *dot = strrchr(file, '.');
    const int stem = (int)(dot && dot > file ? dot - path : (long)strlen(path));
    if (!ending || asprintf(name, "%.*s%s", stem, path, ending) < 0) {
        *name = NULL;
        return mcv_fail(error, MCV_FAILED, "%s: no memory for a name", path);
    }
    if (is_utf8(*name)) return MCV_OK;
    mcv_fail(error, MCV_USAGE, "%s: is no UTF-8 text: name the output by -o", *name);
    free(*name);
    *name = NULL;
    return MCV_USAGE;
}

mcv_result mcv_client_open(const mcv_command *command, const char *rig, mcv_client *client,
                           mcv_error *error) {
    *client = (mcv_client){0};
    MCV_TRY(mcv_client_options(command, NULL, &client->options, error));
    MCV_TRY(mcv_session_open(NULL, &client->session, error));
    return rig ? mcv_rig_open(rig, &client->rig, error) : MCV_OK;
}

void mcv_client_close(mcv_client *client) {
    mcv_rig_free(client->rig);
    mcv_session_close(client->session);
    free(client->options);
}

mcv_result mcv_client_rig(const json_t *document, const char *path, char rig[PATH_MAX],
                          mcv_error *error) {
    char copy[PATH_MAX];
    const char *name = json_string_value(json_object_get(document, "rig"));
    snprintf(copy, sizeof copy, "%s", path);
    if (!name)
        return mcv_fail(error, MCV_BAD_INPUT,
                        "%s: rig: is missing: the scene, as in \"rig\": \"part.gltf\"", path);
    if (snprintf(rig, PATH_MAX, "%s%s%s", name[0] == '/' ? "" : dirname(copy),
                 name[0] == '/' ? "" : "/", name) >= PATH_MAX)
        return mcv_fail(error, MCV_BAD_INPUT, "%s: rig: the path is too long", path);
    return MCV_OK;
}

static void print_notes(const json_t *report) {
    size_t i;
    const json_t *note;
    json_array_foreach(json_object_get(report, "notes"), i, note) {
        mcv_tell(json_string_value(json_object_get(note, "severity")),
                 json_string_value(json_object_get(note, "text")));
    }
}

bool mcv_client_notes(const char *report) {
    json_t *document = json_loads(report, 0, NULL);
    const bool more = json_object_size(document) > (json_object_get(document, "notes") ? 1 : 0);
    print_notes(document);
    json_decref(document);
    return more;
}

static mcv_result print_json(const char *report, mcv_error *error) {
    json_t *document = json_loads(report, 0, NULL);
    print_notes(document);
    json_object_del(document, "notes");
    char *text = json_dumps(document, JSON_INDENT(2) | JSON_REAL_PRECISION(17));
    json_decref(document);
    if (!text) return mcv_fail(error, MCV_FAILED, "no memory for the JSON");
    mcv_client_line(text); /* what it escapes is escaped as JSON does */
    free(text);
    return MCV_OK;
}

/* The length of a first line "warning: SENTENCE", 0 where it is none; *severity: its word. */
static size_t note_length(const char *text, const char **severity) {
    static const char *const severities[] = {"error", "warning", "note"};
    const char *end = strchr(text, '\n');
    for (size_t i = 0; end && i < sizeof severities / sizeof severities[0]; ++i) {
        const size_t length = strlen(severities[i]);
        *severity = severities[i];
        if (strncmp(text, severities[i], length) == 0 && strncmp(text + length, ": ", 2) == 0)
            return (size_t)(end - text);
    }
    return 0;
}

void mcv_client_text(const char *text) {
    const char *severity;
    for (size_t length; (length = note_length(text, &severity)) > 0; text += length + 1) {
        const size_t before = strlen(severity) + 2;
        char *sentence = strndup(text + before, length - before);
        if (sentence) mcv_tell(severity, sentence);
        free(sentence);
    }
    mcv_print_plain(stdout, text);
}

void mcv_client_line(const char *text) {
    mcv_print_plain(stdout, text);
    putchar('\n');
}

mcv_result mcv_client_print(char *report, bool json, mcv_error *error) {
    mcv_result result = MCV_OK;
    if (json)
        result = print_json(report, error);
    else
        mcv_client_text(report);
    mcv_text_free(report);
    return result;
}

bool mcv_client_told(void *user, const char *report) {
    const mcv_command *command = user;
    if (report && command->json) {
        mcv_client_notes(report);
    } else if (report) {
        mcv_client_text(report);
        fflush(stdout);
    }
    return mcv_interrupt == 0;
}

mcv_result mcv_client_picture(const mcv_command *command, mcv_picture_call *call,
                              mcv_error *error) {
    mcv_client client = {0};
    mcv_picture *picture = NULL;
    char *report = NULL;
    mcv_progress_shown shown = {.open = false};
    mcv_result result = mcv_client_open(command, command->argument, &client, error);
    if (result == MCV_OK)
        result = call(client.session, client.rig, client.options, mcv_progress_show, &shown,
                      &picture, &report, error);
    if (shown.open) mcv_progress_end(&shown.line);
    if (result == MCV_OK) result = mcv_client_print(report, command->json, error);
    mcv_picture_free(picture);
    mcv_client_close(&client);
    return result == MCV_INTERRUPTED ? mcv_interrupt_result() : result;
}
