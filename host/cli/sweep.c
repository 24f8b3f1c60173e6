/* SPDX-License-Identifier: Apache-2.0 */
/* mcvisi sweep: many sets of parameters, one render and a few measured figures of each; a table
 * that grows row by row, and a page. */
#include "experiment/design.h"
#include "experiment/expression.h"
#include "analysis/lightfield.h"
#include "cli/camera.h"
#include "cli/interrupt.h"
#include "cli/metrics.h"
#include "cli/picture.h"
#include "cli/places.h"
#include "cli/sensor.h"
#include "core/basics.h"
#include "io/exr.h"
#include "core/output_file.h"
#include "io/plots.h"
#include "reference/reference.h"
#include "core/json.h"
#include "scene/sensors.h"

#include <ctype.h>
#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <libgen.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

enum { MAX_METRICS = 32, MAX_ROW = 8192, FIXED_COLUMNS = 4 };

/* A parameter that varies, or follows from those before it. */
typedef struct parameter {
    char name[64];
    const char *item; /* PATH=… as given */
    int path_length;
    mcv_levels levels;      /* empty for a tie */
    const char *expression; /* of a tie, or NULL */
} parameter;

typedef struct metric {
    char name[128];
    const char *expression;
    double until; /* 0: whatever */
} metric;

typedef struct sweep {
    const mcv_command *command;
    const char *rig;
    char table[PATH_MAX], sidecar[PATH_MAX], page[PATH_MAX];
    mcv_render_options options;
    parameter parameters[MCV_DESIGN_PARAMETERS];
    size_t varied, count; /* parameters: first those that vary, then ties */
    metric metrics[MAX_METRICS];
    size_t metric_count;
    double *sets;             /* [set][varied] */
    size_t set_count, wanted; /* wanted: not left out by --where */
    char fingerprint[32];

    int descriptor; /* of the table */
    size_t columns; /* numbers of a row before its message */
    double *rows;   /* [row][columns] */
    char **messages;
    size_t row_count;
    double stage_seconds; /* of all renders, on the device */
    size_t built,
        compiled; /* acceleration structures and programs that no render before had left */

    mcv_renderer *renderer;
    mcv_asset_cache *assets;
    /* Of the set at work: */
    const double *now;
    const mcv_scene *scene;
    uint32_t sensor;
} sweep;

/* --- what to try
 * ------------------------------------------------------------------------------------------------
 */

/* "emitters/back/halfAngle" becomes halfAngle, or back.halfAngle where there is one already. */
static mcv_result name_parameter(sweep *s, parameter *p, mcv_error *error) {
    int start = p->path_length;
    for (int parts = 0; parts < 3; ++parts) {
        size_t length = 0;
        while (start > 0 && p->item[start - 1] != '/') --start;
        for (int i = start; i < p->path_length && length + 2 < sizeof p->name; ++i) {
            const char c = p->item[i];
            if (length == 0 && isdigit((unsigned char)c)) p->name[length++] = '_';
            p->name[length++] = isalnum((unsigned char)c) ? c : c == '/' ? '.' : '_';
        }
        p->name[length] = '\0';
        bool taken = length == 0;
        for (const parameter *other = s->parameters; other < p; ++other)
            taken = taken || strcmp(other->name, p->name) == 0;
        if (!taken) return MCV_OK;
        if (start > 0) --start;
    }
    return mcv_fail(error, MCV_USAGE, "%s: another parameter has the same path", p->item);
}

static mcv_result read_parameter(sweep *s, const char *item, bool tie, mcv_error *error) {
    const char *equals = strchr(item, '=');
    const char *option = tie ? "tie" : "vary";
    if (!equals || equals == item)
        return mcv_fail(error, MCV_USAGE, "--%s %s: must be PATH=%s", option, item,
                        tie ? "EXPR" : "VALUES");
    if (s->count == MCV_DESIGN_PARAMETERS)
        return mcv_fail(error, MCV_USAGE,
                        "--%s %s: is one too many: at most %d parameters can change", option, item,
                        MCV_DESIGN_PARAMETERS);
    parameter *p = s->parameters + s->count;
    *p = (parameter){
        .item = item, .path_length = (int)(equals - item), .expression = tie ? equals + 1 : NULL};
    MCV_TRY(name_parameter(s, p, error));
    if (!tie) {
        mcv_error detail = {""};
        const mcv_result result = mcv_levels_parse(equals + 1, &p->levels, &detail);
        if (result != MCV_OK) return mcv_fail(error, result, "--vary %s: %s", item, detail.text);
        ++s->varied;
    }
    ++s->count;
    return MCV_OK;
}

/* A parameter's value in the set at work; those that are not computed yet are unknown. */
typedef struct values {
    const sweep *sweep;
    const double *numbers;
    size_t known;
} values;

static mcv_result look_up_parameter(void *user, const char *name, mcv_quantity *quantity,
                                    mcv_error *error) {
    const values *v = user;
    char list[512] = "";
    for (size_t i = 0; i < v->known; ++i) {
        if (strcmp(v->sweep->parameters[i].name, name) == 0) {
            *quantity = (mcv_quantity){v->numbers[i], 0};
            return MCV_OK;
        }
        snprintf(list + strlen(list), sizeof list - strlen(list), "%s%s", i ? ", " : "",
                 v->sweep->parameters[i].name);
    }
    return mcv_fail(error, MCV_USAGE, "there is no parameter \"%s\": there are %s", name, list);
}

