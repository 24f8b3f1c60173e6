/* SPDX-License-Identifier: Apache-2.0 */
/* mcvisi render: every sensor of a scene, or one, into OpenEXR and PNG. */
#include "check/findings.h"
#include "cli/camera.h"
#include "cli/early.h"
#include "cli/interrupt.h"
#include "cli/verbs.h"
#include "cli/picture.h"
#include "cli/tell.h"
#include "verbs/report.h"
#include "scene/sensor_find.h"
#include "core/basics.h"
#include "report/summary.h"
#include "reference/reference.h"
#include "loader/load.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* The files, and what is told of them. */
static mcv_result write_image(const mcv_command *command, const mcv_scene *scene,
                              const mcv_render_options *options, uint32_t sensor,
                              const mcv_render_files *picture, const mcv_film *film,
                              mcv_summary *summary, mcv_error *error) {
    const double begun = mcv_seconds();
    mcv_interrupt_watch(true);
    MCV_TRY(mcv_render_files_write(picture, command, scene, sensor, options, film, &summary->stats,
                                   &summary->preview, error));
    summary->seconds_write = mcv_seconds() - begun;
    summary->width = film->width;
    summary->height = film->height;
    summary->channels = film->channels;
    summary->replicates = film->replicates;
    summary->samples = (uint64_t)llround(mcv_film_mean_samples(film));
    summary->adaptive = film->levels != NULL;
    summary->error = mcv_film_relative_error(film);
    summary->mean = mcv_film_mean(film);
    return MCV_OK;
}

static mcv_result render_sensor(const mcv_command *command, const mcv_scene *scene,
                                mcv_render_options options, uint32_t sensor,
                                const mcv_render_files *picture, mcv_film *film,
                                mcv_summary *summary, mcv_error *error) {
    const bool reference = mcv_wants_reference(command);
    if (reference)
        options.sampler = MCV_SAMPLER_RANDOM; /* it has no other, and the header says so */
    mcv_early early;
    mcv_early_begin(&early, scene, sensor, picture, summary->sensor, &options);
    mcv_result result = (reference ? mcv_reference_render : mcv_render)(
        scene, sensor, &options, film, &summary->stats, error);
    mcv_early_end(&early);
    if (result == MCV_OK)
        result = write_image(command, scene, &options, sensor, picture, film, summary, error);
    summary->seconds_first_picture =
        early.seconds > 0 ? early.seconds : mcv_seconds() - early.begun;
    if (result != MCV_OK) mcv_early_withdraw(&early);
    mcv_early_free(&early);
    return result;
}

static mcv_result print_summary(const mcv_command *command, const mcv_summary *summary,
                                mcv_error *error) {
    char *text = NULL;
    MCV_TRY(command->json ? mcv_summary_json(summary, &text, error)
                          : mcv_summary_text(summary, &text, error));
    printf("%s%s", text, command->json ? "\n" : "");
    free(text);
    return MCV_OK;
}

static mcv_result render_and_print(const mcv_command *command, const mcv_scene *scene,
                                   const mcv_render_options *options, uint32_t sensor, bool several,
                                   double seconds_load, mcv_error *error) {
    char label[128];
    mcv_render_files picture;
    mcv_film film = {0};
    MCV_TRY(mcv_render_files_plan(command, scene, sensor, several, &picture, error));
    mcv_sensor_label(scene, sensor, label, sizeof label);
    mcv_summary summary = {.scene = scene->path,
                           .sensor = label,
                           .image_path = picture.exr,
                           .preview_path = picture.png,
                           .unit = picture.unit,
                           .seconds_load = seconds_load};
    mcv_interrupt_watch(false);
    mcv_result result =
        render_sensor(command, scene, *options, sensor, &picture, &film, &summary, error);
    if (result == MCV_OK) result = print_summary(command, &summary, error);
    if (result == MCV_OK && picture.grey[0])
        result = mcv_camera_write(command, picture.exr, picture.grey, !command->json, error);
    mcv_film_free(&film);
    if (result != MCV_OK || mcv_interrupt_result() == MCV_OK) return result;
    return mcv_fail(error, mcv_interrupt_result(), "interrupted: what was rendered is saved in %s",
                    picture.exr);
}

/* --- all sensors --- */

/* All pictures are planned before rendering: a missing folder must be reported at once, not hours
 * later. */
static mcv_result check_pictures(const mcv_command *command, const mcv_scene *scene, uint32_t first,
                                 uint32_t count, mcv_error *error) {
    mcv_render_files picture, earlier;
    for (uint32_t i = first; i < first + count; ++i) {
        MCV_TRY(mcv_render_files_plan(command, scene, i, count > 1, &picture, error));
        for (uint32_t j = first; j < i; ++j) {
            MCV_TRY(mcv_render_files_plan(command, scene, j, count > 1, &earlier, error));
            if (strcmp(picture.exr, earlier.exr) == 0)
                return mcv_fail(error, MCV_BAD_INPUT,
                                "%s would be the image of both sensors, %s and %s: rename one, or "
                                "choose one by "
                                "--sensor",
                                picture.exr, scene->sensors[j].name, scene->sensors[i].name);
        }
    }
    return MCV_OK;
}

static mcv_result render_scene(const mcv_command *command, mcv_scene *scene,
                               const mcv_render_options *options, double seconds_load,
                               mcv_error *error) {
    uint32_t first = 0;
    uint32_t count = scene->sensor_count;
    if (count == 0)
        return mcv_fail(
            error, MCV_BAD_INPUT,
            "%s: the scene has no sensor: give a node a glTF camera or an MCVISI_sensors sensor",
            scene->path);
    if (command->sensor) {
        MCV_TRY(mcv_sensor_find(scene, command->sensor, &first, error));
        count = 1;
    }
    for (uint32_t i = first; command->resolution[0] && i < first + count; ++i)
        MCV_TRY(mcv_sensor_resize(scene->sensors + i, command->resolution[0],
                                  command->resolution[1], scene, error));
    MCV_TRY(check_pictures(command, scene, first, count, error));
    for (uint32_t i = first; i < first + count; ++i)
        MCV_TRY(render_and_print(command, scene, options, i, count > 1, seconds_load, error));
    return MCV_OK;
}

/* Prints errors and warnings to standard error, before hours are spent on a wrong scene. */
static mcv_result print_findings(const mcv_scene *scene, mcv_error *error) {
    mcv_findings findings;
    MCV_TRY(mcv_findings_of(scene, &findings, error));
    for (size_t i = 0; i < findings.count; ++i)
        if (findings.items[i].severity >= MCV_SEVERITY_WARNING)
            mcv_tell(mcv_severities[findings.items[i].severity], findings.items[i].sentence);
    mcv_findings_free(&findings);
    return MCV_OK;
}

mcv_result mcv_verb_render(const mcv_command *command, mcv_error *error) {
    mcv_scene *scene;
    mcv_render_options options;
    const double begun = mcv_seconds();
    const mcv_camera_settings camera = mcv_camera_settings_of(command);
    if (!command->camera && mcv_camera_wanted(&camera))
        return mcv_fail(
            error, MCV_USAGE,
            "the exposure belongs to --camera FILE: give --camera, or leave the exposure out");
    MCV_TRY(mcv_render_options_read(command, &options, error));
    MCV_TRY(mcv_scene_load(command->argument,
                           (mcv_overrides){command->set.items, command->set.count}, &scene, error));
    const double seconds_load = mcv_seconds() - begun;
    mcv_result result = print_findings(scene, error);
    if (result == MCV_OK) result = render_scene(command, scene, &options, seconds_load, error);
    mcv_scene_free(scene);
    return result;
}
