/* SPDX-License-Identifier: Apache-2.0 */
/* Light transport matrices of the public interface. */
#include "api/rendering.h"
#include "core/basics.h"
#include "core/output_file.h"
#include "io/png.h"
#include "scene/memory.h"
#include "scene/sensors.h"
#include "scene/spectra.h"
#include "transport/matrix_file.h"
#include "transport/white.h"
#include "verbs/transport.h"

#include <stdlib.h>
#include <string.h>

enum { MOST_RECORD_BYTES = 1 << 26 };

void mcv_transport_free(mcv_transport *transport) {
    if (!transport) return;
    mcv_matrix_free(&transport->matrix);
    free(transport->path);
    free(transport);
}

static mcv_result new_transport(const char *path, mcv_transport **transport, mcv_error *error) {
    *transport = calloc(1, sizeof **transport);
    if (*transport && ((*transport)->path = strdup(path))) return MCV_OK;
    mcv_transport_free(*transport);
    *transport = NULL;
    return mcv_fail(error, MCV_FAILED, "no memory for a light transport matrix");
}

/* --- rendering one --- */

static double brightest(const mcv_scene *scene) {
    double most = 0;
    for (uint32_t i = 0; i < scene->emitter_count; ++i)
        for (int k = 0; k < 3; ++k)
            if (scene->emitters[i].radiance[k] > most) most = scene->emitters[i].radiance[k];
    return most;
}

/* The header of the white image, without what JSON cannot hold. */
static mcv_result keep_attributes(const mcv_rendering *r, mcv_matrix *matrix, mcv_error *error) {
    mcv_exr exr;
    mcv_picture *picture;
    char *text = NULL;
    json_error_t wrong;
    const char *key;
    void *next;
    json_t *value;
    MCV_TRY(mcv_rendered_develop(&r->rendered, &exr, error));
    MCV_TRY(mcv_picture_of(&exr, "the matrix", &picture, error));
    const mcv_result result = mcv_picture_attributes(picture, &text, error);
    mcv_picture_free(picture);
    if (result == MCV_OK) matrix->attributes = json_loads(text, 0, &wrong);
    free(text);
    MCV_TRY(result);
    json_object_foreach_safe(matrix->attributes, next, key, value) {
        if (json_is_null(value)) json_object_del(matrix->attributes, key);
    }
    return matrix->attributes ? MCV_OK : mcv_fail(error, MCV_FAILED, "no memory for a header");
}

/* From the gathered records, with the matrix's groups and pattern, which it keeps. */
static mcv_result finish_matrix(const mcv_rendering *r, mcv_gather *gather, double keep,
                                mcv_matrix *matrix, mcv_error *error) {
    const mcv_film *film = r->rendered.film;
    const mcv_element_group *last = matrix->groups + matrix->group_count - 1;
    mcv_matrix whole;
    if (film->samples == 0)
        return mcv_fail(error, MCV_INTERRUPTED, "%s: interrupted before its first sample",
                        r->rendered.scene->path);
    MCV_TRY(mcv_matrix_make(gather, film->width, film->height, film->samples,
                            last->first + last->width * last->height, keep, &whole, error));
    whole.groups = matrix->groups;
    whole.group_count = matrix->group_count;
    whole.pattern = matrix->pattern;
    *matrix = whole;
    return keep_attributes(r, matrix, error);
}

/* Renders into the gather, and makes the matrix of it. */
static mcv_result render_records(mcv_session *session, const mcv_command *command, mcv_rendering *r,
                                 mcv_scene *scene, uint32_t sensor, const mcv_record_sink *sink,
                                 mcv_matrix *matrix, mcv_error *error) {
    mcv_render_options options;
    mcv_render_stats stats = {.stage_count = 0};
    mcv_film film = {0};
    MCV_TRY(mcv_render_options_read(command, &options, error));
    options.records = sink;
    mcv_result result =
        mcv_rendering_run(r, session, command, scene, sensor, &options, &film, &stats, error);
    if (result == MCV_OK && stats.interrupted)
        result =
            mcv_fail(error, MCV_INTERRUPTED, "%s: interrupted before its last sample", scene->path);
    if (result == MCV_OK) result = finish_matrix(r, sink->user, command->keep, matrix, error);
    r->rendered = (mcv_rendered){.set = r->rendered.set}; /* the rest ends here */
    mcv_film_free(&film);
    return result;
}