/* The set's parameters, ties and all; *wanted is false where --where leaves it out. */
static mcv_result complete_set(const sweep *s, size_t set, double *numbers, bool *wanted,
                               mcv_error *error) {
    mcv_quantity value;
    values v = {s, numbers, s->varied};
    memcpy(numbers, s->sets + set * s->varied, s->varied * sizeof *numbers);
    for (size_t i = s->varied; i < s->count; ++i, ++v.known) {
        MCV_TRY(mcv_expression_evaluate(s->parameters[i].expression, look_up_parameter, &v, &value,
                                        error));
        if (!isfinite(value.value))
            return mcv_fail(error, MCV_USAGE, "--tie %s: is no finite number in set %zu",
                            s->parameters[i].item, set);
        numbers[i] = value.value;
    }
    *wanted = true;
    for (size_t i = 0; i < s->command->where.count && *wanted; ++i) {
        MCV_TRY(mcv_expression_evaluate(s->command->where.items[i], look_up_parameter, &v, &value,
                                        error));
        *wanted = value.value != 0 && !isnan(value.value);
    }
    return MCV_OK;
}

/* --- what to measure
 * -------------------------------------------------------------------------------------------- */

static mcv_result read_metrics(sweep *s, mcv_error *error) {
    const mcv_command *c = s->command;
    if (c->metric.count == 0)
        return mcv_fail(error, MCV_USAGE,
                        "--metric is missing: what to measure, as in --metric mean or --metric "
                        "dent.contrast_to_noise");
    if (c->metric.count > MAX_METRICS)
        return mcv_fail(error, MCV_USAGE, "%zu metrics: at most %d", c->metric.count, MAX_METRICS);
    for (; s->metric_count < c->metric.count; ++s->metric_count) {
        metric *m = s->metrics + s->metric_count;
        const char *item = c->metric.items[s->metric_count], *assigned = strstr(item, ":=");
        mcv_quantity ignored;
        *m = (metric){.expression = assigned ? assigned + 2 : item};
        snprintf(m->name, sizeof m->name, "%.*s",
                 (int)(assigned ? assigned - item : (long)strlen(item)), item);
        for (size_t i = 0; i < s->metric_count; ++i)
            if (strcmp(s->metrics[i].name, m->name) == 0)
                return mcv_fail(error, MCV_USAGE, "--metric %s: is there twice", m->name);
        MCV_TRY(
            mcv_expression_evaluate(m->expression, mcv_metric_known, (void *)c, &ignored, error));
    }
    for (size_t i = 0; i < c->until.count; ++i) {
        const char *item = c->until.items[i], *equals = strrchr(item, '=');
        metric *found = NULL;
        char *end = NULL;
        for (size_t k = 0; k < s->metric_count && equals; ++k)
            if (strlen(s->metrics[k].name) == (size_t)(equals - item) &&
                strncmp(s->metrics[k].name, item, (size_t)(equals - item)) == 0)
                found = s->metrics + k;
        if (equals && !found)
            return mcv_fail(error, MCV_USAGE, "--until %s: there is no --metric of this name",
                            item);
        const double until = equals ? strtod(equals + 1, &end) : 0;
        if (!equals || end == equals + 1 || *end || !(until > 0))
            return mcv_fail(error, MCV_USAGE,
                            "--until %s: must be NAME=U, a standard uncertainty above 0", item);
        found->until = until;
    }
    return MCV_OK;
}

/* --- one set
 * ----------------------------------------------------------------------------------------------------
 */

/* Light as mcv_exr_read would give it; nothing but the parts' pixels is owned. */
typedef struct light {
    mcv_exr exr;
    mcv_exr_part parts[2];
    mcv_attribute attributes[MCV_PICTURE_PARAMETERS + 3];
    char names[MCV_PICTURE_PARAMETERS][MCV_EXR_ATTRIBUTE_NAME];
} light;

static mcv_result develop(const sweep *s, const mcv_film *film, light *l, mcv_error *error) {
    const mcv_sensor *sensor = s->scene->sensors + s->sensor;
    const bool irradiance = mcv_sensor_measures_irradiance(sensor);
    memset(l, 0, sizeof *l);
    l->attributes[0] =
        (mcv_attribute){.name = "mcvisi:quantity", .text = irradiance ? "irradiance" : "radiance"};
    l->attributes[1] =
        (mcv_attribute){.name = "mcvisi:unit", .text = irradiance ? "W/m^2" : "W/(m^2 sr)"};
    l->parts[0].name = "image";
    l->parts[1].name = "error";
    l->exr = (mcv_exr){
        .parts = l->parts, .part_count = film->replicates > 1 ? 2 : 1, .attributes = l->attributes};
    l->exr.attribute_count = 2 + mcv_picture_attributes(sensor, l->attributes + 2, l->names);
    MCV_TRY(mcv_film_develop(film, &l->parts[0].image, &l->parts[1].image, error));
    MCV_TRY(mcv_picture_describe(s->scene, s->sensor, &l->parts[0].image, error));
    l->attributes[l->exr.attribute_count++] =
        (mcv_attribute){.name = MCV_CAMERA_MODEL_KEY, .text = l->parts[0].image.description};
    return MCV_OK;
}

static void free_light(light *l) {
    mcv_image_free(&l->parts[0].image);
    mcv_image_free(&l->parts[1].image);
}

/* Values and deviations of one channel, or of the gradient, whose deviations nobody knows. */
static mcv_result read_channel(const sweep *s, const mcv_image *image, const mcv_image *deviation,
                               const mcv_image *render, mcv_metrics *m, mcv_error *error) {
    const mcv_command *c = s->command;
    const mcv_readout readout = mcv_sensor_readout(s->scene->sensors + s->sensor);
    if (c->in) {
        mcv_image gradient;
        if (readout.angular[0] * readout.angular[1] < 2)
            return mcv_fail(error, MCV_BAD_INPUT,
                            "sensor %s is no light field camera: leave out --in emd-gradient",
                            s->scene->sensors[s->sensor].name);
        MCV_TRY(mcv_light_field_gradient(image, readout.angular,
                                         c->form ? MCV_EMD_MASS : MCV_EMD_NORMALIZED,
                                         (uint32_t)c->threads, &gradient, error));
        const mcv_result result =
            mcv_choose_channel(0, s->rig, &gradient, false, &m->readings.values, error);
        mcv_image_free(&gradient);
        MCV_TRY(result);
        m->known = m->whole = false;
        return mcv_image_new(&m->readings.deviation, m->readings.values.width,
                             m->readings.values.height, 1, error);
    }
    MCV_TRY(mcv_choose_channel(c->channel, s->rig, image, false, &m->readings.values, error));
    if (render->pixels)
        MCV_TRY(mcv_choose_channel(c->channel, s->rig, render, true, &m->readings.render, error));
    if (m->known)
        return mcv_choose_channel(c->channel, s->rig, deviation, true, &m->readings.deviation,
                                  error);
    return mcv_image_new(&m->readings.deviation, image->width, image->height, 1, error);
}

