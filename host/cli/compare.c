/* SPDX-License-Identifier: Apache-2.0 */
/* mcvisi compare: do two renders of the same picture differ by more than their noise? */
#include "analysis/compare.h"
#include "cli/command.h"
#include "cli/picture.h"
#include "cli/report.h"
#include "scene/sensor_find.h"
#include "io/exr.h"
#include "io/figure.h"
#include "core/output_file.h"
#include "report/progress.h"
#include "reference/reference.h"
#include "loader/load.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* One of the two renders: a file, or a scene that is rendered here. */
typedef struct render {
    const char *path;
    mcv_exr exr;
    mcv_image mean, error; /* of a scene */
    mcv_measured measured;
    mcv_film film; /* of a file: the replicates' means, each as one sample; empty if it has none */
    char quantity[64], unit[64], sampler[64], device[256];
    double seed;
} render;

static const char *text_attribute(const mcv_exr *exr, const char *name) {
    const mcv_attribute *attribute = mcv_exr_attribute(exr, name);
    return attribute && attribute->text ? attribute->text : "unknown";
}

static double number_attribute(const mcv_exr *exr, const char *name) {
    const mcv_attribute *attribute = mcv_exr_attribute(exr, name);
    return attribute && !attribute->text && attribute->count == 1 ? attribute->numbers[0] : NAN;
}

static const mcv_image *find_part(const mcv_exr *exr, const char *name) {
    for (uint32_t p = 0; p < exr->part_count; ++p)
        if (strcmp(exr->parts[p].name, name) == 0) return &exr->parts[p].image;
    return NULL;
}

static bool is_finite(const mcv_image *image) {
    for (size_t i = 0; i < (size_t)image->width * image->height * image->channels; ++i)
        if (!isfinite(image->pixels[i])) return false;
    return true;
}

/* Makes the film of the replicates if the file has all of them. Rank tests need finite numbers:
 * other images have no film. */
static mcv_result gather_replicates(render *r, mcv_error *error) {
    const mcv_image *mean = r->measured.mean;
    const size_t count = (size_t)mean->width * mean->height * mean->channels;
    char name[32];
    for (uint32_t k = 0; k < r->measured.replicates; ++k) {
        snprintf(name, sizeof name, MCV_PICTURE_REPLICATE, k);
        const mcv_image *image = find_part(&r->exr, name);
        const bool fits = image && image->width == mean->width && image->height == mean->height &&
                          image->channels == mean->channels;
        if (!fits || !is_finite(image)) return MCV_OK;
    }
    MCV_TRY(mcv_film_new(&r->film, mean->width, mean->height, mean->channels,
                         r->measured.replicates, error));
    for (uint32_t k = 0; k < r->measured.replicates; ++k) {
        snprintf(name, sizeof name, MCV_PICTURE_REPLICATE, k);
        const mcv_image *image = find_part(&r->exr, name);
        for (size_t i = 0; i < count; ++i) r->film.sums[k * count + i] = image->pixels[i];
    }
    r->film.samples = 1;
    return MCV_OK;
}

static mcv_result read_render(const char *path, render *r, mcv_error *error) {
    r->path = path;
    MCV_TRY(mcv_exr_read(path, &r->exr, error));
    const double replicates = number_attribute(&r->exr, "mcvisi:replicates");
    r->measured.mean = &r->exr.parts[0].image;
    r->measured.error = find_part(&r->exr, "error");
    if (!r->measured.error)
        return mcv_fail(error, MCV_BAD_INPUT,
                        "%s: has no part `error`: must be written by `mcvisi render` with two or "
                        "more --replicates",
                        path);
    if (!(replicates >= 2 && replicates <= MCV_MAX_REPLICATES && replicates == floor(replicates)))
        return mcv_fail(error, MCV_BAD_INPUT,
                        "%s: mcvisi:replicates in its header must be an integer from 2 to %d", path,
                        MCV_MAX_REPLICATES);
    r->measured.replicates = (uint32_t)replicates;
    snprintf(r->quantity, sizeof r->quantity, "%s", text_attribute(&r->exr, "mcvisi:quantity"));
    snprintf(r->unit, sizeof r->unit, "%s", text_attribute(&r->exr, "mcvisi:unit"));
    snprintf(r->sampler, sizeof r->sampler, "%s", text_attribute(&r->exr, "mcvisi:sampler"));
    snprintf(r->device, sizeof r->device, "%s", text_attribute(&r->exr, "mcvisi:device"));
    r->seed = number_attribute(&r->exr, "mcvisi:seed");
    return gather_replicates(r, error);
}

