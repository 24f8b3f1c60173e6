/* SPDX-License-Identifier: Apache-2.0 */
/* mcvisi compare: do two renders of the same picture differ by more than their noise? */
#include "cli/verbs.h"
#include "cli/picture.h"
#include "cli/tell.h"
#include "verbs/report.h"
#include "scene/sensor_find.h"
#include "io/exr.h"
#include "io/figure.h"
#include "core/output_file.h"
#include "report/progress.h"
#include "reference/reference.h"
#include "loader/load.h"
#include "verbs/compare.h"
#include "verbs/render_picture.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* One of the two renders: a file, or a scene that is rendered here. */
typedef struct render {
    mcv_exr exr;
    mcv_image mean, error; /* of a scene */
    mcv_compared compared;
} render;

static mcv_result read_render(const char *path, render *r, mcv_error *error) {
    MCV_TRY(mcv_exr_read(path, &r->exr, error));
    return mcv_compared_read(&r->exr, path, &r->compared, error);
}

static void free_render(render *r) {
    mcv_film_free(&r->compared.film);
    mcv_image_free(&r->mean);
    mcv_image_free(&r->error);
    mcv_exr_free(&r->exr);
}

/* --- scenes --- */

static mcv_result choose_sensor(const mcv_command *command, mcv_scene *scene, uint32_t *sensor,
                                mcv_error *error) {
    *sensor = 0;
    if (command->sensor) MCV_TRY(mcv_sensor_find(scene, command->sensor, sensor, error));
    if (!command->sensor && scene->sensor_count != 1)
        return mcv_fail(error, MCV_USAGE, "%s: has %u sensors: choose one by --sensor", scene->path,
                        scene->sensor_count);
    if (command->resolution[0])
        return mcv_sensor_resize(scene->sensors + *sensor, command->resolution[0],
                                 command->resolution[1], scene, error);
    return MCV_OK;
}

static mcv_result render_loaded(const mcv_command *command, mcv_scene *scene, render *r,
                                mcv_error *error) {
    const bool reference = mcv_wants_reference(command);
    mcv_render_options options;
    mcv_render_stats stats;
    uint32_t sensor;
    MCV_TRY(choose_sensor(command, scene, &sensor, error));
    MCV_TRY(mcv_render_options_read(command, &options, error));
    mcv_progress_line line = mcv_progress_stderr(r->compared.path, NULL);
    options.progress = mcv_progress_report;
    options.user = &line;
    const mcv_result result = (reference ? mcv_reference_render : mcv_render)(
        scene, sensor, &options, &r->compared.film, &stats, error);
    mcv_progress_end(&line);
    MCV_TRY(result);
    MCV_TRY(mcv_film_develop(&r->compared.film, &r->mean, &r->error, error));
    const bool irradiance = mcv_sensor_measures_irradiance(scene->sensors + sensor);
    snprintf(r->compared.quantity, sizeof r->compared.quantity, "%s",
             irradiance ? "irradiance" : "radiance");
    snprintf(r->compared.unit, sizeof r->compared.unit, "%s", irradiance ? "W/m^2" : "W/(m^2 sr)");
    snprintf(r->compared.sampler, sizeof r->compared.sampler, "%s",
             reference || options.sampler == MCV_SAMPLER_RANDOM ? "random" : "sobol");
    snprintf(r->compared.device, sizeof r->compared.device, "%s", stats.device);
    r->compared.seed = options.seed;
    r->compared.measured = (mcv_measured){&r->mean, &r->error, options.replicates};
    return MCV_OK;
}

static mcv_result render_scene(const mcv_command *command, const char *path, render *r,
                               mcv_error *error) {
    mcv_command options = *command;
    mcv_scene *scene;
    options.replicates = command->repeats;
    r->compared.path = path;
    MCV_TRY(mcv_scene_load(path, (mcv_overrides){command->set.items, command->set.count}, &scene,
                           error));
    const mcv_result result = render_loaded(&options, scene, r, error);
    mcv_scene_free(scene);
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

static bool is_image(const char *path) {
    const size_t length = strlen(path);
    return length >= 4 && strcmp(path + length - 4, ".exr") == 0;
}

static mcv_result get_a(const mcv_command *command, render *a, mcv_error *error) {
    if (!is_image(command->argument)) return render_scene(command, command->argument, a, error);
    return read_render(command->argument, a, error);
}

static mcv_result get_b(const mcv_command *command, render *b, mcv_error *error) {
    mcv_command other = {0};
    char *text = NULL, **argv = NULL;
    if (is_image(command->second)) return read_render(command->second, b, error);
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
    const char *key = json_object_iter_key(json_object_iter(given));
    if (key)
        result = mcv_fail(error, MCV_USAGE, "--%s is for scenes, but both are images: leave it out",
                          key);
    json_decref(given);
    return result;
}

/* --- the comparison --- */

static const char *file_name(const char *path) {
    const char *slash = strrchr(path, '/');
    return slash ? slash + 1 : path;
}

/* Differences beyond 5 standard errors have the same colour. */
static mcv_result draw_difference(const char *path, const mcv_compared *a, const mcv_compared *b,
                                  bool different, mcv_error *error) {
    const mcv_color_scale scale = {.map = MCV_COLORMAP_DIVERGING, .low = -5, .high = 5};
    mcv_image difference;
    char title[256];
    MCV_TRY(mcv_compare_difference(&a->measured, &b->measured, &difference, error));
    snprintf(title, sizeof title, "%.100s - %.100s: %s", file_name(a->path), file_name(b->path),
             different ? "different" : "no difference beyond the noise");
    const mcv_result result =
        mcv_figure_write(path, &difference, title, "difference in standard errors", &scale, error);
    mcv_image_free(&difference);
    return result;
}

static mcv_result compare(const mcv_command *command, const mcv_compared *a, const mcv_compared *b,
                          mcv_error *error) {
    mcv_comparison comparison;
    mcv_report report;
    MCV_TRY(mcv_compare(a, b, &comparison, error));
    if (command->difference)
        MCV_TRY(draw_difference(command->difference, a, b, comparison.different, error));
    mcv_report_begin(&report, command->json, mcv_tell);
    mcv_compare_report(a, b, &comparison, &report);
    MCV_TRY(mcv_report_end(&report, error));
    return comparison.different ? MCV_FAILED : MCV_OK;
}

mcv_result mcv_verb_compare(const mcv_command *command, mcv_error *error) {
    render a = {0}, b = {0};
    if (command->difference) MCV_TRY(mcv_output_check(command->difference, error));
    MCV_TRY(check_options(command, error));
    mcv_result result = get_a(command, &a, error);
    if (result == MCV_OK) result = get_b(command, &b, error);
    if (result == MCV_OK) result = compare(command, &a.compared, &b.compared, error);
    free_render(&a);
    free_render(&b);
    return result;
}