static mcv_result take_readings(const sweep *s, const mcv_film *film, mcv_metrics *m,
                                mcv_error *error) {
    light l;
    mcv_exposure exposure = {0};
    *m = (mcv_metrics){.command = s->command, .known = film->replicates > 1};
    m->readings.render_freedom = film->replicates - 1.0;
    mcv_result result = develop(s, film, &l, error);
    const mcv_image *image = &l.parts[0].image, *deviation = &l.parts[1].image,
                    *light_error = deviation;
    if (result == MCV_OK && mcv_camera_wanted(s->command)) {
        result = mcv_camera_read_out(s->command, s->rig, &l.exr, &exposure,
                                     &m->readings.correlation, error);
        image = &exposure.grey;
        deviation = &exposure.uncertainty;
        light_error = &exposure.render;
        m->known = m->whole = true;
    }
    if (result == MCV_OK) result = read_channel(s, image, deviation, light_error, m, error);
    mcv_exposure_free(&exposure);
    free_light(&l);
    return result;
}

/* The scale of the image, and the places to measure in as its pixels. */
static mcv_result find_places(const sweep *s, mcv_metrics *m, mcv_command *resolved,
                              mcv_error *error) {
    mcv_camera_model model;
    MCV_TRY(mcv_camera_model_of(s->scene, s->scene->sensors + s->sensor, &model, error));
    const bool fits =
        mcv_camera_model_fit(&model, m->readings.values.width, m->readings.values.height);
    for (int i = 0; i < 2 && fits && model.macro[0] * model.macro[1] == 1; ++i)
        m->pixel[i] = model.object_pixel[i];
    const mcv_result result = mcv_places_resolve(s->command, fits ? &model : NULL, resolved, error);
    mcv_camera_model_free(&model);
    m->command = resolved;
    return result;
}

/* The metrics of what has been rendered so far; numbers: value and uncertainty of each, NaN of
 * those that fail. */
static mcv_result measure(const sweep *s, const mcv_film *film, double *numbers, mcv_error *error) {
    mcv_metrics m;
    mcv_command resolved = {0};
    mcv_result result = take_readings(s, film, &m, error);
    if (result == MCV_OK) result = find_places(s, &m, &resolved, error);
    const bool taken = result == MCV_OK;
    for (size_t i = 0; i < s->metric_count; ++i) {
        mcv_quantity value = {NAN, NAN};
        mcv_error why = {""};
        const mcv_result one = taken ? mcv_expression_evaluate(s->metrics[i].expression,
                                                               mcv_metric_look_up, &m, &value, &why)
                                     : MCV_FAILED;
        numbers[2 * i] = one == MCV_OK ? value.value : NAN;
        numbers[2 * i + 1] = one == MCV_OK ? value.uncertainty : NAN;
        if (one != MCV_OK && result == MCV_OK) result = mcv_fail(error, one, "%s", why.text);
    }
    mcv_places_free(&resolved);
    mcv_image_free(&m.readings.values);
    mcv_image_free(&m.readings.deviation);
    mcv_image_free(&m.readings.render);
    return result;
}

static bool is_enough(void *user, const mcv_film *film) {
    const sweep *s = user;
    double numbers[2 * MAX_METRICS];
    mcv_error ignored;
    if (measure(s, film, numbers, &ignored) != MCV_OK) return false;
    for (size_t i = 0; i < s->metric_count; ++i)
        if (s->metrics[i].until > 0 && !(numbers[2 * i + 1] <= s->metrics[i].until)) return false;
    return true;
}

static bool go_on(void *user, double fraction, double spent, double error) {
    (void)user;
    (void)fraction;
    (void)spent;
    (void)error;
    return mcv_interrupt == 0;
}

static mcv_result keep_image(const sweep *s, size_t set, const mcv_film *film,
                             const char *overrides, mcv_error *error) {
    char path[PATH_MAX];
    light l;
    if (!s->command->images) return MCV_OK;
    if (snprintf(path, sizeof path, "%s/set-%05zu.exr", s->command->images, set) >= PATH_MAX)
        return mcv_fail(error, MCV_USAGE, "--images %s: the path is too long", s->command->images);
    mcv_attribute attributes[MCV_PICTURE_PARAMETERS + 9];
    mcv_result result = develop(s, film, &l, error);
    uint32_t count = l.exr.attribute_count;
    memcpy(attributes, l.attributes, count * sizeof *attributes);
    attributes[count++] = (mcv_attribute){.name = "mcvisi:scene", .text = s->rig};
    attributes[count++] =
        (mcv_attribute){.name = "mcvisi:seed", .numbers = {s->options.seed}, .count = 1};
    attributes[count++] =
        (mcv_attribute){.name = "mcvisi:replicates", .numbers = {film->replicates}, .count = 1};
    attributes[count++] = (mcv_attribute){
        .name = "mcvisi:samplesPerReplicate", .numbers = {(double)film->samples}, .count = 1};
    attributes[count++] = (mcv_attribute){.name = "mcvisi:set", .text = overrides};
    if (result == MCV_OK)
        result = mcv_exr_write(path, l.parts, l.exr.part_count, attributes, count, error);
    free_light(&l);
    return result;
}

