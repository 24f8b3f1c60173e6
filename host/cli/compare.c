/* SPDX-License-Identifier: Apache-2.0 */
/* mcvisi compare: do two renders of the same picture differ by more than their noise? Scenes are
 * rendered here first. */
#include "cli/client.h"
#include "cli/progress.h"
#include "cli/verbs.h"
#include "core/basics.h"
#include "core/output_file.h"

#include <stdlib.h>
#include <string.h>

/* --- scenes --- */

static bool on_progress(void *user, const mcv_progress *progress) {
    return mcv_progress_report(user, progress->fraction, progress->seconds, progress->error);
}

/* Those of a render: all replicates are kept, and as many light paths are traced in both scenes. */
static mcv_result scene_options(const mcv_command *command, char **options, mcv_error *error) {
    static const char *const without[] = {"output", "against", "json", NULL};
    char *given;
    MCV_TRY(mcv_client_options(command, without, &given, error));
    json_t *object = json_loads(given, 0, NULL);
    free(given);
    json_object_set_new(object, "replicates", json_integer((json_int_t)command->repeats));
    json_object_set_new(object, "parts", json_string("replicates"));
    json_object_set_new(object, "adaptive", json_string("off"));
    if (!json_object_get(object, "light-paths"))
        json_object_set_new(object, "light-paths", json_string("on"));
    *options = json_dumps(object, JSON_COMPACT | JSON_REAL_PRECISION(17));
    json_decref(object);
    return *options ? MCV_OK : mcv_fail(error, MCV_FAILED, "no memory for the options");
}

static mcv_result render_scene(const mcv_command *command, const char *path, mcv_picture **picture,
                               mcv_error *error) {
    char *options = NULL;
    mcv_session *session = NULL;
    mcv_rig *rig = NULL;
    mcv_progress_line line = mcv_progress_stderr(path, NULL);
    mcv_result result = scene_options(command, &options, error);
    if (result == MCV_OK) result = mcv_session_open(NULL, &session, error);
    if (result == MCV_OK) result = mcv_rig_open(path, &rig, error);
    if (result == MCV_OK)
        result =
            mcv_session_render(session, rig, options, on_progress, &line, picture, NULL, error);
    mcv_progress_end(&line);
    mcv_rig_free(rig);
    mcv_session_close(session);
    free(options);
    return result;
}

/* B's options: those of the command, then those of --against. argv contains the words of `text`,
 * which is allocated here. */
static mcv_result read_against(const mcv_command *command, char **text, char ***argv,
                               mcv_command *other, mcv_error *error) {
    int argc = command->argc;
    const char *against = command->against ? command->against : "";
    *text = strdup(against);
    *argv = calloc((size_t)argc + strlen(against) + 1, sizeof **argv);
    if (!*text || !*argv)
        return mcv_fail(error, MCV_FAILED, "no memory for the options of --against");
    memcpy(*argv, command->argv, (size_t)argc * sizeof **argv);
    for (char *rest, *word = strtok_r(*text, " ", &rest); word; word = strtok_r(NULL, " ", &rest))
        (*argv)[argc++] = word;
    mcv_error detail = {""};
    const mcv_result result = mcv_command_parse(argc, *argv, other, &detail);
    if (result != MCV_OK) return mcv_fail(error, result, "--against: %s", detail.text);
    /* Equal seeds would have equal noise. */
    if (other->seed == command->seed) other->seed = (other->seed + 1) & UINT32_MAX;
    return MCV_OK;
}

/* --- both --- */

static bool is_image(const char *path) { return mcv_ends_in(path, ".exr"); }

static mcv_result get_a(const mcv_command *command, mcv_picture **a, mcv_error *error) {
    return is_image(command->argument) ? mcv_picture_read(command->argument, a, error)
                                       : render_scene(command, command->argument, a, error);
}

static mcv_result get_b(const mcv_command *command, mcv_picture **b, mcv_error *error) {
    mcv_command other = {0};
    char *text = NULL, **argv = NULL;
    if (is_image(command->second)) return mcv_picture_read(command->second, b, error);
    mcv_result result = read_against(command, &text, &argv, &other, error);
    if (result == MCV_OK) result = render_scene(&other, command->second, b, error);
    mcv_command_free(&other);
    free(text);
    free(argv);
    return result;
}

/* Refuses options of scenes for images, which are already rendered. */
static mcv_result check_options(const mcv_command *command, mcv_error *error) {
    static const char *const always[] = {"output", "json", NULL};
    mcv_result result = MCV_OK;
    if (!is_image(command->second)) return MCV_OK;
    if (command->against)
        return mcv_fail(error, MCV_USAGE, "--against: %s is an image: options are for scenes",
                        command->second);
    if (!is_image(command->argument)) return MCV_OK;
    json_t *given = mcv_command_json(command, always);
    if (!given) return mcv_fail(error, MCV_FAILED, "no memory for the options");
    const char *key = json_object_iter_key(json_object_iter(given));
    if (key)
        result = mcv_fail(error, MCV_USAGE, "--%s is for scenes, but both are images: leave it out",
                          key);
    json_decref(given);
    return result;
}

/* Only what is left of the options: where to, and how it is told. */
static mcv_result compare(const mcv_command *command, const mcv_picture *a, const mcv_picture *b,
                          mcv_error *error) {
    char *report = NULL, *options = NULL;
    bool different = false;
    json_t *object =
        json_pack("{s:b, s:s*}", "json", (int)command->json, "output", command->difference);
    if (object) options = json_dumps(object, JSON_COMPACT);
    json_decref(object);
    mcv_result result = options
                            ? mcv_picture_compare(a, b, options, &different, NULL, &report, error)
                            : mcv_fail(error, MCV_FAILED, "no memory for the options");
    free(options);
    if (result == MCV_OK) result = mcv_client_print(report, command->json, error);
    return result == MCV_OK && different ? MCV_FAILED : result;
}

mcv_result mcv_verb_compare(const mcv_command *command, mcv_error *error) {
    mcv_picture *a = NULL, *b = NULL;
    if (command->difference) MCV_TRY(mcv_output_check(command->difference, error));
    MCV_TRY(check_options(command, error));
    mcv_result result = get_a(command, &a, error);
    if (result == MCV_OK) result = get_b(command, &b, error);
    if (result == MCV_OK) result = compare(command, a, b, error);
    mcv_picture_free(a);
    mcv_picture_free(b);
    return result;
}