static void free_render(render *r) {
    mcv_film_free(&r->film);
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
    mcv_progress_line line = mcv_progress_stderr(r->path, NULL);
    options.progress = mcv_progress_report;
    options.user = &line;
    const mcv_result result = (reference ? mcv_reference_render : mcv_render)(
        scene, sensor, &options, &r->film, &stats, error);
    mcv_progress_end(&line);
    MCV_TRY(result);
    MCV_TRY(mcv_film_develop(&r->film, &r->mean, &r->error, error));
    const bool irradiance = mcv_sensor_measures_irradiance(scene->sensors + sensor);
    snprintf(r->quantity, sizeof r->quantity, "%s", irradiance ? "irradiance" : "radiance");
    snprintf(r->unit, sizeof r->unit, "%s", irradiance ? "W/m^2" : "W/(m^2 sr)");
    snprintf(r->sampler, sizeof r->sampler, "%s",
             reference || options.sampler == MCV_SAMPLER_RANDOM ? "random" : "sobol");
    snprintf(r->device, sizeof r->device, "%s", stats.device);
    r->seed = options.seed;
    r->measured = (mcv_measured){&r->mean, &r->error, options.replicates};
    return MCV_OK;
}

static mcv_result render_scene(const mcv_command *command, const char *path, render *r,
                               mcv_error *error) {
    mcv_command options = *command;
    mcv_scene *scene;
    options.replicates = command->repeats;
    r->path = path;
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

/* Equal seeds have equal sample points: the noise is correlated, and the tests find fewer
 * differences. */
static void warn_of_seeds(const render *a, const render *b) {
    if (a->seed != b->seed || strcmp(a->sampler, b->sampler) != 0 ||
        strcmp(a->device, b->device) != 0)
        return;
    fprintf(stderr,
            "mcvisi: warning: both images have seed %.0f: their noise is correlated and hides "
            "differences; render one with another --seed\n",
            a->seed);
}

static mcv_result report_comparison(const mcv_command *command, const render *a, const render *b,
                                    bool ranks, const mcv_comparison *c, mcv_error *error) {
    mcv_report report;
    double histogram[MCV_COMPARE_BINS];
    for (int i = 0; i < MCV_COMPARE_BINS; ++i) histogram[i] = (double)c->histogram[i];
    mcv_report_begin(&report, command->json);
    mcv_report_flag(&report, "different", c->different);
    mcv_report_text(&report, "reason", c->reason);
    mcv_report_text(&report, "pixel_test", ranks ? "Mann-Whitney and Welch" : "Welch");
    mcv_report_numbers(&report, "replicates", "", ", ",
                       (const double[]){a->measured.replicates, b->measured.replicates}, 2);
    mcv_report_numbers(&report, "means", a->unit, ", ", (const double[]){c->mean_x, c->mean_y}, 2);
    mcv_report_number(&report, "p_unit", "", c->p_unit);
    mcv_report_number(&report, "p_tiles", "", c->p_tiles);
    mcv_report_number(&report, "p_count", "", c->p_count);
    mcv_report_number(&report, "p_image", "", c->p_image);
    mcv_report_number(&report, "alpha", "", MCV_COMPARE_ALPHA);
    mcv_report_number(&report, "units", "", (double)c->units);
    mcv_report_number(&report, "tiles", "", (double)c->tiles);
    mcv_report_number(&report, "small_tiles", "", (double)c->small_tiles);
    mcv_report_numbers(&report, "tiles_by_p", "", " ", histogram, MCV_COMPARE_BINS);
    mcv_report_number(&report, "detectable", "", c->detectable);
    mcv_report_number(&report, "detectable_tile", "", c->detectable_tile);
    mcv_report_open(&report, "worst");
    mcv_report_number(&report, "channel", "", c->worst.channel);
    mcv_report_number(&report, "column", "", c->worst.column);
    mcv_report_number(&report, "row", "", c->worst.row);
    mcv_report_numbers(&report, "size", "", " x ",
                       (const double[]){c->worst.width, c->worst.height}, 2);
    mcv_report_close(&report);
    return mcv_report_end(&report, error);
}

static const char *file_name(const char *path) {
    const char *slash = strrchr(path, '/');
    return slash ? slash + 1 : path;
}

/* Differences beyond 5 standard errors have the same colour. */
static mcv_result draw_difference(const char *path, const render *a, const render *b,
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

static mcv_result compare(const mcv_command *command, const render *a, const render *b,
                          mcv_error *error) {
    if (strcmp(a->quantity, b->quantity) != 0)
        return mcv_fail(error, MCV_BAD_INPUT, "%s is %s and %s is %s: both must be the same",
                        a->path, a->quantity, b->path, b->quantity);
    mcv_comparison comparison;
    const bool ranks = a->film.samples > 0 && b->film.samples > 0;
    MCV_TRY(ranks ? mcv_compare_films(&a->film, &b->film, &comparison, error)
                  : mcv_compare_images(&a->measured, &b->measured, &comparison, error));
    if (command->difference)
        MCV_TRY(draw_difference(command->difference, a, b, comparison.different, error));
    warn_of_seeds(a, b);
    MCV_TRY(report_comparison(command, a, b, ranks, &comparison, error));
    return comparison.different ? MCV_FAILED : MCV_OK;
}

mcv_result mcv_verb_compare(const mcv_command *command, mcv_error *error) {
    render a = {0}, b = {0};
    if (command->difference) MCV_TRY(mcv_output_check(command->difference, error));
    MCV_TRY(check_options(command, error));
    mcv_result result = get_a(command, &a, error);
    if (result == MCV_OK) result = get_b(command, &b, error);
    if (result == MCV_OK) result = compare(command, &a, &b, error);
    free_render(&a);
    free_render(&b);
    return result;
}