static mcv_result render_scene(sweep *s, mcv_scene *scene, size_t set, const char *overrides,
                               double *row, mcv_error *error) {
    const mcv_command *c = s->command;
    mcv_film film = {0};
    mcv_render_stats stats;
    s->sensor = 0;
    s->scene = scene;
    if (scene->sensor_count == 0)
        return mcv_fail(error, MCV_BAD_INPUT, "%s: the scene has no sensor", s->rig);
    if (c->sensor) MCV_TRY(mcv_sensor_find(scene, c->sensor, &s->sensor, error));
    if (c->resolution[0])
        MCV_TRY(mcv_sensor_resize(scene->sensors + s->sensor, c->resolution[0], c->resolution[1],
                                  scene, error));
    const bool reference = mcv_wants_reference(c);
    mcv_result result =
        reference
            ? mcv_reference_render(scene, s->sensor, &s->options, &film, &stats, error)
            : mcv_renderer_render(s->renderer, scene, s->sensor, &s->options, &film, &stats, error);
    for (uint32_t i = 0; i < stats.stage_count; ++i) s->stage_seconds += stats.stages[i].seconds;
    s->built += !reference && result == MCV_OK && !stats.kept_structure;
    s->compiled += !reference && result == MCV_OK && !stats.kept_program;
    if (result == MCV_OK && mcv_interrupt != 0)
        result = mcv_fail(error, mcv_interrupt_result(), "interrupted");
    if (result == MCV_OK) {
        row[s->count + 2 * s->metric_count] = (double)(film.samples * film.replicates);
        row[s->count + 2 * s->metric_count + 1] = mcv_film_relative_error(&film);
        result = keep_image(s, set, &film, overrides, error);
    }
    if (result == MCV_OK) result = measure(s, &film, row + s->count, error);
    mcv_film_free(&film);
    return result;
}

/* All --set, then the set's own; texts holds the latter. */
static mcv_result load_scene(const sweep *s, const double *numbers, char (*texts)[512],
                             mcv_scene **scene, mcv_error *error) {
    const mcv_compact_indices *given = &s->command->set;
    const char **items = malloc((given->count + s->count + 1) * sizeof *items);
    if (!items) return mcv_fail(error, MCV_FAILED, "no memory for a set of parameters");
    if (given->count) memcpy(items, given->items, given->count * sizeof *items);
    for (size_t i = 0; i < s->count; ++i) {
        snprintf(texts[i], sizeof texts[i], "%.*s=%.17g", s->parameters[i].path_length,
                 s->parameters[i].item, numbers[i]);
        items[given->count + i] = texts[i];
    }
    const mcv_result result = mcv_scene_load_again(
        s->rig, (mcv_overrides){items, given->count + s->count}, s->assets, scene, error);
    free(items);
    return result;
}

static mcv_result try_set(sweep *s, size_t set, double *row, mcv_error *error) {
    char texts[MCV_DESIGN_PARAMETERS][512], joined[MCV_DESIGN_PARAMETERS * 512] = "", *end = joined;
    mcv_scene *scene;
    MCV_TRY(load_scene(s, row, texts, &scene, error));
    for (size_t i = 0; i < s->count; ++i) {
        if (i) *end++ = '\n';
        end = stpcpy(end, texts[i]);
    }
    const mcv_result result = render_scene(s, scene, set, joined, row, error);
    s->scene = NULL;
    mcv_scene_free(scene);
    return result;
}

/* --- the table
 * --------------------------------------------------------------------------------------------------
 */

static void put_quoted(FILE *out, const char *text) {
    fputc('"', out);
    for (; *text; ++text) {
        if (*text == '"') fputc('"', out);
        fputc(*text == '\n' || *text == '\r' ? ' ' : *text, out);
    }
    fputc('"', out);
}

static void put_name(FILE *out, const char *name, const char *ending) {
    char whole[256];
    snprintf(whole, sizeof whole, "%s%s", name, ending);
    if (whole[strcspn(whole, ",\" \n")])
        put_quoted(out, whole);
    else
        fputs(whole, out);
    fputc(',', out);
}

static void put_header(const sweep *s, FILE *out) {
    fputs("set,", out);
    for (size_t i = 0; i < s->count; ++i) put_name(out, s->parameters[i].name, "");
    for (size_t i = 0; i < s->metric_count; ++i) {
        put_name(out, s->metrics[i].name, "");
        put_name(out, s->metrics[i].name, "_u");
    }
    fputs("samples,render_error,seconds,message\n", out);
}

static void put_row(const sweep *s, FILE *out, const double *row, const char *message) {
    fprintf(out, "%.0f",
            row[s->columns - 1]); /* the set comes first in the file, and last in memory */
    for (size_t i = 0; i + 1 < s->columns; ++i)
        if (isnan(row[i]))
            fputc(',', out);
        else
            fprintf(out, ",%.10g", row[i]);
    fputc(',', out);
    if (message) put_quoted(out, message);
    fputc('\n', out);
}

/* In one piece: another program, or a crash, sees whole rows only. */
static mcv_result append(sweep *s, const char *text, size_t size, mcv_error *error) {
    const ssize_t written = write(s->descriptor, text, size);
    if (written == (ssize_t)size) return MCV_OK;
    if (written > 0 && ftruncate(s->descriptor, lseek(s->descriptor, 0, SEEK_END) - written) != 0)
        return mcv_fail(error, MCV_FAILED, "%s: a row was written in part: %s", s->table,
                        strerror(errno));
    return mcv_fail(error, MCV_FAILED, "%s: %s", s->table,
                    written < 0 ? strerror(errno) : "the disk is full");
}

static mcv_result append_row(sweep *s, const double *row, const char *message, mcv_error *error) {
    char text[MAX_ROW];
    FILE *stream = fmemopen(text, sizeof text, "w");
    if (!stream) return mcv_fail(error, MCV_FAILED, "%s: no memory for a row", s->table);
    if (row)
        put_row(s, stream, row, message);
    else
        put_header(s, stream);
    const long size = ftell(stream);
    const bool fits = !ferror(stream) && size < MAX_ROW - 1;
    fclose(stream);
    return fits ? append(s, text, (size_t)size, error)
                : mcv_fail(error, MCV_FAILED, "%s: a row is too long", s->table);
}