mcv_result mcv_rendering_matrix(mcv_session *session, const mcv_command *command, mcv_rendering *r,
                                mcv_scene *scene, uint32_t sensor, mcv_matrix *matrix,
                                mcv_error *error) {
    mcv_gather gather = {0};
    uint32_t *columns = NULL;
    const uint32_t channels = mcv_scene_channels(scene);
    const size_t most =
        (size_t)(command->memory > 0 ? command->memory : (double)mcv_memory_default());
    /* The records of a launch are on the device and here. */
    const size_t of_records = most / 8 < MOST_RECORD_BYTES ? most / 8 : MOST_RECORD_BYTES;
    const mcv_record_sink sink = {.bytes = of_records, .take = mcv_gather_add, .user = &gather};
    mcv_result result =
        mcv_scene_show_white(scene, command->elements == 1, (uint32_t)command->element_bin,
                             channels, matrix, &columns, error);
    if (result == MCV_OK && mcv_scene_channels(scene) != channels)
        result = mcv_fail(error, MCV_BAD_INPUT,
                          "%s: only the image of an emitter has colours: a matrix of it would be "
                          "grey; give --elements lamps, or a grey image",
                          scene->path);
    if (result == MCV_OK)
        result = mcv_gather_new(&gather, channels, (uint32_t)command->replicates, brightest(scene),
                                most - 2 * of_records, error);
    if (result == MCV_OK) {
        gather.columns = columns;
        result = render_records(session, command, r, scene, sensor, &sink, matrix, error);
        mcv_gather_free(&gather);
    }
    free(columns);
    return result;
}

static mcv_result write_white(const mcv_transport *transport, const char *path, mcv_error *error) {
    const mcv_matrix *m = &transport->matrix;
    const size_t count = (size_t)m->element_count * m->channels;
    mcv_picture *picture = NULL;
    float *ones = malloc((count + 1) * sizeof *ones);
    if (!ones) return mcv_fail(error, MCV_FAILED, "no memory for a pattern");
    for (size_t i = 0; i < count; ++i) ones[i] = 1;
    mcv_result result = mcv_transport_light(transport, ones, &picture, error);
    if (result == MCV_OK) result = mcv_picture_write(picture, path, NULL, error);
    mcv_picture_free(picture);
    free(ones);
    return result;
}

static mcv_result tell(const mcv_command *command, const mcv_transport *transport, double seconds,
                       char **report, mcv_error *error) {
    mcv_report r;
    if (!report) return MCV_OK;
    MCV_TRY(mcv_report_keep(&r, command->json, error));
    mcv_report_text(&r, "scene", transport->path);
    mcv_matrix_report(&transport->matrix, &r);
    mcv_report_number(&r, "seconds", "s", seconds);
    if (command->matrix) mcv_report_text(&r, "matrix", command->matrix);
    if (command->white) mcv_report_text(&r, "white", command->white);
    return mcv_report_take(&r, report, error);
}

static mcv_result check_files(const mcv_command *command, mcv_error *error) {
    if (mcv_wants_reference(command))
        return mcv_fail(error, MCV_USAGE,
                        "the reference renderer records no elements: choose a device");
    if (command->matrix && !mcv_ends_in(command->matrix, ".npz") &&
        !mcv_ends_in(command->matrix, ".mtx"))
        return mcv_fail(error, MCV_USAGE, "--output %s: must end in .npz or .mtx", command->matrix);
    if (command->white && !mcv_ends_in(command->white, ".exr"))
        return mcv_fail(error, MCV_USAGE, "--white %s: must end in .exr", command->white);
    if (command->matrix) MCV_TRY(mcv_output_check(command->matrix, error));
    return command->white ? mcv_output_check(command->white, error) : MCV_OK;
}

/* What mcv_session_transport is given. */
typedef struct transport_call {
    mcv_session *session;
    const mcv_rig *rig;
    mcv_transport **transport;
    char **report; /* or NULL */
} transport_call;

