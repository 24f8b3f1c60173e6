/* SPDX-License-Identifier: Apache-2.0 */
/* mcvisi render: every sensor of a scene, or one, into OpenEXR and PNG. */
#include "cli/interrupt.h"
#include "cli/options.h"
#include "cli/picture.h"
#include "cli/report.h"
#include "cli/sensor.h"
#include "film/film.h"
#include "mcvisi/features.h"
#include "reference/reference.h"
#include "scene/params.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

static const double default_error = 0.01;
static const double default_seconds = 60;

static double now(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* --- progress --------------------------------------------------------------------------------------------------- */

typedef struct progress_line {
    const char *sensor;
    double target; /* error to reach, or 0 */
    double last;   /* when the line was printed [s] */
    bool terminal;
} progress_line;

static bool show_progress(void *user, double fraction, double seconds, double error) {
    progress_line *line = user;
    const bool go_on = mcv_interrupt_received() == MCV_OK;
    if (!line->terminal || (seconds - line->last < 0.2 && go_on)) return go_on;
    line->last = seconds;
    /* The error of n samples falls at least as 1/√n: what is done is at least (target/error)². */
    if (line->target > 0 && isfinite(error) && error > 0) fraction = fmax(fraction, line->target * line->target / (error * error));
    fraction = fmin(fraction, 1);
    fprintf(stderr, "\r%s: %3.0f %%, %.0f s", line->sensor, 100 * fraction, seconds);
    if (fraction > 0) fprintf(stderr, ", %.0f s left", ceil(seconds * (1 - fraction) / fraction));
    if (isfinite(error)) fprintf(stderr, ", error %.2g %%", 100 * error);
    fprintf(stderr, "%s\033[K", go_on ? "" : ", stopping");
    return go_on;
}

/* --- options ---------------------------------------------------------------------------------------------------- */

static mcv_result render_options(const mcv_command *command, mcv_render_options *options, mcv_error *error) {
    *options = mcv_render_defaults();
    options->sampler = command->sampler ? MCV_SAMPLER_RANDOM : MCV_SAMPLER_SOBOL;
    options->replicates = (uint32_t)command->replicates;
    options->seed = (uint32_t)command->seed;
    options->depth = (uint32_t)command->depth;
    options->schedule = command->schedule ? MCV_SCHEDULE_TILE : MCV_SCHEDULE_AUTO;
    options->threads = (uint32_t)command->threads;
    options->device = command->device;
    options->error = command->error;
    options->seconds = command->time;
    if (command->spp && command->samples[1])
        return mcv_fail(error, MCV_USAGE, "--spp and --samples both say how many samples: give one of them");
    if (command->error > 0 && command->replicates < 2)
        return mcv_fail(error, MCV_USAGE, "--error needs replicates to know the error from: give --replicates 2 or more");
    options->first = command->samples[0];
    options->last = command->samples[1];
    if (command->spp) {
        const uint64_t each = (command->spp + command->replicates - 1) / command->replicates;
        for (options->last = 1; options->last < each;) options->last *= 2;
        if (options->last > 0x80000000u)
            return mcv_fail(error, MCV_USAGE, "--spp %llu: must be at most 2^31 for each of the %llu replicates",
                            (unsigned long long)command->spp, (unsigned long long)command->replicates);
    }
    if (options->last == 0 && options->error == 0 && options->seconds == 0) {
        options->error = default_error;
        options->seconds = default_seconds;
    }
    return MCV_OK;
}

/* --- result ----------------------------------------------------------------------------------------------------- */

typedef struct rendered {
    char label[128];
    const char *type; /* of the sensor */
    mcv_picture picture;
    mcv_film film;
    mcv_render_stats stats;
    mcv_preview preview;
    double seconds_load, seconds_write;
} rendered;

static void print_sentences(const rendered *r) {
    const mcv_film *f = &r->film;
    printf("%s: %u x %u pixels, %llu samples each, ", r->label, f->width, f->height, (unsigned long long)f->samples * f->replicates);
    if (f->replicates > 1) printf("error %.3g %%, ", 100 * mcv_film_relative_error(f));
    printf("%.1f s\n", r->stats.seconds_render);
    printf("  mean %s %.4g %s; the preview is white at %.4g, %.2g %% of its pixels are saturated\n", r->picture.quantity, mcv_film_mean(f),
           r->picture.unit, r->preview.white, 100 * r->preview.saturated);
    if (r->stats.lost_energy > 0) printf("  at most %.2g %% of the light is missing behind the depth limit\n", 100 * r->stats.lost_energy);
    if (r->stats.nonfinite > 0) printf("  %llu samples were not finite and count as black\n", (unsigned long long)r->stats.nonfinite);
    printf("  %s\n  %s\n", r->picture.exr, r->picture.png);
}

/* Whether the stage runs with these features, which stand as words in the statistics. */
static bool has_feature(const char *features, const char *word) {
    const size_t length = strlen(word);
    for (const char *at = features; (at = strstr(at, word)); at += length)
        if ((at == features || at[-1] == ' ') && (at[length] == ' ' || at[length] == '\0')) return true;
    return false;
}

static void report_render(mcv_report *report, const rendered *r) {
    const mcv_film *f = &r->film;
    const mcv_render_stats *s = &r->stats;
    mcv_report_element(report, r->label, r->type);
    mcv_report_text(report, "image", r->picture.exr);
    mcv_report_text(report, "preview", r->picture.png);
    mcv_report_numbers(report, "size", "", " x ", (const double[]){f->width, f->height}, 2);
    mcv_report_number(report, "channels", "", f->channels);
    mcv_report_text(report, "quantity", r->picture.quantity);
    mcv_report_text(report, "unit", r->picture.unit);
    mcv_report_text(report, "device", s->device);
    mcv_report_text(report, "driver", s->driver);
    mcv_report_words(report, "features", s->features);
    mcv_report_number(report, "samples", "", (double)f->samples * f->replicates);
    mcv_report_number(report, "replicates", "", f->replicates);
    mcv_report_number(report, "mean", r->picture.unit, mcv_film_mean(f));
    mcv_report_number(report, "error", "", mcv_film_relative_error(f));
    mcv_report_number(report, "white", r->picture.unit, r->preview.white);
    mcv_report_number(report, "saturated", "", r->preview.saturated);
    mcv_report_number(report, "lost_energy", "", s->lost_energy);
    mcv_report_number(report, "nonfinite", "", (double)s->nonfinite);
    mcv_report_number(report, "unmatched", "", (double)s->unmatched);
    mcv_report_flag(report, "interrupted", s->interrupted);
    mcv_report_open(report, "rays");
    mcv_report_number(report, "paths", "", (double)s->paths);
    mcv_report_number(report, "closest", "", (double)s->rays);
    mcv_report_number(report, "shadow", "", (double)s->shadow_rays);
    mcv_report_number(report, "depth_cut", "", (double)s->depth_cut);
    mcv_report_close(report);
    mcv_report_open(report, "seconds");
    mcv_report_number(report, "load", "s", r->seconds_load);
    mcv_report_number(report, "build", "s", s->seconds_build);
    mcv_report_number(report, "compile", "s", s->seconds_compile);
    mcv_report_number(report, "first_sample", "s", s->seconds_first_sample);
    mcv_report_number(report, "render", "s", s->seconds_render);
    mcv_report_number(report, "write", "s", r->seconds_write);
    mcv_report_close(report);
    mcv_report_open(report, "stages");
#define MCV_WITH_NEXT_EVENT has_feature(s->features, "next-event")
#define MCV_X(stage, runs) mcv_report_flag(report, #stage, runs);
    MCV_STAGES(MCV_X)
#undef MCV_X
#undef MCV_WITH_NEXT_EVENT
    mcv_report_close(report);
    mcv_report_close(report);
}

/* --- one sensor ------------------------------------------------------------------------------------------------- */

static mcv_result render_sensor(const mcv_command *command, const mcv_scene *scene, uint32_t sensor, const mcv_render_options *options,
                                rendered *r, mcv_error *error) {
    mcv_render_options told = *options; /* the line below lives no longer than this call */
    const bool reference = command->device && strcmp(command->device, "reference") == 0;
    progress_line line = {.sensor = r->label, .target = options->error, .terminal = isatty(STDERR_FILENO) == 1};
    told.progress = show_progress;
    told.user = &line;
    const mcv_result result = (reference ? mcv_reference_render : mcv_render)(scene, sensor, &told, &r->film, &r->stats, error);
    if (line.last > 0) fputs("\r\033[K", stderr);
    MCV_TRY(result);
    const double begun = now();
    mcv_interrupt_watch(true);
    MCV_TRY(mcv_picture_write(&r->picture, command, scene, sensor, options, &r->film, &r->stats, &r->preview, error));
    r->seconds_write = now() - begun;
    return MCV_OK;
}

/* Pictures are planned before anything is rendered: hours later it is too late to say that a folder is missing. */
static mcv_result render_sensors(const mcv_command *command, mcv_scene *scene, uint32_t first, uint32_t count, double seconds_load,
                                 mcv_report *report, mcv_error *error) {
    mcv_render_options options;
    mcv_picture planned;
    MCV_TRY(render_options(command, &options, error));
    for (uint32_t i = first; i < first + count; ++i) {
        if (command->resolution[0]) {
            MCV_TRY(mcv_sensor_resize(scene->sensors + i, command->resolution[0], command->resolution[1], scene, error));
        }
        MCV_TRY(mcv_picture_plan(command, scene, i, count > 1, &planned, error));
    }
    for (uint32_t i = first; i < first + count; ++i) {
        rendered r = {.type = mcv_sensor_types[scene->sensors[i].type], .seconds_load = seconds_load};
        mcv_sensor_label(scene, i, r.label, sizeof r.label);
        MCV_TRY(mcv_picture_plan(command, scene, i, count > 1, &r.picture, error));
        mcv_interrupt_watch(false);
        const mcv_result result = render_sensor(command, scene, i, &options, &r, error);
        if (result == MCV_OK && command->json) report_render(report, &r);
        if (result == MCV_OK && !command->json) print_sentences(&r);
        mcv_film_free(&r.film);
        MCV_TRY(result);
        const mcv_result interrupted = mcv_interrupt_received();
        if (interrupted != MCV_OK) return mcv_fail(error, interrupted, "interrupted: what was rendered is saved in %s", r.picture.exr);
    }
    return MCV_OK;
}

static mcv_result render_scene(const mcv_command *command, mcv_scene *scene, double seconds_load, mcv_error *error) {
    mcv_report report;
    uint32_t first = 0;
    uint32_t count = scene->sensor_count;
    if (count == 0)
        return mcv_fail(error, MCV_BAD_INPUT, "%s: the scene has no sensor: give a node a glTF camera or an MCVISI_sensors sensor",
                        scene->path);
    if (command->sensor) {
        MCV_TRY(mcv_sensor_find(scene, command->sensor, &first, error));
        count = 1;
    }
    if (!command->json) return render_sensors(command, scene, first, count, seconds_load, NULL, error);

    mcv_report_begin(&report, true);
    mcv_report_text(&report, "version", mcv_version());
    mcv_report_text(&report, "scene", scene->path);
    mcv_report_list(&report, "renders");
    const mcv_result result = render_sensors(command, scene, first, count, seconds_load, &report, error);
    mcv_report_close(&report);
    /* What is finished is reported even if the next sensor failed. */
    mcv_error unreported = {""};
    const mcv_result reported = mcv_report_end(&report, &unreported);
    if (result != MCV_OK || reported == MCV_OK) return result;
    *error = unreported;
    return reported;
}

mcv_result mcv_verb_render(const mcv_command *command, mcv_error *error) {
    mcv_scene *scene;
    const double begun = now();
    MCV_TRY(mcv_scene_load(command->argument, (mcv_overrides){command->set.items, command->set.count}, &scene, error));
    const double seconds_load = now() - begun;
    for (uint32_t i = 0; i < scene->warning_count; ++i) fprintf(stderr, "mcvisi: warning: %s\n", scene->warnings[i]);
    const mcv_result result = render_scene(command, scene, seconds_load, error);
    mcv_scene_free(scene);
    return result;
}