static void remember(sweep *s, const double *row, const char *message) {
    memcpy(s->rows + s->row_count * s->columns, row, s->columns * sizeof *row);
    s->messages[s->row_count++] = message ? strdup(message) : NULL;
}

/* --- the experiment beside the table
 * ---------------------------------------------------------------------------- */

static json_t *describe(const sweep *s) {
    static const char *const without[] = {"output",  "images",   "resume", "device",
                                          "threads", "schedule", "json",   NULL};
    char file[PATH_MAX], folder[PATH_MAX], copy[PATH_MAX];
    json_t *experiment = mcv_command_json(s->command, without);
    json_t *document = json_object();
    const char *rig = realpath(s->rig, file) ? file : s->rig;
    snprintf(copy, sizeof copy, "%s", s->table);
    /* Beside or below the table its name is enough. */
    if (rig == file && realpath(dirname(copy), folder)) {
        const size_t length = strlen(folder);
        if (strncmp(file, folder, length) == 0 && file[length] == '/') rig = file + length + 1;
    }
    json_object_set_new(document, "rig", json_string(rig));
    json_object_set_new(document, "fingerprint", json_string(s->fingerprint));
    json_object_update(document, experiment);
    json_decref(experiment);
    return document;
}

static mcv_result write_sidecar(const sweep *s, mcv_error *error) {
    json_t *document = describe(s);
    char *text = json_dumps(document, JSON_INDENT(2) | JSON_REAL_PRECISION(17));
    json_decref(document);
    if (!text)
        return mcv_fail(error, MCV_FAILED, "%s: the experiment is no UTF-8 text", s->sidecar);
    const mcv_result result = mcv_output_whole(s->sidecar, text, strlen(text), error);
    free(text);
    return result;
}

/* Is it the scene and the experiment that the table was begun with? */
static mcv_result check_sidecar(const sweep *s, mcv_error *error) {
    json_error_t wrong;
    json_t *before = json_load_file(s->sidecar, JSON_REJECT_DUPLICATES, &wrong), *now = describe(s);
    const char *key, *hash = json_string_value(json_object_get(before, "fingerprint"));
    json_t *value;
    mcv_result result = MCV_OK;
    if (!before)
        result = mcv_fail(error, MCV_BAD_INPUT,
                          "%s: cannot be read (%s): without it %s cannot be resumed", s->sidecar,
                          wrong.text, s->table);
    else if (!hash || strcmp(hash, s->fingerprint) != 0)
        result = mcv_fail(
            error, MCV_BAD_INPUT,
            "%s or a file that it names has changed since %s was begun: begin another table by -o",
            s->rig, s->table);
    json_object_foreach(now, key, value) {
        if (result == MCV_OK && strcmp(key, "rig") != 0 &&
            !json_equal(value, json_object_get(before, key)))
            result = mcv_fail(error, MCV_BAD_INPUT,
                              "--%s is not what %s was begun with (%s): begin another table by -o",
                              key, s->table, s->sidecar);
    }
    json_object_foreach(before, key, value) {
        if (result == MCV_OK && !json_object_get(now, key))
            result =
                mcv_fail(error, MCV_BAD_INPUT,
                         "--%s is missing, with which %s was begun (%s): begin another table by -o",
                         key, s->table, s->sidecar);
    }
    json_decref(before);
    json_decref(now);
    return result;
}

/* Takes the quotes off that put_quoted has put around a text and in it. */
static const char *unquote(char *text) {
    char *to = text;
    for (const char *from = text + 1; *from && !(from[0] == '"' && from[1] == '\0'); ++from) {
        *to++ = *from;
        if (from[0] == '"' && from[1] == '"') ++from;
    }
    *to = '\0';
    return text;
}

/* The rows of a table that was begun; what follows the last whole one is cut off. done[set] is set.
 */
static mcv_result read_rows(sweep *s, bool *done, mcv_error *error) {
    char *line = NULL;
    size_t room = 0;
    off_t whole = 0;
    FILE *file = fopen(s->table, "r");
    double row[MCV_DESIGN_PARAMETERS + 2 * MAX_METRICS + FIXED_COLUMNS];
    if (!file) return mcv_fail(error, MCV_BAD_INPUT, "%s: %s", s->table, strerror(errno));
    for (ssize_t length; (length = getline(&line, &room, file)) > 0 && line[length - 1] == '\n';
         whole += length) {
        char *at = line;
        if (whole == 0) continue;
        line[length - 1] = '\0';
        row[s->columns - 1] = strtod(at, &at);
        for (size_t i = 0; i + 1 < s->columns && *at == ','; ++i) {
            char *end;
            row[i] = strtod(++at, &end);
            if (end == at) row[i] = NAN;
            at = end;
        }
        const size_t set = row[s->columns - 1] >= 0 && row[s->columns - 1] < (double)s->set_count
                               ? (size_t)row[s->columns - 1]
                               : SIZE_MAX;
        if (*at != ',' || set == SIZE_MAX || done[set]) continue;
        done[set] = true;
        remember(s, row, at[1] ? unquote(at + 1) : NULL);
    }
    free(line);
    fclose(file);
    return truncate(s->table, whole) == 0
               ? MCV_OK
               : mcv_fail(error, MCV_FAILED, "%s: %s", s->table, strerror(errno));
}

static mcv_result open_table(sweep *s, bool *done, mcv_error *error) {
    struct stat status;
    const bool exists = stat(s->table, &status) == 0;
    const bool resume = s->command->resume && exists;
    if (exists && !s->command->resume)
        return mcv_fail(
            error, MCV_BAD_INPUT,
            "%s is there already: go on with it by --resume, or give another name by -o", s->table);
    if (resume) MCV_TRY(check_sidecar(s, error));
    if (resume) MCV_TRY(read_rows(s, done, error));
    if (!resume) MCV_TRY(mcv_output_check(s->page, error));
    if (!resume) MCV_TRY(write_sidecar(s, error));
    s->descriptor = open(s->table, O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0666);
    if (s->descriptor < 0)
        return mcv_fail(error, MCV_BAD_INPUT, "%s: %s", s->table, strerror(errno));
    return lseek(s->descriptor, 0, SEEK_END) > 0 ? MCV_OK : append_row(s, NULL, NULL, error);
}