static mcv_result render_matrix(void *own, const mcv_command *command, mcv_rendering *r,
                                mcv_error *error) {
    const transport_call *call = own;
    mcv_transport **transport = call->transport;
    mcv_scene *scene = NULL;
    uint32_t sensor;
    MCV_TRY(check_files(command, error));
    MCV_TRY(mcv_session_scene(call->session, call->rig, command, &scene, error));
    mcv_result result = mcv_session_sensor(scene, command, &sensor, error);
    if (result == MCV_OK) result = new_transport(scene->path, transport, error);
    if (result == MCV_OK)
        result = mcv_rendering_matrix(call->session, command, r, scene, sensor,
                                      &(*transport)->matrix, error);
    mcv_scene_free(scene);
    if (result == MCV_OK && command->matrix)
        result = mcv_matrix_write(&(*transport)->matrix, command->matrix, error);
    if (result == MCV_OK && command->white) result = write_white(*transport, command->white, error);
    return result == MCV_OK
               ? tell(command, *transport, mcv_seconds() - r->begun, call->report, error)
               : result;
}

mcv_result mcv_session_transport(mcv_session *session, const mcv_rig *rig, const char *options,
                                 mcv_progress_call *progress, void *user, mcv_transport **transport,
                                 char **report, mcv_error *error) {
    MCV_NEED(transport);
    *transport = NULL;
    if (report) *report = NULL;
    MCV_NEED(session);
    MCV_NEED(rig);
    transport_call call = {session, rig, transport, report};
    const mcv_result result = mcv_rendering_verb(session, rig, MCV_VERB_TRANSPORT, options,
                                                 progress, user, render_matrix, &call, error);
    if (result == MCV_OK) return MCV_OK;
    mcv_transport_free(*transport);
    *transport = NULL;
    return result;
}

/* --- files and what is in them --- */

static mcv_result read_transport(const char *path, mcv_transport **transport, mcv_error *error) {
    MCV_TRY(new_transport(path, transport, error));
    const mcv_result result = mcv_matrix_read(path, &(*transport)->matrix, error);
    if (result == MCV_OK) return MCV_OK;
    mcv_transport_free(*transport);
    *transport = NULL;
    return result;
}

mcv_result mcv_transport_read(const char *path, mcv_transport **transport, mcv_error *error) {
    mcv_result result;
    MCV_NEED(transport);
    *transport = NULL;
    MCV_NEED(path);
    MCV_INSIDE(result, read_transport(path, transport, error));
    return result;
}

mcv_result mcv_transport_write(const mcv_transport *transport, const char *path, mcv_error *error) {
    mcv_result result;
    MCV_NEED(transport);
    MCV_NEED(path);
    MCV_INSIDE(result, mcv_matrix_write(&transport->matrix, path, error));
    return result;
}

static mcv_result dump_header(const mcv_transport *transport, char **json, mcv_error *error) {
    json_t *header = mcv_matrix_header(&transport->matrix);
    *json = header ? json_dumps(header, JSON_COMPACT | JSON_REAL_PRECISION(17)) : NULL;
    json_decref(header);
    return *json ? MCV_OK : mcv_fail(error, MCV_FAILED, "no memory for the header");
}

mcv_result mcv_transport_header(const mcv_transport *transport, char **json, mcv_error *error) {
    mcv_result result;
    MCV_NEED(json);
    *json = NULL;
    MCV_NEED(transport);
    MCV_INSIDE(result, dump_header(transport, json, error));
    return result;
}

mcv_result mcv_transport_entries(const mcv_transport *transport, mcv_matrix_entries *entries,
                                 mcv_error *error) {
    MCV_NEED(transport);
    MCV_NEED(entries);
    const mcv_matrix *m = &transport->matrix;
    if (entries->size < sizeof *entries)
        return mcv_fail(error, MCV_USAGE,
                        "mcv_transport_entries: entries->size must be sizeof(mcv_matrix_entries)");
    entries->row_count = m->row_count;
    entries->column_count = m->column_count;
    entries->element_count = m->element_count;
    entries->replicate_count = m->replicates;
    entries->entry_count = m->row_begins[m->row_count];
    entries->row_begins = m->row_begins;
    entries->columns = m->columns;
    entries->values = m->values;
    entries->replicates = m->replicates_of;
    entries->pattern = m->pattern;
    return MCV_OK;
}