/* --- the page
 * ---------------------------------------------------------------------------------------------------
 */

static mcv_result write_page(const sweep *s, mcv_error *error) {
    mcv_plots_axis axes[MCV_DESIGN_PARAMETERS];
    const char *names[MAX_METRICS];
    char labels[MCV_DESIGN_PARAMETERS][320], title[PATH_MAX + 64], text[PATH_MAX + 256];
    size_t failed = 0;
    const size_t columns = s->varied + 2 * s->metric_count;
    double *numbers = calloc(s->row_count * columns + 1, sizeof *numbers);
    if (!numbers) return mcv_fail(error, MCV_FAILED, "%s: no memory to write it", s->page);
    for (size_t i = 0; i < s->varied; ++i) {
        snprintf(labels[i], sizeof labels[i], "%.*s", s->parameters[i].path_length,
                 s->parameters[i].item);
        axes[i] = (mcv_plots_axis){labels[i], s->parameters[i].levels.logarithmic};
    }
    for (size_t i = 0; i < s->metric_count; ++i) names[i] = s->metrics[i].name;
    for (size_t row = 0; row < s->row_count; ++row) {
        const double *from = s->rows + row * s->columns;
        memcpy(numbers + row * columns, from, s->varied * sizeof *numbers);
        memcpy(numbers + row * columns + s->varied, from + s->count,
               2 * s->metric_count * sizeof *numbers);
        failed += s->messages[row] != NULL;
    }
    snprintf(title, sizeof title, "Sweep of %s", s->rig);
    snprintf(
        text, sizeof text,
        "%zu sets of parameters, %zu of which failed. Numbers are in SI units; the table is %s.",
        s->row_count, failed, s->table);
    const mcv_plots page = {title,       text,
                            axes,        s->varied,
                            names,       s->metric_count,
                            numbers,     (const char *const *)s->messages,
                            s->row_count};
    const mcv_result result = mcv_plots_write(s->page, &page, error);
    free(numbers);
    return result;
}

/* --- the whole
 * --------------------------------------------------------------------------------------------------
 */

static void tell_row(const sweep *s, const double *row, const char *message) {
    if (s->command->json) return;
    printf("%zu/%zu ", s->row_count, s->wanted);
    for (size_t i = 0; i < s->count; ++i) printf(" %s %.5g", s->parameters[i].name, row[i]);
    for (size_t i = 0; i < s->metric_count; ++i)
        if (!isnan(row[s->count + 2 * i]))
            printf("; %s %.5g ± %.2g", s->metrics[i].name, row[s->count + 2 * i],
                   row[s->count + 2 * i + 1]);
    if (message) printf(": %s", message);
    putchar('\n');
    fflush(stdout);
}

/* Where each metric is largest and smallest. */
static mcv_result report(const sweep *s, double spent, mcv_error *error) {
    json_t *document = json_object(), *extremes = json_object();
    size_t failed = 0;
    for (size_t row = 0; row < s->row_count; ++row) failed += s->messages[row] != NULL;
    for (size_t i = 0; i < s->metric_count; ++i) {
        const double *best[2] = {NULL, NULL};
        for (size_t row = 0; row < s->row_count; ++row) {
            const double *r = s->rows + row * s->columns, value = r[s->count + 2 * i];
            if (isnan(value)) continue;
            if (!best[0] || value < best[0][s->count + 2 * i]) best[0] = r;
            if (!best[1] || value > best[1][s->count + 2 * i]) best[1] = r;
        }
        json_t *of = json_object();
        for (int k = 0; k < 2 && best[0]; ++k) {
            const double *r = best[k];
            json_t *point = json_object(), *where = json_object();
            for (size_t p = 0; p < s->count; ++p)
                json_object_set_new(where, s->parameters[p].name, json_real(r[p]));
            json_object_set_new(point, "value", json_real(r[s->count + 2 * i]));
            json_object_set_new(point, "uncertainty",
                                isfinite(r[s->count + 2 * i + 1])
                                    ? json_real(r[s->count + 2 * i + 1])
                                    : json_null());
            json_object_set_new(point, "set", json_integer((json_int_t)r[s->columns - 1]));
            json_object_set_new(point, "parameters", where);
            json_object_set_new(of, k ? "largest" : "smallest", point);
            if (s->command->json) continue;
            printf("%s %s: %.5g ± %.2g", k ? "largest" : "smallest", s->metrics[i].name,
                   r[s->count + 2 * i], r[s->count + 2 * i + 1]);
            for (size_t p = 0; p < s->count; ++p)
                printf("%s %s %.5g", p ? "," : " at", s->parameters[p].name, r[p]);
            putchar('\n');
        }
        json_object_set_new(extremes, s->metrics[i].name, of);
    }
    json_object_set_new(document, "table", json_string(s->table));
    json_object_set_new(document, "page", json_string(s->page));
    json_object_set_new(document, "experiment", json_string(s->sidecar));
    json_object_set_new(document, "rows", json_integer((json_int_t)s->row_count));
    json_object_set_new(document, "failed", json_integer((json_int_t)failed));
    json_object_set_new(document, "seconds", json_real(spent));
    json_object_set_new(document, "stage_seconds", json_real(s->stage_seconds));
    json_object_set_new(document, "assets_read",
                        json_integer((json_int_t)mcv_kept_assets_read(s->assets)));
    json_object_set_new(document, "structures_built", json_integer((json_int_t)s->built));
    json_object_set_new(document, "programs_built", json_integer((json_int_t)s->compiled));
    json_object_set_new(document, "metrics", extremes);
    char *text = json_dumps(document, JSON_COMPACT);
    json_decref(document);
    if (!text) return mcv_fail(error, MCV_FAILED, "no memory for the report");
    if (s->command->json)
        puts(text);
    else
        printf("%zu sets, %zu failed, %.1f s\n  %s\n  %s\n  %s\n", s->row_count, failed, spent,
               s->table, s->sidecar, s->page);
    free(text);
    return MCV_OK;
}

/* A set that fails is a row with its error, and the sweep goes on: but for what would fail every
 * time. */
static mcv_result run_set(sweep *s, size_t set, double *row, mcv_error *error) {
    mcv_error why = {""};
    const double begun = mcv_seconds();
    for (size_t i = s->count; i < s->columns; ++i) row[i] = NAN;
    row[s->columns - 1] = (double)set;
    const mcv_result result = try_set(s, set, row, &why);
    if (mcv_interrupt != 0)
        return mcv_fail(error, mcv_interrupt_result(),
                        "interrupted: go on by --resume; %zu rows are in %s", s->row_count,
                        s->table);
    row[s->columns - 2] = mcv_seconds() - begun;
    const char *message = result == MCV_OK ? NULL : why.text;
    for (char *c = why.text; *c; ++c)
        if (*c == '\n' || *c == '\r') *c = ' ';
    MCV_TRY(append_row(s, row, message, error));
    remember(s, row, message);
    tell_row(s, row, message);
    return MCV_OK;
}

static mcv_result run_sets(sweep *s, const bool *done, mcv_error *error) {
    double row[MCV_DESIGN_PARAMETERS + 2 * MAX_METRICS + FIXED_COLUMNS];
    bool wanted = false;
    for (size_t set = 0; set < s->set_count; ++set) {
        MCV_TRY(complete_set(s, set, row, &wanted, error));
        if (wanted && !done[set]) MCV_TRY(run_set(s, set, row, error));
    }
    return MCV_OK;
}

static mcv_result count_wanted(sweep *s, mcv_error *error) {
    double numbers[MCV_DESIGN_PARAMETERS];
    bool wanted;
    for (size_t set = 0; set < s->set_count; ++set) {
        MCV_TRY(complete_set(s, set, numbers, &wanted, error));
        s->wanted += wanted;
    }
    return s->wanted ? MCV_OK
                     : mcv_fail(error, MCV_USAGE, "--where leaves out all %zu sets", s->set_count);
}

/* The scene as it stands: what is wrong with it would be wrong in every set. */
static mcv_result check_rig(sweep *s, mcv_error *error) {
    mcv_scene *scene;
    uint32_t sensor;
    MCV_TRY(mcv_scene_load_again(s->rig,
                                 (mcv_overrides){s->command->set.items, s->command->set.count},
                                 s->assets, &scene, error));
    snprintf(s->fingerprint, sizeof s->fingerprint, "%016" PRIx64, scene->fingerprint);
    for (uint32_t i = 0; i < scene->warning_count; ++i)
        fprintf(stderr, "mcvisi: warning: %s\n", scene->warnings[i]);
    mcv_result result = scene->sensor_count
                            ? MCV_OK
                            : mcv_fail(error, MCV_BAD_INPUT, "%s: the scene has no sensor", s->rig);
    if (result == MCV_OK && s->command->sensor)
        result = mcv_sensor_find(scene, s->command->sensor, &sensor, error);
    if (result == MCV_OK && !s->command->sensor && scene->sensor_count > 1)
        result = mcv_fail(error, MCV_USAGE, "%s has %u sensors: choose one by --sensor", s->rig,
                          scene->sensor_count);
    mcv_scene_free(scene);
    return result;
}

/* A path that leads nowhere does so in every set; a value out of range may be one set's own. */
static mcv_result check_paths(const sweep *s, mcv_error *error) {
    char texts[MCV_DESIGN_PARAMETERS][512];
    double numbers[MCV_DESIGN_PARAMETERS];
    bool wanted;
    mcv_scene *scene = NULL;
    MCV_TRY(complete_set(s, 0, numbers, &wanted, error));
    const mcv_result result = load_scene(s, numbers, texts, &scene, error);
    mcv_scene_free(scene);
    if (result != MCV_OK && strstr(error->text, ": --set ")) return result;
    error->text[0] = '\0';
    return MCV_OK;
}

static mcv_result plan_files(sweep *s, mcv_error *error) {
    const mcv_command *c = s->command;
    const char *given = c->table ? c->table : c->argument, *dot = strrchr(given, '.'),
               *slash = strrchr(given, '/');
    const int stem =
        (int)(dot && dot > (slash ? slash : given) ? dot - given : (long)strlen(given));
    const char *suffix = c->table ? "" : "-sweep";
    struct stat status;
    if (stem + 16 >= PATH_MAX)
        return mcv_fail(error, MCV_USAGE, "the path of the table is too long");
    if (c->table && (!dot || strcmp(dot, ".csv") != 0))
        return mcv_fail(error, MCV_USAGE, "--output %s: must end in .csv", c->table);
    snprintf(s->table, sizeof s->table, "%.*s%s.csv", stem, given, suffix);
    snprintf(s->sidecar, sizeof s->sidecar, "%.*s%s.json", stem, given, suffix);
    snprintf(s->page, sizeof s->page, "%.*s%s.html", stem, given, suffix);
    if (mcv_same_file(s->sidecar, c->argument))
        return mcv_fail(error, MCV_USAGE, "%s is the experiment: give the table another name by -o",
                        s->sidecar);
    if (c->images && mkdir(c->images, 0777) != 0 &&
        (errno != EEXIST || stat(c->images, &status) != 0 || !S_ISDIR(status.st_mode)))
        return mcv_fail(error, MCV_BAD_INPUT, "--images %s: is no folder that can be made",
                        c->images);
    return MCV_OK;
}

static mcv_result plan(sweep *s, mcv_error *error) {
    const mcv_command *c = s->command;
    MCV_TRY(mcv_render_options_read(c, &s->options, error));
    if (mcv_camera_wanted(c)) MCV_TRY(mcv_camera_check_options(c, error));
    s->options.progress = go_on;
    if (c->until.count > 0) s->options.enough = is_enough;
    s->options.user = s;
    if (c->until.count && c->replicates < 2)
        return mcv_fail(error, MCV_USAGE,
                        "--until needs uncertainties: give --replicates 2 or more");
    if (c->vary.count == 0)
        return mcv_fail(
            error, MCV_USAGE,
            "--vary is missing: what changes, as in --vary emitters/back/halfAngle=0.1deg..2deg:8");
    for (size_t i = 0; i < c->vary.count; ++i)
        MCV_TRY(read_parameter(s, c->vary.items[i], false, error));
    for (size_t i = 0; i < c->tie.count; ++i)
        MCV_TRY(read_parameter(s, c->tie.items[i], true, error));
    MCV_TRY(read_metrics(s, error));
    mcv_levels levels[MCV_DESIGN_PARAMETERS];
    for (size_t i = 0; i < s->varied; ++i) levels[i] = s->parameters[i].levels;
    MCV_TRY(mcv_design_make((int)c->design, levels, s->varied, (size_t)c->points,
                            (uint32_t)c->design_seed, &s->sets, &s->set_count, error));
    MCV_TRY(count_wanted(s, error));
    s->columns = s->count + 2 * s->metric_count + FIXED_COLUMNS;
    s->rows = malloc(s->set_count * s->columns * sizeof *s->rows);
    s->messages = calloc(s->set_count, sizeof *s->messages);
    s->renderer = mcv_renderer_new();
    s->assets = mcv_kept_assets_new();
    if (!s->rows || !s->messages || !s->renderer || !s->assets)
        return mcv_fail(error, MCV_FAILED, "no memory for a table of %zu rows", s->set_count);
    return plan_files(s, error);
}

static mcv_result run_sweep(sweep *s, mcv_error *error) {
    const double begun = mcv_seconds();
    MCV_TRY(plan(s, error));
    MCV_TRY(check_rig(s, error));
    MCV_TRY(check_paths(s, error));
    bool *done = calloc(s->set_count, sizeof *done);
    if (!done) return mcv_fail(error, MCV_FAILED, "no memory for %zu sets", s->set_count);
    mcv_interrupt_watch(false);
    mcv_result result = open_table(s, done, error);
    if (result == MCV_OK) {
        mcv_error later = {""};
        result = run_sets(s, done, error);
        const mcv_result paged =
            s->row_count ? write_page(s, result == MCV_OK ? error : &later) : MCV_OK;
        if (result == MCV_OK) result = paged;
    }
    if (result == MCV_OK) result = report(s, mcv_seconds() - begun, error);
    size_t failed = 0;
    for (size_t row = 0; row < s->row_count; ++row) failed += s->messages[row] != NULL;
    if (result == MCV_OK && failed == s->row_count)
        result = mcv_fail(error, MCV_FAILED, "all %zu sets failed, the first one: %s", failed,
                          s->messages[0]);
    free(done);
    return result;
}

static mcv_result sweep_command(const mcv_command *command, const char *rig, mcv_error *error) {
    sweep s = {.command = command, .rig = rig, .descriptor = -1};
    const mcv_result result = run_sweep(&s, error);
    if (s.descriptor >= 0) close(s.descriptor);
    for (size_t i = 0; i < s.count; ++i) mcv_levels_free(&s.parameters[i].levels);
    for (size_t i = 0; i < s.row_count; ++i) free(s.messages[i]);
    mcv_renderer_free(s.renderer);
    mcv_kept_assets_free(s.assets);
    free(s.messages);
    free(s.rows);
    free(s.sets);
    return result;
}

/* --- experiment files
 * ------------------------------------------------------------------------------------------- */

/* {"rig": "part.gltf", "vary": […], …}: options by their names, before those of the command line.
 */
static mcv_result sweep_file(const mcv_command *given, const char *path, mcv_error *error) {
    char rig[PATH_MAX], copy[PATH_MAX];
    json_error_t wrong;
    mcv_arguments arguments = {0};
    mcv_command command;
    json_t *document = json_load_file(path, JSON_REJECT_DUPLICATES, &wrong);
    if (!document)
        return wrong.line > 0
                   ? mcv_fail(error, MCV_BAD_INPUT, "%s: line %d column %d is no JSON: %s", path,
                              wrong.line, wrong.column, mcv_json_wrong(&wrong))
                   : mcv_fail(error, MCV_BAD_INPUT, "%s: %s", path, strerror(errno));
    const char *name = json_string_value(json_object_get(document, "rig"));
    snprintf(copy, sizeof copy, "%s", path);
    mcv_result result = MCV_OK;
    if (!name)
        result = mcv_fail(error, MCV_BAD_INPUT,
                          "%s: rig: is missing: the scene, as in \"rig\": \"part.gltf\"", path);
    else if (snprintf(rig, sizeof rig, "%s%s%s", name[0] == '/' ? "" : dirname(copy),
                      name[0] == '/' ? "" : "/", name) >= PATH_MAX)
        result = mcv_fail(error, MCV_BAD_INPUT, "%s: rig: the path is too long", path);
    json_object_del(document, "rig");
    json_object_del(document, "fingerprint");
    json_object_del(document, "note");
    if (result == MCV_OK)
        result = mcv_arguments_read(document, path, given, path, &arguments, error);
    json_decref(document);
    if (result == MCV_OK) {
        mcv_error detail = {""};
        result = mcv_command_parse(arguments.count, arguments.items, &command, &detail);
        if (result != MCV_OK) result = mcv_fail(error, result, "%s: %s", path, detail.text);
        if (result == MCV_OK) result = sweep_command(&command, rig, error);
        mcv_command_free(&command);
    }
    mcv_arguments_free(&arguments);
    return result;
}

mcv_result mcv_verb_sweep(const mcv_command *command, mcv_error *error) {
    return mcv_ends_in(command->argument, ".json")
               ? sweep_file(command, command->argument, error)
               : sweep_command(command, command->argument, error);
}
